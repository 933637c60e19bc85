#!/bin/bash
# Runs the loader and the readers under valgrind, which notices uses of uninitialised bytes, as the sanitizers do not:
# fuzz targets over their corpus, and test programs that are given by their path.
#
#   tests/valgrind.sh BUILD TARGET|PROGRAM...
#
# Exits 1 on an error or a leak, 77 (with the reason) without valgrind.
#
# SPDX-License-Identifier: MIT
set -u -o pipefail
command -v valgrind >/dev/null || {
    echo "skipped: valgrind is not there"
    exit 77
}
build=$1 failures=0
shift
echo "TITLE | Valgrind over the loader and the readers, with the inputs kept for the fuzz targets."
for target in "$@"; do
    case $target in
    */*)
        name=$(basename "$target") command=("$target") input="its own files"
        ;;
    *)
        name=$target command=("$build/tests/fuzz/fuzz-$target" "$(dirname "$0")/fuzz/corpus/$target")
        input="$(find "$(dirname "$0")/fuzz/corpus/$target" -type f | wc -l) files"
        ;;
    esac
    echo "[ RUN      ] $name"
    if valgrind -q --error-exitcode=9 --leak-check=full --errors-for-leak-kinds=definite,indirect \
        "${command[@]}" | grep -v -e '^CASE' -e '^TITLE'; then
        echo "[       OK ] $name"
        verdict=pass
    else
        echo "[  FAILED  ] $name"
        verdict=FAIL
        failures=$((failures + 1))
    fi
    echo "CASE | $name | no error, no leak | $input | $verdict"
done
exit $((failures > 0))
