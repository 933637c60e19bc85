/* Materials and files for the tests of factors. See factors.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "factors.h"

#include "tests/support/test.h"

btf_material_desc make_desc(uint64_t seed, btf_layout layout, uint32_t effects) {
    random_state r = {seed};
    btf_material_desc desc =
        factor_material_desc(WIDTH, HEIGHT, VIEWS, LIGHTS, layout, effects, factor_classes);
    factor_material_fill(&r, &desc);
    return desc;
}

uint16_t *make_preview(uint32_t width, uint32_t height) {
    uint16_t *preview = malloc(8 * (size_t)width * height);
    assert_non_null(preview);
    for (size_t i = 0; i < 4 * (size_t)width * height; i++) {
        preview[i] = i % 4 == 3 ? 0 : (uint16_t)(0x3000 + i);
    }
    return preview;
}

saved factor_file, plain_file;

static saved save(const btf_material_desc *desc) {
    btf_material *m = create_accepted(desc);
    const saved s = save_material(m);
    btf_material_close(&m);
    return s;
}

int setup(void **state) {
    (void)state;
    btf_material_desc desc = make_desc(10, BTF_LAYOUT_TIGHT, BTF_EFFECT_VERSION_1);
    uint16_t *preview = make_preview(WIDTH, HEIGHT);
    desc.preview = preview;
    desc.info.blend = BTF_BLEND_ROOTS;
    factor_file = save(&desc);
    free(preview);
    random_material_free(&desc);
    random_state r = {11};
    desc = random_material_desc(WIDTH, HEIGHT, VIEWS, LIGHTS, BTF_LAYOUT_TIGHT, BTF_EFFECT_VERSION_1);
    desc.info.domain = BTF_DOMAIN_SQRT;
    random_material_fill(&r, &desc);
    plain_file = save(&desc);
    random_material_free(&desc);
    return 0;
}

int teardown(void **state) {
    (void)state;
    btf_free(factor_file.data);
    btf_free(plain_file.data);
    return 0;
}
