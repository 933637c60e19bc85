/* Builds the full grid of views and lights from images of known directions. See grid.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "grid.h"

#include "named_images.h"

#include <stdlib.h>

static int compare_directions(const void *a, const void *b) {
    const enc_named_direction *x = a, *y = b;
    if (x->theta != y->theta) {
        return x->theta < y->theta ? -1 : 1;
    }
    if (x->phi != y->phi) {
        return x->phi < y->phi ? -1 : 1;
    }
    return (x->source > y->source) - (x->source < y->source);
}

/* Sorts a list and drops repeated directions (the earliest file stays). Returns the new length. */
static size_t sort_unique(enc_named_direction *list, size_t count) {
    size_t kept = 0;
    qsort(list, count, sizeof *list, compare_directions);
    for (size_t i = 0; i < count; i++) {
        if (kept == 0 || list[i].theta != list[kept - 1].theta || list[i].phi != list[kept - 1].phi) {
            list[kept++] = list[i];
        }
    }
    return kept;
}

static int find_direction(const enc_named_direction *list, size_t count,
                          const enc_named_direction *wanted) {
    size_t low = 0, high = count;
    while (high - low > 1) {
        const size_t middle = (low + high) / 2;
        if (list[middle].theta < wanted->theta ||
            (list[middle].theta == wanted->theta && list[middle].phi <= wanted->phi)) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return (int)low;
}

btf_result enc_grid_list(const enc_context *context, const enc_source *source,
                         const enc_read_options *options, enc_grid_image **out_images, size_t *out_count) {
    enc_named_image *images = NULL;
    *out_images = NULL;
    btf_result result = enc_named_images_find(context, source, options, &images, out_count);
    if (result == BTF_OK && !(*out_images = malloc(*out_count * sizeof **out_images))) {
        result = BTF_ERROR_MEMORY;
    }
    for (size_t i = 0; result == BTF_OK && i < *out_count; i++) {
        (*out_images)[i] = (enc_grid_image){
            .source = images[i].source,
            .view = enc_direction_from_angles(images[i].view.theta, images[i].view.phi),
            .light = enc_direction_from_angles(images[i].light.theta, images[i].light.phi)};
    }
    free(images);
    return result;
}

/* Collects the directions of one kind (views or lights) in paper order. */
static btf_result collect(const enc_context *context, const enc_source *source,
                          const enc_named_image *images, size_t count, bool lights,
                          enc_named_direction **out_list, size_t *out_count) {
    const char *what = lights ? "light" : "view";
    enc_named_direction *list = malloc(count * sizeof *list);
    *out_list = list;
    if (!list) {
        return BTF_ERROR_MEMORY;
    }
    for (size_t i = 0; i < count; i++) {
        list[i] = lights ? images[i].light : images[i].view;
    }
    const size_t n = sort_unique(list, count);
    *out_count = n;
    if (n > ENC_MAX_DIRECTIONS) {
        return enc_fail(context, BTF_ERROR_UNSUPPORTED, "%s: %zu %s directions, more than %d",
                        source->location, n, what, ENC_MAX_DIRECTIONS);
    }
    if (n > 1 && list[1].theta == 0.0) {
        return enc_fail(context, BTF_ERROR_BAD_FILE,
                        "%s: %s directions (0,%g) and (0,%g) are one, the pole: %s, %s", source->location,
                        what, list[0].given_phi, list[1].given_phi, source->paths[list[0].source],
                        source->paths[list[1].source]);
    }
    return BTF_OK;
}

/* Puts every image in its place: owner[view * n_lights + light] is its number among images + 1. */
static btf_result fill(const enc_context *context, const enc_source *source, const enc_named_image *images,
                       size_t count, const enc_named_direction *views, size_t n_views,
                       const enc_named_direction *lights, size_t n_lights, size_t *owner) {
    size_t duplicates = 0, missing = 0, first = 0, earlier = 0;
    const size_t total = n_views * n_lights;
    for (size_t i = 0; i < count; i++) {
        const size_t place = (size_t)find_direction(views, n_views, &images[i].view) * n_lights +
                             (size_t)find_direction(lights, n_lights, &images[i].light);
        if (owner[place] && duplicates++ == 0) {
            first = i;
            earlier = owner[place] - 1;
        }
        if (!owner[place]) {
            owner[place] = i + 1;
        }
    }
    if (duplicates > 0) {
        return enc_fail(
            context, BTF_ERROR_BAD_FILE,
            "%s: %zu images repeat a view and light: first is view (%g,%g) light (%g,%g): %s, %s",
            source->location, duplicates, images[first].view.theta, images[first].view.given_phi,
            images[first].light.theta, images[first].light.given_phi, source->paths[images[earlier].source],
            source->paths[images[first].source]);
    }
    for (size_t place = total; place-- > 0;) {
        if (!owner[place]) {
            missing++;
            first = place;
        }
    }
    if (missing > 0) {
        const enc_named_direction *v = &views[first / n_lights], *l = &lights[first % n_lights];
        return enc_fail(
            context, BTF_ERROR_BAD_FILE,
            "%s: %zu of %zu images are missing (%zu views, %zu lights): first is view (%g,%g) light "
            "(%g,%g)",
            source->location, missing, total, n_views, n_lights, v->theta, v->given_phi, l->theta,
            l->given_phi);
    }
    return BTF_OK;
}

static enc_direction *to_directions(const enc_named_direction *list, size_t count) {
    enc_direction *directions = malloc(count * sizeof *directions);
    for (size_t i = 0; directions && i < count; i++) {
        directions[i] = enc_direction_from_angles(list[i].theta, list[i].phi);
    }
    return directions;
}

static int by_source(const void *a, const void *b) {
    const enc_grid_item *x = a, *y = b;
    return (x->source > y->source) - (x->source < y->source);
}

static enc_grid *assemble(const enc_source *source, const enc_named_image *images,
                          const enc_named_direction *views, size_t n_views,
                          const enc_named_direction *lights, size_t n_lights, const size_t *owner) {
    enc_grid *grid = calloc(1, sizeof *grid);
    if (!grid) {
        return NULL;
    }
    grid->n_views = (int)n_views;
    grid->n_lights = (int)n_lights;
    grid->count = n_views * n_lights;
    grid->views = to_directions(views, n_views);
    grid->lights = to_directions(lights, n_lights);
    grid->items = malloc(grid->count * sizeof *grid->items);
    if (!grid->views || !grid->lights || !grid->items) {
        enc_grid_destroy(&grid);
        return NULL;
    }
    for (size_t place = 0; place < grid->count; place++) {
        grid->items[place] = (enc_grid_item){images[owner[place] - 1].source, (int)(place / n_lights),
                                             (int)(place % n_lights)};
    }
    if (source->is_sequential) {
        qsort(grid->items, grid->count, sizeof *grid->items, by_source);
    }
    return grid;
}

btf_result enc_grid_create(const enc_context *context, const enc_source *source,
                           const enc_read_options *options, enc_grid **out_grid) {
    enc_named_image *images = NULL;
    enc_named_direction *views = NULL, *lights = NULL;
    size_t *owner = NULL;
    size_t count, n_views, n_lights;
    *out_grid = NULL;
    btf_result result = enc_named_images_find(context, source, options, &images, &count);
    if (result == BTF_OK) {
        result = collect(context, source, images, count, false, &views, &n_views);
    }
    if (result == BTF_OK) {
        result = collect(context, source, images, count, true, &lights, &n_lights);
    }
    if (result == BTF_OK && views[0].theta > ENC_GRID_POLE_DISTANCE) {
        result = enc_fail(context, BTF_ERROR_BAD_FILE,
                          "%s: no top view: the view nearest to the surface normal is (%g,%g), more than "
                          "%g degrees from it: %s",
                          source->location, views[0].theta, views[0].given_phi, ENC_GRID_POLE_DISTANCE,
                          source->paths[views[0].source]);
    }
    if (result == BTF_OK && !(owner = calloc(n_views * n_lights, sizeof *owner))) {
        result = BTF_ERROR_MEMORY;
    }
    if (result == BTF_OK) {
        result = fill(context, source, images, count, views, n_views, lights, n_lights, owner);
    }
    if (result == BTF_OK) {
        *out_grid = assemble(source, images, views, n_views, lights, n_lights, owner);
        if (!*out_grid) {
            result = BTF_ERROR_MEMORY;
        }
    }
    free(owner);
    free(lights);
    free(views);
    free(images);
    return result;
}

void enc_grid_destroy(enc_grid **grid) {
    if (!grid || !*grid) {
        return;
    }
    free((*grid)->views);
    free((*grid)->lights);
    free((*grid)->items);
    free(*grid);
    *grid = NULL;
}
