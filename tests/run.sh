#!/bin/bash
# Builds and runs every test on a Debian 12 machine, installing what is missing (as root).
# The last line is "N passed, N failed, N skipped"; the exit code is 0 when nothing failed.
#
#   tests/run.sh          all tests of the release build, then all under AddressSanitizer and UBSan but those that have
#                         nothing for them to see (tests/meson.build: suite plain)
#   tests/run.sh --long   the same with the suite long (tests/README.md): conformance on other devices, libFuzzer, broken builds,
#                         ThreadSanitizer; BTF_FUZZ_SECONDS of each fuzz target (20)
#   tests/run.sh --core   without the tests of decoder/web, which need emscripten, two browsers and npm (1.2 GB), and those
#                         of btf-bake, which need Blender (0.6 GB)
#
# SPDX-License-Identifier: MIT
set -u
root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/.ci/setup.sh"

long=0
core=0
for argument in "$@"; do
    case $argument in
    --long) long=1 ;;
    --core) core=1 ;;
    -h | --help)
        sed -n '2,10s/^# \{0,1\}//p' "$0"
        exit 0
        ;;
    *)
        echo "tests/run.sh: unknown argument '$argument' (expected --long, --core or --help)" >&2
        exit 1
        ;;
    esac
done

purposes=(build test)
[ "$core" = 1 ] || purposes+=(web bake)
install_packages "${purposes[@]}"
export BTF_SOURCE_ROOT=$root BTF_SHARED=${BTF_SHARED:-$root/../shared}
logs=()

# run_suite FOLDER [meson test option...]
run_suite() {
    local folder=$1
    shift
    # One more than there are cores: tests that wait for signals, windows or ranks leave theirs to another.
    meson test -C "$folder" --no-rebuild --print-errorlogs --num-processes $(($(nproc) + 1)) --wrapper "$root/tests/cost.sh" "$@" || true
    logs+=("$folder/meson-logs/testlog-cost.sh.json") # meson names it after the wrapper
}

# With these a package that is missing is an error, not tests that are left out.
all=(-Dwerror=true -Dtests=enabled -Dmpi=enabled)
beside=(-Dweb=false -Dbake=false)
if [ "$core" = 0 ]; then
    "$root/decoder/web/wasm/sources.sh" "$root/build/web-sources" || exit 2
    beside=(-Dweb=true -Dbake=true)
fi
build "$root/build" "${all[@]}" "${beside[@]}"
if [ "$long" = 1 ]; then
    run_suite "$root/build" --timeout-multiplier 10
else
    run_suite "$root/build" --no-suite long
fi

# Null pointers and objects' sizes are AddressSanitizer's own business: without UBSan's checks of each access the build
# takes a fifth less time, and the tests a seventh.
unchecked=-fno-sanitize=null,object-size
# Line numbers are all that a report shows: without the rest of the debug information the build takes a third less time.
lines=-g1
# Optimised as little as keeps the tests fast: of instrumented C, -O1 takes six tenths of what -O2 takes to compile.
little=-O1
# Warnings are errors in the release build alone: with -O1 and checks inlined gcc warns of null pointers that cannot be.
warned=-Dwerror=false
# The alignment of what templates of Eigen load is not looked at: the Ceres bridge compiles in 26 s instead of 43.
build "$root/build-sanitize" "${all[@]}" -Dweb=false -Dbake=false $warned -Dbuildtype=debugoptimized -Db_sanitize=address,undefined -Db_lundef=false \
    "-Dc_args=$unchecked $lines $little" "-Dcpp_args=$unchecked,alignment $lines"
export ASAN_OPTIONS=detect_leaks=1:abort_on_error=0:verify_asan_link_order=0 UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1
export LSAN_OPTIONS=suppressions=$root/tests/lsan.supp:print_suppressions=0 BTF_TEST_LIGHT=1
export LD_PRELOAD=$root/build-sanitize/tests/libkeep_modules.so
run_suite "$root/build-sanitize" --no-suite long --no-suite plain
unset LD_PRELOAD

exec python3 "$root/tests/summary.py" "${logs[@]}"
