"""Marks a wheel that has the C libraries in it as one for this kind of machine alone, which pyproject.toml cannot say.

SPDX-License-Identifier: MIT
"""
import glob

from setuptools import setup
from setuptools.dist import Distribution


class WithLibraries(Distribution):
    def has_ext_modules(self):
        return bool(glob.glob("openbtf/lib/*.so*"))


setup(distclass=WithLibraries)
