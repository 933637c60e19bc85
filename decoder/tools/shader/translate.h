/* From the library's GLSL to other languages: SPIR-V by glslang, HLSL and Metal's language from SPIR-V by SPIRV-Cross.
 * A program that was built without them says so.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_SHADER_TRANSLATE_H
#define OPENBTF_SHADER_TRANSLATE_H

#include <openbtf/shader.h>

/* The languages that come from SPIR-V. */
typedef enum translate_target { TRANSLATE_HLSL, TRANSLATE_MSL } translate_target;

/* A decoder as GLSL for Vulkan, and how its names and descriptor set are. */
typedef struct translate_source {
    const char *decoder; /* btf_shader_source, with BTF_BINDINGS_VULKAN */
    const char *prefix;
    uint32_t descriptor_set; /* of the textures */
    int stochastic;          /* btf_evaluate_stochastic and its kin stand in place of btf_evaluate */
} translate_source;

/* The number of evaluations of a work group, and of words of 32 bits of an evaluation: texture coordinates (2 floats),
 * light (3), view (3), level (a float), then the result (3), in whose place stand random numbers before a stochastic
 * decode. */
enum { TRANSLATE_GROUP = 64, TRANSLATE_RECORD = 12, TRANSLATE_RESULT = 9 };

/* A compute shader `main` that decodes an array of evaluations, in a buffer at binding 0 of the next descriptor set, in
 * SPIR-V 1.0. *out_words is freed by the caller. Errors, on the log: BTF_ERROR_UNSUPPORTED (built without glslang),
 * BTF_ERROR_MEMORY, BTF_ERROR_INTERNAL (glslang refuses the text). */
btf_result translate_to_spirv(const translate_source *source, const btf_log *log, uint32_t **out_words,
                              size_t *out_count);

/* The decoder's functions in another language. *out_text is freed by the caller. Errors, on the log: as above, and
 * BTF_ERROR_UNSUPPORTED where the program was built without SPIRV-Cross. */
btf_result translate_to_text(const translate_source *source, translate_target target, const btf_log *log,
                             char **out_text);

#endif
