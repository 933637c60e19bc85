/* Peers, chosen and timed. See decode_peer_runs.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decode_peer_runs.h"

#include "decode_peers.h"
#include "decode_shaders.h"

#include "encoder/model/decode_samples.h"
#include "encoder/report/metrics.h"

#include <GL/glcorearb.h>
#include <stdlib.h>
#include <string.h>

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
        decoding_probe(d, rig, variant.program, &row);
        result = decoding_estimate_peer(d, images, &row);
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

/* Finds the smallest rank of 8-bit components that reaches the linear PSNR; *out stays empty where none does. */
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

btf_result decode_peers_find_ranks(decoding *d) {
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

btf_result decode_peers_run(decoding *d, decode_rig *rig, const char *device, const btf_material *tables) {
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
