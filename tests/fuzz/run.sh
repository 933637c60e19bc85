#!/bin/bash
# Fuzzes one target with libFuzzer under AddressSanitizer and UBSan, from its corpus; needs clang.
#
#   tests/fuzz/run.sh TARGET [SECONDS] [FOLDER]
#
# TARGET: material plan costs names options list mesh environment checkpoint jpeg png hdr exr archive bonn. SECONDS: by
# default $BTF_FUZZ_SECONDS, else 20, which is enough for obvious faults of new code; for a search, give hours. FOLDER
# (default build-fuzz) takes the build (meson setup -Dfuzzer=true) and the results: FOLDER/TARGET/found/ an input for
# each finding, FOLDER/TARGET/corpus/ the corpus that grows. The last lines state the number of executions, the coverage
# and the core time. Exits 1 on a finding.
#
# SPDX-License-Identifier: MIT
set -eu
cd "$(dirname "$0")/../.."
if [ $# -lt 1 ]; then
    sed -n '2,10s/^# \{0,1\}//p' tests/fuzz/run.sh >&2
    exit 1
fi
target=$1 seconds=${2:-${BTF_FUZZ_SECONDS:-20}} folder=${3:-build-fuzz}
case $target in # bytes of an input
material) most=16384 ;;
plan) most=512 ;;
mesh | options) most=1024 ;;
list | names) most=2048 ;;
costs | environment | checkpoint | jpeg | png | hdr | exr | archive | bonn) most=4096 ;;
*)
    echo "tests/fuzz/run.sh: unknown target '$target'" >&2
    exit 1
    ;;
esac
command -v clang >/dev/null && command -v clang++ >/dev/null || {
    echo "skipped: clang is not there"
    exit 77
}
mkdir -p "$folder/$target/corpus" "$folder/$target/found"
# All targets share one build; runs at the same time wait for each other here. With -O1 it takes six tenths of the time
# of -O2. No target runs the C++ code, which only calls Ceres, so it is not optimised.
(
    flock 9
    if [ ! -f "$folder/build.ninja" ]; then
        CC=clang CXX=clang++ meson setup "$folder" -Dfuzzer=true -Dtests=enabled -Dbuildtype=debugoptimized -Doptimization=1 \
            -Db_sanitize=address,undefined -Db_lundef=false -Dc_args=-g1 "-Dcpp_args=-O0 -g0 -fno-sanitize=all"
    fi
    ninja -C "$folder" "tests/fuzz/fuzz-$target"
) 9>"$folder/lock" >"$folder/$target/build.log" 2>&1 || {
    tail -30 "$folder/$target/build.log" >&2
    exit 1
}
program=$folder/tests/fuzz/fuzz-$target folder=$folder/$target
echo "OpenEXR $(pkg-config --modversion OpenEXR), $(clang --version | head -1)"
set +e
ASAN_OPTIONS=detect_leaks=1:allocator_may_return_null=1 UBSAN_OPTIONS=print_stacktrace=1 \
    bash -c 'time "$@"' - "$program" -max_total_time="$seconds" -max_len=$most -timeout=300 -rss_limit_mb=6000 \
    -malloc_limit_mb=5000 -close_fd_mask=3 -print_final_stats=1 -artifact_prefix="$folder/found/" \
    "$folder/corpus" "tests/fuzz/corpus/$target" >"$folder/log" 2>&1
code=$?
units=$(sed -n 's/^stat::number_of_executed_units: *//p' "$folder/log")
core=$(awk '/^(user|sys)/ { split($2, t, /[ms]/); s += 60 * t[1] + t[2] } END { printf "%.0f", s }' "$folder/log")
echo "TITLE | libFuzzer on each target, under AddressSanitizer and UBSan."
echo "CASE | $target: libFuzzer | nothing found | ${units:-no} runs in $seconds s, $core core s | $([ $code = 0 ] && echo pass || echo FAIL)"
grep -E '#[0-9]+.*(DONE|INITED)|^stat::|ERROR|SUMMARY|not so|^(real|user|sys)' "$folder/log" | tail -20
[ $code = 0 ]
