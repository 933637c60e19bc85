/* btf-bench: measures what the parts cost and what they buy, beside their peers, in one run.
 *
 * SPDX-License-Identifier: MIT
 */
#include "bench.h"

#include "decoder/toolkit/cli.h"
#include "decoder/toolkit/progress.h"
#include "encoder/input/options.h"
#include "encoder/input/reader.h"
#include "tests/sample/sample.h"

#include <errno.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const struct {
    const char *name, *what;
    bench_section_fn run;
    bool quick; /* part of --quick */
} sections[] = {
    {"machine", "what the machine could do at best", bench_section_machine, true},
    {"encode", "encoding: time against accuracy", bench_section_encode, true},
    {"decode", "decoding: time against accuracy, on every GL device and on the CPU", bench_section_decode,
     true},
    {"storage", "storage: bytes against accuracy", bench_section_storage, true},
    {"between", "accuracy between the samples, which is what a renderer sees, and at them",
     bench_section_between, false},
    {"growth", "encoding: growth of time and memory, up to the texels of --size", bench_section_growth, true},
    {"fit", "the Lafortune fit beside a Ceres problem with automatic derivatives", bench_section_fit,
     false},
    {"codecs", "accuracy at equal bytes, and bytes at equal accuracy, beside principal components",
     bench_section_codecs, false},
    {"lowbit", "the low-bit split PCA alone, the best of these peers: for tests/bench/peers.sh", bench_section_lowbit,
     false},
    {"holdout", "accuracy of the presets at directions that the encoder did not see", bench_section_holdout,
     false},
    {"plan", "what decoding only what a scene calls for saves, predicted and measured", bench_section_plan,
     false},
    {"costs", "the prices of the cost model that plans load, fitted to one device", bench_section_costs, false},
    {"stochastic", "decoding one neighbour in place of all: time against noise", bench_section_stochastic, false},
    {"shaders", "nanoseconds a pixel of every shader variant on random materials", bench_section_shaders,
     false},
};
enum { SECTIONS = sizeof sections / sizeof sections[0], MAX_MATERIALS = 64 };

const char *const bench_preset_names[BENCH_PRESETS] = {"fast", "medium", "thorough", "exhaustive"};

/* Comma-separated names as bits. */
typedef struct name_set {
    bool sections[SECTIONS], presets[BENCH_PRESETS];
} name_set;

/* A file, a folder, or the name of a built-in relief. */
typedef struct material {
    const char *input, *pairs; /* pairs: images between the samples of input, or NULL */
    relief_kind relief;        /* where input is NULL */
} material;

static struct {
    const char *out, *device, *keep;
    material materials[MAX_MATERIALS];
    int count, threads, texels, rank, repeats, holdout;
    name_set set;
    bool only, presets_given, repeats_given, quick, quiet;
    uint32_t methods;
    uint64_t budget;
    enc_read_options read;
} o = {.out = "bench", .texels = 24, .rank = 400};

enum { QUICK_SIDE = 32, QUICK_REPEATS = 1, FULL_REPEATS = 3 };

static const char *parse_input(const char *text, void *value) {
    (void)value;
    if (o.count == MAX_MATERIALS) {
        return "at most 64 materials";
    }
    o.materials[o.count++] = (material){.input = text};
    return NULL;
}

static const char *parse_pairs(const char *text, void *value) {
    (void)value;
    material *last = o.count > 0 ? &o.materials[o.count - 1] : NULL;
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
        while (i < BENCH_PRESETS && strcmp(word, bench_preset_names[i]) != 0) {
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
            return "names of machine, encode, decode, storage, between, growth, fit, codecs, lowbit, holdout, "
                   "plan, costs, stochastic, shaders, with commas between";
        }
        o.set.sections[i] = true;
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
        o.methods |= 1u << i;
    }
    return o.methods & (BENCH_METHOD_JOINT | BENCH_METHOD_PAPER) ? NULL : "one of joint, paper at least";
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
     .value = &o.out,
     .help = "folder for CSV files, plots and summary.md; default bench"},
    {.name = "quick",
     .type = CLI_FLAG,
     .value = &o.quick,
     .help =
         "under 10 minutes on 2 idle cores: the sections machine, encode,\ndecode, storage and growth with "
         "fewer settings, samples of\n32x32 texels, data cut to 32x32, encodes once"},
    {.name = "repeats",
     .arg = "N",
     .type = CLI_INT,
     .value = &o.repeats,
     .given = &o.repeats_given,
     .minimum = 1,
     .maximum = BENCH_MOST_REPEATS,
     .help =
         "times that an encode is repeated; default 3, with --quick 1;\ndecodes are repeated 5 times at "
         "least"},
    {.name = "holdout",
     .arg = "WHICH",
     .type = CLI_CHOICE,
     .value = &o.holdout,
     .choices = "none|ring",
     .help = "none (default): all directions are encoded; ring: every second\nazimuth of the ring at 45 "
             "degrees is "
             "left out of encoding, and all\naccuracy is measured there too"},
    {.name = "only",
     .arg = "SECTIONS",
     .type = CLI_CUSTOM,
     .given = &o.only,
     .parse = parse_only,
     .help = "run some sections: machine, encode, decode, storage, between,\ngrowth, fit, codecs, lowbit, holdout, "
             "plan, costs, stochastic, shaders; default all"},
    {.name = "preset",
     .arg = "PRESETS",
     .type = CLI_CUSTOM,
     .given = &o.presets_given,
     .parse = parse_presets,
     .help = "of --method joint, one or more, with commas between; default:\n"
             "all in the section encode, medium in the others (the section\n"
             "decode takes the first alone)"},
    {.name = "device",
     .arg = "NAME",
     .type = CLI_STRING,
     .value = &o.device,
     .help = "decode on this GL device of btf-conform --list; default all of\n"
             "them, with --quick one for each shading language"},
    {.name = "methods",
     .arg = "NAMES",
     .type = CLI_CUSTOM,
     .parse = parse_methods,
     .help =
         "section decode: some of joint, paper, peers, reference (the decoder\non the CPU); section plan: of joint, paper; default all"},
    {.name = "keep",
     .arg = "DIR",
     .type = CLI_STRING,
     .value = &o.keep,
     .help = "section plan: take NAME-joint-PRESET.btf.exr (--levels 4) and\nNAME-paper.btf.exr from this "
             "folder, or encode them once and put\nthem there"},
    {.name = "budget",
     .type = CLI_BYTES,
     .value = &o.budget,
     .help = "GPU bytes a codec may take; default what the paper's layout\ntakes (2.36 MB for 64x64, 81 "
             "directions), at most\n62.5 kB times the root of the number of texels"},
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
               "btf-bench --materials bricks,bumps,weave --size 32x32 --preset fast\n"
               "btf-bench --only growth --size 64x64 --repeats 1\n"
               "btf-bench --input BRICKS64.zip --only decode --device osmesa --methods joint,paper,peers",
    .options = table,
    .max_arguments = 0,
};

/* The texels of the top left corner, at most `side` along each side. */
static btf_result cut(const enc_context *context, int side, enc_data **data) {
    const enc_data *from = *data;
    const int width = from->width < side ? from->width : side,
              height = from->height < side ? from->height : side;
    const size_t stride = enc_data_texel_stride(from);
    enc_data *part = NULL;
    float *buffer = malloc((size_t)width * stride * sizeof *buffer);
    btf_result result = buffer ? enc_data_create(context, width, height, from->n_views, from->views,
                                                 from->n_lights, from->lights, &part)
                               : enc_fail(context, BTF_ERROR_MEMORY, "bench: out of memory");
    for (int y = 0; y < height && result == BTF_OK; y++) {
        const float *samples;
        const size_t w = (size_t)width;
        result = enc_data_texels(context, from, (size_t)y * (size_t)from->width, w, buffer, &samples);
        if (result == BTF_OK) {
            result = enc_data_store_texels(context, part, (size_t)y * w, w, samples);
        }
    }
    free(buffer);
    if (result == BTF_OK) {
        enc_data_destroy(data);
        *data = part;
    } else {
        enc_data_destroy(&part);
    }
    return result;
}

static btf_result get_truth(const enc_context *context, const material *m, const enc_data *data,
                            bench_truth *out_truth) {
    const bool cut_down = o.quick && o.read.size[0] == 0;
    btf_result result = BTF_OK;
    *out_truth = (bench_truth){0};
    if (m->pairs) {
        result = bench_truth_read(context, m->pairs, &o.read, cut_down ? QUICK_SIDE : 0, out_truth);
    } else if (!m->input) {
        const sample_options options = {
            .context = context, .relief = m->relief, .width = data->width, .height = data->height};
        result = bench_truth_raycast(&options, out_truth);
    }
    if (result == BTF_OK && out_truth->count > 0 &&
        (out_truth->width != data->width || out_truth->height != data->height)) {
        result = enc_fail(context, BTF_ERROR_BAD_FILE, "%s has %d x %d texels, %s has %d x %d", m->pairs,
                          out_truth->width, out_truth->height, m->input, data->width, data->height);
        bench_truth_clear(out_truth);
    }
    return result;
}

static btf_result get_data(const enc_context *context, const material *m, enc_data **out_data) {
    const bool sized = o.read.size[0] > 0;
    if (m->input) {
        const btf_result result = enc_read(context, m->input, &o.read, out_data);
        return result == BTF_OK && o.quick && !sized ? cut(context, QUICK_SIDE, out_data) : result;
    }
    const int side = o.quick ? QUICK_SIDE : 0;
    const sample_options options = {.context = context,
                                    .relief = m->relief,
                                    .width = sized ? o.read.size[0] : side,
                                    .height = sized ? o.read.size[1] : side};
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

static bool wanted(int section) {
    return o.only ? o.set.sections[section] : !o.quick || sections[section].quick;
}

static btf_result run_material(const enc_context *context, const material *m, const bench_system *system,
                               bench_journal *journal, FILE *summary) {
    char name[128], source[256];
    enc_data *data = NULL;
    bench_held held = {0};
    bench_truth truth = {0};
    bench_between *between = NULL, *between_data = NULL;
    short_name(m->input ? m->input : relief_kind_name(m->relief), name, sizeof name);
    btf_result result = get_data(context, m, &data);
    if (result == BTF_OK) {
        snprintf(source, sizeof source, "%s%s, %dx%d texels, %d views, %d lights",
                 m->input ? "" : "btf-sample ", name, data->width, data->height, data->n_views,
                 data->n_lights);
        result = bench_held_create(context, data, o.holdout == 1, &held);
    }
    if (result == BTF_OK) {
        result = get_truth(context, m, data, &truth);
    }
    if (result == BTF_OK) {
        result = bench_between_create(context, held.train, &truth, &between);
    }
    if (result == BTF_OK && held.owned) {
        result = bench_between_create(context, data, &truth, &between_data);
    }
    bench_run bench = {.context = context,
                       .data = data,
                       .source = source,
                       .name = name,
                       .out = o.out,
                       .texels = o.texels,
                       .presets_given = o.presets_given,
                       .budget = o.budget,
                       .rank = o.rank,
                       .summary = summary,
                       .held = &held,
                       .truth = &truth,
                       .between = between,
                       .between_data = held.owned ? between_data : between,
                       .journal = journal,
                       .system = system,
                       .repeats = o.repeats,
                       .quick = o.quick,
                       .methods = o.methods,
                       .device = o.device,
                       .keep = o.keep,
                       .most_side = o.read.size[0]};
    memcpy(bench.presets, o.set.presets, sizeof bench.presets);
    if (result == BTF_OK) {
        fprintf(summary, "Truth between the samples of %s: %s.\n\n", name,
                truth.count > 0 ? truth.source : "none is known, so accuracy there is estimated");
    }
    if (held.owned) {
        fprintf(summary,
                "Left out of encoding: %d views and %d lights, every second azimuth of the ring at %.0f "
                "degrees.\n\n",
                held.n_views, held.n_lights, held.theta);
    }
    for (int i = 0; result == BTF_OK && i < SECTIONS; i++) {
        if (wanted(i)) {
            fprintf(summary, "## %s: %s\n\n%s; data: %s.\n\n", sections[i].name, name, sections[i].what,
                    bench.source);
            result = sections[i].run(&bench);
            fflush(summary);
        }
    }
    bench_between_destroy(&between);
    bench_between_destroy(&between_data);
    bench_truth_clear(&truth);
    bench_held_clear(&held);
    enc_data_destroy(&data);
    return result;
}

/* Rows are comparable where these agree: machine, boot, program and settings. Data are named, not read. */
static void describe(const bench_system *s, char *text, size_t size) {
    int length = snprintf(text, size,
                          "%s; %d cores; boot %s; program %016llx; quick %d; threads %d; repeats %d; "
                          "holdout %d; journal 2; budget %llu; size %dx%d; crop %d,%d,%d,%d;",
                          s->cpu, s->cores, s->boot, (unsigned long long)s->program, o.quick, o.threads,
                          o.repeats, o.holdout, (unsigned long long)o.budget, o.read.size[0],
                          o.read.size[1], o.read.crop[0], o.read.crop[1], o.read.crop[2], o.read.crop[3]);
    for (int i = 0; i < o.count && length < (int)size; i++) {
        const material *m = &o.materials[i];
        const char *const files[] = {m->input ? m->input : relief_kind_name(m->relief), m->pairs};
        for (int k = 0; k < 2 && files[k] && length < (int)size; k++) {
            struct stat about = {0};
            if (m->input && stat(files[k], &about) != 0) {
                about.st_size = 0;
            }
            length += snprintf(text + length, size - (size_t)length, " %s (%lld bytes, %lld)", files[k],
                               (long long)about.st_size, (long long)about.st_mtime);
        }
    }
}

static void print_system(const bench_system *s, const bench_journal *journal, FILE *summary) {
    fprintf(summary,
            "# btf-bench\n\n| | |\n| --- | --- |\n| processor | %s, %d cores |\n| load before the run | "
            "%.2f |\n"
            "| system | %s |\n| compiler | %s |\n| OpenBTF | %s, program %016llx |\n| threads | %d |\n"
            "| repeats | encode %d, decode %d |\n| size | %s |\n\n",
            s->cpu, s->cores, s->load, s->kernel, s->compiler, OPENBTF_VERSION,
            (unsigned long long)s->program, o.threads, o.repeats,
            o.repeats > BENCH_DECODE_REPEATS ? o.repeats : BENCH_DECODE_REPEATS,
            o.quick ? "--quick: 32x32 texels unless --size says otherwise; absolute figures are those of "
                      "small data"
                    : "as given");
    if (bench_journal_resumed(journal) > 0) {
        fprintf(summary,
                "%zu rows were measured before the run was stopped, by the same program with the same "
                "settings on this machine since it was booted.\n"
                "\n",
                bench_journal_resumed(journal));
    }
}

static btf_result run(const enc_context *context) {
    char path[4096], identity[3000];
    bench_system system;
    bench_journal *journal = NULL;
    const char *const folders[] = {o.out, o.keep};
    for (size_t i = 0; i < sizeof folders / sizeof *folders; i++) {
        if (folders[i] && mkdir(folders[i], 0777) != 0 && errno != EEXIST) {
            return cli_error(&program, BTF_ERROR_IO, "%s: cannot make the folder: %s", folders[i],
                             strerror(errno));
        }
    }
    bench_system_find(&system);
    describe(&system, identity, sizeof identity);
    btf_result result = bench_journal_open(context, o.out, identity, &journal);
    if (result != BTF_OK) {
        return result;
    }
    if (bench_journal_resumed(journal) > 0) {
        enc_log(context, BTF_LOG_INFO, "%zu rows were measured before the last stop; going on",
                bench_journal_resumed(journal));
    }
    snprintf(path, sizeof path, "%s/summary.md", o.out);
    FILE *summary = fopen(path, "w");
    if (summary) {
        print_system(&system, journal, summary);
        for (int i = 0; i < o.count && result == BTF_OK; i++) {
            result = run_material(context, &o.materials[i], &system, journal, summary);
        }
    }
    if (!summary || (fclose(summary) != 0 && result == BTF_OK)) {
        result = cli_error(&program, BTF_ERROR_IO, "%s: %s", path, strerror(errno));
    }
    bench_journal_close(&journal);
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
    bench_sleep_when_idle(argv);
    o.threads = omp_get_num_procs();
    if (!cli_parse(&program, argc, argv, &arguments, &exit_code)) {
        return exit_code;
    }
    o.methods = o.methods ? o.methods : BENCH_METHOD_ALL;
    if (o.count == 0) {
        o.materials[o.count++] = (material){.relief = RELIEF_BRICKS};
    }
    o.set.presets[1] = o.set.presets[1] || !o.presets_given;
    if (!o.repeats_given) {
        o.repeats = o.quick ? QUICK_REPEATS : FULL_REPEATS;
    }
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
