/* The intermediate results of an encode as pictures. See pictures.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "pictures.h"

#include "canvas.h"
#include "encoder/paper/shadow.h"
#include "montage.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Pixels. A column is as wide as its cells, and at least as wide as 20 letters of caption. */
enum {
    GAP = 8,
    HEADER = ENC_CANVAS_LETTER_HEIGHT + 14,
    CAPTION = 20 * ENC_CANVAS_LETTER_WIDTH,
    CELL = 192
};

static int pitch(int cell_w) {
    return (cell_w > CAPTION ? cell_w : CAPTION) + GAP;
}

/* A canvas of columns x rows cells of cell_w x cell_h with captions above each row of cells. */
static btf_result grid(const enc_context *context, int columns, int rows, int cell_w, int cell_h,
                       enc_canvas *out_canvas) {
    return enc_canvas_create(context, columns * pitch(cell_w) + GAP, rows * (cell_h + HEADER) + GAP,
                             out_canvas);
}
static int grid_x(int column, int cell_w) {
    return GAP + column * pitch(cell_w);
}
static int grid_y(int row, int cell_h) {
    return HEADER + row * (cell_h + HEADER);
}

static btf_result write_canvas(const enc_context *context, enc_canvas *canvas, btf_result result,
                               const char *directory, const char *name) {
    char path[4096];
    if (result == BTF_OK && snprintf(path, sizeof path, "%s/%s", directory, name) >= (int)sizeof path) {
        result = enc_fail(context, BTF_ERROR_USAGE, "%s: the name is too long", directory);
    }
    if (result == BTF_OK) {
        result = enc_canvas_write(context, canvas, path);
    }
    enc_canvas_clear(canvas);
    return result == BTF_OK ? BTF_OK
                            : enc_fail(context, result, "%s/%s: the picture was not drawn: %s", directory,
                                       name, btf_result_text(result));
}

static int zoom_for(const enc_data *data) {
    const int size = data->width > data->height ? data->width : data->height;
    return size < CELL ? CELL / size : 1;
}

/* Lists the steps of the decode that pictures compare with the original; returns their number. */
static int list_steps(const enc_pictures *p, const char *names[3], uint32_t effects[3]) {
    int count = 0;
    if (p->solution->sbrdf) {
        names[count] = "SBRDF";
        effects[count++] = 0;
        if (p->solution->effects & BTF_EFFECT_SHADOW) {
            names[count] = "STVS";
            effects[count++] = BTF_EFFECT_SHADOW;
        }
    }
    names[count] = "full";
    effects[count++] = p->solution->effects;
    return count;
}

/* Gathers the apparent BRDFs of the four texels `at` from one source: out[texel][view][light][3]. */
static btf_result gather_abrdf(const enc_data *data, enc_image_source source, const size_t at[4],
                               float *images, float *out) {
    const size_t texels = enc_data_texel_count(data), views = (size_t)data->n_views,
                 lights = (size_t)data->n_lights;
    for (size_t v = 0; v < views; v++) {
        const btf_result result = source.view(source.user, (int)v, images);
        if (result != BTF_OK) {
            return result;
        }
        for (size_t i = 0; i < 4; i++) {
            for (size_t l = 0; l < lights; l++) {
                memcpy(out + ((i * views + v) * lights + l) * 3, images + (l * texels + at[i]) * 3,
                       3 * sizeof *out);
            }
        }
    }
    return BTF_OK;
}

static btf_result draw_abrdf(const enc_context *context, const enc_pictures *p, const char *directory) {
    const enc_data *data = p->data;
    const size_t texels = enc_data_texel_count(data), width = (size_t)data->width;
    const size_t block = (size_t)data->n_views * (size_t)data->n_lights * 3;
    const size_t at[4] = {texels / 8 + width / 5, texels / 4 + width / 2, texels / 2 + width / 3,
                          texels * 3 / 4 + width * 4 / 5};
    const int most = data->n_views > data->n_lights ? data->n_views : data->n_lights;
    const int zoom = (most + CELL - 1) / most, cell_w = data->n_lights * zoom,
              cell_h = data->n_views * zoom;
    const char *names[3];
    uint32_t effects[3];
    const int steps = list_steps(p, names, effects);
    size_t where[4];
    for (int i = 0; i < 4; i++) {
        where[i] = at[i] % texels;
    }
    float *images = malloc(texels * (size_t)data->n_lights * 3 * sizeof *images);
    float *original = malloc(4 * block * sizeof *original), *model = malloc(4 * block * sizeof *model);
    enc_canvas canvas = {0};
    btf_result result = images && original && model ? BTF_OK : BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        result = grid(context, 1 + 2 * steps, 4, cell_w, cell_h, &canvas);
    }
    if (result == BTF_OK) {
        result = gather_abrdf(data, enc_data_images(data), where, images, original);
    }
    for (int s = -1; result == BTF_OK && s < steps; s++) {
        const enc_decoded_samples decoded = {.decoder = p->decoder, .effects = s >= 0 ? effects[s] : 0};
        if (s >= 0) {
            result = gather_abrdf(data, enc_decoded_images(&decoded), where, images, model);
        }
        for (int i = 0; result == BTF_OK && i < 4; i++) {
            const int y = grid_y(i, cell_h), x = grid_x(s < 0 ? 0 : 1 + 2 * s, cell_w);
            const float *shown = (s < 0 ? original : model) + (size_t)i * block;
            enc_canvas_image(&canvas, x, y, zoom, data->n_lights, data->n_views, shown);
            if (s < 0) {
                enc_canvas_text(&canvas, x, y - 6, "original at %zu,%zu", where[i] % width,
                                where[i] / width);
                continue;
            }
            enc_canvas_text(&canvas, x, y - 6, "%s", names[s]);
            for (size_t k = 0; k < block; k++) {
                model[(size_t)i * block + k] = fabsf(shown[k] - original[(size_t)i * block + k]);
            }
            enc_canvas_image(&canvas, x + pitch(cell_w), y, zoom, data->n_lights, data->n_views,
                             model + (size_t)i * block);
            enc_canvas_text(&canvas, x + pitch(cell_w), y - 6, "error");
        }
    }
    free(model);
    free(original);
    free(images);
    return write_canvas(context, &canvas, result, directory, "abrdf.png");
}

/* ShadowMap of paper 2.1 for one sample. */
static float shadow_ratio(const enc_pictures *p, const float *btf, const float *sbrdf) {
    return enc_shadow_ratio(enc_luminance(sbrdf[0], sbrdf[1], sbrdf[2]),
                            enc_luminance(btf[0], btf[1], btf[2]), p->t_error, p->t_btf);
}

/* Copies one image of a source to out[texel][3]. */
static btf_result one_image(const enc_data *data, enc_image_source source, int view, int light,
                            float *out) {
    const size_t image = enc_data_texel_count(data) * 3;
    float *all = malloc(image * (size_t)data->n_lights * sizeof *all);
    if (!all) {
        return BTF_ERROR_MEMORY;
    }
    const btf_result result = source.view(source.user, view, all);
    if (result == BTF_OK) {
        memcpy(out, all + (size_t)light * image, image * sizeof *out);
    }
    free(all);
    return result;
}

static btf_result draw_steps(const enc_context *context, const enc_pictures *p, const char *directory) {
    const enc_data *data = p->data;
    const size_t texels = enc_data_texel_count(data);
    const int zoom = zoom_for(data), cell_w = data->width * zoom, cell_h = data->height * zoom;
    const int light = enc_nearest_direction(data->lights, data->n_lights, 60, 60);
    const double thetas[3] = {0, 45, 75};
    const char *names[3];
    uint32_t effects[3];
    const int steps = list_steps(p, names, effects);
    const int with_6d = p->solution->sbrdf && p->t_error > 0;
    float *original = calloc(texels * 3, sizeof *original), *shown = calloc(texels * 3, sizeof *shown);
    enc_canvas canvas = {0};
    btf_result result = original && shown ? BTF_OK : BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        result = grid(context, 1 + steps + with_6d, 3, cell_w, cell_h, &canvas);
    }
    for (int r = 0; result == BTF_OK && r < 3; r++) {
        const int view = enc_nearest_direction(data->views, data->n_views, thetas[r], 120);
        int column = 0;
        result = one_image(data, enc_data_images(data), view, light, original);
        enc_canvas_image(&canvas, grid_x(column, cell_w), grid_y(r, cell_h), zoom, data->width,
                         data->height, original);
        enc_canvas_text(&canvas, grid_x(column++, cell_w), grid_y(r, cell_h) - 6, "original, view %.4g",
                        data->views[view].theta);
        for (int s = 0; result == BTF_OK && s < steps; s++) {
            const enc_decoded_samples decoded = {.decoder = p->decoder, .effects = effects[s]};
            result = one_image(data, enc_decoded_images(&decoded), view, light, shown);
            enc_canvas_image(&canvas, grid_x(column, cell_w), grid_y(r, cell_h), zoom, data->width,
                             data->height, shown);
            enc_canvas_text(&canvas, grid_x(column++, cell_w), grid_y(r, cell_h) - 6, "%s", names[s]);
            if (s == 0 && with_6d) {
                for (size_t t = 0; t < texels; t++) {
                    const float ratio = shadow_ratio(p, original + 3 * t, shown + 3 * t);
                    for (size_t channel = 0; channel < 3; channel++) {
                        shown[3 * t + channel] *= ratio;
                    }
                }
                enc_canvas_image(&canvas, grid_x(column, cell_w), grid_y(r, cell_h), zoom, data->width,
                                 data->height, shown);
                enc_canvas_text(&canvas, grid_x(column++, cell_w), grid_y(r, cell_h) - 6,
                                "SBRDF x 6D shadow");
            }
        }
    }
    free(shown);
    free(original);
    return write_canvas(context, &canvas, result, directory, "steps.png");
}

static btf_result draw_shadow(const enc_context *context, const enc_pictures *p, const char *directory) {
    const enc_data *data = p->data;
    const size_t texels = enc_data_texel_count(data);
    const int zoom = zoom_for(data), cell_w = data->width * zoom, cell_h = data->height * zoom;
    const int columns = 5, fixed = enc_nearest_direction(data->lights, data->n_lights, 60, 60);
    float *original = calloc(texels * 3, sizeof *original), *model = calloc(texels * 3, sizeof *model);
    unsigned char *codes = malloc(texels);
    enc_canvas canvas = {0};
    btf_result result = original && model && codes ? BTF_OK : BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        result = grid(context, columns, p->t_error > 0 ? 2 : 1, cell_w, cell_h, &canvas);
    }
    for (int c = 0; result == BTF_OK && c < columns; c++) {
        const int light = enc_nearest_direction(data->lights, data->n_lights, 15 + 15 * c, 60);
        const int x = grid_x(c, cell_w), y = grid_y(0, cell_h);
        enc_canvas_codes(&canvas, x, y, zoom, data->width, data->height,
                         p->solution->shadow + (size_t)light * texels);
        enc_canvas_text(&canvas, x, y - 6, "map, light %.4g,%.4g", data->lights[light].theta,
                        data->lights[light].phi);
        if (p->t_error <= 0) {
            continue;
        }
        const int view = enc_nearest_direction(data->views, data->n_views, 15 * c, 120);
        const enc_decoded_samples decoded = {.decoder = p->decoder, .effects = 0};
        result = one_image(data, enc_data_images(data), view, fixed, original);
        if (result == BTF_OK) {
            result = one_image(data, enc_decoded_images(&decoded), view, fixed, model);
        }
        for (size_t t = 0; t < texels; t++) {
            codes[t] = (unsigned char)(shadow_ratio(p, original + 3 * t, model + 3 * t) * 255.0f + 0.5f);
        }
        enc_canvas_codes(&canvas, x, grid_y(1, cell_h), zoom, data->width, data->height, codes);
        enc_canvas_text(&canvas, x, grid_y(1, cell_h) - 6, "6D, view %.4g", data->views[view].theta);
    }
    free(codes);
    free(model);
    free(original);
    return write_canvas(context, &canvas, result, directory, "shadow.png");
}

/* A motion vector as a colour: hue its direction, saturation its length up to `longest` texels. */
static void flow_colour(const int8_t shift[2], float longest, float out[3]) {
    const float angle = atan2f((float)-shift[1], (float)shift[0]);
    const float length = fminf(hypotf(shift[0], shift[1]) / longest, 1);
    for (int channel = 0; channel < 3; channel++) {
        const float wave = 0.5f + 0.5f * cosf(angle - (float)channel * 2.0943951f);
        out[channel] = 1 - length * (1 - wave);
    }
}

static btf_result draw_flow(const enc_context *context, const enc_pictures *p, const char *directory) {
    const enc_data *data = p->data;
    const size_t texels = enc_data_texel_count(data);
    const int zoom = zoom_for(data), cell_w = data->width * zoom, cell_h = data->height * zoom;
    const int light = enc_nearest_direction(data->lights, data->n_lights, 15, 60);
    const double thetas[3] = {30, 45, 60};
    float *image = calloc(texels * 3, sizeof *image);
    unsigned char *codes = malloc(texels);
    enc_canvas canvas = {0};
    btf_result result = image && codes ? BTF_OK : BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        result = grid(context, 5, 3, cell_w, cell_h, &canvas);
    }
    for (int r = 0; result == BTF_OK && r < 3; r++) {
        const int view = enc_nearest_direction(data->views, data->n_views, thetas[r], 0),
                  y = grid_y(r, cell_h);
        const size_t base = (size_t)view * texels;
        const int shown[2] = {data->top_view, view};
        for (int c = 0; result == BTF_OK && c < 2; c++) {
            result = one_image(data, enc_data_images(data), shown[c], light, image);
            enc_canvas_image(&canvas, grid_x(c, cell_w), y, zoom, data->width, data->height, image);
            enc_canvas_text(&canvas, grid_x(c, cell_w), y - 6, "view %.4g,%.4g",
                            data->views[shown[c]].theta, data->views[shown[c]].phi);
        }
        for (size_t t = 0; t < texels; t++) {
            flow_colour(p->occlusion->shift + 2 * (base + t), 8, image + 3 * t);
            codes[t] = (unsigned char)(255.0f * (1 - p->occlusion->ratio[base + t]) + 0.5f);
        }
        enc_canvas_image(&canvas, grid_x(2, cell_w), y, zoom, data->width, data->height, image);
        enc_canvas_text(&canvas, grid_x(2, cell_w), y - 6, "shifts");
        enc_canvas_codes(&canvas, grid_x(3, cell_w), y, zoom, data->width, data->height, codes);
        enc_canvas_text(&canvas, grid_x(3, cell_w), y - 6, "HiddenRatio");
        for (size_t t = 0; t < texels; t++) {
            codes[t] = p->occlusion->hidden_voted[base + t] ? 255 : 0;
        }
        enc_canvas_codes(&canvas, grid_x(4, cell_w), y, zoom, data->width, data->height, codes);
        enc_canvas_text(&canvas, grid_x(4, cell_w), y - 6, "hidden");
    }
    free(codes);
    free(image);
    return write_canvas(context, &canvas, result, directory, "flow.png");
}

static btf_result draw_hidden(const enc_context *context, const enc_pictures *p, const char *directory) {
    const enc_data *data = p->data;
    const size_t texels = enc_data_texel_count(data);
    const int zoom = zoom_for(data), cell_w = data->width * zoom, cell_h = data->height * zoom;
    const double thetas[3] = {30, 45, 60};
    unsigned char *codes = malloc(texels);
    enc_canvas canvas = {0};
    btf_result result = codes ? grid(context, 3, 2, cell_w, cell_h, &canvas) : BTF_ERROR_MEMORY;
    for (int c = 0; result == BTF_OK && c < 3; c++) {
        const int view = enc_nearest_direction(data->views, data->n_views, thetas[c], 0);
        for (int after = 0; after < 2; after++) {
            const uint8_t *hidden =
                (after ? p->occlusion->hidden : p->occlusion->hidden_voted) + (size_t)view * texels;
            for (size_t t = 0; t < texels; t++) {
                codes[t] = hidden[t] ? 255 : 0;
            }
            enc_canvas_codes(&canvas, grid_x(c, cell_w), grid_y(after, cell_h), zoom, data->width,
                             data->height, codes);
            enc_canvas_text(&canvas, grid_x(c, cell_w), grid_y(after, cell_h) - 6, "%s, view %.4g",
                            after ? "after" : "before", data->views[view].theta);
        }
    }
    free(codes);
    return write_canvas(context, &canvas, result, directory, "hidden.png");
}

static btf_result draw_atlas(const enc_context *context, const enc_pictures *p, const char *directory) {
    static const char *const names[4] = {"R: shadow, centres", "G: gain or hidden", "B: columns or index",
                                         "A: rows or index"};
    const btf_texture maps = btf_material_texture(p->material, BTF_TEXTURE_MAPS);
    const int width = (int)maps.width, height = (int)maps.height;
    const uint8_t *texels = maps.data;
    unsigned char *codes = malloc((size_t)width * (size_t)height);
    enc_canvas canvas = {0};
    btf_result result = codes ? grid(context, 2, 2, width, height, &canvas) : BTF_ERROR_MEMORY;
    for (int c = 0; result == BTF_OK && c < 4; c++) {
        for (size_t i = 0; i < (size_t)width * (size_t)height; i++) {
            codes[i] = texels[4 * i + (size_t)c];
        }
        enc_canvas_codes(&canvas, grid_x(c % 2, width), grid_y(c / 2, height), 1, width, height, codes);
        enc_canvas_text(&canvas, grid_x(c % 2, width), grid_y(c / 2, height) - 6, "%s", names[c]);
    }
    free(codes);
    return write_canvas(context, &canvas, result, directory, "atlas.png");
}

btf_result enc_pictures_write(const enc_context *context, const enc_pictures *p, const char *directory) {
    btf_result result = draw_abrdf(context, p, directory);
    if (result == BTF_OK) {
        result = draw_steps(context, p, directory);
    }
    if (result == BTF_OK && p->solution->shadow) {
        result = draw_shadow(context, p, directory);
    }
    if (result == BTF_OK && p->occlusion) {
        result = draw_flow(context, p, directory);
    }
    if (result == BTF_OK && p->occlusion) {
        result = draw_hidden(context, p, directory);
    }
    if (result == BTF_OK && btf_material_texture(p->material, BTF_TEXTURE_MAPS).data) {
        result = draw_atlas(context, p, directory);
    }
    return result;
}
