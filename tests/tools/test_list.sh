#!/bin/bash
# btf-encode with a list of inputs.
#
# SPDX-License-Identifier: MIT
. "$BTF_SOURCE_ROOT/tests/tools/common.sh" || exit 99
for name in one two three; do
    btf-sample -o "sets/$name" --relief flat --size 4 --directions 0:1,40:6 --quiet || exit 99
done
rm "$(find sets/two -name '*tl040*' | sort | tail -1)" || exit 99
printf '# three inputs\n\n  one\t\r\ntwo/\nthree\n' >sets/all.txt
encode() { btf-encode "$@" --method paper; }

expect "a list goes on after a bad input, and fails" 3 encode sets/all.txt -o made --report reports --pictures pictures
expect_text "the summary counts" "^2 encoded, 1 failed, 0 not tried$" out
expect_text "the summary names the bad one" "^FAILED .* sets/two/: " out
expect_text "the message says what is missing" "1 of 49 images are missing" err
expect_that "the others are there" test -s made/one.btf.exr -a -s made/three.btf.exr -a ! -e made/two.btf.exr
expect_that "reports and pictures as well" test -s reports/one.json -a -s pictures/three/montage.png
expect "alone" 0 encode sets/three -o alone.btf.exr -q
expect_that "the same bytes as alone" cmp alone.btf.exr made/three.btf.exr

cp -r made kept
rm -r made
expect "one item" 0 encode sets/all.txt -o made --item 3 -q
expect_that "only this one" test "$(ls made)" = three.btf.exr
expect "an item that fails" 3 encode sets/all.txt -o made --item 2
expect_text "the others were not tried" "^0 encoded, 1 failed, 2 not tried$" out
expect "no such item" 1 encode sets/all.txt -o made --item 4
expect_text "the list's length is told" "the list has 3" err
expect "an item of what is no list" 1 encode sets/one -o x.btf.exr --item 1
expect_text "the option is named" "--item" err

printf '\xef\xbb\xbfone\r\n' >sets/marked.txt
expect "a list with a byte-order mark" 0 encode sets/marked.txt -o marked -q
expect_that "its first line is read" cmp marked/one.btf.exr kept/one.btf.exr
printf '\xff\xfeo\0n\0e\0' >sets/wide.txt
expect "a list in UTF-16" 5 encode sets/wide.txt -o made
expect_text "it is named" "wide.txt: the text is UTF-16: save it as UTF-8" err

# One table of names for all inputs of a list; it names images with their folders.
mkdir plain
number=0
for name in one three; do
    mkdir "plain/$name"
    find "sets/$name" -name '*tl0*' | sort | while read -r image; do
        number=$((number + 1))
        cp "$image" "plain/$name/$number.${image##*.}"
        echo "$image" | sed -E "s|.*tl([0-9.]+) pl([0-9.]+) tv([0-9.]+) pv([0-9.]+)\.([a-z]+)|$name/$number.\5,\3,\4,\1,\2|"
    done
done >plain/table.csv
printf 'one\nthree\n' >plain/all.txt
expect "a list with a table of names" 0 encode plain/all.txt -o named -q --names plain/table.csv
expect_that "the same bytes as with names" cmp named/three.btf.exr alone.btf.exr
expect_text "files of the other input are told" "49 files are not among the images of" err
expect "no table" 3 encode plain/one -o x.btf.exr -q
expect_text "the option is told" "option names takes a table" err

printf '# nothing\n' >empty.list
expect "an empty list" 3 encode empty.list -o made
expect_text "it says so" "the list names no input" err
printf 'sets/one\nsets/../sets/one.zip\n' >twice.txt
expect "two of one name" 3 encode twice.txt -o made
expect_text "line and name are told" "line 2: .* would both become one.btf.exr" err
for name in .. . / ../ ...zip; do
    printf 'sets/one\n%s\n' "$name" >none.txt
    expect "no name: '$name'" 3 encode none.txt -o made
    expect_text "is refused with its line" "none.txt: line 2: '.*' gives no file name for a material" err
done
printf 'sets/one\n' >list.txt
touch file
expect "the folder is a file" 2 encode list.txt -o file/folder
expect_text "it is named" "file/folder" err

finish
