/* btf-render's command line. See settings.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "settings.h"

#include "decoder/toolkit/decode_options.h"
#include "decoder/toolkit/filter.h"
#include "light_option.h"
#include "picture.h"
#include <math.h>
#include <omp.h>
#include <openbtf/material.h>
#include <stdio.h>
#include <string.h>

settings render_options = {.mesh = "sphere",
                           .device = "osmesa",
                           .fov = 30,
                           .env_gain = 1,
                           .effects = BTF_EFFECT_ALL,
                           .size = {512, 512},
                           .samples = 1,
                           .spp = 1,
                           .env_lights = 64,
                           .components = BTF_MAX_COMPONENTS,
                           .frames = 1,
                           .level = -1,
                           .plan = -1,
                           .tolerance = 0.5,
                           .repeats = 9};

static const char *parse_size(const char *text, void *value) {
    int *size = value;
    const char *end;
    if (!cli_parse_int(text, "x", &size[0], &end) ||
        (*end && !cli_parse_int(end + 1, "", &size[1], NULL))) {
        return "N or WxH, each 1..8192";
    }
    if (!*end) {
        size[1] = size[0];
    }
    return size[0] >= 1 && size[0] <= 8192 && size[1] >= 1 && size[1] <= 8192 ? NULL
                                                                              : "N or WxH, each 1..8192";
}

static const char *parse_view(const char *text, void *value) {
    double view[2];
    if (cli_parse_doubles(text, view, 2) != 2 ||
        !(view[0] >= 0 && view[0] <= 180 && fabs(view[1]) <= 360)) {
        return "theta,phi in degrees, theta 0..180, phi -360..360";
    }
    memcpy(value, view, sizeof view);
    return NULL;
}

static const char *parse_level(const char *text, void *value) {
    int *level = value;
    if (!strcmp(text, "auto")) {
        *level = -1;
        return NULL;
    }
    return cli_parse_int(text, "", level, NULL) && *level >= 0 ? NULL : "auto, or a level from 0";
}

static const char *parse_light(const char *text, void *value) {
    settings *options = value;
    if (strcmp(text, "environment") != 0) {
        return strchr("0123456789.+- ", text[0]) ? light_parse_directional(text, &options->lights)
                                                 : "theta,phi[,intensity[,r,g,b]], or environment";
    }
    options->env_sampled = true;
    return NULL;
}

static const cli_option option_table[] = {
    {.short_name = 'o',
     .name = "output",
     .arg = "OUT",
     .type = CLI_STRING,
     .value = &render_options.out,
     .help = "picture to write: .png (sRGB, 8 bits) or .exr (linear float)"},
    {.name = "mesh",
     .arg = "MESH",
     .type = CLI_STRING,
     .value = &render_options.mesh,
     .help = "plane, sphere, torus, drape, or a Wavefront file *.obj with texture\n"
             "coordinates (default sphere)"},
    {.name = "repeat",
     .type = CLI_DOUBLE,
     .value = &render_options.repeat,
     .given = &render_options.repeat_given,
     .minimum = 0.001,
     .maximum = 1000,
     .help = "copies of the material along the mesh's unit of uv (default 3; plane, drape\n"
             "and OBJ 2)"},
    {.name = "size",
     .arg = "N|WxH",
     .type = CLI_CUSTOM,
     .value = render_options.size,
     .parse = parse_size,
     .help = "pixels (default 512)"},
    {.name = "samples",
     .type = CLI_INT,
     .value = &render_options.samples,
     .minimum = 1,
     .maximum = 8,
     .help = "N x N samples a pixel (default 1)"},
    {.name = "view",
     .type = CLI_CUSTOM,
     .arg = "T,P",
     .value = render_options.view,
     .parse = parse_view,
     .help = "where the camera stands, theta,phi in degrees: theta 0..180 from +z\n"
             "(default 0,0)"},
    {.name = "fov",
     .type = CLI_DOUBLE,
     .value = &render_options.fov,
     .minimum = 0,
     .maximum = 120,
     .help = "angle of view in degrees; 0: parallel projection (default 30)"},
    {.name = "zoom",
     .type = CLI_DOUBLE,
     .value = &render_options.zoom,
     .given = &render_options.zoom_given,
     .minimum = 0.01,
     .maximum = 100,
     .help = "the picture's smaller side spans 2/zoom at the origin (default 0.9; plane 1)"},
    {.name = "light",
     .arg = "T,P[,I[,R,G,B]]",
     .type = CLI_CUSTOM,
     .value = &render_options,
     .parse = parse_light,
     .help = "a light far away: direction, intensity, colour; may be given several times\n"
             "(default 40,120 when there is no other light). --light environment: directions\n"
             "drawn from --environment and the material, --spp of them a sample, in place of\n"
             "lights that stand for the map; noisy, and right in the mean"},
    {.name = "point",
     .arg = "X,Y,Z[,I[,R,G,B]]",
     .type = CLI_CUSTOM,
     .value = &render_options.lights,
     .parse = light_parse_point,
     .help = "a light at a point; intensity I / distance^2; may be given several times"},
    {.name = "environment",
     .arg = "MAP",
     .type = CLI_STRING,
     .value = &render_options.environment,
     .help = "light from a latitude-longitude map, .exr or Radiance .hdr"},
    {.name = "layer",
     .arg = "NAME",
     .type = CLI_STRING,
     .value = &render_options.environment_layer,
     .help = "of an .exr map: the layer, part, PART.LAYER or channel to read (default the\n"
             "first part's R, G, B, or the only ones)"},
    {.name = "environment-lights",
     .type = CLI_INT,
     .value = &render_options.env_lights,
     .given = &render_options.env_lights_given,
     .minimum = 1,
     .maximum = 1024,
     .help = "directional lights that stand for the map (default 64)"},
    {.name = "environment-rotate",
     .arg = "DEG",
     .type = CLI_DOUBLE,
     .value = &render_options.env_rotate,
     .minimum = -360,
     .maximum = 360,
     .help = "turns the map to the right (default 0)"},
    {.name = "environment-gain",
     .type = CLI_DOUBLE,
     .value = &render_options.env_gain,
     .minimum = 0,
     .maximum = 1e6,
     .help = "multiplies the map (default 1)"},
    {.name = "cast-shadows",
     .type = CLI_FLAG,
     .value = &render_options.cast_shadows,
     .help = "the mesh casts shadows on itself"},
    {.name = "background",
     .arg = "GREY",
     .type = CLI_DOUBLE,
     .value = &render_options.background,
     .minimum = 0,
     .maximum = 1e6,
     .help = "linear value behind the mesh (default 0)"},
    {.name = "exposure",
     .arg = "STOPS",
     .type = CLI_DOUBLE,
     .value = &render_options.exposure,
     .minimum = -30,
     .maximum = 30,
     .help = "multiplies the picture by 2^STOPS (default 0)"},
    {.name = "tone",
     .type = CLI_CHOICE,
     .choices = "none|reinhard|filmic",
     .value = &render_options.tone,
     .help = "tone curve of PNG output (default none: values are clipped at 1)"},
    {EFFECTS_OPTION, .value = &render_options.effects},
    {.name = "plan",
     .arg = "auto|none",
     .type = CLI_CHOICE,
     .value = &render_options.plan,
     .choices = "auto|none",
     .help = "auto: decode and upload only what the pictures need (btf-info --plan),\n"
             "one plan for each range of frames. On a flat mesh one directional light, and\n"
             "with --fov 0 the view, are the same in every pixel: the shader then holds\n"
             "their neighbours as constants, which does not change the picture"},
    {.name = "costs",
     .arg = "FILE",
     .type = CLI_STRING,
     .value = &render_options.costs_file,
     .help = "the prices of a GPU (JSON, openbtf/cost.h), as tests/bench/gpu.sh measures them,\n"
             "by which --plan and --fold auto choose; default those of llvmpipe"},
    {.name = "fold",
     .arg = "WHEN",
     .type = CLI_CHOICE,
     .value = &render_options.fold,
     .choices = "auto|always|never",
     .help = "whether to decode a light that is the same in every pixel, with --fov 0 the view\n"
             "as well, once for all pictures: auto (default) where that takes less time, always\n"
             "where it is defined, or never. A light alone cannot be folded where the material\n"
             "has an SBRDF or gloss, which depend on the view. The picture is the same. With the\n"
             "view, several lights far away are folded into their sum, in single precision,\n"
             "unless relief is decoded; without it, by a plan or always, into a sum that is not\n"
             "quite the same where roots are clamped (openbtf/fold.h, BTF_FOLD_SUM)"},
    {.name = "tolerance",
     .arg = "DB",
     .type = CLI_DOUBLE,
     .value = &render_options.tolerance,
     .minimum = 0,
     .maximum = 100,
     .help = "what --plan may lose against the full decode, predicted; default 0.5"},
    {COMPONENTS_OPTION, .value = &render_options.components},
    {INTERPOLATION_OPTION, .value = &render_options.interpolation,
     .given = &render_options.interpolation_given},
    {FILTER_OPTION, .value = &render_options.filter},
    {.name = "stochastic",
     .type = CLI_FLAG,
     .value = &render_options.stochastic,
     .help =
         "decode one view, light and texel, picked at random with its weight, in place of\nblending all"},
    {.name = "spp",
     .type = CLI_INT,
     .value = &render_options.spp,
     .given = &render_options.spp_given,
     .minimum = 1,
     .maximum = 65536,
     .help = "with --stochastic: picks a sample, of which the mean is taken (default 1); with\n"
             "--light environment: directions a sample (default 64), of one pick each where\n"
             "--stochastic is given too"},
    {.name = "level",
     .arg = "auto|N",
     .type = CLI_CUSTOM,
     .value = &render_options.level,
     .parse = parse_level,
     .help = "level of detail, of a file that has several: auto (default), by what a sample\n"
             "covers of the texture, or one for all"},
    {MATH_OPTION, .value = &render_options.math},
    {.name = "device",
     .type = CLI_STRING,
     .value = &render_options.device,
     .help = "reference (the CPU), osmesa (default), egl, glfw, or another of\n"
             "btf-conform's devices"},
    {.name = "figure13",
     .type = CLI_FLAG,
     .value = &render_options.figure13,
     .help = "original, SBRDF, SBRDF with shadow (STVS) and all effects side by side,\n"
             "errors x 4 below, PSNR on stdout; needs --original"},
    {.name = "original",
     .arg = "DATA",
     .type = CLI_STRING,
     .value = &render_options.original,
     .help = "directory or zip of the images that the material was made from"},
    {.name = "baseline",
     .arg = "FILE",
     .type = CLI_STRING,
     .value = &render_options.baseline,
     .help = "with --figure13: another material for SBRDF and STVS, decoded by the\n"
             "reference; needed when FILE has no SBRDF (method joint may leave it out)"},
    {.name = "animate",
     .type = CLI_CHOICE,
     .choices = "view|light",
     .value = &render_options.animate,
     .help = "what turns through 360 degrees of phi over the frames: the camera\n"
             "(default) or all lights"},
    {.name = "frames",
     .type = CLI_INT,
     .value = &render_options.frames,
     .minimum = 1,
     .maximum = 9999,
     .help = "pictures OUT.0001.png, OUT.0002.png, ... (default 1: OUT itself)"},
    {.name = "stats",
     .type = CLI_FLAG,
     .value = &render_options.stats,
     .help = "print times: a frame under one light, and a textured Phong shader over the\n"
             "same pixels (GL devices; median of 9)"},
    {.name = "threads",
     .type = CLI_INT,
     .value = &render_options.threads,
     .minimum = 1,
     .maximum = 1024,
     .help = "threads (default: all cores); the picture does not depend on it"},
    {QUIET_OPTION, .value = &render_options.quiet},
    {.type = CLI_END},
};

const cli_program render_program = {
    .name = "btf-render",
    .usage = "FILE -o OUT [options]",
    .summary = "Renders a material file (*.btf.exr) on a mesh. Visibility, texture coordinates, light and "
               "view are\n"
               "ray-cast once on the CPU; the device evaluates the material; the CPU adds up lights and\n"
               "samples and applies the tone curve.\n"
               "With exact math every device gives the same picture, pixel for pixel.",
    .details =
        "World: x to the right, y up, z towards the default camera; angles are theta from +z, phi from +x\n"
        "towards +y. Built-in meshes fill -1..1; an OBJ is centred and scaled to radius 1. A light of\n"
        "intensity 1 shows the material's own values (a white diffuse surface facing it is 1).",
    .example = "btf-render bricks.btf.exr -o sphere.png --light 40,120 --samples 2\n"
               "btf-render bricks.btf.exr -o teapot.png --mesh teapot.obj --environment sky.exr\n"
               "btf-render bricks.btf.exr -o figure13.png --figure13 --original BRICKS64.zip --mesh plane "
               "--view 40,-90\n"
               "btf-render bricks.btf.exr -o turn.png --frames 36 --animate light",
    .options = option_table,
    .min_arguments = 1,
    .max_arguments = 1,
};

btf_result settings_check(void) {
    if (!render_options.out) {
        return cli_error(&render_program, BTF_ERROR_USAGE,
                         "option --output is missing: a picture, .png or .exr");
    }
    if (!picture_knows(render_options.out)) {
        return cli_error(&render_program, BTF_ERROR_USAGE,
                         "option --output: '%s' ends neither in .png nor in .exr", render_options.out);
    }
    if (render_options.figure13 && !render_options.original) {
        return cli_error(&render_program, BTF_ERROR_USAGE,
                         "option --figure13: needs --original, the images that the material was made from");
    }
    if (!render_options.figure13 && (render_options.original || render_options.baseline)) {
        return cli_error(&render_program, BTF_ERROR_USAGE, "option --%s: only together with --figure13",
                         render_options.original ? "original" : "baseline");
    }
    if (render_options.figure13 && render_options.plan == 0) {
        return cli_error(&render_program, BTF_ERROR_USAGE, "option --plan: not together with --figure13");
    }
    if (render_options.figure13 && render_options.stochastic) {
        return cli_error(&render_program, BTF_ERROR_USAGE,
                         "option --stochastic: not together with --figure13");
    }
    if (render_options.env_sampled && !render_options.environment) {
        return cli_error(&render_program, BTF_ERROR_USAGE,
                         "option --light environment: needs --environment, a map");
    }
    if (render_options.env_sampled && render_options.env_lights_given) {
        return cli_error(
            &render_program, BTF_ERROR_USAGE,
            "option --environment-lights: not together with --light environment, which takes --spp");
    }
    if (render_options.spp_given && !render_options.stochastic && !render_options.env_sampled) {
        return cli_error(&render_program, BTF_ERROR_USAGE,
                         "option --spp: only together with --stochastic or --light environment");
    }
    if (render_options.env_sampled && !render_options.spp_given) {
        render_options.spp = 64;
    }
    if (render_options.figure13 && render_options.level > 0) {
        return cli_error(&render_program, BTF_ERROR_USAGE,
                         "option --level: %d, but --figure13 compares the original with level 0",
                         render_options.level);
    }
    if (render_options.environment && (render_options.env_lights & (render_options.env_lights - 1))) {
        return cli_error(&render_program, BTF_ERROR_USAGE,
                         "option --environment-lights: %d, expected a power of two",
                         render_options.env_lights);
    }
    if (render_options.threads == 0) {
        render_options.threads = omp_get_num_procs();
    }
    return BTF_OK;
}
