/* Environment maps: read, and turned into directional lights.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RENDER_ENVIRONMENT_H
#define OPENBTF_RENDER_ENVIRONMENT_H

#include "lights.h"

/* Cuts a latitude-longitude map into `count` regions (a power of two) of like energy by median cut and adds
 * one directional light for each, at the centre of its energy (P. Debevec, "A median cut algorithm for
 * light probe sampling", 2005). pixels[row][column][3] is linear radiance; row 0 is up (+y), the middle
 * column is ahead (-z, what the default camera looks at), columns grow to the right (+x). `rotate` turns
 * it, degrees to the right. Pixels that are negative or not finite count as 0. Regions without energy add nothing.
 * Errors: BTF_ERROR_MEMORY. */
btf_result light_list_add_environment(light_list *list, int width, int height, const float *pixels,
                                      int count, double rotate, double gain);

/* Reads such a map from a file, EXR or Radiance HDR, of the primaries that it names, else Rec. 709. `layer` picks
 * among the layers and parts of an EXR file (exr_choose.h); may be NULL. Warns of what the file says and is not
 * followed. *out_pixels[height][width][3] is the caller's to free. Errors: BTF_ERROR_IO, BTF_ERROR_BAD_FILE,
 * BTF_ERROR_UNSUPPORTED, BTF_ERROR_MEMORY. */
btf_result environment_read(const char *path, const char *layer, const btf_log *log, int *out_width,
                            int *out_height, float **out_pixels);

/* Reads a map and adds its lights. Errors of both. */
btf_result light_list_read_environment(light_list *list, const char *path, const char *layer, int count,
                                       double rotate, double gain, const btf_log *log);

#endif
