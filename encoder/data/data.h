/* A BTF as the analysis sees it: linear radiance samples in texel-major order.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_DATA_H
#define OPENBTF_ENCODER_DATA_H

#include "encoder/base/context.h"
#include <stdint.h>

enum { ENC_MAX_DIRECTIONS = 256 }; /* views, or lights, of a data set */

/* A sampled direction in the tangent frame of FORMAT.md: x along +u, y along +v, z the normal.
 * theta from z, phi from x towards y, both in degrees; xyz the unit vector rounded to float. */
typedef struct enc_direction {
    double theta, phi;
    float xyz[3];
} enc_direction;

/* Fills xyz from theta and phi. */
enc_direction enc_direction_from_angles(double theta_degrees, double phi_degrees);

/* Where the light stood whose nominal direction is that of a view, since the camera was in its way
 * (coincident.h). */
typedef struct enc_moved_light {
    int index; /* of the light; -1: it stood where it should */
    enc_direction actual;
} enc_moved_light;

/* A coded BTF that makes its samples when asked for. Functions are thread-safe and give the same bits
 * whatever the block. Errors: BTF_ERROR_BAD_FILE (a sample that is no number), BTF_ERROR_MEMORY. */
typedef struct enc_data_origin enc_data_origin;
struct enc_data_origin {
    /* Samples of texels first .. first+count-1, in the order of enc_data. */
    btf_result (*texels)(const enc_context *context, const enc_data_origin *origin, size_t first,
                         size_t count, float *out_samples);
    /* Their light profiles in one view: out[texel][channel][light]. */
    btf_result (*profiles)(const enc_context *context, const enc_data_origin *origin, int view,
                           size_t first, size_t count, float *out_profiles);
    void (*close)(enc_data_origin *origin);
    double seconds; /* predicted core seconds a sample, set by who makes the origin */
};

/* One BTF. Samples are float32, linear Rec. 709 radiance over (normal-incidence irradiance / pi),
 * cosine included: a white Lambertian lit from l holds l.z.
 *
 * Sample order, innermost last: [texel][view][channel][light], texel = row * width + column, row 0 at the
 * top of the image (+v), channel 0..2 = R, G, B. So the light profile of (texel, view) is 3 * n_lights
 * contiguous floats, and all samples of a texel are n_views * 3 * n_lights.
 *
 * Directions are in paper order: theta ascending, then phi ascending from 0. Both lists hold up to
 * ENC_MAX_DIRECTIONS, need not be equal, and have no duplicates. */
typedef struct enc_data {
    int width, height;
    int n_views, n_lights;
    enc_direction *views;  /* [n_views] */
    enc_direction *lights; /* [n_lights] */
    int top_view;          /* index of the view nearest to the pole */
    float *samples; /* all samples; NULL when they lie in the scratch file or are made when asked for */
    size_t mapped; /* bytes of samples that are a view of the scratch file, not to be written to; 0: none */
    int scratch_fd;               /* -1 without a scratch file */
    char *scratch_path;           /* of one that ranks share, where it has a name; else NULL */
    enc_data_origin *origin;      /* makes samples when asked for; NULL: they are stored */
    enc_moved_light *moved_light; /* [n_views], or NULL: every light stood where it should (coincident.h) */
    uint64_t negative;            /* samples clamped to 0 on reading */
    const struct enc_data *original; /* of fitted values (nodes/apply.h): the samples that errors are
                                        measured against; NULL: these themselves */
    char *source;                 /* the input, for messages and reports */
} enc_data;

static inline size_t enc_data_texel_count(const enc_data *data) {
    return (size_t)data->width * (size_t)data->height;
}
/* Where the light of a sample stood: what a model is fitted with. Decoders use the nominal directions. */
static inline const enc_direction *enc_data_light(const enc_data *data, size_t view, size_t light) {
    const enc_moved_light *moved = data->moved_light ? &data->moved_light[view] : NULL;
    return moved && moved->index == (int)light ? &moved->actual : &data->lights[light];
}
/* Floats of one texel. */
static inline size_t enc_data_texel_stride(const enc_data *data) {
    return (size_t)data->n_views * 3 * (size_t)data->n_lights;
}

/* Makes a BTF of zeros with copies of the direction lists. Samples are held in memory when they fit half of
 * context->memory (0: always), else in an unlinked scratch file in $TMPDIR (default /var/tmp), whose size
 * is announced and checked against free space first. The ranks share one scratch file instead; each stores
 * a part of the samples, and then all meet in enc_data_complete. Errors: BTF_ERROR_USAGE (sizes; more than
 * context->memory, by context->least_memory), BTF_ERROR_MEMORY, BTF_ERROR_IO (scratch file, free space). */
btf_result enc_data_create(const enc_context *context, int width, int height, int n_views,
                           const enc_direction *views, int n_lights, const enc_direction *lights,
                           enc_data **out_data);
/* Makes a BTF whose samples come from an origin, which then belongs to the BTF (which closes it, also on
 * error). Where all samples fit half of context->memory (0: always), they are made here, once, with all
 * threads, and kept in memory, or by several ranks in a scratch file that they share; else they are made
 * whenever they are asked for, and no scratch file is written. */
btf_result enc_data_create_from(const enc_context *context, int width, int height, int n_views,
                                const enc_direction *views, int n_lights, const enc_direction *lights,
                                enc_data_origin *origin, enc_data **out_data);
/* To be called once all samples are stored. Returns `result`, or the error of sharing them with the other ranks.
 * Samples that fit half of context->memory are then in memory for all ranks of a machine together. Errors:
 * `result`, BTF_ERROR_IO. */
btf_result enc_data_complete(const enc_context *context, enc_data *data, btf_result result);
/* Copies the moved lights of `from` to `to`, which has the same directions. Errors: BTF_ERROR_MEMORY. */
btf_result enc_data_copy_lights(const enc_data *from, enc_data *to);
void enc_data_destroy(enc_data **data);

/* Whether samples of this size may lie in memory: they fit half of context->memory (0: always), and leave
 * what the encode takes at the least. */
bool enc_data_fits(const enc_context *context, int width, int height, int n_views, int n_lights);

/* The samples of texels first .. first+count-1. Points into data->samples when they are in memory; else
 * reads or makes them into `buffer` (count * enc_data_texel_stride floats) and points there.
 * Thread-safe. Errors: BTF_ERROR_IO. */
btf_result enc_data_texels(const enc_context *context, const enc_data *data, size_t first, size_t count,
                           float *buffer, const float **out_samples);

/* Gathers every image of one view: out[light][texel][channel], n_lights * texels * 3 floats.
 * Thread-safe. Errors: BTF_ERROR_IO. */
btf_result enc_data_view(const enc_context *context, const enc_data *data, int view, float *out);

/* Stores all samples of texels first .. first+count-1, in the order above. Concurrent calls must not
 * overlap. Errors: BTF_ERROR_IO. */
btf_result enc_data_store_texels(const enc_context *context, enc_data *data, size_t first, size_t count,
                                 const float *samples);

/* Stores `count` floats of one texel, from position `at` of its [view][channel][light] samples on.
 * Concurrent calls must not overlap. Errors: BTF_ERROR_IO. */
btf_result enc_data_store_run(const enc_context *context, enc_data *data, size_t texel, size_t at,
                              size_t count, const float *samples);

/* Rec. 709 luminance, which thresholds on a value are compared with. */
static inline float enc_luminance(float r, float g, float b) {
    return 0.2126f * r + 0.7152f * g + 0.0722f * b;
}

#endif
