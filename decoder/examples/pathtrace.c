/* A small path tracer: a material on a sphere and on the plane below it, under a sky and a small light, with light that
 * is reflected between them. Directions are drawn by the tables of openbtf/sampling.h, or in proportion to the cosine,
 * and weighed with those drawn to the light (multiple importance sampling, E. Veach, 1997, the balance heuristic).
 *
 *     pathtrace FILE.btf.exr OUT.png [SAMPLES [cosine]]
 *         renders a picture of so many samples a pixel (default 16)
 *     pathtrace FILE.btf.exr OUT.png compare SECONDS
 *         renders three pictures side by side: by the cosine and by the tables in SECONDS of core time each, and one in
 *         8 times as long, against which it prints the errors of both
 *
 * Uses nothing of OpenBTF but its installed headers.
 *
 * SPDX-License-Identifier: MIT
 */
#include <openbtf/reference.h>
#include <openbtf/sampling.h>

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define PI 3.14159265358979323846f

enum { WIDTH = 160, HEIGHT = 120, PIXELS = WIDTH * HEIGHT, MOST_BOUNCES = 4 };

typedef struct vec {
    float x, y, z;
} vec;

static vec add(vec a, vec b) {
    return (vec){a.x + b.x, a.y + b.y, a.z + b.z};
}
static vec scale(vec a, float k) {
    return (vec){a.x * k, a.y * k, a.z * k};
}
static float dot(vec a, vec b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static vec cross(vec a, vec b) {
    return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static vec unit(vec a) {
    return scale(a, 1 / sqrtf(dot(a, a)));
}

/* The scene: z is up. */
static const vec ball = {0, 0, 1}, lamp = {2.2f, -1.5f, 3.2f};
static const float ball_radius = 1, lamp_radius = 0.25f, lamp_radiance = 60, repeats = 2;

typedef struct scene {
    btf_material *material;
    btf_evaluator *evaluator;
    btf_light_sampling *tables;
    btf_ref_material directions; /* the direction tables alone: what sampling reads */
    btf_ref_sampling sampling;
} scene;

/* xorshift of 64 bits (G. Marsaglia, 2003). */
static uint32_t draw(uint64_t *state) {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return (uint32_t)(*state >> 32);
}
static float draw_unit(uint64_t *state) {
    return (float)(draw(state) >> 8) * 0x1p-24f;
}

static btf_result open_scene(const char *path, scene *s) {
    const btf_log silent = {NULL, NULL};
    memset(s, 0, sizeof *s);
    btf_result result = btf_material_open(path, &silent, &s->material);
    if (result == BTF_OK) {
        result = btf_evaluator_create(s->material, &silent, &s->evaluator);
    }
    if (result == BTF_OK) {
        result = btf_light_sampling_create(s->material, s->evaluator, &silent, &s->tables);
    }
    if (result != BTF_OK) {
        return result;
    }
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(s->material, &info);
    s->directions.n_views = info.n_views;
    s->directions.n_lights = info.n_lights;
    s->directions.view_table = btf_material_texture(s->material, BTF_TEXTURE_VIEW_TABLE).data;
    s->directions.light_table = btf_material_texture(s->material, BTF_TEXTURE_LIGHT_TABLE).data;
    s->directions.view_grid = btf_material_views(s->material).grid;
    s->directions.light_grid = btf_material_lights(s->material).grid;
    s->sampling = (btf_ref_sampling){s->tables->n_triangles, s->tables->triangles, s->tables->densities};
    return BTF_OK;
}

static void close_scene(scene *s) {
    btf_light_sampling_destroy(&s->tables);
    btf_evaluator_destroy(&s->evaluator);
    btf_material_close(&s->material);
}

/* The sky's radiance: brighter towards the horizon, and on one side. */
static vec sky(vec d) {
    static const vec side = {-0.48f, -0.64f, 0.6f};
    const float glow = 2 * powf(fmaxf(dot(d, side), 0), 16), up = fmaxf(d.z, 0);
    return (vec){0.75f - 0.45f * up + glow, 0.8f - 0.35f * up + 0.9f * glow,
                 0.85f - 0.2f * up + 0.75f * glow};
}

/* Distance to a sphere along a unit direction; INFINITY: it is missed. */
static float meet(vec centre, float radius, vec from, vec d) {
    const vec o = add(from, scale(centre, -1));
    const float b = dot(o, d), c = dot(o, o) - radius * radius, h = b * b - c;
    if (h < 0) {
        return INFINITY;
    }
    const float near = -b - sqrtf(h), far = -b + sqrtf(h);
    return near > 1e-3f ? near : far > 1e-3f ? far : INFINITY;
}

typedef enum thing { SKY, LAMP, SURFACE } thing;

/* A point of the surface: its frame, and texture coordinates. */
typedef struct point {
    vec at, tangent, bitangent, normal;
    float uv[2];
} point;

static thing trace(vec from, vec d, point *out) {
    const float to_ball = meet(ball, ball_radius, from, d), to_lamp = meet(lamp, lamp_radius, from, d);
    const float to_plane = d.z < 0 && from.z > 1e-4f ? -from.z / d.z : INFINITY;
    const float nearest = fminf(to_ball, fminf(to_lamp, to_plane));
    if (isinf(nearest)) {
        return SKY;
    }
    if (nearest == to_lamp) {
        return LAMP;
    }
    out->at = add(from, scale(d, nearest));
    if (nearest == to_plane) {
        out->normal = (vec){0, 0, 1};
        out->tangent = (vec){1, 0, 0};
        out->uv[0] = out->at.x * repeats / 2;
        out->uv[1] = out->at.y * repeats / 2;
    } else {
        out->normal = unit(add(out->at, scale(ball, -1)));
        const vec around = {-out->normal.y, out->normal.x, 0};
        out->tangent = dot(around, around) > 1e-8f ? unit(around) : (vec){1, 0, 0};
        out->uv[0] = (atan2f(out->normal.y, out->normal.x) / (2 * PI) + 0.5f) * 3 * repeats;
        out->uv[1] = asinf(fmaxf(-1, fminf(1, out->normal.z))) / PI * 1.5f * repeats;
    }
    out->bitangent = cross(out->normal, out->tangent);
    return SURFACE;
}

static void to_local(const point *p, vec d, float out[3]) {
    out[0] = dot(d, p->tangent);
    out[1] = dot(d, p->bitangent);
    out[2] = dot(d, p->normal);
}

static vec to_world(const point *p, const float d[3]) {
    return unit(add(add(scale(p->tangent, d[0]), scale(p->bitangent, d[1])), scale(p->normal, d[2])));
}

/* Reflected radiance over incident radiance and solid angle, the cosine included. */
static vec reflect(const scene *s, const point *p, const float light[3], const float view[3]) {
    float rgb[3];
    const btf_evaluations one = {
        .struct_size = sizeof one, .count = 1, .uv = p->uv, .lights = light, .views = view, .rgb = rgb};
    btf_evaluate_many(s->evaluator, NULL, &one);
    return scale((vec){rgb[0], rgb[1], rgb[2]}, 1 / PI);
}

static float density(const scene *s, bool cosine, const float view[3], const float light[3]) {
    if (cosine) {
        return light[2] > 0 ? light[2] / PI : 0;
    }
    return btf_ref_pdf_light(&s->directions, &s->sampling, 0, 0, view, light);
}

static float draw_direction(const scene *s, bool cosine, const float view[3], uint64_t *state,
                            float light[3]) {
    const uint32_t u1 = draw(state), u2 = draw(state);
    float pdf;
    if (!cosine) {
        btf_ref_sample_light(&s->directions, &s->sampling, 0, 0, view, u1, u2, light, &pdf);
        return pdf;
    }
    const float r = (float)(u1 >> 8) * 0x1p-24f, phi = (float)(u2 >> 8) * 0x1p-24f * 2 * PI;
    light[0] = sqrtf(r) * cosf(phi);
    light[1] = sqrtf(r) * sinf(phi);
    light[2] = sqrtf(1 - r);
    return light[2] / PI;
}

/* 1 - cos of the half angle of the cone that the lamp fills, seen from a point. */
static float lamp_cone(vec from) {
    const vec o = add(lamp, scale(from, -1));
    const float sine2 = lamp_radius * lamp_radius / dot(o, o);
    return sine2 / (1 + sqrtf(fmaxf(1 - sine2, 0)));
}

/* Radiance that the point reflects of the lamp, estimated by one direction drawn in the cone of the lamp. */
static vec from_lamp(const scene *s, bool cosine, const point *p, const float view[3], uint64_t *state) {
    const vec none = {0, 0, 0}, axis = unit(add(lamp, scale(p->at, -1)));
    const vec side = unit(fabsf(axis.z) < 0.9f ? cross(axis, (vec){0, 0, 1}) : cross(axis, (vec){1, 0, 0}));
    const float cone = lamp_cone(p->at), c = 1 - draw_unit(state) * cone, sine = sqrtf(fmaxf(1 - c * c, 0));
    const float phi = draw_unit(state) * 2 * PI, pdf = 1 / (2 * PI * cone);
    const vec d =
        add(add(scale(side, sine * cosf(phi)), scale(cross(axis, side), sine * sinf(phi))), scale(axis, c));
    float light[3];
    point shadow;
    to_local(p, d, light);
    if (light[2] <= 0 || trace(p->at, d, &shadow) != LAMP) {
        return none;
    }
    return scale(reflect(s, p, light, view), lamp_radiance / (pdf + density(s, cosine, view, light)));
}

static vec radiance(const scene *s, bool cosine, vec from, vec d, uint64_t *state) {
    vec sum = {0, 0, 0}, through = {1, 1, 1};
    float drawn = 0; /* density of d; 0: the camera's */
    for (int bounce = 0; bounce <= MOST_BOUNCES; bounce++) {
        point p;
        const thing hit = trace(from, d, &p);
        if (hit != SURFACE) {
            vec seen = sky(d);
            if (hit == LAMP) {
                const float other = drawn > 0 ? 1 / (2 * PI * lamp_cone(from)) : 0;
                const float own = drawn > 0 ? drawn / (drawn + other) : 1;
                seen = (vec){lamp_radiance * own, lamp_radiance * own, lamp_radiance * own};
            }
            return add(sum, (vec){through.x * seen.x, through.y * seen.y, through.z * seen.z});
        }
        float view[3], light[3];
        to_local(&p, scale(d, -1), view);
        if (view[2] <= 0) {
            return sum;
        }
        const vec lit = from_lamp(s, cosine, &p, view, state);
        sum = add(sum, (vec){through.x * lit.x, through.y * lit.y, through.z * lit.z});
        drawn = draw_direction(s, cosine, view, state, light);
        if (!(drawn > 0) || bounce == MOST_BOUNCES) {
            return sum;
        }
        const vec f = scale(reflect(s, &p, light, view), 1 / drawn);
        through = (vec){through.x * f.x, through.y * f.y, through.z * f.z};
        from = p.at;
        d = to_world(&p, light);
    }
    return sum;
}

/* Adds a sample to each pixel of a picture of sums. */
static void add_samples(const scene *s, bool cosine, uint64_t pass, vec *sums) {
    static const vec eye = {3.4f, -4.2f, 2.6f}, target = {0, 0, 0.75f};
    const vec forward = unit(add(target, scale(eye, -1))), right = unit(cross(forward, (vec){0, 0, 1})),
              up = cross(right, forward);
#pragma omp parallel for schedule(dynamic)
    for (int y = 0; y < HEIGHT; y++) {
        for (int x = 0; x < WIDTH; x++) {
            uint64_t state = (pass * PIXELS + (uint64_t)(y * WIDTH + x) + 1) * 0x9E3779B97F4A7C15u;
            draw(&state);
            const float a = ((float)x + draw_unit(&state)) / WIDTH - 0.5f,
                        b = 0.5f - ((float)y + draw_unit(&state)) / HEIGHT;
            const vec d =
                unit(add(forward, add(scale(right, 0.9f * a), scale(up, 0.9f * HEIGHT / WIDTH * b))));
            sums[y * WIDTH + x] = add(sums[y * WIDTH + x], radiance(s, cosine, eye, d, &state));
        }
    }
}

static double core_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* A picture of so many samples, or, where they are 0, of so many seconds. Returns the samples. */
static int render(const scene *s, bool cosine, int samples, double seconds, uint64_t seed, vec *out) {
    const double end = core_seconds() + seconds;
    int count = 0;
    memset(out, 0, PIXELS * sizeof *out);
    while (samples ? count < samples : core_seconds() < end || count == 0) {
        add_samples(s, cosine, seed + (uint64_t)count++, out);
    }
    for (int i = 0; i < PIXELS; i++) {
        out[i] = scale(out[i], 1.0f / (float)count);
    }
    return count;
}

/* sRGB-coded, 0 to 255. */
static unsigned char coded(float linear) {
    const float x = fmaxf(0, fminf(linear, 1));
    return (unsigned char)(255 * (x <= 0.0031308f ? 12.92f * x : 1.055f * powf(x, 1 / 2.4f) - 0.055f) +
                           0.5f);
}

static void put_big(unsigned char *to, uint32_t value) {
    for (int i = 0; i < 4; i++) {
        to[i] = (unsigned char)(value >> (24 - 8 * i));
    }
}

/* A PNG chunk: the CRC is that of the PNG specification, annex D. */
static void write_chunk(FILE *file, const char *type, const unsigned char *data, uint32_t size) {
    unsigned char head[8], tail[4];
    uint32_t crc = 0xFFFFFFFFu;
    put_big(head, size);
    memcpy(head + 4, type, 4);
    for (uint32_t i = 0; i < size + 4; i++) {
        crc ^= i < 4 ? head[4 + i] : data[i - 4];
        for (int bit = 0; bit < 8; bit++) {
            crc = crc & 1 ? crc >> 1 ^ 0xEDB88320u : crc >> 1;
        }
    }
    put_big(tail, ~crc);
    fwrite(head, 1, sizeof head, file);
    fwrite(data, 1, size, file);
    fwrite(tail, 1, sizeof tail, file);
}

/* Pictures beside each other, in stored blocks of a row each (RFC 1950, 1951). */
static bool write_png(const char *path, vec *const *pictures, int count) {
    const uint32_t row = 1 + 3 * WIDTH * (uint32_t)count, size = 2 + HEIGHT * (5 + row) + 4;
    unsigned char *data = malloc(size), *at = data, header[13] = {0};
    FILE *file = data ? fopen(path, "wb") : NULL;
    if (!file) {
        free(data);
        return false;
    }
    uint32_t a = 1, b = 0;
    *at++ = 0x78;
    *at++ = 0x01;
    for (int y = 0; y < HEIGHT; y++) {
        const unsigned char block[6] = {
            y == HEIGHT - 1,     (unsigned char)row,         (unsigned char)(row >> 8),
            (unsigned char)~row, (unsigned char)(~row >> 8), 0};
        memcpy(at, block, sizeof block);
        unsigned char *pixel = at + sizeof block;
        for (int i = 0; i < count * WIDTH; i++) {
            const vec *p = &pictures[i / WIDTH][y * WIDTH + i % WIDTH];
            *pixel++ = coded(p->x);
            *pixel++ = coded(p->y);
            *pixel++ = coded(p->z);
        }
        for (at += 5; at < pixel; at++) {
            a = (a + *at) % 65521;
            b = (b + a) % 65521;
        }
    }
    put_big(at, b << 16 | a);
    put_big(header, WIDTH * (uint32_t)count);
    put_big(header + 4, HEIGHT);
    header[8] = 8;
    header[9] = 2;
    fwrite("\x89PNG\r\n\x1A\n", 1, 8, file);
    write_chunk(file, "IHDR", header, sizeof header);
    write_chunk(file, "IDAT", data, size);
    write_chunk(file, "IEND", data, 0);
    free(data);
    const bool whole = !ferror(file);
    return fclose(file) == 0 && whole;
}

/* Root of the mean square of differences, of values clipped to 1. */
static double error_of(const vec *picture, const vec *truth) {
    double sum = 0;
    for (int i = 0; i < PIXELS; i++) {
        const float d[3] = {fminf(picture[i].x, 1) - fminf(truth[i].x, 1),
                            fminf(picture[i].y, 1) - fminf(truth[i].y, 1),
                            fminf(picture[i].z, 1) - fminf(truth[i].z, 1)};
        for (int c = 0; c < 3; c++) {
            sum += (double)d[c] * (double)d[c];
        }
    }
    return sqrt(sum / (3 * PIXELS));
}

static bool compare(const scene *s, double seconds, const char *path) {
    static vec pictures[3][PIXELS];
    const int by_cosine = render(s, true, 0, seconds, 1, pictures[0]),
              by_tables = render(s, false, 0, seconds, 1 << 20, pictures[1]),
              longer = render(s, false, 0, 8 * seconds, 1 << 24, pictures[2]);
    printf("cosine: %d samples, error %.5f; tables: %d samples, error %.5f; against %d samples\n",
           by_cosine, error_of(pictures[0], pictures[2]), by_tables, error_of(pictures[1], pictures[2]),
           longer);
    return write_png(path, (vec *const[3]){pictures[0], pictures[1], pictures[2]}, 3);
}

int main(int argc, char **argv) {
    static vec picture[PIXELS];
    const bool compares = argc == 5 && strcmp(argv[3], "compare") == 0;
    const bool cosine = argc == 5 && strcmp(argv[4], "cosine") == 0;
    const double number = argc > 3 ? atof(argv[compares ? 4 : 3]) : 16;
    if (argc < 3 || argc > 5 || (argc == 5 && !compares && !cosine) || !(number > 0 && number <= 1e6)) {
        fprintf(stderr, "usage: pathtrace FILE.btf.exr OUT.png [SAMPLES [cosine] | compare SECONDS]\n");
        return btf_result_exit_code(BTF_ERROR_USAGE);
    }
    scene s;
    btf_result result = open_scene(argv[1], &s);
    bool written = false;
    if (result == BTF_OK && compares) {
        written = compare(&s, number, argv[2]);
    } else if (result == BTF_OK) {
        render(&s, cosine, (int)number > 0 ? (int)number : 1, 0, 1, picture);
        written = write_png(argv[2], (vec *const[1]){picture}, 1);
    }
    if (result == BTF_OK && !written) {
        result = BTF_ERROR_IO;
    }
    if (result != BTF_OK) {
        fprintf(stderr, "pathtrace: %s: %s\n", argv[written || result != BTF_ERROR_IO ? 1 : 2],
                btf_result_text(result));
    }
    close_scene(&s);
    return btf_result_exit_code(result);
}
