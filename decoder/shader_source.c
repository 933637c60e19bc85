/* Assembles the shader text of a material: its macros, then the embedded library text, names prefixed as asked; in
 * WGSL, what the translator makes of that.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/fold/fold.h"
#include "decoder/wgsl/growing.h"
#include "material.h"
#include "reach.h"
#include "shape.h"
#include <openbtf/shader.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_PREFIX = 32 };

/* A float as a constant expression that no compiler rounds. */
static void define_float(btfi_growing *t, const char *name, float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    btfi_print(t, "#define %s uintBitsToFloat(0x%08Xu)\n", name, bits);
}

/* A value that a user may have defined already, e.g. as a uniform. */
static void define_uint(btfi_growing *t, const char *name, uint32_t value) {
    btfi_print(t, "#ifndef %s\n#define %s %uu\n#endif\n", name, name, value);
}

static void define_int(btfi_growing *t, const char *name, int32_t value) {
    btfi_print(t, "#ifndef %s\n#define %s (%d)\n#endif\n", name, name, value);
}

static void fail(const btf_log *log, const char *message) {
    if (log && log->callback) {
        log->callback(log->user, BTF_LOG_ERROR, message);
    }
}

/* The options as given, or the defaults. */
static btf_shader_options read_options(const btf_shader_options *options) {
    btf_shader_options all = {.struct_size = sizeof all};
    if (options) {
        size_t size = options->struct_size < sizeof all ? options->struct_size : sizeof all;
        memcpy(&all, options, size);
    }
    if (!all.prefix) {
        all.prefix = "btf";
    }
    if (all.fold != BTF_FOLD_NONE) { /* its shader looks up no lights, and of BTF_FOLD_BOTH no views */
        all.fixed &= all.fold == BTF_FOLD_BOTH ? 0u : (uint32_t)BTF_FIXED_VIEW;
    }
    return all;
}

/* The part of a material that a shader decodes. */
typedef struct variant {
    uint32_t effects;    /* without the residual */
    uint32_t components; /* 0: no residual */
    int code_zero;       /* the file marks hidden points */
    int relief;          /* 0: none, 1: of one height, 2: of a height map */
    uint32_t gloss;      /* the share in quarters */
} variant;

static variant choose(const btf_material_info *info, const btf_shader_options *options) {
    variant v = {0};
    v.effects = info->effects & ~options->leave_out;
    if (v.effects & BTF_EFFECT_RESIDUAL) {
        v.components = info->components;
        if (options->components && options->components < v.components) {
            v.components = options->components;
        }
    }
    v.effects &= ~(uint32_t)BTF_EFFECT_RESIDUAL;
    v.code_zero = (info->effects & BTF_EFFECT_HIDDEN) != 0;
    v.relief = !(v.effects & BTF_EFFECT_RELIEF) ? 0 : info->relief_step > 0 ? 2 : 1;
    v.gloss = v.effects & BTF_EFFECT_GLOSS ? info->gloss_share : 0;
    return v;
}

uint32_t btf_shader_textures(const btf_material_info *whole, const btf_shader_options *options) {
    btf_shader_options all = read_options(options);
    const btf_material_info shown = btfi_folded_info(whole, all.fold), *info = &shown;
    variant v = choose(info, &all);
    const int view_known = all.fold == BTF_FOLD_BOTH || all.fixed & BTF_FIXED_VIEW;
    const int light_known = all.fold != BTF_FOLD_NONE || (all.fixed & BTF_FIXED_LIGHT && !v.gloss);
    uint32_t textures = view_known ? 0 : 1u << BTF_TEXTURE_VIEW_TABLE;
    textures |= light_known ? 0 : 1u << BTF_TEXTURE_LIGHT_TABLE;
    if (v.relief == 2) {
        textures |= 1u << BTF_TEXTURE_HEIGHTS;
    }
    if (v.relief || v.gloss) {
        textures |= 1u << BTF_TEXTURE_VIEW_VECTORS;
    }
    int shadow = (v.effects & BTF_EFFECT_SHADOW) && info->colour != BTF_COLOUR_NONE;
    int shift = (v.effects & BTF_EFFECT_SHIFT) != 0, hidden = (v.effects & BTF_EFFECT_HIDDEN) != 0;
    int gain = (v.effects & BTF_EFFECT_GAIN) != 0;
    if (info->colour != BTF_COLOUR_NONE) {
        textures |= 1u << BTF_TEXTURE_SBRDF;
    }
    if (info->layout == BTF_LAYOUT_PAPER) {
        if (shadow || shift || hidden || gain) {
            textures |= 1u << BTF_TEXTURE_MAPS;
        }
    } else {
        if (shadow) {
            textures |= 1u << BTF_TEXTURE_SHADOW;
        }
        const int packed = btfi_shares_points(info);
        if (packed && (shift || gain)) {
            textures |= info->point_store == BTF_POINTS_LISTS
                            ? 1u << BTF_TEXTURE_POINT_LISTS | 1u << BTF_TEXTURE_POINT_INDICES
                            : 1u << BTF_TEXTURE_POINTS;
        }
        if (!packed && (shift || hidden)) {
            textures |= 1u << BTF_TEXTURE_SHIFT;
        }
        if (!packed && (gain || hidden || (shift && v.code_zero))) {
            textures |= 1u << BTF_TEXTURE_GAIN;
        }
        if (hidden) {
            textures |= 1u << BTF_TEXTURE_CENTRES;
        }
    }
    if (v.components > 0 && info->store == BTF_STORE_FACTORS) {
        textures |= 1u << BTF_TEXTURE_FACTOR_TEXELS | 1u << BTF_TEXTURE_FACTOR_DIRECTIONS |
                    1u << BTF_TEXTURE_FACTOR_SCALES | 1u << BTF_TEXTURE_FACTOR_VIEWS;
    } else if (v.components > 0) {
        textures |= 1u << BTF_TEXTURE_RESIDUAL_TEXELS | 1u << BTF_TEXTURE_RESIDUAL_DIRECTIONS |
                    1u << BTF_TEXTURE_RESIDUAL_SCALES;
    }
    return textures;
}

/* Lower-case letters, digits and single inner underscores, first a letter. */
static int prefix_is_legal(const char *prefix) {
    size_t length = strlen(prefix);
    if (length < 1 || length > MAX_PREFIX || prefix[length - 1] == '_') {
        return 0;
    }
    for (size_t i = 0; i < length; ++i) {
        char c = prefix[i];
        int letter = c >= 'a' && c <= 'z', digit = c >= '0' && c <= '9';
        if (!letter && (i == 0 || (!digit && (c != '_' || prefix[i - 1] == '_')))) {
            return 0;
        }
    }
    return strcmp(prefix, "gl") != 0 && strncmp(prefix, "gl_", 3) != 0;
}

static int is_word(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
}

/* Appends a text in which names that begin with btf_ and BTF_ begin with the prefix instead. */
static void append_prefixed(btfi_growing *t, const char *source, const char *prefix) {
    char upper[MAX_PREFIX + 1] = {0};
    for (size_t i = 0; prefix[i]; ++i) {
        upper[i] = prefix[i] >= 'a' && prefix[i] <= 'z' ? (char)(prefix[i] - 'a' + 'A') : prefix[i];
    }
    const char *begin = source;
    for (const char *p = source; *p; ++p) {
        if (p != source && is_word(p[-1])) {
            continue;
        }
        int lower = strncmp(p, "btf_", 4) == 0;
        if (!lower && strncmp(p, "BTF_", 4) != 0) {
            continue;
        }
        btfi_append(t, begin, (size_t)(p - begin));
        btfi_append(t, lower ? prefix : upper, strlen(prefix));
        begin = p + 3;
    }
    btfi_append(t, begin, strlen(begin));
}

/* A direction's neighbours as constants, those of weight 0 last. */
static void define_fixed(btfi_growing *t, const char *name, const btfi_directions *directions,
                         const float direction[3], int nearest) {
    btfi_neighbours n = btfi_neighbours_of(directions, direction, nearest);
    btfi_print(t, "#define BTF_FIXED_%s %u\n", name, n.count);
    btfi_print(t, "#define BTF_FIXED_%s_INDEX uvec3(%uu, %uu, %uu)\n", name, n.index[0], n.index[1],
               n.index[2]);
    btfi_print(t, "#define BTF_FIXED_%s_WEIGHT uvec3(%uu, %uu, %uu)\n", name, n.weight[0], n.weight[1],
               n.weight[2]);
}

/* The layers in which a fold keeps the neighbours of a fixed view: in the order of the look-up, while define_fixed has
 * those of weight 0 last. */
static void define_fixed_layers(btfi_growing *t, const btfi_directions *directions,
                                const float direction[3], int nearest) {
    uint32_t index[3], weight[3], layer[3] = {0, 0, 0}, count = 0;
    btfi_lookup(directions, direction, index, weight);
    for (uint32_t k = 0; k < 3; ++k) {
        if (weight[k] > 0 && !nearest) {
            layer[count++] = k;
        }
    }
    btfi_print(t, "#define BTF_FIXED_VIEW_LAYER uvec3(%uu, %uu, %uu)\n", layer[0], layer[1], layer[2]);
}

/* The classes of factors, cut to the first `units` units; words of C1 and C2 are cut to those that these units hold. */
static void define_classes(btfi_growing *t, const btf_material_info *info, uint32_t units) {
    for (int c = 0; c < BTF_FACTOR_CLASSES; ++c) {
        const uint32_t *of = info->factor_classes[c];
        uint32_t n = of[0] < units ? of[0] : units, c1 = of[1] < 4 * n ? of[1] : 4 * n,
                 c2 = of[2] < 4 * n - c1 ? of[2] : 4 * n - c1;
        units -= n;
        btfi_print(t, "#define BTF_FACTOR_UNITS_%d %u\n", c, n);
        btfi_print(t, "#define BTF_FACTOR_C1_%d %u\n", c, c1);
        btfi_print(t, "#define BTF_FACTOR_C2_%d %u\n", c, c2);
    }
}

/* The macros of shaders/options.glsl. Those of version 2 stand only where a material needs them, so that the text
 * of one of version 1 stays what it was. */
static void write_macros(btfi_growing *t, const btf_material *material, const btf_material_info *info,
                         const btf_shader_options *options) {
    variant v = choose(info, options);
    int shadow = (v.effects & BTF_EFFECT_SHADOW) && info->colour != BTF_COLOUR_NONE;
    btfi_print(t, "#define BTF_LAYOUT_TIGHT %d\n", info->layout == BTF_LAYOUT_TIGHT);
    btfi_print(t, "#define BTF_DOMAIN_SQRT %d\n", info->domain == BTF_DOMAIN_SQRT);
    btfi_print(t, "#define BTF_COLOUR %d\n", (int)info->colour);
    btfi_print(t, "#define BTF_LOBES %u\n", info->lobes);
    btfi_print(t, "#define BTF_SHADOW %d\n", shadow);
    btfi_print(t, "#define BTF_SHIFT %d\n", (v.effects & BTF_EFFECT_SHIFT) != 0);
    btfi_print(t, "#define BTF_HIDDEN %d\n", (v.effects & BTF_EFFECT_HIDDEN) != 0);
    btfi_print(t, "#define BTF_GAIN %d\n", (v.effects & BTF_EFFECT_GAIN) != 0);
    btfi_print(t, "#define BTF_COMPONENTS %u\n", v.components);
    btfi_print(t, "#define BTF_CODE_ZERO %d\n", v.code_zero);
    if (info->blend == BTF_BLEND_ROOTS) {
        btfi_print(t, "#define BTF_BLEND_ROOTS 1\n");
    }
    if (v.components > 0 && info->store == BTF_STORE_FACTORS) {
        btfi_print(t, "#define BTF_FACTORS 1\n");
        define_classes(t, info, v.components);
    }
    if (btfi_shares_points(info)) { /* 1 packed points, 2 lists of them */
        btfi_print(t, "#define BTF_POINTS %d\n", (int)info->point_store);
    }
    if (v.relief) {
        btfi_print(t, "#define BTF_RELIEF %d\n", v.relief);
    }
    if (v.gloss) {
        btfi_print(t, "#define BTF_GLOSS %u\n", v.gloss);
    }
    if (options->fold) {
        btfi_print(t, "#define BTF_FOLDED %d\n", (int)options->fold);
    }
    btfi_print(t, "#define BTF_NEAREST %d\n", options->interpolation == BTF_INTERPOLATION_NEAREST);
    btfi_print(t, "#define BTF_BILINEAR %d\n", options->filter != BTF_FILTER_TEXEL);
    if (options->filter == BTF_FILTER_STEEP) {
        btfi_print(t, "#define BTF_STEEP 1\n");
    }
    btfi_print(t, "#define BTF_FAST_MATH %d\n", options->math == BTF_MATH_FAST);
    if (options->have_precise && options->language == BTF_LANGUAGE_GLSL) {
        btfi_print(t, "#define BTF_HAVE_PRECISE 1\n");
    }
    if (options->picks != BTF_PICK_NONE) {
        btfi_print(t, "#define BTF_STOCHASTIC %d\n", (int)options->picks);
    }
    int nearest = options->interpolation == BTF_INTERPOLATION_NEAREST;
    if (options->fixed & BTF_FIXED_VIEW) {
        define_fixed(t, "VIEW", &material->views, options->fixed_view, nearest);
    }
    if (options->fixed & BTF_FIXED_VIEW && options->fold == BTF_FOLD_NEIGHBOURS) {
        define_fixed_layers(t, &material->views, options->fixed_view, nearest);
    }
    if (options->fixed & BTF_FIXED_LIGHT && !v.gloss) { /* with gloss each view has lights of its own */
        define_fixed(t, "LIGHT", &material->lights, options->fixed_light, nearest);
    }

    define_uint(t, "BTF_WIDTH", info->width);
    define_uint(t, "BTF_HEIGHT", info->height);
    define_uint(t, "BTF_LEVELS", info->levels);
    define_uint(t, "BTF_N_LIGHTS", info->n_lights);
    if (options->fold) {
        define_uint(t, "BTF_N_VIEWS", info->n_views);
    }
    define_uint(t, "BTF_VIEW_GRID", btf_material_views(material).grid);
    define_uint(t, "BTF_LIGHT_GRID", btf_material_lights(material).grid);
    if (info->layout == BTF_LAYOUT_PAPER) {
        define_uint(t, "BTF_ATLAS_WIDTH", info->atlas_width);
        define_uint(t, "BTF_ATLAS_HEIGHT", info->atlas_height);
        define_uint(t, "BTF_TILES", info->n_views > info->n_lights ? info->n_views : info->n_lights);
    } else if (v.effects & BTF_EFFECT_HIDDEN) {
        define_uint(t, "BTF_CENTRE_ROWS", btf_material_texture(material, BTF_TEXTURE_CENTRES).height);
    }
    define_float(t, "BTF_RADIANCE_SCALE", info->radiance_scale);
    define_float(t, "BTF_SHADOW_SCALE", info->shadow_scale * 0x1p-12f);
    define_float(t, "BTF_GAIN_SCALE", info->gain_scale);
    define_float(t, "BTF_CENTRE_SCALE", info->centre_scale * 0x1p-12f);
    if (v.components > 0 && info->store == BTF_STORE_FACTORS) {
        define_float(t, "BTF_HORIZON_SCALE", info->horizon_scale);
    }
    if (btfi_shares_points(info)) {
        define_float(t, "BTF_GAIN_BASE", info->gain_base);
        define_float(t, "BTF_GAIN_STEP", info->gain_step);
    }
    if (v.relief) {
        define_int(t, "BTF_RELIEF_BASE", info->relief_base);
        define_int(t, "BTF_RELIEF_STEP", info->relief_step);
        define_int(t, "BTF_RELIEF_STEPS", (int32_t)info->relief_steps);
        define_int(t, "BTF_RELIEF_LEVEL", (int32_t)info->relief_level);
        if (info->relief_end < info->levels) {
            define_int(t, "BTF_RELIEF_END", (int32_t)info->relief_end);
        }
    }
}

/* The samplers' layout qualifiers; literals, since ESSL 310 takes no expression there. */
static void write_bindings(btfi_growing *t, const btf_shader_options *options) {
    const int wgsl =
        options->language == BTF_LANGUAGE_WGSL; /* in which every resource has a group and a binding */
    if (options->bindings == BTF_BINDINGS_NONE && !wgsl) {
        return;
    }
    for (uint32_t i = 0; i < BTF_TEXTURE_COUNT; ++i) {
        char name[40] = {0};
        const char *lower = btf_texture_name((btf_texture_id)i);
        for (size_t c = 0; lower[c] && c + 1 < sizeof name; ++c) {
            name[c] = lower[c] >= 'a' && lower[c] <= 'z' ? (char)(lower[c] - 'a' + 'A') : lower[c];
        }
        btfi_print(t, "#define BTF_BINDING_%s %u\n", name, options->first_binding + i);
    }
    static const char *const more[] = {"FOLDED", "SAMPLING_TRIANGLES", "SAMPLING_DENSITIES", "ZERO"};
    for (uint32_t i = 0; i < sizeof more / sizeof *more; ++i) {
        btfi_print(t, "#define BTF_BINDING_%s %u\n", more[i],
                   options->first_binding + BTF_TEXTURE_COUNT + i);
    }
    if (options->bindings == BTF_BINDINGS_VULKAN || wgsl) {
        btfi_print(t, "#define BTF_UNIFORM(n) layout(set = %u, binding = n) uniform\n",
                   options->descriptor_set);
    } else {
        btfi_print(t, "#define BTF_UNIFORM(n) layout(binding = n) uniform\n");
    }
}

btf_result btf_shader_source(const btf_material *material, const btf_shader_options *options,
                             const btf_log *log, char **out_text) {
    *out_text = NULL;
    btf_shader_options all = read_options(options);
    if (!prefix_is_legal(all.prefix)) {
        char message[160];
        snprintf(message, sizeof message,
                 "shader: prefix \"%.40s\" is not of lower-case letters, digits and single underscores",
                 all.prefix);
        fail(log, message);
        return BTF_ERROR_USAGE;
    }
    if ((unsigned)all.interpolation > BTF_INTERPOLATION_NEAREST ||
        (unsigned)all.filter > BTF_FILTER_STEEP || (unsigned)all.math > BTF_MATH_FAST ||
        (unsigned)all.bindings > BTF_BINDINGS_VULKAN || (unsigned)all.picks > BTF_PICK_ALL ||
        (unsigned)all.fold > BTF_FOLD_SUM || (unsigned)all.language > BTF_LANGUAGE_WGSL) {
        char message[160];
        snprintf(
            message, sizeof message,
            "shader: interpolation %d, filter %d, math %d, bindings %d, picks %d, fold %d or language %d "
            "is unknown",
            (int)all.interpolation, (int)all.filter, (int)all.math, (int)all.bindings, (int)all.picks,
            (int)all.fold, (int)all.language);
        fail(log, message);
        return BTF_ERROR_USAGE;
    }
    if (all.fixed > (BTF_FIXED_VIEW | BTF_FIXED_LIGHT) ||
        ((all.fixed & BTF_FIXED_VIEW) && !btfi_direction_is_legal(all.fixed_view)) ||
        ((all.fixed & BTF_FIXED_LIGHT) && !btfi_direction_is_legal(all.fixed_light))) {
        fail(log, "shader: a fixed direction is not a unit vector above the horizon");
        return BTF_ERROR_USAGE;
    }
    btf_material_info info = {.struct_size = sizeof info};
    btf_result result = btf_material_get_info(material, &info);
    if (result == BTF_OK) {
        result = btf_fold_check(&info, &all, log);
    }
    if (result != BTF_OK) {
        return result;
    }
    info = btfi_folded_info(&info, all.fold);

    btfi_growing macros = {0}, assembled = {0};
    write_macros(&macros, material, &info, &all);
    write_bindings(&macros, &all);
    if (!macros.failed) {
        append_prefixed(&assembled, macros.data, all.prefix);
        append_prefixed(&assembled, btf_shader_library(), all.prefix);
    }
    int failed = macros.failed || assembled.failed;
    free(macros.data);
    if (failed) {
        free(assembled.data);
        fail(log, "shader: out of memory");
        return BTF_ERROR_MEMORY;
    }
    if (all.language == BTF_LANGUAGE_WGSL) {
        result = btf_shader_wgsl(assembled.data, log, out_text);
        free(assembled.data);
        return result;
    }
    *out_text = assembled.data;
    return BTF_OK;
}

void btf_self_test_names(uint32_t failures, char *out_names, size_t size) {
    static const struct {
        uint32_t bit;
        const char *name;
    } list[] = {
#define NAME(id, bit, name, text) {bit, name},
        BTF_SELF_TEST_LIST(NAME)
#undef NAME
    };
    if (size == 0) {
        return;
    }
    snprintf(out_names, size, "%s", failures ? "" : "none");
    size_t length = strlen(out_names);
    for (size_t i = 0; i < sizeof list / sizeof *list; ++i) {
        if (failures & list[i].bit && length < size) {
            int wrote =
                snprintf(out_names + length, size - length, "%s%s", length ? ", " : "", list[i].name);
            length += wrote > 0 ? (size_t)wrote : 0;
        }
    }
}
