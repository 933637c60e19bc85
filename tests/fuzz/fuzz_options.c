/* Fuzz target: a command line, one argument a line, against a table with every kind of option; and each line by itself
 * as a list of directions. An accepted value must lie within its range.
 *
 * SPDX-License-Identifier: MIT
 */
#include "fuzz.h"

#include "decoder/toolkit/cli.h"
#include "decoder/tools/render/light_option.h"
#include "decoder/tools/render/lights.h"
#include "decoder/toolkit/scene_option.h"
#include "encoder/input/options.h"
#include "encoder/job/settings.h"
#include "tests/sample/directions.h"

#include <math.h>
#include <openbtf/material.h>
#include <string.h>

enum { MOST = 64 };

static struct {
    const char *text;
    bool flag;
    int number, choice, size[2];
    double real, angles[2];
    uint64_t bytes;
    uint32_t effects, automatic;
    enc_read_options read;
    scene_option scene;
    double tolerance[2];
    int levels;
    light_list lights;
} o;

/* clang-format off */
static const cli_option table[] = {
    {.short_name = 'o', .name = "output", .type = CLI_STRING, .value = &o.text, .help = "a text"},
    {.short_name = 'q', .name = "quiet", .type = CLI_FLAG, .value = &o.flag, .help = "a flag"},
    {.name = "number", .type = CLI_INT, .value = &o.number, .minimum = -5, .maximum = 1024,
     .help = "an int"},
    {.name = "choice", .type = CLI_CHOICE, .value = &o.choice, .choices = "fast|medium|thorough",
     .help = "a word"},
    {.name = "size", .type = CLI_SIZE, .value = o.size, .minimum = 1, .maximum = 16384, .help = "a size"},
    {.name = "real", .type = CLI_DOUBLE, .value = &o.real, .minimum = 0.5, .maximum = 1e6,
     .help = "a number"},
    {.name = "bytes", .type = CLI_BYTES, .value = &o.bytes, .help = "a number of bytes"},
    {.name = "view", .type = CLI_ANGLES, .value = o.angles, .help = "a direction"},
    {.name = "effects", .type = CLI_EFFECTS, .value = &o.effects, .help = "effects"},
    {.name = "auto", .type = CLI_EFFECTS, .value = &o.automatic, .choices = "auto",
     .help = "effects, or auto"},
    {.name = "transfer", .type = CLI_CUSTOM, .value = &o.read, .parse = enc_parse_transfer,
     .help = "a curve"},
    {.name = "colour", .type = CLI_CUSTOM, .value = &o.read, .parse = enc_parse_colour, .help = "a space"},
    {.name = "crop", .type = CLI_CUSTOM, .value = &o.read, .parse = enc_parse_crop, .help = "a rectangle"},
    {.name = "scene", .type = CLI_CUSTOM, .value = &o.scene, .parse = scene_option_parse,
     .help = "a scene"},
    {.name = "tolerance", .type = CLI_CUSTOM, .value = o.tolerance, .parse = enc_parse_tolerance,
     .help = "one or two numbers"},
    {.name = "levels", .type = CLI_CUSTOM, .value = &o.levels, .parse = enc_parse_levels,
     .help = "levels"},
    {.name = "cosine", .type = CLI_CUSTOM, .value = &o.read, .parse = enc_parse_cosine, .help = "a word"},
    {.name = "light", .type = CLI_CUSTOM, .value = &o.lights, .parse = light_parse_directional,
     .help = "a directional light"},
    {.name = "point", .type = CLI_CUSTOM, .value = &o.lights, .parse = light_parse_point,
     .help = "a light"},
    {.type = CLI_END},
};
/* clang-format on */

static const cli_program program = {.name = "fuzz",
                                    .usage = "ARGUMENT... [OPTION...]",
                                    .summary = "Every kind of option.",
                                    .example = "fuzz x",
                                    .options = table,
                                    .min_arguments = 0,
                                    .max_arguments = 8};

static void check_range(const btf_range *r) {
    const float *d = r->direction;
    FUZZ_CHECK(!r->fixed || (d[2] > 0 && fabsf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - 1) < 1e-5f));
    FUZZ_CHECK(r->theta[0] >= 0 && r->theta[0] <= r->theta[1] && r->theta[1] <= 90);
    FUZZ_CHECK(fabsf(r->phi[0]) <= 360 && fabsf(r->phi[1]) <= 360);
}

static void check_values(void) {
    FUZZ_CHECK(o.tolerance[0] >= 0 && o.tolerance[0] <= 100 && o.tolerance[1] >= 0 &&
               o.tolerance[1] <= 1e6);
    FUZZ_CHECK(o.scene.tolerance >= 0 && o.scene.tolerance <= 1e6f);
    FUZZ_CHECK(o.scene.scene.pixels >= 0 && o.scene.scene.pixels <= 1e6f);
    check_range(&o.scene.scene.view);
    check_range(&o.scene.scene.light);
    FUZZ_CHECK(o.levels >= 0 && o.levels <= BTF_MAX_LEVELS);
    FUZZ_CHECK(o.lights.count < MOST);
    for (size_t i = 0; i < o.lights.count; i++) {
        const light *l = &o.lights.lights[i];
        FUZZ_CHECK(isfinite(l->at.x) && isfinite(l->at.y) && isfinite(l->at.z));
        FUZZ_CHECK(l->is_point || fabs(vec_length(l->at) - 1) < 1e-6);
        for (int c = 0; c < 3; c++) {
            FUZZ_CHECK(l->colour[c] >= 0 && l->colour[c] <= 1e12);
        }
    }
    FUZZ_CHECK(o.number >= -5 && o.number <= 1024);
    FUZZ_CHECK(o.choice >= 0 && o.choice < 3);
    FUZZ_CHECK(o.size[0] >= 1 && o.size[0] <= 16384 && o.size[1] >= 1 && o.size[1] <= 16384);
    FUZZ_CHECK(o.real >= 0.5 && o.real <= 1e6);
    FUZZ_CHECK(o.angles[0] >= 0 && o.angles[0] <= 90 && fabs(o.angles[1]) <= 360);
    FUZZ_CHECK(o.effects <= BTF_EFFECT_ALL);
    FUZZ_CHECK(o.automatic <= BTF_EFFECT_ALL || o.automatic == UINT32_MAX);
    FUZZ_CHECK(o.read.transfer != ENC_TRANSFER_GAMMA || (o.read.gamma >= 0.1 && o.read.gamma <= 10));
    FUZZ_CHECK(o.read.crop[0] >= 0 && o.read.crop[1] >= 0 && o.read.crop[2] >= 0 && o.read.crop[3] >= 0);
}

static void check_directions(const char *text) {
    enc_direction *list = NULL;
    int count = 0;
    const enc_context context = {.threads = 1};
    if (directions_parse(&context, text, &list, &count) != BTF_OK) {
        return;
    }
    FUZZ_CHECK(count >= 1 && count <= DIRECTIONS_MAX);
    for (int i = 0; i < count; i++) {
        char angle[16];
        FUZZ_CHECK(list[i].theta >= 0 && list[i].theta <= 85 && list[i].phi >= 0 && list[i].phi < 360);
        FUZZ_CHECK(list[i].xyz[2] > 0 && isfinite(list[i].xyz[0]) && isfinite(list[i].xyz[1]));
        directions_format_angle(list[i].phi, angle);
    }
    free(list);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    char *text = malloc(size + 1), *lines[MOST + 1] = {(char[]){"fuzz"}};
    FUZZ_CHECK(text != NULL);
    if (size) {
        memcpy(text, data, size);
    }
    text[size] = '\0';
    int count = 1;
    for (char *line = text; line && count < MOST; line = strchr(line, '\n')) {
        if (*line == '\n') {
            *line++ = '\0';
        }
        lines[count++] = line;
    }
    for (int i = 1; i < count; i++) {
        check_directions(lines[i]);
    }
    memset(&o, 0, sizeof o);
    o.size[0] = o.size[1] = 1;
    o.real = 1;
    cli_arguments arguments = {0};
    int exit_code = -1;
    if (cli_parse(&program, count, lines, &arguments, &exit_code)) {
        FUZZ_CHECK(arguments.count >= 0 && arguments.count <= 8);
    } else {
        FUZZ_CHECK(exit_code == 0 || exit_code == 1);
    }
    check_values();
    light_list_clear(&o.lights);
    free(text);
    return 0;
}
