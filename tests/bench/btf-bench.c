/* btf-bench: measures what the parts cost and what they buy, beside their peers, in one run.
 *
 * SPDX-License-Identifier: MIT
 */
#include "bench.h"

#include "decoder/tools/cli.h"
#include "decoder/tools/progress.h"
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
};
enum { SECTIONS = sizeof sections / sizeof sections[0] };

static struct {
    const char *input, *out, *only;
    int threads, texels;
    bool quiet;
} o = {.out = "bench", .texels = 24};

static const cli_option table[] = {
    {.name = "input", .arg = "DATA", .type = CLI_STRING, .value = &o.input,
     .help = "folder or archive of images; default the built-in brick sample"},
    {.name = "out", .arg = "DIR", .type = CLI_STRING, .value = &o.out,
     .help = "folder for CSV files and summary.md; default bench"},
    {.name = "only", .arg = "SECTION", .type = CLI_STRING, .value = &o.only, .help = "run one section: fit"},
    {.name = "texels", .type = CLI_INT, .value = &o.texels, .minimum = 1, .maximum = 100000,
     .help = "texels that the fit is compared on; default 24"},
    {.name = "threads", .type = CLI_INT, .value = &o.threads, .minimum = 1, .maximum = 1024,
     .help = "default: all cores"},
    {.short_name = 'q', .name = "quiet", .type = CLI_FLAG, .value = &o.quiet, .help = "no progress"},
    {.type = CLI_END},
};

static const cli_program program = {
    .name = "btf-bench",
    .usage = "[OPTION...]",
    .summary = "Measures the parts of OpenBTF beside their peers, in one run on one machine: ratios are what counts.\n"
               "A slow run informs and never fails.",
    .example = "btf-bench --input BRICKS64.zip --out bench",
    .options = table,
    .max_arguments = 0,
};

static btf_result get_data(const enc_context *context, enc_data **out_data) {
    if (o.input) {
        const enc_read_options options = {0};
        return enc_read(context, o.input, &options, out_data);
    }
    sample_options options = {0};
    options.context = context;
    return sample_render(&options, out_data, NULL);
}

static btf_result run(const enc_context *context) {
    char path[4096];
    enc_data *data = NULL;
    btf_result result = BTF_OK;
    if (mkdir(o.out, 0777) != 0 && errno != EEXIST) {
        return cli_error(&program, BTF_ERROR_IO, "%s: cannot make the folder: %s", o.out, strerror(errno));
    }
    bool known = !o.only;
    for (int i = 0; i < SECTIONS; i++) {
        known = known || strcmp(o.only, sections[i].name) == 0;
    }
    if (!known) {
        return cli_error(&program, BTF_ERROR_USAGE, "option --only: no section '%s'; expected fit", o.only);
    }
    snprintf(path, sizeof path, "%s/summary.md", o.out);
    FILE *summary = fopen(path, "w");
    if (!summary) {
        return cli_error(&program, BTF_ERROR_IO, "%s: %s", path, strerror(errno));
    }
    result = get_data(context, &data);
    for (int i = 0; result == BTF_OK && i < SECTIONS; i++) {
        if (o.only && strcmp(o.only, sections[i].name) != 0) {
            continue;
        }
        bench_run bench = {.context = context,
                           .data = data,
                           .source = o.input ? o.input : "btf-sample bricks",
                           .out = o.out,
                           .texels = o.texels,
                           .summary = summary};
        fprintf(summary, "## %s\n\n%s; data: %s, %d cores.\n\n", sections[i].name, sections[i].what, bench.source,
                omp_get_num_procs());
        result = sections[i].run(&bench);
    }
    enc_data_destroy(&data);
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
    progress *shown = progress_create(o.quiet);
    const enc_context context = {.log = cli_log(&program, o.quiet), .progress = shown, .threads = o.threads};
    const btf_result result = run(&context);
    progress_destroy(&shown);
    if (result == BTF_OK) {
        show();
    }
    return cli_finish(&program, result);
}
