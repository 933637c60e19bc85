/* Fields of Bonn's binary .btf files. See fields.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "fields.h"

#include <openbtf/reference.h>

#include <math.h>
#include <string.h>

void enc_bonn_refuse(enc_bonn_cursor *c, btf_result result, uint64_t at, const char *field, const char *why,
                     double value) {
    if (c->result == BTF_OK) {
        c->result = enc_fail(c->context, result, "%s: field %s at byte %llu: %s %.9g", c->path, field,
                             (unsigned long long)at, why, value);
    }
}

const unsigned char *enc_bonn_take(enc_bonn_cursor *c, uint64_t size, const char *field) {
    if (c->result != BTF_OK) {
        return NULL;
    }
    if (size > c->size - c->at) {
        enc_bonn_refuse(c, BTF_ERROR_BAD_FILE, c->at, field,
                        "the file ends within this field, whose bytes number", (double)size);
        return NULL;
    }
    c->at += size;
    return c->bytes + c->at - size;
}

uint32_t enc_bonn_u32(const unsigned char *p) {
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

uint32_t enc_bonn_take_u32(enc_bonn_cursor *c, const char *field) {
    const unsigned char *p = enc_bonn_take(c, 4, field);
    return p ? enc_bonn_u32(p) : 0;
}

unsigned enc_bonn_take_u8(enc_bonn_cursor *c, const char *field) {
    const unsigned char *p = enc_bonn_take(c, 1, field);
    return p ? *p : 0;
}

float enc_bonn_take_float(enc_bonn_cursor *c, const char *field) {
    const unsigned char *p = enc_bonn_take(c, 4, field);
    const float value = p ? enc_bonn_number(p, 4) : 0.0f;
    if (!isfinite(value)) {
        enc_bonn_refuse(c, BTF_ERROR_BAD_FILE, c->at - 4, field, "is not a finite number:", (double)value);
    }
    return value;
}

uint32_t enc_bonn_take_count(enc_bonn_cursor *c, const char *field, uint32_t most) {
    const uint32_t value = enc_bonn_take_u32(c, field);
    if (value < 1 || value > most) {
        enc_bonn_refuse(c, value < 1 ? BTF_ERROR_BAD_FILE : BTF_ERROR_UNSUPPORTED, c->at - 4, field,
                        value < 1 ? "must not be" : "exceeds what this program reads:", value);
    }
    return c->result == BTF_OK ? value : 1;
}

unsigned enc_bonn_take_scalar(enc_bonn_cursor *c) {
    const unsigned scalar = enc_bonn_take_u8(c, "scalar size");
    if (scalar != 2 && scalar != 4 && scalar != 8) {
        enc_bonn_refuse(c, BTF_ERROR_BAD_FILE, c->at - 1, "scalar size", "must be 2, 4 or 8, not", scalar);
    }
    return scalar;
}

float enc_bonn_number(const unsigned char *at, unsigned scalar) {
    if (scalar == 2) {
        return btf_ref_half((uint16_t)(at[0] | at[1] << 8));
    }
    const uint64_t low = enc_bonn_u32(at);
    if (scalar == 4) {
        const uint32_t bits = (uint32_t)low;
        float value;
        memcpy(&value, &bits, sizeof value);
        return value;
    }
    const uint64_t bits = low | (uint64_t)enc_bonn_u32(at + 4) << 32;
    double value;
    memcpy(&value, &bits, sizeof value);
    return (float)value;
}
