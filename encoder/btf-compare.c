/* btf-compare: how far apart two BTFs are.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/file.h"
#include "decoder/toolkit/decode_options.h"
#include "decoder/toolkit/filter.h"
#include "decoder/toolkit/progress.h"
#include "encoder/base/stage.h"
#include "encoder/between/blend.h"
#include "encoder/between/decode.h"
#include "encoder/data/images.h"
#include "encoder/input/bonn/file.h"
#include "encoder/input/options.h"
#include "encoder/model/evaluated_images.h"
#include "encoder/report/between.h"
#include "encoder/report/leave_one_out.h"
#include "encoder/report/metrics.h"

#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct {
    enc_read_options read;
    const char *pictures;
    uint32_t effects;
    int interpolation, filter, worst, threads;
    bool json, no_ssim, pairs, leave_one_out, quiet;
} o = {.read = {.names_of_some = true}, /* a table may be for one side only */
       .effects = BTF_EFFECT_ALL, .interpolation = ENC_INTERPOLATE_LINEAR, .worst = 8};

static const cli_option table[] = {
    {.name = "json", .type = CLI_FLAG, .value = &o.json, .help = "print JSON"},
    {.name = "effects",
     .type = CLI_EFFECTS,
     .value = &o.effects,
     .help = "effects decoded from materials; default all"},
    {.name = "interpolation",
     .type = CLI_CHOICE,
     .value = &o.interpolation,
     .choices = "nearest|linear|spline",
     .help = "between sampled directions: take the nearest one, blend with the decoder's\n"
             "barycentric weights, or, of a data set only, by thin-plate splines through\n"
             "the square roots of all its images; default linear"},
    {.name = "filter",
     .type = CLI_CHOICE,
     .value = &o.filter,
     .choices = FILTER_CHOICES,
     .help = "how a material is read between texels, where the effect relief shifts\n"
             "views by parts of a texel; default texel"},
    {.name = "pairs",
     .type = CLI_FLAG,
     .value = &o.pairs,
     .help = "take the images of B one by one at their own directions, even where\n"
             "they form a grid of views and lights"},
    {.name = "leave-one-out",
     .type = CLI_FLAG,
     .value = &o.leave_one_out,
     .help = "estimate the error between the samples of a data set A, and of its material\n"
             "B where that is given: views and lights predicted from the others"},
    {.name = "pictures",
     .arg = "FILE",
     .type = CLI_STRING,
     .value = &o.pictures,
     .help = "where A or B holds pairs: write the worst as a PNG, each a row of\n"
             "truth, model, and four times their error"},
    {.name = "worst",
     .type = CLI_INT,
     .value = &o.worst,
     .minimum = 1,
     .maximum = 64,
     .help = "how many of the worst pairs to list and draw; default 8"},
    {.name = "no-ssim", .type = CLI_FLAG, .value = &o.no_ssim, .help = "leave SSIM out (faster)"},
    ENC_INPUT_OPTIONS(o.read),
    {.name = "threads",
     .type = CLI_INT,
     .value = &o.threads,
     .minimum = 1,
     .maximum = 1024,
     .help = "default: all cores"},
    {QUIET_OPTION, .value = &o.quiet},
    {.type = CLI_END},
};

static const cli_program program = {
    .name = "btf-compare",
    .usage = "A B [OPTION...]\n       btf-compare --leave-one-out DATA [MATERIAL] [OPTION...]",
    .summary =
        "Compares two BTFs image by image: PSNR (linear and sRGB-coded, values clipped to [0, 1]), SSIM,\n"
        "by view ring and light ring. A and B are data sets (folder, zip) or materials (OpenEXR), which\n"
        "the reference decoder evaluates at the directions of the other; two materials are compared at\n"
        "those of A.",
    .details =
        "--names TABLE gives the directions of the images that it lists, of A, B or both; those of other images are\n"
        "read from their names.\n\n"
        "Between the samples: one of A and B may hold single images at any directions, which their names\n"
        "say (tl12.5_pl30_tv40.25_pv110.exr) and which need not form a grid: pairs of a view and a light,\n"
        "such as btf-sample --between writes. The other is evaluated there: a material by the reference\n"
        "decoder, a data set by interpolation of its images. Errors are then told by theta of view and\n"
        "light, and by the angle to the nearest sample.\n\n"
        "btf-compare looks at the content of A and B: a file that begins as OpenEXR is a material; a grid of\n"
        "images under a view from the top, of which at most half is missing, is a data set; other images are pairs.\n\n"
        "--leave-one-out needs no truth between the samples. It predicts samples from others that lie twice as\n"
        "far away as the samples around a direction between them, so it overstates the error there: most where\n"
        "relief, shadows or highlights move from sample to sample.",
    .example = "btf-compare BRICKS64.zip bricks.btf.exr --json\n"
               "btf-compare bricks.btf.exr BRICKS64_between.zip --pictures worst.png\n"
               "btf-compare --leave-one-out BRICKS64.zip bricks.btf.exr",
    .options = table,
    .min_arguments = 1,
    .max_arguments = 2,
};

/* One of the two sides: one of the first three pointers is set. */
typedef struct side {
    const char *path;
    btf_material *material;
    enc_data *data;
    enc_pairs *pairs;
    enc_evaluator *evaluator; /* of the material, made when its images are asked for */
    enc_evaluated_images images;
} side;

static btf_ref_options decoding(void) {
    return (btf_ref_options){.effects = o.effects,
                             .components = UINT32_MAX,
                             .interpolation = o.interpolation == ENC_INTERPOLATE_NEAREST ? BTF_REF_NEAREST
                                                                                         : BTF_REF_LINEAR,
                             .filter = filter_of_reference((btf_filter)o.filter)};
}

static btf_result open_side(const enc_context *context, side *s, bool as_pairs) {
    enc_image_set set = as_pairs ? ENC_SET_PAIRS : ENC_SET_GRID;
    btf_result result = BTF_OK;
    if (file_is_exr(s->path)) {
        return btf_material_open(s->path, &context->log, &s->material);
    }
    if (!as_pairs && !enc_bonn_is(s->path)) {
        result = enc_pairs_classify(context, s->path, &o.read, &set);
    }
    if (result != BTF_OK) {
        return result;
    }
    return set == ENC_SET_PAIRS ? enc_pairs_open(context, s->path, &o.read, &s->pairs)
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

/* Finds the source of a side's images at the directions of `shape`. */
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
    btf_result result = enc_evaluator_create(context, s->material, 0, &s->evaluator);
    if (result != BTF_OK) {
        return result;
    }
    s->images =
        (enc_evaluated_images){.shape = shape, .evaluator = s->evaluator, .options = decoding()};
    *out = enc_evaluated_image_source(&s->images);
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
        return enc_fail(context, BTF_ERROR_BAD_FILE,
                        "%s (%d x %d texels, %d views, %d lights) and %s (%d x %d texels, %d views, %d "
                        "lights) differ in texels or directions",
                        a->path, p->width, p->height, p->n_views, p->n_lights, b->path, q->width, q->height,
                        q->n_views, q->n_lights);
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

static btf_result print_json(const side *a, const side *b, const enc_metrics *m, const enc_between *between,
                             const enc_pairs *pairs) {
    json j = {0};
    json_object(&j, NULL);
    json_string(&j, "a", a->path);
    json_string(&j, "b", b->path);
    if (between) {
        enc_between_json(&j, "between", between, pairs);
    } else {
        enc_metrics_json(&j, "psnr", m, !o.no_ssim);
    }
    json_end(&j);
    const char *text = json_text(&j);
    if (text) {
        fputs(text, stdout);
    }
    json_free(&j);
    return text ? BTF_OK : BTF_ERROR_MEMORY;
}

static btf_result compare_grids(const enc_context *context, side *a, side *b) {
    enc_direction views[BTF_MAX_DIRECTIONS], lights[BTF_MAX_DIRECTIONS];
    enc_data material_shape;
    enc_image_source images[2];
    enc_metrics metrics;
    btf_result result = BTF_OK;
    const enc_data *shape = a->data ? a->data : b->data;
    if (!shape) {
        shape_of(a->material, &material_shape, views, lights);
        shape = &material_shape;
    }
    if (a->data && b->data) {
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
            result = print_json(a, b, &metrics, NULL, NULL);
        } else {
            print_text(&metrics, !o.no_ssim);
        }
    }
    return result;
}

/* A material that is decoded at pairs. */
typedef struct decoded {
    const enc_evaluator *evaluator;
    btf_ref_options options;
} decoded;

static btf_result decoded_pairs(const enc_context *context, const void *user, const enc_pair *pairs,
                                size_t count, float *out) {
    const decoded *d = user;
    return enc_decode_pairs(context, d->evaluator, &d->options, pairs, count, out);
}

static btf_result blended_pairs(const enc_context *context, const void *user, const enc_pair *pairs,
                                size_t count, float *out) {
    return enc_blend_images(context, user, pairs, count, out);
}

static btf_result check_sizes(const enc_context *context, const side *model, const side *truth,
                              const enc_data *shape) {
    const enc_pairs *pairs = truth->pairs;
    return shape->width == pairs->width && shape->height == pairs->height
               ? BTF_OK
               : enc_fail(context, BTF_ERROR_BAD_FILE, "%s has %d x %d texels, %s has %d x %d", model->path,
                          shape->width, shape->height, truth->path, pairs->width, pairs->height);
}

static btf_result measure_pairs(const enc_context *context, const side *a, const side *b,
                                enc_pair_images images, const side *truth) {
    enc_between *between = NULL;
    btf_result result = enc_between_measure(context, truth->pairs, images, !o.no_ssim, &between);
    if (result == BTF_OK && o.pictures) {
        result = enc_between_picture(context, truth->path, &o.read, between, images, (size_t)o.worst,
                                     o.pictures);
    }
    if (result == BTF_OK && o.json) {
        result = print_json(a, b, NULL, between, truth->pairs);
    } else if (result == BTF_OK) {
        enc_between_print(between, truth->pairs, (size_t)o.worst, stdout);
    }
    enc_between_destroy(&between);
    return result;
}

static btf_result compare_pairs(const enc_context *context, side *a, side *b) {
    const side *truth = b->pairs ? b : a;
    side *model = b->pairs ? a : b;
    enc_direction views[BTF_MAX_DIRECTIONS], lights[BTF_MAX_DIRECTIONS];
    enc_data material_shape;
    const enc_data *shape = model->data ? model->data : &material_shape;
    enc_blend *blend = NULL;
    if (model->pairs) {
        return enc_fail(context, BTF_ERROR_USAGE,
                        "%s and %s both hold single images: one of them must be a data set or a material",
                        a->path, b->path);
    }
    if (model->material) {
        shape_of(model->material, &material_shape, views, lights);
    }
    btf_result result = check_sizes(context, model, truth, shape);
    if (result == BTF_OK && model->material) {
        result = enc_evaluator_create(context, model->material, 0, &model->evaluator);
    }
    const decoded d = {model->evaluator, decoding()};
    if (result == BTF_OK && model->data) {
        result = enc_blend_create(context, model->data, (enc_interpolation)o.interpolation, &blend);
    }
    if (result == BTF_OK) {
        const enc_pair_images images = {.images = model->data ? blended_pairs : decoded_pairs,
                                        .user = model->data ? (const void *)blend : &d,
                                        .views = shape->views,
                                        .lights = shape->lights,
                                        .n_views = shape->n_views,
                                        .n_lights = shape->n_lights};
        result = measure_pairs(context, a, b, images, truth);
    }
    enc_blend_destroy(&blend);
    return result;
}

static btf_result print_leave_one_out(const side *a, const side *b, const enc_leave_one_out *measured) {
    json j = {0};
    if (!o.json) {
        enc_leave_one_out_print(measured, stdout);
        return BTF_OK;
    }
    json_object(&j, NULL);
    json_string(&j, "a", a->path);
    json_string(&j, "b", b->path);
    enc_leave_one_out_json(&j, "leave_one_out", measured);
    json_end(&j);
    const char *text = json_text(&j);
    if (text) {
        fputs(text, stdout);
    }
    json_free(&j);
    return text ? BTF_OK : BTF_ERROR_MEMORY;
}

/* Refuses a material whose grid of samples is not that of the data: these samples are what is left out. */
static btf_result check_same_samples(const enc_context *context, const side *data, const side *material) {
    enc_direction views[BTF_MAX_DIRECTIONS], lights[BTF_MAX_DIRECTIONS];
    enc_data shape;
    shape_of(material->material, &shape, views, lights);
    const side other = {.path = material->path, .data = &shape};
    return check_same_grid(context, data, &other);
}

static btf_result leave_one_out(const enc_context *context, side *a, side *b) {
    enc_leave_one_out measured;
    btf_result result = open_side(context, a, false);
    if (result == BTF_OK && b->path) {
        result = open_side(context, b, false);
    }
    if (result == BTF_OK && a->material && b->data) {
        side *swap = a;
        a = b;
        b = swap;
    }
    if (result == BTF_OK && (!a->data || (b->path && !b->material))) {
        result = enc_fail(
            context, BTF_ERROR_USAGE,
            "option --leave-one-out: expected a data set, and at most one file after it, its material");
    }
    if (result == BTF_OK && b->material) {
        result = check_same_samples(context, a, b);
    }
    if (result == BTF_OK) {
        result = enc_leave_one_out_measure(context, a->data, b->material, 1, &measured);
    }
    if (result == BTF_OK && measured.views == 0 && measured.lights == 0) {
        result = enc_fail(context, BTF_ERROR_BAD_FILE,
                          "%s: none of its %d views and %d lights is surrounded by others, from which it "
                          "could be predicted",
                          a->path, a->data->n_views, a->data->n_lights);
    }
    return result == BTF_OK ? print_leave_one_out(a, b, &measured) : result;
}

static btf_result compare(const enc_context *context, side *a, side *b) {
    btf_result result = open_side(context, a, false);
    if (result == BTF_OK) {
        result = open_side(context, b, o.pairs);
    }
    if (result != BTF_OK) {
        return result;
    }
    const bool pairs = a->pairs || b->pairs;
    if (o.interpolation == ENC_INTERPOLATE_SPLINE && !(pairs && (a->data || b->data))) {
        return enc_fail(
            context, BTF_ERROR_USAGE,
            "option --interpolation spline: only for a data set compared with pairs (see --help)");
    }
    if (o.filter != BTF_FILTER_TEXEL && !(pairs && (a->material || b->material))) {
        return enc_fail(context, BTF_ERROR_USAGE,
                        "option --filter %s: only for a material compared with pairs (see --help)",
                        filter_name((btf_filter)o.filter));
    }
    if (!pairs && (o.pictures || o.pairs)) {
        return enc_fail(
            context, BTF_ERROR_USAGE,
            "option --%s: needs single images at directions of their own, which neither %s nor %s holds",
            o.pictures ? "pictures" : "pairs", a->path, b->path);
    }
    return pairs ? compare_pairs(context, a, b) : compare_grids(context, a, b);
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
    side a = {.path = arguments.values[0]}, b = {.path = arguments.count > 1 ? arguments.values[1] : NULL};
    const btf_result result =
        o.leave_one_out ? leave_one_out(&context, &a, &b)
        : b.path        ? compare(&context, &a, &b)
                        : cli_error(&program, BTF_ERROR_USAGE,
                                    "B is missing: expected two data sets or materials (see --help)");
    if (result == BTF_ERROR_INTERRUPTED) {
        cli_error(&program, result, "interrupted");
    }
    enc_evaluator_destroy(&a.evaluator);
    enc_evaluator_destroy(&b.evaluator);
    btf_material_close(&a.material);
    btf_material_close(&b.material);
    enc_data_destroy(&a.data);
    enc_data_destroy(&b.data);
    enc_pairs_close(&a.pairs);
    enc_pairs_close(&b.pairs);
    progress_destroy(&shown);
    return cli_finish(&program, result);
}
