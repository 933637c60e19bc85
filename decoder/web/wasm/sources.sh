#!/bin/bash
# sources.sh FOLDER: Debian's sources of OpenEXR and zlib, in FOLDER/openexr and FOLDER/zlib. Nothing is done where they
# are there already.
#
# The list of source packages and what apt learns of it lie in FOLDER: the machine's own lists are not touched, and no
# rights are needed. Debian's signatures are checked by apt. Exits 2 with a message where that fails.
#
# SPDX-License-Identifier: MIT
set -eu
[ $# -eq 1 ] || { sed -n '2,6s/^# \{0,1\}//p' "$0" >&2; exit 1; }
mkdir -p "$1"
folder=$(cd "$1" && pwd)
if [ -f "$folder/openexr/LICENSE.md" ] && [ -f "$folder/zlib/zlib.h" ]; then
    exit 0
fi
command -v dpkg-source >/dev/null || { echo "dpkg-source is missing: apt-get install dpkg-dev" >&2; exit 2; }
apt=$folder/apt
rm -rf "$apt" "$folder/files" "$folder/openexr" "$folder/zlib" # what an earlier try left
mkdir -p "$apt/lists/partial" "$apt/cache/archives/partial" "$folder/files"
# The release of Debian whose headers the build uses too. Its keys are those that the machine trusts.
cat >"$apt/sources.list" <<EOF
deb-src http://deb.debian.org/debian bookworm main
EOF
options=(-q -o "Dir::Etc::SourceList=$apt/sources.list" -o Dir::Etc::SourceParts=/dev/null -o "Dir::State::Lists=$apt/lists"
    -o "Dir::Cache=$apt/cache" -o APT::Sandbox::User=root)
if ! {
    apt-get "${options[@]}" update && cd "$folder/files" && apt-get "${options[@]}" --download-only source openexr zlib &&
        # apt has checked the files against Debian's signed list
        dpkg-source --no-check -x openexr_*.dsc "$folder/openexr" && dpkg-source --no-check -x zlib_*.dsc "$folder/zlib"
} >"$folder/log" 2>&1; then
    tail -20 "$folder/log" >&2
    echo "sources.sh: Debian's sources of OpenEXR and zlib could not be fetched (all of it: $folder/log)" >&2
    exit 2
fi
rm -rf "$apt"
