/* Materials: made, saved, opened again bit for bit; the numbers of the atlas; every refusal of create.
 *
 * SPDX-License-Identifier: MIT
 */
#include "tests/support/random_material.h"
#include "tests/support/refusals.h"
#include "tests/support/same_material.h"
#include "tests/support/test.h"
#include <sys/stat.h>
#include <unistd.h>

static void fill_and_round_trip(random_state *r, btf_material_desc *desc) {
    random_material_fill(r, desc);
    round_trip(desc);
}

TEST(test_round_trip_effects) {
    random_state r = {1};
    for (int layout = 0; layout < 2; layout++) {
        for (uint32_t effects = 0; effects <= BTF_EFFECT_VERSION_1; effects++) {
            btf_material_desc desc = random_material_desc(5, 3, 9, 4, (btf_layout)layout, effects);
            desc.info.domain = (btf_domain)(effects & 1);
            fill_and_round_trip(&r, &desc);
            random_material_free(&desc);
        }
    }
}

TEST(test_round_trip_models) {
    random_state r = {2};
    for (int layout = 0; layout < 2; layout++) {
        for (int half = 0; half < 2; half++) {
            for (int colour = 0; colour < 3; colour++) {
                for (uint32_t lobes = 1; lobes <= BTF_MAX_LOBES; lobes++) {
                    btf_material_desc desc =
                        random_material_desc(3, 7, 1 + lobes, 11, (btf_layout)layout, BTF_EFFECT_VERSION_1);
                    desc.info.colour = (btf_colour)colour;
                    desc.info.half_float = half && colour != BTF_COLOUR_NONE;
                    desc.info.lobes = colour == BTF_COLOUR_NONE ? 0 : lobes;
                    desc.info.components = 3 * lobes;
                    fill_and_round_trip(&r, &desc);
                    random_material_free(&desc);
                }
            }
        }
    }
}

TEST(test_round_trip_extremes) {
    static const uint32_t shapes[][6] = {/* W, H, views, lights, centres, components */
                                         {1, 1, 1, 1, 1, 1},        {1, 1, 256, 2, 65536, 256},
                                         {1, 9, 2, 256, 4097, 4},   {17, 1, 3, 2, 4096, 5},
                                         {64, 64, 81, 81, 1984, 8}, {31, 65, 81, 17, 300, 33}};
    random_state r = {3};
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
        for (int layout = 0; layout < 2; layout++) {
            const uint32_t *s = shapes[i];
            btf_material_desc desc =
                random_material_desc(s[0], s[1], s[2], s[3], (btf_layout)layout, BTF_EFFECT_VERSION_1);
            desc.info.centres = s[4];
            desc.info.components = s[5];
            fill_and_round_trip(&r, &desc);
            random_material_free(&desc);
        }
    }
}

TEST(test_provenance) {
    random_state r = {4};
    btf_material_desc desc = random_material_desc(4, 4, 3, 3, BTF_LAYOUT_TIGHT, BTF_EFFECT_SHADOW);
    const btf_material_error errors[2] = {{0, 20.5f, 18.25f, 1000},
                                          {BTF_EFFECT_SHADOW, 24.5f, INFINITY, 1200}};
    desc.errors = errors;
    desc.error_count = 2;
    desc.info.method = "joint";
    desc.info.options = "threshold = 0.3; \xC3\xA9 \"quoted\"\n";
    desc.info.source = "BRICKS64.zip";
    desc.info.radiance_scale = 12.5f;
    desc.info.shadow_scale = 1 / 255.0f;
    desc.info.gain_scale = 0x1p-24f;
    desc.info.centre_scale = 0x1p24f;
    fill_and_round_trip(&r, &desc);
    random_material_free(&desc);
}

TEST(test_path) {
    char folder[] = "/tmp/openbtf-test-XXXXXX", path[64], link[64], missing[80];
    if (!mkdtemp(folder)) {
        fail();
    }
    snprintf(path, sizeof path, "%s/a.btf.exr", folder);
    snprintf(link, sizeof link, "%s/link", folder);
    snprintf(missing, sizeof missing, "%s/none/a.btf.exr", folder);
    random_state r = {5};
    btf_material_desc desc = random_material_desc(8, 8, 7, 7, BTF_LAYOUT_PAPER, BTF_EFFECT_VERSION_1);
    random_material_fill(&r, &desc);
    btf_material *a = create_accepted(&desc), *b = NULL;
    assert_int_equal(btf_material_save(a, path, &log_keep), BTF_OK);
    assert_int_equal(btf_material_save(a, path, &log_keep), BTF_OK); /* over the old one */
    assert_int_equal(btf_material_open(path, &log_keep, &b), BTF_OK);
    assert_same_material(a, b);
    btf_material_close(&b);

    struct stat status;
    assert_int_equal(symlink(path, link), 0); /* a link stays one, and what it points to is replaced */
    assert_int_equal(btf_material_save(a, link, &log_keep), BTF_OK);
    assert_int_equal(lstat(link, &status), 0);
    assert_true(S_ISLNK(status.st_mode));
    assert_int_equal(unlink(link), 0);

    assert_int_equal(btf_material_save(a, missing, &log_keep), BTF_ERROR_IO);
    assert_non_null(strstr(last_message, missing));
    assert_non_null(strstr(last_message, "No such file or directory"));
    assert_int_equal(btf_material_save(a, folder, &log_keep), BTF_ERROR_IO);
    assert_non_null(strstr(last_message, "Is a directory"));
    assert_int_equal(btf_material_open(missing, &log_keep, &b), BTF_ERROR_IO);
    assert_non_null(strstr(last_message, "No such file or directory"));
    assert_null(b);
    assert_int_equal(btf_material_open(folder, &log_keep, &b), BTF_ERROR_IO);
    assert_int_equal(btf_material_open("/dev/null", &log_keep, &b), BTF_ERROR_BAD_FILE);
    assert_non_null(strstr(last_message, "/dev/null"));
    assert_int_equal(btf_material_save(a, "/dev/full", &log_keep), BTF_ERROR_IO);
    assert_non_null(strstr(last_message, "/dev/full"));
    assert_int_equal(access("/dev/full", W_OK), 0); /* still there */

    btf_material_close(&a);
    btf_material_close(&a);
    btf_material_close(NULL);
    random_material_free(&desc);
    assert_int_equal(unlink(path), 0);
    assert_int_equal(rmdir(folder), 0); /* nothing was left behind */
}

static void check_atlas(uint32_t size_w, uint32_t size_h, uint32_t directions, uint32_t effects,
                        uint32_t width, uint32_t height, uint32_t room) {
    btf_material_info info = {
        .width = size_w, .height = size_h, .n_views = directions, .n_lights = directions};
    uint32_t aw, ah, ar;
    info.effects = effects;
    assert_int_equal(btf_material_atlas(&info, &aw, &ah, &ar), BTF_OK);
    assert_int_equal(aw, width);
    assert_int_equal(ah, height);
    assert_int_equal(ar, room);
}

TEST(test_atlas_numbers) {
    check_atlas(64, 64, 81, BTF_EFFECT_HIDDEN, 1024, 512, 1984);
    check_atlas(64, 64, 81, 0, 1024, 512, 1984);
    check_atlas(32, 32, 81, BTF_EFFECT_HIDDEN, 512, 256, 480);
    check_atlas(256, 256, 81, BTF_EFFECT_HIDDEN, 4096, 2048, 35840);
    check_atlas(400, 400, 151, BTF_EFFECT_HIDDEN, 8192, 4096, 52336);
    check_atlas(1, 1, 1, 0, 1, 1, 0);

    btf_material_info info = {
        .width = 64, .height = 64, .n_views = 81, .n_lights = 81, .effects = BTF_EFFECT_VERSION_1};
    info.lobes = 3;
    info.centres = 1984;
    info.atlas_width = 1024;
    info.atlas_height = 512;
    info.effects &= ~(uint32_t)BTF_EFFECT_RESIDUAL;
    uint32_t x, y;
    btf_material_atlas_centre(&info, 0, &x, &y);
    assert_int_equal(x, 64); /* 80 tiles fill 1024 x 320; tile 80 stands at (0, 320) */
    assert_int_equal(y, 320);
    btf_material_atlas_centre(&info, 959, &x, &y);
    assert_int_equal(x, 1023);
    assert_int_equal(y, 320);
    btf_material_atlas_centre(&info, 960, &x, &y);
    assert_int_equal(x, 0); /* the second band begins below the tile: row 401 > 320 + 64 */
    assert_int_equal(y, 401);
    btf_material_atlas_centre(&info, 1983, &x, &y);
    assert_int_equal(x, 1023);

    size_t gpu = 0;
    for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
        gpu += btf_material_texture_shape(&info, (btf_texture_id)id).size;
    }
    assert_int_equal(gpu, 64 * 64 * 64 + 4 * 1024 * 512); /* 64 W H + 4 AW AH = 2.36 MB */

    info.width = info.height = 4096;
    info.n_views = info.n_lights = 17;
    assert_int_equal(btf_material_atlas(&info, &x, &y, &info.centres), BTF_ERROR_UNSUPPORTED);
    info.n_views = info.n_lights = 16; /* exactly full, no room for centres */
    assert_int_equal(btf_material_atlas(&info, &x, &y, &info.centres), BTF_ERROR_UNSUPPORTED);
    info.effects = 0;
    assert_int_equal(btf_material_atlas(&info, &x, &y, &info.centres), BTF_OK);
    assert_int_equal(x, 16384);
    assert_int_equal(y, 16384);
}

/* More centres than the smallest atlas holds take the next one that does. */
TEST(test_atlas_asked) {
    btf_material_info info = {.width = 64, .height = 64, .n_views = 81, .n_lights = 81};
    uint32_t width, height, room;
    info.effects = BTF_EFFECT_HIDDEN;
    info.centres = 1984;
    assert_int_equal(btf_material_atlas(&info, &width, &height, &room), BTF_OK);
    assert_int_equal(room, 1984);
    info.centres = 1985;
    assert_int_equal(btf_material_atlas(&info, &width, &height, &room), BTF_OK);
    assert_int_equal(width, 1024);
    assert_int_equal(height, 1024);
    assert_true(room >= 1985);
    info.effects = 0; /* without hidden points nobody reads it */
    assert_int_equal(btf_material_atlas(&info, &width, &height, &room), BTF_OK);
    assert_int_equal(height, 512);
}

/* Centres that an atlas has room for, counted column by column from where the tiles stand; -1 when they do
 * not fit. */
static long count_room(const btf_material_info *info, uint32_t width, uint32_t height) {
    uint32_t tiles = info->n_views > info->n_lights ? info->n_views : info->n_lights,
             columns = width / info->width;
    if (columns == 0 || (tiles + columns - 1) / columns * info->height > height) {
        return -1;
    }
    uint32_t y0 = tiles / columns * info->height, used = tiles % columns * info->width;
    long room = 0;
    for (uint32_t y = y0; y + info->n_lights <= height; y += info->n_lights) {
        for (uint32_t x = 0; x < width; x++) {
            room += !(x < used && y < y0 + info->height);
        }
    }
    return room;
}

/* Odd sizes: centres and tiles never meet, centres are distinct, and no smaller atlas would do. */
TEST(test_atlas_disjoint) {
    static const uint32_t shapes[][4] = {{3, 5, 7, 9},     {5, 3, 9, 7},     {13, 7, 30, 11},
                                         {1, 1, 256, 1},   {20, 33, 81, 16}, {7, 50, 19, 3},
                                         {64, 64, 81, 81}, {10, 10, 33, 5}};
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
        const uint32_t *s = shapes[i];
        btf_material_info info = {.width = s[0], .height = s[1], .n_views = s[2], .n_lights = s[3]};
        info.effects = BTF_EFFECT_HIDDEN;
        uint32_t room, tiles = s[2] > s[3] ? s[2] : s[3];
        assert_int_equal(btf_material_atlas(&info, &info.atlas_width, &info.atlas_height, &room), BTF_OK);
        assert_true(room >= s[2]);
        assert_int_equal(room, count_room(&info, info.atlas_width, info.atlas_height));
        for (uint32_t w = 1; w <= 16384; w *= 2) {
            for (uint32_t h = 1; h <= w; h *= 2) {
                uint64_t own = (uint64_t)info.atlas_width * info.atlas_height, other = (uint64_t)w * h;
                if (other < own || (other == own && w < info.atlas_width)) {
                    assert_true(count_room(&info, w, h) < (long)s[2]);
                }
            }
        }
        size_t area = (size_t)info.atlas_width * info.atlas_height;
        uint8_t *taken = calloc(1, area);
        assert_non_null(taken);
        uint32_t columns = info.atlas_width / s[0];
        for (uint32_t t = 0; t < tiles; t++) {
            for (uint32_t y = 0; y < s[1]; y++) {
                for (uint32_t x = 0; x < s[0]; x++) {
                    size_t at =
                        (size_t)(t / columns * s[1] + y) * info.atlas_width + t % columns * s[0] + x;
                    assert_true(at < area && !taken[at]++);
                }
            }
        }
        for (uint32_t c = 0; c < room; c++) {
            uint32_t x, y;
            btf_material_atlas_centre(&info, c, &x, &y);
            for (uint32_t l = 0; l < s[3]; l++) {
                size_t at = (size_t)(y + l) * info.atlas_width + x;
                assert_true(x < info.atlas_width && at < area && !taken[at]++);
            }
        }
        free(taken);
    }
}

TEST(test_info) {
    random_state r = {6};
    btf_material_desc desc = random_material_desc(4, 4, 3, 5, BTF_LAYOUT_TIGHT, BTF_EFFECT_VERSION_1);
    random_material_fill(&r, &desc);
    btf_material *a = create_accepted(&desc);
    btf_material_info info = accepted_info(a);
    /* 4 RGBA32F; 5 shadow maps; 3 x (gain 1, shift 2); 7 centres of 5 lights; U in 2 layers; V in 6 */
    assert_int_equal(info.gpu_bytes, 16 * 64 + 16 * 5 + 16 * 3 * 3 + 7 * 5 * 4 + 16 * 2 * 4 + 15 * 6 * 4);
    assert_int_equal(info.table_bytes, btf_material_texture(a, BTF_TEXTURE_VIEW_TABLE).size +
                                           btf_material_texture(a, BTF_TEXTURE_LIGHT_TABLE).size + 2 * 16);
    btf_material_info part = {.struct_size = offsetof(btf_material_info, n_views), .n_views = 77};
    assert_int_equal(btf_material_get_info(a, &part), BTF_OK);
    assert_int_equal(part.width, 4);
    assert_int_equal(part.n_views, 77); /* beyond struct_size: untouched */
    part.struct_size = 0;
    assert_int_equal(btf_material_get_info(a, &part), BTF_ERROR_USAGE);
    btf_material_close(&a);
    random_material_free(&desc);
}

TEST(test_create_refuses_info) {
    random_state r = {7};
    btf_material_desc good = random_material_desc(4, 4, 3, 3, BTF_LAYOUT_PAPER, BTF_EFFECT_VERSION_1), bad;
    random_material_fill(&r, &good);
#define REFUSED(change, text)                                                                              \
    do {                                                                                                   \
        bad = good;                                                                                        \
        bad.change;                                                                                        \
        create_refused(&bad, text);                                                                        \
    } while (0)
    REFUSED(struct_size = 8, "struct_size is 8");
    REFUSED(info.width = 0, "size 0 x 4");
    REFUSED(info.height = 16385, "size 4 x 16385");
    REFUSED(info.n_views = 0, "0 views");
    REFUSED(info.n_lights = 257, "257 lights");
    REFUSED(info.layout = (btf_layout)2, "layout 2");
    REFUSED(info.domain = (btf_domain)3, "domain 3");
    REFUSED(info.colour = (btf_colour)4, "colour 4");
    REFUSED(info.effects = 159, "effects 0x9f");
    REFUSED(info.lobes = 5, "lobes 5");
    REFUSED(info.lobes = 0, "lobes 0");
    REFUSED(info.colour = BTF_COLOUR_NONE, "lobes is 3; colour none has no lobes");
    REFUSED(info.centres = 0, "centres 0");
    REFUSED(info.centres = 65537, "centres 65537");
    REFUSED(info.centres = 5000, "not for 5000");
    REFUSED(info.components = 0, "residual of 0");
    REFUSED(info.components = 257, "residual of 257");
    REFUSED(info.effects = 15, "residual of 5 components without");
    REFUSED(info.effects = 27, "without the effect hidden");
    REFUSED(info.atlas_width = 24, "24 x");
    REFUSED(info.atlas_height = 64, "sides must be");
    REFUSED(info.atlas_width = 32768, "32768 x");
    REFUSED(info.radiance_scale = 0, "radianceScale 0");
    REFUSED(info.shadow_scale = -1, "shadowScale -1");
    REFUSED(info.gain_scale = NAN, "gainScale");
    REFUSED(info.centre_scale = 0x1p25f, "centreScale");
    REFUSED(views = NULL, "views: missing");
    REFUSED(lights = NULL, "lights: missing");
    REFUSED(texture[BTF_TEXTURE_SBRDF] = NULL, "sbrdf: missing");
    REFUSED(texture[BTF_TEXTURE_SHADOW] = good.texture[0], "shadow: given");
    REFUSED(error_count = 1, "errors: 1 rows");
    bad = good;
    bad.info.effects &= ~(uint32_t)(BTF_EFFECT_RESIDUAL | BTF_EFFECT_HIDDEN);
    bad.info.components = bad.info.centres = 0;
    bad.info.colour = BTF_COLOUR_NONE;
    bad.info.lobes = 0;
    create_refused(&bad, "colour none without");
    const float low[9] = {0, 0, 1, 0.6f, 0, 0.8f, 1, 0, 0}, twice[9] = {0, 0, 1, 0.6f, 0, 0.8f, 0, 0, 1},
                longer[9] = {0, 0, 1.01f, 0.6f, 0, 0.8f, 0, 0.6f, 0.8f},
                nan[9] = {0, 0, 1, NAN, 0, 0.8f, 0, 0.6f, 0.8f};
    REFUSED(views = low, "views: direction 2");
    REFUSED(lights = twice, "lights: directions 0 and 2 coincide");
    REFUSED(lights = longer, "lights: direction 0");
    REFUSED(views = nan, "views: direction 1");
    btf_material_error errors[2] = {{0, 20, 20, 100}, {32, 20, 20, 100}};
    bad = good;
    bad.errors = errors;
    bad.error_count = 2;
    create_refused(&bad, "row 1 has the effects 0x20");
    errors[1] = (btf_material_error){1, NAN, 20, 100};
    create_refused(&bad, "errors: row 1");
    random_material_free(&good);
}

/* Sets element i of a texture to value, expects the message, sets it back. */
static void refused_u8(btf_material_desc *desc, btf_texture_id id, size_t i, uint8_t value,
                       const char *text) {
    uint8_t *data = (uint8_t *)(uintptr_t)desc->texture[id], old = data[i];
    data[i] = value;
    create_refused(desc, text);
    data[i] = old;
}

static void refused_float(btf_material_desc *desc, btf_texture_id id, size_t i, float value,
                          const char *text) {
    float *data = (float *)(uintptr_t)desc->texture[id], old = data[i];
    data[i] = value;
    create_refused(desc, text);
    data[i] = old;
}

static void refused_half(btf_material_desc *desc, size_t i, uint16_t value, const char *text) {
    uint16_t *data = (uint16_t *)(uintptr_t)desc->texture[BTF_TEXTURE_SBRDF], old = data[i];
    data[i] = value;
    create_refused(desc, text);
    data[i] = old;
}

TEST(test_create_refuses_values) {
    random_state r = {8};
    btf_material_desc d = random_material_desc(4, 4, 5, 3, BTF_LAYOUT_TIGHT, BTF_EFFECT_VERSION_1);
    d.info.colour = BTF_COLOUR_RGB;
    d.info.lobes = 1; /* 6 numbers in 2 layers: components 2 and 3 of layer 1 are unused */
    random_material_fill(&r, &d);
    uint8_t *gain = (uint8_t *)(uintptr_t)d.texture[BTF_TEXTURE_GAIN];
    uint8_t *shift = (uint8_t *)(uintptr_t)d.texture[BTF_TEXTURE_SHIFT];

    refused_float(&d, BTF_TEXTURE_SBRDF, 4 * 5 + 1, NAN, "sbrdf: channel G at (1, 1) holds nan");
    refused_float(&d, BTF_TEXTURE_SBRDF, 0, INFINITY, "sbrdf: channel R at (0, 0) holds inf");
    refused_float(&d, BTF_TEXTURE_SBRDF, 3, 0x1p-25f, "channel lobe1.R");
    refused_float(&d, BTF_TEXTURE_SBRDF, 4 * 16 + 1, 1e-40f, "channel lobe1.B");
    refused_float(&d, BTF_TEXTURE_SBRDF, 4 * 32 + 3, 0x1.000002p24f, "channel lobe1.n");
    refused_float(&d, BTF_TEXTURE_SBRDF, 4 * 16 + 2, 1, "channel (unused)");
    refused_float(&d, BTF_TEXTURE_RESIDUAL_SCALES, 1, -0x1p25f, "residualScales: number 1");
    refused_float(&d, BTF_TEXTURE_RESIDUAL_SCALES, 5, 1, "residualScales: number 5");
    refused_u8(&d, BTF_TEXTURE_RESIDUAL_TEXELS, 2, 0x80,
               "residual_texels: component 2 at (0, 0) holds -128");
    refused_u8(&d, BTF_TEXTURE_RESIDUAL_TEXELS, 4 * 16 + 1, 1, "component 5");
    refused_u8(&d, BTF_TEXTURE_RESIDUAL_DIRECTIONS, 4 * 15 * 3 + 1, 1, "residual_directions: component 5");
    refused_u8(&d, BTF_TEXTURE_CENTRES, 3, 1, "centres: texel (0, 0) holds 1");
    uint8_t old = gain[0], b0 = shift[0], b1 = shift[1];
    gain[0] = 0;
    shift[0] = 7;
    shift[1] = 0;
    create_refused(&d, "gain: view 0, texel (0, 0) names centre 7 of 7");
    shift[0] = 1;
    shift[1] = 1;
    create_refused(&d, "centre 257 of 7");
    shift[0] = b0;
    shift[1] = b1;
    gain[0] = old;

    d.info.effects &= ~(uint32_t)BTF_EFFECT_SHIFT; /* some point has a shift */
    create_refused(&d, "without the effect shift");
    d.info.effects |= BTF_EFFECT_SHIFT;
    d.info.effects &= ~(uint32_t)BTF_EFFECT_GAIN;
    create_refused(&d, "without the effect gain");
    d.info.effects |= BTF_EFFECT_GAIN;
    random_material_free(&d);

    d = random_material_desc(4, 4, 5, 3, BTF_LAYOUT_TIGHT, BTF_EFFECT_GAIN);
    d.info.half_float = 1;
    random_material_fill(&r, &d);
    refused_u8(&d, BTF_TEXTURE_GAIN, 0, 0, "gain code 0 without");
    refused_half(&d, 5, 0x7C00, "channel G at (1, 0) holds inf");
    refused_half(&d, 5, 0xFE00, "nan");
    refused_half(&d, 5, 0x03FF, "which is not 0 or of magnitude 2^-14 to 65504");
    random_material_free(&d);
}

TEST(test_create_refuses_maps) {
    random_state r = {9};
    btf_material_desc d = random_material_desc(4, 4, 3, 5, BTF_LAYOUT_PAPER, 15);
    random_material_fill(&r, &d);
    assert_int_equal(d.info.atlas_width,
                     16); /* 4 columns: tile 4 stands at (0, 4), centres from row 4 on */
    const size_t row = 4 * 16;
    refused_u8(&d, BTF_TEXTURE_MAPS, 4 * 12 + 1, 3,
               "maps: texel (12, 0) holds 3; it has no meaning"); /* no view 3 */
    refused_u8(&d, BTF_TEXTURE_MAPS, 4 * row + 4 * 9 + 3, 2,
               "maps: texel (9, 4) holds"); /* alpha of a centre */
    size_t last = (size_t)d.info.atlas_width * d.info.atlas_height * 4 - 4;
    refused_u8(&d, BTF_TEXTURE_MAPS, last, 9, "holds 9; it has no meaning and must be 0");
    d.info.effects &= ~(uint32_t)BTF_EFFECT_SHADOW;
    create_refused(&d, "it has no meaning and must be 0");
    d.info.effects |= BTF_EFFECT_SHADOW;
    random_material_free(&d);

    d = random_material_desc(4, 4, 3, 3, BTF_LAYOUT_PAPER, BTF_EFFECT_GAIN);
    random_material_fill(&r, &d);
    refused_u8(&d, BTF_TEXTURE_MAPS, 1, 0,
               "maps: view 0, texel (0, 0): gain code 0 without the effect hidden");
    random_material_free(&d);
    d = random_material_desc(4, 4, 16, 3, BTF_LAYOUT_PAPER, BTF_EFFECT_HIDDEN);
    random_material_fill(&r, &d);
    refused_u8(&d, BTF_TEXTURE_MAPS, 1, 127, "gain code 127 without the effect gain");
    random_material_free(&d);

    d = random_material_desc(4, 4, 3, 3, BTF_LAYOUT_PAPER, BTF_EFFECT_SHADOW);
    random_material_fill(&r, &d);
    refused_u8(&d, BTF_TEXTURE_MAPS, 1, 128,
               "maps: texel (0, 0) holds 128; it has no meaning and must be 0");
    refused_u8(&d, BTF_TEXTURE_MAPS, 3, 1, "shift bytes 0, 1 without the effect shift");
    random_material_free(&d);
}

TEST(test_negative_zero) {
    random_state r = {10};
    btf_material_desc d = random_material_desc(2, 2, 3, 3, BTF_LAYOUT_TIGHT, BTF_EFFECT_RESIDUAL);
    random_material_fill(&r, &d);
    ((float *)(uintptr_t)d.texture[BTF_TEXTURE_SBRDF])[3] = -0.0f;
    ((float *)(uintptr_t)d.texture[BTF_TEXTURE_RESIDUAL_SCALES])[3] = -0.0f;
    btf_material *a = create_accepted(&d);
    assert_false(signbit(((const float *)btf_material_texture(a, BTF_TEXTURE_SBRDF).data)[3]));
    assert_false(signbit(((const float *)btf_material_texture(a, BTF_TEXTURE_RESIDUAL_SCALES).data)[3]));
    btf_material_close(&a);
    random_material_free(&d);
}

TEST(test_names) {
    assert_string_equal(btf_texture_name(BTF_TEXTURE_RESIDUAL_TEXELS), "residual_texels");
    assert_string_equal(btf_texture_name((btf_texture_id)99), "unknown");
    assert_int_equal(btf_format_size(BTF_FORMAT_NONE), 0);
    assert_int_equal(btf_format_size(BTF_FORMAT_RG8UI), 2);
    assert_int_equal(btf_format_size(BTF_FORMAT_RGBA8I), 4);
    assert_int_equal(btf_format_size(BTF_FORMAT_RGBA16F), 8);
    assert_int_equal(btf_format_size(BTF_FORMAT_RGBA32F), 16);
    assert_string_equal(btf_result_text(BTF_ERROR_BAD_FILE), "bad file");
    assert_string_equal(btf_result_text((btf_result)99), "unknown result");
    assert_int_equal(btf_result_exit_code(BTF_ERROR_UNSUPPORTED), 5);
    assert_int_equal(btf_result_exit_code(BTF_OK), 0);
    assert_int_equal(btf_result_exit_code((btf_result)99), 4);
}

RUN_TESTS(NULL, NULL)
