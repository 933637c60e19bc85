/* Checks that materials are the same, also after saving and opening.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_SAME_MATERIAL_H
#define OPENBTF_TESTS_SAME_MATERIAL_H

#include <openbtf/material.h>

/* Info, textures of all levels, directions, preview and tables of errors must be the same, bit for bit. */
void assert_same_material(const btf_material *a, const btf_material *b);

/* Saves to memory and opens again: the material must be the same, and saving it once more must give the same bytes.
 * Returns it. */
btf_material *through_a_file(const btf_material *material);

/* A material made of the desc has the desc's textures, directions and errors of levels, also after saving and
 * opening. */
void round_trip(const btf_material_desc *desc);

#endif
