/* The classes of the factors of format 2 (FORMAT.md): how many bits the codes of w and u have, and how they
 * share words and texels.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_CLASSES_H
#define OPENBTF_ENCODER_FACTOR_CLASSES_H

#include <stddef.h>

enum {
    ENC_FACTOR_CLASSES = 5,
    ENC_FACTOR_TIERS = 3,
    ENC_FACTOR_CHANNELS = 3, /* Y, C1, C2 */
    ENC_FACTOR_MOST_UNITS = 256,
    ENC_FACTOR_MOST_WORD = 16, /* components a word, at most */
    ENC_FACTOR_UNIT_WORDS = 4,
};

typedef struct enc_factor_class {
    int bits_w, bits_u;
    size_t word;     /* components a word of 32 bits of w; a unit has four words */
    size_t u_texels; /* texels of u a unit */
    size_t tier;     /* of the views' factors */
    int top_w,
        top_u;    /* the largest level; -top .. top in steps of 2, of 1 with a zero where the class is 0 */
    double error; /* that rounding leaves, over the energy of a component */
} enc_factor_class;

extern const enc_factor_class enc_factor_classes[ENC_FACTOR_CLASSES];

#endif
