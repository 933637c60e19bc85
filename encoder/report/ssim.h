/* Structural similarity of two images (Wang, Bovik, Sheikh, Simoncelli 2004).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_SSIM_H
#define OPENBTF_ENCODER_SSIM_H

typedef struct enc_ssim enc_ssim;

/* Makes the work space for images of one size, for one thread at a time. NULL when out of memory. */
enc_ssim *enc_ssim_create(int width, int height);
void enc_ssim_destroy(enc_ssim **ssim);

/* The mean SSIM of the luminance of two RGB images with values 0..1, [row][column][channel]. Gaussian
 * window of 11 taps, sigma 1.5, K1 = 0.01, K2 = 0.03; the images are taken as periodic, as BTF textures
 * are. */
double enc_ssim_images(enc_ssim *ssim, const float *a, const float *b);

#endif
