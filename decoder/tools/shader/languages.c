/* The decoder in each language. See languages.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "languages.h"

#include "cross_text.h"
#include "decoder/toolkit/file.h"
#include "translate.h"
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define UNIT "the texture unit: set the sampler's uniform to it, or to another"

static const language_facts facts[] = {
    [LANGUAGE_GLSL330] =
        {"glsl330", "decode.glsl", "#version 330 core",
         "GLSL 330 core to 460: a library of functions. It stands behind #version and in front of\n"
         "your own text.",
         UNIT, BTF_BINDINGS_NONE, true},
    [LANGUAGE_GLSL450] =
        {"glsl450", "decode.glsl", "#version 450 core",
         "GLSL 450 core: a library of functions. It stands behind #version and in front of your own\n"
         "text; layout qualifiers bind its samplers.",
         "the texture unit, by a layout qualifier", BTF_BINDINGS_GL, false},
    [LANGUAGE_ESSL300] =
        {"essl300", "decode.glsl", "#version 300 es",
         "ESSL 300, the language of OpenGL ES 3.0 and WebGL2: a library of functions. It stands\n"
         "behind #version and in front of your own text.",
         UNIT, BTF_BINDINGS_NONE, true},
    [LANGUAGE_ESSL310] =
        {"essl310", "decode.glsl", "#version 310 es",
         "ESSL 310, the language of OpenGL ES 3.1: a library of functions. It stands behind #version\n"
         "and in front of your own text; layout qualifiers bind its samplers.",
         "the texture unit, by a layout qualifier", BTF_BINDINGS_GL, true},
    [LANGUAGE_VULKAN] =
        {"vulkan", "decode.glsl", "#version 450",
         "GLSL for Vulkan: a library of functions. It stands behind #version and in front of your own\n"
         "text.",
         "of a combined image sampler in `set`", BTF_BINDINGS_VULKAN, false},
    [LANGUAGE_SPIRV] = {"spirv", "decode.spv", "", "", "of a combined image sampler in `set`",
                        BTF_BINDINGS_VULKAN, false},
    [LANGUAGE_HLSL] =
        {"hlsl", "decode.hlsl", "",
         "HLSL, shader model 5.1, translated by SPIRV-Cross: a library of functions. Include it in\n"
         "front of your own text. `precise` keeps its sums and products as they are written.",
         "t register in space `set`", BTF_BINDINGS_VULKAN, false},
    [LANGUAGE_MSL] =
        {"msl", "decode.metal", "",
         "Metal Shading Language 2.1, translated by SPIRV-Cross: a library of functions, which take the\n"
         "textures as arguments behind those of GLSL. Include it in front of your own text; the kernel at\n"
         "its end, compiled where PREFIX_ENTRY is defined, shows a call. No free compiler of this "
         "language\n"
         "exists for Linux: no Metal compiler has seen this text. Compile it with -fno-fast-math:\n"
         "spvFMul and spvFAdd, through which every sum and product of the decoder goes, are to keep its\n"
         "bits.",
         "texture index", BTF_BINDINGS_VULKAN, false},
    [LANGUAGE_WGSL] =
        {"wgsl", "decode.wgsl", "",
         "WGSL, the language of WebGPU: a library of functions, to be joined with your own text in any\n"
         "order.",
         "of a texture in group `set`", BTF_BINDINGS_NONE, true},
};

const language_facts *language_facts_of(language l) {
    return &facts[l];
}

const char *const *language_functions(const btf_shader_options *options) {
    static const char *const all[] = {"evaluate", "evaluate_nearest", "evaluate_level", "level", NULL};
    static const char *const picked[] = {"random",
                                         "evaluate_stochastic",
                                         "evaluate_stochastic_level",
                                         "evaluate_stochastic_between",
                                         "evaluate_radiance_blend",
                                         "evaluate_radiance_blend_level",
                                         "evaluate_radiance_blend_between",
                                         "level",
                                         NULL};
    return options->picks ? picked : all;
}

/* Puts a block comment in front of a text, which every language but SPIR-V has. Takes over `body`. */
static btf_result comment(language l, const char *prefix, char *body, const btf_log *log, char **out_data,
                          size_t *out_size) {
    char upper[64];
    snprintf(upper, sizeof upper, "%s", prefix);
    for (char *c = upper; *c; c++) {
        *c = (char)toupper((unsigned char)*c); /* as cross_msl writes the macro */
    }
    char *use = cross_replace_prefix(facts[l].use, "PREFIX_", upper);
    char *text = use ? cross_join((const char *const[]){
                           "/* The decoder of a material, written by btf-shader " OPENBTF_VERSION
                           " (OpenBTF, MIT licence).\n",
                           use, "\nmanifest.json names its functions and textures.\n*/\n", body, NULL})
                     : NULL;
    free(use);
    free(body);
    if (!text) {
        file_say(log, "out of memory for a shader");
        return BTF_ERROR_MEMORY;
    }
    *out_data = text;
    *out_size = strlen(text);
    return BTF_OK;
}

btf_result language_write(language l, const btf_material *material, const btf_shader_options *options,
                          const btf_log *log, char **out_data, size_t *out_size) {
    btf_shader_options wanted = *options;
    char *decoder = NULL, *text = NULL;
    uint32_t *words = NULL;
    size_t count = 0;
    *out_data = NULL;
    wanted.bindings = facts[l].bindings;
    wanted.language = l == LANGUAGE_WGSL ? BTF_LANGUAGE_WGSL : BTF_LANGUAGE_GLSL;
    btf_result result = btf_shader_source(material, &wanted, log, &decoder);
    const translate_source source = {.decoder = decoder,
                                     .prefix = wanted.prefix,
                                     .descriptor_set = wanted.descriptor_set,
                                     .stochastic = wanted.picks != BTF_PICK_NONE};
    if (result) {
        return result;
    }
    if (l == LANGUAGE_SPIRV) {
        result = translate_to_spirv(&source, log, &words, &count);
        *out_data = (char *)words;
        *out_size = count * sizeof *words;
    } else if (l == LANGUAGE_HLSL || l == LANGUAGE_MSL) {
        result =
            translate_to_text(&source, l == LANGUAGE_HLSL ? TRANSLATE_HLSL : TRANSLATE_MSL, log, &text);
    } else {
        text = strdup(decoder);
        result = text ? BTF_OK : BTF_ERROR_MEMORY;
    }
    btf_free(decoder);
    return result || !text ? result : comment(l, wanted.prefix, text, log, out_data, out_size);
}
