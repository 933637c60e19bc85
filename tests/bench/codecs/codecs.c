/* Section `codecs`: our methods and their peers at the same bytes, and the bytes with which PCA reaches our quality.
 * Section `lowbit`: the best peer alone.
 *
 * SPDX-License-Identifier: MIT
 */
#include "tests/bench/bench.h"
#include "codec_table.h"
#include "tests/bench/encodes.h"
#include "lowbit.h"
#include "pca.h"

#include "encoder/base/stage.h"
#include "encoder/model/decode_samples.h"
#include "encoder/report/report.h"

#include <math.h>
#include <string.h>

static const char *const coding_names[] = {"linear", "sRGB", "square root"};
static const size_t cluster_counts[] = {8, 16, 32};
/* Ranks of the curve in the plot, over that of the budget. */
static const double curve_parts[] = {0.1, 0.3, 2.0, 4.0};
static const double rank_tolerance = 0.01;

/* The ring of lowest PSNR. */
static codec_ring worst(int count, const double *theta, const enc_error_sum *sums) {
    codec_ring ring = {.linear = HUGE_VAL, .srgb = HUGE_VAL};
    for (int i = 0; i < count; i++) {
        const double linear = enc_psnr_linear(&sums[i]), srgb = enc_psnr_srgb(&sums[i]);
        if (linear < ring.linear) {
            ring.linear = linear;
            ring.linear_theta = theta[i];
        }
        if (srgb < ring.srgb) {
            ring.srgb = srgb;
            ring.srgb_theta = theta[i];
        }
    }
    return ring;
}

static btf_result measure(const bench_run *run, enc_image_source images, bool with_ssim, codec_row *row) {
    enc_metrics m;
    const btf_result result =
        enc_metrics_compare(run->context, run->data, enc_data_images(run->data), images, with_ssim, &m);
    if (result == BTF_OK) {
        row->linear = enc_psnr_linear(&m.total);
        row->srgb = enc_psnr_srgb(&m.total);
        row->ssim = m.ssim;
        row->view_ring = worst(m.n_view_rings, m.view_ring_theta, m.view_ring);
        row->light_ring = worst(m.n_light_rings, m.light_ring_theta, m.light_ring);
    }
    return result;
}

/* Components of the residual: of factors those of all three channels. */
static size_t components_of(const btf_material_info *info) {
    static const uint32_t of_unit[BTF_FACTOR_CLASSES] = {16, 32, 32, 64, 64};
    size_t count = 0;
    for (int c = 0; c < BTF_FACTOR_CLASSES; c++) {
        count += info->factor_classes[c][0] * of_unit[c];
    }
    return info->store == BTF_STORE_FACTORS ? count : info->components;
}

/* Adds a row for each subset of effects: subsets[i] is named names[i]; the last one is the whole material. */
static btf_result measure_encoded(const bench_run *run, const bench_encoded *encoded, int count,
                                  const char *const *names, const uint32_t *subsets, codec_table *table) {
    btf_material_info info = {.struct_size = sizeof info};
    enc_sample_decoder *decoder = NULL;
    btf_result result = btf_material_get_info(encoded->material, &info);
    if (result == BTF_OK) {
        result = enc_sample_decoder_create(run->context, run->data, &encoded->solution, &decoder);
    }
    for (int i = 0; result == BTF_OK && i < count; i++) {
        const enc_decoded_samples played = {.decoder = decoder, .effects = subsets[i]};
        codec_row row = {.kind = CODEC_OURS,
                         .rank = subsets[i] & info.effects & BTF_EFFECT_RESIDUAL ? components_of(&info) : 0,
                         .bytes = enc_report_gpu_bytes(&info, subsets[i]),
                         .wall = encoded->wall,
                         .core = encoded->core};
        snprintf(row.name, sizeof row.name, "%s", names[i]);
        result = measure(run, enc_decoded_images(&played), true, &row);
        if (result == BTF_OK) {
            result = codec_table_add(run->context, table, &row);
        }
    }
    enc_sample_decoder_destroy(&decoder);
    return result;
}

static btf_result run_joint(const bench_run *run, uint64_t budget, int preset, codec_table *table) {
    char name[64];
    const char *names[] = {name};
    const uint32_t all[] = {BTF_EFFECT_ALL};
    bench_encoded encoded;
    snprintf(name, sizeof name, "joint, %s", bench_preset_names[preset]);
    btf_result result = bench_encode_joint(run->context, run->data, preset, budget, &encoded);
    if (result == BTF_OK) {
        result = measure_encoded(run, &encoded, 1, names, all, table);
        bench_encoded_clear(&encoded);
    }
    return result;
}

static btf_result run_paper(const bench_run *run, codec_table *table) {
    const char *const names[] = {"paper: SBRDF", "paper: STVS", "paper: full"};
    const uint32_t subsets[] = {0, BTF_EFFECT_SHADOW, BTF_EFFECT_ALL};
    bench_encoded encoded;
    btf_result result = bench_encode_paper(run->context, run->data, &encoded);
    if (result == BTF_OK) {
        result = measure_encoded(run, &encoded, 3, names, subsets, table);
        bench_encoded_clear(&encoded);
    }
    return result;
}

/* A factorisation and the time that it took. */
typedef struct factors {
    pca_factors f;
    double wall, core;
} factors;

/* Makes a codec of the factorisation, and measures and frees it. */
static btf_result measure_pca(const bench_run *run, const factors *from, codec_kind kind, pca_number number,
                              pca_codec *codec, double wall, double core, codec_row *row) {
    *row = (codec_row){.kind = kind,
                       .srgb_coded = from->f.coding == PCA_SRGB,
                       .eight_bit_of =
                           number == PCA_BYTE && codec->clusters == 1 ? 1 + (int)from->f.coding : 0,
                       .rank = codec->rank,
                       .bytes = codec->bytes,
                       .wall = from->wall + wall,
                       .core = from->core + core};
    if (codec->clusters > 1) {
        snprintf(row->name, sizeof row->name, "PCA in %zu clusters, %s, %s", codec->clusters,
                 number == PCA_HALF ? "half" : "8 bit", coding_names[from->f.coding]);
    } else {
        snprintf(row->name, sizeof row->name, "PCA %s, %s", number == PCA_HALF ? "half" : "8 bit",
                 coding_names[from->f.coding]);
    }
    const btf_result result = measure(run, pca_images(codec), kind == CODEC_PEER, row);
    pca_codec_clear(codec);
    return result;
}

static btf_result run_rank(const bench_run *run, const factors *from, codec_kind kind, pca_number number,
                           size_t rank, codec_row *row) {
    pca_codec codec;
    const btf_result result = pca_encode(run->context, &from->f, number, rank, &codec);
    return result == BTF_OK ? measure_pca(run, from, kind, number, &codec, 0, 0, row) : result;
}

static btf_result run_clusters(const bench_run *run, const factors *from, uint64_t budget, size_t clusters,
                               codec_table *table) {
    const size_t rank = pca_rank_for(run->data, PCA_BYTE, clusters, budget);
    const bench_clock start = bench_now();
    pca_codec codec;
    codec_row row;
    if (rank == 0 || clusters > enc_data_texel_count(run->data)) {
        return BTF_OK;
    }
    btf_result result = pca_encode_clusters(run->context, &from->f, PCA_BYTE, clusters, rank, &codec);
    const bench_clock end = bench_now();
    if (result == BTF_OK) {
        result = measure_pca(run, from, CODEC_PEER, PCA_BYTE, &codec, end.wall - start.wall,
                             end.core - start.core, &row);
    }
    return result == BTF_OK ? codec_table_add(run->context, table, &row) : result;
}

static double own_psnr(const codec_row *row) {
    return row->srgb_coded ? row->srgb : row->linear;
}

/* Finds the two measured rows next to `target` dB: 8-bit components in the factorisation's coding, too few of them in
 * *low, enough in the other. */
static void bracket(const codec_table *table, const factors *from, double target, codec_row *low,
                    codec_row *high) {
    *low = *high = (codec_row){0};
    for (size_t i = 0; i < table->count; i++) {
        const codec_row *row = &table->rows[i];
        if (row->eight_bit_of == 1 + (int)from->f.coding) {
            const bool enough = own_psnr(row) >= target;
            if (!enough && row->rank > low->rank) {
                *low = *row;
            }
            if (enough && (high->rank == 0 || row->rank < high->rank)) {
                *high = *row;
            }
        }
    }
}

/* The smallest rank of 8-bit components that reaches `target` dB in the factorisation's own coding, within
 * 1 %, searched between ranks that were measured: PSNR is about linear in log(rank). out->rank 0: the
 * largest rank does not reach it; its figures stand there. */
static btf_result rank_for_quality(const bench_run *run, const codec_table *table, const factors *from,
                                   double target, codec_row *out) {
    codec_row low, high, row;
    btf_result result = BTF_OK;
    bracket(table, from, target, &low, &high);
    if (high.rank == 0) {
        result = run_rank(run, from, CODEC_CURVE, PCA_BYTE, from->f.rank, &high);
        if (result == BTF_OK && own_psnr(&high) < target) {
            *out = high;
            out->rank = 0;
            return BTF_OK;
        }
    }
    for (int step = 0; result == BTF_OK && high.rank - low.rank > 1; step++) {
        if ((double)(high.rank - low.rank) <= rank_tolerance * (double)high.rank) {
            break;
        }
        const double a = log((double)(low.rank > 0 ? low.rank : 1)), b = log((double)high.rank);
        const double gap = own_psnr(&high) - own_psnr(&low);
        double part = low.rank > 0 && gap > 0 ? (target - own_psnr(&low)) / gap : 0.5;
        part = step % 3 == 2 ? 0.5 : fmin(fmax(part + (step % 2 ? -0.02 : 0.02), 0.02), 0.98);
        size_t rank = (size_t)rint(exp(a + part * (b - a)));
        rank = rank <= low.rank ? low.rank + 1 : rank >= high.rank ? high.rank - 1 : rank;
        result = run_rank(run, from, CODEC_CURVE, PCA_BYTE, rank, &row);
        if (result == BTF_OK && own_psnr(&row) >= target) {
            high = row;
        } else {
            low = row;
        }
    }
    *out = high;
    return result;
}

static btf_result run_pca(const bench_run *run, pca_coding coding, uint64_t budget, codec_table *table) {
    const size_t bytes_rank = pca_rank_for(run->data, PCA_BYTE, 1, budget);
    const size_t half_rank = pca_rank_for(run->data, PCA_HALF, 1, budget);
    const bool narrow = coding == PCA_SQRT; /* not in the plot */
    const bench_clock start = bench_now();
    factors from;
    codec_row row;
    if (half_rank == 0) {
        return BTF_OK;
    }
    btf_result result =
        pca_factorise(run->context, run->data, coding,
                      narrow || (size_t)run->rank < bytes_rank ? bytes_rank : (size_t)run->rank, &from.f);
    if (result != BTF_OK) {
        return result;
    }
    const bench_clock end = bench_now();
    from.wall = end.wall - start.wall;
    from.core = end.core - start.core;
    table->factor_rank = narrow ? table->factor_rank : from.f.rank;
    for (int number = PCA_HALF; number <= PCA_BYTE && result == BTF_OK; number++) {
        result = run_rank(run, &from, CODEC_PEER, (pca_number)number,
                          number == PCA_HALF ? half_rank : bytes_rank, &row);
        if (result == BTF_OK) {
            result = codec_table_add(run->context, table, &row);
        }
    }
    for (size_t i = 0; i < sizeof cluster_counts / sizeof *cluster_counts && result == BTF_OK && !narrow;
         i++) {
        result = run_clusters(run, &from, budget, cluster_counts[i], table);
    }
    for (size_t i = 0; i < sizeof curve_parts / sizeof *curve_parts && result == BTF_OK && !narrow; i++) {
        const size_t rank = (size_t)fmax(1, rint(curve_parts[i] * (double)bytes_rank));
        if (rank <= from.f.rank) {
            result = run_rank(run, &from, CODEC_CURVE, PCA_BYTE, rank, &row);
            if (result == BTF_OK) {
                result = codec_table_add(run->context, table, &row);
            }
        }
    }
    const size_t rows = table->count;
    for (size_t i = 0; i < rows && result == BTF_OK && !narrow; i++) {
        if (strncmp(table->rows[i].name, "joint", 5) == 0) {
            codec_equal equal = {.row = i, .srgb_coded = coding == PCA_SRGB};
            result = rank_for_quality(run, table, &from,
                                      equal.srgb_coded ? table->rows[i].srgb : table->rows[i].linear,
                                      &equal.peer);
            table->equal[table->equals < CODEC_EQUALS ? table->equals++ : CODEC_EQUALS - 1] = equal;
        }
    }
    pca_factors_clear(&from.f);
    return result;
}

/* The peer that codes the axes of opponent colour apart, in 8 bits alone or in as few bits as pay. */
static btf_result run_split(const bench_run *run, uint64_t budget, bool eight_only, codec_row *row) {
    enum { SWEEPS = 6 };
    const lowbit_options options = {(size_t)budget, eight_only, SWEEPS};
    const bench_clock start = bench_now();
    lowbit_codec codec;
    btf_result result = lowbit_encode(run->context, run->data, &options, &codec);
    const bench_clock end = bench_now();
    if (result != BTF_OK) {
        return result;
    }
    *row = (codec_row){.kind = CODEC_PEER,
                       .rank = lowbit_rank(&codec, PCA_RGB),
                       .bytes = codec.bytes,
                       .wall = end.wall - start.wall,
                       .core = end.core - start.core};
    snprintf(row->name, sizeof row->name, "%s, square root", eight_only ? "split PCA 8 bit" : "low-bit split PCA");
    result = measure(run, lowbit_images(&codec), true, row);
    lowbit_codec_clear(&codec);
    return result;
}

/* Adds both of these peers to the table. */
static btf_result run_splits(const bench_run *run, uint64_t budget, codec_table *table) {
    btf_result result = BTF_OK;
    for (int eight_only = 0; eight_only < 2 && result == BTF_OK; eight_only++) {
        codec_row row;
        result = run_split(run, budget, eight_only != 0, &row);
        if (result == BTF_OK) {
            result = codec_table_add(run->context, table, &row);
        }
    }
    return result;
}

btf_result bench_section_lowbit(const bench_run *run) {
    const uint64_t budget = bench_budget(run->budget, run->data);
    FILE *csv = NULL;
    codec_row row;
    btf_result result = run_split(run, budget, false, &row);
    if (result == BTF_OK) {
        result = bench_open(run, "lowbit", "csv", &csv);
    }
    if (result == BTF_OK) {
        fprintf(run->summary,
                "| allowed, MB | MB | components | linear dB | sRGB dB | core s |\n"
                "| --- | --- | --- | --- | --- | --- |\n"
                "| %.3f | %.3f | %zu | %.2f | %.2f | %.1f |\n\n",
                (double)budget / 1e6, (double)row.bytes / 1e6, row.rank, row.linear, row.srgb, row.core);
        fprintf(csv, "budget,bytes,components,linear_db,srgb_db,core_s\n%llu,%zu,%zu,%.4f,%.4f,%.2f\n",
                (unsigned long long)budget, row.bytes, row.rank, row.linear, row.srgb, row.core);
        result = fclose(csv) == 0 ? BTF_OK
                                  : enc_fail(run->context, BTF_ERROR_IO, "lowbit-%s.csv: cannot write", run->name);
    }
    return result;
}

btf_result bench_section_codecs(const bench_run *run) {
    const uint64_t budget = bench_budget(run->budget, run->data);
    codec_table table = {.budget = budget};
    btf_result result = BTF_OK;
    for (int preset = 0; preset < BENCH_PRESETS && result == BTF_OK; preset++) {
        if (run->presets[preset]) {
            result = run_joint(run, budget, preset, &table);
        }
    }
    if (result == BTF_OK) {
        result = run_paper(run, &table);
    }
    enc_stage_begin(run->context, "peers", 4);
    if (result == BTF_OK) {
        result = run_splits(run, budget, &table);
        enc_stage_step(run->context, 1);
    }
    for (int coding = PCA_LINEAR; coding <= PCA_SQRT && result == BTF_OK; coding++) {
        result = run_pca(run, (pca_coding)coding, budget, &table);
        enc_stage_step(run->context, 1);
    }
    enc_stage_end(run->context);
    if (result == BTF_OK) {
        codec_table_print(&table, run->summary);
        result = codec_table_write(run, &table);
    }
    codec_table_clear(&table);
    return result;
}
