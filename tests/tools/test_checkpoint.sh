#!/bin/bash
# btf-encode --checkpoint and --resume: killed at any moment, an encode that goes on gives the same bytes.
#
# SPDX-License-Identifier: MIT
. "$BTF_SOURCE_ROOT/tests/tools/common.sh" || exit 99
small_data ${light:+--size 8}
most=${light:+2} most=${most:-6}

expect "--resume alone is refused" 1 btf-encode data -o x.btf.exr --resume
expect_text "it says what is missing" "--checkpoint" err

for how in "paper --starts 1" joint; do
    method=${how%% *}
    expect "$method, uninterrupted" 0 btf-encode data -o whole.btf.exr --method $how -q
    expect "$method with a checkpoint" 0 btf-encode data -o kept.btf.exr --method $how -q --checkpoint steps
    expect_that "$method: the same bytes" cmp whole.btf.exr kept.btf.exr
    expect_that "$method: the checkpoint is gone" test ! -e steps

    same=0 killed=0 tried=0
    for n in $(moments $most "$(calls btf-encode data -o cut.btf.exr --method $how -q --checkpoint steps)"); do
        rm -rf steps cut.btf.exr
        at "$n call" KILL btf-encode data -o cut.btf.exr --method $how -q --checkpoint steps >/dev/null 2>&1
        [ $? = 137 ] && killed=$((killed + 1))
        [ -e cut.btf.exr ] && [ ! -e steps ] || btf-encode data -o cut.btf.exr --method $how -q --checkpoint steps --resume
        cmp -s whole.btf.exr cut.btf.exr && same=$((same + 1))
        tried=$((tried + 1))
    done
    expect_that "$method: killed at $tried calls that change files" test $killed = $tried
    expect_that "$method: and resumed, the same bytes" test $same = $tried

    same=0 kept=0
    last_step=${light:+2} last_step=${last_step:-$([ $method = joint ] && echo 3 || echo 4)}
    for wanted in $(seq $last_step); do # steps that are there when it is killed
        rm -rf steps cut.btf.exr
        at "$wanted rename .btf-step" KILL btf-encode data -o cut.btf.exr --method $how -q --checkpoint steps >/dev/null 2>&1
        ls steps/*.btf-step >/dev/null 2>&1 && [ ! -e cut.btf.exr ] && kept=$((kept + 1))
        [ -e cut.btf.exr ] || btf-encode data -o cut.btf.exr --method $how -q --checkpoint steps --resume
        cmp -s whole.btf.exr cut.btf.exr && same=$((same + 1))
    done
    expect_that "$method: killed after each of $last_step steps and resumed, the same bytes" test $same = $last_step
    expect_that "$method: steps were kept each time ($kept of $last_step)" test $kept = $last_step
done

rm -rf steps
expect "interrupted after a step" 130 at "1 rename .btf-step" INT btf-encode data -o x.btf.exr --method paper -q --checkpoint steps
expect_that "the step is kept" test -n "$(ls steps)"
expect "other options are refused" 1 btf-encode data -o x.btf.exr --method paper --lobes 1 -q --checkpoint steps --resume
finish
