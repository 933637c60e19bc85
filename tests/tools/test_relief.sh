#!/bin/bash
# btf-encode --relief and --gloss: when they are found, refused and left out.
#
# SPDX-License-Identifier: MIT
. "$BTF_SOURCE_ROOT/tests/tools/common.sh" || exit 99
# Bumps lie below the plane of their highest points: grazing views show them displaced.
btf-sample -o data --relief bumps --grid 1024 --size 16 --directions 0:1,30:6,60:8 --format exr --quiet || exit 99

encode_aloud() { # NAME OPTION...
    local name=$1
    shift
    btf-encode data -o "$name.btf.exr" --preset fast --budget 40000 --report "$name.json" "$@"
}
encode() { encode_aloud "$@" -q; }
expect "relief and gloss, looked for" 0 encode found --relief auto --gloss auto --levels 3
expect "preset fast looks for neither" 0 encode fast
expect "off" 0 encode off --relief off --gloss off
expect "a share by name" 0 encode shared --gloss 2
cat >check.py <<'P'
import json, subprocess
def read(name):
    info = json.loads(subprocess.run(["btf-info", f"{name}.btf.exr", "--json"], capture_output=True, check=True).stdout)
    return json.load(open(f"{name}.json")), info
found, fast, off, shared = map(read, ("found", "fast", "off", "shared"))
relief = found[0]["relief"]
assert relief["chosen"] > 0 and any(r["relief"] for r in relief["rings"]), relief
assert relief["candidates"][0]["kind"] == "none" and relief["candidates"][0]["gain"] == 0, relief
assert "relief" in found[1]["effects"] and "relief=auto gloss=auto" in found[1]["options"], found[1]
assert "relief-chosen=" in found[1]["options"] and "relief-chosen=none" not in found[1]["options"], found[1]["options"]
for report, info in (fast, off):
    assert report["relief"] is None and "relief" not in info["effects"] and "gloss" not in info["effects"], info
    assert "relief=off gloss=0" in info["options"], info["options"]
assert "gloss" in shared[1]["effects"], shared[1]
end, judged = relief["end"], relief["levels"]
assert [l["level"] for l in judged] == list(range(1, len(judged) + 1)) and [l["relief"] for l in judged] == [l["level"] < end for l in judged], judged
assert end == found[1]["relief"]["end"] and 1 <= end <= 3 and f"relief-end={end} " in found[1]["options"], (end, found[1])
P
expect_that "files and reports say so" python3 check.py
cat >worth.py <<'P'
import json, subprocess
info = json.loads(subprocess.run(["btf-info", "found.btf.exr", "--json"], capture_output=True, check=True).stdout)
report = json.load(open("found.json"))
buys, between = info["buys"]["relief"], info["between"]
assert buys["between_samples"] and buys["bytes"] == 256, buys
gain = between["view"]["linear"] - between["view_without_relief"]["linear"]
assert abs(gain - buys["linear"]) < 1e-9 and gain > 0.7 and buys["srgb"] > 0.7, (buys, between)
assert between["both"]["linear"] > between["both_without_relief"]["linear"] and "light_without_relief" not in between, between
assert abs(report["between"]["view"]["linear_without_relief"] - between["view_without_relief"]["linear"]) < 1e-3, report["between"]
assert report["effects"]["relief"]["between_samples"] and not report["effects"]["residual"]["between_samples"], report["effects"]
off = json.loads(subprocess.run(["btf-info", "off.btf.exr", "--json"], capture_output=True, check=True).stdout)
assert "view" in off["between"] and "view_without_relief" not in off["between"], off["between"]
P
expect_that "a file tells what relief is worth between the samples" python3 worth.py
expect "in words" 0 btf-info found.btf.exr
expect_text "not by errors at the samples" "relief +acts between the samples only: \\+[0-9.]+ dB linear, .* where views are left out, for 256 bytes" out
expect_text "and the levels of detail that have it" "on [0-9]+ of [0-9]+ views, below level 1\$" out
expect_that "of the others the decoder's images are those without" sh -c 'btf-decode found.btf.exr -o on.exr --level 1 --view 40,10 --filter bilinear &&
    btf-decode found.btf.exr -o off.exr --level 1 --view 40,10 --filter bilinear --effects residual,gloss && cmp on.exr off.exr'
expect_that "of the first they are not" sh -c 'btf-decode found.btf.exr -o on.exr --view 40,10 && btf-decode found.btf.exr -o off.exr --view 40,10 --effects residual,gloss && ! cmp -s on.exr off.exr'
expect "gloss" 0 btf-info shared.btf.exr
expect_text "acts there too" "gloss +acts between the samples only: [-+][0-9.]+ dB linear, .* where views and lights are left out, for 0 bytes" out
cat >gloss.py <<'P'
import json, subprocess
info = json.loads(subprocess.run(["btf-info", "shared.btf.exr", "--json"], capture_output=True, check=True).stdout)
report = json.load(open("shared.json"))["between"]
between, buys = info["between"], info["buys"]["gloss"]
assert set(between) == {"view", "light", "both", "view_without_gloss", "both_without_gloss"}, between
assert buys["between_samples"] and buys["bytes"] == 0, buys
assert abs(between["both"]["linear"] - between["both_without_gloss"]["linear"] - buys["linear"]) < 1e-9, (buys, between)
assert abs(report["both"]["srgb_without_gloss"] - between["both_without_gloss"]["srgb"]) < 1e-3, (report, between)
assert between["both"] != between["both_without_gloss"] and "linear_without_gloss" not in report["light"], between
P
expect_that "a file tells what gloss is worth between the samples" python3 gloss.py
expect "a plan" 0 btf-info found.btf.exr --plan views=0:60,lights=0:60
expect_text "says so as well" "relief: on, worth \\+[0-9.]+/\\+[0-9.]+ dB between the samples" out
expect "of a picture half as large" 0 btf-info found.btf.exr --plan views=0:60,lights=0:60,pixels=0.5
expect_text "leaves it out" "relief: off, ends before level 1" out
expect_that "off is what fast does" cmp fast.btf.exr off.btf.exr
if [ -z "$light" ]; then
    expect "with threads" 0 encode again --relief auto --gloss auto --levels 3 --threads 3
    expect_that "the same bytes" cmp found.btf.exr again.btf.exr
fi
expect "samples that lie in a file" 0 encode_aloud disk --relief auto --memory "$(least_memory data --preset fast --budget 40000)"
expect_text "have no relief, which is said" "do not fit|does not fit" disk.json
expect_text "in the tables too" "^Relief: not tried: .*memory allowed" out
expect_text "and when it is decided" "relief: not tried: .*memory allowed" err
expect "another share is refused" 1 encode odd --gloss 3
expect_text "with those that there are" "auto.*off.*0.*1.*2" err
expect "the paper's method has no relief" 1 btf-encode data -o odd.btf.exr --method paper --relief auto
expect_text "which is said" "option --relief: for --method joint only" err
finish
