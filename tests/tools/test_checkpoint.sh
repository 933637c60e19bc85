#!/bin/bash
# btf-encode --checkpoint and --resume: an encode that was killed at any moment and resumed gives the same bytes.
#
# SPDX-License-Identifier: MIT
. "$BTF_SOURCE_ROOT/tests/tools/common.sh" || exit 99
small_data ${light:+--size 8}
rings=0:1,30:6,60:8 # enough directions for a map of heights; with fewer a single height is found
[ -n "$light" ] && rings=0:1,40:6
btf-sample -o bumps --relief bumps --grid 1024 --size 16 --directions $rings --format exr --quiet || exit 99
most=${light:+2} most=${most:-6}

expect "--resume alone is refused" 1 btf-encode data -o x.btf.exr --resume
expect_text "it says what is missing" "--checkpoint" err

for method in paper joint relief; do
    case $method in
    paper) how="data --method paper --starts 1" last_step=4 ;;
    joint) how="data --method joint" last_step=4 ;;
    relief) how="bumps --preset fast --relief auto --gloss auto --levels 2" last_step=3 most=${light:+1} most=${most:-2} ;;
    esac
    expect "$method, uninterrupted" 0 btf-encode $how -o whole.btf.exr -q --report whole.json
    rm -f calls
    expect "$method with a checkpoint" 0 env "$preload" BTF_CALLS=calls btf-encode $how -o kept.btf.exr -q --checkpoint steps
    expect_that "$method: the same bytes" cmp whole.btf.exr kept.btf.exr
    expect_that "$method: the checkpoint is gone" test ! -e steps

    same=0 killed=0 tried=0
    for n in $(moments $most "$(cat calls)"); do
        rm -rf steps cut.btf.exr
        at "$n call" KILL btf-encode $how -o cut.btf.exr -q --checkpoint steps >/dev/null 2>&1
        [ $? = 137 ] && killed=$((killed + 1))
        [ -e cut.btf.exr ] && [ ! -e steps ] || btf-encode $how -o cut.btf.exr -q --checkpoint steps --resume
        cmp -s whole.btf.exr cut.btf.exr && same=$((same + 1))
        tried=$((tried + 1))
    done
    expect_that "$method: killed at $tried calls that change files" test $killed = $tried
    expect_that "$method: and resumed, the same bytes" test $same = $tried

    same=0 kept=0
    [ -n "$light" ] && last_step=2
    for wanted in $(seq $last_step); do # how many steps are kept when it is killed
        rm -rf steps cut.btf.exr
        at "$wanted rename .btf-step" KILL btf-encode $how -o cut.btf.exr -q --checkpoint steps >/dev/null 2>&1
        ls steps/*.btf-step >/dev/null 2>&1 && [ ! -e cut.btf.exr ] && kept=$((kept + 1))
        [ -e cut.btf.exr ] || btf-encode $how -o cut.btf.exr -q --checkpoint steps --resume
        cmp -s whole.btf.exr cut.btf.exr && same=$((same + 1))
    done
    expect_that "$method: killed after each of $last_step steps and resumed, the same bytes" test $same = $last_step
    expect_that "$method: steps were kept each time ($kept of $last_step)" test $kept = $last_step
done

# Relief is the first step: a resumed encode reads it and does not search again.
killed() { # the encode of bumps, killed once relief is kept
    rm -rf steps cut.btf.exr
    cp -r relief_kept steps
}
rm -rf steps
at "1 rename .btf-step" KILL btf-encode $how -o cut.btf.exr -q --checkpoint steps >/dev/null 2>&1
mv steps relief_kept
expect_that "relief is found on bumps" grep -q '"chosen": [1-9]' whole.json
killed
expect "relief kept, resumed" 0 btf-encode $how -o cut.btf.exr --checkpoint steps --resume --report cut.json
expect_that "the same bytes" cmp whole.btf.exr cut.btf.exr
expect_that "it is not found again" python3 -c '
import json, sys
lines = open("err").read().replace("\r", "\n").splitlines()
assert any(line.startswith("factorise") for line in lines) and not any(line.startswith("relief") for line in lines), lines
whole, cut = (json.load(open(f"{name}.json"))["relief"] for name in ("whole", "cut"))
assert whole == cut, (whole, cut)'
killed
printf x | dd of=steps/relief.btf-step bs=1 seek=100 conv=notrunc 2>/dev/null
expect "a damaged relief" 0 btf-encode $how -o cut.btf.exr -q --checkpoint steps --resume
expect_text "is named" "relief.btf-step" err
expect_that "and found again" cmp whole.btf.exr cut.btf.exr
killed
expect "relief, whose samples no longer lie in memory, is refused" 1 \
    btf-encode $how -o cut.btf.exr -q --checkpoint steps --resume --memory "$(least_memory $how)"
expect_text "with what to do" "relief.*--memory.*begin anew" err

rm -rf steps
expect "interrupted after a step" 130 at "1 rename .btf-step" INT btf-encode data -o x.btf.exr --method paper -q --checkpoint steps
expect_that "the step is kept" test -n "$(ls steps)"
expect "other options are refused" 1 btf-encode data -o x.btf.exr --method paper --lobes 1 -q --checkpoint steps --resume
finish
