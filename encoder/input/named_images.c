/* The images of a source with the angles that their names or a table give. See named_images.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "named_images.h"

#include "names.h"
#include "names_table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

double enc_named_azimuth(const enc_read_options *options, double theta, double phi) {
    if (theta > ENC_NAMED_SAME) {
        phi = (options->azimuth_cw ? -phi : phi) + options->azimuth_offset;
    }
    phi = fmod(phi, 360.0);
    if (phi < 0.0) {
        phi += 360.0;
    }
    phi = round(phi * 1e9) / 1e9;
    return phi >= 360.0 ? 0.0 : phi + 0.0;
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

/* How far an angle is from a whole number of thousandths of a degree: close to 0 for an angle as somebody
 * wrote it, more for one that was computed. */
static double untidiness(double value) {
    return fabs(value * 1e3 - round(value * 1e3));
}

/* Gives angles that lie within a thousandth of a degree the value of the tidiest among them. */
static void join_equal(noisy_angle *list, size_t count) {
    qsort(list, count, sizeof *list, compare_noisy);
    for (size_t begin = 0, end; begin < count; begin = end) {
        double best = list[begin].value;
        for (end = begin; end < count && list[end].value - list[begin].value <= ENC_NAMED_SAME; end++) {
            if (untidiness(list[end].value) < untidiness(best) || (best < 0.0 && list[end].value >= 0.0)) {
                best = list[end].value;
            }
        }
        for (size_t i = begin; i < end; i++) {
            *list[i].place = best < 0.0 ? best + 360.0 : best;
        }
    }
}

/* Joins angles within ENC_NAMED_SAME of each other, since computed ones carry noise (29.999999999999996):
 * thetas with thetas, azimuths with azimuths, also across 0 = 360. */
static btf_result join_angles(enc_named_image *images, size_t count) {
    noisy_angle *list = malloc(2 * count * sizeof *list);
    if (!list) {
        return BTF_ERROR_MEMORY;
    }
    for (size_t i = 0; i < count; i++) {
        list[2 * i] = (noisy_angle){images[i].view.theta, &images[i].view.theta};
        list[2 * i + 1] = (noisy_angle){images[i].light.theta, &images[i].light.theta};
    }
    for (size_t i = 0; i < 2 * count; i++) {
        if (list[i].value <= ENC_NAMED_SAME) {
            list[i].value = 0.0;
        }
    }
    join_equal(list, 2 * count);
    for (size_t i = 0; i < count; i++) {
        list[2 * i] = (noisy_angle){images[i].view.phi, &images[i].view.phi};
        list[2 * i + 1] = (noisy_angle){images[i].light.phi, &images[i].light.phi};
    }
    for (size_t i = 0; i < 2 * count; i++) {
        if (list[i].value >= 360.0 - ENC_NAMED_SAME) {
            list[i].value -= 360.0;
        }
    }
    join_equal(list, 2 * count);
    free(list);
    return BTF_OK;
}

/* The names of a source as parsed, before all of them together settle how they are meant. */
typedef struct name_list {
    enc_name *names; /* [count] in the order of the source's paths */
    enc_name_verdict *verdicts;
    size_t n_read, n_incomplete, n_bad, n_counters, n_differ, n_foreign;
    size_t incomplete, bad, counter, differs; /* the index of the first of each kind */
    bool dash_is_minus;
    size_t plain; /* the first name that says that a dash is a minus */
    size_t n_frames, frame;
    size_t n_dashes[ENC_NAME_KEYS],
        dash[ENC_NAME_KEYS]; /* how many names have a dash right behind this key,
                                                            and the first */
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
                            const enc_angles *a, enc_named_image *images, size_t *io_count) {
    btf_result result = check_theta(context, o, "light", a->theta_light);
    if (result == BTF_OK) {
        result = check_theta(context, o, "view", a->theta_view);
    }
    if (result != BTF_OK) {
        return result;
    }
    images[(*io_count)++] = (enc_named_image){
        {a->theta_view, enc_named_azimuth(options, a->theta_view, a->phi_view), a->phi_view, o->index},
        {a->theta_light, enc_named_azimuth(options, a->theta_light, a->phi_light), a->phi_light, o->index},
        o->index,
    };
    return BTF_OK;
}

/* Warns of angles that are read as degrees but look like something else. */
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
                             const enc_read_options *options, enc_named_image *images, size_t *out_count) {
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

/* Lists images by a table, or by their names where the table names none of them and need not. */
static btf_result take_table(const enc_context *context, const enc_source *source,
                             const enc_read_options *options, enc_named_image *images, size_t *out_count) {
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

btf_result enc_named_images_find(const enc_context *context, const enc_source *source,
                                 const enc_read_options *options, enc_named_image **out_images,
                                 size_t *out_count) {
    enc_named_image *images = malloc((source->count ? source->count : 1) * sizeof *images);
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
