#!/bin/bash
# Bad input, full disks, interruption: the documented exit code, a message with name and value, no half file.
#
# SPDX-License-Identifier: MIT
. "$BTF_SOURCE_ROOT/tests/tools/common.sh" || exit 99
small_data

expect "no output named" 1 btf-encode data
expect "no input named" 1 btf-encode -o x.btf.exr
expect "an unknown method" 1 btf-encode data -o x.btf.exr --method magic
expect_text "says what was expected" "paper" err
expect "lobes out of range" 1 btf-encode data -o x.btf.exr --lobes 9
expect "a bad transfer" 1 btf-encode data -o x.btf.exr --transfer gamma:x
expect_text "names the value" "gamma:x" err
expect "an input that is not there" 2 btf-encode nothing -o x.btf.exr
expect_text "names the input" "nothing" err
echo "no archive" >broken.zip
expect "an input that is no archive" 3 btf-encode broken.zip -o x.btf.exr

cp -r data missing
rm "$(find missing -name '*tl040 pl120 tv040 pv060*')"
expect "a missing image" 3 btf-encode missing -o x.btf.exr
expect_text "counts what is missing" "1 of 49" err
cp -r data twice
cp "$(find twice -name '*tl040 pl120 tv040 pv060*')" "twice/again tl040 pl120 tv040 pv060.png"
expect "a duplicate image" 3 btf-encode twice -o x.btf.exr
expect_text "names the duplicate" "again tl040" err
cp -r data cut
image=$(find cut -name '*tl040 pl120 tv040 pv060*')
head -c 200 "$image" >cut.png && mv cut.png "$image"
expect "a truncated image" 3 btf-encode cut -o x.btf.exr
expect_text "names the image" "tl040 pl120 tv040 pv060" err
expect "a crop beyond the image" 1 btf-encode data -o x.btf.exr --crop 10,10,10,10
for crop in 4294967297,0,1,1 0,0,0,1 1,2,3 1,2,3,4,5 ' 1,2,3,4' 1,,3,4 -1,0,1,1; do
    expect "no crop: '$crop'" 1 btf-encode data -o x.btf.exr --crop "$crop"
done
for option in --report --pictures; do
    expect "no folder for $option" 2 btf-encode data -o early.btf.exr --method paper -q $option no/such/folder/x
    expect_text "$option: the path is named" "no/such/folder/x" err
    expect_that "$option: found before anything was written" test ! -e early.btf.exr
done
expect "pictures of an input that is not there" 2 btf-encode nothing -o x.btf.exr --pictures drawn
expect_that "leave no empty folder" test ! -e drawn
expect "no folder for the output" 2 btf-encode data -o no/such/folder/x.btf.exr --method paper -q

expect "a material that is none" 3 btf-info data/../broken.zip
expect "a material that is not there" 2 btf-info nothing.btf.exr
expect "compare: not there" 2 btf-compare data nothing.btf.exr
btf-encode data -o good.btf.exr --method paper $starts -q || exit 99
expect "compare: other size" 3 btf-compare <(true) good.btf.exr
btf-sample -o other --relief flat --size 12 --directions 0:1,40:6 --quiet || exit 99
expect "compare: sizes differ" 3 btf-compare other good.btf.exr
expect_text "compare names both sizes" "$side x $side.*12 x 12" err
head -c 3000 good.btf.exr >short.btf.exr
expect "a truncated material" 3 btf-info short.btf.exr

# interruption: the old output stays, nothing half-written appears
cp good.btf.exr kept.btf.exr
btf-sample -o larger --relief bricks --size 32 --directions 0:1,30:6,60:6 --quiet || exit 99
expect "SIGINT gives 130" 130 at "1 print read: done" INT btf-encode larger -o kept.btf.exr --method paper
expect_that "the old file is untouched" cmp good.btf.exr kept.btf.exr
expect_that "no temporary file is left" test -z "$(find . -maxdepth 1 -name '.*.tmp')"

if mkdir tiny && mount -t tmpfs -o size=8k tmpfs tiny 2>/dev/null; then
    expect "a full disk" 2 btf-encode data -o tiny/x.btf.exr --method paper -q
    expect_that "a full disk leaves nothing" test -z "$(ls -A tiny)"
    umount tiny
else
    echo "SKIPPED: a full disk: cannot mount a tmpfs here"
fi
finish
