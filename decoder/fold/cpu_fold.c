/* Folds made on the CPU, by the loops of the evaluator. See openbtf/fold.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cpu_fold.h"
#include "fold.h"
#include "decoder/result.h"
#include <openbtf/fold.h>

#include <stdlib.h>
#include <string.h>

/* Texels of one row of a layer. */
typedef struct piece {
    const btf_evaluator *evaluator;
    const btf_shader_options *pass; /* what is decoded of each texel */
    uint32_t level, row;
    uint32_t *out; /* [width][4] */
} piece;

static void keep(const float rgb[3], uint32_t out[4]) {
    memcpy(out, rgb, 3 * sizeof *rgb);
    out[3] = 0;
}

static void clear_row(const piece *p) {
    memset(p->out, 0, (size_t)p->evaluator->levels[p->level].width * 4 * sizeof *p->out);
}

/* Radiance of the row's texels. */
static btf_result fold_radiance(const piece *p, const float light[3], const float view[3]) {
    enum { MOST = BTFI_MOST_POINTS };
    const uint32_t width = p->evaluator->levels[p->level].width;
    const btf_evaluate_options options = {.struct_size = sizeof options,
                                          .leave_out = p->pass->leave_out,
                                          .components = p->pass->components,
                                          .interpolation = p->pass->interpolation};
    btf_result result = BTF_OK;
    for (uint32_t first = 0; first < width && result == BTF_OK; first += MOST) {
        uint32_t texels[MOST][2];
        int32_t levels[MOST];
        float rgb[MOST][3];
        const uint32_t count = width - first < MOST ? width - first : MOST;
        for (uint32_t i = 0; i < count; i++) {
            texels[i][0] = first + i;
            texels[i][1] = p->row;
            levels[i] = (int32_t)p->level;
        }
        const btf_evaluations many = {.struct_size = sizeof many,
                                      .count = count,
                                      .texels = texels[0],
                                      .lights = light,
                                      .views = view,
                                      .levels = levels,
                                      .fixed = BTF_FIXED_LIGHT | BTF_FIXED_VIEW,
                                      .rgb = rgb[0]};
        result = btf_evaluate_many(p->evaluator, &options, &many);
        for (uint32_t i = 0; i < count && result == BTF_OK; i++) {
            keep(rgb[i], p->out + 4 * (size_t)(first + i));
        }
    }
    return result;
}

btfi_way btfi_fold_way(const btf_evaluator *evaluator, const btf_shader_options *options) {
    const btf_shader_options pass = btf_fold_pass(options);
    const btf_material_info *info = &evaluator->info;
    return (btfi_way){.effects = info->effects & ~pass.leave_out,
                      .components = pass.components && pass.components < info->components
                                        ? pass.components
                                        : info->components,
                      .linear = pass.interpolation == BTF_INTERPOLATION_LINEAR,
                      .filter = BTF_FILTER_TEXEL};
}

void btfi_fold_one_view(btfi_situation *s, int place, uint32_t view) {
    s->lights[0] = s->lights[place];
    s->views = (btfi_neighbours){1, {view, view, view}, {4096, 0, 0}, {0}};
}

void btfi_fold_values(const btf_evaluator *evaluator, const btfi_way *way, const btfi_situation *situation,
                      uint32_t level_index, uint32_t row, uint32_t *out) {
    const btfi_level *level = &evaluator->levels[level_index];
    for (uint32_t first = 0; first < level->width; first += BTFI_MOST_POINTS) {
        btfi_points texels = {0};
        btfi_sources sources[3];
        float values[3][BTFI_MOST_POINTS][3];
        for (; texels.count < BTFI_MOST_POINTS && first + (uint32_t)texels.count < level->width;
             texels.count++) {
            texels.column[texels.count] = first + (uint32_t)texels.count;
            texels.row[texels.count] = row;
        }
        const btfi_points *const points[3] = {&texels, &texels, &texels};
        btfi_find_sources(evaluator, level, way, situation, points, sources);
        btfi_view_values(evaluator, level, way, situation, sources, values);
        for (int i = 0; i < texels.count; i++) {
            keep(values[0][i], out + 4 * (size_t)(first + (uint32_t)i));
        }
    }
}

/* Leaves of a situation the view that a layer keeps, and its lights; false where the layer is empty. */
static bool choose_view(btf_fold fold, uint32_t layer, btfi_situation *s) {
    int a = 0;
    uint32_t view = layer;
    if (fold == BTF_FOLD_NEIGHBOURS) {
        while (a < s->views.count && s->views.place[a] != layer) {
            a++;
        }
        if (a == s->views.count) {
            return false;
        }
        view = s->views.index[a];
    }
    btfi_fold_one_view(s, a, view);
    return true;
}

btf_result btf_fold_rows(const btf_evaluator *evaluator, const btf_shader_options *options,
                         const float light[3], const float view[3], uint32_t level, uint32_t layer,
                         uint32_t first_row, uint32_t rows, uint32_t *out_texels) {
    static const float normal[3] = {0, 0, 1}; /* values under a light alone do not depend on the viewer */
    if (!evaluator || !options || !light || !out_texels) {
        return BTF_ERROR_USAGE;
    }
    const btf_material_info *info = &evaluator->info;
    const btf_fold fold = options->fold;
    if (fold == BTF_FOLD_NONE || fold == BTF_FOLD_SUM || level >= info->levels ||
        (unsigned)options->interpolation > BTF_INTERPOLATION_NEAREST) {
        return BTF_ERROR_USAGE;
    }
    if (btf_fold_check(info, options, NULL) != BTF_OK) {
        return BTF_ERROR_UNSUPPORTED;
    }
    const uint32_t width = evaluator->levels[level].width, height = evaluator->levels[level].height;
    if ((fold != BTF_FOLD_LIGHT && !view) || layer >= btf_fold_layers(info, fold, 1) ||
        first_row > height || rows > height - first_row) {
        return BTF_ERROR_USAGE;
    }
    const btf_shader_options pass = btf_fold_pass(options);
    const btfi_way way = btfi_fold_way(evaluator, options);
    piece p = {evaluator, &pass, level, first_row, out_texels};
    btfi_situation situation;
    btf_result result = BTF_OK;
    const bool values = fold != BTF_FOLD_BOTH,
               seen = values &&
                      btfi_look_up(evaluator, &way, light, fold == BTF_FOLD_LIGHT ? normal : view,
                                   &situation) &&
                      choose_view(fold, layer, &situation);
    for (uint32_t row = 0; row < rows && result == BTF_OK; row++, p.row++, p.out += 4 * (size_t)width) {
        if (!values) {
            result = fold_radiance(&p, light, view);
        } else if (seen) {
            btfi_fold_values(evaluator, &way, &situation, level, p.row, p.out);
        } else {
            clear_row(&p);
        }
    }
    return result;
}

void btf_fold_add(size_t count, const uint32_t *texels, const float weight[3], uint32_t *sum) {
    for (size_t i = 0; i < 4 * count; i++) {
        float value, total;
        if (i % 4 == 3) {
            continue;
        }
        memcpy(&value, texels + i, sizeof value);
        memcpy(&total, sum + i, sizeof total);
        total = total + value * weight[i % 4];
        memcpy(sum + i, &total, sizeof total);
    }
}

btf_result btfi_fold_whole(const btf_material *material, const btf_shader_options *options, uint32_t lights,
                           const btf_log *log, btf_material_info *out_info, btf_evaluator **out_evaluator,
                           uint32_t **out_texels) {
    *out_info = (btf_material_info){.struct_size = sizeof *out_info};
    btf_material_get_info(material, out_info);
    btf_result result = btf_fold_check(out_info, options, log);
    if (result == BTF_OK) {
        result = btf_evaluator_create(material, log, out_evaluator);
    }
    if (result != BTF_OK) {
        return result;
    }
    const size_t bytes = btf_fold_bytes(out_info, options->fold, lights);
    *out_texels = btfi_fold_fits(out_info, options->fold, lights) ? malloc(bytes) : NULL;
    if (!*out_texels) {
        btf_evaluator_destroy(out_evaluator);
        return btfi_fail(log, BTF_ERROR_MEMORY, "fold: out of memory for %zu bytes", bytes);
    }
    return BTF_OK;
}

btf_result btf_material_fold(const btf_material *material, const btf_shader_options *options,
                             uint32_t lights, const float *light, const float *view, const btf_log *log,
                             uint32_t **out_texels) {
    btf_evaluator *evaluator = NULL;
    btf_material_info info;
    uint32_t *texels = NULL;
    if (!out_texels) {
        return BTF_ERROR_USAGE;
    }
    *out_texels = NULL;
    if (!material || !options || options->fold == BTF_FOLD_NONE || options->fold == BTF_FOLD_SUM ||
        lights < 1 || !light || (options->fold != BTF_FOLD_LIGHT && !view)) {
        return btfi_fail(log, BTF_ERROR_USAGE,
                         "fold: a material, options, their fold (1 to 3), a light or a view is missing");
    }
    btf_result result = btfi_fold_whole(material, options, lights, log, &info, &evaluator, &texels);
    if (result != BTF_OK) {
        return result;
    }
    const uint32_t layers = btf_fold_layers(&info, options->fold, 1);
    uint32_t *out = texels;
    for (uint32_t level = 0; level < info.levels && result == BTF_OK; level++) {
        const uint32_t width = btf_level_size(info.width, level),
                       height = btf_level_size(info.height, level);
        for (uint32_t i = 0; i < lights * layers && result == BTF_OK;
             i++, out += (size_t)4 * width * height) {
            result = btf_fold_rows(evaluator, options, light + 3 * (size_t)(i / layers),
                                   view ? view + 3 * (size_t)(i / layers) : NULL, level, i % layers, 0,
                                   height, out);
        }
    }
    btf_evaluator_destroy(&evaluator);
    if (result != BTF_OK) {
        free(texels);
        texels = NULL;
    }
    *out_texels = texels;
    return result;
}
