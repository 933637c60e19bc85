#!/bin/bash
# Makes the picture of plans of tests/bench/README.md, planned.png: full decode, planned decode, their difference (sRGB)
# times 8. A row for each material on a cloth, whose folds are seen and lit from many directions as on an orbit, then one
# for each on a plane, where the light is the same in every pixel and is folded. Prints the plans.
#
#   planned.sh BUILD MATERIAL.btf.exr...
#
# SPDX-License-Identifier: MIT
set -eu
build=$(cd "$1" && pwd)
shift
materials=()
for file in "$@"; do
    materials+=("$(realpath "$file")")
done
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
render() { # NAME FILE OPTIONS...
    name=$1
    shift
    "$build/decoder/tools/render/btf-render" "$@" -o "$name-full.png" --size 200 --light 50,150 --quiet
    "$build/decoder/tools/render/btf-render" "$@" -o "$name-planned.png" --size 200 --light 50,150 --quiet \
        --plan auto --stats | sed -n '/^plan/,/^  between/p'
}
rows=0
for mesh in drape plane; do
    for file in "${materials[@]}"; do
        echo "$mesh, $(basename "$file"):"
        render $rows "$file" --mesh $mesh --repeat 1.5 --view 35,-90
        rows=$((rows + 1))
    done
done
python3 - "$here/planned.png" "$here" $rows <<'P'
import sys
sys.path.insert(0, sys.argv[2])
sys.dont_write_bytecode = True
import png
out, gap = [], 4
for name in map(str, range(int(sys.argv[3]))):
    (width, full), (_, planned) = png.read(name + "-full.png"), png.read(name + "-planned.png")
    for f, p in zip(full, planned):
        error = bytes(min(8 * abs(i - j), 255) for i, j in zip(f, p))
        out.append((b"\xff" * 3 * gap).join((f, p, error)))
    out += [b"\xff" * len(out[0])] * gap
out = out[:-gap]
png.write(sys.argv[1], out)
P
