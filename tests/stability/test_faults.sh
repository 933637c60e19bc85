#!/bin/bash
# Full disks, read-only outputs, signals at any moment, inputs that vanish, two writers of one file.
#
# SPDX-License-Identifier: MIT
. "$BTF_SOURCE_ROOT/tests/stability/cases.sh" || exit 99
title "Faults from outside: whatever happens, a file under its final name is whole, old ones are kept, exit codes are as documented."
export OMP_NUM_THREADS=2
sample() { btf-sample -o "$1" --relief "$2" --size 8 --directions 0:1,40:6 --quiet || exit 99; }
sample data bricks
sample other bumps
# Options with which the paper's method runs all of its stages as fast as possible.
quick="--method paper --starts 1"
sanitized && quick="$quick --lobes 1 --rounds 1"
paper() { btf-encode "$1" -o "$2" $quick -q "${@:3}"; }
joint() { btf-encode "$1" -o "$2" --preset fast -q "${@:3}"; }
paper data paper.btf.exr && joint data joint.btf.exr && paper other other.btf.exr || exit 99
echo "not a material, but not to be lost either" >old

# The moments that are tried, at most (tests/tools/common.sh: moments).
most=1000 some=10
sanitized && most=2 some=2

# whole FILE GOOD: complains unless FILE has the bytes of the old file or of GOOD.
whole() { cmp -s "$1" old || cmp -s "$1" "$2" || complain "$1 is neither the old file nor a whole new one"; }

# same_files FOLDER GOOD: complains unless every file of FOLDER, temporary ones apart, is the same in GOOD.
same_files() {
    local file
    while IFS= read -r file; do must cmp "$1/$file" "$2/$file"; done < <(find "$1" -type f -name '[!.]*' -printf '%P\n' 2>/dev/null)
}

encode() { # METHOD: the command that `at` and `calls` run
    if [ "$1" = paper ]; then echo btf-encode data -o x.btf.exr $quick; else echo btf-encode data -o x.btf.exr --preset fast; fi
}

# signalled METHOD SIGNAL CODES MOMENT: the output must be the old file or a whole new one, and the exit code one of
# CODES; counts the runs that died.
signalled() {
    cp old x.btf.exr
    try at "$4" "$2" $(encode "$1")
    one_of 0 $3
    [ "$code" = 0 ] && must cmp x.btf.exr "$1.btf.exr" || died=$((died + 1))
    whole x.btf.exr "$1.btf.exr"
    [ "$2" = INT ] && [ "$(temporaries .)" != 0 ] && complain "a temporary file is left"
    tried=$((tried + 1))
}

# The next run succeeds and removes what a killed one left.
next_run() {
    must "$1" data x.btf.exr
    must test "$(temporaries .)" = 0
}

# signals METHOD SIGNAL CODES: sends the signal while images are opened, and at each call that changes a file.
signals() {
    local died=0 tried=0 left n
    for n in $(moments $((some / 2)) "$(find data -name '*.png' | wc -l)"); do
        signalled "$1" "$2" "$3" "$n open data/"
    done
    must test $died = $tried # while images are read, no output is finished
    for n in $(moments $most "$(calls $(encode "$1"))"); do
        signalled "$1" "$2" "$3" "$n call"
    done
    left=$(temporaries .)
    next_run "$1"
    verdict "$2 while files are read and written, $1" \
        "exit code ${3/ / or }, or 0 where nothing was left to do; the output old or whole; no temporary file after the next run" \
        "$died of $tried ended early, $left temporary files before the next run"
}
signals paper INT 130
sanitized || signals paper TERM "130 143"
signals paper KILL 137
signals joint INT 130
signals joint KILL 137

# at_stages METHOD SIGNAL CODE: sends the signal when the program has printed that a stage is done, before the next
# begins. (SIGKILL needs no such moments: the files that it leaves depend on the calls that change files alone.)
at_stages() {
    local died=0 tried=0 stage
    $(encode "$1") 2>&1 >/dev/null | sed -n 's/: done after.*//p' >stages
    while IFS= read -r stage; do
        signalled "$1" "$2" "$3" "1 print $stage: done after"
    done <stages
    must test $tried -gt 5
    must test $died = $((tried - 1)) # after the last stage everything is saved, and the run succeeds
    next_run "$1"
    verdict "$2 after each stage, $1" \
        "exit code $3, or 0 where nothing was left to do; the output old or whole; no temporary file after the next run" \
        "$died of $tried ended early"
}
at_stages paper INT 130
sanitized || at_stages joint INT 130

cp old x.btf.exr
code=0
(ulimit -c 0 -f 4 && paper data x.btf.exr) 2>err || code=$?
one_of 153
must cmp x.btf.exr old
must test "$(temporaries .)" = 1
must paper data x.btf.exr
must cmp x.btf.exr paper.btf.exr
must test "$(temporaries .)" = 0
verdict "killed (SIGXFSZ) after 4 KiB of the output" "the old file kept, one temporary file, which the next run removes" "as expected"
cp old x.btf.exr
code=0
(trap '' XFSZ && ulimit -f 4 && paper data x.btf.exr) 2>err || code=$?
one_of 2
must cmp x.btf.exr old
must test "$(temporaries .)" = 0
verdict "a write that fails after 4 KiB of the output" "exit code 2, the old file kept, no temporary file" "$(message)"

# the least --memory that is accepted: samples then lie in a scratch file
least=$(btf-encode data -o least.btf.exr $quick -q --memory 1 2>&1 | grep -o 'at least [0-9]*K' | grep -o '[0-9]*K')
rm -f y.btf.exr
TMPDIR=$PWD btf-encode data -o y.btf.exr $quick --memory "$least" >/dev/null 2>&-
code=$?
one_of 0
must cmp y.btf.exr paper.btf.exr
rm -f y.btf.exr
TMPDIR=$PWD btf-encode data -o y.btf.exr $quick --memory "$least" <&- >&- 2>&-
code=$?
one_of 2
must cmp y.btf.exr paper.btf.exr
verdict "standard streams closed, samples in a scratch file" \
    "the same bytes, nothing is printed into a file; exit code 2 where tables cannot be printed" "as expected"

tar cf same.tar -C data . && cp same.tar kept.tar
for output in same.tar ./same.tar; do
    try btf-encode same.tar -o $output $quick -q
    one_of 1
    must grep -q same.tar err
done
try btf-encode same.tar -o w.btf.exr $quick -q --report same.tar
one_of 1
must cmp same.tar kept.tar
rm -f w.btf.exr
try btf-encode data -o w.btf.exr $quick -q --report w.btf.exr
one_of 1
must test ! -e w.btf.exr
cp paper.btf.exr w.btf.exr
try btf-decode w.btf.exr -o w.btf.exr
one_of 1
must cmp w.btf.exr paper.btf.exr
verdict "an output that is the input, or another output" "exit code 1, the file is named, the input kept" "$(message)"

cp -r data piped
image=$(find piped -name '*.png' | head -1)
rm "$image" && mkfifo "$image"
try timeout -s KILL 1000 btf-encode piped -o v.btf.exr $quick -q
one_of 3
must grep -q "${image##*/}: is neither a file nor a folder" err
must grep -q "1 of 49 images are missing" err
must test ! -e v.btf.exr
verdict "a pipe with an image's name" "it is not waited for: a warning that names it, then exit code 3 for the image that is missing" "$(message | cut -c 1-90)"

mkdir drawn
paper data y.btf.exr --pictures drawn/good --report good.json
long_way=(btf-encode data -o y.btf.exr $quick -q --memory "$least" --pictures drawn/x --report y.json)
mkdir scratch
count=$(TMPDIR=$PWD/scratch calls "${long_way[@]}")
must test "$count" -gt 50
rm -rf drawn/x y.json
for n in $(moments $some "$count"); do
    TMPDIR=$PWD/scratch try at "$n call" KILL "${long_way[@]}"
    one_of 137
    same_files drawn/x drawn/good
    [ -e y.json ] && must python3 -m json.tool y.json
    [ -z "$(ls -A scratch)" ] || complain "left in TMPDIR: $(ls -A scratch)"
done
must test -n "$(ls drawn/x)"
must paper data y.btf.exr --pictures drawn/x --report y.json
must test "$(temporaries .)" = 0
verdict "KILL while pictures and report are written, samples in a scratch file" \
    "each picture and the report whole or absent; nothing left in TMPDIR, nor beside the outputs after the next run" "as expected"

mkdir images
btf-decode paper.btf.exr -o good-images --all >/dev/null 2>&1 || exit 99
for n in $(moments $some "$(calls btf-decode paper.btf.exr -o images --all)"); do
    rm -rf images && mkdir images
    try at "$n call" KILL btf-decode paper.btf.exr -o images --all
    one_of 137
    same_files images good-images
done
must btf-decode paper.btf.exr -o images --all
must test "$(temporaries images)" = 0
verdict "KILL while images are decoded" "each image whole or absent, no temporary file after the next run" \
    "$(find images -name '*.png' | wc -l) images in the end"

lost=0 read=0
while IFS= read -r moment; do
    cp -r data gone
    rm -f z.btf.exr
    try at "$moment" "rm -rf gone" btf-encode gone -o z.btf.exr $quick
    one_of 0 2 3
    must test ! -e gone
    if [ "$code" = 0 ]; then
        read=$((read + 1))
        must btf-info z.btf.exr
    else
        lost=$((lost + 1))
        must test ! -e z.btf.exr
        must test -s err
    fi
done < <(moments $some "$(find data -name '*.png' | wc -l)" | sed 's#$# open gone/#'; printf '1 print %s: done\n' read fit measure)
must test "$lost $read" = "$some 3" # an input that vanishes after it was read does not matter
verdict "the input removed while it is read, and afterwards" "exit code 2 or 3 with a message and no output, or, all being read, 0" \
    "$lost refused, $read read before"

first=0 rounds=3
sanitized && rounds=1
for round in $(seq $rounds); do
    paper data two.btf.exr &
    one=$!
    paper other two.btf.exr &
    wait $one || complain "the first encoder failed"
    wait $! || complain "the second encoder failed"
    if cmp -s two.btf.exr paper.btf.exr; then first=$((first + 1)); else must cmp two.btf.exr other.btf.exr; fi
    must test "$(temporaries .)" = 0
done
verdict "two encoders write one output at once" "both succeed, the file is one of the two to the byte" \
    "$first times the first one's, $((rounds - first)) times the second's"

code=0
paper data "$(printf 'n%.0s' $(seq 247)).btf.exr" 2>err || code=$?
one_of 0
verdict "a file name of 255 bytes, with no room for a longer temporary one" "it is written" "as expected"

# disks of their own
disk=$work/disk
mkdir disk
if mount -t tmpfs -o size=64k tmpfs "$disk" 2>/dev/null; then
    umount "$disk"
    full=0 fits=0 sizes="4 8 12 20 32"
    sanitized && sizes="4 32"
    for kib in $sizes; do
        for kept in no yes; do
            mount -t tmpfs -o size=${kib}k tmpfs "$disk"
            [ $kept = yes ] && cp old disk/x.btf.exr
            try btf-encode data -o disk/x.btf.exr $quick -q
            one_of 0 2
            if [ "$code" = 0 ]; then
                fits=$((fits + 1))
                must cmp disk/x.btf.exr paper.btf.exr
            else
                full=$((full + 1))
                must test -s err
                if [ $kept = yes ]; then must cmp disk/x.btf.exr old; else must test ! -e disk/x.btf.exr; fi
            fi
            must test "$(temporaries disk)" = 0
            umount "$disk"
        done
    done
    verdict "a material onto disks of 4 to 32 KiB, with and without an old file" \
        "exit code 2 with a message, the old file kept, nothing else left; or 0 and a whole file" "$full refused, $fits written"

    mount -t tmpfs -o size=20k tmpfs "$disk"
    try btf-decode paper.btf.exr -o disk --all
    one_of 2
    same_files disk good-images
    must test "$(temporaries disk)" = 0
    verdict "49 images onto a disk of 20 KiB" "exit code 2, images whole or absent" "$(find disk -name '*.png' | wc -l) whole images"
    try env TMPDIR="$disk" btf-encode data -o t.btf.exr $quick -q --memory "$least"
    one_of 2
    must test ! -e t.btf.exr
    must grep -q TMPDIR err
    verdict "a scratch file onto a full disk" "exit code 2, TMPDIR is named, no output" "$(message)"
    umount "$disk"

    mount -t tmpfs -o size=64k tmpfs "$disk"
    cp old disk/x.btf.exr
    cp -r data disk/data 2>/dev/null
    mount -o remount,ro "$disk"
    for tool in "btf-encode data -o disk/x.btf.exr $quick -q" "btf-encode data -o v.btf.exr $quick -q --report disk/r.json" \
        "btf-encode data -o v.btf.exr $quick -q --pictures disk/p" "btf-decode paper.btf.exr -o disk/images --all" \
        "btf-decode paper.btf.exr -o disk --all" "btf-sample -o disk/s --size 8 --directions tiny --quiet"; do
        try $tool
        one_of 2
        must grep -q disk err
    done
    must cmp disk/x.btf.exr old
    must test ! -e v.btf.exr
    umount "$disk"
    verdict "read-only outputs of btf-encode, btf-decode, btf-sample" "exit code 2, the path is named, the old file kept, no work done before" \
        "$(message)"
else
    skipped "a material onto disks of 4 to 32 KiB, with and without an old file" \
        "exit code 2 with a message, the old file kept, nothing else left; or 0 and a whole file" "cannot mount a tmpfs here"
    skipped "49 images onto a disk of 20 KiB" "exit code 2, images whole or absent" "cannot mount a tmpfs here"
    skipped "a scratch file onto a full disk" "exit code 2, TMPDIR is named, no output" "cannot mount a tmpfs here"
    skipped "read-only outputs of btf-encode, btf-decode, btf-sample" "exit code 2, the path is named, the old file kept, no work done before" \
        "cannot mount a tmpfs here"
fi
finish
