#!/usr/bin/env python3
"""Composes the headline picture of the sheets that between.sh leaves in the current folder, and prints its caption:
between.py PICTURE DATA EARLIER BYTES_EARLIER BYTES_NOW, DATA and EARLIER as the caption is to call them.

SPDX-License-Identifier: MIT
"""
import json
import os
import sys
import textwrap

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import png

SIDE, LEFT, TOP, STEP = 128, 190, 22, 134  # of the images of a sheet of btf-compare for 64x64 texels: truth, model, error
GAP, COLUMNS = 4, 5


def sheet(name):
    """Truth, decoded image and four times their error."""
    width, rows = png.read(f'{name}.png')
    if width != LEFT + 3 * STEP or len(rows) != TOP + SIDE + STEP - SIDE:
        sys.exit(f'between.py: {name}.png: expected the sheet of one pair of 64x64 texels, found {width}x{len(rows)}')
    return [[row[3 * x:3 * (x + SIDE)] for row in rows[TOP:TOP + SIDE]] for x in range(LEFT, width, STEP)]


def decibels(name):
    with open(f'{name}.json', encoding='utf-8') as file:
        return json.load(file)['between']


def main():
    path, label, said, earlier_bytes, now_bytes = sys.argv[1:]
    columns, views = [], []
    for n in range(1, COLUMNS + 1):
        truth, earlier, earlier_error = sheet(f'earlier-{n}')
        _, now, now_error = sheet(f'now-{n}')
        columns.append([truth, earlier, now, earlier_error, now_error])
        views.append(decibels(f'now-{n}')['images'][0]['view'][0])
    out = []
    for images in zip(*columns):
        out += [(b'\xff' * 3 * GAP).join(lines) for lines in zip(*images)]
        out += [b'\xff' * len(out[0])] * GAP
    png.write(path, out[:-GAP])

    def each(which):
        return ', '.join(f'{decibels(f"{which}-{n}")["srgb"]:.1f}' for n in range(1, COLUMNS + 1))

    def of_all(which):
        total = decibels(f'{which}-all')
        return f'{total["linear"]:.2f} / {total["srgb"]:.2f}'
    angles = ', '.join(f'{view:.0f}' for view in views)
    caption = f"""Five pairs of view and light between the samples of {label}, 64 x 64 texels, the view at theta {angles}; rows:
truth, {said} in {int(earlier_bytes) / 1e6:.2f} MB, today's default in {int(now_bytes) / 1e6:.2f} MB, and four times the
error of the one and of the other (sRGB). PSNR by column, sRGB: {each('earlier')} dB, now {each('now')} dB; of all
{decibels('now-all')['pairs']} pairs, linear / sRGB: {of_all('earlier')} dB, now {of_all('now')} dB."""
    print(textwrap.fill(' '.join(caption.split()), 119, break_on_hyphens=False))


main()
