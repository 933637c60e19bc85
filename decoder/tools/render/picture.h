/* Pictures: from linear radiance to the values of a screen.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RENDER_PICTURE_H
#define OPENBTF_RENDER_PICTURE_H

#include <openbtf/result.h>
#include <stdbool.h>

/* rgb[row][column][3], linear Rec. 709, row 0 at the top. */
typedef struct picture {
    int width, height;
    float *rgb;
} picture;

typedef enum tone { TONE_NONE = 0, TONE_REINHARD, TONE_FILMIC } tone;

/* Black. BTF_ERROR_MEMORY. */
btf_result picture_create(int width, int height, picture *out_picture);
void picture_clear(picture *p);

/* A linear value as an 8-bit sRGB code (IEC 61966-2-1), rounded to nearest. */
unsigned char picture_code(double linear);

/* Tone curve over exposed values: none, x / (1 + x) (E. Reinhard et al., 2002), or a filmic curve (the
 * rational fit of K. Narkowicz, 2015), channel by channel. */
double picture_tone(tone t, double x);

/* Multiplies by exposure. */
void picture_expose(picture *p, double exposure);

/* Writes .png (tone curve, sRGB, 8 bits) or .exr (linear float, no curve), by the ending of path. Errors:
 * BTF_ERROR_IO, BTF_ERROR_MEMORY. */
btf_result picture_write(const picture *p, const char *path, tone t, btf_log log);

/* True when path ends in .png or .exr. */
bool picture_knows(const char *path);

/* PSNR in dB over the pixels where mask[pixel] is set (NULL: all), values clipped to [0, 1], linear or
 * sRGB-coded (not rounded); 99.99 when equal, and when the mask is empty. */
double picture_psnr(const picture *a, const picture *b, const unsigned char *mask, bool srgb);

#endif
