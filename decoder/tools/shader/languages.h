/* The languages that btf-shader writes, and the decoder's text in each.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_SHADER_LANGUAGES_H
#define OPENBTF_SHADER_LANGUAGES_H

#include <openbtf/shader.h>
#include <stdbool.h>

typedef enum language {
    LANGUAGE_GLSL330,
    LANGUAGE_GLSL450,
    LANGUAGE_ESSL300,
    LANGUAGE_ESSL310,
    LANGUAGE_VULKAN,
    LANGUAGE_SPIRV,
    LANGUAGE_HLSL,
    LANGUAGE_MSL,
    LANGUAGE_WGSL
} language;
#define LANGUAGE_CHOICES "glsl330|glsl450|essl300|essl310|vulkan|spirv|hlsl|msl|wgsl"

typedef struct language_facts {
    const char *name; /* "glsl330" */
    const char *file; /* "decode.glsl" */
    /* the line that a shader of this language begins with, in front of the file; "" for none */
    const char *head;
    const char *use;     /* how the file is used, in a sentence or two, for its first comment */
    const char *binding; /* what the manifest's `binding` is in this language */
    btf_bindings bindings;
    /* the language has no `precise`: the uniform PREFIX_zero, which stays 0, keeps sums and products apart */
    bool needs_zero;
} language_facts;

const language_facts *language_facts_of(language l);

/* The decoder with `options`, whose bindings are set here. *out_data, freed by the caller, holds *out_size bytes: a
 * text, or words of SPIR-V. Errors, on the log: those of btf_shader_source, and BTF_ERROR_UNSUPPORTED for a language
 * that the program was built without. */
btf_result language_write(language l, const btf_material *material, const btf_shader_options *options,
                          const btf_log *log, char **out_data, size_t *out_size);

/* The names of the functions to call, without the prefix, ended by NULL. */
const char *const *language_functions(const btf_shader_options *options);

#endif
