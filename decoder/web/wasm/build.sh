#!/bin/bash
# build.sh OUT [SOURCES [DEPFILE]]: libopenbtf, the reference decoder, OpenEXRCore and zlib as one WebAssembly module, OUT/openbtf.wasm,
# with the notices of what is in it, OUT/NOTICES.txt. Prints its size and that of its gzip.
#
# Needs Debian's emscripten and libopenexr-dev, and OpenEXR's and zlib's sources, which sources.sh fetches into SOURCES
# (default: build/web-sources of the source tree). The same sources give the same bytes, wherever they lie. DEPFILE gets the
# files that were read, for ninja. Exits 2 with a message where something is missing.
#
# SPDX-License-Identifier: MIT
set -eu
[ $# -ge 1 ] || { sed -n '2,8s/^# \{0,1\}//p' "$0" >&2; exit 1; }
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../../.." && pwd)
sources=${2:-$root/build/web-sources}
depfile=${3:-}
[ -z "$depfile" ] || depfile=$(realpath "$depfile")
command -v emcc >/dev/null || { echo "emcc is missing: apt-get install emscripten" >&2; exit 2; }
[ -f /usr/include/OpenEXR/OpenEXRConfig.h ] || { echo "OpenEXR's headers are missing: apt-get install libopenexr-dev" >&2; exit 2; }
"$here/sources.sh" "$sources"
mkdir -p "$1"
out=$(cd "$1" && pwd)
sources=$(cd "$sources" && pwd)
core=$sources/openexr/src/lib/OpenEXRCore

# Debian's emscripten finds its modules by this; a cache elsewhere would be built anew.
export NODE_PATH=/usr/share/nodejs
unset EM_CACHE
# Objects of another state of the sources are of no use: compiling takes half a minute.
objects=$(mktemp -d)
trap 'rm -rf "$objects"' EXIT
mkdir "$objects/text"
python3 "$root/shaders/flatten.py" --embed "btf_shader_library=$root/shaders/openbtf.glsl" \
    "btf_shader_self_test=$root/shaders/self_test.glsl" -o "$objects/text/shader_text.c"

# No path of this machine goes into the module.
flags=(-DNDEBUG -D_GNU_SOURCE -ffp-contract=off -fno-math-errno -ffunction-sections "-fmacro-prefix-map=$root/=" "-fmacro-prefix-map=$sources/="
    "-fmacro-prefix-map=$objects/=" -I/usr/include/Imath)
ours=("$root"/reference/*.c "$root"/decoder/toolkit/{filter,json,reference_view}.c "$here"/{exports,describe}.c "$objects/text/shader_text.c")
for file in "$root"/decoder/*.c "$root"/decoder/*/*.c; do
    case ${file#"$root/decoder/"} in
    toolkit/* | pixels/* | tools/* | examples/* | python/*) ;; # other rooms
    gl*.c | */gl*.c) ;;                             # JavaScript reaches the browser's GL
    *) ours+=("$file") ;;
    esac
done
theirs=("$sources"/zlib/{adler32,compress,crc32,deflate,inffast,inflate,inftrees,trees,uncompr,zutil}.c "$here/without_lossy.c")
for file in "$core"/*.c; do
    case $file in
    */internal_b44*.c | */internal_pxr24.c | */debug.c) ;;
    *) theirs+=("$file") ;;
    esac
done
# One call of emcc compiles the files of a folder: starting it takes as long as compiling a small file. Names are one folder's
# alone, for there are several relief.c.
compile() { # GROUP FILE... -- FLAG...
    mkdir "$objects/$1"
    cd "$objects/$1"
    shift
    local files=()
    while [ "$1" != -- ]; do
        files+=("$1")
        shift
    done
    shift
    emcc -c "$@" "${files[@]}"
}
export -f compile
export objects
{
    for folder in $(printf '%s\n' "${ours[@]}" | xargs -n 1 dirname | sort -u); do
        group=${folder#"$root/"} # the objects are linked by the order of these names, whatever the root is
        group=${group#"$objects/"}
        printf '%s\0' "compile ours_${group//\//_} $(printf '%s\n' "${ours[@]}" | grep "^$folder/[^/]*$" | tr '\n' ' ') -- -O2 -std=c11 -Wall -Wextra \
            -Werror -I$root -I$root/decoder/include -I$root/reference/include -I/usr/include/OpenEXR ${flags[*]}"
    done
    printf '%s\0' "compile theirs ${theirs[*]} -- -Os -std=gnu11 -w -I$core -I/usr/include/OpenEXR -I$sources/zlib ${flags[*]}"
} | xargs -0 -n 1 -P "$(nproc)" bash -c

# Exports are marked in exports.c; the module has no main and no JavaScript of emscripten's.
emcc -O2 -sSTANDALONE_WASM --no-entry -sALLOW_MEMORY_GROWTH -sMAXIMUM_MEMORY=4GB -sINITIAL_MEMORY=1MB -sTOTAL_STACK=512KB \
    -Wl,--gc-sections -Wl,--strip-all "$objects"/*/*.o -o "$out/openbtf.wasm"

{
    printf 'OpenBTF contains these works. Their notices:\n\n'
    printf -- '--- OpenEXR (OpenEXRCore) and Imath (half.h) ---\n\n'
    cat "$sources/openexr/LICENSE.md"
    printf -- '\n--- zlib ---\n\n'
    sed -n '/^Copyright notice:/,$p' "$sources/zlib/README" | sed '1,2d'
    printf -- '\n--- musl, the C library of emscripten ---\n\n'
    cat /usr/share/emscripten/system/lib/libc/musl/COPYRIGHT
    printf -- '\n--- emscripten ---\n\nCopyright (c) 2010-2022 The Emscripten Authors\n\n'
    # the text of the MIT licence, which is there once, below the lists of files
    awk '/^License: Expat$/ { at = 1; text = ""; next } at && /^$/ { at = 0 } at { sub(/^ \.?/, ""); text = text $0 "\n" } END { printf "%s", text }' \
        /usr/share/doc/emscripten/copyright
} >"$out/NOTICES.txt"
if [ -n "$depfile" ]; then # every file that may be read: a change of any builds anew
    printf '%s: %s\n' "${1%/}/openbtf.wasm" "$(find "$root/decoder" "$root/reference" "$root/shaders" -name '*.[ch]' -o -name '*.glsl' -o -path '*/web/wasm/*.sh' | sort | tr '\n' ' ')" >"$depfile"
fi
printf 'openbtf.wasm: %d bytes, %d as gzip\n' "$(stat -c %s "$out/openbtf.wasm")" "$(gzip -9nc "$out/openbtf.wasm" | wc -c)"
