#!/bin/bash
# btf-encode --checkpoint, killed 20 times for each method, at random calls that change files, and resumed each time: it
# gives the same bytes.
#
#   test_kills.sh [COUNT [SEED]]     SEED: selects the calls; drawn and printed where it is not given
#
# SPDX-License-Identifier: MIT
count=${1:-20} seed=${2:-$RANDOM}
. "$BTF_SOURCE_ROOT/tests/tools/common.sh" || exit 99
echo "seed $seed"
RANDOM=$seed
small_data

for method in joint paper; do
    expect "$method, uninterrupted" 0 btf-encode data -o whole.btf.exr --method $method -q
    expect "$method with a checkpoint" 0 btf-encode data -o kept.btf.exr --method $method -q --checkpoint steps
    span=$(calls btf-encode data -o kept.btf.exr --method $method -q --checkpoint steps) same=0 cut=0 halves=0
    for ((i = 0; i < count; i++)); do
        rm -rf steps cut.btf.exr
        at "$((1 + RANDOM % span)) call" KILL btf-encode data -o cut.btf.exr --method $method -q --checkpoint steps >/dev/null 2>&1
        [ ! -e cut.btf.exr ] && cut=$((cut + 1))
        if [ ! -e cut.btf.exr ] || [ -e steps ]; then # not finished, or killed while it removed the steps
            btf-encode data -o cut.btf.exr --method $method -q --checkpoint steps --resume
        fi
        cmp -s whole.btf.exr cut.btf.exr && same=$((same + 1))
        [ -e steps ] && halves=$((halves + 1))
    done
    expect_that "$method: $cut of $count killed before their end" test $cut -gt 0
    expect_that "$method: the same bytes $same times of $count" test $same = $count
    expect_that "$method: no checkpoint is left" test $halves = 0
done
finish
