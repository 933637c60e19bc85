#!/bin/bash
# Runs a test and then prints on stderr its core seconds, its children's included. tests/run.sh gives it to meson as the
# wrapper of all tests, and summary.py reads the log.
#
# SPDX-License-Identifier: MIT
times_file=$(mktemp)
"$@"
code=$?
times >"$times_file"
awk -F '[ms ]+' 'END { printf "core seconds: %.2f\n", 60 * ($1 + $3) + $2 + $4 }' "$times_file" >&2
rm -f "$times_file"
exit $code
