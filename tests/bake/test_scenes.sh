#!/bin/bash
# The scenes of encoder/bake/scenes: made anew, looked at, and baked, encoded and rendered small.
#
# SPDX-License-Identifier: MIT
. "$BTF_SOURCE_ROOT/tests/tools/common.sh"
scenes=$BTF_SOURCE_ROOT/encoder/bake/scenes
blender() { command blender -b --factory-startup --python-exit-code 1 "$@"; }

for name in knit gravel scales; do
    expect "$name-is-made" 0 blender -P "$scenes/$name.py" -- -o $name.blend
    expect_text "$name-says" "^$name.blend: [0-9]+ triangles, 0\.[0-9]+ of the tile deep" out
done

# Wrong command lines.
expect no-output 2 blender -P "$scenes/knit.py" --
expect other-ending 2 blender -P "$scenes/knit.py" -- -o knit.obj
expect_text names-the-file "'knit.obj' does not end in .blend" err
expect no-folder 2 blender -P "$scenes/knit.py" -- -o nowhere/knit.blend
expect_that nothing-else-is-left test "$(ls -A | grep -c blend)" = 3

# A seed is an arrangement.
expect seed 0 blender -P "$scenes/gravel.py" -- -o other.blend --seed 8
expect_that seeds-differ test "$(stat -c %s gravel.blend)" != "$(stat -c %s other.blend)"

blender -P "$BTF_SOURCE_ROOT/tests/bake/check_scene.py" -- knit.blend gravel.blend scales.blend >looked 2>err
code=$?
grep -vE '^(Blender|Read|$)' looked
[ $code = 0 ] && ! grep -q 'FAILED' looked || {
    failures=$((failures + 1))
    tail -5 err
}

finish
