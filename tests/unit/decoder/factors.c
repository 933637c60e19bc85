/* Materials and files for the tests of factors. See factors.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "factors.h"
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

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

btf_material_info info_of(const btf_material *material) {
    btf_material_info info = {.struct_size = sizeof info};
    assert_int_equal(btf_material_get_info(material, &info), BTF_OK);
    return info;
}

saved factor_file, plain_file;

saved save(const btf_material_desc *desc) {
    btf_material *m = create_accepted(desc);
    saved s;
    assert_int_equal(btf_material_save_memory(m, NULL, &s.data, &s.size), BTF_OK);
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

edit_file *take(const saved *s) {
    return edit_load(s->data, s->size);
}

btf_material *accepted(edit_file *file) {
    btf_material *m;
    if (open_edited(file, &m)) {
        fail_msg("refused: %s", last_message);
    }
    return m;
}

void assert_same_material(const btf_material *a, const btf_material *b) {
    const btf_material_info ia = info_of(a), ib = info_of(b);
    assert_int_equal(ia.version, ib.version);
    assert_int_equal(ia.store, ib.store);
    assert_int_equal(ia.blend, ib.blend);
    assert_int_equal(ia.components, ib.components);
    assert_true(ia.horizon_scale == ib.horizon_scale);
    assert_memory_equal(ia.factor_classes, ib.factor_classes, sizeof ia.factor_classes);
    assert_int_equal(ia.levels, ib.levels);
    assert_int_equal(ia.gpu_bytes, ib.gpu_bytes);
    assert_int_equal(ia.table_bytes, ib.table_bytes);
    for (uint32_t level = 0; level < ia.levels; level++) {
        for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
            const btf_texture ta = btf_material_level_texture(a, level, (btf_texture_id)id),
                              tb = btf_material_level_texture(b, level, (btf_texture_id)id);
            assert_int_equal(ta.size, tb.size);
            if (ta.size) {
                assert_memory_equal(ta.data, tb.data, ta.size);
            }
        }
    }
    const uint16_t *pa = btf_material_preview(a), *pb = btf_material_preview(b);
    assert_int_equal(pa != NULL, pb != NULL);
    if (pa) {
        assert_memory_equal(pa, pb, 8 * (size_t)ia.width * ia.height);
    }
}

void round_trip(const btf_material_desc *desc) {
    btf_material *m = create_accepted(desc), *opened;
    void *data, *again;
    size_t size, size_again;
    assert_int_equal(btf_material_save_memory(m, &log_keep, &data, &size), BTF_OK);
    if (btf_material_open_memory(data, size, &log_keep, &opened)) {
        fail_msg("%s", last_message);
    }
    assert_same_material(m, opened);
    for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
        if (desc->texture[id]) {
            assert_memory_equal(btf_material_texture(opened, (btf_texture_id)id).data, desc->texture[id],
                                btf_material_texture(opened, (btf_texture_id)id).size);
        }
    }
    assert_int_equal(btf_material_save_memory(opened, &log_keep, &again, &size_again), BTF_OK);
    assert_int_equal(size, size_again);
    assert_memory_equal(data, again, size);
    btf_free(data);
    btf_free(again);
    btf_material_close(&m);
    btf_material_close(&opened);
}
