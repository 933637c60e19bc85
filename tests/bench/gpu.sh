#!/bin/bash
# Checks and times decoding on this machine's GPU in about 5 minutes: conformance of a third of the variants, decoding of
# both versions of the format beside their fetches alone and the peers, and the prices of the cost model of plans, fitted
# to the device: btf-info, btf-render and btf-view --costs take them.
#
#   tests/bench/gpu.sh [BUILD [DEVICE [INPUT [btf-conform option...]]]]    default: build egl, btf-sample bricks 64x64
#
# DEVICE is one of btf-conform --list. Writes BUILD/bench-gpu/conform.txt, decode-*.csv, costs-*.csv, costs.json and
# summary.md, into OUT instead where that is set; with QUICK set, of data cut to 32x32 texels and in fewer ways. Exit code:
# that of conformance where it fails, else of btf-bench; 5 without the device.
#
# SPDX-License-Identifier: MIT
set -uo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$root/build} device=${2:-egl} input=${3:-}
[ $# -le 3 ] || conform=("${@:4}")
[ $# -gt 3 ] || conform=(--part 1/3 --count 2000 --steps 2000)
out=${OUT:-$build/bench-gpu}
mkdir -p "$out" || exit 2
"$build/tests/conformance/btf-conform" --device "$device" "${conform[@]}" --quiet | tee "$out/conform.txt"
conformance=$?
[ $conformance != 5 ] || exit 5
side=64
[ -z "${QUICK:-}" ] || side=32
data=(--materials bricks --size ${side}x$side)
[ -z "$input" ] || data=(--input "$input")
"$build/tests/bench/btf-bench" "${data[@]}" --only decode,costs --device "$device" --methods joint,paper,peers \
    ${QUICK:+--quick} --out "$out" --quiet >"$out/bench.txt"
measured=$?
sed -n '/^### Format 2/,$p' "$out/bench.txt" | sed '/^### Growth/,/^## costs/d'
[ $conformance = 0 ] || exit $conformance
exit $measured
