/* The list of sections, the files of a section, and the sections that are one table.
 *
 * SPDX-License-Identifier: MIT
 */
#include "bench.h"

#include "fit_bench.h"

#include <errno.h>
#include <string.h>

const bench_section bench_sections[BENCH_SECTIONS] = {
    {"machine", "what the machine could do at best", bench_section_machine, true},
    {"encode", "encoding: time against accuracy", bench_section_encode, true},
    {"decode", "decoding: time against accuracy, on every GL device and on the CPU", bench_section_decode,
     true},
    {"storage", "storage: bytes against accuracy", bench_section_storage, true},
    {"between", "accuracy between the samples, which is what a renderer sees, and at them",
     bench_section_between, false},
    {"growth", "encoding: growth of time and memory, up to the texels of --size", bench_section_growth,
     true},
    {"fit", "the Lafortune fit beside a Ceres problem with automatic derivatives", bench_section_fit,
     false},
    {"codecs", "accuracy at equal bytes, and bytes at equal accuracy, beside principal components",
     bench_section_codecs, false},
    {"lowbit", "the low-bit split PCA alone, the best of these peers: for tests/bench/peers.sh",
     bench_section_lowbit, false},
    {"holdout", "accuracy of the presets at directions that the encoder did not see", bench_section_holdout,
     false},
    {"plan", "what decoding only what a scene calls for saves, predicted and measured", bench_section_plan,
     false},
    {"costs", "the prices of the cost model that plans load, fitted to one device", bench_section_costs,
     false},
    {"stochastic", "decoding one neighbour in place of all: time against noise", bench_section_stochastic,
     false},
    {"shaders", "nanoseconds a pixel of every shader variant on random materials", bench_section_shaders,
     false},
};

const char *const bench_preset_names[BENCH_PRESETS] = {"fast", "medium", "thorough", "exhaustive"};

const char *bench_seen_words(const bench_run *run) {
    return run->truth->count > 0                             ? "between the samples"
           : run->held->owned                                ? "views and lights left out"
           : bench_between_has(run->between, BENCH_ESTIMATE) ? "between the samples, estimated"
                                                             : "at the samples";
}

void bench_path(const bench_run *run, const char *section, const char *extension, char *path, size_t size) {
    snprintf(path, size, "%s/%s-%s.%s", run->out, section, run->name, extension);
}

btf_result bench_open(const bench_run *run, const char *section, const char *extension, FILE **out_file) {
    char path[4096];
    bench_path(run, section, extension, path, sizeof path);
    *out_file = fopen(path, "w");
    return *out_file ? BTF_OK : enc_fail(run->context, BTF_ERROR_IO, "%s: %s", path, strerror(errno));
}

btf_result bench_section_fit(const bench_run *run) {
    FILE *csv = NULL;
    bench_fit_summary s;
    btf_result result = bench_open(run, "fit", "csv", &csv);
    if (result == BTF_OK) {
        result = bench_fit(run->context, run->data, run->texels, csv, &s);
        fclose(csv);
    }
    if (result != BTF_OK) {
        return result;
    }
    fprintf(run->summary,
            "| solver, %d texels | core ms a texel | times faster | cost against Ceres |\n| --- | --- | "
            "--- | --- |\n"
            "| Ceres, automatic derivatives | %.1f | 1 | 1 |\n"
            "| ours, the same start | %.2f | %.0f | %.4f |\n"
            "| ours, all starts | %.2f | %.0f | %.4f |\n\nWorst texel: %.3f of Ceres's cost.\n\n",
            s.texels, 1e3 * s.ceres_seconds / s.texels, 1e3 * s.single_seconds / s.texels,
            s.ceres_seconds / s.single_seconds, s.single_cost / s.ceres_cost,
            1e3 * s.full_seconds / s.texels, s.ceres_seconds / s.full_seconds, s.full_cost / s.ceres_cost,
            s.worst_ratio);
    return BTF_OK;
}
