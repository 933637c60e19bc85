"""Checks of the images of a bake. Each prints what it measured; exit code 1 where it does not hold.

    images.py white DIR                   every texel is cos(theta_l)
    images.py post DIR                    of `axes` from above: shadows fall away from the light, bands lie where they belong
    images.py positions DIR               of `axes`: shifts as tests/sample/relief.h says
    images.py grounded DIR                of `axes` with the reference plane in the ground: it shows no shifts
    images.py alike A B MEAN RMS [C R]    images of the same names differ by at most that, B rolled by C columns, R rows up
    images.py noise A B LEAST MOST        the RMS of what two seeds differ by, divided by the root of 2

SPDX-License-Identifier: MIT
"""
import glob
import math
import os
import re
import sys

import numpy

sys.path.insert(0, os.path.join(os.environ['BTF_SOURCE_ROOT'], 'encoder/bake'))
sys.dont_write_bytecode = True
import bake_exr  # noqa: E402

failed = 0


def hold(right, text):
    global failed
    print(('' if right else 'WRONG: ') + text)
    failed += not right


def images(folder):
    """Returns {path within the folder: ({key: angle}, image)}."""
    found = {}
    for path in sorted(glob.glob(os.path.join(glob.escape(folder), 'tv*/*.exr'))):
        name = os.path.relpath(path, folder)
        angles = {key: float(value) for key, value in re.findall(r'(t[lv]|p[lv])([\d.]+)(?= |\.exr)', os.path.basename(name))}
        found[name] = angles, bake_exr.read_rgb(path).astype(numpy.float64)
    if not found:
        sys.exit(f'{folder}: no images')
    return found


def white(folder):
    worst = 0.0
    for angles, image in images(folder).values():
        error = abs(image - math.cos(math.radians(angles['tl']))).max()
        worst = max(worst, error)
    hold(worst < 0.0005, f'largest difference from cos(theta_l): {worst:.6f}')


def at(image, x, y):
    """The texel at (x, y) of the tile: row 0 is the top."""
    rows, columns, _ = image.shape
    return image[rows - 1 - int(y * rows), int(x * columns)]


def post(folder):
    seen = {}
    for angles, image in images(folder).values():
        if angles['tv'] == 0:
            seen[angles['tl'], angles['pl']] = image
    lit = 0.5 * math.cos(math.radians(45))
    for azimuth, (dx, dy) in {0: (1, 0), 90: (0, 1), 180: (-1, 0), 270: (0, -1)}.items():
        image = seen[45, azimuth]
        away = at(image, 0.5 - dx * 0.12, 0.5 - dy * 0.12)[0]
        towards = at(image, 0.5 + dx * 0.12, 0.5 + dy * 0.12)[0]
        hold(away < 0.01, f'light from azimuth {azimuth}: {away:.4f} behind the post')
        hold(abs(towards - lit) < 0.01, f'light from azimuth {azimuth}: {towards:.4f} in front of it, expected {lit:.4f}')
    # The wedge faces -y: its normal is (0, -depth / 2, 12 / 64), normalised.
    normal = numpy.array([0, -0.125 / 2, 12 / 64])
    normal /= numpy.linalg.norm(normal)
    for azimuth, light in {90: (0, 1), 270: (0, -1)}.items():
        expected = 0.5 * (light[1] * normal[1] + normal[2]) * math.sqrt(0.5)
        got = at(seen[45, azimuth], 0.25, 0.75)[0]
        hold(abs(got - expected) < 0.01, f'the wedge from azimuth {azimuth}: {got:.4f}, expected {expected:.4f}')
    above = seen[0, 0]
    right, top = at(above, 0.97, 0.5), at(above, 0.5, 0.97)
    hold(right[0] > 3 * right[1] and right[0] > 3 * right[2], f'red at the right: {right}')
    hold(top[1] > 3 * top[0] and top[1] > 3 * top[2], f'green at the top: {top}')


def positions(folder):
    depth = 0.125
    above = bake_exr.read_rgb(os.path.join(folder, 'tv000_pv000.exr'))
    rows, columns, _ = above.shape
    x, y = numpy.meshgrid((numpy.arange(columns) + .5) / columns, 1 - (numpy.arange(rows) + .5) / rows)
    error = max(abs(above[:, :, 0] - x).max(), abs(above[:, :, 1] - y).max())
    hold(error < 1e-3, f'from above each texel sees its own place: within {error:.2g}')
    for azimuth, (dx, dy) in {0: (1, 0), 90: (0, 1), 180: (-1, 0), 270: (0, -1)}.items():
        seen = bake_exr.read_rgb(os.path.join(folder, f'tv045_pv{azimuth:03d}.exr'))
        ground = at(seen, 0.5 + 0.3 * dx, 0.1 + 0.2 * abs(dy) + 0.1 * dy)
        expected = numpy.array([int((0.5 + 0.3 * dx) * columns) + .5 - dx * depth * columns,
                                int((0.1 + 0.2 * abs(dy) + 0.1 * dy) * rows) + .5 - dy * depth * rows])
        error = abs(ground[:2] * [columns, rows] - expected).max()
        hold(error < 0.05 and abs(ground[2] + depth) < 1e-4, f'ground from azimuth {azimuth}: {ground}, off by {error:.3f} texels')
        post_top = at(seen, 0.5, 0.5)
        hold(abs(post_top[2]) < 1e-4, f'the top of the post from azimuth {azimuth}: z = {post_top[2]:.5f}')


def grounded(folder):
    for azimuth, (dx, dy) in {0: (1, 0), 90: (0, 1), 180: (-1, 0), 270: (0, -1)}.items():
        seen = bake_exr.read_rgb(os.path.join(folder, f'tv045_pv{azimuth:03d}.exr'))
        rows, columns, _ = seen.shape
        x, y = (0.05, 0.3 + 0.1 * dy) if dy else (0.5 + 0.3 * dx, 0.1)  # on the ground, away from the bodies
        own = numpy.array([(int(x * columns) + .5) / columns, (int(y * rows) + .5) / rows, 0])
        hold(abs(at(seen, x, y) - own).max() < 1e-3, f'ground from azimuth {azimuth}: {at(seen, x, y)}, at {own}')


def alike(a, b, most_mean, most_rms, columns='0', rows='0'):
    a, b = images(a), images(b)
    hold(set(a) == set(b), f'{len(a)} and {len(b)} images of the same names')
    differences = [numpy.roll(b[name][1], (-int(rows), int(columns)), (0, 1)) - a[name][1] for name in a]
    differences = numpy.stack(differences)
    mean, rms = abs(differences.mean()), math.sqrt((differences ** 2).mean())
    hold(mean <= float(most_mean), f'mean difference {mean:.5f}, at most {most_mean}')
    hold(rms <= float(most_rms), f'RMS of the differences {rms:.5f}, at most {most_rms}')


def noise(a, b, least, most):
    a, b = images(a), images(b)
    rms = math.sqrt(numpy.mean([((a[name][1] - b[name][1]) ** 2).mean() for name in a]) / 2)
    hold(float(least) <= rms <= float(most), f'RMS of the noise of one seed {rms:.5f}, expected {least} to {most}')


globals()[sys.argv[1]](*sys.argv[2:])
sys.exit(1 if failed else 0)
