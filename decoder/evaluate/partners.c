/* Shares out the edges of a triangulation among its vertices. See partners.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "partners.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { NONE = BTFI_NO_PARTNER };

typedef struct sharing {
    uint32_t count;
    uint16_t (*of)[BTFI_PARTNERS]; /* the partners of each view, NONE where it has fewer */
    uint16_t *from, *queue; /* of a search: the view whose partner each was found as, and the views found */
} sharing;

/* The place of a partner, or of room for one (NONE), among those of a view; BTFI_PARTNERS: it is not there. */
static int place_of(const sharing *s, uint32_t view, uint32_t partner) {
    int k = 0;
    while (k < BTFI_PARTNERS && s->of[view][k] != partner) {
        k++;
    }
    return k;
}

/* Makes room for a partner of a view: goes from partner to partner to the nearest view that has room, then turns round
 * the edges on the way there. False where there is no way. */
static bool make_room(sharing *s, uint32_t view) {
    uint32_t first = 0, end = 0;
    for (uint32_t i = 0; i < s->count; i++) {
        s->from[i] = NONE;
    }
    s->from[view] = s->queue[end++] = (uint16_t)view;
    while (first < end) {
        uint32_t at = s->queue[first++];
        if (place_of(s, at, NONE) < BTFI_PARTNERS) {
            while (at != view) {
                const uint32_t before = s->from[at];
                s->of[at][place_of(s, at, NONE)] = (uint16_t)before;
                s->of[before][place_of(s, before, at)] = NONE;
                at = before;
            }
            return true;
        }
        for (int k = 0; k < BTFI_PARTNERS; k++) {
            const uint16_t next = s->of[at][k];
            if (s->from[next] == NONE) {
                s->from[next] = (uint16_t)at;
                s->queue[end++] = next;
            }
        }
    }
    return false;
}

/* Makes two views partners, unless they are. */
static bool share(sharing *s, uint32_t a, uint32_t b) {
    if (a == b || place_of(s, a, b) < BTFI_PARTNERS || place_of(s, b, a) < BTFI_PARTNERS) {
        return true;
    }
    const bool by_a = make_room(s, a);
    if (!by_a && !make_room(s, b)) {
        return false;
    }
    const uint32_t owner = by_a ? a : b;
    s->of[owner][place_of(s, owner, NONE)] = (uint16_t)(by_a ? b : a);
    return true;
}

/* Triangles have three sides, and beyond the hull the ends of its nearest edge are neighbours. */
static bool share_all(sharing *s, const btf_directions *views) {
    for (uint32_t i = 0; i < 3 * views->triangle_count; i++) {
        const uint32_t next = i % 3 == 2 ? i - 2 : i + 1;
        if (!share(s, views->triangles[i], views->triangles[next])) {
            return false;
        }
    }
    for (uint32_t i = 0; i < views->hull_count; i++) {
        if (!share(s, views->hull[i], views->hull[(i + 1) % views->hull_count])) {
            return false;
        }
    }
    return true;
}

btf_result btfi_fold_partners(const btf_directions *views, uint32_t **out_codes) {
    const size_t n = views->count;
    *out_codes = NULL;
    if (n > BTFI_MOST_PARTNERED) {
        return BTF_ERROR_UNSUPPORTED;
    }
    sharing s = {.count = views->count,
                 .of = malloc(n * sizeof *s.of),
                 .from = malloc(n * sizeof *s.from),
                 .queue = malloc(n * sizeof *s.queue)};
    uint32_t *codes = malloc(n * sizeof *codes);
    btf_result result = s.of && s.from && s.queue && codes ? BTF_OK : BTF_ERROR_MEMORY;
    for (size_t i = 0; i < n && !result; i++) {
        for (int k = 0; k < BTFI_PARTNERS; k++) {
            s.of[i][k] = NONE;
        }
    }
    if (!result && !share_all(&s, views)) {
        result = BTF_ERROR_UNSUPPORTED;
    }
    for (size_t i = 0; i < n && !result; i++) {
        codes[i] = 0;
        for (int k = 0; k < BTFI_PARTNERS; k++) {
            codes[i] |= (uint32_t)s.of[i][k] << (BTFI_PARTNER_BITS * k);
        }
    }
    free(s.of);
    free(s.from);
    free(s.queue);
    if (result) {
        free(codes);
        codes = NULL;
    }
    *out_codes = codes;
    return result;
}
