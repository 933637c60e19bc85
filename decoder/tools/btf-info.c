/* btf-info: what a material file holds: sizes, directions, effects and what each one buys.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/between.h"
#include "decoder/toolkit/cli.h"
#include "decoder/toolkit/json.h"
#include "decoder/toolkit/scene_option.h"
#include <math.h>
#include <openbtf/material.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static struct {
    bool json, plan;
    scene_option scene;
} options;

static const cli_option option_table[] = {
    {.name = "json", .type = CLI_FLAG, .value = &options.json, .help = "print JSON"},
    {.name = "plan",
     .arg = "SCENE",
     .type = CLI_CUSTOM,
     .value = &options.scene,
     .given = &options.plan,
     .parse = scene_option_parse,
     .help =
         "print how a scene is decoded, as the shader options of btf_plan_effects:\n" SCENE_OPTION_HELP},
    {.type = CLI_END},
};

static const cli_program program = {
    .name = "btf-info",
    .usage = "FILE [--json] [--plan SCENE]",
    .summary =
        "Shows what a material file (*.btf.exr) holds: its sizes, directions, effects, what each effect\n"
        "buys (measured by the encoder), bytes by texture and how it was made.",
    .details =
        "Bytes 'gpu' are those of all textures that a decoder uploads, of all levels of detail; direction\n"
        "tables and scales of the residual stand apart. The textures listed are those of level 0, with their\n"
        "bytes divided by the texels of the material.\n"
        "Factors, the residual of format version 2, come in units: as --components of btf-decode and\n"
        "btf-render, and plans, count them. A unit has four words, each of Y, C1 or C2, separated colour.\n"
        "Memory: the file once, then the textures.",
    .example = "btf-info bricks.btf.exr\nbtf-info bricks.btf.exr --plan views=0:30,lights=0:75,pixels=1.5",
    .options = option_table,
    .min_arguments = 1,
    .max_arguments = 1,
};

static const char *const layout_names[] = {"paper", "tight"};
static const char *const domain_names[] = {"linear", "sqrt"};
static const char *const colour_names[] = {"mono", "rgb", "none"};
static const char *const store_names[] = {"components", "factors"};
static const char *const blend_names[] = {"radiance", "roots"};
static const char *const point_store_names[] = {"separate", "packed", "lists"};

/* Bits of the codes of w and of u in each class of factors (FORMAT.md section 3). */
static const int class_bits[BTF_FACTOR_CLASSES][2] = {{8, 8}, {4, 8}, {4, 4}, {2, 4}, {2, 2}};

/* A class of factors, counted. */
typedef struct class_counts {
    uint32_t units, words[3]; /* of Y, C1, C2 */
    uint32_t components;
} class_counts;

static class_counts count_class(const btf_material_info *info, int c) {
    const uint32_t *n = info->factor_classes[c];
    return (class_counts){.units = n[0],
                          .words = {4 * n[0] - n[1] - n[2], n[1], n[2]},
                          .components = 4 * n[0] * (32 / (uint32_t)class_bits[c][0])};
}

static const char *format_name(btf_format format) {
    static const char *const names[] = {
        [BTF_FORMAT_NONE] = "none",         [BTF_FORMAT_R8UI] = "R8UI",
        [BTF_FORMAT_RG8UI] = "RG8UI",       [BTF_FORMAT_RGBA8UI] = "RGBA8UI",
        [BTF_FORMAT_RGBA8I] = "RGBA8I",     [BTF_FORMAT_RGBA16UI] = "RGBA16UI",
        [BTF_FORMAT_RGBA16F] = "RGBA16F",   [BTF_FORMAT_RGBA32F] = "RGBA32F",
        [BTF_FORMAT_RGBA32UI] = "RGBA32UI",
    };
    return names[format];
}

/* Directions of one polar angle. */
typedef struct ring {
    double theta;
    int count;
} ring;

/* Groups directions whose theta differs by less than 0.05 degrees; returns the number of rings. */
static int find_rings(const btf_directions *d, ring rings[BTF_MAX_DIRECTIONS]) {
    int count = 0;
    for (uint32_t i = 0; i < d->count; i++) {
        const float *v = d->xyz + 3 * (size_t)i;
        double theta =
            atan2(hypot((double)v[0], (double)v[1]), (double)v[2]) * (180 / 3.14159265358979323846);
        int r = 0;
        while (r < count && fabs(rings[r].theta - theta) >= 0.05)
            r++;
        if (r == count)
            rings[count++] = (ring){round(theta * 100) / 100, 0};
        rings[r].count++;
    }
    return count;
}

/* The row that decodes exactly these effects; NULL when the encoder did not measure it. */
static const btf_material_error *find_error(const btf_material_error *errors, size_t count,
                                            uint32_t effects) {
    for (size_t i = 0; i < count; i++)
        if (errors[i].effects == effects)
            return &errors[i];
    return NULL;
}

/* The gain of an effect: the row with it less the row without, the richest such pair. NULL pair when none.
 */
static bool find_gain(const btf_material_error *errors, size_t count, uint32_t effect,
                      const btf_material_error **out_with, const btf_material_error **out_without) {
    bool found = false;
    for (size_t i = 0; i < count; i++) {
        const btf_material_error *without = find_error(errors, count, errors[i].effects & ~effect);
        if (!(errors[i].effects & effect) || !without)
            continue;
        if (!found || __builtin_popcount(errors[i].effects) > __builtin_popcount((*out_with)->effects)) {
            *out_with = &errors[i];
            *out_without = without;
            found = true;
        }
    }
    return found;
}

enum { LABEL = 16, LINE = 100, MOST_RINGS = 16 };

/* Prints a text of a file: control characters, which a terminal would obey, as \\xNN. Returns its
 * columns. */
static int print_safe(const char *text, int length) {
    int columns = 0;
    for (const char *c = text; c < text + length; c++)
        columns += (unsigned char)*c < ' ' || *c == 0x7f ? printf("\\x%02x", (unsigned)(unsigned char)*c)
                                                       : printf("%c", *c);
    return columns;
}

/* Prints a label and words, wrapped at LINE columns where they have blanks. */
static void print_wrapped(const char *label, const char *words) {
    int column = printf("  %-14s", label);
    while (*words) {
        const int length = (int)strcspn(words, " ");
        if (column > LABEL && column + 1 + length > LINE)
            column = printf("\n%*s", LABEL, "") - 1;
        else if (column > LABEL)
            column += printf(" ");
        column += print_safe(words, length);
        words += length;
        words += strspn(words, " ");
    }
    printf("\n");
}

/* Textures that relief alone reads; gloss reads none of its own. */
static size_t between_bytes(const btf_material *material, uint32_t effect) {
    return effect == BTF_EFFECT_RELIEF ? btf_material_texture(material, BTF_TEXTURE_HEIGHTS).size : 0;
}

static void print_rings(const char *name, const btf_directions *d) {
    ring rings[BTF_MAX_DIRECTIONS];
    char text[MOST_RINGS * 40 + 160];
    const int count = find_rings(d, rings);
    int length = snprintf(text, sizeof text, "%u:", (unsigned)d->count);
    for (int i = 0; i < count && count <= MOST_RINGS; i++)
        length += snprintf(text + length, sizeof text - (size_t)length, " %g\u00B0 x %d%s", rings[i].theta,
                           rings[i].count, i + 1 < count ? "," : "");
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

/* An effect that changes nothing at the samples, where the other errors are measured. */
static void print_between_gain(const btf_material *material, uint32_t effect) {
    char word[48];
    double gain[2];
    printf("  %-14sbetween the samples only", cli_effects_text(effect, word));
    if (between_gain(material, effect, gain))
        printf(": %+.2f dB linear, %+.2f dB sRGB where views%s are left out", gain[0], gain[1],
               effect == BTF_EFFECT_GLOSS ? " and lights" : "");
    printf(", for %zu bytes\n", between_bytes(material, effect));
}

static void print_effects(const btf_material *material, const btf_material_info *info) {
    char words[48];
    size_t count;
    const btf_material_error *errors = btf_material_errors(material, &count), *with, *without;
    printf("\nEffects: %s\n", cli_effects_text(info->effects, words));
    for (uint32_t bit = 1; bit < BTF_EFFECT_ALL; bit <<= 1)
        if (info->effects & bit & BETWEEN_EFFECTS)
            print_between_gain(material, bit);
        else if (info->effects & bit && find_gain(errors, count, bit, &with, &without))
            printf("  %-14s%+.2f dB linear, %+.2f dB sRGB for %.0f bytes\n", cli_effects_text(bit, words),
                   (double)(with->psnr_linear - without->psnr_linear),
                   (double)(with->psnr_srgb - without->psnr_srgb),
                   (double)(with->gpu_bytes - without->gpu_bytes));
    if (count)
        printf("Measured by the encoder (PSNR in dB, linear / sRGB):\n");
    for (size_t i = 0; i < count; i++)
        printf("  %6.2f / %6.2f  %9.0f bytes  %s\n", (double)errors[i].psnr_linear,
               (double)errors[i].psnr_srgb, (double)errors[i].gpu_bytes,
               cli_effects_text(errors[i].effects, words));
}

static const char *const left_out_names[] = {[1] = "view",           [2] = "light",          [3] = "both",
                                             [5] = "view, no relief", [7] = "both, no relief", [9] = "view, no gloss",
                                             [11] = "both, no gloss"};
static const char *const left_out_keys[] = {[1] = "view",
                                            [2] = "light",
                                            [3] = "both",
                                            [5] = "view_without_relief",
                                            [7] = "both_without_relief",
                                            [9] = "view_without_gloss",
                                            [11] = "both_without_gloss"};

static double decibels(float mse) {
    return mse > 1e-10f ? -10 * log10((double)mse) : 100;
}

static void print_between(const btf_material *material) {
    const btf_between_errors e = btf_material_between_errors(material);
    if (e.row_count == 0)
        return;
    printf("\nBetween the samples, estimated by leaving samples out, at double the gap (which overstates the\n"
           "error; PSNR in dB, linear / sRGB):\n  %-16s%14s%22s\n",
           "left out", "material", "data, interpolated");
    for (uint32_t i = 0; i < e.row_count; i++) {
        const float *row = e.rows + (size_t)i * e.row_stride;
        printf("  %-16s%7.2f / %6.2f%13.2f / %6.2f\n", left_out_names[(int)row[0]], decibels(row[1]),
               decibels(row[2]), decibels(row[3]), decibels(row[4]));
    }
}

/* The error measured of a level; NULL when none was. */
static const btf_level_error *find_level_error(const btf_material *material, uint32_t level) {
    size_t count;
    const btf_level_error *errors = btf_material_level_errors(material, &count);
    for (size_t i = 0; i < count; i++)
        if (errors[i].level == level)
            return &errors[i];
    return NULL;
}

static void print_levels(const btf_material *material, const btf_material_info *info) {
    if (info->levels < 2)
        return;
    printf("\nLevels of detail (PSNR in dB against the area-filtered original, linear / sRGB):\n");
    for (uint32_t i = 0; i < info->levels; i++) {
        const btf_level_error *error = find_level_error(material, i);
        char size[32];
        snprintf(size, sizeof size, "%u x %u", (unsigned)btf_level_size(info->width, i),
                 (unsigned)btf_level_size(info->height, i));
        printf("  %-3u%-16s%12zu bytes", (unsigned)i, size, btf_level_bytes(info, i));
        if (error)
            printf("  %6.2f / %6.2f", (double)error->psnr_linear, (double)error->psnr_srgb);
        printf("\n");
    }
}

/* The textures that the bytes called gpu leave out. */
static bool is_table(btf_texture_id id) {
    return id == BTF_TEXTURE_VIEW_TABLE || id == BTF_TEXTURE_LIGHT_TABLE ||
           id == BTF_TEXTURE_RESIDUAL_SCALES || id == BTF_TEXTURE_FACTOR_SCALES ||
           id == BTF_TEXTURE_FACTOR_VIEWS || id == BTF_TEXTURE_VIEW_VECTORS;
}

static void print_textures(const btf_material *material, const btf_material_info *info) {
    printf("\nTextures:\n");
    for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
        btf_texture t = btf_material_texture(material, (btf_texture_id)id);
        if (t.format == BTF_FORMAT_NONE)
            continue;
        char size[48];
        if (t.is_array)
            snprintf(size, sizeof size, "%u x %u x %u", (unsigned)t.width, (unsigned)t.height,
                     (unsigned)t.layers);
        else
            snprintf(size, sizeof size, "%u x %u", (unsigned)t.width, (unsigned)t.height);
        printf("  %-20s%-9s%-20s%12zu bytes", btf_texture_name((btf_texture_id)id), format_name(t.format),
               size, t.size);
        if (is_table((btf_texture_id)id))
            printf("  (table)\n");
        else
            printf("%10.2f a texel\n", (double)t.size / ((double)info->width * info->height));
    }
}

static void print_points(const btf_material_info *info) {
    if (info->point_store == BTF_POINTS_SEPARATE)
        return;
    printf("  %-14s", "points");
    if (info->point_store == BTF_POINTS_LISTS)
        printf("lists of %u a texel", (unsigned)info->point_entries);
    else
        printf("packed");
    printf(": shifts within -32..31, gain %g + %g * 0..15\n", (double)info->gain_base, (double)info->gain_step);
}

/* Heights of a relief in texels of level 0, and how many views it acts on. */
typedef struct relief_range {
    double low, high;
    uint32_t views;
} relief_range;

static relief_range find_relief(const btf_material *material, const btf_material_info *info) {
    const btf_texture t = btf_material_texture(material, BTF_TEXTURE_HEIGHTS);
    const float *vectors = btf_material_texture(material, BTF_TEXTURE_VIEW_VECTORS).data;
    int least = t.size ? 255 : 0, most = 0;
    for (size_t i = 0; i < t.size; i++) {
        const int code = ((const uint8_t *)t.data)[i];
        least = code < least ? code : least;
        most = code > most ? code : most;
    }
    const double texel = 256.0 * (1u << info->relief_level);
    relief_range range = {.low = (info->relief_base + (least * info->relief_step >> 8)) / texel,
                          .high = (info->relief_base + (most * info->relief_step >> 8)) / texel};
    for (uint32_t v = 0; v < info->n_views; v++)
        range.views += vectors[4 * (size_t)v + 3] != 0;
    return range;
}

static void print_relief(const btf_material *material, const btf_material_info *info) {
    if (info->effects & BTF_EFFECT_RELIEF) {
        const relief_range r = find_relief(material, info);
        printf("  %-14s", "relief");
        if (info->relief_step > 0)
            printf("heights %.3g to %.3g texels, %u step%s", r.low, r.high, (unsigned)info->relief_steps,
                   info->relief_steps == 1 ? "" : "s");
        else
            printf("height %.3g texels everywhere", r.low);
        printf(", on %u of %u views\n", (unsigned)r.views, (unsigned)info->n_views);
    }
    if (info->effects & BTF_EFFECT_GLOSS)
        printf("  %-14skeeps %g of the half vector\n", "gloss", info->gloss_share / 4.0);
}

static void print_residual(const btf_material_info *info) {
    if (info->store == BTF_STORE_COMPONENTS) {
        if (info->components)
            printf("  %-14s%u components\n", "residual", (unsigned)info->components);
        return;
    }
    uint32_t components = 0;
    for (int c = 0; c < BTF_FACTOR_CLASSES; c++)
        components += count_class(info, c).components;
    printf("  %-14s%u unit%s of factors, %u components\n", "residual", (unsigned)info->components,
           info->components == 1 ? "" : "s", (unsigned)components);
    for (int c = 0; c < BTF_FACTOR_CLASSES; c++) {
        const class_counts n = count_class(info, c);
        if (n.units)
            printf("  %-14s%d bits of w, %d of u: %u unit%s, words: Y %u, C1 %u, C2 %u; %u components\n", "",
                   class_bits[c][0], class_bits[c][1], (unsigned)n.units, n.units == 1 ? "" : "s",
                   (unsigned)n.words[0], (unsigned)n.words[1], (unsigned)n.words[2], (unsigned)n.components);
    }
    const double horizon = 90 - asin(1 / (double)info->horizon_scale) * (180 / 3.14159265358979323846);
    printf("  %-14sfactors fade from theta %.4g\u00B0 of the light to 90\u00B0\n", "horizon", horizon);
}

static void print_text(const char *path, uint64_t file_bytes, const btf_material *material,
                       const btf_material_info *info) {
    const btf_directions views = btf_material_views(material), lights = btf_material_lights(material);
    double samples = 3.0 * info->width * info->height * info->n_views * info->n_lights;
    print_safe(path, (int)strlen(path));
    printf(": OpenBTF material, format version %u\n", (unsigned)info->version);
    printf("  %-14s%u x %u texels\n", "size", (unsigned)info->width, (unsigned)info->height);
    if (info->levels > 1)
        printf("  %-14s%u, down to %u x %u texels\n", "levels", (unsigned)info->levels,
               (unsigned)btf_level_size(info->width, info->levels - 1),
               (unsigned)btf_level_size(info->height, info->levels - 1));
    print_rings("views", &views);
    print_rings("lights", &lights);
    printf("  %-14s%s, domain %s\n", "layout", layout_names[info->layout], domain_names[info->domain]);
    if (info->layout == BTF_LAYOUT_PAPER)
        printf("  %-14s%u x %u\n", "atlas", (unsigned)info->atlas_width, (unsigned)info->atlas_height);
    printf("  %-14s%u lobe%s, colour %s%s\n", "model", (unsigned)info->lobes, info->lobes == 1 ? "" : "s",
           colour_names[info->colour],
           info->colour == BTF_COLOUR_NONE ? ""
           : info->half_float              ? ", half"
                                           : ", float");
    if (info->centres)
        printf("  %-14s%u\n", "centres", (unsigned)info->centres);
    print_points(info);
    print_residual(info);
    print_relief(material, info);
    if (info->version >= 2)
        printf("  %-14s%s\n", "blend", blend_names[info->blend]);
    printf("  %-14sradiance %g, shadow %g, gain %g, centre %g\n", "scales", (double)info->radiance_scale,
           (double)info->shadow_scale, (double)info->gain_scale, (double)info->centre_scale);
    printf("  %-14sfile %llu, gpu %zu (%.2f%% of %.0f 8-bit samples saved), tables %zu\n", "bytes",
           (unsigned long long)file_bytes, info->gpu_bytes, 100 * (1 - (double)info->gpu_bytes / samples),
           samples, info->table_bytes);
    if (*info->method)
        print_wrapped("method", info->method);
    if (*info->options)
        print_wrapped("options", info->options);
    if (*info->source)
        print_wrapped("source", info->source);
    print_effects(material, info);
    print_between(material);
    print_levels(material, info);
    print_textures(material, info);
}

/* Writes the object to stdout and frees it. */
static btf_result put_json(json *j) {
    const char *text = json_text(j);
    if (text)
        fputs(text, stdout);
    json_free(j);
    return text ? BTF_OK : cli_error(&program, BTF_ERROR_MEMORY, "out of memory");
}

static void json_directions(json *j, const char *key, const btf_directions *d) {
    ring rings[BTF_MAX_DIRECTIONS];
    int count = find_rings(d, rings);
    json_object(j, key);
    json_integer(j, "count", d->count);
    json_array(j, "rings");
    for (int i = 0; i < count; i++) {
        json_object(j, NULL);
        json_number(j, "theta", rings[i].theta);
        json_integer(j, "count", rings[i].count);
        json_end(j);
    }
    json_end(j);
    json_integer(j, "triangles", d->triangle_count);
    json_integer(j, "grid", d->grid);
    json_array(j, "xyz");
    for (uint32_t i = 0; i < 3 * d->count; i++)
        json_float(j, NULL, d->xyz[i]);
    json_end(j);
    json_end(j);
}

static void json_effect_list(json *j, const char *key, uint32_t effects) {
    char word[48];
    json_array(j, key);
    for (uint32_t bit = 1; bit < BTF_EFFECT_ALL; bit <<= 1)
        if (effects & bit)
            json_string(j, NULL, cli_effects_text(bit, word));
    json_end(j);
}

static void json_effects(json *j, const btf_material *material, const btf_material_info *info) {
    char word[48];
    size_t count;
    const btf_material_error *errors = btf_material_errors(material, &count), *with, *without;
    json_effect_list(j, "effects", info->effects);
    json_object(j, "buys");
    for (uint32_t bit = 1; bit < BTF_EFFECT_ALL; bit <<= 1)
        if (info->effects & bit & BETWEEN_EFFECTS) {
            double gain[2];
            json_object(j, cli_effects_text(bit, word));
            json_bool(j, "between_samples", true);
            if (between_gain(material, bit, gain)) {
                json_number(j, "linear", gain[0]);
                json_number(j, "srgb", gain[1]);
            }
            json_number(j, "bytes", (double)between_bytes(material, bit));
            json_end(j);
        } else if (info->effects & bit && find_gain(errors, count, bit, &with, &without)) {
            json_object(j, cli_effects_text(bit, word));
            json_number(j, "linear", (double)with->psnr_linear - (double)without->psnr_linear);
            json_number(j, "srgb", (double)with->psnr_srgb - (double)without->psnr_srgb);
            json_number(j, "bytes", (double)with->gpu_bytes - (double)without->gpu_bytes);
            json_end(j);
        }
    json_end(j);
    json_array(j, "errors");
    for (size_t i = 0; i < count; i++) {
        json_object(j, NULL);
        json_effect_list(j, "effects", errors[i].effects);
        json_float(j, "linear", errors[i].psnr_linear);
        json_float(j, "srgb", errors[i].psnr_srgb);
        json_float(j, "gpu", errors[i].gpu_bytes);
        json_end(j);
    }
    json_end(j);
}

static void json_between(json *j, const btf_material *material) {
    const btf_between_errors e = btf_material_between_errors(material);
    json_object(j, "between");
    for (uint32_t i = 0; i < e.row_count; i++) {
        const float *row = e.rows + (size_t)i * e.row_stride;
        json_object(j, left_out_keys[(int)row[0]]);
        json_number(j, "linear", decibels(row[1]));
        json_number(j, "srgb", decibels(row[2]));
        json_number(j, "data_linear", decibels(row[3]));
        json_number(j, "data_srgb", decibels(row[4]));
        json_end(j);
    }
    json_end(j);
}

static void json_levels(json *j, const btf_material *material, const btf_material_info *info) {
    json_array(j, "levels");
    for (uint32_t i = 0; i < info->levels; i++) {
        const btf_level_error *error = find_level_error(material, i);
        json_object(j, NULL);
        json_integer(j, "width", btf_level_size(info->width, i));
        json_integer(j, "height", btf_level_size(info->height, i));
        json_integer(j, "gpu", (int64_t)btf_level_bytes(info, i));
        if (error) {
            json_float(j, "linear", error->psnr_linear);
            json_float(j, "srgb", error->psnr_srgb);
        }
        json_end(j);
    }
    json_end(j);
}

static void json_textures(json *j, const btf_material *material, const btf_material_info *info) {
    json_object(j, "textures");
    for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
        btf_texture t = btf_material_texture(material, (btf_texture_id)id);
        if (t.format == BTF_FORMAT_NONE)
            continue;
        json_object(j, btf_texture_name((btf_texture_id)id));
        json_string(j, "format", format_name(t.format));
        json_integer(j, "width", t.width);
        json_integer(j, "height", t.height);
        json_integer(j, "layers", t.layers);
        json_bool(j, "array", t.is_array);
        json_integer(j, "bytes", (int64_t)t.size);
        json_bool(j, "table", is_table((btf_texture_id)id));
        json_number(j, "bytes_a_texel", (double)t.size / ((double)info->width * info->height));
        json_end(j);
    }
    json_end(j);
}

/* The classes of factors that have units. */
static void json_classes(json *j, const btf_material_info *info) {
    json_array(j, "classes");
    for (int c = 0; c < BTF_FACTOR_CLASSES; c++) {
        const class_counts n = count_class(info, c);
        if (n.units == 0)
            continue;
        json_object(j, NULL);
        json_integer(j, "w_bits", class_bits[c][0]);
        json_integer(j, "u_bits", class_bits[c][1]);
        json_integer(j, "units", n.units);
        json_integer(j, "components", n.components);
        json_object(j, "words");
        json_integer(j, "y", n.words[0]);
        json_integer(j, "c1", n.words[1]);
        json_integer(j, "c2", n.words[2]);
        json_end(j);
        json_end(j);
    }
    json_end(j);
}

static void json_relief(json *j, const btf_material *material, const btf_material_info *info) {
    if (info->effects & BTF_EFFECT_RELIEF) {
        const relief_range r = find_relief(material, info);
        json_object(j, "relief");
        json_number(j, "low", r.low);
        json_number(j, "high", r.high);
        json_integer(j, "base", info->relief_base);
        json_integer(j, "step", info->relief_step);
        json_integer(j, "steps", info->relief_steps);
        json_integer(j, "level", info->relief_level);
        json_integer(j, "views", r.views);
        json_end(j);
    }
    json_number(j, "gloss", info->gloss_share / 4.0);
}

static btf_result print_json(const char *path, uint64_t file_bytes, const btf_material *material,
                             const btf_material_info *info) {
    const btf_directions views = btf_material_views(material), lights = btf_material_lights(material);
    json j = {0};
    json_object(&j, NULL);
    json_string(&j, "file", path);
    json_integer(&j, "version", info->version);
    json_integer(&j, "width", info->width);
    json_integer(&j, "height", info->height);
    json_string(&j, "layout", layout_names[info->layout]);
    json_string(&j, "domain", domain_names[info->domain]);
    json_string(&j, "colour", colour_names[info->colour]);
    json_integer(&j, "lobes", info->lobes);
    json_bool(&j, "half_float", info->half_float);
    json_integer(&j, "centres", info->centres);
    json_integer(&j, "residual", info->components);
    json_string(&j, "store", store_names[info->store]);
    json_classes(&j, info);
    json_float(&j, "horizon_scale", info->horizon_scale);
    json_string(&j, "blend", blend_names[info->blend]);
    json_string(&j, "point_store", point_store_names[info->point_store]);
    json_integer(&j, "point_entries", info->point_entries);
    json_relief(&j, material, info);
    json_bool(&j, "preview", btf_material_preview(material) != NULL);
    if (info->layout == BTF_LAYOUT_PAPER) {
        json_integer(&j, "atlas_width", info->atlas_width);
        json_integer(&j, "atlas_height", info->atlas_height);
    }
    json_object(&j, "scales");
    json_float(&j, "radiance", info->radiance_scale);
    json_float(&j, "shadow", info->shadow_scale);
    json_float(&j, "gain", info->gain_scale);
    json_float(&j, "gain_base", info->gain_base);
    json_float(&j, "gain_step", info->gain_step);
    json_float(&j, "centre", info->centre_scale);
    json_end(&j);
    json_object(&j, "bytes");
    json_integer(&j, "file", (int64_t)file_bytes);
    json_integer(&j, "gpu", (int64_t)info->gpu_bytes);
    json_integer(&j, "tables", (int64_t)info->table_bytes);
    json_end(&j);
    json_effects(&j, material, info);
    json_between(&j, material);
    json_levels(&j, material, info);
    json_textures(&j, material, info);
    json_directions(&j, "views", &views);
    json_directions(&j, "lights", &lights);
    json_string(&j, "method", info->method);
    json_string(&j, "options", info->options);
    json_string(&j, "source", info->source);
    json_end(&j);
    return put_json(&j);
}

static void json_range(json *j, const char *key, const btf_range *r) {
    json_object(j, key);
    json_bool(j, "fixed", r->fixed);
    json_array(j, r->fixed ? "direction" : "theta");
    for (int i = 0; i < (r->fixed ? 3 : 2); i++)
        json_float(j, NULL, r->fixed ? r->direction[i] : r->theta[i]);
    json_end(j);
    if (!r->fixed) {
        json_array(j, "phi");
        json_float(j, NULL, r->phi[0]);
        json_float(j, NULL, r->phi[1]);
        json_end(j);
    }
    json_end(j);
}

static btf_result print_json_plan(const char *path, const btf_plan *plan) {
    json j = {0};
    json_object(&j, NULL);
    json_string(&j, "file", path);
    json_range(&j, "view", &plan->scene.view);
    json_range(&j, "light", &plan->scene.light);
    json_float(&j, "tolerance", options.scene.tolerance);
    json_effect_list(&j, "effects", plan->effects);
    json_integer(&j, "components", plan->components);
    json_string(&j, "store", store_names[plan->textures >> BTF_TEXTURE_FACTOR_DIRECTIONS & 1]);
    json_bool(&j, "nearest", plan->shader.interpolation == BTF_INTERPOLATION_NEAREST);
    json_bool(&j, "bilinear", plan->shader.filter == BTF_FILTER_BILINEAR);
    json_integer(&j, "level", plan->level);
    json_array(&j, "textures");
    for (int id = 0; id < BTF_TEXTURE_COUNT; id++)
        if (plan->textures >> id & 1)
            json_string(&j, NULL, btf_texture_name((btf_texture_id)id));
    json_end(&j);
    json_integer(&j, "views", plan->views);
    json_integer(&j, "lights", plan->lights);
    json_integer(&j, "gpu", (int64_t)plan->gpu_bytes);
    json_integer(&j, "full_gpu", (int64_t)plan->full_gpu_bytes);
    json_float(&j, "cost", plan->cost);
    json_float(&j, "full_cost", plan->full_cost);
    json_bool(&j, "measured", plan->measured);
    json_float(&j, "linear", plan->psnr_linear);
    json_float(&j, "srgb", plan->psnr_srgb);
    json_float(&j, "full_linear", plan->full_psnr_linear);
    json_float(&j, "full_srgb", plan->full_psnr_srgb);
    json_float(&j, "between_linear", plan->between_psnr_linear);
    json_float(&j, "between_srgb", plan->between_psnr_srgb);
    json_float(&j, "full_between_linear", plan->full_between_psnr_linear);
    json_float(&j, "full_between_srgb", plan->full_between_psnr_srgb);
    json_end(&j);
    return put_json(&j);
}

static btf_result print_plan(const char *path, const btf_material *material) {
    btf_plan plan;
    btf_result result = btf_plan_effects(material, &options.scene.scene, options.scene.tolerance, &plan);
    if (result)
        return cli_error(&program, result, "--plan: no such scene");
    if (options.json)
        return print_json_plan(path, &plan);
    scene_plan_print(stdout, "", material, &plan);
    printf("textures");
    for (int id = 0; id < BTF_TEXTURE_COUNT; id++)
        if (plan.textures >> id & 1)
            printf(" %s", btf_texture_name((btf_texture_id)id));
    printf("\n");
    return BTF_OK;
}

static btf_result run(const char *path) {
    btf_log log = cli_log(&program, false);
    btf_material *material = NULL;
    btf_result result = btf_material_open(path, &log, &material);
    if (result)
        return result;
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    struct stat status;
    uint64_t file_bytes = stat(path, &status) == 0 && status.st_size > 0 ? (uint64_t)status.st_size : 0;
    if (options.plan)
        result = print_plan(path, material);
    else if (options.json)
        result = print_json(path, file_bytes, material, &info);
    else
        print_text(path, file_bytes, material, &info);
    btf_material_close(&material);
    return result;
}

int main(int argc, char **argv) {
    cli_arguments arguments;
    int exit_code;
    if (!cli_parse(&program, argc, argv, &arguments, &exit_code))
        return exit_code;
    return cli_finish(&program, run(arguments.values[0]));
}
