/* Valid materials of version 2, filled with seeded random values, for tests.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_FACTOR_MATERIAL_H
#define OPENBTF_TESTS_FACTOR_MATERIAL_H

#include "random_material.h"

/* Nine units of every class: of class 0 two, of class 1 one, of class 2 three, of class 3 one, of class 4
 * two; in class 2 Y alone, elsewhere C1 or C2 too. They have 11 layers of factor_texels. */
enum { FACTOR_UNITS = 9, FACTOR_LAYERS = 11 };
extern const uint32_t factor_classes[BTF_FACTOR_CLASSES][3];

/* random_material_desc with factors of these classes for its residual, and a horizon. */
btf_material_desc factor_material_desc(uint32_t width, uint32_t height, uint32_t n_views, uint32_t n_lights,
                                       btf_layout layout, uint32_t effects,
                                       const uint32_t classes[BTF_FACTOR_CLASSES][3]);

/* Packs shift and gain where the layout and the effects allow it: gains of 0.3 to 1.95. */
void factor_material_pack_points(btf_material_desc *desc);
/* The same in lists of so many entries. */
void factor_material_list_points(btf_material_desc *desc, uint32_t entries);

/* Chooses at random the stores of the residual and of points, and the blend, with one to ten units of any class. */
void factor_material_choose(random_state *r, btf_material_desc *desc);

/* random_material_fill, then, where the store is factors, codes, scales and factors of the views. */
void factor_material_fill(random_state *r, btf_material_desc *desc);

/* The words of a texture of words, and the numbers of one of floats, to be changed. */
uint32_t *factor_words(const btf_material_desc *desc, btf_texture_id id);
float *factor_numbers(const btf_material_desc *desc, btf_texture_id id);

#endif
