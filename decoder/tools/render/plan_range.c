/* The scene that a picture is. See plan_range.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "plan_range.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define DEGREE (3.14159265358979323846 / 180)

static const float sector_degrees = 360.0f / PLAN_SECTORS;

/* Directions of a greater z than this have no azimuth to speak of. */
static const float pole_z = 0.9999f;

static void meet(plan_directions *d, const float direction[3]) {
    if (!d->any) {
        memcpy(d->first, direction, sizeof d->first);
        d->z[0] = d->z[1] = direction[2];
    }
    d->any = true;
    d->varies = d->varies || memcmp(d->first, direction, sizeof d->first) != 0;
    d->z[0] = fminf(d->z[0], direction[2]);
    d->z[1] = fmaxf(d->z[1], direction[2]);
    if (direction[2] > pole_z) {
        memset(d->sector, 1, sizeof d->sector);
    } else {
        const double turns = atan2((double)direction[1], (double)direction[0]) / (360 * DEGREE) + 1;
        d->sector[(int)(turns * PLAN_SECTORS) % PLAN_SECTORS] = true;
    }
}

/* Adds the views and levels of one row of samples, whatever lights them. */
static void add_views(int width, const table_sample *samples, plan_range *range) {
    for (int x = 0; x < width; x++) {
        if (!(samples[x].view[2] > 0)) {
            continue;
        }
        const int level = samples[x].level;
        range->level = !range->view.any || level < range->level ? level : range->level;
        meet(&range->view, samples[x].view);
    }
}

/* Adds one light of a row of samples, but where it is below the horizon: there every material decodes to black. */
static void add_light(int width, const float *inputs, const table_sample *samples, plan_range *range) {
    for (int x = 0; x < width; x++) {
        const float *light = inputs + TABLE_INPUTS * x + 5;
        if (samples[x].view[2] > 0 && light[2] > 0) {
            meet(&range->light, light);
        }
    }
}

btf_result plan_range_add(const render_scene *scene, plan_range *range) {
    table_scene table = scene->table;
    table.width = scene->width * scene->samples;
    table.height = scene->height * scene->samples;
    const size_t width = (size_t)table.width;
    table_sample *samples = calloc(width, sizeof *samples);
    float *inputs = calloc(width, TABLE_INPUTS * sizeof *inputs),
          *weights = calloc(width, 3 * sizeof *weights);
    const bool ok = samples && inputs && weights;
    for (int i = 0; i < PLAN_SECTORS && scene->environment; i++) { /* light comes from anywhere */
        const float degrees = sector_degrees * ((float)i + 0.5f);
        const vec3 rim = vec_from_angles(90, (double)degrees);
        const float horizon[3] = {(float)rim.x, (float)rim.y, 0}, normal[3] = {0, 0, 1};
        meet(&range->light, horizon);
        meet(&range->light, normal);
    }
    for (int row = 0; ok && row < table.height; row++) {
        table_cast(&table, row, 1, samples);
        add_views(table.width, samples, range);
        for (size_t l = 0; l < scene->lights->count; l++) {
            table_light(&table, &scene->lights->lights[l], width, samples, inputs, weights);
            add_light(table.width, inputs, samples, range);
        }
    }
    free(weights);
    free(inputs);
    free(samples);
    return ok ? BTF_OK : BTF_ERROR_MEMORY;
}

static void join(plan_directions *d, const plan_directions *other) {
    if (!other->any) {
        return;
    }
    if (!d->any) {
        *d = *other;
        return;
    }
    d->varies = d->varies || other->varies || memcmp(d->first, other->first, sizeof d->first) != 0;
    d->z[0] = fminf(d->z[0], other->z[0]);
    d->z[1] = fmaxf(d->z[1], other->z[1]);
    for (int i = 0; i < PLAN_SECTORS; i++) {
        d->sector[i] = d->sector[i] || other->sector[i];
    }
}

void plan_range_join(plan_range *range, const plan_range *other) {
    if (other->view.any) {
        range->level = range->view.any && range->level < other->level ? range->level : other->level;
    }
    join(&range->view, &other->view);
    join(&range->light, &other->light);
}

/* The azimuths outside the longest run of empty sectors; 0, 0 (all) where no two neighbouring sectors are empty. */
static void azimuths(const plan_directions *d, float phi[2]) {
    int longest = 0, end = 0;
    for (int from = 0; from < PLAN_SECTORS; from++) {
        int length = 0;
        while (length < PLAN_SECTORS && !d->sector[(from + length) % PLAN_SECTORS]) {
            length++;
        }
        if (length > longest) {
            longest = length;
            end = (from + length) % PLAN_SECTORS;
        }
    }
    const float margin = 0.01f;
    phi[0] = phi[1] = 0;
    if (longest < 2) {
        return;
    }
    phi[0] = sector_degrees * (float)end - margin;
    phi[1] = sector_degrees * (float)((end + PLAN_SECTORS - longest) % PLAN_SECTORS) + margin;
}

static btf_range range_of(const plan_directions *d) {
    const double margin = 0.01;
    btf_range range = {0};
    if (!d->any) {
        return range;
    }
    if (!d->varies && d->z[0] > 1e-6f) {
        range.fixed = 1;
        memcpy(range.direction, d->first, sizeof range.direction);
        return range;
    }
    range.theta[0] = (float)fmax(acos(fmin((double)d->z[1], 1)) / DEGREE - margin, 0);
    range.theta[1] = (float)fmin(acos((double)d->z[0]) / DEGREE + margin, 90);
    azimuths(d, range.phi);
    return range;
}

btf_scene plan_range_scene(const plan_range *range) {
    return (btf_scene){.struct_size = sizeof(btf_scene),
                       .view = range_of(&range->view),
                       .light = range_of(&range->light),
                       .pixels = ldexpf(1, -range->level)};
}

/* The least and greatest theta of a range, in degrees, also of one that is fixed or holds all. */
static void elevations(const btf_range *r, double out[2]) {
    const bool all = r->theta[0] == 0 && r->theta[1] == 0;
    out[0] = r->fixed ? acos(fmin((double)r->direction[2], 1)) / DEGREE : (double)r->theta[0];
    out[1] = r->fixed ? out[0] : all ? 90 : (double)r->theta[1];
}

/* The azimuth at which a range begins, and how many degrees it spans; 360: all. */
static void turns(const btf_range *r, double *from, double *length) {
    if (r->fixed) {
        *from = atan2((double)r->direction[1], (double)r->direction[0]) / DEGREE;
        *length = r->direction[2] > pole_z ? 360 : 0;
        return;
    }
    *from = r->phi[0];
    *length = fmod((double)r->phi[1] - (double)r->phi[0] + 720, 360);
    *length = *length > 0 ? *length : 360;
}

btf_range plan_range_widen(const btf_range *range, float degrees) {
    double theta[2];
    elevations(range, theta);
    return (btf_range){.theta = {(float)fmax(degrees * floor((theta[0] - degrees) / degrees), 0),
                                 (float)fmin(degrees * ceil((theta[1] + degrees) / degrees), 90)}};
}

bool plan_range_covers(const btf_range *outer, const btf_range *inner, float slack) {
    if (outer->fixed) {
        return inner->fixed && memcmp(outer->direction, inner->direction, sizeof outer->direction) == 0;
    }
    double theta[2], wide[2], from, length, wide_from, wide_length;
    elevations(inner, theta);
    elevations(outer, wide);
    turns(inner, &from, &length);
    turns(outer, &wide_from, &wide_length);
    if (wide[0] > fmax(theta[0] - slack, 0) || wide[1] < fmin(theta[1] + slack, 90)) {
        return false;
    }
    if (wide_length >= 360) {
        return true;
    }
    const double offset = fmod(from - slack - wide_from + 1080, 360);
    return offset + length + 2 * (double)slack <= wide_length;
}
