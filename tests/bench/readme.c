/* Writes fragments of the README. See readme.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "readme.h"
#include "tests/bench/decode/decode_materials.h"

#include <math.h>
#include <string.h>

static const bench_row *find(const bench_table *table, const char *name) {
    for (int i = 0; i < table->count; i++) {
        if (strcmp(table->rows[i].name, name) == 0) {
            return &table->rows[i];
        }
    }
    return NULL;
}

static void print_pair(double linear, double srgb, FILE *out) {
    if (isnan(linear)) {
        fprintf(out, " - |");
    } else {
        fprintf(out, " %.2f / %.2f |", linear, srgb);
    }
}

static btf_result encode_table(const bench_run *run, const bench_table *table, const bench_row *medium) {
    static const char *const names[] = {"joint fast",
                                        "joint medium",
                                        "joint medium; 1/2 of the bytes",
                                        "joint thorough",
                                        "joint exhaustive",
                                        "paper",
                                        "paper; 1 lobe"};
    FILE *out;
    const btf_result result = bench_open(run, "readme-encode", "md", &out);
    if (result != BTF_OK) {
        return result;
    }
    fprintf(out,
            "| encoding | times `medium` | core s | %s | at the samples | GPU MB | peak MB |\n"
            "| --- | --- | --- | --- | --- | --- | --- |\n",
            bench_seen_words(run));
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        const bench_row *r = find(table, names[i]);
        if (r) {
            fprintf(out, "| %s | %.2f | %.1f |", r->name, r->core / medium->core, r->core);
            print_pair(bench_seen(r, false), bench_seen(r, true), out);
            print_pair(r->linear, r->srgb, out);
            fprintf(out, " %.3f | %.0f |\n", 1e-6 * r->bytes, 1e-6 * r->memory);
        }
    }
    return fclose(out) == 0 ? BTF_OK : enc_fail(run->context, BTF_ERROR_IO, "readme-encode: cannot write");
}

static void print_between_rows(const bench_run *run, const bench_table *table, FILE *out) {
    for (int i = 0; i < table->count; i++) {
        const bench_row *r = &table->rows[i];
        fprintf(out, "| %s | %s |", run->name, r->name);
        print_pair(r->between[BENCH_TRUTH][0], r->between[BENCH_TRUTH][1], out);
        print_pair(r->linear, r->srgb, out);
        print_pair(r->between[BENCH_ESTIMATE][0], r->between[BENCH_ESTIMATE][1], out);
        fprintf(out, " %.3f |\n", 1e-6 * r->bytes);
    }
}

btf_result bench_readme_between(const bench_run *run, const bench_table *table) {
    FILE *out;
    fprintf(
        run->summary,
        "PSNR, linear / sRGB-coded dB. The estimate leaves out view and light of %d pairs of samples and "
        "predicts them from the others. Peers are blended barycentrically.\n\n"
        "| data | codec | between the samples | at them | estimate | GPU MB |\n"
        "| --- | --- | --- | --- | --- | --- |\n",
        BENCH_ESTIMATE_PAIRS);
    print_between_rows(run, table, run->summary);
    fputc('\n', run->summary);
    const btf_result result = bench_open(run, "readme-between", "md", &out);
    if (result != BTF_OK) {
        return result;
    }
    print_between_rows(run, table, out);
    return fclose(out) == 0 ? BTF_OK : enc_fail(run->context, BTF_ERROR_IO, "readme-between: cannot write");
}

/* dB of `a` over `b` in words, between the samples and at them. */
static void print_gain(const bench_row *a, const bench_row *b, FILE *out) {
    fprintf(out, "%+.2f / %+.2f dB between the samples (%+.2f / %+.2f at them)",
            bench_seen(a, false) - bench_seen(b, false), bench_seen(a, true) - bench_seen(b, true),
            a->linear - b->linear, a->srgb - b->srgb);
}

btf_result bench_readme_encode(const bench_run *run, const bench_table *table) {
    const bench_row *fast = find(table, "joint fast"), *medium = find(table, "joint medium"),
                    *thorough = find(table, "joint thorough"), *paper = find(table, "paper");
    FILE *out;
    if (!fast || !medium || !paper) {
        return BTF_OK;
    }
    btf_result result = encode_table(run, table, medium);
    if (result != BTF_OK || (result = bench_open(run, "guide-encode", "md", &out)) != BTF_OK) {
        return result;
    }
    fprintf(out, "- **While a scene is being made**: `--preset fast`: %.2f times the time of `medium`, ",
            fast->core / medium->core);
    print_gain(fast, medium, out);
    fprintf(out, ".\n- **For a game or a viewer**: `--preset medium`, the default.\n");
    if (thorough) {
        fprintf(out, "- **For an archive**: `--preset thorough`: %.1f times the time of `medium`, ",
                thorough->core / medium->core);
        print_gain(thorough, medium, out);
        fprintf(out, ".\n");
    }
    fprintf(out, "- `--method paper`: %.1f times the time of `medium`, ", paper->core / medium->core);
    print_gain(paper, medium, out);
    fprintf(out, "; there as a baseline, not to be used.\n");
    return fclose(out) == 0 ? BTF_OK : enc_fail(run->context, BTF_ERROR_IO, "guide-encode: cannot write");
}

static void print_row(const decode_row *r, const char *name, double unit, FILE *out) {
    if (r) {
        fprintf(out, "| %s | %.2f | %.0f |", name, r->ns / unit, r->ns);
        const int seen = decode_seen(r);
        print_pair(r->linear[seen], r->srgb[seen], out);
        print_pair(r->linear[0], r->srgb[0], out);
        fprintf(out, " %.3f | %.0f / %.0f | %.0f / %.0f |\n", 1e-6 * r->gpu_bytes, r->cost.fetches,
                r->cost.bytes, r->cost.integers, r->cost.floats);
    }
}

static btf_result decode_rows(const bench_run *run, const decode_table *table, const char *device,
                              const decode_row *base) {
    static const struct {
        const char *material, *effects, *name;
        bool nearest;
        btf_filter filter;
        bool fast;
    } rows[] = {
        {DECODE_JOINT, "whole", "joint: three directions, exact", false, BTF_FILTER_TEXEL, false},
        {DECODE_JOINT, "whole", "the same, fast math", false, BTF_FILTER_TEXEL, true},
        {DECODE_JOINT, "whole", "joint: nearest directions, exact", true, BTF_FILTER_TEXEL, false},
        {DECODE_JOINT, "whole", "joint: three directions, bilinear, exact", false, BTF_FILTER_BILINEAR, false},
        {DECODE_JOINT, "half the components", "joint: half of the units", false, BTF_FILTER_TEXEL, false},
        {DECODE_HALF_JOINT, "whole", "joint: half the bytes", false, BTF_FILTER_TEXEL, false},
        {DECODE_RELIEF, DECODE_NEITHER, "fit, relief and gloss left out", false, BTF_FILTER_TEXEL, false},
        {DECODE_RELIEF, DECODE_NO_RELIEF, "fit and gloss", false, BTF_FILTER_TEXEL, false},
        {DECODE_RELIEF, DECODE_NO_GLOSS, "fit and relief", false, BTF_FILTER_TEXEL, false},
        {DECODE_RELIEF, DECODE_ADDED_GLOSS, "fit, relief and gloss of a quarter, not taken", false,
         BTF_FILTER_TEXEL, false},
        {DECODE_RELIEF, "whole", "fit and what is found, the default", false, BTF_FILTER_TEXEL, false},
        {DECODE_RELIEF, "whole", "the same, bilinear", false, BTF_FILTER_BILINEAR, false},
        {DECODE_RELIEF, "whole", "the same, steep", false, BTF_FILTER_STEEP, false},
        {DECODE_PAPER, "whole", "paper: three directions, exact", false, BTF_FILTER_TEXEL, false},
        {DECODE_PAPER, "whole", "the same, fast math", false, BTF_FILTER_TEXEL, true},
        {"Phong", "two maps", "Phong, two maps", false, BTF_FILTER_TEXEL, true},
        {"uncompressed", "3 x 3 images of 8 bits", "uncompressed, 3 x 3 images", false, BTF_FILTER_TEXEL, true}};
    FILE *out;
    const btf_result result = bench_open(run, "readme-decode", "md", &out);
    if (result != BTF_OK) {
        return result;
    }
    fprintf(out,
            "| decoding, %s | times joint | ns a pixel | %s | at the samples | GPU MB | fetches / bytes | "
            "operations "
            "of integers / floats |\n"
            "| --- | --- | --- | --- | --- | --- | --- | --- |\n",
            table->device[0].renderer, bench_seen_words(run));
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        print_row(decode_table_find(table, device, rows[i].material, rows[i].effects, rows[i].nearest,
                                    rows[i].filter, rows[i].fast),
                  rows[i].name, base->ns, out);
    }
    for (int i = 0; i < table->count; i++) {
        const decode_row *r = &table->rows[i];
        char name[64];
        if (strcmp(r->device, device) == 0 && strcmp(r->material, "PCA") == 0) {
            snprintf(name, sizeof name, "PCA, 8 bit, %s", r->effects);
            print_row(r, name, base->ns, out);
        }
    }
    return fclose(out) == 0 ? BTF_OK : enc_fail(run->context, BTF_ERROR_IO, "readme-decode: cannot write");
}

/* a - b, and 0 in place of -0. */
static double gap(double a, double b) {
    return fabs(a - b) < 0.005 ? 0 : a - b;
}

/* Prints time and accuracy of a cheaper way to decode relative to `base`. */
static void print_way(const char *text, const decode_row *r, const decode_row *base, FILE *out) {
    if (!r) {
        return;
    }
    fprintf(out, "- %s: %.2f times the time", text, r->ns / base->ns);
    const int seen = decode_seen(base);
    if (seen > 0) {
        fprintf(out, ", %+.2f / %+.2f dB between the samples", gap(r->linear[seen], base->linear[seen]),
                gap(r->srgb[seen], base->srgb[seen]));
    }
    if (fabs(r->linear[0] - base->linear[0]) >= 0.005) {
        fprintf(out, ", %+.2f / %+.2f dB at them", r->linear[0] - base->linear[0],
                r->srgb[0] - base->srgb[0]);
    }
    fprintf(out, ".\n");
}

/* One way to decode a material. */
static const decode_row *way(const decode_table *table, const char *material, const char *effects,
                             bool nearest, btf_filter filter, bool fast) {
    return decode_table_find(table, table->device[0].name, material, effects, nearest, filter, fast);
}

btf_result bench_readme_decode(const bench_run *run, const decode_table *table) {
    const char *device = table->devices > 0 ? table->device[0].name : "";
    const decode_row *base = decode_table_find(table, device, DECODE_JOINT, "whole", false, BTF_FILTER_TEXEL, false);
    FILE *out;
    if (!base) {
        return BTF_OK;
    }
    btf_result result = decode_rows(run, table, device, base);
    if (result != BTF_OK || (result = bench_open(run, "guide-decode", "md", &out)) != BTF_OK) {
        return result;
    }
    fprintf(out,
            "\nOf the shader, against joint with three directions, texels and exact mathematics (%.0f ns a "
            "pixel; a viewer's choice), on that device:\n\n",
            base->ns);
    print_way("**A game**: half of the bytes, `--budget`",
              way(table, DECODE_HALF_JOINT, "whole", false, BTF_FILTER_TEXEL, false), base, out);
    print_way("half of the units, `components` of the shader's options",
              way(table, DECODE_JOINT, "half the components", false, BTF_FILTER_TEXEL, false), base, out);
    print_way("nearest directions", way(table, DECODE_JOINT, "whole", true, BTF_FILTER_TEXEL, false), base, out);
    print_way("**A still, or a close look**: bilinear texels",
              way(table, DECODE_JOINT, "whole", false, BTF_FILTER_BILINEAR, false), base, out);
    const decode_row *fast = way(table, DECODE_JOINT, "whole", false, BTF_FILTER_TEXEL, true),
                     *paper = way(table, DECODE_PAPER, "whole", false, BTF_FILTER_TEXEL, false),
                     *paper_fast = way(table, DECODE_PAPER, "whole", false, BTF_FILTER_TEXEL, true);
    if (fast) {
        fprintf(out, "- exactness costs %.2f times the time of native mathematics (`BTF_MATH_FAST`)",
                base->ns / fast->ns);
        if (paper && paper_fast) {
            fprintf(out, ", `--method paper`, which computes `pow`, %.2f", paper->ns / paper_fast->ns);
        }
        fprintf(out, ".\n");
    }
    return fclose(out) == 0 ? BTF_OK : enc_fail(run->context, BTF_ERROR_IO, "guide-decode: cannot write");
}
