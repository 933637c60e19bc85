/* Materials of format version 2, and files of them to be edited, for the tests of factors.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_UNIT_FACTORS_H
#define OPENBTF_TESTS_UNIT_FACTORS_H

#include "tests/support/exr_edit.h"
#include "tests/support/factor_material.h"
#include "tests/support/refusals.h"

enum { WIDTH = 5, HEIGHT = 4, VIEWS = 8, LIGHTS = 7 };

/* factor_material_desc of this size and of factor_classes, filled. */
btf_material_desc make_desc(uint64_t seed, btf_layout layout, uint32_t effects);

/* Halves that differ from one another, and 0 in every fourth. */
uint16_t *make_preview(uint32_t width, uint32_t height);

btf_material_info info_of(const btf_material *material);

/* Files to be edited: of factors and every effect, with a picture; of components, of version 1. */
typedef struct saved {
    void *data;
    size_t size;
} saved;
extern saved factor_file, plain_file;

/* A material of the desc as a file in memory, to be freed with btf_free. */
saved save(const btf_material_desc *desc);

/* Make them and free them, for cmocka's groups. */
int setup(void **state);
int teardown(void **state);

edit_file *take(const saved *s);

/* The edited file must open; returns its material. */
btf_material *accepted(edit_file *file);

/* The members of info that version 2 added, all textures of all levels and the picture are the same. */
void assert_same_material(const btf_material *a, const btf_material *b);

/* A material of the desc, saved and opened, is the same, and saved again the same bytes. */
void round_trip(const btf_material_desc *desc);

#endif
