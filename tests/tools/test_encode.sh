#!/bin/bash
# btf-encode and btf-compare: the effect of every option.
#
# SPDX-License-Identifier: MIT
. "$BTF_SOURCE_ROOT/tests/tools/common.sh" || exit 99
small_data
levels=5
[ $side = 8 ] && levels=4

json() { python3 -c "import json,sys; r=json.load(open('$1')); print($2)"; }

for tool in btf-encode btf-compare btf-info btf-decode btf-sample; do
    expect "$tool --help" 0 $tool --help
    expect_text "$tool --help shows an example" "xample" out
    expect "$tool --version" 0 $tool --version
    expect "$tool --no-such-option is refused" 1 $tool --no-such-option
    expect_text "$tool names the option" "no-such-option" err
done

expect "paper" 0 btf-encode data -o paper.btf.exr --method paper $starts --report paper.json --pictures pictures --threads 2
for picture in montage abrdf steps shadow flow hidden atlas; do
    expect_that "picture $picture" test -s pictures/$picture.png
done
expect_text "table 1" "Table 1" out
expect_text "table 2" "Table 2" out
expect_that "the report has every member" python3 - <<'P'
import json
r = json.load(open("paper.json"))
for member in ("bytes", "ratio", "seconds", "peak_rss", "psnr", "hidden", "effects", "reading", "options"):
    assert member in r, member
assert set(r["psnr"]) == {"sbrdf", "stvs", "full"}
for step in r["psnr"].values():
    assert {"linear", "srgb", "rings"} <= set(step)
assert {"file", "gpu", "parts"} <= set(r["bytes"])
assert {"before", "after", "total"} <= set(r["hidden"])
assert r["seconds"]["total"] > 0 and r["peak_rss"] > 1e6
P
expect "a report through a pipe" 0 bash -c 'set -o pipefail; btf-encode data -o pipe.btf.exr --method paper '"$starts"' --report /dev/stdout -q | python3 -c "import json,sys; json.load(sys.stdin)"'
expect_that "the report has the options used" python3 - <<'P'
import json
options = json.load(open("paper.json"))["options"]
for name in ("transfer", "colour", "effects", "layout", "lobes", "starts", "hidden-threshold", "window"):
    assert name in options, name
P
expect "one thread" 0 btf-encode data -o one.btf.exr --method paper $starts --threads 1 -q
expect "two threads" 0 btf-encode data -o two.btf.exr --method paper $starts --threads 2 -q
expect_that "the same bytes for any number of threads" cmp one.btf.exr two.btf.exr
rings=0:1,20:6,40:9,60:12 directions=28 size=12x10
[ -n "$light" ] && rings=0:1,30:6,60:9 directions=16 size=6x5
btf-sample -o wide --relief bricks --size $size --directions $rings --quiet || exit 99
for how in "paper $starts" "joint --preset fast"; do
    expect "$how in memory" 0 btf-encode wide -o wide.btf.exr --method $how -q
    expect "$how, too little memory" 1 btf-encode wide -o scratch.btf.exr --method $how --memory 1 -q
    expect_text "the least is named" "$size texels, $directions views and $directions lights take at least" err
    expect "a scratch file" 0 env TMPDIR="$work" btf-encode wide -o scratch.btf.exr --method $how \
        --memory "$(least_memory wide --method $how)"
    expect_text "it is announced" "samples: .* scratch file in $work" err
    expect_that "the same bytes through a scratch file" cmp wide.btf.exr scratch.btf.exr
done

printf '1 0 0 4 90\n2 40 0 44 0\n' >moved.txt
expect "lights that stood aside" 0 btf-encode data -o moved.btf.exr --method paper $starts --coincident moved.txt
expect_text "their error is told apart" "light at the view: sbrdf" out
expect_that "they change the fit" bash -c '! cmp -s moved.btf.exr one.btf.exr'
printf '15 0 16 0\n' >strange.txt
expect "a direction that the data lack" 3 btf-encode data -o strange.btf.exr --coincident strange.txt
expect_text "file and line are named" "strange.txt: line 1" err

expect "no effects" 0 btf-encode data -o none.btf.exr --method paper $starts --effects none --report none.json -q
expect_that "no effects, no maps" test "$(json none.json "'maps' in r['bytes']['parts']")" = False
btf-sample -o lit --size 4 --directions small --quiet || exit 99
python3 - <<'P' || exit 99
import pathlib, struct, zlib
for i, path in enumerate(sorted(pathlib.Path("lit").rglob("*.png"))):  # black, but for a texel of one image
    pixels = [255 if i == 200 and byte < 3 else 0 for byte in range(48)]
    rows = b"".join(b"\0" + bytes(pixels[row : row + 12]) for row in range(0, 48, 12))
    chunks = ((b"IHDR", struct.pack(">IIBBBBB", 4, 4, 8, 2, 0, 0, 0)), (b"IDAT", zlib.compress(rows)), (b"IEND", b""))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)) for kind, data in chunks))
P
expect "worse than the diffuse fit" 0 btf-encode lit -o lit.btf.exr --method paper --starts 1 --report lit.json -q
expect_text "the diffuse fit is taken" "diffuse fit alone, so the diffuse fit is taken" err
expect_that "the report has it" test "$(json lit.json "r['trials'][-1]['verdict']")" = "diffuse fit: taken"
expect "exactly these effects" 0 btf-encode lit -o lit.btf.exr --method paper $starts --effects shadow --report lit.json -q
expect_that "the diffuse fit is not tried" test "$(json lit.json "len(r['trials'])")" = 0
expect "shadow alone" 0 btf-encode data -o shadow.btf.exr --method paper $starts --effects shadow -q
expect "layout tight" 0 btf-encode data -o tight.btf.exr --method paper $starts --layout tight -q
expect "tight against paper" 0 btf-compare tight.btf.exr paper.btf.exr --json -q
expect_text "layouts decode alike" '"linear": 100' out
expect "half floats" 0 btf-encode data -o half.btf.exr --method paper $starts --lobes 3 --half --report half.json -q
expect_that "half floats halve the parameters" test "$(json half.json "r['bytes']['parts']['sbrdf']")" = $((side * side * 32))
expect "one lobe" 0 btf-encode data -o lobe.btf.exr --method paper $starts --lobes 1 -q
expect "size" 0 btf-encode data -o size.btf.exr --method paper $starts --size 4x6 --report size.json -q
expect_that "size is taken" test "$(json size.json "(r['width'], r['height'])")" = "(4, 6)"
expect "crop" 0 btf-encode data -o crop.btf.exr --method paper $starts --crop 2,3,5,4 --report crop.json -q
expect_that "crop is taken" test "$(json crop.json "(r['width'], r['height'])")" = "(5, 4)"
expect "transfer" 0 btf-encode data -o transfer.btf.exr --method paper $starts --transfer gamma:2.2 -q
expect "orientation" 0 btf-encode data -o turned.btf.exr --method paper $starts --flip-v --azimuth-cw --azimuth-offset 30 -q
expect_text "the file tells how it was made" "rounds=3" <(btf-info paper.btf.exr)
expect "rounds, thresholds, window, centres" 0 btf-encode data -o many.btf.exr --method paper $starts --rounds 1 --starts 1 \
    --error-threshold 1 --btf-threshold 0.5 --flow-lights 3 --hidden-threshold 0.2 --window 5x5 --centres 9 \
    --data-points -q
expect "more centres than the smallest atlas holds" 0 btf-encode data -o centres.btf.exr --method paper $starts \
    --hidden-threshold 0.2 --centres 300 -q

expect "strict" 0 btf-encode data -o strict.btf.exr --method paper $starts --strict -q
expect_that "strict changes nothing where nothing is negative" python3 - <<'P'
import subprocess
out = subprocess.run(["btf-compare", "strict.btf.exr", "one.btf.exr", "--json", "-q"], capture_output=True, text=True).stdout
assert '"linear": 100' in out, out
P
expect "XYZ" 0 btf-encode data -o xyz.btf.exr --method paper $starts --colour xyz --report xyz.json -q
expect_text "a warning stays under -q" "warning: .* samples below 0" err
expect_that "the report has what reading said" test "$(json xyz.json "[m['level'] for m in r['reading'] if 'below 0' in m['text']]")" = "['warning']"
expect_that "XYZ is recorded" test "$(json xyz.json "r['options']['colour']")" = xyz
expect "compare reads XYZ too" 0 btf-compare data xyz.btf.exr --colour xyz --json -q
expect "strict refuses what XYZ makes of such colours" 3 btf-compare data xyz.btf.exr --colour xyz --strict -q
expect_text "and names the value" "is below 0 \(-0\.[0-9]+\)" err
expect "an unknown colour space" 1 btf-encode data -o x.btf.exr --colour cmyk
expect "joint: a budget" 0 btf-encode data -o joint.btf.exr --preset fast --budget 20k --report joint.json -q
expect_that "joint: the budget is kept" test "$(json joint.json "r['bytes']['gpu'] <= 20000")" = True
expect_that "joint: the report lists what was tried" test "$(json joint.json "[t['verdict'] for t in r['trials'] if t['lobes'] == 0]")" = "['best']"
expect "an option that was removed" 1 btf-encode data -o x.btf.exr --metric linear -q
expect_text "is refused with what to do" "option --metric: it was removed; .* leave it out" err
expect_that "and not told by --help" test -z "$(btf-encode --help | grep -- --metric)"
expect "a method that was removed" 1 btf-encode data -o x.btf.exr --method factors -q
expect_text "is refused with those there are" "is not one of joint.paper" err
expect "joint: an option of the paper's method" 1 btf-encode data -o x.btf.exr --lobes 2 -q
expect_text "is refused by name" "option --lobes: for --method paper only" err
expect "paper: an option of the joint method" 1 btf-encode data -o x.btf.exr --method paper $starts --budget 1M -q
expect_text "is refused by name" "option --budget: for --method joint only, not for paper" err
for tolerance in a 0.05, ,1 0.05,0.2,1 0.05x -1 nan 101 ""; do
    expect "no tolerance: '$tolerance'" 1 btf-encode data -o x.btf.exr --effect-tolerance "$tolerance"
done
expect "joint: quality" 0 btf-encode data -o joint.btf.exr --preset fast --quality 15 --report joint.json -q
expect_that "joint: the quality is reached" test "$(json joint.json "r['psnr']['full']['srgb'] >= 15")" = True

for option in --levels=4294967297 "--levels= 1" "--transfer=gamma: 2" --memory=0 --budget=0.5; do
    expect "$option" 1 btf-encode data -o x.btf.exr "$option"
    expect_text "is refused with option and value" "option ${option%%=*}: '${option#*=}' is not" err
done
expect "levels" 0 btf-encode data -o levels.btf.exr --preset fast --levels all --report levels.json --threads 1
expect_text "a table of levels" "^  $((levels - 1)) +1 x 1 " out
expect_text "and their bytes" '^  full, all levels ' out
expect "levels, two threads" 0 btf-encode data -o levels2.btf.exr --preset fast --levels all --threads 2 -q
expect_that "the same bytes for any number of threads, with levels" cmp levels.btf.exr levels2.btf.exr
btf-info levels.btf.exr --json >info.json
expect_that "levels in report and file" python3 - $side $levels <<'P'
import json, sys
side, levels = map(int, sys.argv[1:])
report, info = json.load(open("levels.json")), json.load(open("info.json"))
assert [(l["width"], l["height"]) for l in report["levels"]] == [(side >> i, side >> i) for i in range(levels)]
for a, b in zip(report["levels"], info["levels"]):
    assert a["gpu"] == b["gpu"] and abs(a["linear"] - b["linear"]) < 1e-4 and abs(a["srgb"] - b["srgb"]) < 1e-4
further = sum(l["gpu"] for l in info["levels"][1:])
assert report["bytes"]["levels"] == further and report["bytes"]["gpu"] == further + info["levels"][0]["gpu"]
texels = info["levels"][0]["gpu"] - info["textures"]["factor_directions"]["bytes"]
assert 0.25 * texels < further < 0.34 * texels, (further, texels)
assert report["options"]["levels"] == "all"
P
expect_text "btf-info tells of each level" "^  $((levels - 2))  2 x 2 .* bytes +[0-9.]+ / +[0-9.]+" <(btf-info levels.btf.exr)
expect "levels through a scratch file" 0 env TMPDIR="$work" btf-encode data -o levels2.btf.exr --preset fast --levels all --memory "$(least_memory data --preset fast)" -q
expect_that "the same bytes through a scratch file, with levels" cmp levels.btf.exr levels2.btf.exr
for level in $(seq $((levels - 2))); do
    size=$((side >> level))
    expect "level $level decoded by the reference" 0 btf-decode levels.btf.exr -o level$level --all --level $level --format exr
    expect "against the original, filtered to $size x $size as images" 0 btf-compare data level$level --size ${size}x$size --json -q
    cp out compared.json
    expect_that "is as good as the file says" test "$(json compared.json "abs(r['psnr']['linear'] - json.load(open('info.json'))['levels'][$level]['linear']) < 0.02")" = True
done
expect "levels of the paper's method" 0 btf-encode data -o plevels.btf.exr --method paper $starts --levels 3 --report plevels.json -q
expect_that "in layout tight" test "$(json plevels.json "(r['options']['layout'], len(r['levels']))")" = "('tight', 3)"
expect "a checkpoint of level 0 is not for the others" 0 btf-encode data -o clevels.btf.exr --method paper $starts --levels 3 \
    --checkpoint steps -q
expect_that "the same bytes" cmp plevels.btf.exr clevels.btf.exr
expect "one level is no table of levels" 0 btf-encode data -o onelevel.btf.exr --method paper $starts --levels 1 --threads 1 -q
expect_that "and the same maps as without the option" btf-compare onelevel.btf.exr paper.btf.exr -q
expect "levels in layout paper" 1 btf-encode data -o x.btf.exr --method paper $starts --layout paper --levels 2
expect_text "are refused" "option --levels: --layout paper has one level" err
expect "more levels than there are" 1 btf-encode data -o x.btf.exr --levels $((levels + 1))
expect_text "are refused with their number" "option --levels: $((levels + 1)), but $side x $side texels have only $levels levels" err
expect "no levels" 1 btf-encode data -o x.btf.exr --levels 0

expect "compare" 0 btf-compare data paper.btf.exr
expect_text "compare prints PSNR" "PSNR linear [0-9.]+ dB" out
expect "compare nearest" 0 btf-compare data paper.btf.exr --interpolation nearest --effects none --no-ssim --json
expect "compare a set with itself" 0 btf-compare data data --json
expect_text "no error against itself" '"linear": 100' out
expect_that "compare agrees with the report" python3 - <<'P'
import json, subprocess
report = json.load(open("paper.json"))["psnr"]["full"]
compared = json.loads(subprocess.run(["btf-compare", "data", "paper.btf.exr", "--json", "-q"], capture_output=True).stdout)
for key in ("linear", "srgb", "ssim"):
    assert abs(report[key] - compared["psnr"][key]) < 2e-3, (key, report[key], compared["psnr"][key])
P
finish
