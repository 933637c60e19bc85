#!/bin/sh
# The reference decoder gives the same bits from gcc and clang, without and with optimisation, on x86-64, i386
# (SSE2) and aarch64 (emulated): reference_hash.c is built each way, without a C library, and must print its
# pinned hash. A compiler or emulator that is missing is named, and its builds are left out; exit 77 when only one build could be run.
#
# Usage: reference_hash.sh [SOURCE_ROOT]
# SPDX-License-Identifier: MIT
set -u

root=${1:-${BTF_SOURCE_ROOT:-$(dirname "$0")/../..}}
build=$(mktemp -d) || exit 1
trap 'rm -rf "$build"' EXIT
sources="$root/tests/unit/reference/reference_hash.c $root/reference/btf_arithmetic.c $root/reference/btf_addressing.c
    $root/reference/btf_directions.c $root/reference/btf_evaluate.c $root/reference/btf_factors.c
    $root/reference/btf_gloss.c $root/reference/btf_relief.c $root/reference/btf_sampling.c $root/reference/btf_source.c
    $root/reference/btf_stochastic.c $root/reference/btf_self_test.c"
flags="-std=c11 -Wall -Wextra -Wpedantic -Werror -ffp-contract=off -DBTF_TEST_FREESTANDING -ffreestanding
    -fno-builtin -fno-stack-protector -fno-pic -static -nostdlib -I$root -I$root/reference/include"
passed=0
failed=0


# check NAME RUNNER COMPILER FLAG...
check() {
    name=$1
    runner=$2
    shift 2
    if ! command -v "$1" >/dev/null 2>&1; then
        echo "skip $name: no $1"
        return
    fi
    if [ -n "$runner" ] && ! command -v "$runner" >/dev/null 2>&1; then
        echo "skip $name: no $runner"
        return
    fi
    # shellcheck disable=SC2086
    if ! printf 'void _start(void);\nvoid _start(void) {\n}\n' |
        "$@" -ffreestanding -nostdlib -static -fno-pic -x c - -o "$build/probe" >/dev/null 2>&1; then
        echo "skip $name: $1 does not build for it"
        return
    fi
    # shellcheck disable=SC2086
    if ! "$@" $flags $sources -o "$build/hash"; then
        echo "FAIL $name: does not compile"
        failed=$((failed + 1))
        return
    fi
    hash=$($runner "$build/hash")
    status=$?
    if [ "$status" -eq 0 ]; then
        echo "ok   $name: $hash"
        passed=$((passed + 1))
    else
        echo "FAIL $name: $hash, exit $status (1: another hash, 3: depends on denormals, 4: refused by the self-test)"
        failed=$((failed + 1))
    fi
}

for level in -O0 -O3; do
    for compiler in gcc clang; do
        check "$compiler $level x86-64" "" "$compiler" -m64 "$level"
        check "$compiler $level i386" "" "$compiler" -m32 -msse2 -mfpmath=sse "$level"
    done
    check "gcc $level x86-64 with FMA" "" gcc -m64 -mfma "$level"
    check "clang $level aarch64" qemu-aarch64 clang --target=aarch64-linux-gnu -fuse-ld=lld "$level"
    check "gcc $level aarch64" qemu-aarch64 aarch64-linux-gnu-gcc "$level"
done

echo "$passed builds agree, $failed fail"
[ "$failed" -eq 0 ] || exit 1
[ "$passed" -ge 2 ] || exit 77
