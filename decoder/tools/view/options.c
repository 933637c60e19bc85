/* btf-view's command line. See options.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "options.h"

#include "decoder/toolkit/decode_options.h"
#include "decoder/toolkit/filter.h"
#include "decoder/toolkit/scene_option.h"
#include <openbtf/material.h>

view_settings view_options = {
    .plan = -1, .tolerance = 0.5, .screenshots = "btf-view", .size = {800, 800}, .effects = BTF_EFFECT_ALL};

static const cli_option option_table[] = {
    {.name = "mesh",
     .arg = "MESH",
     .type = CLI_STRING,
     .value = &view_options.mesh,
     .help = "sphere (default), plane, torus, drape, or a Wavefront file *.obj"},
    {.name = "original",
     .arg = "DATA",
     .type = CLI_STRING,
     .value = &view_options.original,
     .help = "directory or zip of the images that the material was made from, for the\n"
             "split screen"},
    {.name = "size",
     .type = CLI_SIZE,
     .value = view_options.size,
     .minimum = 16,
     .maximum = 8192,
     .help = "of the window (default 800x800)"},
    {.name = "effects",
     .type = CLI_EFFECTS,
     .value = &view_options.effects,
     .help = "effects to begin with (default all)"},
    {INTERPOLATION_OPTION, .value = &view_options.interpolation},
    {FILTER_OPTION, .value = &view_options.filter},
    {MATH_OPTION, .value = &view_options.math},
    {.name = "level",
     .type = CLI_CHOICE,
     .choices = "auto|0",
     .value = &view_options.level,
     .help = "level of detail, of a file that has several: by pixel (default), or the\n"
             "finest"},
    {.name = "plan",
     .arg = "auto|none",
     .type = CLI_CHOICE,
     .choices = "auto|none",
     .value = &view_options.plan,
     .help = "auto: upload and decode only what the view needs, and make a new plan when\n"
             "the view leaves the range of the present one; under a light that rests, a\n"
             "flat model is drawn from a texture with the light folded in (--verbose\n"
             "tells); default none"},
    {.name = "tolerance",
     .arg = "DB",
     .type = CLI_DOUBLE,
     .value = &view_options.tolerance,
     .minimum = 0,
     .maximum = 100,
     .help = "what --plan may lose against the full decode, predicted; default 0.5"},
    {.name = "costs", .arg = "FILE", .type = CLI_STRING, .value = &view_options.costs_file, .help = COSTS_OPTION_HELP},
    {.name = "screenshots",
     .arg = "PREFIX",
     .type = CLI_STRING,
     .value = &view_options.screenshots,
     .help = "key P writes PREFIX-0001.png and so on (default btf-view)"},
    {.name = "verbose",
     .type = CLI_FLAG,
     .value = &view_options.verbose,
     .help = "print every change on stdout"},
    {.short_name = 'q',
     .name = "quiet",
     .type = CLI_FLAG,
     .value = &view_options.quiet,
     .help = "no progress while reading images"},
    {.type = CLI_END},
};

const cli_program view_program = {
    .name = "btf-view",
    .usage = "[FILE] [options]",
    .summary =
        "Shows a material file (*.btf.exr) on a model in a window. Press H for the keys; drop files into\n"
        "the window: another material or a model (*.obj).",
    .details =
        "Left drag turns the model, right drag (or Shift + left) moves the light, the wheel zooms.\n"
        "Keys: M model, 1..7 effects, 0 all of them, N nearest directions, B bilinear, X fast math,\n"
        "L levels of detail, S split screen (middle drag or [ ] move it), + - exposure, A animate,\n"
        "C measure the cost of each effect, P save a picture, I panel, R reset, H help, Q quit.",
    .example = "btf-view bricks.btf.exr --original BRICKS64.zip",
    .options = option_table,
    .max_arguments = 1,
};
