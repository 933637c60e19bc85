#!/usr/bin/env python3
"""Makes the add-on's zip, which Blender installs (Edit > Preferences > Add-ons > Install).

    zip.py OUT.zip [VERSION]     VERSION as in 0.2.0: into bl_info

The modules of encoder/bake go beside those of the add-on, into one folder openbtf_bake. The same sources make the same
bytes.

SPDX-License-Identifier: MIT
"""
import os
import re
import sys
import zipfile

HERE = os.path.dirname(os.path.abspath(__file__))
PACKAGE = 'openbtf_bake'


def modules():
    """Names and paths of what goes into the package."""
    for folder in (HERE, os.path.dirname(HERE)):
        for name in sorted(os.listdir(folder)):
            if name.endswith('.py') and not (folder == HERE and name == 'zip.py'):
                yield name, os.path.join(folder, name)


def main():
    if len(sys.argv) not in (2, 3) or not sys.argv[1].endswith('.zip'):
        sys.exit('usage: zip.py OUT.zip [VERSION]')
    out = sys.argv[1]
    beside = f'{out}.part{os.getpid()}'
    try:
        with zipfile.ZipFile(beside, 'w', zipfile.ZIP_DEFLATED) as archive:
            for name, path in modules():
                with open(path, encoding='utf-8') as file:
                    text = file.read()
                if name == '__init__.py' and len(sys.argv) == 3:
                    numbers = tuple(map(int, sys.argv[2].split('.')))
                    text, count = re.subn(r"'version': \([0-9, ]*\)", f"'version': {numbers}", text)
                    if count != 1:
                        sys.exit(f'{path}: no version to set')
                entry = zipfile.ZipInfo(f'{PACKAGE}/{name}', (1980, 1, 1, 0, 0, 0))
                entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
                archive.writestr(entry, text)
        os.replace(beside, out)
    finally:
        if os.path.exists(beside):
            os.unlink(beside)


if __name__ == '__main__':
    main()
