/* Statistics, the Pareto front, CSV. See results.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "results.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

bench_row bench_row_named(const char *sweep, const char *name, double x) {
    bench_row row = {.x = x,
                     .core = NAN,
                     .core_spread = NAN,
                     .wall = NAN,
                     .wall_spread = NAN,
                     .bytes = NAN,
                     .memory = NAN,
                     .linear = NAN,
                     .srgb = NAN,
                     .ssim = NAN,
                     .pareto_linear = NAN,
                     .pareto_srgb = NAN};
    bench_between_unknown(row.between);
    for (int i = 0; i < BENCH_HELD_SETS; i++) {
        row.held[i][0] = row.held[i][1] = NAN;
    }
    snprintf(row.sweep, sizeof row.sweep, "%s", sweep);
    snprintf(row.name, sizeof row.name, "%s", name);
    return row;
}

void bench_table_add(bench_table *table, const bench_row *row) {
    table->rows[table->count < BENCH_MOST_ROWS ? table->count++ : BENCH_MOST_ROWS - 1] = *row;
}

static int by_value(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double bench_median(double *values, int count, double *out_spread) {
    qsort(values, (size_t)count, sizeof *values, by_value);
    const double median = 0.5 * (values[(count - 1) / 2] + values[count / 2]);
    if (out_spread) {
        *out_spread = median > 0 ? (values[count - 1] - values[0]) / median : 0;
    }
    return median;
}

double bench_cost_core(const bench_row *row) {
    return row->core;
}

double bench_cost_bytes(const bench_row *row) {
    return row->bytes;
}

double bench_seen(const bench_row *row, bool srgb) {
    const double figures[] = {row->between[BENCH_TRUTH][srgb], row->held[BENCH_HELD_SETS - 1][srgb],
                              row->between[BENCH_ESTIMATE][srgb]};
    for (size_t i = 0; i < sizeof figures / sizeof *figures; i++) {
        if (!isnan(figures[i])) {
            return figures[i];
        }
    }
    return srgb ? row->srgb : row->linear;
}

static bool undercut(const bench_table *table, int of, bool srgb, double (*cost)(const bench_row *row)) {
    const bench_row *row = &table->rows[of];
    const double figure = bench_seen(row, srgb);
    for (int i = 0; i < table->count; i++) {
        const bench_row *other = &table->rows[i];
        const double theirs = bench_seen(other, srgb);
        const bool no_worse = theirs >= figure && cost(other) <= cost(row);
        if (no_worse && (theirs > figure || cost(other) < cost(row))) {
            return true;
        }
    }
    return false;
}

void bench_mark_pareto(bench_table *table, double (*cost)(const bench_row *row)) {
    for (int i = 0; i < table->count; i++) {
        table->rows[i].pareto_linear = !undercut(table, i, false, cost);
        table->rows[i].pareto_srgb = !undercut(table, i, true, cost);
    }
}

double bench_exponent(const double *x, const double *y, int count) {
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (int i = 0; i < count; i++) {
        const double a = log(x[i]), b = log(y[i]);
        sx += a;
        sy += b;
        sxx += a * a;
        sxy += a * b;
    }
    return (count * sxy - sx * sy) / (count * sxx - sx * sx);
}

void bench_table_write(const bench_table *table, FILE *csv) {
    fprintf(csv,
            "sweep,setting,x,core_s,core_spread,wall_s,wall_spread,gpu_bytes,peak_bytes,psnr_linear,"
            "psnr_srgb,ssim,psnr_between_linear,psnr_between_srgb,psnr_estimate_linear,psnr_estimate_srgb,"
            "psnr_held_view_linear,psnr_held_view_srgb,psnr_held_light_linear,"
            "psnr_held_light_srgb,psnr_held_both_linear,psnr_held_both_srgb,pareto_linear,pareto_srgb\n");
    for (int i = 0; i < table->count; i++) {
        const bench_row *r = &table->rows[i];
        const double figures[] = {r->x,
                                  r->core,
                                  r->core_spread,
                                  r->wall,
                                  r->wall_spread,
                                  r->bytes,
                                  r->memory,
                                  r->linear,
                                  r->srgb,
                                  r->ssim,
                                  r->between[0][0],
                                  r->between[0][1],
                                  r->between[1][0],
                                  r->between[1][1],
                                  r->held[0][0],
                                  r->held[0][1],
                                  r->held[1][0],
                                  r->held[1][1],
                                  r->held[2][0],
                                  r->held[2][1],
                                  r->pareto_linear,
                                  r->pareto_srgb};
        fprintf(csv, "%s,%s", r->sweep, r->name);
        for (size_t k = 0; k < sizeof figures / sizeof *figures; k++) {
            if (isnan(figures[k])) {
                fputc(',', csv);
            } else {
                fprintf(csv, ",%.9g", figures[k]);
            }
        }
        fputc('\n', csv);
    }
}

double bench_samples_bytes(const enc_data *data) {
    return data->samples ? 4.0 * (double)enc_data_texel_count(data) * (double)enc_data_texel_stride(data)
                         : 0;
}

double bench_samples_8bit(const enc_data *data) {
    return (double)enc_data_texel_count(data) * (double)enc_data_texel_stride(data);
}
