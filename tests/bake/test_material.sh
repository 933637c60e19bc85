#!/bin/bash
# From a scene to a picture of the material: btf-bake, which goes on to btf-encode, and btf-render.
#
#   test_material.sh INTERPRETER
#
# SPDX-License-Identifier: MIT
. "$(dirname "$0")/../tools/common.sh"
interpreter=$1
here=$BTF_SOURCE_ROOT/tests/bake
command -v blender >/dev/null || {
    report 'Blender' failed 'there is no blender: install the packages of .ci/packages-bake.txt, or leave the suite bake out'
    finish
}
PATH=$build/decoder/tools/render:$PATH
btf-bake() { /usr/bin/python3 "$BTF_SOURCE_ROOT/encoder/bake/btf-bake.py" "$@"; }
expect 'scenes' 0 blender --background --factory-startup -noaudio --python "$here/scenes.py" --python-exit-code 9 -- "$work"
expect 'baked and encoded' 0 btf-bake waves.blend -o waves --texels 16 --directions 0:1,50:6 --samples 16 \
    --encode waves.btf.exr -- --preset fast --budget 30kB
expect_text 'btf-encode found nothing to warn of' 'done' err
unwarned() { ! grep -i warning err; }
expect_that 'indeed' unwarned
expect 'the material is near the data' 0 btf-compare waves waves.btf.exr
psnr() { grep -Eo '[0-9]+\.[0-9]+ dB' out | head -1 | awk '{ exit !($1 > 25) }'; }
expect_that 'by more than 25 dB' psnr
expect 'a picture of it' 0 btf-render waves.btf.exr -o waves.png --device reference --size 64x64 --mesh sphere
expect 'parts are missing' 2 btf-bake waves.blend -o half --texels 8 --directions tiny --samples 1 --part 1/2 --encode half.btf.exr
expect_text 'so that nothing is encoded' 'of the other parts are missing: not encoded' err
finish
