/* From the names of images to a full grid of views and lights.
 *
 * SPDX-License-Identifier: MIT
 */
#include "grid.h"

#include "names.h"
#include "names_table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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
    if (theta > ENC_GRID_SAME) {
        phi = (options->azimuth_cw ? -phi : phi) + options->azimuth_offset;
    }
    phi = fmod(phi, 360.0);
    if (phi < 0.0) {
        phi += 360.0;
    }
    phi = round(phi * 1e9) / 1e9;
    return phi >= 360.0 ? 0.0 : phi + 0.0;
}

static int compare_directions(const void *a, const void *b) {
    const named_direction *x = a, *y = b;
    if (x->theta != y->theta) {
        return x->theta < y->theta ? -1 : 1;
    }
    if (x->phi != y->phi) {
        return x->phi < y->phi ? -1 : 1;
    }
    return (x->source > y->source) - (x->source < y->source);
}

/* Sorts a list and drops repeated directions (the earliest file stays). Returns the new length. */
static size_t sort_unique(named_direction *list, size_t count) {
    size_t kept = 0;
    qsort(list, count, sizeof *list, compare_directions);
    for (size_t i = 0; i < count; i++) {
        if (kept == 0 || list[i].theta != list[kept - 1].theta || list[i].phi != list[kept - 1].phi) {
            list[kept++] = list[i];
        }
    }
    return kept;
}

static int find_direction(const named_direction *list, size_t count, const named_direction *wanted) {
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

/* One angle of an image, while equal ones are sought. */
typedef struct noisy_angle {
    double value;
    double *place;
} noisy_angle;

static int compare_noisy(const void *a, const void *b) {
    const noisy_angle *x = a, *y = b;
    return (x->value > y->value) - (x->value < y->value);
}

/* How far an angle is from a thousandth of a degree: little in those that are as somebody wrote them, more
 * in those that were computed. */
static double untidiness(double value) {
    return fabs(value * 1e3 - round(value * 1e3));
}

/* Gives angles that lie within a thousandth of a degree the value of the tidiest among them. */
static void join_equal(noisy_angle *list, size_t count) {
    qsort(list, count, sizeof *list, compare_noisy);
    for (size_t begin = 0, end; begin < count; begin = end) {
        double best = list[begin].value;
        for (end = begin; end < count && list[end].value - list[begin].value <= ENC_GRID_SAME; end++) {
            if (untidiness(list[end].value) < untidiness(best) || (best < 0.0 && list[end].value >= 0.0)) {
                best = list[end].value;
            }
        }
        for (size_t i = begin; i < end; i++) {
            *list[i].place = best < 0.0 ? best + 360.0 : best;
        }
    }
}

/* Computed angles carry noise (29.999999999999996): those within ENC_GRID_SAME of each other become one,
 * among the thetas and among the azimuths, on either side of 0 = 360 too. */
static btf_result join_angles(named_image *images, size_t count) {
    noisy_angle *list = malloc(2 * count * sizeof *list);
    if (!list) {
        return BTF_ERROR_MEMORY;
    }
    for (size_t i = 0; i < count; i++) {
        list[2 * i] = (noisy_angle){images[i].view.theta, &images[i].view.theta};
        list[2 * i + 1] = (noisy_angle){images[i].light.theta, &images[i].light.theta};
    }
    for (size_t i = 0; i < 2 * count; i++) {
        if (list[i].value <= ENC_GRID_SAME) {
            list[i].value = 0.0;
        }
    }
    join_equal(list, 2 * count);
    for (size_t i = 0; i < count; i++) {
        list[2 * i] = (noisy_angle){images[i].view.phi, &images[i].view.phi};
        list[2 * i + 1] = (noisy_angle){images[i].light.phi, &images[i].light.phi};
    }
    for (size_t i = 0; i < 2 * count; i++) {
        if (list[i].value >= 360.0 - ENC_GRID_SAME) {
            list[i].value -= 360.0;
        }
    }
    join_equal(list, 2 * count);
    free(list);
    return BTF_OK;
}

/* The names of a source as parsed, before it is settled how they are meant. */
typedef struct name_list {
    enc_name *names; /* [count] in the order of the source's paths */
    enc_name_verdict *verdicts;
    size_t n_read, n_incomplete, n_bad, n_counters, n_differ, n_foreign;
    size_t incomplete, bad, counter, differs; /* the first of each */
    bool dash_is_minus;
    size_t plain; /* the first name that says so */
    size_t n_frames, frame;
    size_t n_dashes[ENC_NAME_KEYS], dash[ENC_NAME_KEYS]; /* names with a dash right behind this key */
} name_list;

static void note_first(size_t *count, size_t *first, bool holds, size_t index) {
    if (holds && (*count)++ == 0) {
        *first = index;
    }
}

static btf_result list_names(const enc_source *source, name_list *out) {
    size_t n_plain = 0;
    *out = (name_list){.names = malloc((source->count + 1) * sizeof *out->names),
                       .verdicts = malloc((source->count + 1) * sizeof *out->verdicts)};
    if (!out->names || !out->verdicts) {
        return BTF_ERROR_MEMORY;
    }
    for (size_t i = 0; i < source->count; i++) {
        const enc_name *name = &out->names[i];
        const enc_name_verdict verdict = enc_names_parse(source->paths[i], &out->names[i]);
        out->verdicts[i] = verdict;
        out->n_read += verdict == ENC_NAME_READ;
        note_first(&out->n_incomplete, &out->incomplete, verdict == ENC_NAME_INCOMPLETE, i);
        note_first(&out->n_bad, &out->bad, verdict == ENC_NAME_BAD, i);
        note_first(&n_plain, &out->plain, verdict == ENC_NAME_READ && name->is_plain, i);
        note_first(&out->n_counters, &out->counter, verdict == ENC_NAME_READ && name->counter, i);
        note_first(&out->n_frames, &out->frame, verdict == ENC_NAME_READ && name->like_frame, i);
        for (int key = 0; key < ENC_NAME_KEYS; key++) {
            note_first(&out->n_dashes[key], &out->dash[key],
                       verdict == ENC_NAME_READ && name->open_sign[key], i);
        }
        note_first(&out->n_differ, &out->differs, verdict == ENC_NAME_READ && name->folders_differ, i);
    }
    out->dash_is_minus = n_plain > 0;
    return BTF_OK;
}

/* Refuses names that cannot be read for sure, and warns of images that were left out. */
static btf_result judge_names(const enc_context *context, const enc_source *source, const name_list *list) {
    if (list->n_bad > 0) {
        return enc_fail(
            context, BTF_ERROR_BAD_FILE,
            "%s: %zu images have an angle in their names that cannot be read for sure: first is %s: "
            "'%s': %s (rename the files, or give a table of the angles by option names)",
            source->location, list->n_bad, source->paths[list->bad], list->names[list->bad].bad,
            list->names[list->bad].why);
    }
    if (list->n_read == 0 && list->n_incomplete > 0) {
        return enc_fail(
            context, BTF_ERROR_BAD_FILE,
            "%s: of %zu images none has a name with tl, pl, tv and pv, each with one angle: first is "
            "%s (option names takes a table of the angles of files with other names)",
            source->location, list->n_incomplete, source->paths[list->incomplete]);
    }
    if (list->n_incomplete > 0) {
        enc_log(context, BTF_LOG_WARNING,
                "%s: %zu images are left out because their names lack tl, pl, tv or pv, or give one twice: "
                "first is %s",
                source->location, list->n_incomplete, source->paths[list->incomplete]);
    }
    if (list->n_counters > 0) {
        enc_log(context, BTF_LOG_WARNING,
                "%s: %zu images have digits behind their last angle, which are taken as a counter, not as "
                "decimals: first is %s",
                source->location, list->n_counters, source->paths[list->counter]);
    }
    if (list->n_frames == list->n_read && list->n_read > 1) {
        enc_log(context, BTF_LOG_WARNING,
                "%s: of each of the %zu images the last angle alone has decimals: are they a frame number? "
                "They are read as decimals: first is %s",
                source->location, list->n_frames, source->paths[list->frame]);
    }
    for (int key = 0; key < ENC_NAME_KEYS && list->dash_is_minus; key++) {
        if (list->n_dashes[key] == list->n_read && list->n_read > 1) {
            enc_log(
                context, BTF_LOG_WARNING,
                "%s: all %zu images have a dash behind the key %s, which is read as a minus, since other "
                "angles have none behind theirs: first is %s",
                source->location, list->n_read, enc_names_key(key), source->paths[list->dash[key]]);
        }
    }
    if (list->n_differ > 0) {
        enc_log(context, BTF_LOG_WARNING,
                "%s: %zu images lie in folders whose names give other angles than what stands nearer to "
                "the file, "
                "which counts: first is %s",
                source->location, list->n_differ, source->paths[list->differs]);
    }
    return BTF_OK;
}

/* Where the angles of an image come from, for messages. */
typedef struct origin {
    const enc_source *source;
    size_t index;
    bool from_dash; /* an angle is below 0 by a dash that is taken for a minus */
} origin;

static btf_result check_theta(const enc_context *context, const origin *o, const char *what, double theta) {
    if (theta >= 0.0 && theta < 90.0) {
        return BTF_OK;
    }
    return enc_fail(
        context, BTF_ERROR_BAD_FILE,
        "%s: %s: theta %g of the %s is not at least 0 and below 90: theta is the angle to the surface "
        "normal in degrees, not the elevation%s",
        o->source->location, o->source->paths[o->index], theta, what,
        theta < 0.0 && o->from_dash ? " (the dash is read as a minus, since other angles of this data "
                                      "set have none behind their keys)"
                                    : "");
}

/* Adds an image with the angles that its name or the table gives. */
static btf_result add_image(const enc_context *context, const enc_read_options *options, const origin *o,
                            const enc_angles *a, named_image *images, size_t *io_count) {
    btf_result result = check_theta(context, o, "light", a->theta_light);
    if (result == BTF_OK) {
        result = check_theta(context, o, "view", a->theta_view);
    }
    if (result != BTF_OK) {
        return result;
    }
    images[(*io_count)++] = (named_image){
        {a->theta_view, enc_grid_azimuth(options, a->theta_view, a->phi_view), a->phi_view, o->index},
        {a->theta_light, enc_grid_azimuth(options, a->theta_light, a->phi_light), a->phi_light, o->index},
        o->index,
    };
    return BTF_OK;
}

/* Tells of angles that are read as degrees and look like something else. */
static void doubt_units(const enc_context *context, const enc_source *source, const enc_angle_range *range,
                        const size_t example[2]) {
    static const char *const seen[] = {[ENC_RADIANS_ALL] = "angle reaches 6.3",
                                       [ENC_RADIANS_PHI] = "azimuth reaches 6.3",
                                       [ENC_RADIANS_THETA] = "theta reaches 1.58"};
    const enc_radians radians = enc_angles_look_like_radians(range);
    if (radians != ENC_RADIANS_NONE) {
        enc_log(context, BTF_LOG_WARNING,
                "%s: no %s and few apart from 0 are whole: they look like radians, but are read as "
                "degrees: first is %s",
                source->location, seen[radians], source->paths[example[0]]);
    }
    if (enc_angles_look_like_indices(range)) {
        enc_log(context, BTF_LOG_WARNING,
                "%s: all thetas are whole and below 10: they look like numbers of directions, but are read "
                "as degrees: first is %s",
                source->location, source->paths[example[0]]);
    }
    if (range->beyond > 0) {
        enc_log(
            context, BTF_LOG_WARNING,
            "%s: %zu azimuths lie beyond 360 degrees (are they gradians?) and are turned back: first is %s",
            source->location, range->beyond, source->paths[example[1]]);
    }
}

static void survey(enc_angle_range *range, const enc_angles *a, size_t index, size_t example[2]) {
    const size_t before[2] = {range->theta.broken + range->phi.broken, range->beyond};
    enc_angles_survey(range, a);
    if (before[0] == 0 && range->theta.broken + range->phi.broken > 0) {
        example[0] = index;
    }
    if (before[1] == 0 && range->beyond > 0) {
        example[1] = index;
    }
}

/* Lists images by the angles in their names. */
static btf_result take_names(const enc_context *context, const enc_source *source,
                             const enc_read_options *options, named_image *images, size_t *out_count) {
    name_list list;
    enc_angle_range range = {.count = 0};
    size_t example[2] = {0};
    btf_result result = list_names(source, &list);
    if (result == BTF_OK) {
        result = judge_names(context, source, &list);
    }
    for (size_t i = 0; i < source->count && result == BTF_OK; i++) {
        if (list.verdicts[i] != ENC_NAME_READ) {
            continue;
        }
        const enc_angles a = enc_names_angles(&list.names[i], list.dash_is_minus);
        const origin o = {source, i, list.dash_is_minus};
        result = add_image(context, options, &o, &a, images, out_count);
        survey(&range, &a, i, example);
    }
    if (result == BTF_OK) {
        doubt_units(context, source, &range, example);
    }
    free(list.names);
    free(list.verdicts);
    return result;
}

/* Images by a table, or by their names where it has none of them and need not. */
static btf_result take_table(const enc_context *context, const enc_source *source,
                             const enc_read_options *options, named_image *images, size_t *out_count) {
    enc_names_table *table = NULL;
    enc_angle_range range = {.count = 0};
    size_t example[2] = {0};
    btf_result result =
        enc_names_table_read(context, options->names, source, options->names_of_some, &table);
    if (result == BTF_OK && enc_names_table_count(table) == 0) {
        enc_names_table_destroy(&table);
        return take_names(context, source, options, images, out_count);
    }
    for (size_t i = 0; i < source->count && result == BTF_OK; i++) {
        const enc_angles *a = enc_names_table_angles(table, i);
        const origin o = {source, i, false};
        if (!a) {
            continue;
        }
        result = add_image(context, options, &o, a, images, out_count);
        survey(&range, a, i, example);
    }
    if (result == BTF_OK) {
        doubt_units(context, source, &range, example);
    }
    enc_names_table_destroy(&table);
    return result;
}

/* Finds every image's directions. *out_images is allocated here. */
static btf_result find_images(const enc_context *context, const enc_source *source,
                              const enc_read_options *options, named_image **out_images,
                              size_t *out_count) {
    named_image *images = malloc((source->count ? source->count : 1) * sizeof *images);
    *out_images = images;
    *out_count = 0;
    if (!images) {
        return BTF_ERROR_MEMORY;
    }
    if (source->n_foreign > 0) {
        enc_log(context, BTF_LOG_WARNING,
                "%s: %zu files of image formats that are not read are left out: first "
                "is %s",
                source->location, source->n_foreign, source->first_foreign);
    }
    btf_result result = options->names ? take_table(context, source, options, images, out_count)
                                       : take_names(context, source, options, images, out_count);
    if (result == BTF_OK && *out_count == 0) {
        result =
            enc_fail(context, BTF_ERROR_BAD_FILE, "%s: no JPEG, PNG, HDR or EXR image among its %zu files",
                     source->location, source->n_others);
    }
    if (result == BTF_OK) {
        result = join_angles(images, *out_count);
    }
    return result;
}

btf_result enc_grid_list(const enc_context *context, const enc_source *source,
                         const enc_read_options *options, enc_grid_image **out_images, size_t *out_count) {
    named_image *images = NULL;
    *out_images = NULL;
    btf_result result = find_images(context, source, options, &images, out_count);
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
static btf_result collect(const enc_context *context, const enc_source *source, const named_image *images,
                          size_t count, bool lights, named_direction **out_list, size_t *out_count) {
    const char *what = lights ? "light" : "view";
    named_direction *list = malloc(count * sizeof *list);
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
    for (size_t i = 0; directions && i < count; i++) {
        directions[i] = enc_direction_from_angles(list[i].theta, list[i].phi);
    }
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
    named_image *images = NULL;
    named_direction *views = NULL, *lights = NULL;
    size_t *owner = NULL;
    size_t count, n_views, n_lights;
    *out_grid = NULL;
    btf_result result = find_images(context, source, options, &images, &count);
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
