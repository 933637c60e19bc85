"""Materials: open, look inside, evaluate on the CPU, hand over to a GPU.

SPDX-License-Identifier: MIT
"""
import ctypes
import os
import threading
from concurrent.futures import ThreadPoolExecutor
from ctypes import byref, c_float, c_size_t, c_uint32, c_void_p, cast, sizeof

import numpy as np

from . import _library as c
from . import _options as o
from ._plan import Plan

_FORMATS = [None, (np.uint8, 1), (np.uint8, 2), (np.uint8, 4), (np.int8, 4), (np.uint16, 4), (np.float16, 4),
            (np.float32, 4), (np.uint32, 4)]
_TEXTURES = 20


class _Owner(np.ndarray):
    """An array on memory of the library: keeps the owner alive, and is read-only."""

    owner = None

    def __array_finalize__(self, source):
        self.owner = getattr(source, "owner", None)


def _borrow(address, shape, dtype, owner):
    size = int(np.prod(shape)) * np.dtype(dtype).itemsize
    if not address or size == 0:
        return np.empty(shape, dtype)
    buffer = (ctypes.c_char * size).from_address(address)
    array = np.frombuffer(buffer, dtype).reshape(shape).view(_Owner)
    array.owner = owner
    array.flags.writeable = False
    return array


class _Handle:
    """A btf_material, closed when the last array on it is gone."""

    def __init__(self, pointer):
        self.pointer = pointer

    def __del__(self):
        if self.pointer and c is not None and c.library is not None:
            c.library.btf_material_close(byref(self.pointer))


class Errors(tuple):
    """Rows (effects, dB linear, dB sRGB-coded, bytes on the GPU) as the encoder measured them at the samples."""


class Material:
    """An encoded BTF, opened by `openbtf.open`. Immutable; any number of threads may use it at the same time.

    Directions are unit vectors of the tangent frame: x along +u, y along +v, z the normal. Texture coordinates have
    (0, 0) at the lower left corner of the image, which repeats beyond [0, 1). Colours are linear Rec. 709; radiance
    includes the cosine, for an irradiance of pi at normal incidence: a white Lambertian surface gives l.z.
    """

    def __init__(self, handle, name=""):
        self._handle = handle
        self._name = name
        self._info = c.Info(struct_size=sizeof(c.Info))
        c.Messages().check(c.library.btf_material_get_info(handle.pointer, byref(self._info)))
        self._lock = threading.Lock() # of what is made when first needed
        self._evaluator = None
        self._sampling = None
        self._references = {}

    # Evaluator and sampling tables are made when first needed and freed with the object.
    def __del__(self):
        if getattr(self, "_sampling", None):
            c.library.btf_light_sampling_destroy(byref(self._sampling))
        if getattr(self, "_evaluator", None):
            c.library.btf_evaluator_destroy(byref(self._evaluator))

    def __repr__(self):
        return "<openbtf.Material %s: %d x %d texels, %d views, %d lights, %s, %s bytes>" % (
            self._name or "(memory)", self._info.width, self._info.height, self._info.n_views, self._info.n_lights,
            ", ".join(self.effects) or "no effects", format(self.gpu_bytes, ","))

    @property
    def texels(self):
        """(height, width) of level 0."""
        return self._info.height, self._info.width

    @property
    def levels(self):
        """Levels of detail, at least 1."""
        return self._info.levels

    @property
    def effects(self):
        """Names of the effects that the file holds, a subset of `openbtf.EFFECTS`."""
        return o.names_of(self._info.effects)

    @property
    def components(self):
        """Components of the residual; units, where it is stored as factors."""
        return self._info.components

    @property
    def version(self):
        """The oldest version of the format that holds this material."""
        return self._info.version

    @property
    def gpu_bytes(self):
        """Bytes of all textures of all levels, without `table_bytes`: what budgets and reports count."""
        return self._info.gpu_bytes

    @property
    def table_bytes(self):
        """Bytes of direction tables and of the residual's scales, which depend on the directions alone."""
        return self._info.table_bytes

    @property
    def method(self):
        """The encoder's method, options and input, three strings; empty where the file does not say."""
        return tuple((text or b"").decode("utf-8", "replace")
                     for text in (self._info.method, self._info.options, self._info.source))

    @property
    def views(self):
        """float32 (n_views, 3): sampled directions to the viewer. No copy."""
        return self._directions(c.library.btf_material_views)

    @property
    def lights(self):
        """float32 (n_lights, 3): sampled directions to the light. No copy."""
        return self._directions(c.library.btf_material_lights)

    def _directions(self, function):
        directions = function(self._handle.pointer)
        return _borrow(ctypes.addressof(directions.xyz.contents), (directions.count, 3), np.float32, self._handle)

    @property
    def errors(self):
        """The accuracy of each set of effects at the samples: rows (effects, dB linear, dB sRGB-coded, bytes)."""
        count = c_size_t()
        rows = c.library.btf_material_errors(self._handle.pointer, byref(count))
        return Errors((o.names_of(rows[i].effects), rows[i].psnr_linear, rows[i].psnr_srgb, int(rows[i].gpu_bytes))
                      for i in range(count.value))

    def textures(self, level=0):
        """Textures of a level of detail by name (FORMAT.md section 3), as a GPU takes them: arrays of shape
        (layers, height, width, channels), (height, width, channels) where the texture is no array texture; row 0 is
        the top of the image. Read-only, without copies. Levels above 0 hold only what they do not share with level 0.

        >>> import openbtf, os
        >>> m = openbtf.open(os.environ["OPENBTF_SAMPLE"])
        >>> m.textures()["view_table"].dtype
        dtype('uint16')
        """
        if not 0 <= level < self.levels:
            raise c.UsageError("level %r is not within 0..%d" % (level, self.levels - 1), 1)
        found = {}
        for number in range(_TEXTURES):
            texture = c.library.btf_material_level_texture(self._handle.pointer, level, number)
            if not texture.format:
                continue
            dtype, channels = _FORMATS[texture.format]
            shape = (texture.height, texture.width, channels)
            found[c.library.btf_texture_name(number).decode()] = _borrow(
                texture.data, (texture.layers,) + shape if texture.is_array else shape, dtype, self._handle)
        return found

    def evaluate(self, uv, l, v, level=0, effects=None, components=None, interpolation="linear", filter="texel",
                 threads=None):
        """Radiance for many arguments, with the bits of the reference decoder.

        uv (..., 2), l and v (..., 3) are broadcast against each other; the result is float32 (..., 3), 0 where l or v is
        below the horizon. `level`: an integer, or an array that is broadcast too. `effects`: names of those to decode,
        default all. `components`: at most so many. `interpolation`: "linear" or "nearest" sampled directions. `filter`:
        "texel", "bilinear", "steep". `threads`: default one a core; the interpreter's lock is released meanwhile.
        Arguments that share l and v with their neighbours in the array are quickest.

        >>> import openbtf, os
        >>> m = openbtf.open(os.environ["OPENBTF_SAMPLE"])
        >>> m.evaluate([0.5, 0.5], l=[0, 0, 1], v=[0, 0, 1]).shape
        (3,)
        >>> m.evaluate([[0.1, 0.2], [0.3, 0.4]], l=m.lights[:, None], v=[0, 0, 1]).shape
        (6, 2, 3)
        >>> float(m.evaluate([0.5, 0.5], l=[0, 0, -1], v=[0, 0, 1]).max())
        0.0
        """
        uv, l, v = o.vectors(uv, 2, "uv"), o.vectors(l, 3, "l"), o.vectors(v, 3, "v")
        levels = np.asarray(level)
        if levels.dtype.kind not in "iu":
            raise c.UsageError("level has type %s; it is an integer" % levels.dtype, 1)
        shape = np.broadcast_shapes(uv.shape[:-1], l.shape[:-1], v.shape[:-1], levels.shape)
        count = int(np.prod(shape))
        fixed = (1 if v.size == 3 else 0) | (2 if l.size == 3 else 0)
        uv = np.ascontiguousarray(np.broadcast_to(uv, shape + (2,))).reshape(count, 2)
        l = l.reshape(1, 3) if fixed & 2 else np.ascontiguousarray(np.broadcast_to(l, shape + (3,))).reshape(count, 3)
        v = v.reshape(1, 3) if fixed & 1 else np.ascontiguousarray(np.broadcast_to(v, shape + (3,))).reshape(count, 3)
        l, v = np.ascontiguousarray(l), np.ascontiguousarray(v)
        levels = None if levels.ndim == 0 and levels == 0 else np.ascontiguousarray(
            np.broadcast_to(levels, shape), np.int32).reshape(count)
        options = self._evaluate_options(effects, components, interpolation, filter)
        return self._evaluate_many(options, count, threads, uv, None, l, v, levels, fixed).reshape(shape + (3,))

    def image(self, view, light, level=0, effects=None, components=None, interpolation="linear"):
        """What the whole material shows: float32 (height, width, 3), row 0 the top. `view` and `light`: the number of a
        sampled direction, or a unit vector. The other options are those of `evaluate`.

        >>> import openbtf, os
        >>> m = openbtf.open(os.environ["OPENBTF_SAMPLE"])
        >>> m.image(view=0, light=[0, 0.6, 0.8]).shape == m.texels + (3,)
        True
        """
        height, width = (max(1, side >> level) for side in self.texels)
        view, light = self._direction(view, self.views, "view"), self._direction(light, self.lights, "light")
        texels = np.empty((height, width, 2), np.uint32)
        texels[..., 0], texels[..., 1] = np.arange(width), np.arange(height)[:, None]
        texels = texels.reshape(-1, 2)
        levels = np.full(len(texels), level, np.int32)
        options = self._evaluate_options(effects, components, interpolation, "texel")
        rgb = self._evaluate_many(options, len(texels), None, None, texels, light, view, levels, 3)
        return rgb.reshape(height, width, 3)

    def _direction(self, value, samples, name):
        if np.ndim(value) == 0:
            if not -len(samples) <= value < len(samples):
                raise c.UsageError("%s %r is not one of the %d samples" % (name, value, len(samples)), 1)
            return np.ascontiguousarray(samples[value])
        return np.ascontiguousarray(o.vectors(value, 3, name).reshape(3))

    def _evaluate_options(self, effects, components, interpolation, filter):
        with self._lock:
            if not self._evaluator:
                messages, evaluator = c.Messages(), c_void_p()
                messages.check(c.library.btf_evaluator_create(self._handle.pointer, messages.pointer, byref(evaluator)))
                self._evaluator = evaluator
        return c.EvaluateOptions(sizeof(c.EvaluateOptions), o.leave_out(effects), o.components_of(components),
                                 o.choice(o.INTERPOLATIONS, interpolation, "interpolation"),
                                 o.choice(o.FILTERS, filter, "filter"))

    def _evaluate_many(self, options, count, threads, uv, texels, l, v, levels, fixed):
        """float32 (count, 3) of `count` evaluations. Arrays have a row each, or are None; of l and v those that are fixed
        (bits 2 and 1) have one row for all."""
        rgb = np.empty((count, 3), np.float32)

        def part(first, end):
            def rows(array, one=0):
                return None if array is None else array.ctypes.data if one else array[first:].ctypes.data

            evaluations = c.Evaluations(sizeof(c.Evaluations), end - first, rows(uv), rows(texels), rows(l, fixed & 2),
                                        rows(v, fixed & 1), rows(levels), fixed, 0, rows(rgb))
            return c.library.btf_evaluate_many(self._evaluator, byref(options), byref(evaluations))

        self._spread(part, count, threads)
        return rgb

    @staticmethod
    def _spread(part, count, threads):
        """Calls part(first, end) for ranges that cover `count`, on so many threads."""
        threads = min(threads or len(os.sched_getaffinity(0)), max(1, count // 2048))
        edges = [count * i // (4 * threads if threads > 1 else 1) for i in range((4 * threads if threads > 1 else 1) + 1)]
        ranges = list(zip(edges, edges[1:]))
        if threads == 1:
            results = [part(*ranges[0])]
        else:
            with ThreadPoolExecutor(threads) as pool:
                results = list(pool.map(lambda ends: part(*ends), ranges))
        for result in results:
            c.Messages().check(result)

    def evaluate_stochastic(self, uv, l, v, random, picks="all", level=0, effects=None, components=None,
                            interpolation="linear", filter="texel"):
        """Radiance by one neighbour in place of all, picked with its weight by random numbers (FORMAT.md section 9).

        `random`: uint32 (..., 3), broadcast as uv, l, v are. `picks`: "view", "light" (and view), "all" (and the texel).
        A call of the reference decoder for each argument: for comparing, not for speed."""
        uv, l, v = o.vectors(uv, 2, "uv"), o.vectors(l, 3, "l"), o.vectors(v, 3, "v")
        random = np.asarray(random, np.uint32)
        shape = np.broadcast_shapes(uv.shape[:-1], l.shape[:-1], v.shape[:-1], random.shape[:-1])
        uv, l, v, random = (np.ascontiguousarray(np.broadcast_to(a, shape + a.shape[-1:])).reshape(-1, a.shape[-1])
                            for a in (uv, l, v, random))
        pick = o.choice({k: n for k, n in o.PICKS.items() if n}, picks, "picks")
        options = c.RefOptions(127 & ~o.leave_out(effects), o.components_of(components) or 0xFFFFFFFF,
                               1 - o.choice(o.INTERPOLATIONS, interpolation, "interpolation"),
                               o.choice(o.FILTERS, filter, "filter"))
        material = self._reference(level)
        rgb = np.empty((len(uv), 3), np.float32)
        for i in range(len(uv)):
            c.reference.btf_ref_evaluate_stochastic(byref(material), byref(options), pick, uv[i, 0], uv[i, 1],
                                                    l[i].ctypes.data, v[i].ctypes.data, random[i].ctypes.data,
                                                    rgb[i].ctypes.data)
        return rgb.reshape(shape + (3,))

    def sample_light(self, v, u1, u2):
        """Draws directions to the light in proportion to what the material reflects to v (decoder/SAMPLING.md).

        v: float32 (..., 3); u1, u2: uint32, random bits; broadcast. Returns l, float32 (..., 3), and its density over the
        solid angle, float32 (...)."""
        v = o.vectors(v, 3, "v")
        u1, u2 = np.asarray(u1, np.uint32), np.asarray(u2, np.uint32)
        shape = np.broadcast_shapes(v.shape[:-1], u1.shape, u2.shape)
        v = np.ascontiguousarray(np.broadcast_to(v, shape + (3,))).reshape(-1, 3)
        u1, u2 = (np.broadcast_to(u, shape).reshape(-1).tolist() for u in (u1, u2))
        light, pdf = np.empty((len(v), 3), np.float32), np.empty(len(v), np.float32)
        material, tables = self._reference(0), self._tables()
        for i in range(len(v)):
            c.reference.btf_ref_sample_light(byref(material), byref(tables), 0, 0, v[i].ctypes.data, u1[i], u2[i],
                                             light[i].ctypes.data, pdf[i:].ctypes.data)
        return light.reshape(shape + (3,)), pdf.reshape(shape)

    def pdf_light(self, v, l):
        """The density, float32 (...), with which `sample_light` draws l for v; both (..., 3)."""
        v, l = o.vectors(v, 3, "v"), o.vectors(l, 3, "l")
        shape = np.broadcast_shapes(v.shape[:-1], l.shape[:-1])
        v, l = (np.ascontiguousarray(np.broadcast_to(a, shape + (3,))).reshape(-1, 3) for a in (v, l))
        material, tables = self._reference(0), self._tables()
        pdf = [c.reference.btf_ref_pdf_light(byref(material), byref(tables), 0, 0, v[i].ctypes.data, l[i].ctypes.data)
               for i in range(len(v))]
        return np.array(pdf, np.float32).reshape(shape)

    def _tables(self):
        self._evaluate_options(None, None, "linear", "texel") # makes the evaluator
        with self._lock:
            if not self._sampling:
                messages, sampling = c.Messages(), ctypes.POINTER(c.LightSampling)()
                messages.check(c.library.btf_light_sampling_create(self._handle.pointer, self._evaluator, messages.pointer,
                                                                   byref(sampling)))
                self._sampling = sampling
        tables = self._sampling.contents
        return c.RefSampling(tables.n_triangles, cast(tables.triangles, c_void_p), cast(tables.densities, c_void_p))

    def _reference(self, level):
        """The level as the reference decoder takes it."""
        if level not in self._references:
            base, own, info = self.textures(0), self.textures(level), self._info
            at = lambda name: (own.get(name, base.get(name)).ctypes.data if name in base else None)
            material = c.RefMaterial(
                max(1, info.width >> level), max(1, info.height >> level), layout_tight=info.layout,
                domain_sqrt=info.domain, view_grid=c.library.btf_material_views(self._handle.pointer).grid,
                light_grid=c.library.btf_material_lights(self._handle.pointer).grid,
                points_packed=int(info.point_store != 0), centre=at("centres"), level=level + info.relief_level,
                relief_end=info.relief_end + info.relief_level)
            for name in ("n_views", "n_lights", "colour", "half_float", "lobes", "effects", "centres", "components",
                         "atlas_width", "atlas_height", "radiance_scale", "shadow_scale", "gain_scale", "centre_scale",
                         "store", "blend", "horizon_scale", "factor_classes", "gain_base", "gain_step", "relief_base",
                         "relief_step", "relief_steps", "gloss_share"):
                setattr(material, name, getattr(info, name))
            for name in ("sbrdf", "maps", "shadow", "shift", "gain", "residual_texels", "residual_directions",
                         "residual_scales", "view_table", "light_table", "factor_texels", "factor_directions",
                         "factor_scales", "factor_views", "points", "point_lists", "point_indices", "heights",
                         "view_vectors"):
                setattr(material, name, at(name))
            self._references[level] = material
        return self._references[level]

    def glsl(self, effects=None, components=None, interpolation="linear", filter="texel", math="exact", bindings="none",
             first_binding=0, descriptor_set=0, prefix="btf", have_precise=False, picks="none", fold="none"):
        """The GLSL that decodes this material (openbtf/shader.h): a text to stand behind your `#version` line and in front
        of the shader that calls its btf_evaluate(uv, l, v).

        `effects`, `components`, `interpolation` and `filter`: as in `evaluate`. `math`: "exact", the same bits on every
        device, or "fast". `bindings`: how samplers are declared, "none", "gl" (layout(binding = n)) or "vulkan" (with
        `descriptor_set`, too); the binding of a texture is `first_binding` plus its number, the btf_texture_id of
        openbtf/material.h. `prefix`: of all names. `picks`: "none", or "view", "light", "all" for a stochastic decode.
        `have_precise`: True where an extension of yours enables `precise`. `fold`: "none", or the fold that was made
        (openbtf/fold.h), "light", "both", "neighbours".

        >>> import openbtf, os
        >>> m = openbtf.open(os.environ["OPENBTF_SAMPLE"])
        >>> "vec3 cloth_evaluate(vec2 uv, vec3 l, vec3 v)" in m.glsl(prefix="cloth")
        True
        """
        return self._source(effects, components, interpolation, filter, math, int(have_precise),
                            o.choice(o.BINDINGS, bindings, "bindings"), first_binding, descriptor_set, prefix, picks, fold, language=0)

    def wgsl(self, effects=None, components=None, interpolation="linear", filter="texel", math="exact", first_binding=0,
             descriptor_set=0, prefix="btf", picks="none", fold="none"):
        """The same in WGSL, the language of WebGPU: textures are in group `descriptor_set`, from `first_binding` on, and
        with exact math a buffer of zeros, as openbtf/shader.h says. The tool btf-shader writes more languages.

        >>> import openbtf, os
        >>> m = openbtf.open(os.environ["OPENBTF_SAMPLE"])
        >>> "fn btf_evaluate(uv: vec2f, l: vec3f, v: vec3f) -> vec3f" in m.wgsl()
        True
        """
        return self._source(effects, components, interpolation, filter, math, 0, 0, first_binding, descriptor_set, prefix, picks,
                            fold, language=1)

    def _source(self, effects, components, interpolation, filter, math, have_precise, bindings, first_binding, descriptor_set,
                prefix, picks, fold, language):
        """The text of btf_shader_source, in a btf_language."""
        options = c.ShaderOptions(
            sizeof(c.ShaderOptions), o.leave_out(effects), o.components_of(components),
            o.choice(o.INTERPOLATIONS, interpolation, "interpolation"), o.choice(o.FILTERS, filter, "filter"),
            o.choice(o.MATHS, math, "math"), have_precise, bindings, first_binding, descriptor_set,
            prefix.encode())
        options.picks, options.fold = o.choice(o.PICKS, picks, "picks"), o.choice(o.FOLDS, fold, "fold")
        options.language = language
        messages, text = c.Messages(), c_void_p()
        messages.check(c.library.btf_shader_source(self._handle.pointer, byref(options), messages.pointer, byref(text)))
        try:
            return ctypes.string_at(text.value).decode()
        finally:
            c.library.btf_free(text)

    def plan(self, view=None, light=None, tolerance=0.5, pixels=1.0, lights=1, interpolate=False, costs=None,
             still_lights=False, folds=True):
        """The cheapest way to decode a scene at most `tolerance` dB worse where the scene looks (openbtf/plan.h).

        `view` and `light`: None for every direction, (theta_min, theta_max) or (theta_min, theta_max, phi_min, phi_max)
        in degrees, or a unit vector as an array of 3 floats for one that never changes. `pixels`: side of a texel on
        the screen. `lights`: evaluations a pixel. `interpolate`: never nearest directions. `costs`: a file of prices of the
        device (openbtf/cost.h); default those of llvmpipe. `still_lights`: the lights of the range stand still, so that
        with a fixed view their sum can be folded. `folds`: False where nothing will be folded (openbtf/fold.h).

        >>> import openbtf, os
        >>> m = openbtf.open(os.environ["OPENBTF_SAMPLE"])
        >>> plan = m.plan(view=(0, 30), light=(0, 60, -90, 90))
        >>> m.restrict(plan).gpu_bytes == plan.gpu_bytes <= m.gpu_bytes
        True
        """
        scene = c.Scene(struct_size=sizeof(c.Scene), pixels=pixels, lights=lights, interpolate=int(interpolate),
                        still_lights=int(still_lights), no_fold=int(not folds))
        for target, value, name in ((scene.view, view, "view"), (scene.light, light, "light")):
            if value is None:
                continue
            value = np.asarray(value, np.float32)
            if value.shape == (3,):
                target.fixed, target.direction = 1, (c_float * 3)(*value.tolist())
            elif value.shape in ((2,), (4,)):
                target.theta = (c_float * 2)(*value[:2].tolist())
                target.phi = (c_float * 2)(*value[2:].tolist())
            else:
                raise c.UsageError("%s has shape %s; it is 2 or 4 angles, or a unit vector" % (name, value.shape), 1)
        if costs is not None:
            messages, prices = c.Messages(), c.CostModel()
            messages.check(c.library.btf_cost_model_open(os.fsencode(costs), messages.pointer, byref(prices)))
            scene.costs = ctypes.addressof(prices)
        plan = c.Plan(struct_size=sizeof(c.Plan))
        c.Messages().check(c.library.btf_plan_effects(self._handle.pointer, byref(scene), tolerance, byref(plan)))
        plan.scene.costs = None # the prices end with this call
        return Plan(plan)

    def restrict(self, plan):
        """A material that holds what a plan of this one reads, and decodes in the plan's range to the same bits."""
        messages, pointer = c.Messages(), c_void_p()
        messages.check(c.library.btf_material_restrict(self._handle.pointer, byref(plan._c), messages.pointer, byref(pointer)))
        return Material(_Handle(pointer), self._name)

    def save(self, path):
        """Writes the material; the file is whole or absent."""
        messages = c.Messages()
        messages.check(c.library.btf_material_save(self._handle.pointer, os.fsencode(path), messages.pointer))


def open(path):
    """Opens a *.btf.exr file, or one whose bytes are given. Every rule of the format is checked.

    Raises FileError (cannot be read), BadFileError, UnsupportedError (a newer version), MemoryError."""
    messages, pointer = c.Messages(), c_void_p()
    if isinstance(path, (bytes, bytearray, memoryview)):
        data = bytes(path)
        messages.check(c.library.btf_material_open_memory(data, len(data), messages.pointer, byref(pointer)))
        return Material(_Handle(pointer))
    name = os.fspath(path)
    messages.check(c.library.btf_material_open(os.fsencode(name), messages.pointer, byref(pointer)))
    return Material(_Handle(pointer), os.path.basename(os.fsdecode(name)))
