/* Facts of a material that btf-info prints as text and as JSON alike: names, counts, gains.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_INFO_FACTS_H
#define OPENBTF_TOOLS_INFO_FACTS_H

#include <openbtf/material.h>
#include <stdbool.h>

/* Words of the enumerations of material.h, by value. */
extern const char *const layout_names[];
extern const char *const domain_names[];
extern const char *const colour_names[];
extern const char *const store_names[];
extern const char *const blend_names[];
extern const char *const point_store_names[];

/* Bits of the codes of w and of u in each class of factors (FORMAT.md section 3). */
extern const int class_bits[BTF_FACTOR_CLASSES][2];

/* A class of factors, counted. */
typedef struct class_counts {
    uint32_t units, words[3]; /* of Y, C1, C2 */
    uint32_t components;
} class_counts;

class_counts count_class(const btf_material_info *info, int c);

/* The format without its prefix: "RGBA8UI". */
const char *format_name(btf_format format);

/* Directions of one polar angle. */
typedef struct ring {
    double theta;
    int count;
} ring;

/* Groups directions whose theta differs by less than 0.05 degrees; returns the number of rings. */
int find_rings(const btf_directions *d, ring rings[BTF_MAX_DIRECTIONS]);

/* Finds the gain of an effect: a row of the table with the effect, and the row that differs only in lacking it. Of
 * several pairs it takes the one with the most effects. False when there is none. */
bool find_gain(const btf_material_error *errors, size_t count, uint32_t effect,
               const btf_material_error **out_with, const btf_material_error **out_without);

/* The bytes that an effect between the samples takes: relief those of its heights; gloss 0, since it reads no texture
 * of its own. */
size_t between_bytes(const btf_material *material, uint32_t effect);

/* What the first number of a row of btf_between_errors means: the level of detail, and in words and as a JSON key what
 * was left out. */
int left_out_level(float number);
const char *left_out_name(float number);
const char *left_out_key(float number);

/* PSNR of a mean squared error, at most 100. */
double decibels(float mse);

/* The error measured of a level; NULL when none was. */
const btf_level_error *find_level_error(const btf_material *material, uint32_t level);

/* Whether a texture is a table, which the bytes called gpu leave out. */
bool is_table(btf_texture_id id);

/* Heights of a relief in texels of level 0, and how many views it acts on. */
typedef struct relief_range {
    double low, high;
    uint32_t views;
} relief_range;
relief_range find_relief(const btf_material *material, const btf_material_info *info);

#endif
