/* Materials that must be the same. See same_material.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "same_material.h"

#include "refusals.h"
#include "test.h"

static void assert_same_directions(btf_directions a, btf_directions b) {
    assert_int_equal(a.count, b.count);
    assert_memory_equal(a.xyz, b.xyz, a.count * 3 * sizeof *a.xyz);
    assert_memory_equal(a.vertices, b.vertices, a.count * 2 * sizeof *a.vertices);
    assert_int_equal(a.triangle_count, b.triangle_count);
    if (a.triangle_count) {
        assert_memory_equal(a.triangles, b.triangles, a.triangle_count * 3);
    }
    assert_int_equal(a.hull_count, b.hull_count);
    if (a.hull_count) {
        assert_memory_equal(a.hull, b.hull, a.hull_count);
    }
    assert_int_equal(a.grid, b.grid);
    assert_int_equal(a.cells_length, b.cells_length);
    assert_memory_equal(a.cells, b.cells, a.cells_length * sizeof *a.cells);
}

/* Arrays of so many bytes, which may have none. */
static void assert_same_bytes(const void *a, size_t size_a, const void *b, size_t size_b) {
    assert_int_equal(size_a, size_b);
    if (size_a) {
        assert_memory_equal(a, b, size_a);
    } else {
        assert_null(a);
    }
}

void assert_same_material(const btf_material *a, const btf_material *b) {
    btf_material_info ia = accepted_info(a), ib = accepted_info(b);
    assert_string_equal(ia.method, ib.method);
    assert_string_equal(ia.options, ib.options);
    assert_string_equal(ia.source, ib.source);
    ia.method = ib.method = ia.options = ib.options = ia.source = ib.source = NULL;
    assert_memory_equal(&ia, &ib, sizeof ia);
    for (uint32_t level = 0; level < ia.levels; level++) {
        for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
            const btf_texture ta = btf_material_level_texture(a, level, (btf_texture_id)id),
                              tb = btf_material_level_texture(b, level, (btf_texture_id)id);
            assert_int_equal(ta.format, tb.format);
            assert_int_equal(ta.width, tb.width);
            assert_int_equal(ta.height, tb.height);
            assert_int_equal(ta.layers, tb.layers);
            assert_int_equal(ta.is_array, tb.is_array);
            assert_same_bytes(ta.data, ta.size, tb.data, tb.size);
        }
    }
    assert_same_directions(btf_material_views(a), btf_material_views(b));
    assert_same_directions(btf_material_lights(a), btf_material_lights(b));
    const uint16_t *pa = btf_material_preview(a), *pb = btf_material_preview(b);
    const size_t picture = 8 * (size_t)ia.width * ia.height;
    assert_same_bytes(pa, pa ? picture : 0, pb, pb ? picture : 0);
    size_t na, nb;
    const btf_material_error *ea = btf_material_errors(a, &na), *eb = btf_material_errors(b, &nb);
    assert_same_bytes(ea, na * sizeof *ea, eb, nb * sizeof *eb);
    const btf_level_error *la = btf_material_level_errors(a, &na), *lb = btf_material_level_errors(b, &nb);
    assert_same_bytes(la, na * sizeof *la, lb, nb * sizeof *lb);
}

btf_material *through_a_file(const btf_material *material) {
    void *data, *again;
    size_t size, again_size;
    btf_material *opened;
    assert_int_equal(btf_material_save_memory(material, &log_keep, &data, &size), BTF_OK);
    if (btf_material_open_memory(data, size, &log_keep, &opened)) {
        fail_msg("%s", last_message);
    }
    assert_same_material(material, opened);
    assert_int_equal(btf_material_save_memory(opened, &log_keep, &again, &again_size), BTF_OK);
    assert_same_bytes(data, size, again, again_size);
    btf_free(data);
    btf_free(again);
    return opened;
}

/* Whether the library makes the texture of a material of the desc (FORMAT.md section 3). */
static bool library_makes(const btf_material_desc *desc, int id) {
    const bool relief_or_gloss = desc->info.effects & (BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS);
    return id == BTF_TEXTURE_VIEW_TABLE || id == BTF_TEXTURE_LIGHT_TABLE ||
           (id == BTF_TEXTURE_VIEW_VECTORS && relief_or_gloss);
}

static void assert_holds(const btf_material *material, const btf_material_desc *desc) {
    const btf_material_info info = accepted_info(material);
    assert_int_equal(info.levels, desc->info.levels ? desc->info.levels : 1);
    for (uint32_t level = 0; level < BTF_MAX_LEVELS; level++) {
        for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
            const btf_texture t = btf_material_level_texture(material, level, (btf_texture_id)id);
            const void *given = level ? desc->level_texture[level][id] : desc->texture[id];
            assert_int_equal(t.data != NULL, given != NULL || (level == 0 && library_makes(desc, id)));
            if (given) {
                assert_memory_equal(t.data, given, t.size);
            }
        }
    }
    const btf_directions views = btf_material_views(material), lights = btf_material_lights(material);
    assert_memory_equal(views.xyz, desc->views, desc->info.n_views * 3 * sizeof(float));
    assert_memory_equal(lights.xyz, desc->lights, desc->info.n_lights * 3 * sizeof(float));
    size_t count;
    const btf_level_error *errors = btf_material_level_errors(material, &count);
    assert_same_bytes(errors, count * sizeof *errors, desc->level_errors,
                      desc->level_error_count * sizeof *desc->level_errors);
}

void round_trip(const btf_material_desc *desc) {
    btf_material *material = create_accepted(desc), *opened = through_a_file(material);
    assert_holds(material, desc);
    assert_holds(opened, desc);
    btf_material_close(&material);
    btf_material_close(&opened);
    assert_null(material);
}
