#!/bin/bash
# Makes the README's picture of plans, planned.png: full decode, planned decode, their difference (sRGB) times 8, of a
# joint material (first row) and of one of the paper's method (second row), both from the top.
#
#   planned.sh BUILD JOINT.btf.exr PAPER.btf.exr
#
# SPDX-License-Identifier: MIT
set -eu
build=$(cd "$1" && pwd)
joint=$(realpath "$2")
paper=$(realpath "$3")
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
render() { # NAME FILE OPTIONS...
    name=$1
    shift
    "$build/decoder/tools/render/btf-render" "$@" -o "$name-full.png" --size 200 --mesh plane --repeat 1.5 --quiet
    "$build/decoder/tools/render/btf-render" "$@" -o "$name-planned.png" --size 200 --mesh plane --repeat 1.5 --quiet \
        --plan auto --stats | sed -n '/^plan/,/^  predicted/p'
}
render a "$joint" --light 50,150
render b "$paper" --light 50,150 --exposure 1
python3 - "$here/planned.png" <<'P'
import struct, sys, zlib
def read(path):
    data, at, body = open(path, "rb").read(), 8, b""
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        if kind == b"IHDR":
            width, height, depth, colour = struct.unpack(">IIBB", data[at + 8:at + 18])
            assert (depth, colour) == (8, 2), path
        elif kind == b"IDAT":
            body += data[at + 8:at + 8 + size]
        at += size + 12
    raw, rows, last = zlib.decompress(body), [], bytearray(3 * width)
    for y in range(height):
        line = bytearray(raw[y * (3 * width + 1):(y + 1) * (3 * width + 1)])
        how, line = line[0], line[1:]
        for x in range(3 * width):
            a, b, c = line[x - 3] if x > 2 else 0, last[x], last[x - 3] if x > 2 else 0
            p = a + b - c
            paeth = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            line[x] = (line[x] + (0, a, b, (a + b) // 2, paeth)[how]) & 255
        rows.append(bytes(line))
        last = line
    return width, rows
out, gap = [], 4
for name in "ab":
    (width, full), (_, planned) = read(name + "-full.png"), read(name + "-planned.png")
    for f, p in zip(full, planned):
        error = bytes(min(8 * abs(i - j), 255) for i, j in zip(f, p))
        out.append((b"\xff" * 3 * gap).join((f, p, error)))
    out += [b"\xff" * len(out[0])] * gap
out = out[:-gap]
def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
with open(sys.argv[1], "wb") as file:
    file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", len(out[0]) // 3, len(out), 8, 2, 0, 0, 0)) +
               chunk(b"IDAT", zlib.compress(b"".join(b"\0" + row for row in out), 9)) + chunk(b"IEND", b""))
P
