/* Writes the small seeds of the fuzz targets: make_corpus FOLDER. Inputs that the fuzzers found were added by hand.
 *
 * SPDX-License-Identifier: MIT
 */
#include "step_data.h"
#include "tests/support/bonn_files.h"
#include "tests/support/exr_bytes.h"
#include "tests/support/exr_edit.h"
#include "tests/support/factor_material.h"

#include "decoder/toolkit/exr_image.h"
#include "decoder/toolkit/jpeg_image.h"
#include "decoder/toolkit/png_image.h"
#include "encoder/data/checkpoint.h"
#include "encoder/job/relief_step.h"
#include "encoder/paper/steps.h"

#include <archive.h>
#include <archive_entry.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const char *folder;

static void must(bool good, const char *what) {
    if (!good) {
        fprintf(stderr, "make_corpus: %s\n", what);
        exit(1);
    }
}

static const char *path_of(const char *target, const char *name) {
    static char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, target);
    mkdir(path, 0777);
    snprintf(path, sizeof path, "%s/%s/%s", folder, target, name);
    return path;
}

static void write_seed(const char *target, const char *name, const void *data, size_t size) {
    FILE *file = fopen(path_of(target, name), "wb");
    must(file && fwrite(data, 1, size, file) == size && fclose(file) == 0, "cannot write");
}

static void write_text(const char *target, const char *name, const char *text) {
    write_seed(target, name, text, strlen(text));
}

/* The file of a material, as saved and with its pixels uncompressed. */
static void write_material_file(const char *name, const btf_material_desc *desc) {
    btf_material *material;
    void *data, *plain;
    size_t size, plain_size;
    must(btf_material_create(desc, NULL, &material) == BTF_OK, "a material cannot be made");
    must(btf_material_save_memory(material, NULL, &data, &size) == BTF_OK, "a material cannot be saved");
    char file[64];
    snprintf(file, sizeof file, "%s.exr", name);
    write_seed("material", file, data, size);
    edit_file *edit = edit_load(data, size);
    for (int p = 0; p < edit->part_count; p++) {
        edit->parts[p].compression = EXR_COMPRESSION_NONE;
    }
    edit_save(edit, &plain, &plain_size);
    snprintf(file, sizeof file, "%s-plain.exr", name);
    write_seed("material", file, plain, plain_size);
    free(plain);
    edit_free(edit);
    btf_free(data);
    btf_material_close(&material);
}

/* A random material of 2 x 2 texels. */
static void write_material(const char *name, btf_layout layout, btf_colour colour, uint32_t effects,
                           bool half) {
    random_state r = {7};
    btf_material_desc desc = random_material_desc(2, 2, 3, 2, layout, effects);
    desc.info.colour = colour;
    desc.info.half_float = half;
    desc.info.lobes = colour == BTF_COLOUR_NONE ? 0 : 1;
    desc.info.levels = layout == BTF_LAYOUT_TIGHT ? 2 : 1;
    const btf_level_error level_errors[2] = {{0, 30, 28, 100}, {1, 31, 29, 30}};
    desc.level_errors = level_errors;
    desc.level_error_count = desc.info.levels;
    desc.info.components = effects & BTF_EFFECT_RESIDUAL ? 2 : 0;
    desc.info.centres = effects & BTF_EFFECT_HIDDEN ? 3 : 0;
    random_material_fill(&r, &desc);
    write_material_file(name, &desc);
    random_material_free(&desc);
}

/* A material of version 2. With `factors` it has a unit of each class, a preview, and packed points where it can, in
 * lists of `entries` unless that is 0; else it blends roots and stores nothing new. Relief acts on two of three views,
 * in a material cut from a finer one, and ends before level relief_end of 2. */
static void write_version_2(const char *name, btf_layout layout, uint32_t effects, bool factors,
                            uint32_t entries, uint32_t relief_end) {
    static const uint32_t classes[BTF_FACTOR_CLASSES][3] = {{1, 1, 1}, {1, 2, 0}, {1}, {1, 0, 1}, {1}};
    uint16_t preview[2 * 2 * 4] = {0x3C00, 0x3800, 0x3400, 0, 0x3000};
    random_state r = {8};
    btf_material_desc desc = factors ? factor_material_desc(2, 2, 3, 2, layout, effects, classes)
                                     : random_material_desc(2, 2, 3, 2, layout, effects);
    desc.info.lobes = 1;
    desc.info.centres = effects & BTF_EFFECT_HIDDEN ? 3 : 0;
    desc.info.levels = layout == BTF_LAYOUT_TIGHT ? 2 : 1;
    desc.info.domain = BTF_DOMAIN_SQRT;
    desc.info.blend = factors && effects ? BTF_BLEND_RADIANCE : BTF_BLEND_ROOTS;
    desc.preview = preview;
    const uint8_t acts[3] = {1, 0, 1};
    if (effects & BTF_EFFECT_RELIEF) {
        desc.relief_views = acts;
        desc.info.relief_level = 1;
        desc.info.relief_end = relief_end;
    }
    entries ? factor_material_list_points(&desc, entries) : factor_material_pack_points(&desc);
    factor_material_fill(&r, &desc);
    write_material_file(name, &desc);
    desc.relief_views = NULL;
    random_material_free(&desc);
}

/* A material with all tables of errors: of the variants of decoding, their differences to decoding everything, and
 * between the samples; the first two have two bands of views. */
static void write_tables(void) {
    enum { BOTH = BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL };
    /* clang-format off */
    static const float errors[] = {2, 1, 0, 30, 75, 0, 75,
                                   BOTH, 2, 0, 0, 48, 0.001f, 0.002f, 0.002f, 0.004f,
                                   BTF_EFFECT_RESIDUAL, 1, 1, 1, 24, 0.003f, 0.004f, 0.005f, 0.006f};
    static const float differences[] = {2, 1, 0, 30, 75, 0, 75,
                                        BOTH, 2, 0, 0, 48, 0, 0, 0, 0,
                                        BTF_EFFECT_RESIDUAL, 1, 1, 1, 24, 0.01f, 0.02f, 0.03f, 0.04f};
    static const float between[] = {1, 1, 0, 75, 0, 75, 1, 0.1f, 0.2f, 0.3f, 0.4f, 0.01f, 0.02f};
    /* clang-format on */
    random_state r = {9};
    btf_material_desc desc = random_material_desc(2, 2, 3, 2, BTF_LAYOUT_TIGHT, BOTH);
    desc.info.colour = BTF_COLOUR_NONE;
    desc.info.lobes = 0;
    desc.info.components = 2;
    desc.info.levels = 2;
    desc.effect_errors = errors;
    desc.effect_error_count = sizeof errors / sizeof *errors;
    desc.effect_differences = differences;
    desc.effect_difference_count = sizeof differences / sizeof *differences;
    desc.between_errors = between;
    desc.between_error_count = sizeof between / sizeof *between;
    random_material_fill(&r, &desc);
    write_material_file("tables", &desc);
    random_material_free(&desc);
}

/* A material with errors between the samples of two levels, which a file keeps in two attributes. */
static void write_level_tables(void) {
    /* clang-format off */
    static const float between[] = {1, 1, 0, 75, 0, 75,
                                    3, 0.1f, 0.2f, 0.3f, 0.4f, 0.01f, 0.02f,
                                    16 + 3, 0.1f, 0.2f, 0.3f, 0.4f, 0.03f, 0.04f,
                                    16 + 11, 0.1f, 0.2f, 0.3f, 0.4f, -1, -1};
    /* clang-format on */
    random_state r = {9};
    btf_material_desc desc =
        random_material_desc(2, 2, 3, 2, BTF_LAYOUT_TIGHT, BTF_EFFECT_SHADOW | BTF_EFFECT_GLOSS);
    desc.info.lobes = 1;
    desc.info.levels = 2;
    desc.between_errors = between;
    desc.between_error_count = sizeof between / sizeof *between;
    random_material_fill(&r, &desc);
    write_material_file("tables-levels", &desc);
    random_material_free(&desc);
}

static void write_materials(void) {
    const uint32_t all = BTF_EFFECT_VERSION_1,
                   paper = BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN;
    write_material("paper", BTF_LAYOUT_PAPER, BTF_COLOUR_MONO, paper, false);
    write_material("tight", BTF_LAYOUT_TIGHT, BTF_COLOUR_RGB, all, true);
    write_material("residual", BTF_LAYOUT_TIGHT, BTF_COLOUR_NONE, BTF_EFFECT_RESIDUAL | BTF_EFFECT_SHIFT,
                   false);
    write_tables();
    write_level_tables();
    write_version_2("factors", BTF_LAYOUT_TIGHT, 0, true, 0, 0);
    write_version_2("factors-all", BTF_LAYOUT_PAPER, all, true, 0, 0);
    write_version_2("points", BTF_LAYOUT_TIGHT, BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN, true, 0, 0);
    write_version_2("lists", BTF_LAYOUT_TIGHT, BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN, true, 3, 0);
    write_version_2("relief", BTF_LAYOUT_TIGHT,
                    BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS | BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN, true, 0, 0);
    write_version_2("relief-end", BTF_LAYOUT_TIGHT, BTF_EFFECT_RELIEF, true, 0, 1);
    write_version_2("gloss", BTF_LAYOUT_TIGHT, BTF_EFFECT_SHADOW | BTF_EFFECT_GLOSS, false, 0, 0);
    write_version_2("roots", BTF_LAYOUT_TIGHT, BTF_EFFECT_SHADOW | BTF_EFFECT_RESIDUAL, false, 0, 0);
}

static float slope(int c, int x, int y) {
    return (float)(c + x + 2 * y) * 0.125f;
}

/* Images of luminance and chroma in halves: with and without alpha, with chroma in every second pixel. */
static void write_chroma(void) {
    static const bytes_channel all[4] = {{"A", BYTES_HALF, 1, 1},
                                         {"BY", BYTES_HALF, 2, 2},
                                         {"RY", BYTES_HALF, 2, 2},
                                         {"Y", BYTES_HALF, 1, 1}};
    for (int alpha = 0; alpha < 2; alpha++) {
        bytes_part p = {.width = 6, .height = 4, .value = slope, .channel_count = 3 + alpha};
        memcpy(p.channels, all + 1 - alpha, (size_t)p.channel_count * sizeof *all);
        size_t size;
        void *data = exr_bytes(&p, 1, &size);
        write_seed("exr", alpha ? "chroma-alpha.exr" : "chroma.exr", data, size);
        write_seed("environment", alpha ? "chroma-alpha.exr" : "chroma.exr", data, size);
        free(data);
    }
}

static void write_exr(const char *name, const bytes_part *parts, int count) {
    size_t size;
    void *data = exr_bytes(parts, count, &size);
    write_seed("exr", name, data, size);
    free(data);
}

/* Images with layers, parts, a spectrum, primaries and other meaningful attributes. */
static void write_meanings(void) {
    static const float wide[8] = {0.68f, 0.32f, 0.265f, 0.69f, 0.15f, 0.06f, 0.3127f, 0.329f};
    const bytes_channel b = {"B", BYTES_HALF, 1, 1}, g = {"G", BYTES_HALF, 1, 1},
                        r = {"R", BYTES_HALF, 1, 1};
    bytes_part parts[2] = {{.name = "depth",
                            .width = 3,
                            .height = 2,
                            .value = slope,
                            .channel_count = 1,
                            .channels = {{"Z", BYTES_FLOAT, 1, 1}}},
                           {.name = "beauty",
                            .width = 3,
                            .height = 2,
                            .value = slope,
                            .channel_count = 3,
                            .channels = {b, g, r}}};
    write_exr("parts.exr", parts, 2);
    const bytes_part layer = {
        .width = 3,
        .height = 2,
        .value = slope,
        .channel_count = 3,
        .aspect = 2,
        .channels = {{"a.b", BYTES_HALF, 1, 1}, {"a.g", BYTES_HALF, 1, 1}, {"a.r", 0, 1, 1}},
        .attribute_count = 1,
        .attributes = {{"chromaticities", "chromaticities", wide, sizeof wide}}};
    write_exr("layer.exr", &layer, 1);
    const bytes_part spectrum = {.width = 2,
                                 .height = 2,
                                 .value = slope,
                                 .channel_count = 4,
                                 .channels = {{"T.400,5nm", BYTES_HALF, 1, 1},
                                              {"T.500nm", BYTES_HALF, 1, 1},
                                              {"T.600nm", BYTES_HALF, 1, 1},
                                              {"T.700nm", BYTES_HALF, 1, 1}}};
    write_exr("spectrum.exr", &spectrum, 1);
    static const char columns[] =
        "#?RADIANCE\nEXPOSURE=0\nCOLORCORR=1 2 4\nPRIMARIES=.68 .32 .265 .69 .15 .06 .3127 .329\n"
        "GAMMA=2.2 \nPIXASPECT=2\n\n-X 2 +Y 1\nabc\200ABC\201";
    write_seed("hdr", "columns.hdr", columns, sizeof columns - 1);
}

static void write_images(void) {
    enum { W = 6, H = 5 };
    unsigned char rgb[W * H * 3];
    unsigned short deep[W * H * 3];
    float real[W * H * 3];
    const btf_log quiet = {0};
    for (int i = 0; i < W * H * 3; i++) {
        rgb[i] = (unsigned char)(i * 37);
        deep[i] = (unsigned short)(i * 1237);
        real[i] = (float)i * 0.125f;
    }
    must(jpeg_image_write(path_of("jpeg", "rgb.jpg"), W, H, rgb, 80, quiet) == BTF_OK, "JPEG");
    must(png_image_write8(path_of("png", "8.png"), W, H, rgb, quiet) == BTF_OK, "PNG");
    must(png_image_write16(path_of("png", "16.png"), W, H, deep, quiet) == BTF_OK, "PNG");
    must(exr_image_write(path_of("exr", "half.exr"), W, H, real, true, quiet) == BTF_OK, "EXR");
    must(exr_image_write(path_of("exr", "float.exr"), W, H, real, false, quiet) == BTF_OK, "EXR");
    static const char hdr[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n\n-Y 2 +X 8\n"
                              "\2\2\0\10\210\60\210\61\210\62\210\200"
                              "\2\2\0\10\10abcdefgh\210\61\10ABCDEFGH\210\201";
    static const char flat[] = "#?RGBE\r\n\n+Y 1 +X 3\nabc\200\1\1\1\2";
    write_seed("hdr", "runs.hdr", hdr, sizeof hdr - 1);
    write_seed("hdr", "flat.hdr", flat, sizeof flat - 1);
}

static void add_entry(struct archive *a, const char *name, const void *data, size_t size) {
    struct archive_entry *entry = archive_entry_new();
    archive_entry_set_pathname(entry, name);
    archive_entry_set_size(entry, (la_int64_t)size);
    archive_entry_set_filetype(entry, AE_IFREG);
    archive_entry_set_perm(entry, 0644);
    must(archive_write_header(a, entry) == ARCHIVE_OK, "archive");
    must(archive_write_data(a, data, size) == (la_ssize_t)size, "archive");
    archive_entry_free(entry);
}

static void write_archive(const char *name, int (*format)(struct archive *),
                          int (*filter)(struct archive *)) {
    struct archive *a = archive_write_new();
    must(a && format(a) == ARCHIVE_OK && (!filter || filter(a) == ARCHIVE_OK), "archive");
    archive_write_set_bytes_in_last_block(a, 1);
    must(archive_write_open_filename(a, path_of("archive", name)) == ARCHIVE_OK, "archive");
    add_entry(a, "tv0 pv0/tl0 pl0.png", "first", 5);
    add_entry(a, "../tv0 pv0/tl30 pl60.png", "second second second second", 27);
    add_entry(a, "readme.txt", "words", 5);
    must(archive_write_free(a) == ARCHIVE_OK, "archive");
}

static double direction(int view, int light, int channel, unsigned k) {
    return 0.1 * (view + 1) + 0.2 * light + 0.05 * channel - 0.1 * k;
}
static double texel(int x, int y, int channel, int view, unsigned k) {
    return 0.3 * x + 0.2 * y + 0.05 * channel + 0.01 * view - 0.1 * k;
}
static double average(int view, int light, int channel, int x, int y) {
    return 0.5 + 0.1 * view + 0.05 * light + 0.02 * channel + 0.01 * (x + y);
}
static double sample(int view, int light, int channel, int x, int y) {
    return average(view, light, channel, x, y);
}

static void write_bonn(const char *name, bonn_form form, const char *signature, unsigned compression) {
    static const double list[2][2] = {{0, 0}, {45, 90}};
    static const unsigned char mask[6] = {1, 0, 1, 1, 0, 1};
    /* clang-format off */
    const bonn_spec spec = {
        .form = form, .signature = signature, .meta_version = 4, .width = 3, .height = 2, .n_views = 2,
        .n_lights = 2, .views = list, .lights = list, .scalar = {2, 4, 8}, .components = {2, 1, 2},
        .compression = compression, .lines_per_chunk = 1, .mask = compression == 2 ? mask : NULL,
        .direction = direction, .texel = texel, .average = average, .sample = sample,
    };
    /* clang-format on */
    must(bonn_write(path_of("bonn", name), &spec), "a .btf cannot be written");
}

static void write_words(void) {
    write_text("names", "ubo", "UBO_IMPALLA256/tv030_pv060/00008 tl000 pl000 tv030 pv060.jpg");
    write_text("names", "folders", "/a/tv7.5-pl_-30/../TL=015 PL=359.999.EXR");
    write_text("names", "long",
               "tl12345678901e3pl0000000000000000000000000000000000000000000001tv.5pv5.tl1.jpeg");
    write_text("options", "all",
               "in\n-o\nout\n-q\n--number=12\n--choice\nmedium\n--size\n64x32\n--real=0.5e3\n--bytes=2."
               "5Gi\n--view\n30,-120\n"
               "--effects=shadow,gain\n--auto\nauto\n--transfer=gamma:2.2\n--colour\nxyz\n--crop\n1,2,3,"
               "4\n--\n-x");
    write_text("options", "help", "--help");
    write_text("options", "rings", "0:1,30:6:15,60:12\nubo\n200\ntiny");
    write_text("options", "scene",
               "--scene\nviews=0:30:-90:90,light=40:60,pixels=0.5,count=3,tolerance=1,interpolate\n"
               "--tolerance=0.05,0.2\n--scene=all\n--scene=view=0:0,lights=0:75");
    write_text("options", "wrong-scene",
               "--tolerance=0.05,\n--tolerance=nan\n--scene=views=30:20,\n--scene=light=90:0");
    write_text("options", "wrong", "--number=99999999999999999999\n--size=3x\n--crop=4294967297,0,1,1");
}

/* The bytes that checkpoint.c wrote of a step, without its header and hash. */
static void take_step(const char *steps, int step) {
    enum { HEADER = 24, HASH = 8 };
    static unsigned char bytes[65536];
    char path[4096];
    snprintf(path, sizeof path, "%s/%s.btf-step", steps, step_names[step]);
    FILE *file = fopen(path, "rb");
    const size_t size = file ? fread(bytes, 1, sizeof bytes, file) : 0;
    must(size > HEADER + HASH && fclose(file) == 0, path);
    bytes[HEADER - 1] = (unsigned char)step;
    write_seed("checkpoint", step_names[step], bytes + HEADER - 1, size - HEADER - HASH + 1);
}

static void write_steps(void) {
    enc_context context = {.threads = 1};
    char steps[] = "/tmp/btf-corpus-XXXXXX";
    enc_data *data = step_data(&context);
    must(data && mkdtemp(steps), "steps");
    must(enc_checkpoint_open(&context, steps, "corpus", data, false, &context.checkpoint) == BTF_OK,
         "steps");
    enc_sbrdf *sbrdf;
    enc_occlusion *occlusion;
    const enc_fit_options options = enc_fit_options_default();
    enc_fit_stats stats;
    must(enc_fit(&context, data, &options, &sbrdf, &stats) == BTF_OK &&
             enc_step_keep_fit(&context, sbrdf, &stats) == BTF_OK,
         "fit");
    const uint8_t shadow[STEP_LIGHTS * STEP_TEXELS] = {255, 3};
    must(enc_step_keep_shadow(&context, data, shadow) == BTF_OK, "shadow");
    must(enc_occlusion_create(STEP_VIEWS, STEP_TEXELS, &occlusion) == BTF_OK, "occlusion");
    memset(occlusion->hidden + 4, 1, 5);
    must(enc_step_keep_occlusion(&context, step_names[STEP_FLOW], occlusion) == BTF_OK &&
             enc_step_keep_occlusion(&context, step_names[STEP_REFINE], occlusion) == BTF_OK,
         "occlusion");
    uint8_t codes[2 * STEP_LIGHTS * 3] = {9, 8, 7};
    const enc_centres centres = {2, STEP_LIGHTS, 0.01f, codes};
    occlusion->centre[5] = 1;
    must(enc_step_keep_cluster(&context, occlusion, &centres) == BTF_OK, "cluster");
    for (int match = 0; match < 2; match++) {
        const enc_factor_options factors = step_factors(match);
        enc_factors *found;
        must(enc_factor_encode(&context, data, &factors, &found) == BTF_OK, "factors");
        enc_factors_destroy(&found);
    }
    enc_relief_choice choice;
    enc_relief_store relief;
    step_relief(data, &choice, &relief);
    must(relief.heights && relief.views && enc_relief_step_keep(&context, data, &choice, &relief) == BTF_OK,
         "relief");
    bool taken = false; /* a seed must be accepted, or the code after the check would not be reached */
    char reason[ENC_RELIEF_REASON];
    enc_relief_store again;
    must(enc_relief_step_take(&context, data, &taken, &choice, reason, &again) == BTF_OK && taken,
         "relief");
    enc_relief_clear(&again);
    enc_relief_clear(&relief);
    for (int step = 0; step < STEP_COUNT; step++) {
        take_step(steps, step);
    }
    enc_occlusion_destroy(&occlusion);
    enc_sbrdf_destroy(&sbrdf);
    enc_checkpoint_close(&context.checkpoint, true);
    enc_data_destroy(&data);
}

static void write_meshes(void) {
    write_text(
        "mesh", "quad.obj",
        "# a square\nv -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 1 0\n"
        "f 4/4/1 3/3/1 2/2/1 1/1/1\n");
    write_text("mesh", "back.obj",
               "o x\nv 0 0 0\nv 1 0 0 1\r\nv 0 1 \\\n .5e0\nvt 0\nvt 1 2 3\nf -3/-2 -2/-1 -1/1\n"
               "f 1/1 2/2 3/1 1/2 2/1\n");
    write_text("mesh", "wrong.obj", "v 0 0\nf 1/1/1/1 2//3 9/9");
    write_text("mesh", "curve.obj", " \tcurv\n\n");
    write_text("mesh", "huge.obj",
               "v 1e18 -1e18 0\nv -1e18 0 1e18\nv 0 1e-30 0\nvt 1e18 0\nvt 0 1e18\nf 1/1 2/2 3/1");
}

static void write_lists(void) {
    write_text("list", "list", "# inputs\nwool/\n  maps/BRICKS.zip\r\n/a/b.tar.gz\n\nx.btf\n");
    write_text("list", "names", "..\n.\n/\n...zip\na/../\n.zip\n");
    write_text("list", "table", "# moved\n1 0 0 5 45\n30 90 31.5 -90 # next\n2 30 180 29 180\n");
    write_text("list", "wrong", "30 90 90 0\n30 90 nan 0\n");
}

int main(int argc, char **argv) {
    must(argc == 2, "usage: make_corpus FOLDER");
    folder = argv[1];
    mkdir(folder, 0777);
    write_materials();
    write_images();
    write_chroma();
    write_meanings();
    write_archive("zip", archive_write_set_format_zip, NULL);
    write_archive("tar.gz", archive_write_set_format_pax_restricted, archive_write_add_filter_gzip);
    write_archive("tar", archive_write_set_format_ustar, NULL);
    write_archive("7z", archive_write_set_format_7zip, NULL);
    write_bonn("dfmf", BONN_DFMF, "!DFMF08FCR", 0);
    write_bonn("fmf", BONN_FMF, "!FMF12FCER", 0);
    write_bonn("pvf", BONN_PVF, "!PVF06FCR", 0);
    write_bonn("bdi", BONN_BDI, "!BDIF06R2!", 0);
    write_bonn("bdi-bzip", BONN_BDI, "!BDIF06R2!", 1);
    write_bonn("bdi-sparse", BONN_BDI, "!BDIF06R2!", 2);
    write_words();
    write_meshes();
    write_lists();
    write_steps();
    return 0;
}
