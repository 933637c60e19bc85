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
# The radiance of one vector in place of another's, and the directions drawn; the two are then replayed alone.
cp "$folder/01-radiance.exr" "$folder/00-radiance.exr" 2>/dev/null || cp "$folder/02-radiance.exr" "$folder/00-radiance.exr"
"$2" - "$folder" <<'P'
import json, shutil, sys
path = sys.argv[1] + "/"
manifest = json.load(open(path + "manifest.json"))
drawn = [v for v in manifest["vectors"] if "drawn" in v]
shutil.copy(path + drawn[0]["drawn"], path + drawn[1]["drawn"])
manifest["vectors"] = [v for v in manifest["vectors"] if v["radiance"] == "00-radiance.exr"] + [drawn[1]]
assert len(manifest["vectors"]) == 2
json.dump(manifest, open(path + "manifest.json", "w"))
P
if "$2" "$3" "$folder" --pixels 32 2>"$folder/err" || ! grep -q 'radiance is' "$folder/err" || ! grep -q 'drawn is' "$folder/err"; then
    echo "a changed vector is not found"
    exit 1
fi
