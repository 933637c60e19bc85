/* Environment maps from files (decoder/tools/render/environment.h): which of an OpenEXR file's pictures is read, and
 * what is warned of or refused.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/tools/render/environment.h"
#include "tests/support/exr_bytes.h"
#include "tests/support/image_files.h"
#include "tests/support/messages.h"
#include "tests/support/temporary.h"
#include "tests/support/test.h"

#include <unistd.h>

static float value_of(int c, int x, int y) {
    (void)x;
    (void)y;
    return (float)(1 << c);
}

/* Reads a map from a file of this one part, and sums up the colours of its lights in *out_sum. */
static btf_result read_map(const bytes_part *part, const char *layer, double out_sum[3]) {
    light_list list = {0};
    size_t size;
    void *bytes = exr_bytes(part, 1, &size);
    write_whole_file(temporary_file, bytes, size);
    free(bytes);
    forget_messages();
    const btf_result result = light_list_read_environment(&list, temporary_file, layer, 4, 0, 1, &log_keep);
    for (int c = 0; c < 3; c++) {
        out_sum[c] = 0;
        for (size_t i = 0; i < list.count; i++) {
            out_sum[c] += list.lights[i].colour[c];
        }
    }
    light_list_clear(&list);
    return result;
}

static float chroma_of(int c, int x, int y) {
    static const float values[4] = {1, -0.25f, 0.5f, 8};
    (void)x;
    (void)y;
    return values[c];
}

static bytes_part map_of(const char *b, const char *g, const char *r, const char *further) {
    bytes_part p = {.width = 8, .height = 4, .value = value_of};
    const char *names[4] = {b, g, r, further};
    for (int c = 0; c < 4 && names[c]; c++) {
        p.channels[p.channel_count++] = (bytes_channel){names[c], BYTES_HALF, 1, 1};
    }
    return p;
}

/* A sphere of radiance L gives lights whose colours add up to 4 L (irradiance over pi). */
static void expect_sum(const double sum[3], double r, double g, double b) {
    assert_true(fabs(sum[0] - 4 * r) < 1e-3 && fabs(sum[1] - 4 * g) < 1e-3 && fabs(sum[2] - 4 * b) < 1e-3);
}

TEST(test_layers) {
    double sum[3];
    bytes_part p = map_of("B", "G", "R", NULL);
    assert_int_equal(read_map(&p, NULL, sum), BTF_OK);
    expect_sum(sum, 4, 2, 1);
    assert_string_equal(all_messages, "");
    p = map_of("sky.B", "sky.G", "sky.R", "sun.Y");
    assert_int_equal(read_map(&p, NULL, sum), BTF_OK);
    expect_sum(sum, 4, 2, 1);
    assert_non_null(strstr(all_messages, "layer sky"));
    assert_int_equal(read_map(&p, "sun", sum), BTF_OK); /* grey */
    expect_sum(sum, 8, 8, 8);
    assert_int_equal(read_map(&p, "sky.G", sum), BTF_OK);
    expect_sum(sum, 2, 2, 2);
    assert_int_equal(read_map(&p, "moon", sum), BTF_ERROR_UNSUPPORTED);
    assert_non_null(strstr(all_messages, "sky.B, sky.G, sky.R, sun.Y"));
}

/* Subsampled chroma is read without OpenEXRCore's unpacking, here too. */
TEST(test_chroma) {
    double sum[3];
    bytes_part p = map_of("A", "BY", "RY", "Y");
    p.channels[1].xs = p.channels[1].ys = p.channels[2].xs = p.channels[2].ys = 2;
    p.value = chroma_of;
    assert_int_equal(read_map(&p, NULL, sum), BTF_OK);
    assert_true(fabs(sum[0] - 4 * 12) < 0.01 && fabs(sum[2] - 4 * 6) < 0.01);
}

TEST(test_meaning) {
    static const float p3[8] = {0.68f, 0.32f, 0.265f, 0.69f, 0.15f, 0.06f, 0.3127f, 0.329f};
    double sum[3];
    bytes_part p = map_of("B", "G", "R", NULL);
    p.attributes[p.attribute_count++] =
        (bytes_attribute){"chromaticities", "chromaticities", p3, sizeof p3};
    assert_int_equal(read_map(&p, NULL, sum), BTF_OK);
    /* R = 1.22494 * 4 - 0.22494 * 2 of Display P3 */
    assert_true(fabs(sum[0] - 4 * 4.4499) < 0.01);
    assert_non_null(strstr(all_messages, "converted to Rec. 709"));
    p = map_of("B", "G", "R", NULL);
    p.attributes[p.attribute_count++] = (bytes_attribute){"envmap", "envmap", "\1", 1};
    assert_int_equal(read_map(&p, NULL, sum), BTF_ERROR_UNSUPPORTED);
    assert_non_null(strstr(all_messages, "the faces of a cube"));
    p.attributes[0].value = "\0";
    assert_int_equal(read_map(&p, NULL, sum), BTF_OK);
    p = map_of("X", "Y", "Z", NULL);
    assert_int_equal(read_map(&p, NULL, sum), BTF_ERROR_UNSUPPORTED);
    assert_non_null(strstr(all_messages, "colours are XYZ"));
}

/* One sample below 0, one infinite, one that is no number. */
static float broken_value(int c, int x, int y) {
    if (y == 1 && x == 5) {
        return c == 0 ? -1.0f : c == 1 ? INFINITY : NAN;
    }
    return 1.0f;
}

/* Samples that cannot be radiance are counted in a warning, and so is a shape that is not 2:1. */
TEST(test_contents) {
    double sum[3];
    bytes_part p = map_of("B", "G", "R", NULL);
    p.value = broken_value;
    for (int c = 0; c < 3; c++) {
        p.channels[c].type = BYTES_FLOAT; /* as written, infinity and all */
    }
    assert_int_equal(read_map(&p, NULL, sum), BTF_OK);
    assert_true(sum[0] < 4 && sum[0] > 3.5);
    assert_non_null(strstr(all_messages, "3 samples that are below 0, infinite or not a number"));
    assert_non_null(strstr(all_messages, "the first is nan in column 5, row 1"));
    const struct {
        int width, height;
        bool told;
    } sizes[] = {{8, 4, false}, {9, 4, false}, {1, 1, false}, {8, 8, true}, {24, 4, true}, {12, 16, true}};
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
        p = map_of("B", "G", "R", NULL);
        p.width = sizes[k].width;
        p.height = sizes[k].height;
        assert_int_equal(read_map(&p, NULL, sum), BTF_OK);
        assert_int_equal(strstr(all_messages, "latitude and longitude") != NULL, sizes[k].told);
    }
    write_whole_file(temporary_file, "\x89PNG", 4);
    light_list list = {0};
    forget_messages();
    assert_int_equal(light_list_read_environment(&list, temporary_file, NULL, 4, 0, 1, &log_keep),
                     BTF_ERROR_BAD_FILE);
    assert_non_null(strstr(all_messages, "neither an OpenEXR nor a Radiance HDR file"));
}

RUN_TESTS(make_temporary_file, remove_temporary_file)
