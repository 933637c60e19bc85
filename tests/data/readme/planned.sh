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
python3 - "$here/planned.png" "$here" <<'P'
import sys
sys.path.insert(0, sys.argv[2])
sys.dont_write_bytecode = True
import png
out, gap = [], 4
for name in "ab":
    (width, full), (_, planned) = png.read(name + "-full.png"), png.read(name + "-planned.png")
    for f, p in zip(full, planned):
        error = bytes(min(8 * abs(i - j), 255) for i, j in zip(f, p))
        out.append((b"\xff" * 3 * gap).join((f, p, error)))
    out += [b"\xff" * len(out[0])] * gap
out = out[:-gap]
png.write(sys.argv[1], out)
P
