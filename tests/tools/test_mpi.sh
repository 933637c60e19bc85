#!/bin/bash
# mpirun -n N btf-encode: gives the bytes of one process; and the outcome when a rank fails, dies, or is told to stop.
# Argument: "yes" where btf-encode was built with MPI.
#
# SPDX-License-Identifier: MIT
. "$BTF_SOURCE_ROOT/tests/tools/common.sh" || exit 99
PATH=$build/tests/tools:$PATH
if [ "$1" != yes ]; then
    expect "a program without MPI refuses to be one of several" 5 env OMPI_COMM_WORLD_SIZE=2 btf-encode data -o x.btf.exr
    expect_text "it says why" "2 ranks, but this program was built without MPI" err
    [ "$failures" = 0 ] || finish
    echo "skipped: built without MPI"
    exit 77
fi
if ! command -v mpirun >/dev/null; then
    echo "skipped: no mpirun"
    exit 77
fi
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMP_WAIT_POLICY=passive
export OMPI_MCA_rmaps_base_oversubscribe=1 OMPI_MCA_btl_vader_single_copy_mechanism=none
mkdir tmp
export TMPDIR=$work/tmp

# Under the sanitizers: OpenMPI's own leaks are suppressed by the names in their stacks (tests/lsan.supp). These need
# the slow unwinder, and whole stacks would double the time; OpenMPI's libraries are among the first six frames.
ranks() { ASAN_OPTIONS=${ASAN_OPTIONS:-}:fast_unwind_on_malloc=0:malloc_context_size=6 mpirun "$@"; }
on_ranks() { # N ARGUMENT...: btf-encode on N ranks of one thread
    local n=$1
    shift
    ranks -n "$n" btf-encode "$@" --threads 1
}
nothing_left() { [ ! -e "$1" ] && [ -z "$(find . -name '.*.tmp' -o -name 'btf-scratch-*')" ]; }
# No half-written file is left. A whole one is right if the job ended before the signal came.
nothing_half() { if [ -e "$1" ]; then cmp whole.btf.exr "$1" && rm "$1"; fi && nothing_left "$1"; }

# The numbers of ranks to try: all, or the last one in light runs.
numbers() { [ -n "$light" ] && echo "${1##* }" || echo "$1"; }

for n in $(numbers "2 3 5"); do
    expect "transfers between $n ranks, whole and in pieces" 0 ranks -n $n mpi_transfers
done

small_data ${light:+--size 8 --directions 0:1,40:4}
more_ranks=9
[ -n "$light" ] && more_ranks=6 # still more than the data have views
python3 -c 'import shutil; shutil.make_archive("data", "zip", "data")'
bonn_sample small.btf || exit 99

# N ranks give the bytes of one process. Both get the same options, which the file records.
same() { # NAME RANKS ARGUMENT...
    local name=$1 ranks=$2 n
    shift 2
    expect "$name: alone" 0 btf-encode "$@" -o one.btf.exr -q --threads 2
    for n in $(numbers "$ranks"); do
        rm -f many.btf.exr
        expect "$name: $n ranks" 0 on_ranks "$n" "$@" -o many.btf.exr -q
        expect_that "$name: $n ranks write the same bytes" cmp one.btf.exr many.btf.exr
    done
}
unless_light same "joint, folder" "1 2 3" data
btf-sample -o plane --relief flat --size 8 --directions 0:1,25:6,50:12 --format exr --quiet || exit 99
same "joint, a reflectance alone" "2 3" plane
expect_that "which it is" sh -c 'btf-info one.btf.exr --json | grep -q model=reflectance'
same "joint, fast, levels, archive" 3 data.zip --preset fast --levels all
unless_light same "joint, Bonn" 3 small.btf --preset fast
rings=0:1,30:6,60:8
[ -n "$light" ] && rings=0:1,40:6
btf-sample -o bumps --relief bumps --grid 1024 --size 16 --directions $rings --format exr --quiet || exit 99
same "joint, relief, levels" "1 2" bumps --preset fast --relief auto --gloss auto --levels 2
expect_that "relief is found" sh -c 'btf-info one.btf.exr | grep -q "relief-chosen=[a-m]"'
btf-sample -o strip --relief bricks --size 72x4 --directions 0:1,40:3 --quiet || exit 99
same "joint, match, two blocks of texels" 3 strip --effects shift,gain,residual --budget 24K
same "joint, more ranks than views" $more_ranks data --preset fast
same "joint, samples on disk" 2 data --preset fast --memory "$(least_memory data --preset fast)"
same "joint, Bonn, samples made when needed" 2 small.btf --preset fast --memory "$(least_memory small.btf --preset fast)"
unless_light same "paper, folder" 3 data --method paper $starts
same "paper, archive, levels" 2 data.zip --method paper $starts --levels 2
same "paper, Bonn" 2 small.btf --method paper $starts
expect_that "no scratch file stays" nothing_left none

# The report states the ranks; tables are printed once.
expect "a report" 0 on_ranks 2 data -o r.btf.exr --method paper $starts --report r.json
expect_that "its numbers" python3 -c '
import json
r = json.load(open("r.json"))
b = r["between_ranks"]
assert r["ranks"] == 2
assert b["fit"]["received"] > 1000 and sum(v["meetings"] for v in b.values()) > 10, b
assert b["read"]["meetings"] >= 1 and b["measure"]["received"] > 0, b'
expect_that "one table" test "$(grep -c 'Table 2' out)" = 1

# All ranks encode each input of a list together; a bad input does not stop the others.
printf 'data\nnowhere\nsmall.btf\n' >list.txt
expect "a list with a bad input" 2 on_ranks 2 list.txt -o many -q --preset fast
btf-encode data -o one.btf.exr -q --preset fast
expect_that "the first of it" cmp one.btf.exr many/data.btf.exr
btf-encode small.btf -o one.btf.exr -q --preset fast
expect_that "the last of it" cmp one.btf.exr many/small.btf.exr
expect_that "the bad input is named once" test "$(grep -c 'error: nowhere' err)" = 1

# Errors: one message, the documented code, nothing left.
expect "a bad option" 1 on_ranks 3 data -o x.btf.exr --nonsense
expect_that "it is named once" test "$(grep -c 'unknown option --nonsense' err)" = 1
expect "help" 0 on_ranks 2 --help
expect_that "help comes once" test "$(grep -c 'mpirun -n N' out)" = 1
cp -r data bad
last=$(find bad -name '*.png' | sort | tail -1)
head -c 40 "$last" >cut && mv cut "$last"
expect "an image that rank 1 finds bad" 3 on_ranks 2 bad -o x.btf.exr -q
expect_that "it is named once" test "$(grep -c "rank [0-9]*: .*$(basename "$last")" err)" = 1
expect_that "nothing is written" nothing_left x.btf.exr
mkdir full
expect "an output that cannot be made" 2 on_ranks 2 data -o nowhere/x.btf.exr -q
expect_that "it is said once" test "$(grep -c 'nowhere' err)" = 1
expect "no folder for scratch files" 2 ranks -n 2 env TMPDIR=/nonexistent btf-encode data -o x.btf.exr -q
expect_text "it is named" "/nonexistent" err
mkdir a b
expect "a folder that the ranks do not share" 2 \
    ranks -n 1 -wdir "$work/a" env TMPDIR=. btf-encode ../data -o ../x.btf.exr -q : \
    -n 1 -wdir "$work/b" env TMPDIR=. btf-encode ../data -o ../x.btf.exr -q
expect_text "the advice" "rank 1: scratch file: .*set TMPDIR to a folder that all nodes share" err
expect_that "nothing is written then" nothing_left x.btf.exr

# Kills one rank by SIGKILL, or all by SIGTERM. Rank 0 runs the kill once it has kept a step; it is a child of mpirun,
# and so is rank 1.
kept=(data --method paper $starts -o x.btf.exr -q --checkpoint steps)
cat >kill_ranks <<'S'
mpirun=$(awk '/^PPid/ { print $2 }' /proc/$PPID/status)
ranks=$(cat /proc/$mpirun/task/$mpirun/children)
[ $who = all ] && victims="$mpirun $ranks" || victims=$(echo $ranks | awk '{ print $NF }')
kill -$signal $victims
S
kill_one() { # SIGNAL WHO: of the encode of two ranks, once it has kept a step
    local rank=(btf-encode "${kept[@]}" --threads 1)
    ranks -n 1 env "$preload" "BTF_MOMENT=1 rename .btf-step" "BTF_ACTION=signal=$1 who=$2; . ./kill_ranks" "${rank[@]}" : -n 1 "${rank[@]}" 2>err >out
    code=$?
}
kill_one KILL rank
expect_that "a killed rank ends the job with a code ($code)" test "$code" != 0
expect_text "a message tells of it" "signal 9|[Kk]illed|exited" err
expect_that "no half file after it" test ! -e x.btf.exr
expect_that "no scratch file after it" test -z "$(find tmp -name 'btf-scratch-*')"
expect_that "the checkpoint is there" test -n "$(ls steps)"
btf-encode "${kept[@]}" --resume && mv x.btf.exr alone.btf.exr
expect_that "one process goes on from there, nothing half stays" nothing_left x.btf.exr
btf-encode data --method paper $starts -o whole.btf.exr -q
expect_that "with the bytes of an uninterrupted run" cmp whole.btf.exr alone.btf.exr
kill_one TERM rank
expect_that "SIGTERM to one rank ends the job with 130 ($code)" test "$code" = 130
expect_text "it is said" "interrupted; no material was written" err
expect_that "nothing half after that" nothing_left x.btf.exr
rm -rf steps
kill_one TERM all
expect_that "SIGTERM to all ends the job with a code ($code)" test "$code" != 0
expect_that "nothing half after it" nothing_half x.btf.exr
expect "three ranks go on from two" 0 on_ranks 3 "${kept[@]}" --resume
expect_that "with the same bytes" cmp whole.btf.exr x.btf.exr
expect_that "the checkpoint is gone" test ! -e steps
kept=(data --budget 10K -o x.btf.exr -q --checkpoint steps)
kill_one KILL rank
expect_that "joint: the checkpoint of a killed rank is there" test -n "$(ls steps)"
rm -f x.btf.exr
expect "joint: three ranks go on from two" 0 on_ranks 3 "${kept[@]}" --resume
btf-encode data --budget 10K -o whole.btf.exr -q
expect_that "joint: with the same bytes" cmp whole.btf.exr x.btf.exr
kept=(bumps --preset fast --relief auto --gloss auto -o x.btf.exr -q --checkpoint steps)
kill_one KILL rank
expect_that "relief: the checkpoint of a killed rank is there" test -e steps/relief.btf-step
rm -f x.btf.exr
expect "relief: one goes on from two" 0 on_ranks 1 "${kept[@]}" --resume
btf-encode bumps --preset fast --relief auto --gloss auto -o whole.btf.exr -q
expect_that "relief: with the same bytes" cmp whole.btf.exr x.btf.exr
finish
