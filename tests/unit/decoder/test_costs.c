/* Cost models: which files are read, which are refused and why, and that plans use their prices.
 *
 * SPDX-License-Identifier: MIT
 */
#include "tests/support/factor_material.h"
#include "tests/support/refusals.h"
#include "tests/support/test.h"

#include <openbtf/fold.h>

#include <unistd.h>

#define REST                                                                                               \
    "\"pixel\": 1, \"look_up\": 2.5, \"point\": 0.5, \"move\": 4e0, \"step\": 0, \"fetch\": 1.25e+1,"      \
    "\"byte\": 125E-3, \"integer\": 0.02, \"masked\": 0"
#define GOOD "{\"openbtf_costs\": 1, " REST ", \"float\": 0.03}"

static btf_result parse(const char *text, btf_cost_model *out) {
    message_count = 0;
    return btf_cost_model_read(text, strlen(text), "costs.json", &log_keep, out);
}

TEST(files_are_read) {
    btf_cost_model m;
    assert_int_equal(parse(GOOD, &m), BTF_OK);
    assert_true(m.struct_size == sizeof m && m.device[0] == 0 && m.pixel == 1 && m.look_up == 2.5 &&
                m.point == 0.5 && m.move == 4 && m.step == 0 && fabs(m.fetch - 12.5) < 1e-12 &&
                fabs(m.byte - 0.125) < 1e-15 && fabs(m.integer - 0.02) < 1e-15 &&
                fabs(m.real - 0.03) < 1e-15);
    /* members in any order, members that only inform people, escapes, spaces */
    assert_int_equal(
        parse(" {\n\t\"float\" : 0.03 ,\"device\":\"a \\\"GPU\\\" \\u0041\\u20ac\\n\", \"variants\": 90,\r"
              "\"deviation\": 0.05, " REST ", \"openbtf_costs\": 1} \n",
              &m),
        BTF_OK);
    assert_string_equal(m.device, "a \"GPU\" A?\n");
    assert_int_equal(message_count, 0);
    char text[1000], name[400];
    memset(name, 'x', sizeof name - 1);
    name[sizeof name - 1] = 0;
    snprintf(text, sizeof text, "{\"openbtf_costs\": 1, " REST ", \"float\": 0, \"device\": \"%s\"}", name);
    assert_int_equal(parse(text, &m), BTF_OK);
    assert_int_equal(strlen(m.device), sizeof m.device - 1);
}

/* clang-format off */
static const struct {
    const char *text, *message;
} refused[] = {
    {"", "byte 0: expected {, the start of a cost model"},
    {"[]", "byte 0: expected {"},
    {"{}", "expected a key in quotes"},
    {"{\"pixel\": 1", "expected , or }"},
    {"{\"pixel\" 1}", "expected a colon"},
    {GOOD "x", "expected the end of the file"},
    {GOOD GOOD, "expected the end of the file"},
    {"{\"openbtf_costs\": 1, " REST "}", "costs.json: float is missing"},
    {"{" REST ", \"float\": 1}", "openbtf_costs is missing"},
    {"{\"openbtf_costs\": 2, " REST ", \"float\": 1}", "openbtf_costs is 2; this library reads 1"},
    {"{\"openbtf_costs\": -1, " REST ", \"float\": 1}", "openbtf_costs is -1; this library reads 1"},
    {"{\"openbtf_costs\": 1, " REST ", \"float\": -0.5}", "float is -0.5, not within 0 to 1e+06"},
    {"{\"openbtf_costs\": 1, " REST ", \"float\": 1000001}", "float is 1000001, not within 0 to 1e+06"},
    {"{\"openbtf_costs\": 1, " REST ", \"float\": 1e400}", "float is 1e400, not within"},
    {"{\"openbtf_costs\": 1, " REST ", \"float\": -1e400}", "float is -1e400, not within"},
    {"{\"openbtf_costs\": 1, " REST ", \"float\": NaN}", "float is NaN, not a number"},
    {"{\"openbtf_costs\": 1, " REST ", \"float\": Infinity}", "float is Infinity, not a number"},
    {"{\"openbtf_costs\": 1, " REST ", \"float\": \"1\"}", "float is \"1\", not a number"},
    {"{\"openbtf_costs\": 1, " REST ", \"float\": null}", "float is null, not a number"},
    {"{\"openbtf_costs\": 1, " REST ", \"float\": 1.}", "float is 1., not a number"},
    {"{\"openbtf_costs\": 1, " REST ", \"float\": .5}", "float is .5, not a number"},
    {"{\"openbtf_costs\": 1, " REST ", \"float\": 01}", "float is 01, not a number"},
    {"{\"openbtf_costs\": 1, " REST ", \"float\": 1e}", "float is 1e, not a number"},
    {"{\"openbtf_costs\": 1, " REST ", \"float\": 1 2}", "expected , or }"},
    {"{\"openbtf_costs\": 1, " REST ", \"float\": 0x10}", "float is 0x10, not a number"},
    {"{\"openbtf_costs\": 1, " REST ", \"float\": }", "float is nothing, not a number"},
    {"{\"openbtf_costs\": 1, " REST ", \"float\": [1]}", "float is nothing, not a number"},
    {"{\"openbtf_costs\": 1, " REST ", \"float\": 1,}", "expected a key in quotes"},
    {"{\"openbtf_costs\": 1, " REST ", \"float\": 1, \"float\": 1}", "float is there twice"},
    {"{\"openbtf_costs\": 1, " REST ", \"float\": 1, \"texel\": 1}", "unknown key \"texel\""},
    {"{\"openbtf_costs\": 1, " REST ", \"float\": 1, \"device\": 3}", "expected a string after \"device\""},
    {"{\"openbtf_costs\": 1, " REST ", \"float\": 1, \"device\": \"a}", "expected \" at the end of a string"},
    {"{\"openbtf_costs\": 1, " REST ", \"float\": 1, \"device\": \"\\q\"}", "expected an escape of JSON"},
    {"{\"openbtf_costs\": 1, " REST ", \"float\": 1, \"device\": \"\\u12g4\"}", "expected an escape of JSON"},
    {"{\"openbtf_costs\": 1, " REST ", \"float\": 1, \"device\": \"\n\"}", "expected no control character"},
    {"{\"openbtf_costs\": 1, " REST ", \"float\": 1, \"deviation\": -1}", "deviation is -1, not within"},
    {"{\"openbtf_costs\": 1, \"pixel\": 0, \"look_up\": 0, \"point\": 0, \"move\": 0, \"step\": 0, \"fetch\": 0,"
     "\"byte\": 0, \"integer\": 0, \"float\": 0, \"masked\": 0}", "every price is 0"},
};
/* clang-format on */

TEST(others_are_refused) {
    const btf_cost_model before = {.struct_size = 7, .device = "untouched"};
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        btf_cost_model m = before;
        const btf_result result = parse(refused[i].text, &m);
        if (result != BTF_ERROR_BAD_FILE || message_count != 1 ||
            !strstr(last_message, refused[i].message) || strncmp(last_message, "costs.json: ", 12) != 0) {
            fail_msg("%s: %d, \"%s\" for \"%s\"", refused[i].text, (int)result, last_message,
                     refused[i].message);
        }
        assert_memory_equal(&m, &before, sizeof m);
        assert_int_equal(btf_cost_model_read(refused[i].text, strlen(refused[i].text), "x", NULL, &m),
                         BTF_ERROR_BAD_FILE);
    }
    /* cut off anywhere it is no model, and nothing behind the end is read */
    for (size_t size = 0; size < strlen(GOOD); size++) {
        char *cut = malloc(size + 1);
        btf_cost_model m;
        assert_non_null(cut);
        memcpy(cut, GOOD, size);
        assert_int_equal(btf_cost_model_read(cut, size, "x", NULL, &m), BTF_ERROR_BAD_FILE);
        free(cut);
    }
}

TEST(files_are_opened) {
    btf_cost_model m;
    char path[] = "/tmp/btf-costs-XXXXXX";
    const int made = mkstemp(path);
    assert_true(made >= 0);
    FILE *file = fdopen(made, "w");
    fputs(GOOD, file);
    assert_int_equal(fclose(file), 0);
    assert_int_equal(btf_cost_model_open(path, &log_keep, &m), BTF_OK);
    assert_true(m.pixel == 1);
    file = fopen(path, "a");
    for (int i = 0; i < 70000; i++) {
        fputc(' ', file);
    }
    assert_int_equal(fclose(file), 0);
    message_count = 0;
    assert_int_equal(btf_cost_model_open(path, &log_keep, &m), BTF_ERROR_BAD_FILE);
    assert_non_null(strstr(last_message, "a cost model has 65536 at most"));
    unlink(path);
    assert_int_equal(btf_cost_model_open(path, &log_keep, &m), BTF_ERROR_IO);
    assert_non_null(strstr(last_message, path));
    assert_int_equal(btf_cost_model_open("/", &log_keep, &m), BTF_ERROR_IO);
}

/* A price alone makes its count the cost; NULL are those built in. */
TEST(costs_are_counts_by_prices) {
    btf_decode_counts n = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
#define ALONE(price, name, count)                                                                          \
    {                                                                                                      \
        const btf_cost_model m = {.struct_size = sizeof m, .price = 10};                                   \
        assert_true(btf_cost_of(&n, &m) == 10 * n.count);                                                  \
    }
    BTF_COST_LIST(ALONE)
    assert_true(btf_cost_of(&n, NULL) == btf_cost_of(&n, btf_cost_model_builtin()));
    n = (btf_decode_counts){0};
    assert_true(btf_cost_of(&n, NULL) == 1e-6);
}

TEST(plans_go_by_the_prices) {
    random_state r = {6};
    static const uint32_t classes[BTF_FACTOR_CLASSES][3] = {{2, 4, 2}, {1, 1, 1}, {5, 2, 3}, {1}, {4}};
    btf_material_desc desc = factor_material_desc(4, 4, 81, 81, BTF_LAYOUT_TIGHT,
                                                  BTF_EFFECT_SHIFT | BTF_EFFECT_RESIDUAL, classes);
    btf_material *material = NULL;
    desc.info.colour = BTF_COLOUR_NONE;
    desc.info.lobes = 0;
    factor_material_fill(&r, &desc);
    assert_int_equal(btf_material_create(&desc, NULL, &material), BTF_OK);
    random_material_free(&desc);
    const btf_cost_model fetches = {.struct_size = sizeof fetches, .fetch = 1},
                         floats = {.struct_size = sizeof floats, .real = 1};
    btf_scene scene = {
        .struct_size = sizeof scene, .light = {.fixed = 1, .direction = {0, 0, 1}}, .costs = &fetches};
    btf_material_info info = accepted_info(material);
    btf_shader_options o = {.struct_size = sizeof o};
    const btf_decode_counts n = btf_count_decode(&info, &o);
    assert_true(n.fetches > 100 && btf_plan_cost(material, &o, &scene) == (float)n.fetches);
    btf_plan plan;
    assert_int_equal(btf_plan_effects(material, &scene, 0.5f, &plan), BTF_OK);
    assert_true(plan.full_cost == (float)n.fetches && plan.cost < plan.full_cost &&
                plan.scene.costs == &fetches);
    /* a fold reads three texels a pixel, and makes them by a fetch each of what one view takes */
    assert_true(plan.fold == BTF_FOLD_LIGHT && plan.folded_cost == 3);
    o.fold = BTF_FOLD_LIGHT;
    assert_true(btf_fold_cost(material, &o, &scene).folded == 3);
    scene.costs = &floats;
    assert_true(btf_fold_cost(material, &o, &scene).folded == 1e-6f);
    assert_int_equal(btf_plan_effects(material, &scene, 0.5f, &plan), BTF_OK);
    assert_true(plan.full_cost == (float)n.floats);
    btf_material_close(&material);
}

RUN_TESTS(NULL, NULL)
