"""The C library as ctypes sees it: where it lies, its structures, and its errors as exceptions.

Structures are those of openbtf/*.h, member by member; tests/python/layout.py compares sizes and offsets with the
compiler's.

SPDX-License-Identifier: MIT
"""
import ctypes
import logging
import os
import pathlib
from ctypes import POINTER, c_char_p, c_double, c_float, c_int, c_int32, c_size_t, c_uint16, c_uint32, c_uint8, c_void_p

log = logging.getLogger("openbtf")


class Error(Exception):
    """A call of the library failed. `result` is the number of openbtf/result.h; the text is the library's message."""

    def __init__(self, message, result=4):
        super().__init__(message)
        self.result = result


class UsageError(Error, ValueError):
    """An argument that the library does not take (BTF_ERROR_USAGE)."""


class FileError(Error, OSError):
    """A file cannot be read or written (BTF_ERROR_IO)."""

    def __init__(self, message, result=2):
        OSError.__init__(self, message)
        self.result = result


class BadFileError(Error):
    """A file whose contents break a rule of its format (BTF_ERROR_BAD_FILE)."""


class UnsupportedError(Error):
    """A file, or a way to decode one, that this version does not know (BTF_ERROR_UNSUPPORTED)."""


_ERRORS = {1: UsageError, 2: FileError, 3: BadFileError, 6: UnsupportedError}


class Log(ctypes.Structure):
    CALLBACK = ctypes.CFUNCTYPE(None, c_void_p, c_int, c_char_p)
    _fields_ = [("callback", CALLBACK), ("user", c_void_p)]


class Texture(ctypes.Structure):
    _fields_ = [("format", c_int), ("is_array", c_int), ("width", c_uint32), ("height", c_uint32), ("layers", c_uint32),
                ("data", c_void_p), ("size", c_size_t)]


class Info(ctypes.Structure):
    _fields_ = [
        ("struct_size", c_size_t), ("width", c_uint32), ("height", c_uint32), ("n_views", c_uint32), ("n_lights", c_uint32),
        ("layout", c_int), ("domain", c_int), ("colour", c_int), ("half_float", c_int), ("lobes", c_uint32),
        ("effects", c_uint32), ("centres", c_uint32), ("components", c_uint32), ("atlas_width", c_uint32),
        ("atlas_height", c_uint32), ("radiance_scale", c_float), ("shadow_scale", c_float), ("gain_scale", c_float),
        ("centre_scale", c_float), ("gpu_bytes", c_size_t), ("table_bytes", c_size_t), ("method", c_char_p),
        ("options", c_char_p), ("source", c_char_p), ("levels", c_uint32), ("store", c_int),
        ("factor_classes", (c_uint32 * 3) * 5), ("blend", c_int), ("horizon_scale", c_float), ("version", c_uint32),
        ("point_store", c_int), ("gain_base", c_float), ("gain_step", c_float), ("point_entries", c_uint32),
        ("relief_base", c_int32), ("relief_step", c_int32), ("relief_steps", c_uint32), ("relief_level", c_uint32),
        ("gloss_share", c_uint32), ("relief_end", c_uint32)]


class MaterialError(ctypes.Structure):
    _fields_ = [("effects", c_uint32), ("psnr_linear", c_float), ("psnr_srgb", c_float), ("gpu_bytes", c_float)]


class BetweenErrors(ctypes.Structure):
    _fields_ = [("view_bands", c_uint32), ("light_bands", c_uint32), ("view_limits", POINTER(c_float)),
                ("light_limits", POINTER(c_float)), ("row_count", c_uint32), ("row_stride", c_uint32),
                ("rows", POINTER(c_float))]


class Directions(ctypes.Structure):
    _fields_ = [("count", c_uint32), ("xyz", POINTER(c_float)), ("vertices", POINTER(c_uint16)),
                ("triangle_count", c_uint32), ("triangles", POINTER(c_uint16)), ("hull_count", c_uint32),
                ("hull", POINTER(c_uint16)), ("grid", c_uint32), ("cells", POINTER(c_uint16)), ("cells_length", c_size_t)]


class ShaderOptions(ctypes.Structure):
    _fields_ = [("struct_size", c_size_t), ("leave_out", c_uint32), ("components", c_uint32), ("interpolation", c_int),
                ("filter", c_int), ("math", c_int), ("have_precise", c_int), ("bindings", c_int), ("first_binding", c_uint32),
                ("descriptor_set", c_uint32), ("prefix", c_char_p), ("fixed", c_uint32), ("fixed_view", c_float * 3),
                ("fixed_light", c_float * 3), ("picks", c_int), ("fold", c_int), ("language", c_int)]


class EvaluateOptions(ctypes.Structure):
    _fields_ = [("struct_size", c_size_t), ("leave_out", c_uint32), ("components", c_uint32), ("interpolation", c_int),
                ("filter", c_int)]


class Evaluations(ctypes.Structure):
    _fields_ = [("struct_size", c_size_t), ("count", c_size_t), ("uv", c_void_p), ("texels", c_void_p), ("lights", c_void_p),
                ("views", c_void_p), ("levels", c_void_p), ("fixed", c_uint32), ("stride", c_size_t), ("rgb", c_void_p)]


class CostModel(ctypes.Structure):
    _fields_ = [("struct_size", c_size_t), ("device", ctypes.c_char * 128)] + [(name, c_double) for name in (
        "pixel", "look_up", "point", "move", "step", "fetch", "byte", "integer", "real", "masked")]


class Range(ctypes.Structure):
    _fields_ = [("theta", c_float * 2), ("phi", c_float * 2), ("fixed", c_int), ("direction", c_float * 3)]


class Scene(ctypes.Structure):
    _fields_ = [("struct_size", c_size_t), ("view", Range), ("light", Range), ("pixels", c_float), ("lights", c_uint32),
                ("interpolate", c_int), ("costs", c_void_p), ("still_lights", c_int), ("no_fold", c_int),
                ("folded_pixels", c_double), ("folded_bytes", c_size_t)]


class Plan(ctypes.Structure):
    _fields_ = [
        ("struct_size", c_size_t), ("scene", Scene), ("shader", ShaderOptions), ("effects", c_uint32),
        ("components", c_uint32), ("level", c_uint32), ("textures", c_uint32), ("views", c_uint32), ("lights", c_uint32),
        ("gpu_bytes", c_size_t), ("full_gpu_bytes", c_size_t), ("cost", c_float), ("full_cost", c_float),
        ("measured", c_int), ("psnr_linear", c_float), ("psnr_srgb", c_float), ("full_psnr_linear", c_float),
        ("full_psnr_srgb", c_float), ("between_psnr_linear", c_float), ("between_psnr_srgb", c_float),
        ("full_between_psnr_linear", c_float), ("full_between_psnr_srgb", c_float), ("fold", c_int),
        ("fold_bytes", c_size_t), ("folded_cost", c_float), ("fold_pixels", c_double), ("price", c_float)]


class LightSampling(ctypes.Structure):
    _fields_ = [("n_views", c_uint32), ("n_lights", c_uint32), ("n_triangles", c_uint32), ("triangles", POINTER(c_uint32)),
                ("densities", POINTER(c_float))]


class RefSampling(ctypes.Structure):
    _fields_ = [("n_triangles", c_uint32), ("triangles", c_void_p), ("densities", c_void_p)]


class RefOptions(ctypes.Structure):
    _fields_ = [("effects", c_uint32), ("components", c_uint32), ("interpolation", c_int), ("filter", c_int)]


class RefMaterial(ctypes.Structure):
    _fields_ = [
        ("width", c_uint32), ("height", c_uint32), ("n_views", c_uint32), ("n_lights", c_uint32), ("layout_tight", c_int),
        ("domain_sqrt", c_int), ("colour", c_int), ("half_float", c_int), ("lobes", c_uint32), ("effects", c_uint32),
        ("centres", c_uint32), ("components", c_uint32), ("atlas_width", c_uint32), ("atlas_height", c_uint32),
        ("radiance_scale", c_float), ("shadow_scale", c_float), ("gain_scale", c_float), ("centre_scale", c_float),
        ("sbrdf", c_void_p), ("maps", c_void_p), ("shadow", c_void_p), ("shift", c_void_p), ("gain", c_void_p),
        ("centre", c_void_p), ("residual_texels", c_void_p), ("residual_directions", c_void_p), ("residual_scales", c_void_p),
        ("view_table", c_void_p), ("light_table", c_void_p), ("view_grid", c_uint32), ("light_grid", c_uint32),
        ("store", c_int), ("blend", c_int), ("horizon_scale", c_float), ("factor_classes", (c_uint32 * 3) * 5),
        ("factor_texels", c_void_p), ("factor_directions", c_void_p), ("factor_scales", c_void_p), ("factor_views", c_void_p),
        ("points_packed", c_int), ("gain_base", c_float), ("gain_step", c_float), ("points", c_void_p),
        ("point_lists", c_void_p), ("point_indices", c_void_p), ("heights", c_void_p), ("view_vectors", c_void_p),
        ("relief_base", c_int32), ("relief_step", c_int32), ("relief_steps", c_uint32), ("gloss_share", c_uint32),
        ("level", c_uint32), ("relief_end", c_uint32)]


def _find(name):
    """The library beside this package's prefix, in $OPENBTF_LIBDIR, or wherever the loader looks."""
    file = "lib%s.so.0.2" % name
    places = [os.environ["OPENBTF_LIBDIR"]] if "OPENBTF_LIBDIR" in os.environ else []
    here = pathlib.Path(__file__).resolve().parent
    places += [here / "lib"]
    for parent in here.parents:
        if parent.name != "lib": # Debian's folder of an architecture, meson's where it does not know Debian, anybody's
            places += sorted(parent.glob("lib/*-linux-gnu*")) + [parent / "lib64", parent / "lib"]
        if len(places) > 24:
            break
    for place in places:
        path = pathlib.Path(place) / file
        if path.is_file():
            return str(path)
    return file


def load(name):
    """Opens lib<name>; ImportError says where it was looked for. A library that the linker finds is taken last."""
    try:
        return ctypes.CDLL(_find(name))
    except OSError as error:
        raise ImportError("lib%s is not installed where the openbtf package looks (its own prefix, $OPENBTF_LIBDIR, the "
                          "linker's folders): %s" % (name, error)) from error


_FLOATS = POINTER(c_float)
_SIGNATURES = {
    "btf_result_text": (c_char_p, [c_int]),
    "btf_material_open": (c_int, [c_char_p, POINTER(Log), POINTER(c_void_p)]),
    "btf_material_open_memory": (c_int, [c_void_p, c_size_t, POINTER(Log), POINTER(c_void_p)]),
    "btf_material_close": (None, [POINTER(c_void_p)]),
    "btf_material_get_info": (c_int, [c_void_p, POINTER(Info)]),
    "btf_material_level_texture": (Texture, [c_void_p, c_uint32, c_int]),
    "btf_texture_name": (c_char_p, [c_int]),
    "btf_material_views": (Directions, [c_void_p]),
    "btf_material_lights": (Directions, [c_void_p]),
    "btf_material_errors": (POINTER(MaterialError), [c_void_p, POINTER(c_size_t)]),
    "btf_material_between_errors": (BetweenErrors, [c_void_p]),
    "btf_material_save": (c_int, [c_void_p, c_char_p, POINTER(Log)]),
    "btf_material_restrict": (c_int, [c_void_p, POINTER(Plan), POINTER(Log), POINTER(c_void_p)]),
    "btf_cost_model_open": (c_int, [c_char_p, POINTER(Log), POINTER(CostModel)]),
    "btf_plan_effects": (c_int, [c_void_p, POINTER(Scene), c_float, POINTER(Plan)]),
    "btf_shader_source": (c_int, [c_void_p, POINTER(ShaderOptions), POINTER(Log), POINTER(c_void_p)]),
    "btf_free": (None, [c_void_p]),
    "btf_evaluator_create": (c_int, [c_void_p, POINTER(Log), POINTER(c_void_p)]),
    "btf_evaluator_destroy": (None, [POINTER(c_void_p)]),
    "btf_evaluate_many": (c_int, [c_void_p, POINTER(EvaluateOptions), POINTER(Evaluations)]),
    "btf_light_sampling_create": (c_int, [c_void_p, c_void_p, POINTER(Log), POINTER(POINTER(LightSampling))]),
    "btf_light_sampling_destroy": (None, [POINTER(POINTER(LightSampling))]),
}
_REFERENCE_SIGNATURES = {
    "btf_ref_sample_light": (None, [POINTER(RefMaterial), POINTER(RefSampling), c_float, c_float, c_void_p, c_uint32,
                                    c_uint32, c_void_p, c_void_p]),
    "btf_ref_pdf_light": (c_float, [POINTER(RefMaterial), POINTER(RefSampling), c_float, c_float, c_void_p, c_void_p]),
    "btf_ref_evaluate_stochastic": (None, [POINTER(RefMaterial), POINTER(RefOptions), c_int, c_float, c_float, c_void_p,
                                           c_void_p, c_void_p, c_void_p]),
}


def declare(library, signatures):
    """Tells ctypes the types of the functions."""
    for name, (result, arguments) in signatures.items():
        function = getattr(library, name)
        function.restype = result
        function.argtypes = arguments
    return library


library = declare(load("openbtf"), _SIGNATURES)
reference = declare(load("openbtf_reference"), _REFERENCE_SIGNATURES)


class Messages:
    """Collects what one call logs; errors become the exception's text, the rest goes to logging's "openbtf"."""

    def __init__(self):
        self.errors = []
        self._callback = Log.CALLBACK(self._take)
        self.c = Log(self._callback, None)

    def _take(self, _user, level, message):
        text = message.decode("utf-8", "replace")
        if level == 0:
            self.errors.append(text)
        else:
            log.log(logging.WARNING if level == 1 else logging.INFO, "%s", text)

    @property
    def pointer(self):
        return ctypes.byref(self.c)

    def check(self, result):
        """Raises what a result code stands for."""
        if result == 0:
            return
        text = "; ".join(self.errors) or library.btf_result_text(result).decode()
        if result == 5:
            raise MemoryError(text)
        if result == 8:
            raise KeyboardInterrupt(text)
        raise _ERRORS.get(result, Error)(text, result)
