/* The filters between texels by name, and as the reference decoder numbers them.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLKIT_FILTER_H
#define OPENBTF_TOOLKIT_FILTER_H

#include <openbtf/shader.h>

/* Choices of an option --filter, by value of btf_filter. */
#define FILTER_CHOICES "texel|bilinear|steep"

/* "texel", "bilinear" or "steep". */
const char *filter_name(btf_filter filter);

/* BTF_REF_TEXEL, _BILINEAR or _STEEP. */
int filter_of_reference(btf_filter filter);

/* The texture coordinate of the centre of texel `i` of `size`, counted from the left or from below: the
 * next multiple of 2^-18, in which texture coordinates are counted, so that no part of the texel before is
 * blended in, and, up to 1024 texels, none of the next. */
float filter_centre(uint32_t i, uint32_t size);

#endif
