#!/bin/bash
# The Python package over the libraries of this build: its tests, the layout of its structures, its wheel, its example.
#
#   test_python.sh INTERPRETER
#
# SPDX-License-Identifier: MIT
. "$(dirname "$0")/../tools/common.sh"
interpreter=$1
"$interpreter" -c 'import numpy, setuptools, wheel' 2>/dev/null || {
    echo "skipped: $interpreter has no numpy, setuptools or wheel"
    exit 77
}
unset LD_LIBRARY_PATH # meson sets it so that programs find the libraries of the build folder
root=$BTF_SOURCE_ROOT
mkdir lib
ln -s "$build"/decoder/libopenbtf.so.0.2 "$build"/reference/libopenbtf_reference.so.0.2 \
    "$build"/encoder/library/libopenbtf_input.so.0.2 lib/
export OPENBTF_LIBDIR=$work/lib OPENBTF_BINDIR=$build/encoder OMP_WAIT_POLICY=passive

"$interpreter" "$root/tests/python/test_openbtf.py" || failures=$((failures + 1))

layout() {
    "$interpreter" "$root/tests/python/layout.py" layout.c &&
        cc -std=c11 -fsyntax-only -I"$root/decoder/include" -I"$root/reference/include" \
            -I"$root/encoder/library/include" layout.c
}
expect_that 'structures are laid out as the headers say' layout
sed -i '0,/== [0-9]*, "btf_plan"/s//== 8, "btf_plan"/' layout.c
expect 'and one that is not is noticed' 1 cc -std=c11 -fsyntax-only -I"$root/decoder/include" \
    -I"$root/reference/include" -I"$root/encoder/library/include" layout.c

wheel() {
    cp -r "$root/decoder/python" package && cd package && cp -L ../lib/*.so.0.2 openbtf/ && mkdir openbtf/lib &&
        mv openbtf/*.so.0.2 openbtf/lib/ &&
        "$interpreter" -c 'from setuptools.build_meta import build_wheel; build_wheel("..")' && cd .. &&
        "$interpreter" -m zipfile -e openbtf-0.2.0-*linux*.whl unpacked
}
expect_that 'a wheel' wheel
from_wheel() {
    env -u OPENBTF_LIBDIR PYTHONPATH="$work/unpacked" "$interpreter" -c '
import openbtf, sys
assert openbtf.__file__.startswith(sys.argv[1]), openbtf.__file__
print(openbtf.open(sys.argv[2]).image(0, 0).shape)' "$work/unpacked" "$root/tests/data/golden/v1-tight.btf.exr"
}
expect 'it works alone, with the libraries in it' 0 from_wheel

expect 'without libraries' 1 env OPENBTF_LIBDIR=/nowhere PYTHONPATH="$root/decoder/python" "$interpreter" -c 'import openbtf'
expect_text 'without libraries: says where it looked' 'is not installed where the openbtf package looks' err

# The program of the room's README.
cp "$root/tests/data/golden/v1-tight.btf.exr" cloth.btf.exr
expect 'a data set' 0 btf-sample -o set --size 20 --directions tiny --quiet
(cd set && "$interpreter" -m zipfile -c ../UBO2003.zip tv*)
awk '/^```python$/ { inside = 1; next } /^```$/ { inside = 0 } inside' "$root/decoder/python/README.md" >program.py
expect 'the program of README.md' 0 "$interpreter" program.py
expect_text 'which encodes' 'save.*100|100.*save' out
expect_that 'and writes a shader' grep -q btf_evaluate cloth.frag

# One script for a zip of UBO2003, a Bonn file and a material.
"$build/tests/tools/bonn_sample" bonn.btf
script=$root/decoder/python/examples/lights.py
expect 'a script on a zip and its material' 0 "$interpreter" "$script" UBO2003.zip cloth.btf.exr
expect_text 'the same brightness' 'RMS against the first: 0\.0[012]' out
expect 'on a folder, which is the same as the zip' 0 "$interpreter" "$script" set UBO2003.zip
expect_text 'the same numbers' 'RMS against the first: 0\.00000' out
expect 'on a Bonn file' 0 "$interpreter" "$script" bonn.btf
expect_text 'seven lights' 'Data bonn.btf: 7 views, 7 lights, 16 x 16 texels' out
expect 'on what is neither' 1 "$interpreter" "$script" program.py

expect 'the example' 0 "$interpreter" "$root/decoder/python/examples/abrdf.py" \
    "$root/tests/data/golden/v1-tight.btf.exr" "$root/tests/data/golden/v2-relief.btf.exr" -o lobes
expect_that 'its picture or table' test -s lobes.png -o -s lobes.csv
finish
