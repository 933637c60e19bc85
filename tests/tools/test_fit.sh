#!/bin/bash
# btf-encode --fit: whether values at views and lights are fitted for directions between them, or are the samples.
#
# SPDX-License-Identifier: MIT
. "$BTF_SOURCE_ROOT/tests/tools/common.sh" || exit 99
relief="--relief flat --size 8 --directions 0:1,25:6,50:12,70:16"
btf-sample -o data $relief --format exr --quiet && btf-sample -o pairs $relief --between 60 --quiet || exit 99

encode() { # NAME OPTION...
    local name=$1
    shift
    btf-encode data -o "$name.btf.exr" -q --preset fast --effects residual --effect-tolerance 0 --budget 100000 --report "$name.json" "$@" &&
        btf-compare "$name.btf.exr" pairs --json -q >"$name.between.json" && btf-info "$name.btf.exr" --json >"$name.info.json"
}
expect "a fit, which is the default" 0 encode fitted
expect "the samples" 0 encode samples --fit samples
cat >fit.py <<'P'
import json
def read(name):
    return [json.load(open(f"{name}{kind}.json")) for kind in ("", ".between", ".info")]
fitted, samples = read("fitted"), read("samples")
assert fitted[0]["fit"]["chosen"] > 0, fitted[0]["fit"]
for kind in ("linear", "srgb"):
    between = [r[1]["between"][kind] for r in (fitted, samples)]
    at = [r[0]["psnr"]["full"][kind] for r in (fitted, samples)]
    print(kind, "between, fitted and samples:", between, "at the samples:", at)
    assert between[0] > between[1] + 0.1 and at[0] < at[1], (kind, between, at)
assert fitted[2]["bytes"]["gpu"] == samples[2]["bytes"]["gpu"]
options = [r[2]["options"] for r in (fitted, samples)]
assert "fit=between" in options[0] and "fit-kappa=" in options[0] and "fit-kappa=none" not in options[0], options
assert "fit=samples" in options[1] and "kappa" not in options[1], options
candidates = fitted[0]["fit"]["candidates"]
assert candidates[0]["kappa_views"] is None and len(candidates) > 3
for c in candidates[1:]:  # stronger fits cost more at the samples
    assert c["at_srgb"] < 100 and c["left_out_srgb"] > 10, c
# both reports state errors at and between the samples for both choices; those of the choice not taken are predictions,
# right within 2 dB at the samples and 4 dB between
for mine, other in ((fitted, samples), (samples, fitted)):
    fit, place = mine[0]["fit"], other[0]["fit"]["chosen"]
    assert fit["best"] == fitted[0]["fit"]["chosen"] and samples[0]["fit"]["chosen"] == 0, fit
    for kind in ("linear", "srgb"):
        at, between = [[c for c in fit["candidates"] if c["candidate"] == place][0][f"coded_{where}_{kind}"] for where in ("at", "between")]
        really = other[0]["psnr"]["full"][kind], other[1]["between"][kind]
        print(kind, "expected of", other[0]["fit"]["chosen"], (at, between), "measured", really)
        assert abs(at - really[0]) < 2 and abs(between - really[1]) < 4, (kind, at, between, really)
    taken = [c for c in fit["candidates"] if c["candidate"] == fit["chosen"]][0]
    assert abs(taken["coded_at_linear"] - mine[0]["psnr"]["full"]["linear"]) < 1e-6, taken
    assert taken["allowed"], taken
assert all(a["at_srgb"] > b["at_srgb"] for a, b in zip(candidates[1:], candidates[2:])), candidates
P
expect_that "is better between the samples, worse at them, of as many bytes; the file and the report say so" python3 fit.py
cat that

if [ -z "$light" ]; then
    expect "with threads" 0 encode again --threads 3
    expect_that "the same bytes" cmp fitted.btf.exr again.btf.exr
fi
expect "from a scratch file" 0 encode disk --memory "$(least_memory data --preset fast --budget 100000)"
expect_that "the same bytes" cmp fitted.btf.exr disk.btf.exr
expect "the paper's method keeps the samples" 0 btf-encode data -o paper.btf.exr -q --method paper --starts 1 --report paper.json
expect_text "without a word of a fit" '"options"' paper.json
expect_that "in its report" test "$(grep -c '"fit": {' paper.json)" = 0
expect "or fits them when asked" 0 btf-encode data -o paper.btf.exr -q --method paper --starts 1 --fit between
expect_text "and says so" "fit-kappa" <(btf-info paper.btf.exr --json)

# For lists of directions through which no spline goes, the encode uses the samples.
for directions in 0:1 0:1,40:1 0:1,30:1,60:1; do
    btf-sample -o few --relief bumps --size 4 --directions $directions --quiet || exit 99
    expect "directions $directions" 0 btf-encode few -o few.btf.exr -q --preset fast
    expect_text "have no fit" "fit-kappa=none" <(btf-info few.btf.exr --json)
    rm -rf few
done
expect "another fit is refused" 1 btf-encode data -o x.btf.exr --fit smooth
expect_text "with those that there are" "between.*samples" err
finish
