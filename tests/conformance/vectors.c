/* Writes test vectors from the reference decoder.
 *
 * SPDX-License-Identifier: MIT
 */
#include "vectors.h"
#include "cases.h"
#include "decoder/toolkit/cli.h"
#include "decoder/toolkit/exr_image.h"
#include "decoder/toolkit/filter.h"
#include "decoder/toolkit/json.h"
#include "decoder/toolkit/output.h"
#include "decoder/toolkit/reference_view.h"
#include "variant.h"

#include <openbtf/sampling.h>

#include <stdio.h>
#include <stdlib.h>

/* LARGEST: the most bytes of a material's textures. TABLE_WIDTH: pixels in a row of the tables' image. */
enum { SIDE = 16, PIXELS = SIDE * SIDE, PLANES = 5, SAMPLED = 2, LARGEST = 400000, TABLE_WIDTH = 64 };
static const char *const plane_names[PLANES + SAMPLED] = {"uv",     "light", "view",   "radiance",
                                                          "picked", "drawn", "density"};

/* Arguments and radiance of a vector, one RGB plane after the other. */
static void evaluate(const btf_material *material, uint32_t level, const variant *v, int number,
                     float (*planes)[PIXELS][3]) {
    btf_ref_material reference;
    reference_view(material, level, &reference);
    btf_ref_options options = variant_reference_options(&v->shader);
    random_state r = {v->spec.seed};
    for (int i = 0; i < PIXELS; ++i) {
        uint32_t words[CASE_WORDS];
        float f[CASE_WORDS];
        case_make(&r, material, words);
        memcpy(f, words, sizeof f);
        memcpy(planes[0][i], f, 2 * sizeof *f);
        planes[0][i][2] = 0;
        memcpy(planes[1][i], f + 2, 3 * sizeof *f);
        memcpy(planes[2][i], f + 5, 3 * sizeof *f);
        btf_ref_evaluate(&reference, &options, f[0], f[1], f + 2, f + 5, planes[3][i]);
        const uint32_t counter[3] = {(uint32_t)(i % SIDE), (uint32_t)(i / SIDE), (uint32_t)number};
        uint32_t random[3];
        btf_ref_random(counter, random);
        btf_ref_evaluate_stochastic(&reference, &options, BTF_REF_PICK_ALL, f[0], f[1], f + 2, f + 5,
                                    random, planes[4][i]);
    }
}

/* Directions that the tables draw, and densities: of the drawn one, of the pixel's light. */
static void sample(const btf_material *material, const btf_light_sampling *tables, int number,
                   float (*planes)[PIXELS][3]) {
    const btf_ref_sampling sampling = {tables->n_triangles, tables->triangles, tables->densities};
    btf_ref_material reference;
    reference_view(material, 0, &reference);
    for (int i = 0; i < PIXELS; ++i) {
        const uint32_t counter[3] = {(uint32_t)(i % SIDE), (uint32_t)(i / SIDE), (uint32_t)number};
        const float *light = planes[1][i], *view = planes[2][i];
        uint32_t random[3];
        btf_ref_random(counter, random);
        btf_ref_sample_light(&reference, &sampling, 0, 0, view, random[0], random[1], planes[PLANES][i],
                             &planes[PLANES + 1][i][0]);
        planes[PLANES + 1][i][1] = btf_ref_pdf_light(&reference, &sampling, 0, 0, view, light);
        planes[PLANES + 1][i][2] = 0;
    }
}

/* The words of both tables, three a pixel. */
static btf_result write_tables(const char *path, const btf_light_sampling *tables, const btf_log *log) {
    const size_t triangles = 4 * (size_t)tables->n_triangles * (tables->n_views + 1),
                 densities = (size_t)tables->n_views * (tables->n_lights + 1),
                 rows = (triangles + densities + 3 * TABLE_WIDTH - 1) / (3 * TABLE_WIDTH);
    float *words = calloc(rows * TABLE_WIDTH, 3 * sizeof *words);
    if (!words) {
        return BTF_ERROR_MEMORY;
    }
    memcpy(words, tables->triangles, triangles * sizeof *words);
    memcpy(words + triangles, tables->densities, densities * sizeof *words);
    btf_result result =
        exr_image_write(path, TABLE_WIDTH, (int)rows, words, false, log ? *log : (btf_log){0});
    free(words);
    return result;
}

/* Light sampling of every fourth vector. */
static btf_result add_sampling(const char *directory, int number, const btf_material *material,
                               const btf_log *log, json *j, float (*planes)[PIXELS][3]) {
    char path[1200], name[40];
    btf_evaluator *evaluator = NULL;
    btf_light_sampling *tables = NULL;
    btf_result result = btf_evaluator_create(material, log, &evaluator);
    if (result == BTF_OK) {
        result = btf_light_sampling_create(material, evaluator, log, &tables);
    }
    btf_evaluator_destroy(&evaluator);
    if (result != BTF_OK) {
        return result;
    }
    sample(material, tables, number, planes);
    snprintf(name, sizeof name, "%02d-tables.exr", number);
    snprintf(path, sizeof path, "%.1000s/%s", directory, name);
    json_string(j, "tables", name);
    json_integer(j, "triangles", tables->n_triangles);
    result = write_tables(path, tables, log);
    btf_light_sampling_destroy(&tables);
    return result;
}

/* One vector's files and its entry in the manifest. */
static btf_result write_vector(const char *directory, int number, const variant *v, const btf_log *log,
                               json *j, float (*planes)[PIXELS][3]) {
    btf_material *material = NULL;
    btf_result result = synthetic_create(&v->spec, log, &material);
    if (result != BTF_OK) {
        return result;
    }
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    if (info.gpu_bytes > LARGEST) { /* left out: smaller materials show the same */
        btf_material_close(&material);
        return BTF_OK;
    }
    const uint32_t level = (uint32_t)(v->spec.seed % info.levels);
    char path[1200], name[40], effects[48];
    snprintf(name, sizeof name, "%02d.btf.exr", number);
    snprintf(path, sizeof path, "%.1000s/%s", directory, name);
    result = btf_material_save(material, path, log);
    json_object(j, NULL);
    json_string(j, "material", name);
    json_string(j, "about", v->name);
    json_integer(j, "version", info.version);
    json_string(j, "effects", cli_effects_text(v->spec.effects & ~v->shader.leave_out, effects));
    json_integer(j, "components", v->shader.components ? v->shader.components : BTF_MAX_COMPONENTS);
    json_string(j, "interpolation", v->shader.interpolation ? "nearest" : "linear");
    json_string(j, "filter", filter_name(v->shader.filter));
    json_integer(j, "level", level);
    json_integer(j, "number", number);
    evaluate(material, level, v, number, planes);
    const bool drawn = number % 4 == 2;
    if (drawn && result == BTF_OK) {
        result = add_sampling(directory, number, material, log, j, planes);
    }
    for (int p = 0; p < PLANES + (drawn ? SAMPLED : 0) && result == BTF_OK; ++p) {
        snprintf(name, sizeof name, "%02d-%s.exr", number, plane_names[p]);
        snprintf(path, sizeof path, "%.1000s/%s", directory, name);
        result = exr_image_write(path, SIDE, SIDE, planes[p][0], false, log ? *log : (btf_log){0});
        json_string(j, plane_names[p], name);
    }
    json_end(j);
    btf_material_close(&material);
    return result;
}

static btf_result write_manifest(const char *directory, json *j, const btf_log *log) {
    const char *text = json_text(j);
    if (!text) {
        return BTF_ERROR_MEMORY;
    }
    char path[1200];
    snprintf(path, sizeof path, "%.1000s/manifest.json", directory);
    output *file = NULL;
    btf_result result = output_open(path, log ? *log : (btf_log){0}, &file);
    if (result != BTF_OK) {
        return result;
    }
    fputs(text, output_stream(file));
    return output_commit(&file);
}

btf_result vectors_write(const char *directory, uint64_t seed, const btf_log *log) {
    variant *list = calloc(VARIANT_MAX, sizeof *list);
    float(*planes)[PIXELS][3] = calloc(PLANES + SAMPLED, sizeof *planes);
    btf_result result = list && planes ? BTF_OK : BTF_ERROR_MEMORY;
    size_t count = result == BTF_OK ? variant_pairwise(seed, list) : 0;
    json j = {0};
    json_object(&j, NULL);
    json_integer(&j, "version", BTF_FORMAT_VERSION);
    json_string(
        &j, "about",
        "For each vector: decode level of detail `level` of `material` with `effects`, at most "
        "`components` residual components (units, where its store is factors), "
        "`interpolation` and `filter` at each pixel's uv (R, G), light and view (xyz in RGB); all 32 bits "
        "of "
        "each channel of `radiance` must come out, and of `picked` where view, light and texel are picked "
        "by the random "
        "numbers of (column, row, `number`). Float channels; arguments may be NaN or infinite. Vectors "
        "with `tables` have "
        "light sampling (SAMPLING.md) too: its two tables, of `triangles` a row, word by word, three a "
        "pixel; `drawn`, the "
        "direction that the first two of the random numbers draw for the view; `density`, R that of this "
        "direction, G that of "
        "the pixel's light.");
    json_array(&j, "vectors");
    for (size_t i = 0; i < count && result == BTF_OK; ++i) {
        result = write_vector(directory, (int)i, &list[i], log, &j, planes);
    }
    json_end(&j);
    json_end(&j);
    if (result == BTF_OK) {
        result = write_manifest(directory, &j, log);
    }
    json_free(&j);
    free(planes);
    free(list);
    return result;
}
