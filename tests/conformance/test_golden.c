/* Files of both versions, written once and kept, with the bits that they decoded to then. Whatever changes in the
 * library, they must open and decode to the same bits. Some have what the encoder never writes: other compressions,
 * private parts, rows from below, extreme parameters, mixtures of classes, codes at their bounds.
 *
 * test_golden: checks tests/data/golden with the reference, and with a device where there is one.
 * test_golden --write DIR: makes new ones (only for a new kind of file: the old ones stay as they are).
 *
 * expected.txt, a line an evaluation: file, level of detail, effects, components, interpolation, filter;
 * then bits of u, v, light and view; then of the radiance.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cases.h"
#include "check.h"
#include "decoder/toolkit/filter.h"
#include "decoder/toolkit/reference_view.h"
#include "synthetic.h"
#include "tests/support/exr_edit.h"
#include "tests/support/messages.h"
#include "tests/support/test.h"
#include "variant.h"

enum { LINES = 16 }; /* of a file */

/* A file: contents, and how it differs from what the library writes. */
typedef struct golden {
    const char *name;
    uint32_t version;
    synthetic_spec spec;
    exr_compression_t compression;
    int odd; /* 1: parts in another order, rows from below, a private part, an unknown attribute, small
                display window; 2: heights made for four finer levels */
} golden;

/* clang-format off */
static const golden files[] = {
    {"v1-paper", 1, {.seed = 101, .width = 5, .height = 3, .n_views = 7, .n_lights = 11,
     .colour = BTF_COLOUR_MONO, .lobes = 2,
     .effects = BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN, .centres = 20,
     .directions = SYNTHETIC_RANDOM}, EXR_COMPRESSION_PIZ, 1},
    {"v1-tight", 1, {.seed = 102, .width = 5, .height = 4, .n_views = 7, .n_lights = 6,
     .layout = BTF_LAYOUT_TIGHT, .domain = BTF_DOMAIN_SQRT, .colour = BTF_COLOUR_RGB, .half_float = 1,
     .lobes = 1, .effects = BTF_EFFECT_VERSION_1, .components = 6, .centres = 9, .levels = 3},
     EXR_COMPRESSION_RLE, 0},
    {"v1-extreme", 1, {.seed = 103, .width = 3, .height = 5, .n_views = 2, .n_lights = 5,
     .layout = BTF_LAYOUT_TIGHT, .colour = BTF_COLOUR_MONO, .lobes = 4,
     .effects = BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL, .components = 5, .directions = SYNTHETIC_COLLINEAR,
     .values = SYNTHETIC_EXTREME}, EXR_COMPRESSION_ZIPS, 1},
    {"v1-components", 1, {.seed = 104, .width = 6, .height = 6, .n_views = 7, .n_lights = 7,
     .layout = BTF_LAYOUT_TIGHT, .domain = BTF_DOMAIN_SQRT, .colour = BTF_COLOUR_NONE,
     .effects = BTF_EFFECT_RESIDUAL | BTF_EFFECT_SHIFT, .components = 9}, EXR_COMPRESSION_NONE, 0},
    {"v2-all", 2, {.seed = 105, .width = 4, .height = 3, .n_views = 7, .n_lights = 6,
     .layout = BTF_LAYOUT_TIGHT, .domain = BTF_DOMAIN_SQRT, .colour = BTF_COLOUR_NONE,
     .effects = BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL,
     .components = 8, .centres = 9, .levels = 2,
     .classes = {{1, 1, 1}, {2, 2, 3}, {2, 1, 0}, {2, 0, 3}, {1, 0, 0}}, .blend = BTF_BLEND_ROOTS,
     .horizon_scale = 3.5f}, EXR_COMPRESSION_ZIP, 1},
    {"v2-paper", 2, {.seed = 106, .width = 3, .height = 3, .n_views = 7, .n_lights = 6,
     .colour = BTF_COLOUR_MONO, .lobes = 1, .effects = BTF_EFFECT_SHADOW | BTF_EFFECT_RESIDUAL,
     .components = 6, .classes = {{1, 2, 2}, {0, 0, 0}, {3, 0, 1}, {1, 0, 0}, {1, 1, 3}},
     .codes = SYNTHETIC_BOUNDS, .horizon_scale = 2}, EXR_COMPRESSION_PIZ, 0},
    {"v2-extreme", 2, {.seed = 107, .width = 3, .height = 2, .n_views = 3, .n_lights = 5,
     .layout = BTF_LAYOUT_TIGHT, .domain = BTF_DOMAIN_SQRT, .colour = BTF_COLOUR_RGB, .lobes = 1,
     .effects = BTF_EFFECT_VERSION_1, .components = 4, .centres = 9, .directions = SYNTHETIC_RANDOM,
     .classes = {{0, 0, 0}, {1, 0, 0}, {0, 0, 0}, {0, 0, 0}, {3, 4, 3}}, .values = SYNTHETIC_EXTREME,
     .codes = SYNTHETIC_BOUNDS}, EXR_COMPRESSION_NONE, 1},
    /* no factors */
    {"v2-roots", 2, {.seed = 108, .width = 4, .height = 4, .n_views = 7, .n_lights = 4,
     .layout = BTF_LAYOUT_TIGHT, .domain = BTF_DOMAIN_SQRT, .colour = BTF_COLOUR_MONO, .lobes = 1,
     .effects = BTF_EFFECT_HIDDEN | BTF_EFFECT_RESIDUAL, .components = 5, .centres = 9,
     .blend = BTF_BLEND_ROOTS}, EXR_COMPRESSION_RLE, 0},
    {"v2-points", 2, {.seed = 109, .width = 6, .height = 4, .n_views = 7, .n_lights = 5,
     .layout = BTF_LAYOUT_TIGHT, .domain = BTF_DOMAIN_SQRT, .colour = BTF_COLOUR_MONO, .lobes = 1,
     .effects = BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL,
     .components = 4, .levels = 2, .classes = {{1, 1, 1}, {0, 0, 0}, {2, 1, 0}, {0, 0, 0}, {1, 0, 0}},
     .blend = BTF_BLEND_ROOTS, .horizon_scale = 3.5f, .packed = 1}, EXR_COMPRESSION_ZIP, 1},
    {"v2-lists", 2, {.seed = 110, .width = 5, .height = 4, .n_views = 7, .n_lights = 5,
     .layout = BTF_LAYOUT_TIGHT, .domain = BTF_DOMAIN_SQRT, .colour = BTF_COLOUR_NONE,
     .effects = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL, .components = 3, .levels = 2,
     .classes = {{1, 1, 1}, {0, 0, 0}, {2, 1, 0}}, .blend = BTF_BLEND_ROOTS, .horizon_scale = 3.5f,
     .packed = 1, .entries = 11}, EXR_COMPRESSION_PIZ, 1},
    {.name = "v2-relief", .version = 2, .spec = {.seed = 111, .width = 6, .height = 5, .n_views = 7,
     .n_lights = 6, .layout = BTF_LAYOUT_TIGHT, .domain = BTF_DOMAIN_SQRT, .colour = BTF_COLOUR_NONE,
     .effects = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL | BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS,
     .components = 3, .levels = 3, .classes = {{1, 1, 1}, {0, 0, 0}, {2, 1, 0}}, .blend = BTF_BLEND_ROOTS,
     .horizon_scale = 3.5f, .packed = 1, .relief = SYNTHETIC_GENTLE, .relief_mixed = 1, .gloss_share = 1},
     .compression = EXR_COMPRESSION_ZIP, .odd = 1},
    /* a height of no map; what version 1 has besides */
    {.name = "v2-height", .version = 2, .spec = {.seed = 112,
     .width = 5, .height = 4, .n_views = 7, .n_lights = 6, .layout = BTF_LAYOUT_TIGHT,
     .domain = BTF_DOMAIN_SQRT, .colour = BTF_COLOUR_RGB, .half_float = 1, .lobes = 1,
     .effects = BTF_EFFECT_ALL, .components = 5, .centres = 9, .relief = SYNTHETIC_FLAT, .gloss_share = 2},
     .compression = EXR_COMPRESSION_PIZ},
    {.name = "v2-level", /* as cut from a material of finer levels, with heights at their bounds */
     .version = 2, .spec = {.seed = 113, .width = 5, .height = 3, .n_views = 19, .n_lights = 7,
     .layout = BTF_LAYOUT_TIGHT, .colour = BTF_COLOUR_MONO, .lobes = 2,
     .effects = BTF_EFFECT_SHADOW | BTF_EFFECT_RELIEF, .levels = 2, .relief = SYNTHETIC_HIGH},
     .compression = EXR_COMPRESSION_NONE, .odd = 2},
    /* the end of relief before the second of three levels */
    {.name = "v2-end", .version = 2,
     .spec = {.seed = 114, .width = 7, .height = 5, .n_views = 9, .n_lights = 6, .layout = BTF_LAYOUT_TIGHT,
     .domain = BTF_DOMAIN_SQRT, .colour = BTF_COLOUR_NONE,
     .effects = BTF_EFFECT_RESIDUAL | BTF_EFFECT_RELIEF, .components = 2, .levels = 3,
     .classes = {{0, 0, 0}, {0, 0, 0}, {2, 1, 1}}, .blend = BTF_BLEND_ROOTS, .horizon_scale = 3.5f,
     .relief = SYNTHETIC_GENTLE, .relief_mixed = 1, .relief_end = 1}, .compression = EXR_COMPRESSION_ZIP},
};
/* clang-format on */
enum { FILES = sizeof files / sizeof *files };

static void folder_path(char out[1000]) {
    const char *root = getenv("BTF_SOURCE_ROOT");
    snprintf(out, 1000, "%.900s/tests/data/golden", root ? root : ".");
}

static btf_material *open_golden(const char *name) {
    char folder[1000], path[1200];
    btf_material *material = NULL;
    folder_path(folder);
    snprintf(path, sizeof path, "%s/%.60s.btf.exr", folder, name);
    if (btf_material_open(path, &log_print, &material) != BTF_OK) {
        fail_msg("%s does not open", path);
    }
    return material;
}

/* --- writing --- */

static void make_odd(edit_file *file) {
    edit_part first = file->parts[0];
    edit_copy_part(file, first.name, "x-private");
    for (int p = 0; p + 1 < file->part_count; ++p) {
        file->parts[p] = file->parts[p + 1];
    }
    file->parts[file->part_count - 1] = first;
    for (int p = 0; p < file->part_count; ++p) {
        file->parts[p].order = EXR_LINEORDER_DECREASING_Y;
        file->parts[p].display_width = file->parts[p].display_height = 1;
    }
    file->attributes[file->attribute_count++] =
        (edit_attribute){.name = "openbtf.later", .type = EXR_ATTR_INT, .i = 5};
}

static int write_file(const golden *g, const char *folder) {
    btf_material *material = NULL;
    void *data = NULL, *edited = NULL;
    size_t size = 0, edited_size = 0;
    char path[1200];
    if (synthetic_create(&g->spec, &log_print, &material) ||
        btf_material_save_memory(material, NULL, &data, &size)) {
        return 1;
    }
    btf_material_close(&material);
    edit_file *file = edit_load(data, size);
    for (int p = 0; p < file->part_count; ++p) {
        file->parts[p].compression = g->compression;
    }
    if (g->odd == 1) {
        make_odd(file);
    }
    if (g->odd == 2) {
        file->attributes[file->attribute_count++] =
            (edit_attribute){.name = "openbtf.reliefLevel", .type = EXR_ATTR_INT, .i = 4};
    }
    edit_save(file, &edited, &edited_size);
    snprintf(path, sizeof path, "%.1000s/%s.btf.exr", folder, g->name);
    FILE *out = fopen(path, "wb");
    const int bad = !out || fwrite(edited, 1, edited_size, out) != edited_size;
    if (out) {
        fclose(out);
    }
    edit_free(file);
    btf_free(data);
    free(edited);
    return bad;
}

static void write_lines(const golden *g, const char *folder, FILE *out) {
    btf_material *material = NULL;
    char path[1200];
    snprintf(path, sizeof path, "%.1000s/%s.btf.exr", folder, g->name);
    if (btf_material_open(path, &log_print, &material)) {
        exit(1);
    }
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    random_state r = {g->spec.seed};
    for (uint32_t i = 0; i < LINES; ++i) {
        btf_ref_material reference;
        const uint32_t level = i % info.levels;
        const bool between = info.effects & (BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS);
        btf_ref_options o = {.effects = i % 4 == 3 ? random_below(&r, between ? 128 : 32)
                                        : between  ? BTF_EFFECT_ALL
                                                   : BTF_EFFECT_VERSION_1,
                             .components = i % 4 == 2 ? 1 + random_below(&r, 5) : 1000,
                             .interpolation = i % 5 ? BTF_REF_LINEAR : BTF_REF_NEAREST,
                             .filter = i % 3 == 0              ? BTF_REF_TEXEL
                                       : i % 3 == 1 && between ? BTF_REF_STEEP
                                                               : BTF_REF_BILINEAR};
        uint32_t words[CASE_WORDS], bits[3] = {0, 0, 0};
        float f[CASE_WORDS], rgb[3];
        reference_view(material, level, &reference);
        for (int tries = 0; tries < 50 && (bits[0] | bits[1] | bits[2]) == 0; ++tries) { /* most are lit */
            case_make(&r, material, words);
            memcpy(f, words, sizeof f);
            btf_ref_evaluate(&reference, &o, f[0], f[1], f + 2, f + 5, rgb);
            memcpy(bits, rgb, sizeof bits);
        }
        fprintf(out, "%s %u %u %u %s %s", g->name, level, o.effects, o.components,
                o.interpolation == BTF_REF_LINEAR ? "linear" : "nearest",
                filter_name((btf_filter)o.filter));
        for (int k = 0; k < CASE_WORDS; ++k) {
            fprintf(out, " %08x", words[k]);
        }
        fprintf(out, " %08x %08x %08x\n", bits[0], bits[1], bits[2]);
    }
    btf_material_close(&material);
}

static int write_all(const char *folder) {
    char path[1200];
    snprintf(path, sizeof path, "%.1000s/expected.txt", folder);
    FILE *out = fopen(path, "w");
    if (!out) {
        return 1;
    }
    for (int i = 0; i < FILES; ++i) {
        if (write_file(&files[i], folder)) {
            return 1;
        }
        write_lines(&files[i], folder, out);
    }
    return fclose(out) != 0;
}

/* --- checking --- */

/* A line of expected.txt. */
typedef struct expectation {
    char name[64], interpolation[16], filter[16];
    unsigned level, effects, components, arguments[CASE_WORDS], radiance[3];
} expectation;

static bool read_line(FILE *file, expectation *e) {
    if (fscanf(file, "%60s %u %u %u %12s %12s", e->name, &e->level, &e->effects, &e->components,
               e->interpolation, e->filter) != 6) {
        return false;
    }
    for (int i = 0; i < CASE_WORDS + 3; ++i) {
        if (fscanf(file, "%x", i < CASE_WORDS ? &e->arguments[i] : &e->radiance[i - CASE_WORDS]) != 1) {
            return false;
        }
    }
    return true;
}

TEST(reference_gives_the_bits) {
    char folder[1000], path[1100];
    folder_path(folder);
    snprintf(path, sizeof path, "%s/expected.txt", folder);
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    expectation e;
    int lines = 0, lit = 0, seen[FILES] = {0};
    while (read_line(file, &e)) {
        float f[CASE_WORDS], rgb[3];
        uint32_t bits[3];
        btf_ref_material reference;
        btf_ref_options o = {.effects = e.effects, .components = e.components};
        o.interpolation = strcmp(e.interpolation, "linear") == 0 ? BTF_REF_LINEAR : BTF_REF_NEAREST;
        o.filter = strcmp(e.filter, "bilinear") == 0 ? BTF_REF_BILINEAR
                   : strcmp(e.filter, "steep") == 0  ? BTF_REF_STEEP
                                                     : BTF_REF_TEXEL;
        btf_material *material = open_golden(e.name);
        reference_view(material, e.level, &reference);
        memcpy(f, e.arguments, sizeof f);
        btf_ref_evaluate(&reference, &o, f[0], f[1], f + 2, f + 5, rgb);
        memcpy(bits, rgb, sizeof bits);
        for (int c = 0; c < 3; ++c) {
            if (bits[c] != e.radiance[c]) {
                fail_msg("line %d, %s: channel %d is %08x, it was %08x", lines + 1, e.name, c, bits[c],
                         e.radiance[c]);
            }
        }
        lit += (bits[0] | bits[1] | bits[2]) != 0;
        for (int i = 0; i < FILES; ++i) {
            seen[i] += strcmp(files[i].name, e.name) == 0;
        }
        btf_material_close(&material);
        ++lines;
    }
    fclose(file);
    assert_int_equal(lines, FILES * LINES);
    assert_true(lit > 3 * lines / 4);
    for (int i = 0; i < FILES; ++i) {
        assert_int_equal(seen[i], LINES);
    }
}

/* Each file has the version that the library gives its material, and is saved with that version. */
TEST(versions_stay) {
    for (int i = 0; i < FILES; ++i) {
        btf_material *material = open_golden(files[i].name), *again = NULL;
        btf_material_info info = {.struct_size = sizeof info};
        void *data = NULL;
        size_t size = 0;
        btf_material_get_info(material, &info);
        assert_int_equal(info.version, files[i].version);
        assert_int_equal(btf_material_save_memory(material, &log_print, &data, &size), BTF_OK);
        assert_int_equal(btf_material_open_memory(data, size, &log_print, &again), BTF_OK);
        btf_material_get_info(again, &info);
        assert_int_equal(info.version, files[i].version);
        for (int id = 0; id < BTF_TEXTURE_COUNT; ++id) {
            const btf_texture a = btf_material_texture(material, id), b = btf_material_texture(again, id);
            assert_int_equal(a.size, b.size);
            if (a.size) {
                assert_memory_equal(a.data, b.data, a.size);
            }
        }
        btf_free(data);
        btf_material_close(&material);
        btf_material_close(&again);
    }
}

TEST(device_agrees) {
    char reason[400] = "";
    context_prepare(&context_devices[0]);
    gpu *device = gpu_create(&context_devices[0], reason, sizeof reason);
    if (!device) {
        print_message("skipped: %s\n", reason);
        skip();
    }
    for (int i = 0; i < FILES; ++i) {
        btf_material *material = open_golden(files[i].name);
        btf_shader_options shader = {.struct_size = sizeof shader,
                                     .filter = (btf_filter)(i < 10 ? i & 1 : i % 3)};
        check_subject s = {.gpu = device, .material = material, .shader = &shader, .log = &log_print};
        check_outcome outcome = {0};
        assert_int_equal(check_radiance(&s, 2 * (uint64_t)i, 2000, &outcome), BTF_OK);
        if (outcome.different) {
            fail_msg("%s: %llu of %llu differ", files[i].name, (unsigned long long)outcome.different,
                     (unsigned long long)outcome.evaluated);
        }
        btf_material_close(&material);
    }
    gpu_destroy(&device);
}

int main(int argc, char **argv) {
    if (argc == 3 && strcmp(argv[1], "--write") == 0) {
        return write_all(argv[2]);
    }
    return run_listed("tests", NULL, NULL);
}
