"""Data sets: read samples of any kind that the encoder reads, write them, encode them.

SPDX-License-Identifier: MIT
"""
import ctypes
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from ctypes import POINTER, byref, c_char_p, c_double, c_float, c_int, c_size_t, c_void_p, sizeof

import numpy as np

from . import _library as c
from ._options import choice

_TRANSFERS = {"auto": 0, "srgb": 1, "linear": 2}
_PRIMARIES = {"auto": 0, "rgb": 1, "xyz": 2}
_COSINES = {"auto": 0, "included": 1, "missing": 2}


class InputOptions(ctypes.Structure):
    _fields_ = [("struct_size", c_size_t), ("transfer", c_int), ("gamma", c_double), ("primaries", c_int),
                ("cosine", c_int), ("size", c_int * 2), ("crop", c_int * 4), ("flip_v", c_int), ("azimuth_cw", c_int),
                ("azimuth_offset", c_double), ("layer", c_char_p), ("names", c_char_p), ("strict", c_int),
                ("memory", c_size_t)]


class InputInfo(ctypes.Structure):
    _fields_ = [("struct_size", c_size_t), ("width", c_int), ("height", c_int), ("n_views", c_int), ("n_lights", c_int),
                ("views", POINTER(c_float)), ("lights", POINTER(c_float)), ("view_angles", POINTER(c_double)),
                ("light_angles", POINTER(c_double)), ("lazy", c_int)]


_library = None


def _input_library():
    """libopenbtf_input, opened when first needed: materials can be used where it is not installed."""
    global _library
    if _library is None:
        _library = c.declare(c.load("openbtf_input"), {
            "btf_input_open": (c_int, [c_char_p, POINTER(InputOptions), POINTER(c.Log), POINTER(c_void_p)]),
            "btf_input_get_info": (c_int, [c_void_p, POINTER(InputInfo)]),
            "btf_input_image": (c_int, [c_void_p, c_int, c_int, POINTER(c.Log), c_void_p]),
            "btf_input_close": (None, [POINTER(c_void_p)]),
            "btf_input_write_image": (c_int, [c_char_p, c_int, c_int, c_void_p, POINTER(c.Log)]),
        })
    return _library


class Data:
    """Samples of a BTF, opened by `openbtf.read`: linear Rec. 709 radiance, cosine included, for an irradiance of pi at
    normal incidence. Directions are in paper order: theta ascending, then phi ascending from 0.

    `d[view, light]` is float32 (..., height, width, 3), row 0 the top; view and light may be slices or lists, and the
    texels may be sliced too: `d[0, :, 10:20, 30]`. Images are read when asked for. Any number of threads may read."""

    def __init__(self, path, pointer):
        self.path = path
        self._pointer = pointer
        info = InputInfo(struct_size=sizeof(InputInfo))
        c.Messages().check(_input_library().btf_input_get_info(pointer, byref(info)))
        self._size = info.height, info.width
        self._views = np.ctypeslib.as_array(info.views, (info.n_views, 3)).copy()
        self._lights = np.ctypeslib.as_array(info.lights, (info.n_lights, 3)).copy()
        self._view_angles = np.ctypeslib.as_array(info.view_angles, (info.n_views, 2)).copy()
        self._light_angles = np.ctypeslib.as_array(info.light_angles, (info.n_lights, 2)).copy()
        self.lazy = bool(info.lazy)

    def __del__(self):
        if getattr(self, "_pointer", None):
            _input_library().btf_input_close(byref(self._pointer))

    def __repr__(self):
        return "<openbtf.Data %s: %d views, %d lights, %d x %d texels>" % (
            os.path.basename(os.fspath(self.path)), len(self._views), len(self._lights), self._size[1], self._size[0])

    @property
    def shape(self):
        """(n_views, n_lights, height, width, 3)."""
        return (len(self._views), len(self._lights)) + self._size + (3,)

    @property
    def views(self):
        """float32 (n_views, 3): unit vectors to the viewer."""
        return self._views

    @property
    def lights(self):
        """float32 (n_lights, 3): unit vectors to the light."""
        return self._lights

    @property
    def view_angles(self):
        """float64 (n_views, 2): theta from the normal and phi from +u towards +v, degrees."""
        return self._view_angles

    @property
    def light_angles(self):
        """float64 (n_lights, 2): likewise."""
        return self._light_angles

    def image(self, view, light):
        """float32 (height, width, 3), row 0 the top; `view` and `light` are numbers of the lists."""
        count = len(self._views), len(self._lights)
        if not -count[0] <= view < count[0] or not -count[1] <= light < count[1]:
            raise c.UsageError("view %r or light %r is not one of %d views and %d lights" % ((view, light) + count), 1)
        rgb = np.empty(self._size + (3,), np.float32)
        messages = c.Messages()
        messages.check(_input_library().btf_input_image(self._pointer, view % count[0], light % count[1], messages.pointer,
                                                        rgb.ctypes.data))
        return rgb

    def __getitem__(self, key):
        key = key if isinstance(key, tuple) else (key,)
        if Ellipsis in [k for k in key if k is Ellipsis]:
            at = [k is Ellipsis for k in key].index(True)
            key = key[:at] + (slice(None),) * (5 - len(key) + 1) + key[at + 1:]
        if len(key) > 5:
            raise IndexError("%d indices for 5 axes: view, light, row, column, channel" % len(key))
        key += (slice(None),) * (5 - len(key))
        lists, drop = [], []
        for axis in (0, 1):
            drop.append(np.ndim(key[axis]) == 0 and not isinstance(key[axis], slice))
            numbers = np.arange(self.shape[axis])[key[axis]]
            lists.append(np.atleast_1d(numbers))
        pairs = [(v, l) for v in lists[0] for l in lists[1]]
        first = self.image(int(pairs[0][0]), int(pairs[0][1]))[key[2:]] if pairs else np.empty(self._size + (3,))[key[2:]]
        out = np.empty((len(pairs),) + first.shape, np.float32)

        def fill(i):
            out[i] = first if i == 0 else self.image(int(pairs[i][0]), int(pairs[i][1]))[key[2:]]

        if self.lazy and len(pairs) > 8:
            with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
                list(pool.map(fill, range(len(pairs))))
        else:
            for i in range(len(pairs)):
                fill(i)
        out = out.reshape((len(lists[0]), len(lists[1])) + first.shape)
        return out[tuple(0 if d else slice(None) for d in drop)]

    def __len__(self):
        return len(self._views)

    def __array__(self, dtype=None):
        whole = self[:]
        return whole if dtype is None else whole.astype(dtype)


def read(path, transfer="auto", gamma=None, primaries="auto", cosine="auto", size=None, crop=None, flip_v=False,
         azimuth_cw=False, azimuth_offset=0.0, layer=None, names=None, strict=False, memory=None):
    """Opens a data set: a folder or archive of images whose names say tl, pl, tv and pv (UBO2003, UTIA, ...), or a Bonn
    .btf file (UBO2014).

    `transfer`: "auto", "srgb", "linear", or "auto" with `gamma`. `primaries`: "auto", "rgb", "xyz". `cosine`: whether
    values hold the light's cosine, "auto", "included", "missing". `size`: (width, height) to resize to. `crop`: (x, y,
    width, height) in pixels of the file. `names`: a table of the images' directions. `strict`: refuse values below 0.
    `memory`: bytes for samples of archives and Bonn files, default 1 GiB. Raises what `openbtf.open` does.

    >>> import numpy, openbtf, tempfile
    >>> angles = [(0, 0), (45, 0), (45, 120), (45, 240)]            # theta, phi
    >>> samples = numpy.full((4, 4, 2, 3, 3), 0.25, numpy.float32)  # views, lights, rows, columns, channels
    >>> folder = tempfile.TemporaryDirectory()
    >>> openbtf.write(folder.name, samples, angles, angles)
    >>> d = openbtf.read(folder.name)
    >>> d.shape
    (4, 4, 2, 3, 3)
    >>> d[0, :, 1, 2].shape                                         # one texel under all lights
    (4, 3)
    >>> folder.cleanup()
    """
    options = InputOptions(
        struct_size=sizeof(InputOptions), transfer=3 if gamma is not None else choice(_TRANSFERS, transfer, "transfer"),
        gamma=gamma or 0.0, primaries=choice(_PRIMARIES, primaries, "primaries"), cosine=choice(_COSINES, cosine, "cosine"),
        flip_v=int(flip_v), azimuth_cw=int(azimuth_cw), azimuth_offset=azimuth_offset,
        layer=layer.encode() if layer else None, names=os.fsencode(names) if names else None, strict=int(strict),
        memory=memory or 0)
    options.size = (c_int * 2)(*(size or (0, 0)))
    options.crop = (c_int * 4)(*(crop or (0, 0, 0, 0)))
    messages, pointer = c.Messages(), c_void_p()
    messages.check(_input_library().btf_input_open(os.fsencode(path), byref(options), messages.pointer, byref(pointer)))
    return Data(path, pointer)


def angles(directions):
    """(N, 2) theta and phi in degrees of unit vectors (N, 3): theta from the normal, phi within [0, 360), 0 at the normal,
    both to a ten-thousandth of a degree, which is what float32 holds.

    >>> import numpy
    >>> angles(numpy.array([[0, 0, 1], [0, 0.5, 0.75 ** 0.5]])).tolist()
    [[0.0, 0.0], [30.0, 90.0]]
    """
    directions = np.asarray(directions, np.float64)
    if directions.ndim != 2 or directions.shape[1] not in (2, 3):
        raise c.UsageError("directions have shape %s; it is (N, 3), or (N, 2) for angles" % (directions.shape,), 1)
    if directions.shape[1] == 2:
        return directions
    x, y, z = directions.T
    theta = np.degrees(np.arctan2(np.hypot(x, y), z)).round(4)
    phi = (np.degrees(np.arctan2(y, x)).round(4) + 0.0) % 360
    return np.stack([theta, np.where(theta == 0, 0, phi)], 1)


def _name(angle):
    """An angle as file names of UBO2003 have it: three digits, and decimals where there are any."""
    text = "%08.4f" % angle
    return text.rstrip("0").rstrip(".")


def write(path, array, views, lights):
    """Writes samples as a folder of float OpenEXR images with the names of UBO2003, which `read` and btf-encode read.

    `array`: (n_views, n_lights, height, width, 3), anything that gives float32 images by `array[view, light]`; row 0 the
    top, linear Rec. 709 radiance with cosine. `views`, `lights`: unit vectors (N, 3), or (N, 2) theta and phi in degrees.
    The folder is made; it has to be empty."""
    view_angles, light_angles = angles(views), angles(lights)
    shape = tuple(array.shape)
    if len(shape) != 5 or shape[:2] != (len(view_angles), len(light_angles)) or shape[4] != 3:
        raise c.UsageError("the array has shape %s; %d views and %d lights call for (%d, %d, height, width, 3)" % (
            shape, len(view_angles), len(light_angles), len(view_angles), len(light_angles)), 1)
    folder = pathlib.Path(path)
    folder.mkdir(parents=True, exist_ok=True)
    if any(folder.iterdir()):
        raise c.UsageError("%s is not empty" % folder, 1)
    for v, (tv, pv) in enumerate(view_angles):
        inner = folder / ("tv%s_pv%s" % (_name(tv), _name(pv)))
        inner.mkdir(exist_ok=True)
        for l, (tl, pl) in enumerate(light_angles):
            image = np.ascontiguousarray(array[v, l], np.float32)
            if not np.isfinite(image).all():
                raise c.UsageError("the image of view %d and light %d holds values that are no numbers" % (v, l), 1)
            name = "%05d tl%s pl%s tv%s pv%s.exr" % (len(view_angles) * l + v, _name(tl), _name(pl), _name(tv), _name(pv))
            messages = c.Messages()
            messages.check(_input_library().btf_input_write_image(
                os.fsencode(inner / name), shape[3], shape[2], image.ctypes.data, messages.pointer))


def _encoder():
    """btf-encode: $OPENBTF_BINDIR, that of this prefix, or the one on PATH."""
    places = [os.environ["OPENBTF_BINDIR"]] if "OPENBTF_BINDIR" in os.environ else []
    places += [str(parent / "bin") for parent in pathlib.Path(__file__).resolve().parents]
    for place in places:
        program = os.path.join(place, "btf-encode")
        if os.access(program, os.X_OK):
            return program
    program = shutil.which("btf-encode")
    if not program:
        raise c.FileError("btf-encode is neither in $OPENBTF_BINDIR, nor in this package's prefix, nor on PATH")
    return program


_EXIT = {1: 1, 2: 2, 3: 3, 4: 4, 5: 6, 7: 7}
_PROGRESS = re.compile(r"^([a-z][^:]*): (?:done after [\d.]+ s, )?(\d+)%")


def encode(data, out, progress=None, views=None, lights=None, **options):
    """Runs btf-encode and opens the material that it wrote.

    `data`: a path, what `read` returned (read anew from its path, with btf-encode's options), or an array with `views`
    and `lights` as `write` takes them. `out`: the material, NAME.btf.exr. `options`: those of `btf-encode --help`, `_` for
    `-`: budget="1M", preset="fast", relief="off"; True for one without a value. `progress(stage, percent)` is called as
    it goes on. Raises as `open` does, with the tool's message."""
    if isinstance(data, np.ndarray):
        if views is None or lights is None:
            raise c.UsageError("an array needs views and lights", 1)
        with tempfile.TemporaryDirectory() as folder:
            inner = os.path.join(folder, "data")
            write(inner, data, views, lights)
            return encode(inner, out, progress, **options)
    path = data.path if isinstance(data, Data) else data
    command = [_encoder(), os.fspath(path), "-o", os.fspath(out)]
    for name, value in options.items():
        if value is None or value is False:
            continue
        command.append("--" + name.replace("_", "-"))
        if value is not True:
            command.append("x".join(map(str, value)) if name == "size" and not isinstance(value, str) else
                           ",".join(map(str, value)) if isinstance(value, (tuple, list)) else str(value))
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                               text=True, errors="replace")
    lines = []
    try:
        for line in process.stderr:
            line = line.rstrip("\n")
            match = _PROGRESS.match(line)
            if match:
                if progress:
                    progress(match[1], int(match[2]))
            elif line:
                lines.append(line)
        code = process.wait()
    except BaseException:
        process.terminate()
        process.wait()
        raise
    finally:
        process.stderr.close()
    if code != 0:
        errors = [line.split("error: ", 1)[1] for line in lines if "error: " in line] or lines[-3:]
        c_messages = c.Messages()
        c_messages.errors = errors
        c_messages.check(_EXIT.get(code, 4))
    from .material import open as open_material
    return open_material(out)
