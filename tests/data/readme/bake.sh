#!/bin/bash
# Makes the pictures of encoder/bake/SCENES.md, and prints its table: bakes the three scenes, encodes them, renders them on
# models, and compares a sphere of each material with a sphere of the scene's own geometry.
#
#   bake.sh BUILD WORK      WORK keeps scenes, images and materials: after a stop the same command goes on
#
# BTF_BAKE_OPTIONS are options of btf-bake, in place of --texels 64 --directions ubo --samples 16; BTF_CYCLES_SAMPLES those of
# the pictures by Cycles alone (128).
#
# SPDX-License-Identifier: MIT
set -euo pipefail
build=$(cd "$1" && pwd)
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../../.." && pwd)
mkdir -p "$2"
cd "$2"
PATH=$build/encoder:$build/decoder/tools:$build/decoder/tools/render:$root/encoder/bake:$PATH
export OMP_WAIT_POLICY=passive
options=${BTF_BAKE_OPTIONS:---texels 64 --directions ubo --samples 16}
python=/usr/bin/python3 # whose numpy apt installs
size=256 repeat=4

blender() {
    command blender --factory-startup -b --python-exit-code 1 "$@" >blender.log 2>&1 || {
        tail -20 blender.log >&2
        return 1
    }
}
cycles() { # SCENE WHAT OUT OPTION...: a picture by Cycles alone
    local scene=$1
    shift
    blender "$scene" -P "$here/bake_cycles.py" -- "$@" --size $size --samples "${BTF_CYCLES_SAMPLES:-128}" --light "$light"
}
seconds() { # NAME COMMAND...: runs it and adds its core seconds to NAME.seconds, also where it is stopped
    "$python" "$here/bake.py" seconds "$@"
}

# Scene, light, and how its model is shown: mesh, repeats, view, zoom.
for each in knit:40,120:drape:2.5:20,-60:0.92 gravel:40,120:torus:4:0,0:0.97 scales:50,-65:drape:2:35,-100:1; do
    IFS=: read -r name light mesh times view zoom <<<"$each"
    echo "$name" >&2
    [ -f "$name.blend" ] || {
        blender -P "$root/encoder/bake/scenes/$name.py" -- -o "$name.blend"
        cp blender.log "$name.log"
    }
    [ -f "$name.baked" ] || {
        # shellcheck disable=SC2086 # options are several words
        seconds "$name-bake.seconds" "$python" "$root/encoder/bake/btf-bake.py" \
            "$name.blend" -o "$name" $options
        touch "$name.baked"
    }
    [ -f "$name.btf.exr" ] || btf-encode "$name" -o "$name.btf.exr" --report "$name.json" -q
    [ -f "$name-surface.exr" ] || cycles "$name.blend" surface "$name-surface.exr"
    btf-render "$name.btf.exr" -o "$name-model.exr" --mesh "$mesh" --repeat "$times" --view "$view" --zoom "$zoom" \
        --size 194 --samples 3 --light "$light" --cast-shadows --filter steep --exposure 0.4 --background 0.8 --quiet
    "$python" "$here/bake.py" row "$here/bake-$name.png" "$name-surface.exr" "$name" "$name-model.exr"

    [ -f "$name-truth.exr" ] || cycles "$name.blend" sphere "$name-truth.exr" --repeat $repeat
    btf-render "$name.btf.exr" -o "$name-sphere.exr" --mesh sphere --repeat $repeat --fov 0 --zoom 0.9 --size $size \
        --samples 4 --light "$light" --filter steep --quiet
    "$python" "$here/bake.py" compare "$here/bake-$name-sphere.png" "$name-truth.exr" "$name-sphere.exr" >"$name-sphere.json"
done
cat <<M
<!-- scenes: written by tests/bench/regenerate.sh -->
Made by btf-bake and by btf-encode with its defaults. Core seconds; PSNR in dB, linear / sRGB, over the samples; of the
spheres, sRGB: all, where the normal is within 45 degrees of the view, and the outermost tenth of the radius.

M
"$python" "$here/bake.py" table knit gravel scales
echo '<!-- /scenes -->'
