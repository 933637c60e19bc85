/* OpenBTF: attributes of part 0 of a file, read by type and checked against the range that FORMAT.md gives them.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_HEADER_ATTRIBUTES_H
#define OPENBTF_HEADER_ATTRIBUTES_H

#include "decoder/result.h"
#include <openexr.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#pragma GCC visibility push(hidden)

/* The file that is read. The first error stays in `result`; from then on the functions below that take an attribute by
 * its name read nothing: they return NULL or 0, btfi_get_int_or() *absent, and say that there are 0 numbers or bytes.
 * btfi_copy_integers() and btfi_keep_floats(), which are given their numbers, still copy them. */
typedef struct btfi_attributes {
    exr_const_context_t context;
    const btf_log *log;
    btf_result result;
} btfi_attributes;

/* Tells the caller's log why the file is refused, and sets BTF_ERROR_BAD_FILE, unless an error came before. */
void btfi_refuse(btfi_attributes *r, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Tells the log that there is no memory for the attribute, and sets BTF_ERROR_MEMORY. */
void btfi_out_of_memory(btfi_attributes *r, const char *name);

/* The attribute of that name; NULL when the file has none (refused if `required`), or one of another type
 * (refused). */
const exr_attribute_t *btfi_find_attribute(btfi_attributes *r, const char *name, exr_attribute_type_t type,
                                           const char *type_name, bool required);

/* An integer within low..high; any other is refused. btfi_get_int_or() takes *absent for an attribute that the
 * file does not have, btfi_get_int() refuses the file. */
uint32_t btfi_get_int(btfi_attributes *r, const char *name, int32_t low, int32_t high);
uint32_t btfi_get_int_or(btfi_attributes *r, const char *name, int32_t low, int32_t high,
                         const uint32_t *absent);

/* A float, which the file must have. */
float btfi_get_float(btfi_attributes *r, const char *name);

/* A string, and in *out_length the number of bytes before its first zero. NULL when the file has none. A string
 * of more than 1 MiB is refused. The text is the file's. */
const char *btfi_get_string(btfi_attributes *r, const char *name, bool required, size_t *out_length);

/* The index among words[count] of a string that the file must have; any other word is refused. */
int btfi_get_word(btfi_attributes *r, const char *name, const char *const *words, int count);

/* The numbers of a floatvector, whose count is a multiple of `group` and at most group * most. NULL when the file
 * has none. The numbers are the file's. */
const float *btfi_get_floats(btfi_attributes *r, const char *name, bool required, size_t group, size_t most,
                             size_t *out_count);

/* A copy of `count` numbers as integers, for the caller to free; numbers that are not integers within 0..high,
 * which is at most 65535, are refused. btfi_get_integers() reads the numbers from a floatvector. */
uint16_t *btfi_copy_integers(btfi_attributes *r, const char *name, const float *values, size_t count,
                             unsigned high);
uint16_t *btfi_get_integers(btfi_attributes *r, const char *name, bool required, size_t group, size_t most,
                            unsigned high, size_t *out_count);

/* Copies values[count] into *out, for the caller to free, and sets *out_count. */
void btfi_keep_floats(btfi_attributes *r, const char *name, const float *values, size_t count, float **out,
                      size_t *out_count);

#pragma GCC visibility pop

#endif
