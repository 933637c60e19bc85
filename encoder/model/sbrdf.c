/* Lafortune parameters: storage and evaluation.
 *
 * SPDX-License-Identifier: MIT
 */
#include "sbrdf.h"
#include "encoder/math/simd.h"
#include <assert.h>
#include <stdlib.h>

btf_result enc_sbrdf_create(size_t n_texels, int lobes, bool rgb, enc_sbrdf **out_sbrdf) {
    *out_sbrdf = NULL;
    if (n_texels == 0 || lobes < 1 || lobes > ENC_MAX_LOBES ||
        n_texels > SIZE_MAX / sizeof(float) / enc_sbrdf_stride(ENC_MAX_LOBES, true)) {
        return BTF_ERROR_USAGE;
    }
    enc_sbrdf *sbrdf = malloc(sizeof *sbrdf);
    float *values = calloc(n_texels * enc_sbrdf_stride(lobes, rgb), sizeof *values);
    if (!sbrdf || !values) {
        free(sbrdf);
        free(values);
        return BTF_ERROR_MEMORY;
    }
    *sbrdf = (enc_sbrdf){.n_texels = n_texels, .lobes = lobes, .rgb = rgb, .values = values};
    *out_sbrdf = sbrdf;
    return BTF_OK;
}

void enc_sbrdf_destroy(enc_sbrdf **sbrdf) {
    if (*sbrdf) {
        free((*sbrdf)->values);
        free(*sbrdf);
        *sbrdf = NULL;
    }
}

/* One texel under one view: the inputs of the lane loop. */
typedef struct lobe_sum {
    int lobes;
    bool rgb;
    const float *colour; /* mono: C_R, C_G, C_B, rho_d; RGB: rho, then w a lobe */
    const float *shape;  /* (Cx, Cy, Cz, n) a lobe */
    const float *view;
} lobe_sum;

/* f = C * (rho_d + sum_j q_j), or rho + sum_j w_j * q_j (FORMAT.md section 9), for ENC_LANES lights.
 * P = l * v first, then b = (Cx * P.x + Cy * P.y) + Cz * P.z, as there. */
ENC_INLINE void evaluate_lanes(const lobe_sum *model, const enc_v16u *light_x, const enc_v16u *light_y,
                               const enc_v16u *light_z, enc_v16 out[3]) {
    const enc_v16 zero = {0};
    const enc_v16 px = *light_x * model->view[0];
    const enc_v16 py = *light_y * model->view[1];
    const enc_v16 pz = *light_z * model->view[2];
    if (model->rgb) {
        for (int c = 0; c < 3; c++) {
            out[c] = zero + model->colour[c];
        }
    } else {
        out[0] = zero + model->colour[3];
    }
    for (int j = 0; j < model->lobes; j++) {
        const float *lobe = model->shape + 4 * j;
        const enc_v16 base = (lobe[0] * px + lobe[1] * py) + lobe[2] * pz;
        enc_v16 power;
        enc_v16_pow(&base, lobe[3], &power);
        if (model->rgb) {
            const float *weight = model->colour + 3 + 3 * j;
            for (int c = 0; c < 3; c++) {
                out[c] = out[c] + weight[c] * power;
            }
        } else {
            out[0] = out[0] + power;
        }
    }
    if (!model->rgb) {
        const enc_v16 sum = out[0];
        for (int c = 0; c < 3; c++) {
            out[c] = model->colour[c] * sum;
        }
    }
}

ENC_INLINE void evaluate_all(const lobe_sum *model, int n, const float *light_x, const float *light_y,
                             const float *light_z, float *out) {
    const size_t plane = (size_t)n;
    int i = 0;
    for (; i + ENC_LANES <= n; i += ENC_LANES) {
        enc_v16 values[3];
        evaluate_lanes(model, (const enc_v16u *)(light_x + i), (const enc_v16u *)(light_y + i),
                       (const enc_v16u *)(light_z + i), values);
        for (int c = 0; c < 3; c++) {
            *(enc_v16u *)(out + (size_t)c * plane + i) = values[c];
        }
    }
    if (i < n) {
        float rest[3][ENC_LANES] = {{0}};
        for (int k = 0; k < n - i; k++) {
            rest[0][k] = light_x[i + k];
            rest[1][k] = light_y[i + k];
            rest[2][k] = light_z[i + k];
        }
        enc_v16 values[3];
        evaluate_lanes(model, (const enc_v16u *)rest[0], (const enc_v16u *)rest[1],
                       (const enc_v16u *)rest[2], values);
        for (int c = 0; c < 3; c++) {
            const float *lanes = (const float *)&values[c];
            for (int k = 0; k < n - i; k++) {
                out[(size_t)c * plane + (size_t)(i + k)] = lanes[k];
            }
        }
    }
}

#ifdef ENC_HAVE_X86_DISPATCH
ENC_TARGET_AVX512 static void evaluate_avx512(const lobe_sum *model, int n, const float *light_x,
                                              const float *light_y, const float *light_z, float *out) {
    evaluate_all(model, n, light_x, light_y, light_z, out);
}
ENC_TARGET_AVX2 static void evaluate_avx2(const lobe_sum *model, int n, const float *light_x,
                                          const float *light_y, const float *light_z, float *out) {
    evaluate_all(model, n, light_x, light_y, light_z, out);
}
#endif

void enc_sbrdf_evaluate(const enc_sbrdf *sbrdf, size_t texel, const float view[3], int n,
                        const float *light_x, const float *light_y, const float *light_z, float *out) {
    assert(texel < sbrdf->n_texels && n >= 0);
    const float *values = sbrdf->values + texel * enc_sbrdf_stride(sbrdf->lobes, sbrdf->rgb);
    const lobe_sum model = {
        .lobes = sbrdf->lobes,
        .rgb = sbrdf->rgb,
        .colour = values,
        .shape = values + (sbrdf->rgb ? 3 + 3 * sbrdf->lobes : 4),
        .view = view,
    };
#ifdef ENC_HAVE_X86_DISPATCH
    switch (enc_isa_current()) {
    case ENC_ISA_AVX512:
        evaluate_avx512(&model, n, light_x, light_y, light_z, out);
        return;
    case ENC_ISA_AVX2:
        evaluate_avx2(&model, n, light_x, light_y, light_z, out);
        return;
    case ENC_ISA_BASE:
        break;
    }
#endif
    evaluate_all(&model, n, light_x, light_y, light_z, out);
}
