/* btf-info: the contents of a material file: sizes, directions, effects and the accuracy that each adds.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/tools/info/info_json.h"
#include "decoder/tools/info/info_plan.h"
#include "decoder/tools/info/info_text.h"
#include "decoder/toolkit/cli.h"
#include "decoder/toolkit/scene_option.h"
#include <openbtf/material.h>
#include <sys/stat.h>

static struct {
    const char *costs;
    bool json, plan;
    scene_option scene;
} options;

static const cli_option option_table[] = {
    {.name = "json", .type = CLI_FLAG, .value = &options.json, .help = "print JSON"},
    {.name = "plan",
     .arg = "SCENE",
     .type = CLI_CUSTOM,
     .value = &options.scene,
     .given = &options.plan,
     .parse = scene_option_parse,
     .help = "print the plan that btf_plan_effects makes for a scene. SCENE:\n" SCENE_OPTION_HELP},
    {.name = "costs",
     .arg = "FILE",
     .type = CLI_STRING,
     .value = &options.costs,
     .help = COSTS_OPTION_HELP},
    {.type = CLI_END},
};

static const cli_program program = {
    .name = "btf-info",
    .usage = "FILE [--json] [--plan SCENE [--costs FILE]]",
    .summary =
        "Shows the contents of a material file (*.btf.exr): its sizes, directions, effects, how much\n"
        "accuracy each effect adds (measured by the encoder), bytes by texture and how it was made.",
    .details =
        "Bytes 'gpu' are those of all textures that a decoder uploads, of all levels of detail; direction\n"
        "tables and scales of the residual are counted apart. The list of textures is that of level 0, "
        "with\n"
        "bytes divided by the texels of the material.\n"
        "Factors, the residual of format version 2, come in units; --components of btf-decode and\n"
        "btf-render, and plans, count units too. A unit has four words, each of one channel: Y, C1 or C2.\n"
        "Memory needed: the size of the file, and that of the textures.",
    .example = "btf-info bricks.btf.exr\nbtf-info bricks.btf.exr --plan views=0:30,lights=0:75,pixels=1.5",
    .options = option_table,
    .min_arguments = 1,
    .max_arguments = 1,
};

static btf_result run(const cli_arguments *arguments) {
    const char *path = arguments->values[0];
    btf_log log = cli_log(&program, false);
    btf_material *material = NULL;
    btf_cost_model costs;
    btf_result result = BTF_OK;
    if (options.costs && !options.plan) {
        return cli_error(&program, BTF_ERROR_USAGE, "option --costs: only together with --plan");
    }
    if (options.costs) {
        result = btf_cost_model_open(options.costs, &log, &costs);
    }
    options.scene.scene.costs = options.costs ? &costs : NULL;
    if (!result) {
        result = btf_material_open(path, &log, &material);
    }
    if (result) {
        return result;
    }
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    struct stat status;
    uint64_t file_bytes = stat(path, &status) == 0 && status.st_size > 0 ? (uint64_t)status.st_size : 0;
    if (options.plan) {
        result = print_plan(&program, path, material, &options.scene, options.json);
    } else if (options.json) {
        result = print_json(&program, path, file_bytes, material, &info);
    } else {
        print_text(path, file_bytes, material, &info);
    }
    btf_material_close(&material);
    return result;
}

int main(int argc, char **argv) {
    return cli_run(&program, argc, argv, run);
}
