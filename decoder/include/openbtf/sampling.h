/* OpenBTF: tables by which renderers draw the direction to the light in proportion to the radiance that a
 * material would reflect (decoder/SAMPLING.md).
 *
 * The tables are made of the material itself; no file holds them. btf_ref_sample_light() and
 * btf_ref_pdf_light() of openbtf/reference.h read them.
 *
 * Thread rule: tables are immutable once made; functions with gl in their names as in gl.h: one context, current.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_SAMPLING_H
#define OPENBTF_SAMPLING_H

#include <openbtf/evaluate.h>
#include <openbtf/gl.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Tables of light sampling, as textures. */
typedef struct btf_light_sampling {
    uint32_t n_views, n_lights; /**< as in btf_material_info */
    uint32_t n_triangles; /**< triangles of the lights; where there are none, 1, which is never drawn */
    /** RGBA32UI, [n_views + 1][n_triangles][4], texture `sampling_triangles`. Row of a view, for each
     * triangle: in R the end of its part of 2^32, then the bits of the floats at its corners; last row: in
     * R, G, B its corners in the plane of the directions, x + 65536 y. */
    const uint32_t *triangles;
    /** R32F, [n_views][n_lights + 1], texture `sampling_densities`: at each light the density in the plane
     * whose horizon has radius 1, then the share of the cosine. */
    const float *densities;
} btf_light_sampling;

/** Makes the tables of a material, whose evaluator is handed over. Errors: BTF_ERROR_USAGE (a null
 * pointer), BTF_ERROR_MEMORY. *out_sampling is freed with btf_light_sampling_destroy. */
btf_result btf_light_sampling_create(const btf_material *material, const btf_evaluator *evaluator,
                                     const btf_log *log, btf_light_sampling **out_sampling);

/** Frees *sampling and sets it to NULL. NULL and a pointer to NULL are accepted. */
void btf_light_sampling_destroy(btf_light_sampling **sampling);

/** Tables of light sampling in the current GL context, for shaders of `#define BTF_SAMPLING 1`. */
typedef struct btf_gl_light_sampling btf_gl_light_sampling;

/** Uploads the two tables as textures; @p sampling may be destroyed afterwards. Of @p options get_proc_address is
 * read. All state of GL is as before. Errors: BTF_ERROR_USAGE (a null pointer, no get_proc_address),
 * BTF_ERROR_UNSUPPORTED (a missing function; a table beyond GL's limits, and the message says which), BTF_ERROR_MEMORY.
 * On error *out_sampling is NULL and nothing is left behind. */
btf_result btf_gl_light_sampling_create(const btf_light_sampling *sampling, const btf_gl_options *options,
                                        const btf_log *log, btf_gl_light_sampling **out_sampling);

/** Points the samplers of a linked program at the textures, as btf_gl_bind does those of the material. Sets: the
 * uniforms, and the texture bindings of units first_unit .. first_unit + *out_units - 1 (sampler objects of these units
 * are unbound). *out_units, which may be NULL, gets how many that are: 2, or those that the program reads. @p prefix as
 * in btf_shader_options, NULL for "btf". */
void btf_gl_light_sampling_bind(btf_gl_light_sampling *sampling, uint32_t program, uint32_t first_unit,
                                const char *prefix, uint32_t *out_units);

/** @return the bytes of both textures. */
size_t btf_gl_light_sampling_bytes(const btf_gl_light_sampling *sampling);

/** Deletes the textures and sets *sampling to NULL. NULL and a pointer to NULL are accepted. */
void btf_gl_light_sampling_destroy(btf_gl_light_sampling **sampling);

#ifdef __cplusplus
}
#endif
#endif
