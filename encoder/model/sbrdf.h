/* Spatially varying Lafortune parameters (paper 2.1; Lafortune et al. 1997; McAllister et al. 2002).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_MODEL_SBRDF_H
#define OPENBTF_ENCODER_MODEL_SBRDF_H

#include <openbtf/result.h>
#include <stdbool.h>
#include <stddef.h>

enum { ENC_MAX_LOBES = 4 };

/* One parameter block a texel, in the order of the file's channels (FORMAT.md, "sbrdf"):
 *   one colour (rgb = false): C_R, C_G, C_B, rho_d, then (Cx, Cy, Cz, n) a lobe:       4 + 4 * lobes
 *   RGB lobes  (rgb = true):  rho_R, rho_G, rho_B, then (w_R, w_G, w_B) a lobe, then
 *                             (Cx, Cy, Cz, n) a lobe:                                   3 + 7 * lobes
 * Model (no 1/pi, m(l) = max(l.z, 0), or its square root in the square-root domain):
 *   one colour: m(l) * C * (rho_d + sum_j max(0, Cx lx vx + Cy ly vy + Cz lz vz)^n), max(C) = 1
 *   RGB lobes:  m(l) * (rho + sum_j w_j * max(0, ...)^n)
 * Every parameter is 0 or of magnitude 2^-24 .. 2^24. */
typedef struct enc_sbrdf {
    size_t n_texels;
    int lobes; /* 1 .. ENC_MAX_LOBES */
    bool rgb;
    float *values; /* [texel][enc_sbrdf_stride] */
} enc_sbrdf;

static inline size_t enc_sbrdf_stride(int lobes, bool rgb) {
    return rgb ? 3 + 7 * (size_t)lobes : 4 + 4 * (size_t)lobes;
}

/* The index of parameter `i` of a texel among the numbers of the file's texture: RGBA layers, of which the
 * lobes' (Cx, Cy, Cz, n) begin a new one (FORMAT.md section 4). */
static inline size_t enc_sbrdf_texture_index(const enc_sbrdf *sbrdf, size_t texel, size_t i) {
    const size_t head = sbrdf->rgb ? 3 + 3 * (size_t)sbrdf->lobes : 4, head_layers = (head + 3) / 4;
    const size_t slot = i < head ? i : head_layers * 4 + (i - head);
    return ((slot / 4) * sbrdf->n_texels + texel) * 4 + slot % 4;
}

/* All zeros. Errors: BTF_ERROR_USAGE, BTF_ERROR_MEMORY. */
btf_result enc_sbrdf_create(size_t n_texels, int lobes, bool rgb, enc_sbrdf **out_sbrdf);
void enc_sbrdf_destroy(enc_sbrdf **sbrdf);

/* Evaluates one texel under `n` lights (xyz) from one view: out[channel * n + i], without the multiplier
 * m(l). In vectors of floats. */
void enc_sbrdf_evaluate(const enc_sbrdf *sbrdf, size_t texel, const float view[3], int n,
                        const float *light_x, const float *light_y, const float *light_z, float *out);

#endif
