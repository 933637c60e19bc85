/* OpenBTF: functions that reading and writing of OpenEXR files share.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_EXR_COMMON_H
#define OPENBTF_EXR_COMMON_H

#include "parts.h"
#include <openexr.h>
#include <stdbool.h>

#pragma GCC visibility push(hidden)

/* Words of attributes, by value of the enumeration. */
extern const char *const btfi_layout_words[2]; /* btf_layout */
extern const char *const btfi_domain_words[2]; /* btf_domain */
extern const char *const btfi_colour_words[3]; /* btf_colour */
extern const char *const btfi_blend_words[2];  /* btf_blend */
extern const char *const btfi_point_words[3];  /* btf_point_store */

/* "shadow,shift" for a mask of effects; "" for none. size >= 48. */
void btfi_effects_text(uint32_t effects, char *buffer, size_t size);

/* OpenEXR's last message to this thread, to be cleared before a file is begun. It is kept for the thread: OpenEXR
 * holds the lock of its context while it calls the handler, so that the handler cannot ask the context for user data. */
void btfi_exr_clear_message(void);
const char *btfi_exr_message(exr_result_t code); /* that of the code when there is none */
bool btfi_exr_was_out_of_memory(void);           /* OpenEXR goes on without some attributes */
void btfi_exr_keep_message(exr_const_context_t context, exr_result_t code, const char *message);

/* OpenEXR's type of channels whose values are stored so. */
exr_pixel_type_t btfi_pixel_type(btfi_storage storage);

/* The half that holds an integer -128..255. */
uint16_t btfi_half_from_int(int value);
/* The integer that a half holds, or INT32_MIN when it holds none. */
int32_t btfi_int_from_half(uint16_t bits);

#pragma GCC visibility pop

#endif
