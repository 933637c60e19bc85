/* A scene on the command line. See scene_option.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "scene_option.h"
#include "between.h"

#include "cli.h"
#include "filter.h"
#include <math.h>
#include <openbtf/fold.h>
#include <stdlib.h>
#include <string.h>

#define DEGREE (3.14159265358979323846 / 180)

static const char expected[] =
    "views=T0:T1[:P0:P1],lights=...,view=T:P,light=T:P,pixels=X,count=N,tolerance=DB,"
    "interpolate, still or all";

/* Reads numbers with colons between them, up to the end of the word; returns how many, 0 when there is anything
 * else. */
static int read_numbers(const char *text, size_t length, double out[4]) {
    const char *end = text + length;
    for (int count = 1; count <= 4; count++) {
        char *next;
        out[count - 1] = strtod(text, &next);
        if (next == text || next > end || !isfinite(out[count - 1])) {
            return 0;
        }
        if (next == end) {
            return count;
        }
        if (*next != ':') {
            return 0;
        }
        text = next + 1;
    }
    return 0;
}

static bool in_order(double low, double high) {
    return low >= 0 && high >= low && high <= 90;
}

static bool set_range(btf_range *range, const double *n, int count) {
    if ((count != 2 && count != 4) || !in_order(n[0], n[1])) {
        return false;
    }
    *range = (btf_range){.theta = {(float)n[0], (float)n[1]}};
    for (int i = 2; i < count; i++) {
        if (!(fabs(n[i]) <= 360)) {
            return false;
        }
        range->phi[i - 2] = (float)n[i];
    }
    return true;
}

static bool set_direction(btf_range *range, const double *n, int count) {
    if (count != 2 || !(n[0] >= 0 && n[0] < 90) || !(fabs(n[1]) <= 360)) {
        return false;
    }
    const double s = sin(n[0] * DEGREE);
    *range = (btf_range){.fixed = 1,
                         .direction = {(float)(s * cos(n[1] * DEGREE)), (float)(s * sin(n[1] * DEGREE)),
                                       (float)cos(n[0] * DEGREE)}};
    return true;
}

/* Reads one word of the list. */
static bool read_word(const char *word, size_t length, scene_option *o) {
    static const char *const keys[] = {
        "views=", "lights=", "view=", "light=", "pixels=", "count=", "tolerance="};
    double n[4];
    if (length == 3 && memcmp(word, "all", 3) == 0) {
        return true;
    }
    if (length == 11 && memcmp(word, "interpolate", 11) == 0) {
        o->scene.interpolate = 1;
        return true;
    }
    if (length == 5 && memcmp(word, "still", 5) == 0) {
        o->scene.still_lights = 1;
        return true;
    }
    for (int k = 0; k < (int)(sizeof keys / sizeof *keys); k++) {
        const size_t size = strlen(keys[k]);
        if (length <= size || memcmp(word, keys[k], size) != 0) {
            continue;
        }
        const int count = read_numbers(word + size, length - size, n);
        if (k < 2) {
            return set_range(k == 0 ? &o->scene.view : &o->scene.light, n, count);
        }
        if (k < 4) {
            return set_direction(k == 2 ? &o->scene.view : &o->scene.light, n, count);
        }
        if (count != 1 || !(n[0] >= 0 && n[0] <= 1e6)) {
            return false;
        }
        if (k == 4) {
            o->scene.pixels = (float)n[0];
        } else if (k == 5) {
            o->scene.lights = (uint32_t)n[0];
        } else {
            o->tolerance = (float)n[0];
        }
        return k != 5 || (n[0] >= 1 && n[0] == floor(n[0]));
    }
    return false;
}

const char *scene_option_parse(const char *text, void *value) {
    scene_option *o = value;
    *o = (scene_option){.scene = {.struct_size = sizeof o->scene}, .tolerance = 0.5f};
    while (true) {
        const size_t length = strcspn(text, ",");
        if (!read_word(text, length, o)) {
            return expected;
        }
        if (!text[length]) {
            return NULL;
        }
        text += length + 1;
    }
}

const char *scene_plan_reason(const btf_material *material, const btf_plan *plan, int index, char *text,
                              size_t size) {
    const uint32_t bit = 1u << index, others = plan->effects & ~bit;
    const bool on = plan->effects & bit, residual = bit == BTF_EFFECT_RESIDUAL;
    btf_material_info info = {.struct_size = sizeof info};
    float linear, srgb;
    btf_material_get_info(material, &info);
    if (!(info.effects & bit)) {
        snprintf(text, size, "not in the file");
        return text;
    }
    if (bit == BTF_EFFECT_RELIEF && plan->level >= info.relief_end) {
        snprintf(text, size, "off, ends before level %u", (unsigned)info.relief_end);
        return text;
    }
    if (bit & BETWEEN_EFFECTS) {
        const bool known = btf_plan_worth(material, plan, (btf_effect)bit, &linear, &srgb) == BTF_OK;
        snprintf(text, size,
                 known ? "%s, worth %+.1f/%+.1f dB between the samples" : "%s, acts between the samples",
                 on ? "on" : "off", (double)linear, (double)srgb);
        return text;
    }
    const uint32_t components = !residual ? plan->components : on ? 0 : info.components;
    if (btf_plan_predict(material, plan, on ? others : others | bit, components, &linear, &srgb)) {
        snprintf(text, size, "%s", on ? "on" : "off");
    } else {
        snprintf(text, size, "%s, %s it %+.1f/%+.1f dB", on ? "on" : "off", on ? "without" : "with",
                 (double)(linear - plan->psnr_linear), (double)(srgb - plan->psnr_srgb));
    }
    return text;
}

static void print_reasons(FILE *out, const char *indent, const btf_material *material,
                          const btf_plan *plan) {
    btf_material_info info = {.struct_size = sizeof info};
    char text[80];
    btf_material_get_info(material, &info);
    for (int i = 0; i < CLI_EFFECTS_COUNT; i++) {
        if (info.effects >> i & 1) {
            fprintf(out, "%s%s: %s\n", indent, cli_effect_word(i),
                    scene_plan_reason(material, plan, i, text, sizeof text));
        }
    }
}

const char *scene_plan_amount(const btf_plan *plan, char *text, size_t size) {
    const bool factors = plan->textures >> BTF_TEXTURE_FACTOR_DIRECTIONS & 1;
    snprintf(text, size, "%u %s%s", (unsigned)plan->components, factors ? "unit" : "component",
             plan->components == 1 ? "" : "s");
    return text;
}

/* Prints `text` and the parts of the material that the plan leaves out; nothing where it leaves out none. */
static void print_left_out(FILE *out, const char *text, const btf_material *material,
                           const btf_plan *plan) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    const uint32_t effects = info.effects & ~plan->effects;
    const bool factors = info.store == BTF_STORE_FACTORS;
    const struct {
        uint32_t count;
        const char *one;
    } parts[] = {{effects & BTF_EFFECT_RESIDUAL ? 0 : info.components - plan->components,
                  factors ? "unit" : "component"},
                 {info.n_views - plan->views, "view"},
                 {info.n_lights - plan->lights, "light"},
                 {plan->level, "level"}};
    const char *separator = text;
    for (int i = 0; i < CLI_EFFECTS_COUNT; i++) {
        if (effects >> i & 1) {
            fprintf(out, "%s%s", separator, cli_effect_word(i));
            separator = ", ";
        }
    }
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
        if (parts[i].count > 0) {
            fprintf(out, "%s%u %s%s", separator, (unsigned)parts[i].count, parts[i].one,
                    parts[i].count == 1 ? "" : "s");
            separator = ", ";
        }
    }
    if (separator != text) {
        fprintf(out, "\n");
    }
}

/* Prints how a fixed light, or the sum of several still ones, is folded, or why nothing is. */
static void print_fold(FILE *out, const char *indent, const btf_material *material, const btf_plan *plan) {
    btf_material_info info = {.struct_size = sizeof info};
    float linear, srgb;
    btf_material_get_info(material, &info);
    const bool light_alone = !plan->scene.view.fixed, glossy = info.effects & BTF_EFFECT_GLOSS;
    if (plan->fold != BTF_FOLD_NONE) {
        fprintf(out, "%s%s folded into %zu bytes: %.0f%% of the time, after %.0f pixels%s\n", indent,
                plan->fold == BTF_FOLD_LIGHT ? "light"
                : plan->fold == BTF_FOLD_SUM ? "lights"
                : plan->scene.light.fixed    ? "light and view"
                                             : "lights and view",
                plan->fold_bytes, 100 * (double)plan->folded_cost / (double)plan->full_cost,
                plan->fold_pixels, light_alone && glossy ? "; for that gloss is left out" : "");
        return;
    }
    fprintf(out, "%snothing is folded: ", indent);
    if (plan->scene.no_fold) {
        fprintf(out, "no fold is wanted\n");
    } else if ((plan->scene.light.fixed
                    ? btf_fold_best(&info, &plan->shader, plan->scene.view.fixed)
                    : btf_fold_best_sum(&info, &plan->shader, plan->scene.view.fixed)) != BTF_FOLD_NONE) {
        fprintf(out, "a fold would not pay within %.0f pixels, or is too large\n",
                plan->scene.folded_pixels);
    } else if (info.colour != BTF_COLOUR_NONE) {
        fprintf(out, "the SBRDF depends on the view\n");
    } else if (!plan->scene.light.fixed && plan->effects & BTF_EFFECT_RELIEF) {
        fprintf(out, "with relief each view shows other texels\n");
    } else if (btf_plan_worth(material, plan, BTF_EFFECT_GLOSS, &linear, &srgb) == BTF_OK) {
        fprintf(out,
                "with gloss lights depend on the view; without it about %.2f/%.2f dB are lost between the "
                "samples\n",
                (double)linear, (double)srgb);
    } else {
        fprintf(out,
                "with gloss lights depend on the view, and the file does not say what gloss is worth\n");
    }
}

void scene_plan_print(FILE *out, const char *indent, const btf_material *material, const btf_plan *plan) {
    char words[48], amount[32], left_out[64];
    snprintf(left_out, sizeof left_out, "%sleft out: ", indent);
    fprintf(out, "%seffects %s", indent, cli_effects_text(plan->effects, words));
    if (plan->components) {
        fprintf(out, ", %s", scene_plan_amount(plan, amount, sizeof amount));
    }
    fprintf(out, ", %s directions, %s, level %u%s%s\n",
            plan->shader.interpolation == BTF_INTERPOLATION_NEAREST ? "nearest" : "interpolated",
            plan->shader.filter == BTF_FILTER_TEXEL ? "one texel" : filter_name(plan->shader.filter),
            (unsigned)plan->level, plan->shader.fixed & BTF_FIXED_VIEW ? ", fixed view" : "",
            plan->shader.fixed & BTF_FIXED_LIGHT ? ", fixed light" : "");
    print_left_out(out, left_out, material, plan);
    fprintf(out, "%s%u views, %u lights, %zu bytes of %zu (%.0f%%), %.0f%% of the time\n", indent,
            (unsigned)plan->views, (unsigned)plan->lights, plan->gpu_bytes, plan->full_gpu_bytes,
            100 * (double)plan->gpu_bytes / (double)plan->full_gpu_bytes,
            100 * (double)plan->cost / (double)plan->full_cost);
    if (plan->scene.light.fixed || plan->scene.still_lights || plan->fold != BTF_FOLD_NONE) {
        print_fold(out, indent, material, plan);
    }
    print_reasons(out, indent, material, plan);
    if (plan->measured) {
        fprintf(out, "%spredicted PSNR %.2f dB linear, %.2f sRGB; full decode %.2f, %.2f\n", indent,
                (double)plan->psnr_linear, (double)plan->psnr_srgb, (double)plan->full_psnr_linear,
                (double)plan->full_psnr_srgb);
    }
    if (plan->full_between_psnr_linear > 0) {
        fprintf(out,
                "%sbetween the samples, estimated: %.2f dB linear, %.2f sRGB; full decode %.2f, %.2f\n",
                indent, (double)plan->between_psnr_linear, (double)plan->between_psnr_srgb,
                (double)plan->full_between_psnr_linear, (double)plan->full_between_psnr_srgb);
    }
    if (!plan->measured) {
        fprintf(out, "%sthe file has no effect errors: everything is decoded\n", indent);
    }
}
