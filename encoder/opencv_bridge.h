/* The one door to OpenCV (C++): image decoding and encoding, text drawing, DIS optical flow.
 *
 * No C++ exception crosses it, OpenCV's own messages are silenced, and every call runs on the calling
 * thread alone. All functions may be called from several threads at once, a flow handle from one at a time.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_OPENCV_BRIDGE_H
#define OPENBTF_ENCODER_OPENCV_BRIDGE_H

#include <openbtf/result.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A decoded image: pixels[row][column][channel], row 0 at the top, channels R, G, B (or one grey channel).
 * Samples are unsigned char (depth 8), unsigned short (16) or float (32), as coded in the file. */
typedef struct enc_cv_image {
    int width, height;
    int channels; /* 1 or 3; alpha is dropped */
    int depth;    /* 8, 16 or 32 (float) */
    void *pixels; /* malloc'ed, the caller frees */
} enc_cv_image;

/* Decodes one JPEG, PNG or Radiance HDR held in memory; EXIF rotation is not applied. Does not notice a
 * truncated JPEG: encoder/image.c checks the file's structure first.
 * Errors: BTF_ERROR_BAD_FILE, BTF_ERROR_UNSUPPORTED (sample type), BTF_ERROR_MEMORY. */
btf_result enc_cv_decode_image(const void *data, size_t size, enc_cv_image *out_image);

/* Encodes rgb[row][column][3] as JPEG of `quality` 0..100 without chroma subsampling.
 * *out_data is malloc'ed, the caller frees. Errors: BTF_ERROR_INTERNAL, BTF_ERROR_MEMORY. */
btf_result enc_cv_encode_jpeg(int width, int height, const unsigned char *rgb, int quality,
                              unsigned char **out_data, size_t *out_size);

/* Encodes pixels[row][column][channels] as PNG; channels 1 or 3, depth 8 (unsigned char) or 16
 * (unsigned short). *out_data is malloc'ed, the caller frees. Errors as enc_cv_encode_jpeg. */
btf_result enc_cv_encode_png(int width, int height, int channels, int depth, const void *pixels,
                             unsigned char **out_data, size_t *out_size);

/* Draws one line of text into rgb[row][column][3], clipped at the edges; (x, y) is the left end of the base
 * line, size the height of a capital letter in pixels. */
void enc_cv_draw_text(unsigned char *rgb, int width, int height, int x, int y, const char *text,
                      double size, const unsigned char colour[3]);

/* The width in pixels of the text as enc_cv_draw_text draws it. */
int enc_cv_text_width(const char *text, double size);

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

/* enc_cv_flow_compute with an object made for this call. */
int enc_cv_flow_dis(int width, int height, const unsigned char *from, const unsigned char *to,
                    float *out_xy);

#ifdef __cplusplus
}
#endif
#endif
