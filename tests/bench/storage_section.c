/* Section `storage`: accuracy over bytes of our methods and of principal components, whole and by clusters.
 *
 * SPDX-License-Identifier: MIT
 */
#include "bench.h"
#include "tests/bench/codecs/lowbit.h"
#include "tests/bench/codecs/pca.h"
#include "plots.h"

#include "decoder/toolkit/reference_view.h"
#include "encoder/model/pack.h"
#include "encoder/report/report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The fractions of the budget at which the curves have points. */
static const double parts[] = {0.125, 0.25, 0.5, 1, 2};
enum { PARTS = sizeof parts / sizeof parts[0] };

typedef struct storage {
    const bench_run *run;
    const enc_data *data;
    char name[160]; /* in the journal */
    uint64_t budget;
    bench_table *table;
    btf_ref_material tables; /* directions, for what lies between; of `first` */
    bench_encoded first;
} storage;

/* Takes the row of the journal, else measures it by `measure` and keeps it. */
typedef btf_result (*measure_fn)(storage *s, const void *what, bench_row *row);

static btf_result measured(storage *s, bench_row row, measure_fn measure, const void *what) {
    btf_result result = BTF_OK;
    if (!bench_journal_find(s->run->journal, s->name, &row)) {
        result = measure(s, what, &row);
        if (result == BTF_OK) {
            result = bench_journal_add(s->run->context, s->run->journal, s->name, &row);
        }
    }
    if (result == BTF_OK) {
        bench_table_add(s->table, &row);
        enc_log(s->run->context, BTF_LOG_INFO, "  %-40s %8.3f MB %6.2f %6.2f dB", row.name,
                1e-6 * row.bytes, row.linear, row.srgb);
    }
    return result;
}

/* One subset of effects of a material. */
typedef struct subset {
    const bench_encoded *encoded;
    uint32_t effects;
} subset;

static btf_result measure_subset(storage *s, const void *what, bench_row *row) {
    const subset *of = what;
    btf_material_info info = {.struct_size = sizeof info};
    btf_result result = btf_material_get_info(of->encoded->material, &info);
    row->bytes = (double)enc_report_gpu_bytes(&info, of->effects);
    row->core = of->encoded->core;
    row->wall = of->encoded->wall;
    if (result == BTF_OK) {
        result =
            bench_accuracy(s->run->context, s->run->held, s->run->between, of->encoded, of->effects, row);
    }
    return result;
}

static btf_result measure_joint(storage *s, const void *what, bench_row *row) {
    const uint64_t *budget = what;
    bench_encoded encoded;
    btf_result result = bench_encode_joint(s->run->context, s->data, ENC_PRESET_MEDIUM, *budget, &encoded);
    const subset whole = {&encoded, BTF_EFFECT_ALL};
    if (result == BTF_OK) {
        result = measure_subset(s, &whole, row);
        bench_encoded_clear(&encoded);
    }
    return result;
}

static btf_result run_joint(storage *s) {
    char name[72];
    btf_result result = BTF_OK;
    for (int i = 0; i < PARTS && result == BTF_OK; i++) {
        const uint64_t budget = (uint64_t)(parts[i] * (double)s->budget);
        if (budget >= bench_joint_least(s->data)) {
            snprintf(name, sizeof name, "joint medium; %g of the budget", parts[i]);
            result = measured(s, bench_row_named("joint", name, parts[i]), measure_joint, &budget);
        }
    }
    return result;
}

static btf_result run_paper(storage *s) {
    static const struct {
        const char *name;
        uint32_t effects;
    } subsets[] = {
        {"paper: SBRDF", 0}, {"paper: STVS", BTF_EFFECT_SHADOW}, {"paper: full", BTF_EFFECT_ALL}};
    btf_result result = BTF_OK;
    for (int i = 0; i < 3 && result == BTF_OK; i++) {
        const subset of = {&s->first, subsets[i].effects};
        result = measured(s, bench_row_named("paper", subsets[i].name, i), measure_subset, &of);
    }
    return result;
}

/* A peer: principal components in a number of clusters, in 8 bits or halves. */
typedef struct components {
    const pca_factors *factors;
    pca_number number;
    size_t clusters, rank;
} components;

/* Fills a peer's row: the time of encoding since `start`, its bytes, and the accuracy of its images. */
static btf_result fill_row(storage *s, bench_clock start, size_t bytes, enc_image_source images,
                           bench_row *row) {
    const bench_clock end = bench_now();
    row->core = end.core - start.core;
    row->wall = end.wall - start.wall;
    row->bytes = (double)bytes;
    return bench_accuracy_images(s->run->context, s->run->held, s->run->between, &s->tables, images, row);
}

static btf_result measure_pca(storage *s, const void *what, bench_row *row) {
    const components *of = what;
    const bench_clock start = bench_now();
    pca_codec codec;
    btf_result result =
        of->clusters > 1
            ? pca_encode_clusters(s->run->context, of->factors, of->number, of->clusters, of->rank, &codec)
            : pca_encode(s->run->context, of->factors, of->number, of->rank, &codec);
    if (result == BTF_OK) {
        result = fill_row(s, start, codec.bytes, pca_images(&codec), row);
        pca_codec_clear(&codec);
    }
    return result;
}

static btf_result run_components(storage *s, const char *sweep, components of) {
    char name[72];
    size_t last = 0;
    btf_result result = BTF_OK;
    for (int i = 0; i < PARTS && result == BTF_OK; i++) {
        of.rank = pca_rank_for(s->data, of.number, of.clusters, (uint64_t)(parts[i] * (double)s->budget));
        of.rank = of.rank < of.factors->rank ? of.rank : of.factors->rank;
        if (of.rank > last) {
            snprintf(name, sizeof name, "%s rank %zu", sweep, of.rank);
            result = measured(s, bench_row_named(sweep, name, (double)of.rank), measure_pca, &of);
            last = of.rank;
        }
    }
    return result;
}

static btf_result run_pca(storage *s) {
    static const char *const sweeps[] = {"PCA linear", "PCA sRGB"};
    const size_t most =
        pca_rank_for(s->data, PCA_BYTE, 1, (uint64_t)(parts[PARTS - 1] * (double)s->budget));
    btf_result result = BTF_OK;
    for (int coding = PCA_LINEAR; coding <= PCA_SRGB && most > 0 && result == BTF_OK; coding++) {
        pca_factors factors;
        result = pca_factorise(s->run->context, s->data, (pca_coding)coding, most, &factors);
        if (result != BTF_OK) {
            break;
        }
        result = run_components(s, sweeps[coding], (components){&factors, PCA_BYTE, 1, 0});
        if (result == BTF_OK && coding == PCA_LINEAR) {
            result = run_components(s, "PCA half", (components){&factors, PCA_HALF, 1, 0});
        }
        for (size_t clusters = 8; clusters <= 16 && coding == PCA_LINEAR && result == BTF_OK;
             clusters *= 2) {
            char sweep[24];
            snprintf(sweep, sizeof sweep, "PCA clusters %zu", clusters);
            if (clusters < enc_data_texel_count(s->data)) {
                result = run_components(s, sweep, (components){&factors, PCA_BYTE, clusters, 0});
            }
        }
        pca_factors_clear(&factors);
    }
    return result;
}

/* A peer that codes the axes of opponent colour apart, in 8 bits alone or in as few bits as pay. */
typedef struct split {
    double part; /* of the budget */
    bool eight_only;
} split;

static btf_result measure_split(storage *s, const void *what, bench_row *row) {
    enum { SWEEPS = 6 };
    const split *of = what;
    const lowbit_options options = {(size_t)(of->part * (double)s->budget), of->eight_only, SWEEPS};
    const bench_clock start = bench_now();
    lowbit_codec codec;
    btf_result result = lowbit_encode(s->run->context, s->data, &options, &codec);
    if (result == BTF_OK) {
        result = fill_row(s, start, codec.bytes, lowbit_images(&codec), row);
        lowbit_codec_clear(&codec);
    }
    return result;
}

static btf_result run_split(storage *s) {
    static const char *const sweeps[] = {"low-bit PCA", "split PCA"};
    char name[72];
    btf_result result = BTF_OK;
    for (int eight_only = 0; eight_only < 2; eight_only++) {
        for (int i = 0; i < PARTS && result == BTF_OK; i++) {
            const split of = {parts[i], eight_only};
            if (pca_rank_for(s->data, PCA_BYTE, 1, (size_t)(parts[i] * (double)s->budget)) == 0) {
                continue; /* the budget is below the fewest bytes that the method needs */
            }
            snprintf(name, sizeof name, "%s; %g of the budget", sweeps[eight_only], parts[i]);
            result = measured(s, bench_row_named(sweeps[eight_only], name, parts[i]), measure_split, &of);
        }
    }
    return result;
}

static btf_result measure_uncompressed(storage *s, const void *what, bench_row *row) {
    const enc_interpolation *kind = what;
    row->bytes = bench_samples_8bit(s->data);
    return bench_between_images(s->run->context, s->run->between, s->data, *kind, row->between);
}

/* Uncompressed images are exact at the samples, so that the row has no figure there; bytes are those of 8-bit
 * images. */
static btf_result run_uncompressed(storage *s) {
    static const enc_interpolation kinds[] = {ENC_INTERPOLATE_LINEAR, ENC_INTERPOLATE_SPLINE};
    static const char *const sweeps[] = {"uncompressed", "splines"};
    static const char *const names[] = {"uncompressed; barycentric", "uncompressed; splines"};
    btf_result result = BTF_OK;
    for (int i = 0; i < 2 && result == BTF_OK; i++) {
        result = measured(s, bench_row_named(sweeps[i], names[i], NAN), measure_uncompressed, &kinds[i]);
    }
    return result;
}

static void print_pair(double linear, double srgb, FILE *out) {
    if (isnan(linear)) {
        fprintf(out, " - |");
    } else {
        fprintf(out, " %.2f / %.2f |", linear, srgb);
    }
}

static void print(const storage *s, FILE *out) {
    const bench_row *base = NULL;
    for (int i = 0; i < s->table->count; i++) {
        if (strcmp(s->table->rows[i].sweep, "joint") == 0 && s->table->rows[i].x == 1) {
            base = &s->table->rows[i];
        }
    }
    fprintf(out,
            "The budget is %.3f MB (10^6 bytes on the GPU). `*`: on the Pareto front of bytes and PSNR %s; "
            "PSNR is linear / sRGB-coded, dB. Peers are blended barycentrically.\n\n"
            "| codec | times the budget | %s | against joint at the budget | front | MB | at the samples "
            "| SSIM | estimate | held view and light |\n"
            "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
            1e-6 * (double)s->budget, bench_seen_words(s->run), bench_seen_words(s->run));
    for (int i = 0; i < s->table->count && base; i++) {
        const bench_row *r = &s->table->rows[i];
        fprintf(out, "| %s | %.3f |", r->name, r->bytes / (double)s->budget);
        print_pair(bench_seen(r, false), bench_seen(r, true), out);
        fprintf(out, " %+.2f / %+.2f | %s %s | %.3f |", bench_seen(r, false) - bench_seen(base, false),
                bench_seen(r, true) - bench_seen(base, true), r->pareto_linear > 0 ? "*" : "",
                r->pareto_srgb > 0 ? "*" : "", 1e-6 * r->bytes);
        print_pair(r->linear, r->srgb, out);
        fprintf(out, isnan(r->ssim) ? " - |" : " %.4f |", r->ssim);
        print_pair(r->between[BENCH_ESTIMATE][0], r->between[BENCH_ESTIMATE][1], out);
        print_pair(r->held[2][0], r->held[2][1], out);
        fputc('\n', out);
    }
    fputc('\n', out);
}

btf_result bench_section_storage(const bench_run *run) {
    FILE *csv = NULL;
    storage s = {.run = run,
                 .data = run->held->train,
                 .budget = bench_budget(run->budget, run->held->train),
                 .table = calloc(1, sizeof(bench_table))};
    if (!s.table) {
        return enc_fail(run->context, BTF_ERROR_MEMORY, "bench: out of memory");
    }
    snprintf(s.name, sizeof s.name, "storage/%s", run->name);
    btf_result result = bench_encode_paper(run->context, s.data, &s.first);
    if (result == BTF_OK) {
        reference_view(s.first.material, 0, &s.tables);
        result = run_joint(&s);
    }
    if (result == BTF_OK) {
        result = run_paper(&s);
    }
    if (result == BTF_OK) {
        result = run_pca(&s);
    }
    if (result == BTF_OK) {
        result = run_split(&s);
    }
    if (result == BTF_OK) {
        result = run_uncompressed(&s);
    }
    if (result == BTF_OK && (result = bench_open(run, "storage", "csv", &csv)) == BTF_OK) {
        bench_mark_pareto(s.table, bench_cost_bytes);
        bench_table_write(s.table, csv);
        fclose(csv);
        print(&s, run->summary);
        result = bench_plot_storage(run, s.table);
    }
    bench_encoded_clear(&s.first);
    free(s.table);
    return result;
}
