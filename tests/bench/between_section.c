/* Section `between`: accuracy between the samples, where renderers look, and at the samples: of our methods, of
 * principal components of the same bytes, and of the uncompressed images, interpolated.
 *
 * SPDX-License-Identifier: MIT
 */
#include "bench.h"
#include "readme.h"
#include "tests/bench/codecs/lowbit.h"
#include "tests/bench/codecs/pca.h"

#include "decoder/toolkit/reference_view.h"
#include "encoder/base/stage.h"
#include "encoder/relief/relief.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LOWBIT_SWEEPS = 6 };

typedef struct section {
    const bench_run *run;
    bench_held whole; /* nothing is left out: every row is of all data */
    char name[160];   /* in the journal */
    uint64_t budget;
    enc_relief_store relief; /* the default's choice between the samples: relief, gloss, fitted nodes */
    bench_table *table;
} section;

typedef btf_result (*measure_fn)(const section *s, int setting, bench_row *row);

/* Takes the row of the journal, else measures it and keeps it. */
static btf_result measured(section *s, const char *sweep, const char *name, measure_fn measure,
                           int setting) {
    bench_row row = bench_row_named(sweep, name, NAN);
    btf_result result = BTF_OK;
    if (!bench_journal_find(s->run->journal, s->name, &row)) {
        result = measure(s, setting, &row);
        if (result == BTF_OK) {
            result = bench_journal_add(s->run->context, s->run->journal, s->name, &row);
        }
    }
    if (result == BTF_OK) {
        bench_table_add(s->table, &row);
        enc_log(s->run->context, BTF_LOG_INFO,
                "  %-36s %8.3f MB %6.2f %6.2f dB between, %6.2f %6.2f at samples", row.name,
                1e-6 * row.bytes, bench_seen(&row, false), bench_seen(&row, true), row.linear, row.srgb);
    }
    return result;
}

/* Uncompressed images are exact at the samples, so that the row has no figure there; bytes are those of 8-bit
 * images. */
static btf_result measure_uncompressed(const section *s, int kind, bench_row *row) {
    row->bytes = bench_samples_8bit(s->run->data);
    return bench_between_images(s->run->context, s->run->between_data, s->run->data,
                                (enc_interpolation)kind, row->between);
}

static btf_result measure_encoded(const section *s, bench_encoded *encoded, bench_row *row) {
    row->bytes = (double)encoded->bytes;
    row->core = encoded->core;
    row->wall = encoded->wall;
    const btf_result result =
        bench_accuracy(s->run->context, &s->whole, s->run->between_data, encoded, BTF_EFFECT_ALL, row);
    bench_encoded_clear(encoded);
    return result;
}

static btf_result measure_joint(const section *s, int preset, bench_row *row) {
    bench_encoded encoded;
    const btf_result result =
        bench_encode_joint(s->run->context, s->run->data, preset, s->budget, &encoded);
    return result == BTF_OK ? measure_encoded(s, &encoded, row) : result;
}

static btf_result measure_still(const section *s, int preset, bench_row *row) {
    bench_encoded encoded;
    const btf_result result =
        bench_encode_joint_between(s->run->context, s->run->data, preset, s->budget, NULL, &encoded);
    return result == BTF_OK ? measure_encoded(s, &encoded, row) : result;
}

/* Our method with fitted nodes, relief and gloss; the preset fast has no relief and gloss. */
static btf_result measure_fitted(const section *s, int preset, bench_row *row) {
    bench_encoded encoded;
    const btf_result result =
        bench_encode_joint_between(s->run->context, s->run->data, preset, s->budget,
                                   preset == ENC_PRESET_FAST ? NULL : &s->relief, &encoded);
    return result == BTF_OK ? measure_encoded(s, &encoded, row) : result;
}

static btf_result choose_relief(section *s) {
    const enc_relief_options options = {.relief = true, .gloss = -1};
    bool wanted = false;
    for (int i = 0; i < BENCH_PRESETS; i++) {
        wanted = wanted || (s->run->presets[i] && i != ENC_PRESET_FAST);
    }
    enc_relief_choice choice;
    return wanted ? enc_relief_choose(s->run->context, s->run->data, &options, &choice, &s->relief)
                  : BTF_OK;
}

static btf_result measure_paper(const section *s, int setting, bench_row *row) {
    bench_encoded encoded;
    (void)setting;
    const btf_result result = bench_encode_paper(s->run->context, s->run->data, &encoded);
    return result == BTF_OK ? measure_encoded(s, &encoded, row) : result;
}

/* Decoded images of a peer, blended barycentrically between the samples. */
static btf_result measure_peer(const section *s, enc_image_source images, size_t bytes, bench_clock start,
                               bench_row *row) {
    const bench_clock end = bench_now();
    row->bytes = (double)bytes;
    row->core = end.core - start.core;
    row->wall = end.wall - start.wall;
    return bench_accuracy_images(s->run->context, &s->whole, s->run->between_data, NULL, images, row);
}

static btf_result measure_pca(const section *s, int coding, bench_row *row) {
    const size_t rank = pca_rank_for(s->run->data, PCA_BYTE, 1, s->budget);
    const bench_clock start = bench_now();
    pca_factors factors;
    pca_codec codec;
    btf_result result = pca_factorise(s->run->context, s->run->data, (pca_coding)coding, rank, &factors);
    if (result != BTF_OK) {
        return result;
    }
    result = pca_encode(s->run->context, &factors, PCA_BYTE, rank, &codec);
    if (result == BTF_OK) {
        result = measure_peer(s, pca_images(&codec), codec.bytes, start, row);
        pca_codec_clear(&codec);
    }
    pca_factors_clear(&factors);
    return result;
}

static btf_result measure_split(const section *s, int eight_only, bench_row *row) {
    const lowbit_options options = {(size_t)s->budget, eight_only != 0, LOWBIT_SWEEPS};
    const bench_clock start = bench_now();
    lowbit_codec codec;
    btf_result result = lowbit_encode(s->run->context, s->run->data, &options, &codec);
    if (result == BTF_OK) {
        result = measure_peer(s, lowbit_images(&codec), codec.bytes, start, row);
        lowbit_codec_clear(&codec);
    }
    return result;
}

static btf_result measure_all(section *s) {
    static const struct {
        const char *sweep, *name;
        measure_fn measure;
        int setting;
    } rows[] = {{"paper", "paper", measure_paper, 0},
                {"PCA", "PCA 8 bit linear", measure_pca, PCA_LINEAR},
                {"PCA", "PCA 8 bit square root", measure_pca, PCA_SQRT},
                {"split PCA", "split PCA 8 bit", measure_split, 1},
                {"split PCA", "low-bit split PCA", measure_split, 0},
                {"uncompressed", "uncompressed; barycentric", measure_uncompressed, ENC_INTERPOLATE_LINEAR},
                {"splines", "uncompressed; splines", measure_uncompressed, ENC_INTERPOLATE_SPLINE}};
    char name[72];
    btf_result result = BTF_OK;
    for (int i = 0; i < BENCH_PRESETS && result == BTF_OK; i++) {
        if (s->run->presets[i]) {
            snprintf(name, sizeof name, "joint %s", bench_preset_names[i]);
            result = measured(s, "preset", name, measure_fitted, i);
            snprintf(name, sizeof name, "joint %s; relief and gloss off", bench_preset_names[i]);
            if (result == BTF_OK && i != ENC_PRESET_FAST && s->relief.effects) {
                result = measured(s, "still", name, measure_still, i);
            }
            snprintf(name, sizeof name, "joint %s; --fit samples", bench_preset_names[i]);
            if (result == BTF_OK) {
                result = measured(s, "samples", name, measure_joint, i);
            }
        }
    }
    const bool components = pca_rank_for(s->run->data, PCA_BYTE, 1, s->budget) > 0;
    for (size_t i = 0; i < sizeof rows / sizeof *rows && result == BTF_OK; i++) {
        if (components || !strstr(rows[i].name, "PCA")) {
            result = measured(s, rows[i].sweep, rows[i].name, rows[i].measure, rows[i].setting);
        }
    }
    return result;
}

btf_result bench_section_between(const bench_run *run) {
    FILE *csv = NULL;
    section s = {.run = run,
                 .whole = {.train = run->data},
                 .budget = bench_budget(run->budget, run->data),
                 .table = calloc(1, sizeof(bench_table))};
    if (!s.table) {
        return enc_fail(run->context, BTF_ERROR_MEMORY, "bench: out of memory");
    }
    snprintf(s.name, sizeof s.name, "between/%s", run->name);
    btf_result result = choose_relief(&s);
    if (result == BTF_OK) {
        result = measure_all(&s);
    }
    if (result == BTF_OK && (result = bench_open(run, "between", "csv", &csv)) == BTF_OK) {
        bench_mark_pareto(s.table, bench_cost_bytes);
        bench_table_write(s.table, csv);
        if (fclose(csv) != 0) {
            result = enc_fail(run->context, BTF_ERROR_IO, "between-%s.csv: cannot write", run->name);
        }
    }
    if (result == BTF_OK) {
        result = bench_readme_between(run, s.table);
    }
    enc_relief_clear(&s.relief);
    free(s.table);
    return result;
}
