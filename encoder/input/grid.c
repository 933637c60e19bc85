/* From the names of images to a full grid of views and lights.
 *
 * SPDX-License-Identifier: MIT
 */
#include "grid.h"

#include "names.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_DIRECTIONS = 256 };

/* A direction of one image: as the name gives it, and as it is used. */
typedef struct named_direction {
    double theta, phi;
    double given_phi;
    size_t source;
} named_direction;

/* One image whose name was understood. */
typedef struct named_image {
    named_direction view, light;
    size_t source;
} named_image;

double enc_grid_azimuth(const enc_read_options *options, double theta, double phi) {
    if (theta != 0.0)
        phi = (options->azimuth_cw ? -phi : phi) + options->azimuth_offset;
    phi = fmod(phi, 360.0);
    if (phi < 0.0)
        phi += 360.0;
    phi = round(phi * 1e9) / 1e9;
    return phi >= 360.0 ? 0.0 : phi + 0.0;
}

static int compare_directions(const void *a, const void *b) {
    const named_direction *x = a, *y = b;
    if (x->theta != y->theta)
        return x->theta < y->theta ? -1 : 1;
    if (x->phi != y->phi)
        return x->phi < y->phi ? -1 : 1;
    return (x->source > y->source) - (x->source < y->source);
}

/* Sorts a list and drops what occurs again (the earliest file stays). Returns the new length. */
static size_t sort_unique(named_direction *list, size_t count) {
    size_t kept = 0;
    qsort(list, count, sizeof *list, compare_directions);
    for (size_t i = 0; i < count; i++)
        if (kept == 0 || list[i].theta != list[kept - 1].theta || list[i].phi != list[kept - 1].phi)
            list[kept++] = list[i];
    return kept;
}

static int find_direction(const named_direction *list, size_t count, const named_direction *wanted) {
    size_t low = 0, high = count;
    while (high - low > 1) {
        const size_t middle = (low + high) / 2;
        if (list[middle].theta < wanted->theta ||
            (list[middle].theta == wanted->theta && list[middle].phi <= wanted->phi))
            low = middle;
        else
            high = middle;
    }
    return (int)low;
}

static btf_result check_angles(const enc_context *context, const enc_source *source, const char *what,
                               double theta, size_t index) {
    if (theta >= 0.0 && theta < 90.0)
        return BTF_OK;
    return enc_fail(context, BTF_ERROR_BAD_FILE,
                    "%s: %s: theta %g of the %s is not at least 0 and below 90", source->location,
                    source->paths[index], theta, what);
}

/* Understands every name that can be. *out_images is allocated here. */
static btf_result parse_names(const enc_context *context, const enc_source *source,
                              const enc_read_options *options, named_image **out_images,
                              size_t *out_count) {
    size_t count = 0, nameless = 0, first_nameless = 0;
    named_image *images = malloc((source->count ? source->count : 1) * sizeof *images);
    *out_images = images;
    if (!images)
        return BTF_ERROR_MEMORY;
    for (size_t i = 0; i < source->count; i++) {
        enc_angles a;
        if (!enc_names_parse(source->paths[i], &a)) {
            if (nameless++ == 0)
                first_nameless = i;
            continue;
        }
        btf_result result = check_angles(context, source, "light", a.theta_light, i);
        if (result == BTF_OK)
            result = check_angles(context, source, "view", a.theta_view, i);
        if (result != BTF_OK)
            return result;
        images[count++] = (named_image){
            {a.theta_view, enc_grid_azimuth(options, a.theta_view, a.phi_view), a.phi_view, i},
            {a.theta_light, enc_grid_azimuth(options, a.theta_light, a.phi_light), a.phi_light, i},
            i,
        };
    }
    *out_count = count;
    if (count == 0 && nameless > 0)
        return enc_fail(
            context, BTF_ERROR_BAD_FILE,
            "%s: of %zu images none has a name with tl, pl, tv and pv, each with one angle: first is %s",
            source->location, nameless, source->paths[first_nameless]);
    if (count == 0)
        return enc_fail(context, BTF_ERROR_BAD_FILE,
                        "%s: no JPEG, PNG, HDR or EXR image among its %zu files", source->location,
                        source->n_others);
    if (nameless > 0)
        enc_log(context, BTF_LOG_WARNING,
                "%s: %zu images are left out, their names lack tl, pl, tv or pv, or give one twice: first "
                "is %s",
                source->location, nameless, source->paths[first_nameless]);
    return BTF_OK;
}

/* Collects the directions of one kind (views or lights) in paper order. */
static btf_result collect(const enc_context *context, const enc_source *source, const named_image *images,
                          size_t count, bool lights, named_direction **out_list, size_t *out_count) {
    const char *what = lights ? "light" : "view";
    named_direction *list = malloc(count * sizeof *list);
    *out_list = list;
    if (!list)
        return BTF_ERROR_MEMORY;
    for (size_t i = 0; i < count; i++)
        list[i] = lights ? images[i].light : images[i].view;
    const size_t n = sort_unique(list, count);
    *out_count = n;
    if (n > MAX_DIRECTIONS)
        return enc_fail(context, BTF_ERROR_UNSUPPORTED, "%s: %zu %s directions, more than %d",
                        source->location, n, what, MAX_DIRECTIONS);
    if (n > 1 && list[1].theta == 0.0)
        return enc_fail(context, BTF_ERROR_BAD_FILE,
                        "%s: %s directions (0,%g) and (0,%g) are one, the pole: %s, %s", source->location,
                        what, list[0].given_phi, list[1].given_phi, source->paths[list[0].source],
                        source->paths[list[1].source]);
    return BTF_OK;
}

/* Puts every image in its place: owner[view * n_lights + light] is its number among images + 1. */
static btf_result fill(const enc_context *context, const enc_source *source, const named_image *images,
                       size_t count, const named_direction *views, size_t n_views,
                       const named_direction *lights, size_t n_lights, size_t *owner) {
    size_t duplicates = 0, missing = 0, first = 0, earlier = 0;
    const size_t total = n_views * n_lights;
    for (size_t i = 0; i < count; i++) {
        const size_t place = (size_t)find_direction(views, n_views, &images[i].view) * n_lights +
                             (size_t)find_direction(lights, n_lights, &images[i].light);
        if (owner[place] && duplicates++ == 0) {
            first = i;
            earlier = owner[place] - 1;
        }
        if (!owner[place])
            owner[place] = i + 1;
    }
    if (duplicates > 0)
        return enc_fail(
            context, BTF_ERROR_BAD_FILE,
            "%s: %zu images repeat a view and light: first is view (%g,%g) light (%g,%g): %s, %s",
            source->location, duplicates, images[first].view.theta, images[first].view.given_phi,
            images[first].light.theta, images[first].light.given_phi, source->paths[images[earlier].source],
            source->paths[images[first].source]);
    for (size_t place = total; place-- > 0;) {
        if (!owner[place]) {
            missing++;
            first = place;
        }
    }
    if (missing > 0) {
        const named_direction *v = &views[first / n_lights], *l = &lights[first % n_lights];
        return enc_fail(
            context, BTF_ERROR_BAD_FILE,
            "%s: %zu of %zu images are missing (%zu views, %zu lights): first is view (%g,%g) light "
            "(%g,%g)",
            source->location, missing, total, n_views, n_lights, v->theta, v->given_phi, l->theta,
            l->given_phi);
    }
    return BTF_OK;
}

static enc_direction *to_directions(const named_direction *list, size_t count) {
    enc_direction *directions = malloc(count * sizeof *directions);
    for (size_t i = 0; directions && i < count; i++)
        directions[i] = enc_direction_from_angles(list[i].theta, list[i].phi);
    return directions;
}

static int by_source(const void *a, const void *b) {
    const enc_grid_item *x = a, *y = b;
    return (x->source > y->source) - (x->source < y->source);
}

static enc_grid *assemble(const enc_source *source, const named_image *images, const named_direction *views,
                          size_t n_views, const named_direction *lights, size_t n_lights,
                          const size_t *owner) {
    enc_grid *grid = calloc(1, sizeof *grid);
    if (!grid)
        return NULL;
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
    for (size_t place = 0; place < grid->count; place++)
        grid->items[place] = (enc_grid_item){images[owner[place] - 1].source, (int)(place / n_lights),
                                             (int)(place % n_lights)};
    if (source->is_sequential)
        qsort(grid->items, grid->count, sizeof *grid->items, by_source);
    return grid;
}

btf_result enc_grid_create(const enc_context *context, const enc_source *source,
                           const enc_read_options *options, enc_grid **out_grid) {
    named_image *images = NULL;
    named_direction *views = NULL, *lights = NULL;
    size_t *owner = NULL;
    size_t count, n_views, n_lights;
    *out_grid = NULL;
    btf_result result = parse_names(context, source, options, &images, &count);
    if (result == BTF_OK)
        result = collect(context, source, images, count, false, &views, &n_views);
    if (result == BTF_OK)
        result = collect(context, source, images, count, true, &lights, &n_lights);
    if (result == BTF_OK && views[0].theta > ENC_GRID_POLE_DISTANCE)
        result = enc_fail(
            context, BTF_ERROR_BAD_FILE,
            "%s: no top view: the view nearest to the pole is (%g,%g), more than %g degrees off: %s",
            source->location, views[0].theta, views[0].given_phi, ENC_GRID_POLE_DISTANCE,
            source->paths[views[0].source]);
    if (result == BTF_OK && !(owner = calloc(n_views * n_lights, sizeof *owner)))
        result = BTF_ERROR_MEMORY;
    if (result == BTF_OK)
        result = fill(context, source, images, count, views, n_views, lights, n_lights, owner);
    if (result == BTF_OK) {
        *out_grid = assemble(source, images, views, n_views, lights, n_lights, owner);
        if (!*out_grid)
            result = BTF_ERROR_MEMORY;
    }
    free(owner);
    free(lights);
    free(views);
    free(images);
    return result;
}

void enc_grid_destroy(enc_grid **grid) {
    if (!grid || !*grid)
        return;
    free((*grid)->views);
    free((*grid)->lights);
    free((*grid)->items);
    free(*grid);
    *grid = NULL;
}
