/* Version 2 of the format in the header of a file: attributes that are missing, wrong or of another version.
 *
 * SPDX-License-Identifier: MIT
 */
#include "factors.h"
#include "tests/support/test.h"

static edit_attribute *add_attribute(edit_file *e, const char *name, exr_attribute_type_t type) {
    assert_true(e->attribute_count < EDIT_ATTRIBUTES);
    edit_attribute *a = &e->attributes[e->attribute_count++];
    *a = (edit_attribute){.type = type};
    snprintf(a->name, sizeof a->name, "%s", name);
    return a;
}

static void add_floats(edit_file *e, const char *name, int count) {
    edit_attribute *a = add_attribute(e, name, EXR_ATTR_FLOAT_VECTOR);
    a->values = calloc((size_t)count, sizeof *a->values);
    assert_non_null(a->values);
    a->count = count;
}

TEST(test_file_attributes) {
    static const char *const needed[] = {"factorScales", "factorViews", "horizonScale"};
    for (size_t i = 0; i < sizeof needed / sizeof *needed; i++) {
        char name[64];
        snprintf(name, sizeof name, "openbtf.%s", needed[i]);
        EDIT_REFUSED(take(&factor_file), edit_remove_attribute(e, name),
                     told("attribute %s is missing", name));
    }
    static const char *const typed[] = {"factorClasses", "factorScales", "factorViews", "horizonScale",
                                        "blend"};
    for (size_t i = 0; i < sizeof typed / sizeof *typed; i++) {
        char name[64];
        snprintf(name, sizeof name, "openbtf.%s", typed[i]);
        EDIT_REFUSED(take(&factor_file), edit_find_attribute(e, name)->type = EXR_ATTR_DOUBLE,
                     told("attribute %s is of type double", name));
    }
    /* without classes the residual is stored as components */
    EDIT_REFUSED(take(&factor_file), edit_remove_attribute(e, "openbtf.factorClasses"),
                 "attribute openbtf.residualScales is missing");
    EDIT_REFUSED(take(&factor_file), add_floats(e, "openbtf.residualScales", FACTOR_UNITS),
                 "attribute openbtf.residualScales is there, but there are no components of the residual");
    EDIT_REFUSED(take(&factor_file), edit_find_attribute(e, "openbtf.residual")->i = 8,
                 "factorClasses: the classes have 9 units in all, the residual has 8");
    /* version 1 has no factors: its residual is of nine components */
    EDIT_REFUSED(take(&factor_file), edit_find_attribute(e, "openbtf.version")->i = 1,
                 "attribute openbtf.residualScales is missing");
    edit_file *e = take(&factor_file); /* a file without a residual and with factors */
    edit_attribute *effects = edit_find_attribute(e, "openbtf.effects");
    free(effects->text);
    effects->text = strdup("shadow");
    edit_find_attribute(e, "openbtf.residual")->i = 0;
    edit_find_attribute(e, "openbtf.centres")->i = 0;
    file_refused(e, "factors without the effect residual");
}

/* Changes one number of a floatvector. */
static void refused_number(const char *name, int index, float value, const char *text) {
    number_refused(take(&factor_file), name, index, value, text);
}

static void refused_count(const char *name, int count, const char *text) {
    count_refused(take(&factor_file), name, count, text);
}

TEST(test_file_numbers) {
    refused_number("factorClasses", 6, 2,
                   "factorClasses: the classes have 8 units in all, the residual has 9");
    refused_number("factorClasses", 0, 2.5f, "openbtf.factorClasses: number 0 is 2.5");
    refused_number("factorClasses", 4, -1, "openbtf.factorClasses: number 4 is -1");
    refused_number("factorClasses", 14, NAN, "openbtf.factorClasses: number 14 is ");
    refused_number("factorClasses", 6, 1025, "openbtf.factorClasses: number 6 is 1025");
    refused_number("factorClasses", 6, 257, "factorClasses: class 2 has 257 units");
    refused_number("factorClasses", 7, 13, "with 13 words of C1");
    /* Words of C1 in class 2 make its first two units mixed; the third stays whole. */
    edit_file *e = take(&factor_file);
    edit_find_attribute(e, "openbtf.factorClasses")->values[7] = 5;
    edit_find_attribute(e, "openbtf.factorScales")->values[4 * 4 + 1] = 0.125f;
    btf_material *m = open_accepted(e);
    assert_int_equal(accepted_info(m).factor_classes[2][1], 5);
    btf_material_close(&m);
    e = take(&factor_file);
    edit_find_attribute(e, "openbtf.factorClasses")->values[7] = 5;
    edit_find_attribute(e, "openbtf.factorScales")->values[4 * 5 + 1] = 0.125f;
    file_refused(e, "factorScales: unit 5, all of Y, has the scales");
}

TEST(test_file_counts) {
    refused_count("factorClasses", 14, "openbtf.factorClasses holds 14 numbers");
    refused_count("factorClasses", 30, "openbtf.factorClasses holds 30 numbers");
    refused_count("factorScales", 35, "openbtf.factorScales holds 35 numbers");
    refused_count("factorScales", 40,
                  "openbtf.factorScales holds 40 numbers, which do not fit the 9 units of factors");
    refused_count("factorViews", 9 * VIEWS - 1, "openbtf.factorViews holds 71 numbers");
    refused_count("factorViews", 9 * VIEWS + 9,
                  "openbtf.factorViews holds 81 numbers, which do not fit the 8 views");
    refused_number("factorScales", 3, NAN, "factorScales: number 3 is nan");
    refused_number("factorScales", 30, 0x1p25f, "factorScales: number 30 is ");
    refused_number("factorScales", 15, 0.5f, "factorScales: unit 3, all of Y, has the scales");
    refused_number("factorViews", 9 * VIEWS - 1, 0x1p-25f, "factorViews: number 71 is ");
    static const float horizons[] = {0, 0.5f, NAN, INFINITY, 0x1p25f};
    for (size_t i = 0; i < sizeof horizons / sizeof *horizons; i++) {
        EDIT_REFUSED(take(&factor_file), edit_find_attribute(e, "openbtf.horizonScale")->f = horizons[i],
                     "horizonScale");
    }
    edit_file *e = take(&factor_file);
    edit_attribute *blend = edit_find_attribute(e, "openbtf.blend");
    free(blend->text);
    blend->text = strdup("root");
    file_refused(e, "openbtf.blend is \"root\", which is unknown");
    e = take(&factor_file);
    edit_attribute *domain = edit_find_attribute(e, "openbtf.domain");
    free(domain->text);
    domain->text = strdup("linear");
    file_refused(e, "blend roots needs domain sqrt");
    e = take(&factor_file);
    edit_remove_attribute(e, "openbtf.blend");
    btf_material *m = open_accepted(e);
    assert_int_equal(accepted_info(m).blend, BTF_BLEND_RADIANCE);
    btf_material_close(&m);
}

/* Attributes of version 2 say nothing in a file of version 1; a file that calls itself version 2 and holds
 * nothing of it is saved as version 1. */
TEST(test_versions) {
    btf_material *plain, *m;
    assert_int_equal(btf_material_open_memory(plain_file.data, plain_file.size, NULL, &plain), BTF_OK);
    assert_int_equal(accepted_info(plain).version, 1);
    assert_true(accepted_info(plain).horizon_scale == 1);
    edit_file *e = take(&plain_file);
    add_floats(e, "openbtf.factorClasses", 15);
    add_floats(e, "openbtf.factorScales", 4);
    add_floats(e, "openbtf.factorViews", 9);
    add_attribute(e, "openbtf.horizonScale", EXR_ATTR_FLOAT)->f = -3;
    add_attribute(e, "openbtf.blend", EXR_ATTR_STRING)->text = strdup("roots");
    m = open_accepted(e);
    assert_same_material(m, plain);
    btf_material_close(&m);

    e = take(&plain_file);
    edit_find_attribute(e, "openbtf.version")->i = 2;
    edit_copy_part(e, "shadow", "preview");
    edit_resize(edit_find_part(e, "preview"), WIDTH, HEIGHT);
    edit_remove_channel(edit_find_part(e, "preview"), "Y");
    for (int c = 0; c < 3; c++) {
        edit_add_channel(edit_find_part(e, "preview"), (const char[2]){"RGB"[c], 0}, EXR_PIXEL_HALF);
    }
    m = open_accepted(e);
    assert_same_material(m, plain);
    void *data;
    size_t size;
    assert_int_equal(btf_material_save_memory(m, NULL, &data, &size), BTF_OK);
    assert_int_equal(size, plain_file.size);
    assert_memory_equal(data, plain_file.data, size);
    btf_free(data);
    btf_material_close(&m);

    e = take(&plain_file); /* the store is that of version 1 */
    edit_find_attribute(e, "openbtf.version")->i = 2;
    add_floats(e, "openbtf.factorScales", 4);
    file_refused(e, "attribute openbtf.factorScales is there, but there are no units of factors");
    e = take(&plain_file);
    edit_find_attribute(e, "openbtf.version")->i = 2;
    add_attribute(e, "openbtf.blend", EXR_ATTR_STRING)->text = strdup("roots");
    m = open_accepted(e);
    assert_int_equal(accepted_info(m).blend, BTF_BLEND_ROOTS);
    assert_int_equal(accepted_info(m).store, BTF_STORE_COMPONENTS);
    assert_int_equal(accepted_info(m).version, 2);
    btf_material_close(&m);
    btf_material_close(&plain);
}

RUN_TESTS(setup, teardown)
