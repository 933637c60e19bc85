#!/bin/bash
# The npm package, packed by npm, installed from its tarball and run in Node.js: BUILT GOLDEN CORPUS.
#
# SPDX-License-Identifier: MIT
set -eu
here=$(cd "$(dirname "$0")" && pwd)
web=$here/../../decoder/web
for program in node npm; do
    command -v $program >/dev/null || { echo "$program is missing: apt-get install ${program/%node/nodejs}"; exit 1; }
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$web/package.sh" "$work/package" "$1"
version=$(sed -n "s/^ *version: '\(.*\)',/\1/p" "$here/../../meson.build")
mkdir "$work/user"
cd "$work/user"
# npm keeps what it knows in the scratch folder, and asks no registry for anything
export npm_config_cache=$work/cache npm_config_offline=true npm_config_audit=false npm_config_fund=false npm_config_update_notifier=false
npm pack --silent "$work/package"
[ -f "openbtf-$version.tgz" ] || { echo "no tarball of version $version, that of meson.build: $(ls)"; exit 1; }
printf '{ "name": "user", "private": true }\n' >package.json
npm install --silent "./openbtf-$version.tgz"
cp "$here/harness.mjs" "$here/test_module.mjs" .
wasm=node_modules/openbtf/openbtf.wasm
echo "openbtf.wasm: $(stat -c %s $wasm) bytes, $(gzip -9nc $wasm | wc -c) as gzip; scripts: $(cat node_modules/openbtf/*.js | wc -c)," \
    "$(cat node_modules/openbtf/*.js | gzip -9nc | wc -c) as gzip; tarball: $(stat -c %s openbtf-*.tgz)"
node test_module.mjs "$2" "$3"
