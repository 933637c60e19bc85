/* Sums of lights under a view that moves, made on the CPU. See openbtf/fold.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cpu_fold.h"
#include "decoder/evaluate/exact.h"
#include "decoder/evaluate/partners.h"
#include "decoder/result.h"
#include <openbtf/fold.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A row of texels of all layers. */
typedef struct sum_row {
    size_t width, layer; /* words of a layer */
    uint32_t *values;    /* [view][column][4] under the light that is added */
    uint32_t *out;       /* the row in layer 0; that in layer i lies i * layer words behind */
} sum_row;

/* Sets roots of a magnitude below 2^-30 to 0, which the decoder clamps to 0 as well where one view has all the weight.
 * So no product of two is too small to be a normal number. */
static void drop_small(size_t words, uint32_t *values) {
    for (size_t i = 0; i < words; i++) {
        values[i] = fabsf(btfi_float(values[i])) >= 0x1p-30f ? values[i] : 0;
    }
}

/* The number that stands for the product of two roots (openbtf/fold.h): with it the square of their mean, multiplied
 * out, is that of the decoder, which clamps the mean at 0. */
BTFI_INLINE float product_of(float a, float b) {
    const float more = a > b ? a : b, less = a > b ? b : a;
    const float high = more > 0 ? more : 0.0f, low = less > -high ? less : -high;
    return low * (high + (low < 0 ? low : 0.0f) * 0.5f);
}

/* sum = sum + product * weight, each rounded. Four channels, the last of which are 0, make a vector. */
static void add_products(size_t width, const uint32_t *a, const uint32_t *b, const float weight[4],
                         uint32_t *sum) {
    for (size_t x = 0; x < 4 * width; x += 4) {
        for (size_t c = 0; c < 4; c++) {
            const float product = product_of(btfi_float(a[x + c]), btfi_float(b[x + c]));
            sum[x + c] = btfi_bits(btfi_float(sum[x + c]) + product * weight[c]);
        }
    }
}

/* Adds the values of a light to all layers of the row. */
static void add_light(const btf_evaluator *e, const sum_row *row, const float weight[3]) {
    const float four[4] = {weight[0], weight[1], weight[2], 0};
    if (e->info.blend == BTF_BLEND_ROOTS) {
        drop_small(4 * row->width * e->info.n_views, row->values);
    }
    for (uint32_t view = 0; view < e->info.n_views; view++) {
        const uint32_t *values = row->values + 4 * row->width * view;
        if (e->info.blend != BTF_BLEND_ROOTS) {
            btf_fold_add(row->width, values, weight, row->out + row->layer * view);
            continue;
        }
        uint32_t *sum = row->out + row->layer * (1 + BTFI_PARTNERS) * view;
        add_products(row->width, values, values, four, sum);
        for (uint32_t k = 0; k < BTFI_PARTNERS; k++) {
            const uint32_t partner = btfi_partner(e->partners[view], k);
            if (partner != BTFI_NO_PARTNER) {
                add_products(row->width, values, row->values + 4 * row->width * partner, four,
                             sum + row->layer * (1 + k));
            }
        }
    }
}

static uint32_t layers_of_view(const btf_evaluator *e) {
    return e->info.blend == BTF_BLEND_ROOTS ? 1 + BTFI_PARTNERS : 1;
}

static void clear(const btf_evaluator *e, const sum_row *row) {
    for (uint32_t i = 0; i < layers_of_view(e) * e->info.n_views; i++) {
        memset(row->out + row->layer * i, 0, 4 * row->width * sizeof *row->out);
    }
}

/* Writes into each view's own layer who its partners are. */
static void name_partners(const btf_evaluator *e, const sum_row *row) {
    for (uint32_t view = 0; view < e->info.n_views && e->info.blend == BTF_BLEND_ROOTS; view++) {
        uint32_t *texels = row->out + row->layer * layers_of_view(e) * view;
        for (size_t x = 0; x < row->width; x++) {
            texels[4 * x + 3] = e->partners[view];
        }
    }
}

static btf_result check(const btf_evaluator *evaluator, const btf_shader_options *options, uint32_t lights,
                        const float *light, const float *weight, uint32_t level, uint32_t first_row,
                        uint32_t rows) {
    if (!evaluator || !options || options->fold != BTF_FOLD_SUM || lights < 1 || !light || !weight ||
        level >= evaluator->info.levels || (unsigned)options->interpolation > BTF_INTERPOLATION_NEAREST) {
        return BTF_ERROR_USAGE;
    }
    const uint32_t height = evaluator->levels[level].height;
    if (first_row > height || rows > height - first_row) {
        return BTF_ERROR_USAGE;
    }
    return evaluator->info.blend == BTF_BLEND_ROOTS && !evaluator->partners
               ? BTF_ERROR_UNSUPPORTED
               : btf_fold_check(&evaluator->info, options, NULL);
}

btf_result btf_fold_sum_rows(const btf_evaluator *evaluator, const btf_shader_options *options,
                             uint32_t lights, const float *light, const float *weight, uint32_t level,
                             uint32_t first_row, uint32_t rows, uint32_t *out_level) {
    static const float normal[3] = {0, 0, 1}; /* values under a light alone do not depend on the viewer */
    const btf_result result = check(evaluator, options, lights, light, weight, level, first_row, rows);
    if (result != BTF_OK || !out_level) {
        return result != BTF_OK ? result : BTF_ERROR_USAGE;
    }
    const btfi_way way = btfi_fold_way(evaluator, options);
    const uint32_t views = evaluator->info.n_views;
    const size_t width = evaluator->levels[level].width;
    sum_row row = {.width = width,
                   .layer = 4 * width * evaluator->levels[level].height,
                   .values = malloc(4 * width * views * sizeof *row.values)};
    if (!row.values) {
        return BTF_ERROR_MEMORY;
    }
    for (uint32_t y = first_row; y < first_row + rows; y++) {
        row.out = out_level + 4 * width * y;
        clear(evaluator, &row);
        for (uint32_t i = 0; i < lights; i++) {
            btfi_situation situation;
            if (!btfi_look_up(evaluator, &way, light + 3 * (size_t)i, normal, &situation)) {
                continue;
            }
            for (uint32_t view = 0; view < views; view++) {
                btfi_fold_one_view(&situation, 0, view);
                btfi_fold_values(evaluator, &way, &situation, level, y, row.values + 4 * width * view);
            }
            add_light(evaluator, &row, weight + 3 * (size_t)i);
        }
        name_partners(evaluator, &row);
    }
    free(row.values);
    return BTF_OK;
}

btf_result btf_material_fold_sum(const btf_material *material, const btf_shader_options *options,
                                 uint32_t lights, const float *light, const float *weight,
                                 const btf_log *log, uint32_t **out_texels) {
    btf_evaluator *evaluator = NULL;
    btf_material_info info;
    uint32_t *texels = NULL;
    if (!out_texels) {
        return BTF_ERROR_USAGE;
    }
    *out_texels = NULL;
    if (!material || !options || options->fold != BTF_FOLD_SUM || lights < 1 || !light || !weight) {
        return btfi_fail(log, BTF_ERROR_USAGE,
                         "fold: a material, options of which the fold is 4, lights or weights are missing");
    }
    btf_result result = btfi_fold_whole(material, options, 1, log, &info, &evaluator, &texels);
    if (result != BTF_OK) {
        return result;
    }
    uint32_t *out = texels;
    for (uint32_t level = 0; level < info.levels && result == BTF_OK; level++) {
        const uint32_t width = btf_level_size(info.width, level),
                       height = btf_level_size(info.height, level);
        result = btf_fold_sum_rows(evaluator, options, lights, light, weight, level, 0, height, out);
        out += (size_t)4 * width * height * btf_fold_layers(&info, BTF_FOLD_SUM, 1);
    }
    btf_evaluator_destroy(&evaluator);
    if (result != BTF_OK) {
        free(texels);
        return result == BTF_ERROR_MEMORY
                   ? btfi_fail(log, result, "fold: out of memory for %zu bytes",
                               btf_fold_bytes(&info, BTF_FOLD_SUM, 1))
                   : btfi_fail(log, result, "fold: the triangulation of views does not lie in a plane");
    }
    *out_texels = texels;
    return BTF_OK;
}
