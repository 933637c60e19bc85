/* The manifest. See manifest.h; shaders/README.md describes its members.
 *
 * SPDX-License-Identifier: MIT
 */
#include "manifest.h"

#include "decoder/toolkit/cli.h"
#include "decoder/toolkit/filter.h"
#include "decoder/toolkit/json.h"
#include "decoder/toolkit/output.h"
#include "translate.h"
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void write_effects(json *j, uint32_t effects) {
    json_array(j, "effects");
    for (int i = 0; i < CLI_EFFECTS_COUNT; i++) {
        if (effects >> i & 1) {
            json_string(j, NULL, cli_effect_word(i));
        }
    }
    json_end(j);
}

static void write_vector(json *j, const char *key, const float v[3]) {
    json_array(j, key);
    for (int i = 0; i < 3; i++) {
        json_float(j, NULL, v[i]);
    }
    json_end(j);
}

static void write_options(json *j, const manifest *m, const btf_material_info *info) {
    static const char *const picks[] = {"none", "view", "light", "all"};
    const btf_shader_options *o = m->options;
    const uint32_t most = info->effects & BTF_EFFECT_RESIDUAL & ~o->leave_out ? info->components : 0;
    json_object(j, "options");
    json_string(j, "prefix", o->prefix);
    write_effects(j, info->effects & ~o->leave_out);
    json_integer(j, "components", o->components && o->components < most ? o->components : most);
    json_string(j, "interpolation", o->interpolation == BTF_INTERPOLATION_NEAREST ? "nearest" : "linear");
    json_string(j, "filter", filter_name(o->filter));
    json_string(j, "math", o->math == BTF_MATH_FAST ? "fast" : "exact");
    json_string(j, "picks", picks[o->picks]);
    if (o->fixed & BTF_FIXED_VIEW) {
        write_vector(j, "fixed_view", o->fixed_view);
    }
    if (o->fixed & BTF_FIXED_LIGHT) {
        write_vector(j, "fixed_light", o->fixed_light);
    }
    json_end(j);
}

static void write_material(json *j, const btf_material_info *info) {
    json_object(j, "material");
    json_integer(j, "format_version", info->version);
    json_integer(j, "width", info->width);
    json_integer(j, "height", info->height);
    json_integer(j, "levels", info->levels);
    json_integer(j, "views", info->n_views);
    json_integer(j, "lights", info->n_lights);
    write_effects(j, info->effects);
    json_object(j, "scales");
    json_float(j, "radiance", info->radiance_scale);
    json_float(j, "shadow", info->shadow_scale);
    json_float(j, "gain", info->gain_scale);
    json_float(j, "centre", info->centre_scale);
    json_float(j, "horizon", info->horizon_scale);
    json_float(j, "gain_base", info->gain_base);
    json_float(j, "gain_step", info->gain_step);
    json_end(j);
    json_end(j);
}

/* The head of a function as the text has it, on one line: from the beginning of its line to the bracket that closes
 * its parameters, or to the brace behind what WGSL returns. Freed by the caller; NULL where the text has no such
 * function. */
static char *signature(const char *text, const char *prefix, const char *function, language l) {
    char name[80];
    snprintf(name, sizeof name, "%s_%s(", prefix, function);
    const char *at = text;
    while ((at = strstr(at, name))) {
        const char *line = at;
        while (line > text && line[-1] != '\n') {
            line--;
        }
        if (line < at && isalpha((unsigned char)*line) && at[-1] == ' ') {
            const char *end = strchr(at, l == LANGUAGE_WGSL ? '{' : ')');
            size_t length = end ? (size_t)(end - line) + (l != LANGUAGE_WGSL) : 0;
            while (length > 0 && line[length - 1] == ' ') {
                length--;
            }
            char *head = end ? strndup(line, length) : NULL;
            for (char *c = head; c && *c; c++) {
                *c = *c == '\n' ? ' ' : *c;
            }
            return head;
        }
        at += strlen(name);
    }
    return NULL;
}

static void write_shader(json *j, const manifest *m) {
    const language_facts *facts = language_facts_of(m->language);
    char name[80];
    json_object(j, "shader");
    json_string(j, "language", facts->name);
    json_string(j, "file", facts->file);
    json_integer(j, "bytes", (int64_t)m->text_bytes);
    json_string(j, "head", facts->head);
    if (m->language == LANGUAGE_SPIRV) {
        json_object(j, "entry");
        json_string(j, "name", "main");
        json_string(j, "stage", "compute");
        json_integer(j, "group", TRANSLATE_GROUP);
        json_integer(j, "set", (int64_t)m->options->descriptor_set + 1);
        json_integer(j, "binding", 0);
        json_integer(j, "record_words", TRANSLATE_RECORD);
        json_integer(j, "result_at", TRANSLATE_RESULT);
        json_end(j);
    }
    json_array(j, "functions");
    for (const char *const *f = language_functions(m->options); *f && m->text; f++) {
        char *head = signature(m->text, m->options->prefix, *f, m->language);
        if (head) {
            snprintf(name, sizeof name, "%s_%s", m->options->prefix, *f);
            json_object(j, NULL);
            json_string(j, "name", name);
            json_string(j, "signature", head);
            json_end(j);
        }
        free(head);
    }
    json_end(j);
    if (facts->needs_zero && m->options->math == BTF_MATH_EXACT) {
        snprintf(name, sizeof name, "%s_zero", m->options->prefix);
        json_object(j, "zero");
        json_string(j, "uniform", name);
        json_string(j, "type", m->language == LANGUAGE_WGSL ? "u32" : "uint");
        json_integer(j, "value", 0);
        if (m->language == LANGUAGE_WGSL) { /* openbtf/shader.h, BTF_LANGUAGE_WGSL */
            json_integer(j, "set", (int64_t)m->options->descriptor_set);
            json_integer(j, "binding", (int64_t)m->options->first_binding + BTF_TEXTURE_COUNT + 3);
            json_integer(j, "buffer_bytes", 16);
        }
        json_end(j);
    }
    json_end(j);
}

static void write_texture(json *j, const manifest *m, const manifest_texture *t) {
    const btf_texture *finest = t->levels.level;
    const texture_format *f = texture_format_of(finest->format);
    char sampler[80];
    json_object(j, NULL);
    json_string(j, "name", btf_texture_name(t->levels.id));
    snprintf(sampler, sizeof sampler, "%s_%s", m->options->prefix, btf_texture_name(t->levels.id));
    json_string(j, "sampler", sampler);
    json_integer(j, "set", m->options->descriptor_set);
    json_integer(j, "binding", (int64_t)m->options->first_binding + t->levels.id);
    json_string(j, "file", t->file);
    json_integer(j, "file_bytes", (int64_t)t->bytes);
    json_string(j, "format", f->name);
    json_integer(j, "vk_format", f->vulkan);
    json_integer(j, "dxgi_format", f->dxgi);
    json_integer(j, "gl_internal_format", f->gl);
    json_integer(j, "gl_format", f->gl_layout);
    json_integer(j, "gl_type", f->gl_type);
    json_integer(j, "texel_bytes", (int64_t)f->channels * f->component);
    json_bool(j, "array", finest->is_array);
    json_integer(j, "width", finest->width);
    json_integer(j, "height", finest->height);
    json_integer(j, "layers", finest->layers);
    json_array(j, "levels");
    for (uint32_t i = 0; i < t->levels.count; i++) {
        json_object(j, NULL);
        json_integer(j, "width", t->levels.level[i].width);
        json_integer(j, "height", t->levels.level[i].height);
        json_integer(j, "offset", (int64_t)t->places[i].offset);
        json_integer(j, "layer_stride", (int64_t)t->places[i].stride);
        json_integer(j, "bytes", (int64_t)t->levels.level[i].size);
        json_end(j);
    }
    json_end(j);
    json_end(j);
}

static void write_plan(json *j, const btf_plan *plan) {
    json_object(j, "plan");
    json_integer(j, "level", plan->level);
    json_integer(j, "whole_gpu_bytes", (int64_t)plan->full_gpu_bytes);
    json_bool(j, "measured", plan->measured);
    json_float(j, "psnr_linear", plan->psnr_linear);
    json_float(j, "psnr_srgb", plan->psnr_srgb);
    json_end(j);
}

btf_result manifest_write(const char *path, const manifest *m, btf_log log) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(m->material, &info);
    uint64_t bytes = 0;
    for (int i = 0; i < m->texture_count; i++) {
        for (uint32_t k = 0; k < m->textures[i].levels.count; k++) {
            bytes += m->textures[i].levels.level[k].size;
        }
    }
    json j = {0};
    json_object(&j, NULL);
    json_integer(&j, "openbtf_shader", 1);
    json_string(&j, "written_by", "btf-shader " OPENBTF_VERSION);
    write_shader(&j, m);
    write_options(&j, m, &info);
    write_material(&j, &info);
    if (m->plan) {
        write_plan(&j, m->plan);
    }
    json_string(&j, "texture_files", texture_store_name(m->store));
    json_string(&j, "binding", language_facts_of(m->language)->binding);
    json_integer(&j, "texture_bytes", (int64_t)bytes);
    json_array(&j, "textures");
    for (int i = 0; i < m->texture_count; i++) {
        write_texture(&j, m, &m->textures[i]);
    }
    json_end(&j);
    json_end(&j);
    const char *text = json_text(&j);
    output *file = NULL;
    btf_result result = text ? output_open(path, log, &file) : BTF_ERROR_MEMORY;
    if (!result) {
        fputs(text, output_stream(file));
        result = output_commit(&file);
    }
    json_free(&j);
    return result;
}
