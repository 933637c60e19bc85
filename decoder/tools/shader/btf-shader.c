/* btf-shader: all that a program without the library needs to show a material: the decoder in its shading language, the
 * textures as files, and a manifest of both.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/cli.h"
#include "decoder/toolkit/decode_options.h"
#include "decoder/toolkit/file.h"
#include "decoder/toolkit/filter.h"
#include "decoder/toolkit/output.h"
#include "decoder/toolkit/progress.h"
#include "decoder/toolkit/scene_option.h"
#include "folder.h"
#include "manifest.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_BINDINGS = 1000 };

static struct {
    const char *out, *prefix, *costs;
    int language, store, interpolation, filter, math, picks, components, first_binding, set;
    bool language_given, effects_given, components_given, interpolation_given, filter_given, plan_given;
    bool force, quiet;
    uint32_t effects;
    scene_option scene;
} options = {.prefix = "btf", .effects = BTF_EFFECT_ALL, .components = BTF_MAX_COMPONENTS};

static const cli_option option_table[] = {
    {.short_name = 'o',
     .name = "output",
     .arg = "DIR",
     .type = CLI_STRING,
     .value = &options.out,
     .help = "folder to write; it is whole or absent"},
    {.short_name = 'l',
     .name = "language",
     .type = CLI_CHOICE,
     .choices = LANGUAGE_CHOICES,
     .value = &options.language,
     .given = &options.language_given,
     .help = "of the decoder: glsl330 (OpenGL 3.3 to 4.6), glsl450 (with bindings), essl300\n"
             "(OpenGL ES 3.0, WebGL2), essl310, vulkan (GLSL), spirv (a compute shader), hlsl,\n"
             "msl (Metal), wgsl (WebGPU)"},
    {.name = "textures",
     .type = CLI_CHOICE,
     .choices = TEXTURE_STORE_CHOICES,
     .value = &options.store,
     .help = "files of textures: ktx2 (default), dds, or raw bytes, which the manifest describes"},
    {EFFECTS_OPTION, .value = &options.effects, .given = &options.effects_given},
    {COMPONENTS_OPTION, .value = &options.components, .given = &options.components_given},
    {INTERPOLATION_OPTION, .value = &options.interpolation, .given = &options.interpolation_given},
    {FILTER_OPTION, .value = &options.filter, .given = &options.filter_given},
    {MATH_OPTION, .value = &options.math},
    {.name = "picks",
     .type = CLI_CHOICE,
     .choices = "none|view|light|all",
     .value = &options.picks,
     .help = "a stochastic decode, which takes one neighbour, picked with its weight, in place of\n"
             "blending: the view; view and light; view, light and texel (default none)"},
    {.name = "plan",
     .arg = "SCENE",
     .type = CLI_CUSTOM,
     .value = &options.scene,
     .given = &options.plan_given,
     .parse = scene_option_parse,
     .help = "write only what a scene needs, which chooses effects, components, interpolation,\n"
             "filter and level of detail. SCENE:\n" SCENE_OPTION_HELP},
    {.name = "costs",
     .arg = "FILE",
     .type = CLI_STRING,
     .value = &options.costs,
     .help = COSTS_OPTION_HELP},
    {.name = "prefix",
     .type = CLI_STRING,
     .value = &options.prefix,
     .help = "of all names, so that two materials fit one program (default btf)"},
    {.name = "first-binding",
     .type = CLI_INT,
     .value = &options.first_binding,
     .minimum = 0,
     .maximum = MOST_BINDINGS,
     .help = "binding of texture sbrdf; the others follow in the order of FORMAT.md (default 0)"},
    {.name = "set",
     .type = CLI_INT,
     .value = &options.set,
     .minimum = 0,
     .maximum = MOST_BINDINGS,
     .help = "descriptor set of the textures, space in HLSL (default 0)"},
    {.name = "force",
     .type = CLI_FLAG,
     .value = &options.force,
     .help = "replace DIR, if btf-shader wrote all that is in it"},
    {.short_name = 'q',
     .name = "quiet",
     .type = CLI_FLAG,
     .value = &options.quiet,
     .help = "no summary, no information; warnings stay"},
    {.type = CLI_END},
};

static const cli_program program = {
    .name = "btf-shader",
    .usage = "FILE --language L -o DIR [options]",
    .summary =
        "Writes what an engine without the library needs to show a material file (*.btf.exr): the decoder\n"
        "in a shading language, each texture as a file, and manifest.json, which describes both.",
    .details = "The folder holds decode.glsl (.spv, .hlsl, .metal, .wgsl), a file for each texture that "
               "the decoder\n"
               "reads, and manifest.json. share/openbtf/README.md (shaders/README.md of the sources) "
               "describes them.\n"
               "spirv needs a build with glslang, hlsl and msl need SPIRV-Cross, too.",
    .example = "btf-shader bricks.btf.exr --language hlsl --textures dds -o bricks\n"
               "btf-shader bricks.btf.exr --language essl300 --plan views=0:30 -o bricks",
    .options = option_table,
    .min_arguments = 1,
    .max_arguments = 1,
};

/* The names that this program gives files. */
static bool is_ours(const char *name) {
    if (!strcmp(name, "manifest.json")) {
        return true;
    }
    for (int l = LANGUAGE_GLSL330; l <= LANGUAGE_WGSL; l++) {
        if (!strcmp(name, language_facts_of((language)l)->file)) {
            return true;
        }
    }
    for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
        for (int store = TEXTURE_STORE_KTX2; store <= TEXTURE_STORE_RAW; store++) {
            char file[48];
            snprintf(file, sizeof file, "%s.%s", btf_texture_name((btf_texture_id)id),
                     texture_store_name((texture_store)store));
            if (!strcmp(name, file)) {
                return true;
            }
        }
    }
    return false;
}

/* Units and components are stored in whole layers, so that the first ones are the first layers. */
static uint32_t layers_read(const btf_material_info *info, uint32_t components, btf_texture_id id,
                            uint32_t layers) {
    const uint32_t groups = (components + 3) / 4;
    uint32_t texels = 0, units = components;
    switch (id) {
    case BTF_TEXTURE_RESIDUAL_TEXELS:
        return groups;
    case BTF_TEXTURE_RESIDUAL_DIRECTIONS:
        return 3 * groups;
    case BTF_TEXTURE_FACTOR_DIRECTIONS:
        return components;
    case BTF_TEXTURE_FACTOR_TEXELS: /* classes 1 and 3 have two a unit (FORMAT.md section 3) */
        for (int c = 0; c < BTF_FACTOR_CLASSES; c++) {
            const uint32_t n = info->factor_classes[c][0] < units ? info->factor_classes[c][0] : units;
            texels += c == 1 || c == 3 ? 2 * n : n;
            units -= n;
        }
        return texels;
    default:
        return layers;
    }
}

/* The levels of a texture, without the layers that the shader does not read. */
static texture_levels list_levels(const manifest *m, const btf_material_info *info, btf_texture_id id) {
    texture_levels t = {.id = id};
    const uint32_t wanted = m->options->components,
                   components = wanted && wanted < info->components ? wanted : info->components;
    for (uint32_t i = 0; i < info->levels; i++) {
        btf_texture level = btf_material_level_texture(m->material, i, id);
        if (level.format == BTF_FORMAT_NONE) {
            break;
        }
        const uint32_t layers = layers_read(info, components, id, level.layers);
        level.size = level.size / level.layers * layers;
        level.layers = layers;
        t.level[t.count++] = level;
    }
    return t;
}

static btf_result write_text(const char *path, const char *data, size_t size, btf_log log) {
    output *file;
    btf_result result = output_open(path, log, &file);
    if (!result) {
        fwrite(data, 1, size, output_stream(file));
        result = output_commit(&file);
    }
    return result;
}

/* Fills the folder; m has material, options, plan, language and store. */
static btf_result write_files(manifest *m, folder *f, btf_log log) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(m->material, &info);
    char *text = NULL;
    btf_result result = language_write(m->language, m->material, m->options, &log, &text, &m->text_bytes);
    m->text = m->language == LANGUAGE_SPIRV ? NULL : text;
    if (!result) {
        result = write_text(folder_file(f, language_facts_of(m->language)->file), text, m->text_bytes, log);
    }
    const uint32_t textures = btf_shader_textures(&info, m->options);
    for (int id = 0; id < BTF_TEXTURE_COUNT && !result; id++) {
        manifest_texture *t = &m->textures[m->texture_count];
        if (!(textures >> id & 1)) {
            continue;
        }
        if (progress_cancelled()) {
            result = cli_error(&program, BTF_ERROR_INTERRUPTED, "interrupted");
            break;
        }
        t->levels = list_levels(m, &info, (btf_texture_id)id);
        snprintf(t->file, sizeof t->file, "%s.%s", btf_texture_name((btf_texture_id)id),
                 texture_store_name(m->store));
        result =
            texture_file_write(folder_file(f, t->file), m->store, &t->levels, log, t->places, &t->bytes);
        m->texture_count++;
    }
    if (!result) {
        result = manifest_write(folder_file(f, "manifest.json"), m, log);
    }
    free(text);
    m->text = NULL;
    return result;
}

static btf_result export_material(const btf_material *material, const btf_shader_options *shader,
                                  const btf_plan *plan, btf_log log) {
    static manifest m; /* 30 KB */
    m = (manifest){.material = material,
                   .options = shader,
                   .plan = plan,
                   .language = (language)options.language,
                   .store = (texture_store)options.store};
    folder *f = NULL;
    btf_result result = folder_open(options.out, options.force, is_ours, &log, &f);
    if (!result) {
        result = write_files(&m, f, log);
    }
    if (result) {
        folder_abort(&f);
        return result;
    }
    result = folder_commit(&f);
    if (!result && !options.quiet) {
        uint64_t bytes = 0;
        for (int i = 0; i < m.texture_count; i++) {
            bytes += m.textures[i].bytes;
        }
        fprintf(stderr, "%s: %s of %zu bytes, %d textures of %llu bytes, manifest.json\n", options.out,
                language_facts_of(m.language)->file, m.text_bytes, m.texture_count,
                (unsigned long long)bytes);
    }
    return result;
}

/* Makes the restriction of the plan, and its options. */
static btf_result make_plan(const btf_material *material, const btf_log *log, btf_plan *out_plan,
                            btf_material **out_restricted) {
    static btf_cost_model costs; /* the scene keeps its address */
    if (options.costs) {
        const btf_result result = btf_cost_model_open(options.costs, log, &costs);
        if (result) {
            return result;
        }
        options.scene.scene.costs = &costs;
    }
    *out_plan = (btf_plan){.struct_size = sizeof *out_plan};
    const btf_result result =
        btf_plan_effects(material, &options.scene.scene, options.scene.tolerance, out_plan);
    if (result) {
        return cli_error(&program, result, "option --plan: no plan can be made for this scene");
    }
    return btf_material_restrict(material, out_plan, log, out_restricted);
}

static btf_result check_options(void) {
    if (!options.out || !*options.out) {
        return cli_error(&program, BTF_ERROR_USAGE, "option --output is missing: a folder to write");
    }
    if (!options.language_given) {
        return cli_error(&program, BTF_ERROR_USAGE, "option --language is missing: one of %s",
                         LANGUAGE_CHOICES);
    }
    if (options.plan_given && (options.effects_given || options.components_given ||
                               options.interpolation_given || options.filter_given)) {
        return cli_error(
            &program, BTF_ERROR_USAGE,
            "option --plan: not together with --effects, --components, --interpolation or --filter, "
            "which it chooses");
    }
    if (options.costs && !options.plan_given) {
        return cli_error(&program, BTF_ERROR_USAGE, "option --costs: only together with --plan");
    }
    return BTF_OK;
}

static btf_result run(const cli_arguments *arguments) {
    const char *path = arguments->values[0];
    const btf_log log = cli_log(&program, options.quiet);
    btf_material *material = NULL, *restricted = NULL;
    btf_plan plan;
    btf_result result = check_options();
    progress *p =
        result ? NULL : progress_create(true); /* for its signals: a run takes well under a second */
    if (!result) {
        result = btf_material_open(path, &log, &material);
    }
    if (!result && options.plan_given) {
        result = make_plan(material, &log, &plan, &restricted);
    }
    if (!result) {
        btf_shader_options shader = {.struct_size = sizeof shader,
                                     .leave_out = ~options.effects,
                                     .components = (uint32_t)options.components,
                                     .interpolation = (btf_interpolation)options.interpolation,
                                     .filter = (btf_filter)options.filter};
        if (options.components == 0) { /* to the library 0 means all */
            shader.leave_out |= BTF_EFFECT_RESIDUAL;
        }
        if (options.plan_given) {
            shader = plan.shader;
        }
        shader.math = (btf_math)options.math;
        shader.picks = (btf_picks)options.picks;
        shader.prefix = options.prefix;
        shader.first_binding = (uint32_t)options.first_binding;
        shader.descriptor_set = (uint32_t)options.set;
        result = export_material(restricted ? restricted : material, &shader,
                                 options.plan_given ? &plan : NULL, log);
    }
    btf_material_close(&restricted);
    btf_material_close(&material);
    progress_destroy(&p);
    return result;
}

int main(int argc, char **argv) {
    return cli_run(&program, argc, argv, run);
}
