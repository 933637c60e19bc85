#!/bin/bash
# Sets encodes beside the best peer, the low-bit split PCA of btf-bench, and beside version 1, at the samples.
#
#   tests/bench/peers.sh BUILD [--work DIR] [--budget BYTES] peers|few [NAME...]
#       the default preset beside the low-bit split PCA in the same bytes allowed: what --budget says, else the default;
#       few: an eighth, a quarter and a half of them
#   tests/bench/peers.sh BUILD [--work DIR] v1 BTF_ENCODE [NAME...]
#       --preset fast of BTF_ENCODE, that of version 1, beside today's fast and default in the bytes that it took
#   tests/bench/peers.sh --list     the materials, and the options of btf-sample that make them
#
# Prints a table, a row a material; with NAMEs these alone. PSNR is linear / sRGB-coded. All encodes are of --fit samples
# --effect-tolerance 0 --relief off --gloss off. Tools of BUILD are brought up to date first. What ended is kept in
# DIR/COMMIT (DIR: default BUILD/peers): after a stop the same command goes on while the sources stand at that commit.
# Samples of others are looked for in $BTF_SHARED/data (default ../shared/data), and passed over where they are not there.
# All of it takes hours; no time is measured, so that a busy machine may do.
#
# SPDX-License-Identifier: MIT
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
shared=${BTF_SHARED:-$root/../shared}/data
export OMP_WAIT_POLICY=passive

# Those that the encoder was tuned on come first. "=" is a file of others.
materials='BRICKS64         = BRICKS64.zip
UBO_IMPALLA64    = UBO_IMPALLA64.zip
bricks           --relief bricks
bumps            --relief bumps
weave            --relief weave
flat             --relief flat
white            --relief white
axes             --relief axes
bricks-32        --relief bricks --size 32
bumps-32         --relief bumps --size 32
weave-32         --relief weave --size 32
flat-32          --relief flat --size 32
white-32         --relief white --size 32
axes-32          --relief axes --size 32
bricks-seed      --relief bricks --seed 7
weave-noise      --relief weave --seed 9 --noise 0.003
bumps-jpeg       --relief bumps --seed 25 --format jpeg --quality 85
bricks-seed-32   --relief bricks --size 32 --seed 8
bumps-seed-32    --relief bumps --size 32 --seed 11
weave-seed-32    --relief weave --size 32 --seed 5
bumps-noise-32   --relief bumps --size 32 --seed 3 --noise 0.01
flat-noise-32    --relief flat --size 32 --noise 0.003
bricks-dark-32   --relief bricks --size 32 --seed 21 --exposure 0.04
bumps-dark-32    --relief bumps --size 32 --seed 22 --exposure 0.02 --noise 0.0005
weave-bright-32  --relief weave --size 32 --seed 23 --exposure 4
flat-bright-32   --relief flat --size 32 --seed 24 --exposure 8
bumps-24x40      --relief bumps --size 24x40 --seed 26
bricks-96x10     --relief bricks --size 96x10 --seed 27
weave-19         --relief weave --seed 28 --directions small
bumps-37         --relief bumps --seed 29 --directions 0:1,25:6,50:12,75:18
bricks-151x12    --relief bricks --size 32 --seed 30 --views ubo2014 --lights 12
bumps-12x151     --relief bumps --size 32 --seed 31 --views 12 --lights ubo2014'

usage() {
    sed -n '2,/^$/s/^# \{0,1\}//p' "$0" | sed '/^SPDX/,$d'
    exit "$1"
}
case ${1:-} in
--list)
    echo "$materials"
    exit
    ;;
-h | --help) usage 0 ;;
'') usage 1 >&2 ;;
esac
build=$(cd "$1" && pwd)
shift
PATH=$build/encoder:$build/tests/sample:$build/tests/bench:$build/decoder/tools:$PATH
work=$build/peers budget=
while [ $# -gt 0 ]; do
    case $1 in
    --work) work=${2:?expected a folder after --work} ;;
    --budget) budget=${2:?expected bytes after --budget} ;;
    *) break ;;
    esac
    shift 2
done
kind=${1:-peers} v1=
[ $# -eq 0 ] || shift
case $kind in
peers | few) ;;
v1)
    v1=${1:?expected the btf-encode of version 1 after v1}
    [ -x "$v1" ] || { echo "peers.sh: $v1 is no program" >&2; exit 1; }
    shift
    ;;
*) usage 1 >&2 ;;
esac
# shellcheck source=tests/bench/commit.sh
. "$root/tests/bench/commit.sh"
at=$(commit)
firsts=$work # what version 1 encoded is the same at any commit of these sources
work=$work/$at
mkdir -p "$work"
targets='encoder/btf-encode tests/sample/btf-sample tests/bench/btf-bench'
[ "$kind" != v1 ] || targets="$targets encoder/btf-compare decoder/tools/btf-info"
# shellcheck disable=SC2086
ninja -C "$build" $targets >"$work/ninja.log" || {
    tail -20 "$work/ninja.log" >&2
    exit 1
}
echo "peers.sh: commit $at" >&2

need() { # makes the sample of this row where a step wants it and it is not there
    if [ ! -e "$data" ]; then
        rm -rf "$data.part"
        # shellcheck disable=SC2086
        btf-sample -o "$data.part" --format exr $options --quiet >&2
        mv "$data.part" "$data"
    fi
}
ours() { # BYTES PRESET: "BYTES LINEAR SRGB" of the report; at the least bytes where BYTES hold nothing
    local file=$work/$name-$2-$1 bytes=$1
    while [ ! -s "$file.json" ]; do
        need
        if btf-encode "$data" -o "$file.btf.exr" --preset "$2" --budget "$bytes" --fit samples --effect-tolerance 0 --relief off \
            --gloss off --report "$file.json.part" -q >&2 2>"$file.error"; then
            rm "$file.btf.exr"
            mv "$file.json.part" "$file.json"
        else
            bytes=$(sed -n 's/.*give --budget \([0-9]*[kM]\) or more.*/\1/p' "$file.error")
            [ -n "$bytes" ] || { cat "$file.error" >&2; return 1; }
        fi
    done
    python3 -c 'import json, sys
r = json.load(open(sys.argv[1])); p = r["psnr"]["full"]; print(r["bytes"]["gpu"], p["linear"], p["srgb"])' "$file.json"
}
peer() { # BYTES, "" for the default: "ALLOWED BYTES LINEAR SRGB" of the low-bit split PCA
    local out=$work/lowbit-$name-$1 csv
    csv=$out/lowbit-$name.csv
    [ -s "$csv" ] || {
        need
        btf-bench --only lowbit --input "$data" ${1:+--budget "$1"} --out "$out" -q >/dev/null
    }
    tail -n 1 "$csv" | awk -F, '{ print $1, $2, $4, $5 }'
}
first() { # the same of version 1, decoded by today's btf-compare
    local file=$work/v1-$name made
    made=$firsts/v1-$name-$(cksum <"$v1" | cut -d' ' -f1)
    [ -s "$file.json" ] || {
        need
        [ -s "$made.btf.exr" ] || {
            "$v1" "$data" -o "$made.part.btf.exr" --preset fast -q >&2
            mv "$made.part.btf.exr" "$made.btf.exr"
        }
        btf-info --json "$made.btf.exr" >"$file.info"
        btf-compare "$data" "$made.btf.exr" --no-ssim --json -q >"$file.json.part"
        mv "$file.json.part" "$file.json"
    }
    python3 - "$file" <<'P'
import json, sys
info, found = (json.load(open(sys.argv[1] + end)) for end in (".info", ".json"))
print(info["bytes"]["gpu"], found["psnr"]["linear"], found["psnr"]["srgb"])
P
}
cells() { # HEAD; "BYTES LINEAR SRGB"...: a row of dB and MB, then what the last is above the first in dB
    awk -v head="$1" 'NR == 1 { printf "| %s ", head } { printf "| %.2f / %.2f, %.3f MB ", $2, $3, $1 / 1e6; if (NR == 1) { a = $2; b = $3 } c = $2; d = $3 }
        END { printf "| %+.2f / %+.2f |\n", c - a, d - b }'
}

if [ "$kind" = v1 ]; then
    printf '| material | version 1, `fast` | today, `fast` | today, default | default above version 1 |\n| --- | --- | --- | --- | --- |\n'
else
    printf '| material | bytes allowed | low-bit split PCA | default | above it |\n| --- | --- | --- | --- | --- |\n'
fi
while read -r name options <&3; do
    [ $# -eq 0 ] || [[ " $* " == *" $name "* ]] || continue
    data=$work/$name
    if [ "$options" != "${options#=}" ]; then
        data=$shared/${options#= }
        [ -e "$data" ] || { echo "peers.sh: $data is not there: $name is passed over" >&2; continue; }
    fi
    if [ "$kind" = v1 ]; then
        found=$(first)
        bytes=${found%% *}
        { echo "$found"; ours "$bytes" fast; ours "$bytes" medium; } | cells "$name"
    else
        most=$budget
        [ -n "$most" ] || most=$(peer "" | cut -d' ' -f1)
        for part in $([ "$kind" = few ] && echo 8 4 2 || echo 1); do
            bytes=$((most / part))
            { peer "$([ $bytes = "$most" ] && echo "$budget" || echo $bytes)" | cut -d' ' -f2-; ours $bytes medium; } |
                cells "$name | $(awk "BEGIN { printf \"%.3f MB\", $bytes / 1e6 }")"
        done
    fi
    [ "$data" != "$work/$name" ] || rm -rf "$data"
done 3<<<"$materials"
