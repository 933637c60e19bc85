/* Pairs of a view and a light between the samples of a grid: at random, from a list, or as a slow orbit.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_SAMPLE_PAIRS_H
#define OPENBTF_SAMPLE_PAIRS_H

#include "encoder/data/data.h"

enum { PAIRS_MAX = 100000, PAIRS_NAME = 96 };

typedef struct sample_pair {
    enc_direction view, light;
} sample_pair;

/* The direction that moves in an orbit. */
typedef enum pairs_orbit { PAIRS_NO_ORBIT, PAIRS_ORBIT_VIEW, PAIRS_ORBIT_LIGHT } pairs_orbit;

/* Each fills *out_pairs (malloc'd). Angles are rounded to 1e-4 degrees, which is what file names hold, and
 * no two pairs are alike. */

/* `count` pairs of 1..PAIRS_MAX, both directions uniform over the solid angle from the pole to 74 degrees:
 * within the hull of rings that reach 75. Another seed, other pairs; the first pairs of a seed do not
 * depend on the count. Errors: BTF_ERROR_MEMORY. */
btf_result pairs_random(const enc_context *context, int count, uint32_t seed, sample_pair **out_pairs);

/* Reads a text file. A line holds a pair: theta and phi of the view, theta and phi of the light, in degrees, separated
 * by blanks or commas. A name may stand before them; # begins a comment; the first line may hold titles. The table of
 * an orbit can thus be read as a list. Theta is 0..85. Errors, on the log with the line: BTF_ERROR_IO,
 * BTF_ERROR_BAD_FILE, BTF_ERROR_MEMORY. */
btf_result pairs_read(const enc_context *context, const char *path, sample_pair **out_pairs,
                      int *out_count);

/* `frames` steps of one turn of the view or the light at `theta`, from azimuth 0 counter-clockwise, while
 * the other stays at `fixed`. Errors: BTF_ERROR_MEMORY. */
btf_result pairs_turn(const enc_context *context, pairs_orbit orbit, int frames, double theta,
                      enc_direction fixed, sample_pair **out_pairs);

/* The name of a pair's image without its extension: "tl0123.4567_pl..._tv..._pv...", four decimals each;
 * "frame00012_tl..." with a frame's number, -1 for none. buffer: PAIRS_NAME. */
void pairs_name(const sample_pair *pair, int frame, char *buffer);

/* DIR/directions.csv: file, theta_v, phi_v, theta_l, phi_l. Errors: BTF_ERROR_IO. */
btf_result pairs_write_table(const enc_context *context, const char *folder, const char *extension,
                             const sample_pair *pairs, int count);

#endif
