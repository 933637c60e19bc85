#!/bin/bash
# btf-bench on data of 8x8 texels and 19 directions: sections, files, exit codes, going on after a stop.
#
# SPDX-License-Identifier: MIT
. "$BTF_SOURCE_ROOT/tests/tools/common.sh" || exit 99
PATH=$build/tests/bench:$PATH

# columns FILE: every line has as many fields as the first, numbers are numbers, and there are rows.
cat >columns.py <<'P'
import csv, math, sys
for path in sys.argv[1:]:
    rows = list(csv.DictReader(open(path), restkey="more"))
    assert rows, path
    for row in rows:
        assert "more" not in row and None not in row.values(), (path, row)
        for key, value in row.items():
            if key.startswith(("psnr", "core", "wall", "ns", "gpu")) and value != "":
                assert math.isfinite(float(value)) and float(value) >= 0, (path, key, value)
P

expect "sample" 0 btf-sample -o tiny --size 8x8 --directions small --quiet
if [ -n "$light" ]; then # the sections that encode do nothing but what test_encode.sh does, a hundred times
    expect "machine" 0 btf-bench --quick --input tiny --only machine --out b -q
    expect_that "table has its columns" python3 columns.py b/machine-tiny.csv
    expect "an unknown section" 1 btf-bench --only nothing
    expect "no data" 2 btf-bench --input missing --out x -q
    expect "no folder" 2 btf-bench --quick --input tiny --out columns.py/x -q
    OMP_WAIT_POLICY=passive expect "interrupted" 130 at "1 rename journal" INT btf-bench --materials bricks --size 24x24 --only encode --out i -q
    finish
fi
expect "machine, encode, storage" 0 btf-bench --quick --input tiny --only machine,encode,storage --out b -q
expect_that "tables have their columns" python3 columns.py b/encode-tiny.csv b/storage-tiny.csv b/machine-tiny.csv
expect_that "every sweep is there" python3 - <<'P'
import csv
rows = list(csv.DictReader(open("b/encode-tiny.csv")))
sweeps = {row["sweep"] for row in rows}
assert sweeps == {"paper", "preset", "rounds", "joint effects", "lobes", "rejection", "lights voted", "window",
                  "centres", "numbers"}, sweeps
names = {row["setting"]: row for row in rows}
for row in rows:
    assert row["psnr_held_both_linear"] != "" and float(row["psnr_linear"]) > 10, row
    assert float(row["core_s"]) > 0 and float(row["peak_bytes"]) > 1e5, row
# More rounds never fit worse than one by much, and the front is not empty.
one, many = names["joint medium; at most 1 rounds"], names["joint medium"]
assert float(many["psnr_linear"]) > float(one["psnr_linear"]) - 0.5
front = [row for row in rows if row["pareto_linear"] == "1"]
best = max(rows, key=lambda row: float(row["psnr_linear"]))
fastest = min(rows, key=lambda row: float(row["core_s"]))
assert best["pareto_linear"] == "1" and fastest["pareto_linear"] == "1", (best, fastest)
for row in front:
    for other in rows:
        assert not (float(other["core_s"]) < float(row["core_s"]) and
                    float(other["psnr_linear"]) > float(row["psnr_linear"])), (row, other)
P
expect_text "the summary names the machine" "processor" b/summary.md
expect_text "the summary names the directions left out" "Left out of encoding: 3 views and 3 lights" b/summary.md
if command -v gnuplot >/dev/null; then
    for plot in encode-tiny encode-paper-tiny storage-tiny readme-encode-tiny; do
        expect_that "plot $plot" test -s "b/$plot.png" -a -s "b/$plot.svg" -a -s "b/$plot.dat" -a -s "b/$plot.gp"
    done
else
    printf '[ RUN      ] plots\nskipped: no gnuplot\n[  SKIPPED ] plots\n'
fi

# Going on: rows stay as they were measured; a line that was cut short is measured again.
cp b/journal.csv before.csv
rows=$(($(wc -l <before.csv) - 5))
head -n $((rows + 1)) before.csv >b/journal.csv
sed -n $((rows + 2))p before.csv | cut -c1-40 | tr -d '\n' >>b/journal.csv
expect "goes on after a stop" 0 btf-bench --quick --input tiny --only machine,encode,storage --out b -q
expect_text "says how many rows were there" "^$rows rows come from before" b/summary.md
expect_that "keeps the rows it had, measures the others" python3 - $((rows + 1)) <<'P'
import sys
kept = int(sys.argv[1])
old, new = (open(path).read().splitlines() for path in ("before.csv", "b/journal.csv"))
assert kept > 9 and old[:kept] == new[:kept]
assert len(old) == len(new) and all(line.endswith(",end") for line in new[1:])
assert [line.split(",")[:3] for line in old] == [line.split(",")[:3] for line in new]
assert any(a != b for a, b in zip(old[kept:], new[kept:]))
P
expect "other settings, another run" 0 btf-bench --quick --input tiny --only machine --preset fast --repeats 2 --out b -q
expect_that "nothing of the other run is left" test -z "$(grep 'come from before' b/summary.md)"

mkdir -p none
printf '#!/bin/sh\nexit 1\n' >none/gnuplot
chmod +x none/gnuplot
expect "growth, without gnuplot" 0 env PATH="$PWD/none:$PATH" btf-bench --quick --input tiny --only growth --repeats 1 --out g -q
expect_that "growth has its table and no plot" test -s g/growth-tiny.csv -a ! -e g/growth-texels-tiny.png
expect_that "growth has finite exponents" python3 - <<'P'
import re
rows = [line.split("|") for line in open("g/summary.md") if re.match(r"\| (joint fast|paper) \|", line)]
import math
assert len(rows) == 4 and all(math.isfinite(float(row[i])) for row in rows for i in (3, 4)), rows
P

if "$build/tests/conformance/btf-conform" --device osmesa --count 10 --steps 10 >/dev/null 2>&1; then
    expect "decode" 0 btf-bench --quick --input tiny --only decode --device osmesa --out d -q
    expect_that "decode has its columns" python3 columns.py d/decode-tiny.csv
    expect_that "the CPU and the GPU decode alike" python3 - <<'P'
import csv
rows = [row for row in csv.DictReader(open("d/decode-tiny.csv")) if row["effects"] == "whole" and row["side"] == "0"]
def of(device, material, directions):
    return next(row for row in rows if (row["device"], row["material"], row["directions"], row["filter"], row["math"]) ==
                (device, material, directions, "texel", "exact"))
for material in {row["material"] for row in rows}:
    for directions in ("linear", "nearest"):
        a, b = (of(device, material, directions) for device in ("osmesa", "CPU reference"))
        for figure in ("psnr_linear", "psnr_srgb", "psnr_held_linear", "psnr_held_srgb"):
            assert a[figure] == b[figure] != "", (material, directions, figure, a[figure], b[figure])
P
else
    printf '[ RUN      ] decode\nskipped: no OSMesa\n[  SKIPPED ] decode\n'
fi

# Section plan: every cell is filled; kept materials are taken.
mkdir kept
expect "plan" 0 btf-bench --quick --input tiny --only plan --preset fast --holdout none --keep kept --out p -q
expect_that "keeps its materials" test -s kept/tiny-joint-fast.btf.exr -a -s kept/tiny-paper.btf.exr
cp p/plan-tiny.csv first.csv
touch -d 2001-01-01 kept/*
expect "plan of kept materials" 0 btf-bench --quick --input tiny --only plan --preset fast --holdout none --keep kept --out p2 -q
expect_that "does not encode again" test "$(find kept -newermt 2002-01-01 -name '*.exr' | wc -l)" = 0
expect_that "and fills every cell alike" python3 - <<'P'
import csv
rows, again = (list(csv.DictReader(open(name))) for name in ("first.csv", "p2/plan-tiny.csv"))
assert len(rows) == len(again) == 16
for a, b in zip(rows, again):
    assert all(a.values()), a
    for key in a:
        assert key in ("ns", "full_ns", "measured_time") or a[key] == b[key], (key, a, b)
P
expect "kept materials of other data" 1 btf-bench --quick --input tiny --size 4x4 --only plan --preset fast --holdout none --keep kept --out p3 -q
expect "an unknown section" 1 btf-bench --only nothing
expect "no data" 2 btf-bench --input missing --out x -q
expect "no folder" 2 btf-bench --quick --input tiny --out columns.py/x -q
OMP_WAIT_POLICY=passive expect "interrupted" 130 at "1 rename journal" INT btf-bench --materials bricks --size 24x24 --only encode --out i -q
expect_that "nothing to hold out" btf-bench --quick --input tiny --only encode --preset fast --holdout none --out n -q
expect_that "then no held-out figures" test -s n/encode-tiny.csv -a -z "$(cut -d, -f13 n/encode-tiny.csv | tail -n +2 | tr -d '\n')"
finish
