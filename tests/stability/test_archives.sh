#!/bin/bash
# Odd, broken and malicious archives: which are read, which are refused, and at what cost.
#
# SPDX-License-Identifier: MIT
. "$BTF_SOURCE_ROOT/tests/stability/cases.sh" || exit 99
title "Archives that are odd, broken or meant to harm. Nothing is ever extracted; a file in one is at most 1 GiB."
mkdir -p a/b/c && cd a/b/c || exit 99
btf-sample -o data --relief bricks --size 8 --directions 0:1,40:6 --quiet || exit 99
python3 "$BTF_SOURCE_ROOT/tests/stability/make_archives.py" data archives >sizes 2>/dev/null || exit 99
quick="--method paper --starts 1 --lobes 1 --effects none -q" # a short encode: only reading is tested
btf-encode data -o good.btf.exr $quick || exit 99

# Memory that a process may take, in KiB: a bomb that is unpacked whole does not fit (sanitizers need more of their
# own).
bound=2500000
sanitized && bound=unlimited

# encodes INPUT WHAT: the same samples as from the folder.
encodes() {
    try bash -c "ulimit -v $bound; exec btf-encode archives/$1 -o x.btf.exr $quick"
    one_of 0
    [ "$code" = 0 ] && must btf-compare good.btf.exr x.btf.exr
    rm -f x.btf.exr
    nothing_else
    verdict "$2" "read like the folder; nothing is written but the output" "as expected"
}

# refuses INPUT WHAT CODE WORDS: with a message, no output, and nothing else written.
refuses() {
    try bash -c "ulimit -v $bound; exec btf-encode archives/$1 -o x.btf.exr $quick"
    one_of "$3"
    must test ! -e x.btf.exr
    must grep -Eq -- "$4" err
    nothing_else
    verdict "$2" "exit code $3, a message of \"$4\"; nothing is written" "$(message)"
}

nothing_else() {
    find "$work" -not -path "*/archives*" -not -name out -not -name err -not -name that | sort >after
    must diff before after
}
touch before after sizes && find "$work" -not -path "*/archives*" -not -name out -not -name err -not -name that | sort >before

encodes plain.zip "a plain zip"
encodes absolute.zip "a zip with absolute names"
encodes dots.zip "a zip with names that begin with ../../../"
encodes dots.tar "a tar with names that begin with ../../"
encodes many.zip "a zip with 100,000 further entries"
encodes long.zip "a zip with a name of 60,000 bytes"
encodes utf8.zip "a zip with names that are not ASCII, as UTF-8"
encodes latin.zip "a zip with names of bytes above 127 in no known code"
encodes utf8.tar "a tar (pax) with names that are not ASCII"
encodes links.tar "a tar with links, devices, a FIFO and a folder named like images"
refuses nested.zip "a zip in a zip" 3 "no JPEG, PNG, HDR or EXR image"
refuses encrypted.zip "an encrypted zip" 3 "archives/encrypted.zip: .*Passphrase"
refuses bomb.zip "a zip bomb: 1.1 GiB of zeros in 1.1 MB" 5 "more than 1073741824 bytes"
refuses bomb-4g.zip "a zip bomb of 4 GiB and 1 MiB that declares 1 MiB" 5 "more than 1073741824 bytes"
refuses declares-4g.zip "a zip whose entries declare 4 GiB" 5 "more than 1073741824 bytes"
refuses declares-0.zip "a zip whose entries declare 0 bytes" 3 "archives/declares-0.zip: .*uncompressed data"
refuses stored-lie.zip "a zip whose stored entries declare 512 MiB" 3 "archives/stored-lie.zip: .*uncompressed data"
refuses twice.zip "a zip with an image twice" 3 "tl0"
refuses empty.zip "a zip without entries" 3 "archives/empty.zip: no JPEG, PNG, HDR or EXR image"
finish
