/* The text that btf-info prints. See info_text.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "info_text.h"

#include "decoder/toolkit/between.h"
#include "decoder/toolkit/cli.h"
#include "info_facts.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { LABEL = 16, LINE = 100, MOST_RINGS = 16 };

/* Prints a text of a file, with control characters, which a terminal would obey, as \xNN. Returns its columns. */
static int print_safe(const char *text, int length) {
    int columns = 0;
    for (const char *c = text; c < text + length; c++) {
        columns += (unsigned char)*c < ' ' || *c == 0x7f ? printf("\\x%02x", (unsigned)(unsigned char)*c)
                                                         : printf("%c", *c);
    }
    return columns;
}

/* Prints a label and words, wrapped at LINE columns where they have blanks. */
static void print_wrapped(const char *label, const char *words) {
    int column = printf("  %-14s", label);
    while (*words) {
        const int length = (int)strcspn(words, " ");
        if (column > LABEL && column + 1 + length > LINE) {
            column = printf("\n%*s", LABEL, "") - 1;
        } else if (column > LABEL) {
            column += printf(" ");
        }
        column += print_safe(words, length);
        words += length;
        words += strspn(words, " ");
    }
    printf("\n");
}

static void print_rings(const char *name, const btf_directions *d) {
    ring rings[BTF_MAX_DIRECTIONS];
    char text[MOST_RINGS * 40 + 160];
    const int count = find_rings(d, rings);
    int length = snprintf(text, sizeof text, "%u:", (unsigned)d->count);
    for (int i = 0; i < count && count <= MOST_RINGS; i++) {
        length += snprintf(text + length, sizeof text - (size_t)length, " %g\u00B0 x %d%s", rings[i].theta,
                           rings[i].count, i + 1 < count ? "," : "");
    }
    if (count > MOST_RINGS) {
        double low = rings[0].theta, high = low;
        for (int i = 1; i < count; i++) {
            low = fmin(low, rings[i].theta);
            high = fmax(high, rings[i].theta);
        }
        length += snprintf(text + length, sizeof text - (size_t)length,
                           " %d angles from %g\u00B0 to %g\u00B0 (--json lists them)", count, low, high);
    }
    snprintf(text + length, sizeof text - (size_t)length, "; %u triangles, grid %u x %u",
             (unsigned)d->triangle_count, (unsigned)d->grid, (unsigned)d->grid);
    print_wrapped(name, text);
}

/* Prints the gain of an effect that changes nothing at the samples, where the other errors are measured. */
static void print_between_gain(const btf_material *material, uint32_t effect) {
    char word[48];
    double gain[2];
    printf("  %-14sacts between the samples only", cli_effects_text(effect, word));
    if (between_gain(material, effect, gain)) {
        printf(": %+.2f dB linear, %+.2f dB sRGB where views%s are left out", gain[0], gain[1],
               effect == BTF_EFFECT_GLOSS ? " and lights" : "");
    }
    printf(", for %zu bytes\n", between_bytes(material, effect));
}

static void print_effects(const btf_material *material, const btf_material_info *info) {
    char words[48];
    size_t count;
    const btf_material_error *errors = btf_material_errors(material, &count), *with, *without;
    printf("\nEffects: %s\n", cli_effects_text(info->effects, words));
    for (uint32_t bit = 1; bit < BTF_EFFECT_ALL; bit <<= 1) {
        if (info->effects & bit & BETWEEN_EFFECTS) {
            print_between_gain(material, bit);
        } else if (info->effects & bit && find_gain(errors, count, bit, &with, &without)) {
            printf("  %-14s%+.2f dB linear, %+.2f dB sRGB for %.0f bytes\n", cli_effects_text(bit, words),
                   (double)(with->psnr_linear - without->psnr_linear),
                   (double)(with->psnr_srgb - without->psnr_srgb),
                   (double)(with->gpu_bytes - without->gpu_bytes));
        }
    }
    if (count) {
        printf("Accuracy at the samples, measured by the encoder (PSNR in dB, linear / sRGB):\n");
    }
    for (size_t i = 0; i < count; i++) {
        printf("  %6.2f / %6.2f  %9.0f bytes  %s\n", (double)errors[i].psnr_linear,
               (double)errors[i].psnr_srgb, (double)errors[i].gpu_bytes,
               cli_effects_text(errors[i].effects, words));
    }
}

static void print_between(const btf_material *material) {
    const btf_between_errors e = btf_material_between_errors(material);
    if (e.row_count == 0) {
        return;
    }
    printf(
        "\n"
        "Between the samples, estimated by predicting samples left out from neighbours twice as far away\n"
        "(which overstates the error; PSNR in dB, linear / sRGB):\n"
        "  %-16s%14s%22s\n",
        "left out", "material", "data, interpolated");
    for (uint32_t i = 0; i < e.row_count; i++) {
        const float *row = e.rows + (size_t)i * e.row_stride;
        const int level = left_out_level(row[0]);
        printf("  %-16s%7.2f / %6.2f%13.2f / %6.2f", left_out_name(row[0]), decibels(row[1]),
               decibels(row[2]), decibels(row[3]), decibels(row[4]));
        printf(level > 0 ? "  level %d\n" : "\n", level);
    }
}

static void print_levels(const btf_material *material, const btf_material_info *info) {
    if (info->levels < 2) {
        return;
    }
    printf("\nLevels of detail (PSNR in dB against the area-filtered original, linear / sRGB):\n");
    for (uint32_t i = 0; i < info->levels; i++) {
        const btf_level_error *error = find_level_error(material, i);
        char size[32];
        snprintf(size, sizeof size, "%u x %u", (unsigned)btf_level_size(info->width, i),
                 (unsigned)btf_level_size(info->height, i));
        printf("  %-3u%-16s%12zu bytes", (unsigned)i, size, btf_level_bytes(info, i));
        if (error) {
            printf("  %6.2f / %6.2f", (double)error->psnr_linear, (double)error->psnr_srgb);
        }
        printf("\n");
    }
}

static void print_textures(const btf_material *material, const btf_material_info *info) {
    printf("\nTextures:\n");
    for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
        btf_texture t = btf_material_texture(material, (btf_texture_id)id);
        if (t.format == BTF_FORMAT_NONE) {
            continue;
        }
        char size[48];
        if (t.is_array) {
            snprintf(size, sizeof size, "%u x %u x %u", (unsigned)t.width, (unsigned)t.height,
                     (unsigned)t.layers);
        } else {
            snprintf(size, sizeof size, "%u x %u", (unsigned)t.width, (unsigned)t.height);
        }
        printf("  %-20s%-9s%-20s%12zu bytes", btf_texture_name((btf_texture_id)id), format_name(t.format),
               size, t.size);
        if (is_table((btf_texture_id)id)) {
            printf("  (table)\n");
        } else {
            printf("%10.2f a texel\n", (double)t.size / ((double)info->width * info->height));
        }
    }
}

static void print_points(const btf_material_info *info) {
    if (info->point_store == BTF_POINTS_SEPARATE) {
        return;
    }
    printf("  %-14s", "points");
    if (info->point_store == BTF_POINTS_LISTS) {
        printf("lists of %u points a texel", (unsigned)info->point_entries);
    } else {
        printf("packed");
    }
    printf(": shifts within -32..31, gain %g + %g * 0..15\n", (double)info->gain_base,
           (double)info->gain_step);
}

static void print_relief(const btf_material *material, const btf_material_info *info) {
    if (info->effects & BTF_EFFECT_RELIEF) {
        const relief_range r = find_relief(material, info);
        printf("  %-14s", "relief");
        if (info->relief_step > 0) {
            printf("heights %.3g to %.3g texels, %u step%s", r.low, r.high, (unsigned)info->relief_steps,
                   info->relief_steps == 1 ? "" : "s");
        } else {
            printf("height %.3g texels everywhere", r.low);
        }
        printf(", on %u of %u views", (unsigned)r.views, (unsigned)info->n_views);
        if (info->relief_end < info->levels) {
            printf(", below level %u", (unsigned)info->relief_end);
        }
        printf("\n");
    }
    if (info->effects & BTF_EFFECT_GLOSS) {
        printf("  %-14skeeps %g of the half vector\n", "gloss", info->gloss_share / 4.0);
    }
}

static void print_residual(const btf_material_info *info) {
    if (info->store == BTF_STORE_COMPONENTS) {
        if (info->components) {
            printf("  %-14s%u components\n", "residual", (unsigned)info->components);
        }
        return;
    }
    uint32_t components = 0;
    for (int c = 0; c < BTF_FACTOR_CLASSES; c++) {
        components += count_class(info, c).components;
    }
    printf("  %-14s%u unit%s of factors, %u components\n", "residual", (unsigned)info->components,
           info->components == 1 ? "" : "s", (unsigned)components);
    for (int c = 0; c < BTF_FACTOR_CLASSES; c++) {
        const class_counts n = count_class(info, c);
        if (n.units) {
            printf("  %-14s%d bits of w, %d of u: %u unit%s, words: Y %u, C1 %u, C2 %u; %u components\n",
                   "", class_bits[c][0], class_bits[c][1], (unsigned)n.units, n.units == 1 ? "" : "s",
                   (unsigned)n.words[0], (unsigned)n.words[1], (unsigned)n.words[2],
                   (unsigned)n.components);
        }
    }
    const double horizon = 90 - asin(1 / (double)info->horizon_scale) * (180 / 3.14159265358979323846);
    printf("  %-14sfactors fade to black from theta %.4g\u00B0 of the light to 90\u00B0\n", "horizon",
           horizon);
}

void print_text(const char *path, uint64_t file_bytes, const btf_material *material,
                const btf_material_info *info) {
    const btf_directions views = btf_material_views(material), lights = btf_material_lights(material);
    double samples = 3.0 * info->width * info->height * info->n_views * info->n_lights;
    print_safe(path, (int)strlen(path));
    printf(": OpenBTF material, format version %u\n", (unsigned)info->version);
    printf("  %-14s%u x %u texels\n", "size", (unsigned)info->width, (unsigned)info->height);
    if (info->levels > 1) {
        printf("  %-14s%u, down to %u x %u texels\n", "levels", (unsigned)info->levels,
               (unsigned)btf_level_size(info->width, info->levels - 1),
               (unsigned)btf_level_size(info->height, info->levels - 1));
    }
    print_rings("views", &views);
    print_rings("lights", &lights);
    printf("  %-14s%s, domain %s\n", "layout", layout_names[info->layout], domain_names[info->domain]);
    if (info->layout == BTF_LAYOUT_PAPER) {
        printf("  %-14s%u x %u\n", "atlas", (unsigned)info->atlas_width, (unsigned)info->atlas_height);
    }
    printf("  %-14s%u lobe%s, colour %s%s\n", "model", (unsigned)info->lobes, info->lobes == 1 ? "" : "s",
           colour_names[info->colour],
           info->colour == BTF_COLOUR_NONE ? ""
           : info->half_float              ? ", half"
                                           : ", float");
    if (info->centres) {
        printf("  %-14s%u\n", "centres", (unsigned)info->centres);
    }
    print_points(info);
    print_residual(info);
    print_relief(material, info);
    if (info->version >= 2) {
        printf("  %-14s%s\n", "blend", blend_names[info->blend]);
    }
    printf("  %-14sradiance %g, shadow %g, gain %g, centre %g\n", "scales", (double)info->radiance_scale,
           (double)info->shadow_scale, (double)info->gain_scale, (double)info->centre_scale);
    printf("  %-14sfile %llu, gpu %zu (%.2f%% of %.0f 8-bit samples saved), tables %zu\n", "bytes",
           (unsigned long long)file_bytes, info->gpu_bytes, 100 * (1 - (double)info->gpu_bytes / samples),
           samples, info->table_bytes);
    if (*info->method) {
        print_wrapped("method", info->method);
    }
    if (*info->options) {
        print_wrapped("options", info->options);
    }
    if (*info->source) {
        print_wrapped("source", info->source);
    }
    print_effects(material, info);
    print_between(material);
    print_levels(material, info);
    print_textures(material, info);
}
