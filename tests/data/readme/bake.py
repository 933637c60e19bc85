#!/usr/bin/env python3
"""Puts the pictures of encoder/bake/SCENES.md together, from linear OpenEXR images (Blender's and btf-render's).

    bake.py row OUT.png SURFACE.exr DATA MODEL.exr        scene, some images of the data set, material: the
                                                          middle of the first and the last
    bake.py compare OUT.png TRUTH.exr MATERIAL.exr        both, and four times their difference (sRGB, mean of
                                                          the channels); the errors as JSON
    bake.py seconds FILE COMMAND...                       runs it and adds the core seconds that it took to those in FILE
    bake.py table NAME...                                 the table of what bake.sh left in this folder, as Markdown

compare looks at the disc of the sphere, radius 0.9 of half the picture less one pixel, where
no pixel has background in it; values are clipped to 0..1.

SPDX-License-Identifier: MIT
"""
import json
import os
import re
import resource
import struct
import subprocess
import sys
import zlib

import numpy as np

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), '../../../encoder/bake'))
import bake_exr  # noqa: E402

GAP = 4
# Rows and columns of the images shown: views and lights, theta and phi; the nearest of the data set.
VIEWS = [(0, 0), (60, 270), (60, 90)]
LIGHTS = [(0, 0), (45, 120), (60, 260)]
ROW = 194  # height of a row of pictures: three images of 62 texels, and gaps


def write_png(path, codes):
    """Writes [row][column][3] of 8 bits, each line by the PNG filter whose bytes are the least in sum."""
    height, width, _ = codes.shape
    lines = codes.reshape(height, 3 * width).astype(int)
    left = np.pad(lines, ((0, 0), (3, 0)))[:, :-3]
    up = np.pad(lines, ((1, 0), (0, 0)))[:-1]
    corner = np.pad(left, ((1, 0), (0, 0)))[:-1]
    guess = left + up - corner
    a, b, c = abs(guess - left), abs(guess - up), abs(guess - corner)
    paeth = np.where((a <= b) & (a <= c), left, np.where(b <= c, up, corner))
    filtered = np.stack([(lines - p) & 255 for p in (0 * lines, left, up, (left + up) // 2, paeth)]).astype(np.uint8)
    best = np.abs(filtered.astype(np.int8).astype(int)).sum(axis=2).argmin(axis=0)
    body = b''.join(bytes([f]) + filtered[f, y].tobytes() for y, f in enumerate(best))

    def chunk(kind, data):
        return struct.pack('>I', len(data)) + kind + data + struct.pack('>I', zlib.crc32(kind + data))

    data = (b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', struct.pack('>IIBBBBB', width, height, 8, 2, 0, 0, 0)) +
            chunk(b'IDAT', zlib.compress(body, 9)) + chunk(b'IEND', b''))
    with open(path + '.part', 'wb') as file:
        file.write(data)
    os.replace(path + '.part', path)


def beside(pictures):
    gap = np.full((pictures[0].shape[0], GAP, 3), 255, np.uint8)
    return np.concatenate([part for each in pictures for part in (gap, each)][1:], axis=1)


def vector(theta, phi):
    theta, phi = np.radians(theta), np.radians(phi)
    return np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])


def montage(folder):
    """ROW x ROW pixels of images of a data set, each cut to what fits."""
    images = []
    for where, _, names in os.walk(folder):
        for name in names:
            found = re.search(r'tl([\d.]+) pl([\d.]+) tv([\d.]+) pv([\d.]+)\.exr$', name)
            if found:
                images.append((*map(float, found.groups()), os.path.join(where, name)))
    if not images:
        sys.exit(f'bake.py: {folder}: no images')
    lights = np.array([vector(each[0], each[1]) for each in images])
    views = np.array([vector(each[2], each[3]) for each in images])
    step = (ROW + GAP) // len(VIEWS)
    frame = np.full((ROW, ROW, 3), 255, np.uint8)
    for i, view in enumerate(VIEWS):
        for j, light in enumerate(LIGHTS):
            nearest = (views @ vector(*view) + lights @ vector(*light)).argmax()
            one = bake_exr.srgb(bake_exr.read_rgb(images[nearest][4]))[:step - GAP, :step - GAP]
            top, left = step * i + (step - GAP - one.shape[0]) // 2, step * j + (step - GAP - one.shape[1]) // 2
            frame[top:top + one.shape[0], left:left + one.shape[1]] = one
    return frame


def middle(codes):
    """The middle ROW x ROW pixels."""
    top, left = (codes.shape[0] - ROW) // 2, (codes.shape[1] - ROW) // 2
    return codes[top:top + ROW, left:left + ROW]


def decibels(error):
    return round(float(-10 * np.log10(max(np.mean(error ** 2), 1e-10))), 2)


def coded(linear):
    """sRGB in 0..1, not rounded."""
    value = np.clip(linear, 0, 1)
    return np.where(value <= 0.0031308, 12.92 * value, 1.055 * value ** (1 / 2.4) - 0.055)


def compare(out, truth, material):
    a, b = bake_exr.read_rgb(truth), bake_exr.read_rgb(material)
    if a.shape != b.shape:
        sys.exit(f'bake.py: {truth} has {a.shape[1]}x{a.shape[0]} pixels, {material} {b.shape[1]}x{b.shape[0]}')
    side = a.shape[0]
    y, x = np.mgrid[:side, :side] + 0.5 - side / 2
    radius = np.hypot(x, y) / (0.45 * side)
    inside = np.hypot(x, y) < 0.45 * side - 1
    linear, code = np.clip(a, 0, 1) - np.clip(b, 0, 1), coded(a) - coded(b)
    mean = [float(np.clip(each, 0, 1)[inside].mean()) for each in (a, b)]
    # The middle: normals within 45 degrees of the view. The rim: beyond 64 degrees.
    middle, rim = inside & (radius < np.sqrt(0.5)), inside & (radius > 0.9)
    print(json.dumps({'linear': decibels(linear[inside]), 'srgb': decibels(code[inside]), 'middle': decibels(code[middle]),
                      'rim': decibels(code[rim]), 'mean_truth': round(mean[0], 4), 'mean_material': round(mean[1], 4)}))
    error = np.clip(255 * 4 * np.abs(code).mean(axis=2, keepdims=True) + 0.5, 0, 255).astype(np.uint8)
    write_png(out, beside([bake_exr.srgb(a), bake_exr.srgb(b), error.repeat(3, axis=2)]))


def seconds(path, command):
    code = subprocess.run(command, stdin=subprocess.DEVNULL, check=False).returncode
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    before = 0.0
    if os.path.exists(path):
        with open(path, encoding='utf-8') as file:
            before = float(file.read())
    with open(path, 'w', encoding='utf-8') as file:
        print(before + used.ru_utime + used.ru_stime, file=file)
    return code


def text(path):
    with open(path, encoding='utf-8') as file:
        return file.read()


def table(names):
    print('| scene | triangles | depth | texels, samples | images | bake, core s | encode, core s | bytes on the GPU | '
          'PSNR over the samples | sphere: all, middle, rim |')
    print('| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |')
    for name in names:
        triangles, depth = re.search(r'(\d+) triangles, ([0-9.]+) of', text(f'{name}.log')).groups()
        report, sphere, made = (json.loads(text(path)) for path in (f'{name}.json', f'{name}-sphere.json', f'{name}/bake.json'))
        views = len({os.path.dirname(image) for image in made['images']})
        psnr = report['psnr']['full']
        print(f'| {name} | {int(triangles):,} | {float(depth):.2f} | {made["texels"][0]} x {made["texels"][1]}, {made["samples"]} | '
              f'{len(made["images"]):,} ({views} views) | {float(text(name + "-bake.seconds")):,.0f} | '
              f'{report["core_seconds"]["total"]:.0f} | {report["bytes"]["gpu"]:,} | '
              f'{psnr["linear"]:.2f} / {psnr["srgb"]:.2f} | '
              f'{sphere["srgb"]:.1f}, {sphere["middle"]:.1f}, {sphere["rim"]:.1f} |')


def main():
    what, out, *rest = sys.argv[1:]
    if what == 'seconds':
        sys.exit(seconds(out, rest))
    if what == 'table':
        table([out] + rest)
        return
    if what == 'compare':
        compare(out, *rest)
    else:
        surface, data, model = rest
        first, last = (middle(bake_exr.srgb(bake_exr.read_rgb(path))) for path in (surface, model))
        write_png(out, beside([first, montage(data), last]))


main()
