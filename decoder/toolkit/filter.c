/* The filters between texels. See filter.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "filter.h"

#include <openbtf/reference.h>

const char *filter_name(btf_filter filter) {
    return filter == BTF_FILTER_BILINEAR ? "bilinear" : filter == BTF_FILTER_STEEP ? "steep" : "texel";
}

int filter_of_reference(btf_filter filter) {
    return filter == BTF_FILTER_BILINEAR ? BTF_REF_BILINEAR
           : filter == BTF_FILTER_STEEP  ? BTF_REF_STEEP
                                         : BTF_REF_TEXEL;
}

float filter_centre(uint32_t i, uint32_t size) {
    return (float)(((2 * i + 1) * ((uint32_t)1 << 17) + size - 1) / size) * 0x1p-18f;
}
