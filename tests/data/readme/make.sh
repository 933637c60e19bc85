#!/bin/bash
# Makes the README's pictures of the viewer and of levels of detail, viewer.png, levels-off.png and levels-on.png, from
# the built-in sample: make.sh BUILD [WORK [levels|viewer]]. WORK keeps sample and material for the next time. The viewer
# needs Xvfb and xdotool.
#
# SPDX-License-Identifier: MIT
set -eu
build=$(cd "$1" && pwd)
here=$(cd "$(dirname "$0")" && pwd)
PATH=$build/encoder:$build/decoder/tools:$build/decoder/tools/render:$build/decoder/tools/view:$build/tests/sample:$PATH
xvfb= viewer=
if [ $# -gt 1 ]; then
    mkdir -p "$2"
    cd "$2"
    trap 'kill $viewer $xvfb 2>/dev/null || true' EXIT
else
    work=$(mktemp -d)
    cd "$work"
    trap 'kill $viewer $xvfb 2>/dev/null || true; rm -rf "$work"' EXIT
fi
[ -d bricks ] || btf-sample -o bricks --relief bricks --size 32 --quiet
[ -f bricks.btf.exr ] || btf-encode bricks -o bricks.btf.exr --preset fast --levels all -q

which=${3:-both}
for level in 0 auto; do
    [ $which != viewer ] || break
    name=$([ $level = 0 ] && echo off || echo on)
    btf-render bricks.btf.exr -o "$here/levels-$name.png" --mesh plane --view 66,-90 --fov 40 --zoom 1.55 --repeat 26 \
        --size 400x220 --light 40,150 --exposure 0.5 --background 0.9 --level $level --quiet
done

[ $which != levels ] || exit 0
rm -f display log shot-*.png
Xvfb -displayfd 3 -screen 0 800x600x24 3>display 2>xvfb.log &
xvfb=$!
while ! grep -q . display 2>/dev/null; do
    kill -0 $xvfb
    sleep 0.2
done
export DISPLAY=:$(cat display)
unset WAYLAND_DISPLAY

btf-view bricks.btf.exr --original bricks --mesh torus --size 640x480 --screenshots shot --verbose --quiet >log &
viewer=$!
said() { # waits for a line
    while ! grep -q "$1" log; do
        kill -0 $viewer
        sleep 0.3
    done
}
said '^ready'
xdotool windowfocus "$(xdotool search --name '^btf-view$' | head -1)"
sleep 0.5
for key in s plus plus; do
    xdotool key $key
    sleep 0.3
done
xdotool mousemove --window "$(xdotool search --name '^btf-view$' | head -1)" 320 280
xdotool mousedown 1
xdotool mousemove_relative -- -0 90
xdotool mouseup 1
said '^view'
xdotool key p
said '^saved'
mv shot-0001.png "$here/viewer.png"
xdotool key q
wait $viewer
viewer=
