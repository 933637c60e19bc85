#!/bin/bash
# Packs the npm package, installs the tarball, runs it in Node.js and checks its types: BUILT GOLDEN CORPUS NPM_FOLDER.
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
# npm keeps its cache in the scratch folder and asks no registry
export npm_config_cache=$work/cache npm_config_offline=true npm_config_audit=false npm_config_fund=false npm_config_update_notifier=false
npm pack --silent "$work/package"
[ -f "openbtf-$version.tgz" ] || { echo "no tarball of version $version, that of meson.build: $(ls)"; exit 1; }
printf '{ "name": "user", "private": true }\n' >package.json
npm install --silent "./openbtf-$version.tgz"
cp "$here/harness.mjs" "$here/test_module.mjs" .
node test_module.mjs "$2" "$3"
python3 "$web/sizes.py" node_modules/openbtf "$web/README.md"
stat -c 'tarball: %s bytes' openbtf-*.tgz

# The tarball beside three, its peer dependency: openbtf/three is found and makes a material, and the types are right.
ln -s "$4/node_modules/three" "$4/node_modules/@types" node_modules/
cp "$here/test_three.mjs" "$here/types.ts" .
node test_three.mjs "$2"
node "$4/node_modules/typescript/bin/tsc" --noEmit --strict --target es2022 --module nodenext --lib es2022,dom,dom.iterable --types three \
    types.ts
