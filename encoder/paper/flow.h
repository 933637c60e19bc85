/* Vote-based optical flow: which texel of the top view each texel of each view shows (paper 2.3.1).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_PAPER_FLOW_H
#define OPENBTF_ENCODER_PAPER_FLOW_H

#include "encoder/data/data.h"
#include "encoder/model/occlusion.h"
#include <stdbool.h>

enum { ENC_FLOW_PRIOR_LIGHTS = 27 }; /* lights of the first estimate, at most; more change nothing */

/* Zero means the default beside the field. */
typedef struct enc_flow_options {
    int lights;             /* lights that vote, spread evenly over the list; default all */
    float hidden_threshold; /* hidden where HiddenRatio exceeds it; default 0.7, the paper's */
    float miss;             /* texels by which forward and backward flow may miss; default 1 */
    float difference;  /* relative luminance difference up to which two texels may show one surface point;
                          default 0.35 */
    int padding;       /* texels of periodic continuation on each side, at least 16; default 16 */
    bool plain;        /* no first estimate (flow_prior.h): each light starts from 0; default false */
    float depth, rise; /* heights that the estimate tries below and above the plane, in tiles;
                          defaults 0.15 and 0.03 */
} enc_flow_options;

/* Finds the flow between two images of one light, without a first estimate. target and top are luminances
 * [texel], row 0 at the top; out_flow[texel][2] = (columns, rows): target(x) shows what top(x + flow)
 * shows, not wrapped; out_hidden[texel] = 1 where the forward-backward flow misses by more than
 * options->miss texels or the luminances, both images scaled to one mean, differ by more than
 * options->difference of the larger one. An image without light gives zero flow and hides nothing. Errors:
 * BTF_ERROR_USAGE (options), BTF_ERROR_MEMORY, BTF_ERROR_INTERNAL (OpenCV). Any thread. */
btf_result enc_flow_pair(const enc_context *context, int width, int height, const float *target,
                         const float *top, const enc_flow_options *options, float *out_flow,
                         uint8_t *out_hidden);

/* Lets the lights vote, each by its own flow from the view's first estimate, for every view but the top
 * view, of which nothing is shifted or hidden: HiddenRatio(x) = avg_l HiddenMap_l(x), hidden where
 * HiddenRatio(x) > hidden_threshold, shift(x) = the integer vector with most votes among the lights whose
 * flow does not hide x (of all lights where each hides it); ties prefer the smaller shift, then the smaller
 * row, then column. Flows are rounded to texels and wrapped over the tile, at most 127 texels long in
 * columns and in rows. Lights under which either view is black do not vote. The stage is called "flow".
 * Memory a thread: n_lights * texels * 15 bytes for images and votes, 27 * texels * 12 for the estimate's
 * planes, texels * labels * 12 for its volumes (labels: shifts tried, at most 254).
 *
 * Errors: BTF_ERROR_USAGE (options), BTF_ERROR_MEMORY, BTF_ERROR_IO (scratch file), BTF_ERROR_INTERNAL
 * (OpenCV), BTF_ERROR_INTERRUPTED. */
btf_result enc_flow_vote(const enc_context *context, const enc_data *data, const enc_flow_options *options,
                         enc_occlusion **out_occlusion);

/* The end-point error against known shifts over one ring of views (one theta), in texels. */
typedef struct enc_flow_ring {
    double theta;        /* degrees */
    size_t points;       /* known points of the ring */
    size_t moved;        /* of them, those whose true shift is longer than `least` */
    size_t moved_hidden; /* of these, those that the vote calls hidden */
    double error;        /* mean error of the voted shift over `points` */
    double zero;         /* the same for the shift 0 */
    double moved_error;  /* mean error of the voted shift over `moved`, hidden ones included */
    double moved_zero;   /* the same for the shift 0 */
} enc_flow_ring;

/* Compares with truth[view][texel][2] = (columns, rows), floats, any representative of the wrapped shift;
 * points with exclude[view][texel] != 0 (exclude may be NULL) are left out. Differences are wrapped over
 * the tile. Fills at most `capacity` rings in order of theta and returns how many there are. Means over
 * nothing are 0. */
int enc_flow_error(const enc_data *data, const enc_occlusion *occlusion, const float *truth,
                   const uint8_t *exclude, double least, enc_flow_ring *out_rings, int capacity);

/* Shifts along one axis that the first estimate of a flow tells apart, at most. */
enum { ENC_FLOW_LABELS = 256 };

/* Bytes of one view's flow: images, planes of the first estimate, volumes of its search, votes. `side` is
 * the longer one. */
uint64_t enc_flow_bytes(uint64_t texels, uint64_t side, uint64_t lights);

#endif
