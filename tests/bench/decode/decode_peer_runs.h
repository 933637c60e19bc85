/* The peers of section `decode` on one GL device: a Phong model, uncompressed images, principal components of
 * as many bytes, and of the same quality, as ours.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_DECODE_PEER_RUNS_H
#define OPENBTF_TESTS_BENCH_DECODE_PEER_RUNS_H

#include "decoding.h"

/* Components of the bytes of the material `joint`, and of its quality, to d->components; none where there is no
 * such material or peers are not wanted. Errors: those of the codecs. */
btf_result decode_peers_find_ranks(decoding *d);
/* A row for each peer. tables: a material with the directions of the data. */
btf_result decode_peers_run(decoding *d, decode_rig *rig, const char *device, const btf_material *tables);

#endif
