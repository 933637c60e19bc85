/* Values at the nodes, the directions of a list, chosen so that a decoder's blend of three nodes follows a
 * smooth spline through the samples.
 *
 * A decoder blends barycentrically the values f' of three nodes. f' = W f is fitted to the samples f: W
 * minimises the squared difference between the blend of W and the weights of the cubic spline over the hull
 * of the directions, plus kappa times that at the nodes themselves (least squares with Tikhonov's
 * regularisation, 1963): (B^T B + l) W = B^T R + l, of barycentric weights B and spline weights R of points
 * of the hull, l = kappa points / nodes. Large kappa keeps the samples (W = 1), kappa 0 departs from them
 * most. W depends on the directions alone; its rows sum to 1.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_NODES_FIT_H
#define OPENBTF_ENCODER_NODES_FIT_H

#include "interpolate.h"

enum { ENC_FIT_POINTS = 4000 }; /* directions of the hull, evenly spread, of which the difference is taken */

/* Sums of absolute weights of a node, at most: more would amplify noise in the samples. The rings of
 * 81 directions have 1.7. */
#define ENC_FIT_MOST_GAIN 4.0

typedef struct enc_node_fit enc_node_fit;

/* Prepares fits for `count` distinct directions, by about `points` directions of their hull. Errors, not
 * logged: BTF_ERROR_UNSUPPORTED (there is no such spline: two directions or fewer, or nearly in one line,
 * or two nearly the same), those of btf_material_create, BTF_ERROR_MEMORY. */
btf_result enc_node_fit_create(const enc_context *context, const enc_direction *directions, int count,
                               int points, enc_node_fit **out_fit);
void enc_node_fit_destroy(enc_node_fit **fit);

/* Finds W for kappa >= 0: out [count][count]. Errors, not logged: BTF_ERROR_UNSUPPORTED (a node's gain
 * would exceed ENC_FIT_MOST_GAIN), BTF_ERROR_MEMORY. Thread-safe. */
btf_result enc_node_fit_weights(const enc_node_fit *fit, double kappa, float *out);

/* Finds how a decoder of the fitted nodes blends the samples in directions between them: the weights of
 * three nodes in each direction, `at` [n_at], become weights of all samples, out [n_at][count]. Errors as
 * before. */
btf_result enc_node_fit_blend(const enc_node_fit *fit, double kappa, size_t n_at, const enc_weights *at,
                              float *out);

/* Gives the directions of the hull that the fit uses; returns their number. */
int enc_node_fit_points(const enc_node_fit *fit, const float (**out_points)[3]);

#endif
