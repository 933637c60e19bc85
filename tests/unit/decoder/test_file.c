/* Files that our writer never writes: what a reader accepts, and every refusal of FORMAT.md sections 2
 * and 7.
 *
 * SPDX-License-Identifier: MIT
 */
#include "tests/support/exr_edit.h"
#include "tests/support/random_material.h"
#include "tests/support/refusals.h"
#include "tests/support/test.h"

/* A saved material with every effect; atlas or tight. */
static saved save_random(btf_layout layout, bool half) {
    random_state r = {21};
    btf_material_desc desc = random_material_desc(5, 4, 8, 7, layout, BTF_EFFECT_VERSION_1);
    desc.info.half_float = half;
    desc.info.method = "joint";
    desc.info.centres = 11;
    const btf_material_error errors[1] = {{BTF_EFFECT_VERSION_1, 30, 28, 12345}};
    desc.errors = errors;
    desc.error_count = 1;
    saved s;
    s.data = random_material_save(&r, &desc, &s.size);
    return s;
}

static saved tight_file, paper_file;

static int setup(void **state) {
    (void)state;
    tight_file = save_random(BTF_LAYOUT_TIGHT, false);
    paper_file = save_random(BTF_LAYOUT_PAPER, true);
    return 0;
}

static int teardown(void **state) {
    (void)state;
    btf_free(tight_file.data);
    btf_free(paper_file.data);
    return 0;
}

/* The edited file must open, with the textures of the original. */
static void accepted(edit_file *file, const saved *original) {
    btf_material *a = open_accepted(file), *b;
    assert_int_equal(btf_material_open_memory(original->data, original->size, NULL, &b), BTF_OK);
    for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
        btf_texture ta = btf_material_texture(a, (btf_texture_id)id),
                    tb = btf_material_texture(b, (btf_texture_id)id);
        assert_int_equal(ta.size, tb.size);
        if (ta.size) {
            assert_memory_equal(ta.data, tb.data, ta.size);
        }
    }
    btf_material_close(&a);
    btf_material_close(&b);
}

/* A channel that is subsampled, or sampled in a way that OpenEXR forbids, is refused before OpenEXRCore unpacks pixels.
 * Each channel of each part is tried. */
TEST(test_sampling) {
    static const unsigned char values[][2] = {{2, 1}, {1, 2}, {2, 2}, {0, 1}, {1, 0}, {255, 255}};
    static const char list[] = "channels\0chlist";
    uint8_t *data = malloc(tight_file.size);
    int channels = 0;
    assert_non_null(data);
    memcpy(data, tight_file.data, tight_file.size);
    uint8_t *at = data, *end = data + tight_file.size;
    while ((at = memmem(at, (size_t)(end - at), list, sizeof list))) {
        at += sizeof list + 4;
        for (; *at; channels++) {
            uint8_t *sampling = at + strlen((char *)at) + 1 + 8; /* behind the pixel type and pLinear */
            for (size_t v = 0; v < sizeof values / sizeof *values; v++) {
                for (int part = 1; part < 4; part++) {
                    btf_material *material = NULL;
                    for (int axis = 0; axis < 2; axis++) {
                        sampling[4 * axis] = part >> axis & 1 ? values[v][axis] : 1;
                    }
                    if (sampling[0] == 1 && sampling[4] == 1) {
                        continue;
                    }
                    last_message[0] = 0;
                    assert_int_equal(btf_material_open_memory(data, tight_file.size, &log_keep, &material),
                                     BTF_ERROR_BAD_FILE);
                    assert_null(material);
                    assert_true(last_message[0]);
                }
            }
            sampling[0] = sampling[4] = 1;
            at = sampling + 8;
        }
    }
    assert_true(channels > 10);
    free(data);
}

TEST(test_other_writers) {
    static const exr_compression_t good[] = {EXR_COMPRESSION_NONE, EXR_COMPRESSION_RLE,
                                             EXR_COMPRESSION_ZIPS, EXR_COMPRESSION_ZIP,
                                             EXR_COMPRESSION_PIZ};
    const saved *files[2] = {&tight_file, &paper_file};
    for (int f = 0; f < 2; f++) {
        for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
            edit_file *e = take(files[f]);
            for (int p = 0; p < e->part_count; p++) {
                e->parts[p].compression = good[i];
            }
            accepted(e, files[f]);
        }
        edit_file *e = take(files[f]); /* parts in another order, rows from below */
        edit_part first = e->parts[0];
        for (int p = 0; p + 1 < e->part_count; p++) {
            e->parts[p] = e->parts[p + 1];
        }
        e->parts[e->part_count - 1] = first;
        for (int p = 0; p < e->part_count; p++) {
            e->parts[p].order = EXR_LINEORDER_DECREASING_Y;
            e->parts[p].compression = EXR_COMPRESSION_ZIPS;
        }
        accepted(e, files[f]);
        e = take(files[f]); /* display windows are ignored */
        e->parts[0].display_width = 1;
        accepted(e, files[f]);
        e = take(files[f]); /* private parts, unknown attributes, no provenance */
        edit_copy_part(e, "sbrdf", "x-mine");
        e->attributes[e->attribute_count++] =
            (edit_attribute){.name = "openbtf.later", .type = EXR_ATTR_INT, .i = 5};
        edit_remove_attribute(e, "openbtf.method");
        edit_remove_attribute(e, "openbtf.errors");
        accepted(e, files[f]);
    }
}

/* OpenEXR's C++ library refuses parts with different display windows. The writer gives all parts one that covers
 * them. */
TEST(test_display_window) {
    edit_file *e = take(&tight_file);
    int width = 0, height = 0;
    for (int p = 0; p < e->part_count; p++) {
        width = e->parts[p].width > width ? e->parts[p].width : width;
        height = e->parts[p].height > height ? e->parts[p].height : height;
    }
    for (int p = 0; p < e->part_count; p++) {
        assert_int_equal(e->parts[p].display_width, width);
        assert_int_equal(e->parts[p].display_height, height);
    }
    edit_free(e);
}

TEST(test_negative_zero) {
    edit_file *e = take(&tight_file);
    float *value = (float *)(void *)edit_find_channel(e, "sbrdf", "rho_d")->data;
    *value = -0.0f;
    uint16_t *code = (uint16_t *)(void *)edit_find_channel(e, "residual_texels", "Y")->data;
    *code = 0x8000;
    btf_material *m = open_accepted(e);
    assert_false(signbit(((const float *)btf_material_texture(m, BTF_TEXTURE_SBRDF).data)[3]));
    assert_int_equal(*(const int8_t *)btf_material_texture(m, BTF_TEXTURE_RESIDUAL_TEXELS).data, 0);
    btf_material_close(&m);
}

TEST(test_parts) {
    static const char *const names[] = {
        "sbrdf", "shadow", "shift", "gain", "centres", "residual_texels", "residual_directions"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        EDIT_REFUSED(take(&tight_file), edit_remove_part(e, names[i]), told("part %s: missing", names[i]));
        EDIT_REFUSED(take(&tight_file), edit_copy_part(e, names[i], "what"), "part what: unknown");
        EDIT_REFUSED(take(&tight_file), edit_resize(edit_find_part(e, names[i]), 9, 7),
                     told("part %s: data window (0,0)-(8,6)", names[i]));
        EDIT_REFUSED(take(&tight_file), edit_find_part(e, names[i])->min_x = 1,
                     told("part %s: data window (1,0)", names[i]));
        EDIT_REFUSED(take(&tight_file), edit_find_part(e, names[i])->compression = EXR_COMPRESSION_PXR24,
                     told("part %s: compression 5", names[i]));
        EDIT_REFUSED(take(&tight_file), edit_add_channel(edit_find_part(e, names[i]), "Z", EXR_PIXEL_HALF),
                     told("part %s: unknown channel Z", names[i]));
        edit_file *e = take(&tight_file);
        edit_part *part = edit_find_part(e, names[i]);
        char channel[40];
        snprintf(channel, sizeof channel, "%s", part->channels[0].name);
        edit_remove_channel(part, channel);
        edit_add_channel(part, "Z", EXR_PIXEL_HALF);
        file_refused(e, told("part %s: channel ", names[i]));
        e = take(&tight_file);
        part = edit_find_part(e, names[i]);
        int last = part->channel_count - 1; /* the first channel of sbrdf says whether all are halves */
        snprintf(channel, sizeof channel, "%s", part->channels[last].name);
        edit_remove_channel(part, channel);
        edit_add_channel(part, channel, EXR_PIXEL_UINT);
        file_refused(e, told("part %s: channel %s is of type 0", names[i], channel));
    }
    EDIT_REFUSED(take(&tight_file), edit_copy_part(e, "shadow", "maps"),
                 "part maps: unknown, or not in a material of these effects");
}

/* Two parts of one name: EXR writers refuse that, so the bytes are changed. */
TEST(test_repeated_part) {
    uint8_t *copy = malloc(tight_file.size);
    assert_non_null(copy);
    memcpy(copy, tight_file.data, tight_file.size);
    static const char name[9] = {5, 0, 0, 0, 's', 'h', 'i', 'f', 't'}; /* its length, then the text */
    uint8_t *at = memmem(copy, tight_file.size, name, sizeof name);
    assert_non_null(at);
    memcpy(at + 4, "sbrdf", 5);
    btf_material *m;
    btf_result result = btf_material_open_memory(copy, tight_file.size, &log_keep, &m);
    assert_int_equal(result, BTF_ERROR_BAD_FILE);
    assert_non_null(strstr(last_message, "repeat"));
    free(copy);
}

static void set_half(edit_file *e, const char *part, const char *channel, size_t pixel, uint16_t bits) {
    memcpy(edit_find_channel(e, part, channel)->data + 2 * pixel, &bits, 2);
}

static void set_float(edit_file *e, const char *part, const char *channel, size_t pixel, float value) {
    memcpy(edit_find_channel(e, part, channel)->data + 4 * pixel, &value, 4);
}

TEST(test_values) {
    static const uint16_t bad_u8[] = {0x3800 /* 0.5 */, 0x5C00 /* 256 */, 0xBC00 /* -1 */, 0x7C00,
                                      0x7E01,           0x0001,           0x5BFC /* 255.5 */};
    static const char *const channels[][2] = {
        {"shadow", "Y"}, {"shift", "G"}, {"gain", "Y"}, {"centres", "B"}};
    for (size_t c = 0; c < sizeof channels / sizeof *channels; c++) {
        for (size_t i = 0; i < sizeof bad_u8 / sizeof *bad_u8; i++) {
            EDIT_REFUSED(take(&tight_file), set_half(e, channels[c][0], channels[c][1], 3, bad_u8[i]),
                         told("part %s: channel %s at (3, 0) holds half 0x%04x", channels[c][0],
                              channels[c][1], bad_u8[i]));
        }
    }
    static const uint16_t bad_i8[] = {0xD800 /* -128 */, 0x5800 /* 128 */, 0x3800};
    for (size_t i = 0; i < sizeof bad_i8 / sizeof *bad_i8; i++) {
        EDIT_REFUSED(take(&tight_file), set_half(e, "residual_directions", "G", 0, bad_i8[i]),
                     "part residual_directions: channel G at (0, 0) holds half");
    }
    /* 7 layers of 5 x 4 in a sheet of 3 columns: (5, 8) is covered by none */
    EDIT_REFUSED(take(&tight_file), set_half(e, "shadow", "Y", 8 * 15 + 5, 0x3C00),
                 "part shadow: channel Y at (5, 8) holds half 0x3c00");

    static const float bad_float[] = {NAN, INFINITY, 0x1p-25f, 1e-42f, 0x1.8p24f};
    for (size_t i = 0; i < sizeof bad_float / sizeof *bad_float; i++) {
        EDIT_REFUSED(take(&tight_file), set_float(e, "sbrdf", "lobe2.Cy", 6, bad_float[i]),
                     "sbrdf: channel lobe2.Cy at (1, 1) holds");
    }
    static const uint16_t bad_half[] = {0x7C00, 0xFC00, 0x7FFF, 0x0001, 0x83FF};
    for (size_t i = 0; i < sizeof bad_half / sizeof *bad_half; i++) {
        EDIT_REFUSED(take(&paper_file), set_half(e, "sbrdf", "lobe3.n", 19, bad_half[i]),
                     "sbrdf: channel lobe3.n at (4, 3) holds");
    }
    edit_file *e = take(&paper_file); /* G code 0 with an index of 65535 */
    set_half(e, "maps", "G", 0, 0);
    set_half(e, "maps", "B", 0, 0x5BF8);
    set_half(e, "maps", "A", 0, 0x5BF8);
    file_refused(e, "maps: view 0, texel (0, 0) names centre 65535 of ");
    e = take(&paper_file);
    edit_part *maps = edit_find_part(e, "maps");
    set_half(e, "maps", "R", (size_t)maps->width * (size_t)maps->height - 1, 0x3C00);
    file_refused(e, "it has no meaning and must be 0");
}

TEST(test_attributes) {
    static const char *const needed[] = {
        "version",        "layout",        "domain",      "width",     "height",
        "effects",        "lobes",         "colour",      "centres",   "residual",
        "residualScales", "radianceScale", "shadowScale", "gainScale", "centreScale",
        "atlasWidth",     "atlasHeight",   "views",       "lights",    "viewVertices",
        "lightVertices",  "viewGrid",      "lightGrid",   "viewCells", "lightCells"};
    for (size_t i = 0; i < sizeof needed / sizeof *needed; i++) {
        char name[64];
        snprintf(name, sizeof name, "openbtf.%s", needed[i]);
        EDIT_REFUSED(take(&paper_file), edit_remove_attribute(e, name),
                     told("attribute %s is missing", name));
        EDIT_REFUSED(take(&paper_file), edit_find_attribute(e, name)->type = EXR_ATTR_DOUBLE,
                     told("attribute %s is of type double", name));
    }
    edit_file *e = take(&paper_file);
    edit_find_attribute(e, "openbtf.version")->i = BTF_FORMAT_VERSION + 1;
    refused_as(e, BTF_ERROR_UNSUPPORTED, "format version 3 is newer than 2");
    EDIT_REFUSED(take(&paper_file), edit_find_attribute(e, "openbtf.version")->i = 0,
                 "openbtf.version is 0");
}

TEST(test_attribute_values) {
    static const struct {
        const char *name;
        int32_t value;
        const char *text;
    } integers[] = {
        {"width", 0, "openbtf.width is 0"},
        {"width", -5, "openbtf.width is -5"},
        {"height", 16385, "openbtf.height is 16385"},
        {"width", 6, "part sbrdf: data window"},
        {"lobes", 5, "openbtf.lobes is 5"},
        {"lobes", 0, "lobes 0"},
        {"lobes", 2, "part sbrdf: unknown channel lobe3"},
        {"lobes", 4, "part sbrdf: channel lobe4.Cx is missing"},
        {"centres", 0, "centres 0"},
        {"centres", 65537, "openbtf.centres is 65537"},
        {"centres", 5000, "not for 5000"},
        {"residual", 257, "openbtf.residual is 257"},
        {"residual", 4, "openbtf.residualScales holds 5 numbers, which do not fit the 4"},
        {"atlasWidth", 48, "atlas 48 x"},
        {"atlasHeight", 4, "cannot hold"},
        {"viewGrid", 3, "views: grid 3"},
        {"lightGrid", 128, "openbtf.lightGrid is 128"},
    };
    for (size_t i = 0; i < sizeof integers / sizeof *integers; i++) {
        char name[64];
        snprintf(name, sizeof name, "openbtf.%s", integers[i].name);
        EDIT_REFUSED(take(&paper_file), edit_find_attribute(e, name)->i = integers[i].value,
                     integers[i].text);
    }
    static const struct {
        const char *name, *value, *text;
    } strings[] = {
        {"layout", "loose", "openbtf.layout is \"loose\""},
        {"layout", "tight", "part maps: unknown"},
        {"domain", "log", "openbtf.domain is \"log\""},
        {"colour", "rgba", "openbtf.colour is \"rgba\""},
        {"colour", "rgb", "part sbrdf: channel lobe1.R is missing"},
        {"effects", "shadow,shine", "openbtf.effects is"},
        {"effects", "shift,shadow,hidden,gain,residual", "out of order"},
        {"effects", "shadow,,shift", "out of order"},
        {"effects", "shadow,shift,hidden,gain,residual,", "openbtf.effects is"},
        {"effects", "shadow, shift", "openbtf.effects is"},
        {"effects", "shadow,shift,hidden,gain", "residual of 5 components without"},
        {"effects", "shadow,shift,gain,residual", "without the effect hidden"},
        {"effects", "shift,hidden,gain,residual", "it has no meaning and must be 0"},
    };
    for (size_t i = 0; i < sizeof strings / sizeof *strings; i++) {
        char name[64];
        snprintf(name, sizeof name, "openbtf.%s", strings[i].name);
        edit_file *e = take(&paper_file);
        edit_attribute *a = edit_find_attribute(e, name);
        free(a->text);
        a->text = strdup(strings[i].value);
        file_refused(e, strings[i].text);
    }
    static const char *const scales[] = {"radianceScale", "shadowScale", "gainScale", "centreScale"};
    static const float values[] = {0, -1, NAN, INFINITY, 0x1p-25f, 0x1p25f};
    for (size_t i = 0; i < 4; i++) {
        for (size_t k = 0; k < 6; k++) {
            char name[64];
            snprintf(name, sizeof name, "openbtf.%s", scales[i]);
            EDIT_REFUSED(take(&paper_file), edit_find_attribute(e, name)->f = values[k], scales[i]);
        }
    }
}

/* Changes one number of a floatvector. */
static void refused_number(const char *name, int index, float value, const char *text) {
    number_refused(take(&paper_file), name, index, value, text);
}

/* Changes the length of a floatvector. */
static void refused_count(const char *name, int count, const char *text) {
    count_refused(take(&paper_file), name, count, text);
}

TEST(test_directions) {
    refused_number("views", 2, 0.5f, "views: direction 0");
    refused_number("views", 5, -0.9f, "views: direction 1");
    refused_number("lights", 3, NAN, "lights: direction 1");
    refused_number("viewVertices", 0, 8100, "views: vertex 0");
    refused_number("viewVertices", 0, 20000, "openbtf.viewVertices: number 0 is 20000");
    refused_number("viewVertices", 1, 0.5f, "openbtf.viewVertices: number 1 is 0.5");
    refused_number("lightVertices", 1, NAN, "openbtf.lightVertices: number 1");
    refused_number("lightVertices", 3, -1, "openbtf.lightVertices: number 3");
    refused_number("lightTriangles", 0, 7, "openbtf.lightTriangles: number 0 is 7");
    refused_number("viewTriangles", 1, 0, "views: triangle 0 is not counter-clockwise");
    refused_number("viewHull", 0, 8, "openbtf.viewHull: number 0 is 8");
    refused_number("viewHull", 0, 0, "outside hull edge");
    refused_number("viewCells", 0, 60000, "views: the list of cell 0");
    refused_number("viewCells", -1, 700, "views: cell");
    refused_number("viewCells", 1, -1, "openbtf.viewCells: number 1 is -1");
    refused_count("views", 7, "openbtf.views holds 7 numbers");
    refused_count("views", 257 * 3, "openbtf.views holds 771 numbers");
    refused_count("views", 21, "viewVertices holds 16 numbers");
    refused_count("viewVertices", 14, "viewVertices holds 14 numbers");
    refused_count("viewTriangles", 4, "viewTriangles holds 4 numbers");
    refused_count("viewHull", 1, "views: the hull has 1 vertices");
    refused_count("viewHull", 17, "viewHull holds 17 numbers");
    refused_count("viewCells", 3, "ends early");
    refused_count("lightCells", 70000, "openbtf.lightCells holds 70000");
    refused_count("errors", 3, "openbtf.errors holds 3 numbers");
    refused_number("errors", 0, 32, "openbtf.errors: row 0 has the effects 32");
    refused_number("errors", 1, NAN, "errors: row 0");
    refused_number("residualScales", 2, 0x1p-30f, "residualScales: number 2");
    refused_number("residualScales", 0, NAN, "residualScales: number 0");

    EDIT_REFUSED(take(&paper_file), edit_remove_attribute(e, "openbtf.viewHull"),
                 "views: the hull has 0 vertices, which 8 directions cannot have");
    /* the hull says more cells than there are records */
    EDIT_REFUSED(take(&paper_file), edit_remove_attribute(e, "openbtf.viewTriangles"), "views: cell");
    edit_file *e = take(&paper_file); /* clockwise */
    edit_attribute *hull = edit_find_attribute(e, "openbtf.lightHull");
    for (int i = 0; i < hull->count / 2; i++) {
        float swap = hull->values[i];
        hull->values[i] = hull->values[hull->count - 1 - i];
        hull->values[hull->count - 1 - i] = swap;
    }
    file_refused(e, "outside hull edge");
    e = take(&paper_file); /* triangles not in order */
    edit_attribute *cells = edit_find_attribute(e, "openbtf.viewCells");
    int at = 0;
    while (cells->values[at] < 2) {
        at += 1 + (int)cells->values[at];
    }
    cells->values[at + 2] = cells->values[at + 1];
    file_refused(e, "are not in order");
    e = take(&paper_file);
    cells = edit_find_attribute(e, "openbtf.viewCells");
    cells->values = realloc(cells->values, (size_t)(cells->count + 1) * sizeof(float));
    assert_non_null(cells->values);
    cells->values[cells->count++] = 0;
    file_refused(e, "1 numbers follow the last cell");
}

/* A header that promises more than a file of its size can hold is refused before anything is allocated. */
TEST(test_implausible) {
    random_state r = {22};
    btf_material_desc desc = random_material_desc(1, 1, 256, 1, BTF_LAYOUT_TIGHT, BTF_EFFECT_SHIFT);
    random_material_fill(&r, &desc);
    btf_material *material;
    saved s;
    assert_int_equal(btf_material_create(&desc, NULL, &material), BTF_OK);
    assert_int_equal(btf_material_save_memory(material, NULL, &s.data, &s.size), BTF_OK);
    /* width and height 16384: 2^28 texels, 256 layers of shifts, 128 GiB; windows are made to agree */
    for (int i = 0; i < 2; i++) {
        const char *name = i ? "openbtf.height" : "openbtf.width";
        size_t length = strlen(name) + 1;
        uint8_t *at = memmem(s.data, s.size, name, length);
        assert_non_null(at);
        memcpy(at + length + 4 + 4, "\0\100\0\0", 4); /* after type and size */
    }
    uint8_t *cursor = s.data;
    for (int i = 0; i < 4; i++) { /* dataWindow and displayWindow of both parts */
        cursor = memmem(cursor, s.size - (size_t)(cursor - (uint8_t *)s.data), "box2i", 6);
        assert_non_null(cursor);
        int32_t side = i < 2 ? 16384 : 16384 * 16;
        int32_t window[4] = {0, 0, side - 1, side - 1};
        memcpy(cursor + 6 + 4, window, sizeof window);
        cursor += 10;
    }
    btf_material *m;
    last_message[0] = 0;
    assert_int_equal(btf_material_open_memory(s.data, s.size, &log_keep, &m), BTF_ERROR_BAD_FILE);
    print_message("%s\n", last_message);
    btf_free(s.data);
    btf_material_close(&material);
    random_material_free(&desc);
}

RUN_TESTS(setup, teardown)
