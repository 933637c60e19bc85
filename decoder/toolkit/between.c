/* Effects that act between the samples. See between.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "between.h"

#include <math.h>
#include <stddef.h>

/* Numbers of rows in the material's table of errors between the samples: what was left out and predicted. Relief is
 * judged where a view was left out. Gloss is judged where both were: under a sampled light it does no more than blend
 * in other lights. */
enum { VIEW = 1, BOTH = 3, VIEW_WITHOUT_RELIEF = 5, BOTH_WITHOUT_GLOSS = 11 };

static const float *find_row(const btf_between_errors *e, int left_out) {
    for (uint32_t i = 0; i < e->row_count; i++) {
        const float *row = e->rows + (size_t)i * e->row_stride;
        if (row[0] == (float)left_out) {
            return row;
        }
    }
    return NULL;
}

bool between_gain(const btf_material *material, uint32_t effect, double out_gain[2]) {
    const btf_between_errors e = btf_material_between_errors(material);
    const bool gloss = effect == BTF_EFFECT_GLOSS;
    const float *with = find_row(&e, gloss ? BOTH : VIEW),
                *without = find_row(&e, gloss ? BOTH_WITHOUT_GLOSS : VIEW_WITHOUT_RELIEF);
    out_gain[0] = out_gain[1] = 0;
    if (!(effect & BETWEEN_EFFECTS) || !with || !without) {
        return false;
    }
    for (int i = 0; i < 2; i++) {
        out_gain[i] = 10 * log10(fmax((double)without[1 + i], 1e-10) / fmax((double)with[1 + i], 1e-10));
    }
    return true;
}
