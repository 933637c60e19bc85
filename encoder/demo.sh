#!/bin/bash
# The main job on a Debian 12 machine, installing what is missing (as root): encodes a BTF, prints size and accuracy
# tables, and leaves pictures in build/demo/.
#
#   encoder/demo.sh                  the built-in sample, a brick wall
#   encoder/demo.sh DATA [OPTION..]  a data set (folder, zip) of yours; options go to btf-encode
#
# SPDX-License-Identifier: MIT
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/.ci/setup.sh"

case ${1:-} in
-h | --help)
    sed -n '2,6s/^# \{0,1\}//p' "$0"
    exit 0
    ;;
esac

install_packages build
build "$root/build" -- encoder/btf-encode decoder/tools/btf-info tests/sample/btf-sample

demo=$root/build/demo
tools=$root/build
mkdir -p "$demo"
if [ $# -gt 0 ]; then
    data=$1
    shift
else
    data=$demo/data/bricks
    if [ ! -d "$data" ]; then # under another name until it is whole
        rm -rf "$data.part"
        "$tools/tests/sample/btf-sample" -o "$data.part" --relief bricks --format png
        mv "$data.part" "$data"
    fi
fi
name=$(basename "${data%/}")
name=${name%.*}
material=$demo/$name.btf.exr

"$tools/encoder/btf-encode" "$data" -o "$material" --report "$demo/$name.json" --pictures "$demo/$name" "$@"
"$tools/decoder/tools/btf-info" "$material"
echo
echo "Pictures: $demo/$name/montage.png and others beside it. Material: $material"
