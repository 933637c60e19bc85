/* OpenBTF: data sets of BTFs as images in linear light, whatever they are stored in.
 *
 * Reads what btf-encode reads: folders and archives of images whose names say the directions (UBO2003, UTIA and
 * others) or of which a table does, and Bonn's binary .btf files (encoder/INPUTS.md of the source). A library of its
 * own, libopenbtf_input, since it needs what image files and archives need; it takes no MPI and makes no material.
 *
 * Directions are unit vectors of the tangent frame (x along +u, y along +v, z the normal), to the viewer and to the
 * light, in paper order: theta ascending, then phi ascending from 0. Values are linear Rec. 709 radiance over
 * (normal-incidence irradiance / pi), cosine included: a white Lambertian surface gives l.z. They are never below 0.
 *
 * Thread rule: any number of threads may read images of one btf_input at the same time; calls for an archive or a Bonn
 * file wait for one another. Messages go to the log of the call, one at a time, and may come from threads that the
 * call made. No handler of signals is installed.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_INPUT_H
#define OPENBTF_INPUT_H

#include <openbtf/result.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** How the values of images are coded. */
typedef enum btf_transfer {
    BTF_TRANSFER_AUTO = 0, /**< as a PNG says, else sRGB for 8 and 16 bits, linear for HDR and EXR */
    BTF_TRANSFER_SRGB,     /**< sRGB */
    BTF_TRANSFER_LINEAR,   /**< linear light */
    BTF_TRANSFER_GAMMA,    /**< a power, btf_input_options.gamma */
} btf_transfer;

/** The primaries of images. */
typedef enum btf_primaries {
    BTF_PRIMARIES_AUTO = 0, /**< those that the file names, else Rec. 709 */
    BTF_PRIMARIES_RGB,      /**< Rec. 709, whatever the file says */
    BTF_PRIMARIES_XYZ,      /**< CIE XYZ, white point D65 (UTIA's OpenEXR files) */
} btf_primaries;

/** Whether values hold the cosine of the angle between light and normal. */
typedef enum btf_cosine {
    BTF_COSINE_AUTO = 0, /**< as the file says; images do */
    BTF_COSINE_INCLUDED, /**< they do */
    BTF_COSINE_MISSING,  /**< they are multiplied by it */
} btf_cosine;

/** How to read. All zeros is a good default; a null pointer means that too. Messages name an option by its member here,
 * which in btf-encode is the option of that name (`option layer`: --layer). */
typedef struct btf_input_options {
    size_t struct_size;      /**< sizeof(btf_input_options) */
    btf_transfer transfer;   /**< how values are coded */
    double gamma;            /**< of BTF_TRANSFER_GAMMA, above 0 */
    btf_primaries primaries; /**< of the values */
    btf_cosine cosine;       /**< in the values */
    int size[2];             /**< width and height to resize to, by an area filter in linear light; 0: as read */
    int crop[4];             /**< x, y from the top, width, height in pixels of the file; all 0: everything */
    int flip_v;              /**< 1: row 0 of the files is the bottom */
    int azimuth_cw;          /**< 1: azimuths of the names grow clockwise */
    double azimuth_offset;   /**< degrees added to every azimuth */
    const char *layer;       /**< of OpenEXR files: the layer, part or channel to read; NULL: the plain choice */
    const char *names;       /**< table of the images' directions (btf-encode --names); NULL: names say them */
    int strict;              /**< 1: refuse values below 0 in place of setting them to 0 */
    size_t memory;           /**< bytes allowed: samples beyond half of them, of archives, go to a scratch file
                                  in $TMPDIR, and those of Bonn files are made when asked for; 0: 1 GiB */
} btf_input_options;

/** A data set that was opened. */
typedef struct btf_input btf_input;

/** Sizes and directions of a data set. Lists belong to the btf_input. */
typedef struct btf_input_info {
    size_t struct_size;    /**< sizeof(btf_input_info), set by the caller */
    int width, height;     /**< of an image, in texels */
    int n_views, n_lights; /**< directions */
    const float *views;    /**< [n_views][3] */
    const float *lights;   /**< [n_lights][3] */
    const double *view_angles;  /**< [n_views][2] theta and phi in degrees */
    const double *light_angles; /**< [n_lights][2] likewise */
    int lazy; /**< 1: images are read when asked for; 0: everything was read when it was opened */
} btf_input_info;

/** Opens a data set: the names of a folder are read, and its first image; an archive is read whole; of a Bonn file the
 * factors are mapped. *out_input is closed with btf_input_close. Errors, with file names and counts on @p log:
 * BTF_ERROR_USAGE (an option), BTF_ERROR_IO, BTF_ERROR_BAD_FILE (missing, duplicate or wrong directions, damaged
 * images, values that are no numbers), BTF_ERROR_UNSUPPORTED, BTF_ERROR_MEMORY. */
btf_result btf_input_open(const char *path, const btf_input_options *options, const btf_log *log,
                          btf_input **out_input);

/** Fills *out_info up to its struct_size. Errors: BTF_ERROR_USAGE (a null pointer, a struct_size too small to be
 * one). */
btf_result btf_input_get_info(const btf_input *input, btf_input_info *out_info);

/** Reads the image of a view under a light, numbers of the lists: out_rgb [height][width][3], row 0 the top. Errors:
 * BTF_ERROR_USAGE (a number beyond its list), and those of btf_input_open. */
btf_result btf_input_image(btf_input *input, int view, int light, const btf_log *log, float *out_rgb);

/** Closes *input and sets it to NULL. NULL and a pointer to NULL are accepted. */
void btf_input_close(btf_input **input);

/** Writes an image as an OpenEXR file of 32-bit floats, channels R, G, B, losslessly compressed; the file is whole or
 * absent. @p rgb [height][width][3], linear, row 0 the top. Errors: BTF_ERROR_USAGE (a null pointer, a side outside
 * 1..16384), BTF_ERROR_IO, BTF_ERROR_MEMORY. */
btf_result btf_input_write_image(const char *path, int width, int height, const float *rgb, const btf_log *log);

#ifdef __cplusplus
}
#endif
#endif
