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
expect "truth between the samples" 0 btf-sample -o pairs --size 8x8 --between 20 --quiet
if [ -n "$light" ]; then # sections that encode only repeat what test_encode.sh does, a hundred times
    expect "machine" 0 btf-bench --quick --input tiny --only machine --out b -q
    expect_that "table has its columns" python3 columns.py b/machine-tiny.csv
    expect "an unknown section" 1 btf-bench --only nothing
    expect "no data" 2 btf-bench --input missing --out x -q
    expect "pairs of nothing" 1 btf-bench --pairs pairs --input tiny
    expect "unknown methods" 1 btf-bench --methods joint,none
    expect "nothing to decode" 1 btf-bench --methods peers
    expect "no folder" 2 btf-bench --quick --input tiny --out columns.py/x -q
    OMP_WAIT_POLICY=passive expect "interrupted" 130 at "1 rename journal" INT btf-bench --materials bricks --size 24x24 --only encode --out i -q
    finish
fi
expect "machine, encode, storage" 0 btf-bench --quick --input tiny --pairs pairs --only machine,encode,storage --holdout ring --out b -q
expect_that "tables have their columns" python3 columns.py b/encode-tiny.csv b/storage-tiny.csv b/machine-tiny.csv
expect_that "every sweep is there" python3 - <<'P'
import csv
rows = list(csv.DictReader(open("b/encode-tiny.csv")))
sweeps = {row["sweep"] for row in rows}
assert sweeps == {"paper", "preset", "tolerance", "budget", "lobes", "rejection", "lights voted", "window",
                  "centres", "numbers"}, sweeps
names = {row["setting"]: row for row in rows}
for row in rows:
    assert row["psnr_held_both_linear"] != "" and float(row["psnr_linear"]) > 10, row
    assert float(row["psnr_between_linear"]) > 10 and float(row["psnr_estimate_srgb"]) > 10, row
    assert float(row["core_s"]) > 0 and float(row["peak_bytes"]) > 1e5, row
front = [row for row in rows if row["pareto_linear"] == "1"]
# Of settings with the same result only the cheapest is on the front.
best = max(rows, key=lambda row: (float(row["psnr_between_linear"]), -float(row["core_s"])))
fastest = min(rows, key=lambda row: (float(row["core_s"]), -float(row["psnr_between_linear"])))
assert best["pareto_linear"] == "1" and fastest["pareto_linear"] == "1", (best, fastest)
for row in front:
    for other in rows:
        assert not (float(other["core_s"]) < float(row["core_s"]) and
                    float(other["psnr_between_linear"]) > float(row["psnr_between_linear"])), (row, other)
stored = {row["setting"]: row for row in csv.DictReader(open("b/storage-tiny.csv"))}
assert {row["sweep"] for row in stored.values()} >= {"joint", "paper", "PCA linear", "split PCA", "low-bit PCA",
                                                     "uncompressed", "splines"}, stored
assert stored["uncompressed; splines"]["psnr_linear"] == "" != stored["uncompressed; splines"]["psnr_between_srgb"]
P
expect_text "the summary names the machine" "processor" b/summary.md
expect_text "the summary names the truth" "Truth between the samples of tiny: 20 images of pairs" b/summary.md
expect_text "the summary names the directions left out" "Left out of encoding: 3 views and 3 lights" b/summary.md
if command -v gnuplot >/dev/null; then
    for plot in encode-tiny encode-paper-tiny storage-tiny readme-encode-tiny readme-storage-tiny; do
        expect_that "plot $plot" test -s "b/$plot.png" -a -s "b/$plot.svg" -a -s "b/$plot.dat" -a -s "b/$plot.gp"
    done
else
    printf '[ RUN      ] plots\nskipped: no gnuplot\n[  SKIPPED ] plots\n'
fi

# Stochastic decode: noise falls with the root of the number of samples, and is largest where most is picked; at the
# samples the blends equal the full decode.
expect "stochastic" 0 btf-bench --quick --input tiny --only stochastic --preset fast --repeats 1 --out s -q
expect_that "noise halves with four times the samples" python3 - <<'P'
import csv
rows = {row["decoded"]: row for row in csv.DictReader(open("s/stochastic-tiny.csv"))}
picked = ["view picked", "view and light picked", "all picked"]
noise = {name: [float(row[f"rms_{n}"]) for n in (1, 4, 16, 64)] for name, row in rows.items() if row["rms_4"]}
assert list(noise)[:3] == picked and len(noise) == 4, noise
for name, rms in noise.items():
    assert all(1.8 < a / b < 2.2 for a, b in zip(rms, rms[1:])), (name, rms)
assert all(noise[a][i] < noise[b][i] for a, b in zip(picked, picked[1:]) for i in range(4)), noise
P
expect_text "blends are the full decode at the samples" '^. of views and lights . equal . [0-9.]+ / ' s/summary.md

# Going on: rows stay as they were measured; a line that was cut short is measured again.
cp b/journal.csv before.csv
rows=$(($(wc -l <before.csv) - 5))
head -n $((rows + 1)) before.csv >b/journal.csv
sed -n $((rows + 2))p before.csv | cut -c1-40 | tr -d '\n' >>b/journal.csv
expect "goes on after a stop" 0 btf-bench --quick --input tiny --pairs pairs --only machine,encode,storage --holdout ring --out b -q
expect_text "says how many rows were there" "^$rows rows were measured before the run was stopped" b/summary.md
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

# Between the samples: all figures are those of btf-compare; without truth they are estimates.
btf_between() { btf-bench --input tiny "$@" --only between --preset fast --repeats 1 -q; }
expect "between" 0 btf_between --pairs pairs --out e
expect "between, without truth" 0 btf_between --out f
expect "between, ray-cast" 0 btf-bench --materials bricks --size 4x4 --only between --preset fast --repeats 1 --out r -q
expect "the same data as images" 0 btf-sample -o same --grid 1024 --size 4x4 --format exr --quiet
expect "the same truth as images" 0 btf-sample -o same_pairs --grid 1024 --size 4x4 --between 100 --quiet
expect "encodes" 0 btf-encode tiny -o tiny.btf.exr --preset fast --quiet
for data in tiny same; do
    for kind in linear spline; do
        btf-compare "$data" "$([ $data = tiny ] && echo pairs || echo same_pairs)" --interpolation $kind --json >"$data-$kind.json" 2>err
    done
done
btf-compare tiny.btf.exr pairs --json >tiny-joint.json 2>err
btf-compare tiny tiny.btf.exr --json >at.json 2>err
cat >between.py <<'P'
import csv, json
def rows(path):
    return {row["setting"]: row for row in csv.DictReader(open(path))}
def check(row, path, key="between", column="psnr_between"):
    figures = json.load(open(path))[key]
    for kind in ("linear", "srgb"):
        assert abs(float(row[f"{column}_{kind}"]) - figures[kind]) < 2e-3, (row, path, figures[kind])
given, none, cast = rows("e/between-tiny.csv"), rows("f/between-tiny.csv"), rows("r/between-bricks.csv")
assert list(cast) == list(given), list(cast)
assert list(given) == list(none) == [
    "joint fast", "joint fast; --fit samples", "paper", "PCA 8 bit linear", "PCA 8 bit square root", "split PCA 8 bit", "low-bit split PCA",
    "uncompressed; barycentric", "uncompressed; splines"], list(given)
for of, data in ((given, "tiny"), (cast, "same")):
    check(of["uncompressed; barycentric"], data + "-linear.json")
    check(of["uncompressed; splines"], data + "-spline.json")
check(given["joint fast"], "tiny-joint.json")
check(given["joint fast"], "at.json", "psnr", "psnr")
for name in given:
    assert none[name]["psnr_between_linear"] == none[name]["psnr_between_srgb"] == "", name
    for kind in ("linear", "srgb"):  # the estimate does not depend on truth, and differs from the figure at the samples
        assert none[name]["psnr_estimate_" + kind] == given[name]["psnr_estimate_" + kind] != "", name
        assert given[name]["psnr_estimate_" + kind] != given[name]["psnr_" + kind], name
# A codec that almost equals the data at the samples has almost their accuracy between them.
near, data = given["low-bit split PCA"], given["uncompressed; barycentric"]
assert float(near["psnr_linear"]) > 45
for kind in ("between", "estimate"):
    assert abs(float(near[f"psnr_{kind}_linear"]) - float(data[f"psnr_{kind}_linear"])) < 0.1, (kind, near, data)
P
expect_that "are the figures of btf-compare" python3 between.py
# The best peer alone, for peers.sh.
expect "low-bit" 0 btf-bench --input tiny --only lowbit --out l -q
expect_that "is that of section between" python3 - <<'P'
import csv
alone, = csv.DictReader(open("l/lowbit-tiny.csv"))
among = {row["setting"]: row for row in csv.DictReader(open("e/between-tiny.csv"))}["low-bit split PCA"]
assert int(alone["bytes"]) == int(float(among["gpu_bytes"])) <= int(alone["budget"]), (alone, among)
for kind in ("linear", "srgb"):
    assert abs(float(alone[kind + "_db"]) - float(among["psnr_" + kind])) < 2e-3, (kind, alone, among)
P
expect "peers: the list" 0 "$BTF_SOURCE_ROOT/tests/bench/peers.sh" --list
expect_text "has its materials" "^UBO_IMPALLA64 += UBO_IMPALLA64.zip$" out
expect "peers: nothing said" 1 "$BTF_SOURCE_ROOT/tests/bench/peers.sh"
expect "peers: another table" 1 "$BTF_SOURCE_ROOT/tests/bench/peers.sh" "$build" others
expect_text "without truth it says so" "none is known, so accuracy there is estimated" f/summary.md
expect "images of another size" 0 btf-sample -o larger --size 9x8 --between 2 --quiet
expect "truth of another size" 3 btf-bench --input tiny --pairs larger --only machine --out x -q
expect_text "says which" "larger has 9 x 8 texels, tiny has 8 x 8" err
expect "pairs of nothing" 1 btf-bench --pairs pairs --input tiny
# A journal of another version is not read, nor are lines whose number of fields is that of another version.
sed -e '1s/journal 2;/journal 1;/' -i e/journal.csv
expect "a journal of another version" 0 btf_between --pairs pairs --out e
expect_that "is not gone on from" test -z "$(grep 'come from before' e/summary.md)"
sed -e '2,$s/,[^,]*,[^,]*,end$/,end/' -i e/journal.csv
expect "a journal of fewer columns" 0 btf_between --pairs pairs --out e
expect_that "is not misread" python3 between.py
expect_that "nor gone on from" test -z "$(grep 'come from before' e/summary.md)"

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

if "$build/tests/conformance/btf-conform" --device osmesa --variant 3 --count 10 --steps 10 >/dev/null 2>&1; then
    expect "decode" 0 btf-bench --quick --input tiny --pairs pairs --holdout ring --only decode --device osmesa --methods joint,paper,reference --out d -q
    expect_that "decode has its columns" python3 columns.py d/decode-tiny.csv
    cat >decode.py <<'P'
import csv, sys
rows = [row for row in csv.DictReader(open("d/decode-tiny.csv")) if row["side"] == "0"]
def of(device, material, directions="linear", effects="whole", math="exact"):
    found = [row for row in rows if (row["device"], row["material"], row["directions"], row["effects"], row["filter"],
                                     row["math"]) == (device, material, directions, effects, "texel", math)]
    assert len(found) == 1, (device, material, directions, effects, math, found)
    return found[0]
ours = {row["material"] for row in rows if row["device"] == "CPU reference"}
assert ours == {"joint", "joint; half the bytes", "paper"}, ours
for material in ours:
    for directions in ("linear",) if "joint;" in material else ("linear", "nearest"):
        a, b, c = (of(device, material, directions) for device in ("osmesa", "CPU reference", "CPU evaluator"))
        for figure in ("psnr_linear", "psnr_srgb", "psnr_held_linear", "psnr_held_srgb", "psnr_between_linear",
                       "psnr_between_srgb", "fetches", "fetched_bytes", "integer_operations", "float_operations"):
            assert a[figure] == b[figure] == c[figure] != "", (material, directions, figure, a[figure], b[figure], c[figure])
# Every material has rows of its fetches alone and of native mathematics, and counts.
for material in ours:
    whole, floor = of("osmesa", material), of("osmesa", material, effects="fetches only")
    assert whole["fetches"] == floor["fetches"] != "0" and floor["integer_operations"] == "0", (whole, floor)
    assert float(whole["ns"]) > 0 and float(floor["ns"]) > 0 and int(whole["gpu_bytes"]) > 0
    assert float(of("osmesa", material, math="fast")["ns"]) > 0
joint, half = (of("osmesa", name) for name in ("joint", "joint; half the bytes"))
assert int(half["gpu_bytes"]) < int(joint["gpu_bytes"]), (joint, half)
for effects in ("whole; one view", "whole; one light", "half the components", "a quarter of the components"):
    part = of("osmesa", "joint", effects=effects)
    assert 0 < int(part["fetches"]) < int(joint["fetches"]), part
P
    expect_that "the CPU and the GPU decode alike, and counts are there" python3 decode.py
    expect_text "both formats stand beside each other" "^\\| joint \\| whole, linear, texel " d/summary.md
    expect_text "the README's rows have joint" "^\\| joint: half the bytes \\|" d/readme-decode-tiny.md
    expect "conformance and decoding for a GPU" 0 env QUICK=1 OUT="$work/gpu" "$BTF_SOURCE_ROOT/tests/bench/gpu.sh" "$build" osmesa tiny --variant 3 --count 10 --steps 10
    expect_text "prints what it found" "^\\| joint; half the bytes \\|" out
    expect_that "and keeps it, of the methods asked for" python3 - <<'P'
import csv, os
rows = list(csv.DictReader(open("gpu/decode-tiny.csv")))
assert {row["material"].split(";")[0] for row in rows} == {"joint", "paper", "PCA", "Phong", "uncompressed"}
assert {row["device"] for row in rows} == {"osmesa"} and os.path.getsize("gpu/conform.txt") > 0
costs = list(csv.DictReader(open("gpu/costs-tiny.csv")))
assert len(costs) > 8 and all(float(row["ns"]) > 0 and float(row["predicted_ns"]) > 0 for row in costs)
P
    expect_text "prints the prices" "^Prices in ns on .*llvmpipe" out
    expect "plans go by the prices that were fitted" 0 btf-info tiny.btf.exr --plan all --costs gpu/costs.json
else
    printf '[ RUN      ] decode\nskipped: no OSMesa\n[  SKIPPED ] decode\n'
fi

# Section plan: every cell is filled; kept materials are used again.
expect "plan" 0 btf-bench --quick --input tiny --only plan --preset fast --holdout none --keep kept --out p -q
expect_that "keeps its materials" test -s kept/tiny-joint-fast.btf.exr -a -s kept/tiny-paper.btf.exr
cp p/plan-tiny.csv first.csv
touch -d 2001-01-01 kept/*
expect "plan of kept materials" 0 btf-bench --quick --input tiny --only plan --preset fast --holdout none --keep kept --out p2 -q
expect_that "does not encode again" test "$(find kept -newermt 2002-01-01 -name '*.exr' | wc -l)" = 0
expect_that "and fills every cell alike" python3 - <<'P'
import csv
rows, again = (list(csv.DictReader(open(name))) for name in ("first.csv", "p2/plan-tiny.csv"))
assert len(rows) == len(again) == 18
assert [row["fold"] for row in rows if "joint" in row["method"] and "still" in row["scene"]] == ["light", "none", "both"]
for a, b in zip(rows, again):
    assert all(a.values()), a
    for key in a:
        assert key in ("ns", "full_ns", "folded_ns", "measured_time") or a[key] == b[key], (key, a, b)
P
expect "kept materials of other data" 1 btf-bench --quick --input tiny --size 4x4 --only plan --preset fast --holdout none --keep kept --out p3 -q
expect "an unknown section" 1 btf-bench --only nothing
expect "no data" 2 btf-bench --input missing --out x -q
expect "no folder" 2 btf-bench --quick --input tiny --out columns.py/x -q
OMP_WAIT_POLICY=passive expect "interrupted" 130 at "1 rename journal" INT btf-bench --materials bricks --size 24x24 --only encode --out i -q
expect_that "nothing to hold out" btf-bench --quick --input tiny --only encode --preset fast --out n -q
expect_that "then no held-out figures" python3 - <<'P'
import csv
rows = list(csv.DictReader(open("n/encode-tiny.csv")))
assert rows and not any(value for row in rows for key, value in row.items() if key.startswith("psnr_held")), rows
P
finish
