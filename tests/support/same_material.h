/* Materials that must be the same, and the way of one through a file.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_SAME_MATERIAL_H
#define OPENBTF_TESTS_SAME_MATERIAL_H

#include <openbtf/material.h>

/* Facts, textures of all levels, directions, preview and tables of errors are the same, bit for bit. */
void assert_same_material(const btf_material *a, const btf_material *b);

/* The material from a file in memory: the same, and written again the same bytes. */
btf_material *through_a_file(const btf_material *material);

/* A material of the desc, before and behind a file, has the textures, directions and errors of levels of the desc. */
void round_trip(const btf_material_desc *desc);

#endif
