"""OpenBTF: bidirectional texture functions, compressed.

    import openbtf
    m = openbtf.open("cloth.btf.exr")
    m.evaluate(uv, l, v)        # radiance for arrays of texture coordinates, lights and views
    m.image(view=0, light=3)    # what the whole material shows
    m.glsl()                    # the shader that decodes it
    m.textures()                # what it reads, as arrays

    d = openbtf.read("UBO2003.zip")     # samples: folders, archives, Bonn .btf files
    d.image(view=0, light=3)
    openbtf.encode(d_or_path, "cloth.btf.exr")

Directions are unit vectors of the tangent frame (x along +u, y along +v, z the normal) to the viewer and to the light;
colours are linear Rec. 709. Errors are exceptions with the messages of the C library.

SPDX-License-Identifier: MIT
"""
from ._library import BadFileError, Error, FileError, UnsupportedError, UsageError
from ._options import EFFECTS
from ._plan import Plan
from .material import Material, open
from .data import Data, encode, read, write

__all__ = ["BadFileError", "Data", "EFFECTS", "Error", "FileError", "Material", "Plan", "UnsupportedError", "UsageError",
           "encode", "open", "read", "write"]
__version__ = "0.2.0"
for _error in (BadFileError, Error, FileError, UnsupportedError, UsageError): # as tracebacks show them
    _error.__module__ = __name__
