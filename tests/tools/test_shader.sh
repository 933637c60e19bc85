#!/bin/bash
# btf-shader's options, exit codes and files; tests/conformance/shader runs its shaders on devices.
#
# SPDX-License-Identifier: MIT
. "$BTF_SOURCE_ROOT/tests/tools/common.sh" || exit 99
PATH=$build/decoder/tools/shader:$PATH
golden=$BTF_SOURCE_ROOT/tests/data/golden
file=$golden/v2-all.btf.exr
example=$BTF_SOURCE_ROOT/decoder/examples/load_textures.py

# ---- the command line

expect 'no language' 1 btf-shader "$file" -o a
expect_text 'is asked for one' 'option --language is missing: one of glsl330' err
expect 'no folder' 1 btf-shader "$file" -l glsl330
expect_text 'is asked for one' 'option --output is missing' err
expect 'an unknown language' 1 btf-shader "$file" -l cg -o a
expect 'an unknown kind of texture' 1 btf-shader "$file" -l hlsl --textures ktx -o a
expect 'a prefix that is no name' 1 btf-shader "$file" -l glsl330 --prefix Two -o a
expect_text 'is told' 'prefix "Two" is not of lower-case' err
expect 'a plan and effects' 1 btf-shader "$file" -l glsl330 --plan all --effects shift -o a
expect 'costs without a plan' 1 btf-shader "$file" -l glsl330 --costs costs.json -o a
expect 'costs that are missing' 2 btf-shader "$file" -l glsl330 --plan all --costs costs.json -o a
expect 'a file that is missing' 2 btf-shader none.btf.exr -l glsl330 -o a
echo text >text.btf.exr
expect 'a file that is no material' 3 btf-shader text.btf.exr -l glsl330 -o a
expect_that 'nothing was written' test -z "$(find . -name 'a' -o -name '.a.*')"

# ---- the folder is whole or absent

expect 'a folder' 0 btf-shader "$file" -l glsl330 -o a
expect_text 'tells what it holds' '^a: decode.glsl of [0-9]+ bytes, [0-9]+ textures of [0-9]+ bytes, manifest.json$' err
expect_that 'the same again' btf-shader "$file" -l glsl330 -o again/ -q
expect_that 'the same bytes' diff -r a again
expect 'a folder that is there' 2 btf-shader "$file" -l essl310 -o a
expect_text 'is not replaced' 'a: the folder exists; --force replaces it' err
expect_that 'it is as it was' diff -r a again
expect 'with --force it is' 0 btf-shader "$file" -l essl310 --textures raw --force -o a -q
expect_that 'and nothing of the old one stays' test -z "$(find a -name '*.ktx2')"
expect_text 'the new one is there' '"language": "essl310"' a/manifest.json
echo mine >a/notes.txt
expect 'a folder with a file of others' 2 btf-shader "$file" -l glsl330 --force -o a
expect_text 'which is named' "a: holds 'notes.txt', which btf-shader does not write" err
expect_that 'stays as it is' test -s a/notes.txt -a -s a/decode.glsl
mkdir empty
expect 'an empty folder' 0 btf-shader "$file" -l glsl330 -o empty -q
echo file >file
expect 'a file in its place' 2 btf-shader "$file" -l glsl330 --force -o file
expect_that 'stays' test "$(cat file)" = file
expect 'a folder of nowhere' 2 btf-shader "$file" -l glsl330 -o none/a
expect 'a folder without a name' 2 btf-shader "$file" -l glsl330 -o .
expect_that 'no temporary folder is left' test -z "$(find . -name '.*.tmp')"

most=$(calls btf-shader "$file" -l glsl330 -o counted -q)
whole() { # FOLDER: absent, or with all its files
    [ ! -e "$1" ] || diff -r "$1" again
}
for n in $(moments $([ -n "$light" ] && echo 3 || echo 8) "$most"); do
    rm -rf killed
    expect "killed at call $n" 137 at "$n call" KILL btf-shader "$file" -l glsl330 -o killed -q
    expect_that 'whole or absent' whole killed
    expect 'the next run' 0 btf-shader "$file" -l glsl330 --force -o killed -q
    expect_that 'is whole' diff -r killed again
    expect_that 'and removes what the dead one left' test -z "$(find . -name '.killed*')"
done
rm -rf stopped
expect 'interrupted' 130 at '3 call' INT btf-shader "$file" -l glsl330 -o stopped -q
expect_that 'nothing is left' test -z "$(find . -name '*stopped*')"

# A run with the same process id as a dead one, as happens in containers: only the lock tells whether a folder is in
# use.
left_over() { # FOLDER: makes the folder that a run killed while writing leaves
    mkdir "$1" && echo half >"$1/decode.glsl" && echo half >"$1/.manifest.json.1-0.tmp"
}
left_over .dead.1-0.tmp # named after process 1, which runs
left_over .dead.1-0.tmpx
left_over .dead.1.tmp
mkdir .dead.2-0.tmp && echo mine >.dead.2-0.tmp/notes.txt
ln -s again .dead.3-0.tmp
expect 'beside a folder that a dead run left' 0 btf-shader "$file" -l glsl330 -o dead -q
expect_that 'is whole' diff -r dead again
expect_that 'the folder without a lock is gone' test ! -e .dead.1-0.tmp
expect_that 'folders of other names stay' test -s .dead.1-0.tmpx/decode.glsl -a -s .dead.1.tmp/decode.glsl
expect_that 'files of others stay' test -s .dead.2-0.tmp/notes.txt
expect_that 'links are not followed' test -s again/decode.glsl
left_over .alive.1-0.tmp
exec 9<.alive.1-0.tmp
flock -n 9 || exit 99
expect 'beside a folder that a live run fills' 0 btf-shader "$file" -l glsl330 -o alive -q 9<&-
expect_that 'is whole' diff -r alive again
expect_that 'the locked folder stays' test -s .alive.1-0.tmp/decode.glsl -a -s .alive.1-0.tmp/.manifest.json.1-0.tmp
exec 9<&-
expect 'once its run is dead' 0 btf-shader "$file" -l glsl330 --force -o alive -q
expect_that 'it is removed' test -z "$(find . -name '.alive*')"
# The name of the temporary folder that a run will choose exists already: $BASHPID is the process id of the program that
# exec starts.
taken() { # OUT: runs with a locked folder of its own process id in its way
    local locked=.$1.$BASHPID-0.tmp
    left_over "$locked" && exec 8<"$locked" && flock -n 8 && echo "$locked" >locked &&
        exec btf-shader "$file" -l glsl330 -o "$1" -q
}
expect 'its own name is taken' 0 eval '(taken taken)'
expect_that 'is whole' diff -r taken again
expect_that 'and has not touched the other' test -s "$(cat locked)/decode.glsl"
cat >held.sh <<'S' # tests whether flock refuses the temporary folder of `held`, and another run leaves it alone
for folder in .held.*.tmp; do
    ! flock -n "$folder" true && btf-shader "$file" -l glsl330 -o held --force -q && test -d "$folder" && touch was-held
done
S
export file
cp -r again held
expect 'while it fills its folder' 0 at '1 rename decode.glsl' 'unset LD_PRELOAD; bash held.sh' \
    btf-shader "$file" -l glsl330 -o held -q --force
expect_that 'it holds the lock' test -e was-held
long=$(printf 'n%.0s' {1..250})
expect 'a name of 250 bytes' 0 btf-shader "$file" -l glsl330 -o "$long" -q
expect_that 'is whole' diff -r "$long" again
expect 'is replaced' 0 btf-shader "$file" -l glsl330 --force -o "$long" -q
expect_that 'no temporary folder is left' test -z "$(find . -name '.nnn*')"
expect 'a name of 256 bytes' 2 btf-shader "$file" -l glsl330 -o "${long}nnnnnn"
expect_text 'is told' 'n: cannot make the folder: File name too long' err

# ---- what the files say

/usr/bin/python3 -c 'import numpy' 2>that || echo 'skipped: no numpy: the example loader is not run'
for store in ktx2 dds raw; do
    btf-shader "$golden/v2-level.btf.exr" -l glsl450 --textures $store -o "level-$store" -q || exit 99
    if /usr/bin/python3 -c 'import numpy' 2>that; then
        expect "the example loads $store" 0 /usr/bin/python3 "$example" "level-$store"
        cp out "loaded-$store"
    fi
done
if [ -s loaded-ktx2 ]; then
    expect_that 'the same texels from DDS' diff loaded-ktx2 loaded-dds
    expect_that 'the same texels from raw files' diff loaded-ktx2 loaded-raw
    expect_text 'several levels' '^heights 1 R8UI ' loaded-ktx2
    cat >compare.py <<'P'
import hashlib, sys
sys.path.insert(0, sys.argv[1])
import openbtf
material = openbtf.open(sys.argv[2])
for line in open("loaded-ktx2"):
    name, level, _, _, digest = line.split()
    assert hashlib.sha256(material.textures(int(level))[name].tobytes()).hexdigest()[:16] == digest, line
P
    unless_light expect 'the texels that the library has' 0 env LD_LIBRARY_PATH="$build/decoder:$build/reference" \
        /usr/bin/python3 compare.py "$BTF_SOURCE_ROOT/decoder/python" "$golden/v2-level.btf.exr"
    expect 'the example without a folder' 1 /usr/bin/python3 "$example"
fi
expect 'a plan' 0 btf-shader "$file" -l glsl450 --plan views=0:20,pixels=0.4 -o plan -q
expect 'fewer units' 0 btf-shader "$file" -l glsl450 --components 1 -o units -q
expect 'no residual' 0 btf-shader "$file" -l glsl450 --components 0 -o bare -q
expect 'another prefix, bindings and set' 0 btf-shader "$file" -l vulkan --prefix two --first-binding 7 --set 3 -o two -q
expect 'fast math' 0 btf-shader "$file" -l glsl330 --math fast -o fast -q
expect 'WGSL' 0 btf-shader "$file" -l wgsl --set 1 --first-binding 4 --prefix web -o web -q
cat >manifests.py <<'P'
import json, os
def manifest(folder):
    with open(folder + "/manifest.json") as file:
        m = json.load(file)
    assert sorted(os.listdir(folder)) == sorted(["manifest.json", m["shader"]["file"]] + [t["file"] for t in m["textures"]])
    with open(f"{folder}/{m['shader']['file']}") as file:
        text = file.read()
    for f in m["shader"]["functions"]:
        assert f["signature"] in text and f["name"] + "(" in f["signature"], f
    assert {f["name"].split("_", 1)[1] for f in m["shader"]["functions"]} == {"evaluate", "evaluate_nearest", "evaluate_level", "level"}
    assert m["texture_bytes"] == sum(l["bytes"] for t in m["textures"] for l in t["levels"])
    assert ("zero" in m["shader"]) == (m["shader"]["language"] in ("glsl330", "essl300", "essl310", "wgsl") and m["options"]["math"] == "exact")
    return m
whole, units, bare, two = manifest("again"), manifest("units"), manifest("bare"), manifest("two")
assert whole["shader"]["zero"] == {"uniform": "btf_zero", "type": "uint", "value": 0}
layers = lambda m, name: [t["layers"] for t in m["textures"] if t["name"] == name]
assert units["options"]["components"] == 1 and layers(units, "factor_directions") == [1] != layers(whole, "factor_directions")
assert bare["options"]["components"] == 0 and layers(bare, "factor_texels") == []
assert "residual" not in bare["options"]["effects"] and "residual" in bare["material"]["effects"]
assert [t["set"] for t in two["textures"]] == [3] * len(two["textures"]) and two["textures"][0]["binding"] >= 7
assert all(t["sampler"] == "two_" + t["name"] for t in two["textures"])
assert "zero" not in manifest("fast")["shader"]
web = manifest("web")
with open("web/decode.wgsl") as file:
    text = file.read()
for t in web["textures"]: # each texture, and the run-time zero, is declared at the binding that the manifest states
    assert any(f'@group({t["set"]}) @binding({t["binding"]}) var {t["sampler"]}:' in line for line in text.splitlines()), t["name"]
zero = web["shader"]["zero"]
assert f'@group({zero["set"]}) @binding({zero["binding"]}) var<uniform> {zero["uniform"]}: u32' in text, zero
assert text.count("@binding(") == len(web["textures"]) + 1
assert web["shader"]["functions"][0]["signature"].startswith("fn web_evaluate(") and web["shader"]["functions"][0]["signature"].endswith("vec3f")
plan = manifest("plan")["plan"]
assert plan["whole_gpu_bytes"] > 0 and plan["level"] >= 0
P
expect 'manifests' 0 python3 manifests.py

# ---- languages that need other libraries: written, or refused with their name

for language in spirv hlsl msl; do
    btf-shader "$file" -l $language -o "of-$language" -q 2>err
    code=$?
    if [ $code = 5 ]; then
        expect_text "$language: the missing library is named" 'built without (glslang|SPIRV-Cross)' err
        expect_that "$language: nothing is left" test ! -e "of-$language"
    else
        expect_that "$language" test $code = 0 -a -s "of-$language/manifest.json"
        if [ $language = msl ]; then
            expect_text 'its comment names the macro of the kernel' 'where BTF_ENTRY is defined' of-msl/decode.metal
            expect_text 'and the kernel asks for it' '^#ifdef BTF_ENTRY$' of-msl/decode.metal
        fi
    fi
done
finish
