/* Section `holdout`: accuracy at directions that were not encoded. Every second azimuth of the ring at 45 degrees is
 * left out of the encoding, as views and as lights. There the reference decoder's result is compared with the truth,
 * and so are the original images interpolated with the same neighbours and weights.
 *
 * SPDX-License-Identifier: MIT
 */
#include "tests/bench/bench.h"
#include "tests/bench/encodes.h"
#include "held.h"

#include "decoder/toolkit/reference_view.h"
#include "encoder/base/stage.h"
#include "encoder/report/metrics.h"
#include "encoder/model/decode_samples.h"
#include "encoder/data/images.h"

#include <math.h>

enum { SETS = BENCH_HELD_SETS, CELLS = 1 + SETS, ROWS = 2 + 2 * BENCH_PRESETS };
static const char *const set_names[CELLS] = {"train", "held view", "held light", "both"};

typedef struct held_row {
    char name[64];
    double linear[CELLS], srgb[CELLS]; /* NAN: not applicable */
} held_row;

static btf_result compare(const bench_run *run, const enc_data *truth, enc_image_source images, int cell,
                          held_row *row) {
    enc_metrics m;
    const btf_result result =
        enc_metrics_compare(run->context, truth, enc_data_images(truth), images, false, &m);
    if (result == BTF_OK) {
        row->linear[cell] = enc_psnr_linear(&m.total);
        row->srgb[cell] = enc_psnr_srgb(&m.total);
    }
    return result;
}

/* The original images, blended or nearest. */
static btf_result original_row(const bench_run *run, const bench_held *held, const btf_ref_material *tables,
                               bool nearest, held_row *row) {
    btf_result result = BTF_OK;
    snprintf(row->name, sizeof row->name, "original, %s", nearest ? "nearest" : "interpolated");
    row->linear[0] = row->srgb[0] = NAN;
    for (int i = 0; i < SETS && result == BTF_OK; i++) {
        const bench_blend b = {held->train, held->sets[i], tables, nearest};
        result = compare(run, held->sets[i], bench_blended_images(&b), 1 + i, row);
    }
    return result;
}

static btf_result decoded_row(const bench_run *run, const bench_held *held, const bench_encoded *encoded,
                              const btf_ref_material *material, bool nearest, held_row *row) {
    enc_sample_decoder *decoder = NULL;
    btf_result result = enc_sample_decoder_create(run->context, held->train, &encoded->solution, &decoder);
    const enc_decoded_samples played = {.decoder = decoder, .effects = BTF_EFFECT_ALL};
    if (result == BTF_OK) {
        result = compare(run, held->train, enc_decoded_images(&played), 0, row);
    }
    enc_sample_decoder_destroy(&decoder);
    for (int i = 0; i < SETS && result == BTF_OK; i++) {
        const enc_reference_images decoded = {
            .shape = held->sets[i],
            .material = *material,
            .options = {.effects = BTF_EFFECT_ALL,
                        .components = UINT32_MAX,
                        .interpolation = nearest ? BTF_REF_NEAREST : BTF_REF_LINEAR,
                        .filter = BTF_REF_TEXEL}};
        result = compare(run, held->sets[i], enc_reference_image_source(&decoded), 1 + i, row);
    }
    return result;
}

/* Encodes with one preset and fills its rows; the first preset also fills those of the original images. */
static btf_result run_preset(const bench_run *run, const bench_held *held, int preset, held_row *rows,
                             int *count) {
    bench_encoded encoded;
    btf_ref_material material;
    btf_result result = bench_encode_joint(run->context, held->train, preset, run->budget, &encoded);
    if (result != BTF_OK) {
        return result;
    }
    reference_view(encoded.material, 0, &material);
    enc_stage_begin(run->context, "held-out directions", 2);
    for (int nearest = 1; nearest >= 0 && *count < 2 && result == BTF_OK; nearest--) {
        result = original_row(run, held, &material, nearest, &rows[(*count)++]);
    }
    for (int nearest = 1; nearest >= 0 && result == BTF_OK; nearest--) {
        held_row *row = &rows[(*count)++];
        snprintf(row->name, sizeof row->name, "joint, %s, %s", bench_preset_names[preset],
                 nearest ? "nearest" : "interpolated");
        result = decoded_row(run, held, &encoded, &material, nearest, row);
        enc_stage_step(run->context, 1);
    }
    enc_stage_end(run->context);
    bench_encoded_clear(&encoded);
    return result;
}

static btf_result print_rows(const bench_run *run, const held_row *rows, int count) {
    FILE *csv;
    const btf_result result = bench_open(run, "holdout", "csv", &csv);
    if (result != BTF_OK) {
        return result;
    }
    fprintf(csv, "decoder,directions,linear_db,srgb_db\n");
    for (int i = 0; i < count; i++) {
        fprintf(run->summary, "| %s |", rows[i].name);
        for (int k = 0; k < CELLS; k++) {
            if (isnan(rows[i].linear[k])) {
                fprintf(run->summary, " - |");
            } else {
                fprintf(run->summary, " %.2f / %.2f |", rows[i].linear[k], rows[i].srgb[k]);
                fprintf(csv, "\"%s\",%s,%.4f,%.4f\n", rows[i].name, set_names[k], rows[i].linear[k],
                        rows[i].srgb[k]);
            }
        }
        fputc('\n', run->summary);
    }
    fputc('\n', run->summary);
    if (fclose(csv) != 0) {
        return enc_fail(run->context, BTF_ERROR_IO, "holdout-%s.csv: cannot write", run->name);
    }
    return BTF_OK;
}

btf_result bench_section_holdout(const bench_run *run) {
    bench_held held;
    held_row rows[ROWS];
    int count = 0;
    btf_result result = bench_held_create(run->context, run->data, true, &held);
    if (result == BTF_OK && !held.owned) {
        fprintf(run->summary, "No ring has several views and lights, so there is nothing to hold out.\n"
                              "\n");
        return BTF_OK;
    }
    for (int preset = 0; preset < BENCH_PRESETS && result == BTF_OK; preset++) {
        if (run->presets[preset]) {
            result = run_preset(run, &held, preset, rows, &count);
        }
    }
    if (result == BTF_OK) {
        fprintf(
            run->summary,
            "Left out: %d of %d views and %d of %d lights, every second azimuth of the ring at %.0f "
            "degrees. PSNR, "
            "linear / sRGB-coded dB.\n\n| decoder | %s | %s | %s | %s |\n| --- | --- | --- | --- | --- |\n",
            held.n_views, run->data->n_views, held.n_lights, run->data->n_lights, held.theta, set_names[0],
            set_names[1], set_names[2], set_names[3]);
        result = print_rows(run, rows, count);
    }
    bench_held_clear(&held);
    return result;
}
