/* The state that all decoders of section `decode` share: materials, peers, samples to compare at, and the rows
 * made of them.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_DECODING_H
#define OPENBTF_TESTS_BENCH_DECODING_H

#include "decode_materials.h"
#include "decode_probes.h"
#include "decode_table.h"
#include "tests/bench/codecs/pca.h"

/* A codec of 8-bit components, and why it was chosen. */
typedef struct peer_codec {
    const char *note; /* NULL: not there */
    pca_codec codec;
} peer_codec;

enum { PEER_CODECS = 2 };

typedef struct decoding {
    const bench_run *run;
    decode_material materials[DECODE_MATERIALS];
    peer_codec components[PEER_CODECS];
    decode_probes trained, held, between;
    int repeats;
    decode_table *table;
    uint32_t *floor; /* inputs of a floor shader */
} decoding;

/* Makes a row for a material decoded with these options, with its counts and bytes. */
decode_row decoding_row(const char *device, const decode_material *m, const char *effects,
                        const btf_shader_options *shader);

/* Components that a subset decodes: whole groups of four, or units. */
uint32_t decoding_part(const decode_material *m, const decode_subset *s);

/* Measures the accuracy of a compiled program for the row. */
void decoding_probe(const decoding *d, decode_rig *rig, unsigned program, decode_row *row);

/* Where truth between the samples is not known, these put an estimate of the accuracy there into the row: for a
 * material, or for the interpolated images of a peer. A peer without images (NULL), whose samples do not depend on
 * one another, gets its accuracy at the samples. Errors: those of bench_between_material and bench_between_images. */
btf_result decoding_estimate_material(const decoding *d, const decode_material *m, const decode_subset *s,
                                      decode_row *row);
btf_result decoding_estimate_peer(const decoding *d, const enc_image_source *images, decode_row *row);

#endif
