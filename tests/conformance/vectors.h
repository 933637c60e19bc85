/* Language-neutral test vectors: materials, arguments and radiance as OpenEXR files, and a JSON manifest.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_CONFORMANCE_VECTORS_H
#define OPENBTF_CONFORMANCE_VECTORS_H

#include <openbtf/result.h>
#include <stdint.h>

/* Writes manifest.json and, for each vector NN, NN.btf.exr (the material), NN-uv.exr (R = u, G = v),
 * NN-light.exr, NN-view.exr (xyz in RGB), NN-radiance.exr and NN-picked.exr (radiance of one view, light and
 * texel that btf_random of column, row and NN picks), of float channels that hold exact bits.
 * Every fourth has light sampling too: NN-tables.exr (its two tables word by word, three a pixel), NN-drawn.exr and
 * NN-density.exr. `directory` must exist. A port decodes the material at each pixel's arguments and compares all 32 bits of
 * each radiance channel. Errors: BTF_ERROR_IO, BTF_ERROR_MEMORY, those of making materials. */
btf_result vectors_write(const char *directory, uint64_t seed, const btf_log *log);

#endif
