"""Writes a tile of overlapping scales, green above and copper at their thick front ends: from one side the surface is
green, from the other mostly copper, for each scale hides the front of the one behind it or shows its own.

    blender -b --factory-startup -P scales.py -- -o scales.blend

SPDX-License-Identifier: MIT
"""
import os
import sys

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import tile  # noqa: E402

COLUMNS, ROWS = 5, 8  # an even number of rows: each is moved by half a scale against the next
LENGTH = 0.27
THICKNESS = 0.004, 0.040  # at the root and at the tip
LIFT = np.radians(18)
ALONG, ACROSS = 16, 14  # quadrilaterals along and across a side of a scale


def outline(v):
    """The width of a scale at v, from its root (0) to its tip (1), as a fraction of its greatest width."""
    return np.where(v < 0.55, 0.88 + 0.12 * np.sin(np.pi * v / 1.1), np.sqrt(1 - np.clip((v - 0.55) / 0.45, 0, 1) ** 2.2))


def blade(u, v, lift, curl):
    """The upper side of a scale at u across (-1 to 1) and v along, with its root at the origin and its tip towards -y."""
    half = 0.5 * 0.97 / COLUMNS * outline(v)
    arch = 0.018 * (1 - u ** 2) * np.sin(np.pi * np.clip(0.15 + 0.85 * v, 0, 1)) ** 0.5
    keel = 0.009 * np.exp(-(u / 0.13) ** 2) * np.clip(1.25 * (1 - v), 0, 1) ** 0.5
    along = LENGTH * v
    z = along * np.sin(lift) + arch + keel + curl * v ** 3
    return np.stack([half * u, -along * np.cos(lift), z], axis=-1)


def side(position):
    """Upward unit normals of a grid of positions (rows along v, columns along u)."""
    du, dv = np.gradient(position, axis=1), np.gradient(position, axis=0)
    normal = np.cross(dv, du)
    short = np.linalg.norm(normal, axis=-1, keepdims=True)
    return np.where(short > 1e-12, normal / np.maximum(short, 1e-12), [0.0, 0.0, 1.0])


def add_scale(part, x, y, lift, curl, upper):
    """A closed body: above, below, and the rim between them."""
    v, u = np.meshgrid(1 - np.linspace(1, 0, ALONG + 1) ** 1.5, np.linspace(-1, 1, ACROSS + 1), indexing='ij')
    v = np.minimum(v, 0.999)  # the tip is a very short edge, not a point: a point has no normal
    above = blade(u, v, lift, curl)
    normals = side(above)
    below = above - normals * (THICKNESS[0] + (THICKNESS[1] - THICKNESS[0]) * v ** 1.5)[..., None]
    place = np.array([x, y, 0.0])
    grid = tile.lattice(ALONG + 1, ACROSS + 1, closed=False)
    part.add((above + place).reshape(-1, 3), normals.reshape(-1, 3), grid[:, ::-1], upper)
    part.add((below + place).reshape(-1, 3), -normals.reshape(-1, 3), grid, 2)
    around = np.concatenate([np.arange(ACROSS + 1), np.arange(2, ALONG + 1) * (ACROSS + 1) - 1,
                             np.arange((ALONG + 1) * (ACROSS + 1) - 1, ALONG * (ACROSS + 1) - 1, -1),
                             np.arange(ALONG - 1, 0, -1) * (ACROSS + 1)])
    rim = np.stack([above.reshape(-1, 3)[around], below.reshape(-1, 3)[around]])
    forwards = np.roll(rim[0], -1, axis=0) - np.roll(rim[0], 1, axis=0)  # clockwise, seen from above
    outwards = tile.unit(np.cross(forwards, rim[1] - rim[0]))
    front = np.where(v.ravel()[around] > 0.5, 2, upper)
    part.add((rim + place).reshape(-1, 3), np.tile(outwards, (2, 1)), tile.lattice(2, len(around), closed=True),
             np.tile(front, 2))


def main():
    given = tile.arguments('Writes a tile of scales as a scene of Blender.', seed=3)
    random = np.random.RandomState(given.seed)
    tile.begin()
    part = tile.Part('scales', [tile.material('green', (0.02, 0.30, 0.20), roughness=0.35, specular=0.6),
                                tile.material('deep green', (0.02, 0.20, 0.19), roughness=0.35, specular=0.6),
                                tile.material('copper', (0.80, 0.25, 0.05), roughness=0.45, specular=0.4)])
    for row in range(ROWS):
        for column in range(COLUMNS):
            x, y = (column + 0.25 + 0.5 * (row % 2)) / COLUMNS, 1 - (row + 0.1) / ROWS
            add_scale(part, x, y, LIFT + np.radians(2.0) * random.normal(), 0.02 + 0.006 * random.normal(),
                      int(random.uniform() < 0.4))
    skin = tile.material('skin', (0.50, 0.13, 0.03), roughness=0.8, specular=0.2)
    lowest = np.concatenate(part.vertices)[:, 2].min()
    tile.finish([part, tile.ground(lowest - 0.002, skin)], given.output)


main()
