/* Makes the material that FORMAT.md section 13 takes apart, and decodes it where that section does.
 *
 *     example_file OUT.btf.exr
 *
 * Prints a line a decode: level of the light's z, weights of the lights, radiance.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/reference_view.h"
#include <openbtf/material.h>
#include <openbtf/reference.h>
#include <stdio.h>

static void say(void *user, btf_log_level level, const char *message) {
    (void)user;
    (void)level;
    fprintf(stderr, "example_file: %s\n", message);
}

/* 2 x 2 texels, one view, three lights, one component, no SBRDF: radiance is 0.5 of full scale and less. */
static btf_result make(const btf_log *log, btf_material **out_material) {
    static const float view[3] = {0, 0, 1}, lights[9] = {0, 0, 1, 0.6f, 0, 0.8f, 0, 0.6f, 0.8f};
    static const int8_t texels[4][4] = {{100}, {-50}, {0}, {127}};
    static const int8_t directions[3][3][4] = {
        {{80}, {40}, {-80}}, {{60}, {20}, {-60}}, {{40}, {10}, {-40}}}; /* R, G, B */
    static const float scales[4] = {0x1p-14f};
    btf_material_desc desc = {
        .struct_size = sizeof desc,
        .info = {.struct_size = sizeof desc.info,
                 .width = 2,
                 .height = 2,
                 .n_views = 1,
                 .n_lights = 3,
                 .layout = BTF_LAYOUT_TIGHT,
                 .domain = BTF_DOMAIN_LINEAR,
                 .colour = BTF_COLOUR_NONE,
                 .effects = BTF_EFFECT_RESIDUAL,
                 .components = 1,
                 .radiance_scale = 1,
                 .shadow_scale = 1,
                 .gain_scale = BTF_GAIN_SCALE,
                 .centre_scale = 1},
        .views = view,
        .lights = lights,
    };
    desc.texture[BTF_TEXTURE_RESIDUAL_TEXELS] = texels;
    desc.texture[BTF_TEXTURE_RESIDUAL_DIRECTIONS] = directions;
    desc.texture[BTF_TEXTURE_RESIDUAL_SCALES] = scales;
    return btf_material_create(&desc, log, out_material);
}

int main(int argc, char **argv) {
    const btf_log log = {say, NULL};
    btf_material *material = NULL;
    btf_ref_material reference;
    if (argc != 2) {
        return 1;
    }
    btf_result result = make(&log, &material);
    if (result == BTF_OK) {
        result = btf_material_save(material, argv[1], &log);
    }
    btf_material_close(&material);
    if (result == BTF_OK) { /* decode what was read back from the file */
        result = btf_material_open(argv[1], &log, &material);
    }
    if (result) {
        return btf_result_exit_code(result);
    }
    reference_view(material, 0, &reference);
    static const float view[3] = {0, 0, 1}, light[2][3] = {{0.6f, 0, 0.8f}, {0.28f, 0, 0.96f}};
    const btf_ref_options options = {UINT32_MAX, UINT32_MAX, BTF_REF_LINEAR, BTF_REF_TEXEL};
    for (int i = 0; i < 2; i++) {
        int32_t q[2];
        float rgb[3];
        btf_ref_project(light[i], q);
        const btf_ref_neighbours n = btf_ref_lookup(reference.light_table, reference.light_grid, q);
        btf_ref_evaluate(&reference, &options, 0.25f, 0.75f, light[i], view, rgb);
        printf("q %d %d lights %u %u %u weights %u %u %u rgb %.9g %.9g %.9g\n", (int)q[0], (int)q[1],
               (unsigned)n.index[0], (unsigned)n.index[1], (unsigned)n.index[2], (unsigned)n.weight[0],
               (unsigned)n.weight[1], (unsigned)n.weight[2], (double)rgb[0], (double)rgb[1],
               (double)rgb[2]);
    }
    btf_material_close(&material);
    return 0;
}
