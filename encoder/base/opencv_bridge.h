/* The one door to OpenCV (C++): DIS optical flow.
 *
 * No C++ exception crosses it, OpenCV's own messages are silenced, and every call runs on the calling
 * thread alone. All functions may be called from several threads at once, a flow handle from one at a time.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_OPENCV_BRIDGE_H
#define OPENBTF_ENCODER_OPENCV_BRIDGE_H

#ifdef __cplusplus
extern "C" {
#endif

/* DIS optical flow (Kroeger et al. 2016), preset medium: a reusable object, one for each thread. */
typedef struct enc_cv_flow enc_cv_flow;

/* Returns NULL on failure. */
enc_cv_flow *enc_cv_flow_create(void);
void enc_cv_flow_destroy(enc_cv_flow **flow);

/* Replaces the preset's settings: the finest pyramid level that is searched (0: full resolution, 1: half),
 * the distance between 8x8 patches, descent steps a patch, and rounds of variational smoothing. */
void enc_cv_flow_tune(enc_cv_flow *flow, int finest_level, int patch_stride, int descent_steps,
                      int smoothing_rounds);

/* Dense flow between two grey images [row][column]: from(x, y) is seen at to(x + out_xy[0], y + out_xy[1]),
 * out_xy[row][column][2] = (columns to the right, rows down). Deterministic. Returns 0, or -1 on failure
 * (images too small, out of memory). */
int enc_cv_flow_compute(enc_cv_flow *flow, int width, int height, const unsigned char *from,
                        const unsigned char *to, float *out_xy);

#ifdef __cplusplus
}
#endif
#endif
