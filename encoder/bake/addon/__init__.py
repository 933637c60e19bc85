"""Bakes a BTF from within Blender: File > Export, and a panel in the material tab.

The settings are those of btf-bake and the code is the same: the modules of encoder/bake, which lie beside this file in the
add-on's zip (addon/zip.py) and one folder up in the repository.

SPDX-License-Identifier: MIT
"""
import os
import sys

bl_info = {
    'name': 'OpenBTF: bake a BTF',
    'author': 'OpenBTF',
    'version': (0, 2, 0),
    'blender': (3, 0, 0),
    'location': 'File > Export, and Properties > Material',
    'description': 'Renders a surface under every view and light, as a data set or as a material for a shader',
    'category': 'Import-Export',
}

_here = os.path.dirname(os.path.abspath(__file__))
for _folder in (_here, os.path.dirname(_here)):
    if os.path.exists(os.path.join(_folder, 'btf_bake.py')):
        if _folder not in sys.path:
            sys.path.insert(0, _folder)
        break
else:
    raise ImportError(f'{_here}: btf_bake.py is missing: the add-on has to be installed from the zip that addon/zip.py makes')

from . import operators, panel, properties  # noqa: E402


def register():
    for module in (properties, operators, panel):
        module.register()


def unregister():
    for module in (panel, operators, properties):
        module.unregister()
