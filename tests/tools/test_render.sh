#!/bin/bash
# btf-render: the same picture on every device for every mesh and effect set, every option, every exit code.
#
# SPDX-License-Identifier: MIT
. "$BTF_SOURCE_ROOT/tests/tools/common.sh" || exit 99
PATH=$build/decoder/tools/render:$PATH
small_data
btf-encode data -o m.btf.exr --method paper $starts -q || exit 99
render() { btf-render m.btf.exr --size 40 --quiet "$@"; }
same() { expect_that "$1" cmp "$2" "$3"; }
differ() { expect_that "$1" test "$(cmp -s "$2" "$3"; echo $?)" = 1; }

cat >seat.obj <<'O'
v -1 0 -1
v 1 0 -1
v 1 0 1
v -1 0 1
v -1 1.5 -1
v 1 1.5 -1
vt 0 0
vt 1 0
vt 1 1
vt 0 1
f 4/1 3/2 2/3 1/4
f 1/1 2/2 6/3 5/4
O

# One scene rendered on a device; 5 means that the machine has no such device.
devices=
for device in osmesa egl softpipe egl-es300; do
    render -o probe.png --device $device >out 2>err
    case $? in
    0) devices="$devices $device" ;;
    5) echo "no $device here: $(cat err)" ;;
    *) report "device $device starts" failed "$(cat err)" ;;
    esac
done
expect_that "a GL device is there" test -n "$devices"
meshes="plane sphere torus drape seat.obj" sets="none shadow shift,hidden all"
levels=5
if [ -n "$light" ]; then
    meshes="sphere seat.obj" sets=all levels=4
    has_softpipe=$(grep -o softpipe <<<"$devices")
    devices=${devices% softpipe*} # the driver's devices would show the sanitizers only the same code of ours
fi
for mesh in $meshes; do
    for effects in $sets; do
        render -o r.png --device reference --mesh $mesh --effects $effects --view 35,-70 --cast-shadows
        for device in $devices; do
            # A mesh changes the samples, a set of effects the shader. All pairs of these are rendered on osmesa; on
            # other devices each mesh and each set occurs once.
            [ $device = softpipe ] && [ $effects != all ] && continue
            case $device in
            egl*) [ $effects = all ] || [ $mesh = sphere ] || continue ;;
            esac
            render -o g.png --device $device --mesh $mesh --effects $effects --view 35,-70 --cast-shadows
            same "$mesh, $effects: $device gives the reference's picture" r.png g.png
        done
    done
done
# Format version 2: factors, both blends.
for made in "1 tight 1 roots" "2 paper 1 radiance"; do
    "$build/tests/tools/factor_file" v2.btf.exr $made || exit 99
    for way in "" "--components 4 --filter bilinear" "--interpolation nearest --effects shift,residual"; do
        v2() { btf-render v2.btf.exr --size 40 --quiet --mesh torus $way "$@"; }
        v2 -o r.png --device reference
        for device in $devices; do
            [ $device = softpipe ] && [ -n "$way" ] && continue # minutes
            # osmesa renders both materials with all options; other devices render each option once, and both materials.
            case "$device $made" in
            egl\ 1* | egl-es300\ 2*) [ -n "${way##--components*}" ] || continue ;;
            egl\ 2* | egl-es300\ 1*) [ -z "${way##--components*}" ] || continue ;;
            esac
            v2 -o g.png --device $device
            same "factors, $made, ${way:-all}: $device gives the reference's picture" r.png g.png
        done
    done
done
render -o default.png --device reference
for way in "--interpolation nearest" "--filter bilinear" "--samples 3 --exposure -1.5" "--point 1,1,2,3 --light 20,0,0.5,1,0,0" \
    "--tone filmic --background 0.2" "--tone reinhard" "--fov 0 --zoom 0.5 --repeat 1.5" "--size 31x17" "--stochastic" \
    "--stochastic --spp 3 --filter bilinear --point 1,1,2,3 --light 20,0"; do
    render -o r.png --device reference $way
    render -o g.png --device osmesa $way
    same "$way: the reference's picture" r.png g.png
    differ "$way: another picture than the default" r.png default.png
done
render -o a.exr --device reference
render -o b.exr --device osmesa --threads 1
same "EXR: the reference's picture, whatever the threads" a.exr b.exr
expect "many samples, several bands" 0 render -o big.png --device reference --size 140x128 --samples 4
render -o big2.png --size 140x128 --samples 4
same "several bands: the reference's picture" big.png big2.png

# Levels of detail: the level of each sample is part of the table.
btf-encode data -o levels.btf.exr --preset fast --levels all -q || exit 99
btf-encode data -o plevels.btf.exr --method paper $starts --levels 4 -q || exit 99
lod() { btf-render "$@" --size 40 --quiet; }
for mesh in $meshes; do
    level_sets=all paper_level_sets=all # every mesh, and on one of them every set
    [ $mesh = torus ] && level_sets="none shift gain all" paper_level_sets="shadow shadow,shift hidden all"
    for effects in $level_sets; do
        lod levels.btf.exr -o r.png --device reference --mesh $mesh --effects $effects --view 35,-70 --repeat 9
        for device in $devices; do
            [ $device = softpipe ] && continue
            [ $device = osmesa ] || [ $effects = all ] || continue
            lod levels.btf.exr -o g.png --device $device --mesh $mesh --effects $effects --view 35,-70 --repeat 9
            same "levels, $mesh, $effects: $device gives the reference's picture" r.png g.png
        done
    done
    lod levels.btf.exr -o finest.png --mesh $mesh --view 35,-70 --repeat 9 --level 0
    differ "levels, $mesh: another picture than the finest level alone" r.png finest.png
    for effects in $paper_level_sets; do
        lod plevels.btf.exr -o r.png --device reference --mesh $mesh --effects $effects --view 35,-70 --repeat 9
        lod plevels.btf.exr -o g.png --device osmesa --mesh $mesh --effects $effects --view 35,-70 --repeat 9
        same "paper's levels, $mesh, $effects: the reference's picture" r.png g.png
    done
done
for way in "--filter bilinear" "--interpolation nearest --samples 2" "--level 2" "--fov 0" "--stochastic --spp 2"; do
    lod levels.btf.exr -o r.png --device reference --mesh plane --view 60,-90 --repeat 9 $way
    lod levels.btf.exr -o g.png --device osmesa --mesh plane --view 60,-90 --repeat 9 $way
    same "levels, $way: the reference's picture" r.png g.png
done
case $devices${has_softpipe:-} in
*softpipe*)
    for way in "" "--level 2" "--math fast"; do
        expect "softpipe fetches one level for four pixels $way" 5 lod levels.btf.exr -o x.png --device softpipe $way
        expect_text "is told $way" 'fetches from mip levels other than the one asked for' err
    done
    ;;
esac
plane() { btf-render levels.btf.exr --mesh plane --fov 0 --repeat 1 --quiet "$@"; }
for level in $(seq 0 $((levels - 1))); do
    plane -o auto.png --size $((side >> level))
    plane -o level.png --size $((side >> level)) --level $level
    same "a plane at 1/$((1 << level)) scale takes level $level" auto.png level.png
done
plane -o finer.png --size $side --samples 2
plane -o level.png --size $side --samples 2 --level 0
same "supersamples take the level of their own spacing" finer.png level.png
expect "a level that is not there" 1 render -o x.png --level 1
expect_text "is told" 'option --level: 1, but m.btf.exr has 1 level$' err
for option in --level=4294967296 --size=4294967297 "--size=8x 8" "--view= 1,2"; do
    expect "$option" 1 render -o x.png "$option"
    expect_text "is refused with option and value" "option ${option%%=*}: '${option#*=}' is not" err
done
cp m.btf.exr same.btf.exr
expect "a picture in the material's place" 1 btf-render same.btf.exr -o ./same.btf.exr --device reference --size 16
expect_text "is told" 'option --output: same.btf.exr is an input' err
expect_that "the material is kept" cmp m.btf.exr same.btf.exr
expect "no level" 1 render -o x.png --level coarse
expect "figure 13 of a coarser level" 1 lod levels.btf.exr -o x.png --figure13 --original data --level 1
expect_text "is told why" 'option --level: 1, but --figure13' err
expect "figure 13 of a file with levels" 0 lod plevels.btf.exr -o f13.png --figure13 --original data --mesh plane --view 40,0 --repeat 9
lod m.btf.exr -o f13b.png --figure13 --original data --mesh plane --view 40,0 --repeat 9 >out2
same "shows the finest" f13.png f13b.png

btf-decode m.btf.exr -o d.png --light 40,120
expect "a plane straight on" 0 btf-render m.btf.exr -o p.png --mesh plane --fov 0 --repeat 1 --size $side --quiet
same "which is the decoded image" d.png p.png

expect "fast math" 0 render -o f.png --math fast
expect "statistics" 0 render -o s.png --stats --interpolation nearest
expect_text "name decode" '^decode: [0-9.]+ ms a frame, [0-9.]+ frames a second' out
expect_text "and Phong beside it" '^phong: [0-9.]+ ms a frame' out
expect "statistics of the reference" 0 render -o s.png --stats --device reference
expect_text "say so" '^device: reference decoder' out
btf-encode data -o joint.btf.exr -q || exit 99
for device in reference ${devices%% softpipe*}; do
    btf-render joint.btf.exr -o r.png --size 24 --quiet --device $device --effects shadow,shift,hidden,gain
    expect "$device: no components" 0 btf-render joint.btf.exr -o s.png --size 24 --quiet --device $device --components 0
    same "$device: which is no residual" r.png s.png
done
expect "frames of light" 0 btf-render m.btf.exr -o turn.png --size 24 --frames 3 --animate light
expect_that "are numbered" test "$(ls turn.000[123].png | wc -l)" = 3
differ "and differ" turn.0001.png turn.0002.png
expect "frames of the view" 0 render -o orbit.exr --frames 2 --animate view --view 60,0 --mesh torus
differ "and differ too" orbit.0001.exr orbit.0002.exr

render -o sky.exr --light 0,0 --background 1
expect "an environment map" 0 render -o e.png --environment sky.exr --environment-lights 16 --environment-rotate 30 --environment-gain 2 --stats --device reference
expect_text "gives so many lights" ' 16 lights' out
render -o e2.png --environment sky.exr --environment-lights 16 --environment-rotate 30 --environment-gain 2
same "the reference's picture under a map" e.png e2.png

# Directions drawn by map and material: the same picture on every device, also with picks and with a plan.
sampled() { render -o "$@" --environment sky.exr --light environment --mesh torus --cast-shadows; }
expect "a map that is sampled" 0 sampled r.png --device reference --spp 6 --stats
expect_text "says how" '^environment: 6 directions a sample' out
expect_text "which no light stands for" ' 0 lights' out
for device in $devices; do
    [ $device = softpipe ] && continue
    sampled g.png --device $device --spp 6
    same "$device: the reference's picture under directions" r.png g.png
done
sampled s.png --device reference --spp 7
differ "another direction, another picture" r.png s.png
sampled s.png --device reference
sampled g.png --device reference --spp 64
same "64 directions by default" s.png g.png
sampled s.png --device reference --spp 6 --plan auto --tolerance 0
same "a plan that loses nothing draws the same" r.png s.png
sampled s.png --device reference --spp 6 --stochastic
sampled g.png --device osmesa --spp 6 --stochastic
same "directions of one pick each" s.png g.png
differ "which are not decoded whole" r.png s.png
sampled turn.png --device reference --spp 2 --frames 2 --animate light
differ "the map turns" turn.0001.png turn.0002.png
expect "a map that is not there to sample" 1 render -o x.png --light environment
expect_text "is told" 'option --light environment: needs --environment' err
expect "lights of a map that is sampled" 1 render -o x.png --light environment --environment sky.exr --environment-lights 16
expect_text "are told" 'option --environment-lights: not together with --light environment' err
expect "no map to sample" 2 render -o x.png --light environment --environment none.exr
printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n' >sky.hdr
for i in 1 2 3 4 5 6 7 8; do printf '\x80\x80\x80\x82' >>sky.hdr; done
expect "a Radiance map" 0 render -o e.png --environment sky.hdr --environment-lights 4
expect "a layer of a map that lacks it" 5 render -o x.png --environment sky.exr --environment-lights 4 --layer diffuse
expect_text "is refused by name" "option layer: 'diffuse' does not name exactly one layer" err
expect "a layer of a Radiance map" 5 render -o x.png --environment sky.hdr --environment-lights 4 --layer diffuse
expect_text "is refused by name too" "sky.hdr: option --layer: 'diffuse'" err

expect "figure 13" 0 btf-render m.btf.exr -o f13.png --size 60 --figure13 --original data --mesh plane --view 40,0 --quiet
expect_text "with the full method" '^full: psnr linear [0-9.]+ dB, srgb [0-9.]+ dB' out
expect_that "which climbs from SBRDF to full" python3 - <<'P'
import re
psnr = {l.split(":")[0]: float(re.search("linear ([0-9.]+)", l).group(1)) for l in open("out")}
assert psnr["SBRDF"] < psnr["full"], psnr
P
btf-sample -o other --relief bumps --size $side --directions 0:1,45:4 --quiet
expect "figure 13 with other data" 1 btf-render m.btf.exr -o x.png --figure13 --original other
expect_text "names both counts" 'original: the images have 5 views, but the material has 7' err
expect "figure 13 with a baseline" 0 btf-render m.btf.exr -o f13b.png --size 60 --figure13 --original data --baseline m.btf.exr --mesh plane --view 40,0 --quiet
same "which is the same when it is the material itself" f13.png f13b.png
expect "no such baseline" 2 render -o x.png --figure13 --original data --baseline none.btf.exr
expect "a baseline without figure 13" 1 render -o x.png --baseline m.btf.exr
expect "figure 13 without data" 1 render -o x.png --figure13
expect "data without figure 13" 1 render -o x.png --original data

expect "help" 0 btf-render --help
for option in $(grep -o '^ *\.\?{*.*\.name = "[a-z0-9-]*"' "$BTF_SOURCE_ROOT/decoder/tools/render/settings.c" | sed 's/.*"\(.*\)"/\1/' | grep -v btf-render); do
    expect_text "help names --$option" "--$option" out
    name=--$option
    [ $option = output ] && name=-o
    expect_that "$name is exercised" grep -Eq -- "(^|[^a-z-])$name([^a-z-]|\$)" "$0"
done
expect "no output" 1 render
expect_text "is told" 'option --output is missing' err
expect "an output of another kind" 1 render -o x.jpg
expect "an unknown mesh" 1 render -o x.png --mesh cube
expect_text "names the meshes" "'cube': expected plane, sphere, torus, drape" err
expect "an unknown device" 1 render -o x.png --device teapot
expect_text "names the devices" "'teapot' is not one of reference, osmesa" err
expect "fast math on the reference" 1 render -o x.png --device reference --math fast
expect "picks that nothing picks" 1 render -o x.png --spp 4
expect_text "are told" 'option --spp: only together with --stochastic or --light environment' err
expect "no picks" 1 render -o x.png --stochastic --spp 0
expect "figure 13 by picks" 1 render -o x.png --stochastic --figure13 --original data
expect_text "is told" 'option --stochastic: not together with --figure13' err
expect "a wrong light" 1 render -o x.png --light 10
expect "a light behind a space" 1 render -o x.png --light " 10,20"
expect_text "is refused with its value" "option --light: . 10,20. is not" err
expect "a wrong point" 1 render -o x.png --point 1,2
expect "a wrong view" 1 render -o x.png --view 200,0
expect "a wrong size" 1 render -o x.png --size 0
expect "a wrong number of lights" 1 render -o x.png --environment sky.exr --environment-lights 5
expect "no material" 2 btf-render none.btf.exr -o x.png
expect_text "names it" 'none.btf.exr' err
expect "no OBJ" 2 render -o x.png --mesh none.obj
printf 'v 0 0 0\nf 1 2 3\n' >bad.obj
expect "a broken OBJ" 3 render -o x.png --mesh bad.obj
expect_text "names file and line" 'bad.obj:2: face' err
expect "no map" 2 render -o x.png --environment none.exr
expect "a broken map" 3 render -o x.png --environment seat.obj
expect "a broken material" 3 btf-render seat.obj -o x.png
expect "an output folder that is not there" 2 render -o none/x.png
expect_that "no picture is left of a failure" test ! -e x.png
expect "no display" 5 env -u DISPLAY -u WAYLAND_DISPLAY btf-render m.btf.exr -o x.png --device glfw
expect_text "is told" 'device glfw' err

# A light, or light and view, that are the same in every pixel are decoded once (folded) and give the same picture.
btf-encode data -o still.btf.exr --preset fast --gloss off --relief off --levels 2 -q || exit 99
still() { btf-render still.btf.exr --size 40 --quiet --mesh plane --light 20,100 "$@"; }
for way in "--view 30,50 --repeat 9" "--view 30,50 --filter bilinear --interpolation nearest" "--fov 0 --view 20,0" \
    "--view 10,20 --plan auto --tolerance 3"; do
    still -o r.png --device reference --fold never $way
    for device in reference osmesa; do
        expect "$device folds: $way" 0 still -o f.png --device $device --fold always --stats $way
        expect_text "$device: says so: $way" "^folded: light$(grep -q -- '--fov 0' <<<"$way" && echo ' and view'), [0-9]+ bytes" out
        same "$device: the same picture folded, $way" r.png f.png
    done
done
still -o r.png --device reference --fold never --view 60,0 --animate view --frames 2
for device in reference osmesa; do
    still -o f.png --device $device --fold always --view 60,0 --animate view --frames 2
    same "$device: folded once for all frames" r.0002.png f.0002.png
done
for way in "--mesh sphere" "--point 0,0,2" "--animate light --frames 2"; do
    expect "nothing to fold: $way" 0 still -o f.png --fold always --stats --device reference $way
    expect_text "says so: $way" '^folded: nothing' out
done
still -o r.png --device osmesa --fold never
expect "no memory for a fold" 0 env "$short_gpu" btf-render still.btf.exr --size 40 --quiet --mesh plane --light 20,100 \
    -o f.png --device osmesa --fold always --stats
expect_text "says so once" 'refuses [0-9]+ bytes for a fold: nothing is folded' err
expect_that "and nothing else" test "$(wc -l <err)" = 1
expect_text "and folds nothing" '^folded: nothing' out
same "and shows the same picture" r.png f.png

# An SBRDF and gloss depend on the view: they are folded only where the view is still as well.
btf-encode data -o glossy.btf.exr --preset fast --gloss 1 -q || exit 99
for file in m glossy; do
    view_dependent() { btf-render $file.btf.exr --size 40 --quiet --mesh plane --light 20,100 "$@"; }
    expect "$file: a perspective" 0 view_dependent -o f.png --fold always --stats --device reference
    expect_text "$file: is not folded" '^folded: nothing' out
    view_dependent -o r.png --fov 0 --view 20,0 --device reference --fold never
    for device in reference osmesa; do
        expect "$file, $device: a parallel projection" 0 \
            view_dependent -o f.png --fov 0 --view 20,0 --device $device --fold always --stats
        expect_text "$file, $device: is folded" '^folded: light and view' out
        same "$file, $device: the same picture" r.png f.png
    done
done
# Several lights that are the same in every pixel are folded into their sum: the same bits on every device.
many() { btf-render still.btf.exr --size 40 --quiet --mesh plane --fov 0 --view 20,0 "$@"; }
for way in "--light 20,100 --light 50,0 --light 70,-120" "--environment sky.exr --environment-lights 16" \
    "--light 20,100 --light 50,0 --plan auto --tolerance 3"; do
    many -o r.exr --device reference $way
    for device in reference osmesa; do
        expect "$device folds several: $way" 0 many -o f.exr --device $device --fold always --stats $way
        expect_text "$device: says so: $way" '^folded: [0-9]+ lights and view, [0-9]+ bytes' out
        same "$device: the same sum, $way" r.exr f.exr
    done
done
for way in "--light 20,100" "--light 20,100 --light 50,0 --cast-shadows" "--light 20,100 --point 0,0,2"; do
    expect "no sum: $way" 0 many -o f.exr --device reference --fold always --stats $way
    expect_that "which says so" test "$(grep -c 'lights' out)" = 1 # of the picture
done
# In a perspective as well, by a plan or on demand: the same bits on every device. Without either lights are added up one by one.
for way in "--light 20,100 --light 50,0 --light 70,-120 --fold always" "--environment sky.exr --environment-lights 16 --fold always" \
    "--light 20,100 --light 50,0 --size 400 --plan auto --tolerance 3" \
    "--light 20,100 --light 50,0 --fold always --animate view --frames 2"; do
    for device in reference osmesa; do
        expect "$device folds several under a view that varies: $way" 0 \
            many -o $device.exr --fov 30 --device $device --stats $way
        expect_text "$device: says so: $way" '^folded: [0-9]+ lights, [0-9]+ bytes' out
    done
    case $way in
    *frames*) same "the same second sum, $way" reference.0002.exr osmesa.0002.exr ;;
    *) same "the same sum, $way" reference.exr osmesa.exr ;;
    esac
done
expect "several lights without a plan" 0 many -o f.exr --fov 30 --size 400 --device osmesa --stats --light 20,100 --light 50,0
expect_text "are not added up beforehand" '^folded: nothing' out
expect "a fold that is none" 1 render -o x.png --fold often

# Plans: a restriction gives the same picture as its plan on the whole material; tolerance 0 leaves out nothing that
# shows.
for way in "--mesh plane --view 10,20 --light 15,40" "--mesh sphere" "--mesh plane --view 0,0 --animate view --frames 2"; do
    render -o whole.png --device reference $way
    expect "planned: $way" 0 render -o planned.png --device reference $way --plan auto --tolerance 0 --stats
    expect_text "says what: $way" '^  effects ' out
    if [ -e whole.png ]; then
        same "planned: the same picture, $way" whole.png planned.png
    else
        same "planned: the same second picture" whole.0002.png planned.0002.png
    fi
    rm -f whole*.png planned*.png
done
render -o r.png --device reference --mesh plane --plan auto --tolerance 30
render -o g.png --device osmesa --mesh plane --plan auto --tolerance 30
same "planned with less: the reference's picture" r.png g.png
# Directions that are the same in every pixel become constants of the shader, where the reference looks them up: the
# same pictures. --fold never, since the reference makes no fold textures, and a plan that may count on them can differ.
folds() { # NAME, WHAT THE PLAN SAYS (none: nothing), OPTIONS
    local name=$1 fixed=$2
    shift 2
    expect "folded: $name" 0 render -o g.png --device osmesa --plan auto --tolerance 3 --fold never --stats "$@"
    if [ "$fixed" = none ]; then
        expect_that "which folds nothing" test "$(grep -c ', fixed' out)" = 0
    else
        expect_text "which says so" "level 0, $fixed\$" out
    fi
    render -o r.png --device reference --plan auto --tolerance 3 "$@"
    same "and is the picture of the plan that looks up: $name" r.png g.png
    render -o g.png --device osmesa --plan auto --tolerance 0 "$@"
    render -o r.png --device reference --interpolation linear "$@"
    same "within 0 dB it is the whole's: $name" r.png g.png
}
folds "flat, parallel, one light" 'fixed view, fixed light' --mesh plane --fov 0 --view 30,50 --light 20,100
unless_light folds "flat, parallel, at a sample" 'fixed view, fixed light' --mesh plane --fov 0 --light 0,0
unless_light folds "flat, parallel, two lights" 'fixed view' --mesh plane --fov 0 --view 30,50 --light 20,100 --light 50,0
unless_light folds "flat, parallel, a point" 'fixed view' --mesh plane --fov 0 --view 30,50 --point 1,1,2
folds "flat, perspective" 'fixed light' --mesh plane --view 30,50 --light 20,100
folds "not flat" none --mesh torus --fov 0 --view 30,50 --light 20,100
unless_light folds "levels of a folded light" 'fixed light' --mesh plane --view 70,50 --light 20,100 --repeat 4
for turn in view light; do
    turn="--mesh plane --view 40,0 --light 30,20 --frames 4 --animate $turn --plan auto --tolerance 3"
    render -o g.png --device osmesa $turn --stats >out
    expect_text "a plan for each range of frames" '^plan for frames 1 to ' out
    render -o r.png --device reference $turn
    for frame in 0001 0002 0003 0004; do
        same "frame $frame of $turn" r.$frame.png g.$frame.png
    done
done
render -o g.png --device osmesa --fov 0 $turn --stats >out
unless_light expect_text "lights that turn are not folded, the view is" 'level 0, fixed view$' out # small data: each frame has a plan
expect "no plan for figure 13" 1 btf-render m.btf.exr -o x.png --figure13 --original data --plan auto
costs=$BTF_SOURCE_ROOT/tests/fuzz/corpus/costs
expect "a plan by prices of a device" 0 render -o x.png --device reference --plan auto --costs "$costs/llvmpipe.json"
expect "prices that are cut off" 3 render -o y.png --device reference --plan auto --costs "$costs/cut.json"
expect_text "are named" "cut.json" err
expect_that "and nothing is drawn" test ! -e y.png
expect "a plan that is none" 1 render -o x.png --plan all
finish
