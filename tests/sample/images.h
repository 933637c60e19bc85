/* Writes the images of a scene as files: of a grid of views and lights, or of single pairs of them.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_SAMPLE_IMAGES_H
#define OPENBTF_SAMPLE_IMAGES_H

#include "camera.h"
#include "pairs.h"
#include "sample.h"

/* 8-bit sRGB PNG, 16-bit sRGB PNG, JPEG; OpenEXR of floats, linear and not clipped. */
typedef enum images_format { IMAGES_PNG, IMAGES_PNG16, IMAGES_JPEG, IMAGES_EXR } images_format;

typedef struct images_job {
    const enc_context *context; /* log, progress, threads */
    const sample_scene *scene;
    const char *folder; /* the folder of the images; a path of at most PATH_MAX - 128 bytes */
    images_format format;
    int quality;         /* of JPEG */
    sample_camera camera;
    sample_truth *truth; /* filled by images_write_grid(); or NULL */
} images_job;

/* "png", "jpg" or "exr". */
const char *images_extension(images_format format);

/* Makes a folder and its parents. Errors, on the log: BTF_ERROR_IO, BTF_ERROR_MEMORY. */
btf_result images_make_folder(const enc_context *context, const char *path);

/* Renders the scene's views under its lights, and writes the images in the layout of UBO2003:
 * FOLDER/tvTTT_pvPPP/NNNNN tlTTT plPPP tvTTT pvPPP.EXTENSION. Errors, on the log: BTF_ERROR_IO, BTF_ERROR_MEMORY,
 * BTF_ERROR_INTERRUPTED. */
btf_result images_write_grid(const images_job *job);

/* Renders single pairs of a view and a light, and writes FOLDER/NAME.EXTENSION by pairs_name(), with the number
 * of the frame where they are numbered. Errors as above. */
btf_result images_write_pairs(const images_job *job, const sample_pair *pairs, int count, bool numbered);

#endif
