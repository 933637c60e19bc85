#!/bin/bash
# ThreadSanitizer over the encoder's OpenMP stages: clang with libomp, whose tool libarcher tells the sanitizer of
# OpenMP's own synchronisation (with libgomp every barrier looks like a race).
#
#   tests/tsan.sh [FOLDER]     FOLDER (default build-tsan) takes the build
#
# Both methods encode tiny data with 4 threads, with various options, layouts and levels of detail, and a BTF is
# sampled, decoded, compared and rendered by the reference. Then the sanitizer has to report a loop with a race, which
# shows that it works. Exits 0, 1 on a race, 77 (with the reason) without clang or libomp.
#
# SPDX-License-Identifier: MIT
set -eu
cd "$(dirname "$0")/.."
folder=${1:-build-tsan}
skip() {
    echo "skipped: $1"
    exit 77
}
command -v clang >/dev/null && command -v clang++ >/dev/null || skip "clang is not there"
archer=$(readlink -f "$(clang -print-resource-dir)/../../libarcher.so")
[ -f "$archer" ] || skip "libarcher.so is not there (package libomp-dev)"
mkdir -p "$folder"
# Neither Ceres nor the C++ that calls it is instrumented: with its Eigen templates it would take a third of the build.
if [ ! -f "$folder/build.ninja" ]; then
    CC=clang CXX=clang++ meson setup "$folder" -Dbuildtype=debugoptimized -Doptimization=1 -Db_sanitize=thread \
        -Db_lundef=false -Dc_args=-g1 "-Dcpp_args=-g0 -fno-sanitize=all" >"$folder/setup.log" 2>&1 || {
        cat "$folder/setup.log"
        exit 1
    }
fi
ninja -C "$folder" encoder/btf-encode encoder/btf-compare decoder/tools/btf-decode decoder/tools/render/btf-render \
    tests/sample/btf-sample >"$folder/ninja.log" 2>&1 || {
    tail -30 "$folder/ninja.log"
    exit 1
}
export OMP_TOOL_LIBRARIES=$archer TSAN_OPTIONS="ignore_noninstrumented_modules=1 exitcode=66 history_size=5"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
tools=$(cd "$folder" && pwd)
failures=0
echo "TITLE | ThreadSanitizer over the parallel stages, 4 threads."

# watched NAME COMMAND...: the command must succeed, and the sanitizer must report nothing.
watched() {
    local name=$1 code=0
    shift
    "$@" >"$work/out" 2>"$work/err" || code=$?
    if [ $code = 0 ] && ! grep -q "WARNING: ThreadSanitizer" "$work/err"; then
        echo "[ RUN      ] $name"
        echo "[       OK ] $name"
        echo "CASE | $name | no race | silent | pass"
    else
        echo "CASE | $name | no race | exit code $code | FAIL"
        echo "[ RUN      ] $name"
        head -60 "$work/err"
        echo "[  FAILED  ] $name"
        failures=$((failures + 1))
    fi
}

encode() { "$tools/encoder/btf-encode" "$work/data" -o "$work/x.btf.exr" --threads 4 -q "$@"; }
watched "sample" "$tools/tests/sample/btf-sample" -o "$work/data" --relief bricks --size 12 --directions 0:1,45:5 --quiet
watched "paper" encode --method paper
least=$(encode --method paper --memory 1 2>&1 | grep -o 'at least [0-9]*K' | grep -o '[0-9]*K') # so little that samples lie in a scratch file
watched "paper, scratch file, pictures, report" encode --method paper --memory "$least" --pictures "$work/p" --report "$work/r.json"
watched "joint" encode
watched "joint, levels" encode --preset fast --levels all
watched "decode" "$tools/decoder/tools/btf-decode" "$work/x.btf.exr" -o "$work/decoded" --all
watched "render" "$tools/decoder/tools/render/btf-render" "$work/x.btf.exr" -o "$work/r.png" --device reference --size 40 --threads 4
watched "compare" "$tools/encoder/btf-compare" "$work/data" "$work/x.btf.exr"

# a parallel loop that sums up without a reduction
cat >"$work/race.c" <<'C'
#include <stdio.h>
int main(void) {
    static double sum;
#pragma omp parallel for num_threads(4)
    for (int i = 0; i < 100000; i++)
        sum += i;
    printf("%g\n", sum);
    return 0;
}
C
clang -fopenmp -fsanitize=thread -g -O1 "$work/race.c" -o "$work/race"
code=0
"$work/race" >"$work/out" 2>"$work/err" || code=$?
echo "[ RUN      ] a race is seen"
if grep -q "WARNING: ThreadSanitizer: data race" "$work/err"; then
    echo "[       OK ] a race is seen"
    echo "CASE | a loop with a race in it | it is reported | as expected | pass"
else
    echo "CASE | a loop with a race in it | it is reported | exit code $code | FAIL"
    echo "exit code $code"
    echo "[  FAILED  ] a race is seen"
    failures=$((failures + 1))
fi
exit $((failures > 0))
