#!/bin/bash
# Builds and runs every test on a Debian 12 machine, installing what is missing (as root).
# The last line is "N passed, N failed, N skipped"; the exit code is 0 when nothing failed.
#
#   tests/run.sh          all tests of the release build, then under AddressSanitizer and UBSan all but the suite plain
#                         (tests/meson.build)
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
    # One process more than there are cores: tests that wait for signals, windows or ranks leave their core idle.
    meson test -C "$folder" --no-rebuild --print-errorlogs --num-processes $(($(nproc) + 1)) --wrapper "$root/tests/cost.sh" "$@" || true
    logs+=("$folder/meson-logs/testlog-cost.sh.json") # meson names it after the wrapper
}

# With these options a missing package is an error; without them its tests would be left out.
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

# AddressSanitizer notices accesses through null pointers and beyond objects. Without UBSan's own checks of each access
# the build takes a fifth less time, and the tests a seventh.
unchecked=-fno-sanitize=null,object-size
# Reports show line numbers and no more. Without the rest of the debug information the build takes a third less time.
lines=-g1
# -O1 keeps the tests fast enough, and compiles instrumented C in six tenths of the time of -O2.
little=-O1
# Warnings are errors in the release build alone: with -O1 and checks inlined gcc warns of null pointers that cannot be.
warned=-Dwerror=false
# UBSan does not check the alignment of loads in Eigen's templates, so that the Ceres bridge compiles in 26 s, not 43.
build "$root/build-sanitize" "${all[@]}" -Dweb=false -Dbake=false $warned -Dbuildtype=debugoptimized -Db_sanitize=address,undefined -Db_lundef=false \
    "-Dc_args=$unchecked $lines $little" "-Dcpp_args=$unchecked,alignment $lines"
export ASAN_OPTIONS=detect_leaks=1:abort_on_error=0:verify_asan_link_order=0 UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1
export LSAN_OPTIONS=suppressions=$root/tests/lsan.supp:print_suppressions=0 BTF_TEST_LIGHT=1
export LD_PRELOAD=$root/build-sanitize/tests/libkeep_modules.so
run_suite "$root/build-sanitize" --no-suite long --no-suite plain
unset LD_PRELOAD

exec python3 "$root/tests/summary.py" "${logs[@]}"
