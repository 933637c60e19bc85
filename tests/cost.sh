#!/bin/bash
# Runs a test and then tells its core seconds, its children's included, on stderr: meson's wrapper in tests/run.sh,
# whose log summary.py reads.
#
# SPDX-License-Identifier: MIT
times_file=$(mktemp)
"$@"
code=$?
times >"$times_file"
awk -F '[ms ]+' 'END { printf "core seconds: %.2f\n", 60 * ($1 + $3) + $2 + $4 }' "$times_file" >&2
rm -f "$times_file"
exit $code
