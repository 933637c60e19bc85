/* Section `holdout`: what lies between the samples. Every second azimuth of the ring at 45 degrees is left
 * out of the encoding, as views and as lights; the material is decoded there by the reference decoder and
 * compared with the truth, beside the original images interpolated with the same neighbours and weights.
 *
 * SPDX-License-Identifier: MIT
 */
#include "bench.h"
#include "encodes.h"

#include "decoder/tools/reference_view.h"
#include "encoder/metrics.h"
#include "encoder/playback.h"
#include "encoder/reference_images.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *const preset_names[BENCH_PRESETS] = {"fast", "medium", "thorough", "exhaustive"};
static const double held_theta = 45;

/* Indices into a list of directions. */
typedef struct choice {
    int index[256];
    int count;
} choice;

/* The ring of several directions nearest to 45 degrees loses every second one to `held`. */
static void split(const enc_direction *directions, int count, choice *train, choice *held) {
    double theta[256];
    int ring_of[256], members[256] = {0}, ring = -1, position = 0;
    const int rings = enc_rings(directions, count, theta, ring_of);
    for (int i = 0; i < count; i++) {
        members[ring_of[i]]++;
    }
    for (int r = 0; r < rings; r++) {
        if (members[r] > 1 && (ring < 0 || fabs(theta[r] - held_theta) < fabs(theta[ring] - held_theta))) {
            ring = r;
        }
    }
    train->count = held->count = 0;
    for (int i = 0; i < count; i++) {
        const bool out = ring_of[i] == ring && position++ % 2 == 1;
        choice *to = out ? held : train;
        to->index[to->count++] = i;
    }
}

/* The data of some views under some lights. */
static btf_result subset(const enc_context *context, const enc_data *data, const choice *views,
                         const choice *lights, enc_data **out_data) {
    enc_direction view_list[256], light_list[256];
    for (int i = 0; i < views->count; i++) {
        view_list[i] = data->views[views->index[i]];
    }
    for (int i = 0; i < lights->count; i++) {
        light_list[i] = data->lights[lights->index[i]];
    }
    btf_result result = enc_data_create(context, data->width, data->height, views->count, view_list,
                                        lights->count, light_list, out_data);
    if (result != BTF_OK) {
        return result;
    }
    const size_t all_lights = (size_t)data->n_lights, n = (size_t)lights->count;
    float *buffer = malloc(enc_data_texel_stride(data) * sizeof *buffer);
    float *part = malloc(enc_data_texel_stride(*out_data) * sizeof *part);
    result = buffer && part ? BTF_OK : enc_fail(context, BTF_ERROR_MEMORY, "bench: out of memory");
    for (size_t t = 0; t < enc_data_texel_count(data) && result == BTF_OK; t++) {
        const float *samples;
        result = enc_data_texels(context, data, t, 1, buffer, &samples);
        for (size_t i = 0; i < (size_t)views->count * 3 && result == BTF_OK; i++) {
            const size_t view = (size_t)views->index[i / 3];
            for (size_t l = 0; l < n; l++) {
                part[i * n + l] = samples[(view * 3 + i % 3) * all_lights + (size_t)lights->index[l]];
            }
        }
        if (result == BTF_OK) {
            result = enc_data_store_texels(context, *out_data, t, 1, part);
        }
    }
    free(buffer);
    free(part);
    if (result != BTF_OK) {
        enc_data_destroy(out_data);
    }
    return result;
}

/* Sampled images, blended at other directions with the neighbours and weights of a material's tables. */
typedef struct blended {
    const enc_data *samples;
    const enc_data *shape; /* directions to blend at */
    const btf_ref_material *tables;
    bool nearest;
} blended;

static btf_ref_neighbours look_up(const uint16_t *table, uint32_t grid, const enc_direction *direction,
                                  bool nearest) {
    int32_t q[2];
    btf_ref_project(direction->xyz, q);
    const btf_ref_neighbours found = btf_ref_lookup(table, grid, q);
    return nearest ? btf_ref_nearest(found) : found;
}

static btf_result blended_view(const void *user, int view, float *out) {
    const blended *b = user;
    const size_t image = enc_data_texel_count(b->shape) * 3, lights = (size_t)b->shape->n_lights;
    const btf_ref_neighbours views =
        look_up(b->tables->view_table, b->tables->view_grid, &b->shape->views[view], b->nearest);
    float *images = malloc((size_t)b->samples->n_lights * image * sizeof *images);
    btf_result result = images ? BTF_OK : BTF_ERROR_MEMORY;
    memset(out, 0, lights * image * sizeof *out);
    for (int i = 0; i < 3 && result == BTF_OK; i++) {
        if (views.weight[i] == 0) {
            continue;
        }
        result = enc_data_view(NULL, b->samples, (int)views.index[i], images);
        for (size_t l = 0; l < lights && result == BTF_OK; l++) {
            const btf_ref_neighbours near =
                look_up(b->tables->light_table, b->tables->light_grid, &b->shape->lights[l], b->nearest);
            for (int k = 0; k < 3; k++) {
                const float weight = (float)(views.weight[i] * near.weight[k]) * 0x1p-24f;
                const float *from = images + near.index[k] * image;
                for (size_t p = 0; p < image && weight > 0; p++) {
                    out[l * image + p] += weight * from[p];
                }
            }
        }
    }
    free(images);
    return result;
}

enum { SETS = 3, CELLS = 1 + SETS, ROWS = 2 + 2 * BENCH_PRESETS };
static const char *const set_names[CELLS] = {"train", "held view", "held light", "both"};

typedef struct held_row {
    char name[64];
    double linear[CELLS], srgb[CELLS]; /* NAN: not applicable */
} held_row;

/* The training data and the three kinds of held-out samples. */
typedef struct held_data {
    enc_data *train, *sets[SETS];
} held_data;

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
static btf_result original_row(const bench_run *run, const held_data *held, const btf_ref_material *tables,
                               bool nearest, held_row *row) {
    btf_result result = BTF_OK;
    snprintf(row->name, sizeof row->name, "original, %s", nearest ? "nearest" : "interpolated");
    row->linear[0] = row->srgb[0] = NAN;
    for (int i = 0; i < SETS && result == BTF_OK; i++) {
        const blended b = {held->train, held->sets[i], tables, nearest};
        result = compare(run, held->sets[i], (enc_image_source){blended_view, &b}, 1 + i, row);
    }
    return result;
}

static btf_result decoded_row(const bench_run *run, const held_data *held, const bench_encoded *encoded,
                              const btf_ref_material *material, bool nearest, held_row *row) {
    enc_playback *playback = NULL;
    btf_result result = enc_playback_create(run->context, held->train, &encoded->solution, &playback);
    const enc_played played = {.playback = playback, .effects = BTF_EFFECT_ALL};
    if (result == BTF_OK) {
        result = compare(run, held->train, enc_played_images(&played), 0, row);
    }
    enc_playback_destroy(&playback);
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

/* Encodes with one preset and fills its rows; the first one also those of the original images. */
static btf_result run_preset(const bench_run *run, const held_data *held, int preset, held_row *rows,
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
        snprintf(row->name, sizeof row->name, "joint, %s, %s", preset_names[preset],
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
    choice views, held_views, lights, held_lights;
    held_data held = {0};
    held_row rows[ROWS];
    int count = 0;
    split(run->data->views, run->data->n_views, &views, &held_views);
    split(run->data->lights, run->data->n_lights, &lights, &held_lights);
    if (held_views.count == 0 || held_lights.count == 0) {
        fprintf(run->summary, "No ring of several views and lights: nothing to hold out.\n\n");
        return BTF_OK;
    }
    btf_result result = subset(run->context, run->data, &views, &lights, &held.train);
    if (result == BTF_OK) {
        result = subset(run->context, run->data, &held_views, &lights, &held.sets[0]);
    }
    if (result == BTF_OK) {
        result = subset(run->context, run->data, &views, &held_lights, &held.sets[1]);
    }
    if (result == BTF_OK) {
        result = subset(run->context, run->data, &held_views, &held_lights, &held.sets[2]);
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
            held_views.count, run->data->n_views, held_lights.count, run->data->n_lights,
            run->data->views[held_views.index[0]].theta, set_names[0], set_names[1], set_names[2],
            set_names[3]);
        result = print_rows(run, rows, count);
    }
    enc_data_destroy(&held.train);
    for (int i = 0; i < SETS; i++) {
        enc_data_destroy(&held.sets[i]);
    }
    return result;
}
