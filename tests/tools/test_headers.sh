#!/bin/bash
# Each public header compiles by itself, without a warning, in every C and C++ standard that users have.
#
# SPDX-License-Identifier: MIT
. "$(dirname "$0")/common.sh"
root=$BTF_SOURCE_ROOT
flags="-Wall -Wextra -pedantic -Werror -fsyntax-only -I$root/decoder/include -I$root/reference/include -I$root/encoder/library/include"

# each_header COMPILER LANGUAGE STANDARD: compiles every header alone, included twice, with a use of each of its
# constants, since compilers do not check a macro that is not used.
each_header() {
    local header
    for header in "$root"/{decoder,reference,encoder/library}/include/openbtf/*.h; do
        {
            printf '#include <openbtf/%s>\n' "$(basename "$header")" "$(basename "$header")"
            echo 'int openbtf_here;'
            sed -n 's/^#define \(BTF_[A-Z0-9_]*\) .*/int use_\1[sizeof(\1)];/p' "$header"
        } >each.txt
        # shellcheck disable=SC2086
        "$1" -x "$2" "-std=$3" $flags each.txt || return 1
    done
}

for compiler in gcc clang; do
    command -v $compiler >/dev/null || { echo "no $compiler: its checks are left out" && continue; }
    for standard in c99 c11 c17; do
        expect_that "$compiler $standard" each_header $compiler c $standard
    done
    for standard in c++11 c++14 c++17 c++20 c++2b; do
        expect_that "$compiler $standard" each_header $compiler c++ $standard
    done
done

# Decimal constants equal the powers of two that they stand for.
exact() {
    printf '#include <openbtf/material.h>\nstatic_assert(BTF_GAIN_SCALE == 0x1p-7f, "");\n' |
        g++ -x c++ -std=c++17 -I"$root/decoder/include" -fsyntax-only -
}
expect_that 'BTF_GAIN_SCALE is 2^-7' exact

# The name that the reference's header had first.
old_name() {
    printf '#include <btf_reference.h>\nint mono = BTF_REF_MONO;\n' |
        gcc -x c -std=c11 -fsyntax-only -I"$root/reference/include" -I"$root/reference/compat" -
}
expect_that 'btf_reference.h' old_name
finish
