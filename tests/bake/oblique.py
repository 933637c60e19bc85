"""Compares the sheared camera with an ordinary orthographic one, whose picture a homography turns into texels.

    blender --background --factory-startup waves.blend --python oblique.py -- SOURCE_ROOT FOLDER

Renders waves.blend from (60, 36) lit from (40, 120) both ways, prints the RMS of the difference and the correlation, and
writes RMS, correlation to FOLDER/oblique.txt.

SPDX-License-Identifier: MIT
"""
import math
import os
import sys

import numpy

SOURCE, FOLDER = sys.argv[-2:]
sys.path.insert(0, os.path.join(SOURCE, 'encoder/bake'))
sys.dont_write_bytecode = True
import bake_checks  # noqa: E402
import bake_directions  # noqa: E402
import bake_exr  # noqa: E402
import bake_scene  # noqa: E402
from bake_settings import Settings  # noqa: E402
from mathutils import Matrix  # noqa: E402

VIEW, LIGHT = (60.0, 36.0), (40.0, 120.0)
TEXELS, FINE = 16, 256  # FINE: pixels along each side of the ordinary picture, which shows 2 x 2 tiles

settings = Settings(output='-', texels=(TEXELS, TEXELS), samples=256, bounces=1, views='60:1:36', lights='40:1:120')
path = os.path.join(FOLDER, 'oblique.exr')
with bake_scene.BakeScene(settings) as baking:
    bake_checks.check(baking, [VIEW], [LIGHT], path, lambda *_, **__: None)
    baking.set_light(LIGHT)
    baking.set_view(VIEW)
    baking.render(path, 1)
    sheared = bake_exr.read_rgb(path)

    # An ordinary camera: its axes right, up and back (the direction to the viewer) are orthonormal, and its picture is
    # centred on the tile.
    back = numpy.array(bake_directions.vector(VIEW))
    right = numpy.cross((0, 0, 1), back)
    right /= numpy.linalg.norm(right)
    up = numpy.cross(back, right)
    centre = numpy.array([0.5, 0.5, 0]) + 4 * back
    rows = [[right[i], up[i], back[i], centre[i]] for i in range(3)]
    baking.camera.matrix_parent_inverse = Matrix((*rows, (0, 0, 0, 1)))
    baking.camera.data.ortho_scale, baking.camera.data.clip_end = 2, 20
    baking.scene.render.resolution_x = baking.scene.render.resolution_y = FINE
    baking.scene.cycles.samples = 16
    baking.render(path, 2)
    ordinary = bake_exr.read_rgb(path)

# Projects points of the reference plane, 8 x 8 a texel, into the ordinary picture and reads them there bilinearly.
fine = (numpy.arange(8 * TEXELS) + .5) / (8 * TEXELS)
x, y = numpy.meshgrid(fine, 1 - fine)
offset = numpy.stack([x - .5, y - .5, numpy.zeros_like(x)], 2)
column = (offset @ right / 2 + .5) * FINE - .5
row = (.5 - offset @ up / 2) * FINE - .5
c, r = numpy.floor(column).astype(int), numpy.floor(row).astype(int)
u, v = (column - c)[..., None], (row - r)[..., None]
looked = ((1 - v) * ((1 - u) * ordinary[r, c] + u * ordinary[r, c + 1]) +
          v * ((1 - u) * ordinary[r + 1, c] + u * ordinary[r + 1, c + 1]))
looked = looked.reshape(TEXELS, 8, TEXELS, 8, 3).mean((1, 3))
rms = math.sqrt(((looked - sheared) ** 2).mean())
correlation = numpy.corrcoef(looked.ravel(), sheared.ravel())[0, 1]
with open(os.path.join(FOLDER, 'oblique.txt'), 'w', encoding='utf-8') as file:
    file.write(f'{rms:.5f} {correlation:.5f} {sheared.std():.5f}\n')
