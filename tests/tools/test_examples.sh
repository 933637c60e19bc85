#!/bin/bash
# The examples: a forward shader with two materials and an ordinary one; Vulkan against the reference.
#
# SPDX-License-Identifier: MIT
. "$BTF_SOURCE_ROOT/tests/tools/common.sh" || exit 99
PATH=$build/decoder/examples:$build/tests/tools:$PATH
small_data
btf-encode data -o a.btf.exr --method paper $starts -q || exit 99
btf-sample -o other --relief bumps --size 12 --directions 0:1,45:4 --quiet || exit 99
btf-encode other -o b.btf.exr --method paper $starts -q || exit 99
btf-encode other -o c.btf.exr --method paper $starts --levels all -q || exit 99
factor_file d.btf.exr 3 tight 3 roots || exit 99

# third NAME PART: the middle of a third of the columns, 0..2
third() {
    python3 - "$1" "$2" <<'P'
import sys
data = open(sys.argv[1], "rb").read()
pixels, width, part = data[-480 * 160 * 3:], 480, int(sys.argv[2])
assert data.startswith(b"P6\n480 160\n255\n") and len(data) == 15 + len(pixels)
sys.stdout.buffer.write(b"".join(pixels[3 * (480 * r + 160 * part + 30):3 * (480 * r + 160 * part + 130)] for r in range(160)))
P
}
expect "forward: two materials" 0 forward a.btf.exr b.btf.exr
cp out ab.ppm
expect "forward: the other way round" 0 forward b.btf.exr a.btf.exr
cp out ba.ppm
expect "forward: one twice" 0 forward a.btf.exr a.btf.exr
cp out aa.ppm
for name in ab ba aa; do
    for part in 0 1 2; do third $name.ppm $part >$name$part; done
done
expect_that "left is its own material" cmp ab0 aa0
expect_that "right is its own material" cmp ba2 aa2
expect_that "the ordinary one does not depend on them" cmp ab1 ba1
expect_that "left and right differ by material" test "$(cmp -s ab0 ba0; echo $?)" = 1
expect_that "no part is black" test "$(for f in ab0 ab1 ab2; do tr -d '\0' <$f | head -c 1 | wc -c; done | tr -d '\n')" = 111
expect "forward: format version 2" 0 forward d.btf.exr a.btf.exr
cp out da.ppm
third da.ppm 0 >da0
expect_that "left is another material" test "$(cmp -s da0 aa0; echo $?)" = 1
expect_that "and not black" test "$(tr -d '\0' <da0 | head -c 1 | wc -c)" = 1
expect "forward without arguments" 1 forward
expect "forward without a file" 2 forward none.btf.exr a.btf.exr

# mean PICTURE...: the mean of each picture's bytes
mean() {
    python3 - "$@" <<'P'
import struct, sys, zlib
for path in sys.argv[1:]:
    with open(path, "rb") as file:
        data, at, pixels = file.read(), 8, b""
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        assert struct.unpack(">I", data[at + 8 + size:at + 12 + size])[0] == zlib.crc32(data[at + 4:at + 8 + size])
        pixels += data[at + 8:at + 8 + size] if kind == b"IDAT" else b""
        at += size + 12
    pixels = zlib.decompress(pixels)
    assert len(pixels) == 120 * (1 + 3 * 160), len(pixels)
    print(sum(pixels) / (120 * 480))
P
}
samples=6
[ -n "$light" ] && samples=1
expect "pathtrace: by tables" 0 pathtrace a.btf.exr tables.png $samples
expect "pathtrace: by the cosine" 0 pathtrace a.btf.exr cosine.png $samples cosine
expect "pathtrace: factors" 0 pathtrace d.btf.exr factors.png 1
mean tables.png cosine.png factors.png >means
unless_light expect_that "both ways converge to one picture, and it is not black" awk 'NR == 1 { a = $1 } NR == 2 { b = $1 } END { exit !(a > 20 && a - b < 1.5 && b - a < 1.5) }' means
expect "pathtrace without arguments" 1 pathtrace
expect "pathtrace: no samples" 1 pathtrace a.btf.exr none.png 0
expect "pathtrace without a file" 2 pathtrace none.btf.exr none.png
expect "pathtrace to nowhere" 2 pathtrace a.btf.exr none/none.png 1

if command -v vulkan >/dev/null && command -v glslangValidator >/dev/null; then
    lavapipe=$(ls /usr/share/vulkan/icd.d/lvp_icd*.json 2>/dev/null | head -1)
    cp "$BTF_SOURCE_ROOT/tests/data/golden/v2-all.btf.exr" factors.btf.exr
    cp "$BTF_SOURCE_ROOT/tests/data/golden/v2-paper.btf.exr" atlas.btf.exr
    cp "$BTF_SOURCE_ROOT/tests/data/golden/v2-points.btf.exr" points.btf.exr
    for m in factors $(unless_light echo atlas points a b d) c; do
        expect "vulkan: the shader of $m" 0 vulkan $m.btf.exr
        cp out decode.comp
        expect "vulkan: to SPIR-V" 0 glslangValidator -V decode.comp -o decode.spv
        expect_that "which is there" test -s decode.spv
        if [ -z "$lavapipe" ]; then
            echo "skipped: no lavapipe here"
            continue
        fi
        expect "vulkan: run" 0 env VK_ICD_FILENAMES="$lavapipe" vulkan $m.btf.exr decode.spv
        expect_text "vulkan: no bit differs" '^0 of 16384 differ' out
    done
    # a wrong shader is noticed
    sed 's/radiance\[c\]/radiance[c] * 1.0000001/' decode.comp >wrong.comp
    glslangValidator -V wrong.comp -o wrong.spv >/dev/null
    [ -z "$lavapipe" ] || expect "vulkan: a wrong bit is found" 7 env VK_ICD_FILENAMES="$lavapipe" vulkan c.btf.exr wrong.spv
    sed 's/int(i % BTF_LEVELS)/0/' decode.comp >wrong.comp # the last was c
    glslangValidator -V wrong.comp -o wrong.spv >/dev/null
    [ -z "$lavapipe" ] || expect "vulkan: a wrong level is found" 7 env VK_ICD_FILENAMES="$lavapipe" vulkan c.btf.exr wrong.spv
    expect "vulkan: no device" 5 env VK_ICD_FILENAMES=none.json vulkan b.btf.exr decode.spv
    expect "vulkan: no SPIR-V" 2 vulkan b.btf.exr none.spv
    expect "vulkan without arguments" 1 vulkan
else
    echo "skipped: the Vulkan example was not built, or no glslangValidator"
fi
finish
