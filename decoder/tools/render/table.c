/* The ray-cast table.
 *
 * SPDX-License-Identifier: MIT
 */
#include "table.h"

/* Lowest view.z that a visible point may have. */
#define LOWEST_VIEW 1e-3

camera_frame camera_get_frame(const camera *c) {
    camera_frame f = {.half = 1 / c->zoom};
    f.back = vec_from_angles(c->theta, c->phi);
    /* +y up; from straight above or below, where y says nothing, the limit along phi */
    vec3 up = vec_sub(vec(0, 1, 0), vec_mul(f.back, f.back.y));
    f.up = vec_length(up) > 1e-6 ? vec_unit(up, vec(0, 1, 0)) : vec(0, 0, f.back.y > 0 ? -1 : 1);
    f.right = vec_cross(f.up, f.back);
    f.distance = c->fov > 0 ? f.half / tan(c->fov * (RENDER_PI / 360)) : 0;
    return f;
}

static void primary_ray(const table_scene *s, const camera_frame *f, double x, double y, vec3 *origin,
                        vec3 *direction) {
    const double smaller = s->width < s->height ? s->width : s->height;
    double px = (2 * (x + 0.5) - s->width) / smaller * f->half;
    double py = (s->height - 2 * (y + 0.5)) / smaller * f->half;
    vec3 target = vec_add(vec_mul(f->right, px), vec_mul(f->up, py));
    *origin = f->distance > 0 ? vec_mul(f->back, f->distance) : vec_add(target, vec_mul(f->back, 1000));
    *direction = f->distance > 0 ? vec_unit(vec_sub(target, *origin), vec(0, 0, -1)) : vec_mul(f->back, -1);
}

/* Interpolates an attribute of the corners at the hit. */
static double blend(const bvh_hit *h, float a, float b, float c) {
    return (double)a + h->b * ((double)b - (double)a) + h->c * ((double)c - (double)a);
}

static vec3 blend3(const bvh_hit *h, const float *a, const float *b, const float *c) {
    return vec(blend(h, a[0], b[0], c[0]), blend(h, a[1], b[1], c[1]), blend(h, a[2], b[2], c[2]));
}

static float fraction(double c) {
    float f = (float)(c - floor(c));
    return f < 1 ? f : 0;
}

/* The length of the step of uv, in texels, from the hit to where another ray meets the plane of the triangle; infinite
 * where it does not. */
static double footprint(const table_scene *s, const bvh_hit *h, vec3 at, vec3 origin, vec3 direction) {
    const uint32_t *t = s->mesh->triangles + 3 * (size_t)h->triangle;
    const mesh_vertex *a = s->mesh->vertices + t[0], *b = s->mesh->vertices + t[1],
                      *c = s->mesh->vertices + t[2];
    const vec3 pa = vec_from(a->position), ab = vec_sub(vec_from(b->position), pa),
               ac = vec_sub(vec_from(c->position), pa), face = vec_cross(ab, ac);
    const double along = vec_dot(direction, face), area = vec_dot(face, face);
    const double distance = vec_dot(vec_sub(at, origin), face) / along;
    if (!(area > 0) || !(distance > 0) || !isfinite(distance)) {
        return INFINITY;
    }
    const vec3 step = vec_sub(vec_add(origin, vec_mul(direction, distance)), at);
    const double wb = vec_dot(vec_cross(step, ac), face) / area,
                 wc = vec_dot(vec_cross(ab, step), face) / area;
    double length = 0;
    for (int k = 0; k < 2; k++) {
        const double d =
            (wb * ((double)b->uv[k] - (double)a->uv[k]) + wc * ((double)c->uv[k] - (double)a->uv[k])) *
            s->repeat[k] * s->texels[k];
        length += d * d;
    }
    return sqrt(length);
}

static int find_level(const table_scene *s, const camera_frame *f, int x, int y, vec3 at,
                      const bvh_hit *h) {
    const int last = s->levels - 1;
    if (s->level >= 0 || last <= 0) {
        return s->level > 0 ? s->level : 0;
    }
    double longest = 1;
    for (int axis = 0; axis < 2; axis++) {
        vec3 origin, direction;
        primary_ray(s, f, x + (axis == 0), y + (axis == 1), &origin, &direction);
        longest = fmax(longest, footprint(s, h, at, origin, direction));
    }
    const double level = floor(log2(longest) + 0.5);
    return level < last ? (int)level : last;
}

static void fill(const table_scene *s, vec3 to_viewer, vec3 at, const bvh_hit *h, table_sample *out) {
    const uint32_t *t = s->mesh->triangles + 3 * (size_t)h->triangle;
    const mesh_vertex *a = s->mesh->vertices + t[0], *b = s->mesh->vertices + t[1],
                      *c = s->mesh->vertices + t[2];
    vec3 pa = vec_from(a->position);
    vec3 face = vec_cross(vec_sub(vec_from(b->position), pa), vec_sub(vec_from(c->position), pa));
    vec3 n = vec_unit(blend3(h, a->normal, b->normal, c->normal), vec_unit(face, vec(0, 0, 1)));
    vec3 tangent = blend3(h, a->tangent, b->tangent, c->tangent);
    tangent = vec_unit(vec_sub(tangent, vec_mul(n, vec_dot(n, tangent))), vec_perpendicular(n));
    vec3 bitangent = vec_mul(vec_cross(n, tangent), a->tangent[3] < 0 ? -1 : 1);
    if (vec_dot(face, n) < 0) {
        face = vec_mul(face, -1);
    }
    if (vec_dot(face, to_viewer) < 0) {
        n = vec_mul(n, -1);
    }
    vec3 view = vec(vec_dot(to_viewer, tangent), vec_dot(to_viewer, bitangent), vec_dot(to_viewer, n));
    if (view.z < LOWEST_VIEW) {
        view.z = LOWEST_VIEW;
    }
    view = vec_unit(view, vec(0, 0, 1));
    out->uv[0] = fraction(blend(h, a->uv[0], b->uv[0], c->uv[0]) * s->repeat[0]);
    out->uv[1] = fraction(blend(h, a->uv[1], b->uv[1], c->uv[1]) * s->repeat[1]);
    vec_store(view, out->view);
    vec_store(at, out->position);
    vec_store(tangent, out->tangent);
    vec_store(bitangent, out->bitangent);
    vec_store(n, out->normal);
}

void table_cast(const table_scene *scene, int first_row, int rows, table_sample *out) {
    const camera_frame frame = camera_get_frame(&scene->camera);
#pragma omp parallel for schedule(dynamic, 4) num_threads(scene->threads)
    for (int row = 0; row < rows; row++) {
        for (int x = 0; x < scene->width; x++) {
            table_sample *sample = out + (size_t)row * (size_t)scene->width + (size_t)x;
            vec3 origin, direction;
            bvh_hit hit;
            *sample = (table_sample){0};
            primary_ray(scene, &frame, x, first_row + row, &origin, &direction);
            if (bvh_trace(scene->bvh, origin, direction, 0, INFINITY, &hit)) {
                const vec3 at = vec_add(origin, vec_mul(direction, hit.t));
                fill(scene, vec_mul(direction, -1), at, &hit, sample);
                sample->level = find_level(scene, &frame, x, first_row + row, at, &hit);
            }
        }
    }
}

static bool blocked(const table_scene *s, const table_sample *sample, vec3 to_light, double distance) {
    const double start = 4e-3; /* clear of the facets round the point */
    bvh_hit hit;
    vec3 origin = vec_add(vec_from(sample->position), vec_mul(vec_from(sample->normal), start));
    return bvh_trace(s->bvh, origin, to_light, 0, distance, &hit);
}

bool table_is_shadowed(const table_scene *scene, const table_sample *sample, vec3 to_light) {
    return blocked(scene, sample, to_light, INFINITY);
}

void table_set_sample(const table_sample *sample, float *inputs) {
    for (int k = 0; k < 2; k++) {
        inputs[k] = sample->uv[k];
    }
    for (int k = 0; k < 3; k++) {
        inputs[2 + k] = sample->view[k];
        inputs[5 + k] = 0;
    }
    inputs[8] = (float)sample->level;
}

vec3 table_to_local(const table_sample *sample, vec3 direction) {
    return vec(vec_dot(direction, vec_from(sample->tangent)),
               vec_dot(direction, vec_from(sample->bitangent)),
               vec_dot(direction, vec_from(sample->normal)));
}

void table_light(const table_scene *scene, const light *l, size_t count, const table_sample *samples,
                 float *inputs, float *weights) {
    const int64_t n = (int64_t)count;
#pragma omp parallel for schedule(static, 4096) num_threads(scene->threads)
    for (int64_t i = 0; i < n; i++) {
        const table_sample *sample = samples + i;
        float *in = inputs + TABLE_INPUTS * i, *weight = weights + 3 * i;
        vec3 to_light = l->at;
        double distance = 1;
        table_set_sample(sample, in);
        for (int k = 0; k < 3; k++) {
            weight[k] = 0;
        }
        if (sample->view[2] == 0) {
            continue;
        }
        if (l->is_point) {
            to_light = vec_sub(l->at, vec_from(sample->position));
            distance = vec_length(to_light);
            if (distance < 1e-6) {
                continue;
            }
            to_light = vec_mul(to_light, 1 / distance);
        }
        const vec3 local = table_to_local(sample, to_light);
        vec_store(local, in + 5);
        if (scene->cast_shadows && local.z > 0 &&
            blocked(scene, sample, to_light, l->is_point ? distance : INFINITY)) {
            continue;
        }
        for (int k = 0; k < 3; k++) {
            weight[k] = (float)(l->colour[k] / (distance * distance));
        }
    }
}
