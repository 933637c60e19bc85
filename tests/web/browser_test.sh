#!/bin/bash
# Conformance in a browser: chromium|firefox BUILT BTF_CONFORM PYTHON.
#
# SPDX-License-Identifier: MIT
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$here/../..
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/vectors"
"$3" --vectors "$work/vectors"
"$4" "$here/vectors.py" "$root/tests/conformance/port/replay.py" "$work/vectors" "$work/raw"
"$root/decoder/web/package.sh" "$work/package" "$2"
node "$here/conform.mjs" "$1" "$work/package" "$work/raw" "$root/tests/data/golden"
