/* The picture a report comes with: rows are views; columns are the original, what each step of the decode
 * gives, and the error of the last one.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_MONTAGE_H
#define OPENBTF_ENCODER_MONTAGE_H

#include "encoder/data/images.h"

/* One column. */
typedef struct enc_montage_column {
    const char *title;
    enc_image_source images;
} enc_montage_column;

enum { ENC_ERROR_GAIN = 4 }; /* absolute errors are shown four times as bright */

/* One row a view ring, under the light nearest to (45, 60) degrees. columns[0] is the original; the last
 * column of the picture is |original - columns[count - 1]| * ENC_ERROR_GAIN in sRGB-coded values. Errors:
 * those of the sources, BTF_ERROR_IO, BTF_ERROR_MEMORY. */
btf_result enc_montage_write(const enc_context *context, const enc_data *shape, int count,
                             const enc_montage_column *columns, const char *path);

/* The direction of the list nearest to (theta, phi) in degrees. */
int enc_nearest_direction(const enc_direction *directions, int count, double theta, double phi);

#endif
