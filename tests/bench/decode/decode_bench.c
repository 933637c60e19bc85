/* Times of decoding: every variant, the floor of its fetches, fast math, and the peers, on one GL context.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decode_bench.h"
#include "decode_rig.h"
#include "decode_shaders.h"

#include "tests/conformance/synthetic.h"

#include <GL/glcorearb.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

enum { TEXELS = 64, RING_DIRECTIONS = 81 };

typedef struct bench {
    decode_rig rig;
    const btf_log *log;
    bench_decode *out;
} bench;

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
    row->ns =
        rig_measure_variant(&b->rig, material, &shader, bench_body_decode, b->rig.inputs, &row->spread);
    uint32_t *floor = calloc(RIG_PIXELS, GPU_INPUTS * sizeof *floor);
    if (!floor) {
        return BTF_ERROR_MEMORY;
    }
    rig_floor_inputs(material, b->rig.inputs, floor);
    row->floor_ns = rig_measure_variant(&b->rig, material, &shader, bench_body_floor, floor, NULL);
    free(floor);
    shader.math = BTF_MATH_FAST;
    row->fast_ns = rig_measure_variant(&b->rig, material, &shader, bench_body_decode, b->rig.inputs, NULL);
    return row->ns > 0 ? BTF_OK : BTF_ERROR_INTERNAL;
}

/* Times a peer on textures of its own, two at most. The library's shader text finds its neighbours. */
static void bench_peer(bench *b, const char *name, const btf_material *material, const char *body,
                       const char *const samplers[2], const unsigned textures[2]) {
    btf_shader_options shader = {.leave_out = BTF_EFFECT_ALL, .math = BTF_MATH_FAST};
    bench_decode_row *row = add_row(b, name, 0);
    rig_variant variant = rig_variant_create(&b->rig, material, &shader, body, GPU_FIRST_UNIT + 2);
    if (variant.program) {
        for (int i = 0; i < 2 && samplers[i]; ++i) {
            rig_sampler(&b->rig, variant.program, samplers[i], GPU_FIRST_UNIT + i);
        }
        row->ns = rig_measure(&b->rig, variant.program, b->rig.inputs, RIG_SIDE, &row->spread);
    }
    rig_variant_destroy(&b->rig, &variant);
    rig_texture_delete(&b->rig, 2, textures);
}

static void bench_peers(bench *b, const btf_material *material) {
    decode_rig *rig = &b->rig;
    unsigned phong[2] = {rig_texture(rig, GPU_FIRST_UNIT, GL_SRGB8_ALPHA8, 256, 256, 0, NULL),
                         rig_texture(rig, GPU_FIRST_UNIT + 1, GL_RGBA8, 256, 256, 0, NULL)};
    bench_peer(b, "Phong, two filtered textures", material, bench_body_phong,
               (const char *const[]){"peer_albedo", "peer_normal"}, phong);
    unsigned lookup[2] = {
        rig_texture(rig, GPU_FIRST_UNIT, GL_SRGB8_ALPHA8, 9 * TEXELS, 9 * TEXELS, RING_DIRECTIONS, NULL),
        0};
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
        if (result != BTF_OK) {
            return result;
        }
        btf_shader_options shader = {.struct_size = sizeof shader, .math = BTF_MATH_FAST};
        bench_decode_row *row = add_row(b, "PCA, 8 bit", ranks[i]);
        row->ns =
            rig_measure_variant(&b->rig, material, &shader, bench_body_pca, b->rig.inputs, &row->spread);
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
    for (int i = 0; i < b->rig.repeats && result == BTF_OK; ++i) {
        btf_material *opened = NULL;
        btf_gl *gl = NULL;
        btf_gl_options options = gpu_gl_options(b->rig.gpu, NULL);
        double t0 = rig_wall_seconds();
        result = btf_material_open_memory(file, size, b->log, &opened);
        double t1 = rig_wall_seconds();
        if (result == BTF_OK) {
            result = btf_gl_upload(opened, &options, b->log, &gl);
        }
        double t2 = rig_wall_seconds();
        b->out->open_ms = fmin(b->out->open_ms, 1e3 * (t1 - t0));
        b->out->upload_ms = fmin(b->out->upload_ms, 1e3 * (t2 - t1));
        btf_gl_destroy(&gl);
        btf_material_close(&opened);
    }
    btf_free(file);
    return result;
}

/* Factors of 2.36, 1.26 and 0.68 MB; then the first with a source for each view, and with relief and gloss. */
static btf_result bench_factors(bench *b) {
    static const struct {
        const char *name;
        uint32_t classes[BTF_FACTOR_CLASSES][3], effects;
        synthetic_relief relief;
    } sets[] = {
        {"factors, 13 units", {{2, 2, 1}, {1, 0, 0}, {5, 2, 1}, {1, 0, 0}, {4, 1, 0}}, 0, SYNTHETIC_FLAT},
        {"factors, 7 units", {{1, 1, 1}, {1, 0, 0}, {3, 1, 1}, {0, 0, 0}, {2, 0, 0}}, 0, SYNTHETIC_FLAT},
        {"factors, 4 units", {{1, 1, 1}, {0, 0, 0}, {2, 1, 1}, {0, 0, 0}, {1, 0, 0}}, 0, SYNTHETIC_FLAT},
        {"factors, 13 units; shift",
         {{2, 2, 1}, {1, 0, 0}, {5, 2, 1}, {1, 0, 0}, {4, 1, 0}},
         BTF_EFFECT_SHIFT,
         SYNTHETIC_FLAT},
        {"factors, 13 units; one height",
         {{2, 2, 1}, {1, 0, 0}, {5, 2, 1}, {1, 0, 0}, {4, 1, 0}},
         BTF_EFFECT_RELIEF,
         SYNTHETIC_FLAT},
        {"factors, 13 units; relief",
         {{2, 2, 1}, {1, 0, 0}, {5, 2, 1}, {1, 0, 0}, {4, 1, 0}},
         BTF_EFFECT_RELIEF,
         SYNTHETIC_GENTLE},
        {"factors, 13 units; gloss",
         {{2, 2, 1}, {1, 0, 0}, {5, 2, 1}, {1, 0, 0}, {4, 1, 0}},
         BTF_EFFECT_GLOSS,
         SYNTHETIC_FLAT},
        {"factors, 13 units; both",
         {{2, 2, 1}, {1, 0, 0}, {5, 2, 1}, {1, 0, 0}, {4, 1, 0}},
         BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS,
         SYNTHETIC_GENTLE}};
    static const btf_shader_options ways[] = {
        {0}, {.filter = BTF_FILTER_STEEP}, {.interpolation = BTF_INTERPOLATION_NEAREST}};
    static const char *const words[] = {"", ", steep", ", nearest directions"};
    char name[BENCH_DECODE_NAME];
    btf_result result = BTF_OK;
    for (size_t i = 0; i < sizeof sets / sizeof *sets && result == BTF_OK; ++i) {
        synthetic_spec spec = base_spec();
        btf_material *material = NULL;
        spec.layout = BTF_LAYOUT_TIGHT;
        spec.domain = BTF_DOMAIN_SQRT;
        spec.colour = BTF_COLOUR_NONE;
        spec.effects = BTF_EFFECT_RESIDUAL | sets[i].effects;
        spec.relief = sets[i].relief;
        spec.gloss_share = sets[i].effects & BTF_EFFECT_GLOSS ? 1 : 0;
        memcpy(spec.classes, sets[i].classes, sizeof spec.classes);
        for (int c = 0; c < BTF_FACTOR_CLASSES; ++c) {
            spec.components += spec.classes[c][0];
        }
        result = synthetic_create(&spec, b->log, &material);
        for (size_t way = 0; way < sizeof ways / sizeof *ways && result == BTF_OK; ++way) {
            snprintf(name, sizeof name, "%s%s", sets[i].name, words[way]);
            result = bench_variant(b, name, material, ways[way]);
        }
        btf_material_close(&material);
    }
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
          {"low rank: full", {0}},
          {"low rank: full, nearest directions", {.interpolation = BTF_INTERPOLATION_NEAREST}},
          {"low rank: full, bilinear", {.filter = BTF_FILTER_BILINEAR}},
          {"low rank: residual cut", {.components = 8}},
          {"low rank: residual cut", {.components = 4}},
          {"low rank: without residual", {.leave_out = BTF_EFFECT_RESIDUAL}},
          {"low rank: SBRDF", {.leave_out = BTF_EFFECT_ALL}},
      };
    for (size_t i = 0; i < sizeof papers / sizeof *papers && result == BTF_OK; ++i) {
        result = bench_variant(b, papers[i].name, paper, papers[i].shader);
    }
    spec.layout = BTF_LAYOUT_TIGHT;
    spec.domain = BTF_DOMAIN_SQRT;
    spec.colour = BTF_COLOUR_RGB;
    spec.lobes = 2;
    spec.half_float = 1;
    spec.effects = BTF_EFFECT_VERSION_1;
    spec.components = 16;
    if (result == BTF_OK) {
        result = synthetic_create(&spec, b->log, &tight);
    }
    for (size_t i = 0; i < sizeof tights / sizeof *tights && result == BTF_OK; ++i) {
        result = bench_variant(b, tights[i].name, tight, tights[i].shader);
    }
    btf_material_close(&tight);
    /* a residual without an SBRDF, with shifts */
    spec.colour = BTF_COLOUR_NONE;
    spec.lobes = 0;
    spec.effects = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL;
    spec.components = 48;
    if (result == BTF_OK) {
        result = synthetic_create(&spec, b->log, &tight);
    }
    if (result == BTF_OK) {
        result = bench_variant(b, "low rank: residual sources", tight, (btf_shader_options){0});
    }
    if (result == BTF_OK) {
        result = bench_variant(b, "low rank: residual sources", tight, (btf_shader_options){.components = 16});
    }
    if (result == BTF_OK) {
        result = bench_loading(b, tight);
    }
    if (result == BTF_OK) {
        result = bench_factors(b);
    }
    if (result == BTF_OK) {
        bench_peers(b, paper);
    }
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
    char why[300];
    bench b = {.log = log, .out = out};
    *out = (bench_decode){0};
    btf_result result = rig_create(&context_devices[0], repeats, log, why, sizeof why, &b.rig);
    if (result != BTF_OK) {
        if (log && log->callback) {
            log->callback(log->user, BTF_LOG_ERROR, why);
        }
        return result;
    }
    snprintf(out->renderer, sizeof out->renderer, "%s", gpu_name(b.rig.gpu));
    result = bench_variants(&b);
    for (int i = 0; i < file_count && result == BTF_OK; ++i) {
        result = bench_file(&b, files[i]);
    }
    if (result == BTF_OK) {
        result = bench_pca(&b, ranks, sizeof ranks / sizeof *ranks);
    }
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    out->peak_mb = (double)usage.ru_maxrss * 1024 * 1e-6;
    rig_destroy(&b.rig);
    return result;
}

void bench_decode_print(const bench_decode *result, FILE *markdown, FILE *csv) {
    if (markdown) {
        fprintf(markdown,
                "%s; core ns a pixel, median; 64 x 64 texels, 81 x 81 directions.\n\n"
                "| shader | k | ns | spread | floor | times floor | fast math | times fast |\n"
                "| --- | --- | --- | --- | --- | --- | --- | --- |\n",
                result->renderer);
    }
    if (csv) {
        fprintf(csv, "shader,components,ns,spread,floor_ns,fast_ns\n");
    }
    for (int i = 0; i < result->count; ++i) {
        const bench_decode_row *r = &result->rows[i];
        if (csv) {
            fprintf(csv, "\"%s\",%d,%.1f,%.3f,%.1f,%.1f\n", r->name, r->components, r->ns, r->spread,
                    r->floor_ns, r->fast_ns);
        }
        if (!markdown) {
            continue;
        }
        fprintf(markdown, "| %s | %d | %.0f | %.0f%% |", r->name, r->components, r->ns, 100 * r->spread);
        if (r->floor_ns > 0) {
            fprintf(markdown, " %.0f | %.2f |", r->floor_ns, r->ns / r->floor_ns);
        } else {
            fprintf(markdown, " | |");
        }
        if (r->fast_ns > 0) {
            fprintf(markdown, " %.0f | %.2f |\n", r->fast_ns, r->ns / r->fast_ns);
        } else {
            fprintf(markdown, " | |\n");
        }
    }
    if (markdown) {
        fprintf(markdown,
                "\nA material of %.2f MB: opened from memory in %.1f ms, uploaded in %.1f ms. Peak memory "
                "of the "
                "process, the uncompressed BTF of the peer included: %.0f MB.\n\n",
                1e-6 * result->bytes, result->open_ms, result->upload_ms, result->peak_mb);
    }
}
