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

#include <stdio.h>
#include <stdlib.h>

enum { SIDE = 16, PIXELS = SIDE * SIDE, PLANES = 5, LARGEST = 400000 }; /* bytes of a material's textures */
static const char *const plane_names[PLANES] = {"uv", "light", "view", "radiance", "picked"};

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

/* One vector's files and its entry in the manifest. */
static btf_result write_vector(const char *directory, int number, const variant *v, const btf_log *log,
                               json *j, float (*planes)[PIXELS][3]) {
    btf_material *material = NULL;
    btf_result result = synthetic_create(&v->spec, log, &material);
    if (result != BTF_OK)
        return result;
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    if (info.gpu_bytes > LARGEST) { /* the others have all that it shows */
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
    for (int p = 0; p < PLANES && result == BTF_OK; ++p) {
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
    if (!text)
        return BTF_ERROR_MEMORY;
    char path[1200];
    snprintf(path, sizeof path, "%.1000s/manifest.json", directory);
    output *file = NULL;
    btf_result result = output_open(path, log ? *log : (btf_log){0}, &file);
    if (result != BTF_OK)
        return result;
    fputs(text, output_stream(file));
    return output_commit(&file);
}

btf_result vectors_write(const char *directory, uint64_t seed, const btf_log *log) {
    variant *list = calloc(VARIANT_MAX, sizeof *list);
    float(*planes)[PIXELS][3] = calloc(PLANES, sizeof *planes);
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
        "numbers of (column, row, `number`). Float channels; arguments may be NaN or infinite.");
    json_array(&j, "vectors");
    for (size_t i = 0; i < count && result == BTF_OK; ++i)
        result = write_vector(directory, (int)i, &list[i], log, &j, planes);
    json_end(&j);
    json_end(&j);
    if (result == BTF_OK)
        result = write_manifest(directory, &j, log);
    json_free(&j);
    free(planes);
    free(list);
    return result;
}
