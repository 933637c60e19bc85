/* OpenBTF: checks that the values of textures keep the rules of FORMAT.md sections 2 to 5.
 *
 * SPDX-License-Identifier: MIT
 */
#include "values.h"

#include "decoder/atlas.h"
#include "decoder/parts.h"
#include <math.h>

/* The textures of one level, while they are checked: info's size is that of the level. */
typedef struct values {
    const btfi_check *check;
    const btf_material_info *info;
    uint32_t level;
} values;

/* The name of the channel of `sbrdf` at (layer, component); NULL where there is none. */
static const char *sbrdf_channel(const btfi_part *part, uint32_t layer, uint32_t component) {
    for (int i = 0; i < part->channel_count; i++) {
        if (part->channels[i].layer == layer && part->channels[i].component == component) {
            return part->channels[i].name;
        }
    }
    return NULL;
}

static btf_result refuse_parameter(const values *v, const btfi_part *part, uint32_t layer,
                                   uint32_t component, size_t texel, double value) {
    const char *name = sbrdf_channel(part, layer, component);
    return btfi_fail(v->check->log, v->check->code,
                     "%s: channel %s at (%zu, %zu) holds %g, which is not %s",
                     btfi_texture_name(v->level, BTF_TEXTURE_SBRDF).text, name ? name : "(unused)",
                     texel % v->info->width, texel / v->info->width, value,
                     !name                 ? "0"
                     : v->info->half_float ? "0 or of magnitude 2^-14 to 65504"
                                           : "0 or of magnitude 2^-24 to 2^24");
}

static double half_value(uint16_t bits) {
    int exponent = bits >> 10 & 31, mantissa = bits & 1023;
    double value = exponent == 31
                       ? (mantissa ? NAN : INFINITY)
                       : ldexp(exponent ? mantissa + 1024 : mantissa, (exponent ? exponent : 1) - 25);
    return bits & 0x8000 ? -value : value;
}

static btf_result check_sbrdf(const values *v, void *data) {
    btfi_part sbrdf, *const part = &sbrdf;
    if (!btfi_part_of(v->info, 0, BTF_TEXTURE_SBRDF, part)) {
        return BTF_ERROR_INTERNAL; /* info was checked */
    }
    const size_t texels = (size_t)v->info->width * v->info->height;
    for (uint32_t layer = 0; layer < part->shape.layers; layer++) {
        bool used[4];
        for (uint32_t c = 0; c < 4; c++) {
            used[c] = sbrdf_channel(part, layer, c) != NULL;
        }
        for (size_t i = 0; i < 4 * texels; i++) {
            size_t at = 4 * texels * layer + i;
            if (v->info->half_float) {
                uint16_t *h = (uint16_t *)data + at;
                uint16_t exponent = *h & 0x7C00; /* 0: denormal; 0x7C00: infinite or no number */
                if ((*h & 0x7FFF) == 0) {
                    *h = 0;
                } else if (exponent == 0 || exponent == 0x7C00 || !used[i % 4]) {
                    return refuse_parameter(v, part, layer, i % 4, i / 4, half_value(*h));
                }
            } else {
                float *f = (float *)data + at;
                if (*f == 0) {
                    *f = 0;
                } else if (!btfi_is_parameter(*f) || !used[i % 4]) {
                    return refuse_parameter(v, part, layer, i % 4, i / 4, (double)*f);
                }
            }
        }
    }
    return BTF_OK;
}

/* Checks the gain code and the shift bytes of one texel and view. `where` names the texture. */
static btf_result check_point(const values *v, const char *where, uint32_t column, uint32_t row,
                              uint32_t view, unsigned g, unsigned b0, unsigned b1) {
    const uint32_t effects = v->info->effects;
    const btfi_check *check = v->check;
    if (g == 0) {
        if (!(effects & BTF_EFFECT_HIDDEN)) {
            return btfi_fail(check->log, check->code,
                             "%s: view %u, texel (%u, %u): gain code 0 without the effect hidden", where,
                             (unsigned)view, (unsigned)column, (unsigned)row);
        }
        if (b0 + 256 * b1 >= v->info->centres) {
            return btfi_fail(check->log, check->code, "%s: view %u, texel (%u, %u) names centre %u of %u",
                             where, (unsigned)view, (unsigned)column, (unsigned)row, b0 + 256 * b1,
                             (unsigned)v->info->centres);
        }
        return BTF_OK;
    }
    if (g != BTF_GAIN_ONE && !(effects & BTF_EFFECT_GAIN)) {
        return btfi_fail(check->log, check->code,
                         "%s: view %u, texel (%u, %u): gain code %u without the effect gain, not %d", where,
                         (unsigned)view, (unsigned)column, (unsigned)row, g, BTF_GAIN_ONE);
    }
    if ((b0 | b1) != 0 && !(effects & BTF_EFFECT_SHIFT)) {
        return btfi_fail(check->log, check->code,
                         "%s: view %u, texel (%u, %u): shift bytes %u, %u without the effect shift", where,
                         (unsigned)view, (unsigned)column, (unsigned)row, b0, b1);
    }
    return BTF_OK;
}

/* Checks textures shift and gain of layout tight, either of which may be NULL. */
static btf_result check_tight_points(const values *v, const uint8_t *shift, const uint8_t *gain) {
    const uint32_t w = v->info->width, h = v->info->height;
    const btfi_name where = btfi_texture_name(v->level, gain ? BTF_TEXTURE_GAIN : BTF_TEXTURE_SHIFT);
    size_t i = 0;
    for (uint32_t view = 0; view < v->info->n_views; view++) {
        for (uint32_t row = 0; row < h; row++) {
            for (uint32_t column = 0; column < w; column++, i++) {
                btf_result result =
                    check_point(v, where.text, column, row, view, gain ? gain[i] : BTF_GAIN_ONE,
                                shift ? shift[2 * i] : 0, shift ? shift[2 * i + 1] : 0);
                if (result) {
                    return result;
                }
            }
        }
    }
    return BTF_OK;
}

/* Checks the indices of lists of points. A byte has the indices of two views, the first in its low half; where the
 * number of views is odd, the last high half is 0. */
static btf_result check_point_indices(const values *v, const uint8_t *data) {
    const uint32_t w = v->info->width, texels = w * v->info->height, entries = v->info->point_entries;
    const btfi_name name = btfi_texture_name(v->level, BTF_TEXTURE_POINT_INDICES);
    for (uint32_t view = 0; view < v->info->n_views + v->info->n_views % 2; view++) {
        for (uint32_t t = 0; t < texels; t++) {
            const unsigned index = data[(size_t)(view >> 1) * texels + t] >> 4 * (view & 1) & 15u;
            if (view == v->info->n_views && index != 0) {
                return btfi_fail(v->check->log, v->check->code,
                                 "%s: texel (%u, %u): the high bits of the last layer hold %u, not 0",
                                 name.text, (unsigned)(t % w), (unsigned)(t / w), index);
            }
            if (index >= entries) {
                return btfi_fail(v->check->log, v->check->code,
                                 "%s: view %u, texel (%u, %u) names entry %u of %u", name.text,
                                 (unsigned)view, (unsigned)(t % w), (unsigned)(t / w), index,
                                 (unsigned)entries);
            }
        }
    }
    return BTF_OK;
}

static btf_result refuse_meaningless(const values *v, const char *where, size_t x, size_t y,
                                     unsigned value) {
    return btfi_fail(v->check->log, v->check->code,
                     "%s: texel (%zu, %zu) holds %u; it has no meaning and must be 0", where, x, y, value);
}

/* Checks the texels of `centres`: alpha is 0, and so is all that lies beyond centre K. */
static btf_result check_tight_centres(const values *v, const uint8_t *data) {
    btf_texture t = btf_material_texture_shape(v->info, BTF_TEXTURE_CENTRES);
    for (uint32_t y = 0; y < t.height; y++) {
        for (uint32_t x = 0; x < t.width; x++, data += 4) {
            bool used = x / v->info->n_lights * t.height + y < v->info->centres;
            for (int c = used ? 3 : 0; c < 4; c++) {
                if (data[c]) {
                    return refuse_meaningless(v, "centres", x, y, data[c]);
                }
            }
        }
    }
    return BTF_OK;
}

/* Checks row `row` of a tile. */
static btf_result check_tile_row(const values *v, uint32_t tile, uint32_t row, const uint8_t *data,
                                 uint32_t x0, uint32_t y) {
    const bool light = tile < v->info->n_lights && v->info->effects & BTF_EFFECT_SHADOW;
    const bool view = tile < v->info->n_views;
    const bool code = v->info->effects & (BTF_EFFECT_GAIN | BTF_EFFECT_HIDDEN);
    for (uint32_t column = 0; column < v->info->width; column++, data += 4) {
        if (data[0] && !light) {
            return refuse_meaningless(v, "maps", x0 + column, y, data[0]);
        }
        if (!code && data[1]) {
            return refuse_meaningless(v, "maps", x0 + column, y, data[1]);
        }
        if (!view && (data[1] | data[2] | data[3])) {
            return refuse_meaningless(v, "maps", x0 + column, y, data[1] | data[2] | data[3]);
        }
        if (view) {
            btf_result result =
                check_point(v, "maps", column, row, tile, code ? data[1] : BTF_GAIN_ONE, data[2], data[3]);
            if (result) {
                return result;
            }
        }
    }
    return BTF_OK;
}

static btf_result check_maps(const values *v, const uint8_t *data) {
    const btf_material_info *info = v->info;
    btfi_atlas atlas;
    if (!btfi_atlas_plan(info, info->atlas_width, info->atlas_height, &atlas)) {
        return BTF_ERROR_INTERNAL; /* info was checked */
    }
    for (uint32_t y = 0; y < info->atlas_height; y++, data += 4 * (size_t)info->atlas_width) {
        uint32_t first = y / info->height * atlas.columns, x = 0;
        for (uint32_t i = 0; i < atlas.columns && first + i < atlas.tiles; i++, x += info->width) {
            btf_result result = check_tile_row(v, first + i, y % info->height, data + 4 * (size_t)x, x, y);
            if (result) {
                return result;
            }
        }
        for (; x < info->atlas_width; x++) {
            const uint8_t *texel = data + 4 * (size_t)x;
            uint32_t centre;
            if (!(texel[0] | texel[1] | texel[2] | texel[3])) {
                continue;
            }
            if (!btfi_atlas_centre_at(info, &atlas, x, y, &centre) || centre >= info->centres || texel[3]) {
                return refuse_meaningless(v, "maps", x, y, texel[0] | texel[1] | texel[2] | texel[3]);
            }
        }
    }
    return BTF_OK;
}

/* Checks codes of components: those from k on are 0, and none is -128. */
static btf_result check_residual(const values *v, btf_texture_id id, uint32_t layers_a_quad,
                                 const int8_t *data) {
    btf_texture t = btf_material_texture_shape(v->info, id);
    const size_t texels = (size_t)t.width * t.height;
    for (uint32_t layer = 0; layer < t.layers; layer++) {
        uint32_t first = layer / layers_a_quad * 4;
        for (size_t i = 0; i < 4 * texels; i++) {
            int8_t value = *data++;
            if (value == -128 || (value != 0 && first + i % 4 >= v->info->components)) {
                return btfi_fail(v->check->log, v->check->code,
                                 "%s: component %zu at (%zu, %zu) holds %d, which is not %s",
                                 btfi_texture_name(v->level, id).text, first + i % 4, i / 4 % t.width,
                                 i / 4 / t.width, value, value == -128 ? "within -127 to 127" : "0");
            }
        }
    }
    return BTF_OK;
}

static btf_result check_residual_scales(const values *v, float *data) {
    btf_texture t = btf_material_texture_shape(v->info, BTF_TEXTURE_RESIDUAL_SCALES);
    for (uint32_t i = 0; i < 4 * t.width; i++) {
        if (data[i] == 0) {
            data[i] = 0;
        } else if (!btfi_is_parameter(data[i]) || i >= v->info->components) {
            return btfi_fail(v->check->log, v->check->code,
                             "residualScales: number %u is %g, which is not %s", (unsigned)i,
                             (double)data[i],
                             i >= v->info->components ? "0" : "0 or of magnitude 2^-24 to 2^24");
        }
    }
    return BTF_OK;
}

/* Checks that no byte of class 0, whose units come first and take one texel each, is -128. Codes of fewer bits may be
 * anything. */
static btf_result check_factors(const values *v, btf_texture_id id, const uint32_t *data) {
    const btf_texture t = btf_material_texture_shape(v->info, id);
    const size_t texels = (size_t)t.width * t.height, words = 4 * texels * v->info->factor_classes[0][0];
    for (size_t i = 0; i < words; i++) {
        for (int byte = 0; byte < 4; byte++) {
            if ((data[i] >> (8 * byte) & 255) == 128) {
                return btfi_fail(
                    v->check->log, v->check->code,
                    "%s: unit %zu at (%zu, %zu): byte %d of channel %c is -128, not within -127 to 127",
                    btfi_texture_name(v->level, id).text, i / 4 / texels, i / 4 % texels % t.width,
                    i / 4 % texels / t.width, byte, "RGBA"[i % 4]);
            }
        }
    }
    return BTF_OK;
}

/* Checks the `count` numbers of an attribute, of which each texel of `data` holds `group`, and turns -0 into 0. */
static btf_result check_parameters(const values *v, const char *attribute, float *data, size_t group,
                                   size_t count) {
    for (size_t i = 0; i < count; i++) {
        float *number = &data[i / group * 4 + i % group];
        if (!btfi_is_parameter(*number)) {
            return btfi_fail(v->check->log, v->check->code,
                             "%s: number %zu is %g, which is not 0 or of magnitude 2^-24 to 2^24",
                             attribute, i, (double)*number);
        }
        *number = *number == 0 ? 0 : *number;
    }
    return BTF_OK;
}

static btf_result check_factor_scales(const values *v, float *data) {
    const uint32_t units = v->info->components;
    btf_result result = check_parameters(v, "factorScales", data, 4, 4 * (size_t)units);
    for (uint32_t unit = 0; unit < units && !result; unit++, data += 4) {
        if (!btfi_unit_is_mixed(v->info, unit) &&
            (data[1] != data[0] || data[2] != data[0] || data[3] != data[0])) {
            result = btfi_fail(
                v->check->log, v->check->code,
                "factorScales: unit %u, all of Y, has the scales %g, %g, %g, %g, which are not equal",
                (unsigned)unit, (double)data[0], (double)data[1], (double)data[2], (double)data[3]);
        }
    }
    return result;
}

static btf_result check_factor_views(const values *v, float *data) {
    const size_t texels = 3 * (size_t)v->info->n_views;
    for (size_t i = 0; i < texels; i++) {
        float *fourth = &data[4 * i + 3];
        if (*fourth != 0) {
            return btfi_fail(v->check->log, v->check->code,
                             "factor_views: A of view %zu, tier %zu is %g, not 0", i / 3, i % 3,
                             (double)*fourth);
        }
        *fourth = 0;
    }
    return check_parameters(v, "factorViews", data, 3, 3 * texels);
}

/* Checks the textures of a level; those that it does not have are NULL. */
static btf_result check_level(const values *v, void *const texture[BTF_TEXTURE_COUNT]) {
    btf_result result;
    if (texture[BTF_TEXTURE_SBRDF] && (result = check_sbrdf(v, texture[BTF_TEXTURE_SBRDF]))) {
        return result;
    }
    if (texture[BTF_TEXTURE_MAPS] && (result = check_maps(v, texture[BTF_TEXTURE_MAPS]))) {
        return result;
    }
    if ((texture[BTF_TEXTURE_SHIFT] || texture[BTF_TEXTURE_GAIN]) &&
        (result = check_tight_points(v, texture[BTF_TEXTURE_SHIFT], texture[BTF_TEXTURE_GAIN]))) {
        return result;
    }
    if (texture[BTF_TEXTURE_POINT_INDICES] &&
        (result = check_point_indices(v, texture[BTF_TEXTURE_POINT_INDICES]))) {
        return result;
    }
    if (texture[BTF_TEXTURE_CENTRES] && (result = check_tight_centres(v, texture[BTF_TEXTURE_CENTRES]))) {
        return result;
    }
    if (texture[BTF_TEXTURE_RESIDUAL_TEXELS] &&
        (result =
             check_residual(v, BTF_TEXTURE_RESIDUAL_TEXELS, 1, texture[BTF_TEXTURE_RESIDUAL_TEXELS]))) {
        return result;
    }
    if (texture[BTF_TEXTURE_RESIDUAL_DIRECTIONS] &&
        ((result = check_residual(v, BTF_TEXTURE_RESIDUAL_DIRECTIONS, 3,
                                  texture[BTF_TEXTURE_RESIDUAL_DIRECTIONS])) ||
         (result = check_residual_scales(v, texture[BTF_TEXTURE_RESIDUAL_SCALES])))) {
        return result;
    }
    if (texture[BTF_TEXTURE_FACTOR_TEXELS] &&
        (result = check_factors(v, BTF_TEXTURE_FACTOR_TEXELS, texture[BTF_TEXTURE_FACTOR_TEXELS]))) {
        return result;
    }
    if (texture[BTF_TEXTURE_FACTOR_DIRECTIONS] &&
        ((result =
              check_factors(v, BTF_TEXTURE_FACTOR_DIRECTIONS, texture[BTF_TEXTURE_FACTOR_DIRECTIONS])) ||
         (result = check_factor_scales(v, texture[BTF_TEXTURE_FACTOR_SCALES])) ||
         (result = check_factor_views(v, texture[BTF_TEXTURE_FACTOR_VIEWS])))) {
        return result;
    }
    return BTF_OK;
}

btf_result btfi_check_values(const btfi_check *check, const btf_material_info *info,
                             void *texture[BTF_MAX_LEVELS][BTF_TEXTURE_COUNT]) {
    btf_result result = BTF_OK;
    for (uint32_t level = 0; level < info->levels && !result; level++) {
        btf_material_info of_level = *info;
        of_level.width = btf_level_size(info->width, level);
        of_level.height = btf_level_size(info->height, level);
        result = check_level(&(values){check, &of_level, level}, texture[level]);
    }
    return result;
}

btf_result btfi_check_errors(const btfi_check *check, uint32_t known, const btf_material_error *errors,
                             size_t count) {
    for (size_t i = 0; i < count; i++) {
        const btf_material_error *e = &errors[i];
        if (e->effects & ~known) {
            return btfi_fail(check->log, check->code,
                             "errors: row %zu has the effects 0x%x, of which bits are unknown", i,
                             (unsigned)e->effects);
        }
        if (e->psnr_linear != e->psnr_linear || e->psnr_srgb != e->psnr_srgb || !(e->gpu_bytes >= 0)) {
            return btfi_fail(check->log, check->code, "errors: row %zu is (%g, %g, %g)", i,
                             (double)e->psnr_linear, (double)e->psnr_srgb, (double)e->gpu_bytes);
        }
    }
    return BTF_OK;
}

btf_result btfi_check_level_errors(const btfi_check *check, uint32_t levels, const btf_level_error *errors,
                                   size_t count) {
    for (size_t i = 0; i < count; i++) {
        const btf_level_error *e = &errors[i];
        if (e->level >= levels || (i > 0 && e->level <= errors[i - 1].level)) {
            return btfi_fail(check->log, check->code,
                             "level errors: row %zu is of level %u; levels must rise and be below %u", i,
                             (unsigned)e->level, (unsigned)levels);
        }
        if (e->psnr_linear != e->psnr_linear || e->psnr_srgb != e->psnr_srgb || !(e->gpu_bytes >= 0)) {
            return btfi_fail(check->log, check->code, "level errors: row %zu is (%g, %g, %g)", i,
                             (double)e->psnr_linear, (double)e->psnr_srgb, (double)e->gpu_bytes);
        }
    }
    return BTF_OK;
}
