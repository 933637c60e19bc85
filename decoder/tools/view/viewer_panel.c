/* btf-view: draws the picture and the text over it, times it, saves it.
 *
 * SPDX-License-Identifier: MIT
 */
#include "viewer_panel.h"

#include "decoder/toolkit/cli.h"
#include "decoder/toolkit/filter.h"
#include "decoder/toolkit/png_image.h"
#include "options.h"
#include "viewer_plan.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static uint32_t effects_in_use(const viewer *v) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(v->material, &info);
    return v->state.effects & info.effects;
}

/* Draws the model and measures how long that takes. */
static btf_result draw_model(viewer *v, const view_state *s, double *out_ms) {
    int width, height;
    viewer_frame_size(v, &width, &height);
    v->gl.Finish();
    double start = glfwGetTime();
    btf_result result = drawing_draw(v->drawing, s, width, height, &v->log);
    v->gl.Finish();
    *out_ms = 1e3 * (glfwGetTime() - start);
    return result;
}

/* Says which levels of detail are shown and, where relief is on but ends before the last of them, at which one. */
static void levels_text(const viewer *v, char *text, size_t size) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(v->material, &info);
    const bool ends = effects_in_use(v) & BTF_EFFECT_RELIEF && info.relief_end < info.levels;
    if (!v->state.has_levels) {
        text[0] = 0;
    } else if (!v->state.levels) {
        snprintf(text, size, ", level 0");
    } else if (ends) {
        snprintf(text, size, ", levels (relief below %u)", (unsigned)info.relief_end);
    } else {
        snprintf(text, size, ", levels");
    }
}

/* The text in the corner: the material and how it is decoded, time and accuracy, and the last message. */
static void panel_text(const viewer *v, char *text, size_t size) {
    char list[800] = "", quality[80] = "not in the file", words[48], levels[40], picks[60] = "";
    if (!v->material) {
        snprintf(text, size, "drop a material here: *.btf.exr\n%s", v->message);
        return;
    }
    if (v->state.stochastic) {
        snprintf(picks, sizeof picks, ", stochastic, %d samples a pixel", drawing_samples(v->drawing));
    }
    const btf_material_error *error = costs_error(v->material, v->state.effects);
    if (error) {
        snprintf(quality, sizeof quality, "%.1f dB linear, %.1f dB sRGB", (double)error->psnr_linear,
                 (double)error->psnr_srgb);
    }
    if (view_options.plan == 0) {
        viewer_plan_text(v, list, sizeof list);
    } else {
        costs_text(&v->costs, v->material, v->state.effects, list, sizeof list);
    }
    levels_text(v, levels, sizeof levels);
    snprintf(text, size,
             "%s on %s\n%s, %s, %s math%s%s, exposure %+.2f\nframe %.1f ms (%.0f a second)\nPSNR %s\n"
             "effects %s: %s\n%ssplit %s\n%s",
             v->material_name, view_mesh_name(v->state.mesh),
             v->state.interpolation == BTF_INTERPOLATION_NEAREST ? "nearest" : "linear",
             filter_name(v->state.filter), v->state.math == BTF_MATH_FAST ? "fast" : "exact", levels, picks,
             v->state.exposure, v->frame_ms, 1e3 / (v->frame_ms > 0.01 ? v->frame_ms : 0.01), quality,
             cli_effects_text(v->state.effects, words),
             view_options.plan == 0 ? "as the plan decodes them" : "time and PSNR of each", list,
             view_split_name(v->state.split), v->message[0] ? v->message : "H: help");
}

/* Draws the panel and the help over the picture, in letters of twice the size on large windows. */
static void draw_overlays(viewer *v) {
    char text[1800];
    int width, height, w, h;
    viewer_frame_size(v, &width, &height);
    const int zoom = width >= 1100 && height >= 900 ? 2 : 1;
    if (v->state.info || !v->material) {
        panel_text(v, text, sizeof text);
        overlay_draw(v->overlay, text, 6, 6, zoom, width, height);
    }
    if (v->state.help) {
        overlay_size(view_help_text(), zoom, &w, &h);
        overlay_draw(v->overlay, view_help_text(), (width - w) / 2, (height - h) / 2, zoom, width, height);
    }
}

btf_result viewer_draw_frame(viewer *v) {
    btf_result result = draw_model(v, &v->state, &v->frame_ms);
    if (result) {
        return result;
    }
    if (v->material && v->state.split == VIEW_SPLIT_OFF) {
        costs_record(&v->costs, effects_in_use(v), v->frame_ms);
    }
    draw_overlays(v);
    return BTF_OK;
}

/* Times frames with each effect of the file switched, then with the effects as they are; each time is the median of
 * five frames. */
btf_result viewer_measure(viewer *v) {
    if (!v->material) {
        return BTF_OK;
    }
    view_state s = v->state;
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(v->material, &info);
    s.split = VIEW_SPLIT_OFF;
    costs_clear(&v->costs);
    for (uint32_t i = 0; i <= CLI_EFFECTS_COUNT; i++) {
        const uint32_t change = i < CLI_EFFECTS_COUNT ? 1u << i : 0;
        double ms[6];
        if (change && !(info.effects & change)) {
            continue;
        }
        s.effects = effects_in_use(v) ^ change;
        for (int k = 0; k < 6; k++) { /* in the first frame shaders are compiled: it does not count */
            btf_result result = draw_model(v, &s, &ms[k]);
            if (result) {
                return result;
            }
        }
        for (int a = 1; a < 6; a++) {
            for (int b = a + 1; b < 6; b++) {
                if (ms[b] < ms[a]) {
                    double swap = ms[a];
                    ms[a] = ms[b];
                    ms[b] = swap;
                }
            }
        }
        costs_record(&v->costs, s.effects, ms[3]);
    }
    char text[160];
    snprintf(text, sizeof text, "measured: %.1f ms a frame", v->costs.ms[effects_in_use(v)]);
    viewer_tell(v, text);
    return BTF_OK;
}

btf_result viewer_save_picture(viewer *v) {
    static int number = 0;
    char path[1024], text[1100];
    int width, height;
    double wait;
    btf_result result = view_options.plan == 0 && v->material ? viewer_plan(v, &wait) : BTF_OK;
    if (!result) {
        result = viewer_draw_frame(v);
    }
    if (result) {
        return result;
    }
    viewer_frame_size(v, &width, &height);
    do {
        snprintf(path, sizeof path, "%.900s-%04d.png", view_options.screenshots, ++number);
    } while (access(path, F_OK) == 0 && number < 9999);
    const size_t row = (size_t)width * 3;
    unsigned char *rgba = malloc((size_t)width * (size_t)height * 4), *rgb = malloc(row * (size_t)height);
    if (!rgba || !rgb) {
        free(rgba);
        free(rgb);
        return cli_error(&view_program, BTF_ERROR_MEMORY, "out of memory for a picture");
    }
    v->gl.ReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, rgba);
    for (int y = 0; y < height; y++) {
        for (int x = 0; x < width; x++) {
            memcpy(rgb + (size_t)(height - 1 - y) * row + 3 * (size_t)x,
                   rgba + 4 * ((size_t)y * (size_t)width + (size_t)x), 3);
        }
    }
    if (png_image_write8(path, width, height, rgb, v->log) == BTF_OK) {
        snprintf(text, sizeof text, "saved %s", path);
        viewer_tell(v, text);
    }
    free(rgba);
    free(rgb);
    return BTF_OK;
}
