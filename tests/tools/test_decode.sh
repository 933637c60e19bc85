#!/bin/bash
# btf-decode, btf-info and btf-sample.
#
# SPDX-License-Identifier: MIT
. "$BTF_SOURCE_ROOT/tests/tools/common.sh" || exit 99
small_data --truth truth
last=4 # the coarsest level of detail
[ $side = 8 ] && last=3
btf-encode data -o m.btf.exr --method paper $starts -q || exit 99

expect "one image" 0 btf-decode m.btf.exr -o one.png --view 40,60 --light 40,120
expect_that "a PNG came" test "$(head -c 4 one.png | tail -c 3)" = PNG
expect "one image as EXR" 0 btf-decode m.btf.exr -o one.exr --view 20,10 --light 30,5 --format exr --effects shadow
expect "all images" 0 btf-decode m.btf.exr -o all --all --threads 2
expect_that "as many images as the data has" test "$(find all -name '*.png' | wc -l)" = 49
expect "they are a data set again" 0 btf-compare all m.btf.exr --json -q
expect_that "and agree with the material up to 8 bits" python3 - <<'P'
import json
assert json.load(open("out"))["psnr"]["srgb"] > 50
P
expect "all images without --all, as in the README" 0 btf-decode m.btf.exr -o every
expect_that "they are the same" diff -r all every
mkdir there.png
expect "into a folder that is there, whatever its name" 0 btf-decode m.btf.exr -o there.png
expect_that "they are the same" diff -r all there.png
expect "an image where its ending says so" 0 btf-decode m.btf.exr -o TOP.PNG
expect "an EXR where its ending says so" 0 btf-decode m.btf.exr -o top.Exr
expect_that "by its content" test "$(head -c 4 top.Exr | od -A n -t x1 | tr -d " ")" = 762f3101
expect "one direction without an ending" 1 btf-decode m.btf.exr -o image --view 0,0
expect_text "is asked for one" "'image' ends neither in .png nor in .exr" err

# A file's content decides how it is opened; the ending of a name decides which format is written.
cp m.btf.exr M.BTF.EXR
cp m.btf.exr mat.btf
(cd data && python3 -m zipfile -c ../data.txt ./*)
for name in M.BTF.EXR mat.btf; do
    expect "info of $name" 0 btf-info $name --json
    expect "decode $name" 0 btf-decode $name -o named.png --view 0,0
    expect "compare with $name" 0 btf-compare data $name -q --no-ssim
done
expect "an archive called a text" 0 btf-encode data.txt -o named.BTF.EXR --method paper $starts -q
expect "compared under that name" 0 btf-compare data.txt m.btf.exr -q --no-ssim
expect "a material as input" 3 btf-encode mat.btf -o x.btf.exr -q
expect_text "is told" "mat.btf: is an OpenEXR file" err
expect "another ending to write" 1 btf-encode data -o mat.btf --method paper -q
expect_text "is refused" "'mat.btf' does not end in .btf.exr" err
PATH=$build/tests/conformance:$build/tests/bench:$PATH
for tool in btf-info btf-decode btf-encode btf-compare btf-sample btf-conform btf-bench; do
    $tool --help >out
    expect_that "$tool --help tells exit codes once" test "$(grep -ci '^ *exit codes' out)" = 1
done

# Names may hold control sequences of terminals, which tools print as text.
cp -r data $'da\e[31mta'
btf-encode $'da\e[31mta' -o $'m\e[31m.btf.exr' --method paper -q --effects none
expect "info of strange names" 0 btf-info $'m\e[31m.btf.exr'
expect_that "has no control characters" python3 -c 'assert "\x1b" not in open("out").read() and "da\\x1b[31mta" in open("out").read()'

# Directions that do not lie on rings do not give a line of thousands of characters.
expect_that "scattered directions" python3 - <<'P'
import os, random, shutil, glob
random.seed(3)
images = sorted(glob.glob("data/*/*.png"))
views = [(0, 0)] + [(random.uniform(5, 80), random.uniform(0, 360)) for _ in range(39)]
os.makedirs("scattered")
for v, (theta, phi) in enumerate(views):
    for l in range(2):
        shutil.copy(images[(2 * v + l) % len(images)], f"scattered/tv{theta:.4f}_pv{phi:.4f}_tl{30 * l}_pl0.png")
P
expect "are encoded" 0 btf-encode scattered -o scattered.btf.exr --method paper -q --effects none
expect "and told" 0 btf-info scattered.btf.exr
expect_text "in short" "views +40: [34][0-9] angles from 0.* to [0-9.]+.* \\(--json lists them\\)" out
expect_that "on lines of 100 columns" python3 -c 'assert max(len(l.rstrip("\n")) for l in open("out", encoding="utf-8")) <= 100'
expect "an ending of another format" 1 btf-decode m.btf.exr -o one.jpg
expect "an ending against --format" 1 btf-decode m.btf.exr -o one.png --format exr
expect_that "write nothing" test ! -e one.jpg
expect "--format for all images" 0 btf-decode m.btf.exr -o no_direction --format exr
expect_that "is obeyed" test "$(find no_direction -name '*.exr' | wc -l)" -gt 4
expect "all images as EXR" 0 btf-decode m.btf.exr -o exr --all --format exr
expect "the EXR set" 0 btf-compare exr m.btf.exr --json -q
expect_that "and agree exactly" python3 - <<'P'
import json
assert json.load(open("out"))["psnr"]["linear"] > 90
P
expect "info as JSON" 0 btf-info m.btf.exr --json
expect_that "which is JSON" python3 -c 'import json; r=json.load(open("out")); assert r'
expect "a material of levels" 0 btf-encode data -o levels.btf.exr --method paper $starts --levels all -q
for level in 0 2 $last; do
    expect "level $level" 0 btf-decode levels.btf.exr -o level$level.png --level $level --light 30,45
done
expect "no level" 0 btf-decode levels.btf.exr -o level.png --light 30,45
expect_that "is level 0" cmp level.png level0.png
expect_that "levels are of their sizes" python3 - $side $last <<'P'
import struct, sys
side, last = map(int, sys.argv[1:])
def size(name): return struct.unpack(">II", open(name, "rb").read()[16:24])
assert [size(f"level{i}.png") for i in (0, 2, last)] == [(side, side), (side >> 2, side >> 2), (1, 1)]
P
expect "all images of a level" 0 btf-decode levels.btf.exr -o small --all --level 3
expect_that "as many as of level 0" test "$(find small -name '*.png' | wc -l)" = 49
expect "a level too many" 1 btf-decode levels.btf.exr -o x.png --level $((last + 1))
expect_text "is refused with their number" "option --level: $((last + 1)), but levels.btf.exr has $((last + 1)) levels" err
expect "level 1 of one" 1 btf-decode m.btf.exr -o x.png --level 1
expect "decode without an output" 1 btf-decode m.btf.exr --all
expect "decode nothing" 2 btf-decode none.btf.exr -o x.png --view 0,0 --light 0,0
tiny=(--relief weave --size 8 --directions tiny -q)
expect "sample" 0 btf-sample -o w0 "${tiny[@]}"
expect "sample again" 0 btf-sample -o w1 "${tiny[@]}" --threads 1
expect_that "sample: the same bytes" diff -r w0 w1
expect "sample: another seed" 0 btf-sample -o w2 "${tiny[@]}" --seed 7
expect_that "sample: another seed is another material" test -n "$(diff -rq w0 w2)"
expect "sample: rays and cells" 0 btf-sample -o w3 "${tiny[@]}" --supersample 1 --grid 256
expect "sample: JPEG" 0 btf-sample -o w4 "${tiny[@]}" --format jpeg --quality 40
expect "sample: better JPEG" 0 btf-sample -o w5 "${tiny[@]}" --format jpeg --quality 98
expect_that "sample: quality costs bytes" test "$(du -sb w5 | cut -f1)" -gt "$(du -sb w4 | cut -f1)"
expect "sample: a quality out of range" 1 btf-sample -o x "${tiny[@]}" --format jpeg --quality 101
expect "sample: a grid that is no power of two" 1 btf-sample -o x "${tiny[@]}" --grid 300
expect "sample: an unknown relief" 1 btf-sample -o x --relief moon
expect_that "truth was written" test -n "$(ls truth)"
for relief in bumps weave flat axes; do
    expect "sample $relief" 0 btf-sample -o "s-$relief" --relief $relief --size 12 --directions 0:1,45:4 --format exr --quiet
    expect "encode $relief" 0 btf-encode "s-$relief" -o $relief.btf.exr --method paper $starts -q
done
expect "a plan" 0 btf-info m.btf.exr --plan views=0:15,light=40:60,pixels=1.5,tolerance=20
expect_text "names effects" "^effects " out
expect_text "and what it saves" "7 views, 1 lights, .* bytes of" out
costs=$BTF_SOURCE_ROOT/tests/fuzz/corpus/costs
expect "a plan by another device's prices" 0 btf-info m.btf.exr --plan views=0:15,light=40:60 --costs "$costs/llvmpipe.json"
expect "prices that are cut off" 3 btf-info m.btf.exr --plan all --costs "$costs/cut.json"
expect_text "are named" "cut.json" err
expect "prices that are not there" 2 btf-info m.btf.exr --plan all --costs none.json
expect "prices without a plan" 1 btf-info m.btf.exr --costs "$costs/llvmpipe.json"
expect "a plan as JSON" 0 btf-info m.btf.exr --json --plan all
expect_that "loses less than the tolerance between the samples" python3 - <<'P'
import json
r = json.load(open("out"))
assert r["measured"] and r["views"] == 7 and r["lights"] == 7
assert r["full_between_linear"] - 0.5 <= r["between_linear"] and r["full_between_srgb"] - 0.5 <= r["between_srgb"]
assert "shadow" in r["effects"] and "shift" in r["effects"] and r["cost"] <= r["full_cost"]
P
expect "a far scene" 0 btf-info levels.btf.exr --json --plan pixels=0.25
expect_that "takes a coarser level" python3 -c 'import json; assert json.load(open("out"))["level"] == 2'

# Factors: format version 2.
PATH=$build/tests/tools:$PATH
expect "a material of factors" 0 factor_file v2.btf.exr 1 tight 3 roots
expect "is told" 0 btf-info v2.btf.exr
expect_text "with its version" "format version 2$" out
expect_text "its units" "^  residual +9 units of factors, 352 components$" out
expect_text "its classes" "^ +8 bits of w, 8 of u: 2 units, words: Y 3, C1 3, C2 2; 32 components$" out
expect_text "the last of them" "^ +2 bits of w, 2 of u: 2 units, words: Y 7, C1 0, C2 1; 128 components$" out
expect_text "its blend" "^  blend +roots$" out
expect_text "its horizon" "^  horizon +factors fade to black from theta 79.98° of the light to 90°$" out
expect_text "bytes of its texels" "^  factor_texels +RGBA32UI +16 x 12 x 11 +33792 bytes +176.00 a texel$" out
expect_text "and of its directions" "^  factor_directions +RGBA32UI +19 x 19 x 9 +51984 bytes +270.75 a texel$" out
expect_that "on lines of 100 columns" python3 -c 'assert max(len(l.rstrip("\n")) for l in open("out", encoding="utf-8")) <= 100'
expect "and as JSON" 0 btf-info v2.btf.exr --json
expect_that "the same" python3 - <<'P'
import json
r = json.load(open("out"))
assert (r["version"], r["store"], r["residual"], r["blend"], r["preview"]) == (2, "factors", 9, "roots", False), r
assert r["horizon_scale"] == 5.75 and len(r["classes"]) == 5
assert r["classes"][3] == {"w_bits": 2, "u_bits": 4, "units": 1, "components": 64, "words": {"y": 2, "c1": 2, "c2": 0}}
t = r["textures"]
assert t["factor_texels"]["bytes_a_texel"] == 176 and t["factor_views"]["table"] and not t["shadow"]["table"]
assert sum(x["bytes"] for x in t.values() if not x["table"]) == r["levels"][0]["gpu"]
assert sum(x["bytes"] for x in t.values() if x["table"]) == r["bytes"]["tables"]
P
expect "packed points" 0 factor_file points.btf.exr 1 tight 1 roots packed
expect "are told" 0 btf-info points.btf.exr
expect_text "with their gains" "^  points +packed: shifts within -32..31, gain 0.3 \\+ 0.11 \\* 0..15$" out
expect_text "and their bytes" "^  points +RG8UI +16 x 12 x 19 +7296 bytes +38.00 a texel$" out
expect "and as JSON" 0 btf-info points.btf.exr --json
expect_that "the same" python3 - <<'P'
import json
r = json.load(open("out"))
assert r["version"] == 2 and r["point_store"] == "packed" and abs(r["scales"]["gain_step"] - 0.11) < 1e-6, r
assert r["textures"]["points"]["format"] == "RG8UI" and "shift" not in r["textures"], r["textures"]
P
expect "lists of points" 0 factor_file lists.btf.exr 1 tight 1 roots lists
expect "are told" 0 btf-info lists.btf.exr
expect_text "with their length" "^  points +lists of 4 points a texel: shifts within -32..31, gain 0.3 \\+ 0.11 \\* 0..15$" out
expect_text "and the bytes of the lists" "^  point_lists +RG8UI +16 x 12 x 4 +1536 bytes +8.00 a texel$" out
expect_text "and of the indices" "^  point_indices +R8UI +16 x 12 x 10 +1920 bytes +10.00 a texel$" out
expect "and as JSON" 0 btf-info lists.btf.exr --json
expect_that "the same" python3 -c 'import json; r = json.load(open("out")); assert (r["point_store"], r["point_entries"]) == ("lists", 4), r'
expect "relief and gloss" 0 factor_file relief.btf.exr 1 tight 3 roots relief
expect "are told" 0 btf-info relief.btf.exr
expect_text "with heights" "^  relief +heights -0.988 to 2.1 texels, 7 steps, on 19 of 19 views$" out
expect_text "and a share" "^  gloss +keeps 0.25 of the half vector$" out
expect_text "among the effects" "^Effects: shadow,shift,hidden,gain,residual,relief,gloss$" out
expect_text "and the textures" "^  heights +R8UI +16 x 12 +192 bytes +1.00 a texel$" out
expect_text "of which one is a table" "^  view_vectors +RGBA32F +19 x 1 +304 bytes  \\(table\\)$" out
expect_that "on lines of 100 columns" python3 -c 'assert max(len(l.rstrip("\n")) for l in open("out", encoding="utf-8")) <= 100'
expect "and as JSON" 0 btf-info relief.btf.exr --json
expect_that "the same" python3 - <<'P'
import json
r = json.load(open("out"))
assert r["version"] == 2 and r["gloss"] == 0.25 and r["effects"][-2:] == ["relief", "gloss"], r
assert (r["relief"]["base"], r["relief"]["step"], r["relief"]["steps"], r["relief"]["views"]) == (-256, 801, 7, 19), r
t = r["textures"]
assert t["view_vectors"]["table"] and not t["heights"]["table"]
assert sum(x["bytes"] for x in t.values() if x["table"]) == r["bytes"]["tables"]
P
way="--view 40,60 --light 40,120"
expect "they are decoded" 0 btf-decode relief.btf.exr -o all.exr $way
expect "without relief" 0 btf-decode relief.btf.exr -o flat.exr $way --effects shadow,shift,hidden,gain,residual,gloss
expect "without gloss" 0 btf-decode relief.btf.exr -o dull.exr $way --effects shadow,shift,hidden,gain,residual,relief
expect "without both" 0 btf-decode relief.btf.exr -o none.exr $way --effects shadow,shift,hidden,gain,residual
expect "by a filter" 0 btf-decode relief.btf.exr -o soft.exr $way --filter bilinear
expect "by a steep one" 0 btf-decode relief.btf.exr -o steep.exr $way --filter steep
expect_that "each another image" test "$(md5sum all.exr flat.exr dull.exr none.exr soft.exr steep.exr | cut -d' ' -f1 | sort -u | wc -l)" = 6
expect "without either, filtered" 0 btf-decode relief.btf.exr -o plain.exr $way --filter steep --effects shadow,shift,hidden,gain,residual
expect_that "centres of texels are texels" cmp none.exr plain.exr
mkdir way
cp steep.exr way/tl40_pl120_tv40_pv60.exr
expect "against the steep one" 0 btf-compare relief.btf.exr way --filter steep --no-ssim --json -q
expect_that "no error by the same filter" python3 -c 'import json; assert json.load(open("out"))["between"]["linear"] > 99'
expect "by whole texels" 0 btf-compare relief.btf.exr way --no-ssim --json -q
expect_that "some" python3 -c 'import json; assert json.load(open("out"))["between"]["linear"] < 60'
expect "no such filter" 1 btf-decode relief.btf.exr -o x.exr --filter soft
expect "one height" 0 factor_file height.btf.exr 1 tight 1 roots height
expect "is told" 0 btf-info height.btf.exr
expect_text "as one" "^  relief +height -1 texels everywhere, on 19 of 19 views$" out
expect "and decoded" 0 btf-decode height.btf.exr -o height.exr $way
expect "lists are decoded" 0 btf-decode lists.btf.exr -o lists.exr --view 40,60 --light 40,120
expect "version 1 as JSON" 0 btf-info m.btf.exr --json
expect_that "is of version 1" python3 -c 'import json; r = json.load(open("out")); assert (r["version"], r["store"], r["classes"]) == (1, "components", [])'
expect "a plan of it" 0 btf-info v2.btf.exr --plan views=0:15
expect_text "counts units" "^effects .*residual, 9 units, " out
expect_text "and names textures" "^textures .*factor_texels factor_directions factor_scales factor_views" out
expect "factors are decoded" 0 btf-decode v2.btf.exr -o all.exr --view 40,60 --light 40,120
expect "the first units" 0 btf-decode v2.btf.exr -o four.exr --view 40,60 --light 40,120 --components 4
expect_that "are another image" test "$(cmp -s all.exr four.exr; echo $?)" = 1
expect "all units" 0 btf-decode v2.btf.exr -o nine.exr --view 40,60 --light 40,120 --components 9
expect_that "are all" cmp all.exr nine.exr
expect "a level of factors" 0 btf-decode v2.btf.exr -o level1.exr --view 40,60 --light 40,120 --level 2

for scene in views=30:20 views=0 light=90:0 pixels=-1 count=1.5 "" all, nonsense views=0:30:0; do
    expect "no scene: '$scene'" 1 btf-info m.btf.exr --plan "$scene"
done
finish
