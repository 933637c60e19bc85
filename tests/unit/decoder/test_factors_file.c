/* Version 2 of the format in files: saving and opening, parts, words of factors, the preview.
 *
 * SPDX-License-Identifier: MIT
 */
#include "factors.h"
#include "tests/support/test.h"

TEST(test_round_trip) {
    for (int i = 0; i < 16; i++) {
        const btf_layout layout = i & 1 ? BTF_LAYOUT_PAPER : BTF_LAYOUT_TIGHT;
        random_state r = {(uint64_t)i};
        btf_material_desc desc = factor_material_desc(WIDTH, HEIGHT, VIEWS, LIGHTS, layout,
                                                      i & 2 ? BTF_EFFECT_VERSION_1 : 0, factor_classes);
        desc.info.blend = i & 4 ? BTF_BLEND_ROOTS : BTF_BLEND_RADIANCE;
        desc.info.levels = layout == BTF_LAYOUT_TIGHT ? 3 : 1;
        if (!(i & 2)) {
            desc.info.colour = BTF_COLOUR_NONE;
            desc.info.lobes = 0;
        }
        factor_material_fill(&r, &desc);
        uint16_t *preview = make_preview(WIDTH, HEIGHT);
        desc.preview = i & 8 ? preview : NULL;
        round_trip(&desc);
        free(preview);
        random_material_free(&desc);
    }
}

/* Blending roots alone makes a file of version 2, and nothing of factors is written. */
TEST(test_roots_without_factors) {
    for (int residual = 0; residual < 2; residual++) {
        random_state r = {9};
        btf_material_desc desc = random_material_desc(3, 2, 4, 3, BTF_LAYOUT_TIGHT,
                                                      residual ? BTF_EFFECT_RESIDUAL : BTF_EFFECT_SHADOW);
        desc.info.domain = BTF_DOMAIN_SQRT;
        desc.info.blend = BTF_BLEND_ROOTS;
        random_material_fill(&r, &desc);
        uint16_t *preview = make_preview(3, 2);
        desc.preview = preview;
        round_trip(&desc);
        btf_material *m = create_accepted(&desc);
        assert_int_equal(accepted_info(m).version, 2);
        void *data;
        size_t size;
        assert_int_equal(btf_material_save_memory(m, NULL, &data, &size), BTF_OK);
        edit_file *e = edit_load(data, size);
        assert_int_equal(edit_find_attribute(e, "openbtf.version")->i, 2);
        assert_string_equal(edit_find_attribute(e, "openbtf.blend")->text, "roots");
        assert_string_equal(e->parts[0].name, "preview");
        for (int a = 0; a < e->attribute_count; a++) {
            assert_null(strstr(e->attributes[a].name, "factor"));
            assert_null(strstr(e->attributes[a].name, "horizon"));
        }
        edit_free(e);
        btf_free(data);
        btf_material_close(&m);
        free(preview);
        random_material_free(&desc);
    }
}

TEST(test_file_parts) {
    static const char *const names[] = {"factor_texels", "factor_directions", "preview"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        const bool words = i < 2;
        edit_file *e = take(&factor_file);
        edit_part *part = edit_find_part(e, names[i]);
        assert_int_equal(part->channel_count, words ? 4 : 3);
        for (int c = 0; c < part->channel_count; c++) {
            assert_int_equal(part->channels[c].type, words ? EXR_PIXEL_UINT : EXR_PIXEL_HALF);
        }
        if (words) {
            edit_remove_part(e, names[i]);
            file_refused(e, told("part %s: missing", names[i]));
        } else {
            edit_free(e);
        }
        EDIT_REFUSED(take(&factor_file), edit_resize(edit_find_part(e, names[i]), 9, 3),
                     told("part %s: data window (0,0)-(8,2)", names[i]));
        for (int type = 0; type < 3; type++) {
            static const exr_pixel_type_t types[3] = {EXR_PIXEL_HALF, EXR_PIXEL_FLOAT, EXR_PIXEL_UINT};
            if (types[type] == (words ? EXR_PIXEL_UINT : EXR_PIXEL_HALF)) {
                continue;
            }
            e = take(&factor_file);
            part = edit_find_part(e, names[i]);
            edit_remove_channel(part, "G");
            edit_add_channel(part, "G", types[type]);
            file_refused(e, told("part %s: channel G is of type %d, not %d (%s)", names[i],
                                 (int)types[type], words ? 0 : 1, words ? "UINT" : "HALF"));
        }
        EDIT_REFUSED(take(&factor_file), edit_remove_channel(edit_find_part(e, names[i]), "B"),
                     told("part %s: channel B is missing", names[i]));
        EDIT_REFUSED(
            take(&factor_file),
            edit_add_channel(edit_find_part(e, names[i]), "Y", words ? EXR_PIXEL_UINT : EXR_PIXEL_HALF),
            told("part %s: unknown channel Y", names[i]));
    }
    EDIT_REFUSED(take(&factor_file), edit_copy_part(e, "factor_texels", "residual_texels"),
                 "part residual_texels: unknown");
    EDIT_REFUSED(take(&factor_file), edit_copy_part(e, "factor_texels", "level1.factor_texels"),
                 "part level1.factor_texels: unknown");
}

TEST(test_file_words) {
    /* 11 layers of 5 x 4 in a sheet of 4 columns: the twelfth cell, from (15, 8) on, is empty */
    edit_file *e = take(&factor_file);
    edit_part *part = edit_find_part(e, "factor_texels");
    assert_int_equal(part->width, 20);
    assert_int_equal(part->height, 12);
    uint32_t word = 0x80000001u;
    memcpy(edit_find_channel(e, "factor_texels", "A")->data + 4 * (9 * 20 + 16), &word, 4);
    file_refused(e, "part factor_texels: channel A at (16, 9) holds 0x80000001 where no layer lies, not 0");
    e = take(&factor_file); /* layer 1 of class 0 begins at column 5 */
    word = 0x00800000u;
    memcpy(edit_find_channel(e, "factor_texels", "R")->data + 4 * (3 * 20 + 7), &word, 4);
    file_refused(e, "factor_texels: unit 1 at (2, 3): byte 2 of channel R is -128");
    e = take(&factor_file);
    word = 0xFFFFFF80u;
    memcpy(edit_find_channel(e, "factor_directions", "B")->data, &word, 4);
    file_refused(e, "factor_directions: unit 0 at (0, 0): byte 0 of channel B is -128");
}

/* Words come through every compression and order of rows. */
TEST(test_other_writers) {
    static const exr_compression_t good[] = {EXR_COMPRESSION_NONE, EXR_COMPRESSION_RLE,
                                             EXR_COMPRESSION_ZIPS, EXR_COMPRESSION_PIZ};
    btf_material *original;
    assert_int_equal(btf_material_open_memory(factor_file.data, factor_file.size, NULL, &original), BTF_OK);
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        edit_file *e = take(&factor_file);
        for (int p = 0; p < e->part_count; p++) {
            e->parts[p].compression = good[i];
            e->parts[p].order = i % 2 ? EXR_LINEORDER_DECREASING_Y : EXR_LINEORDER_INCREASING_Y;
        }
        btf_material *m = open_accepted(e);
        assert_same_material(m, original);
        btf_material_close(&m);
    }
    btf_material_close(&original);
}

/* The picture may be anything, and may be missing. */
TEST(test_preview) {
    edit_file *e = take(&factor_file);
    assert_string_equal(e->parts[0].name, "preview");
    const uint16_t nan = 0x7E01, denormal = 0x0001;
    memcpy(edit_find_channel(e, "preview", "R")->data, &nan, 2);
    memcpy(edit_find_channel(e, "preview", "B")->data + 2 * (WIDTH * HEIGHT - 1), &denormal, 2);
    btf_material *m = open_accepted(e);
    assert_int_equal(btf_material_preview(m)[0], nan);
    assert_int_equal(btf_material_preview(m)[4 * (WIDTH * HEIGHT - 1) + 2], denormal);
    btf_material_close(&m);
    e = take(&factor_file);
    edit_remove_part(e, "preview");
    m = open_accepted(e);
    assert_null(btf_material_preview(m));
    btf_material_close(&m);
    /* version 1 knows no such part */
    EDIT_REFUSED(take(&plain_file), edit_copy_part(e, "sbrdf", "preview"), "part preview: unknown");
    btf_material_desc desc = random_material_desc(2, 2, 3, 3, BTF_LAYOUT_TIGHT, 0);
    random_state r = {12};
    random_material_fill(&r, &desc);
    uint16_t *preview = make_preview(2, 2);
    desc.preview = preview;
    create_refused(&desc, "preview: given, but nothing else of the material needs version 2, and files of "
                          "version 1 have no preview");
    free(preview);
    random_material_free(&desc);
}

RUN_TESTS(setup, teardown)
