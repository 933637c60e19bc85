/* Small BTFs made from formulas, and measures that the stability tests share.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_STABILITY_HARD_DATA_H
#define OPENBTF_TESTS_STABILITY_HARD_DATA_H

#include "encoder/data/data.h"
#include "encoder/model/sbrdf.h"

enum { HARD_MAX_DIRECTIONS = 64 };

/* A list of directions in paper order: the pole, then rings. */
typedef struct hard_directions {
    int n;
    enc_direction list[HARD_MAX_DIRECTIONS];
} hard_directions;

/* Rings at theta[i] degrees with count[i] directions each. */
hard_directions hard_rings(int rings, const double *theta, const int *count);
/* 0, 30, 60 degrees with 1, 6, 6 azimuths. */
hard_directions hard_thirteen(void);
/* 0, 25, 50, 75 degrees with 1, 6, 8, 10 azimuths. */
hard_directions hard_twentyfive(void);

/* The value of one sample: out_rgb is zero on entry. */
typedef void (*hard_value_fn)(const void *user, int texel, const enc_direction *view,
                              const enc_direction *light, int sample, float out_rgb[3]);

/* Black; one value (user: a float); noise from 0 up to a value (user: a float, NULL: 1); values from 1e-8 to 1e6 with
 * evenly spread logarithms. */
void hard_black(const void *user, int texel, const enc_direction *view, const enc_direction *light,
                int sample, float out_rgb[3]);
void hard_constant(const void *user, int texel, const enc_direction *view, const enc_direction *light,
                   int sample, float out_rgb[3]);
void hard_noise(const void *user, int texel, const enc_direction *view, const enc_direction *light,
                int sample, float out_rgb[3]);
void hard_spread(const void *user, int texel, const enc_direction *view, const enc_direction *light,
                 int sample, float out_rgb[3]);

/* A BTF in memory; exits on failure. `sample` counts view * lights + light. */
enc_data *hard_create(int width, int height, const hard_directions *views, const hard_directions *lights,
                      hard_value_fn value, const void *user);

/* A ray-cast relief (tests/sample), side x side texels, every sample times `scale`; exits on failure. */
enc_data *hard_relief(int side, const hard_directions *views, const hard_directions *lights, float scale);

/* A copy with samples in other places: for sample (texel, view, light) of the copy, `from` changes the three numbers to
 * those of the original. Directions stay, or are those of `views` and `lights`. */
enc_data *hard_moved(const enc_data *data, const enc_direction *views, const enc_direction *lights,
                     void (*from)(const void *user, int *texel, int *view, int *light), const void *user);

/* A number in [0, 1) from three integers, the same everywhere. */
float hard_random(uint32_t a, uint32_t b, uint32_t c);

/* The value of a Lafortune model in double, with libm's pow; linear domain, cosine included. Layout of
 * sbrdf.h. */
double hard_model(const float *parameters, int lobes, bool rgb, bool square_root, const enc_direction *view,
                  const enc_direction *light, int channel);

static inline float *hard_sample(const enc_data *data, size_t texel, int view, int channel, int light) {
    return data->samples +
           ((texel * (size_t)data->n_views + (size_t)view) * 3 + (size_t)channel) * (size_t)data->n_lights +
           light;
}

/* PSNR in dB, peak `peak`, of an error sum over `count` samples; 200 for an error of zero. */
double hard_psnr(double squares, double count, double peak);

#endif
