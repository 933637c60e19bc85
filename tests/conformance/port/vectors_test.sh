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
"$2" "$3" "$folder" --pixels 32
# The radiance of one vector in place of another's, which is then replayed alone.
cp "$folder/01-radiance.exr" "$folder/00-radiance.exr" 2>/dev/null || cp "$folder/02-radiance.exr" "$folder/00-radiance.exr"
"$2" - "$folder/manifest.json" <<'P'
import json, sys
manifest = json.load(open(sys.argv[1]))
manifest["vectors"] = [v for v in manifest["vectors"] if v["radiance"] == "00-radiance.exr"]
assert len(manifest["vectors"]) == 1
json.dump(manifest, open(sys.argv[1], "w"))
P
if "$2" "$3" "$folder" --pixels 32 2>/dev/null; then
    echo "a changed vector is not found"
    exit 1
fi
# Directions drawn of one vector in place of another's.
"$1" --vectors "$folder"
drawn=("$folder"/*-drawn.exr)
cp "${drawn[0]}" "${drawn[1]}"
if "$2" "$3" "$folder" --pixels 4 2>"$folder/err" || ! grep -q 'drawn is' "$folder/err"; then
    echo "changed directions are not found"
    exit 1
fi
