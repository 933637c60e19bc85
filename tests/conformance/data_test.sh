#!/bin/bash
# Materials made from a part of the shared data, on llvmpipe and softpipe: BTF_ENCODE BTF_CONFORM.
#
# SPDX-License-Identifier: MIT
set -eu
data=${BTF_SHARED:-$BTF_SOURCE_ROOT/../shared}/data
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
files=()
for name in BRICKS64 UBO_IMPALLA64; do
    if [ ! -f "$data/$name.zip" ]; then
        echo "skipped: no $data/$name.zip"
        exit 77
    fi
    "$1" "$data/$name.zip" -o "$folder/$name-paper.btf.exr" --crop 20x24 --method paper --starts 1 --quiet
    "$1" "$data/$name.zip" -o "$folder/$name-joint.btf.exr" --crop 20x24 --method joint --preset fast --quiet
    files+=("$folder/$name-paper.btf.exr" "$folder/$name-joint.btf.exr")
done
code=0
"$2" "${files[@]}" --device osmesa,softpipe,egl-es300 --count 100000 --steps 400000 --quiet || code=$?
if [ $code -eq 5 ]; then
    exit 77
fi
exit $code
