/* btf-sample: writes a BTF with known truth as a folder of images in the UBO2003 layout.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/cli.h"
#include "decoder/toolkit/progress.h"
#include "directions.h"
#include "images.h"
#include "pairs.h"
#include "sample.h"
#include "truth_files.h"

#include <limits.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct {
    const char *out, *truth, *directions, *views, *lights, *pairs;
    int relief, format, quality, seed, supersample, grid, threads;
    int between, pair_seed, frames;
    pairs_orbit orbit;
    double orbit_theta, fixed[2], exposure, noise;
    int size[2];
    bool has_format, quiet;
} options = {.directions = "ubo",
             .quality = 95,
             .supersample = 2,
             .grid = 1024,
             .orbit_theta = 45,
             .fixed = {30, 45},
             .exposure = 1,
             .size = {64, 64}};

static const char *parse_relief(const char *text, void *value) {
    relief_kind kind = relief_kind_from_name(text);
    *(int *)value = kind;
#define RELIEF_WORD(id, name, help) " " name
    return kind < RELIEF_COUNT ? NULL : "one of" RELIEF_LIST(RELIEF_WORD);
#undef RELIEF_WORD
}

/* "view:FRAMES" or "light:FRAMES", and optionally ":THETA", the theta of the direction that moves (default 45). */
static const char *parse_orbit(const char *text, void *value) {
    static const char expected[] =
        "view or light, then :FRAMES (1 to 100000) and, if need be, :THETA (above 0, at most 85)";
    const char *colon = strchr(text, ':');
    const size_t length = colon ? (size_t)(colon - text) : 0;
    pairs_orbit *orbit = value;
    *orbit = length == 4 && strncmp(text, "view", 4) == 0    ? PAIRS_ORBIT_VIEW
             : length == 5 && strncmp(text, "light", 5) == 0 ? PAIRS_ORBIT_LIGHT
                                                             : PAIRS_NO_ORBIT;
    const char *end = NULL;
    if (*orbit == PAIRS_NO_ORBIT || !cli_parse_int(colon + 1, ":", &options.frames, &end) ||
        options.frames < 1 || options.frames > PAIRS_MAX) {
        return expected;
    }
    if (*end == ':' && (!cli_parse_double(end + 1, "", &options.orbit_theta, NULL) ||
                        !(options.orbit_theta > 0 && options.orbit_theta <= 85))) {
        return expected;
    }
    return NULL;
}

/* "64" or "64x48". */
static const char *parse_size(const char *text, void *value) {
    int *size = value, end = 0;
    if (sscanf(text, "%5dx%5d%n", &size[0], &size[1], &end) != 2 || text[end]) {
        if (sscanf(text, "%5d%n", &size[0], &end) != 1 || text[end]) {
            return "N or WIDTHxHEIGHT";
        }
        size[1] = size[0];
    }
    return size[0] >= 1 && size[0] <= 8192 && size[1] >= 1 && size[1] <= 8192 ? NULL : "sides of 1 to 8192";
}

static const cli_option table[] = {
    {.short_name = 'o',
     .name = "output",
     .arg = "DIR",
     .type = CLI_STRING,
     .value = &options.out,
     .help = "folder for the images, made if need be; files of the same name are replaced"},
    {.name = "relief",
     .arg = "NAME",
     .type = CLI_CUSTOM,
     .value = &options.relief,
     .parse = parse_relief,
     .help = "what to render, see below (default bricks)"},
    {.name = "size",
     .arg = "N|WxH",
     .type = CLI_CUSTOM,
     .value = options.size,
     .parse = parse_size,
     .help = "texels (default 64)"},
    {.name = "truth",
     .arg = "DIR",
     .type = CLI_STRING,
     .value = &options.truth,
     .help = "also write the true positions, shifts, hidden points and shadows as .npy\nfiles, with a "
             "README.txt"},
    {.name = "format",
     .type = CLI_CHOICE,
     .value = &options.format,
     .choices = "png|png16|jpeg|exr",
     .given = &options.has_format,
     .help = "8-bit sRGB PNG, 16-bit sRGB PNG, JPEG, or float OpenEXR, linear and not\n"
             "clipped (default png, between the samples exr)"},
    {.name = "quality",
     .type = CLI_INT,
     .value = &options.quality,
     .minimum = 1,
     .maximum = 100,
     .help = "of JPEG (default 95)"},
    {.name = "directions",
     .arg = "LIST",
     .type = CLI_STRING,
     .value = &options.directions,
     .help = "views and lights: ubo (81), ubo2014 (151), small (19), tiny (5), a number\n"
             "of 1..256 on a spiral, or rings THETA:COUNT[:OFFSET],... (default ubo)"},
    {.name = "views",
     .arg = "LIST",
     .type = CLI_STRING,
     .value = &options.views,
     .help = "views, where they differ from --directions"},
    {.name = "lights",
     .arg = "LIST",
     .type = CLI_STRING,
     .value = &options.lights,
     .help = "lights, where they differ from --directions"},
    {.name = "between",
     .arg = "N",
     .type = CLI_INT,
     .value = &options.between,
     .minimum = 1,
     .maximum = PAIRS_MAX,
     .help = "instead of a grid: N random pairs of view and light, each uniform over the\n"
             "solid angle up to theta 74"},
    {.name = "pair-seed",
     .type = CLI_INT,
     .value = &options.pair_seed,
     .minimum = 0,
     .maximum = INT_MAX,
     .help = "of --between: another seed, other pairs of the same material (default 0)"},
    {.name = "pairs",
     .arg = "LIST",
     .type = CLI_STRING,
     .value = &options.pairs,
     .help = "instead of a grid: the pairs of a text file, theta and phi of the view,\n"
             "theta and phi of the light a line"},
    {.name = "orbit",
     .arg = "WHAT:FRAMES[:THETA]",
     .type = CLI_CUSTOM,
     .value = &options.orbit,
     .parse = parse_orbit,
     .help = "instead of a grid: one turn of the view or the light at THETA (default 45)\n"
             "in numbered frames, with DIR/directions.csv beside them"},
    {.name = "fixed",
     .type = CLI_ANGLES,
     .value = options.fixed,
     .help = "where that stays which does not move in an orbit (default 30,45)"},
    {.name = "seed",
     .type = CLI_INT,
     .value = &options.seed,
     .minimum = 0,
     .maximum = INT_MAX,
     .help = "another seed, another material of the kind (default 0)"},
    {.name = "exposure",
     .type = CLI_DOUBLE,
     .value = &options.exposure,
     .minimum = 0,
     .maximum = 1e6,
     .help = "all values are multiplied by this: a dark material, or highlights\nfar above 1 (default 1)"},
    {.name = "noise",
     .type = CLI_DOUBLE,
     .value = &options.noise,
     .minimum = 0,
     .maximum = 1e6,
     .help = "standard deviation of normal noise that each value of a grid gets then,\nas a camera adds it; what "
             "falls below 0 is 0 (default 0)"},
    {.name = "supersample",
     .type = CLI_INT,
     .value = &options.supersample,
     .minimum = 1,
     .maximum = 4,
     .help = "rays along each side of a texel (default 2)"},
    {.name = "grid",
     .type = CLI_INT,
     .value = &options.grid,
     .minimum = 64,
     .maximum = 4096,
     .help = "cells along each side of the relief, a power of two (default 1024)"},
    {.name = "threads",
     .type = CLI_INT,
     .value = &options.threads,
     .minimum = 1,
     .maximum = 256,
     .help = "threads (default: all cores); the result does not depend on them"},
    {.short_name = 'q',
     .name = "quiet",
     .type = CLI_FLAG,
     .value = &options.quiet,
     .help = "no progress, no summary"},
    {.type = CLI_END},
};

#define RELIEF_LINE(id, name, text) "\n  " name "\t" text

static const cli_program program = {
    .name = "btf-sample",
    .usage = "-o DIR [options]",
    .summary =
        "Renders a BTF with known truth: a periodic relief with hard shadows, seen from every view under\n"
        "every light, as images in the UBO2003 layout:\n"
        "DIR/tvTTT_pvPPP/NNNNN tlTTT plPPP tvTTT pvPPP.png, NNNNN = views * light + view. With --between,\n"
        "--pairs or --orbit: the same relief between the samples, "
        "DIR/tlTT.TTTT_plPPP.PPPP_tv..._pv....exr,\n"
        "the truth that btf-compare measures against.",
    .details = "Reliefs:" RELIEF_LIST(
        RELIEF_LINE) "\n\n"
                     "Values are radiance over (normal-incidence irradiance / pi), cosine included: a "
                     "white Lambertian\n"
                     "lit from l holds l.z. 8-bit and 16-bit images clip at 1.",
    .example = "btf-sample -o bricks --truth bricks-truth\n"
               "btf-sample -o bricks-between --between 200\n"
               "btf-sample -o bricks-orbit --orbit light:360:60 --fixed 20,0\n"
               "btf-sample -o tiny --relief axes --size 32 --views 0:1,45:4 --lights small --format exr",
    .options = table,
};

static bool is_between(void) {
    return options.between || options.pairs || options.orbit;
}

/* Refuses options that exclude one another. */
static btf_result check_between(const enc_context *context) {
    if ((options.between != 0) + (options.pairs != NULL) + (options.orbit != PAIRS_NO_ORBIT) > 1) {
        return enc_fail(context, BTF_ERROR_USAGE, "one of --between, --pairs and --orbit is enough");
    }
    if (is_between() && (options.truth || options.views || options.lights)) {
        return enc_fail(context, BTF_ERROR_USAGE, "--%s is for a grid, not for single pairs",
                        options.truth   ? "truth"
                        : options.views ? "views"
                                        : "lights");
    }
    if (is_between() && options.noise > 0) {
        return enc_fail(context, BTF_ERROR_USAGE, "--noise is for a grid: single pairs are the truth, without noise");
    }
    if (options.fixed[0] > 85) {
        return enc_fail(context, BTF_ERROR_USAGE, "--fixed: theta %g is not in 0..85", options.fixed[0]);
    }
    return BTF_OK;
}

static btf_result make_pairs(const enc_context *context, sample_pair **out_pairs, int *out_count) {
    if (options.pairs) {
        return pairs_read(context, options.pairs, out_pairs, out_count);
    }
    *out_count = options.orbit ? options.frames : options.between;
    return options.orbit
               ? pairs_turn(context, options.orbit, options.frames, options.orbit_theta,
                            enc_direction_from_angles(options.fixed[0], options.fixed[1]), out_pairs)
               : pairs_random(context, options.between, (uint32_t)options.pair_seed, out_pairs);
}

/* Single images between the samples. */
static btf_result run_pairs(const images_job *j, const enc_context *context) {
    sample_pair *pairs = NULL;
    int count = 0;
    btf_result result = make_pairs(context, &pairs, &count);
    if (result == BTF_OK) {
        result = images_make_folder(context, options.out);
    }
    if (result == BTF_OK && options.orbit) {
        result = pairs_write_table(context, options.out, images_extension(j->format), pairs, count);
    }
    if (result == BTF_OK) {
        result = images_write_pairs(j, pairs, count, options.orbit != PAIRS_NO_ORBIT);
    }
    if (result == BTF_OK && !options.quiet) {
        printf("%s: %s, %dx%d texels, %d pairs of view and light\n", options.out,
               relief_kind_name((relief_kind)options.relief), options.size[0], options.size[1], count);
    }
    free(pairs);
    return result;
}

/* A grid of views and lights. */
static btf_result run_grid(images_job *j, const enc_context *context) {
    const sample_options *o = sample_scene_options(j->scene);
    btf_result result = images_make_folder(context, options.out);
    if (result == BTF_OK && options.truth) {
        result = images_make_folder(context, options.truth);
    }
    if (result == BTF_OK && options.truth) {
        result = sample_truth_create(j->scene, &j->truth);
    }
    if (result == BTF_OK) {
        result = images_write_grid(j);
    }
    if (result == BTF_OK && j->truth) {
        result = truth_files_write(j->scene, j->truth, options.truth);
    }
    if (result == BTF_OK && !options.quiet) {
        printf("%s: %s, %dx%d texels, %d views, %d lights, depth %.4f%s%s\n", options.out,
               relief_kind_name(o->relief), o->width, o->height, o->n_views, o->n_lights,
               sample_scene_relief(j->scene)->depth, options.truth ? ", truth in " : "",
               options.truth ? options.truth : "");
    }
    return result;
}

static btf_result run(const enc_context *context) {
    if (is_between() && !options.has_format) {
        options.format = IMAGES_EXR;
    }
    images_job j = {.context = context,
                    .folder = options.out,
                    .format = (images_format)options.format,
                    .quality = options.quality,
                    .camera = {options.exposure, options.noise, (uint32_t)options.seed}};
    sample_scene *scene = NULL;
    enc_direction *views = NULL, *lights = NULL;
    sample_options o = {.context = context,
                        .relief = (relief_kind)options.relief,
                        .seed = (uint32_t)options.seed,
                        .width = options.size[0],
                        .height = options.size[1],
                        .supersample = options.supersample,
                        .grid = options.grid};
    const char *list = is_between() ? "0:1" : options.directions; /* pairs have directions of their own */
    btf_result result = check_between(context);
    if (result == BTF_OK) {
        result = directions_parse(context, options.views ? options.views : list, &views, &o.n_views);
    }
    if (result == BTF_OK) {
        result = directions_parse(context, options.lights ? options.lights : list, &lights, &o.n_lights);
    }
    o.views = views;
    o.lights = lights;
    if (result == BTF_OK && strlen(options.out) > PATH_MAX - 128) {
        result = enc_fail(context, BTF_ERROR_USAGE, "-o: the path is longer than %d", PATH_MAX - 128);
    }
    if (result == BTF_OK) {
        result = sample_scene_create(&o, &scene);
    }
    if (result == BTF_OK) {
        j.scene = scene;
        result = is_between() ? run_pairs(&j, context) : run_grid(&j, context);
    }
    sample_truth_destroy(&j.truth);
    sample_scene_destroy(&scene);
    free(views);
    free(lights);
    return result;
}

int main(int argc, char **argv) {
    cli_arguments arguments;
    int exit_code;
    if (!cli_parse(&program, argc, argv, &arguments, &exit_code)) {
        return exit_code;
    }
    if (!options.out || !*options.out) {
        return cli_finish(&program, cli_error(&program, BTF_ERROR_USAGE, "-o DIR is missing"));
    }
    progress *p = progress_create(options.quiet);
    if (!p) {
        return cli_finish(&program, cli_error(&program, BTF_ERROR_MEMORY, "out of memory"));
    }
    enc_context context = {.log = cli_log(&program, options.quiet),
                           .progress = p,
                           .threads = options.threads ? options.threads : omp_get_num_procs()};
    btf_result result = run(&context);
    progress_destroy(&p);
    return cli_finish(&program, result);
}
