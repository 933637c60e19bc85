/* OpenBTF: the views or lights that a restriction keeps. See subset.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "subset.h"

#include "decoder/reach.h"

#include <stdlib.h>
#include <string.h>

static bool same_array(const void *a, const void *b, size_t size) {
    return size == 0 || memcmp(a, b, size) == 0;
}

static bool same_directions(const btfi_directions *a, const btfi_directions *b) {
    return a->count == b->count && a->triangle_count == b->triangle_count &&
           a->hull_count == b->hull_count && a->grid == b->grid && a->cells_length == b->cells_length &&
           same_array(a->vertices, b->vertices, 2 * (size_t)a->count * sizeof *a->vertices) &&
           same_array(a->triangles, b->triangles, 3 * (size_t)a->triangle_count * sizeof *a->triangles) &&
           same_array(a->hull, b->hull, a->hull_count * sizeof *a->hull) &&
           same_array(a->cells, b->cells, a->cells_length * sizeof *a->cells);
}

static int compare_triangles(const void *a, const void *b) {
    const uint16_t *p = a, *q = b;
    for (int k = 0; k < 2; k++) {
        if (p[k] != q[k]) {
            return p[k] - q[k];
        }
    }
    return p[2] - q[2];
}

/* Whether a list has a triangle. It must have been triangulated by btfi_triangulate, which sorts triangles. */
static bool has_triangle(const btfi_directions *d, const uint16_t corner[3]) {
    return d->triangle_count > 0 && bsearch(corner, d->triangles, d->triangle_count,
                                            3 * sizeof *d->triangles, compare_triangles) != NULL;
}

static bool has_edge(const btfi_directions *d, const uint16_t corner[3], bool with_next) {
    for (uint32_t h = 0; h < d->hull_count; h++) {
        if (d->hull[h] == corner[0] && d->hull[(h + 1) % d->hull_count] == corner[1] &&
            (!with_next || d->hull[(h + 2) % d->hull_count] == corner[2])) {
            return true;
        }
    }
    return false;
}

/* Whether the triangulation of the subset holds every record that the range needs. */
static bool has_records(const btfi_directions *whole, const btfi_reach *reach, const btfi_subset *kept,
                        const btfi_directions *small) {
    uint16_t now[BTF_MAX_DIRECTIONS] = {0}, corner[3];
    for (uint32_t i = 0; i < kept->count; i++) {
        now[kept->number[i]] = (uint16_t)i;
    }
    for (uint32_t t = 0; t < whole->triangle_count; t++) {
        for (int k = 0; k < 3; k++) {
            corner[k] = now[whole->triangles[3 * (size_t)t + (size_t)k]];
        }
        if (reach->record[t] && !has_triangle(small, corner)) {
            return false;
        }
    }
    for (uint32_t h = 0; h < whole->hull_count; h++) {
        const uint8_t needed = reach->record[whole->triangle_count + h];
        for (uint32_t k = 0; k < 3; k++) {
            corner[k] = now[whole->hull[(h + k) % whole->hull_count]];
        }
        if (needed && kept->count > 1 && !has_edge(small, corner, (needed & BTFI_REACH_CORNER) != 0)) {
            return false;
        }
    }
    return true;
}

/* Whether a fixed direction has the same neighbours and weights in the subset. */
static bool same_answer(const btfi_directions *whole, const btfi_subset *kept, const btfi_directions *small,
                        const float direction[3]) {
    const btfi_neighbours a = btfi_neighbours_of(whole, direction, false),
                          b = btfi_neighbours_of(small, direction, false);
    bool same = a.count == b.count;
    for (uint32_t i = 0; same && i < a.count; i++) {
        same = a.index[i] == kept->number[b.index[i]] && a.weight[i] == b.weight[i];
    }
    return same;
}

/* Takes the directions for which `keep` [direction] is true; NULL: all. */
static void select_directions(const btfi_directions *whole, const bool *keep, btfi_subset *out) {
    out->count = 0;
    for (uint32_t i = 0; i < whole->count; i++) {
        if (!keep || keep[i]) {
            memcpy(out->xyz[out->count], whole->xyz + 3 * (size_t)i, sizeof out->xyz[0]);
            out->number[out->count++] = (uint16_t)i;
        }
    }
}

void btfi_subset_all(const btfi_directions *whole, btfi_subset *out_subset) {
    select_directions(whole, NULL, out_subset);
}

btf_result btfi_subset_choose(const btfi_directions *whole, const btf_range *range, const btf_log *log,
                              btfi_subset *out_subset) {
    const btfi_check check = {log, BTF_ERROR_MEMORY};
    btfi_reach reach;
    btfi_directions again = {0}, small = {0};
    btfi_reach_range(whole, range, &reach);
    select_directions(whole, reach.keep, out_subset);
    if (out_subset->count == whole->count) {
        return BTF_OK;
    }
    btf_result result = btfi_directions_build(&check, "directions", whole->count, whole->xyz, &again);
    if (result == BTF_OK) {
        result = btfi_directions_build(&check, "directions", out_subset->count, out_subset->xyz[0], &small);
    }
    if (result == BTF_OK && (!same_directions(whole, &again) ||
                             (range->fixed ? !same_answer(whole, out_subset, &small, range->direction)
                                           : !has_records(whole, &reach, out_subset, &small)))) {
        btfi_subset_all(whole, out_subset);
    }
    btfi_directions_clear(&again);
    btfi_directions_clear(&small);
    return result;
}
