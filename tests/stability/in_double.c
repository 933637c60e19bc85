/* The functions that the stages in double call in place of the functions of floats, and the entry points of these
 * stages (precision_double.h). Compiled as they are: every float below is a double.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/paper/fit.h"
#include "encoder/lafortune/gram.h"
#include "encoder/paper/flow.h"
#include "precision_double.h"

static const enc_context one_thread = {.threads = 1};

/* ---- the data ---- */

const double_direction *double_light(const enc_data *data, size_t view, size_t light) {
    static double_direction direction;
    (void)view;
    for (int k = 0; k < 3; k++) {
        direction.xyz[k] = data->lights[light].xyz[k];
    }
    return &direction;
}

double double_luminance(double r, double g, double b) {
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

btf_result double_texels(const enc_context *context, const enc_data *data, size_t first, size_t count,
                         double *buffer, const double **out_samples) {
    enum { MOST = 16 * 25 * 25 * 3 };
    static double samples[MOST];
    const size_t stride = enc_data_texel_stride(data);
    (void)context, (void)buffer;
    if (count * stride > MOST) {
        return BTF_ERROR_MEMORY;
    }
    for (size_t i = 0; i < count * stride; i++) {
        samples[i] = data->samples[first * stride + i];
    }
    *out_samples = samples;
    return BTF_OK;
}

btf_result double_view(const enc_context *context, const enc_data *data, int view, double *out) {
    const size_t texels = enc_data_texel_count(data), lights = (size_t)data->n_lights;
    (void)context;
    for (size_t i = 0; i < lights * texels * 3; i++) {
        const size_t l = i / (3 * texels), t = i / 3 % texels, c = i % 3;
        out[i] = data->samples[((t * (size_t)data->n_views + (size_t)view) * 3 + c) * lights + l];
    }
    return BTF_OK;
}

/* ---- the fit ---- */

btf_result enc_sbrdf_create(size_t n_texels, int lobes, bool rgb, enc_sbrdf **out_sbrdf) {
    enc_sbrdf *sbrdf = malloc(sizeof *sbrdf);
    double *values = calloc(n_texels * enc_sbrdf_stride(lobes, rgb), sizeof *values);
    if (sbrdf == NULL || values == NULL) {
        free(sbrdf);
        free(values);
        return BTF_ERROR_MEMORY;
    }
    *sbrdf = (enc_sbrdf){n_texels, lobes, rgb, values};
    *out_sbrdf = sbrdf;
    return BTF_OK;
}

void enc_sbrdf_destroy(enc_sbrdf **sbrdf) {
    if (*sbrdf != NULL) {
        free((*sbrdf)->values);
        free(*sbrdf);
        *sbrdf = NULL;
    }
}

void enc_sbrdf_evaluate(const enc_sbrdf *sbrdf, size_t texel, const double view[3], int n,
                        const double *light_x, const double *light_y, const double *light_z, double *out) {
    const double *p = sbrdf->values + texel * enc_sbrdf_stride(sbrdf->lobes, sbrdf->rgb);
    const double *shapes = p + (sbrdf->rgb ? 3 + 3 * sbrdf->lobes : 4);
    for (int i = 0; i < 3 * n; i++) {
        const int c = i / n, s = i % n;
        double sum = p[sbrdf->rgb ? c : 3];
        for (int j = 0; j < sbrdf->lobes; j++) {
            const double *shape = shapes + 4 * j;
            const double base = shape[0] * light_x[s] * view[0] + shape[1] * light_y[s] * view[1] +
                                shape[2] * light_z[s] * view[2];
            const double power = base > 0x1p-24 && shape[3] > 0 ? pow(base, shape[3]) : 0;
            sum += sbrdf->rgb ? p[3 + 3 * j + c] * power : power;
        }
        out[i] = sbrdf->rgb ? sum : p[c] * sum;
    }
}

void enc_gram_accumulate(const enc_gram_samples *samples, int lobes, const enc_gram_point *point,
                         double *out_gram) {
    const int columns = enc_gram_columns(lobes);
    double column[ENC_GRAM_MAX_COLUMNS];
    memset(out_gram, 0, sizeof *out_gram * (size_t)(columns * columns));
    for (size_t i = 0; i < samples->n; i++) {
        const double m = samples->multiplier[i];
        double sum[3];
        column[0] = m;
        for (int c = 0; c < 3; c++) {
            sum[c] = point->colour[c][0];
        }
        for (int j = 0; j < lobes; j++) {
            const double *shape = point->shape[j];
            double base = 0;
            for (int k = 0; k < 3; k++) {
                base += shape[k] * samples->product[k][i];
            }
            const bool on = base >= ENC_GRAM_MIN_BASE;
            const double power = on ? pow(base, shape[3]) : 0;
            for (int k = 0; k < 3; k++) {
                column[4 + 4 * j + k] = on ? m * power / base * samples->product[k][i] : 0;
            }
            column[7 + 4 * j] = on ? m * power * log(base) : 0;
            for (int c = 0; c < 3; c++) {
                sum[c] += point->colour[c][1 + j] * power;
            }
        }
        for (int c = 0; c < 3; c++) {
            column[1 + c] = m * sum[c] - samples->target[c][i];
        }
        for (int a = 0; a < columns; a++) {
            for (int b = 0; b < columns; b++) {
                out_gram[a * columns + b] += column[a] * column[b];
            }
        }
    }
}

double enc_gram_peak(const enc_gram_samples *samples, const double c[3]) {
    double peak = ENC_GRAM_MIN_BASE;
    for (size_t i = 0; i < samples->n; i++) {
        peak = fmax(peak, c[0] * samples->product[0][i] + c[1] * samples->product[1][i] +
                              c[2] * samples->product[2][i]);
    }
    return peak;
}

bool precision_fit_in_double(const enc_data *data, int lobes, bool rgb, bool square_root, double *out) {
    enc_fit_options options = enc_fit_options_default();
    enc_sbrdf *sbrdf = NULL;
    options.lobes = lobes;
    options.rgb = rgb;
    options.square_root = square_root;
    if (enc_fit(&one_thread, data, &options, &sbrdf, NULL) != BTF_OK) {
        return false;
    }
    memcpy(out, sbrdf->values, sbrdf->n_texels * enc_sbrdf_stride(lobes, rgb) * sizeof *out);
    enc_sbrdf_destroy(&sbrdf);
    return true;
}

/* ---- the flow ---- */

#undef float
#undef enc_cv_flow_compute
int double_cv_flow(enc_cv_flow *flow, int width, int height, const unsigned char *from,
                   const unsigned char *to, double *out_xy) {
    const size_t n = 2 * (size_t)width * (size_t)height;
    float *xy = malloc(n * sizeof *xy);
    const int result = xy == NULL ? -1 : enc_cv_flow_compute(flow, width, height, from, to, xy);
    for (size_t i = 0; i < n && result == 0; i++) {
        out_xy[i] = (double)xy[i];
    }
    free(xy);
    return result;
}

enc_occlusion *precision_flow_in_double(const enc_data *data, bool plain) {
    const enc_flow_options options = {.plain = plain};
    enc_occlusion *occlusion = NULL;
    return enc_flow_vote(&one_thread, data, &options, &occlusion) == BTF_OK ? occlusion : NULL;
}
