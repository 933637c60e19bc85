#!/bin/bash
# btf-bake: the values of its images, its messages about bad scenes, and that it goes on after a kill.
#
#   test_bake.sh INTERPRETER    a Python with numpy
#
# SPDX-License-Identifier: MIT
. "$(dirname "$0")/../tools/common.sh"
interpreter=$1
here=$BTF_SOURCE_ROOT/tests/bake
command -v blender >/dev/null || {
    report 'Blender' failed 'there is no blender: install the packages of .ci/packages-bake.txt, or leave the suite bake out'
    finish
}
btf-bake() { /usr/bin/python3 "$BTF_SOURCE_ROOT/encoder/bake/btf-bake.py" "$@"; }
images() { "$interpreter" "$here/images.py" "$@"; }
in_blender() { blender --background --factory-startup -noaudio "$@"; }

expect 'scenes' 0 in_blender --python "$here/scenes.py" --python-exit-code 9 -- "$work"

# Values, axes, cameras.
expect 'a white plane' 0 btf-bake white.blend -o white --texels 8 --directions 0:1,40:2,75:3 --samples 4 --sun-angle 0 --strict
expect_that 'gives cos(theta_l) from every view' images white white
expect_text 'progress stands in the log' 'render: done after' err
expect 'a tile that is not square' 0 btf-bake white.blend -o slim --texels 8x4 --tile 0.25,0.5,0.5,0.25 --directions 0:1,60:2 \
    --samples 4 --sun-angle 0 --no-repeat
expect_that 'neither are its texels' images white slim

expect 'posts' 0 btf-bake axes.blend -o post --texels 32 --views 0:1 --lights tiny --samples 4 --bounces 0 --sun-angle 0
expect_that 'their shadows fall away from the light, and texels lie where FORMAT.md says' images post post
expect 'a wide light' 0 btf-bake axes.blend -o soft --texels 32 --views 0:1 --lights tiny --samples 4 --bounces 0 --sun-angle 20
expect 'softens them' 1 images alike post soft 1 0.01
expect 'where texels look' 0 btf-bake axes.blend --position positions --texels 32 --directions tiny
expect_that 'is where the relief is' images positions positions
expect 'from the ground up' 0 btf-bake axes.blend --position grounded --texels 32 --directions tiny --z -0.125
expect_text 'the post protrudes' "'post' protrudes by 0.125 above the reference plane at z = -0.125" err
expect_that 'and the ground stays where it is' images grounded grounded
expect 'again, at another height' 2 btf-bake axes.blend --position positions --texels 32 --directions tiny --z -0.125
expect_text 'is refused' 'positions/bake.json: begun with other settings: z was 0.0, now -0.125' err
expect 'with other texels' 2 btf-bake axes.blend --position positions --texels 16 --directions tiny
expect_text 'too' 'texels was \[32, 32\], now \[16, 16\]' err
expect 'more views' 0 btf-bake axes.blend --position positions --texels 32 --directions 15:1 -q
expect_that 'go into the same folder' test -f positions/tv015_pv000.exr
expect 'positions among images' 2 btf-bake axes.blend --position post --texels 32 --directions tiny
expect_text 'are refused' 'post/bake.json: begun with other settings: holds' err

oblique() { in_blender waves.blend --python "$here/oblique.py" --python-exit-code 9 -- "$BTF_SOURCE_ROOT" "$work" && cat oblique.txt; }
expect 'an ordinary camera' 0 oblique
close() { awk '{ exit !($1 < 0.01 && $2 > 0.999) }' oblique.txt; }
expect_that 'and the homography give what the sheared camera gives' close

# The tile continues at its edges: a bake of another period of the surface gives the same images, shifted.
wavy() { btf-bake waves.blend --texels 8 --directions 0:1,60:3 --samples 64 --bounces 0 "$@"; }
expect 'a tile' 0 wavy -o waves
expect 'the same surface from elsewhere' 0 wavy -o shifted --tile 0.5,0.25,1,1
expect_that 'is the same, shifted: the edges continue' images alike waves shifted 0.0015 0.012 4 2
expect 'another frame' 0 wavy -o frame --frame 2 --tile 0.5,0,1,1
expect_that 'in which it has moved by half a tile' images alike waves frame 0.0015 0.012
expect 'without copies' 0 wavy -o alone --no-repeat
expect 'the edges look into nothing' 1 images alike waves alone 0.0015 0.012

# The same surface from btf-sample, which has a ray tracer of its own.
same=(--directions 0:1,40:3,75:2)
expect 'axes by btf-sample' 0 command btf-sample -o sampled --relief axes --size 16 "${same[@]}" --supersample 4 --format exr -q
expect 'axes by btf-bake' 0 btf-bake axes.blend -o baked --texels 16 "${same[@]}" --samples 64 --bounces 0 --sun-angle 0 --strict
expect_that 'are the same BTF' images alike sampled baked 0.001 0.015

# Blender or the driver is killed at several moments. Then the same command goes on, and the files are the same.
small() { btf-bake waves.blend --texels 8 --directions tiny --samples 4 -q "$@"; }
expect 'a small bake' 0 small -o whole
killed_at() { # MOMENT ACTION
    printf '#!/bin/bash\n[ "$1" = --version ] && exec blender "$@"\nexec env %q %q %q blender "$@"\n' "$preload" \
        "BTF_MOMENT=$1" "BTF_ACTION=$2" >wrapped
    chmod +x wrapped
    small -o resumed --blender ./wrapped
}
# Actions that Blender performs on its driver: it kills it and goes on once the process is gone; or it interrupts it and
# sleeps until the driver ends it.
driver='driver=$(awk "/^PPid/ { print \$2 }" /proc/$PPID/status)'
driver_killed="$driver; kill -KILL \$driver; while grep -q '^State:.*[^Z] (' /proc/\$driver/status 2>/dev/null; do :; done"
driver_interrupted="$driver; kill -INT \$driver; sleep 10"
expect 'Blender is killed' 4 killed_at '3 rename tl' KILL
expect_text 'which is said' 'Blender ended with -9' err
expect 'the driver is killed' 137 killed_at '4 rename tl' "$driver_killed"
expect 'Blender is killed before an image has its name' 4 killed_at '6 open .bake-' KILL
expect 'interrupted' 130 killed_at '2 rename tl' "$driver_interrupted"
expect_text 'how to go on' 'the same command goes on' err
expect 'the same command' 0 small -o resumed
expect_that 'gives the same files' diff -r -x bake-done.txt whole resumed
expect_that 'lists what is done' test "$(wc -l <resumed/bake-done.txt)" = 25
left_over() { find resumed -name '.bake-*' | grep .; }
expect 'and leaves nothing beside them' 1 left_over
expect 'nothing is left to do' 0 btf-bake waves.blend --texels 8 --directions tiny --samples 4 -o resumed
expect_text 'which is said too' '25 of 25 images are there' err
expect 'two of two parts' 0 small -o parts --part 2/2
expect 'are one half' 0 btf-bake waves.blend --texels 8 --directions tiny --samples 4 -o parts --part 2/2
expect_text 'the other one is missing' '13 of the other parts are missing' err
expect 'one of two' 0 small -o parts --part 1/2
expect_that 'and the other' diff -r -x 'bake-done*' whole parts

# Options that change values change them; they are refused for a folder that was begun with other values.
expect 'another seed' 0 small -o seed --seed 1
expect_that 'is other noise' images noise whole seed 0.0005 0.1
expect 'one thread' 0 small -o alone1 --threads 1
expect_that 'gives the same files' diff -r -x bake-done.txt whole alone1
expect 'more samples' 0 small -o fine --samples 64
expect 'and another seed' 0 small -o finer --samples 64 --seed 1
expect_that 'are less of it' images noise fine finer 0.0001 0.01
expect 'one bounce' 0 small -o direct --bounces 0
expect 'is darker' 1 images alike whole direct 0.002 1
expect 'other settings' 2 small -o whole --samples 5
expect_text 'name what differs' 'samples was 4, now 5' err
expect 'another scene' 2 btf-bake white.blend -o whole --texels 8 --directions tiny --samples 4
expect_text 'too' 'scene_sha256 was' err
cp -r whole unsaved
sed -i 's/"scene_sha256": ".*"/"scene_sha256": ""/' unsaved/bake.json
expect 'a folder begun with an unsaved scene' 0 small -o unsaved
expect_text 'is warned of' 'unsaved/bake.json: unsaved changes of the scene have no hash' err
cp white.blend lost.blend
expect 'a scene that names a file' 0 in_blender lost.blend --python-exit-code 9 --python-expr 'import bpy
bpy.data.images.new("own", 4, 4).save_render("leaf.png")
bpy.data.images.load(bpy.path.abspath("//leaf.png")).use_fake_user = True
bpy.ops.wm.save_mainfile()'
once() { btf-bake lost.blend -o lost --texels 8 --directions 0:1 --samples 1 -q; }
expect 'its bake' 0 once
expect 'once more' 0 once
echo changed >>leaf.png
expect 'after a change of that file' 2 once
expect_text 'is another one' 'linked_sha256 was' err
mkdir strange && touch strange/notes
expect 'a folder of something else' 2 small -o strange
expect_text 'is named' "strange: holds 'notes'" err
expect 'a preview' 0 btf-bake waves.blend --preview waves.png --texels 8 --samples 4
is_png() { [ "$(head -c 4 "$1" | tail -c 3)" = PNG ]; }
expect_that 'is a PNG file' is_png waves.png
echo '45 0 10 120 # one
0 0 30 90' >pairs.txt
expect 'single pairs' 0 small -o pairs --pairs pairs.txt
expect_that 'have their names' test -f pairs/tl10.0000_pl120.0000_tv45.0000_pv000.0000.exr

# Bad scenes and options.
bad() { # NAME CODE TEXT ARGUMENT...
    expect "$1" "$2" btf-bake "${@:4}" --texels 8 --directions 0:1 --samples 1
    expect_text "$1: the message" "$3" err
}
printf '#!/bin/bash\necho Blender 2.79\n' >old && chmod +x old
bad 'no such collection' 3 "no collection 'BTF'" nowhere.blend -o bad
bad 'nothing in it' 3 'nothing to bake' empty.blend -o bad
bad 'no material' 3 "object 'patch' has faces without a material" bare.blend -o bad
bad 'emission' 3 'the scene emits light' glowing.blend -o bad
bad 'no such object' 3 "no object 'nobody'" white.blend -o bad --object nobody
bad 'nothing within the tile' 3 'nothing lies within the tile 5,5,1,1' white.blend -o bad --tile 5,5,1,1 --no-repeat
bad 'a tile of zero size' 1 'a tile of 1 x 0 has no area' white.blend -o bad --tile 0,0,1,0
bad 'a folder that cannot be' 2 'white.blend' white.blend -o white.blend/in
bad 'no such scene' 2 'none.blend: No such file' none.blend -o bad
bad 'a scene that is none' 3 'not a file of Blender' "$here/scenes.py" -o bad
head -c 3000 white.blend >cut.blend
bad 'a scene that is cut off' 3 'cannot read it' cut.blend -o bad
bad 'no Blender' 5 "'nowhere/blender': there is no such program" white.blend -o bad --blender nowhere/blender
bad 'an old Blender' 5 'Blender 2.79' white.blend -o bad --blender ./old
expect 'no texels' 1 btf-bake white.blend -o bad --texels 0
expect_text 'are not divided by' '--texels: \(0, 0\) are not within 1..8192' err
bad 'positions in the folder of the images' 1 'is the folder of the images' white.blend -o bad --position ./bad
bad 'no output' 1 'no output' white.blend
bad 'encoding options without encoding' 1 'run.* with --encode' white.blend -o bad -- --budget 1MB
bad 'faults' 0 "'leaf' protrudes by 0.05 above the reference plane at z = 0" faults.blend -o faults
expect_text 'a part beyond the tile' "'leaf' reaches 0.25 beyond the tile at \+x" err
expect_text 'a hole' 'open below: 2[0-9.]* % of the texels seen from above' err
expect_text 'a lamp' "lights of the scene do not shine: 'lamp'" err
expect 'one object of it' 0 btf-bake faults.blend -o object --object ground --z -0.1 --tile 0,0,1,0.75 --texels 8 \
    --directions 0:1 --samples 1 --strict
bad 'faults, strictly' 3 'warnings, and --strict' faults.blend -o strict --strict
finish
