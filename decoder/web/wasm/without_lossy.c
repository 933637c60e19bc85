/* Stands in for OpenEXRCore's internal_b44.c and internal_pxr24.c: codecs that lose bits, which no material may use
 * (FORMAT.md section 2), with tables of 128 KB. OpenBTF refuses such files before it decodes a chunk; should a call come
 * here all the same, it is refused as OpenEXRCore refuses DWA.
 *
 * SPDX-License-Identifier: MIT
 */
#include <internal_compress.h>
#include <internal_decompress.h>
#include <internal_structs.h>

/* Reports that a codec is not here, through the context of an encoding or decoding pipeline. */
#define REFUSE(pipeline, codec)                                                                            \
    EXR_PROMOTE_CONST_CONTEXT_AND_PART_OR_ERROR_NO_LOCK((pipeline)->context, (pipeline)->part_index);      \
    return pctxt->report_error(pctxt, EXR_ERR_FEATURE_NOT_IMPLEMENTED,                                     \
                               codec " compression is not in this build: materials may not use it")

#define APPLY(name, codec)                                                                                 \
    exr_result_t name(exr_encode_pipeline_t *encode) {                                                     \
        REFUSE(encode, codec);                                                                             \
    }
#define UNDO(name, codec)                                                                                  \
    exr_result_t name(exr_decode_pipeline_t *decode, const void *compressed_data, uint64_t comp_buf_size,  \
                      void *uncompressed_data, uint64_t uncompressed_size) {                               \
        (void)compressed_data;                                                                             \
        (void)comp_buf_size;                                                                               \
        (void)uncompressed_data;                                                                           \
        (void)uncompressed_size;                                                                           \
        REFUSE(decode, codec);                                                                             \
    }

APPLY(internal_exr_apply_b44, "B44")
APPLY(internal_exr_apply_b44a, "B44A")
APPLY(internal_exr_apply_pxr24, "PXR24")
UNDO(internal_exr_undo_b44, "B44")
UNDO(internal_exr_undo_b44a, "B44A")
UNDO(internal_exr_undo_pxr24, "PXR24")
