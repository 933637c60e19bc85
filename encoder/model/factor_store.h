/* The store of the residual as factors (FORMAT.md section 3, version 2): its arrays, and the levels of
 * their codes.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_MODEL_FACTOR_STORE_H
#define OPENBTF_ENCODER_MODEL_FACTOR_STORE_H

#include <openbtf/material.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { ENC_STORE_TIERS = 3, ENC_STORE_WORDS = 4, ENC_STORE_MOST_WORD = 16 };

/* A class of factors (FORMAT.md section 3): how many bits the codes of w and u have, and how they share words
 * and texels. */
typedef struct enc_factor_class {
    int bits_w, bits_u;
    size_t word;       /* components a word of 32 bits of w; a unit has four words */
    uint32_t u_texels; /* texels of u a unit */
    size_t tier;       /* of the views' factors */
    int shift;         /* of the sum over a word or a whole unit before it becomes a float */
    int top_w,
        top_u;    /* the largest level; -top .. top in steps of 2, of 1 with a zero where the class is 0 */
    double error; /* squared error that rounding leaves, over the energy of a component: for encoders */
} enc_factor_class;

extern const enc_factor_class enc_factor_classes[BTF_FACTOR_CLASSES];

/* The codes as the textures hold them. All zeros: there are none. */
typedef struct enc_factor_store {
    uint32_t classes[BTF_FACTOR_CLASSES][3]; /* units, words of C1, words of C2 */
    uint32_t units, layers;                  /* n_w, n_u */
    uint32_t *texels;                        /* [layer][texel][word] */
    uint32_t *directions;                    /* [unit][view][light][word] */
    float *scales;                           /* [unit][word] */
    float *views;                            /* [view][tier][Y, C1, C2, 0] */
    float horizon_scale;                     /* 1 / l.z of the outermost light */
} enc_factor_store;

/* Where the codes of a unit lie, and what they mean. */
typedef struct enc_factor_unit {
    int class, tier, shift; /* shift: of the sum over a word or a whole unit before it becomes a float */
    bool mixed;             /* evaluated word by word */
    uint32_t layer;         /* its first texel of u */
    int word;               /* components of a word */
    int channel[ENC_STORE_WORDS]; /* 0 Y, 1 C1, 2 C2 */
    size_t first;                 /* its first component, counting from unit 0; four words follow */
} enc_factor_unit;

/* Sums of a table of classes: units, and texels of u. */
uint32_t enc_store_units(const uint32_t classes[BTF_FACTOR_CLASSES][3]);
uint32_t enc_store_layers(const uint32_t classes[BTF_FACTOR_CLASSES][3]);
/* The classes of the first `units` units. */
void enc_store_truncate(const uint32_t classes[BTF_FACTOR_CLASSES][3], uint32_t units,
                        uint32_t out[BTF_FACTOR_CLASSES][3]);
/* Describes each unit, out [units]. Returns the components of all. */
size_t enc_store_list(const uint32_t classes[BTF_FACTOR_CLASSES][3], enc_factor_unit *out);

/* Where the code of u of component i of a word lies (FORMAT.md section 3). */
typedef struct enc_store_place {
    int second; /* 1: in the unit's second texel */
    int bit;    /* the lowest */
} enc_store_place;
enc_store_place enc_store_place_of_u(int class, int i);

/* Levels of a unit's codes, word by word, from its texel of w and from its one or two texels of u: out [4 *
 * unit->word]. */
void enc_store_w_levels(const enc_factor_unit *unit, const uint32_t words[ENC_STORE_WORDS], int16_t *out);
void enc_store_u_levels(const enc_factor_unit *unit, const uint32_t first[ENC_STORE_WORDS],
                        const uint32_t second[ENC_STORE_WORDS], int16_t *out);

/* Levels of all units of a texel, [component]; `texels` are those of a layer. */
void enc_store_texel_levels(const enc_factor_unit *units, size_t count, const uint32_t *texel_words,
                            size_t texels, size_t texel, int16_t *out);

/* Writes the codes of these levels, [component], to a texel whose words are 0. */
void enc_store_pack_texel(const enc_factor_unit *units, size_t count, const int16_t *levels, size_t texels,
                          size_t texel, uint32_t *texel_words);

void enc_store_clear(enc_factor_store *factors);

#endif
