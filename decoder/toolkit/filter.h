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

#endif
