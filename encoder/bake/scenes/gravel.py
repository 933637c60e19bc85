"""Writes a tile of gravel: rounded stones that lie on one another, and touch without running into one another.

    blender -b --factory-startup -P gravel.py -- -o gravel.blend

Each stone falls straight down at a few places, onto what lies there already, and stays where its middle comes to rest
lowest. (Deposition with restructuring, without rolling: R. Jullien and P. Meakin, Europhysics Letters 4, 1987.)

SPDX-License-Identifier: MIT
"""
import os
import sys

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import tile  # noqa: E402

STONES, PLACES = 78, 300
CELLS = 256  # cells along a side of the height field onto which stones fall
STEPS = 16   # samples along an edge of a triangle; they lie closer together than cells
COLOURS = [('granite', (0.30, 0.29, 0.28), 0.6), ('slate', (0.10, 0.115, 0.13), 0.45), ('sandstone', (0.42, 0.29, 0.17), 0.8),
           ('quartz', (0.68, 0.64, 0.57), 0.35), ('porphyry', (0.27, 0.10, 0.07), 0.55), ('basalt', (0.05, 0.05, 0.055), 0.4),
           ('ochre', (0.50, 0.33, 0.14), 0.75)]
SHARES = [0.26, 0.16, 0.18, 0.12, 0.10, 0.06, 0.12]


def icosphere(subdivisions):
    """Unit vectors and triangles of a sphere: an icosahedron whose triangles are cut into four, `subdivisions`
    times."""
    g = (1 + np.sqrt(5)) / 2
    vertices = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g), (0, -1, -g), (0, 1, -g),
                (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]
    vertices = [np.array(v) / np.linalg.norm(v) for v in vertices]
    triangles = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6),
                 (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7),
                 (9, 8, 1)]
    for _ in range(subdivisions):
        middles, finer = {}, []

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                middles[key] = len(vertices)
                vertices.append((vertices[a] + vertices[b]) / np.linalg.norm(vertices[a] + vertices[b]))
            return middles[key]

        for a, b, c in triangles:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        triangles = finer
    return np.array(vertices), np.array(triangles)


def normals_of(vertices, triangles):
    """Normals of a closed mesh: at each vertex the mean of its triangles' normals, weighted by area."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    face = np.cross(b - a, c - a)
    sums = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(sums, triangles[:, k], face)
    return tile.unit(sums)


def turned(yaw, tilt, roll):
    def about(axis, angle):
        c, s = np.cos(angle), np.sin(angle)
        i, j = [k for k in range(3) if k != axis]
        m = np.eye(3)
        m[i, i], m[i, j], m[j, i], m[j, j] = c, -s, s, c
        return m
    return about(2, yaw) @ about(0, tilt) @ about(1, roll)


def stone(random, sphere):
    """Vertices of a stone around the origin: an ellipsoid that lies flat, more or less, with a few broad dents."""
    bumps = np.zeros(len(sphere))
    for _ in range(6):
        wave = random.normal(size=3) * 1.7
        bumps += random.uniform(0.015, 0.05) * np.cos(sphere @ wave + random.uniform(0, 2 * np.pi))
    size = np.clip(0.060 * np.exp(0.28 * random.normal()), 0.036, 0.095)
    axes = size * np.array([random.uniform(1.0, 1.35), random.uniform(0.85, 1.05), random.uniform(0.55, 0.8)])
    return (sphere * (1 + bumps)[:, None] * axes) @ turned(
        random.uniform(0, 2 * np.pi), 0.28 * random.normal(), 0.28 * random.normal()).T


def footprint(vertices, triangles):
    """Cells that a stone covers, relative to its middle: columns, rows, and its lowest and highest z in each."""
    i, j = np.meshgrid(np.arange(STEPS + 1), np.arange(STEPS + 1), indexing='ij')
    weights = np.stack([i, j, STEPS - i - j], axis=-1)[i + j <= STEPS] / STEPS
    points = np.einsum('sk,tkd->tsd', weights, vertices[triangles]).reshape(-1, 3)
    cell = np.floor(points[:, :2] * CELLS).astype(int)
    lowest = cell.min(axis=0)
    width, height = cell.max(axis=0) - lowest + 1
    low, high = np.full((width, height), np.inf), np.full((width, height), -np.inf)
    at = tuple((cell - lowest).T)
    np.minimum.at(low, at, points[:, 2])
    np.maximum.at(high, at, points[:, 2])
    x, y = np.nonzero(np.isfinite(low))
    return x + lowest[0], y + lowest[1], low[x, y], high[x, y]


def main():
    given = tile.arguments('Writes a tile of gravel as a scene of Blender.', seed=7)
    random = np.random.RandomState(given.seed)  # its numbers stay the same in every version of numpy
    tile.begin()
    sphere, triangles = icosphere(2)
    part = tile.Part('stones', [tile.material(name, colour, roughness=rough) for name, colour, rough in COLOURS])
    heights = np.zeros((CELLS, CELLS))
    for _ in range(STONES):
        vertices = stone(random, sphere)
        x, y, low, high = footprint(vertices, triangles)
        places = random.randint(0, CELLS, size=(PLACES, 2))
        # The tile is a torus here: a stone that reaches beyond one side comes back on the other.
        columns, rows = (places[:, :1] + x) % CELLS, (places[:, 1:] + y) % CELLS
        rest = (heights[columns, rows] - low).max(axis=1)
        best = rest.argmin()
        at = columns[best], rows[best]
        heights[at] = np.maximum(heights[at], rest[best] + high)
        vertices = vertices + [places[best, 0] / CELLS, places[best, 1] / CELLS, rest[best]]
        part.add(vertices, normals_of(vertices, triangles), triangles, random.choice(len(COLOURS), p=SHARES))
    soil = tile.material('soil', (0.06, 0.045, 0.03), roughness=0.95, specular=0.1)
    tile.finish([part, tile.ground(0.0, soil)], given.output)


main()
