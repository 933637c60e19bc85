/* OpenBTF: checks that a header keeps the rules of FORMAT.md sections 2 to 5 and 7.
 *
 * SPDX-License-Identifier: MIT
 */
#include "info.h"

#include "decoder/atlas.h"
#include "decoder/shape.h"

static bool is_power_of_two(uint32_t n) {
    return n != 0 && (n & (n - 1)) == 0;
}

static btf_result check_scale(const btfi_check *check, const char *name, float value) {
    if (value > 0 && btfi_is_parameter(value)) {
        return BTF_OK;
    }
    return btfi_fail(check->log, check->code, "%s %g is not within 2^-24 to 2^24", name, (double)value);
}

/* Checks the classes of factors, which must all be 0 where the residual is stored otherwise. */
static btf_result check_classes(const btfi_check *check, const btf_material_info *info) {
    const bool factors = info->store == BTF_STORE_FACTORS;
    uint32_t units = 0;
    for (uint32_t c = 0; c < BTF_FACTOR_CLASSES; c++) {
        const uint32_t *n = info->factor_classes[c];
        if (n[0] > BTF_MAX_COMPONENTS || n[1] > 4 * n[0] || n[2] > 4 * n[0] - n[1]) {
            return btfi_fail(check->log, check->code,
                             "factorClasses: class %u has %u units (at most %d) with %u words of C1 and %u "
                             "of C2 (at most 4 a unit)",
                             (unsigned)c, (unsigned)n[0], BTF_MAX_COMPONENTS, (unsigned)n[1],
                             (unsigned)n[2]);
        }
        units += n[0];
    }
    if (units != (factors ? info->components : 0)) {
        return btfi_fail(check->log, check->code,
                         "factorClasses: the classes have %u units in all, the residual has %u",
                         (unsigned)units, factors ? (unsigned)info->components : 0);
    }
    if (factors && btfi_factor_layers(info, units) > BTF_MAX_COMPONENTS) {
        return btfi_fail(check->log, check->code, "factorClasses: %u layers of factor_texels, not 1 to %d",
                         (unsigned)btfi_factor_layers(info, units), BTF_MAX_COMPONENTS);
    }
    return BTF_OK;
}

/* Checks how points are stored. Packed points, in lists or not, hold both shift and gain, and leave no code for hidden
 * points. */
static btf_result check_points(const btfi_check *check, const btf_material_info *info) {
    const bool lists = info->point_store == BTF_POINTS_LISTS;
    if (info->point_store != BTF_POINTS_SEPARATE && !btfi_shares_points(info)) {
        return btfi_fail(check->log, check->code, "unknown store %d of shift and gain",
                         (int)info->point_store);
    }
    if (lists ? info->point_entries < 1 || info->point_entries > BTF_MAX_POINT_ENTRIES
              : info->point_entries != 0) {
        return btfi_fail(check->log, check->code,
                         lists ? "pointEntries %u is not within 1 to %d"
                               : "pointEntries is %u, but only lists of points have entries",
                         (unsigned)info->point_entries, BTF_MAX_POINT_ENTRIES);
    }
    if (info->point_store == BTF_POINTS_SEPARATE) {
        if (info->gain_base != 0 || info->gain_step != 0) {
            return btfi_fail(check->log, check->code,
                             "gainBase %g and gainStep %g are only for packed points",
                             (double)info->gain_base, (double)info->gain_step);
        }
        return BTF_OK;
    }
    const uint32_t both = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN;
    if (info->layout != BTF_LAYOUT_TIGHT) {
        return btfi_fail(check->log, check->code, "packed points need layout tight");
    }
    if ((info->effects & (both | BTF_EFFECT_HIDDEN)) != both) {
        return btfi_fail(check->log, check->code,
                         "packed points need the effects shift and gain, and no effect hidden");
    }
    if (!btfi_is_parameter(info->gain_base) || !btfi_is_parameter(info->gain_step)) {
        return btfi_fail(check->log, check->code, "%s %g is neither 0 nor of magnitude 2^-24 to 2^24",
                         btfi_is_parameter(info->gain_base) ? "gainStep" : "gainBase",
                         (double)(btfi_is_parameter(info->gain_base) ? info->gain_step : info->gain_base));
    }
    return BTF_OK;
}

/* Checks the heights of the relief and the share of the half vector, which must be 0 without their effects. */
static btf_result check_relief(const btfi_check *check, const btf_material_info *info) {
    const bool relief = info->effects & BTF_EFFECT_RELIEF, gloss = info->effects & BTF_EFFECT_GLOSS;
    const struct {
        const char *name;
        int64_t value, low, high;
    } numbers[] = {{"reliefBase", info->relief_base, INT16_MIN, INT16_MAX},
                   {"reliefStep", info->relief_step, 0, INT16_MAX},
                   {"reliefSteps", info->relief_steps, 1, BTF_MAX_RELIEF_STEPS},
                   {"reliefLevel", info->relief_level, 0, BTF_MAX_LEVELS - 1},
                   {"glossShare", info->gloss_share, 1, 2}};
    const int count = (int)(sizeof numbers / sizeof *numbers);
    for (int i = 0; i < count; i++) {
        const bool of_gloss = i == count - 1;
        const long long value = numbers[i].value;
        if (of_gloss ? gloss : relief) {
            if (value < numbers[i].low || value > numbers[i].high) {
                return btfi_fail(check->log, check->code, "%s %lld is not within %lld to %lld",
                                 numbers[i].name, value, (long long)numbers[i].low,
                                 (long long)numbers[i].high);
            }
        } else if (value != 0) {
            return btfi_fail(check->log, check->code, "%s %lld without the effect %s", numbers[i].name,
                             value, of_gloss ? "gloss" : "relief");
        }
    }
    if ((relief || gloss) && info->layout != BTF_LAYOUT_TIGHT) {
        return btfi_fail(check->log, check->code, "the effect %s needs layout tight",
                         relief ? "relief" : "gloss");
    }
    const int top = info->relief_base + (255 * info->relief_step >> 8);
    if (top > INT16_MAX) {
        return btfi_fail(check->log, check->code,
                         "reliefBase %d and reliefStep %d: the greatest height is %d, above %d",
                         (int)info->relief_base, (int)info->relief_step, top, INT16_MAX);
    }
    if (relief && info->relief_step == 0 && info->relief_steps != 1) {
        return btfi_fail(check->log, check->code, "reliefSteps is %u; it must be 1 where reliefStep is 0",
                         (unsigned)info->relief_steps);
    }
    return BTF_OK;
}

/* Checks the members that only version 2 stores. */
static btf_result check_version_2(const btfi_check *check, const btf_material_info *info) {
    if (info->store != BTF_STORE_COMPONENTS && info->store != BTF_STORE_FACTORS) {
        return btfi_fail(check->log, check->code, "unknown store %d of the residual", (int)info->store);
    }
    if (info->store == BTF_STORE_FACTORS && !(info->effects & BTF_EFFECT_RESIDUAL)) {
        return btfi_fail(check->log, check->code, "factors without the effect residual");
    }
    if (info->blend != BTF_BLEND_RADIANCE && info->blend != BTF_BLEND_ROOTS) {
        return btfi_fail(check->log, check->code, "unknown blend %d", (int)info->blend);
    }
    if (info->blend == BTF_BLEND_ROOTS && info->domain != BTF_DOMAIN_SQRT) {
        return btfi_fail(check->log, check->code, "blend roots needs domain sqrt");
    }
    if (!(info->horizon_scale >= 1 && info->horizon_scale <= BTFI_PARAMETER_MAX)) {
        return btfi_fail(check->log, check->code, "horizonScale %g is not within 1 to 2^24",
                         (double)info->horizon_scale);
    }
    if (info->store != BTF_STORE_FACTORS && info->horizon_scale != 1) {
        return btfi_fail(check->log, check->code, "horizonScale is %g; without factors it must be 1",
                         (double)info->horizon_scale);
    }
    btf_result result = check_points(check, info);
    result = result ? result : check_relief(check, info);
    return result ? result : check_classes(check, info);
}

static btf_result check_effects(const btfi_check *check, const btf_material_info *info) {
    if (info->effects & ~(uint32_t)BTF_EFFECT_ALL) {
        return btfi_fail(check->log, check->code, "effects 0x%x has unknown bits", (unsigned)info->effects);
    }
    if (info->effects & BTF_EFFECT_HIDDEN) {
        if (info->centres < 1 || info->centres > BTF_MAX_CENTRES) {
            return btfi_fail(check->log, check->code,
                             "centres %u is not within 1 to %d (effect hidden is present)",
                             (unsigned)info->centres, BTF_MAX_CENTRES);
        }
    } else if (info->centres != 0) {
        return btfi_fail(check->log, check->code, "centres %u without the effect hidden",
                         (unsigned)info->centres);
    }
    if (info->effects & BTF_EFFECT_RESIDUAL) {
        if (info->components < 1 || info->components > BTF_MAX_COMPONENTS) {
            return btfi_fail(check->log, check->code,
                             "residual of %u components is not within 1 to %d (effect residual is present)",
                             (unsigned)info->components, BTF_MAX_COMPONENTS);
        }
    } else if (info->components != 0) {
        return btfi_fail(check->log, check->code, "residual of %u components without the effect residual",
                         (unsigned)info->components);
    }
    return BTF_OK;
}

static btf_result check_model(const btfi_check *check, const btf_material_info *info) {
    switch (info->colour) {
    case BTF_COLOUR_MONO:
    case BTF_COLOUR_RGB:
        if (info->lobes < 1 || info->lobes > BTF_MAX_LOBES) {
            return btfi_fail(check->log, check->code, "lobes %u is not within 1 to %d",
                             (unsigned)info->lobes, BTF_MAX_LOBES);
        }
        return BTF_OK;
    case BTF_COLOUR_NONE:
        if (info->lobes != 0) {
            return btfi_fail(check->log, check->code, "lobes is %u; colour none has no lobes",
                             (unsigned)info->lobes);
        }
        if (!(info->effects & BTF_EFFECT_RESIDUAL)) {
            return btfi_fail(check->log, check->code, "colour none without the effect residual");
        }
        return BTF_OK;
    }
    return btfi_fail(check->log, check->code, "unknown colour %d", (int)info->colour);
}

static btf_result check_layout(const btfi_check *check, const btf_material_info *info) {
    const uint32_t aw = info->atlas_width, ah = info->atlas_height;
    if (info->layout == BTF_LAYOUT_TIGHT) {
        if (aw != 0 || ah != 0) {
            return btfi_fail(check->log, check->code, "the atlas is %u x %u; layout tight has no atlas",
                             (unsigned)aw, (unsigned)ah);
        }
        return BTF_OK;
    }
    if (info->layout != BTF_LAYOUT_PAPER) {
        return btfi_fail(check->log, check->code, "unknown layout %d", (int)info->layout);
    }
    if (!is_power_of_two(aw) || !is_power_of_two(ah) || aw < ah || aw > BTF_MAX_SIZE) {
        return btfi_fail(check->log, check->code,
                         "atlas %u x %u: sides must be powers of two, width >= height, width <= %d",
                         (unsigned)aw, (unsigned)ah, BTF_MAX_SIZE);
    }
    btfi_atlas atlas;
    if (!btfi_atlas_plan(info, aw, ah, &atlas)) {
        return btfi_fail(check->log, check->code, "atlas %u x %u cannot hold %u tiles of %u x %u",
                         (unsigned)aw, (unsigned)ah,
                         (unsigned)(info->n_views > info->n_lights ? info->n_views : info->n_lights),
                         (unsigned)info->width, (unsigned)info->height);
    }
    if (info->centres > atlas.room) {
        return btfi_fail(check->log, check->code, "atlas %u x %u has room for %u centres, not for %u",
                         (unsigned)aw, (unsigned)ah, (unsigned)atlas.room, (unsigned)info->centres);
    }
    return BTF_OK;
}

static btf_result check_levels(const btfi_check *check, const btf_material_info *info) {
    uint32_t most = 1;
    while (info->width >> most || info->height >> most) {
        most++;
    }
    if (info->levels < 1 || info->levels > most) {
        return btfi_fail(check->log, check->code, "levels %u is not within 1 to %u (size %u x %u)",
                         (unsigned)info->levels, (unsigned)most, (unsigned)info->width,
                         (unsigned)info->height);
    }
    if (info->levels > 1 && info->layout != BTF_LAYOUT_TIGHT) {
        return btfi_fail(check->log, check->code, "levels is %u; layout paper has one level",
                         (unsigned)info->levels);
    }
    if (info->levels + info->relief_level > BTF_MAX_LEVELS) {
        return btfi_fail(check->log, check->code, "reliefLevel %u and levels %u are more than %d in all",
                         (unsigned)info->relief_level, (unsigned)info->levels, BTF_MAX_LEVELS);
    }
    if (!(info->effects & BTF_EFFECT_RELIEF) && info->relief_end != 0) {
        return btfi_fail(check->log, check->code, "reliefEnd %u without the effect relief",
                         (unsigned)info->relief_end);
    }
    if (info->effects & BTF_EFFECT_RELIEF && (info->relief_end < 1 || info->relief_end > info->levels)) {
        return btfi_fail(check->log, check->code, "reliefEnd %u is not within 1 to %u (levels)",
                         (unsigned)info->relief_end, (unsigned)info->levels);
    }
    return BTF_OK;
}

/* Checks the number of views or lights. `layers`: each has a layer in the textures of these effects. That counts in
 * layout `paper` as well, so that btf_material_to_tight can make the layers. */
static btf_result check_directions(const btfi_check *check, const char *name, uint32_t count, bool layers,
                                   const char *effects) {
    if (count < 1 || count > BTF_MAX_DIRECTIONS) {
        return btfi_fail(check->log, check->code, "%u %s, not 1 to %d", (unsigned)count, name,
                         BTF_MAX_DIRECTIONS);
    }
    if (layers && count > BTF_MAX_DIRECTION_LAYERS) {
        return btfi_fail(check->log, check->code, "%u %s; with the effect %s there are 1 to %d",
                         (unsigned)count, name, effects, BTF_MAX_DIRECTION_LAYERS);
    }
    return BTF_OK;
}

btf_result btfi_check_info(const btfi_check *check, const btf_material_info *info) {
    if (info->width < 1 || info->width > BTF_MAX_SIZE || info->height < 1 || info->height > BTF_MAX_SIZE) {
        return btfi_fail(check->log, check->code, "size %u x %u is not within 1 to %d",
                         (unsigned)info->width, (unsigned)info->height, BTF_MAX_SIZE);
    }
    if (info->domain != BTF_DOMAIN_LINEAR && info->domain != BTF_DOMAIN_SQRT) {
        return btfi_fail(check->log, check->code, "unknown domain %d", (int)info->domain);
    }

    btf_result result;
    if ((result = check_directions(check, "views", info->n_views,
                                   info->effects & (BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN | BTF_EFFECT_GAIN),
                                   "shift, hidden or gain")) ||
        (result = check_directions(check, "lights", info->n_lights, info->effects & BTF_EFFECT_SHADOW,
                                   "shadow")) ||
        (result = check_effects(check, info)) || (result = check_model(check, info)) ||
        (result = check_version_2(check, info)) || (result = check_layout(check, info)) ||
        (result = check_levels(check, info)) ||
        (result = check_scale(check, "radianceScale", info->radiance_scale)) ||
        (result = check_scale(check, "shadowScale", info->shadow_scale)) ||
        (result = check_scale(check, "gainScale", info->gain_scale)) ||
        (result = check_scale(check, "centreScale", info->centre_scale))) {
        return result;
    }

    if (sizeof(size_t) < 8) { /* with 64 bits no material wraps: all need fewer than 2^42 bytes */
        double bytes = 0;
        for (uint32_t level = 0; level < info->levels; level++) {
            for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
                btf_texture t = btf_material_level_shape(info, level, (btf_texture_id)id);
                bytes += (double)t.width * t.height * t.layers * (double)btf_format_size(t.format);
            }
        }
        if (bytes >= 0x1p31) {
            return btfi_fail(check->log, BTF_ERROR_UNSUPPORTED,
                             "%.0f bytes of textures exceed the address space", bytes);
        }
    }
    return BTF_OK;
}
