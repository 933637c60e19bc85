/* Hard data for the fit and the shadow test: for any input the fit gives parameters that a file can hold, and models
 * the data no worse than the best diffuse surface does.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cases.h"
#include "hard_data.h"

#include "encoder/paper/fit.h"
#include "encoder/paper/shadow.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 2, TEXELS = SIDE * SIDE };

/* One way of fitting. */
typedef struct variant {
    const char *name;
    int lobes;
    bool rgb, square_root;
} variant;

static const variant variants[] = {
    {"one colour", 3, false, false},
    {"RGB lobes", 3, true, false},
    {"one colour, square root", 2, false, true},
    {"RGB lobes, square root", 4, true, true},
};

/* The first failure, empty when there was none. */
static char complaint[256];
static void complain(const variant *v, const char *what, double a, double b) {
    if (complaint[0] == 0) {
        snprintf(complaint, sizeof complaint, "%s: %s %g, %g", v->name, what, a, b);
    }
}

static bool storable(float x) {
    return x == 0 || (fabsf(x) >= 0x1p-24f && fabsf(x) <= 0x1p24f);
}

static void check_storable(const variant *v, const enc_sbrdf *sbrdf) {
    const size_t n = sbrdf->n_texels * enc_sbrdf_stride(sbrdf->lobes, sbrdf->rgb);
    for (size_t i = 0; i < n; i++) {
        if (!storable(sbrdf->values[i])) {
            complain(v, "parameter", (double)sbrdf->values[i], (double)i);
        }
    }
    for (size_t t = 0; t < sbrdf->n_texels; t++) {
        const float *shape = sbrdf->values + t * enc_sbrdf_stride(sbrdf->lobes, sbrdf->rgb) +
                             (sbrdf->rgb ? 3 + 3 * sbrdf->lobes : 4);
        for (int j = 0; j < sbrdf->lobes; j++) {
            if (shape[4 * j + 3] > (float)ENC_FIT_MAX_N || shape[4 * j + 3] < 0) {
                complain(v, "n", (double)shape[4 * j + 3], (double)j);
            }
        }
    }
}

/* Costs in the fitted domain over all samples of a texel, in double. */
typedef struct costs {
    double energy, fit, diffuse;
} costs;

static double fitted_domain(bool square_root, double value) {
    return square_root ? sqrt(value) : value;
}

/* A diffuse term as the file may hold it. */
static double stored_diffuse(double value) {
    return value < 0x1p-24 ? 0 : fmin(value, 0x1p24);
}

static costs costs_of(const variant *v, const enc_data *data, const enc_sbrdf *sbrdf, size_t texel) {
    costs sum = {0};
    const float *parameters = sbrdf->values + texel * enc_sbrdf_stride(sbrdf->lobes, sbrdf->rgb);
    for (int c = 0; c < 3; c++) {
        double mm = 0, my = 0;
        for (int pass = 0; pass < 2; pass++) {
            const double albedo = pass > 0 && mm > 0 ? stored_diffuse(my / mm) : 0;
            for (int view = 0; view < data->n_views; view++) {
                for (int light = 0; light < data->n_lights; light++) {
                    const enc_direction *l = data->lights + light;
                    const double y =
                        fitted_domain(v->square_root, (double)*hard_sample(data, texel, view, c, light));
                    const double m = fitted_domain(v->square_root, fmax((double)l->xyz[2], 0));
                    if (pass == 0) {
                        mm += m * m;
                        my += m * y;
                        continue;
                    }
                    const double model =
                        fitted_domain(v->square_root, hard_model(parameters, v->lobes, v->rgb,
                                                                 v->square_root, data->views + view, l, c));
                    sum.energy += y * y;
                    sum.fit += (model - y) * (model - y);
                    sum.diffuse += (albedo * m - y) * (albedo * m - y);
                }
            }
        }
    }
    return sum;
}

/* The fit of `data` by one variant, twice with one thread and once with two: the same bytes. */
static enc_sbrdf *fit_thrice(const variant *v, const enc_data *data, const enc_fit_options *options,
                             enc_fit_stats *stats) {
    enc_sbrdf *kept = NULL;
    for (int run = 0; run < 3; run++) {
        const enc_context context = {.threads = run == 2 ? 2 : 1};
        enc_sbrdf *sbrdf = NULL;
        const btf_result result = enc_fit(&context, data, options, &sbrdf, stats);
        if (result != BTF_OK) {
            complain(v, "result", result, run);
            enc_sbrdf_destroy(&kept);
            return NULL;
        }
        if (kept == NULL) {
            kept = sbrdf;
            continue;
        }
        const size_t n = kept->n_texels * enc_sbrdf_stride(kept->lobes, kept->rgb);
        if (memcmp(kept->values, sbrdf->values, n * sizeof(float)) != 0) {
            complain(v, "run differs", run, 0);
        }
        enc_sbrdf_destroy(&sbrdf);
    }
    return kept;
}

/* Makes the shadow map of a fit: it has codes for any data, and the same with two threads. */
static void check_shadow(const variant *v, const enc_data *data, const enc_sbrdf *sbrdf) {
    uint8_t codes[2][HARD_MAX_DIRECTIONS * TEXELS];
    enc_shadow_options options = enc_shadow_options_default();
    options.square_root = v->square_root;
    float buffer[7 * HARD_MAX_DIRECTIONS];
    for (int threads = 1; threads <= 2; threads++) {
        const enc_context context = {.threads = threads};
        const btf_result result = enc_top_view_shadow(&context, data, sbrdf, &options, codes[threads - 1]);
        if (result != BTF_OK) {
            complain(v, "shadow result", result, threads);
            return;
        }
    }
    const size_t n = (size_t)data->n_lights * enc_data_texel_count(data);
    if (memcmp(codes[0], codes[1], n) != 0) {
        complain(v, "shadow map differs", 0, 0);
    }
    for (size_t t = 0; t < enc_data_texel_count(data); t++) {
        for (int view = 0; view < data->n_views; view++) {
            float *ratio = buffer + 6 * data->n_lights;
            enc_shadow_profile(data, sbrdf, &options, t, view, hard_sample(data, t, view, 0, 0), buffer,
                               ratio);
            for (int l = 0; l < data->n_lights; l++) {
                if (!(ratio[l] >= 0 && ratio[l] <= 1)) {
                    complain(v, "shadow ratio", (double)ratio[l], l);
                }
            }
        }
    }
}

/* Fits by every variant, plain and with rejection, and adds the case. `least_db`: by how many dB the plain fit must
 * have less error than the diffuse one, over all texels and the variants of the linear domain; 0 requires only that it
 * is no worse. */
static void check_fit(const char *input, enc_data *data, double least_db) {
    complaint[0] = 0;
    double least = 1e9, largest = 0;
    for (size_t i = 0; i < sizeof variants / sizeof *variants; i++) {
        const variant *v = variants + i;
        enc_fit_options options = enc_fit_options_default();
        options.lobes = v->lobes;
        options.rgb = v->rgb;
        options.square_root = v->square_root;
        options.rounds = 0;
        enc_fit_stats stats;
        enc_sbrdf *sbrdf = fit_thrice(v, data, &options, &stats);
        double fit = 0, diffuse = 0, energy = 0;
        for (size_t t = 0; sbrdf != NULL && t < sbrdf->n_texels; t++) {
            const costs c = costs_of(v, data, sbrdf, t);
            if (!(c.fit <= c.diffuse * (1 + 1e-5) + 3e-6 * c.energy)) {
                complain(v, "cost, and that of the diffuse fit", c.fit, c.diffuse);
            }
            fit += c.fit;
            diffuse += c.diffuse;
            energy += c.energy;
        }
        if (sbrdf != NULL) {
            check_storable(v, sbrdf);
            check_shadow(v, data, sbrdf);
            const double db =
                energy > 0 ? 10 * log10((diffuse + 1e-12 * energy) / (fit + 1e-12 * energy)) : 0;
            least = !v->square_root && db < least ? db : least;
            largest = db > largest ? db : largest;
        }
        enc_sbrdf_destroy(&sbrdf);

        options.rounds = 3;
        sbrdf = fit_thrice(v, data, &options, &stats);
        if (sbrdf != NULL) {
            check_storable(v, sbrdf);
            check_shadow(v, data, sbrdf);
            if (!(stats.cost <= diffuse * (1 + 1e-5) + 3e-6 * energy)) {
                complain(v, "cost after rejection, and that of the diffuse fit", stats.cost, diffuse);
            }
        }
        enc_sbrdf_destroy(&sbrdf);
    }
    enc_data_destroy(&data);
    char expected[160];
    snprintf(expected, sizeof expected,
             "parameters that a file holds, n at most %g, no worse than diffuse%s%s", ENC_FIT_MAX_N,
             least_db > 0 ? ", better by dB: " : "", "");
    if (least_db > 0) {
        snprintf(expected + strlen(expected), sizeof expected - strlen(expected), "%g", least_db);
        if (!(least >= least_db)) {
            complain(variants, "gain over the diffuse fit, in dB", least, least_db);
        }
    }
    if (complaint[0] != 0) {
        cases_add(input, expected, false, "%s", complaint);
    } else {
        cases_add(input, expected, true, "%.1f to %.1f dB below the diffuse fit's error", fmax(least, 0),
                  largest);
    }
}

/* ---- the data ---- */

/* user: {the bright value, the dark one}. */
static void one_bright(const void *user, int texel, const enc_direction *v, const enc_direction *l,
                       int sample, float rgb[3]) {
    const float *value = user;
    (void)v;
    (void)l;
    for (int c = 0; c < 3; c++) {
        rgb[c] = sample == 17 * (texel + 1) % 169 ? value[0] : value[1];
    }
}

/* A few bright samples, far apart. */
static void sparse(const void *user, int texel, const enc_direction *v, const enc_direction *l, int sample,
                   float rgb[3]) {
    (void)user, (void)v, (void)l;
    rgb[0] = rgb[1] = rgb[2] = (sample + texel) % 21 == 3 ? 1 : 0;
}

/* user: {log10 of the least, log10 of the largest}: evenly spread logarithms. */
static void spread(const void *user, int texel, const enc_direction *v, const enc_direction *l, int sample,
                   float rgb[3]) {
    const float *range = user;
    (void)v;
    (void)l;
    for (int c = 0; c < 3; c++) {
        const double at = (double)hard_random((uint32_t)texel, (uint32_t)sample, (uint32_t)c);
        rgb[c] = (float)pow(10, (double)range[0] + at * (double)(range[1] - range[0]));
    }
}

/* A Lafortune surface. */
typedef struct surface {
    float scale;
    float diffuse;
    float lobe[2][4];
    float weight[2];
    float zeros; /* share of samples that are exactly 0 */
} surface;

static void lafortune(const void *user, int texel, const enc_direction *v, const enc_direction *l,
                      int sample, float rgb[3]) {
    const surface *s = user;
    if (hard_random((uint32_t)texel, (uint32_t)sample, 77) < s->zeros) {
        return;
    }
    const float tint[3] = {1.0f, 0.8f - 0.05f * (float)texel, 0.5f};
    for (int c = 0; c < 3; c++) {
        double sum = (double)(s->diffuse * tint[c]);
        for (int j = 0; j < 2; j++) {
            double base = 0;
            for (int k = 0; k < 3; k++) {
                base += (double)s->lobe[j][k] * (double)l->xyz[k] * (double)v->xyz[k];
            }
            sum += base > 0 ? (double)s->weight[j] * pow(base, (double)s->lobe[j][3]) : 0;
        }
        rgb[c] = (float)((double)s->scale * sum * (double)l->xyz[2]);
    }
}

static void fit_surface(const char *input, const hard_directions *directions, surface s, double least_db) {
    check_fit(input, hard_create(SIDE, SIDE, directions, directions, lafortune, &s), least_db);
}

static void fit_function(const char *input, hard_value_fn value, const void *user) {
    const hard_directions directions = hard_thirteen();
    check_fit(input, hard_create(SIDE, SIDE, &directions, &directions, value, user), 0);
}

static void flat_data(void) {
    const float half = 0.5f, tiny = 1e-40f, least_half = 0x1p-24f, most_half = 65504.0f, huge = 1e30f;
    fit_function("all black", hard_black, NULL);
    fit_function("constant 0.5, light or not", hard_constant, &half);
    fit_function("denormals: constant 1e-40", hard_constant, &tiny);
    fit_function("constant 2^-24, the least half float", hard_constant, &least_half);
    fit_function("constant 65504, the largest half float", hard_constant, &most_half);
    fit_function("constant 1e30, beyond what a file holds", hard_constant, &huge);
    fit_function("one bright sample of 1 in black", one_bright, (const float[]){1, 0});
    fit_function("one bright sample of 1e6 among 1e-8", one_bright, (const float[]){1e6f, 1e-8f});
    fit_function("values spread from 1e-8 to 1e6", spread, (const float[]){-8, 6});
    fit_function("values spread from 1e-44 to 1e38", spread, (const float[]){-44, 38});
    fit_function("noise only", hard_noise, NULL);
}

static void lobes(void) {
    const hard_directions directions = hard_thirteen(), dense = hard_twentyfive();
    fit_surface("a dim surface: times 1e-6", &directions,
                (surface){1e-6f, 0.5f, {{-1, -1, 1, 8}}, {0.5f, 0}, 0}, 0);
    fit_surface("a bright surface: times 1e6", &directions,
                (surface){1e6f, 0.5f, {{-1, -1, 1, 1}}, {2, 0}, 0}, 3);
    fit_surface("highlight 1000 times the diffuse term", &directions,
                (surface){1, 0.5f, {{-1, -1, 1, 20}}, {500, 0}, 0}, 20);
    fit_surface("half of the samples exactly 0", &directions,
                (surface){1, 0.5f, {{-1, -1, 1, 8}}, {0.5f, 0}, 0.5f}, 0);
    fit_surface("mirror-like lobe, n = 200", &directions, (surface){1, 0.2f, {{-1, -1, 1, 200}}, {5, 0}, 0},
                20);
    fit_surface("mirror-like lobe, n = 2000, beyond its bound", &directions,
                (surface){1, 0.2f, {{-1, -1, 1, 2000}}, {5, 0}, 0}, 20);
    fit_surface("retro-reflection, n = 30", &directions, (surface){1, 0.2f, {{1, 1, 1, 30}}, {5, 0}, 0},
                20);
    fit_surface("lobe below the horizon: Cz = -0.3", &dense,
                (surface){1, 0.3f, {{-1.2f, -1.2f, -0.3f, 4}}, {2, 0}, 0}, 6);
    fit_surface("anisotropic lobe, Cx = -1.2, Cy = -0.3", &dense,
                (surface){1, 0.3f, {{-1.2f, -0.3f, 0.9f, 9}}, {1, 0}, 0}, 10);
    fit_surface("anisotropic lobe, Cx = 1, Cy = -1", &dense,
                (surface){1, 0.3f, {{1, -1, 0.8f, 6}}, {1, 0}, 0}, 10);
    fit_surface("two equal lobes: the Jacobian lacks a rank", &directions,
                (surface){1, 0.3f, {{-1, -1, 1, 6}, {-1, -1, 1, 6}}, {0.5f, 0.5f}, 0}, 10);
    const hard_directions grazing =
        hard_rings(5, (const double[]){0, 85, 87.5, 89, 89.9}, (const int[]){1, 4, 4, 4, 4});
    fit_surface("views and lights at 0 and 85 to 89.9 degrees", &grazing,
                (surface){1, 0.3f, {{-1, -1, 1, 12}}, {1, 0}, 0}, 3);
    const hard_directions only_grazing = hard_rings(2, (const double[]){89, 89.9}, (const int[]){4, 4});
    fit_surface("views and lights at 89 and 89.9 degrees alone", &only_grazing,
                (surface){1, 0.3f, {{-1, -1, 1, 12}}, {1, 0}, 0}, 0);
}

static void few_samples(void) {
    const hard_directions one = hard_rings(1, (const double[]){20}, (const int[]){1});
    const hard_directions two = hard_rings(1, (const double[]){40}, (const int[]){2});
    const surface s = {1, 0.3f, {{-1, -1, 1, 12}}, {1, 0}, 0};
    fit_surface("one view, one light: 1 sample, up to 31 unknowns", &one, s, 0);
    fit_surface("two views, two lights: 4 samples, up to 31 unknowns", &two, s, 0);
}

/* Where rejection would remove all samples, the texel keeps its fit. Seen from the pole, the model gives the same value
 * for all lights of a ring, and so lies above every dark sample. */
static void all_rejected(void) {
    const hard_directions pole = hard_rings(1, (const double[]){0}, (const int[]){1});
    const hard_directions ring = hard_rings(1, (const double[]){30}, (const int[]){60});
    enc_data *data = hard_create(SIDE, SIDE, &pole, &ring, sparse, NULL);
    complaint[0] = 0;
    uint64_t rejected = 0;
    for (size_t i = 0; i < sizeof variants / sizeof *variants; i++) {
        const variant *v = variants + i;
        enc_fit_options options = enc_fit_options_default();
        options.lobes = v->lobes;
        options.rgb = v->rgb;
        options.square_root = v->square_root;
        options.t_error = 0;
        options.t_btf = 1e30f;
        enc_fit_stats stats[2];
        enc_sbrdf *with = fit_thrice(v, data, &options, &stats[0]);
        options.rounds = 0;
        enc_sbrdf *without = fit_thrice(v, data, &options, &stats[1]);
        if (with != NULL && without != NULL) {
            const size_t n = with->n_texels * enc_sbrdf_stride(with->lobes, with->rgb);
            if (memcmp(with->values, without->values, n * sizeof(float)) != 0) {
                complain(v, "the fit changed", 0, 0);
            }
            check_storable(v, with);
            rejected += stats[0].rejected;
        }
        enc_sbrdf_destroy(&with);
        enc_sbrdf_destroy(&without);
    }
    enc_data_destroy(&data);
    if (rejected != 0) {
        complain(variants, "rejected", (double)rejected, 0);
    }
    cases_add("thresholds that reject all but 5 % of the samples",
              "nothing is rejected, the first fit stays", complaint[0] == 0, "%s",
              complaint[0] == 0 ? "the same bytes as without rejection" : complaint);
}

/* A fit that starts from two equal lobes: the same derivatives twice. */
static void equal_starts(void) {
    const hard_directions d = hard_twentyfive();
    const surface s = {1, 0.3f, {{-1, -1, 1, 6}, {0.9f, 0.9f, 0.9f, 9}}, {0.5f, 0.5f}, 0};
    const size_t n = (size_t)(d.n * d.n);
    float *planes = malloc(7 * n * sizeof *planes);
    enc_fit_workspace *workspace = NULL;
    if (planes == NULL || enc_fit_workspace_create(n, &workspace) != BTF_OK) {
        exit(1);
    }
    for (int v = 0; v < d.n; v++) {
        for (int l = 0; l < d.n; l++) {
            const size_t i = (size_t)(v * d.n + l);
            float rgb[3];
            lafortune(&s, 0, d.list + v, d.list + l, (int)i, rgb);
            for (int k = 0; k < 3; k++) {
                planes[(size_t)k * n + i] = d.list[v].xyz[k] * d.list[l].xyz[k];
                planes[(size_t)(4 + k) * n + i] = rgb[k];
            }
            planes[3 * n + i] = d.list[l].xyz[2];
        }
    }
    const enc_fit_samples samples = {.n = n,
                                     .product = {planes, planes + n, planes + 2 * n},
                                     .multiplier = planes + 3 * n,
                                     .target = {planes + 4 * n, planes + 5 * n, planes + 6 * n}};
    enc_fit_options options = enc_fit_options_default();
    options.lobes = 2;
    options.max_evaluations = 1;
    const float start[12] = {1, 0.8f, 0.5f, 0.3f, -0.8f, -0.8f, 0.8f, 4, -0.8f, -0.8f, 0.8f, 4};
    float out[12];
    enc_fit_result before, after;
    bool ok = enc_fit_texel(workspace, &samples, &options, start, 0, out, &before) == BTF_OK;
    options.max_evaluations = 60;
    ok = enc_fit_texel(workspace, &samples, &options, start, 0, out, &after) == BTF_OK && ok;
    for (int i = 0; i < 12; i++) {
        ok = ok && storable(out[i]);
    }
    ok = ok && after.cost <= before.cost;
    cases_add("a start of two identical lobes", "finite, no dearer than the start", ok,
              "cost %.3g, of the start %.3g", after.cost, before.cost);
    enc_fit_workspace_destroy(&workspace);
    free(planes);
}

/* The lobe's largest value anywhere over its largest at a sample: bounded. */
static void overshoot(void) {
    const hard_directions d = hard_thirteen();
    const surface s = {1, 0.2f, {{-1.3f, -1.3f, 0.1f, 60}}, {20, 0}, 0};
    enc_data *data = hard_create(SIDE, SIDE, &d, &d, lafortune, &s);
    const enc_context context = {.threads = 1};
    enc_fit_options options = enc_fit_options_default();
    options.rounds = 0;
    enc_sbrdf *sbrdf = NULL;
    double worst = 0;
    bool ok = enc_fit(&context, data, &options, &sbrdf, NULL) == BTF_OK;
    for (size_t t = 0; ok && t < TEXELS; t++) {
        const float *lobe = sbrdf->values + t * enc_sbrdf_stride(3, false) + 4;
        for (int j = 0; j < 3; j++, lobe += 4) {
            double peak = ENC_SHADOW_MIN_MODEL, reach = 0;
            for (int v = 0; v < d.n; v++) {
                for (int l = 0; l < d.n; l++) {
                    double base = 0;
                    for (int k = 0; k < 3; k++) {
                        base += (double)(lobe[k] * d.list[v].xyz[k]) * (double)d.list[l].xyz[k];
                    }
                    peak = base > 0 ? fmax(peak, pow(base, (double)lobe[3])) : peak;
                }
            }
            for (int k = 0; k < 3; k++) {
                const double most = k < 2 ? fabs((double)lobe[k]) : fmax((double)lobe[k], 0);
                reach = most > 0 ? fmax(reach, pow(most, (double)lobe[3])) : reach;
            }
            worst = lobe[3] > 0 ? fmax(worst, reach / peak) : worst;
        }
    }
    ok = ok && worst <= 4.01;
    cases_add("a sharp lobe below the last ring", "no lobe exceeds 4 times its largest sample anywhere", ok,
              "%.2f times", worst);
    enc_sbrdf_destroy(&sbrdf);
    enc_data_destroy(&data);
}

/* The shadow ratio where the paper divides by 0. */
static void shadow_ratios(void) {
    const float values[] = {0, -0.0f, 1e-45f, 1e-38f, 1e-8f, 1e-5f, 0.1f, 1, 1e6f, FLT_MAX, INFINITY, NAN};
    const int n = sizeof values / sizeof *values;
    bool ok = true;
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < n; k++) {
            for (int e = 0; e < n; e++) {
                const float ratio = enc_shadow_ratio(values[i], values[k], values[e], 0.3f);
                ok = ok && ratio >= 0 && ratio <= 1 &&
                     enc_shadow_code(ratio) == (uint8_t)(255 * ratio + 0.5f);
            }
        }
    }
    ok = ok && enc_shadow_ratio(0, 0, 0.3f, 0.3f) == 1 && enc_shadow_ratio(0.5f, 0, 0.3f, 0.3f) == 0 &&
         enc_shadow_ratio(1e-6f, 0, 0.3f, 0.3f) == 1 && enc_shadow_code(NAN) == 0;
    cases_add("shadow ratio of every pair of 0, -0, denormals, 1e-8 to infinity, NaN",
              "0 to 1; 0 over 0 is 1, 0 over 0.5 is 0", ok, "%d pairs and thresholds", n * n * n);
}

int main(void) {
    cases_title("The fit of the SBRDF (four variants: one colour and RGB lobes, linear and square root, "
                "each plain and "
                "with rejection, with 1 and 2 threads; a gain in dB is asked of the linear ones) "
                "and the shadow test.");
    flat_data();
    lobes();
    few_samples();
    all_rejected();
    equal_starts();
    overshoot();
    shadow_ratios();
    return cases_result();
}
