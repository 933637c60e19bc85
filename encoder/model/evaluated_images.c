/* Images of a material. See evaluated_images.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "evaluated_images.h"

#include <stdlib.h>

/* Goes through all lights of a texel before the next texel, since they share the levels of its codes. */
static btf_result view_images(const void *user, int view, float *out) {
    const enc_evaluated_images *images = user;
    const enc_data *shape = images->shape;
    const float *to_viewer = shape->views[view].xyz;
    const size_t lights = (size_t)shape->n_lights, texels = enc_data_texel_count(shape);
    enc_evaluated_neighbours *around = malloc(lights * sizeof *around);
    enc_evaluated_texel *texel = enc_evaluated_texel_create(images->evaluator, 0);
    const btf_result result = around && texel ? BTF_OK : BTF_ERROR_MEMORY;
    for (size_t l = 0; result == BTF_OK && l < lights; l++) {
        around[l] = enc_evaluated_look_up(images->evaluator, shape->lights[l].xyz, to_viewer);
    }
    for (size_t t = 0; result == BTF_OK && t < texels; t++) {
        enc_evaluated_texel_move(texel, t);
        for (size_t l = 0; l < lights; l++) {
            const enc_evaluated_at at = {&around[l].lights, &around[l].views, shape->lights[l].xyz,
                                         to_viewer, true, false};
            enc_evaluate(texel, &images->options, &at, &images->options.components, 1,
                         (float(*)[3])(out + 3 * (l * texels + t)));
        }
    }
    enc_evaluated_texel_destroy(&texel);
    free(around);
    return result;
}

enc_image_source enc_evaluated_image_source(const enc_evaluated_images *images) {
    return (enc_image_source){.view = view_images, .user = images};
}
