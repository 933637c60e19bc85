#!/bin/bash
# btf-view under Xvfb: every key and mouse gesture as real events, screenshots, dropped files, no display, no GL.
#
# SPDX-License-Identifier: MIT
. "$BTF_SOURCE_ROOT/tests/tools/common.sh" || exit 99
PATH=$build/decoder/tools/view:$build/decoder/tools/render:$build/tests/tools:$PATH
for tool in btf-view x_drop xdotool Xvfb; do
    if ! command -v $tool >/dev/null; then
        echo "skipped: no $tool"
        exit 77
    fi
done
small_data
btf-encode data -o m.btf.exr --method paper $starts -q || exit 99
btf-encode data -o levels.btf.exr --preset fast --levels all -q || exit 99
cat >far.obj <<'O'
v -1 -1 0
v 1 -1 0
v 1 1 0
v -1 1 0
vt 0 0
vt 40 0
vt 40 40
vt 0 40
f 1/1 2/2 3/3 4/4
O
cat >seat.obj <<'O'
v -1 -1 0
v 1 -1 0
v 0 1 0
vt 0 0
vt 1 0
vt 0 1
f 1/1 2/2 3/3
O

expect "help" 0 btf-view --help
for option in mesh original size effects interpolation filter math level plan tolerance screenshots verbose quiet; do
    expect_text "help names --$option" "--$option" out
    expect_that "--$option is exercised" grep -Eq -- "(^|[^a-z-])--$option([^a-z-]|\$)" "$0"
done
expect "no display" 5 env -u DISPLAY -u WAYLAND_DISPLAY btf-view m.btf.exr
expect_text "is told, with what to do" 'no display: .*btf-render' err
expect "no file" 2 btf-view none.btf.exr
expect_text "is told" 'none.btf.exr' err
expect "a broken file" 3 btf-view seat.obj
expect "an unknown mesh" 1 btf-view m.btf.exr --mesh cube
echo "v 1" >bad.obj
expect "a broken OBJ" 3 env -u DISPLAY btf-view m.btf.exr --mesh bad.obj
expect "original without a file" 1 btf-view --original data
expect "prices that are cut off" 3 btf-view m.btf.exr --plan auto --costs "$BTF_SOURCE_ROOT/tests/fuzz/corpus/costs/cut.json"
expect "a plan that is none" 1 btf-view m.btf.exr --plan all
expect "a wrong size" 1 btf-view --size 1x1

# until_it COMMAND...: waits until the command succeeds. No result depends on how long that takes: the limit of minutes
# only ends a viewer that hangs.
until_it() {
    for i in $(seq 3000); do
        "$@" && return
        sleep 0.1
    done
}

# A virtual display.
Xvfb -displayfd 3 -screen 0 800x600x24 3>display 2>xvfb.log &
xvfb=$!
trap 'kill $viewer $xvfb 2>/dev/null; rm -rf "$work"' EXIT
viewer=
until_it test -s display
export DISPLAY=:$(cat display)
unset WAYLAND_DISPLAY

expect "no OpenGL 3.3" 5 env MESA_GL_VERSION_OVERRIDE=2.1 btf-view m.btf.exr
expect_text "is told" 'no OpenGL 3.3' err

with=() # variables in the viewer's environment
told=   # a text that the viewer must print on stderr before the first picture of `rests`
start() { # OPTIONS...: in the background, until the window is ready
    : >log
    env "${with[@]}" btf-view "$@" --size 320x240 --verbose --quiet --screenshots shot >log 2>view.err &
    viewer=$!
    until_it grep -q '^ready' log
    window=$(xdotool search --sync --name '^btf-view$' | head -1)
    xdotool windowfocus --sync "$window"
}
# said NAME LINE: waits for the line in the log
is_said() { tail -n +$((seen + 1)) log | grep -Eq -- "$1"; }
said() {
    until_it is_said "$2"
    tail -n +$((seen + 1)) log >new
    seen=$(wc -l <log)
    expect_text "$1" "$2" new
}
seen=0
press() { # KEY LINE
    xdotool key "$1"
    said "key $1" "$2"
}
drag() { # BUTTON LINE [with shift]
    xdotool mousemove --window "$window" 160 120
    [ -n "${3:-}" ] && xdotool keydown shift
    xdotool mousedown "$1"
    xdotool mousemove --window "$window" 200 150
    xdotool mouseup "$1"
    [ -n "${3:-}" ] && xdotool keyup shift
    said "drag with button $1 ${3:-}" "$2"
}
shots=0
shoot() { # saves a picture as $1.png
    shots=$((shots + 1))
    press p "^saved shot-$(printf %04d $shots).png"
    cp "shot-$(printf %04d $shots).png" "$1.png"
}
differ() { expect_that "$1" test "$(cmp -s "$2" "$3"; echo $?)" = 1; }

start m.btf.exr --original data
press i '^panel off'
shoot start
for key in 1:shift,hidden 2:hidden 3:gain; do
    press ${key%%:*} "^effects ${key##*:}"
    shoot "effect${key%%:*}"
done
differ "shadows off are seen" start.png effect1.png
press 4 '^effects residual'
press 5 '^effects relief,gloss'
press 6 '^effects gloss'
press 7 '^effects none'
shoot none
press 0 '^effects all'
shoot all
expect_that "all effects again is the same picture" cmp start.png all.png
differ "no effects are seen" start.png none.png
press s '^split SBRDF'
shoot split
differ "the split is seen" start.png split.png
press bracketright '^split at 0.55'
press bracketleft '^split at 0.50'
drag 2 '^split at 0.6'
press s '^split original'
shoot original
differ "the original is seen" split.png original.png
press s '^split off'
press t '^stochastic on'
shoot picked
differ "one neighbour in place of all is seen" all.png picked.png
press t '^stochastic off'
shoot blended
expect_that "all of them again are the same picture" cmp all.png blended.png
press n '^directions nearest'
shoot nearest
differ "nearest directions are seen" start.png nearest.png
press n '^directions linear'
press b '^filter bilinear'
shoot bilinear
differ "bilinear is seen" start.png bilinear.png
press b '^filter steep'
shoot steep
differ "steep is seen" bilinear.png steep.png
press b '^filter texel'
press x '^math fast'
press x '^math exact'
press l '^levels off \(the file has one\)'
press l '^levels on'
press plus '^exposure \+0.25'
shoot bright
differ "exposure is seen" start.png bright.png
press minus '^exposure \+0.00'
press KP_Add '^exposure \+0.25'
press KP_Subtract '^exposure \+0.00'
for mesh in plane torus drape; do
    press m "^model $mesh"
    shoot $mesh
done
differ "models are seen" plane.png torus.png
press m '^model sphere'
shoot sphere
expect_that "the sphere again is the same picture" cmp start.png sphere.png
drag 1 '^view [1-9]'
shoot orbit
differ "turning is seen" start.png orbit.png
drag 3 '^light [1-9]'
drag 1 '^light [1-9]' shift
shoot light
differ "the light is seen" orbit.png light.png
xdotool click 4
said "the wheel" '^zoom 0.99'
xdotool click 5
said "the wheel back" '^zoom 0.90'
press h '^help on'
shoot help
differ "help is seen" light.png help.png
press F1 '^help off'
press r '^reset'
shoot reset
press i '^panel off'
press c '^measured: [0-9.]+ ms a frame'
press a '^animation on'
has_moved() { # takes a picture at each call; succeeds once one differs
    shoot moved >moves && ! cmp -s start.png moved.png
}
until_it has_moved
cat moves
press a '^animation off'
shoot moved
differ "animation is seen" start.png moved.png

expect "a model dropped" 0 x_drop "$window" seat.obj
said "is shown" '^opened seat.obj'
shoot dropped
differ "and seen" moved.png dropped.png
cp seat.obj seat.txt
expect "a model without its ending dropped" 0 x_drop "$window" seat.txt
said "is shown" '^opened seat.txt'
press m '^model sphere'
btf-sample -o other --relief bumps --size 12 --directions 0:1,45:4 --quiet
btf-encode other -o other.btf.exr --method paper -q
expect "a material dropped" 0 x_drop "$window" other.btf.exr
said "is shown" '^opened other.btf.exr'
expect "a broken file dropped" 0 x_drop "$window" log
press s '^split SBRDF'
expect_text "is told, and the viewer goes on" 'error: .*log' view.err
press s '^split off'
xdotool key Escape
wait $viewer
expect_that "Escape quits with 0" test $? = 0

seen=0
start levels.btf.exr --mesh far.obj
press i '^panel off'
shoot minified
press l '^levels off$'
shoot finest
differ "levels are seen where the texture is small" minified.png finest.png
press l '^levels on$'
press x '^math fast'
press x '^math exact'
shoot again
expect_that "levels again are the same picture" cmp minified.png again.png
xdotool key q
wait $viewer
seen=0
start levels.btf.exr --mesh far.obj --level 0
press i '^panel off'
shoot option
expect_that "--level 0 is what the key does" cmp finest.png option.png
xdotool key q
wait $viewer

seen=0
start --mesh seat.obj --effects none --interpolation nearest --filter bilinear --math fast
expect "a material dropped on an empty window" 0 x_drop "$window" m.btf.exr
said "is shown" '^opened m.btf.exr'
press 1 '^effects shadow'
press n '^directions linear'
press b '^filter steep'
press b '^filter texel'
press x '^math exact'
xdotool key q
wait $viewer
expect_that "Q quits with 0" test $? = 0

# The viewer makes a plan, then folds the light, then the light moves, then the camera leaves the plan's range and comes
# back: all the time the pictures are those of a viewer that decodes everything.
# logged NAME N LINE: waits until the log has N such lines
has_logged() { [ "$(grep -Ec -- "$2" log)" -ge "$1" ]; }
logged() {
    until_it has_logged "$2" "$3"
    expect_that "$1" test "$(grep -Ec -- "$3" log)" -ge $2
}
tour() { # NAME, planned or not: pictures NAME-0.png to 3
    press i '^panel off'
    if [ $2 = planned ]; then
        logged "$1: a plan" 1 '^plan 1: .*light free'
        logged "$1: at rest" 1 '^plan .*light folded.*made in [0-9.]+ ms'
    fi
    shoot $1-0
    drag 3 '^light [1-9]'
    [ $2 = planned ] && logged "$1: the light moved" 2 '^plan .*light free'
    shoot $1-1
    [ $2 = planned ] && logged "$1: and rests" 2 '^plan .*light folded'
    for i in 1 2 3 4; do
        drag 1 '^view [1-9]'
    done
    [ $2 = planned ] && logged "$1: the camera left the range" 1 '^plan .*: views (7.5|[1-9][0-9]).* made in [0-9.]+ ms'
    shoot $1-2
    press r '^reset'
    press i '^panel off'
    [ $2 = planned ] && logged "$1: and came back" 3 '^plan .*light free'
    shoot $1-3
    xdotool key q
    wait $viewer
    expect_that "$1 quits with 0" test $? = 0
}
if [ -z "$light" ]; then # pictures to compare with
    seen=0
    start levels.btf.exr --mesh plane
    tour whole everything
fi
seen=0
start levels.btf.exr --mesh plane --plan auto --tolerance 0
tour planned planned
for i in 0 1 2 3; do
    unless_light expect_that "planned within 0 dB: picture $i is the same" cmp whole-$i.png planned-$i.png
done

# A resting light on a flat model is folded into a texture, with a plan and without. The picture must be that of a model
# with a speck that no pixel shows and that is not flat, so that nothing can be folded.
btf-encode data -o still.btf.exr --preset fast --gloss off --relief off -q || exit 99
cat >quad.obj <<'O'
v -1 -1 0
v 1 -1 0
v 1 1 0
v -1 1 0
vt 0 0
vt 2 0
vt 2 2
vt 0 2
vn 0 0 1
f 1/1/1 2/2/1 3/3/1 4/4/1
O
{
    cat quad.obj
    printf 'v 0 0 0\nv 0.0000001 0 0\nv 0 0.0000001 0\nvn 0 1 0\nf 5/1/2 6/2/2 7/3/2\n'
} >speck.obj
rests() { # NAME, PATTERN OF WHAT IS FOLDED (none: nothing), OPTIONS: pictures NAME-0 and, the light moved, NAME-1
    local name=$1 line=$2
    shift 2
    seen=0
    start still.btf.exr "$@"
    press i '^panel off'
    [ "$line" = none ] || logged "$name: the light rests" 1 "$line"
    [ -z "$told" ] || until_it grep -q "$told" view.err # otherwise the picture could come before the light rests
    shoot $name-0
    drag 3 '^light [1-9]'
    [ "$line" = none ] || logged "$name: the light moved, and rests again" 2 "$line"
    shoot $name-1
    xdotool key q
    wait $viewer
    expect_that "$name quits with 0" test $? = 0
}
if [ -z "$light" ]; then
    rests free none --mesh speck.obj
    expect_that "a speck's normal is not folded" test "$(grep -c folded log)" = 0
fi
rests folded '^the light rests: folded into [0-9]+ bytes' --mesh quad.obj
rests plan '^plan .*light folded into a texture.*fold [0-9.]+' --mesh quad.obj --plan auto --tolerance 0
if [ -z "$light" ]; then # under the sanitizers test_render.sh has such a refusal
    with=("$short_gpu") told=refuses
    rests refused none --mesh quad.obj --plan auto --tolerance 0
    with=() told=
    expect_text "no memory for a fold is told" 'refuses [0-9]+ bytes for a fold of the light: nothing is folded' view.err
    expect_that "once" test "$(wc -l <view.err)" = 1
    expect_that "no plan folds" test "$(grep -c 'folded into a texture' log)" = 0
    for i in 0 1; do
        expect_that "no memory for a fold: picture $i is the same" cmp free-$i.png refused-$i.png
    done
fi
for i in 0 1; do
    unless_light expect_that "folded by itself: picture $i is the same" cmp free-$i.png folded-$i.png
    expect_that "folded by a plan: picture $i is the same" cmp folded-$i.png plan-$i.png
done
seen=0
start levels.btf.exr --plan auto --tolerance 20 --original data
logged "a plan that leaves out" 1 '^plan 1: .*bytes of'
press h '^help on'
press s '^split SBRDF|^split original'
press s '^split '
shoot planned
press m '^model plane'
logged "another model, another plan" 1 '^plan [2-9]'
xdotool key q
wait $viewer
expect_that "a planned view quits with 0" test $? = 0
finish
