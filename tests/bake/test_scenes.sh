#!/bin/bash
# Makes the scenes of encoder/bake/scenes, checks them, and bakes, encodes and renders them at a small size. Also checks
# the comparison that the documents show: of a flat tile, the sphere with the material looks like the sphere with the
# tile.
#
#   test_scenes.sh INTERPRETER
#
# SPDX-License-Identifier: MIT
. "$BTF_SOURCE_ROOT/tests/tools/common.sh"
interpreter=$1
scenes=$BTF_SOURCE_ROOT/encoder/bake/scenes
pictures=$BTF_SOURCE_ROOT/tests/data/readme
command -v blender >/dev/null || {
    report 'Blender' failed 'there is no blender: install the packages of .ci/packages-bake.txt, or leave the suite bake out'
    finish
}
PATH=$build/decoder/tools/render:$PATH
blender() { command blender -b --factory-startup -noaudio --python-exit-code 1 "$@"; }
btf-bake() { /usr/bin/python3 "$BTF_SOURCE_ROOT/encoder/bake/btf-bake.py" "$@"; }

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

blender -P "$BTF_SOURCE_ROOT/tests/bake/check_scene.py" -- knit.blend gravel.blend scales.blend >looked 2>err
code=$?
grep -vE '^(Blender|Read|$)' looked
[ $code = 0 ] && grep -q 'OK \] scales-alone' looked || {
    failures=$((failures + 1))
    tail -n 5 err
}

for name in knit gravel scales; do
    expect "$name-is-baked" 0 btf-bake $name.blend -o $name --texels 8 --directions tiny --samples 2 --encode $name.btf.exr \
        -- --preset fast
    expect "$name-is-rendered" 0 btf-render $name.btf.exr -o $name.exr --size 32 --device reference --quiet
done

# Under a light from -y the scales look copper from that side, and green from the other.
cat >colours.py <<'P1'
import glob
import sys
sys.path.insert(0, sys.argv[1])
import bake_exr
side = {}
for azimuth in (90, 270):
    path, = glob.glob(f'scales/**/*tl045 pl270 tv045 pv{azimuth:03d}.exr', recursive=True)
    red, green, _ = bake_exr.read_rgb(path).mean(axis=(0, 1))
    side[azimuth] = red / green
sys.exit(not (side[270] > 2 * side[90] > 0) and f'red by green: {side}')
P1
expect_that scales-change-colour "$interpreter" colours.py "$BTF_SOURCE_ROOT/encoder/bake"

# A flat tile of four colours: it has no relief that a material could miss, and its colours tell which side of the
# picture is which.
cat >flat.py <<'P2'
import os
import bpy
bpy.ops.wm.read_factory_settings(use_empty=True)
collection = bpy.data.collections.new('BTF')
bpy.context.scene.collection.children.link(collection)
for k, colour in enumerate(((0.8, 0.1, 0.1), (0.1, 0.7, 0.1), (0.1, 0.1, 0.8), (0.8, 0.7, 0.1))):
    x, y = 0.5 * (k % 2), 0.5 * (k // 2)
    mesh = bpy.data.meshes.new('quarter')
    mesh.from_pydata([(x, y, 0), (x + 0.5, y, 0), (x + 0.5, y + 0.5, 0), (x, y + 0.5, 0)], [], [(0, 1, 2, 3)])
    material = bpy.data.materials.new('colour')
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    diffuse = nodes.new('ShaderNodeBsdfDiffuse')
    diffuse.inputs['Color'].default_value = (*colour, 1)
    links.new(diffuse.outputs[0], nodes['Material Output'].inputs[0])
    mesh.materials.append(material)
    collection.objects.link(bpy.data.objects.new('quarter', mesh))
bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath('flat.blend'))
P2
expect flat-is-made 0 blender -P flat.py
expect flat-is-baked 0 btf-bake flat.blend -o flat --texels 32 --directions 0:1,30:6,60:12 --samples 1 --encode flat.btf.exr -- \
    --preset fast
expect flat-sphere 0 blender flat.blend -P "$pictures/bake_cycles.py" -- sphere truth.exr --size 64 --samples 16 --repeat 2 \
    --light 40,120
expect flat-rendered 0 btf-render flat.btf.exr -o flat.exr --mesh sphere --repeat 2 --fov 0 --zoom 0.9 --size 64 --samples 4 \
    --light 40,120 --device reference --quiet
expect flat-compared 0 "$interpreter" "$pictures/bake.py" compare flat.png truth.exr flat.exr
cp out compared
agrees() { "$interpreter" -c 'import json, sys; found = json.load(open("compared")); sys.exit(found["middle"] < 33 and str(found))'; }
expect_that flat-spheres-agree agrees

finish
