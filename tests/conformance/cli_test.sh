#!/bin/bash
# Every option and exit code of btf-conform: BTF_CONFORM.
#
# SPDX-License-Identifier: MIT
set -u
conform=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
failures=0
unset DISPLAY WAYLAND_DISPLAY

# expect CODE WORDS ARGUMENTS...: the exit code, and words (a regular expression) in what is printed.
expect() {
    local code=$1 words=$2 got
    shift 2
    "$conform" "$@" >"$folder/out" 2>&1
    got=$?
    if [ $got -ne "$code" ] || ! grep -qE -- "$words" "$folder/out"; then
        echo "btf-conform $*: exit $got, expected $code and \"$words\" in:"
        head -20 "$folder/out"
        failures=$((failures + 1))
    fi
}

expect 0 '--vectors' --help
expect 0 'btf-conform' --version
expect 0 '^softpipe .*330 core' --list
expect 1 'vulkan' --device vulkan
expect 1 'count' --count minus
expect 1 'CASE:RENDERER:REASON' --waive all
for part in 0/6 7/6 1 1/6x 1/ /6; do
    expect 1 'K/N, with K from 1 to N' --part "$part"
done
expect 1 'not with --variant' --part 1/6 --variant 20
expect 1 'not with a FILE' --part 1/6 "$folder/absent.btf.exr"
expect 2 'absent' "$folder/absent.btf.exr"
echo "no EXR" >"$folder/bad.btf.exr"
expect 3 'bad' "$folder/bad.btf.exr"
expect 2 'nowhere' --vectors "$folder/nowhere"
expect 5 'not supported' --device glfw
if "$conform" --device osmesa --variant 20 --count 100 --steps 100 >"$folder/out" 2>&1; then
    expect 0 '^pass: [0-9]+ evaluations, 0 differ' --device osmesa --variant 20 --count 100 --steps 100
    expect 0 '"name": "steps 20: ' --device osmesa --part 21/40 --count 0 --steps 100 --json
    if ! grep -q '"name": "steps 60: ' "$folder/out" || ! grep -q '"name": "steps 100: ' "$folder/out" ||
        [ "$(grep -c '"name": "steps ' "$folder/out")" != 3 ]; then
        echo "--part 21/40 is not variants 20, 60 and 100: $(grep '"name": "steps ' "$folder/out")"
        failures=$((failures + 1))
    fi
    expect 0 'fast math 20: .*relative error' --device osmesa --variant 20 --count 100 --steps 100 --fast-math
    expect 0 '"verdict": "pass"' --device osmesa --variant 20 --count 100 --steps 100 --json
    expect 0 '"self_test": "none"' --device osmesa --variant 20 --count 100 --steps 100 --json --seed 9
    "$conform" --vectors "$folder" || failures=$((failures + 1))
    material=$(ls "$folder"/[0-9]*.btf.exr | head -1)
    expect 0 'minus 127' "$material" --device osmesa --count 100 --steps 100 --json
    # Without a difference, nothing is waived and no picture is written.
    expect 0 '^pass' "$material" --device osmesa --count 100 --steps 0 --dump "$folder" --waive 'radiance:llvm:a reason'
    if ls "$folder"/*.png >/dev/null 2>&1; then
        echo "pictures without a failure"
        failures=$((failures + 1))
    fi
    expect 7 'first in source' --sabotage --device osmesa --variant 20 --count 0 --steps 100 --dump "$folder"
    expect 7 '"verdict": "fail"' --sabotage --device osmesa --variant 20 --count 0 --steps 100 --json
    expect 0 'waived: known' --sabotage --device osmesa --variant 20 --count 0 --steps 100 --waive 'steps:llvmpipe:known'
    for picture in reference gpu mask; do
        if ! ls "$folder"/*-$picture.png >/dev/null 2>&1; then
            echo "no picture $picture"
            failures=$((failures + 1))
        fi
    done
fi
[ $failures -eq 0 ]
