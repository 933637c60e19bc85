#!/bin/bash
# Conformance in WebGPU: chromium|firefox BUILT BTF_CONFORM TEST_WGSL PYTHON [--long].
#
# SPDX-License-Identifier: MIT
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$here/../../..
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# checked first, because the rest takes long
node --input-type=module -e "import { needPrograms, needWebGPU } from '$here/../browser.mjs'; needPrograms('$1'); needWebGPU('$1');"
mkdir "$work/vectors" "$work/texts"
"$3" --vectors "$work/vectors"
"$5" "$here/../vectors.py" "$root/tests/conformance/port/replay_exr.py" "$work/vectors" "$work/raw"
"$4" --write "$work/texts"
"$root/decoder/web/package.sh" "$work/package" "$2"
node "$here/run.mjs" "$1" "$work/package" "$work/raw" "$root/tests/data/golden" "$work/texts" ${6:+"$6"}
