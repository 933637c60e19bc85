/* Numbers of the classes of the factors of format 2 (FORMAT.md), whose table is the model's.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_CLASSES_H
#define OPENBTF_ENCODER_FACTOR_CLASSES_H

#include "encoder/model/factor_store.h"

enum {
    ENC_FACTOR_CLASSES = 5,
    ENC_FACTOR_TIERS = 3,
    ENC_FACTOR_CHANNELS = 3, /* Y, C1, C2 */
    ENC_FACTOR_MOST_UNITS = 256,
    ENC_FACTOR_MOST_WORD = 16, /* components a word, at most */
    ENC_FACTOR_UNIT_WORDS = 4,
};

#endif
