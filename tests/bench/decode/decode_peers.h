/* Data for the decoders of peers, fitted to a data set: a Phong model on two maps, an uncompressed look-up, principal
 * components.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_DECODE_PEERS_H
#define OPENBTF_TESTS_BENCH_DECODE_PEERS_H

#include "tests/bench/codecs/pca.h"

#include <openbtf/material.h>

/* Albedo with the strength of the highlight in alpha (sRGB-coded but for alpha), and the normal (n + 1) /
 * 2; [row from the bottom][column][4], as GL wants them. A Lambertian normal and albedo fitted to each
 * texel over all views and lights by least squares, and one strength of a highlight of exponent 40 for all.
 * Errors: BTF_ERROR_MEMORY, BTF_ERROR_IO. */
btf_result peer_phong(const enc_context *context, const enc_data *data, unsigned char **out_albedo,
                      unsigned char **out_normal);

/* All images, 8-bit sRGB: a layer a view of `columns` x rows sheets of lights, row 0 the top. */
btf_result peer_images(const enc_context *context, const enc_data *data, int *out_columns, int *out_rows,
                       unsigned char **out_bytes);

/* A material that holds 8-bit components of linear values and nothing else, for a shader that sums them
 * itself. Its rank is that of the codec, up to 256, with zeros up to a multiple of 4. Errors: those of
 * packing; BTF_ERROR_UNSUPPORTED for a larger rank. */
btf_result peer_components(const enc_context *context, const pca_codec *codec, btf_material **out_material);

#endif
