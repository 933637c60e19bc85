/* Files of materials cut short, changed byte by byte, and taken apart and put together wrongly. Nothing may crash; a
 * refusal gives one message; a file that opens decodes to finite values. With the argument `long`, every byte takes
 * every value.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cases.h"

#include "decoder/toolkit/reference_view.h"
#include "tests/support/exr_edit.h"
#include "tests/support/factor_material.h"
#include "tests/support/messages.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct saved {
    const char *name;
    void *data;
    size_t size;
} saved;

/* Saves a small material, with lists of `entries` points a texel unless that is 0. */
static saved save_small(const char *name, btf_layout layout, uint32_t levels, uint32_t entries) {
    random_state r = {61};
    const uint32_t hidden = entries ? 0 : BTF_EFFECT_HIDDEN;
    const uint32_t effects = (BTF_EFFECT_VERSION_1 & ~(uint32_t)BTF_EFFECT_HIDDEN) | hidden;
    btf_material_desc desc = random_material_desc(2, 2, 3, 2, layout, effects);
    desc.info.lobes = 1;
    desc.info.components = 2;
    desc.info.centres = hidden ? 3 : 0;
    if (entries) {
        factor_material_list_points(&desc, entries);
    }
    desc.info.levels = levels;
    desc.info.half_float = levels > 1;
    const btf_level_error level_errors[2] = {{0, 30, 28, 100}, {1, 31, 29, 30}};
    const btf_material_error errors[1] = {{BTF_EFFECT_VERSION_1, 30, 28, 100}};
    desc.level_errors = level_errors;
    desc.level_error_count = levels;
    desc.errors = errors;
    desc.error_count = 1;
    random_material_fill(&r, &desc);
    btf_material *material;
    saved s = {.name = name};
    if (btf_material_create(&desc, NULL, &material) ||
        btf_material_save_memory(material, NULL, &s.data, &s.size)) {
        exit(99);
    }
    btf_material_close(&material);
    random_material_free(&desc);
    return s;
}

typedef enum outcome { REFUSED, OPENED, WRONG } outcome;

/* Opens bytes from a buffer of exactly their size, and decodes the material if they open. */
static outcome open_bytes(const void *data, size_t size) {
    static const float directions[3][3] = {{0, 0, 1}, {0.6f, 0, 0.8f}, {-0.48f, 0.64f, 0.6f}};
    btf_material *material = NULL;
    void *exact = malloc(size ? size : 1);
    if (!exact) {
        exit(99);
    }
    memcpy(exact, data, size);
    message_count = 0;
    const btf_result result = btf_material_open_memory(exact, size, &log_keep, &material);
    free(exact);
    outcome seen = result == BTF_OK ? OPENED : REFUSED;
    if ((result == BTF_OK) != (material != NULL) || message_count != (result != BTF_OK) ||
        (result != BTF_OK && result != BTF_ERROR_BAD_FILE && result != BTF_ERROR_UNSUPPORTED)) {
        seen = WRONG;
    }
    btf_material_info info = {.struct_size = sizeof info};
    if (material) {
        btf_material_get_info(material, &info);
    }
    for (uint32_t level = 0; level < info.levels; level++) {
        const btf_ref_options options = {BTF_EFFECT_ALL, UINT32_MAX, BTF_REF_LINEAR, BTF_REF_BILINEAR};
        btf_ref_material view;
        reference_view(material, level, &view);
        for (int i = 0; i < 9; i++) {
            float rgb[3];
            btf_ref_evaluate(&view, &options, 0.3f * (float)i, 0.4f, directions[i / 3], directions[i % 3],
                             rgb);
            for (int c = 0; c < 3; c++) {
                if (!isfinite(rgb[c]) || rgb[c] < 0) {
                    seen = WRONG;
                }
            }
        }
    }
    btf_material_close(&material);
    return seen;
}

static void try_prefixes(const saved *s) {
    char input[100];
    size_t opened = 0;
    for (size_t size = 0; size < s->size; size++) {
        opened += open_bytes(s->data, size) != REFUSED;
    }
    snprintf(input, sizeof input, "every prefix of a material, %s", s->name);
    cases_add(input, "refused with one message", opened == 0, "%zu of %zu not", opened, s->size);
}

/* Every byte with each of its bits flipped (in light runs one bit, in turn), as 0 and as 255; with `all` as every other
 * value. */
static void try_bytes(const saved *s, bool all) {
    const bool light = !all && getenv("BTF_TEST_LIGHT");
    char input[120];
    size_t counts[3] = {0};
    uint8_t *copy = malloc(s->size);
    if (!copy) {
        exit(99);
    }
    memcpy(copy, s->data, s->size);
    for (size_t at = 0; at < s->size; at++) {
        const uint8_t old = copy[at];
        for (int v = 0; v < (all ? 256 : 10); v++) {
            if (light && v < 8 && v != (int)(at % 8)) {
                continue;
            }
            copy[at] = (uint8_t)(all ? v : v < 8 ? old ^ 1 << v : v == 8 ? 0 : 255);
            if (copy[at] != old) {
                counts[open_bytes(copy, s->size)]++;
            }
        }
        copy[at] = old;
    }
    free(copy);
    snprintf(input, sizeof input, "every byte of a material, %s: %s", s->name,
             all ? "all other values" : "each bit turned, 0 and 255");
    cases_add(input, "refused with one message, or decodes to finite values", counts[WRONG] == 0,
              "%zu refused, %zu opened, %zu otherwise", counts[REFUSED], counts[OPENED], counts[WRONG]);
}

/* Saves the edited file, and returns the outcome of opening it. */
static outcome open_edited(edit_file *file) {
    void *data;
    size_t size;
    edit_save(file, &data, &size);
    edit_free(file);
    const outcome seen = open_bytes(data, size);
    free(data);
    return seen;
}

static int asked, refused;
static char complaint[300];

/* The file has to be refused, with `word` in the message. */
static void count_refusal(outcome seen, const char *word) {
    asked++;
    if (seen == REFUSED && strstr(last_message, word)) {
        refused++;
    } else if (!complaint[0]) {
        snprintf(complaint, sizeof complaint, "; %.60s: %.200s", word,
                 seen == REFUSED ? last_message : "opened");
    }
}

/* The edited file, which is freed, has to be refused. */
static void expect_refused(edit_file *file, const char *word) {
    count_refusal(open_edited(file), word);
}

/* One part under the name of another. EXR writers refuse that, so the bytes are changed. */
static void expect_renamed_refused(const saved *s, const char *part, const char *name) {
    uint8_t text[44] = {(uint8_t)strlen(part)}; /* its length, then the text */
    memcpy(text + 4, part, strlen(part));
    uint8_t *copy = malloc(s->size), *at;
    if (!copy) {
        exit(99);
    }
    memcpy(copy, s->data, s->size);
    at = memmem(copy, s->size, text, 4 + strlen(part));
    if (at) {
        memcpy(at + 4, name, strlen(name));
    }
    count_refusal(open_bytes(copy, s->size), at ? "repeated" : "the part's name is not in the file");
    free(copy);
}

static void add_refused(const char *what, const saved *s, const char *expected) {
    cases_add(told("%s, %s", what, s->name), expected, asked > 0 && asked == refused,
              "%d of %d refused so%s", refused, asked, complaint);
    asked = refused = 0;
    complaint[0] = 0;
}

/* Parts missing, repeated, renamed, resized, moved, or with other channels: each must be refused with the part's name.
 * A rename keeps the length of the name, since it is made in the bytes. */
static void try_parts(const saved *s) {
    edit_file *file = edit_load(s->data, s->size);
    const int count = file->part_count;
    char names[EDIT_PARTS][40];
    for (int p = 0; p < count; p++) {
        snprintf(names[p], sizeof names[p], "%s", file->parts[p].name);
    }
    edit_free(file);
    static const char *const named = "refused, the part named";

    for (int p = 0; p < count; p++) {
        file = edit_load(s->data, s->size);
        edit_remove_part(file, names[p]);
        expect_refused(file, names[p]);
    }
    add_refused("each part missing", s, named);
    for (int p = 0; p < count; p++) {
        file = edit_load(s->data, s->size);
        edit_copy_part(file, names[p], "level7.copy");
        expect_refused(file, "level7.copy");
    }
    add_refused("each part twice, under an unknown name", s, named);
    for (int p = 0; p < count; p++) {
        for (int q = 0; q < count; q++) {
            if (p != q && strlen(names[p]) == strlen(names[q])) {
                expect_renamed_refused(s, names[p], names[q]);
            }
        }
    }
    if (asked > 0) {
        add_refused("a part under the name of another, of the same length", s, "refused as repeated");
    }
    for (int p = 0; p < count; p++) {
        for (int change = 0; change < 6; change++) {
            file = edit_load(s->data, s->size);
            edit_part *part = edit_find_part(file, names[p]);
            static const int sides[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
            if (change < 4 && part->width + sides[change][0] > 0 && part->height + sides[change][1] > 0) {
                edit_resize(part, part->width + sides[change][0], part->height + sides[change][1]);
            } else if (change % 2) {
                part->min_x = -1;
            } else {
                part->min_y = 1;
            }
            expect_refused(file, names[p]);
        }
    }
    add_refused("each part a texel wider, taller, narrower, lower, or moved", s, named);
    for (int p = 0; p < count; p++) {
        file = edit_load(s->data, s->size);
        const int channels = edit_find_part(file, names[p])->channel_count;
        edit_free(file);
        for (int c = 0; c < channels; c++) {
            for (int change = 0; change < 2; change++) {
                file = edit_load(s->data, s->size);
                edit_part *part = edit_find_part(file, names[p]);
                char channel[40];
                snprintf(channel, sizeof channel, "%s", part->channels[c].name);
                if (channels == 1 && !change) {
                    snprintf(part->channels[c].name, sizeof part->channels[c].name, "other");
                } else {
                    edit_remove_channel(part, channel);
                    if (change) {
                        edit_add_channel(part, channel, EXR_PIXEL_UINT);
                    }
                }
                expect_refused(file, names[p]);
            }
        }
        file = edit_load(s->data, s->size);
        edit_add_channel(edit_find_part(file, names[p]), "zz", EXR_PIXEL_HALF);
        expect_refused(file, names[p]);
    }
    add_refused("each channel missing, of type UINT, or one too many", s, named);
}

static bool is_optional(const char *name) {
    static const char *const names[] = {"method", "options", "source", "errors", "levelErrors"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        if (!strcmp(name + strlen("openbtf."), names[i])) {
            return true;
        }
    }
    return false;
}

static void try_attributes(const saved *s) {
    edit_file *file = edit_load(s->data, s->size);
    const int count = file->attribute_count;
    static char names[EDIT_ATTRIBUTES][40];
    for (int i = 0; i < count; i++) {
        snprintf(names[i], sizeof names[i], "%s", file->attributes[i].name);
    }
    edit_free(file);
    for (int i = 0; i < count; i++) {
        file = edit_load(s->data, s->size);
        edit_remove_attribute(file, names[i]);
        /* openbtf.levels and lists of triangles may be missing; then the rest of the file contradicts that */
        if (is_optional(names[i])) {
            edit_free(file);
        } else {
            expect_refused(file, strstr(names[i], "levels")       ? "level"
                                 : strstr(names[i], "pointStore") ? "part point_"
                                 : strstr(names[i], "Triangles")  ? "s: "
                                 : strstr(names[i], "Hull")       ? "s: "
                                                                  : names[i]);
        }
    }
    add_refused("each attribute missing that is not optional", s,
                "refused, the attribute or what then lacks named");
    for (int i = 0; i < count; i++) {
        file = edit_load(s->data, s->size);
        edit_find_attribute(file, names[i])->type = EXR_ATTR_DOUBLE;
        expect_refused(file, strcmp(names[i], "openbtf.version") ? names[i] : "version");
    }
    add_refused("each attribute of type double", s, "refused, the attribute named");

    static const int32_t integers[] = {-1,    0,     3,     5,       17,        255,      257,
                                       16384, 16385, 65537, 1 << 24, INT32_MAX, INT32_MIN};
    static const float reals[] = {0.5f, -1, -0.0f, 1e30f, 0x1p-25f, 0x1p-149f, INFINITY, NAN, 300, 16385};
    size_t counts[3] = {0};
    for (int i = 0; i < count; i++) {
        for (size_t v = 0; v < 16; v++) {
            file = edit_load(s->data, s->size);
            edit_attribute *a = edit_find_attribute(file, names[i]);
            if (a->type == EXR_ATTR_INT && v < sizeof integers / sizeof *integers) {
                a->i = integers[v];
            } else if (a->type == EXR_ATTR_FLOAT && v < sizeof reals / sizeof *reals) {
                a->f = reals[v];
            } else if (a->type == EXR_ATTR_FLOAT_VECTOR && v < sizeof reals / sizeof *reals) {
                a->values[(v * 7) % (size_t)a->count] = reals[v];
            } else if (a->type == EXR_ATTR_FLOAT_VECTOR && v < 14 && a->count > 1) {
                a->count -= v < 12 ? 1 : a->count / 2;
            } else if (a->type == EXR_ATTR_STRING && v < 2 && a->text) {
                a->text[0] = v ? '\xff' : '\0';
            }
            counts[open_edited(file)]++;
        }
    }
    cases_add(told("each number of the header absurd or contradictory, %s", s->name),
              "refused with one message, or decodes to finite values",
              counts[WRONG] == 0 && counts[REFUSED] > 100, "%zu refused, %zu opened, %zu otherwise",
              counts[REFUSED], counts[OPENED], counts[WRONG]);

    file = edit_load(s->data, s->size);
    edit_find_attribute(file, "openbtf.version")->i = BTF_FORMAT_VERSION + 1;
    expect_refused(file, "version");
    file = edit_load(s->data, s->size);
    edit_find_attribute(file, "openbtf.version")->i = INT32_MAX;
    expect_refused(file, "version");
    add_refused("a newer version", s, "refused, the version named");
}

int main(int argc, char **argv) {
    const bool all = argc > 1 && !strcmp(argv[1], "long");
    const saved files[] = {save_small("layout paper", BTF_LAYOUT_PAPER, 1, 0),
                           save_small("layout tight", BTF_LAYOUT_TIGHT, 1, 0),
                           save_small("two levels of halves", BTF_LAYOUT_TIGHT, 2, 0),
                           save_small("lists of points", BTF_LAYOUT_TIGHT, 2, 6)};
    cases_title("Materials cut short, changed byte by byte, taken apart and put together wrong.");
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        if (!all) {
            try_prefixes(&files[i]);
        }
        try_bytes(&files[i], all);
        if (all) {
            continue;
        }
        try_parts(&files[i]);
        try_attributes(&files[i]);
    }
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        btf_free(files[i].data);
    }
    return cases_result();
}
