#!/bin/bash
# npm.sh FOLDER: installs the packages of the package-lock.json beside this file to FOLDER/node_modules. npm checks each
# against its hash there. Exits 2 with a message where that fails.
#
# SPDX-License-Identifier: MIT
set -eu
[ $# -eq 1 ] || { sed -n '2,3s/^# \{0,1\}//p' "$0" >&2; exit 1; }
here=$(cd "$(dirname "$0")" && pwd)
command -v npm >/dev/null || { echo "npm is missing: apt-get install npm" >&2; exit 2; }
mkdir -p "$1"
cp "$here/package.json" "$here/package-lock.json" "$1"
cd "$1"
export npm_config_cache=$PWD/npm-cache npm_config_audit=false npm_config_fund=false npm_config_update_notifier=false
if ! npm ci --ignore-scripts >npm.log 2>&1; then
    tail -20 npm.log >&2
    echo "npm.sh: the packages of tests/web/package-lock.json could not be fetched" >&2
    exit 2
fi
rm -rf npm-cache
touch npm.stamp
