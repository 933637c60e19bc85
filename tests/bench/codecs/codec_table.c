/* The rows of section `codecs`. See codec_table.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "codec_table.h"

#include <math.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

extern char **environ;

btf_result codec_table_add(const enc_context *context, codec_table *table, const codec_row *row) {
    codec_row *rows = realloc(table->rows, (table->count + 1) * sizeof *rows);
    if (!rows) {
        return enc_fail(context, BTF_ERROR_MEMORY, "bench: out of memory for %zu rows", table->count + 1);
    }
    table->rows = rows;
    rows[table->count++] = *row;
    enc_log(context, BTF_LOG_INFO, "  %-36s rank %4zu %8.3f MB %6.2f %6.2f dB %.4f", row->name, row->rank,
            (double)row->bytes / 1e6, row->linear, row->srgb, row->ssim);
    return BTF_OK;
}

void codec_table_clear(codec_table *table) {
    free(table->rows);
    *table = (codec_table){0};
}

/* Prints by how much our whole materials lead over the best figure of any peer. */
static void print_lead(const codec_table *table, FILE *out) {
    codec_row best = {0};
    for (size_t i = 0; i < table->count; i++) {
        const codec_row *r = &table->rows[i];
        if (r->kind == CODEC_PEER) {
            best.linear = fmax(best.linear, r->linear);
            best.srgb = fmax(best.srgb, r->srgb);
            best.ssim = fmax(best.ssim, r->ssim);
        }
    }
    for (size_t i = 0; i < table->count && best.linear > 0; i++) {
        const codec_row *r = &table->rows[i];
        if (r->kind == CODEC_OURS && strncmp(r->name, "paper", 5) != 0) {
            fprintf(
                out,
                "%s against the best peer in each figure: %+.2f dB linear, %+.2f dB sRGB, %+.4f SSIM.\n\n",
                r->name, r->linear - best.linear, r->srgb - best.srgb, r->ssim - best.ssim);
        }
    }
}

static void print_equal(const codec_table *table, FILE *out) {
    fprintf(out, "Equal quality: the 8-bit PCA that reaches the same PSNR (rank within 1 %%).\n\n"
                 "| ours | equal in | dB | our MB | PCA rank | PCA MB | times ours |\n"
                 "| --- | --- | --- | --- | --- | --- | --- |\n");
    for (int i = 0; i < table->equals; i++) {
        const codec_equal *e = &table->equal[i];
        const codec_row *ours = &table->rows[e->row];
        const char *unreached = e->peer.rank > 0 ? "" : "> ";
        fprintf(out, "| %s | %s | %.2f | %.3f | %s%zu | %s%.3f | %s%.2f |\n", ours->name,
                e->srgb_coded ? "sRGB" : "linear", e->srgb_coded ? ours->srgb : ours->linear,
                (double)ours->bytes / 1e6, unreached, e->peer.rank > 0 ? e->peer.rank : table->factor_rank,
                unreached, (double)e->peer.bytes / 1e6, unreached,
                (double)e->peer.bytes / (double)ours->bytes);
    }
    fputc('\n', out);
}

void codec_table_print(const codec_table *table, FILE *out) {
    fprintf(out,
            "Equal bytes: at most %.3f MB (10^6 bytes) on the GPU; PSNR of all samples, clipped to [0, 1]; "
            "rings with "
            "their theta, linear. Seconds of PCA are those of the factorisation that serves all ranks.\n\n"
            "| codec | rank | MB | linear dB | sRGB dB | SSIM | worst view ring | worst light ring | wall "
            "s | core s |\n"
            "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
            (double)table->budget / 1e6);
    for (size_t i = 0; i < table->count; i++) {
        const codec_row *r = &table->rows[i];
        if (r->kind != CODEC_CURVE) {
            fprintf(
                out,
                "| %s | %zu | %.3f | %.2f | %.2f | %.4f | %.2f at %.0f | %.2f at %.0f | %.1f | %.1f |\n",
                r->name, r->rank, (double)r->bytes / 1e6, r->linear, r->srgb, r->ssim, r->view_ring.linear,
                r->view_ring.linear_theta, r->light_ring.linear, r->light_ring.linear_theta, r->wall,
                r->core);
        }
    }
    fputc('\n', out);
    print_lead(table, out);
    print_equal(table, out);
}

static void write_rows(const codec_table *table, FILE *csv) {
    fprintf(csv, "codec,kind,rank,bytes,linear_db,srgb_db,ssim,view_ring_linear_db,view_ring_linear_theta,"
                 "view_ring_srgb_db,view_ring_srgb_theta,light_ring_linear_db,light_ring_linear_theta,"
                 "light_ring_srgb_db,light_ring_srgb_theta,wall_s,core_s\n");
    for (size_t i = 0; i < table->count; i++) {
        const codec_row *r = &table->rows[i];
        static const char *const kinds[] = {"ours", "peer", "curve"};
        fprintf(csv, "\"%s\",%s,%zu,%zu,%.4f,%.4f,", r->name, kinds[r->kind], r->rank, r->bytes, r->linear,
                r->srgb);
        if (r->kind != CODEC_CURVE) {
            fprintf(csv, "%.5f", r->ssim);
        }
        const codec_ring *rings[] = {&r->view_ring, &r->light_ring};
        for (int k = 0; k < 2; k++) {
            fprintf(csv, ",%.4f,%g,%.4f,%g", rings[k]->linear, rings[k]->linear_theta, rings[k]->srgb,
                    rings[k]->srgb_theta);
        }
        fprintf(csv, ",%.2f,%.2f\n", r->wall, r->core);
    }
}

static int by_bytes(const void *a, const void *b) {
    const codec_row *const *x = a, *const *y = b;
    return ((*x)->bytes > (*y)->bytes) - ((*x)->bytes < (*y)->bytes);
}

/* Writes the rows whose name begins with `name`, by rising bytes, as a data block of gnuplot. Returns their number. */
static size_t write_block(const codec_table *table, const char *block, const char *name, FILE *script) {
    const codec_row **rows = malloc((table->count + 1) * sizeof *rows);
    size_t count = 0;
    for (size_t i = 0; rows && i < table->count; i++) {
        if (strncmp(table->rows[i].name, name, strlen(name)) == 0) {
            rows[count++] = &table->rows[i];
        }
    }
    if (count > 1) {
        qsort(rows, count, sizeof *rows, by_bytes);
    }
    fprintf(script, "$%s << EOD\n", block);
    for (size_t i = 0; i < count; i++) {
        fprintf(script, "%.6f %.4f %.4f\n", (double)rows[i]->bytes / 1e6, rows[i]->linear, rows[i]->srgb);
    }
    fprintf(script, "EOD\n");
    free(rows);
    return count;
}

static void write_script(const bench_run *run, const codec_table *table, const char *picture,
                         FILE *script) {
    static const struct {
        const char *block, *name, *title, *style;
    } series[] = {{"joint", "joint", "joint", "points pt 7 ps 1.2"},
                  {"paper", "paper", "paper: SBRDF, STVS, full", "linespoints pt 5"},
                  {"linear", "PCA 8 bit, linear", "PCA 8 bit, linear", "linespoints pt 4"},
                  {"srgb", "PCA 8 bit, sRGB", "PCA 8 bit, sRGB-coded", "linespoints pt 6"},
                  {"halves", "PCA half", "PCA half", "points pt 1"},
                  {"clusters", "PCA in", "PCA in clusters", "points pt 2"},
                  {"split", "split PCA", "split PCA 8 bit", "points pt 8"},
                  {"lowbit", "low-bit split PCA", "low-bit split PCA", "points pt 9"}};
    enum { SERIES = sizeof series / sizeof series[0] };
    size_t points[SERIES];
    for (int i = 0; i < SERIES; i++) {
        points[i] = write_block(table, series[i].block, series[i].name, script);
    }
    fprintf(script,
            "set terminal svg size 1000,480 background 'white'\nset output '%s'\nset logscale x\n"
            "set multiplot layout 1,2 title '%s' noenhanced\nset grid\nset key top left\nset xlabel "
            "'MB on the GPU'\n",
            picture, run->name);
    for (int panel = 0; panel < 2; panel++) {
        fprintf(script, "set ylabel 'PSNR, %s, dB'\nplot", panel == 0 ? "linear" : "sRGB-coded");
        const char *comma = " ";
        for (int i = 0; i < SERIES; i++) {
            if (points[i] > 0) {
                fprintf(script, "%s$%s using 1:%d with %s title '%s'", comma, series[i].block, 2 + panel,
                        series[i].style, series[i].title);
                comma = ", ";
            }
        }
        fputc('\n', script);
    }
    fprintf(script, "unset multiplot\n");
}

static btf_result plot(const bench_run *run, const codec_table *table) {
    char script_path[4096], picture[4096];
    FILE *script;
    btf_result result = bench_open(run, "codecs", "gp", &script);
    if (result != BTF_OK) {
        return result;
    }
    bench_path(run, "codecs", "gp", script_path, sizeof script_path);
    bench_path(run, "codecs", "svg", picture, sizeof picture);
    write_script(run, table, picture, script);
    if (fclose(script) != 0) {
        return enc_fail(run->context, BTF_ERROR_IO, "%s: cannot write", script_path);
    }
    char program[] = "gnuplot", *arguments[] = {program, script_path, NULL};
    pid_t child;
    int status = -1;
    if (posix_spawnp(&child, program, NULL, NULL, arguments, environ) != 0 ||
        waitpid(child, &status, 0) != child || status != 0) {
        enc_log(run->context, BTF_LOG_INFO, "%s: no plot: gnuplot is missing or failed", script_path);
    } else {
        fprintf(run->summary, "Plot: `%s`.\n\n", strrchr(picture, '/') + 1);
    }
    return BTF_OK;
}

btf_result codec_table_write(const bench_run *run, const codec_table *table) {
    FILE *csv;
    const btf_result result = bench_open(run, "codecs", "csv", &csv);
    if (result != BTF_OK) {
        return result;
    }
    write_rows(table, csv);
    if (fclose(csv) != 0) {
        return enc_fail(run->context, BTF_ERROR_IO, "codecs-%s.csv: cannot write", run->name);
    }
    return plot(run, table);
}
