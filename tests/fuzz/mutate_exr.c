/* A mutator that knows OpenEXR's layout: headers of named, typed attributes, then a table of offsets, then
 * chunks.
 *
 * SPDX-License-Identifier: MIT
 */
#include "fuzz.h"

#include <string.h>

size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size);

enum { MOST_ATTRIBUTES = 512, NAME = 256 };

typedef struct attribute {
    size_t begin, type, value, end; /* name, type and value start there */
} attribute;

typedef struct layout {
    attribute attributes[MOST_ATTRIBUTES];
    int count;
    size_t table;  /* the table of offsets starts there */
    size_t chunks; /* 8 bytes each */
} layout;

static uint32_t random_next(uint32_t *state) {
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

/* The end of a zero-terminated text, behind its zero; 0 when there is none. */
static size_t text_end(const uint8_t *data, size_t size, size_t at) {
    const uint8_t *zero = at < size ? memchr(data + at, 0, size - at < NAME ? size - at : NAME) : NULL;
    return zero ? (size_t)(zero - data) + 1 : 0;
}

static bool read_layout(const uint8_t *data, size_t size, layout *l) {
    memset(l, 0, sizeof *l);
    if (size < 9) {
        return false;
    }
    const bool many = data[5] & 0x10;
    size_t at = 8;
    for (bool first = true; l->count < MOST_ATTRIBUTES;) {
        if (at >= size) {
            return false;
        }
        if (data[at] == 0) { /* the end of a header; of all when it is empty or the only one */
            at++;
            if (!many || first) {
                break;
            }
            first = true;
            continue;
        }
        first = false;
        attribute *a = &l->attributes[l->count];
        int32_t bytes;
        a->begin = at;
        if (!(a->type = text_end(data, size, at)) || !(at = text_end(data, size, a->type)) ||
            size - at < 4) {
            return false;
        }
        memcpy(&bytes, data + at, 4);
        a->value = at + 4;
        if (bytes < 0 || (size_t)bytes > size - a->value) {
            return false;
        }
        at = a->end = a->value + (size_t)bytes;
        int32_t chunks;
        if (!strcmp((const char *)data + a->begin, "chunkCount") && bytes == 4) {
            memcpy(&chunks, data + a->value, 4);
            l->chunks += chunks > 0 && chunks < 100000 ? (size_t)chunks : 0;
        }
        l->count++;
    }
    l->table = at;
    if (l->chunks > (size - at) / 8) {
        l->chunks = (size - at) / 8;
    }
    return l->count > 0;
}

/* Moves all bytes from `end` on to `end + more`, and adjusts the offsets. Returns the new size, 0 when there is no
 * room. */
static size_t make_room(uint8_t *data, size_t size, size_t max_size, const layout *l, size_t end,
                        long more) {
    const size_t moved = (size_t)((long)size + more);
    if (moved > max_size) {
        return 0;
    }
    memmove(data + (long)end + more, data + end, size - end);
    for (size_t i = 0; i < l->chunks; i++) {
        uint64_t offset;
        uint8_t *entry = data + (long)l->table + more + 8 * (long)i;
        memcpy(&offset, entry, 8);
        offset += (uint64_t)more;
        memcpy(entry, &offset, 8);
    }
    return moved;
}

static void put_size(uint8_t *data, const attribute *a, size_t bytes) {
    const int32_t value = (int32_t)bytes;
    memcpy(data + a->value - 4, &value, 4);
}

/* Overwrites 4 bytes of the value with a number at some limit. */
static void put_number(uint8_t *data, const attribute *a, uint32_t *state) {
    static const uint32_t numbers[] = {
        0,          1,          2,          3,          255,        256,        257,        16384,
        16385,      65535,      65536,      0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 0x3F800000, 0x7F800000,
        0x7FC00000, 0x80000001, 0x33800000, 0x33000000, 0x4B800000, 0x4C000000, 0x477FE000, 0x38800000};
    const size_t words = (a->end - a->value) / 4;
    if (words) {
        memcpy(data + a->value + 4 * (random_next(state) % words),
               &numbers[random_next(state) % (sizeof numbers / sizeof *numbers)], 4);
    }
}

/* Replaces the value by `bytes` of `value`. */
static size_t put_value(uint8_t *data, size_t size, size_t max_size, const layout *l, const attribute *a,
                        const uint8_t *value, size_t bytes) {
    const size_t moved =
        make_room(data, size, max_size, l, a->end, (long)bytes - (long)(a->end - a->value));
    if (!moved) {
        return size;
    }
    memcpy(data + a->value, value, bytes);
    put_size(data, a, bytes);
    return moved;
}

static size_t mutate_attribute(uint8_t *data, size_t size, size_t max_size, const layout *l,
                               uint32_t *state) {
    static uint8_t buffer[1 << 16];
    const attribute *a = &l->attributes[random_next(state) % (uint32_t)l->count];
    const attribute *b = &l->attributes[random_next(state) % (uint32_t)l->count];
    const size_t bytes = a->end - a->value, whole = a->end - a->begin;
    size_t n, moved;
    switch (random_next(state) % 8) {
    case 0:
    case 1:
        put_number(data, a, state);
        return size;
    case 2:
        if (bytes) {
            LLVMFuzzerMutate(data + a->value, bytes, bytes);
        }
        return size;
    case 3:
        if (bytes > sizeof buffer / 2) {
            return size;
        }
        memcpy(buffer, data + a->value, bytes);
        n = LLVMFuzzerMutate(buffer, bytes, 2 * bytes + 16);
        return put_value(data, size, max_size, l, a, buffer, n);
    case 4: /* left out */
        return make_room(data, size, max_size, l, a->end, -(long)whole);
    case 5: /* twice */
        moved = make_room(data, size, max_size, l, a->end, (long)whole);
        if (moved) {
            memcpy(data + a->end, data + a->begin, whole);
        }
        return moved ? moved : size;
    case 6: /* the value of another one */
        n = b->end - b->value;
        if (n > sizeof buffer) {
            return size;
        }
        memcpy(buffer, data + b->value, n);
        return put_value(data, size, max_size, l, a, buffer, n);
    default: /* name and type, zeros included */
        LLVMFuzzerMutate(data + a->begin, a->value - a->begin, a->value - a->begin);
        return size;
    }
}

size_t fuzz_mutate_exr(uint8_t *data, size_t size, size_t max_size, unsigned seed) {
    static layout l;
    uint32_t state = seed * 2654435761u + 1;
    const uint32_t kind = random_next(&state) % 8;
    if (kind == 0 || !read_layout(data, size, &l)) {
        return LLVMFuzzerMutate(data, size, max_size);
    }
    if (kind < 3 && l.table < size) { /* changes offsets and chunks, without moving anything */
        const size_t at = l.table + random_next(&state) % (size - l.table);
        const size_t n = 1 + random_next(&state) % 64;
        LLVMFuzzerMutate(data + at, n < size - at ? n : size - at, n < size - at ? n : size - at);
        return size;
    }
    return mutate_attribute(data, size, max_size, &l, &state);
}
