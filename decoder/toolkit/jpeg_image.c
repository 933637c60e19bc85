/* JPEG images through libjpeg: writing, and reading that takes no damaged file for a good one.
 *
 * SPDX-License-Identifier: MIT
 */
#include "jpeg_image.h"

#include "exif.h"
#include "output.h"

#include <setjmp.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jpeglib.h>
#include <jerror.h>

/* libjpeg's error manager, where to jump back to, and the texts of the first complaints. */
typedef struct complaint {
    struct jpeg_error_mgr manager;
    jmp_buf back;
    bool damaged, lenient; /* lenient: headers break a rule, the pixels are as they should be */
    char text[JMSG_LENGTH_MAX];
    char lenient_text[JMSG_LENGTH_MAX];
} complaint;

static void keep_text(j_common_ptr common) {
    complaint *c = (complaint *)common->err;
    if (!c->text[0]) {
        c->manager.format_message(common, c->text);
    }
}

static void on_error(j_common_ptr common) {
    keep_text(common);
    longjmp(((complaint *)common->err)->back, 1);
}

/* At level -1 libjpeg warns of corrupt data and goes on. Such a file is refused, unless the warning does not touch the
 * picture. JWRN_NOT_SEQUENTIAL warns of a scan header whose progressive parameters are wrong, in a file that is not
 * progressive and has no use for them. */
static void on_message(j_common_ptr common, int level) {
    complaint *c = (complaint *)common->err;
    const int code = c->manager.msg_code;
    if (level >= 0 || code == JWRN_EXTRANEOUS_DATA || code == JWRN_JFIF_MAJOR) {
        return;
    }
    if (code == JWRN_ADOBE_XFORM || code == JWRN_NOT_SEQUENTIAL || code == JWRN_BOGUS_ICC) {
        if (!c->lenient) {
            c->manager.format_message(common, c->lenient_text);
        }
        c->lenient = true;
        return;
    }
    c->damaged = true;
    keep_text(common);
}

static void on_output(j_common_ptr common) {
    (void)common;
}

static struct jpeg_error_mgr *complaint_init(complaint *c) {
    jpeg_std_error(&c->manager);
    c->manager.error_exit = on_error;
    c->manager.emit_message = on_message;
    c->manager.output_message = on_output;
    c->damaged = c->lenient = false;
    c->text[0] = '\0';
    return &c->manager;
}

/* A decoder in the making: what must survive libjpeg's longjmp lives here, not in locals. */
typedef struct reading {
    struct jpeg_decompress_struct jpeg;
    complaint error;
    int width, height, channels;
    unsigned char *pixels;
    image_info *info;
} reading;

/* The orientation that an EXIF marker gives, 1 when there is none. */
static int orientation(const struct jpeg_decompress_struct *jpeg) {
    static const char head[6] = "Exif\0";
    for (jpeg_saved_marker_ptr m = jpeg->marker_list; m; m = m->next) {
        if (m->data_length >= sizeof head && memcmp(m->data, head, sizeof head) == 0) {
            return exif_orientation(m->data + sizeof head, m->data_length - sizeof head);
        }
    }
    return 1;
}

/* Notes XMP's orientation, which is not followed: few readers follow it, and programs that turn pixels leave it
 * behind. */
static void note_xmp(reading *r) {
    static const char head[] = "http://ns.adobe.com/xap/1.0/";
    for (jpeg_saved_marker_ptr m = r->jpeg.marker_list; m; m = m->next) {
        if (m->marker == JPEG_APP0 + 1 && m->data_length >= sizeof head &&
            memcmp(m->data, head, sizeof head) == 0 && xmp_orientation(m->data, m->data_length) != 1) {
            image_note(r->info, IMAGE_NOTE_TURNED,
                       "JPEG: XMP orientation %d is not applied: taken as stored",
                       xmp_orientation(m->data, m->data_length));
        }
    }
}

/* Notes a colour profile; without one, what EXIF says of the colour space. */
static void heed_colour(reading *r) {
    JOCTET *profile = NULL;
    unsigned int size = 0;
    if (jpeg_read_icc_profile(&r->jpeg, &profile, &size)) {
        image_info_profile(r->info, "JPEG", profile, size, NULL);
        free(profile);
        return;
    }
    static const char head[6] = "Exif\0";
    for (jpeg_saved_marker_ptr m = r->jpeg.marker_list; m; m = m->next) {
        if (m->data_length >= sizeof head && memcmp(m->data, head, sizeof head) == 0 &&
            exif_colour_is_other(m->data + sizeof head, m->data_length - sizeof head)) {
            image_note(
                r->info, IMAGE_NOTE_SPACE,
                "JPEG: EXIF says that the colour space is not sRGB (cameras mean Adobe RGB): not applied");
        }
    }
}

static btf_result decode(reading *r, const void *data, size_t size, size_t max_pixels) {
    if (setjmp(r->error.back)) {
        return BTF_ERROR_BAD_FILE;
    }
    jpeg_create_decompress(&r->jpeg);
    jpeg_mem_src(&r->jpeg, data, (unsigned long)size);
    jpeg_save_markers(&r->jpeg, JPEG_APP0 + 1, 0xFFFF);
    jpeg_save_markers(&r->jpeg, JPEG_APP0 + 2, 0xFFFF);
    jpeg_read_header(&r->jpeg, TRUE);
    if (r->jpeg.num_components != 1 && r->jpeg.num_components != 3) {
        snprintf(r->error.text, sizeof r->error.text, "%d colour components%s: convert to RGB",
                 r->jpeg.num_components, r->jpeg.num_components == 4 ? " (CMYK or YCCK)" : "");
        return BTF_ERROR_UNSUPPORTED;
    }
    if ((size_t)r->jpeg.image_width * r->jpeg.image_height > max_pixels) {
        snprintf(r->error.text, sizeof r->error.text,
                 "%ux%u pixels are more than %zu, the most that are read", r->jpeg.image_width,
                 r->jpeg.image_height, max_pixels);
        return BTF_ERROR_UNSUPPORTED;
    }
    const int turned = orientation(&r->jpeg);
    if (turned != 1) {
        snprintf(r->error.text, sizeof r->error.text,
                 "EXIF orientation %d: turn the pixels, then set it to 1", turned);
        return BTF_ERROR_UNSUPPORTED;
    }
    note_xmp(r);
    heed_colour(r);
    r->jpeg.out_color_space = r->jpeg.num_components == 1 ? JCS_GRAYSCALE : JCS_RGB;
    r->jpeg.dct_method = JDCT_ISLOW;
    jpeg_start_decompress(&r->jpeg);
    r->width = (int)r->jpeg.output_width;
    r->height = (int)r->jpeg.output_height;
    r->channels = r->jpeg.output_components;
    const size_t row_bytes = (size_t)r->width * (size_t)r->channels;
    r->pixels = malloc(row_bytes * (size_t)r->height);
    if (!r->pixels) {
        return BTF_ERROR_MEMORY;
    }
    while (r->jpeg.output_scanline < r->jpeg.output_height) {
        JSAMPROW row = r->pixels + (size_t)r->jpeg.output_scanline * row_bytes;
        jpeg_read_scanlines(&r->jpeg, &row, 1);
    }
    jpeg_finish_decompress(&r->jpeg);
    if (r->error.lenient) {
        image_note(r->info, IMAGE_NOTE_HEADER, "JPEG: %.180s: read nevertheless", r->error.lenient_text);
    }
    return r->error.damaged ? BTF_ERROR_BAD_FILE : BTF_OK;
}

btf_result jpeg_image_read(const void *data, size_t size, size_t max_pixels, int *out_width,
                           int *out_height, int *out_channels, unsigned char **out_pixels, image_info *info,
                           char *message, size_t message_size) {
    reading *r = calloc(1, sizeof *r);
    if (!r) {
        return BTF_ERROR_MEMORY;
    }
    r->info = info;
    r->jpeg.err = complaint_init(&r->error);
    const btf_result result = decode(r, data, size, max_pixels);
    jpeg_destroy_decompress(&r->jpeg);
    if (result == BTF_OK) {
        *out_width = r->width;
        *out_height = r->height;
        *out_channels = r->channels;
        *out_pixels = r->pixels;
    } else {
        free(r->pixels);
        snprintf(message, message_size, "JPEG: %s",
                 r->error.text[0] ? r->error.text : btf_result_text(result));
    }
    free(r);
    return result;
}

typedef struct writing {
    struct jpeg_compress_struct jpeg;
    complaint error;
} writing;

static btf_result encode(writing *w, FILE *stream, int width, int height, const unsigned char *rgb,
                         int quality) {
    if (setjmp(w->error.back)) {
        return BTF_ERROR_IO;
    }
    jpeg_create_compress(&w->jpeg);
    jpeg_stdio_dest(&w->jpeg, stream);
    w->jpeg.image_width = (JDIMENSION)width;
    w->jpeg.image_height = (JDIMENSION)height;
    w->jpeg.input_components = 3;
    w->jpeg.in_color_space = JCS_RGB;
    jpeg_set_defaults(&w->jpeg);
    jpeg_set_quality(&w->jpeg, quality, TRUE);
    w->jpeg.dct_method = JDCT_ISLOW;
    for (int c = 0; c < w->jpeg.num_components; c++) {
        w->jpeg.comp_info[c].h_samp_factor = 1;
        w->jpeg.comp_info[c].v_samp_factor = 1;
    }
    jpeg_start_compress(&w->jpeg, TRUE);
    while (w->jpeg.next_scanline < w->jpeg.image_height) {
        JSAMPROW row = (JSAMPROW)(rgb + (size_t)w->jpeg.next_scanline * (size_t)width * 3);
        jpeg_write_scanlines(&w->jpeg, &row, 1);
    }
    jpeg_finish_compress(&w->jpeg);
    return BTF_OK;
}

btf_result jpeg_image_write(const char *path, int width, int height, const unsigned char *rgb, int quality,
                            btf_log log) {
    writing *w = calloc(1, sizeof *w);
    if (!w) {
        return BTF_ERROR_MEMORY;
    }
    output *file;
    btf_result result = output_open(path, log, &file);
    if (result == BTF_OK) {
        w->jpeg.err = complaint_init(&w->error);
        result = encode(w, output_stream(file), width, height, rgb, quality);
        jpeg_destroy_compress(&w->jpeg);
        if (result == BTF_OK) {
            result = output_commit(&file);
        } else {
            output_abort(&file);
            if (log.callback) {
                char text[JMSG_LENGTH_MAX + 256];
                snprintf(text, sizeof text, "%.200s: JPEG: %s", path, w->error.text);
                log.callback(log.user, BTF_LOG_ERROR, text);
            }
        }
    }
    free(w);
    return result;
}
