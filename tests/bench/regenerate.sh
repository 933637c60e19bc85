#!/bin/bash
# Makes the pictures, plots and measured tables of the documents anew from a build, part by part.
#
#   tests/bench/regenerate.sh BUILD [--work DIR] [PART...]   default: every part, work in BUILD/regenerate
#   tests/bench/regenerate.sh --list                         the parts and what each writes; tests/docs.py compares it with
#                                                            the documents
#
# Tools of BUILD are brought up to date first. A part that ends leaves a stamp with the commit in DIR, and is passed over
# while the sources stand at that commit: after a stop, the same command goes on. btf-bench goes on within a part, and
# encodes that ended are kept. tests/data/readme/made.txt says of each name which commit it was made from.
#
# Parts that time (bench, growth, plan, codecs, presets, shaders, stochastic, pathtrace; viewer shows a time) want an idle
# machine. bench, storage, growth, relief, codecs and presets take up to some 10 core minutes each, plan longer, peers and
# first are slow, bake takes more than an hour, the others take a few minutes. first needs BTF_V1_ENCODE, the btf-encode of
# version 1 (commit 90311cd), and is passed over without.
# Samples of others are looked for in $BTF_SHARED/data (default ../shared/data), and what needs them is left as it is
# where they are not there. Experiments (encoder/nodes/FIT.md, tables without marks of encoder/relief/RELIEF.md, FORMAT.md
# section 12) are not written by any part: they say which build they come from.
#
# SPDX-License-Identifier: MIT
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
pictures=$root/tests/data/readme
shared=${BTF_SHARED:-$root/../shared}/data

# Part, then what it writes: pictures of tests/data/readme, FILE#NAME for what stands between the marks NAME of a page,
# and pages that are made as a whole.
writes='api      decoder/API.md
example  decoder/FORMAT.md#example
languages shaders/README.md#languages
levels   decoder/README.md#levels levels-off.png levels-on.png
viewer   viewer.png
web      decoder/web/README.md#pages web-viewer.png web-gallery.png
between  README.md#headline between.png
relief   encoder/relief/RELIEF.md#alone
demo     hero.png montage.png figure13.png
planned  planned.png
fit      fit.png
bench    tests/bench/README.md#bench encode.png decode.png
storage  tests/bench/README.md#between storage.png
growth   encoder/README.md#growth growth-texels.png growth-directions.png
plan     tests/bench/README.md#plan
codecs   README.md#results tests/bench/README.md#codecs
presets  tests/bench/README.md#presets
shaders  tests/bench/README.md#shaders
peers    tests/bench/README.md#peers
first    tests/bench/README.md#first
stochastic tests/bench/README.md#stochastic stochastic.png
pathtrace pathtrace.png
bake     encoder/bake/SCENES.md#scenes bake-knit.png bake-gravel.png bake-scales.png bake-knit-sphere.png bake-gravel-sphere.png bake-scales-sphere.png'

if [ "${1:-}" = --list ]; then
    echo "$writes"
    exit
fi
if [ "${1:--h}" = -h ] || [ "$1" = --help ]; then
    sed -n '2,/^$/s/^# \{0,1\}//p' "$0" | sed '/^SPDX/,$d'
    exit
fi
build=$(cd "$1" && pwd)
shift
work=$build/regenerate
if [ "${1:-}" = --work ]; then
    mkdir -p "${2:?expected a folder after --work}"
    work=$(cd "$2" && pwd)
    shift 2
fi
mkdir -p "$work"
parts=$(echo "$writes" | sed 's/ .*//')
for part in "$@"; do
    grep -qx -- "$part" <<<"$parts" || {
        echo "regenerate.sh: no part $part; parts are:" $parts >&2
        exit 1
    }
done
[ $# -gt 0 ] || set -- $parts

# shellcheck source=tests/bench/commit.sh
. "$root/tests/bench/commit.sh"
note() { # NAME: a line of made.txt
    local list=$pictures/made.txt
    grep -v "^$1 " "$list" >"$list.new" || true
    echo "$1 $(commit) $(date -u +%Y-%m-%d)" >>"$list.new"
    LC_ALL=C sort -o "$list" "$list.new"
    rm "$list.new"
}
PATH=$build/encoder:$build/decoder/examples:$build/decoder/tools:$build/decoder/tools/render:$build/decoder/tools/view:$build/tests/sample:$build/tests/bench:$PATH
export OMP_WAIT_POLICY=passive
sample() { # KIND SIZE: a data set of btf-sample, made once; prints its folder
    local at=$work/$1-$2-$(commit)
    if [ ! -d "$at" ]; then
        rm -rf "$at.part"
        btf-sample -o "$at.part" --relief "$1" --size "$2" --quiet
        mv "$at.part" "$at"
    fi
    echo "$at"
}
encoded() { # NAME INPUT OPTION...: a material and its report, made once a commit; prints the material
    local name=$1-$(commit)
    shift
    [ -f "$work/$name.btf.exr" ] || btf-encode "$@" -o "$work/$name.btf.exr" --report "$work/$name.json" -q >&2
    echo "$work/$name.btf.exr"
}
needs() { # FILE...: of the samples of others; false, with a line, where one is missing
    local file
    for file in "$@"; do
        if [ ! -e "$shared/$file" ]; then
            echo "$part: left as it is, $shared/$file is missing"
            passed_over=1
            return 1
        fi
    done
}

part_api() { python3 "$root/tests/api.py" "$root" --write; }
part_example() { "$root/tests/unit/decoder/example.py" "$build/tests/unit/example_file" "$root/decoder/FORMAT.md" --write; }
part_languages() {
    {
        echo '<!-- languages: written by tests/bench/regenerate.sh -->'
        BTF_SOURCE_ROOT=$root BTF_BUILD_ROOT=$build "$root/tests/conformance/shader/test_shader.sh" --table
        echo '<!-- /languages -->'
    } | "$root/tests/bench/marks.py" "$root/shaders/README.md" languages
}
part_levels() {
    "$pictures/make.sh" "$build" "$work/levels-$(commit)" levels
    btf-info --json "$work/levels-$(commit)/bricks.btf.exr" >"$work/levels.json"
    python3 - "$work/levels.json" <<'P' | "$root/tests/bench/marks.py" "$root/decoder/README.md" levels
import json, sys
with open(sys.argv[1]) as file:
    info = json.load(file)
own = ("sbrdf", "shadow", "shift", "gain", "points", "point_lists", "point_indices", "residual_texels", "factor_texels", "heights")
shared = sum(t["bytes"] for name, t in info["textures"].items() if name not in own and not t["table"])
print("<!-- levels: written by tests/bench/regenerate.sh -->\n| level | texels | bytes on the GPU | "
      "PSNR in dB against the filtered original, linear / sRGB |\n| --- | --- | --- | --- |")
for i, level in enumerate(info["levels"]):
    note = f" ({shared:,} of them shared)" if i == 0 else ""
    print(f'| {i} | {level["width"]} x {level["height"]} | {level["gpu"]:,}{note} | '
          f'{level["linear"]:.2f} / {level["srgb"]:.2f} |')
print("<!-- /levels -->")
P
}
part_web() {
    if [ ! -f "$build/decoder/web/viewer/viewer.html" ]; then
        echo "web: left as it is, BUILD was set up without -Dweb=true"
        passed_over=1
        return 0
    fi
    "$root/decoder/web/sizes.py" --pages "$build"/decoder/web/viewer/{viewer,gallery}.html |
        "$root/tests/bench/marks.py" "$root/decoder/web/README.md" pages
    node "$root/tests/web/viewer/pictures.mjs" "$build"/decoder/web/viewer/{viewer,gallery}.html "$pictures"
}
part_viewer() { "$pictures/make.sh" "$build" "$work/levels-$(commit)" viewer; }
part_between() { # of BRICKS64 where it is there, else of the built-in sample
    if [ -z "${BTF_V1:-}" ]; then
        echo "between: left as it is: BTF_V1 names no material of version 1, the second row of the picture"
        passed_over=1
        return 0
    fi
    local caption=$work/headline-$(commit).md
    if [ -e "$shared/BRICKS64.zip" ] && [ -e "$shared/BRICKS64_between.zip" ]; then
        export BTF_DATA=$shared/BRICKS64.zip BTF_PAIRS=$shared/BRICKS64_between.zip
    fi
    "$pictures/between.sh" "$build" "$work/between-$(commit)" >"$caption"
    {
        printf '<!-- headline: written by tests/bench/regenerate.sh -->\n![Between the samples: %s](%s)\n\n' \
            'truth, version 1, now, four times the errors of both' tests/data/readme/between.png
        cat "$caption"
        echo '<!-- /headline -->'
    } | "$root/tests/bench/marks.py" "$root/README.md" headline
}
part_relief() {
    needs BRICKS64.zip BRICKS64_between.zip || return 0
    local kind data pairs budget relief filter effects name one
    local at=$work/relief-$(commit)
    mkdir -p "$at"
    for kind in BRICKS64 bumps; do
        if [ $kind = BRICKS64 ]; then
            data=$shared/BRICKS64.zip pairs=$shared/BRICKS64_between.zip
        else
            data=$(sample bumps 64) pairs=$work/bumps-between-$(commit)
            [ -d "$pairs" ] || {
                btf-sample -o "$pairs.part" --relief bumps --between 100 --quiet
                mv "$pairs.part" "$pairs"
            }
        fi
        [ -s "$at/$kind-images.json" ] || btf-compare "$data" "$pairs" --pairs --no-ssim --json -q >"$at/$kind-images.json"
        for budget in 2.36MB 8MB; do
            for relief in off auto; do
                name=$kind-$budget-$relief
                encoded "relief-$name" "$data" --preset fast --effect-tolerance 0 --budget $budget --relief $relief \
                    --gloss auto >/dev/null
                cp "$work/relief-$name-$(commit).json" "$at/$name.json"
                for filter in texel bilinear steep; do
                    [ $relief = auto ] || [ $filter = texel ] || continue # without relief all filters are one
                    # Gloss changes none of the other textures: decoding without it is the same as a file encoded without.
                    for effects in residual,relief residual,relief,gloss; do
                        one=$at/$name-$filter-${effects##*,}.json
                        [ -s "$one" ] || btf-compare "$work/relief-$name-$(commit).btf.exr" "$pairs" --pairs --no-ssim \
                            --json --filter $filter --effects $effects -q >"$one"
                    done
                done
            done
        done
    done
    "$root/tests/bench/relief_table.py" "$at" | "$root/tests/bench/marks.py" "$root/encoder/relief/RELIEF.md" alone
}
part_demo() {
    local data material paper
    data=$(sample bricks 64)
    material=$(encoded bricks "$data" --pictures "$work/bricks-pictures" --budget 2.36MB)
    paper=$(encoded bricks-paper "$data" --method paper)
    cp "$work/bricks-pictures/montage.png" "$pictures/montage.png"
    btf-render "$material" -o "$pictures/hero.png" --mesh torus --size 640x400 --samples 3 --repeat 4 --view 50,40 \
        --zoom 0.95 --light 40,90 --cast-shadows --background 0.9 --quiet
    btf-render "$material" -o "$pictures/figure13.png" --figure13 --original "$data" --baseline "$paper" --mesh plane \
        --view 40,-90 --repeat 2 --size 256 --quiet
}
part_planned() {
    needs BRICKS64.zip UBO_IMPALLA64.zip || return 0
    "$pictures/planned.sh" "$build" "$(encoded BRICKS64-levels "$shared/BRICKS64.zip" --levels 4)" \
        "$(encoded UBO_IMPALLA64-levels "$shared/UBO_IMPALLA64.zip" --levels 4)"
}
part_fit() {
    needs BRICKS64.zip UBO_IMPALLA64.zip || return 0
    local kind reports=() # of factors: a reflectance alone, which flat takes else, has no fit
    for kind in BRICKS64 UBO_IMPALLA64; do
        encoded "fit-$kind" "$shared/$kind.zip" --preset fast --effects residual --budget 2.36MB --effect-tolerance 0 >/dev/null
        reports+=("$work/fit-$kind-$(commit).json")
    done
    for kind in bricks bumps weave flat; do
        encoded "fit-$kind" "$(sample $kind 64)" --preset fast --effects residual --budget 2.36MB --effect-tolerance 0 >/dev/null
        reports+=("$work/fit-$kind-$(commit).json")
    done
    "$root/tests/bench/fit_curve.py" "${reports[@]}"
}
part_bench() {
    # Bumps take relief, which bricks of 32x32 texels do not.
    btf-bench --only machine,encode,decode --quick --materials bumps --out "$work/bench-$(commit)"
    "$root/tests/bench/readme.sh" --from "$work/bench-$(commit)"
}
part_storage() {
    needs BRICKS64.zip BRICKS64_between.zip || return 0
    local at=$work/storage-$(commit)
    mkdir -p "$at"
    btf-bench --only between --quick --size 64x64 --input "$shared/BRICKS64.zip" \
        --pairs "$shared/BRICKS64_between.zip" --out "$at/BRICKS64"
    btf-bench --only between,storage --quick --materials bricks --out "$at/bricks"
    btf-bench --only between --quick --materials bumps,weave,flat --out "$at/others"
    "$root/tests/bench/readme.sh" --between "$at"/{BRICKS64,bricks,others}
}
part_growth() {
    btf-bench --only growth --repeats 1 --size 64x64 --out "$work/growth-$(commit)"
    local over
    for over in texels directions; do
        cp "$work/growth-$(commit)/growth-$over-bricks.png" "$pictures/growth-$over.png"
    done
    "$root/tests/bench/readme.sh" --growth "$work/growth-$(commit)"
}
part_plan() {
    needs BRICKS64.zip BRICKS64_between.zip UBO_IMPALLA64.zip || return 0
    local kind kept
    kept=$work/plan-files-$(commit)
    mkdir -p "$kept"
    for kind in BRICKS64 UBO_IMPALLA64; do
        cp "$(encoded $kind-levels "$shared/$kind.zip" --levels 4)" "$kept/$kind-joint-medium.btf.exr"
    done
    btf-bench --only plan --preset medium --methods joint --input "$shared/BRICKS64.zip" --pairs "$shared/BRICKS64_between.zip" \
        --input "$shared/UBO_IMPALLA64.zip" --out "$work/plan-$(commit)" --keep "$kept"
    "$root/tests/bench/readme.sh" --plan "$work/plan-$(commit)"
}
tabled() { # NAME PAGE ARGUMENT...: the table NAME of tables.py, between its marks of a page
    local name=$1 page=$2
    shift 2
    "$root/tests/bench/tables.py" "$name" "$@" | "$root/tests/bench/marks.py" "$root/$page" "$name"
}
part_codecs() {
    needs BRICKS64.zip UBO_IMPALLA64.zip || return 0
    local at=$work/codecs-$(commit) kind
    mkdir -p "$at"
    for kind in BRICKS64 UBO_IMPALLA64 bricks bumps; do
        case $kind in
        b*) set -- --materials $kind --size 64x64 ;;
        *) set -- --input "$shared/$kind.zip" ;;
        esac
        [ -s "$at/$kind/codecs-$kind.csv" ] || btf-bench --only codecs --preset medium "$@" --out "$at/$kind"
    done
    tabled results README.md "$at"/*
    tabled codecs tests/bench/README.md "$at"/*
}
part_presets() {
    needs BRICKS64.zip UBO_IMPALLA64.zip || return 0
    local at=$work/presets-$(commit) kind effects preset data
    mkdir -p "$at"
    for kind in BRICKS64-all BRICKS64-residual UBO_IMPALLA64-all bricks-residual; do
        effects=${kind#*-} data=$shared/${kind%-*}.zip
        [ $kind != bricks-residual ] || data=$(sample bricks 64)
        for preset in fast medium thorough exhaustive; do
            set -- --preset $preset --budget 2.36MB --effect-tolerance 0 --fit samples --relief off --gloss off
            [ $effects = all ] || set -- "$@" --effects $effects
            encoded "preset-$kind-$preset" "$data" "$@" >/dev/null
            cp "$work/preset-$kind-$preset-$(commit).json" "$at/$kind-$preset.json"
        done
    done
    tabled presets tests/bench/README.md "$at"
}
part_shaders() {
    local at
    at=$work/shaders-$(commit)
    btf-bench --only shaders --materials bricks --size 4x4 --out "$at"
    tabled shaders tests/bench/README.md "$at"
}
part_peers() {
    needs UBO_IMPALLA64.zip || return 0
    "$root/tests/bench/peers.sh" "$build" --work "$work/peers" peers UBO_IMPALLA64 {flat,white,axes}-32 \
        {bumps,weave}-seed-32 {bumps,flat}-noise-32 {bricks,bumps}-dark-32 {weave,flat}-bright-32 bumps-24x40 bricks-96x10 \
        bricks-151x12 bumps-12x151 >"$work/peers.md"
    tabled peers tests/bench/README.md "$work/peers.md"
}
part_first() {
    if [ -z "${BTF_V1_ENCODE:-}" ]; then
        echo "first: left as it is: BTF_V1_ENCODE names no btf-encode of version 1"
        passed_over=1
        return 0
    fi
    needs BRICKS64.zip || return 0
    "$root/tests/bench/peers.sh" "$build" --work "$work/peers" v1 "$BTF_V1_ENCODE" BRICKS64 \
        {bricks,bumps,weave,flat,white,axes}-32 >"$work/first.md"
    tabled first tests/bench/README.md "$work/first.md"
}
part_stochastic() {
    needs BRICKS64.zip BRICKS64_between.zip UBO_IMPALLA64.zip || return 0
    local at=$work/stochastic-$(commit)
    mkdir -p "$at"
    btf-bench --only stochastic --preset fast --input "$shared/BRICKS64.zip" --pairs "$shared/BRICKS64_between.zip" \
        --device osmesa --out "$at/BRICKS64" --keep "$at"
    btf-bench --only stochastic --preset medium --input "$shared/UBO_IMPALLA64.zip" --device osmesa --out "$at/IMPALLA" --keep "$at"
    btf-bench --only stochastic --preset fast --quick --materials bumps,bricks --size 32x32 --device osmesa --out "$at/small"
    cp "$at/BRICKS64/stochastic-BRICKS64.png" "$pictures/stochastic.png"
    tabled stochastic tests/bench/README.md "$at"/{BRICKS64,IMPALLA,small}
}
part_pathtrace() {
    needs BRICKS64.zip || return 0
    pathtrace "$(encoded BRICKS64-fast "$shared/BRICKS64.zip" --preset fast)" "$pictures/pathtrace.png" compare 1
}
part_bake() { # BTF_BAKE_OPTIONS as of bake.sh
    if ! command -v blender >/dev/null; then
        echo "bake: left as it is, there is no blender"
        passed_over=1
        return 0
    fi
    "$pictures/bake.sh" "$build" "$work/bake-$(commit)" >"$work/bake.md"
    "$root/tests/bench/marks.py" "$root/encoder/bake/SCENES.md" scenes <"$work/bake.md"
}

targets_of() { # a part: its programs
    case $1 in
    api) ;;
    example) echo tests/unit/example_file ;;
    languages) echo decoder/tools/shader/btf-shader tests/conformance/shader/run_shader ;;
    levels) echo encoder/btf-encode decoder/tools/{btf-info,render/btf-render} tests/sample/btf-sample ;;
    web) grep -q '^build decoder/web/viewer/viewer.html' "$build/build.ninja" && echo decoder/web/viewer/{viewer,gallery}.html ;;
    viewer) echo encoder/btf-encode decoder/tools/view/btf-view tests/sample/btf-sample ;;
    pathtrace) echo encoder/btf-encode decoder/examples/pathtrace ;;
    relief) echo encoder/btf-{encode,compare} tests/sample/btf-sample ;;
    between) echo encoder/btf-{encode,compare} decoder/tools/btf-info tests/sample/btf-sample ;;
    plan) echo encoder/btf-encode tests/bench/btf-bench ;;
    bake) echo encoder/btf-encode decoder/tools/render/btf-render ;;
    peers | first) ;; # peers.sh builds what it needs
    presets) echo encoder/btf-encode tests/sample/btf-sample ;;
    bench | storage | growth | codecs | shaders | stochastic) echo tests/bench/btf-bench ;;
    *) echo encoder/btf-encode decoder/tools/{btf-decode,render/btf-render} tests/sample/btf-sample ;;
    esac
}
targets=$(for part in "$@"; do targets_of "$part" || true; done | tr ' ' '\n' | sort -u)
[ -z "$targets" ] || ninja -C "$build" $targets >"$work/ninja.log" || {
    tail -20 "$work/ninja.log" >&2
    exit 1
}
for part in "$@"; do
    stamp=$work/$part.stamp now=$(commit)
    if [ -f "$stamp" ] && [ "$(cat "$stamp")" = "$now" ]; then
        echo "$part: made from $now already"
        continue
    fi
    echo "$part: from $now"
    passed_over=
    "part_$part"
    [ -z "$passed_over" ] || continue
    for name in $(sed -n "s/^$part  *//p" <<<"$writes"); do
        note "$name"
    done
    echo "$now" >"$stamp"
done
