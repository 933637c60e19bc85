#!/bin/bash
# Two builds of the WebAssembly module from sources in different folders have the same bytes: BUILT SOURCES.
#
# SPDX-License-Identifier: MIT
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/tree"
cp -r "$root/decoder" "$root/reference" "$root/shaders" "$work/tree/"
cp -r "$2" "$work/sources"
"$work/tree/decoder/web/wasm/build.sh" "$work/out" "$work/sources"
for file in openbtf.wasm NOTICES.txt; do
    cmp "$1/$file" "$work/out/$file"
done
