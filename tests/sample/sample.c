/* Renders a relief: rays, shading, supersampling, and the truth about each texel.
 *
 * SPDX-License-Identifier: MIT
 */
#include "sample.h"

#include "directions.h"
#include "encoder/base/stage.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

struct sample_scene {
    sample_options options;
    relief *surface;
    enc_direction *views, *lights;
    double (*light_xyz)[3];  /* [light], unit in double */
    raycast_shadow *shadows; /* [light] */
};

/* A surface point with the data that shading it needs. */
typedef struct shading_point {
    raycast_hit hit;
    relief_material material;
    double facing; /* n.v */
} shading_point;

/* The unit vector in double; enc_direction holds it rounded. */
static void direction_vector(const enc_direction *direction, double out[3]) {
    const double degree = 3.14159265358979323846 / 180;
    double sine = sin(direction->theta * degree);
    out[0] = sine * cos(direction->phi * degree);
    out[1] = sine * sin(direction->phi * degree);
    out[2] = cos(direction->theta * degree);
}

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* base^exponent by squaring: the same bits on every machine. */
static double integer_power(double base, int exponent) {
    double result = 1;
    for (; exponent > 0; exponent >>= 1) {
        if (exponent & 1) {
            result *= base;
        }
        base *= base;
    }
    return result;
}

/* The equation of relief_material, for a light at l that casts `shadow`. */
static bool shade_point(const sample_scene *scene, const shading_point *point, const double v[3],
                        const double l[3], const raycast_shadow *shadow, double out_rgb[3]) {
    const double *n = point->hit.normal;
    const relief_material *m = &point->material;
    double ambient = scene->surface->ambient * l[2];
    for (int c = 0; c < 3; ++c) {
        out_rgb[c] = ambient * m->albedo[c];
    }
    double cosine = dot(n, l);
    if (cosine <= 0 || !raycast_lit(shadow, point->hit.position)) {
        return false;
    }
    double mirrored = 2 * cosine * point->facing - dot(l, v); /* r.v */
    double lobe = mirrored > 0 ? integer_power(mirrored, m->exponent) : 0;
    for (int c = 0; c < 3; ++c) {
        out_rgb[c] += cosine * (m->albedo[c] + m->gloss[c] * lobe);
    }
    return true;
}

static shading_point prepare_point(const sample_scene *scene, const raycast_hit *hit, const double v[3]) {
    shading_point point = {.hit = *hit, .facing = dot(hit->normal, v)};
    relief_material_at(scene->surface, hit->position[0], hit->position[1], &point.material);
    return point;
}

bool sample_shade(const sample_scene *scene, const raycast_hit *hit, const double v[3], int light,
                  double out_rgb[3]) {
    shading_point point = prepare_point(scene, hit, v);
    return shade_point(scene, &point, v, scene->light_xyz[light], &scene->shadows[light], out_rgb);
}

const relief *sample_scene_relief(const sample_scene *scene) {
    return scene->surface;
}

const sample_options *sample_scene_options(const sample_scene *scene) {
    return &scene->options;
}

/* Fills in defaults and checks the user's options. */
static btf_result check_options(sample_options *o) {
    if (o->width == 0) {
        o->width = 64;
    }
    if (o->height == 0) {
        o->height = 64;
    }
    if (o->supersample == 0) {
        o->supersample = 2;
    }
    if (o->grid == 0) {
        o->grid = 1024;
    }
    if (o->relief < 0 || o->relief >= RELIEF_COUNT) {
        return enc_fail(o->context, BTF_ERROR_USAGE, "sample: there is no relief %d", (int)o->relief);
    }
    if (o->width < 1 || o->width > 8192 || o->height < 1 || o->height > 8192) {
        return enc_fail(o->context, BTF_ERROR_USAGE, "sample: size %dx%d is not within 1..8192", o->width,
                        o->height);
    }
    if (o->supersample < 1 || o->supersample > 4) {
        return enc_fail(o->context, BTF_ERROR_USAGE, "sample: supersampling %d is not within 1..4",
                        o->supersample);
    }
    if (o->grid < 64 || o->grid > 4096 || (o->grid & (o->grid - 1)) != 0) {
        return enc_fail(o->context, BTF_ERROR_USAGE, "sample: grid %d is not a power of two of 64..4096",
                        o->grid);
    }
    return BTF_OK;
}

/* A copy of a list, or of the 81 directions where there is none; every direction must be above the horizon. */
static btf_result copy_directions(const enc_context *context, const enc_direction *list, int count,
                                  enc_direction **out_list, int *out_count) {
    if (!list) {
        return directions_parse(context, "ubo", out_list, out_count);
    }
    if (count < 1 || count > DIRECTIONS_MAX) {
        return enc_fail(context, BTF_ERROR_USAGE, "sample: %d directions are not within 1..256", count);
    }
    for (int i = 0; i < count; ++i) {
        if (!(list[i].theta >= 0 && list[i].theta <= 85)) {
            return enc_fail(context, BTF_ERROR_USAGE, "sample: direction %d, theta %g is not within 0..85",
                            i, list[i].theta);
        }
    }
    *out_list = malloc((size_t)count * sizeof **out_list);
    if (!*out_list) {
        return enc_fail(context, BTF_ERROR_MEMORY, "sample: out of memory");
    }
    memcpy(*out_list, list, (size_t)count * sizeof *list);
    *out_count = count;
    return BTF_OK;
}

static int thread_count(const enc_context *context) {
    return context && context->threads > 1 ? context->threads : 1;
}

static btf_result create_shadows(sample_scene *scene) {
    const enc_context *context = scene->options.context;
    const int n_lights = scene->options.n_lights;
    btf_result result = BTF_OK;
    enc_stage_begin(context, "shadows", (size_t)n_lights);
#pragma omp parallel for schedule(dynamic) num_threads(thread_count(context))
    for (int i = 0; i < n_lights; ++i) {
        direction_vector(&scene->lights[i], scene->light_xyz[i]);
        btf_result one = enc_cancelled(context) ? BTF_ERROR_INTERRUPTED
                                                : raycast_shadow_create(scene->surface, scene->light_xyz[i],
                                                                        &scene->shadows[i]);
        if (one != BTF_OK) {
#pragma omp critical(sample_result)
            result = one;
        }
        enc_stage_step(context, 1);
    }
    enc_stage_end(context);
    return result;
}

btf_result sample_scene_create(const sample_options *options, sample_scene **out_scene) {
    sample_options o = *options;
    btf_result result = check_options(&o);
    if (result != BTF_OK) {
        return result;
    }
    sample_scene *scene = calloc(1, sizeof *scene);
    if (!scene) {
        return enc_fail(o.context, BTF_ERROR_MEMORY, "sample: out of memory");
    }
    result = copy_directions(o.context, o.views, o.n_views, &scene->views, &o.n_views);
    if (result != BTF_OK) {
        goto fail;
    }
    result = copy_directions(o.context, o.lights, o.n_lights, &scene->lights, &o.n_lights);
    if (result != BTF_OK) {
        goto fail;
    }
    o.views = scene->views;
    o.lights = scene->lights;
    scene->options = o;
    result = relief_create(o.relief, o.seed, o.grid, thread_count(o.context), &scene->surface);
    if (result != BTF_OK) {
        goto fail;
    }
    scene->light_xyz = calloc((size_t)o.n_lights, sizeof *scene->light_xyz);
    scene->shadows = calloc((size_t)o.n_lights, sizeof *scene->shadows);
    result = scene->light_xyz && scene->shadows ? create_shadows(scene) : BTF_ERROR_MEMORY;
    if (result != BTF_OK) {
        goto fail;
    }
    *out_scene = scene;
    return BTF_OK;
fail:
    if (result == BTF_ERROR_MEMORY) {
        enc_fail(o.context, result, "sample: out of memory for a grid of %d and %d lights", o.grid,
                 o.n_lights);
    }
    sample_scene_destroy(&scene);
    return result;
}

void sample_scene_destroy(sample_scene **scene) {
    if (!scene || !*scene) {
        return;
    }
    sample_scene *s = *scene;
    if (s->shadows) {
        for (int i = 0; i < s->options.n_lights; ++i) {
            raycast_shadow_destroy(&s->shadows[i]);
        }
    }
    free(s->shadows);
    free(s->light_xyz);
    free(s->views);
    free(s->lights);
    relief_destroy(&s->surface);
    free(s);
    *scene = NULL;
}

/* The truth of one texel that does not depend on the light. */
static void record_geometry(const sample_scene *scene, int view, int row, int column, const double v[3],
                            sample_truth *truth) {
    const int width = scene->options.width, height = scene->options.height;
    double x = (column + 0.5) / width, y = 1 - (row + 0.5) / height;
    raycast_hit hit = raycast_view(scene->surface, x, y, v);
    size_t index = ((size_t)view * height + row) * width + column;
    for (int c = 0; c < 3; ++c) {
        truth->position[3 * index + c] = (float)hit.position[c];
    }
    truth->shift[2 * index] = (float)((hit.position[0] - x) * width);
    truth->shift[2 * index + 1] = (float)((y - hit.position[1]) * height);
    truth->hidden[index] = 0;
}

/* The point that ray k of a texel sees. */
static shading_point ray_point(const sample_scene *scene, int row, int column, int k, const double v[3]) {
    const sample_options *o = &scene->options;
    const int s = o->supersample;
    double x = (column + (k % s + 0.5) / s) / o->width;
    double y = 1 - (row + (k / s + 0.5) / s) / o->height;
    raycast_hit hit = raycast_view(scene->surface, x, y, v);
    return prepare_point(scene, &hit, v);
}

btf_result sample_scene_pair(const sample_scene *scene, const enc_direction *view,
                             const enc_direction *light, float *image) {
    const sample_options *o = &scene->options;
    const int rays = o->supersample * o->supersample;
    double v[3], l[3];
    raycast_shadow shadow;
    direction_vector(view, v);
    direction_vector(light, l);
    btf_result result = raycast_shadow_create(scene->surface, l, &shadow);
    for (int texel = 0; result == BTF_OK && texel < o->width * o->height; ++texel) {
        double sum[3] = {0, 0, 0};
        for (int k = 0; k < rays; ++k) {
            const shading_point point = ray_point(scene, texel / o->width, texel % o->width, k, v);
            double rgb[3];
            shade_point(scene, &point, v, l, &shadow, rgb);
            for (int c = 0; c < 3; ++c) {
                sum[c] += rgb[c];
            }
        }
        for (int c = 0; c < 3; ++c) {
            image[3 * (size_t)texel + (size_t)c] = (float)(sum[c] / rays);
        }
    }
    if (result == BTF_OK) {
        raycast_shadow_destroy(&shadow);
    }
    return result;
}

btf_result sample_scene_view(const sample_scene *scene, int view, float *images, sample_truth *truth) {
    const sample_options *o = &scene->options;
    assert(view >= 0 && view <= o->n_views);
    const int s = o->supersample, rays = s * s;
    const size_t texels = (size_t)o->width * o->height;
    const bool pole = view == o->n_views;
    double v[3] = {0, 0, 1};
    if (!pole) {
        direction_vector(&scene->views[view], v);
    }
    uint8_t *shadow = NULL; /* [light][row][column] */
    if (truth) {
        shadow = pole ? truth->top_shadow : truth->shadow + (size_t)view * o->n_lights * texels;
    }
    /* work in bands of rows, so that each light's shadow is in the cache for many points */
    const size_t row_points = (size_t)o->width * rays, band_points = 1 << 14;
    const int band = row_points < band_points ? (int)(band_points / row_points) : 1;
    shading_point *points = malloc((size_t)band * row_points * sizeof *points);
    if (!points) {
        return BTF_ERROR_MEMORY;
    }
    for (int first = 0; first < o->height; first += band) {
        const int rows = o->height - first < band ? o->height - first : band;
        for (int row = first; row < first + rows; ++row) {
            for (int column = 0; column < o->width; ++column) {
                shading_point *out = points + (row - first) * row_points + (size_t)column * rays;
                for (int k = 0; k < rays; ++k) {
                    out[k] = ray_point(scene, row, column, k, v);
                }
                if (truth && !pole) {
                    record_geometry(scene, view, row, column, v, truth);
                }
            }
        }
        const size_t count = (size_t)rows * o->width;
        for (int light = 0; light < o->n_lights; ++light) {
            for (size_t i = 0; i < count; ++i) {
                size_t index = (size_t)light * texels + (size_t)first * o->width + i;
                double sum[3] = {0, 0, 0};
                int unlit = 0;
                for (int k = 0; k < rays; ++k) {
                    double rgb[3];
                    unlit += !shade_point(scene, &points[i * rays + k], v, scene->light_xyz[light],
                                          &scene->shadows[light], rgb);
                    for (int c = 0; c < 3; ++c) {
                        sum[c] += rgb[c];
                    }
                }
                if (shadow) {
                    shadow[index] = 2 * unlit >= rays;
                }
                if (images) {
                    for (int c = 0; c < 3; ++c) {
                        images[3 * index + c] = (float)(sum[c] / rays);
                    }
                }
            }
        }
    }
    free(points);
    return BTF_OK;
}

btf_result sample_truth_create(const sample_scene *scene, sample_truth **out_truth) {
    const sample_options *o = &scene->options;
    size_t texels = (size_t)o->width * o->height, views = (size_t)o->n_views, lights = (size_t)o->n_lights;
    sample_truth *truth = calloc(1, sizeof *truth);
    if (!truth) {
        return BTF_ERROR_MEMORY;
    }
    truth->width = o->width;
    truth->height = o->height;
    truth->n_views = o->n_views;
    truth->n_lights = o->n_lights;
    truth->position = calloc(views * texels, 3 * sizeof *truth->position);
    truth->shift = calloc(views * texels, 2 * sizeof *truth->shift);
    truth->hidden = calloc(views, texels);
    truth->shadow = calloc(views * lights, texels);
    truth->top_shadow = calloc(lights, texels);
    if (!truth->position || !truth->shift || !truth->hidden || !truth->shadow || !truth->top_shadow) {
        sample_truth_destroy(&truth);
        return enc_fail(o->context, BTF_ERROR_MEMORY,
                        "sample: out of memory for the truth of %dx%d, %d views, %d lights", o->width,
                        o->height, o->n_views, o->n_lights);
    }
    *out_truth = truth;
    return BTF_OK;
}

void sample_truth_destroy(sample_truth **truth) {
    if (!truth || !*truth) {
        return;
    }
    free((*truth)->position);
    free((*truth)->shift);
    free((*truth)->hidden);
    free((*truth)->shadow);
    free((*truth)->top_shadow);
    free(*truth);
    *truth = NULL;
}

/* images[light][texel][3] of one view to the samples' order [texel][view][channel][light]. */
static void scatter_view(const sample_options *o, int view, const float *images, enc_data *data) {
    const size_t texels = enc_data_texel_count(data), lights = (size_t)o->n_lights;
    for (size_t texel = 0; texel < texels; ++texel) {
        float *out = data->samples + texel * enc_data_texel_stride(data) + (size_t)view * 3 * lights;
        for (size_t c = 0; c < 3; ++c) {
            for (size_t light = 0; light < lights; ++light) {
                out[c * lights + light] = images[3 * (light * texels + texel) + c];
            }
        }
    }
}

btf_result sample_render(const sample_options *options, enc_data **out_data, sample_truth **out_truth) {
    sample_scene *scene = NULL;
    enc_data *data = NULL;
    sample_truth *truth = NULL;
    btf_result result = sample_scene_create(options, &scene);
    if (result != BTF_OK) {
        return result;
    }
    const sample_options *o = &scene->options;
    enc_context in_memory = {.threads = thread_count(o->context)};
    if (o->context) {
        in_memory.log = o->context->log;
    }
    result = enc_data_create(&in_memory, o->width, o->height, o->n_views, o->views, o->n_lights, o->lights,
                             &data);
    if (result == BTF_OK && out_truth) {
        result = sample_truth_create(scene, &truth);
    }
    if (result == BTF_OK && !data->source) {
        data->source = strdup(relief_kind_name(o->relief));
        result = data->source ? BTF_OK : enc_fail(o->context, BTF_ERROR_MEMORY, "sample: out of memory");
    }
    if (result != BTF_OK) {
        goto done;
    }
    const size_t floats = 3 * (size_t)o->n_lights * enc_data_texel_count(data);
    const int jobs = o->n_views + (truth ? 1 : 0);
    enc_stage_begin(o->context, "render", (size_t)jobs);
#pragma omp parallel num_threads(in_memory.threads)
    {
        float *images = malloc(floats * sizeof *images);
#pragma omp for schedule(dynamic)
        for (int view = 0; view < jobs; ++view) {
            btf_result one = !images                     ? BTF_ERROR_MEMORY
                             : enc_cancelled(o->context) ? BTF_ERROR_INTERRUPTED
                                                         : sample_scene_view(scene, view, images, truth);
            if (one != BTF_OK) {
#pragma omp critical(sample_result)
                result = one;
            } else if (view < o->n_views) {
                scatter_view(o, view, images, data);
            }
            enc_stage_step(o->context, 1);
        }
        free(images);
    }
    enc_stage_end(o->context);
    if (result == BTF_ERROR_MEMORY) {
        enc_fail(o->context, result, "sample: out of memory for the %d images of a view", o->n_lights);
    }
done:
    sample_scene_destroy(&scene);
    if (result != BTF_OK) {
        enc_data_destroy(&data);
        sample_truth_destroy(&truth);
        return result;
    }
    *out_data = data;
    if (out_truth) {
        *out_truth = truth;
    }
    return BTF_OK;
}

btf_result sample_render_small(const enc_context *context, relief_kind relief, const char *views,
                               const char *lights, int size, enc_data **out_data) {
    sample_options o = {
        .context = context, .relief = relief, .width = size, .height = size, .supersample = 1, .grid = 256};
    enc_direction *v = NULL, *l = NULL;
    *out_data = NULL;
    btf_result result = directions_parse(context, views, &v, &o.n_views);
    if (result == BTF_OK) {
        result = directions_parse(context, lights, &l, &o.n_lights);
    }
    if (result == BTF_OK) {
        o.views = v;
        o.lights = l;
        result = sample_render(&o, out_data, NULL);
    }
    free(v);
    free(l);
    return result;
}
