#!/usr/bin/env bash
# Accuracy between the samples: btf-sample writes pairs of view and light, btf-compare measures against them.
#
# SPDX-License-Identifier: MIT
. "$(dirname "$0")/common.sh"
relief=(--relief bumps --size 8 --supersample 1 --grid 256 -q)
rings=0:1,30:6,65:10
expect "a data set" 0 btf-sample -o data --directions $rings --format exr "${relief[@]}"
expect "pairs between its samples" 0 btf-sample -o pairs --between 30 "${relief[@]}"
expect_that "thirty of them, named with decimals" bash -c \
    'ls pairs | grep -Ecx "tl[0-9]{2}\.[0-9]{4}_pl[0-9]{3}\.[0-9]{4}_tv[0-9]{2}\.[0-9]{4}_pv[0-9]{3}\.[0-9]{4}\.exr" | grep -qx 30'
expect "again" 0 btf-sample -o again --between 30 --threads 1 "${relief[@]}"
expect_that "the same bytes" diff -r pairs again
expect "other pairs" 0 btf-sample -o others --between 30 --pair-seed 1 "${relief[@]}"
expect_that "have other names" test -z "$(comm -12 <(ls pairs) <(ls others))"
expect "as JPEG" 0 btf-sample -o jpeg --between 2 --format jpeg "${relief[@]}"
expect_that "where that is asked for" bash -c 'ls jpeg | grep -c jpg | grep -qx 2'
expect "a material" 0 btf-encode data -o m.btf.exr --method paper --starts 1 --report report.json
expect_text "with an estimate between the samples" "^Between the samples, estimated: 17 views and 17 lights are left out" out
expect_text "of views and lights together" "^  both +[0-9.]+ / [0-9.]+ +[0-9.]+ / [0-9.]+$" out
expect "the same by itself" 0 btf-compare --leave-one-out data m.btf.exr --json -q
expect_that "is that of the report" python3 - <<'P'
import json
report, found = json.load(open("report.json"))["between"], json.load(open("out"))["leave_one_out"]
assert report == found, (report, found)
for left in ("view", "light", "both"):
    assert 5 < found[left]["linear"] < 60 and 5 < found[left]["data_srgb"] < 60
P
expect "the file" 0 btf-info m.btf.exr --json
expect_that "holds it" python3 - <<'P'
import json
report, found = json.load(open("report.json"))["between"], json.load(open("out"))["between"]
for left in ("view", "light", "both"):
    for key, value in found[left].items():
        assert abs(value - report[left][key]) < 1e-3, (left, key)
P
expect "told" 0 btf-info m.btf.exr
expect_text "to people" "^Between the samples, estimated by predicting samples left out" out
expect "of data alone" 0 btf-compare --leave-one-out data --json -q --threads 1
expect_that "is the data's part of it" python3 - <<'P'
import json
report, found = json.load(open("report.json"))["between"], json.load(open("out"))["leave_one_out"]
assert found["both"]["data_linear"] == report["both"]["data_linear"] and found["both"]["linear"] is None
P
expect "leave-one-out of pairs" 1 btf-compare --leave-one-out pairs -q
expect "of a material alone" 1 btf-compare --leave-one-out m.btf.exr -q
btf-sample -o few --directions tiny --size 8 -q
expect "of another data set's material" 3 btf-compare --leave-one-out few m.btf.exr -q
expect "one side alone" 1 btf-compare data
expect_text "needs another" "B is missing" err

expect "data against pairs" 0 btf-compare data pairs --json -q
expect_that "bands, pairs and totals agree" python3 - <<'P'
import json, math
r = json.load(open("out"))["between"]
assert r["pairs"] == 30 == len(r["images"])
mean = lambda key: -10 * math.log10(sum(10 ** (-i[key] / 10) for i in r["images"]) / 30)
assert abs(mean("linear") - r["linear"]) < 1e-6 and abs(mean("srgb") - r["srgb"]) < 1e-6
assert abs(sum(i["ssim"] for i in r["images"]) / 30 - r["ssim"]) < 1e-9
for bands in r["bands"].values():
    assert sum(b["pairs"] for b in bands) == 30
for b in r["bands"]["view_gap"]:
    inside = [i for i in r["images"] if b["low"] <= i["view_gap"] < b["high"]]
    assert len(inside) == b["pairs"]
    e = sum(10 ** (-i["srgb"] / 10) for i in inside) / len(inside)
    assert abs(-10 * math.log10(e) - b["srgb"]) < 1e-6
json.dump(r, open("linear.json", "w"))
P
expect "the nearest samples" 0 btf-compare data pairs --interpolation nearest --json -q
expect_that "are worse" python3 - <<'P'
import json
assert json.load(open("out"))["between"]["linear"] < json.load(open("linear.json"))["linear"] - 1
P
# Without shadows, splines beat barycentric weights.
btf-sample -o flat --directions $rings --format exr "${relief[@]}" --relief flat || exit 99
btf-sample -o flat-pairs --between 30 "${relief[@]}" --relief flat || exit 99
expect "a flat sample" 0 btf-compare flat flat-pairs --json -q
cp out linear.json
expect "by splines" 0 btf-compare flat flat-pairs --interpolation spline --json -q
expect_that "is smooth" python3 - <<'P'
import json
linear, spline = json.load(open("linear.json"))["between"], json.load(open("out"))["between"]
assert spline["linear"] > linear["linear"] + 3 and spline["srgb"] > linear["srgb"] + 1.5, (linear["linear"], spline["linear"])
P
expect "a material against pairs" 0 btf-compare m.btf.exr pairs --pictures worst.png --worst 3 -q
expect_text "tells totals" "^PSNR linear [0-9.]+ dB, sRGB [0-9.]+ dB, SSIM 0[.][0-9]+$" out
expect_text "by angle to the nearest sample" "^light to sample" out
expect_that "draws the worst" python3 - <<'P'
import struct
png = open("worst.png", "rb").read()
assert png[:4] == b"\x89PNG"
width, height = struct.unpack(">II", png[16:24])
assert width > 3 * 160 and height > 3 * 160, (width, height)
P
cp out first
expect "the other way round" 0 btf-compare pairs m.btf.exr --worst 3 -q
expect_that "the same" diff first out
(cd pairs && python3 -c 'import shutil; shutil.make_archive("../pairs", "zip", ".")')
expect "from an archive" 0 btf-compare m.btf.exr pairs.zip --worst 3 -q
expect_that "the same again" diff first out
cp m.btf.exr other-name
expect "a material by its content, whatever its name" 0 btf-compare other-name pairs --worst 3 -q
expect_that "the same once more" diff first out

# At the samples: pairs of the grid's own directions have the error of the grid.
expect "pairs at samples" 0 btf-compare m.btf.exr data --pairs --json -q
cp out at.json
expect "the grid" 0 btf-compare m.btf.exr data --json -q
expect_that "has the same error" python3 - <<'P'
import json
a, b = json.load(open("at.json"))["between"], json.load(open("out"))["psnr"]
assert a["pairs"] == 17 * 17
for key in ("linear", "srgb", "ssim"):
    assert abs(a[key] - b[key]) < 1e-6, (key, a[key], b[key])
P
expect "data at its own samples" 0 btf-compare data data --pairs --interpolation spline --no-ssim --json -q
expect_that "are kept by splines" python3 -c 'import json; assert json.load(open("out"))["between"]["linear"] > 90'

expect "an orbit of the light" 0 btf-sample -o orbit --orbit light:12:60 --fixed 20,-90 "${relief[@]}"
expect_that "twelve frames and their table" bash -c \
    'test "$(ls orbit | grep -c "^frame000[01][0-9]_tl60.0000_pl[0-9.]*_tv20.0000_pv270.0000.exr$")" = 12 -a "$(wc -l <orbit/directions.csv)" = 13'
expect_text "with titles" "^file,theta_v,phi_v,theta_l,phi_l$" orbit/directions.csv
expect_text "and a line a frame" "^frame00003_.*exr,20.0000,270.0000,60.0000,90.0000$" orbit/directions.csv
expect "against a material" 0 btf-compare m.btf.exr orbit -q
expect_text "twelve pairs" "12 pairs" out
expect "the pairs of its table" 0 btf-sample -o list --pairs orbit/directions.csv "${relief[@]}"
expect_that "are the same images" cmp orbit/frame00005_tl60.0000_pl150.0000_tv20.0000_pv270.0000.exr \
    list/tl60.0000_pl150.0000_tv20.0000_pv270.0000.exr
expect "an orbit of the view" 0 btf-sample -o turn --orbit view:4 "${relief[@]}"
expect_that "at theta 45 under a fixed light" test -e turn/frame00001_tl30.0000_pl045.0000_tv45.0000_pv090.0000.exr

# Noise of 0.003 is 50.5 dB; a little less is left where the values of the sample lie at 0.
expect "noise of a camera" 0 btf-sample -o noisy --directions $rings --format exr "${relief[@]}" --relief flat --noise 0.003
expect "against the sample without" 0 btf-compare flat noisy --no-ssim --json -q
expect_that "is of that size" python3 -c 'import json; d = json.load(open("out"))["psnr"]["linear"]; assert 50.3 < d < 51.5, d'
expect "a longer exposure" 0 btf-sample -o bright --directions $rings --format exr "${relief[@]}" --relief flat --exposure 1.25
expect "against the sample" 0 btf-compare flat bright --no-ssim --json -q
expect_that "is brighter" python3 -c 'import json; d = json.load(open("out"))["psnr"]["linear"]; assert 15 < d < 35, d'
expect "truth has no noise" 1 btf-sample -o x --between 3 --noise 0.1
expect "two ways at once" 1 btf-sample -o x --between 3 --orbit view:4
expect "an orbit of nothing" 1 btf-sample -o x --orbit camera:4
expect "an orbit of no frames" 1 btf-sample -o x --orbit view:0
expect "no pairs" 1 btf-sample -o x --between 0
expect "truth is of grids" 1 btf-sample -o x --between 3 --truth y
expect "a list that is not there" 2 btf-sample -o x --pairs none.txt
printf '1 2 3 4\n10 20 30\n' >short.txt
expect "a list with a short line" 3 btf-sample -o x --pairs short.txt
expect_text "is told with the line" "short.txt: line 2: expected theta and phi" err
expect_that "nothing was written" test ! -e x

expect "pairs against pairs" 1 btf-compare pairs others -q
expect_text "need a side to measure" "one of them must be a data set or a material" err
expect "splines of a material" 1 btf-compare m.btf.exr pairs --interpolation spline -q
expect "splines at samples" 1 btf-compare data data --interpolation spline -q
expect "a filter of data" 1 btf-compare data pairs --filter steep -q
expect_text "is told" "--filter steep: only for a material compared with pairs" err
expect "a filter at samples" 1 btf-compare data m.btf.exr --filter bilinear -q
expect "pictures of grids" 1 btf-compare data m.btf.exr --pictures x.png -q
btf-sample -o large --between 3 --size 24 -q
expect "sizes differ" 3 btf-compare m.btf.exr large -q
expect_text "are told" "m.btf.exr has 8 x 8 texels, large has 24 x 24" err
expect "unless the pairs are resized" 0 btf-compare m.btf.exr large --size 8x8 -q
rm "data/tv030_pv060/$(ls data/tv030_pv060 | head -1)"
expect "a grid that lacks an image" 3 btf-compare m.btf.exr data -q
expect_text "is no set of pairs" "1 of 289 images are missing" err
expect "unless that is asked for" 0 btf-compare m.btf.exr data --pairs --no-ssim -q
expect_text "288 of them" "288 pairs" out
printf 'no image' >pairs/tl1_pl2_tv3_pv4.exr
expect "a damaged image" 3 btf-compare m.btf.exr pairs -q
expect_text "is named" "pairs: tl1_pl2_tv3_pv4.exr: " err
finish
