"""The words that options of this package take, and the numbers that the C library has for them.

SPDX-License-Identifier: MIT
"""
import numpy as np

from . import _library as c

EFFECTS = {"shadow": 1, "shift": 2, "hidden": 4, "gain": 8, "residual": 16, "relief": 32, "gloss": 64}
INTERPOLATIONS = {"linear": 0, "nearest": 1}
FILTERS = {"texel": 0, "bilinear": 1, "steep": 2}
MATHS = {"exact": 0, "fast": 1}
BINDINGS = {"none": 0, "gl": 1, "vulkan": 2}
PICKS = {"none": 0, "view": 1, "light": 2, "all": 3}
FOLDS = {"none": 0, "light": 1, "both": 2, "neighbours": 3}


def choice(table, value, name):
    """The number of a word. Raises UsageError, which lists the words, where `value` is none of them."""
    try:
        return table[value]
    except (KeyError, TypeError):
        raise c.UsageError("%s is %r; it can be %s" % (name, value, ", ".join(map(repr, table))), 1) from None


def names_of(mask):
    """The names of the effects in a btf_effect mask."""
    return tuple(name for name, bit in EFFECTS.items() if mask & bit)


def leave_out(effects):
    """The btf_effect bits to leave out so that `effects` are decoded: names, or None for all."""
    if effects is None:
        return 0
    if isinstance(effects, str):
        effects = [effects]
    keep = 0
    for effect in effects:
        keep |= choice(EFFECTS, effect, "effect")
    return sum(EFFECTS.values()) & ~keep


def components_of(count):
    """The member `components` of the C structures, where 0 means all. For none at all the effect `residual` is left
    out."""
    if count is None:
        return 0
    if count < 1:
        raise c.UsageError("components is %r; it is at least 1, and without \"residual\" in effects there are none" % (count,), 1)
    return int(count)


def vectors(value, length, name):
    """`value` as float32 vectors; raises UsageError where its last axis is not `length` long."""
    array = np.asarray(value, np.float32)
    if array.ndim == 0 or array.shape[-1] != length:
        raise c.UsageError("%s has shape %s; the last axis has to be %d long" % (name, array.shape, length), 1)
    return array
