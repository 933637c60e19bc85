#!/bin/bash
# A plane, of which a reflectance model alone is as good as factors, and smaller.
#
# SPDX-License-Identifier: MIT
. "$BTF_SOURCE_ROOT/tests/tools/common.sh" || exit 99
plane="--size 8 --directions 0:1,25:6,50:12,70:16"
btf-sample -o flat --relief flat $plane --format exr --quiet && btf-sample -o pairs --relief flat $plane --between 60 --quiet || exit 99
btf-sample -o bumps --relief bumps $plane --format exr --quiet || exit 99
btf-sample -o bright --relief bricks --size 16 --directions 0:1,25:6,50:12,70:16 --format exr --exposure 300 --quiet || exit 99

expect "a plane" 0 btf-encode flat -o flat.btf.exr -q --report flat.json
expect "as factors" 0 btf-encode flat -o factors.btf.exr -q --effects residual --report factors.json
expect "what is in the file" 0 btf-info flat.btf.exr --json
mv out flat.info.json
cat >plane.py <<'P'
import json
model, factors, info = (json.load(open(name)) for name in ("flat.json", "factors.json", "flat.info.json"))
print({k: round(v, 2) for k, v in model["psnr"]["full"].items() if k in ("linear", "srgb")}, model["bytes"]["gpu"], factors["bytes"]["gpu"], info["options"])
assert model["bytes"]["gpu"] >= 16 * 64 and model["bytes"]["gpu"] < 16 * 64 * 4 / 3 and model["bytes"]["gpu"] * 4 < factors["bytes"]["gpu"]
assert model["psnr"]["full"]["linear"] > 60 and model["psnr"]["full"]["srgb"] > 60, model["psnr"]["full"]
best = [t for t in model["trials"] if t["verdict"] == "best"]
assert len(best) == 1 and best[0]["lobes"] == 1 and best[0]["gpu"] == 16 * 64, model["trials"]
assert [t["verdict"] for t in model["trials"]].count("left out") >= 1, model["trials"]
assert abs(best[0]["psnr"] - model["psnr"]["full"]["srgb"]) < 1e-6, (best, model["psnr"])  # weighed as it is stored
assert all(t["lobes"] == 0 for t in factors["trials"]), factors["trials"]
assert info["options"].endswith(" model=reflectance") and info["version"] == 1, info
assert model["fit"] is None and model["relief"] is None, (model["fit"], model["relief"])
P
expect_that "is a model of 16 bytes a texel, without fit and relief; file and report say so" python3 plane.py
for name in flat factors; do
    expect "$name between the samples" 0 btf-compare $name.btf.exr pairs --json -q
    mv out $name.between.json
done
expect_that "the model is far better between the samples" python3 - <<'P'
import json
model, factors = (json.load(open(f"{name}.between.json"))["between"] for name in ("flat", "factors"))
print(model, factors)
assert model["linear"] > factors["linear"] + 6 and model["srgb"] > factors["srgb"] + 6
P

expect "levels of detail" 0 btf-encode flat -o levels.btf.exr -q --levels 3 --report levels.json
expect_that "are models, too" python3 - <<'P'
import json
levels = json.load(open("levels.json"))["levels"]
print(levels)
assert len(levels) == 3 and all(level["linear"] > 30 for level in levels)
P
expect "a relief" 0 btf-encode bumps -o bumps.btf.exr -q --report bumps.json
expect_that "has factors; the model was given up by the survey, as the report says" python3 - <<'P'
import json
trials = json.load(open("bumps.json"))["trials"]
assert all(t["lobes"] == 0 for t in trials[:-1]) and trials[-1]["lobes"] == 1, trials
assert trials[-1]["verdict"].startswith("given up") and trials[-1]["gpu"] == 0 and trials[-1]["psnr"] is None, trials
P
expect "a relief so bright that most is above 1, where no error is measured" 0 btf-encode bright -o bright.btf.exr -q --report bright.json
expect_that "has factors" python3 -c 'import json; assert json.load(open("bright.json"))["trials"][-1]["verdict"].startswith("given up")'
expect "a quality that the model has" 0 btf-encode flat -o quality.btf.exr -q --quality 60 --report quality.json
expect_that "it is taken" python3 -c 'import json; assert json.load(open("quality.json"))["trials"][-1]["verdict"] == "best"'
expect "gloss that the user wants" 0 btf-encode flat -o gloss.btf.exr -q --gloss 2 --report gloss.json
expect_that "needs factors" python3 -c 'import json; assert all(t["lobes"] == 0 for t in json.load(open("gloss.json"))["trials"])'
if [ -z "$light" ]; then
    expect "with threads" 0 btf-encode flat -o again.btf.exr -q --threads 3
    expect_that "the same bytes" cmp flat.btf.exr again.btf.exr
fi
expect "killed once the model is found" 137 at "1 print reflectance: done" KILL btf-encode flat -o resumed.btf.exr --checkpoint steps
expect "resumed" 0 btf-encode flat -o resumed.btf.exr -q --checkpoint steps --resume
expect_that "the same bytes" cmp flat.btf.exr resumed.btf.exr
expect "from a scratch file" 0 btf-encode flat -o disk.btf.exr -q --memory "$(least_memory flat)"
expect_that "the same bytes" cmp flat.btf.exr disk.btf.exr
finish
