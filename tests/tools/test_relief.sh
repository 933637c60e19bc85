#!/bin/bash
# btf-encode --relief and --gloss: what acts between the samples, found, refused and left out.
#
# SPDX-License-Identifier: MIT
. "$BTF_SOURCE_ROOT/tests/tools/common.sh" || exit 99
# Bumps lie below the plane of their highest points: grazing views show them displaced.
btf-sample -o data --relief bumps --size 16 --directions 0:1,30:6,60:8 --format exr --quiet || exit 99

encode() { # NAME OPTION...
    local name=$1
    shift
    btf-encode data -o "$name.btf.exr" -q --preset fast --budget 100000 --report "$name.json" "$@"
}
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
P
expect_that "files and reports say so" python3 check.py
expect_that "off is what fast does" cmp fast.btf.exr off.btf.exr
expect "with threads" 0 encode again --relief auto --gloss auto --levels 3 --threads 3
expect_that "the same bytes" cmp found.btf.exr again.btf.exr
expect "samples that lie in a file" 0 encode disk --relief auto --memory "$(least_memory data --preset fast --budget 100000)"
expect_text "have no relief, which is said" "do not fit|does not fit" disk.json
expect "another share is refused" 1 encode odd --gloss 3
expect_text "with those that there are" "auto.*off.*0.*1.*2" err
expect "the paper's method has no relief" 1 btf-encode data -o odd.btf.exr --method paper --relief auto
expect_text "which is said" "option --relief: for --method joint only" err
finish
