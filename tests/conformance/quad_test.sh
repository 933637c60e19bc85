#!/bin/bash
# Runs the example on a material: BTF_CONFORM QUAD. The picture must have its size and more than one colour.
#
# SPDX-License-Identifier: MIT
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$1" --vectors "$folder"
material=$(ls "$folder"/*.btf.exr | head -1)
code=0
"$2" "$material" 30 40 >"$folder/quad.ppm" || code=$?
if [ $code -eq 5 ]; then
    echo "skipped: no surfaceless EGL context"
    exit 77
fi
[ $code -eq 0 ]
[ "$(head -c 15 "$folder/quad.ppm" | tr '\n' ' ')" = "P6 256 256 255 " ]
[ "$(wc -c <"$folder/quad.ppm")" -eq $((256 * 256 * 3 + 15)) ]
[ "$(tail -c +16 "$folder/quad.ppm" | od -An -v -tu1 -w3 | sort -u | wc -l)" -gt 10 ]
! "$2" "$folder/absent.btf.exr" 2>/dev/null
