/* Times of decoding: every variant, the floor of its fetches, fast math, and the peers, on one GL context.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decode_bench.h"
#include "decode_shaders.h"

#include "decoder/tools/reference_view.h"
#include "tests/conformance/gpu.h"
#include "tests/conformance/random.h"
#include "tests/conformance/synthetic.h"

#include <GL/glcorearb.h>
#include <math.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <time.h>

enum { SIDE = GPU_SIDE, PIXELS = SIDE * SIDE, MOST_REPEATS = 25, TEXELS = 64, RING_DIRECTIONS = 81 };

typedef struct bench {
    gpu *gpu;
    const btf_log *log;
    int repeats;
    uint32_t *inputs, *outputs; /* of a grid */
    bench_decode *out;
} bench;

/* Core time of the process, all threads. */
static double core_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static double wall_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int compare_double(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

/* u, v and the tangent-frame light and view of a pixel of a sphere that fills the grid. */
static void sphere_pixel(int i, float out[8]) {
    double px = 2 * (i % SIDE + 0.5) / SIDE - 1, py = 2 * (i / SIDE + 0.5) / SIDE - 1, r = hypot(px, py);
    if (r > 0.97) {
        px *= 0.97 / r;
        py *= 0.97 / r;
    }
    double n[3] = {px, py, sqrt(1 - px * px - py * py)}, world_light[3] = {0.3, 0.2, sqrt(1 - 0.09 - 0.04)};
    double t[3] = {n[2], 0, -n[0]}, length = hypot(t[0], t[2]);
    for (int c = 0; c < 3; ++c)
        t[c] /= length;
    double b[3] = {n[1] * t[2] - n[2] * t[1], n[2] * t[0] - n[0] * t[2], n[0] * t[1] - n[1] * t[0]};
    const double *axes[3] = {t, b, n};
    out[0] = (float)(2 * px + 2);
    out[1] = (float)(2 * py + 2);
    for (int c = 0; c < 3; ++c) {
        out[2 + c] = (float)(axes[c][0] * world_light[0] + axes[c][1] * world_light[1] +
                             axes[c][2] * world_light[2]);
        out[5 + c] = (float)axes[c][2];
    }
    out[4] = fmaxf(out[4], 0.05f);
}

/* How many records a look-up tries, and which texel of the table the first is. */
static uint32_t records_tried(const uint16_t *table, uint32_t grid, const int32_t q[2],
                              uint32_t *out_first) {
    uint32_t cx = ((uint32_t)(q[0] < 16383 ? q[0] : 16383) * grid) >> 14,
             cy = ((uint32_t)(q[1] < 16383 ? q[1] : 16383) * grid) >> 14;
    const uint16_t *cell = table + 4 * (cy * grid + cx);
    *out_first = grid * grid + 2u * cell[0];
    for (uint32_t i = 0; i < cell[1]; ++i) {
        const uint16_t *r = table + 4 * ((size_t)*out_first + 2 * i);
        int64_t x[4] = {r[0], r[2], r[4], r[0]}, y[4] = {r[1], r[3], r[5], r[1]};
        int inside = !(r[7] & 256);
        for (int e = 0; e < 3; ++e)
            inside = inside && (x[e] - q[0]) * (y[e + 1] - q[1]) - (y[e] - q[1]) * (x[e + 1] - q[0]) >= 0;
        if (inside)
            return i + 1;
    }
    return cell[1];
}

/* The inputs of the floor shaders: texel, neighbours and table addresses, ready to fetch. */
static void prepare_floor(const btf_material *material, const uint32_t *decode, uint32_t *floor) {
    btf_ref_material m;
    reference_view(material, 0, &m);
    for (int i = 0; i < PIXELS; ++i, decode += GPU_INPUTS, floor += GPU_INPUTS) {
        float f[8];
        int32_t q[2];
        uint32_t first, tried;
        memcpy(f, decode, sizeof f);
        floor[0] = btf_ref_coordinate(f[0], m.width) >> 18;
        floor[1] = m.height - 1 - (btf_ref_coordinate(f[1], m.height) >> 18);
        for (int of_lights = 0; of_lights < 2; ++of_lights) {
            const uint16_t *table = of_lights ? m.light_table : m.view_table;
            uint32_t grid = of_lights ? m.light_grid : m.view_grid;
            btf_ref_project(f + (of_lights ? 2 : 5), q);
            btf_ref_neighbours n = btf_ref_lookup(table, grid, q);
            tried = records_tried(table, grid, q, &first);
            floor[2 + of_lights] = n.index[0] | n.index[1] << 8 | n.index[2] << 16 | tried << 24;
            floor[4 + of_lights] = first;
        }
        floor[6] = floor[7] = 0;
    }
}

/* Draws a program over `inputs`, after one run that compiles; returns core ns a pixel, 0 on an error. */
static double measure(bench *b, unsigned program, const uint32_t *inputs, double *out_spread) {
    enum { DRAWS = 2 };
    double ns[MOST_REPEATS];
    if (gpu_run(b->gpu, program, PIXELS, inputs, b->outputs, b->log) != BTF_OK)
        return 0;
    for (int i = 0; i < b->repeats; ++i) {
        double before = core_seconds();
        if (gpu_draw(b->gpu, program, SIDE, DRAWS) != BTF_OK)
            return 0;
        ns[i] = 1e9 * (core_seconds() - before) / (DRAWS * PIXELS);
    }
    qsort(ns, (size_t)b->repeats, sizeof *ns, compare_double);
    double median = ns[b->repeats / 2];
    if (out_spread)
        *out_spread = (ns[b->repeats - 1] - ns[0]) / median;
    return median;
}

/* Compiles a body around a variant, uploads, binds, measures. */
static double measure_variant(bench *b, const btf_material *material, const btf_shader_options *shader,
                              const char *body, const uint32_t *inputs, double *out_spread) {
    char *text = NULL;
    btf_gl *gl = NULL;
    double ns = 0;
    if (btf_shader_source(material, shader, b->log, &text) != BTF_OK)
        return 0;
    unsigned program = gpu_program(b->gpu, NULL, text, body, b->log);
    btf_free(text);
    btf_gl_options options = gpu_gl_options(b->gpu, shader);
    if (program && btf_gl_upload(material, &options, b->log, &gl) == BTF_OK &&
        btf_gl_bind(gl, program, GPU_FIRST_UNIT, NULL, b->log, NULL) == BTF_OK)
        ns = measure(b, program, inputs, out_spread);
    btf_gl_destroy(&gl);
    gpu_delete_program(b->gpu, program);
    return ns;
}

static bench_decode_row *add_row(bench *b, const char *name, int components) {
    bench_decode_row *row =
        &b->out->rows[b->out->count < BENCH_DECODE_MAX ? b->out->count++ : BENCH_DECODE_MAX - 1];
    *row = (bench_decode_row){.components = components};
    snprintf(row->name, sizeof row->name, "%s", name);
    return row;
}

/* A variant, its floor and its fast math. */
static btf_result bench_variant(bench *b, const char *name, const btf_material *material,
                                btf_shader_options shader) {
    shader.struct_size = sizeof shader;
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    int residual = (info.effects & ~shader.leave_out & BTF_EFFECT_RESIDUAL) != 0;
    uint32_t k =
        shader.components && shader.components < info.components ? shader.components : info.components;
    bench_decode_row *row = add_row(b, name, residual ? (int)k : 0);
    row->ns = measure_variant(b, material, &shader, bench_body_decode, b->inputs, &row->spread);
    /* The floor is of one texel. */
    if (shader.filter == BTF_FILTER_TEXEL) {
        uint32_t *floor = calloc(PIXELS, GPU_INPUTS * sizeof *floor);
        if (!floor)
            return BTF_ERROR_MEMORY;
        prepare_floor(material, b->inputs, floor);
        row->floor_ns = measure_variant(b, material, &shader, bench_body_floor, floor, NULL);
        free(floor);
    }
    shader.math = BTF_MATH_FAST;
    row->fast_ns = measure_variant(b, material, &shader, bench_body_decode, b->inputs, NULL);
    return row->ns > 0 ? BTF_OK : BTF_ERROR_INTERNAL;
}

#define GL(type, name) ((type)get(options.user, #name))

/* A texture of random bytes on a unit; returns its name. layers 0: a 2D texture with mip levels, filtered.
 */
static GLuint random_texture(bench *b, int unit, GLint format, int width, int height, int layers) {
    btf_gl_options options = gpu_gl_options(b->gpu, NULL);
    btf_gl_get_proc_address get = options.get_proc_address;
    size_t size = 4 * (size_t)width * (size_t)height * (size_t)(layers ? layers : 1);
    GLenum target = layers ? GL_TEXTURE_2D_ARRAY : GL_TEXTURE_2D;
    unsigned char *bytes = malloc(size);
    GLuint texture = 0;
    random_state r = {size};
    if (!bytes)
        return 0;
    for (size_t i = 0; i + 8 <= size; i += 8) {
        uint64_t bits = random_bits(&r);
        memcpy(bytes + i, &bits, sizeof bits);
    }
    GL(PFNGLACTIVETEXTUREPROC, glActiveTexture)((GLenum)(GL_TEXTURE0 + unit));
    GL(PFNGLGENTEXTURESPROC, glGenTextures)(1, &texture);
    GL(PFNGLBINDTEXTUREPROC, glBindTexture)(target, texture);
    if (layers) {
        GL(PFNGLTEXPARAMETERIPROC, glTexParameteri)(target, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
        GL(PFNGLTEXPARAMETERIPROC, glTexParameteri)(target, GL_TEXTURE_MAX_LEVEL, 0);
        GL(PFNGLTEXIMAGE3DPROC, glTexImage3D)
        (target, 0, format, width, height, layers, 0, GL_RGBA, GL_UNSIGNED_BYTE, bytes);
    } else {
        GL(PFNGLTEXIMAGE2DPROC, glTexImage2D)
        (target, 0, format, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, bytes);
        GL(PFNGLGENERATEMIPMAPPROC, glGenerateMipmap)(target);
    }
    free(bytes);
    return texture;
}

/* A peer on textures of its own, two at most; the library's text gives it neighbours. */
static void bench_peer(bench *b, const char *name, const btf_material *material, const char *body,
                       const char *const samplers[2], const GLuint textures[2]) {
    btf_gl_options options = gpu_gl_options(b->gpu, NULL);
    btf_gl_get_proc_address get = options.get_proc_address;
    btf_shader_options shader = {
        .struct_size = sizeof shader, .leave_out = BTF_EFFECT_ALL, .math = BTF_MATH_FAST};
    char *text = NULL;
    btf_gl *gl = NULL;
    bench_decode_row *row = add_row(b, name, 0);
    if (btf_shader_source(material, &shader, b->log, &text) != BTF_OK)
        return;
    unsigned program = gpu_program(b->gpu, NULL, text, body, b->log);
    btf_free(text);
    btf_gl_options upload = gpu_gl_options(b->gpu, &shader);
    if (program && btf_gl_upload(material, &upload, b->log, &gl) == BTF_OK &&
        btf_gl_bind(gl, program, GPU_FIRST_UNIT + 2, NULL, b->log, NULL) == BTF_OK) {
        GL(PFNGLUSEPROGRAMPROC, glUseProgram)(program);
        for (int i = 0; i < 2 && samplers[i]; ++i) {
            GLint location = GL(PFNGLGETUNIFORMLOCATIONPROC, glGetUniformLocation)(program, samplers[i]);
            GL(PFNGLUNIFORM1IPROC, glUniform1i)(location, GPU_FIRST_UNIT + i);
        }
        row->ns = measure(b, program, b->inputs, &row->spread);
    }
    btf_gl_destroy(&gl);
    gpu_delete_program(b->gpu, program);
    GL(PFNGLDELETETEXTURESPROC, glDeleteTextures)(2, textures);
}

static void bench_peers(bench *b, const btf_material *material) {
    GLuint phong[2] = {random_texture(b, GPU_FIRST_UNIT, GL_SRGB8_ALPHA8, 256, 256, 0),
                       random_texture(b, GPU_FIRST_UNIT + 1, GL_RGBA8, 256, 256, 0)};
    bench_peer(b, "Phong, two filtered textures", material, bench_body_phong,
               (const char *const[]){"peer_albedo", "peer_normal"}, phong);
    GLuint lookup[2] = {
        random_texture(b, GPU_FIRST_UNIT, GL_SRGB8_ALPHA8, 9 * TEXELS, 9 * TEXELS, RING_DIRECTIONS), 0};
    bench_peer(b, "uncompressed BTF, 3 x 3 directions", material, bench_body_lookup,
               (const char *const[]){"peer_images", NULL}, lookup);
}

static synthetic_spec base_spec(void) {
    return (synthetic_spec){.seed = 1,
                            .width = TEXELS,
                            .height = TEXELS,
                            .n_views = RING_DIRECTIONS,
                            .n_lights = RING_DIRECTIONS,
                            .centres = 1984};
}

/* PCA of 8-bit components: a residual without shifts, decoded by a shader that fetches U once. */
static btf_result bench_pca(bench *b, const int *ranks, int count) {
    synthetic_spec spec = base_spec();
    spec.layout = BTF_LAYOUT_TIGHT;
    spec.colour = BTF_COLOUR_NONE;
    spec.effects = BTF_EFFECT_RESIDUAL;
    for (int i = 0; i < count; ++i) {
        spec.components = (uint32_t)ranks[i];
        btf_material *material = NULL;
        btf_result result = synthetic_create(&spec, b->log, &material);
        if (result != BTF_OK)
            return result;
        btf_shader_options shader = {.struct_size = sizeof shader, .math = BTF_MATH_FAST};
        bench_decode_row *row = add_row(b, "PCA, 8 bit", ranks[i]);
        row->ns = measure_variant(b, material, &shader, bench_body_pca, b->inputs, &row->spread);
        btf_material_close(&material);
    }
    return BTF_OK;
}

/* Opening from memory and uploading, the best of a few. */
static btf_result bench_loading(bench *b, const btf_material *material) {
    void *file = NULL;
    size_t size = 0;
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    b->out->bytes = (double)(info.gpu_bytes + info.table_bytes);
    btf_result result = btf_material_save_memory(material, b->log, &file, &size);
    b->out->open_ms = b->out->upload_ms = INFINITY;
    for (int i = 0; i < b->repeats && result == BTF_OK; ++i) {
        btf_material *opened = NULL;
        btf_gl *gl = NULL;
        btf_gl_options options = gpu_gl_options(b->gpu, NULL);
        double t0 = wall_seconds();
        result = btf_material_open_memory(file, size, b->log, &opened);
        double t1 = wall_seconds();
        if (result == BTF_OK)
            result = btf_gl_upload(opened, &options, b->log, &gl);
        double t2 = wall_seconds();
        b->out->open_ms = fmin(b->out->open_ms, 1e3 * (t1 - t0));
        b->out->upload_ms = fmin(b->out->upload_ms, 1e3 * (t2 - t1));
        btf_gl_destroy(&gl);
        btf_material_close(&opened);
    }
    btf_free(file);
    return result;
}

/* The variants of layout paper, then of layout tight. */
static btf_result bench_variants(bench *b) {
    synthetic_spec spec = base_spec();
    spec.colour = BTF_COLOUR_MONO;
    spec.lobes = 3;
    spec.effects = BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN;
    btf_material *paper = NULL, *tight = NULL;
    btf_result result = synthetic_create(&spec, b->log, &paper);
    static const struct {
        const char *name;
        btf_shader_options shader;
    } papers[] =
        {
            {"paper: full", {0}},
            {"paper: full, nearest directions", {.interpolation = BTF_INTERPOLATION_NEAREST}},
            {"paper: full, bilinear", {.filter = BTF_FILTER_BILINEAR}},
            {"paper: without hidden", {.leave_out = BTF_EFFECT_HIDDEN}},
            {"paper: SBRDF and shadow (STVS)", {.leave_out = BTF_EFFECT_HIDDEN | BTF_EFFECT_SHIFT}},
            {"paper: SBRDF", {.leave_out = BTF_EFFECT_ALL}},
        },
      tights[] = {
          {"joint: full", {0}},
          {"joint: full, nearest directions", {.interpolation = BTF_INTERPOLATION_NEAREST}},
          {"joint: full, bilinear", {.filter = BTF_FILTER_BILINEAR}},
          {"joint: residual cut", {.components = 8}},
          {"joint: residual cut", {.components = 4}},
          {"joint: without residual", {.leave_out = BTF_EFFECT_RESIDUAL}},
          {"joint: SBRDF", {.leave_out = BTF_EFFECT_ALL}},
      };
    for (size_t i = 0; i < sizeof papers / sizeof *papers && result == BTF_OK; ++i)
        result = bench_variant(b, papers[i].name, paper, papers[i].shader);
    spec.layout = BTF_LAYOUT_TIGHT;
    spec.domain = BTF_DOMAIN_SQRT;
    spec.colour = BTF_COLOUR_RGB;
    spec.lobes = 2;
    spec.half_float = 1;
    spec.effects = BTF_EFFECT_ALL;
    spec.components = 16;
    if (result == BTF_OK)
        result = synthetic_create(&spec, b->log, &tight);
    for (size_t i = 0; i < sizeof tights / sizeof *tights && result == BTF_OK; ++i)
        result = bench_variant(b, tights[i].name, tight, tights[i].shader);
    btf_material_close(&tight);
    /* Sources of the residual alone, under shifts. */
    spec.colour = BTF_COLOUR_NONE;
    spec.lobes = 0;
    spec.effects = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL;
    spec.components = 48;
    if (result == BTF_OK)
        result = synthetic_create(&spec, b->log, &tight);
    if (result == BTF_OK)
        result = bench_variant(b, "joint: residual sources", tight, (btf_shader_options){0});
    if (result == BTF_OK)
        result = bench_variant(b, "joint: residual sources", tight, (btf_shader_options){.components = 16});
    if (result == BTF_OK)
        result = bench_loading(b, tight);
    if (result == BTF_OK)
        bench_peers(b, paper);
    btf_material_close(&tight);
    btf_material_close(&paper);
    return result;
}

/* A material from a file, as a scene would decode it. */
static btf_result bench_file(bench *b, const char *path) {
    const char *base = strrchr(path, '/');
    char name[BENCH_DECODE_NAME];
    btf_material *material = NULL;
    btf_result result = btf_material_open(path, b->log, &material);
    static const struct {
        const char *how;
        btf_shader_options shader;
    } ways[] = {
        {"", {0}},
        {", nearest directions", {.interpolation = BTF_INTERPOLATION_NEAREST}},
        {", bilinear", {.filter = BTF_FILTER_BILINEAR}},
    };
    for (size_t i = 0; i < sizeof ways / sizeof *ways && result == BTF_OK; ++i) {
        snprintf(name, sizeof name, "%.36s%s", base ? base + 1 : path, ways[i].how);
        result = bench_variant(b, name, material, ways[i].shader);
    }
    btf_material_close(&material);
    return result;
}

btf_result bench_decode_run(int repeats, char *const *files, int file_count, const btf_log *log,
                            bench_decode *out) {
    static const int ranks[] = {4, 8, 16, 32, 48, 98, 196};
    *out = (bench_decode){0};
    bench b = {.log = log,
               .repeats = repeats < 1              ? 1
                          : repeats > MOST_REPEATS ? MOST_REPEATS
                                                   : repeats,
               .out = out};
    char why[300];
    context_prepare(&context_devices[0]);
    b.gpu = gpu_create(&context_devices[0], why, sizeof why);
    if (!b.gpu) {
        if (log && log->callback)
            log->callback(log->user, BTF_LOG_ERROR, why);
        return BTF_ERROR_UNSUPPORTED;
    }
    snprintf(out->renderer, sizeof out->renderer, "%s", gpu_name(b.gpu));
    b.inputs = calloc(PIXELS, GPU_INPUTS * sizeof *b.inputs);
    b.outputs = calloc(PIXELS, GPU_OUTPUTS * sizeof *b.outputs);
    btf_result result = b.inputs && b.outputs ? BTF_OK : BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        for (int i = 0; i < PIXELS; ++i) {
            float f[8];
            sphere_pixel(i, f);
            memcpy(b.inputs + GPU_INPUTS * (size_t)i, f, sizeof f);
        }
        result = bench_variants(&b);
    }
    for (int i = 0; i < file_count && result == BTF_OK; ++i)
        result = bench_file(&b, files[i]);
    if (result == BTF_OK)
        result = bench_pca(&b, ranks, sizeof ranks / sizeof *ranks);
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    out->peak_mb = (double)usage.ru_maxrss * 1024 * 1e-6;
    free(b.inputs);
    free(b.outputs);
    gpu_destroy(&b.gpu);
    return result;
}

void bench_decode_print(const bench_decode *result, FILE *markdown, FILE *csv) {
    if (markdown)
        fprintf(markdown,
                "%s; core ns a pixel, median; 64 x 64 texels, 81 x 81 directions.\n\n"
                "| shader | k | ns | spread | floor | times floor | fast math | times fast |\n"
                "| --- | --- | --- | --- | --- | --- | --- | --- |\n",
                result->renderer);
    if (csv)
        fprintf(csv, "shader,components,ns,spread,floor_ns,fast_ns\n");
    for (int i = 0; i < result->count; ++i) {
        const bench_decode_row *r = &result->rows[i];
        if (csv)
            fprintf(csv, "\"%s\",%d,%.1f,%.3f,%.1f,%.1f\n", r->name, r->components, r->ns, r->spread,
                    r->floor_ns, r->fast_ns);
        if (!markdown)
            continue;
        fprintf(markdown, "| %s | %d | %.0f | %.0f%% |", r->name, r->components, r->ns, 100 * r->spread);
        if (r->floor_ns > 0)
            fprintf(markdown, " %.0f | %.2f |", r->floor_ns, r->ns / r->floor_ns);
        else
            fprintf(markdown, " | |");
        if (r->fast_ns > 0)
            fprintf(markdown, " %.0f | %.2f |\n", r->fast_ns, r->ns / r->fast_ns);
        else
            fprintf(markdown, " | |\n");
    }
    if (markdown)
        fprintf(markdown,
                "\nA material of %.2f MB: opened from memory in %.1f ms, uploaded in %.1f ms. Peak memory "
                "of the "
                "process, the uncompressed BTF of the peer included: %.0f MB.\n\n",
                1e-6 * result->bytes, result->open_ms, result->upload_ms, result->peak_mb);
}
