#!/usr/bin/env python3
"""Holds section 13 of decoder/FORMAT.md, a file to the byte, to the file that example_file makes.

    example.py PROGRAM FORMAT.md             prints how they differ; exit code 1 where they do
    example.py PROGRAM FORMAT.md --write     writes the section
    example.py PROGRAM FORMAT.md --self-test also changes each byte of the file in turn, and fails where the section
                                             would stay as it is

SPDX-License-Identifier: MIT
"""
import difflib
import os
import re
import struct
import subprocess
import sys
import tempfile

BEGIN, END = '<!-- example: written by tests/unit/decoder/example.py -->', '<!-- /example -->'
NUMBERS = {'int': '<i', 'float': '<f'}


class Walk:
    """Goes through the bytes of an OpenEXR file and keeps a row for each piece: (offset, bytes, field, meaning)."""

    def __init__(self, data):
        self.data, self.at, self.rows = data, 0, []

    def take(self, size, field, meaning):
        piece = self.data[self.at:self.at + size]
        self.rows.append((self.at, piece, field, meaning(piece) if callable(meaning) else meaning))
        self.at += size
        return piece

    def text(self):
        end = self.data.index(b'\0', self.at)
        piece = self.data[self.at:end].decode('latin-1')
        self.at = end + 1
        return piece


def floats(piece):
    return [float(f'{x:.7g}') for (x,) in struct.iter_unpack('<f', piece)]


def shown(kind, piece):
    if kind == 'string':
        return f'"{piece.decode("latin-1")}"'
    if kind in ('floatvector', 'v2f'):
        return ', '.join(f'{x:g}' for x in floats(piece))
    if kind in NUMBERS:
        return f'{struct.unpack(NUMBERS[kind], piece)[0]:.7g}'
    if kind == 'box2i':
        return '({}, {}) to ({}, {})'.format(*struct.unpack('<4i', piece))
    if kind == 'chlist':
        names = [name.decode() for name in re.findall(rb'([A-Za-z]+)\0\1?\x01\0{3}.{4}\x01\0{3}\x01\0{3}', piece, re.S)]
        return f'HALF channels {", ".join(names)}, every pixel' if len(names) > 1 else f'a HALF channel {names[0]}, every pixel'
    return {'compression': {3: 'ZIP'}, 'lineOrder': {0: 'rows from the top'}}[kind].get(piece[0], str(piece[0]))


def half(bits):
    return f'{struct.unpack("<e", struct.pack("<H", bits))[0]:g}'


def header(walk):
    """One header; returns the names of its channels and its window."""
    channels, window, name = [], None, None
    while walk.data[walk.at]:
        start = walk.at
        attribute, kind = walk.text(), walk.text()
        size = struct.unpack_from('<i', walk.data, walk.at)[0]
        walk.at += 4
        value = walk.data[walk.at:walk.at + size]
        walk.at += size
        walk.rows.append((start, value, f'`{attribute}` {kind} {size}', shown(kind, value)))
        if attribute == 'channels':
            channels = [c.decode() for c in re.findall(rb'([A-Z]+)\0\x01\0{3}.{4}\x01\0{3}\x01\0{3}', value, re.S)]
        elif attribute == 'dataWindow':
            window = struct.unpack('<4i', value)
        elif attribute == 'name':
            name = value.decode()
    walk.take(1, 'end of the header', '')
    return name, channels, window


def chunk(walk, parts):
    number = struct.unpack('<i', walk.take(4, 'part of the chunk', lambda p: str(struct.unpack('<i', p)[0])))[0]
    name, channels, (left, top, right, bottom) = parts[number]
    width, height = right - left + 1, bottom - top + 1
    walk.take(4, 'first row', lambda p: str(struct.unpack('<i', p)[0]))
    size = struct.unpack('<i', walk.take(4, 'bytes that follow', lambda p: str(struct.unpack('<i', p)[0])))[0]
    if size != 2 * len(channels) * width * height:
        sys.exit('example.py: the chunk is compressed, and the section would not show its values')
    for row in range(height):
        for channel in channels:
            walk.take(2 * width, f'`{name}`, row {row}, {channel}',
                      lambda p: ', '.join(half(x) for (x,) in struct.iter_unpack('<H', p)))


def table(data):
    walk = Walk(data)
    walk.take(4, 'magic number of OpenEXR', '')
    walk.take(4, 'version 2; bit 12: several parts', '')
    parts = []
    while walk.data[walk.at]:
        parts.append(header(walk))
    walk.take(1, 'end of the headers', '')
    for name, _, _ in parts:
        walk.take(8, f'offset of the chunk of `{name}`', lambda p: str(struct.unpack('<Q', p)[0]))
    for _ in parts:
        chunk(walk, parts)
    if walk.at != len(data):
        sys.exit(f'example.py: {len(data) - walk.at} bytes follow the last chunk')
    rows = ['| at | field | bytes | value |', '| --- | --- | --- | --- |']
    for at, piece, field, meaning in walk.rows:
        hexed = '' if '` string ' in field else piece.hex(' ', -4)
        rows.append(f'| {at} | {field} | {hexed} | {meaning} |')
    return '\n'.join(rows)


def section(data, printed):
    lines = [re.fullmatch(r'q (\d+) (\d+) lights 0 1 2 weights (\d+) (\d+) (\d+) rgb (\S+) (\S+) (\S+)', line).groups()
             for line in printed.strip().split('\n')]
    at, between = lines
    cells = re.search(r'`openbtf.lightCells` .*\| ([^|]*) \|', shown_bytes := table(data))[1].split(', ')
    counts, rest = [], cells
    while rest:
        counts.append(rest[0])
        rest = rest[1 + int(rest[0]):]
    residual = ', '.join(f'{100 * 2**-26 * 4096 * v:.7g}' for v in (40, 20, 10))
    sums = [sum(int(w) * v for w, v in zip(between[2:5], codes)) for codes in ((80, 40, -80), (60, 20, -60), (40, 10, -40))]
    return f"""{BEGIN}
The smallest material that shows something: 2 x 2 texels, a view from the top, three lights, no SBRDF, one component.
Its file has {len(data)} bytes. All numbers are little-endian. An attribute is its name and type, each ended by a byte
of 0, the size of its value in four bytes, and the value; the table gives the place of the name and the bytes of the
value alone. Pixels are stored as they are where ZIP makes them no smaller, as here.

{shown_bytes}

The view is alone and has no triangle and no hull. The lights make one triangle, and the grid of 2 x 2 cells lists for
its four cells {', '.join(counts)} records: number 0 is the triangle, 1 to 3 are the edges of the hull.

**At a sample.** u = 0.25, v = 0.75 is column 0, row 0: U = 100. l = (0.6, 0, 0.8) is projected to q = ({at[0]}, {at[1]}),
the vertex of light 1: its weight is 4096, so that t = 4096 * V with V = 40, 20, 10 for R, G, B. With s = 2^-14 the
residual is `r = (100 * (2^-14 * 2^-12)) * t` = {residual}. The domain is linear, m = l.z = 0.8, the
view weighs 4096, radianceScale is 1: the radiance is r * 0.8 = {at[5]}, {at[6]}, {at[7]}.

**Between samples.** l = (0.28, 0, 0.96) is projected to q = ({between[0]}, {between[1]}), on the edge from light 0 to light 1.
The triangle accepts it with the weights {between[2]}, {between[3]}, {between[4]}; the last is what rounding down leaves. t is
{sums[0]}, {sums[1]}, {sums[2]}, and the radiance (100 * 2^-26 * t) * 0.96, each step rounded to a float, is
{between[5]}, {between[6]}, {between[7]}.
{END}"""


def main():
    program, page = sys.argv[1:3]
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, 'example.btf.exr')
        printed = subprocess.run([program, path], check=True, capture_output=True, text=True).stdout
        with open(path, 'rb') as file:
            data = file.read()
    made = section(data, printed)
    with open(page, encoding='utf-8') as file:
        text = file.read()
    begin, end = text.index(BEGIN), text.index(END) + len(END)
    if '--write' in sys.argv[3:]:
        with open(page, 'w', encoding='utf-8') as file:
            file.write(text[:begin] + made + text[end:])
        return
    bad = 0
    if text[begin:end] != made:
        print('\n'.join(difflib.unified_diff(text[begin:end].split('\n'), made.split('\n'), page, 'the file', lineterm='')))
        bad = 1
    if '--self-test' in sys.argv[3:]:
        for at in range(len(data)):
            changed = data[:at] + bytes([data[at] ^ 0x41]) + data[at + 1:]
            try:
                bad |= table(changed) == table(data) and print(f'byte {at}: a change is not shown') is None
            except (SystemExit, KeyError, IndexError, ValueError, struct.error, TypeError):
                pass # the change left no valid file: noticed
    sys.exit(int(bad))


if __name__ == '__main__':
    main()
