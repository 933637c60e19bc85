#!/bin/bash
# Installs the add-on's zip in Blender and uses the add-on without a window.
#
# SPDX-License-Identifier: MIT
. "$BTF_SOURCE_ROOT/tests/tools/common.sh"
zip=$BTF_SOURCE_ROOT/encoder/bake/addon/zip.py
command -v blender >/dev/null || {
    report 'Blender' failed 'there is no blender: install the packages of .ci/packages-bake.txt, or leave the suite bake out'
    finish
}

expect zip-is-made 0 python3 "$zip" addon.zip 1.2.3
expect again 0 python3 "$zip" again.zip 1.2.3
expect_that zip-is-the-same cmp addon.zip again.zip
expect zip-lists 0 python3 -m zipfile -l addon.zip
expect_text zip-has-the-package '^openbtf_bake/__init__.py' out
expect_text zip-has-the-modules '^openbtf_bake/btf_bake.py' out
expect zip-wants-a-zip 1 python3 "$zip" addon.tar
python3 -m zipfile -e addon.zip unpacked
expect_text zip-has-the-version "'version': \(1, 2, 3\)" unpacked/openbtf_bake/__init__.py

# A block with a material and a post on it.
cat >scene.py <<'S'
import os
import bpy
bpy.ops.wm.read_factory_settings(use_empty=True)
collection = bpy.data.collections.new('BTF')
bpy.context.scene.collection.children.link(collection)
material = bpy.data.materials.new('grey')
for name, place, size in ('block', (0.5, 0.5, -0.5), (1, 1, 0.8)), ('post', (0.4, 0.6, -0.05), (0.3, 0.2, 0.1)):
    bpy.ops.mesh.primitive_cube_add(size=1, location=place, scale=size)
    thing = bpy.context.object
    thing.name = name
    thing.data.materials.append(material)
    for each in thing.users_collection:
        each.objects.unlink(thing)
    collection.objects.link(thing)
bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath('scene.blend'))
S
expect scene 0 blender -b --factory-startup --python-exit-code 1 -P scene.py
mkdir scripts scratch
TMPDIR=$work/scratch BLENDER_USER_SCRIPTS=$work/scripts BLENDER_USER_CONFIG=$work/config blender -b scene.blend --python-exit-code 1 \
    -P "$BTF_SOURCE_ROOT/tests/bake/check_addon.py" -- "$work/addon.zip" "$build/encoder/btf-encode" >used 2>err
code=$?
grep -vE '^(Fra:|Saved:| Time:|Blender|Read|Info:|$)' used
[ $code = 0 ] && grep -q 'OK \] addon-unregisters-second' used || {
    failures=$((failures + 1))
    tail -n 20 used err
}
left_over() { find scratch -name 'btf-*' | grep .; }
expect nothing-is-left-in-the-scratch-folder 1 left_over

finish
