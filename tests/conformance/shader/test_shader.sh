#!/bin/bash
# Runs the files that btf-shader writes on every device that reads their language, and compares with the reference
# decoder; shows that wrong bytes and unprotected arithmetic are noticed.
#
#     test_shader.sh             a golden material in every language, and one of version 2; wrong files are noticed
#     test_shader.sh --long      every golden material in every language, and options
#     test_shader.sh --table     prints the table of languages of shaders/README.md (tests/bench/regenerate.sh)
#
# SPDX-License-Identifier: MIT
. "$BTF_SOURCE_ROOT/tests/tools/common.sh" || exit 99
PATH=$build/decoder/tools/shader:$build/tests/conformance/shader:$PATH
golden=$BTF_SOURCE_ROOT/tests/data/golden
entry=$BTF_SOURCE_ROOT/tests/conformance/shader/entry.py
metal=$BTF_SOURCE_ROOT/tests/conformance/shader/metal
count=4096
[ -n "${1:-}" ] && count=65536
lavapipe=$(ls /usr/share/vulkan/icd.d/lvp_icd*.json 2>/dev/null | head -1)
[ -n "$lavapipe" ] && export VK_ICD_FILENAMES=$lavapipe

# to_spirv LANGUAGE FOLDER OUT: the compute shader of a folder of GLSL for Vulkan, HLSL or SPIR-V
to_spirv() {
    case $1 in
    spirv) cp "$2/decode.spv" "$3" ;;
    vulkan)
        python3 "$entry" entry "$2" whole.comp || return 1
        glslangValidator -V whole.comp -o "$3"
        ;;
    hlsl)
        python3 "$entry" entry "$2" whole.hlsl || return 1
        glslangValidator -D -V -e main -S comp whole.hlsl -o "$3"
        ;;
    esac
}

# by_cpp FOLDER OUT: a library of Metal's text, by a C++ compiler
by_cpp() {
    local compiler=clang++
    command -v $compiler >/dev/null || compiler=g++
    python3 "$metal.py" "$1" metal.cc || return 1
    $compiler -std=c++17 -O1 -ffp-contract=off -w -fPIC -shared "-I$metal" metal.cc -o "$2"
}

# devices LANGUAGE: prints the devices that read it
devices() {
    case $1 in
    glsl330) echo osmesa-330 ;;
    glsl450) [ "$count" = 4096 ] && echo osmesa || echo osmesa egl ;;
    essl300) echo egl-es300 ;;
    essl310) echo egl-es310 ;;
    msl) echo metal ;;
    *) echo vulkan ;;
    esac
}

# decodes NAME LANGUAGE FOLDER FILE [argument of run_shader...]: on each device
decodes() {
    local name=$1 language=$2 folder=$3 file=$4 device
    shift 4
    for device in $(devices "$language"); do
        if [ "$device" = vulkan ]; then
            if [ -z "$lavapipe" ]; then
                echo "skipped: no lavapipe here"
                continue
            fi
            expect_that "$name: to SPIR-V" to_spirv "$language" "$folder" code.spv
            [ "$language" = vulkan ] || expect_that "$name: sums and products are protected" python3 "$entry" protected code.spv
            expect "$name: on $device" 0 run_shader vulkan "$folder" "$file" --code code.spv --count $count "$@"
        elif [ "$device" = metal ]; then
            expect_that "$name: sums and products are protected" python3 "$entry" protected "$folder/decode.metal"
            expect_that "$name: as C++" by_cpp "$folder" ./metal.so
            expect "$name: on the CPU" 0 run_shader metal "$folder" "$file" --code ./metal.so --count $count "$@"
        else
            expect "$name: on $device" 0 run_shader "$device" "$folder" "$file" --count $count "$@"
        fi
        expect_text "$name: on $device: no bit differs" "^$language: 0 of $count evaluations differ" out
        grep -h "^$language:" out
    done
}

# ways NAME LANGUAGE TEXTURES: a golden file through btf-shader and a device
ways() {
    local name="$1 in $2 with $3"
    rm -rf folder
    expect "$name" 0 btf-shader "$golden/$1.btf.exr" --language "$2" --textures "$3" --first-binding 1 -o folder -q
    decodes "$name" "$2" folder "$golden/$1.btf.exr"
}

# row LANGUAGE COMPILER: a line of the table
row() {
    local results
    rm -rf folder
    btf-shader "$golden/v2-all.btf.exr" -l "$1" --first-binding 1 -o folder -q || exit 2
    results=$(decodes table "$1" folder "$golden/v2-all.btf.exr" | tee table.log | sed -nE 's/.*: ([0-9]+) of ([0-9]+) eval.*/\1 of \2/p' | sort -u | paste -sd ';')
    ! grep -q FAILED table.log || { cat table.log >&2; exit 2; }
    printf '| `%s` | %s | %s | %s | %s |\n' "$1" "$2" "$3" "${results:-}" "$(stat -c %s folder/decode.* | sed ':a;s/\B[0-9]\{3\}\>/,&/;ta')"
}
if [ "${1:-}" = --table ]; then
    echo '| language | compiled by | run on | values that differ | bytes, `v2-all` |'
    echo '| --- | --- | --- | --- | --- |'
    row glsl330 'Mesa' 'OSMesa (llvmpipe)'
    row glsl450 'Mesa' 'OSMesa, EGL (llvmpipe)'
    row essl300 'Mesa' 'EGL (llvmpipe)'
    row essl310 'Mesa' 'EGL (llvmpipe)'
    row vulkan 'glslang' 'lavapipe'
    row spirv 'glslang' 'lavapipe'
    row hlsl "glslang's HLSL front end" 'lavapipe'
    row msl 'no Metal compiler; a C++ compiler' 'the CPU'
    rm -rf folder
    btf-shader "$golden/v2-all.btf.exr" -l wgsl -o folder -q || exit 2
    printf '| `wgsl` | browsers | WebGPU of browsers, by `tests/web`: the same text of the library | | %s |\n' \
        "$(stat -c %s folder/decode.wgsl | sed ':a;s/\B[0-9]\{3\}\>/,&/;ta')"
    exit
fi

languages="glsl330 glsl450 essl300 essl310 vulkan spirv hlsl msl"
stores=(ktx2 dds raw)
i=0
# The atlas of the paper, whose shader is the smallest, in every language, and one of version 2; the long run has all.
for language in $languages; do
    ways v1-paper "$language" "${stores[i++ % 3]}"
done
ways v2-roots essl310 raw
if [ "${1:-}" = --long ]; then
    for file in "$golden"/*.btf.exr; do
        for language in $languages; do
            ways "$(basename "$file" .btf.exr)" "$language" "${stores[i++ % 3]}"
        done
        i=$((i + 1)) # the next material begins with other kinds of texture file
    done

    # The shader has the options that the manifest states.
    file=$golden/v2-all.btf.exr
    expect 'nearest, steep, without gain' 0 btf-shader "$file" -l essl300 -o nearest -q --interpolation nearest \
        --filter steep --effects shift,residual,relief --components 1
    decodes 'nearest, steep, without gain' essl300 nearest "$file"
    for language in glsl330 spirv hlsl msl; do
        expect "stochastic, $language" 0 btf-shader "$file" -l $language -o "picks-$language" -q --picks all \
            --filter bilinear --prefix stone_2
        decodes "stochastic, $language" $language "picks-$language" "$file"
    done
    finish
fi

# ---- what is wrong is noticed

file=$golden/v2-all.btf.exr

# swap_byte FILE [AT]: changes the byte at AT, or one near the end
swap_byte() {
    python3 - "$1" "${2:--3}" <<'P'
import sys
data = bytearray(open(sys.argv[1], "rb").read())
data[int(sys.argv[2])] ^= 0x15
open(sys.argv[1], "wb").write(data)
P
}
for store in "${stores[@]}"; do
    rm -rf folder
    btf-shader "$golden/v1-paper.btf.exr" -l glsl450 --textures $store --first-binding 1 -o folder -q
    swap_byte "folder/maps.$store"
    expect "a wrong byte of $store" 7 run_shader osmesa folder "$golden/v1-paper.btf.exr"
    expect_text "a wrong byte of $store: the texture is named" '^maps: level 0 is not' err
done
rm -rf folder
btf-shader "$file" -l glsl450 --textures ktx2 --first-binding 1 -o folder -q
for at in 12 16 32 40 80 88; do # vkFormat, typeSize, layerCount, levelCount, the index of levels
    cp folder/shift.ktx2 kept
    swap_byte folder/shift.ktx2 $at
    expect "KTX 2.0: byte $at is read" 3 run_shader osmesa folder "$file"
    mv kept folder/shift.ktx2
done
if [ -n "$lavapipe" ]; then
    btf-shader "$file" -l hlsl -o hlsl -q
    sed -i 's/precise //' hlsl/decode.hlsl
    to_spirv hlsl hlsl loose.spv >/dev/null
    expect 'HLSL without precise: seen in SPIR-V' 1 python3 "$entry" protected loose.spv
    expect 'and in the text' 1 python3 "$entry" protected hlsl/decode.hlsl
fi

# ---- Metal's language, which no compiler of it sees here

expect 'msl' 0 btf-shader "$file" -l msl -o msl -q
expect_that 'msl: sums and products are protected' python3 "$entry" protected msl/decode.metal
sed 's/float4 r = spvFMul(a, float4(b))/float4 r = a * b/' msl/decode.metal >loose.metal
expect 'msl: a product that is not' 1 python3 "$entry" protected loose.metal
expect_text 'msl: it says that nobody compiled it' 'no Metal compiler has seen this text' msl/decode.metal
finish
