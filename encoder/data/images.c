/* A data set as a source of images. See images.h.
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
