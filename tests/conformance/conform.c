/* Runs the cases of a device in a child process, because a driver is chosen by the environment when it is loaded, and
 * one that crashes must not end the runs of the others.
 *
 * SPDX-License-Identifier: MIT
 */
#include "conform.h"
#include "decoder/toolkit/filter.h"

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

const char *conform_verdict_name(conform_verdict verdict) {
    static const char *const names[] = {"pass", "fail", "not supported", "waived"};
    return names[verdict];
}

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* The child sends a head, then cases until the end of the pipe. */
typedef struct head {
    char renderer[200];
    conform_verdict verdict;
    char reason[300];
    uint32_t self_test;
} head;

static bool write_all(int fd, const void *data, size_t size) {
    const char *p = data;
    while (size > 0) {
        ssize_t n = write(fd, p, size);
        if (n < 0 && errno == EINTR) {
            continue;
        }
        if (n <= 0) {
            return false;
        }
        p += n;
        size -= (size_t)n;
    }
    return true;
}

static bool read_all(int fd, void *data, size_t size) {
    char *p = data;
    while (size > 0) {
        ssize_t n = read(fd, p, size);
        if (n < 0 && errno == EINTR) {
            continue;
        }
        if (n <= 0) {
            return false;
        }
        p += n;
        size -= (size_t)n;
    }
    return true;
}

/* Keeps the last message, for the reason of a verdict. */
typedef struct listener {
    char last[200];
    const btf_log *next;
} listener;

static void listen(void *user, btf_log_level level, const char *message) {
    listener *l = user;
    if (level == BTF_LOG_ERROR) {
        snprintf(l->last, sizeof l->last, "%s", message);
    }
    if (l->next && l->next->callback && level != BTF_LOG_ERROR) {
        l->next->callback(l->next->user, level, message);
    }
}

typedef struct runner {
    const conform_options *options;
    const context_device *device;
    gpu *gpu;
    int fd;
    listener listener;
    btf_log log;
    uint32_t self_test; /* the bits of the rules that the device breaks */
} runner;

/* A waiver is CASE:RENDERER:REASON, each part found anywhere in its name; an empty one matches all. */
static bool is_waived(const runner *r, conform_case *c) {
    const char *waiver = r->options->waiver;
    const char *second = waiver ? strchr(waiver, ':') : NULL,
               *third = second ? strchr(second + 1, ':') : NULL;
    if (!third) {
        return false;
    }
    char name[200], renderer[200];
    snprintf(name, sizeof name, "%.*s", (int)(second - waiver), waiver);
    snprintf(renderer, sizeof renderer, "%.*s", (int)(third - second - 1), second + 1);
    if (!strstr(c->name, name) || !strstr(gpu_name(r->gpu), renderer)) {
        return false;
    }
    snprintf(c->reason, sizeof c->reason, "%s", third + 1);
    return true;
}

/* Judges a case and sends it. */
static void finish(runner *r, conform_case *c, btf_result result, double started) {
    c->seconds = now() - started;
    if (result != BTF_OK) {
        /* a refusal by the device means "not supported"; any other error is a failure */
        c->verdict = result == BTF_ERROR_UNSUPPORTED ? CONFORM_NOT_SUPPORTED : CONFORM_FAIL;
        snprintf(c->reason, sizeof c->reason, "%.190s",
                 r->listener.last[0] ? r->listener.last : btf_result_text(result));
    } else if (c->is_fast) {
        c->verdict =
            c->fast.beyond * CONFORM_FAST_SHARE <= 3 * c->fast.evaluated ? CONFORM_PASS : CONFORM_FAIL;
    } else if (c->outcome.different > 0) {
        c->verdict = is_waived(r, c) ? CONFORM_WAIVED : CONFORM_FAIL;
    }
    if (!write_all(r->fd, c, sizeof *c)) {
        _exit(1);
    }
}

/* A decoder that takes the row's shift for the column's. */
static const char *swap_shift(char *library) {
    static const char right[] = "btf_wrap(x.x, btf_shift_of(codes.y)";
    char *at = strstr(library, right);
    if (at) {
        *strchr(at + sizeof "btf_wrap(x.x, btf_shift_of(codes" - 1, 'y') = 'z';
    }
    return library;
}

/* The bits of the self-test that the device fails and the material needs: those of levels of detail, of factors and of
 * lists, where the material has them. */
static uint32_t beyond_device(const runner *r, const btf_material *material) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    return r->self_test & ((info.levels > 1 ? BTF_SELF_TEST_LEVELS : 0u) |
                           (info.store == BTF_STORE_FACTORS ? BTF_SELF_TEST_FACTORS : 0u) |
                           (info.point_store == BTF_POINTS_LISTS ? BTF_SELF_TEST_LISTS : 0u));
}

/* Records one case in place of all those of a variant that the device cannot pass. */
static void refuse_variant(runner *r, uint32_t failures, const char *name) {
    char names[120];
    conform_case c = {0};
    btf_self_test_names(failures, names, sizeof names);
    snprintf(c.name, sizeof c.name, "%.30s %s", names, name);
    snprintf(r->listener.last, sizeof r->listener.last, "the self-test finds: %s", names);
    finish(r, &c, BTF_ERROR_UNSUPPORTED, now());
}

/* Steps and radiance of one variant, whole and restricted, of one material. */
static void run_variant(runner *r, const btf_material *material, const btf_shader_options *shader,
                        const char *name, uint64_t seed, uint64_t divide) {
    const conform_options *o = r->options;
    static const char *const kinds[] = {"steps", "radiance", "planned", "stochastic", "folded", "sampling"};
    const uint32_t beyond = beyond_device(r, material);
    if (beyond) {
        refuse_variant(r, beyond, name);
        return;
    }
    for (int kind = 0; kind < 6; ++kind) {
        uint64_t count = (kind ? o->count : o->steps) / divide;
        if (count == 0 || (kind == 2 && seed % 3 != 0) || (kind == 3 && seed % 3 == 0) ||
            (kind == 4 && seed % 3 != 1) ||
            (kind == 5 && seed % 4 != 2)) { /* each for some of the variants: compiling takes longest */
            continue;
        }
        conform_case c = {.seed = seed};
        snprintf(c.name, sizeof c.name, "%s %s", kinds[kind], name);
        char label[160];
        snprintf(label, sizeof label, "%s-%llu", r->device->name, (unsigned long long)seed);
        check_subject subject = {.gpu = r->gpu,
                                 .material = material,
                                 .shader = shader,
                                 .tamper = o->sabotage ? swap_shift : NULL,
                                 .log = &r->log,
                                 .dump_dir = o->dump_dir,
                                 .label = label};
        r->listener.last[0] = 0;
        double started = now();
        btf_result result = kind == 5   ? check_sampling(&subject, seed, count, &c.outcome)
                            : kind == 4 ? check_folded(&subject, seed, count, &c.outcome)
                            : kind == 3 ? check_stochastic(&subject, seed, count, &c.outcome)
                            : kind == 2 ? check_planned(&subject, seed, count, &c.outcome)
                            : kind == 1 ? check_radiance(&subject, seed, count, &c.outcome)
                                        : check_steps(&subject, seed, count, NULL, &c.outcome);
        finish(r, &c, result, started);
    }
}

static void run_fast(runner *r, const btf_material *material, btf_shader_options shader, const char *name,
                     uint64_t seed, uint64_t count) {
    if (beyond_device(r, material)) {
        return;
    }
    conform_case c = {.seed = seed, .is_fast = true};
    snprintf(c.name, sizeof c.name, "fast math %s", name);
    shader.math = BTF_MATH_FAST;
    check_subject subject = {.gpu = r->gpu, .material = material, .shader = &shader, .log = &r->log};
    r->listener.last[0] = 0;
    double started = now();
    btf_result result = check_fast_math(&subject, seed, count, &c.fast);
    if (c.fast.evaluated) {
        c.fast.mean_relative /= 3.0 * (double)c.fast.evaluated;
    }
    finish(r, &c, result, started);
}

static void run_synthetic(runner *r, uint64_t divide) {
    static variant list[VARIANT_MAX];
    const conform_options *o = r->options;
    size_t count = variant_pairwise(o->seed, list);
    for (size_t i = 0; i < count; ++i) {
        const int beyond = (int)i - o->first;
        if (beyond < 0 || (o->stride ? beyond % o->stride : beyond) != 0) {
            continue;
        }
        variant *v = &list[i];
        btf_material *material = NULL;
        r->listener.last[0] = 0;
        btf_result result = synthetic_create(&v->spec, &r->log, &material);
        char name[VARIANT_NAME + 16];
        snprintf(name, sizeof name, "%zu: %s", i, v->name);
        if (result != BTF_OK) {
            conform_case c = {.seed = v->spec.seed};
            snprintf(c.name, sizeof c.name, "material %s", name);
            finish(r, &c, BTF_ERROR_INTERNAL, now());
            continue;
        }
        v->shader.have_precise = r->device->enable_gpu_shader5;
        run_variant(r, material, &v->shader, name, v->spec.seed, divide);
        if (o->fast && v->spec.values == SYNTHETIC_PLAUSIBLE) {
            run_fast(r, material, v->shader, name, v->spec.seed, o->count / divide);
        }
        btf_material_close(&material);
    }
}

/* Checks the given files, each with every effect left out in turn and with both interpolations and filters. */
static void run_files(runner *r, uint64_t divide) {
    static const btf_shader_options ways[] = {
        {.leave_out = 0},
        {.filter = BTF_FILTER_BILINEAR},
        {.filter = BTF_FILTER_STEEP},
        {.interpolation = BTF_INTERPOLATION_NEAREST},
        {.interpolation = BTF_INTERPOLATION_NEAREST, .filter = BTF_FILTER_BILINEAR},
        {.leave_out = BTF_EFFECT_SHADOW},
        {.leave_out = BTF_EFFECT_SHIFT},
        {.leave_out = BTF_EFFECT_HIDDEN},
        {.leave_out = BTF_EFFECT_GAIN},
        {.leave_out = BTF_EFFECT_RESIDUAL},
        {.leave_out = BTF_EFFECT_RELIEF},
        {.leave_out = BTF_EFFECT_GLOSS},
        {.components = 3},
        {.leave_out = BTF_EFFECT_ALL},
    };
    for (int f = 0; f < r->options->file_count; ++f) {
        const char *path = r->options->files[f], *base = strrchr(path, '/');
        base = base ? base + 1 : path;
        btf_material *material = NULL;
        r->listener.last[0] = 0;
        btf_result result = btf_material_open(path, &r->log, &material);
        if (result != BTF_OK) {
            conform_case c = {0};
            snprintf(c.name, sizeof c.name, "material %.120s", base);
            finish(r, &c, result, now());
            continue;
        }
        for (size_t i = 0; i < sizeof ways / sizeof *ways; ++i) {
            btf_shader_options shader = ways[i];
            shader.struct_size = sizeof shader;
            shader.have_precise = r->device->enable_gpu_shader5;
            char name[VARIANT_NAME];
            snprintf(name, sizeof name, "%.60s minus %u cut %u %s %s", base, shader.leave_out,
                     shader.components, shader.interpolation ? "nearest" : "linear",
                     filter_name(shader.filter));
            run_variant(r, material, &shader, name, r->options->seed + i, divide);
            if (r->options->fast) {
                run_fast(r, material, shader, name, r->options->seed + i, r->options->count / divide);
            }
        }
        btf_material_close(&material);
    }
}

/* The child: never returns. */
static void run_child(const context_device *device, const conform_options *options, int fd) {
    runner r = {.options = options, .device = device, .fd = fd, .listener = {.next = options->log}};
    r.log = (btf_log){listen, &r.listener};
    head h = {.verdict = CONFORM_PASS};
    context_prepare(device);
    r.gpu = gpu_create(device, h.reason, sizeof h.reason);
    if (!r.gpu) {
        h.verdict = CONFORM_NOT_SUPPORTED;
        write_all(fd, &h, sizeof h);
        _exit(0);
    }
    snprintf(h.renderer, sizeof h.renderer, "%s", gpu_name(r.gpu));
    btf_gl_options gl = gpu_gl_options(r.gpu, NULL);
    if (btf_gl_self_test(&gl, &r.log, &h.self_test) != BTF_OK) {
        h.verdict = CONFORM_NOT_SUPPORTED;
        snprintf(h.reason, sizeof h.reason, "%s", r.listener.last);
    } else if (h.self_test &
               ~(uint32_t)(BTF_SELF_TEST_LEVELS | BTF_SELF_TEST_FACTORS | BTF_SELF_TEST_LISTS)) {
        char names[120];
        btf_self_test_names(h.self_test, names, sizeof names);
        h.verdict = CONFORM_NOT_SUPPORTED;
        snprintf(h.reason, sizeof h.reason, "the self-test finds: %s", names);
    }
    r.self_test = h.self_test;
    if (write_all(fd, &h, sizeof h) && h.verdict == CONFORM_PASS) {
        uint64_t divide =
            device->gallium_driver && strcmp(device->gallium_driver, "softpipe") == 0 ? 20 : 1;
        if (options->file_count > 0) {
            run_files(&r, divide);
        } else {
            run_synthetic(&r, divide);
        }
    }
    gpu_destroy(&r.gpu);
    close(fd);
    _exit(0);
}

static btf_result collect(int fd, conform_device *out) {
    conform_case c;
    while (read_all(fd, &c, sizeof c)) {
        if (out->case_count == out->case_capacity) {
            size_t capacity = 2 * out->case_capacity + 64;
            conform_case *grown = realloc(out->cases, capacity * sizeof *grown);
            if (!grown) {
                return BTF_ERROR_MEMORY;
            }
            out->cases = grown;
            out->case_capacity = capacity;
        }
        out->cases[out->case_count++] = c;
        if (c.verdict == CONFORM_FAIL) {
            out->verdict = CONFORM_FAIL;
        }
    }
    return BTF_OK;
}

btf_result conform_run(const context_device *device, const conform_options *options, conform_device *out) {
    memset(out, 0, sizeof *out);
    out->device = device;
    double started = now();
    int ends[2];
    if (pipe(ends) != 0) {
        return BTF_ERROR_INTERNAL;
    }
    fflush(NULL);
    pid_t child = fork();
    if (child < 0) {
        close(ends[0]);
        close(ends[1]);
        return BTF_ERROR_INTERNAL;
    }
    if (child == 0) {
        close(ends[0]);
        run_child(device, options, ends[1]);
    }
    close(ends[1]);
    head h;
    btf_result result = BTF_OK;
    bool answered = read_all(ends[0], &h, sizeof h);
    if (answered) {
        memcpy(out->renderer, h.renderer, sizeof out->renderer);
        memcpy(out->reason, h.reason, sizeof out->reason);
        out->verdict = h.verdict;
        out->self_test = h.self_test;
        result = collect(ends[0], out);
    }
    close(ends[0]);
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
        continue;
    }
    if (!answered || !WIFEXITED(status) || WEXITSTATUS(status) != 0) {
        out->verdict = CONFORM_FAIL;
        if (WIFSIGNALED(status)) {
            snprintf(out->reason, sizeof out->reason, "the process ended by signal %d", WTERMSIG(status));
        } else {
            snprintf(out->reason, sizeof out->reason, "the process ended with code %d",
                     WEXITSTATUS(status));
        }
    }
    out->seconds = now() - started;
    return result;
}
