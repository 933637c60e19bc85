#!/bin/bash
# package.sh OUT BUILT: the npm package `openbtf` as a folder OUT: the scripts and types of decoder/web/openbtf, the module and the
# notices that wasm/build.sh wrote into BUILT, and the licence. `npm pack OUT` makes its tarball.
#
# SPDX-License-Identifier: MIT
set -eu
[ $# -eq 2 ] || { sed -n '2,3s/^# \{0,1\}//p' "$0" >&2; exit 1; }
here=$(cd "$(dirname "$0")" && pwd)
rm -rf "$1"
mkdir -p "$1"
cp "$here"/openbtf/{package.json,README.md} "$here"/openbtf/*.js "$here"/openbtf/*.d.ts "$2/openbtf.wasm" "$2/NOTICES.txt" \
    "$here/../../LICENSE" "$1"
