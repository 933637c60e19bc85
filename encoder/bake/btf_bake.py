"""Bakes a scene of Blender into a data set that btf-encode reads: every view under every light, by Cycles on the CPU.

btf-bake, the driver, starts Blender with this file and hands it the settings in JSON:

    blender --background SCENE.blend --python btf_bake.py -- SETTINGS.json REPORT_FD

Within Blender, as an add-on does, put this folder on sys.path and call

    import btf_bake
    btf_bake.run(btf_bake.Settings(output='/tmp/cloth', texels=(32, 32), directions='small'))

for the file that is open. encoder/bake/README.md says what is baked, and how.

SPDX-License-Identifier: MIT
"""
import hashlib
import json
import os
import sys
import time
import zlib

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import bake_settings  # noqa: E402
from bake_settings import BAD_FILE, IO, UNSUPPORTED, BakeError, Settings  # noqa: E402,F401

settings = Settings  # either name

RECORD = 'bake.json'  # how a data set was made, in its folder


def run(settings, report=None):
    """Bakes the file that is open in Blender; the open file is left as it is.

    settings: a Settings; what is asked for of output, position and preview is written.
    report: called as report(kind, **values) from this thread: kind 'info' or 'warning' with text=; 'progress' with
    stage=, done=, total= and left=, the seconds until the end of the stage, negative where they are not known yet. What it
    raises ends the bake between two images, and passes through; a later run with the same settings goes on there.
    Returns {'images': of this part, 'rendered': by this run, 'missing': of the other parts, 'seconds', 'triangles'}.
    Raises BakeError, whose text is for the user and whose code is an exit code of the tools."""
    report = report or (lambda kind, **values: None)
    settings.check()
    raise BakeError(UNSUPPORTED, 'not there yet')


def main():
    """As the driver starts it: reports are JSON lines to the descriptor, the last one of kind 'end'."""
    arguments = sys.argv[sys.argv.index('--') + 1:]
    with open(arguments[0], encoding='utf-8') as file:
        asked = bake_settings.from_json(file.read())


if __name__ == '__main__':
    main()
