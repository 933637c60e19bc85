#!/usr/bin/env bash
# The published accuracy between the samples of BRICKS64, skipped without ../shared. With --long also that of materials
# that btf-encode makes of it.
#
# SPDX-License-Identifier: MIT
. "$(dirname "$0")/common.sh"
shared=${BTF_SHARED:-$BTF_SOURCE_ROOT/../shared}/data
data=$shared/BRICKS64.zip pairs=$shared/BRICKS64_between.zip
if [ ! -r "$data" ] || [ ! -r "$pairs" ]; then
    echo "skipped: needs $data and $pairs"
    exit 77
fi

# figures NAME LINEAR SRGB: the PSNR in the JSON of `out` must be these, to the two decimals that are published.
figures() {
    expect_that "$1: $2 / $3" python3 - "$2" "$3" <<'P'
import json, sys
r = json.load(open("out"))["between"]
print("%.3f / %.3f" % (r["linear"], r["srgb"]))
assert r["pairs"] == 200 and "%.2f" % r["linear"] == sys.argv[1] and "%.2f" % r["srgb"] == sys.argv[2]
P
}
# at_least NAME LINEAR SRGB: the PSNR must be at least these, since later encoders may do better.
at_least() {
    expect_that "$1: at least $2 / $3" python3 - "$2" "$3" <<'P'
import json, sys
r = json.load(open("out"))["between"]
print("%.3f / %.3f" % (r["linear"], r["srgb"]))
assert r["pairs"] == 200 and r["linear"] >= float(sys.argv[1]) and r["srgb"] >= float(sys.argv[2])
P
}
if [ "${1:-}" != --long ]; then
    expect "uncompressed" 0 btf-compare "$data" "$pairs" --no-ssim --json -q
    figures barycentric 26.36 24.78
    expect "splines" 0 btf-compare "$data" "$pairs" --interpolation spline --no-ssim --json -q
    figures "thin-plate splines" 27.78 26.36
else
    # The preset fast takes a tenth of the core time. Its codes are coarser; relief, gloss and nodes are those of the
    # default.
    expect "encode" 0 btf-encode "$data" -o m.btf.exr --preset fast --relief auto --gloss auto -q
    expect "the material" 0 btf-compare m.btf.exr "$pairs" --no-ssim --json -q
    at_least "joint, fast" 27.9 26.6
    expect "encode without relief and gloss" 0 btf-encode "$data" -o n.btf.exr --preset fast -q
    expect "that material" 0 btf-compare n.btf.exr "$pairs" --no-ssim --json -q
    at_least "joint, fitted nodes alone" 26.6 25.65
fi
finish
