/* Section `decode`: what accuracy costs per pixel, for every set of effects, directions, filter and kind of
 * mathematics, on every GL device and on the CPU, beside peers. All of it is measured in one process.
 *
 * Accuracy is that of the device's own pixels: samples drawn at random from the data are decoded by the
 * very shader that is timed.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decode_cost.h"
#include "decode_materials.h"
#include "decode_peers.h"
#include "decode_shaders.h"
#include "decode_table.h"

#include "encoder/math/srgb.h"
#include "encoder/model/decode_samples.h"
#include "encoder/report/metrics.h"
#include "tests/bench/readme.h"
#include "tests/conformance/random.h"

#include <openbtf/evaluate.h>

#include <GL/glcorearb.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { PROBES = RIG_PIXELS, REFERENCE_PIXELS = 4096 };

/* Samples of the data as inputs of a shader, and what should come out. */
typedef struct probes {
    uint32_t *inputs; /* [PROBES][GPU_INPUTS]; NULL: none */
    float *truth;     /* [PROBES][3] */
} probes;

/* A codec of 8-bit components, and for what it was chosen. */
typedef struct peer_codec {
    const char *note; /* NULL: not there */
    pca_codec codec;
} peer_codec;

enum { PEER_CODECS = 2 };

typedef struct decoding {
    const bench_run *run;
    decode_material materials[DECODE_MATERIALS];
    peer_codec components[PEER_CODECS];
    probes trained, held, between;
    int repeats;
    decode_table *table;
    uint32_t *floor; /* inputs of a floor shader */
} decoding;

/* Probes.
 * ------------------------------------------------------------------------------------------------ */

static void probes_clear(probes *p) {
    free(p->inputs);
    free(p->truth);
    *p = (probes){0};
}

/* The middle of texel t, a hair further: u * 2^18 is rounded down. */
static void probe_input(int width, int height, size_t t, const enc_direction *light,
                        const enc_direction *view, uint32_t *out) {
    const float u = ((float)(t % (size_t)width) + 0.5f) / (float)width + 0x1p-18f;
    const float v = 1 - ((float)(t / (size_t)width) + 0.5f) / (float)height + 0x1p-18f;
    const float *l = light->xyz, *w = view->xyz;
    const float f[GPU_INPUTS] = {u, v, l[0], l[1], l[2], w[0], w[1], w[2]};
    memcpy(out, f, sizeof f);
}

static btf_result probes_create(const enc_context *context, const enc_data *data, probes *p) {
    const size_t texels = enc_data_texel_count(data), lights = (size_t)data->n_lights;
    random_state random = {1};
    float *buffer = malloc(enc_data_texel_stride(data) * sizeof *buffer);
    *p = (probes){calloc(PROBES, GPU_INPUTS * sizeof *p->inputs), calloc(PROBES, 3 * sizeof *p->truth)};
    btf_result result = buffer && p->inputs && p->truth
                            ? BTF_OK
                            : enc_fail(context, BTF_ERROR_MEMORY, "bench: out of memory for samples");
    for (size_t i = 0; i < PROBES && result == BTF_OK; i++) {
        /* Evenly over texels, so that each is read once. */
        const size_t t = i * texels / PROBES, view = random_bits(&random) % (uint64_t)data->n_views,
                     light = random_bits(&random) % lights;
        const float *samples;
        result = enc_data_texels(context, data, t, 1, buffer, &samples);
        probe_input(data->width, data->height, t, &data->lights[light], &data->views[view],
                    p->inputs + GPU_INPUTS * i);
        for (size_t c = 0; c < 3 && result == BTF_OK; c++) {
            p->truth[3 * i + c] = samples[(view * 3 + c) * lights + light];
        }
    }
    free(buffer);
    if (result != BTF_OK) {
        probes_clear(p);
    }
    return result;
}

/* The same between the samples. */
static btf_result probes_between(const enc_context *context, const bench_truth *truth, probes *p) {
    const size_t texels = (size_t)truth->width * (size_t)truth->height;
    random_state random = {2};
    *p = (probes){calloc(PROBES, GPU_INPUTS * sizeof *p->inputs), calloc(PROBES, 3 * sizeof *p->truth)};
    if (!p->inputs || !p->truth) {
        probes_clear(p);
        return enc_fail(context, BTF_ERROR_MEMORY, "bench: out of memory for samples");
    }
    for (size_t i = 0; i < PROBES; i++) {
        const size_t t = i * texels / PROBES, at = (size_t)(random_bits(&random) % truth->count);
        const enc_pair *pair = &truth->pair[at];
        probe_input(truth->width, truth->height, t, &pair->light, &pair->view, p->inputs + GPU_INPUTS * i);
        memcpy(p->truth + 3 * i, truth->images + 3 * (at * texels + t), 3 * sizeof *p->truth);
    }
    return BTF_OK;
}

/* PSNR of decoded[i * pitch .. + 2] against the truth, linear and sRGB-coded, clipped to [0, 1]. */
static void compare(const probes *p, const float *decoded, size_t pitch, double *out_linear,
                    double *out_srgb) {
    enc_error_sum sum = {.count = 3.0 * PROBES};
    for (size_t i = 0; i < PROBES; i++) {
        for (size_t c = 0; c < 3; c++) {
            const float a = fminf(fmaxf(decoded[i * pitch + c], 0), 1),
                        b = fminf(fmaxf(p->truth[3 * i + c], 0), 1);
            const double linear = (double)a - b, srgb = (double)enc_srgb_encode(a) - enc_srgb_encode(b);
            sum.linear += linear * linear;
            sum.srgb += srgb * srgb;
        }
    }
    *out_linear = enc_psnr_linear(&sum);
    *out_srgb = enc_psnr_srgb(&sum);
}

/* The accuracy of a compiled program into the row. */
static void probe(const decoding *d, decode_rig *rig, unsigned program, decode_row *row) {
    const probes *const sets[] = {&d->trained, &d->held, &d->between};
    for (int i = 0; i < 3; i++) {
        if (sets[i]->inputs &&
            gpu_run(rig->gpu, program, PROBES, sets[i]->inputs, rig->outputs, rig->log) == BTF_OK) {
            compare(sets[i], (const float *)(const void *)rig->outputs, GPU_OUTPUTS, &row->linear[i],
                    &row->srgb[i]);
        }
    }
}

/* Where truth between the samples is not known: an estimate.
 * ------------------------------------------------------------------------------------------------ */

static bool estimates(const decoding *d) {
    return d->run->truth->count == 0 && bench_between_has(d->run->between, BENCH_ESTIMATE);
}

/* Whether another row has it already, whatever the device, filter and mathematics. */
static bool estimated_before(const decoding *d, decode_row *row) {
    for (int i = 0; i < d->table->count; i++) {
        const decode_row *r = &d->table->rows[i];
        if (r->estimated && strcmp(r->material, row->material) == 0 &&
            strcmp(r->effects, row->effects) == 0 && r->nearest == row->nearest &&
            r->filter == row->filter) {
            row->linear[2] = r->linear[2];
            row->srgb[2] = r->srgb[2];
            row->estimated = true;
            return true;
        }
    }
    return false;
}

static void take_estimate(const double figures[2], decode_row *row) {
    row->linear[2] = figures[0];
    row->srgb[2] = figures[1];
    row->estimated = true;
}

/* Components that a subset decodes: whole groups of four, or units. */
static uint32_t part_of(const decode_material *m, const decode_subset *s) {
    const uint32_t group = m->view.store == BTF_REF_FACTORS ? 1 : 4, of = s->part * group;
    return s->part ? (m->view.components + of - 1) / of * group : 0;
}

static btf_result estimate_material(const decoding *d, const decode_material *m, const decode_subset *s,
                                    decode_row *row) {
    const btf_ref_options options = {.effects = BTF_EFFECT_ALL & ~s->leave_out,
                                     .components = s->part ? part_of(m, s) : UINT32_MAX,
                                     .interpolation = row->nearest ? BTF_REF_NEAREST : BTF_REF_LINEAR,
                                     .filter = (int)row->filter};
    bench_between_figures figures;
    if (!estimates(d) || estimated_before(d, row)) {
        return BTF_OK;
    }
    const btf_result result =
        bench_between_material(d->run->context, d->run->between, &m->view, &options, figures);
    if (result == BTF_OK) {
        take_estimate(figures[BENCH_ESTIMATE], row);
    }
    return result;
}

/* Of a peer's images, interpolated; of one without, no sample of which depends on others, that at them. */
static btf_result estimate_peer(const decoding *d, const enc_image_source *images, decode_row *row) {
    const enc_data *data = d->run->held->train;
    bench_between_figures figures = {[BENCH_ESTIMATE] = {row->linear[0], row->srgb[0]}};
    enc_data *decoded = NULL;
    btf_result result = BTF_OK;
    if (!estimates(d) || estimated_before(d, row)) {
        return BTF_OK;
    }
    if (images) {
        result = bench_decode_all(d->run->context, data, *images, &decoded);
        if (result == BTF_OK) {
            result = bench_between_images(d->run->context, d->run->between, decoded, ENC_INTERPOLATE_LINEAR,
                                          figures);
        }
        enc_data_destroy(&decoded);
    }
    if (result == BTF_OK) {
        take_estimate(figures[BENCH_ESTIMATE], row);
    }
    return result;
}

/* Our own materials.
 * ------------------------------------------------------------------------------------------------ */

/* A row's counts and bytes. */
static void count(const decode_material *m, const btf_shader_options *shader, decode_row *row) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(m->encoded.material, &info);
    row->gpu_bytes = (double)m->encoded.bytes;
    row->cost = decode_cost_of(&info, shader);
    row->counted = true;
}

/* The options of a subset; its fixed directions are the first of the material. */
static btf_shader_options options_of(const decode_material *m, const decode_subset *s,
                                     btf_shader_options how) {
    const btf_directions views = btf_material_views(m->encoded.material),
                         lights = btf_material_lights(m->encoded.material);
    how.leave_out = s->leave_out;
    how.components = part_of(m, s);
    how.fixed = s->fixed;
    memcpy(how.fixed_view, views.xyz, sizeof how.fixed_view);
    memcpy(how.fixed_light, lights.xyz, sizeof how.fixed_light);
    return how;
}

static decode_row row_of(const char *device, const decode_material *m, const char *effects,
                         const btf_shader_options *shader) {
    decode_row row = decode_row_named(device, m->name, effects);
    row.nearest = shader->interpolation == BTF_INTERPOLATION_NEAREST;
    row.filter = shader->filter;
    row.fast = shader->math == BTF_MATH_FAST;
    count(m, shader, &row);
    return row;
}

static btf_result run_variant(decoding *d, decode_rig *rig, const char *device, const decode_material *m,
                              const decode_subset *s, btf_shader_options how) {
    btf_result result = BTF_OK;
    const btf_shader_options shader = options_of(m, s, how);
    decode_row row = row_of(device, m, s->name, &shader);
    rig_variant variant =
        rig_variant_create(rig, m->encoded.material, &shader, bench_body_decode, GPU_FIRST_UNIT);
    if (variant.program) {
        row.ns = rig_measure(rig, variant.program, rig->inputs, RIG_SIDE, &row.spread);
        if (!s->fixed) {
            probe(d, rig, variant.program, &row);
            result = estimate_material(d, m, s, &row);
        }
    }
    rig_variant_destroy(rig, &variant);
    if (row.ns > 0) {
        decode_table_add(d->table, &row);
    }
    return result;
}

/* The fetches of the whole material, added up. */
static void run_floor(decoding *d, decode_rig *rig, const char *device, const decode_material *m,
                      btf_shader_options shader) {
    decode_row row = row_of(device, m, DECODE_FLOOR, &shader);
    row.cost.integers = row.cost.floats = 0;
    row.ns =
        rig_measure_variant(rig, m->encoded.material, &shader, bench_body_floor, d->floor, &row.spread);
    if (row.ns > 0) {
        decode_table_add(d->table, &row);
    }
}

/* Bits of a way to decode: nearest directions, bilinear texels, native mathematics, steep texels. */
enum { WAYS = 9 };

/* Whether a subset is decoded in this way: all of them in every way where `all`; else the whole in both
 * interpolations of texels, and on the first device whatever is exact there. Directions that never change
 * and parts of factors are decoded in one way; so are further factors where not all is wanted, on the first
 * device natively too. Relief: exact, on the first device, by each filter. */
static bool is_run(const decoding *d, const decode_material *m, int s, int way, bool all) {
    const decode_subset *of = &m->subsets[s];
    const bool first = d->table->devices == 1;
    const bool factors = m->view.store == BTF_REF_FACTORS, relief = strcmp(m->name, DECODE_RELIEF) == 0;
    if (relief) {
        return first && (s == 0 ? (way & 5) == 0 : way == 0);
    }
    if (of->fixed || (s > 0 && factors)) {
        return way == 0 && first;
    }
    if (factors && !all && m != decode_material_find(d->materials, DECODE_JOINT)) {
        return way == 0 || (first && way == 4);
    }
    if (way & 8) {
        return false;
    }
    return all || (s == 0 && (way & 2) == 0) || (s == 0 && first) || (first && way < 2);
}

static btf_result run_material(decoding *d, decode_rig *rig, const char *device, const decode_material *m,
                               bool all) {
    btf_result result = BTF_OK;
    for (int s = 0; s < m->count; s++) {
        for (int way = 0; way < WAYS && result == BTF_OK; way++) {
            const btf_shader_options shader = {.interpolation = way & 1 ? BTF_INTERPOLATION_NEAREST
                                                                        : BTF_INTERPOLATION_LINEAR,
                                               .filter = way & 8   ? BTF_FILTER_STEEP
                                                         : way & 2 ? BTF_FILTER_BILINEAR
                                                                   : BTF_FILTER_TEXEL,
                                               .math = way & 4 ? BTF_MATH_FAST : BTF_MATH_EXACT};
            if (is_run(d, m, s, way, all)) {
                result = run_variant(d, rig, device, m, &m->subsets[s], shader);
            }
        }
    }
    if (strcmp(m->name, DECODE_RELIEF) == 0) {
        return result; /* where its fetches are depends on the heights */
    }
    rig_floor_inputs(m->encoded.material, rig->inputs, d->floor);
    run_floor(d, rig, device, m, (btf_shader_options){0});
    if (all && d->table->devices == 1) {
        run_floor(d, rig, device, m, (btf_shader_options){.interpolation = BTF_INTERPOLATION_NEAREST});
        run_floor(d, rig, device, m, (btf_shader_options){.filter = BTF_FILTER_BILINEAR});
    }
    return result;
}

/* Decoding at smaller and smaller pictures. */
static void run_sizes(decoding *d, decode_rig *rig, const char *device, const decode_material *m) {
    const btf_shader_options shader = {0};
    rig_variant variant =
        rig_variant_create(rig, m->encoded.material, &shader, bench_body_decode, GPU_FIRST_UNIT);
    for (int side = RIG_SIDE / 8; variant.program && side <= RIG_SIDE; side *= 2) {
        decode_row row = row_of(device, m, "whole", &shader);
        row.side = side;
        row.ns = rig_measure(rig, variant.program, rig->inputs, side, &row.spread);
        decode_table_add_size(d->table, &row);
    }
    rig_variant_destroy(rig, &variant);
}

/* Peers.
 * ------------------------------------------------------------------------------------------------ */

/* images: what it decodes to at the samples and interpolates; NULL: it has no samples. */
static btf_result run_peer(decoding *d, decode_rig *rig, const char *device, const char *name,
                           const char *note, const btf_material *tables, uint32_t leave_out,
                           decode_cost cost, double bytes, const char *body, const char *const samplers[2],
                           const enc_image_source *images) {
    btf_result result = BTF_OK;
    const btf_shader_options shader = {.leave_out = leave_out, .math = BTF_MATH_FAST};
    decode_row row = decode_row_named(device, name, note);
    row.peer = true;
    row.fast = true;
    row.cost = cost;
    row.counted = true;
    row.gpu_bytes = bytes;
    rig_variant variant = rig_variant_create(rig, tables, &shader, body, GPU_FIRST_UNIT + 2);
    if (variant.program) {
        for (int i = 0; i < 2 && samplers[i]; ++i) {
            rig_sampler(rig, variant.program, samplers[i], GPU_FIRST_UNIT + i);
        }
        row.ns = rig_measure(rig, variant.program, rig->inputs, RIG_SIDE, &row.spread);
        probe(d, rig, variant.program, &row);
        result = estimate_peer(d, images, &row);
    }
    rig_variant_destroy(rig, &variant);
    if (row.ns > 0) {
        decode_table_add(d->table, &row);
    }
    return result;
}

static btf_result run_phong(decoding *d, decode_rig *rig, const char *device, const btf_material *tables) {
    const enc_data *data = d->run->held->train;
    unsigned char *albedo, *normal;
    btf_result result = peer_phong(d->run->context, data, &albedo, &normal);
    if (result == BTF_OK) {
        const unsigned textures[2] = {
            rig_texture(rig, GPU_FIRST_UNIT, GL_SRGB8_ALPHA8, data->width, data->height, 0, albedo),
            rig_texture(rig, GPU_FIRST_UNIT + 1, GL_RGBA8, data->width, data->height, 0, normal)};
        result = run_peer(d, rig, device, "Phong", "two maps", tables, BTF_EFFECT_ALL, decode_cost_phong(),
                          8 * (double)enc_data_texel_count(data), bench_body_phong,
                          (const char *const[]){"peer_albedo", "peer_normal"}, NULL);
        rig_texture_delete(rig, 2, textures);
        free(albedo);
        free(normal);
    }
    return result;
}

static btf_result run_look_up(decoding *d, decode_rig *rig, const char *device,
                              const btf_material *tables) {
    const enc_data *data = d->run->held->train;
    unsigned char *bytes;
    int columns, rows;
    btf_result result = peer_images(d->run->context, data, &columns, &rows, &bytes);
    if (result == BTF_OK) {
        const unsigned texture = rig_texture(rig, GPU_FIRST_UNIT, GL_SRGB8_ALPHA8, columns * data->width,
                                             rows * data->height, data->n_views, bytes);
        const enc_image_source images = enc_data_images(data);
        result = run_peer(d, rig, device, "uncompressed", "3 x 3 images of 8 bits", tables, BTF_EFFECT_ALL,
                          decode_cost_lookup(), bench_samples_8bit(data), bench_body_lookup,
                          (const char *const[]){"peer_images", NULL}, &images);
        rig_texture_delete(rig, 1, &texture);
        free(bytes);
    }
    return result;
}

static btf_result run_pca(decoding *d, decode_rig *rig, const char *device, const peer_codec *peer) {
    const pca_codec *codec = &peer->codec;
    char name[64];
    btf_material *components = NULL;
    btf_result result = peer_components(d->run->context, codec, &components);
    if (result == BTF_OK) {
        snprintf(name, sizeof name, "rank %zu; %s", codec->rank, peer->note);
        const enc_image_source images = pca_images(codec);
        result = run_peer(d, rig, device, "PCA", name, components, 0, decode_cost_pca((int)codec->rank),
                          (double)codec->bytes, bench_body_pca, (const char *const[]){NULL, NULL}, &images);
    }
    btf_material_close(&components);
    return result;
}

/* The smallest rank of 8-bit components that reaches the linear PSNR; none where they do not. */
static btf_result find_quality(decoding *d, const pca_factors *factors, double target, peer_codec *out) {
    const enc_data *data = d->run->held->train;
    const enc_context *context = d->run->context;
    size_t low = 0, high = factors->rank + 1;
    btf_result result = BTF_OK;
    while (high - low > 1 && result == BTF_OK) {
        const size_t rank = (low + high) / 2;
        pca_codec codec;
        enc_metrics m;
        result = pca_encode(context, factors, PCA_BYTE, rank, &codec);
        if (result == BTF_OK) {
            result =
                enc_metrics_compare(context, data, enc_data_images(data), pca_images(&codec), false, &m);
            if (result == BTF_OK && enc_psnr_linear(&m.total) >= target) {
                high = rank;
            } else {
                low = rank;
            }
            pca_codec_clear(&codec);
        }
    }
    if (result == BTF_OK && high <= factors->rank) {
        return pca_encode(context, factors, PCA_BYTE, high, &out->codec);
    }
    if (result == BTF_OK) {
        fprintf(
            d->run->summary,
            "PCA of rank %zu, the largest that a file of version 1 holds, does not reach %.2f dB (%s).\n\n",
            factors->rank, target, out->note);
    }
    out->note = NULL;
    return result;
}

/* Errors over all samples. */
static btf_result measure_samples(const bench_run *run, const decode_material *m, enc_metrics *out) {
    const enc_data *data = run->held->train;
    enc_sample_decoder *decoder = NULL;
    btf_result result = enc_sample_decoder_create(run->context, data, &m->encoded.solution, &decoder);
    const enc_decoded_samples played = {.decoder = decoder, .effects = BTF_EFFECT_ALL};
    if (result == BTF_OK) {
        result = enc_metrics_compare(run->context, data, enc_data_images(data), enc_decoded_images(&played),
                                     false, out);
    }
    enc_sample_decoder_destroy(&decoder);
    return result;
}

/* Components of the bytes of joint, and of its quality. */
static btf_result find_ranks(decoding *d) {
    const enc_data *data = d->run->held->train;
    const decode_material *joint = decode_material_find(d->materials, DECODE_JOINT);
    enc_metrics metrics;
    pca_factors factors;
    if (!joint || !(d->run->methods & BENCH_METHOD_PEERS)) {
        return BTF_OK;
    }
    btf_result result = measure_samples(d->run, joint, &metrics);
    if (result == BTF_OK) {
        result = pca_factorise(d->run->context, data, PCA_LINEAR, 256, &factors);
    }
    if (result != BTF_OK) {
        return result;
    }
    size_t rank = pca_rank_for(data, PCA_BYTE, 1, joint->encoded.bytes);
    rank = rank < factors.rank ? rank : factors.rank;
    if (rank > 0) {
        d->components[0].note = "equal bytes";
        result = pca_encode(d->run->context, &factors, PCA_BYTE, rank, &d->components[0].codec);
    }
    if (result == BTF_OK) {
        d->components[1].note = "equal quality";
        result = find_quality(d, &factors, enc_psnr_linear(&metrics.total), &d->components[1]);
    }
    pca_factors_clear(&factors);
    return result;
}

/* The CPU.
 * ------------------------------------------------------------------------------------------------ */

/* The two decoders of the CPU, of the same bits. */
typedef struct cpu_decoder {
    const char *device;
    const decode_material *material;
    btf_evaluator *evaluator; /* NULL: the reference */
} cpu_decoder;

static void cpu_pixels(const cpu_decoder *c, const decode_row *row, const uint32_t *inputs, size_t count,
                       float *out) {
    const btf_ref_options options = {.effects = BTF_EFFECT_ALL,
                                     .components = UINT32_MAX,
                                     .interpolation = row->nearest ? BTF_REF_NEAREST : BTF_REF_LINEAR,
                                     .filter = (int)row->filter};
    const btf_evaluate_options many = {
        .struct_size = sizeof many,
        .interpolation = row->nearest ? BTF_INTERPOLATION_NEAREST : BTF_INTERPOLATION_LINEAR,
        .filter = row->filter};
    enum { CHUNK = 64 };
    for (size_t first = 0; first < count; first += CHUNK) {
        const size_t some = count - first < CHUNK ? count - first : CHUNK;
        float f[CHUNK][GPU_INPUTS];
        memcpy(f, inputs + GPU_INPUTS * first, some * sizeof *f);
        for (size_t i = 0; i < some && !c->evaluator; i++) {
            btf_ref_evaluate(&c->material->view, &options, f[i][0], f[i][1], f[i] + 2, f[i] + 5,
                             out + 3 * (first + i));
        }
        const btf_evaluations evaluations = {.struct_size = sizeof evaluations,
                                             .count = some,
                                             .uv = f[0],
                                             .lights = f[0] + 2,
                                             .views = f[0] + 5,
                                             .stride = GPU_INPUTS,
                                             .rgb = out + 3 * first};
        if (c->evaluator) {
            btf_evaluate_many(c->evaluator, &many, &evaluations);
        }
    }
}

static btf_result run_cpu_decoder(decoding *d, const cpu_decoder *c, const uint32_t *sphere,
                                  float *decoded) {
    btf_result result = BTF_OK;
    for (int way = 0; way < 4 && result == BTF_OK; way++) {
        double ns[RIG_MOST_REPEATS];
        const btf_shader_options as = {.interpolation =
                                           way & 1 ? BTF_INTERPOLATION_NEAREST : BTF_INTERPOLATION_LINEAR,
                                       .filter = way & 2 ? BTF_FILTER_BILINEAR : BTF_FILTER_TEXEL};
        decode_row row = row_of(c->device, c->material, c->material->subsets[0].name, &as);
        for (int r = 0; r < d->repeats; r++) {
            const double before = rig_core_seconds();
            cpu_pixels(c, &row, sphere, REFERENCE_PIXELS, decoded);
            ns[r] = 1e9 * (rig_core_seconds() - before) / REFERENCE_PIXELS;
        }
        row.ns = bench_median(ns, d->repeats, &row.spread);
        const probes *const sets[] = {&d->trained, &d->held, &d->between};
        for (int set = 0; set < 3; set++) {
            if (!sets[set]->inputs) {
                continue;
            }
#pragma omp parallel for num_threads(d->run->context->threads)
            for (size_t i = 0; i < PROBES; i++) {
                cpu_pixels(c, &row, sets[set]->inputs + GPU_INPUTS * i, 1, decoded + 3 * i);
            }
            compare(sets[set], decoded, 3, &row.linear[set], &row.srgb[set]);
        }
        result = estimate_material(d, c->material, &c->material->subsets[0], &row);
        decode_table_add(d->table, &row);
    }
    return result;
}

static btf_result run_cpu(decoding *d, const decode_material *m) {
    const size_t most = PROBES > REFERENCE_PIXELS ? PROBES : REFERENCE_PIXELS;
    float *decoded = malloc(3 * most * sizeof *decoded);
    uint32_t *sphere = malloc(REFERENCE_PIXELS * sizeof(uint32_t) * GPU_INPUTS);
    cpu_decoder decoders[2] = {{"CPU reference", m, NULL}, {"CPU evaluator", m, NULL}};
    btf_result result =
        decoded && sphere ? BTF_OK : enc_fail(d->run->context, BTF_ERROR_MEMORY, "bench: out of memory");
    for (size_t i = 0; i < REFERENCE_PIXELS && result == BTF_OK; i++) {
        float f[GPU_INPUTS];
        rig_sphere_pixel((int)(i * (RIG_PIXELS / REFERENCE_PIXELS) + i * RIG_SIDE / RIG_PIXELS), f);
        memcpy(sphere + GPU_INPUTS * i, f, sizeof f);
    }
    if (result == BTF_OK) {
        result = btf_evaluator_create(m->encoded.material, &d->run->context->log, &decoders[1].evaluator);
    }
    for (int i = 0; i < 2 && result == BTF_OK; i++) {
        result = run_cpu_decoder(d, &decoders[i], sphere, decoded);
    }
    btf_evaluator_destroy(&decoders[1].evaluator);
    free(decoded);
    free(sphere);
    return result;
}

/* The section.
 * ------------------------------------------------------------------------------------------------ */

/* tables: a material with the directions of the data. */
static btf_result run_peers(decoding *d, decode_rig *rig, const char *device, const btf_material *tables) {
    btf_result result = run_phong(d, rig, device, tables);
    if (result == BTF_OK) {
        result = run_look_up(d, rig, device, tables);
    }
    for (int i = 0; i < PEER_CODECS && result == BTF_OK; i++) {
        if (d->components[i].note) {
            result = run_pca(d, rig, device, &d->components[i]);
        }
    }
    return result;
}

static btf_result run_device(decoding *d, const context_device *device) {
    char why[300];
    decode_rig rig;
    btf_result result = rig_create(device, d->repeats, &d->run->context->log, why, sizeof why, &rig);
    if (result != BTF_OK) {
        enc_log(d->run->context, BTF_LOG_INFO, "  %s: %s", device->name, why);
        fprintf(d->run->summary,
                "Device %s is not available: %s.\n"
                "\n",
                device->name, why);
        return result == BTF_ERROR_UNSUPPORTED ? BTF_OK : result;
    }
    decode_table_device(d->table, device->name, gpu_name(rig.gpu), rig.software);
    enc_log(d->run->context, BTF_LOG_INFO, "  %s: %s", device->name, gpu_name(rig.gpu));
    const btf_material *tables = NULL;
    for (int i = 0; i < DECODE_MATERIALS && result == BTF_OK; i++) {
        const decode_material *m = &d->materials[i];
        if (!m->name) {
            continue;
        }
        result = run_material(d, &rig, device->name, m, !d->run->quick);
        if (d->table->devices == 1 && !strchr(m->name, ';')) {
            run_sizes(d, &rig, device->name, m);
        }
        tables = tables ? tables : m->encoded.material;
    }
    if (result == BTF_OK && d->run->methods & BENCH_METHOD_PEERS) {
        result = run_peers(d, &rig, device->name, tables);
    }
    rig_destroy(&rig);
    return result;
}

/* --quick: one of each language that keeps exactness in another way. */
static bool in_quick(const context_device *device) {
    static const char *const names[] = {"osmesa", "egl", "egl-es300", "glfw"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        if (strcmp(device->name, names[i]) == 0) {
            return true;
        }
    }
    return false;
}

/* Every device but softpipe: OSMesa takes one driver a process, and that one only interprets shaders. The
 * devices that name no driver get what the user's environment says. */
static btf_result run_devices(decoding *d) {
    const char *set = getenv("GALLIUM_DRIVER");
    char *users = set ? strdup(set) : NULL;
    btf_result result = BTF_OK;
    for (const context_device *device = context_devices; device->name && result == BTF_OK; device++) {
        const bool interprets = device->gallium_driver && strcmp(device->gallium_driver, "softpipe") == 0;
        if (users) {
            setenv("GALLIUM_DRIVER", users, 1);
        } else {
            unsetenv("GALLIUM_DRIVER");
        }
        const char *only = d->run->device;
        if (only ? strcmp(only, device->name) == 0 : !interprets && (!d->run->quick || in_quick(device))) {
            result = run_device(d, device);
        }
    }
    free(users);
    return result;
}

static btf_result measure(decoding *d) {
    const bench_held *held = d->run->held;
    btf_result result = decode_materials_create(d->run, d->materials);
    if (result == BTF_OK) {
        result = probes_create(d->run->context, held->train, &d->trained);
    }
    if (result == BTF_OK && held->sets[2]) {
        result = probes_create(d->run->context, held->sets[2], &d->held);
    }
    if (result == BTF_OK && d->run->truth->count > 0) {
        result = probes_between(d->run->context, d->run->truth, &d->between);
    }
    if (result == BTF_OK) {
        result = find_ranks(d);
    }
    if (result == BTF_OK) {
        result = run_devices(d);
    }
    for (int i = 0; i < DECODE_MATERIALS && result == BTF_OK; i++) {
        const decode_material *m = &d->materials[i];
        if (m->name && d->run->methods & BENCH_METHOD_REFERENCE) {
            result = run_cpu(d, m);
        }
    }
    return result;
}

btf_result bench_section_decode(const bench_run *run) {
    decoding d = {.run = run,
                  .repeats = run->repeats > BENCH_DECODE_REPEATS ? run->repeats : BENCH_DECODE_REPEATS,
                  .table = calloc(1, sizeof(decode_table)),
                  .floor = calloc(RIG_PIXELS, GPU_INPUTS * sizeof(uint32_t))};
    btf_result result =
        d.table && d.floor ? BTF_OK : enc_fail(run->context, BTF_ERROR_MEMORY, "bench: out of memory");
    if (result == BTF_OK) {
        result = measure(&d);
    }
    if (result == BTF_OK) {
        result = decode_table_write(run, d.table);
    }
    if (result == BTF_OK && d.table->devices > 0) {
        result = bench_readme_decode(run, d.table);
    }
    decode_materials_clear(d.materials);
    for (int i = 0; i < PEER_CODECS; i++) {
        pca_codec_clear(&d.components[i].codec);
    }
    probes_clear(&d.trained);
    probes_clear(&d.held);
    probes_clear(&d.between);
    free(d.floor);
    free(d.table);
    return result;
}
