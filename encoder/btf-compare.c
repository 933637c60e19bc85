/* btf-compare: how far apart two BTFs are.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/file.h"
#include "decoder/toolkit/progress.h"
#include "decoder/toolkit/reference_view.h"
#include "encoder/base/stage.h"
#include "encoder/input/options.h"
#include "encoder/report/metrics.h"
#include "encoder/data/images.h"

#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct {
    enc_read_options read;
    uint32_t effects;
    int interpolation, threads;
    bool json, no_ssim, quiet;
} o = {.effects = BTF_EFFECT_ALL, .interpolation = 1};

static const cli_option table[] = {
    {.name = "json", .type = CLI_FLAG, .value = &o.json, .help = "print JSON"},
    {.name = "effects",
     .type = CLI_EFFECTS,
     .value = &o.effects,
     .help = "effects decoded from materials; default all"},
    {.name = "interpolation",
     .type = CLI_CHOICE,
     .value = &o.interpolation,
     .choices = "nearest|linear",
     .help = "between a material's sampled directions; default linear"},
    {.name = "no-ssim", .type = CLI_FLAG, .value = &o.no_ssim, .help = "leave SSIM out (faster)"},
    ENC_INPUT_OPTIONS(o.read),
    {.name = "threads",
     .type = CLI_INT,
     .value = &o.threads,
     .minimum = 1,
     .maximum = 1024,
     .help = "default: all cores"},
    {.short_name = 'q', .name = "quiet", .type = CLI_FLAG, .value = &o.quiet, .help = "no progress"},
    {.type = CLI_END},
};

static const cli_program program = {
    .name = "btf-compare",
    .usage = "A B [OPTION...]",
    .summary =
        "Compares two BTFs image by image: PSNR (linear and sRGB-coded, values clipped to [0, 1]), SSIM,\n"
        "by view ring and light ring. A and B are data sets (folder, zip) or materials (OpenEXR), which\n"
        "the reference decoder evaluates at the directions of the other; two materials are compared at\n"
        "those of A.",
    .example = "btf-compare BRICKS64.zip bricks.btf.exr --json",
    .options = table,
    .min_arguments = 2,
    .max_arguments = 2,
};

/* One of the two sides. */
typedef struct side {
    const char *path;
    btf_material *material; /* NULL: a data set */
    enc_data *data;
    enc_reference_images reference;
} side;

static btf_result open_side(const enc_context *context, side *s) {
    return file_is_exr(s->path) ? btf_material_open(s->path, &context->log, &s->material)
                                : enc_read(context, s->path, &o.read, &s->data);
}

/* The directions of a material as a data set without samples. */
static void shape_of(const btf_material *material, enc_data *shape, enc_direction *views,
                     enc_direction *lights) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    *shape = (enc_data){.width = (int)info.width,
                        .height = (int)info.height,
                        .n_views = (int)info.n_views,
                        .n_lights = (int)info.n_lights,
                        .views = views,
                        .lights = lights,
                        .scratch_fd = -1};
    const btf_directions lists[2] = {btf_material_views(material), btf_material_lights(material)};
    enc_direction *out[2] = {views, lights};
    for (int i = 0; i < 2; i++) {
        for (uint32_t d = 0; d < lists[i].count; d++) {
            const float *xyz = lists[i].xyz + 3 * d;
            out[i][d] = (enc_direction){.theta = atan2(hypot(xyz[0], xyz[1]), xyz[2]) * 180 / M_PI,
                                        .phi = atan2(xyz[1], xyz[0]) * 180 / M_PI};
            memcpy(out[i][d].xyz, xyz, sizeof out[i][d].xyz);
        }
    }
}

/* The side's images at the directions of `shape`. */
static btf_result images_of(const enc_context *context, side *s, const side *other, const enc_data *shape,
                            enc_image_source *out) {
    if (!s->material) {
        *out = enc_data_images(s->data);
        return BTF_OK;
    }
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(s->material, &info);
    if ((int)info.width != shape->width || (int)info.height != shape->height) {
        return enc_fail(context, BTF_ERROR_BAD_FILE, "%s has %u x %u texels, %s has %d x %d", s->path,
                        info.width, info.height, other->path, shape->width, shape->height);
    }
    s->reference.shape = shape;
    s->reference.options =
        (btf_ref_options){.effects = o.effects,
                          .components = UINT32_MAX,
                          .interpolation = o.interpolation ? BTF_REF_LINEAR : BTF_REF_NEAREST};
    reference_view(s->material, 0, &s->reference.material);
    *out = enc_reference_image_source(&s->reference);
    return BTF_OK;
}

/* Names hold rounded angles: directions count as the same up to about a hundredth of a degree. */
static bool same_directions(const enc_direction *a, const enc_direction *b, int count) {
    for (int i = 0; i < count; i++) {
        for (int axis = 0; axis < 3; axis++) {
            if (fabsf(a[i].xyz[axis] - b[i].xyz[axis]) > 2e-4f) {
                return false;
            }
        }
    }
    return true;
}

static btf_result check_same_grid(const enc_context *context, const side *a, const side *b) {
    const enc_data *p = a->data, *q = b->data;
    const bool same = p->width == q->width && p->height == q->height && p->n_views == q->n_views &&
                      p->n_lights == q->n_lights && same_directions(p->views, q->views, p->n_views) &&
                      same_directions(p->lights, q->lights, p->n_lights);
    if (!same) {
        return enc_fail(
            context, BTF_ERROR_BAD_FILE,
            "%s (%d x %d, %d views, %d lights) and %s (%d x %d, %d views, %d lights) do not have the same "
            "texels and directions",
            a->path, p->width, p->height, p->n_views, p->n_lights, b->path, q->width, q->height, q->n_views,
            q->n_lights);
    }
    return BTF_OK;
}

static void print_text(const enc_metrics *m, bool with_ssim) {
    printf("PSNR linear %.3f dB, sRGB %.3f dB", enc_psnr_linear(&m->total), enc_psnr_srgb(&m->total));
    if (with_ssim) {
        printf(", SSIM %.4f", m->ssim);
    }
    printf("\n%-12s %8s %8s\n", "view theta", "linear", "sRGB");
    for (int r = 0; r < m->n_view_rings; r++) {
        printf("%-12.4g %8.3f %8.3f\n", m->view_ring_theta[r], enc_psnr_linear(&m->view_ring[r]),
               enc_psnr_srgb(&m->view_ring[r]));
    }
    printf("%-12s %8s %8s\n", "light theta", "linear", "sRGB");
    for (int r = 0; r < m->n_light_rings; r++) {
        printf("%-12.4g %8.3f %8.3f\n", m->light_ring_theta[r], enc_psnr_linear(&m->light_ring[r]),
               enc_psnr_srgb(&m->light_ring[r]));
    }
}

static btf_result print_json(const side *a, const side *b, const enc_metrics *m, bool with_ssim) {
    json j = {0};
    json_object(&j, NULL);
    json_string(&j, "a", a->path);
    json_string(&j, "b", b->path);
    enc_metrics_json(&j, "psnr", m, with_ssim);
    json_end(&j);
    const char *text = json_text(&j);
    if (text) {
        fputs(text, stdout);
    }
    json_free(&j);
    return text ? BTF_OK : BTF_ERROR_MEMORY;
}

static btf_result compare(const enc_context *context, side *a, side *b) {
    enc_direction views[BTF_MAX_DIRECTIONS], lights[BTF_MAX_DIRECTIONS];
    enc_data material_shape;
    enc_image_source images[2];
    enc_metrics metrics;
    btf_result result = open_side(context, a);
    if (result == BTF_OK) {
        result = open_side(context, b);
    }
    const enc_data *shape = a->data ? a->data : b->data;
    if (result == BTF_OK && !shape) {
        shape_of(a->material, &material_shape, views, lights);
        shape = &material_shape;
    }
    if (result == BTF_OK && a->data && b->data) {
        result = check_same_grid(context, a, b);
    }
    if (result == BTF_OK) {
        result = images_of(context, a, b, shape, &images[0]);
    }
    if (result == BTF_OK) {
        result = images_of(context, b, a, shape, &images[1]);
    }
    if (result == BTF_OK) {
        enc_stage_begin(context, "compare", (size_t)shape->n_views);
        result = enc_metrics_compare(context, shape, images[0], images[1], !o.no_ssim, &metrics);
        enc_stage_end(context);
    }
    if (result == BTF_OK) {
        if (o.json) {
            result = print_json(a, b, &metrics, !o.no_ssim);
        } else {
            print_text(&metrics, !o.no_ssim);
        }
    }
    return result;
}

int main(int argc, char **argv) {
    cli_arguments arguments;
    int exit_code;
    o.threads = omp_get_num_procs();
    if (!cli_parse(&program, argc, argv, &arguments, &exit_code)) {
        return exit_code;
    }
    progress *shown = progress_create(o.quiet);
    const enc_context context = {
        .log = cli_log(&program, o.quiet), .progress = shown, .threads = o.threads};
    side a = {.path = arguments.values[0]}, b = {.path = arguments.values[1]};
    const btf_result result = compare(&context, &a, &b);
    if (result == BTF_ERROR_INTERRUPTED) {
        cli_error(&program, result, "interrupted");
    }
    btf_material_close(&a.material);
    btf_material_close(&b.material);
    enc_data_destroy(&a.data);
    enc_data_destroy(&b.data);
    progress_destroy(&shown);
    return cli_finish(&program, result);
}
