/* The command line of btf-bench. See command_line.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "command_line.h"

#include "encoder/input/options.h"

#include <stdio.h>
#include <string.h>

bench_options bench_given = {.out = "bench", .texels = 24, .rank = 400};

static const char *parse_input(const char *text, void *value) {
    (void)value;
    if (bench_given.count == BENCH_MAX_MATERIALS) {
        return "at most 64 materials";
    }
    bench_given.materials[bench_given.count++] = (bench_material){.input = text};
    return NULL;
}

static const char *parse_pairs(const char *text, void *value) {
    (void)value;
    bench_material *last = bench_given.count > 0 ? &bench_given.materials[bench_given.count - 1] : NULL;
    if (!last || !last->input || last->pairs) {
        return "a path, given after the --input that it belongs to";
    }
    last->pairs = text;
    return NULL;
}

/* The next word of a comma-separated list, in `word`; false at its end. */
static bool next_word(const char **text, char *word, size_t size) {
    const size_t length = strcspn(*text, ",");
    snprintf(word, size, "%.*s", (int)length, *text);
    *text += length + ((*text)[length] == ',');
    return length > 0;
}

static const char *parse_materials(const char *text, void *value) {
    char word[32];
    (void)value;
    while (next_word(&text, word, sizeof word)) {
        const relief_kind kind = relief_kind_from_name(word);
        if (kind == RELIEF_COUNT || bench_given.count == BENCH_MAX_MATERIALS) {
            return "names of bricks, bumps, weave, flat, white, axes, with commas between";
        }
        bench_given.materials[bench_given.count++] = (bench_material){.relief = kind};
    }
    return NULL;
}

static const char *parse_presets(const char *text, void *value) {
    char word[32];
    (void)value;
    while (next_word(&text, word, sizeof word)) {
        int i = 0;
        while (i < BENCH_PRESETS && strcmp(word, bench_preset_names[i]) != 0) {
            i++;
        }
        if (i == BENCH_PRESETS) {
            return "names of fast, medium, thorough, exhaustive, with commas between";
        }
        bench_given.presets[i] = true;
    }
    return NULL;
}

static const char *parse_only(const char *text, void *value) {
    char word[32];
    (void)value;
    while (next_word(&text, word, sizeof word)) {
        int i = 0;
        while (i < BENCH_SECTIONS && strcmp(word, bench_sections[i].name) != 0) {
            i++;
        }
        if (i == BENCH_SECTIONS) {
            return "names of machine, encode, decode, storage, between, growth, fit, codecs, lowbit, holdout, "
                   "plan, costs, stochastic, shaders, with commas between";
        }
        bench_given.sections[i] = true;
    }
    return NULL;
}

/* In the order of the bits BENCH_METHOD. */
static const char *const method_names[] = {"joint", "paper", "peers", "reference"};
enum { METHODS = sizeof method_names / sizeof method_names[0] };

static const char *parse_methods(const char *text, void *value) {
    char word[32];
    (void)value;
    while (next_word(&text, word, sizeof word)) {
        int i = 0;
        while (i < METHODS && strcmp(word, method_names[i]) != 0) {
            i++;
        }
        if (i == METHODS) {
            return "names of joint, paper, peers, reference, with commas between";
        }
        bench_given.methods |= 1u << i;
    }
    return bench_given.methods & (BENCH_METHOD_JOINT | BENCH_METHOD_PAPER) ? NULL
                                                                           : "one of joint, paper at least";
}

static const cli_option table[] = {
    {.name = "input",
     .arg = "DATA",
     .type = CLI_CUSTOM,
     .parse = parse_input,
     .help = "folder or archive of images; may be given again for more"},
    {.name = "pairs",
     .arg = "PAIRS",
     .type = CLI_CUSTOM,
     .parse = parse_pairs,
     .help = "folder or archive of the true images between the samples of the\n"
             "--input before it (btf-compare --help); without it, accuracy there\n"
             "is estimated by leaving out each view and light, and built-in\n"
             "samples are ray-cast at 100 random pairs"},
    {.name = "materials",
     .arg = "NAMES",
     .type = CLI_CUSTOM,
     .parse = parse_materials,
     .help = "built-in samples, e.g. bricks,bumps,weave; default bricks\nwhere no --input is given"},
    {.name = "out",
     .arg = "DIR",
     .type = CLI_STRING,
     .value = &bench_given.out,
     .help = "folder for CSV files, plots and summary.md; default bench"},
    {.name = "quick",
     .type = CLI_FLAG,
     .value = &bench_given.quick,
     .help =
         "under 10 minutes on 2 idle cores: the sections machine, encode,\ndecode, storage and growth with "
         "fewer settings, samples of\n32x32 texels, data cut to 32x32, encodes once"},
    {.name = "repeats",
     .arg = "N",
     .type = CLI_INT,
     .value = &bench_given.repeats,
     .given = &bench_given.repeats_given,
     .minimum = 1,
     .maximum = BENCH_MOST_REPEATS,
     .help =
         "times that an encode is repeated; default 3, with --quick 1;\ndecodes are repeated 5 times at "
         "least"},
    {.name = "holdout",
     .arg = "WHICH",
     .type = CLI_CHOICE,
     .value = &bench_given.holdout,
     .choices = "none|ring",
     .help = "none (default): all directions are encoded; ring: every second\nazimuth of the ring at 45 "
             "degrees is "
             "left out of encoding, and all\naccuracy is measured there too"},
    {.name = "only",
     .arg = "SECTIONS",
     .type = CLI_CUSTOM,
     .given = &bench_given.only,
     .parse = parse_only,
     .help = "run some sections: machine, encode, decode, storage, between,\ngrowth, fit, codecs, lowbit, holdout, "
             "plan, costs, stochastic, shaders; default all"},
    {.name = "preset",
     .arg = "PRESETS",
     .type = CLI_CUSTOM,
     .given = &bench_given.presets_given,
     .parse = parse_presets,
     .help = "of --method joint, one or more, with commas between; default:\n"
             "all in the section encode, medium in the others (the section\n"
             "decode takes the first alone)"},
    {.name = "device",
     .arg = "NAME",
     .type = CLI_STRING,
     .value = &bench_given.device,
     .help = "decode on this GL device of btf-conform --list; default all of\n"
             "them, with --quick one for each shading language"},
    {.name = "methods",
     .arg = "NAMES",
     .type = CLI_CUSTOM,
     .parse = parse_methods,
     .help = "section decode: some of joint, paper, peers, reference (the decoder\non the CPU); section "
             "plan: of joint, paper; default all"},
    {.name = "keep",
     .arg = "DIR",
     .type = CLI_STRING,
     .value = &bench_given.keep,
     .help = "section plan: take NAME-joint-PRESET.btf.exr (--levels 4) and\nNAME-paper.btf.exr from this "
             "folder, or encode them once and put\nthem there"},
    {.name = "budget",
     .type = CLI_BYTES,
     .value = &bench_given.budget,
     .help = "GPU bytes a codec may take; default what the paper's layout\ntakes (2.36 MB for 64x64, 81 "
             "directions), at most\n62.5 kB times the root of the number of texels"},
    {.name = "rank",
     .type = CLI_INT,
     .value = &bench_given.rank,
     .minimum = 1,
     .maximum = 2000,
     .help = "components of the largest PCA; default 400"},
    {.name = "texels",
     .type = CLI_INT,
     .value = &bench_given.texels,
     .minimum = 1,
     .maximum = 100000,
     .help = "texels that the fit is compared on; default 24"},
    ENC_INPUT_OPTIONS(bench_given.read),
    {.name = "threads",
     .type = CLI_INT,
     .value = &bench_given.threads,
     .minimum = 1,
     .maximum = 1024,
     .help = "default: all cores"},
    {.short_name = 'q',
     .name = "quiet",
     .type = CLI_FLAG,
     .value = &bench_given.quiet,
     .help = "no progress"},
    {.type = CLI_END},
};

const cli_program bench_program = {
    .name = "btf-bench",
    .usage = "[OPTION...]",
    .summary = "Measures the parts of OpenBTF beside their peers, in one run on one machine: ratios are "
               "what counts.\n"
               "A slow run informs and never fails.",
    .example = "btf-bench --input BRICKS64.zip --only codecs,holdout --out bench\n"
               "btf-bench --materials bricks,bumps,weave --size 32x32 --preset fast\n"
               "btf-bench --only growth --size 64x64 --repeats 1\n"
               "btf-bench --input BRICKS64.zip --only decode --device osmesa --methods joint,paper,peers",
    .options = table,
    .max_arguments = 0,
};
