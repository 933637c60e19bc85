/* Places of a class of 8 bits that no component needs, which then hold what rounding left.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_EMPTY_PLACES_H
#define OPENBTF_ENCODER_FACTOR_EMPTY_PLACES_H

#include "codes.h"

/* Data of few components, such as those of one reflectance for all texels, fill no unit. Adds to the rounded codes of each
 * channel the leading components of the difference between `components` and codes, one for each empty place that gains by it:
 * first in words that are empty, which get scales of their own, then beside other components, with their scale. Codes that are
 * there stay as they are, and so do channels without an empty place. No threads, no samples: every rank does the same. Errors:
 * BTF_ERROR_MEMORY. */
btf_result enc_factor_fill_places(const enc_factor_matrix *matrix, const enc_components components[ENC_FACTOR_CHANNELS],
                                  enc_factor_codes *io_codes);

#endif
