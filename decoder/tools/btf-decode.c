/* btf-decode: images of a material on the CPU: one view under one light, or all of them in
 * the layout of UBO2003.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/cli.h"
#include "decoder/toolkit/decode_options.h"
#include "decoder/toolkit/exr_image.h"
#include "decoder/toolkit/file.h"
#include "decoder/toolkit/filter.h"
#include "decoder/toolkit/output.h"
#include "decoder/toolkit/png_image.h"
#include "decoder/toolkit/progress.h"
#include <errno.h>
#include <math.h>
#include <omp.h>
#include <openbtf/evaluate.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define PI 3.14159265358979323846

enum { FORMAT_PNG, FORMAT_EXR };

static struct {
    const char *out;
    double view[2], light[2];
    bool view_given, light_given, format_given;
    bool all, quiet;
    uint32_t effects;
    int interpolation, filter, format, threads, components, level;
} options = {.effects = BTF_EFFECT_ALL, .interpolation = 1, .components = BTF_MAX_COMPONENTS};

static const cli_option option_table[] = {
    {.short_name = 'o',
     .name = "output",
     .arg = "OUT",
     .type = CLI_STRING,
     .value = &options.out,
     .help = "image (.png or .exr, in any case), or a directory for all"},
    {.name = "view",
     .type = CLI_ANGLES,
     .value = options.view,
     .given = &options.view_given,
     .help = "direction to the viewer, theta,phi in degrees (default 0,0)"},
    {.name = "light",
     .type = CLI_ANGLES,
     .value = options.light,
     .given = &options.light_given,
     .help = "direction to the light (default 0,0)"},
    {.name = "all",
     .type = CLI_FLAG,
     .value = &options.all,
     .help = "every sampled view under every sampled light; default where\n"
             "neither --view nor --light is given and OUT is not an image"},
    {EFFECTS_OPTION, .value = &options.effects},
    {COMPONENTS_OPTION, .value = &options.components},
    {.name = "level",
     .arg = "N",
     .type = CLI_INT,
     .value = &options.level,
     .minimum = 0,
     .maximum = BTF_MAX_LEVELS - 1,
     .help = "level of detail to decode, below the number of levels of FILE (default 0)"},
    {.name = "interpolation",
     .type = CLI_CHOICE,
     .choices = "nearest|linear",
     .value = &options.interpolation,
     .help = "between sampled directions (default linear)"},
    {.name = "filter",
     .type = CLI_CHOICE,
     .choices = FILTER_CHOICES,
     .value = &options.filter,
     .help = "between texels (default texel); at the centres of texels, which are decoded\n"
             "here, it makes a difference only with the effect relief, which shifts views\n"
             "by parts of a texel"},
    {.name = "format",
     .type = CLI_CHOICE,
     .choices = "png|exr",
     .value = &options.format,
     .given = &options.format_given,
     .help = "png: 8 bits, sRGB-coded; exr: linear float\n(default: what OUT ends in, png with --all)"},
    {.name = "threads",
     .type = CLI_INT,
     .value = &options.threads,
     .minimum = 1,
     .maximum = 1024,
     .help = "threads of --all (default: all cores)"},
    {QUIET_OPTION, .value = &options.quiet},
    {.type = CLI_END},
};

static const cli_program program = {
    .name = "btf-decode",
    .usage = "FILE -o OUT [--view T,P] [--light T,P] | FILE -o DIR",
    .summary = "Decodes a material file (*.btf.exr) to images, texel by texel, bit for bit as the reference\n"
               "decoder and every exact decoder do.",
    .details =
        "Angles: theta from the surface normal, phi from +u (to the right) towards +v (up).\n"
        "All images are DIR/tvTTT_pvPPP/NNNNN tlTTT plPPP tvTTT pvPPP.png (.exr), the layout of UBO2003.\n"
        "A direction below the horizon gives black.",
    .example = "btf-decode bricks.btf.exr -o top.png --light 45,90\nbtf-decode bricks.btf.exr -o bricks/",
    .options = option_table,
    .min_arguments = 1,
    .max_arguments = 1,
};

/* All that decoding an image takes; threads only read it. */
typedef struct decoder {
    btf_evaluator *evaluator;
    btf_evaluate_options options;
    uint32_t width, height; /* of the level */
    uint32_t *texels;       /* [height][width][2], where whole texels are decoded; else NULL */
    float *uv;              /* [height][width][2], of their centres; else NULL */
    int32_t *levels;        /* [height][width] */
    int format;
    btf_log log;
    float thresholds[256]; /* code c of sRGB begins at thresholds[c] */
} decoder;

static void from_angles(const double angles[2], float out[3]) {
    double theta = angles[0] * (PI / 180), phi = angles[1] * (PI / 180);
    out[0] = (float)(sin(theta) * cos(phi));
    out[1] = (float)(sin(theta) * sin(phi));
    out[2] = (float)cos(theta);
}

/* The linear values at which each sRGB code (IEC 61966-2-1) begins, when values are rounded to the nearest code. */
static void make_thresholds(float thresholds[256]) {
    thresholds[0] = -INFINITY;
    for (int c = 1; c < 256; c++) {
        double s = (c - 0.5) / 255;
        thresholds[c] = (float)(s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4));
    }
}

static unsigned char srgb_code(const float thresholds[256], float linear) {
    int low = 0;
    for (int step = 128; step > 0; step /= 2) {
        if (linear >= thresholds[low + step]) {
            low += step;
        }
    }
    return (unsigned char)low;
}

/* Decodes the texel grid into rgb (floats) and writes it; codes is as large as rgb. */
static btf_result decode_image(const decoder *d, const char *path, const float light[3],
                               const float view[3], float *rgb, unsigned char *codes) {
    const uint32_t width = d->width, height = d->height;
    const size_t values = (size_t)width * height * 3;
    const btf_evaluations evaluations = {.struct_size = sizeof evaluations,
                                         .count = (size_t)width * height,
                                         .uv = d->uv,
                                         .texels = d->texels,
                                         .lights = light,
                                         .views = view,
                                         .levels = d->levels,
                                         .fixed = BTF_FIXED_LIGHT | BTF_FIXED_VIEW,
                                         .rgb = rgb};
    const btf_result result = btf_evaluate_many(d->evaluator, &d->options, &evaluations);
    if (result) {
        return cli_error(&program, result, "cannot decode an image");
    }
    if (d->format == FORMAT_EXR) {
        return exr_image_write(path, (int)width, (int)height, rgb, false, d->log);
    }
    for (size_t i = 0; i < values; i++) {
        codes[i] = srgb_code(d->thresholds, rgb[i]);
    }
    return png_image_write8(path, (int)width, (int)height, codes, d->log);
}

static btf_result make_buffers(const decoder *d, float **out_rgb, unsigned char **out_codes) {
    const size_t values = (size_t)d->width * d->height * 3;
    *out_rgb = malloc(values * sizeof **out_rgb);
    *out_codes = malloc(values);
    return *out_rgb && *out_codes ? BTF_OK : BTF_ERROR_MEMORY;
}

static btf_result decode_one(const decoder *d) {
    float view[3], light[3], *rgb;
    unsigned char *codes;
    from_angles(options.view, view);
    from_angles(options.light, light);
    btf_result result = make_buffers(d, &rgb, &codes);
    if (result) {
        cli_error(&program, result, "out of memory for an image");
    } else {
        result = decode_image(d, options.out, light, view, rgb, codes);
    }
    free(rgb);
    free(codes);
    return result;
}

/* Writes an angle as it stands in names of files: three digits, and as many decimals (up to 4) as it takes to come
 * within `tolerance` degrees. */
static void angle_text(double degrees, double tolerance, char text[16]) {
    int decimals = 0;
    double scale = 1;
    while (decimals < 4 && fabs(round(degrees * scale) / scale - degrees) > tolerance) {
        decimals++;
        scale *= 10;
    }
    double rounded = round(degrees * scale) / scale;
    snprintf(text, 16, "%0*.*f", decimals ? decimals + 4 : 3, decimals, rounded >= 360 ? 0 : rounded);
}

/* Writes the two angles of names like tlTTT plPPP, for a stored direction, which is of single precision. */
static void direction_text(const float d[3], char theta[16], char phi[16]) {
    const double sine = hypot((double)d[0], (double)d[1]), precision = 5e-5;
    double azimuth = atan2((double)d[1], (double)d[0]) * (180 / PI);
    angle_text(atan2(sine, (double)d[2]) * (180 / PI), precision, theta);
    if (sine < 1e-6) {
        azimuth = 0;
    } else if (azimuth < -precision / sine) {
        azimuth += 360;
    }
    angle_text(azimuth < 0 ? 0 : azimuth, sine < 1e-6 ? precision : precision / sine, phi);
}

static btf_result make_directory(const char *path) {
    struct stat status;
    if (mkdir(path, 0777) == 0 ||
        (errno == EEXIST && stat(path, &status) == 0 && S_ISDIR(status.st_mode))) {
        return BTF_OK;
    }
    return cli_error(&program, BTF_ERROR_IO, "%s: %s", path, strerror(errno));
}

/* Decodes a view under every light, into the folder of the view. */
static btf_result decode_view(const decoder *d, const btf_directions *views, const btf_directions *lights,
                              uint32_t v, uint32_t l, float *rgb, unsigned char *codes) {
    char path[4096], tv[16], pv[16], tl[16], pl[16];
    const float *view = views->xyz + 3 * (size_t)v, *light = lights->xyz + 3 * (size_t)l;
    direction_text(view, tv, pv);
    direction_text(light, tl, pl);
    int length =
        snprintf(path, sizeof path, "%s/tv%s_pv%s/%05u tl%s pl%s tv%s pv%s.%s", options.out, tv, pv,
                 (unsigned)(views->count * l + v), tl, pl, tv, pv, d->format == FORMAT_EXR ? "exr" : "png");
    if (length >= (int)sizeof path) {
        return cli_error(&program, BTF_ERROR_USAGE, "%s: the file name is too long", options.out);
    }
    return decode_image(d, path, light, view, rgb, codes);
}

static btf_result decode_all(const decoder *d, const btf_directions *views, const btf_directions *lights) {
    btf_result result = make_directory(options.out);
    for (uint32_t v = 0; v < views->count && !result; v++) {
        char path[4096], tv[16], pv[16];
        direction_text(views->xyz + 3 * (size_t)v, tv, pv);
        if (snprintf(path, sizeof path, "%s/tv%s_pv%s", options.out, tv, pv) >= (int)sizeof path) {
            return cli_error(&program, BTF_ERROR_USAGE, "%s: the file name is too long", options.out);
        }
        result = make_directory(path);
    }
    progress *p = result ? NULL : progress_create(options.quiet);
    if (!p) {
        return result ? result : cli_error(&program, BTF_ERROR_MEMORY, "out of memory");
    }
    const int count = (int)(views->count * lights->count);
    progress_begin(p, "decoding", (size_t)count);
#pragma omp parallel num_threads(options.threads)
    {
        float *rgb;
        unsigned char *codes;
        btf_result mine = make_buffers(d, &rgb, &codes);
        if (mine) {
            cli_error(&program, mine, "out of memory for an image");
        }
#pragma omp for schedule(dynamic)
        for (int i = 0; i < count; i++) {
            btf_result seen;
#pragma omp atomic read
            seen = result;
            if (!mine && !seen && progress_cancelled()) {
                mine = BTF_ERROR_INTERRUPTED;
            }
            if (!mine && !seen) {
                mine = decode_view(d, views, lights, (uint32_t)i / lights->count,
                                   (uint32_t)i % lights->count, rgb, codes);
            }
            if (mine) {
#pragma omp atomic write
                result = mine;
            }
            progress_step(p, 1);
        }
        free(rgb);
        free(codes);
    }
    progress_end(p);
    progress_destroy(&p);
    return result == BTF_ERROR_INTERRUPTED ? cli_error(&program, result, "interrupted") : result;
}

static bool is_directory(const char *path) {
    struct stat status;
    return stat(path, &status) == 0 && S_ISDIR(status.st_mode);
}

/* Whether OUT is no folder and ends as an image format does that is not written. */
static bool ends_as_other_image(const char *path) {
    static const char *const endings[] = {".jpg", ".jpeg", ".tif",  ".tiff",
                                          ".hdr", ".bmp",  ".webp", ".zip"};
    for (size_t i = 0; i < sizeof endings / sizeof *endings; i++) {
        if (file_ends_in(path, endings[i])) {
            return !is_directory(path);
        }
    }
    return false;
}

/* Picks the format by OUT's ending where --format does not. */
static btf_result choose_format(void) {
    const char *other = options.format == FORMAT_EXR ? ".png" : ".exr";
    if (options.format_given && !options.all && file_ends_in(options.out, other)) {
        return cli_error(&program, BTF_ERROR_USAGE,
                         "option --format: the file name '%s' ends as another format's", options.out);
    }
    if (options.format_given || options.all) {
        return BTF_OK;
    }
    if (file_ends_in(options.out, ".exr")) {
        options.format = FORMAT_EXR;
    } else if (!file_ends_in(options.out, ".png")) {
        return cli_error(&program, BTF_ERROR_USAGE,
                         "option --output: '%s' ends neither in .png nor in .exr, and there is no --format",
                         options.out);
    }
    return BTF_OK;
}

static btf_result check_options(void) {
    if (!options.out) {
        return cli_error(&program, BTF_ERROR_USAGE,
                         "option --output is missing: an image, or a directory for all images");
    }
    if (options.all && (options.view_given || options.light_given)) {
        return cli_error(&program, BTF_ERROR_USAGE, "option --all: not together with --view or --light");
    }
    if (!options.all && ends_as_other_image(options.out)) {
        return cli_error(&program, BTF_ERROR_USAGE,
                         "option --output: '%s' ends neither in .png nor in .exr", options.out);
    }
    const bool is_image = file_ends_in(options.out, ".png") || file_ends_in(options.out, ".exr");
    if (!options.view_given && !options.light_given && (!is_image || is_directory(options.out))) {
        options.all = true;
    }
    if (options.threads == 0) {
        options.threads = omp_get_num_procs();
    }
    return choose_format();
}

static void clear_decoder(decoder *d) {
    btf_evaluator_destroy(&d->evaluator);
    free(d->texels);
    free(d->uv);
    free(d->levels);
}

/* Sets where an image is decoded: at whole texels, or at texture coordinates of their centres. */
static bool make_positions(decoder *d) {
    const size_t count = (size_t)d->width * d->height;
    d->levels = malloc(count * sizeof *d->levels);
    if (d->options.filter == BTF_FILTER_TEXEL) {
        d->texels = malloc(2 * count * sizeof *d->texels);
    } else {
        d->uv = malloc(2 * count * sizeof *d->uv);
    }
    if (!d->levels || (!d->texels && !d->uv)) {
        return false;
    }
    for (size_t i = 0; i < count; i++) {
        const uint32_t column = (uint32_t)(i % d->width), row = (uint32_t)(i / d->width);
        d->levels[i] = options.level;
        if (d->texels) {
            d->texels[2 * i] = column;
            d->texels[2 * i + 1] = row;
        } else {
            d->uv[2 * i] = filter_centre(column, d->width);
            d->uv[2 * i + 1] = filter_centre(d->height - 1 - row, d->height);
        }
    }
    return true;
}

static btf_result make_decoder(const char *path, const btf_material *material, decoder *d) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    if ((uint32_t)options.level >= info.levels) {
        return cli_error(&program, BTF_ERROR_USAGE, "option --level: %d, but %s has %u level%s",
                         options.level, path, (unsigned)info.levels, info.levels == 1 ? "" : "s");
    }
    d->width = btf_level_size(info.width, (uint32_t)options.level);
    d->height = btf_level_size(info.height, (uint32_t)options.level);
    d->options = (btf_evaluate_options){
        .struct_size = sizeof d->options,
        .leave_out = ~options.effects | (options.components == 0 ? (uint32_t)BTF_EFFECT_RESIDUAL : 0),
        .components = (uint32_t)options.components,
        .interpolation = options.interpolation ? BTF_INTERPOLATION_LINEAR : BTF_INTERPOLATION_NEAREST,
        .filter = (btf_filter)options.filter};
    const btf_result result = btf_evaluator_create(material, &d->log, &d->evaluator);
    if (result) {
        return result;
    }
    return make_positions(d) ? BTF_OK : cli_error(&program, BTF_ERROR_MEMORY, "out of memory for an image");
}

static btf_result run(const cli_arguments *arguments) {
    const char *path = arguments->values[0];
    btf_result result = check_options();
    if (result) {
        return result;
    }
    if (output_is_same(options.out, path)) {
        return cli_error(&program, BTF_ERROR_USAGE, "option --output: %s is the input", options.out);
    }
    decoder d = {.format = options.format, .log = cli_log(&program, options.quiet)};
    btf_material *material = NULL;
    if ((result = btf_material_open(path, &d.log, &material))) {
        return result;
    }
    make_thresholds(d.thresholds);
    result = make_decoder(path, material, &d);
    if (!result && options.all) {
        const btf_directions views = btf_material_views(material), lights = btf_material_lights(material);
        result = decode_all(&d, &views, &lights);
    } else if (!result) {
        result = decode_one(&d);
    }
    clear_decoder(&d);
    btf_material_close(&material);
    return result;
}

int main(int argc, char **argv) {
    return cli_run(&program, argc, argv, run);
}
