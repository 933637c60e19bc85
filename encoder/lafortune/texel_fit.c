/* The fit of one texel: the Gram matrix of the samples turned into a small least-squares problem with the
 * colours eliminated, Ceres as its solver, and the choice among starts and simpler models. See texel_fit.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "texel_fit.h"

#include "ceres_bridge.h"
#include "normal_equations.h"
#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum {
    PLANES = 7,       /* product x, y, z, multiplier, target R, G, B */
    THINNING = 4,     /* starts compete on every fourth sample */
    THIN_FROM = 2048, /* of at least so many */
};

struct enc_fit_workspace {
    size_t max_samples;
    float *memory;       /* all padded planes */
    float *full[PLANES]; /* the samples */
    float *thin[PLANES]; /* a quarter of them */
};

/* Starting shapes (Cx, Cy, Cz, n), with lobes apart from one another: in a prototype, lobes that began
 * alike never parted, and those that began symmetric in azimuth parted slowly. The first set has a mirror
 * lobe and two slanted ones. Four sets, competing on a quarter of the samples, gave BRICKS64 20.71 / 17.99
 * dB, one alone 20.69 / 17.98. */
static const double start_shapes[ENC_FIT_MAX_STARTS][ENC_MAX_LOBES][4] = {
    {{-1.0, -1.0, 1.0, 8}, {0.8, -0.3, 0.6, 2}, {-0.3, 0.8, 0.6, 2}, {0.5, 0.5, 0.7, 3}},
    {{-0.9, -0.9, 0.9, 30}, {0.7, 0.7, 0.7, 4}, {-0.5, -0.5, 0.9, 1}, {0.3, -0.8, 0.6, 2}},
    {{0.9, 0.9, 0.9, 12}, {-0.8, 0.3, 0.6, 2}, {0.3, -0.8, 0.6, 2}, {-0.9, -0.9, 0.9, 20}},
    {{-0.7, -0.7, 0.9, 3}, {0.2, 0.2, 1.1, 6}, {0.6, -0.6, 0.5, 1}, {-0.6, 0.6, 0.5, 1}},
};
static const double start_diffuse = 0.8;

/* A lobe may be at most so many times its largest value at a sample: without a limit, sharp lobes settle
 * between the sampled directions or below the last ring, invisible but for one sample's flank (of BRICKS64's RGB
 * lobes, 3 % exceeded 1000 times). */
static const double most_overshoot = 4;

enc_fit_options enc_fit_options_default(void) {
    return (enc_fit_options){
        .lobes = 3,
        .rounds = 3,
        .t_error = 0.3f,
        .t_btf = 0.3f,
        .starts = 4,
        .tolerance = 1e-3,
        .max_evaluations = 60,
    };
}

static size_t padded_size(size_t n) {
    return (n + ENC_GRAM_BLOCK - 1) / ENC_GRAM_BLOCK * ENC_GRAM_BLOCK;
}

btf_result enc_fit_workspace_create(size_t max_samples, enc_fit_workspace **out_workspace) {
    *out_workspace = NULL;
    if (max_samples == 0 || max_samples > SIZE_MAX / 128) {
        return BTF_ERROR_USAGE;
    }
    const size_t full = padded_size(max_samples), thin = padded_size(max_samples / THINNING + 1);
    enc_fit_workspace *workspace = malloc(sizeof *workspace);
    float *memory = aligned_alloc(64, PLANES * (full + thin) * sizeof *memory);
    if (!workspace || !memory) {
        free(workspace);
        free(memory);
        return BTF_ERROR_MEMORY;
    }
    workspace->max_samples = max_samples;
    workspace->memory = memory;
    for (size_t i = 0; i < PLANES; i++) {
        workspace->full[i] = memory + i * full;
        workspace->thin[i] = memory + PLANES * full + i * thin;
    }
    *out_workspace = workspace;
    return BTF_OK;
}

void enc_fit_workspace_destroy(enc_fit_workspace **workspace) {
    if (*workspace) {
        free((*workspace)->memory);
        free(*workspace);
        *workspace = NULL;
    }
}

void enc_fit_fixed_start(int index, int lobes, float *out_parameters) {
    assert(index >= 0 && index < ENC_FIT_MAX_STARTS && lobes >= 1 && lobes <= ENC_MAX_LOBES);
    for (int c = 0; c < 3; c++) {
        out_parameters[c] = 1;
    }
    out_parameters[3] = (float)start_diffuse;
    for (int i = 0; i < 4 * lobes; i++) {
        out_parameters[4 + i] = (float)start_shapes[index][i / 4][i % 4];
    }
}

/* The `n` samples that lie in `plane`, whose padding it sets to 0. */
static enc_gram_samples padded_samples(float *const plane[PLANES], size_t n) {
    for (int k = 0; k < PLANES; k++) {
        memset(plane[k] + n, 0, (padded_size(n) - n) * sizeof(float));
    }
    return (enc_gram_samples){
        .n = n,
        .product = {plane[0], plane[1], plane[2]},
        .multiplier = plane[3],
        .target = {plane[4], plane[5], plane[6]},
    };
}

/* Copies one sample of every THINNING, at a place that moves on so as not to fall in step with the
 * lights. */
static enc_gram_samples thin_samples(enc_fit_workspace *workspace, size_t n) {
    const size_t count = n / THINNING;
    for (int k = 0; k < PLANES; k++) {
        for (size_t i = 0; i < count; i++) {
            workspace->thin[k][i] = workspace->full[k][i * THINNING + i % THINNING];
        }
    }
    return padded_samples(workspace->thin, count);
}

/* Copies the samples in, roots of the weights multiplied in and targets scaled to at most 1, and solves the
 * model without lobes. Returns false when all targets are 0. */
static bool load_samples(enc_fit_workspace *workspace, const enc_fit_samples *samples, enc_fit_problem *p) {
    assert(samples->n > 0 && samples->n <= workspace->max_samples);
    float largest = 0;
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < samples->n; i++) {
            if (samples->target[c][i] > largest && (!samples->weight || samples->weight[i] > 0)) {
                largest = samples->target[c][i];
            }
        }
    }
    if (largest == 0) {
        return false;
    }
    const size_t n = samples->n;
    const double inverse = 1.0 / (double)largest;
    float *const *array = workspace->full;
    double aa = 0, at[3] = {0}, tt[3] = {0};
    for (size_t i = 0; i < n; i++) {
        const float root = samples->weight ? sqrtf(samples->weight[i]) : 1.0f;
        const float multiplier = root * samples->multiplier[i];
        array[3][i] = multiplier;
        aa += (double)multiplier * (double)multiplier;
        for (int c = 0; c < 3; c++) {
            const float target = root * (float)((double)samples->target[c][i] * inverse);
            array[4 + c][i] = target;
            at[c] += (double)multiplier * (double)target;
            tt[c] += (double)target * (double)target;
        }
    }
    for (int k = 0; k < 3; k++) {
        memcpy(array[k], samples->product[k], n * sizeof(float));
    }
    p->samples = padded_samples(array, n);
    p->scale = (double)largest;
    p->diffuse_cost = 0;
    p->energy = 0;
    for (int c = 0; c < 3; c++) {
        p->diffuse_colour[c] = aa > 0 ? at[c] / aa : 0;
        p->diffuse_cost += tt[c] - p->diffuse_colour[c] * at[c];
        p->energy += tt[c];
    }
    return true;
}

/* Runs one descent from p->best (shapes, rho_d; colours 0 or good ones), whose cost is not looked at. */
static btf_result descend(enc_fit_problem *p, const enc_fit_options *options) {
    double parameters[ENC_FIT_MAX_PARAMETERS], lower[ENC_FIT_MAX_PARAMETERS], upper[ENC_FIT_MAX_PARAMETERS];
    int size = 0;
    if (!p->rgb) {
        lower[0] = 0;
        upper[0] = fmax(1e3, p->best.diffuse);
        parameters[size++] = p->best.diffuse;
    }
    for (int j = 0; j < p->lobes; j++) {
        for (int k = 0; k < 4; k++, size++) {
            const double value = p->best.shape[j][k];
            parameters[size] = k < 3 ? value : log(value);
            lower[size] = k < 3 ? fmin(-ENC_FIT_MAX_C, value) : log(fmin(ENC_FIT_MIN_N, value));
            upper[size] = k < 3 ? fmax(ENC_FIT_MAX_C, value) : log(fmax(ENC_FIT_MAX_N, value));
        }
    }
    const enc_ceres_options solver = {
        .parameters = size,
        .lower = lower,
        .upper = upper,
        .tolerance = options->tolerance,
        .max_evaluations = options->max_evaluations,
        .trust_region_radius = 1e4,
    };
    p->best.cost = DBL_MAX;
    enc_ceres_summary summary;
    return enc_ceres_minimize(&solver, enc_fit_evaluate, p, parameters, &summary) ? BTF_OK
                                                                                  : BTF_ERROR_MEMORY;
}

/* Sets p->best to the fixed start `index`. */
static void fixed_start(enc_fit_problem *p, int index) {
    memset(&p->best, 0, sizeof p->best);
    memcpy(p->best.shape, start_shapes[index], sizeof p->best.shape);
    for (int j = 0; j < ENC_MAX_LOBES; j++) {
        p->overshoot[j] = log(most_overshoot);
    }
    p->best.diffuse = start_diffuse;
}

/* Finds the best end from the fixed starts. Where there are many samples, a quarter of them decides which
 * start goes on with all. */
static btf_result best_fixed_start(enc_fit_workspace *workspace, enc_fit_problem *p,
                                   const enc_fit_options *options, int starts, enc_fit_solution *out_best) {
    const enc_gram_samples full = p->samples;
    const bool compete = starts > 1 && full.n >= THIN_FROM;
    if (compete) {
        p->samples = thin_samples(workspace, full.n);
    }
    btf_result result = BTF_OK;
    for (int s = 0; s < starts && result == BTF_OK; s++) {
        fixed_start(p, s);
        result = descend(p, options);
        *out_best = p->best.cost < out_best->cost ? p->best : *out_best;
    }
    p->samples = full;
    if (compete && result == BTF_OK) {
        p->best = *out_best;
        result = descend(p, options);
        *out_best = p->best;
    }
    return result;
}

/* Brings the caller's parameters to the scale of the search: with one colour, the larger of rho_d and the
 * lobes becomes about 1, as a fit leaves it. Lobes that are 0 stay so, or are revived in a fixed shape.
 * Returns whether there were any. */
static bool given_start(enc_fit_problem *p, const float *start, bool revive) {
    memset(&p->best, 0, sizeof p->best);
    const float *shapes = start + (p->rgb ? 3 + 3 * p->lobes : 4);
    double size = p->rgb ? 1 : fmax((double)start[3], 1e-6);
    bool dead[ENC_MAX_LOBES], any_dead = false;
    for (int j = 0; j < p->lobes; j++) {
        const float *shape = shapes + 4 * j;
        const double c = fmax(fmax(fabs((double)shape[0]), fabs((double)shape[1])), fabs((double)shape[2]));
        dead[j] = !(c > 0 && shape[3] > 0);
        any_dead = any_dead || dead[j];
        if (!dead[j] && !p->rgb) {
            size = fmax(size, pow(c, (double)shape[3]));
        }
    }
    size = fmin(fmax(size, 1e-30), 1e30);
    for (int j = 0; j < p->lobes; j++) {
        for (int k = 0; k < 4; k++) {
            const double value = dead[j] ? start_shapes[0][j][k] : (double)shapes[4 * j + k];
            const double factor =
                dead[j] ? (revive ? 0.5 : 0) : pow(size, -1 / fmax((double)shapes[4 * j + 3], 1e-3));
            p->best.shape[j][k] = k < 3 ? value * factor : value;
        }
        double peak;
        p->overshoot[j] = log(most_overshoot);
        if (!dead[j]) {
            const double *shape = p->best.shape[j];
            p->overshoot[j] =
                fmax(p->overshoot[j], shape[3] * enc_fit_overshoot(&p->samples, shape, &peak));
        }
    }
    p->best.diffuse = p->rgb ? 0 : (double)start[3] / size;
    for (int c = 0; c < 3; c++) {
        for (int t = 0; t <= p->lobes; t++) {
            p->best.colour[c][t] = p->rgb   ? (double)start[3 * t + c] / p->scale
                                   : t == 0 ? (double)start[c] * size / p->scale
                                            : 0;
        }
    }
    return any_dead;
}

/* Replaces *best by the end from the caller's start, if that is better. A start with lobes of 0 is also
 * tried without reviving them, which may give the better end. */
static btf_result descend_from(enc_fit_problem *p, const enc_fit_options *options, const float *start,
                               enc_fit_solution *best) {
    enc_fit_options only_look = *options;
    only_look.max_evaluations = 1;
    btf_result result = BTF_OK;
    if (given_start(p, start, false)) {
        result = descend(p, &only_look);
        *best = p->best.cost < best->cost ? p->best : *best;
    }
    given_start(p, start, true);
    if (result == BTF_OK) {
        result = descend(p, options);
        *best = p->best.cost < best->cost ? p->best : *best;
    }
    return result;
}

/* A parameter as the file may hold it: 0, or of magnitude 2^-24 .. 2^24; *cut is set where that changes it. */
static float storable(double value, bool *cut) {
    const double magnitude = fabs(value);
    if (!(magnitude >= 0x1p-24)) {
        *cut = *cut || magnitude != 0;
        return 0;
    }
    *cut = *cut || magnitude > 0x1p24;
    return (float)copysign(fmin(magnitude, 0x1p24), value);
}

/* Stores a solution of one colour: max(C) = 1, its scale goes into rho_d and the lobes. */
static void store_one_colour(const enc_fit_problem *p, const enc_fit_solution *at, float *out, bool *cut) {
    const double largest = fmax(fmax(at->colour[0][0], at->colour[1][0]), at->colour[2][0]);
    const double factor = largest * p->scale;
    if (!(factor > 0)) {
        return;
    }
    for (int c = 0; c < 3; c++) {
        out[c] = storable(at->colour[c][0] / largest, cut);
    }
    out[3] = storable(at->diffuse * factor, cut);
    bool any = out[3] != 0;
    for (int j = 0; j < p->lobes; j++) {
        const double *shape = at->shape[j];
        float *lobe = out + 4 + 4 * j;
        const double grow = shape[3] > 0 ? pow(factor, 1 / shape[3]) : 0;
        for (int k = 0; k < 3; k++) {
            lobe[k] = storable(shape[k] * grow, cut);
        }
        const bool dead = lobe[0] == 0 && lobe[1] == 0 && lobe[2] == 0;
        lobe[3] = dead ? 0 : storable(shape[3], cut);
        any = any || !dead;
    }
    if (!any) {
        memset(out, 0, sizeof *out * enc_sbrdf_stride(p->lobes, false));
    }
}

/* Stores a solution of RGB lobes. */
static void store_rgb(const enc_fit_problem *p, const enc_fit_solution *at, float *out, bool *cut) {
    for (int c = 0; c < 3; c++) {
        out[c] = storable(at->colour[c][0] * p->scale, cut);
    }
    for (int j = 0; j < p->lobes; j++) {
        const double *shape = at->shape[j];
        float *lobe = out + 3 + 3 * p->lobes + 4 * j;
        bool any = false;
        for (int c = 0; c < 3 && shape[3] > 0; c++) {
            out[3 + 3 * j + c] = storable(at->colour[c][1 + j] * p->scale, cut);
            any = any || out[3 + 3 * j + c] != 0;
        }
        for (int k = 0; any && k < 4; k++) {
            lobe[k] = storable(shape[k], cut);
        }
    }
}

/* Writes a solution as the file holds it. True where the limits of the file change a parameter. */
static bool store(const enc_fit_problem *p, const enc_fit_solution *at, float *out) {
    bool cut = false;
    memset(out, 0, sizeof *out * enc_sbrdf_stride(p->lobes, p->rgb));
    if (p->rgb) {
        store_rgb(p, at, out, &cut);
    } else {
        store_one_colour(p, at, out, &cut);
    }
    return cut;
}

/* The cost of stored parameters, in the scale of the search and in double. */
static double stored_cost(const enc_fit_problem *p, const float *parameters) {
    const float *shapes = parameters + (p->rgb ? 3 + 3 * p->lobes : 4);
    double cost = 0;
    for (size_t i = 0; i < p->samples.n; i++) {
        double value[3];
        for (int c = 0; c < 3; c++) {
            value[c] = (double)parameters[p->rgb ? c : 3];
        }
        for (int j = 0; j < p->lobes; j++) {
            double base = 0;
            for (int k = 0; k < 3; k++) {
                base += (double)shapes[4 * j + k] * (double)p->samples.product[k][i];
            }
            const double power = base >= 0x1p-24 ? fmin(pow(base, (double)shapes[4 * j + 3]), 0x1p40) : 0;
            for (int c = 0; c < 3; c++) {
                value[c] += p->rgb ? (double)parameters[3 + 3 * j + c] * power : power;
            }
        }
        for (int c = 0; c < 3; c++) {
            const double colour = (p->rgb ? 1 : (double)parameters[c]) / p->scale;
            const double r =
                (double)p->samples.multiplier[i] * (colour * value[c]) - (double)p->samples.target[c][i];
            cost += r * r;
        }
    }
    return cost;
}

/* The best model without lobes. */
static enc_fit_solution diffuse_solution(const enc_fit_problem *p) {
    enc_fit_solution solution = {.cost = fmax(p->diffuse_cost, 0), .diffuse = 1};
    for (int c = 0; c < 3; c++) {
        solution.colour[c][0] = p->diffuse_colour[c];
    }
    return solution;
}

btf_result enc_fit_texel(enc_fit_workspace *workspace, const enc_fit_samples *samples,
                         const enc_fit_options *options, const float *start, int starts,
                         float *out_parameters, enc_fit_result *out_result) {
    assert(options->lobes >= 1 && options->lobes <= ENC_MAX_LOBES);
    assert(starts >= 0 && starts <= ENC_FIT_MAX_STARTS && (start || starts > 0));
    memset(out_parameters, 0, sizeof *out_parameters * enc_sbrdf_stride(options->lobes, options->rgb));
    *out_result = (enc_fit_result){0};
    enc_fit_problem p = {.lobes = options->lobes, .rgb = options->rgb};
    if (!load_samples(workspace, samples, &p)) {
        return BTF_OK;
    }
    enc_fit_solution best = {.cost = DBL_MAX};
    btf_result result = BTF_OK;
    if (starts > 0) {
        result = best_fixed_start(workspace, &p, options, starts, &best);
    }
    if (start && result == BTF_OK) {
        result = descend_from(&p, options, start, &best);
    }
    if (result != BTF_OK) {
        return result;
    }
    bool diffuse = !(best.cost < p.diffuse_cost * (1 - 1e-6));
    if (!diffuse) {
        p.best = best;
        while (enc_fit_drop_idle_lobe(&p)) {
            out_result->dead_lobes++;
        }
        best = p.best;
        if (store(&p, &best, out_parameters)) {
            /* Parameters were cut to the range of the file: the lobes as cut must still be better than none. */
            best.cost = stored_cost(&p, out_parameters);
            float plain[3 + 7 * ENC_MAX_LOBES];
            const enc_fit_solution without = diffuse_solution(&p);
            store(&p, &without, plain);
            diffuse = !(best.cost < stored_cost(&p, plain));
        }
    }
    if (diffuse) {
        best = diffuse_solution(&p);
        out_result->diffuse = true;
        out_result->dead_lobes = p.lobes;
        if (store(&p, &best, out_parameters)) {
            best.cost = stored_cost(&p, out_parameters);
        }
    }
    out_result->cost = best.cost * p.scale * p.scale;
    out_result->evaluations = p.evaluations;
    return BTF_OK;
}
