/* Accuracy as JSON. See metrics_json.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "metrics_json.h"

#include <math.h>

void enc_metrics_json(json *j, const char *key, const enc_metrics *m, bool with_ssim) {
    json_object(j, key);
    json_number(j, "linear", enc_psnr_linear(&m->total));
    json_number(j, "srgb", enc_psnr_srgb(&m->total));
    json_number(j, "ssim", with_ssim ? m->ssim : NAN);
    if (m->coincident.count > 0) {
        json_object(j, "coincident");
        json_number(j, "linear", enc_psnr_linear(&m->coincident));
        json_number(j, "srgb", enc_psnr_srgb(&m->coincident));
        json_end(j);
    }
    json_object(j, "rings");
    for (int side = 0; side < 2; side++) {
        const int rings = side == 0 ? m->n_view_rings : m->n_light_rings;
        json_array(j, side == 0 ? "view" : "light");
        for (int r = 0; r < rings; r++) {
            const enc_error_sum *sum = side == 0 ? &m->view_ring[r] : &m->light_ring[r];
            json_object(j, NULL);
            json_number(j, "theta", side == 0 ? m->view_ring_theta[r] : m->light_ring_theta[r]);
            json_number(j, "linear", enc_psnr_linear(sum));
            json_number(j, "srgb", enc_psnr_srgb(sum));
            json_end(j);
        }
        json_end(j);
    }
    json_end(j);
    json_end(j);
}
