/* A small set of images, and checks of the result of reading it. See image_set.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "image_set.h"

#include "decoder/toolkit/png_image.h"
#include "test.h"

#include <sys/stat.h>

const double set_views[VIEWS][2] = {{0, 0}, {30, 0}, {30, 120}, {75, 240}};
const double set_lights[LIGHTS][2] = {{0, 0}, {15, 90}, {15, 270}, {45, 7.5}, {75, 345}};

enc_context set_context = {.log = {keep_message, NULL}, .threads = 2};
const btf_log set_no_log = {NULL, NULL};

int set_make_folder(void **state) {
    forget_messages();
    set_context.memory = 0;
    set_context.threads = 2;
    return make_temporary_folder(state);
}

unsigned char set_code(int v, int l, int row, int column, int c) {
    return (unsigned char)((v * 61 + l * 31 + row * 17 + column * 5 + c * 83) % 256);
}

void set_make_codes(int v, int l, unsigned char codes[W * H * 3]) {
    for (int row = 0; row < H; row++) {
        for (int column = 0; column < W; column++) {
            for (int c = 0; c < 3; c++) {
                codes[(row * W + column) * 3 + c] = set_code(v, l, row, column, c);
            }
        }
    }
}

const char *set_name_of(custom naming, int v, int l, const char *extension) {
    static char path[PATH];
    char sub[300];
    const double tv = set_views[v][0], pv = set_views[v][1], tl = set_lights[l][0], pl = set_lights[l][1];
    sub[0] = '\0';
    switch (naming) {
    case UBO:
        snprintf(sub, sizeof sub, "%s/tv%03g_pv%03g", temporary_folder, tv, pv);
        snprintf(path, sizeof path, "%s/%05d tl%03g pl%03g tv%03g pv%03g.%s", sub, v * LIGHTS + l + 1, tl,
                 pl, tv, pv, extension);
        break;
    case UTIA:
        snprintf(path, sizeof path, "%s/tl%03g_pl%03g_tv%03g_pv%03g.%s", temporary_folder, tl, pl, tv, pv,
                 extension);
        break;
    case BONN:
        snprintf(path, sizeof path, "%s/TV%g-PV%g-TL%g-PL%.2f.%s", temporary_folder, tv, pv, tl, pl,
                 extension);
        break;
    case FOLDERS:
        snprintf(sub, sizeof sub, "%s/tv=%g pv=%g", temporary_folder, tv, pv);
        snprintf(path, sizeof path, "%s/pl%.1f tl%.1f.%s", sub, pl, tl, extension);
        break;
    }
    if (sub[0]) {
        mkdir(sub, 0777);
    }
    return path;
}

void set_write_png8(custom naming, int v, int l) {
    unsigned char codes[W * H * 3];
    set_make_codes(v, l, codes);
    assert_int_equal(png_image_write8(set_name_of(naming, v, l, "png"), W, H, codes, set_no_log), BTF_OK);
}

void set_write(custom naming) {
    for (int v = 0; v < VIEWS; v++) {
        for (int l = 0; l < LIGHTS; l++) {
            set_write_png8(naming, v, l);
        }
    }
}

enc_data *set_read_folder(const enc_read_options *options) {
    enc_data *data = NULL;
    const btf_result result = enc_read(&set_context, temporary_folder, options, &data);
    if (result != BTF_OK) {
        fail_msg("%s", all_messages);
    }
    return data;
}

void set_expect_refused(const char *input, const enc_read_options *options, btf_result expected, ...) {
    enc_data *data = NULL;
    va_list words;
    all_messages[0] = '\0';
    assert_int_equal(enc_read(&set_context, input, options, &data), expected);
    assert_null(data);
    va_start(words, expected);
    for (const char *word; (word = va_arg(words, const char *));) {
        if (!strstr(all_messages, word)) {
            fail_msg("\"%s\" does not say \"%s\"", all_messages, word);
        }
    }
    va_end(words);
}

float set_sample(const enc_data *data, int v, int l, int row, int column, int c) {
    const size_t texel = (size_t)row * (size_t)data->width + (size_t)column;
    float *buffer = malloc(enc_data_texel_stride(data) * sizeof *buffer);
    const float *samples;
    assert_non_null(buffer);
    assert_int_equal(enc_data_texels(&set_context, data, texel, 1, buffer, &samples), BTF_OK);
    const float value = samples[(v * 3 + c) * data->n_lights + l];
    free(buffer);
    return value;
}

void set_expect(const enc_data *data, double tolerance) {
    assert_int_equal(data->width, W);
    assert_int_equal(data->height, H);
    assert_int_equal(data->n_views, VIEWS);
    assert_int_equal(data->n_lights, LIGHTS);
    assert_int_equal(data->top_view, 0);
    for (int v = 0; v < VIEWS; v++) {
        assert_true(data->views[v].theta == set_views[v][0] && data->views[v].phi == set_views[v][1]);
    }
    for (int l = 0; l < LIGHTS; l++) {
        assert_true(data->lights[l].theta == set_lights[l][0] && data->lights[l].phi == set_lights[l][1]);
    }
    for (int row = 0; row < H; row++) {
        for (int column = 0; column < W; column++) {
            for (int v = 0; v < VIEWS; v++) {
                for (int c = 0; c < 3; c++) {
                    for (int l = 0; l < LIGHTS; l++) {
                        const double expected = enc_srgb_decode(set_code(v, l, row, column, c) / 255.0);
                        const double value = set_sample(data, v, l, row, column, c);
                        if (!(fabs(value - expected) <= tolerance)) {
                            fail_msg("view %d light %d row %d column %d channel %d: %g, not %g", v, l, row,
                                     column, c, value, expected);
                        }
                    }
                }
            }
        }
    }
}
