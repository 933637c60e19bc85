/* Counts of fetches, bytes and operations. See decode_cost.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decode_cost.h"

#include <stdbool.h>

/* How a material is decoded, in numbers. */
typedef struct way {
    int views, lights, texels;
    uint32_t effects;
    bool fast;
} way;

static way way_of(const btf_material_info *info, const btf_shader_options *shader) {
    const bool nearest = shader->interpolation == BTF_INTERPOLATION_NEAREST;
    return (way){.views = nearest || shader->fixed & BTF_FIXED_VIEW ? 1 : 3,
                 .lights = nearest || shader->fixed & BTF_FIXED_LIGHT ? 1 : 3,
                 .texels = shader->filter == BTF_FILTER_TEXEL ? 1 : 4,
                 .effects = info->effects & ~shader->leave_out,
                 .fast = shader->math == BTF_MATH_FAST};
}

static void fetch(decode_cost *cost, double count, double bytes) {
    cost->fetches += count;
    cost->bytes += count * bytes;
}

/* Shift, gain and hidden codes of each view and texel. */
static void add_codes(decode_cost *cost, const btf_material_info *info, const way *w) {
    const bool shift = w->effects & (BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN),
               code = w->effects & (BTF_EFFECT_GAIN | BTF_EFFECT_HIDDEN) ||
                      (w->effects & BTF_EFFECT_SHIFT && info->effects & BTF_EFFECT_HIDDEN);
    const double points = w->views * w->texels;
    if (info->point_store == BTF_POINTS_LISTS) { /* the index, then what it names */
        fetch(cost, shift || code ? points : 0, 1);
        fetch(cost, shift || code ? points : 0, 2);
    } else if (info->point_store == BTF_POINTS_PACKED) {
        fetch(cost, shift || code ? points : 0, 2);
    } else if (info->layout == BTF_LAYOUT_PAPER) {
        fetch(cost, shift || code ? points : 0, 4);
    } else {
        fetch(cost, code ? points : 0, 1);
        fetch(cost, shift ? points : 0, 2);
    }
}

/* pow of FORMAT.md section 8: log2 has 18 float operations and 4 of integers, the product 1, exp2 16 and 2.
 * Natively three: log2, product, exp2. */
static void add_pow(decode_cost *cost, double count, bool fast) {
    cost->floats += count * (fast ? 3 : 35);
    cost->integers += count * (fast ? 0 : 6);
}

/* Lobe: a dot product of three factors, its power, and 1 (mono) or 3 x 2 (rgb) operations of its colour. */
static void add_sbrdf(decode_cost *cost, const btf_material_info *info, const way *w) {
    const double points = w->views * w->texels, lobes = info->lobes;
    const bool mono = info->colour == BTF_COLOUR_MONO;
    if (info->colour == BTF_COLOUR_NONE) {
        return;
    }
    fetch(cost, points * (mono ? 1 + lobes : (3 + 3 * info->lobes + 3) / 4 + lobes),
          info->half_float ? 8 : 16);
    add_pow(cost, points * lobes, w->fast);
    cost->floats += points * (lobes * (5 + (mono ? 1 : 6)) + (mono ? 3 : 0));
    if (w->effects & BTF_EFFECT_SHADOW) {
        fetch(cost, points * w->lights, info->layout == BTF_LAYOUT_PAPER ? 4 : 1);
        cost->integers += points * 2 * w->lights;
        cost->floats += points * 5;
    }
}

/* A group of four components in a view: integers are summed over lights, 12 a texel of V, once for all
 * texels, which share the conversion of the 12 sums and of the 4 scales; then 4 + 4 + 12 + 12 operations.
 */
static void add_components(decode_cost *cost, int components, const way *w) {
    const double groups = (components + 3) / 4 * w->views;
    fetch(cost, groups * 3 * w->lights, 4);
    fetch(cost, groups, 16);
    fetch(cost, groups * w->texels, 4);
    cost->integers += groups * 24 * w->lights;
    cost->floats += groups * (16 + 32 * w->texels);
}

/* Of a class of factors: how many shifts bring out the codes of w, operations that expand a word of u,
 * multiply a word of w with it (the masks, shifts, products and sums of s shifts: 4 s - 1), and take the
 * dot product of a whole unit or of a word out. Class 0 has signed bytes: 7 operations unpack a word. */
typedef struct class_cost {
    int steps, expand, product, unit, word, layers, tier;
    bool shifted;
} class_cost;

static const class_cost classes[BTF_FACTOR_CLASSES] = {{4, 7, 14, 0, 0, 1, 0, true},
                                                       {4, 5 * 4 - 2 + 5, 15, 7, 2, 2, 1, true},
                                                       {4, 5 * 4 - 1 + 5, 15, 5, 2, 1, 1, true},
                                                       {8, 5 * 8 - 2 + 5, 31, 5, 2, 2, 2, false},
                                                       {4, 5 * 4 - 1 + 5, 15, 11, 2, 1, 2, false}};

/* One unit, evaluated whole or word by word, in `views` views for one u a texel, or one a texel and view. */
static void add_unit(decode_cost *cost, const class_cost *c, bool mixed, int views, int of_u,
                     const way *w) {
    const int sums = mixed ? 4 : 1, blend = 2 * w->lights + c->shifted;
    fetch(cost, views * w->lights + c->layers * w->texels * of_u + 1, 16);
    cost->floats += sums;
    cost->integers += w->texels * of_u * 4.0 * c->expand;
    const double dot = 4 * c->product + (mixed ? 4 * c->word : c->unit);
    cost->integers += w->texels * views * (w->lights * dot + sums * blend);
    cost->floats += w->texels * views * 3.0 * sums;
}

static int units_of_words(uint32_t words, int units) {
    const int whole = (int)((words + 3) / 4);
    return whole < units ? whole : units;
}

/* u is fetched and expanded once for all views, but where they have sources of their own: with shift alone view after
 * view, with relief in one round. A tier has three
 * factors of its view, and the channels take 6 operations. */
static void add_factors(decode_cost *cost, const btf_material_info *info, int units, const way *w) {
    const bool relief = w->effects & BTF_EFFECT_RELIEF, apart = w->effects & BTF_EFFECT_SHIFT && !relief;
    const int rounds = apart ? w->views : 1, views = apart ? 1 : w->views;
    int tiers[3] = {0};
    for (int c = 0; c < BTF_FACTOR_CLASSES; c++) {
        const int most = (int)info->factor_classes[c][0], here = most < units ? most : units;
        const int mixed =
            c == 0 ? here : units_of_words(info->factor_classes[c][1] + info->factor_classes[c][2], here);
        for (int i = 0; i < rounds * here; i++) {
            add_unit(cost, &classes[c], i < rounds * mixed, views, relief ? views : 1, w);
        }
        tiers[classes[c].tier] += here;
        units -= here;
    }
    for (int t = 0; t < 3; t++) {
        if (tiers[t] > 0) {
            fetch(cost, w->views, 16);
            cost->floats += w->views * w->texels * 6.0;
        }
    }
    cost->floats += w->views * w->texels * 6.0;
}

/* A vector of each view; a march of the pixel and, where views are interpolated, one of each of them, whole ones: a step
 * moves (4 operations and 2 to wrap), and compares a height of 3. */
static void add_relief(decode_cost *cost, const btf_material_info *info, const way *w) {
    if (w->effects & (BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS)) {
        fetch(cost, w->views, 16);
    }
    if (!(w->effects & BTF_EFFECT_RELIEF) || info->relief_step == 0) {
        return;
    }
    const double steps = (info->relief_steps + 1.0) * (w->views > 1 ? 1 + w->views : 1);
    fetch(cost, steps, 1);
    cost->integers += steps * 13;
}

decode_cost decode_cost_of(const btf_material_info *info, const btf_shader_options *shader) {
    const way w = way_of(info, shader);
    const uint32_t most = info->components;
    const int components =
        (int)(shader->components > 0 && shader->components < most ? shader->components : most);
    decode_cost cost = {0};
    add_codes(&cost, info, &w);
    add_sbrdf(&cost, info, &w);
    add_relief(&cost, info, &w);
    if (w.effects & BTF_EFFECT_RESIDUAL && info->store == BTF_STORE_FACTORS) {
        add_factors(&cost, info, components, &w);
    } else if (w.effects & BTF_EFFECT_RESIDUAL) {
        add_components(&cost, components, &w);
    }
    return cost;
}

decode_cost decode_cost_pca(int rank) {
    const double groups = (rank + 3) / 4;
    decode_cost cost = {0};
    fetch(&cost, groups * 28, 4);
    fetch(&cost, groups, 16);
    /* U: converted, scaled; each texel of V: converted, weighted, added; three dot products, added. */
    cost.floats = groups * (8 + 27 * 12 + 3 * 8);
    return cost;
}

decode_cost decode_cost_lookup(void) {
    decode_cost cost = {0};
    fetch(&cost, 9, 4);
    cost.floats = 9 * 6;
    return cost;
}

decode_cost decode_cost_phong(void) {
    decode_cost cost = {0};
    fetch(&cost, 2, 4);
    /* The normal unpacked and normalised 12, two dot products 10, reflection 9, power 3, colour 8. */
    cost.floats = 42;
    return cost;
}
