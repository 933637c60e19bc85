#!/bin/bash
# Odd data sets through every tool: one texel, one direction, 256 lights, unequal lists, decimal angles, narrow images.
#
# SPDX-License-Identifier: MIT
. "$BTF_SOURCE_ROOT/tests/tools/common.sh" || exit 99

# odd NAME SAMPLE-OPTION...: sample, encode both ways, decode, compare; reports and pictures must be whole.
methods="paper joint"
odd() {
    local name=$1
    shift
    expect "$name: sample" 0 btf-sample -o "$name" --relief bumps --format exr --quiet "$@"
    expect "$name: paper" 0 btf-encode "$name" -o "$name.btf.exr" --method paper $starts --effects shadow,shift,hidden \
        --report "$name.json" --pictures "$name-p"
    expect_that "$name: no 'nan' in the tables" test -z "$(grep -iwE 'nan|-nan|inf' out)"
    expect_that "$name: the report's numbers are numbers" python3 - "$name.json" <<'P'
import json, sys
def walk(x):
    assert x is not None
    for y in x.values() if isinstance(x, dict) else x if isinstance(x, list) else []:
        walk(y)
r = json.load(open(sys.argv[1]))
walk(r["psnr"])
walk(r["effects"])
assert r["psnr"]["full"]["linear"] > 10
P
    local picture
    for picture in montage abrdf steps shadow flow hidden atlas; do
        expect_that "$name: picture $picture" test -s "$name-p/$picture.png"
    done
    expect "$name: info" 0 btf-info "$name.btf.exr"
    expect "$name: decode" 0 btf-decode "$name.btf.exr" -o "$name-d" --all --format exr --quiet
    expect "$name: compare" 0 btf-compare "$name-d" "$name.btf.exr" --json -q
    expect_text "$name: what was decoded is what the material holds" '"linear": (100|9[0-9]\.)' out
    expect "$name: the decoded set has the original's directions" 0 btf-compare "$name" "$name-d" --json -q
    [[ $methods == *joint* ]] || return 0
    expect "$name: joint" 0 btf-encode "$name" -o "$name-j.btf.exr" --preset fast --report "$name-j.json" -q
    expect_that "$name: joint is no worse than paper" python3 - "$name" <<'P'
import json, sys
psnr = [json.load(open(sys.argv[1] + end))["psnr"]["full"] for end in (".json", "-j.json")]
# no better than 45 dB is asked for, where 8-bit codes end
assert all(psnr[1][key] >= min(psnr[0][key] - 0.05, 45) for key in ("linear", "srgb")), psnr
P
}

odd texel --size 1 --directions 0:1,40:6
odd narrow --size 1x9 --directions 0:1,40:4
odd pair --size 6 --directions 0:1
long=307x14 ring=2 many=3x2
[ -n "$light" ] && long=307x7 ring=1 many=2x1
odd long --size $long --directions 0:1,40:$ring
odd top --size 8 --views 0:1 --lights ubo
odd unequal --size 3x5 --views 0:1,37.5:5:7.5 --lights 20:3,62.25:7
odd lights --size $many --views 0:1,50:2 --lights 256
[ -n "$light" ] && methods=paper # fitting so many directions takes most of the time, and was done once above
odd views --size $many --views 0:1,15:15,30:60,60:90,75:90 --lights 10:2

expect "joint: unequal lists" 0 btf-encode unequal -o joint.btf.exr --preset fast --pictures joint-p -q
finish
