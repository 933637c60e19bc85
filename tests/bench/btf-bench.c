/* btf-bench: measures the time, bytes and accuracy of the parts of OpenBTF, and of their peers, in one run.
 *
 * SPDX-License-Identifier: MIT
 */
#include "bench.h"

#include "command_line.h"
#include "decoder/toolkit/progress.h"
#include "encoder/input/reader.h"

#include <errno.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const bench_options *const o = &bench_given;

enum { QUICK_SIDE = 32, QUICK_REPEATS = 1, FULL_REPEATS = 3 };

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

static btf_result get_truth(const enc_context *context, const bench_material *m, const enc_data *data,
                            bench_truth *out_truth) {
    const bool cut_down = o->quick && o->read.size[0] == 0;
    btf_result result = BTF_OK;
    *out_truth = (bench_truth){0};
    if (m->pairs) {
        result = bench_truth_read(context, m->pairs, &o->read, cut_down ? QUICK_SIDE : 0, out_truth);
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

static btf_result get_data(const enc_context *context, const bench_material *m, enc_data **out_data) {
    const bool sized = o->read.size[0] > 0;
    if (m->input) {
        const btf_result result = enc_read(context, m->input, &o->read, out_data);
        return result == BTF_OK && o->quick && !sized ? cut(context, QUICK_SIDE, out_data) : result;
    }
    const int side = o->quick ? QUICK_SIDE : 0;
    const sample_options options = {.context = context,
                                    .relief = m->relief,
                                    .width = sized ? o->read.size[0] : side,
                                    .height = sized ? o->read.size[1] : side};
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
    return o->only ? o->sections[section] : !o->quick || bench_sections[section].quick;
}

static btf_result run_material(const enc_context *context, const bench_material *m,
                               const bench_system *system, bench_journal *journal, FILE *summary) {
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
        result = bench_held_create(context, data, o->holdout == 1, &held);
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
                       .out = o->out,
                       .texels = o->texels,
                       .presets_given = o->presets_given,
                       .budget = o->budget,
                       .rank = o->rank,
                       .summary = summary,
                       .held = &held,
                       .truth = &truth,
                       .between = between,
                       .between_data = held.owned ? between_data : between,
                       .journal = journal,
                       .system = system,
                       .repeats = o->repeats,
                       .quick = o->quick,
                       .methods = o->methods,
                       .device = o->device,
                       .keep = o->keep,
                       .most_side = o->read.size[0]};
    memcpy(bench.presets, o->presets, sizeof bench.presets);
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
    for (int i = 0; result == BTF_OK && i < BENCH_SECTIONS; i++) {
        if (wanted(i)) {
            fprintf(summary, "## %s: %s\n\n%s; data: %s.\n\n", bench_sections[i].name, name,
                    bench_sections[i].what, bench.source);
            result = bench_sections[i].run(&bench);
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

/* Writes the identity of the run: machine, boot, program and settings. Rows are comparable where these agree. Data are
 * identified by name alone. */
static void describe(const bench_system *s, char *text, size_t size) {
    int length =
        snprintf(text, size,
                 "%s; %d cores; boot %s; program %016llx; quick %d; threads %d; repeats %d; "
                 "holdout %d; journal 2; budget %llu; size %dx%d; crop %d,%d,%d,%d;",
                 s->cpu, s->cores, s->boot, (unsigned long long)s->program, o->quick, o->threads,
                 o->repeats, o->holdout, (unsigned long long)o->budget, o->read.size[0], o->read.size[1],
                 o->read.crop[0], o->read.crop[1], o->read.crop[2], o->read.crop[3]);
    for (int i = 0; i < o->count && length < (int)size; i++) {
        const bench_material *m = &o->materials[i];
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
            (unsigned long long)s->program, o->threads, o->repeats,
            o->repeats > BENCH_DECODE_REPEATS ? o->repeats : BENCH_DECODE_REPEATS,
            o->quick ? "--quick: 32x32 texels unless --size says otherwise; absolute figures are those of "
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
    const char *const folders[] = {o->out, o->keep};
    for (size_t i = 0; i < sizeof folders / sizeof *folders; i++) {
        if (folders[i] && mkdir(folders[i], 0777) != 0 && errno != EEXIST) {
            return cli_error(&bench_program, BTF_ERROR_IO, "%s: cannot make the folder: %s", folders[i],
                             strerror(errno));
        }
    }
    bench_system_find(&system);
    describe(&system, identity, sizeof identity);
    btf_result result = bench_journal_open(context, o->out, identity, &journal);
    if (result != BTF_OK) {
        return result;
    }
    if (bench_journal_resumed(journal) > 0) {
        enc_log(context, BTF_LOG_INFO, "%zu rows were measured before the last stop; going on",
                bench_journal_resumed(journal));
    }
    snprintf(path, sizeof path, "%s/summary.md", o->out);
    FILE *summary = fopen(path, "w");
    if (summary) {
        print_system(&system, journal, summary);
        for (int i = 0; i < o->count && result == BTF_OK; i++) {
            result = run_material(context, &o->materials[i], &system, journal, summary);
        }
    }
    if (!summary || (fclose(summary) != 0 && result == BTF_OK)) {
        result = cli_error(&bench_program, BTF_ERROR_IO, "%s: %s", path, strerror(errno));
    }
    bench_journal_close(&journal);
    return result;
}

/* Prints the summary at the end. */
static void show(void) {
    char path[4096], line[1024];
    snprintf(path, sizeof path, "%s/summary.md", o->out);
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
    bench_given.threads = omp_get_num_procs();
    if (!cli_parse(&bench_program, argc, argv, &arguments, &exit_code)) {
        return exit_code;
    }
    bench_given.methods = bench_given.methods ? bench_given.methods : BENCH_METHOD_ALL;
    if (bench_given.count == 0) {
        bench_given.materials[bench_given.count++] = (bench_material){.relief = RELIEF_BRICKS};
    }
    bench_given.presets[1] = bench_given.presets[1] || !bench_given.presets_given;
    if (!bench_given.repeats_given) {
        bench_given.repeats = bench_given.quick ? QUICK_REPEATS : FULL_REPEATS;
    }
    progress *shown = progress_create(bench_given.quiet);
    const enc_context context = {.log = cli_log(&bench_program, bench_given.quiet),
                                 .progress = shown,
                                 .threads = bench_given.threads};
    const btf_result result = run(&context);
    progress_destroy(&shown);
    if (result == BTF_OK) {
        show();
    }
    return cli_finish(&bench_program, result);
}
