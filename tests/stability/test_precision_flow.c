/* The encoder's part of the flow (images, first estimate, consistency and votes) in float and in double. The optical
 * flow between them is the same, because OpenCV's DIS has no double version.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cases.h"
#include "precision.h"
#include "precision_double.h"

#include "encoder/paper/flow.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const enc_context context = {.threads = 1};

void precision_flow(void) {
    precision_scene s = precision_scene_make(12);
    const size_t points = (size_t)s.data->n_views * enc_data_texel_count(s.data);
    for (int plain = 0; plain < 2; plain++) {
        const enc_flow_options options = {.plain = plain};
        enc_occlusion *single = NULL, *twice = precision_flow_in_double(s.data, plain);
        if (enc_flow_vote(&context, s.data, &options, &single) != BTF_OK || twice == NULL) {
            exit(1);
        }
        size_t shifts = 0, flags = 0, moved = 0;
        for (size_t i = 0; i < points; i++) {
            shifts += memcmp(single->shift + 2 * i, twice->shift + 2 * i, 2) != 0;
            flags += single->hidden[i] != twice->hidden[i];
            moved += single->shift[2 * i] != 0 || single->shift[2 * i + 1] != 0;
        }
        const size_t hidden = enc_occlusion_hidden_count(single, -1);
        enc_centres *a = NULL, *b = NULL;
        if (enc_cluster(&context, s.data, NULL, 24, single, &a) != BTF_OK ||
            enc_cluster(&context, s.data, NULL, 24, twice, &b) != BTF_OK) {
            exit(1);
        }
        const double psnr = precision_psnr_of_parts(s.data, s.sbrdf, s.shadow, single, a);
        const double exact = precision_psnr_of_parts(s.data, s.sbrdf, s.shadow, twice, b);
        cases_add(
            plain ? "flow without a first estimate, its images and votes in double around OpenCV's DIS "
                    "(float only)"
                  : "flow, its images, first estimate and votes in double around OpenCV's DIS (float "
                    "only)",
            "less than 0.05 dB either way", moved > 0 && fabs(exact - psnr) < precision_most_loss,
            "%.4f dB, double %.4f dB; of %zu points %zu move, %zu are hidden, %zu shifts and %zu flags "
            "differ",
            psnr, exact, points, moved, hidden, shifts, flags);
        enc_centres_destroy(&a);
        enc_centres_destroy(&b);
        enc_occlusion_destroy(&single);
        enc_occlusion_destroy(&twice);
    }
    precision_scene_clear(&s);
}
