/* btf-bench: measures what the parts cost and what they buy, beside their peers, in one run.
 *
 * SPDX-License-Identifier: MIT
 */
#include "bench.h"

#include "decoder/tools/cli.h"
#include "decoder/tools/progress.h"
#include "encoder/input_options.h"
#include "encoder/reader.h"
#include "tests/sample/sample.h"

#include <errno.h>
#include <omp.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

static const struct {
    const char *name, *what;
    bench_section_fn run;
} sections[] = {
    {"fit", "the Lafortune fit beside a Ceres problem with automatic derivatives", bench_section_fit},
    {"codecs", "accuracy at equal bytes, and bytes at equal accuracy, beside principal components",
     bench_section_codecs},
    {"holdout", "accuracy at directions that the encoder did not see", bench_section_holdout},
    {"decode", "nanoseconds a pixel of every shader variant, beside its floor, fast math and peers",
     bench_section_decode},
};
enum { SECTIONS = sizeof sections / sizeof sections[0], MAX_MATERIALS = 64 };

static const char *const preset_names[BENCH_PRESETS] = {"fast", "medium", "thorough", "exhaustive"};

/* Comma-separated names as bits. */
typedef struct name_set {
    bool sections[SECTIONS], presets[BENCH_PRESETS];
} name_set;

/* A file, a folder, or the name of a built-in relief. */
typedef struct material {
    const char *input;
    relief_kind relief; /* where input is NULL */
} material;

static struct {
    const char *out;
    material materials[MAX_MATERIALS];
    int count, threads, texels, rank;
    name_set set;
    bool only, presets_given, quiet;
    uint64_t budget;
    enc_read_options read;
} o = {.out = "bench", .texels = 24, .rank = 400};

static const char *parse_input(const char *text, void *value) {
    (void)value;
    if (o.count == MAX_MATERIALS) {
        return "at most 64 materials";
    }
    o.materials[o.count++] = (material){.input = text};
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
        if (kind == RELIEF_COUNT || o.count == MAX_MATERIALS) {
            return "names of bricks, bumps, weave, flat, white, axes, with commas between";
        }
        o.materials[o.count++] = (material){.relief = kind};
    }
    return NULL;
}

static const char *parse_presets(const char *text, void *value) {
    char word[32];
    (void)value;
    while (next_word(&text, word, sizeof word)) {
        int i = 0;
        while (i < BENCH_PRESETS && strcmp(word, preset_names[i]) != 0) {
            i++;
        }
        if (i == BENCH_PRESETS) {
            return "names of fast, medium, thorough, exhaustive, with commas between";
        }
        o.set.presets[i] = true;
    }
    return NULL;
}

static const char *parse_only(const char *text, void *value) {
    char word[32];
    (void)value;
    while (next_word(&text, word, sizeof word)) {
        int i = 0;
        while (i < SECTIONS && strcmp(word, sections[i].name) != 0) {
            i++;
        }
        if (i == SECTIONS) {
            return "names of fit, codecs, holdout, decode, with commas between";
        }
        o.set.sections[i] = true;
    }
    return NULL;
}

static const cli_option table[] = {
    {.name = "input",
     .arg = "DATA",
     .type = CLI_CUSTOM,
     .parse = parse_input,
     .help = "folder or archive of images; may be given again for more"},
    {.name = "materials",
     .arg = "NAMES",
     .type = CLI_CUSTOM,
     .parse = parse_materials,
     .help = "built-in samples, e.g. bricks,bumps,weave; default bricks\nwhere no --input is given"},
    {.name = "out",
     .arg = "DIR",
     .type = CLI_STRING,
     .value = &o.out,
     .help = "folder for CSV files, plots and summary.md; default bench"},
    {.name = "only",
     .arg = "SECTIONS",
     .type = CLI_CUSTOM,
     .given = &o.only,
     .parse = parse_only,
     .help = "run some sections: fit, codecs, holdout, decode; default all"},
    {.name = "preset",
     .arg = "PRESETS",
     .type = CLI_CUSTOM,
     .given = &o.presets_given,
     .parse = parse_presets,
     .help = "of --method joint, one or more, with commas between;\ndefault medium"},
    {.name = "budget",
     .type = CLI_BYTES,
     .value = &o.budget,
     .help = "GPU bytes a codec may take; default what the paper's layout\ntakes (2.36 MB for 64x64, 81 "
             "directions)"},
    {.name = "rank",
     .type = CLI_INT,
     .value = &o.rank,
     .minimum = 1,
     .maximum = 2000,
     .help = "components of the largest PCA; default 400"},
    {.name = "texels",
     .type = CLI_INT,
     .value = &o.texels,
     .minimum = 1,
     .maximum = 100000,
     .help = "texels that the fit is compared on; default 24"},
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
    .name = "btf-bench",
    .usage = "[OPTION...]",
    .summary = "Measures the parts of OpenBTF beside their peers, in one run on one machine: ratios are "
               "what counts.\n"
               "A slow run informs and never fails.",
    .example = "btf-bench --input BRICKS64.zip --only codecs,holdout --out bench\n"
               "btf-bench --materials bricks,bumps,weave --size 32x32 --preset fast",
    .options = table,
    .max_arguments = 0,
};

static btf_result get_data(const enc_context *context, const material *m, enc_data **out_data) {
    if (m->input) {
        return enc_read(context, m->input, &o.read, out_data);
    }
    const sample_options options = {
        .context = context, .relief = m->relief, .width = o.read.size[0], .height = o.read.size[1]};
    return sample_render(&options, out_data, NULL);
}

/* The last part of a path without its extension, in characters that suit a file name. */
static void short_name(const char *path, char *name, size_t size) {
    size_t length = strlen(path);
    while (length > 1 && path[length - 1] == '/') {
        length--;
    }
    size_t start = length;
    while (start > 0 && path[start - 1] != '/') {
        start--;
    }
    snprintf(name, size, "%.*s", (int)(length - start), path + start);
    char *dot = strrchr(name, '.');
    if (dot && dot > name) {
        *dot = 0;
    }
    for (char *c = name; *c; c++) {
        const bool plain = (*c >= '0' && *c <= '9') || (*c >= 'A' && *c <= 'Z') || (*c >= 'a' && *c <= 'z');
        *c = plain || *c == '-' ? *c : '_';
    }
}

static btf_result run_material(const enc_context *context, const material *m, FILE *summary) {
    char name[128], source[256];
    enc_data *data = NULL;
    short_name(m->input ? m->input : relief_kind_name(m->relief), name, sizeof name);
    btf_result result = get_data(context, m, &data);
    if (result == BTF_OK) {
        snprintf(source, sizeof source, "%s%s, %dx%d texels, %d views, %d lights",
                 m->input ? "" : "btf-sample ", name, data->width, data->height, data->n_views,
                 data->n_lights);
    }
    bench_run bench = {.context = context,
                       .data = data,
                       .source = source,
                       .name = name,
                       .out = o.out,
                       .texels = o.texels,
                       .budget = o.budget,
                       .rank = o.rank,
                       .summary = summary};
    memcpy(bench.presets, o.set.presets, sizeof bench.presets);
    for (int i = 0; result == BTF_OK && i < SECTIONS; i++) {
        if (!o.only || o.set.sections[i]) {
            fprintf(summary, "## %s: %s\n\n%s; data: %s; %d cores.\n\n", sections[i].name, name,
                    sections[i].what, bench.source, omp_get_num_procs());
            result = sections[i].run(&bench);
            fflush(summary);
        }
    }
    enc_data_destroy(&data);
    return result;
}

static btf_result run(const enc_context *context) {
    char path[4096];
    if (mkdir(o.out, 0777) != 0 && errno != EEXIST) {
        return cli_error(&program, BTF_ERROR_IO, "%s: cannot make the folder: %s", o.out, strerror(errno));
    }
    snprintf(path, sizeof path, "%s/summary.md", o.out);
    FILE *summary = fopen(path, "w");
    if (!summary) {
        return cli_error(&program, BTF_ERROR_IO, "%s: %s", path, strerror(errno));
    }
    btf_result result = BTF_OK;
    for (int i = 0; i < o.count && result == BTF_OK; i++) {
        result = run_material(context, &o.materials[i], summary);
    }
    if (fclose(summary) != 0 && result == BTF_OK) {
        result = cli_error(&program, BTF_ERROR_IO, "%s: %s", path, strerror(errno));
    }
    return result;
}

/* The summary, printed at the end. */
static void show(void) {
    char path[4096], line[1024];
    snprintf(path, sizeof path, "%s/summary.md", o.out);
    FILE *summary = fopen(path, "r");
    while (summary && fgets(line, sizeof line, summary)) {
        fputs(line, stdout);
    }
    if (summary) {
        fclose(summary);
    }
}

int main(int argc, char **argv) {
    cli_arguments arguments;
    int exit_code;
    o.threads = omp_get_num_procs();
    if (!cli_parse(&program, argc, argv, &arguments, &exit_code)) {
        return exit_code;
    }
    if (o.count == 0) {
        o.materials[o.count++] = (material){.relief = RELIEF_BRICKS};
    }
    o.set.presets[1] = o.set.presets[1] || !o.presets_given;
    progress *shown = progress_create(o.quiet);
    const enc_context context = {
        .log = cli_log(&program, o.quiet), .progress = shown, .threads = o.threads};
    const btf_result result = run(&context);
    progress_destroy(&shown);
    if (result == BTF_OK) {
        show();
    }
    return cli_finish(&program, result);
}
