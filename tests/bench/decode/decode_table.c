/* Rows of section `decode`. See decode_table.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decode_table.h"

#include "decode_materials.h"

#include "tests/bench/plots.h"

#include <math.h>
#include <string.h>

static const char *const filter_words[] = {
    [BTF_FILTER_TEXEL] = "texel", [BTF_FILTER_BILINEAR] = "bilinear", [BTF_FILTER_STEEP] = "steep"};

decode_row decode_row_named(const char *device, const char *material, const char *effects) {
    decode_row row = {.linear = {NAN, NAN, NAN}, .srgb = {NAN, NAN, NAN}};
    snprintf(row.device, sizeof row.device, "%s", device);
    snprintf(row.material, sizeof row.material, "%s", material);
    snprintf(row.effects, sizeof row.effects, "%s", effects);
    return row;
}

int decode_seen(const decode_row *row) {
    return !isnan(row->linear[1]) && row->estimated ? 1
           : !isnan(row->linear[2])                 ? 2
                                                    : !isnan(row->linear[1]);
}

void decode_table_add(decode_table *table, const decode_row *row) {
    table->rows[table->count < DECODE_MOST_ROWS ? table->count++ : DECODE_MOST_ROWS - 1] = *row;
}

void decode_table_add_size(decode_table *table, const decode_row *row) {
    table->sizes[table->size_count < DECODE_MOST_SIZES ? table->size_count++ : DECODE_MOST_SIZES - 1] =
        *row;
}

void decode_table_device(decode_table *table, const char *name, const char *renderer, bool software) {
    const int i = table->devices < DECODE_MOST_DEVICES ? table->devices++ : DECODE_MOST_DEVICES - 1;
    snprintf(table->device[i].name, sizeof table->device[i].name, "%s", name);
    snprintf(table->device[i].renderer, sizeof table->device[i].renderer, "%s", renderer);
    table->device[i].software = software;
}

const decode_row *decode_table_find(const decode_table *table, const char *device, const char *material,
                                    const char *effects, bool nearest, btf_filter filter, bool fast) {
    for (int i = 0; i < table->count; i++) {
        const decode_row *r = &table->rows[i];
        if (strcmp(r->device, device) == 0 && strcmp(r->material, material) == 0 &&
            strcmp(r->effects, effects) == 0 && r->nearest == nearest && r->filter == filter &&
            r->fast == fast) {
            return r;
        }
    }
    return NULL;
}

static void write_figure(FILE *csv, double x) {
    if (isnan(x)) {
        fputc(',', csv);
    } else {
        fprintf(csv, ",%.4f", x);
    }
}

static void write_csv(const decode_table *table, FILE *csv) {
    fprintf(
        csv,
        "device,material,effects,directions,filter,math,side,ns,spread,psnr_linear,psnr_srgb,"
        "psnr_held_linear,psnr_held_srgb,psnr_between_linear,psnr_between_srgb,between,gpu_bytes,fetches,"
        "fetched_bytes,integer_operations,float_operations\n");
    for (int i = 0; i < table->count + table->size_count; i++) {
        const decode_row *r = i < table->count ? &table->rows[i] : &table->sizes[i - table->count];
        fprintf(csv, "%s,%s,%s,%s,%s,%s,%d,%.2f,%.4f", r->device, r->material, r->effects,
                r->nearest ? "nearest" : "linear", filter_words[r->filter],
                r->fast ? "fast" : "exact", r->side, r->ns, r->spread);
        for (int set = 0; set < 3; set++) {
            write_figure(csv, r->linear[set]);
            write_figure(csv, r->srgb[set]);
        }
        fprintf(csv, ",%s,%.0f,%.0f,%.0f,%.0f,%.0f\n",
                isnan(r->linear[2]) ? ""
                : r->estimated      ? "estimate"
                                    : "truth",
                r->gpu_bytes, r->cost.fetches, r->cost.bytes, r->cost.integers, r->cost.floats);
    }
}

static void print_pair(double linear, double srgb, FILE *out) {
    if (isnan(linear)) {
        fprintf(out, " - |");
    } else {
        fprintf(out, " %.2f / %.2f |", linear, srgb);
    }
}

/* Prints the time divided by that of row `of`; nothing where that is NULL. */
static void print_times(const decode_row *r, const decode_row *of, FILE *out) {
    if (of) {
        fprintf(out, " %.2f |", r->ns / of->ns);
    } else {
        fprintf(out, " |");
    }
}

static void print_cost(const decode_cost *cost, FILE *out) {
    fprintf(out, " %.0f | %.0f | %.0f | %.0f |", cost->fetches, cost->bytes, cost->integers, cost->floats);
}

/* The row of the same fetches alone; NULL: not measured. */
static const decode_row *floor_of(const decode_table *table, const decode_row *r) {
    return strcmp(r->effects, "whole") != 0 ? NULL
                                            : decode_table_find(table, r->device, r->material, DECODE_FLOOR,
                                                                r->nearest, r->filter, false);
}

static void print_device(const decode_table *table, const char *device, const char *renderer, bool software,
                         FILE *out) {
    const decode_row *base = decode_table_find(table, device, DECODE_JOINT, "whole", false, BTF_FILTER_TEXEL, false);
    fprintf(out,
            "### %s\n\n%s; %s a pixel.\n\n"
            "| material | effects | directions | filter | mathematics | times joint | times its fetches "
            "| ns | spread | between the samples%s | at the samples | held out | fetches | bytes | integer "
            "operations | float operations |\n"
            "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | "
            "--- |\n",
            device, renderer, software ? "core time" : "time",
            base && base->estimated ? ", estimated" : "");
    for (int i = 0; i < table->count; i++) {
        const decode_row *r = &table->rows[i];
        if (strcmp(r->device, device) != 0) {
            continue;
        }
        const decode_row *floor = floor_of(table, r);
        fprintf(out, "| %s | %s | %s | %s | %s |", r->material, r->effects,
                r->nearest ? "nearest" : "linear", filter_words[r->filter],
                r->fast ? "fast" : "exact");
        print_times(r, base, out);
        print_times(r, floor, out);
        fprintf(out, " %.0f | %.0f%% |", r->ns, 100 * r->spread);
        print_pair(r->linear[2], r->srgb[2], out);
        print_pair(r->linear[0], r->srgb[0], out);
        print_pair(r->linear[1], r->srgb[1], out);
        print_cost(&r->cost, out);
        fputc('\n', out);
    }
    fputc('\n', out);
}

/* Times of smaller pictures, and the exponent of a picture's time over its pixels. */
static void print_sizes(const decode_table *table, FILE *out) {
    static const char *const materials[] = {DECODE_JOINT, DECODE_PAPER};
    enum { MATERIALS = sizeof materials / sizeof *materials };
    fprintf(out,
            "### Growth with resolution\n\n| material | exponent of time over pixels | ns a pixel at 32, "
            "64, 128, 256 pixels a side |\n| --- | --- | --- |\n");
    for (int m = 0; m < MATERIALS; m++) {
        double pixels[DECODE_MOST_SIZES], time[DECODE_MOST_SIZES];
        int count = 0;
        for (int i = 0; i < table->size_count; i++) {
            const decode_row *r = &table->sizes[i];
            if (strcmp(r->material, materials[m]) == 0) {
                pixels[count] = (double)r->side * r->side;
                time[count] = r->ns * pixels[count];
                count++;
            }
        }
        if (count > 1) {
            fprintf(out, "| %s | %.2f |", materials[m], bench_exponent(pixels, time, count));
            for (int i = 0; i < count; i++) {
                fprintf(out, "%s%.0f", i ? ", " : " ", time[i] / pixels[i]);
            }
            fprintf(out, " |\n");
        }
    }
    fputc('\n', out);
}

/* Prints how the time of a pixel splits up on the first device, found by leaving parts out of the shader. */
static void print_places(const decode_table *table, FILE *out) {
    static const char *const materials[] = {DECODE_JOINT, DECODE_HALF_JOINT, DECODE_PAPER};
    enum { MATERIALS = sizeof materials / sizeof *materials };
    const char *device = table->device[0].name;
    fprintf(out,
            "### Where the time goes, %s\n\nOf a whole pixel, three directions, texels, exact: the same "
            "fetches "
            "alone; what exactness adds to native mathematics; the rest is arithmetic.\n\n"
            "| material | ns | fetches | exactness | the rest |\n| --- | --- | --- | --- | --- |\n",
            device);
    for (int m = 0; m < MATERIALS; m++) {
        const decode_row *whole =
                             decode_table_find(table, device, materials[m], "whole", false, BTF_FILTER_TEXEL, false),
                         *fast =
                             decode_table_find(table, device, materials[m], "whole", false, BTF_FILTER_TEXEL, true),
                         *floor = decode_table_find(table, device, materials[m], DECODE_FLOOR, false,
                                                    BTF_FILTER_TEXEL, false);
        if (whole && fast && floor) {
            fprintf(out, "| %s | %.0f | %.0f %% | %+.0f %% | %.0f %% |\n", materials[m], whole->ns,
                    100 * floor->ns / whole->ns, 100 * (whole->ns - fast->ns) / whole->ns,
                    100 * (fast->ns - floor->ns) / whole->ns);
        }
    }
    fputc('\n', out);
}

/* --- format 2 beside format 1 --- */

static void print_version(const decode_table *table, const decode_row *r, FILE *out) {
    const decode_row *paper = decode_table_find(table, r->device, DECODE_PAPER, r->effects, r->nearest,
                                                r->filter, false),
                     *fast = decode_table_find(table, r->device, r->material, r->effects, r->nearest,
                                               r->filter, true);
    fprintf(out, "| %s | %s, %s, %s | %.3f |", r->material, r->effects, r->nearest ? "nearest" : "linear",
            filter_words[r->filter], 1e-6 * r->gpu_bytes);
    print_pair(r->linear[0], r->srgb[0], out);
    fprintf(out, " %.0f |", r->ns);
    print_times(r, paper, out);
    print_times(r, floor_of(table, r), out);
    print_times(r, fast, out);
    print_cost(&r->cost, out);
    fputc('\n', out);
}

static void print_versions(const decode_table *table, FILE *out) {
    static const char *const materials[] = {DECODE_JOINT, DECODE_HALF_JOINT, DECODE_PAPER};
    const char *device = table->device[0].name;
    fprintf(out,
            "### Format 2 (joint) beside format 1 (paper), %s\n\nExact mathematics, %s a pixel. Times "
            "paper: of the same directions and filter. Exact over native: at most 1.25 is the aim. Counts "
            "are by formula (decode_cost.h): textures but the direction tables; sums of SBRDF, shadow and "
            "residual.\n\n"
            "| material | decoded | MB | at the samples | ns | times paper | times its fetches | exact over "
            "native | fetches | bytes | integer operations | float operations |\n"
            "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
            device, table->device[0].software ? "core ns" : "ns");
    for (size_t m = 0; m < sizeof materials / sizeof *materials; m++) {
        for (int i = 0; i < table->count; i++) {
            const decode_row *r = &table->rows[i];
            if (strcmp(r->device, device) == 0 && strcmp(r->material, materials[m]) == 0 &&
                strcmp(r->effects, DECODE_FLOOR) != 0 && !r->fast) {
                print_version(table, r, out);
            }
        }
    }
    fputc('\n', out);
}

typedef struct shown {
    const char *material, *title;
    int fast; /* 0, 1; -1: either */
} shown;

/* The series of the plots; those of fast math are not in the README's. */
static const shown series[] = {{DECODE_JOINT, "joint, exact", 0},
                               {DECODE_JOINT, "joint, fast math", 1},
                               {DECODE_HALF_JOINT, "joint, half the bytes, exact", 0},
                               {DECODE_RELIEF, "joint, relief and gloss, exact", 0},
                               {DECODE_PAPER, "paper, exact", 0},
                               {DECODE_PAPER, "paper, fast math", 1},
                               {"Phong", "Phong", -1},
                               {"PCA", "PCA, 8 bit", -1},
                               {"uncompressed", "uncompressed, 3 x 3 images", -1}};

/* The label of a row of the material with relief and gloss: which of them is decoded, and the filter. */
static const char *relief_label(const decode_row *r, bool whole) {
    static const char *const with[] = {"relief", "relief; bilinear", "relief; steep"};
    static const struct {
        const char *effects, *label;
    } of[] = {{DECODE_NO_RELIEF, "gloss alone"},
              {DECODE_NO_GLOSS, "relief alone"},
              {DECODE_ADDED_GLOSS, "relief and gloss"},
              {DECODE_NEITHER, "relief off"}};
    for (size_t i = 0; i < sizeof of / sizeof *of; i++) {
        if (strcmp(r->effects, of[i].effects) == 0 && r->filter == BTF_FILTER_TEXEL) {
            return of[i].label;
        }
    }
    return whole && !r->nearest ? with[r->filter] : NULL;
}

/* The feature of a row that the mark of an exact one names. */
static const char *label_of(const decode_row *r) {
    const bool whole = strcmp(r->effects, "whole") == 0;
    if (r->peer) {
        return strncmp(r->effects, "rank", 4) == 0 ? strchr(r->effects, ';') + 2 : NULL;
    }
    if (r->fast) {
        return NULL;
    }
    if (strcmp(r->material, DECODE_RELIEF) == 0) {
        return relief_label(r, whole);
    }
    if (r->filter != BTF_FILTER_TEXEL || strchr(r->material, ';')) {
        return NULL;
    }
    return !whole ? NULL : r->nearest ? "nearest" : "linear";
}

static btf_result decode_plot(const bench_run *run, const decode_table *table, const char *device,
                              const char *section, bool headline) {
    char title[200];
    snprintf(title, sizeof title, "Decoding: time against accuracy, %s", run->source);
    plot *p = plot_create(title, "time of one pixel, ns", headline ? 2 : PLOT_PANELS);
    bench_accuracy_panels(run, p, headline);
    plot_front(p);
    for (size_t s = 0; s < sizeof series / sizeof *series; s++) {
        if (headline && series[s].fast > 0) {
            continue;
        }
        plot_series(p, series[s].title, false);
        for (int i = 0; i < table->count; i++) {
            const decode_row *r = &table->rows[i];
            if (strcmp(r->device, device) == 0 && strcmp(r->material, series[s].material) == 0 &&
                (series[s].fast < 0 || series[s].fast == r->fast)) {
                /* uncompressed data are so accurate that their mark would squeeze all others together */
                const double whole = strcmp(r->material, "uncompressed") == 0 ? NAN : 1;
                const int seen = decode_seen(r);
                const double of_seen = seen > 0 ? 1 : whole, linear = whole * r->linear[0];
                const double y[PLOT_PANELS] = {of_seen * r->linear[seen],
                                               headline ? linear : of_seen * r->srgb[seen], linear,
                                               whole * r->srgb[0]};
                if (isfinite(r->linear[0])) {
                    plot_point(p, r->ns, y, label_of(r));
                }
            }
        }
    }
    for (int i = 0; i < table->count; i++) {
        const decode_row *r = &table->rows[i];
        if (strcmp(r->device, device) == 0 && strcmp(r->effects, DECODE_FLOOR) == 0 && !r->nearest &&
            r->filter == BTF_FILTER_TEXEL && !strchr(r->material, ';')) {
            snprintf(title, sizeof title, "fetches of %s", r->material);
            plot_vertical(p, r->ns, title);
        }
    }
    return bench_finish_plot(run, section, &p);
}

btf_result decode_table_write(const bench_run *run, const decode_table *table) {
    FILE *csv = NULL;
    btf_result result = bench_open(run, "decode", "csv", &csv);
    if (result != BTF_OK) {
        return result;
    }
    write_csv(table, csv);
    if (fclose(csv) != 0) {
        return enc_fail(run->context, BTF_ERROR_IO, "decode-%s.csv: cannot write", run->name);
    }
    fprintf(
        run->summary,
        "Median of the repeats. Accuracy is that of the very pixels: PSNR of 65,536 random samples, linear "
        "/ "
        "sRGB-coded dB, between the samples, at them, and at views and lights that were left out of the "
        "encoding. At the "
        "middle of a texel, where there is truth to compare with, filters change nothing but with relief.\n\n");
    if (table->devices > 0) {
        result = decode_plot(run, table, table->device[0].name, "decode", false);
        if (result == BTF_OK) {
            result = decode_plot(run, table, table->device[0].name, "readme-decode", true);
        }
        print_versions(table, run->summary);
        print_places(table, run->summary);
        print_sizes(table, run->summary);
    }
    for (int i = 0; i < table->devices; i++) {
        print_device(table, table->device[i].name, table->device[i].renderer, table->device[i].software,
                     run->summary);
    }
    if (run->methods & BENCH_METHOD_REFERENCE) {
        print_device(table, "CPU reference", run->system->cpu, true, run->summary);
        print_device(table, "CPU evaluator", run->system->cpu, true, run->summary);
    }
    return result;
}
