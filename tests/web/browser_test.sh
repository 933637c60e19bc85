#!/bin/bash
# All tests in a browser: chromium|firefox BUILT BTF_CONFORM BTF_RENDER PYTHON NPM_FOLDER [PART...].
#
# SPDX-License-Identifier: MIT
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$here/../..
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/vectors" "$work/raw" "$work/scenes"
case " ${*:7} " in
'  ' | *' conform '*) # the only part that reads vectors
    "$3" --vectors "$work/vectors"
    "$5" "$here/vectors.py" "$root/tests/conformance/port/replay_exr.py" "$work/vectors" "$work/raw"
    ;;
esac
"$root/decoder/web/package.sh" "$work/package" "$2"
node "$here/run_browser.mjs" "$1" "$work/package" "$work/raw" "$root/tests/data/golden" "$6/node_modules" "$4" "$work/scenes" "${@:7}"
