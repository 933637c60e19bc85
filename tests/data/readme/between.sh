#!/bin/bash
# Makes the picture of accuracy between the samples, between.png: at five pairs of view and light between the samples of
# btf-sample bumps, 64x64 texels, a column each: truth, material, the same encoded without relief and gloss, and four
# times the error of the one and of the other (sRGB). Prints each column's PSNR (sRGB).
#
#   between.sh BUILD [WORK]      WORK keeps samples and materials for the next time
#
# SPDX-License-Identifier: MIT
set -eu
build=$(cd "$1" && pwd)
here=$(cd "$(dirname "$0")" && pwd)
if [ $# -gt 1 ]; then
    mkdir -p "$2"
    work=$(cd "$2" && pwd)
else
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
fi
cd "$work"
PATH=$build/encoder:$build/decoder/tools:$build/tests/sample:$PATH
export OMP_WAIT_POLICY=passive

# Far from the rings of samples, 0 to 75 degrees in steps of 15: the view's theta and phi, the light's.
cat >pairs.txt <<'P'
20 15 40 75
35 100 25 160
50 200 50 290
60 280 35 10
67 330 20 110
P
[ -d bumps ] || btf-sample -o bumps --relief bumps --size 64 --quiet
[ -d truth ] || btf-sample -o truth --relief bumps --size 64 --pairs pairs.txt --format png --quiet
encode() { btf-encode bumps -o $1.btf.exr --preset fast --relief $2 --gloss $2 --budget 2.36MB --effect-tolerance 0 -q; }
[ -f on.btf.exr ] || encode on auto
[ -f off.btf.exr ] || encode off off
column=0
while read -r view_theta view_phi light_theta light_phi; do
    column=$((column + 1))
    name=$(printf 'tl%07.4f_pl%08.4f_tv%07.4f_pv%08.4f' "$light_theta" "$light_phi" "$view_theta" "$view_phi")
    cp "truth/$name.png" "truth-$column.png"
    for material in on off; do
        btf-decode $material.btf.exr -o $material-$column.png --view "$view_theta,$view_phi" \
            --light "$light_theta,$light_phi" -q
    done
done <pairs.txt
python3 - "$here/between.png" "$here" <<'P'
import math
import sys
sys.path.insert(0, sys.argv[2])
sys.dont_write_bytecode = True
import png
SCALE, GAP, COLUMNS = 2, 4, 5
def error(a, b):
    return [bytes(min(4 * abs(i - j), 255) for i, j in zip(p, q)) for p, q in zip(a, b)]
def decibels(a, b):
    squares = [(i - j) ** 2 for p, q in zip(a, b) for i, j in zip(p, q)]
    return 10 * math.log10(255 ** 2 * len(squares) / max(sum(squares), 1e-9))
def enlarged(rows):
    for row in rows:
        line = b"".join(row[x:x + 3] * SCALE for x in range(0, len(row), 3))
        for _ in range(SCALE):
            yield line
columns = []
for column in range(1, COLUMNS + 1):
    truth, on, off = (png.read(f"{name}-{column}.png")[1] for name in ("truth", "on", "off"))
    print(f"column {column}: {decibels(on, truth):.2f} dB, without relief and gloss {decibels(off, truth):.2f} dB")
    columns.append([truth, on, off, error(on, truth), error(off, truth)])
out = []
for pictures in zip(*columns):
    out += [(b"\xff" * 3 * GAP).join(lines) for lines in zip(*map(enlarged, pictures))]
    out += [b"\xff" * len(out[0])] * GAP
out = out[:-GAP]
png.write(sys.argv[1], out)
P
