/* Materials of format version 2, and files of them to be edited, for the tests of factors.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_UNIT_FACTORS_H
#define OPENBTF_TESTS_UNIT_FACTORS_H

#include "tests/support/exr_edit.h"
#include "tests/support/factor_material.h"
#include "tests/support/refusals.h"
#include "tests/support/same_material.h"

enum { WIDTH = 5, HEIGHT = 4, VIEWS = 8, LIGHTS = 7 };

/* factor_material_desc of this size and of factor_classes, filled. */
btf_material_desc make_desc(uint64_t seed, btf_layout layout, uint32_t effects);

/* Halves that differ from one another, and 0 in every fourth. */
uint16_t *make_preview(uint32_t width, uint32_t height);

/* Files to be edited: of factors and every effect, with a picture; of components, of version 1. */
extern saved factor_file, plain_file;

/* Make and free these files, for cmocka's groups. */
int setup(void **state);
int teardown(void **state);

#endif
