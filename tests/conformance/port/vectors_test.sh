#!/bin/bash
# Writes test vectors and replays them with the decoder in Python: BTF_CONFORM PYTHON REPLAY.
# The replay must also find a vector that is changed. Light runs write them alone: nothing of ours is in the replay.
#
# SPDX-License-Identifier: MIT
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$1" --vectors "$folder"
[ -z "${BTF_TEST_LIGHT:-}" ] || exit 0
"$2" "$3" "$folder" --pixels 64
# The radiance of one vector in place of another's, and the directions drawn.
cp "$folder/01-radiance.exr" "$folder/00-radiance.exr" 2>/dev/null || cp "$folder/02-radiance.exr" "$folder/00-radiance.exr"
drawn=("$folder"/*-drawn.exr)
cp "${drawn[0]}" "${drawn[1]}"
if "$2" "$3" "$folder" --pixels 16 2>"$folder/err" || ! grep -q 'radiance is' "$folder/err" || ! grep -q 'drawn is' "$folder/err"; then
    echo "a changed vector is not found"
    exit 1
fi
