/* factor_file OUT SEED [LAYOUT LEVELS BLEND POINTS]: writes a material of version 2 filled at random, with
 * every effect of version 1, or with shift and gain packed where POINTS is `packed`, in lists of four where
 * it is `lists`; `relief` adds relief and gloss, `height` the same with one height everywhere.
 *
 * SPDX-License-Identifier: MIT
 */
#include "tests/support/factor_material.h"
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void print_message(void *user, btf_log_level level, const char *message) {
    (void)user;
    (void)level;
    fprintf(stderr, "factor_file: %s\n", message);
}

int main(int argc, char **argv) {
    const btf_log log = {print_message, NULL};
    if (argc < 3) {
        return 1;
    }
    random_state r = {strtoul(argv[2], NULL, 10)};
    const btf_layout layout =
        argc > 3 && strcmp(argv[3], "paper") == 0 ? BTF_LAYOUT_PAPER : BTF_LAYOUT_TIGHT;
    const char *points = argc > 6 ? argv[6] : "";
    const bool lists = strcmp(points, "lists") == 0;
    const bool height = strcmp(points, "height") == 0, relief = height || strcmp(points, "relief") == 0;
    const uint32_t effects = lists || strcmp(points, "packed") == 0 ? BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN
                             : relief                               ? BTF_EFFECT_ALL
                                                                    : BTF_EFFECT_VERSION_1;
    btf_material_desc desc = factor_material_desc(16, 12, 19, 19, layout, effects, factor_classes);
    lists ? factor_material_list_points(&desc, 4) : factor_material_pack_points(&desc);
    if (height) {
        desc.info.relief_step = 0;
        desc.info.relief_steps = 1;
    }
    desc.info.levels = argc > 4 ? (uint32_t)strtoul(argv[4], NULL, 10) : 1;
    desc.info.blend = argc > 5 && strcmp(argv[5], "roots") == 0 ? BTF_BLEND_ROOTS : BTF_BLEND_RADIANCE;
    /* Small enough values for a picture to show more than white. */
    desc.info.radiance_scale = 0x1p-6f;
    factor_material_fill(&r, &desc);
    btf_material *material = NULL;
    btf_result result = btf_material_create(&desc, &log, &material);
    if (!result) {
        result = btf_material_save(material, argv[1], &log);
    }
    btf_material_close(&material);
    random_material_free(&desc);
    return result;
}
