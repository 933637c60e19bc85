/* Values of texels in a view. See source.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "source.h"

#include "exact.h"

enum { MOST_PARAMETERS = 16 };

/* Bytes of one layer of a texture with layers, or of one tile of the atlas: those of texel (column, row)
 * begin at first[row * row_step + column * step]. */
typedef struct plane {
    const uint8_t *first;
    size_t row_step, step;
} plane;

/* How a texel is seen in a view. */
typedef struct appearance {
    bool hidden;
    uint32_t centre;       /* where hidden */
    int32_t columns, rows; /* shift, where not hidden */
    float gain;
} appearance;

/* A tile of the atlas of layout paper, from a channel on. */
static plane tile(const btf_evaluator *e, uint32_t index, size_t channel) {
    const uint32_t columns = e->info.atlas_width / e->info.width;
    const size_t column = (size_t)(index % columns) * e->info.width,
                 row = (size_t)(index / columns) * e->info.height;
    return (plane){e->maps + 4 * (row * e->info.atlas_width + column) + channel,
                   4 * (size_t)e->info.atlas_width, 4};
}

static plane layer(const btfi_level *l, const uint8_t *texture, uint32_t index, size_t step) {
    return (plane){texture + (size_t)index * l->width * l->height * step, l->width * step, step};
}

static plane shadow_plane(const btf_evaluator *e, const btfi_level *l, uint32_t light) {
    return e->info.layout == BTF_LAYOUT_TIGHT ? layer(l, l->shadow, light, 1) : tile(e, light, 0);
}

static const uint8_t *at(const plane *of, uint32_t column, uint32_t row) {
    return of->first + row * of->row_step + column * of->step;
}

static uint32_t wrap(uint32_t position, int32_t shift, uint32_t size) {
    int32_t p = (int32_t)position + shift;
    if (p >= 0 && p < (int32_t)size) {
        return (uint32_t)p;
    }
    p %= (int32_t)size;
    return (uint32_t)(p < 0 ? p + (int32_t)size : p);
}

static appearance packed(const btf_evaluator *e, const btfi_way *way, const uint8_t bytes[2]) {
    const uint32_t p = bytes[0] + 256u * bytes[1];
    appearance seen = {false, 0, 0, 0, 1.0f};
    if (way->effects & BTF_EFFECT_SHIFT) {
        seen.columns = (int32_t)(p & 63) - 32;
        seen.rows = (int32_t)(p >> 6 & 63) - 32;
    }
    if (way->effects & BTF_EFFECT_GAIN) {
        seen.gain = e->info.gain_base + (float)(p >> 12) * e->info.gain_step;
    }
    return seen;
}

/* How a point is seen whose gain has this code and whose shift has these bytes; for what the file does not store, the
 * caller hands over 128, 0 and 0. */
static appearance separate(const btf_evaluator *e, const btfi_way *way, uint32_t code, uint32_t byte0,
                           uint32_t byte1) {
    appearance seen = {false, 0, 0, 0, 1.0f};
    if (code == 0) {
        seen.hidden = (way->effects & BTF_EFFECT_HIDDEN) != 0;
        seen.centre = byte0 + 256 * byte1;
        return seen;
    }
    if (way->effects & BTF_EFFECT_SHIFT) {
        seen.columns = (int8_t)byte0;
        seen.rows = (int8_t)byte1;
    }
    if (way->effects & BTF_EFFECT_GAIN) {
        seen.gain = (float)code * e->info.gain_scale;
    }
    return seen;
}

/* Textures that say how a view shows the texels. */
typedef struct point_planes {
    plane gain, shift; /* of packed points in `shift`, of lists the indices */
    bool codes, shifts;
} point_planes;

static point_planes planes_of(const btf_evaluator *e, const btfi_level *l, uint32_t view) {
    const bool tight = e->info.layout == BTF_LAYOUT_TIGHT;
    point_planes out = {.codes = e->info.effects & (BTF_EFFECT_GAIN | BTF_EFFECT_HIDDEN),
                        .shifts = e->info.effects & (BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN)};
    if (e->info.point_store == BTF_POINTS_PACKED) {
        out.shift = layer(l, l->points, view, 2);
    } else if (e->info.point_store == BTF_POINTS_LISTS) {
        out.shift = layer(l, l->point_indices, view / 2, 1);
    } else if (tight) {
        if (out.codes) {
            out.gain = layer(l, l->gain, view, 1);
        }
        if (out.shifts) {
            out.shift = layer(l, l->shifts, view, 2);
        }
    } else if (out.codes || out.shifts) {
        out.gain = tile(e, view, 1);
        out.shift = tile(e, view, 2);
    }
    return out;
}

static appearance look_at(const btf_evaluator *e, const btfi_level *l, const btfi_way *way, uint32_t view,
                          const point_planes *planes, uint32_t column, uint32_t row) {
    if (e->info.point_store == BTF_POINTS_PACKED) {
        return packed(e, way, at(&planes->shift, column, row));
    }
    if (e->info.point_store == BTF_POINTS_LISTS) {
        const uint32_t entry = *at(&planes->shift, column, row) >> view % 2 * 4 & 15;
        const plane entries = layer(l, l->point_lists, entry, 2);
        return packed(e, way, at(&entries, column, row));
    }
    const uint8_t *bytes = planes->shifts ? at(&planes->shift, column, row) : (const uint8_t[2]){0, 0};
    return separate(e, way, planes->codes ? *at(&planes->gain, column, row) : BTF_GAIN_ONE, bytes[0],
                    bytes[1]);
}

/* Prefetches the first cache lines of a row of so many bytes: the machine brings the rest by itself. */
static void await(const void *row, size_t bytes) {
    enum { LINE = 64, MOST_LINES = 8 };
    for (size_t i = 0; i < bytes && i < LINE * MOST_LINES; i += LINE) {
        __builtin_prefetch((const char *)row + i);
    }
}

void btfi_await_points(const btf_evaluator *e, const btfi_level *l, const btfi_situation *s,
                       const btfi_points *const points[3]) {
    const size_t row =
        e->factors_stored ? (size_t)BTFI_UNIT_BYTES * e->info.components : 4 * (size_t)e->info.components;
    const void *first = e->factors_stored ? (const void *)e->w : e->v;
    for (int a = 0; a < s->views.count; a++) {
        const point_planes planes = planes_of(e, l, s->views.index[a]);
        for (int i = 0; i < points[a]->count; i++) {
            if (planes.shifts) {
                await(at(&planes.shift, points[a]->column[i], points[a]->row[i]), 1);
            }
            if (planes.codes && planes.gain.first) {
                await(at(&planes.gain, points[a]->column[i], points[a]->row[i]), 1);
            }
        }
        for (int b = 0; b < s->lights[a].count && first; b++) {
            await((const char *)first +
                      ((size_t)s->views.index[a] * e->info.n_lights + s->lights[a].index[b]) * row,
                  row);
        }
    }
}

/* Prefetches the parameters of a source. */
static void await_source(const btf_evaluator *e, const btfi_level *l, const btfi_sources *sources, int i) {
    const size_t texel = sources->seen.texel[i], texels = (size_t)l->width * l->height;
    if (l->u) {
        await(l->u + texel * e->u_bytes, e->u_bytes);
    }
    if (l->components) {
        await(l->components + texel * e->info.components, e->info.components);
    }
    if (l->sbrdf) {
        const size_t size = e->info.half_float ? 8 : 16;
        const uint32_t layers =
            (e->info.colour == BTF_COLOUR_MONO ? 1 : (3 * (1 + e->info.lobes) + 3) / 4) + e->info.lobes;
        for (uint32_t j = 0; j < layers; j++) {
            await((const char *)l->sbrdf + (j * texels + texel) * size, 1);
        }
    }
    if (e->info.effects & BTF_EFFECT_SHADOW) {
        for (int b = 0; b < sources->seen.lights->count; b++) {
            const plane codes = shadow_plane(e, l, sources->seen.lights->index[b]);
            await(at(&codes, sources->column[i], sources->row[i]), 1);
        }
    }
}

void btfi_find_sources(const btf_evaluator *e, const btfi_level *l, const btfi_way *way,
                       const btfi_situation *s, const btfi_points *const points[3],
                       btfi_sources sources[3]) {
    for (int a = 0; a < s->views.count; a++) {
        btfi_sources *out = &sources[a];
        const uint32_t view = s->views.index[a];
        const point_planes planes = planes_of(e, l, view);
        out->seen.view = view;
        out->seen.lights = &s->lights[a];
        out->seen.count = points[a]->count;
        for (int i = 0; i < points[a]->count; i++) {
            const uint32_t column = points[a]->column[i], row = points[a]->row[i];
            const appearance seen = look_at(e, l, way, view, &planes, column, row);
            out->centre[i] = seen.hidden ? (int32_t)seen.centre : -1;
            out->gain[i] = seen.gain;
            out->column[i] = wrap(column, seen.columns, l->width);
            out->row[i] = wrap(row, seen.rows, l->height);
            out->seen.texel[i] = (size_t)out->row[i] * l->width + out->column[i];
            await_source(e, l, out, i);
        }
    }
}

/* `count` parameters of a texel from a layer of `sbrdf` on, four of each. */
static void read_parameters(const btf_evaluator *e, const btfi_level *l, uint32_t first_layer, size_t texel,
                            uint32_t count, float *out) {
    const size_t texels = (size_t)l->width * l->height;
    for (uint32_t i = 0; i < count; i++) {
        const size_t index = 4 * ((first_layer + i / 4) * texels + texel) + i % 4;
        out[i] = e->info.half_float ? btfi_half(((const uint16_t *)l->sbrdf)[index])
                                    : ((const float *)l->sbrdf)[index];
    }
}

/* Section 9, SBRDF(x', P), of the sources of all views: values [view][point]. */
static void sbrdf(const btf_evaluator *e, const btfi_level *l, const btfi_situation *s,
                  const btfi_sources *sources, float out[3][BTFI_MOST_POINTS][3]) {
    float exponents[BTFI_MOST_POWERS], q[BTFI_MOST_POWERS];
    const float *product = s->product;
    const bool mono = e->info.colour == BTF_COLOUR_MONO;
    const uint32_t lobes = e->info.lobes, weights = mono ? 4 : 3 * (1 + lobes);
    int count = 0;
    for (int a = 0; a < s->views.count; a++) {
        for (int i = 0; i < sources[a].seen.count; i++) {
            for (uint32_t j = 0; j < lobes; j++, count++) {
                float c[4];
                read_parameters(e, l, (weights + 3) / 4 + j, sources[a].seen.texel[i], 4, c);
                q[count] = c[0] * product[0] + c[1] * product[1] + c[2] * product[2];
                exponents[count] = c[3];
            }
        }
    }
    for (int i = count; i % 8 != 0; i++) {
        q[i] = exponents[i] = 0.0f;
    }
    e->kernels->powers(count, exponents, q);
    const float *power = q;
    for (int a = 0; a < s->views.count; a++) {
        for (int i = 0; i < sources[a].seen.count; i++, power += lobes) {
            float of[MOST_PARAMETERS], *f = out[a][i];
            read_parameters(e, l, 0, sources[a].seen.texel[i], weights, of);
            if (mono) {
                float sum = of[3];
                for (uint32_t j = 0; j < lobes; j++) {
                    sum = sum + power[j];
                }
                for (int c = 0; c < 3; c++) {
                    f[c] = of[c] * sum;
                }
                continue;
            }
            for (int c = 0; c < 3; c++) {
                f[c] = of[c];
                for (uint32_t j = 0; j < lobes; j++) {
                    f[c] = f[c] + of[3 * (1 + j) + (uint32_t)c] * power[j];
                }
            }
        }
    }
}

/* Weakens h by the shadow of each point. */
static void shade(const btf_evaluator *e, const btfi_level *l, const btfi_sources *sources, float h[][3]) {
    const btfi_neighbours *lights = sources->seen.lights;
    const float scale = e->info.shadow_scale * 0x1p-12f;
    plane codes[3] = {{0}};
    for (int b = 0; b < lights->count; b++) {
        codes[b] = shadow_plane(e, l, lights->index[b]);
    }
    for (int i = 0; i < sources->seen.count; i++) {
        int32_t sum = 0;
        for (int b = 0; b < lights->count; b++) {
            sum += lights->weight[b] * *at(&codes[b], sources->column[i], sources->row[i]);
        }
        const float shadow = (float)sum * scale;
        for (int c = 0; c < 3; c++) {
            h[i][c] = h[i][c] * shadow;
        }
    }
}

static void centre_value(const btf_evaluator *e, const btfi_neighbours *lights, uint32_t centre,
                         float out[3]) {
    int32_t sum[3] = {0, 0, 0};
    for (int b = 0; b < lights->count; b++) {
        const uint8_t *code =
            e->centre_texels + 4 * (e->centre_at[centre] + lights->index[b] * e->centre_step);
        for (int c = 0; c < 3; c++) {
            sum[c] += lights->weight[b] * code[c];
        }
    }
    for (int c = 0; c < 3; c++) {
        out[c] = (float)sum[c] * (e->info.centre_scale * 0x1p-12f);
    }
}

/* Turns y before the gain into the value that is blended, a root or radiance. */
static void finish(const btf_evaluator *e, const btfi_sources *sources, int i, float y[3]) {
    const bool roots = e->info.blend == BTF_BLEND_ROOTS;
    if (sources->centre[i] >= 0) {
        centre_value(e, sources->seen.lights, (uint32_t)sources->centre[i], y);
        for (int c = 0; c < 3; c++) {
            y[c] = roots ? y[c] : y[c] * y[c];
        }
        return;
    }
    for (int c = 0; c < 3; c++) {
        const float value = y[c] * sources->gain[i];
        if (roots) {
            y[c] = value > 0x1p32f ? 0x1p32f : value < -0x1p32f ? -0x1p32f : value;
        } else {
            const float kept = btfi_keep_within(value);
            y[c] = e->info.domain == BTF_DOMAIN_SQRT ? kept * kept : kept;
        }
    }
}

void btfi_view_values(const btf_evaluator *e, const btfi_level *l, const btfi_way *way,
                      const btfi_situation *s, const btfi_sources sources[3],
                      float out[3][BTFI_MOST_POINTS][3]) {
    const bool residual = way->effects & BTF_EFFECT_RESIDUAL;
    if (e->modelled) {
        sbrdf(e, l, s, sources, out);
    }
    for (int a = 0; a < s->views.count; a++) {
        float r[BTFI_MOST_POINTS][3] = {{0}};
        if (e->modelled && way->effects & BTF_EFFECT_SHADOW) {
            shade(e, l, &sources[a], out[a]);
        }
        if (residual && e->factors_stored) {
            e->kernels->factors(e, l, way->components, &sources[a].seen, r);
        } else if (residual) {
            e->kernels->components(e, l, way->components, &sources[a].seen, r);
        }
        for (int i = 0; i < sources[a].seen.count; i++) {
            float *y = out[a][i];
            for (int c = 0; c < 3; c++) {
                const float h = e->modelled ? y[c] : 0.0f;
                if (residual && !e->factors_stored) {
                    y[c] = (e->modelled ? h + r[i][c] : r[i][c]) * s->cosine;
                } else if (residual && !e->modelled) {
                    y[c] = r[i][c] * s->horizon;
                } else {
                    y[c] = residual ? h * s->cosine + r[i][c] * s->horizon : h * s->cosine;
                }
            }
            finish(e, &sources[a], i, y);
        }
    }
}
