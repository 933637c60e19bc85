/* Chooses the part and the channels of an OpenEXR file that make the picture.
 *
 * SPDX-License-Identifier: MIT
 */
#include "exr_choose.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* Everything in the file that could be meant. */
typedef struct choices {
    int count, room;
    exr_choice *of;
} choices;

static bool is_deep(exr_const_context_t context, int part) {
    exr_storage_t storage;
    return exr_get_storage(context, part, &storage) != EXR_ERR_SUCCESS ||
           (storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED);
}

static const char *part_name(exr_const_context_t context, int part) {
    const char *name = NULL;
    return exr_get_name(context, part, &name) == EXR_ERR_SUCCESS && name ? name : "";
}

void exr_part_text(exr_const_context_t context, int part, char *out, size_t size) {
    const char *name = part_name(context, part);
    if (name[0]) {
        snprintf(out, size, "part \"%.60s\"", name);
    } else {
        snprintf(out, size, "part %d", part + 1);
    }
}

static bool usable(double nm) {
    return nm >= 100.0 && nm <= 10000.0;
}

/* "390.00-410.00", as Mitsuba names its bands: the middle, and where the number begins. */
static bool band_middle(const char *name, size_t end, double *out_nm, size_t *out_begin) {
    size_t begin = end;
    while (begin > 0 && (isdigit((unsigned char)name[begin - 1]) || strchr(".-", name[begin - 1]))) {
        begin--;
    }
    while (begin < end && !isdigit((unsigned char)name[begin])) { /* the dot that ends a layer's name */
        begin++;
    }
    char *after;
    const double from = strtod(name + begin, &after);
    if (*after != '-' || !isdigit((unsigned char)after[1])) {
        return false;
    }
    const double to = strtod(after + 1, &after);
    *out_nm = 0.5 * (from + to);
    *out_begin = begin;
    return after == name + end && from < to && usable(from) && usable(to);
}

bool exr_wavelength(const char *name, double *out_nm, size_t *out_layer_length) {
    const size_t length = strlen(name);
    if (length < 5 || strcasecmp(name + length - 2, "nm") != 0) {
        return false;
    }
    const size_t end = length - 2;
    size_t first;
    if (band_middle(name, end, out_nm, &first) && (first == 0 || name[first - 1] == '.')) {
        *out_layer_length = first > 0 ? first - 1 : 0;
        return true;
    }
    size_t begin = end;
    while (begin > 0 && isdigit((unsigned char)name[begin - 1])) {
        begin--;
    }
    if (begin == end) {
        return false;
    }
    double value = strtod(name + begin, NULL), weight = 0.1;
    if (begin > 1 && strchr(".,", name[begin - 1]) && isdigit((unsigned char)name[begin - 2])) {
        size_t whole = begin - 1;
        while (whole > 0 && isdigit((unsigned char)name[whole - 1])) {
            whole--;
        }
        double decimal = 0.0;
        for (size_t i = whole; i < begin - 1; i++) {
            decimal = 10.0 * decimal + (name[i] - '0');
        }
        for (size_t i = begin; i < end; i++, weight *= 0.1) {
            decimal += weight * (name[i] - '0');
        }
        if (usable(decimal)) { /* else "S0.400nm": the dot ends the layer's name */
            value = decimal;
            begin = whole;
        }
    }
    if (begin > 0 && tolower((unsigned char)name[begin - 1]) == 'w' &&
        (begin == 1 || name[begin - 2] == '.')) {
        begin--;
    }
    if (begin > 0 && name[begin - 1] != '.') {
        return false;
    }
    *out_nm = value;
    *out_layer_length = begin > 0 ? begin - 1 : 0;
    return usable(value);
}

/* The part of a channel's name before its last dot. */
static size_t layer_length(const char *name) {
    const char *dot = strrchr(name, '.');
    return dot ? (size_t)(dot - name) : 0;
}

static int by_name(const void *key, const void *entry) {
    return strcmp(key, ((const exr_attr_chlist_entry_t *)entry)->name.str);
}

/* The number of the channel of a layer with one of the names, "R" or "red|Red|RED"; -1. OpenEXRCore keeps the
 * list in the order of the names. */
static int find(const exr_attr_chlist_t *list, const char *layer, const char *names) {
    for (const char *n = names; *n;) {
        const int size = (int)strcspn(n, "|");
        char name[300];
        snprintf(name, sizeof name, "%s%s%.*s", layer, layer[0] ? "." : "", size, n);
        const exr_attr_chlist_entry_t *entry =
            bsearch(name, list->entries, (size_t)list->num_channels, sizeof *list->entries, by_name);
        if (entry) {
            return (int)(entry - list->entries);
        }
        n += size + (n[size] == '|');
    }
    return -1;
}

/* Finds the picture that a layer holds, if any. Luminance with only one of its two channels of chroma is none: it would
 * come out grey. */
static bool picture_of(const exr_attr_chlist_t *list, exr_choice *choice) {
    static const struct {
        exr_kind kind;
        const char *names[3];
    } sets[] = {
        {EXR_KIND_RGB, {"R", "G", "B"}},
        {EXR_KIND_XYZ, {"X", "Y", "Z"}},
        {EXR_KIND_CHROMA, {"RY", "Y", "BY"}},
        {EXR_KIND_RGB, {"r", "g", "b"}},
        {EXR_KIND_RGB, {"red|Red|RED", "green|Green|GREEN", "blue|Blue|BLUE"}},
        {EXR_KIND_GREY, {"Y", NULL, NULL}},
    };
    for (size_t s = 0; s < sizeof sets / sizeof *sets; s++) {
        int found = 0, wanted = 0;
        for (; wanted < 3 && sets[s].names[wanted]; wanted++) {
            choice->channel[wanted] = find(list, choice->layer, sets[s].names[wanted]);
            found += choice->channel[wanted] >= 0;
        }
        choice->kind = sets[s].kind;
        if (found == wanted) {
            return true;
        }
        if (choice->kind == EXR_KIND_CHROMA && found == 2 && choice->channel[1] >= 0) {
            return false;
        }
    }
    return false;
}

static bool has(const choices *all, int part, const char *layer, bool spectrum) {
    for (int i = 0; i < all->count; i++) {
        if (all->of[i].part == part && strcmp(all->of[i].layer, layer) == 0 &&
            (all->of[i].kind == EXR_KIND_SPECTRUM) == spectrum) {
            return true;
        }
    }
    return false;
}

/* False when out of memory. */
static bool add(choices *all, const exr_choice *choice) {
    if (all->count == all->room) {
        exr_choice *more = realloc(all->of, (size_t)(2 * all->room + 16) * sizeof *more);
        if (!more) {
            return false;
        }
        all->of = more;
        all->room = 2 * all->room + 16;
    }
    all->of[all->count++] = *choice;
    return true;
}

/* Adds what the layer of one channel holds; false when out of memory. */
static bool collect_layer(const exr_attr_chlist_t *list, int part, const char *name, choices *all) {
    exr_choice choice = {.part = part};
    double nm;
    size_t length;
    const bool spectral = exr_wavelength(name, &nm, &length);
    if (!spectral) {
        length = layer_length(name);
    }
    if (length >= sizeof choice.layer) {
        return true;
    }
    memcpy(choice.layer, name, length);
    if (has(all, part, choice.layer, spectral)) {
        return true;
    }
    int bands = 0;
    for (int i = 0; i < list->num_channels && spectral; i++) {
        size_t other;
        bands += exr_wavelength(list->entries[i].name.str, &nm, &other) && other == length &&
                 strncmp(list->entries[i].name.str, name, length) == 0;
    }
    if (spectral) {
        choice.kind = EXR_KIND_SPECTRUM;
    }
    /* S1, S2 and S3 are the polarised components of the Stokes vector whose S0 is the light */
    if (spectral
            ? bands >= 4 && !(choice.layer[0] == 'S' && strchr("123", choice.layer[1]) && choice.layer[1])
            : picture_of(list, &choice)) {
        return add(all, &choice);
    }
    return true;
}

/* The channels of each layer are looked for among all, which is slow with more of them. */
enum { MOST_CHANNELS = 4096 };

/* Refuses a part of too many channels. */
static bool count_fits(exr_const_context_t context, char *message, size_t message_size) {
    int parts = 0;
    exr_get_count(context, &parts);
    for (int p = 0; p < parts; p++) {
        const exr_attr_chlist_t *list;
        if (exr_get_channels(context, p, &list) != EXR_ERR_SUCCESS || list->num_channels <= MOST_CHANNELS) {
            continue;
        }
        snprintf(message, message_size, "EXR: a part has %d channels; at most %d can be read",
                 (int)list->num_channels, MOST_CHANNELS);
        return false;
    }
    return true;
}

/* False when out of memory. */
static bool collect(exr_const_context_t context, choices *all) {
    int parts = 0;
    exr_get_count(context, &parts);
    for (int p = 0; p < parts; p++) {
        const exr_attr_chlist_t *list;
        if (is_deep(context, p) || exr_get_channels(context, p, &list) != EXR_ERR_SUCCESS) {
            continue;
        }
        for (int i = 0; i < list->num_channels; i++) {
            if (!collect_layer(list, p, list->entries[i].name.str, all)) {
                return false;
            }
        }
    }
    return true;
}

/* Lists parts and channels for a message, cut off where there is no more room. */
static void list_all(exr_const_context_t context, char *out, size_t size) {
    int parts = 0;
    size_t used = 0;
    exr_get_count(context, &parts);
    for (int p = 0; p < parts && used < size; p++) {
        const exr_attr_chlist_t *list;
        char text[80];
        exr_part_text(context, p, text, sizeof text);
        used += (size_t)snprintf(out + used, size - used, "%s%s%s has", p ? "; " : "", text,
                                 is_deep(context, p) ? " (deep data)" : "");
        for (int i = 0; exr_get_channels(context, p, &list) == EXR_ERR_SUCCESS && i < list->num_channels &&
                        used < size;
             i++) {
            used += (size_t)snprintf(out + used, size - used, "%s%.60s", i ? ", " : " ",
                                     list->entries[i].name.str);
        }
    }
    if (used >= size && size > 4) {
        memcpy(out + size - 4, "...", 4);
    }
}

/* The order in which choices that nobody named are preferred: colour, then grey. X, Y, Z in a layer are
 * positions or normals. */
static int rank(const exr_choice *c) {
    if (c->kind == EXR_KIND_XYZ && c->layer[0]) {
        return 2;
    }
    return c->kind == EXR_KIND_GREY;
}

/* The choice that nobody needs to name; NULL. */
static const exr_choice *plain_choice(const choices *all) {
    const exr_choice *first = NULL, *only[3] = {NULL, NULL, NULL};
    int count[3] = {0, 0, 0}; /* by rank */
    for (int i = 0; i < all->count; i++) {
        const exr_choice *c = &all->of[i];
        if (c->part == 0 && !c->layer[0] && c->kind != EXR_KIND_SPECTRUM) {
            first = c;
        } else if (count[rank(c)]++ == 0) {
            only[rank(c)] = c;
        }
    }
    if (first && (first->kind != EXR_KIND_GREY || count[0] == 0)) {
        return first;
    }
    if (!first && count[0] > 0) {
        return count[0] == 1 ? only[0] : NULL;
    }
    return !first && count[1] == 1 ? only[1] : NULL;
}

/* Whether `layer` names a choice: 3 as its layer, 2 as PART.LAYER, 1 as its part, 0 not. */
static int named(exr_const_context_t context, const exr_choice *c, const char *layer) {
    const char *part = part_name(context, c->part);
    const size_t length = strlen(part);
    if (c->layer[0] && strcmp(c->layer, layer) == 0) {
        return 3;
    }
    if (c->kind == EXR_KIND_SPECTRUM && strcasecmp(layer, "spectral") == 0) {
        return 3;
    }
    if (!length || strncmp(layer, part, length) != 0) {
        return 0;
    }
    if (c->layer[0] && layer[length] == '.' && strcmp(layer + length + 1, c->layer) == 0) {
        return 2;
    }
    return layer[length] == '\0' ? 1 : 0;
}

static bool choose_named(exr_const_context_t context, const choices *all, const char *layer,
                         exr_choice *out_choice) {
    int best = 0, count = 0;
    for (int i = 0; i < all->count; i++) {
        int how = 2 * named(context, &all->of[i], layer);
        how += how == 2 && !all->of[i].layer[0]; /* of a named part, what belongs to no layer */
        count = how > best ? 1 : count + (how > 0 && how == best);
        if (how > best) {
            *out_choice = all->of[i];
        }
        best = how > best ? how : best;
    }
    if (count > 0) {
        return count == 1;
    }
    int parts = 0;
    exr_get_count(context, &parts);
    for (int p = 0; p < parts; p++) {
        const exr_attr_chlist_t *list;
        if (is_deep(context, p) || exr_get_channels(context, p, &list) != EXR_ERR_SUCCESS) {
            continue;
        }
        for (int i = 0; i < list->num_channels; i++) {
            if (strcmp(list->entries[i].name.str, layer) == 0) {
                *out_choice = (exr_choice){.part = p, .kind = EXR_KIND_GREY, .channel = {i}};
                count++;
            }
        }
    }
    return count == 1;
}

static void note_choice(exr_const_context_t context, const choices *all, const exr_choice *c,
                        const char *layer, image_info *info) {
    char part[80];
    exr_part_text(context, c->part, part, sizeof part);
    if (!layer && (c->part > 0 || c->layer[0])) {
        image_note(info, IMAGE_NOTE_LAYER, "EXR: read from %s%s%.80s", part, c->layer[0] ? ", layer " : "",
                   c->layer);
    }
    for (int i = 0; i < all->count && !layer; i++) {
        const exr_choice *other = &all->of[i];
        if (other->part == c->part && other->kind != EXR_KIND_SPECTRUM) {
            continue;
        }
        if (other->part == c->part && c->kind == EXR_KIND_SPECTRUM) {
            continue;
        }
        if (other->part == c->part) {
            image_note(info, IMAGE_NOTE_PARTS,
                       "EXR: the picture of %s is read, not its spectrum (option layer: \"spectral\" reads "
                       "the spectrum)",
                       part);
        } else if (rank(other) <= rank(c) && (!other->layer[0] || other->kind == EXR_KIND_SPECTRUM)) {
            char beside[80];
            exr_part_text(context, other->part, beside, sizeof beside);
            image_note(info, IMAGE_NOTE_PARTS,
                       "EXR: %s is read, not the %s in %s (option layer picks another)", part,
                       other->kind == EXR_KIND_SPECTRUM ? "spectrum" : "picture", beside);
        }
    }
}

btf_result exr_choose(exr_const_context_t context, const char *layer, exr_choice *out_choice,
                      image_info *info, char *message, size_t message_size) {
    choices all = {0};
    if (!count_fits(context, message, message_size)) {
        return BTF_ERROR_UNSUPPORTED;
    }
    if (!collect(context, &all)) {
        free(all.of);
        return BTF_ERROR_MEMORY;
    }
    const exr_choice *plain = layer ? NULL : plain_choice(&all);
    if (plain) {
        *out_choice = *plain;
    }
    const bool found = plain || (layer && choose_named(context, &all, layer, out_choice));
    if (found) {
        note_choice(context, &all, out_choice, layer, info);
    } else {
        char list[600];
        list_all(context, list, sizeof list);
        if (layer) {
            snprintf(message, message_size,
                     "EXR: option layer: '%.60s' does not name exactly one layer, part or channel: %s",
                     layer, list);
        } else if (all.count == 0) {
            snprintf(message, message_size,
                     "EXR: there are no channels R, G, B, nor X, Y, Z, nor Y, RY, BY, nor Y alone, nor "
                     "four of a spectrum (such as 400nm); option layer names one to read as grey: %s",
                     list);
        } else {
            snprintf(message, message_size,
                     "EXR: the file holds several pictures; option layer picks one: %s", list);
        }
    }
    free(all.of);
    return found ? BTF_OK : BTF_ERROR_UNSUPPORTED;
}
