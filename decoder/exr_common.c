/* OpenBTF: words, messages and integers in halves, as OpenEXR files of materials have them.
 *
 * SPDX-License-Identifier: MIT
 */
#include "exr_common.h"

#include "shape.h"
#include <stdio.h>

const char *const btfi_layout_words[2] = {"paper", "tight"};
const char *const btfi_domain_words[2] = {"linear", "sqrt"};
const char *const btfi_colour_words[3] = {"mono", "rgb", "none"};
const char *const btfi_blend_words[2] = {"radiance", "roots"};
const char *const btfi_point_words[3] = {"separate", "packed", "lists"};

void btfi_effects_text(uint32_t effects, char *buffer, size_t size) {
    size_t length = 0;
    buffer[0] = 0;
    for (int i = 0; btfi_effect_name(i); i++) {
        if (effects & 1u << i) {
            length += (size_t)snprintf(buffer + length, size - length, "%s%s", length ? "," : "",
                                       btfi_effect_name(i));
        }
    }
}

static _Thread_local char last_message[256];
static _Thread_local bool out_of_memory;

void btfi_exr_clear_message(void) {
    last_message[0] = 0;
    out_of_memory = false;
}

const char *btfi_exr_message(exr_result_t code) {
    return last_message[0] ? last_message : exr_get_default_error_message(code);
}

bool btfi_exr_was_out_of_memory(void) {
    return out_of_memory;
}

void btfi_exr_keep_message(exr_const_context_t context, exr_result_t code, const char *message) {
    (void)context;
    out_of_memory = out_of_memory || code == EXR_ERR_OUT_OF_MEMORY;
    snprintf(last_message, sizeof last_message, "%s",
             message ? message : exr_get_default_error_message(code));
}

exr_pixel_type_t btfi_pixel_type(btfi_storage storage) {
    return storage == BTFI_STORAGE_FLOAT    ? EXR_PIXEL_FLOAT
           : storage == BTFI_STORAGE_UINT32 ? EXR_PIXEL_UINT
                                            : EXR_PIXEL_HALF;
}

uint16_t btfi_half_from_int(int value) {
    unsigned magnitude = (unsigned)(value < 0 ? -value : value), exponent = 25;
    if (magnitude == 0) {
        return 0;
    }
    while (magnitude < 1024) {
        magnitude <<= 1;
        exponent--;
    }
    return (uint16_t)((value < 0 ? 0x8000u : 0u) | exponent << 10 | (magnitude & 1023u));
}

int32_t btfi_int_from_half(uint16_t bits) {
    int exponent = bits >> 10 & 31, mantissa = (bits & 1023) | 1024;
    if ((bits & 0x7FFF) == 0) {
        return 0;
    }
    if (exponent < 15 || exponent > 25 || (mantissa & ((1 << (25 - exponent)) - 1)) != 0) {
        return INT32_MIN;
    }
    int value = mantissa >> (25 - exponent);
    return bits & 0x8000 ? -value : value;
}
