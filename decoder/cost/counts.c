/* OpenBTF: counts of a decode. See counts.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "counts.h"
#include "decoder/fold/fold.h"
#include "decoder/shape.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

/* How a material is decoded, in numbers. */
typedef struct way {
    uint32_t views, skipped, lights, texels;
    uint32_t effects, components;
    bool fast, stochastic, fixed_view, fixed_light;
} way;

static way way_of(const btf_material_info *info, const btf_shader_options *o, const btfi_around *around) {
    const uint32_t effects = info->effects & ~o->leave_out;
    const bool residual = effects & BTF_EFFECT_RESIDUAL;
    const uint32_t most = info->components;
    return (way){.views = around->views,
                 .skipped = around->skipped,
                 .lights = o->picks >= BTF_PICK_LIGHT ? 1 : around->lights,
                 .texels = o->filter == BTF_FILTER_TEXEL || o->picks == BTF_PICK_ALL ? 1 : 4,
                 .effects = effects,
                 .components = !residual                               ? 0
                               : o->components && o->components < most ? o->components
                                                                       : most,
                 .fast = o->math == BTF_MATH_FAST,
                 .stochastic = o->picks != BTF_PICK_NONE,
                 .fixed_view = o->fixed & BTF_FIXED_VIEW,
                 .fixed_light = o->fixed & BTF_FIXED_LIGHT && !(effects & BTF_EFFECT_GLOSS)};
}

static void fetch(btf_decode_counts *n, double count, double bytes) {
    n->fetches += count;
    n->bytes += count * bytes;
}

/* Counts the codes of shift, gain and hidden points of each view and texel. They are read twice where factors are
 * decoded along a relief, since the sources of all views are found beforehand. */
static void add_codes(btf_decode_counts *n, const btf_material_info *info, const way *w) {
    const bool shift = w->effects & (BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN),
               code = w->effects & (BTF_EFFECT_GAIN | BTF_EFFECT_HIDDEN) ||
                      (w->effects & BTF_EFFECT_SHIFT && info->effects & BTF_EFFECT_HIDDEN);
    const bool twice = w->effects & BTF_EFFECT_RELIEF && w->components > 0 &&
                       info->store == BTF_STORE_FACTORS && !w->stochastic;
    const double points = (double)w->views * w->texels * (twice ? 2 : 1);
    if (info->point_store == BTF_POINTS_LISTS) { /* the index, then what it names */
        fetch(n, shift || code ? points : 0, 1);
        fetch(n, shift || code ? points : 0, 2);
    } else if (info->point_store == BTF_POINTS_PACKED) {
        fetch(n, shift || code ? points : 0, 2);
    } else if (info->layout == BTF_LAYOUT_PAPER) {
        fetch(n, shift || code ? points : 0, 4);
    } else {
        fetch(n, code ? points : 0, 1);
        fetch(n, shift ? points : 0, 2);
    }
    if (w->effects & BTF_EFFECT_HIDDEN) {
        fetch(n, (double)w->views * w->texels * w->lights, 4);
    }
}

/* pow of FORMAT.md section 8: log2 has 18 float operations and 4 of integers, the product 1, exp2 16 and 2.
 * Natively three: log2, product, exp2. */
static void add_pow(btf_decode_counts *n, double count, bool fast) {
    n->floats += count * (fast ? 3 : 35);
    n->integers += count * (fast ? 0 : 6);
}

/* Lobe: a dot product of three factors, its power, and 1 (mono) or 3 x 2 (rgb) operations of its colour. */
static void add_sbrdf(btf_decode_counts *n, const btf_material_info *info, const way *w) {
    const double points = (double)w->views * w->texels, lobes = info->lobes;
    const bool mono = info->colour == BTF_COLOUR_MONO;
    if (info->colour == BTF_COLOUR_NONE) {
        return;
    }
    fetch(n, points * (mono ? 1 + lobes : (3 + 3 * info->lobes + 3) / 4 + lobes),
          info->half_float ? 8 : 16);
    add_pow(n, points * lobes, w->fast);
    n->floats += points * (lobes * (5 + (mono ? 1 : 6)) + (mono ? 3 : 0));
    if (w->effects & BTF_EFFECT_SHADOW) {
        fetch(n, points * w->lights, info->layout == BTF_LAYOUT_PAPER ? 4 : 1);
        n->integers += points * 2 * w->lights;
        n->floats += points * 5;
    }
}

/* A group of four components in a view: integers are summed over lights, 12 a texel of V, once for all
 * texels, which share the conversion of the 12 sums and of the 4 scales; then 4 + 4 + 12 + 12 operations.
 * A rasteriser that masks saves views of weight 0 where the groups are a loop, all but its first turn. */
static void add_components(btf_decode_counts *n, const way *w) {
    enum { UNROLLED = 6 };
    const uint32_t groups = (w->components + 3) / 4;
    const double turns = groups > UNROLLED ? (double)(w->views - w->skipped) * groups + w->skipped
                                           : (double)w->views * groups;
    fetch(n, turns * 3 * w->lights, 4);
    fetch(n, turns, 16);
    fetch(n, turns * w->texels, 4);
    n->integers += turns * 24 * w->lights;
    n->floats += turns * (16 + 32.0 * w->texels);
}

/* Counts for a class of factors of the operations that expand a word of u; that take the codes out of a word of w, once
 * for all texels (a shift and a mask for each of s shifts); that multiply them with u (products and sums: 2 s - 1); and
 * that take the dot product of a whole unit, or of a word, out of the sum. Class 0 has signed bytes: 7 operations
 * unpack a word. */
typedef struct class_counts {
    uint32_t expand, codes, product, unit, word, layers, tier;
    bool shifted;
} class_counts;

static const class_counts classes[BTF_FACTOR_CLASSES] = {{7, 7, 7, 0, 0, 1, 0, true},
                                                         {5 * 4 - 2 + 5, 8, 7, 7, 2, 2, 1, true},
                                                         {5 * 4 - 1 + 5, 8, 7, 5, 2, 1, 1, true},
                                                         {5 * 8 - 2 + 5, 16, 15, 5, 2, 2, 2, false},
                                                         {5 * 4 - 1 + 5, 8, 7, 11, 2, 1, 2, false}};

/* One unit, evaluated whole or word by word, in `views` views for one u a texel, or one a texel and view. */
static void add_unit(btf_decode_counts *n, const class_counts *c, bool mixed, uint32_t views, uint32_t of_u,
                     const way *w) {
    const double sums = mixed ? 4 : 1, blend = 2.0 * w->lights + c->shifted;
    const double texels = w->texels;
    fetch(n, views * w->lights + c->layers * texels * of_u + 1, 16);
    n->floats += sums;
    n->integers += texels * of_u * 4 * c->expand;
    n->integers += views * w->lights * 4.0 * c->codes;
    const double dot = 4.0 * c->product + (mixed ? 4 * c->word : c->unit);
    n->integers += texels * views * (w->lights * dot + sums * blend);
    n->floats += texels * views * 3 * sums;
}

static uint32_t units_of_words(uint32_t words, uint32_t units) {
    const uint32_t whole = (words + 3) / 4;
    return whole < units ? whole : units;
}

/* Whether views are evaluated one after another, behind the branch that passes over those of weight 0. */
static bool is_apart(const way *w) {
    return w->stochastic || (w->effects & BTF_EFFECT_SHIFT && !(w->effects & BTF_EFFECT_RELIEF));
}

/* u is fetched and expanded once for all views, unless these have sources of their own: then view after view with shift
 * alone, and all in one round with relief. A tier has three factors of its view, and the channels take 6 operations. */
static void add_factors(btf_decode_counts *n, const btf_material_info *info, const way *w) {
    const bool relief = w->effects & BTF_EFFECT_RELIEF, apart = is_apart(w);
    const uint32_t rounds = apart ? w->views : 1, views = apart ? 1 : w->views;
    uint32_t tiers[3] = {0}, units = w->components;
    for (int c = 0; c < BTF_FACTOR_CLASSES; c++) {
        const uint32_t most = info->factor_classes[c][0], here = most < units ? most : units;
        const uint32_t mixed =
            c == 0 ? here : units_of_words(info->factor_classes[c][1] + info->factor_classes[c][2], here);
        for (uint32_t i = 0; i < rounds * here; i++) {
            add_unit(n, &classes[c], i < rounds * mixed, views, relief ? views : 1, w);
        }
        tiers[classes[c].tier] += here;
        units -= here;
    }
    for (int t = 0; t < 3; t++) {
        if (tiers[t] > 0) {
            fetch(n, w->views, 16);
            n->floats += 6.0 * w->views * w->texels;
        }
    }
    n->floats += 6.0 * w->views * w->texels;
}

/* The vectors of `views` views. Along a relief the pixel marches once, whichever its filter, and where there are
 * several views each once. Gloss moves the light for each of the views that are evaluated, by 95 operations and a
 * power. */
static void add_between(btf_decode_counts *n, const btf_material_info *info, const way *w, uint32_t views) {
    if (w->effects & BTFI_VECTOR_EFFECTS) {
        fetch(n, views, 16);
    }
    if (w->effects & BTF_EFFECT_RELIEF) {
        n->moves += 1 + views;
        if (info->relief_step > 0) {
            n->steps += (info->relief_steps + 1.0) * (views > 1 ? 1 + views : 1);
        }
    }
    if (w->effects & BTF_EFFECT_GLOSS) {
        n->floats += 60.0 * w->views;
        add_pow(n, w->views, w->fast);
    }
}

/* A texel of 16 bytes is kept for each view, or for all together; of sums of products one for every two views as well,
 * which takes 12 operations to find and 8 to add. */
static btf_decode_counts count_folded(const btf_material_info *info, const btf_shader_options *o,
                                      const way *all) {
    const btf_material_info shown = btfi_folded_info(info, o->fold);
    const bool both = o->fold == BTF_FOLD_BOTH;
    way w = *all;
    w.effects = shown.effects & ~o->leave_out;
    w.views = both ? 1 : w.views;
    btf_decode_counts n = {
        .pixels = 1, .look_ups = both || w.fixed_view ? 0 : 1, .points = (double)w.views * w.texels};
    fetch(&n, n.points, 16);
    if (o->fold == BTF_FOLD_SUM && info->blend == BTF_BLEND_ROOTS) {
        const double pairs = w.views * (w.views - 1) / 2.0 * w.texels;
        fetch(&n, pairs, 16);
        n.integers += 12 * pairs;
        n.floats += 8 * pairs;
    }
    add_between(&n, &shown, &w, w.views);
    return n;
}

btf_decode_counts btfi_count_decode(const btf_material_info *info, const btf_shader_options *o,
                                    const btfi_around *around) {
    way w = way_of(info, o, around);
    if (o->fold != BTF_FOLD_NONE) {
        return count_folded(info, o, &w);
    }
    const uint32_t codes = BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN | BTF_EFFECT_GAIN;
    const bool gloss = w.effects & BTF_EFFECT_GLOSS,
               lit = w.components > 0 || w.effects & BTF_EFFECT_HIDDEN ||
                     (info->colour != BTF_COLOUR_NONE && w.effects & BTF_EFFECT_SHADOW);
    const uint32_t marched = w.views;
    /* Where the views are constants, compilers see that their values are the same, and decode once. */
    if (w.stochastic ||
        (w.fixed_view && !(w.effects & (codes | BTFI_VECTOR_EFFECTS)) && w.components == 0)) {
        w.views = 1;
        w.skipped = 0;
    }
    btf_decode_counts n = {.pixels = 1, .points = (double)w.views * w.texels};
    n.look_ups = (w.fixed_view ? 0 : 1) + (!lit || w.fixed_light ? 0 : gloss ? w.views : 1);
    if (!lit) {
        w.effects &= ~(uint32_t)BTF_EFFECT_GLOSS;
    }
    add_codes(&n, info, &w);
    add_between(&n, info, &w, marched);
    if (w.components > 0 && info->store == BTF_STORE_FACTORS && !is_apart(&w)) {
        add_factors(&n, info, &w);
    }
    const double before = n.integers + n.floats;
    add_sbrdf(&n, info, &w);
    if (w.components > 0 && info->store == BTF_STORE_FACTORS && is_apart(&w)) {
        add_factors(&n, info, &w);
    } else if (w.components > 0 && info->store == BTF_STORE_COMPONENTS) {
        add_components(&n, &w);
    }
    n.masked = w.stochastic ? 0 : n.integers + n.floats - before;
    return n;
}

btf_decode_counts btf_count_decode(const btf_material_info *info, const btf_shader_options *options) {
    btf_shader_options o = {.struct_size = sizeof o};
    if (options) {
        memcpy(&o, options, options->struct_size < sizeof o ? options->struct_size : sizeof o);
    }
    const bool nearest = o.interpolation == BTF_INTERPOLATION_NEAREST,
               gloss = info->effects & ~o.leave_out & BTF_EFFECT_GLOSS;
    const btfi_around around = {.views = nearest || o.fixed & BTF_FIXED_VIEW ? 1 : 3,
                                .lights = nearest || (o.fixed & BTF_FIXED_LIGHT && !gloss) ? 1 : 3};
    return btfi_count_decode(info, &o, &around);
}
