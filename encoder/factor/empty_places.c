/* Greedy components of the rounding error. See empty_places.h.
 *
 * The difference of components and codes is a sum of few products, so that its leading component takes two
 * products with vectors a step of power iteration, in double: it is 2^-8 of the values, then 2^-16.
 *
 * SPDX-License-Identifier: MIT
 */
#include "empty_places.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { STEPS = 8, SPREADS = 6 /* ways to share levels between u and w */ };

/* Share of a channel's first component below which the codes are as exact as the components themselves. */
static const double exact = 1e-13;

/* The root of the product of both steps of a new word: the product, times an axis of matrix.h, is a scale, and files hold
 * none below 2^-24. */
static const double least_step = 0x1p-11;

typedef struct filler {
    const enc_components *from;
    enc_factor_channel *to;
    size_t texels, columns;
    float *factor;       /* [column] of its view */
    double *u, *w;       /* [texel], [column] in and out of a product with the difference */
    double *leading;     /* [texel] u of the leading component, of length 1 */
    float *tried, *best; /* u, then w, in levels times steps */
} filler;

static void filler_clear(filler *f) {
    free(f->factor);
    free(f->u);
    free(f->w);
    free(f->leading);
    free(f->tried);
    free(f->best);
}

static bool filler_make(const enc_components *from, enc_factor_codes *codes, int channel, filler *out) {
    const size_t texels = codes->texels, columns = codes->columns;
    *out = (filler){.from = from,
                    .to = &codes->channel[channel],
                    .texels = texels,
                    .columns = columns,
                    .factor = malloc(columns * sizeof(float)),
                    .u = malloc(texels * sizeof(double)),
                    .w = malloc(columns * sizeof(double)),
                    .leading = malloc(texels * sizeof(double)),
                    .tried = malloc((texels + columns) * sizeof(float)),
                    .best = malloc((texels + columns) * sizeof(float))};
    for (size_t i = 0; i < columns && out->factor; i++) {
        out->factor[i] = enc_factor_view(codes, i / codes->lights, enc_factor_classes[0].tier, channel);
    }
    return out->factor && out->u && out->w && out->leading && out->tried && out->best;
}

/* io [count] += sign * sum over j of q_j (p_j . x) of p [n][depth] and q [n][count]. */
static void add_product(size_t n, size_t depth, const float *p, const double *x, size_t count, const float *q, double sign,
                        double *io) {
    for (size_t j = 0; j < n; j++) {
        double along = 0;
        for (size_t i = 0; i < depth; i++) {
            along += (double)p[j * depth + i] * x[i];
        }
        for (size_t i = 0; i < count && along != 0; i++) {
            io[i] += sign * along * (double)q[j * count + i];
        }
    }
}

/* f->w = u E, or f->u = E w, of the difference E. */
static void multiply(const filler *f, bool to_w) {
    const size_t depth = to_w ? f->texels : f->columns, count = to_w ? f->columns : f->texels;
    const double *x = to_w ? f->u : f->w;
    double *out = to_w ? f->w : f->u;
    memset(out, 0, count * sizeof *out);
    add_product(f->from->rank, depth, to_w ? f->from->u : f->from->w, x, count, to_w ? f->from->w : f->from->u, 1, out);
    add_product(f->to->rank, depth, to_w ? f->to->u : f->to->w, x, count, to_w ? f->to->w : f->to->u, -1, out);
}

static double square(size_t n, const double *x) {
    double sum = 0;
    for (size_t i = 0; i < n; i++) {
        sum += x[i] * x[i];
    }
    return sum;
}

/* Finds f->leading, and f->w that goes with it; returns their energy. */
static double find_leading(const filler *f) {
    uint32_t state = 1;
    for (size_t i = 0; i < f->texels; i++) {
        state = state * 1664525u + 1013904223u;
        f->u[i] = 1 + ldexp((double)(state >> 8), -24); /* not at right angles to what is all of one sign */
    }
    for (int step = 0; step < STEPS; step++) {
        const double length = sqrt(square(f->texels, f->u));
        for (size_t i = 0; i < f->texels && length > 0; i++) {
            f->u[i] /= length;
        }
        multiply(f, true);
        memcpy(f->leading, f->u, f->texels * sizeof *f->u);
        if (step + 1 < STEPS) {
            multiply(f, false);
        }
    }
    return square(f->columns, f->w);
}

static float round_to(float step, double x) {
    return step > 0 ? step * (float)fmin(fmax(rint(x / (double)step), -127), 127) : 0.0f;
}

/* Rounds f->leading times `by`, then the w that fits it best, into f->tried; returns what the squared error loses. */
static double try_levels(const filler *f, double by, float step_u, float step_w) {
    float *w = f->tried + f->texels;
    double gain = 0;
    for (size_t i = 0; i < f->texels; i++) {
        f->tried[i] = round_to(step_u, by * f->leading[i]);
        f->u[i] = (double)f->tried[i];
    }
    const double length = square(f->texels, f->u);
    multiply(f, true);
    for (size_t i = 0; i < f->columns; i++) {
        w[i] = length > 0 ? round_to(step_w * f->factor[i], f->w[i] / length) : 0.0f;
        gain += (double)w[i] * (2 * f->w[i] - length * (double)w[i]);
    }
    return gain;
}

/* Writes the leading component to place j in steps of its group, or where these are 0, in such as suit it. */
static void fill_place(const filler *f, size_t j, float *io_step_u, float *io_step_w) {
    double most_u = 0, most_w = 0, most = 0;
    for (size_t i = 0; i < f->texels; i++) {
        most_u = fmax(most_u, fabs(f->leading[i]));
    }
    for (size_t i = 0; i < f->columns; i++) {
        most_w = fmax(most_w, f->factor[i] > 0 ? fabs(f->w[i]) / (double)f->factor[i] : 0);
    }
    if (!(most_u > 0 && most_w > 0)) { /* the views that are left have a factor of 0 */
        return;
    }
    if (!(*io_step_u > 0 && *io_step_w > 0)) {
        const double step = fmax(sqrt(most_u * most_w) / 127, least_step), balance = sqrt(most_w / most_u);
        *io_step_u = (float)(step * balance);
        *io_step_w = (float)(step / balance);
    }
    /* The largest product, in levels of both. Where u is the same everywhere, few levels do for it, and leave more to
     * w; else as many do as are there. */
    const double all = most_u * most_w / ((double)*io_step_u * (double)*io_step_w);
    const double fewest = fmin(fmax(ceil(all / 127), 1), 127), greatest = fmin(fmax(all, fewest), 127);
    for (int i = 0; i < SPREADS; i++) {
        const double levels = fewest * pow(greatest / fewest, (double)i / (SPREADS - 1));
        const double gain = try_levels(f, levels * (double)*io_step_u / most_u, *io_step_u, *io_step_w);
        if (gain > most) {
            most = gain;
            memcpy(f->best, f->tried, (f->texels + f->columns) * sizeof *f->best);
        }
    }
    if (most > 0) {
        memcpy(f->to->u + j * f->texels, f->best, f->texels * sizeof *f->best);
        memcpy(f->to->w + j * f->columns, f->best + f->texels, f->columns * sizeof *f->best);
    }
}

/* Fills the places first .. end - 1 of a group in turn. */
static void fill_group(const filler *f, size_t first, size_t end) {
    enc_factor_channel *to = f->to;
    for (size_t j = first; j < end && find_leading(f) > exact * f->from->energy[0]; j++) {
        fill_place(f, j, &to->step_u[j], &to->step_w[j]);
        for (size_t i = j + 1; i < end; i++) {
            to->step_u[i] = to->step_u[j];
            to->step_w[i] = to->step_w[j];
        }
    }
}

btf_result enc_factor_fill_places(const enc_factor_matrix *m, const enc_components components[ENC_FACTOR_CHANNELS],
                                  enc_factor_codes *codes) {
    bool room = true;
    for (int c = 0; c < ENC_FACTOR_CHANNELS && room; c++) {
        const size_t word = enc_factor_classes[0].word, held = codes->channel[c].rank;
        const size_t places = codes->plan.words[0][c] * word, whole = (held + word - 1) / word * word;
        filler f = {0};
        if (held == 0 || held >= places) {
            continue;
        }
        room = filler_make(&components[c], codes, c, &f) && enc_factor_codes_extend(codes, c);
        for (size_t first = whole; first < places && room; first += word) {
            fill_group(&f, first, first + word);
        }
        if (room) {
            fill_group(&f, held, whole);
        }
        filler_clear(&f);
    }
    return room ? BTF_OK : enc_fail(m->context, BTF_ERROR_MEMORY, "factors: out of memory");
}
