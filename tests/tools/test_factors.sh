#!/bin/bash
# btf-encode --method joint: its files, its reports and its refusals.
#
# SPDX-License-Identifier: MIT
. "$BTF_SOURCE_ROOT/tests/tools/common.sh" || exit 99
small_data
levels=3 # levels that are decoded and compared
[ $side = 8 ] && levels=2
json() { python3 -c "import json,sys; r=json.load(open('$1')); print($2)"; }

expect_text "--help tells of the method" "joint \(default\): low-bit factors" <(btf-encode --help)
expect "factors" 0 btf-encode data -o factors.btf.exr --method joint --effects residual --report factors.json --pictures drawn --threads 1
expect_text "bytes a texel by texture" "^  factor_texels +[0-9.]+ +[0-9.]+" out
expect_text "what the first units give" "^Only the first units of the residual decoded" out
expect_that "a montage" test -s drawn/montage.png
btf-info factors.btf.exr --json >info.json || exit 99
expect_that "a file of version 2" test "$(json info.json "(r['version'], r['domain'], r['effects'])")" = "(2, 'sqrt', ['residual'])"
expect_that "the report says the bytes of each texture" python3 - $side <<'P'
import json, sys
texels = int(sys.argv[1]) ** 2
r, info = json.load(open("factors.json")), json.load(open("info.json"))
parts = r["bytes"]["parts"]
assert parts["factor_texels"] + parts["factor_directions"] == r["bytes"]["gpu"] == info["bytes"]["gpu"], r["bytes"]
assert parts["factor_texels"] % (16 * texels) == 0 and parts["factor_directions"] == 7 * 7 * 16 * info["residual"]
assert abs(r["bytes"]["a_texel"] * texels - r["bytes"]["gpu"]) < 1e-6
assert r["trials"][0]["verdict"] == "best" and r["trials"][0]["gpu"] == r["bytes"]["gpu"], r["trials"]
P
expect "what the reference decodes" 0 btf-compare data factors.btf.exr --json -q
cp out compared.json
expect_that "is as good as report and file say" python3 - <<'P'
import json
r, c, info = (json.load(open(f)) for f in ("factors.json", "compared.json", "info.json"))
for key in ("linear", "srgb"):
    told = [r["psnr"]["full"][key], [e for e in info["errors"] if e["effects"]][0][key]]
    assert all(abs(x - c["psnr"][key]) < 2e-3 for x in told), (key, told, c["psnr"][key])
assert c["psnr"]["linear"] > 25, c["psnr"]["linear"]
P
expect_that "fewer units: fewer bytes, and never better" python3 - <<'P'
import json
rows = json.load(open("factors.json"))["truncations"]
full = json.load(open("factors.json"))["psnr"]["full"]
assert len(rows) > 1 and rows[0]["units"] == json.load(open("info.json"))["residual"]
for more, fewer in zip(rows, rows[1:]):
    assert more["units"] > fewer["units"] and more["gpu"] > fewer["gpu"]
    assert more["linear"] > fewer["linear"] and more["srgb"] > fewer["srgb"], (more, fewer)
assert abs(rows[0]["linear"] - full["linear"]) < 0.5 and abs(rows[0]["srgb"] - full["srgb"]) < 0.5, (rows[0], full)
P
expect "two threads" 0 btf-encode data -o two.btf.exr --effects residual --threads 2 -q
expect_that "the same bytes for any number of threads" cmp factors.btf.exr two.btf.exr
expect "a file that holds it, decoded" 0 btf-decode factors.btf.exr -o decoded --all --format exr
expect "against the data" 0 btf-compare data decoded --json -q
expect_that "is the material" python3 - <<'P'
import json
a, b = json.load(open("compared.json"))["psnr"], json.load(open("out"))["psnr"]
assert all(abs(a[key] - b[key]) < 0.02 for key in ("linear", "srgb")), (a, b)
P
expect "a plan of it" 0 btf-info factors.btf.exr --plan views=0:30,lights=0:60
expect_that "a picture for viewers of OpenEXR" python3 - <<'P'
data = open("factors.btf.exr", "rb").read(20000)
assert data.index(b"preview") < data.index(b"factor_texels")
P

btf-sample -o wide --relief bricks --size 12x10 --directions 0:1,30:6,60:9 --quiet || exit 99
for budget in 30k $(unless_light echo 100k); do
    expect "a budget of $budget" 0 btf-encode wide -o budget.btf.exr --preset fast --budget $budget --report budget.json -q
    expect_that "is kept" test "$(json budget.json "20000 < r['bytes']['gpu'] <= int('$budget'[:-1]) * 1000")" = True
done
expect "a budget that holds nothing" 1 btf-encode wide -o x.btf.exr --budget 5k -q
expect_text "is refused with the least" "a budget of 5000 bytes is too small: one unit of factors takes [0-9]+" err
least=$(sed -n 's/.*--budget \([0-9]*k\) or more.*/\1/p' err)
expect "the budget that it names instead" 0 btf-encode wide -o least.btf.exr --preset fast --budget "$least" -q
expect "a thousand bytes less" 1 btf-encode wide -o x.btf.exr --budget $((${least%k} - 1))k -q
expect_text "offers fewer texels" "one unit of [0-9]+ texels at most \(--size\)" err
paper=$(sed -n 's/.*--half takes \([0-9]*\).*/\1/p' err)
texels=$(sed -n 's/.*unit of \([0-9]*\) texels.*/\1/p' err)
expect "which hold a unit" 0 btf-encode wide -o x.btf.exr --preset fast --size "${texels}x1" --budget $((${least%k} - 1))k -q
expect "and the reflectance that it offers" 0 btf-encode wide -o x.btf.exr --method paper --effects none --lobes 1 --half \
    --report paper.json -q
expect_that "takes what was said" test "$(json paper.json "r['bytes']['gpu']")" = "$paper"
expect "quality" 0 btf-encode wide -o quality.btf.exr --preset fast --quality 25 --report quality.json -q
expect_that "is reached, with fewer bytes than without" python3 - <<'P'
import json
q, b = json.load(open("quality.json")), json.load(open("budget.json"))
assert q["psnr"]["full"]["srgb"] >= 25, q["psnr"]["full"]
assert q["bytes"]["gpu"] < b["bytes"]["gpu"] and len(q["trials"]) > 1, q["trials"]
assert [t["verdict"] for t in q["trials"]].count("best") == 1
assert [t["gpu"] for t in q["trials"] if t["verdict"] == "best"] == [q["bytes"]["gpu"]]
P
expect "a quality out of reach" 0 btf-encode wide -o x.btf.exr --preset fast --budget 30k --quality 90 -q
expect_text "is told" "warning: factors: [0-9.]+ dB is the best that was found, below --quality 90.00, within 30000 bytes" err
expect "fast" 0 btf-encode wide -o fast.btf.exr --preset fast --budget 30k --report fast.json -q
preset=fast
if [ -z "$light" ]; then
    expect "a better preset" 0 btf-encode wide -o medium.btf.exr --budget 30k --report medium.json -q
    expect_that "descent on the codes gains" test "$(python3 -c "
import json
a, b = (json.load(open(f))['psnr']['full'] for f in ('medium.json', 'fast.json'))
print(a['linear'] > b['linear'] and a['srgb'] > b['srgb'])")" = True
    preset=medium
fi

expect "too little memory" 1 btf-encode wide -o x.btf.exr --memory 1 -q
expect_text "the least is named" "12x10 texels, 16 views and 16 lights take at least" err
expect "a budget beyond the memory" 1 btf-encode wide -o x.btf.exr --memory 20M --budget 200M -q
expect_text "is refused with the least" "factors of 200000000 bytes .* take at least [0-9]+K" err
expect "a scratch file" 0 env TMPDIR="$work" btf-encode wide -o scratch.btf.exr --preset $preset --budget 30k \
    --memory "$(least_memory wide --preset $preset --budget 30k)"
expect_text "it is announced" "samples: .* scratch file in $work" err
expect_that "the same bytes through a scratch file" cmp $preset.btf.exr scratch.btf.exr
expect "a prediction" 0 btf-encode wide --predict self
expect_text "has its stages" "^  factorise +[0-9.]+ core s" out
expect "a prediction by a report" 0 btf-encode wide --preset $preset --budget 30k --predict $preset.json
expect "levels" 0 btf-encode data -o levels.btf.exr --levels all --report levels.json --threads 1 -q
if [ -z "$light" ]; then
    expect "levels, two threads" 0 btf-encode data -o levels2.btf.exr --levels all --threads 2 -q
    expect_that "the same bytes for any number of threads, with levels" cmp levels.btf.exr levels2.btf.exr
fi
for level in $(seq $levels); do
    size=$((side >> level))
    expect "level $level decoded by the reference" 0 btf-decode levels.btf.exr -o level$level --all --level $level --format exr
    expect "against the original, filtered to $size x $size as images" 0 btf-compare data level$level --size ${size}x$size --json -q
    cp out compared.json
    expect_that "is as good as the report says" test "$(json compared.json "abs(r['psnr']['linear'] - json.load(open('levels.json'))['levels'][$level]['linear']) < 0.02")" = True
    unless_light expect_that "and not worse than level 0" test "$(json levels.json "r['levels'][$level]['linear'] > r['levels'][0]['linear'] - 1")" = True
done

# Without balancing, the weak components of such data would have scales below the least that files hold.
"$build/tests/tools/bonn_sample" small.btf || exit 99
expect "a Bonn file" 0 btf-encode small.btf -o bonn.btf.exr --report bonn.json -q
expect_that "is encoded well" test "$(json bonn.json "r['psnr']['full']['linear'] > 40")" = True

for refused in "--effects shift" "--effects shift,residual" "--effects shadow,residual" "--effects none" "--effect-tolerance 0,1" \
    "--layout paper" "--half" "--metric linear" "--lobes 2"; do
    expect "factors $refused" 1 btf-encode data -o x.btf.exr $refused -q
    expect_text "is refused by name" "option ${refused%% *}: " err
done
expect_that "and nothing is written" test ! -e steps
expect "the residual by name" 0 btf-encode data -o named.btf.exr --effects residual --effect-tolerance 0.05 -q
expect_that "is the same" cmp named.btf.exr factors.btf.exr

# Grey images of pure noise. Light runs leave this out, since it only compares numbers.
if [ -z "$light" ]; then
    btf-sample -o plane --relief white --size 24 --directions small --quiet || exit 99
    python3 - <<'P' || exit 99
import glob, random, struct, zlib
random.seed(1)
chunk = lambda name, data: struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
paths = sorted(glob.glob("plane/*/*.png"))
assert len(paths) == 361
for path in paths:
    rows = b"".join(b"\0" + bytes(round(random.gauss(140, 5)) for _ in range(3 * 24)) for _ in range(24))
    head = struct.pack(">IIBBBBB", 24, 24, 8, 2, 0, 0, 0)
    open(path, "wb").write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))
P
    expect "noise" 0 btf-encode plane -o plane.btf.exr --budget 200k --report plane.json -q
    expect "with the whole budget" 0 btf-encode plane -o filled.btf.exr --budget 200k --effect-tolerance 0 --report filled.json -q
    expect_that "needs one unit of it" test "$(json plane.json "r['bytes']['gpu'] < 17000 and json.load(open('filled.json'))['bytes']['gpu'] > 180000")" = True
    expect_that "and the report says why" test "$(json plane.json "(lambda u: u['pays'] < 17000 and u['budget'] == 200000 and u['tolerance'] == 0.05 and u['noise_beyond'] and u['signal'] == [1, 0, 0])(r['unspent'])")" = True
    expect_that "which nobody asks of the other" test "$(json filled.json "r['unspent'] is None")" = True
fi

cp factors.btf.exr kept.btf.exr
for moment in "1 print read: done" "1 print factorise: done" "1 open kept.btf.exr"; do
    expect "SIGINT at '$moment'" 130 at "$moment" INT btf-encode wide -o kept.btf.exr
    expect_that "the old file is untouched" cmp factors.btf.exr kept.btf.exr
    expect_that "no temporary file is left" test -z "$(find . -maxdepth 1 -name '.*.tmp')"
done
finish
