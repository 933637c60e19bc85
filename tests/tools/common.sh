# Sourced by the tests of the tools: a scratch folder, a small data set, and checks that print one line each in the
# form that tests/summary.py counts.
#
# SPDX-License-Identifier: MIT
set -u
build=$BTF_BUILD_ROOT
PATH=$build/encoder:$build/decoder/tools:$build/tests/sample:$PATH
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
failures=0
light=${BTF_TEST_LIGHT:-} # not empty: repeat less (tests/meson.build)
starts=${light:+--starts 1} # for --method paper where fitting from several starts is not the subject

report() { # NAME VERDICT [detail]
    echo "[ RUN      ] $1"
    if [ "$2" = ok ]; then
        echo "[       OK ] $1"
    else
        echo "${3:-}"
        echo "[  FAILED  ] $1"
        failures=$((failures + 1))
    fi
}

# expect NAME CODE COMMAND...: runs it and compares the exit code; output is kept in $work/out and $work/err.
expect() {
    local name=$1 code=$2 got
    shift 2
    "$@" >out 2>err </dev/null
    got=$?
    if [ "$got" = "$code" ]; then
        report "$name" ok
    else
        report "$name" failed "exit code $got, expected $code: $* $(head -c 2000 err)"
    fi
}

# expect_text NAME PATTERN FILE: an extended regular expression must be found.
expect_text() {
    if grep -Eq -- "$2" "$3"; then
        report "$1" ok
    else
        report "$1" failed "no match for '$2' in: $(head -c 1000 "$3")"
    fi
}

# expect_that NAME COMMAND...: the command must succeed.
expect_that() {
    local name=$1
    shift
    if "$@" >that 2>&1; then
        report "$name" ok
    else
        report "$name" failed "$* failed: $(head -c 1000 that)"
    fi
}

finish() { exit $((failures > 0)); }

# A data set of 7 views and 7 lights in $work/data, 16 x 16.
small_data() { btf-sample -o data --relief bricks --size 16 --directions 0:1,40:6 --quiet "$@" || exit 99; }

# The least --memory that btf-encode takes with these arguments: samples then lie in a scratch file.
least_memory() { btf-encode "$@" -o least.btf.exr -q --memory 1 2>&1 | grep -o 'at least [0-9]*K' | grep -o '[0-9]*K'; }
