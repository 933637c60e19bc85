/* Data sets and materials as sources of images. See images.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "images.h"

static btf_result data_view(const void *user, int view, float *out) {
    return enc_data_view(NULL, user, view, out);
}

enc_image_source enc_data_images(const enc_data *data) {
    return (enc_image_source){.view = data_view, .user = data};
}

static btf_result reference_view_images(const void *user, int view, float *out) {
    const enc_reference_images *images = user;
    const enc_data *shape = images->shape;
    const btf_ref_material *material = &images->material;
    const float *to_viewer = shape->views[view].xyz;
    for (int l = 0; l < shape->n_lights; l++) {
        const float *to_light = shape->lights[l].xyz;
        for (uint32_t row = 0; row < material->height; row++) {
            for (uint32_t column = 0; column < material->width; column++) {
                btf_ref_evaluate_texel(material, &images->options, column, row, to_light, to_viewer, out);
                out += 3;
            }
        }
    }
    return BTF_OK;
}

enc_image_source enc_reference_image_source(const enc_reference_images *images) {
    return (enc_image_source){.view = reference_view_images, .user = images};
}
