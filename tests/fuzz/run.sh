#!/bin/bash
# Fuzzes one target with libFuzzer under AddressSanitizer and UBSan, from its corpus; needs clang.
#
#   tests/fuzz/run.sh TARGET SECONDS [FOLDER]
#
# TARGET: material plan names options list mesh environment checkpoint jpeg png hdr exr archive bonn. FOLDER (default
# build-fuzz) takes the program and what it finds: FOLDER/TARGET/found/ holds an input for each finding,
# FOLDER/TARGET/corpus/ what it learnt. The last lines say how many executions there were, what they covered and what
# core time they took. Exits 1 on a finding.
#
# SPDX-License-Identifier: MIT
set -eu
cd "$(dirname "$0")/../.."
if [ $# -lt 2 ]; then
    sed -n '2,10s/^# \{0,1\}//p' tests/fuzz/run.sh >&2
    exit 1
fi
target=$1 seconds=$2 folder=${3:-build-fuzz}/$1
version=$(pkg-config --modversion OpenEXR)
core=$(ls decoder/*.c | grep -v -e /gl -e /plan -e /shader_source)
context="encoder/base/context.c encoder/base/stage.c encoder/base/ranks.c encoder/base/ranks_alone.c"
images="encoder/input/image.c $context $(echo decoder/toolkit/*_image.c) $(echo decoder/pixels/*.c)
        decoder/toolkit/exif.c decoder/toolkit/output.c
        decoder/toolkit/progress.c decoder/toolkit/estimate.c decoder/result.c decoder/temporary.c"
data="$context encoder/data/data.c encoder/base/scratch.c encoder/input/grid.c encoder/input/names.c decoder/toolkit/progress.c decoder/toolkit/estimate.c decoder/toolkit/output.c
      decoder/result.c decoder/temporary.c $(echo reference/*.c)"
libraries="$(pkg-config --cflags --libs-only-L OpenEXR) -lm"
most=4096
planner="$(ls decoder/*.c | grep -v /gl) $folder/shader_text.c"
# The GLSL that decoder/shader_source.c puts together.
embed_shaders() {
    mkdir -p "$folder"
    python3 shaders/flatten.py --embed btf_shader_library=shaders/openbtf.glsl \
        btf_shader_self_test=shaders/self_test.glsl -o "$folder/shader_text.c"
}
case $target in
material)
    sources="tests/fuzz/fuzz_material.c tests/fuzz/mutate_exr.c $core $(ls reference/*.c) decoder/toolkit/reference_view.c"
    libraries+=" -lOpenEXRCore"
    most=16384
    ;;
plan)
    embed_shaders
    sources="tests/fuzz/fuzz_plan.c tests/support/plan_decode.c tests/support/random_material.c $planner
             $(ls reference/*.c) decoder/toolkit/reference_view.c"
    libraries+=" -lOpenEXRCore"
    most=512
    ;;
mesh)
    sources="tests/fuzz/fuzz_mesh.c decoder/tools/mesh/obj.c decoder/tools/mesh/mesh.c decoder/tools/mesh/tangents.c
             decoder/toolkit/file.c"
    most=1024
    ;;
environment)
    sources="tests/fuzz/fuzz_environment.c tests/fuzz/file.c tests/fuzz/mutate_exr.c decoder/tools/render/environment.c
             decoder/tools/render/lights.c decoder/toolkit/file.c $images"
    libraries+=" -lOpenEXRCore -lpng -ljpeg -lz"
    ;;
list)
    sources="tests/fuzz/fuzz_list.c tests/fuzz/file.c encoder/input/light_positions.c encoder/data/coincident.c encoder/job/batch.c $data"
    libraries+=" -Wl,--defsym=enc_job_run=0" # lists are read here, their jobs not run
    most=2048
    ;;
checkpoint)
    sources="tests/fuzz/fuzz_checkpoint.c tests/fuzz/step_data.c encoder/data/checkpoint.c encoder/paper/kept.c encoder/model/sbrdf.c
             encoder/model/occlusion.c encoder/paper/cluster.c $(echo encoder/kmeans*.c) $(echo encoder/fit*.c) $(ls encoder/joint*.c |
             grep -v -e _run -e _candidates -e _hide -e _quality -e _budget) encoder/model/pack.c encoder/report/metrics.c
             encoder/data/profiles.c encoder/paper/norms.c encoder/data/coincident.c encoder/report/ssim.c encoder/math/simd.c
             $(ls $core | grep -v -e /result -e /temporary) $folder/ceres_bridge.o $data"
    mkdir -p "$folder"
    clang++ -std=c++17 -O1 -isystem/usr/include/eigen3 -I. -Idecoder/include -c encoder/lafortune/ceres_bridge.cc -o "$folder/ceres_bridge.o"
    libraries+=" -fopenmp=libgomp -lceres -lglog -lstdc++ -lOpenEXRCore"
    most=4096
    ;;
names)
    sources="tests/fuzz/fuzz_names.c encoder/input/names.c"
    most=2048
    ;;
options)
    embed_shaders
    sources="tests/fuzz/fuzz_options.c decoder/toolkit/cli.c decoder/toolkit/scene_option.c encoder/input/options.c encoder/job/settings.c
             decoder/tools/render/lights.c decoder/tools/render/light_option.c
             tests/sample/directions.c $(ls $planner | grep -v -e /result -e /temporary) $data"
    libraries+=" -lOpenEXRCore"
    most=1024
    ;;
jpeg | png | hdr | exr)
    sources="tests/fuzz/fuzz_image.c tests/fuzz/mutate_exr.c tests/fuzz/mutate_png.c $images"
    libraries+=" -DFUZZ_IMAGE=FUZZ_${target^^} -DENC_IMAGE_MAX_PIXELS=((size_t)1<<20) -lOpenEXRCore -lpng -ljpeg -lz"
    ;;
archive)
    sources="tests/fuzz/fuzz_archive.c tests/fuzz/file.c encoder/input/source.c encoder/input/source_archive.c encoder/input/source_folder.c encoder/input/names.c $context
             decoder/toolkit/progress.c decoder/toolkit/estimate.c decoder/toolkit/output.c decoder/result.c decoder/temporary.c"
    libraries+=" -DENC_SOURCE_MAX_FILE=((size_t)1<<20) -larchive"
    ;;
bonn)
    sources="tests/fuzz/fuzz_bonn.c tests/fuzz/file.c reference/btf_arithmetic.c encoder/input/bonn_file.c encoder/input/bonn_decode.c encoder/input/bonn_colour.c encoder/math/gemm.c
             $context decoder/toolkit/progress.c decoder/toolkit/estimate.c decoder/toolkit/output.c decoder/result.c decoder/temporary.c"
    libraries+=" -fopenmp=libgomp -larchive"
    ;;
*)
    echo "tests/fuzz/run.sh: unknown target '$target'" >&2
    exit 1
    ;;
esac
command -v clang >/dev/null || {
    echo "skipped: clang is not there"
    exit 77
}
mkdir -p "$folder/corpus" "$folder/found"
# shellcheck disable=SC2086
clang -std=c11 -D_GNU_SOURCE -DOPENBTF_VERSION='"fuzz"' -O1 -g -ffp-contract=off -fno-omit-frame-pointer \
    -fsanitize=fuzzer,address,undefined -fno-sanitize-recover=undefined -I. -Idecoder -Idecoder/tools \
    -Idecoder/include -Ireference/include $sources $libraries -o "$folder/fuzz"
echo "OpenEXR $version, $(clang --version | head -1)"
set +e
ASAN_OPTIONS=detect_leaks=1:allocator_may_return_null=1 UBSAN_OPTIONS=print_stacktrace=1 \
    bash -c 'time "$@"' - "$folder/fuzz" -max_total_time="$seconds" -max_len=$most -timeout=20 -rss_limit_mb=6000 \
    -malloc_limit_mb=5000 -close_fd_mask=3 -print_final_stats=1 -artifact_prefix="$folder/found/" \
    "$folder/corpus" "tests/fuzz/corpus/$target" >"$folder/log" 2>&1
code=$?
units=$(sed -n 's/^stat::number_of_executed_units: *//p' "$folder/log")
core=$(awk '/^(user|sys)/ { split($2, t, /[ms]/); s += 60 * t[1] + t[2] } END { printf "%.0f", s }' "$folder/log")
echo "TITLE | libFuzzer on each target, under AddressSanitizer and UBSan."
echo "CASE | $target: libFuzzer for $seconds s | nothing found | ${units:-no} runs, $core core s | $([ $code = 0 ] && echo pass || echo FAIL)"
grep -E '#[0-9]+.*(DONE|INITED)|^stat::|ERROR|SUMMARY|not so|^(real|user|sys)' "$folder/log" | tail -20
[ $code = 0 ]
