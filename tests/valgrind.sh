#!/bin/bash
# Valgrind over the loader and the readers, which the sanitizers see without their uninitialised bytes: the corpus of
# each fuzz target goes through it.
#
#   tests/valgrind.sh BUILD TARGET...
#
# Exits 1 on an error or a leak, 77 (with the reason) without valgrind.
#
# SPDX-License-Identifier: MIT
set -u
command -v valgrind >/dev/null || {
    echo "skipped: valgrind is not there"
    exit 77
}
build=$1 failures=0
shift
for target in "$@"; do
    echo "[ RUN      ] $target"
    if valgrind -q --error-exitcode=9 --leak-check=full --errors-for-leak-kinds=definite,indirect \
        "$build/tests/fuzz/fuzz-$target" "$(dirname "$0")/fuzz/corpus/$target"; then
        echo "[       OK ] $target"
    else
        echo "[  FAILED  ] $target"
        failures=$((failures + 1))
    fi
done
exit $((failures > 0))
