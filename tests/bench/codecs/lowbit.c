/* Components of opponent colour in 8, 4 and 2 bits. See lowbit.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "lowbit.h"

#include "encoder/math/gemm.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    LANES = 96,       /* texels or columns that one thread refines at a time */
    REFIT_SWEEPS = 3, /* sweeps that fit u to the rounded w, before u is rounded */
    BISECTIONS = 60,  /* steps of the search for the price of a byte */
    SCALE_BYTES = 4,  /* a component's scale of u, and another of w */
    VIEW_BYTES = 1,   /* a view's factor, for each axis and number of bits of w */
    TIERS = 3,
};

static const uint8_t tier_bits[TIERS] = {8, 4, 2};

/* The squared error of rounding to so many bits, relative to the component's energy: measured on factors of several
 * materials (which ones was not recorded) with the scales below. The optimum is flat, so that other values change
 * little. */
static double rounding_error(int bits, bool of_u) {
    return bits == 8 ? 6e-5 : bits == 4 ? (of_u ? 0.016 : 0.0135) : 0.13;
}

/* The largest level of a factor, in steps. In 8 bits levels are whole steps and include 0; in 4 and 2 bits they are the
 * odd steps, so that there are as many of each sign. */
static float top_level(int bits) {
    return bits == 8 ? 127 : bits == 4 ? 15 : 3;
}

/* The level nearest to `x`, in steps. */
static float nearest_level(int bits, float x) {
    const float top = top_level(bits);
    const float level = bits == 8 ? rintf(x) : 2 * rintf(0.5f * (x - 1)) + 1;
    return level > top ? top : level < -top ? -top : level;
}

/* --- allocation --- */

typedef struct choice {
    uint8_t bits_u, bits_w; /* 0: dropped */
} choice;

typedef struct allocation {
    const double *energy[3]; /* [rank], falling */
    size_t rank[3], texels, columns;
    bool eight_only;
    choice *chosen[3]; /* [rank] */
} allocation;

static size_t component_bytes(const allocation *a, choice c) {
    return c.bits_u == 0 ? 0 : (a->texels * c.bits_u + a->columns * c.bits_w + 7) / 8 + 2 * SCALE_BYTES;
}

static choice cheapest(const allocation *a, double energy, double price) {
    choice best = {0, 0};
    double least = energy;
    for (int w = 0; w < TIERS; w++) {
        for (int u = 0; u < TIERS; u++) {
            const choice c = {tier_bits[u], tier_bits[w]};
            const double error = rounding_error(c.bits_u, true) + rounding_error(c.bits_w, false);
            const double cost = energy * error + price * (double)component_bytes(a, c);
            if (cost < least && (!a->eight_only || (u == 0 && w == 0))) {
                least = cost;
                best = c;
            }
        }
    }
    return best;
}

/* Chooses the bits of each component at this price of a byte; returns the bytes of all components. */
static size_t allocate_at(const allocation *a, double price) {
    size_t bytes = 0;
    for (int p = 0; p < 3; p++) {
        for (size_t j = 0; j < a->rank[p]; j++) {
            a->chosen[p][j] = cheapest(a, a->energy[p][j], price);
            bytes += component_bytes(a, a->chosen[p][j]);
        }
    }
    return bytes;
}

/* The lowest price at which the components fit: the least error by Lagrange's multiplier (Shoham and Gersho
 * 1988). */
static void allocate(const allocation *a, size_t budget) {
    double low = 0, high = 1;
    for (int p = 0; p < 3; p++) {
        high += a->rank[p] > 0 ? a->energy[p][0] : 0; /* at this price no component is worth a byte */
    }
    if (allocate_at(a, low) <= budget) {
        return;
    }
    for (int i = 0; i < BISECTIONS; i++) {
        const double middle = low > 0 ? sqrt(low * high) : high * 1e-12;
        if (allocate_at(a, middle) <= budget) {
            high = middle;
        } else {
            low = middle;
        }
    }
    allocate_at(a, high);
}

/* --- rounding --- */

/* One axis of opponent colour while its factors are found. Factors are stored component by component, so that texels,
 * or columns, are contiguous. */
typedef struct axis {
    const enc_context *context;
    size_t texels, columns, views, lights, rank;
    const uint8_t *bits_u, *bits_w;
    float *samples;   /* [texel][column] */
    float *u, *w;     /* [rank][texel], [rank][column] */
    float *step_u;    /* [rank] of a level */
    float *step_w;    /* [rank] */
    float *view_step; /* [tier][view] that step_w is multiplied with */
    float *gram;      /* [rank][rank] of the factor that is held */
    float *product;   /* [rank][texel or column]: samples times that factor */
    float *packed;    /* the factor that is held, packed for products */
    enc_gemm_tile tile;
} axis;

static int tier_of(int bits) {
    return bits == 8 ? 0 : bits == 4 ? 1 : 2;
}

/* gram = f f^T for a factor f [rank][count]. */
static void find_gram(const axis *a, const float *f, size_t count, float *panels) {
    enc_gemm_pack_rows(a->rank, count, f, count, ENC_GEMM_M, a->packed);
#pragma omp parallel for schedule(dynamic) num_threads(a->context->threads)
    for (size_t j = 0; j < a->rank; j += ENC_GEMM_N) {
        const size_t n = a->rank - j < ENC_GEMM_N ? a->rank - j : ENC_GEMM_N;
        float *panel =
            panels + enc_thread_index() * LANES * (a->texels > a->columns ? a->texels : a->columns);
        enc_gemm_pack_rows(n, count, f + j * count, count, ENC_GEMM_N, panel);
        enc_gemm_multiply(a->tile, a->rank, n, count, a->packed, panel, a->gram + j, a->rank, 0);
    }
}

/* product [rank][texel] = w samples^T, or [rank][column] = u samples; `packed` holds the factor. */
static void find_product(const axis *a, bool of_texels, float *panels) {
    const size_t count = of_texels ? a->texels : a->columns, depth = of_texels ? a->columns : a->texels;
#pragma omp parallel for schedule(dynamic) num_threads(a->context->threads)
    for (size_t i = 0; i < count; i += LANES) {
        const size_t n = count - i < LANES ? count - i : LANES;
        float *panel =
            panels + enc_thread_index() * LANES * (a->texels > a->columns ? a->texels : a->columns);
        if (of_texels) {
            enc_gemm_pack_rows(n, depth, a->samples + i * depth, depth, ENC_GEMM_N, panel);
        } else {
            enc_gemm_pack_columns(n, depth, a->samples + i, count, ENC_GEMM_N, panel);
        }
        enc_gemm_multiply(a->tile, a->rank, n, depth, a->packed, panel, a->product + i, count, 0);
    }
}

/* The rounding of one component in the current lanes. */
typedef struct rounding {
    int bits; /* 0: values are not rounded */
    const float *step;
} rounding;

static inline float rounded(rounding r, size_t lane, float x) {
    if (r.bits == 0) {
        return x;
    }
    const float step = r.step[lane];
    return step > 0 ? step * nearest_level(r.bits, x / step) : 0.0f;
}

/* One sweep of coordinate descent: each component of x [rank][LANES] in turn goes to the level nearest to
 * its best value with the others held. r = product - gram x is kept up to date. */
static void sweep(const axis *a, size_t n, const rounding *how, float *x, float *r) {
    for (size_t j = 0; j < a->rank; j++) {
        const float *g = a->gram + j * a->rank;
        float delta[LANES], most = 0;
        for (size_t i = 0; i < n; i++) {
            const float old = x[j * LANES + i];
            const float best = g[j] > 0 ? old + r[j * LANES + i] / g[j] : 0.0f;
            x[j * LANES + i] = rounded(how[j], i, best);
            delta[i] = x[j * LANES + i] - old;
            most = fmaxf(most, fabsf(delta[i]));
        }
        for (size_t p = 0; most > 0 && p < a->rank; p++) {
            for (size_t i = 0; i < n; i++) {
                r[p * LANES + i] -= g[p] * delta[i];
            }
        }
    }
}

/* Refines the lanes first .. first + n - 1 of a factor f [rank][count]. work: rank * (2 LANES) floats. */
static void refine_lanes(const axis *a, size_t first, size_t n, size_t count, const rounding *how,
                         int sweeps, float *f, float *work) {
    float *x = work, *r = work + a->rank * LANES;
    for (size_t j = 0; j < a->rank; j++) {
        memcpy(x + j * LANES, f + j * count + first, n * sizeof *x);
        memcpy(r + j * LANES, a->product + j * count + first, n * sizeof *r);
    }
    for (size_t p = 0; p < a->rank; p++) {
        for (size_t j = 0; j < a->rank; j++) {
            const float g = a->gram[p * a->rank + j];
            for (size_t i = 0; i < n; i++) {
                r[p * LANES + i] -= g * x[j * LANES + i];
            }
        }
    }
    for (int s = 0; s < sweeps; s++) {
        sweep(a, n, how, x, r);
    }
    for (size_t j = 0; j < a->rank; j++) {
        memcpy(f + j * count + first, x + j * LANES, n * sizeof *x);
    }
}

/* Refines u by sweeps while w is fixed; with `round`, to levels. */
static void refine_u(const axis *a, int sweeps, bool round, float *panels, float *work) {
    find_gram(a, a->w, a->columns, panels);
    find_product(a, true, panels);
#pragma omp parallel for schedule(dynamic) num_threads(a->context->threads)
    for (size_t first = 0; first < a->texels; first += LANES) {
        const size_t n = a->texels - first < LANES ? a->texels - first : LANES;
        float *mine = work + enc_thread_index() * a->rank * (3 * LANES + 4);
        rounding *how = (rounding *)(void *)(mine + 3 * a->rank * LANES);
        float *steps = mine + 2 * a->rank * LANES;
        for (size_t j = 0; j < a->rank; j++) {
            for (size_t i = 0; i < n; i++) {
                steps[j * LANES + i] = a->step_u[j];
            }
            how[j] = (rounding){round ? a->bits_u[j] : 0, steps + j * LANES};
        }
        refine_lanes(a, first, n, a->texels, how, sweeps, a->u, mine);
    }
}

static float step_of_w(const axis *a, size_t j, size_t column) {
    return a->step_w[j] * a->view_step[(size_t)tier_of(a->bits_w[j]) * a->views + column / a->lights];
}

static void refine_w(const axis *a, int sweeps, float *panels, float *work) {
    find_gram(a, a->u, a->texels, panels);
    find_product(a, false, panels);
#pragma omp parallel for schedule(dynamic) num_threads(a->context->threads)
    for (size_t first = 0; first < a->columns; first += LANES) {
        const size_t n = a->columns - first < LANES ? a->columns - first : LANES;
        float *mine = work + enc_thread_index() * a->rank * (3 * LANES + 4);
        rounding *how = (rounding *)(void *)(mine + 3 * a->rank * LANES);
        float *steps = mine + 2 * a->rank * LANES;
        for (size_t j = 0; j < a->rank; j++) {
            for (size_t i = 0; i < n; i++) {
                steps[j * LANES + i] = step_of_w(a, j, first + i);
            }
            how[j] = (rounding){a->bits_w[j], steps + j * LANES};
        }
        refine_lanes(a, first, n, a->columns, how, sweeps, a->w, mine);
    }
}

/* The step whose levels leave the least squared error over values that were divided by `divisor` (NULL: 1) and count
 * with its square. Tried are the step that puts the largest value at the top level, and smaller ones that clip it. */
static float best_step(int bits, size_t count, const float *x, const float *divisor, size_t run) {
    static const float parts[] = {1, 0.85f, 0.7f, 0.6f, 0.5f, 0.42f, 0.35f, 0.28f, 0.22f};
    float most = 0, best = 0;
    double least = HUGE_VAL;
    for (size_t i = 0; i < count; i++) {
        most = fmaxf(most, fabsf(x[i]) / (divisor ? divisor[i / run] : 1));
    }
    for (size_t p = 0; most > 0 && p < sizeof parts / sizeof *parts; p++) {
        const float step = parts[p] * most / top_level(bits);
        double error = 0;
        for (size_t i = 0; i < count; i++) {
            const float d = divisor ? divisor[i / run] : 1;
            const float e = x[i] - d * step * nearest_level(bits, x[i] / (d * step));
            error += (double)e * e;
        }
        if (error < least) {
            least = error;
            best = step;
        }
    }
    return best;
}

/* A view's factor for the w of one number of bits: how far its values are from the rms of their components,
 * as a power of 2^(1/16), which a byte holds. */
static void find_view_steps(const axis *a) {
    for (int t = 0; t < TIERS; t++) {
        for (size_t v = 0; v < a->views; v++) {
            double sum = 0;
            size_t count = 0;
            for (size_t j = 0; j < a->rank; j++) {
                double all = 0, mine = 0;
                const float *w = a->w + j * a->columns;
                for (size_t i = 0; i < a->columns && tier_of(a->bits_w[j]) == t; i++) {
                    const double square = (double)w[i] * w[i];
                    all += square;
                    mine += i / a->lights == v ? square : 0;
                }
                if (all > 0) {
                    sum += mine * (double)a->views / all;
                    count++;
                }
            }
            const double factor = count > 0 && sum > 0 ? log2(sqrt(sum / (double)count)) : 0;
            a->view_step[(size_t)t * a->views + v] = (float)exp2(rint(16 * fmin(fmax(factor, -7), 7)) / 16);
        }
    }
}

static void round_w(const axis *a) {
    find_view_steps(a);
#pragma omp parallel for schedule(dynamic) num_threads(a->context->threads)
    for (size_t j = 0; j < a->rank; j++) {
        float *w = a->w + j * a->columns;
        const int bits = a->bits_w[j];
        a->step_w[j] =
            best_step(bits, a->columns, w, a->view_step + (size_t)tier_of(bits) * a->views, a->lights);
        for (size_t i = 0; i < a->columns; i++) {
            const float step = step_of_w(a, j, i);
            w[i] = step > 0 ? step * nearest_level(bits, w[i] / step) : 0.0f;
        }
    }
}

static void find_steps_u(const axis *a) {
#pragma omp parallel for schedule(dynamic) num_threads(a->context->threads)
    for (size_t j = 0; j < a->rank; j++) {
        a->step_u[j] = best_step(a->bits_u[j], a->texels, a->u + j * a->texels, NULL, 1);
    }
}

static btf_result round_axis(const axis *a, int sweeps, float *panels, float *work) {
    round_w(a);
    refine_u(a, REFIT_SWEEPS, false, panels, work);
    find_steps_u(a);
    refine_u(a, 1, true, panels, work);
    for (int s = 0; s < sweeps; s++) {
        if (enc_cancelled(a->context)) {
            return BTF_ERROR_INTERRUPTED;
        }
        refine_w(a, 1, panels, work);
        refine_u(a, 1, true, panels, work);
    }
    return BTF_OK;
}

/* The samples of one axis, [texel][column]. */
static void load_samples(const enc_context *context, const enc_data *data, pca_plane plane, float *out) {
    const size_t stride = enc_data_texel_stride(data), texels = enc_data_texel_count(data);
#pragma omp parallel for num_threads(context->threads)
    for (size_t t = 0; t < texels; t++) {
        pca_encode_samples(data, PCA_SQRT, plane, data->samples + t * stride, out + t * (stride / 3));
    }
}

/* Copies the chosen components of an axis into the codec, unrounded, scaled so that u and w have equal power. */
static bool take_components(const pca_factors *f, const double *energy, const choice *chosen,
                            lowbit_plane *out) {
    for (size_t j = 0; j < f->rank; j++) {
        out->rank += chosen[j].bits_u > 0;
    }
    out->bits_u = malloc(out->rank + 1);
    out->bits_w = malloc(out->rank + 1);
    out->u = enc_gemm_alloc((out->rank + 1) * f->texels);
    out->w = enc_gemm_alloc((out->rank + 1) * f->columns);
    if (!out->bits_u || !out->bits_w || !out->u || !out->w) {
        return false;
    }
    size_t k = 0;
    for (size_t j = 0; j < f->rank; j++) {
        if (chosen[j].bits_u == 0) {
            continue;
        }
        const float power = (float)pow(energy[j], 0.25); /* the root of the singular value */
        out->bits_u[k] = chosen[j].bits_u;
        out->bits_w[k] = chosen[j].bits_w;
        for (size_t i = 0; i < f->texels; i++) {
            out->u[k * f->texels + i] = f->u[i * f->rank + j] / power;
        }
        for (size_t i = 0; i < f->columns; i++) {
            out->w[k * f->columns + i] = f->v[j * f->columns + i] * power;
        }
        k++;
    }
    return true;
}

static btf_result encode_axis(const enc_context *context, const enc_data *data, pca_plane plane, int sweeps,
                              lowbit_plane *out) {
    const size_t texels = enc_data_texel_count(data), columns = enc_data_texel_stride(data) / 3;
    const size_t longest = texels > columns ? texels : columns, rank = out->rank,
                 threads = (size_t)context->threads;
    axis a = {.context = context,
              .texels = texels,
              .columns = columns,
              .views = (size_t)data->n_views,
              .lights = (size_t)data->n_lights,
              .rank = rank,
              .bits_u = out->bits_u,
              .bits_w = out->bits_w,
              .samples = enc_gemm_alloc(texels * columns),
              .u = out->u,
              .w = out->w,
              .step_u = enc_gemm_alloc(rank),
              .step_w = enc_gemm_alloc(rank),
              .view_step = enc_gemm_alloc(TIERS * (size_t)data->n_views),
              .gram = enc_gemm_alloc(rank * rank),
              .product = enc_gemm_alloc(rank * longest),
              .packed = enc_gemm_alloc((rank + ENC_GEMM_M) * longest),
              .tile = enc_gemm_select()};
    float *panels = enc_gemm_alloc(threads * LANES * longest);
    float *work = enc_gemm_alloc(threads * rank * (3 * LANES + 4));
    btf_result result = BTF_ERROR_MEMORY;
    if (a.samples && a.step_u && a.step_w && a.view_step && a.gram && a.product && a.packed && panels &&
        work) {
        load_samples(context, data, plane, a.samples);
        result = round_axis(&a, sweeps, panels, work);
    } else {
        enc_fail(context, result, "low-bit PCA: out of memory for %zu components", rank);
    }
    free(a.samples);
    free(a.step_u);
    free(a.step_w);
    free(a.view_step);
    free(a.gram);
    free(a.product);
    free(a.packed);
    free(panels);
    free(work);
    return result;
}

/* The bytes of the views' factors: an axis has a set for each number of bits that its w uses. */
static size_t view_bytes(const lowbit_codec *codec) {
    size_t bytes = 0;
    for (int p = 0; p < 3; p++) {
        bool has[TIERS] = {false};
        for (size_t j = 0; j < codec->plane[p].rank; j++) {
            has[tier_of(codec->plane[p].bits_w[j])] = true;
        }
        for (int t = 0; t < TIERS; t++) {
            bytes += has[t] ? VIEW_BYTES * (size_t)codec->data->n_views : 0;
        }
    }
    return bytes;
}

/* Energies of components: squared norms of their columns of u. */
static double *energies(const pca_factors *f) {
    double *energy = calloc(f->rank + 1, sizeof *energy);
    for (size_t i = 0; energy && i < f->texels; i++) {
        for (size_t j = 0; j < f->rank; j++) {
            energy[j] += (double)f->u[i * f->rank + j] * f->u[i * f->rank + j];
        }
    }
    return energy;
}

static btf_result encode_planes(const enc_context *context, const enc_data *data,
                                const pca_factors *factors, const lowbit_options *options,
                                lowbit_codec *codec) {
    const size_t all_views = 3 * TIERS * VIEW_BYTES * (size_t)data->n_views;
    allocation a = {
        .texels = factors[0].texels, .columns = factors[0].columns, .eight_only = options->eight_only};
    double *energy[3];
    bool room = true;
    for (int p = 0; p < 3; p++) {
        a.rank[p] = factors[p].rank;
        a.energy[p] = energy[p] = energies(&factors[p]);
        a.chosen[p] = calloc(factors[p].rank + 1, sizeof(choice));
        room = room && energy[p] && a.chosen[p];
    }
    if (room) {
        allocate(&a, options->budget > all_views ? options->budget - all_views : 0);
    }
    size_t rank = 0;
    for (int p = 0; p < 3 && room; p++) {
        room = take_components(&factors[p], energy[p], a.chosen[p], &codec->plane[p]);
        for (size_t j = 0; j < a.rank[p]; j++) {
            codec->bytes += component_bytes(&a, a.chosen[p][j]);
        }
        rank += codec->plane[p].rank;
    }
    for (int p = 0; p < 3; p++) {
        free(energy[p]);
        free(a.chosen[p]);
    }
    if (!room) {
        return enc_fail(context, BTF_ERROR_MEMORY, "low-bit PCA: out of memory");
    }
    if (rank == 0) {
        return enc_fail(context, BTF_ERROR_USAGE, "low-bit PCA: %zu bytes are too few for one component",
                        options->budget);
    }
    codec->bytes += view_bytes(codec);
    btf_result result = BTF_OK;
    for (int p = 0; p < 3 && result == BTF_OK; p++) {
        if (codec->plane[p].rank > 0) {
            result = encode_axis(context, data, (pca_plane)p, options->sweeps, &codec->plane[p]);
        }
    }
    return result;
}

/* The most components that could be worth computing: as many as the budget holds in the fewest bits. */
static size_t most_rank(const enc_data *data, const lowbit_options *options) {
    const size_t texels = enc_data_texel_count(data), columns = enc_data_texel_stride(data) / 3;
    const size_t each = (texels + columns) * (options->eight_only ? 8 : 2) / 8 + 2 * SCALE_BYTES;
    const size_t rank = options->budget / each + 1;
    return rank < LOWBIT_MOST_RANK ? rank : LOWBIT_MOST_RANK;
}

btf_result lowbit_encode(const enc_context *context, const enc_data *data, const lowbit_options *options,
                         lowbit_codec *out_codec) {
    pca_factors factors[3] = {{0}};
    btf_result result = BTF_OK;
    *out_codec = (lowbit_codec){.data = data};
    if (!data->samples) {
        return enc_fail(context, BTF_ERROR_MEMORY, "low-bit PCA needs all samples in memory");
    }
    for (int p = 0; p < 3 && result == BTF_OK; p++) {
        /* colour differences have a tenth of the components of brightness, and never half of them */
        const size_t rank = (most_rank(data, options) + (p > 0)) / (p > 0 ? 2 : 1);
        result = pca_factorise_plane(context, data, (pca_plane)p, PCA_SQRT, rank, &factors[p]);
    }
    if (result == BTF_OK) {
        result = encode_planes(context, data, factors, options, out_codec);
    }
    for (int p = 0; p < 3; p++) {
        pca_factors_clear(&factors[p]);
    }
    if (result != BTF_OK) {
        lowbit_codec_clear(out_codec);
    }
    return result;
}

void lowbit_codec_clear(lowbit_codec *codec) {
    for (int p = 0; p < 3; p++) {
        free(codec->plane[p].bits_u);
        free(codec->plane[p].bits_w);
        free(codec->plane[p].u);
        free(codec->plane[p].w);
    }
    *codec = (lowbit_codec){0};
}

size_t lowbit_rank(const lowbit_codec *codec, pca_plane plane) {
    return plane != PCA_RGB ? codec->plane[plane].rank
                            : codec->plane[0].rank + codec->plane[1].rank + codec->plane[2].rank;
}

/* --- decoding --- */

/* Composes out [light][texel][3] from the three axes of a view, each [texel][light]. */
static void compose(size_t texels, size_t lights, float *const axes[3], float *out) {
    for (size_t t = 0; t < texels; t++) {
        for (size_t l = 0; l < lights; l++) {
            for (int c = 0; c < 3; c++) {
                float y = 0;
                for (int p = 0; p < 3; p++) {
                    y += pca_axes[p][c] * axes[p][t * lights + l];
                }
                out[(l * texels + t) * 3 + (size_t)c] = y > 0 ? y * y : 0;
            }
        }
    }
}

static btf_result decode_view(const void *user, int view, float *out) {
    const lowbit_codec *codec = user;
    const size_t lights = (size_t)codec->data->n_lights, texels = enc_data_texel_count(codec->data);
    const size_t columns = lights * (size_t)codec->data->n_views;
    const size_t panels = enc_gemm_panels(lights, ENC_GEMM_N), most = lowbit_rank(codec, PCA_RGB);
    float *axes[3] = {enc_gemm_alloc(texels * lights), enc_gemm_alloc(texels * lights),
                      enc_gemm_alloc(texels * lights)};
    float *left = enc_gemm_alloc(ENC_GEMM_M * most), *right = enc_gemm_alloc(panels * ENC_GEMM_N * most);
    const bool room = axes[0] && axes[1] && axes[2] && left && right;
    for (int p = 0; p < 3 && room; p++) {
        const lowbit_plane *plane = &codec->plane[p];
        enc_gemm_pack_columns(lights, plane->rank, plane->w + (size_t)view * lights, columns, ENC_GEMM_N,
                              right);
        for (size_t t = 0; t < texels; t += ENC_GEMM_M) {
            const size_t count = texels - t < ENC_GEMM_M ? texels - t : ENC_GEMM_M;
            enc_gemm_pack_columns(count, plane->rank, plane->u + t, texels, ENC_GEMM_M, left);
            enc_gemm_multiply(enc_gemm_select(), count, lights, plane->rank, left, right,
                              axes[p] + t * lights, lights, 0);
        }
    }
    if (room) {
        compose(texels, lights, axes, out);
    }
    for (int p = 0; p < 3; p++) {
        free(axes[p]);
    }
    free(left);
    free(right);
    return room ? BTF_OK : BTF_ERROR_MEMORY;
}

enc_image_source lowbit_images(const lowbit_codec *codec) {
    return (enc_image_source){decode_view, codec};
}
