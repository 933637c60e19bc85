/* Fields of Bonn's binary .btf files, read one after the other, and the numbers in them. All are little-endian.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_BONN_FIELDS_H
#define OPENBTF_ENCODER_BONN_FIELDS_H

#include "encoder/base/context.h"
#include <stdint.h>

/* The place in a file that is read next. The first field that is cut off by the end of the file, or
 * refused, sets `result`; from then on the functions below read nothing and return 0 or NULL, or 1 for a
 * count. */
typedef struct enc_bonn_cursor {
    const enc_context *context;
    const char *path;           /* of the file, for messages */
    const unsigned char *bytes; /* the whole file */
    uint64_t size, at;
    btf_result result;
} enc_bonn_cursor;

/* Tells the context's log that the field at byte `at` is refused: "PATH: field FIELD at byte AT: WHY VALUE". */
void enc_bonn_refuse(enc_bonn_cursor *c, btf_result result, uint64_t at, const char *field, const char *why,
                     double value);

/* Steps over `size` bytes and returns their address. */
const unsigned char *enc_bonn_take(enc_bonn_cursor *c, uint64_t size, const char *field);

uint32_t enc_bonn_take_u32(enc_bonn_cursor *c, const char *field);
unsigned enc_bonn_take_u8(enc_bonn_cursor *c, const char *field);
/* Takes a finite float of 4 bytes. */
float enc_bonn_take_float(enc_bonn_cursor *c, const char *field);
/* Takes a count from 1 to `most`. */
uint32_t enc_bonn_take_count(enc_bonn_cursor *c, const char *field, uint32_t most);
/* Takes the size in bytes of a matrix's numbers: 2, 4 or 8. */
unsigned enc_bonn_take_scalar(enc_bonn_cursor *c);

/* The integer of 4 bytes at an address, and the floating-point number of `scalar` bytes there: 2 (half), 4
 * or 8. */
uint32_t enc_bonn_u32(const unsigned char *at);
float enc_bonn_number(const unsigned char *at, unsigned scalar);

#endif
