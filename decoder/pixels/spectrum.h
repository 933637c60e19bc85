/* Spectra to linear Rec. 709.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_PIXELS_SPECTRUM_H
#define OPENBTF_PIXELS_SPECTRUM_H

#include <stdbool.h>
#include <stddef.h>

/* weights[i][3]: what one unit in band i adds to R, G and B. nm: wavelengths of the bands, strictly rising;
 * between them a spectrum is linear, beyond them constant. It is integrated from 380 to 780 nm against the
 * colour matching functions of CIE 1931, 2 degrees, as fitted by Wyman, Sloan and Shirley (JCGT 2(2), 2013,
 * multi-lobe), and
 *  - under D65, where `emission` is false (reflectance, the share of light that comes back): a spectrum
 *    that is 1 everywhere becomes (1, 1, 1);
 *  - as it is, where it is true (light): scaled so that a spectrum that is 1 everywhere has Y = 1.
 * count >= 1. */
void spectrum_weights(const double *nm, size_t count, bool emission, float (*weights)[3]);

#endif
