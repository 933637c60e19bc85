"""Writes a tile of plain knitting: 5 x 7 stitches, yarn of three twisted plies, a diamond knitted in.

    blender -b --factory-startup -P knit.py -- -o knit.blend

SPDX-License-Identifier: MIT
"""
import os
import sys

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import tile  # noqa: E402

WALES, COURSES = 5, 7  # stitches along x and y
# K. Crane, "A Simple Parametric Model of Plain-Knit Yarns" (2023): the curve (t + a sin 2t, h cos t, d cos 2t), courses
# about h + 1/2 apart. Five stitches are 31.4 of its units wide, and so are seven courses of 4.49.
SWING, HEIGHT, BULGE = 1.5, 4.0, 1.0
UNIT = 1 / (2 * np.pi * WALES)
RADIUS = 0.72 # of the yarn, thicker than Crane's for a fuller fabric; courses are 1.53 apart where they pass each other
SEGMENTS, SIDES, PLIES, TURNS = 44, 6, 3, 4 # of a stitch: rings of vertices, their corners, plies, turns of the twist
COLOURS = {'.': ('navy', (0.035, 0.075, 0.20)), 'o': ('cream', (0.72, 0.62, 0.45)), 'x': ('rust', (0.50, 0.085, 0.03))}
PATTERN = ['x.x.x',
           '..o..',
           '.ooo.',
           'ooxoo',
           '.ooo.',
           '..o..',
           '.....']


def centre_line(t):
    """The yarn of a course at parameters t, (n, 3), in units of the model. z is turned round: the side with the V's is up."""
    return np.stack([t + SWING * np.sin(2 * t), HEIGHT * np.cos(t), -BULGE * np.cos(2 * t)], axis=-1)


def even_parameters(count):
    """count parameters of [0, 2 pi) at equal steps of arc length, one stitch."""
    fine = np.linspace(0, 2 * np.pi, 4001)
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(centre_line(fine), axis=0), axis=1))])
    return np.interp(np.arange(count) / count * length[-1], length, fine)


def across(curve, shift):
    """Two unit vectors across a curve at each of its points. After its last point the curve goes on with its first,
    moved by `shift`. No part of it may run along z."""
    after = np.concatenate([curve[1:], curve[:1] + shift])
    before = np.concatenate([curve[-1:] - shift, curve[:-1]])
    tangent = tile.unit(after - before)
    first = np.array([0.0, 0.0, 1.0]) - tangent[:, 2:] * tangent
    first = tile.unit(first)
    return first, np.cross(tangent, first)


def clearance():
    """The least distance between centre lines of neighbouring courses, in units of the model."""
    t = even_parameters(400)
    curve = np.concatenate([centre_line(t) + [2 * np.pi * k, 0, 0] for k in (-1, 0, 1)])
    above = centre_line(t) + [0, 1 / (UNIT * COURSES), 0]
    return np.linalg.norm(above[:, None] - curve[None], axis=-1).min()


def add_course(part, course, slots):
    t = np.concatenate([even_parameters(SEGMENTS) + 2 * np.pi * w for w in range(WALES)])
    shift = np.array([2 * np.pi * WALES, 0, 0])
    yarn = centre_line(t)
    first, second = across(yarn, shift)
    # Three circles that touch one another within one of radius RADIUS.
    ply = RADIUS / (1 + 2 / np.sqrt(3))
    # By stretches of equal arc length. A whole number of turns a stitch joins ends and colours.
    twist = 2 * np.pi * TURNS * np.arange(len(t)) / SEGMENTS
    corner = 2 * np.pi * np.arange(SIDES) / SIDES
    for p in range(PLIES):
        angle = (twist + 2 * np.pi * p / PLIES)[:, None]
        line = yarn + (RADIUS - ply) * (np.cos(angle) * first + np.sin(angle) * second)
        u, v = across(line, shift)
        out = np.cos(corner)[None, :, None] * u[:, None] + np.sin(corner)[None, :, None] * v[:, None]
        rings = line[:, None] + ply * out
        # One more ring, the first of the next tile, so that the neighbour's copy begins where this one ends.
        rings = np.concatenate([rings, rings[:1] + shift])
        out = np.concatenate([out, out[:1]])
        rings = rings * UNIT + [0, (course + 0.5) / COURSES, 0]
        triangles = tile.lattice(len(rings), SIDES, closed=True)
        # A stitch looks like its two legs: it goes from the foot at one odd multiple of pi to that at the next.
        ring = triangles.min(axis=1) // SIDES
        stitch = (ring + SEGMENTS // 2) // SEGMENTS % WALES
        part.add(rings.reshape(-1, 3), out.reshape(-1, 3), triangles, np.asarray(slots)[stitch] * PLIES + p)


def main():
    given = tile.arguments('Writes a tile of plain knitting as a scene of Blender.')
    if clearance() < 2 * RADIUS:
        raise ValueError(f'courses are {clearance():.3f} apart, and the yarn is {2 * RADIUS} thick')
    tile.begin()
    # Plies of one yarn differ a little, as those of tweed do.
    materials = [tile.material(f'{name} {p + 1}', np.array(colour) * tint, roughness=0.85, specular=0.2, sheen=0.4)
                 for name, colour in COLOURS.values() for p, tint in enumerate((1, 0.85, 1.12))]
    part = tile.Part('yarn', materials)
    for course, row in enumerate(reversed(PATTERN)):
        add_course(part, course, [list(COLOURS).index(letter) for letter in row])
    lowest = np.concatenate(part.vertices)[:, 2].min()
    lining = tile.material('lining', (0.02, 0.02, 0.025), roughness=0.9, specular=0.1)
    tile.finish([part, tile.ground(lowest - 0.005, lining)], given.output)


main()
