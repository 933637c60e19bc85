#!/usr/bin/env python3
"""Two materials side by side: what one texel reflects over all lights (its apparent BRDF), and how far the materials are
apart.

    abrdf.py A.btf.exr [B.btf.exr] [-o NAME]      NAME.png by matplotlib; without it NAME.csv

SPDX-License-Identifier: MIT
"""
import argparse

import numpy as np
import openbtf

parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
parser.add_argument("materials", nargs="+", metavar="MATERIAL")
parser.add_argument("-o", "--output", default="abrdf", metavar="NAME")
arguments = parser.parse_args()
materials = [openbtf.open(path) for path in arguments.materials]
for m in materials:
    print(m)

# 1. Every light of a disc: x and y of the light, seen from 30 degrees, at the middle of the tile.
side = 128
x, y = np.meshgrid(np.linspace(-1, 1, side), np.linspace(1, -1, side))
height = 1 - x**2 - y**2
l = np.stack([x, y, np.sqrt(np.maximum(height, 0))], -1)
v = [0.5, 0, 0.75**0.5]
lobes = [m.evaluate([0.5, 0.5], l, v, filter="bilinear") for m in materials]

# 2. How much each reflects of a white sky: the mean over lights in proportion to the solid angle of a disc's points.
inside = height > 1e-3
weight = (inside / np.sqrt(np.maximum(height, 1e-3)))[..., None]
for m, lobe in zip(materials, lobes):
    albedo = (lobe * weight)[inside].sum(0) / np.pi * (2 / side) ** 2
    print("%s: reflects %s of a white sky" % (m.method[2] or "material", np.round(albedo, 3)))
if len(lobes) == 2:
    print("RMS between them: %.4f" % np.sqrt(np.mean((lobes[0] - lobes[1])[inside] ** 2)))

try:
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plot
except ImportError:
    name = arguments.output + ".csv"
    np.savetxt(name, np.concatenate([lobe[side // 2] for lobe in lobes], 1), delimiter=",", fmt="%.6g",
               header="radiance along lights from -u to +u: r,g,b of each material")
    print("%s (matplotlib is not installed: no picture)" % name)
else:
    figure, axes = plot.subplots(1, len(lobes) + 1, figsize=(4 * (len(lobes) + 1), 4))
    for axis, m, lobe in zip(axes, materials, lobes):
        axis.imshow(np.where(inside[..., None], np.clip(lobe, 0, 1) ** (1 / 2.2), 1), extent=(-1, 1, -1, 1))
        axis.set_title("lights over texel (0.5, 0.5)")
        axes[-1].plot(x[0], lobe[side // 2].mean(-1), label=m.method[2] or "material")
    axes[-1].set_xlabel("light, x")
    axes[-1].set_ylabel("radiance")
    axes[-1].legend()
    figure.tight_layout()
    figure.savefig(arguments.output + ".png", dpi=100)
    print(arguments.output + ".png")
