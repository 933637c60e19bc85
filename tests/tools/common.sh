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
starts="--starts 1${light:+ --lobes 1}" # for --method paper where the fit is not the subject
side=16                     # texels of small_data
[ -n "$light" ] && side=8
# Reliefs of fewer cells than the default, which take longer to make than the images take to encode.
btf-sample() { command btf-sample --grid 256 "$@"; }

# With BTF_TEST_COSTS, each line begins with the core seconds so far: the work between two lines took the difference.
report() { # NAME VERDICT [detail]
    if [ -n "${BTF_TEST_COSTS:-}" ]; then
        times >times
        awk -F '[ms ]+' '{ s += 60 * ($1 + $3) + $2 + $4 } END { printf "%.1f core seconds\n", s }' times
        rm times
    fi
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

# unless_light COMMAND...: runs a command that light runs leave out, since it shows the sanitizers nothing that its
# neighbours do not.
unless_light() { [ -n "$light" ] || "$@"; }

# A data set of 7 views and 7 lights in $work/data, $side x $side.
small_data() { btf-sample -o data --relief bricks --size $side --directions 0:1,40:6 --quiet "$@" || exit 99; }

# The least --memory that btf-encode accepts with these arguments. With it samples lie in a scratch file.
least_memory() { btf-encode "$@" -o least.btf.exr -q --memory 1 2>&1 | grep -o 'at least [0-9]*K' | grep -o '[0-9]*K'; }

# at MOMENT ACTION COMMAND...: acts on the tool at a moment that does not depend on time (tests/support/moment.c).
# ACTION is INT, TERM, KILL or a shell command; MOMENT is one of
#     N call             before the N-th call that makes or changes a file: `calls` says how many there are
#     N open TEXT        before the N-th file is opened whose path holds TEXT
#     N rename TEXT      after the N-th file got a final name that holds TEXT
#     N print TEXT       after the N-th line on stderr that holds TEXT, such as "read: done"
at() {
    local moment=$1 action=$2
    shift 2
    env "$preload" "BTF_MOMENT=$moment" "BTF_ACTION=$action" "$@"
}
preload=LD_PRELOAD=$build/tests/support/libmoment.so${LD_PRELOAD:+:$LD_PRELOAD}
# Simulates a GPU without memory for folds, for OSMesa and GLFW (tests/support/short_gpu.c).
short_gpu=LD_PRELOAD=$build/tests/support/libshort_gpu.so${LD_PRELOAD:+:$LD_PRELOAD}
export ASAN_OPTIONS=${ASAN_OPTIONS:-}:verify_asan_link_order=0 # its runtime is not the first library then

# calls COMMAND...: prints how many calls of the command make or change a file.
calls() {
    rm -f calls
    env "$preload" BTF_CALLS=calls "$@" >/dev/null 2>&1
    cat calls
}

# moments N CALLS: prints N evenly spaced numbers from 1 to CALLS; all of them where there are fewer than N.
moments() { awk -v n="$1" -v c="$2" 'BEGIN { n = n < c ? n : c; for (i = 0; i < n; i++) print 1 + int(i * (c - 1) / (n > 1 ? n - 1 : 1)) }'; }
