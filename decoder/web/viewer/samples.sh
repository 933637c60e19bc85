#!/bin/bash
# samples.sh BUILD OUT: materials for the viewer and its gallery, from built-in samples: OUT/NAME.btf.exr, a picture of each,
# OUT/NAME.png, and OUT/materials.json, which build.py reads. BUILD has btf-sample, btf-encode and btf-render.
#
# To show your own data, write such a folder yourself.
#
# SPDX-License-Identifier: MIT
set -eu
[ $# -eq 2 ] || { sed -n '2,6s/^# \{0,1\}//p' "$0" >&2; exit 1; }
build=$(cd "$1" && pwd)
mkdir -p "$2"
out=$(cd "$2" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
sample=$build/tests/sample/btf-sample encode=$build/encoder/btf-encode render=$build/decoder/tools/render/btf-render

# name of btf-sample, title, what it shows; model, repeats, view, light and zoom of its picture; options of btf-encode
materials='bricks|Bricks|Deep joints that shadow themselves and hide as the view sinks|cloth|2|25,55|50,125|0.95|--effects shift,gain,residual
bumps|Pebbles|Rounded pebbles that hide one another as the view sinks|sphere|3|20,70|38,110|0.85|--effects shift,gain,residual --relief auto
weave|Weave|A plain weave of threads in two colours|torus|3|16,-25|42,112|0.95|
flat|Flat|No relief: a painted plane with a gloss, for comparison|plane|2|48,75|40,110|0.9|--gloss auto'

{
    printf '[\n'
    separator=
    while IFS='|' read -r name title about mesh repeat view light zoom options; do
        "$sample" -o "$work/$name" --relief "$name" --size 32 --quiet
        "$encode" "$work/$name" -o "$out/$name.btf.exr" --preset fast --levels all --budget 400kB $options -q >&2
        "$render" "$out/$name.btf.exr" -o "$out/$name.png" --mesh "${mesh/cloth/drape}" --size 400x300 --samples 2 --repeat "$repeat" \
            --view "$view" --zoom "$zoom" --light "$light" --background 0.015 --filter bilinear --device reference --quiet
        # the link shows what the picture shows
        printf '%s  {"name": "%s", "title": "%s", "about": "%s", "file": "%s", "still": "%s",\n   "view": "%s"}' "$separator" "$name" \
            "$title" "$about" "$name.btf.exr" "$name.png" "mesh=$mesh&repeat=$repeat&theta=${view%,*}&phi=${view#*,}&lightTheta=${light%,*}&lightPhi=${light#*,}&zoom=$zoom"
        separator=$',\n'
    done <<<"$materials"
    printf '\n]\n'
} >"$work/materials.json"
mv "$work/materials.json" "$out/materials.json"
