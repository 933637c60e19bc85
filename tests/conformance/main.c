/* btf-conform: does what a GPU decodes agree, bit for bit, with the reference?
 *
 * SPDX-License-Identifier: MIT
 */
#include "conform.h"
#include "decoder/toolkit/cli.h"
#include "decoder/toolkit/json.h"
#include "vectors.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct {
    const char *device, *dump, *waive, *vectors;
    int seed, count, steps, variant;
    struct {
        int number, count;
    } part;
    bool json, fast, list, quiet, sabotage, variant_given, part_given;
} arguments = {.device = "all", .seed = 1, .count = 20000, .steps = 20000, .part = {1, 1}};

/* For --part: "2/6". */
static const char *parse_part(const char *text, void *value) {
    (void)value;
    const char *end = NULL;
    if (!cli_parse_int(text, "/", &arguments.part.number, &end) || *end != '/' ||
        !cli_parse_int(end + 1, "", &arguments.part.count, NULL) || arguments.part.number < 1 ||
        arguments.part.number > arguments.part.count) {
        return "K/N, with K from 1 to N";
    }
    return NULL;
}

/* clang-format off */
static const cli_option options[] = {
    {.short_name = 'd', .name = "device", .arg = "LIST", .type = CLI_STRING, .value = &arguments.device,
     .help = "devices, comma-separated, or all (default); --list names them"},
    {.name = "list", .type = CLI_FLAG, .value = &arguments.list, .help = "name the devices and stop"},
    {.name = "json", .type = CLI_FLAG, .value = &arguments.json, .help = "print JSON with every case"},
    {.name = "count", .type = CLI_INT, .value = &arguments.count, .minimum = 0, .maximum = 1e9,
     .help = "evaluations of radiance a variant (default 20000; a twentieth on softpipe)"},
    {.name = "steps", .type = CLI_INT, .value = &arguments.steps, .minimum = 0, .maximum = 1e9,
     .help = "elements of each integer step a variant, at most (default 20000)"},
    {.name = "seed", .type = CLI_INT, .value = &arguments.seed, .minimum = 0, .maximum = 1e9,
     .help = "seed of variants, materials and arguments (default 1)"},
    {.name = "variant", .type = CLI_INT, .value = &arguments.variant, .given = &arguments.variant_given,
     .minimum = 0, .maximum = 1e6, .help = "run this variant alone"},
    {.name = "part", .arg = "K/N", .type = CLI_CUSTOM, .parse = parse_part, .given = &arguments.part_given,
     .help = "run every N-th variant, from the K-th on, so that N devices share them"},
    {.name = "fast-math", .type = CLI_FLAG, .value = &arguments.fast,
     .help = "measure the error of BTF_FAST_MATH too"},
    {.name = "dump", .arg = "DIR", .type = CLI_STRING, .value = &arguments.dump,
     .help = "write reference, GPU and mask of the first failing batch as PNG"},
    {.name = "waive", .arg = "CASE:RENDERER:REASON", .type = CLI_STRING, .value = &arguments.waive,
     .help = "differences of cases and renderers whose names hold these words are waived"},
    {.name = "sabotage", .type = CLI_FLAG, .value = &arguments.sabotage,
     .help = "make the decoder wrong (shift bytes swapped), to see how a failure is reported"},
    {.name = "vectors", .arg = "DIR", .type = CLI_STRING, .value = &arguments.vectors,
     .help = "write language-neutral test vectors there and stop"},
    {.name = "quiet", .type = CLI_FLAG, .value = &arguments.quiet,
     .help = "print failures and the verdict alone"},
    {.type = CLI_END},
};
/* clang-format on */

static const cli_program program = {
    .name = "btf-conform",
    .usage = "[FILE...] [--device LIST] [--json] [--vectors DIR]",
    .summary =
        "Compares what GPUs decode with the reference decoder, bit for bit. Without a FILE, materials are\n"
        "synthetic: legal, random and extreme, one for each of some 115 pairwise variants.",
    .details =
        "A device that no context can be had for, or whose arithmetic fails the self-test, is not "
        "supported;\n"
        "that is no failure (5) as long as another device was checked.\n"
        "\n"
        "Fast math fails when more than one channel in 1000 is off by more than 1/128 of its value (of "
        "1/1024\n"
        "where it is darker).",
    .example = "btf-conform --device osmesa,egl-es300\nbtf-conform bricks.btf.exr --json",
    .options = options,
    .min_arguments = 0,
    .max_arguments = -1,
};

/* Is a name in a comma-separated list? */
static bool in_list(const char *list, const char *name) {
    size_t length = strlen(name);
    for (const char *p = list; p; p = strchr(p, ',') ? strchr(p, ',') + 1 : NULL) {
        if (strncmp(p, name, length) == 0 && (p[length] == ',' || p[length] == 0)) {
            return true;
        }
    }
    return false;
}

/* Every word of the list must be a device. */
static bool check_list(const char *list) {
    char word[64];
    for (const char *p = list; p; p = strchr(p, ',') ? strchr(p, ',') + 1 : NULL) {
        snprintf(word, sizeof word, "%.*s", (int)strcspn(p, ","), p);
        bool known = strcmp(word, "all") == 0;
        for (const context_device *d = context_devices; d->name; ++d) {
            known = known || strcmp(d->name, word) == 0;
        }
        if (!known) {
            cli_error(&program, BTF_ERROR_USAGE, "--device: \"%s\" is unknown, expected a name of --list",
                      word);
            return false;
        }
    }
    return true;
}

static void print_failure(const conform_case *c) {
    const check_outcome *o = &c->outcome;
    printf("    %s: %llu of %llu differ, first in %s at %llu (seed %llu)\n", c->name,
           (unsigned long long)o->different, (unsigned long long)o->evaluated, o->step,
           (unsigned long long)o->index, (unsigned long long)c->seed);
    printf("      inputs   ");
    for (int i = 0; i < GPU_INPUTS; ++i) {
        printf(" %08x", o->inputs[i]);
    }
    printf("\n      reference");
    for (int i = 0; i < GPU_OUTPUTS; ++i) {
        printf(" %08x", o->expected[i]);
    }
    printf("\n      gpu      ");
    for (int i = 0; i < GPU_OUTPUTS; ++i) {
        printf(" %08x", o->actual[i]);
    }
    printf("\n");
}

static void print_fast(const conform_case *c) {
    const check_fast *f = &c->fast;
    double total = 3.0 * (double)f->evaluated;
    uint64_t few = f->ulp_counts[0] + f->ulp_counts[1] + f->ulp_counts[2] + f->ulp_counts[3];
    printf("    %s: equal %.1f%%, within 7 ULP %.1f%%, relative error mean %.1e, worst %.1e, "
           "%llu beyond 1/128\n",
           c->name, 100 * (double)f->ulp_counts[0] / total, 100 * (double)few / total, f->mean_relative,
           f->worst_relative, (unsigned long long)f->beyond);
}

static void print_device(const conform_device *d) {
    uint64_t evaluated = 0, different = 0;
    for (size_t i = 0; i < d->case_count; ++i) {
        evaluated += d->cases[i].outcome.evaluated;
        different += d->cases[i].outcome.different;
    }
    printf("%-20s %s%s%s\n", d->device->name, conform_verdict_name(d->verdict), d->reason[0] ? ": " : "",
           d->reason);
    if (d->renderer[0]) {
        printf("    %s, #version %s: %zu cases, %llu evaluations, %llu differ, %.1f s\n", d->renderer,
               d->device->glsl, d->case_count, (unsigned long long)evaluated, (unsigned long long)different,
               d->seconds);
    }
    for (size_t i = 0; i < d->case_count; ++i) {
        const conform_case *c = &d->cases[i];
        if (c->verdict == CONFORM_FAIL && c->outcome.different > 0) {
            print_failure(c);
        } else if (c->is_fast && (!arguments.quiet || c->verdict != CONFORM_PASS)) {
            print_fast(c);
        }
        if (c->reason[0]) {
            printf("    %s: %s: %s\n", c->name, conform_verdict_name(c->verdict), c->reason);
        }
    }
}

static void json_words(json *j, const char *key, const uint32_t *words, int count) {
    json_array(j, key);
    for (int i = 0; i < count; ++i) {
        char text[16];
        snprintf(text, sizeof text, "%08x", words[i]);
        json_string(j, NULL, text);
    }
    json_end(j);
}

static void json_case(json *j, const conform_case *c) {
    json_object(j, NULL);
    json_string(j, "name", c->name);
    json_string(j, "verdict", conform_verdict_name(c->verdict));
    if (c->reason[0]) {
        json_string(j, "reason", c->reason);
    }
    json_integer(j, "seed", (int64_t)c->seed);
    if (c->is_fast) {
        json_integer(j, "evaluated", (int64_t)c->fast.evaluated);
        json_number(j, "relative_error_mean", c->fast.mean_relative);
        json_number(j, "relative_error_worst", c->fast.worst_relative);
        json_number(j, "absolute_error_worst", c->fast.worst_absolute);
        json_integer(j, "beyond_bound", (int64_t)c->fast.beyond);
        json_array(j, "ulp_bins"); /* 0, 1, 2..3, 4..7, ... */
        for (int i = 0; i < 34; ++i) {
            json_integer(j, NULL, (int64_t)c->fast.ulp_counts[i]);
        }
        json_end(j);
    } else {
        json_integer(j, "evaluated", (int64_t)c->outcome.evaluated);
        json_integer(j, "different", (int64_t)c->outcome.different);
        if (c->outcome.different > 0) {
            json_string(j, "step", c->outcome.step);
            json_integer(j, "index", (int64_t)c->outcome.index);
            json_words(j, "inputs", c->outcome.inputs, GPU_INPUTS);
            json_words(j, "reference", c->outcome.expected, GPU_OUTPUTS);
            json_words(j, "gpu", c->outcome.actual, GPU_OUTPUTS);
        }
    }
    json_number(j, "seconds", c->seconds);
    json_end(j);
}

static void json_device(json *j, const conform_device *d) {
    char names[120];
    btf_self_test_names(d->self_test, names, sizeof names);
    json_object(j, NULL);
    json_string(j, "name", d->device->name);
    json_string(j, "verdict", conform_verdict_name(d->verdict));
    if (d->reason[0]) {
        json_string(j, "reason", d->reason);
    }
    json_string(j, "renderer", d->renderer);
    json_string(j, "glsl", d->device->glsl);
    json_string(j, "self_test", names);
    json_number(j, "seconds", d->seconds);
    json_array(j, "cases");
    for (size_t i = 0; i < d->case_count; ++i) {
        json_case(j, &d->cases[i]);
    }
    json_end(j);
    json_end(j);
}

static btf_result run(const cli_arguments *files) {
    btf_log log = cli_log(&program, arguments.quiet);
    conform_options o = {.seed = (uint64_t)arguments.seed,
                         .count = (uint64_t)arguments.count,
                         .steps = (uint64_t)arguments.steps,
                         .first = arguments.variant_given ? arguments.variant : arguments.part.number - 1,
                         .stride = arguments.variant_given ? 0 : arguments.part.count,
                         .fast = arguments.fast,
                         .sabotage = arguments.sabotage,
                         .dump_dir = arguments.dump,
                         .waiver = arguments.waive,
                         .files = files->values,
                         .file_count = files->count,
                         .log = &log};
    /* A file that cannot be read ends the program with a usage error; it is no failure of a device. */
    for (int i = 0; i < files->count; ++i) {
        btf_material *material = NULL;
        btf_result result = btf_material_open(files->values[i], &log, &material);
        btf_material_close(&material);
        if (result != BTF_OK) {
            return result;
        }
    }
    json j = {0};
    json_object(&j, NULL);
    json_array(&j, "devices");
    btf_result result = BTF_OK;
    bool checked = false, failed = false;
    uint64_t evaluated = 0, different = 0;
    for (const context_device *d = context_devices; d->name && result == BTF_OK; ++d) {
        if (!in_list(arguments.device, d->name) && !in_list(arguments.device, "all")) {
            continue;
        }
        conform_device outcome;
        result = conform_run(d, &o, &outcome);
        checked = checked || outcome.verdict == CONFORM_PASS || outcome.verdict == CONFORM_FAIL;
        failed = failed || outcome.verdict == CONFORM_FAIL;
        for (size_t i = 0; i < outcome.case_count; ++i) {
            evaluated += outcome.cases[i].outcome.evaluated;
            different += outcome.cases[i].outcome.different;
        }
        if (arguments.json) {
            json_device(&j, &outcome);
        } else {
            print_device(&outcome);
        }
        free(outcome.cases);
        fflush(stdout);
    }
    json_end(&j);
    const char *verdict = failed ? "fail" : checked ? "pass" : "not supported";
    json_integer(&j, "evaluated", (int64_t)evaluated);
    json_integer(&j, "different", (int64_t)different);
    json_string(&j, "verdict", verdict);
    json_end(&j);
    if (arguments.json && json_text(&j)) {
        fputs(json_text(&j), stdout);
    } else if (!arguments.json) {
        printf("%s: %llu evaluations, %llu differ\n", verdict, (unsigned long long)evaluated,
               (unsigned long long)different);
    }
    json_free(&j);
    if (result != BTF_OK) {
        return cli_error(&program, result, "%s", btf_result_text(result));
    }
    return failed ? BTF_ERROR_DIFFERENT : checked ? BTF_OK : BTF_ERROR_UNSUPPORTED;
}

int main(int argc, char **argv) {
    cli_arguments files;
    int exit_code;
    if (!cli_parse(&program, argc, argv, &files, &exit_code)) {
        return exit_code;
    }
    if (arguments.list) {
        for (const context_device *d = context_devices; d->name; ++d) {
            printf("%-20s %s, OpenGL %s%d.%d, #version %s%s\n", d->name, d->provider->name,
                   d->request.es ? "ES " : "", d->request.major, d->request.minor, d->glsl,
                   d->enable_gpu_shader5 ? ", GL_ARB_gpu_shader5" : "");
        }
        return cli_finish(&program, BTF_OK);
    }
    if (!check_list(arguments.device)) {
        return cli_finish(&program, BTF_ERROR_USAGE);
    }
    if (arguments.part_given && (arguments.variant_given || files.count > 0)) {
        return cli_finish(&program, cli_error(&program, BTF_ERROR_USAGE, "--part: not with %s",
                                              arguments.variant_given ? "--variant" : "a FILE"));
    }
    const char *colon = arguments.waive ? strchr(arguments.waive, ':') : NULL;
    if (arguments.waive && (!colon || !strchr(colon + 1, ':'))) {
        return cli_finish(&program,
                          cli_error(&program, BTF_ERROR_USAGE,
                                    "--waive: \"%s\" is not CASE:RENDERER:REASON", arguments.waive));
    }
    if (arguments.vectors) {
        btf_log log = cli_log(&program, arguments.quiet);
        return cli_finish(&program, vectors_write(arguments.vectors, (uint64_t)arguments.seed, &log));
    }
    return cli_finish(&program, run(&files));
}
