/* The JSON that btf-info prints. See info_json.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "info_json.h"

#include "decoder/toolkit/between.h"
#include "info_facts.h"
#include <stdio.h>

btf_result put_json(const cli_program *program, json *j) {
    const char *text = json_text(j);
    if (text) {
        fputs(text, stdout);
    }
    json_free(j);
    return text ? BTF_OK : cli_error(program, BTF_ERROR_MEMORY, "out of memory");
}

static void json_directions(json *j, const char *key, const btf_directions *d) {
    ring rings[BTF_MAX_DIRECTIONS];
    int count = find_rings(d, rings);
    json_object(j, key);
    json_integer(j, "count", d->count);
    json_array(j, "rings");
    for (int i = 0; i < count; i++) {
        json_object(j, NULL);
        json_number(j, "theta", rings[i].theta);
        json_integer(j, "count", rings[i].count);
        json_end(j);
    }
    json_end(j);
    json_integer(j, "triangles", d->triangle_count);
    json_integer(j, "grid", d->grid);
    json_array(j, "xyz");
    for (uint32_t i = 0; i < 3 * d->count; i++) {
        json_float(j, NULL, d->xyz[i]);
    }
    json_end(j);
    json_end(j);
}

void json_effect_list(json *j, const char *key, uint32_t effects) {
    char word[48];
    json_array(j, key);
    for (uint32_t bit = 1; bit < BTF_EFFECT_ALL; bit <<= 1) {
        if (effects & bit) {
            json_string(j, NULL, cli_effects_text(bit, word));
        }
    }
    json_end(j);
}

static void json_effects(json *j, const btf_material *material, const btf_material_info *info) {
    char word[48];
    size_t count;
    const btf_material_error *errors = btf_material_errors(material, &count), *with, *without;
    json_effect_list(j, "effects", info->effects);
    json_object(j, "buys");
    for (uint32_t bit = 1; bit < BTF_EFFECT_ALL; bit <<= 1) {
        if (info->effects & bit & BETWEEN_EFFECTS) {
            double gain[2];
            json_object(j, cli_effects_text(bit, word));
            json_bool(j, "between_samples", true);
            if (between_gain(material, bit, gain)) {
                json_number(j, "linear", gain[0]);
                json_number(j, "srgb", gain[1]);
            }
            json_number(j, "bytes", (double)between_bytes(material, bit));
            json_end(j);
        } else if (info->effects & bit && find_gain(errors, count, bit, &with, &without)) {
            json_object(j, cli_effects_text(bit, word));
            json_number(j, "linear", (double)with->psnr_linear - (double)without->psnr_linear);
            json_number(j, "srgb", (double)with->psnr_srgb - (double)without->psnr_srgb);
            json_number(j, "bytes", (double)with->gpu_bytes - (double)without->gpu_bytes);
            json_end(j);
        }
    }
    json_end(j);
    json_array(j, "errors");
    for (size_t i = 0; i < count; i++) {
        json_object(j, NULL);
        json_effect_list(j, "effects", errors[i].effects);
        json_float(j, "linear", errors[i].psnr_linear);
        json_float(j, "srgb", errors[i].psnr_srgb);
        json_float(j, "gpu", errors[i].gpu_bytes);
        json_end(j);
    }
    json_end(j);
}

static void json_between_row(json *j, const float *row) {
    json_object(j, left_out_key(row[0]));
    json_number(j, "linear", decibels(row[1]));
    json_number(j, "srgb", decibels(row[2]));
    json_number(j, "data_linear", decibels(row[3]));
    json_number(j, "data_srgb", decibels(row[4]));
    json_end(j);
}

/* Writes the rows of one level. */
static void json_between(json *j, const btf_material *material, int level) {
    const btf_between_errors e = btf_material_between_errors(material);
    json_object(j, "between");
    for (uint32_t i = 0; i < e.row_count; i++) {
        const float *row = e.rows + (size_t)i * e.row_stride;
        if (left_out_level(row[0]) == level) {
            json_between_row(j, row);
        }
    }
    json_end(j);
}

static void json_levels(json *j, const btf_material *material, const btf_material_info *info) {
    json_array(j, "levels");
    for (uint32_t i = 0; i < info->levels; i++) {
        const btf_level_error *error = find_level_error(material, i);
        json_object(j, NULL);
        json_integer(j, "width", btf_level_size(info->width, i));
        json_integer(j, "height", btf_level_size(info->height, i));
        json_integer(j, "gpu", (int64_t)btf_level_bytes(info, i));
        if (error) {
            json_float(j, "linear", error->psnr_linear);
            json_float(j, "srgb", error->psnr_srgb);
        }
        if (i > 0) {
            json_between(j, material, (int)i);
        }
        json_end(j);
    }
    json_end(j);
}

static void json_textures(json *j, const btf_material *material, const btf_material_info *info) {
    json_object(j, "textures");
    for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
        btf_texture t = btf_material_texture(material, (btf_texture_id)id);
        if (t.format == BTF_FORMAT_NONE) {
            continue;
        }
        json_object(j, btf_texture_name((btf_texture_id)id));
        json_string(j, "format", format_name(t.format));
        json_integer(j, "width", t.width);
        json_integer(j, "height", t.height);
        json_integer(j, "layers", t.layers);
        json_bool(j, "array", t.is_array);
        json_integer(j, "bytes", (int64_t)t.size);
        json_bool(j, "table", is_table((btf_texture_id)id));
        json_number(j, "bytes_a_texel", (double)t.size / ((double)info->width * info->height));
        json_end(j);
    }
    json_end(j);
}

/* Writes the classes of factors that have units. */
static void json_classes(json *j, const btf_material_info *info) {
    json_array(j, "classes");
    for (int c = 0; c < BTF_FACTOR_CLASSES; c++) {
        const class_counts n = count_class(info, c);
        if (n.units == 0) {
            continue;
        }
        json_object(j, NULL);
        json_integer(j, "w_bits", class_bits[c][0]);
        json_integer(j, "u_bits", class_bits[c][1]);
        json_integer(j, "units", n.units);
        json_integer(j, "components", n.components);
        json_object(j, "words");
        json_integer(j, "y", n.words[0]);
        json_integer(j, "c1", n.words[1]);
        json_integer(j, "c2", n.words[2]);
        json_end(j);
        json_end(j);
    }
    json_end(j);
}

static void json_relief(json *j, const btf_material *material, const btf_material_info *info) {
    if (info->effects & BTF_EFFECT_RELIEF) {
        const relief_range r = find_relief(material, info);
        json_object(j, "relief");
        json_number(j, "low", r.low);
        json_number(j, "high", r.high);
        json_integer(j, "base", info->relief_base);
        json_integer(j, "step", info->relief_step);
        json_integer(j, "steps", info->relief_steps);
        json_integer(j, "level", info->relief_level);
        json_integer(j, "end", info->relief_end);
        json_integer(j, "views", r.views);
        json_end(j);
    }
    json_number(j, "gloss", info->gloss_share / 4.0);
}

btf_result print_json(const cli_program *program, const char *path, uint64_t file_bytes,
                      const btf_material *material, const btf_material_info *info) {
    const btf_directions views = btf_material_views(material), lights = btf_material_lights(material);
    json j = {0};
    json_object(&j, NULL);
    json_string(&j, "file", path);
    json_integer(&j, "version", info->version);
    json_integer(&j, "width", info->width);
    json_integer(&j, "height", info->height);
    json_string(&j, "layout", layout_names[info->layout]);
    json_string(&j, "domain", domain_names[info->domain]);
    json_string(&j, "colour", colour_names[info->colour]);
    json_integer(&j, "lobes", info->lobes);
    json_bool(&j, "half_float", info->half_float);
    json_integer(&j, "centres", info->centres);
    json_integer(&j, "residual", info->components);
    json_string(&j, "store", store_names[info->store]);
    json_classes(&j, info);
    json_float(&j, "horizon_scale", info->horizon_scale);
    json_string(&j, "blend", blend_names[info->blend]);
    json_string(&j, "point_store", point_store_names[info->point_store]);
    json_integer(&j, "point_entries", info->point_entries);
    json_relief(&j, material, info);
    json_bool(&j, "preview", btf_material_preview(material) != NULL);
    if (info->layout == BTF_LAYOUT_PAPER) {
        json_integer(&j, "atlas_width", info->atlas_width);
        json_integer(&j, "atlas_height", info->atlas_height);
    }
    json_object(&j, "scales");
    json_float(&j, "radiance", info->radiance_scale);
    json_float(&j, "shadow", info->shadow_scale);
    json_float(&j, "gain", info->gain_scale);
    json_float(&j, "gain_base", info->gain_base);
    json_float(&j, "gain_step", info->gain_step);
    json_float(&j, "centre", info->centre_scale);
    json_end(&j);
    json_object(&j, "bytes");
    json_integer(&j, "file", (int64_t)file_bytes);
    json_integer(&j, "gpu", (int64_t)info->gpu_bytes);
    json_integer(&j, "tables", (int64_t)info->table_bytes);
    json_end(&j);
    json_effects(&j, material, info);
    json_between(&j, material, 0);
    json_levels(&j, material, info);
    json_textures(&j, material, info);
    json_directions(&j, "views", &views);
    json_directions(&j, "lights", &lights);
    json_string(&j, "method", info->method);
    json_string(&j, "options", info->options);
    json_string(&j, "source", info->source);
    json_end(&j);
    return put_json(program, &j);
}
