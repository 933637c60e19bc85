#!/bin/bash
# btf-encode --checkpoint and --resume: killed at random moments, an encode that goes on gives the same bytes.
#
# SPDX-License-Identifier: MIT
. "$BTF_SOURCE_ROOT/tests/tools/common.sh" || exit 99
small_data ${light:+--size 8}
RANDOM=20 # the same moments every time, as far as the machine is
moments=${light:+2} moments=${moments:-6} last_step=${light:+2} last_step=${last_step:-4}

expect "--resume alone is refused" 1 btf-encode data -o x.btf.exr --resume
expect_text "it says what is missing" "--checkpoint" err

for method in paper joint; do
    expect "$method, uninterrupted" 0 btf-encode data -o whole.btf.exr --method $method -q
    begin=$(date +%s%N)
    expect "$method with a checkpoint" 0 btf-encode data -o kept.btf.exr --method $method -q --checkpoint steps
    span=$((($(date +%s%N) - begin) / 1000))
    expect_that "$method: the same bytes" cmp whole.btf.exr kept.btf.exr
    expect_that "$method: the checkpoint is gone" test ! -e steps

    same=0
    for i in $(seq $moments); do
        rm -rf steps cut.btf.exr
        micro=$((RANDOM * span / 32768))
        timeout -s KILL "$(printf '%d.%06d' $((micro / 1000000)) $((micro % 1000000)))" \
            btf-encode data -o cut.btf.exr --method $method -q --checkpoint steps >/dev/null 2>&1
        [ -e cut.btf.exr ] || btf-encode data -o cut.btf.exr --method $method -q --checkpoint steps --resume
        cmp -s whole.btf.exr cut.btf.exr && same=$((same + 1))
    done
    expect_that "$method: killed at $moments random moments and resumed, the same bytes" test $same = $moments

    same=0 kept=0
    for wanted in $(seq $last_step); do # steps that are there when it is killed
        rm -rf steps cut.btf.exr
        btf-encode data -o cut.btf.exr --method $method -q --checkpoint steps &
        while kill -0 $! 2>/dev/null && [ "$(ls steps 2>/dev/null | wc -l)" -lt $wanted ]; do sleep 0.002; done
        kill -KILL $! 2>/dev/null
        wait $! 2>/dev/null
        ls steps/*.btf-step >/dev/null 2>&1 && kept=$((kept + 1))
        [ -e cut.btf.exr ] || btf-encode data -o cut.btf.exr --method $method -q --checkpoint steps --resume
        cmp -s whole.btf.exr cut.btf.exr && same=$((same + 1))
    done
    expect_that "$method: killed after each of $last_step steps and resumed, the same bytes" test $same = $last_step
    expect_that "$method: steps were kept ($kept times of $last_step)" test $kept -gt 0
done

rm -rf steps
timeout -s INT 0.02 btf-encode data -o x.btf.exr --method paper -q --checkpoint steps
mkdir -p steps
expect "other options go on from nothing, or are refused" 0 bash -c '
    ls steps/*.btf-step >/dev/null 2>&1 || exit 0
    btf-encode data -o x.btf.exr --method paper --lobes 1 -q --checkpoint steps --resume
    test $? = 1'
finish
