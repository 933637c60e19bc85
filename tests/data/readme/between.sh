#!/bin/bash
# Makes the headline picture, between.png: five pairs of view and light between the samples, a column each, in rows truth,
# an earlier material, the default of this build, and four times the error of each (sRGB). Prints the caption with each
# column's PSNR and that of all pairs, as Markdown.
#
#   between.sh BUILD [WORK]      WORK keeps samples and materials for the next time
#
# BTF_DATA=DATA BTF_PAIRS=PAIRS name data and images between its samples (BRICKS64.zip and BRICKS64_between.zip, say);
# without them both are made: btf-sample bumps, 64x64 texels.
# BTF_V1=FILE is what the encoder of version 1 wrote from the same data, BTF_V1_FROM the commit that it was built from.
# Without it the second row is --method paper of this build, the only method that still writes format version 1.
#
# SPDX-License-Identifier: MIT
set -euo pipefail
build=$(cd "$1" && pwd)
here=$(cd "$(dirname "$0")" && pwd)
[ -z "${BTF_DATA:-}" ] || BTF_DATA=$(realpath "$BTF_DATA")
[ -z "${BTF_PAIRS:-}" ] || BTF_PAIRS=$(realpath "$BTF_PAIRS")
[ -z "${BTF_V1:-}" ] || BTF_V1=$(realpath "$BTF_V1")
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

if [ -n "${BTF_DATA:-}" ]; then
    data=$BTF_DATA pairs=${BTF_PAIRS:?expected images between the samples of BTF_DATA}
    label=$(basename "$data" .zip)
    mkdir -p truth
    python3 -m zipfile -e "$pairs" truth
    pairs=truth
else
    # Far from the rings of samples, 0 to 75 degrees in steps of 15: the view's theta and phi, the light's.
    printf '%s\n' '20 15 40 75' '35 100 25 160' '50 200 50 290' '60 280 35 10' '67 330 20 110' >pairs.txt
    data=bumps pairs=truth label='`btf-sample` bumps'
    [ -d bumps ] || btf-sample -o bumps --relief bumps --size 64 --quiet
    [ -d truth ] || btf-sample -o truth --relief bumps --size 64 --pairs pairs.txt --quiet
fi
if [ -n "${BTF_V1:-}" ]; then
    earlier=$BTF_V1 said="version 1 of the encoder${BTF_V1_FROM:+ ($BTF_V1_FROM)}"
else
    earlier=paper.btf.exr said='`--method paper`'
    [ -f $earlier ] || btf-encode "$data" -o $earlier --method paper -q
fi
[ -f now.btf.exr ] || btf-encode "$data" -o now.btf.exr --budget 2.36MB -q

# The pairs whose views lie nearest to these angles, whatever else they are.
n=0
for theta in 20 35 50 60 67; do
    n=$((n + 1))
    name=$(find $pairs -name '*.exr' | sed -E "s/.*_tv0*([0-9.]+)_.*/\1 &/" |
        awk -v t=$theta '{ d = $1 - t; print (d < 0 ? -d : d), $2 }' | LC_ALL=C sort -g -k1,1 -k2 | sed -n '1s/[^ ]* //p')
    rm -rf pair
    mkdir pair
    cp "$name" pair/
    for which in earlier now; do
        file=now.btf.exr
        [ $which = now ] || file=$earlier
        btf-compare "$file" pair --pairs --no-ssim --json --pictures $which-$n.png --worst 1 -q >$which-$n.json
    done
done
btf-compare "$earlier" $pairs --pairs --no-ssim --json -q >earlier-all.json
btf-compare now.btf.exr $pairs --pairs --no-ssim --json -q >now-all.json
bytes() { btf-info --json "$1" | python3 -c 'import json, sys; print(json.load(sys.stdin)["levels"][0]["gpu"])'; }
python3 "$here/between.py" "$here/between.png" "$label" "$said" "$(bytes "$earlier")" "$(bytes now.btf.exr)"
