/* Samples in memory and in a scratch file (encoder/data/data.h, encoder/input/source.h), sets in archives, and sets of
 * ../shared against the values of another reader.
 *
 * SPDX-License-Identifier: MIT
 */
#include "tests/support/image_files.h"
#include "tests/support/image_set.h"
#include "tests/support/test.h"

#include <archive.h>
#include <archive_entry.h>
#include <sys/stat.h>
#include <unistd.h>

/* A different thread count, and a scratch file in blocks of one image, give the same samples. */
SET_TEST(test_scratch_file) {
    const enc_read_options options = {0};
    set_write(UBO);
    enc_data *memory = set_read_folder(&options);
    assert_non_null(memory->samples);
    set_context.threads = 1;
    enc_data *one = set_read_folder(&options);
    const size_t stride = enc_data_texel_stride(memory), texels = enc_data_texel_count(memory);
    assert_memory_equal(memory->samples, one->samples, stride * texels * sizeof(float));
    enc_data_destroy(&one);

    const size_t limits[] = {1, 1000, 3000};
    for (size_t i = 0; i < sizeof limits / sizeof *limits; i++) {
        set_context.memory = limits[i];
        set_context.threads = 1 + (int)i % 2;
        all_messages[0] = '\0';
        enc_data *scratch = set_read_folder(&options);
        assert_null(scratch->samples);
        assert_true(scratch->scratch_fd >= 0);
        assert_non_null(strstr(all_messages, "scratch file in"));
        struct stat status;
        assert_int_equal(fstat(scratch->scratch_fd, &status), 0);
        assert_int_equal(status.st_nlink, 0); /* the scratch file has no name */
        float *buffer = malloc(stride * texels * sizeof *buffer);
        const float *samples;
        assert_int_equal(enc_data_texels(&set_context, scratch, 0, texels, buffer, &samples), BTF_OK);
        assert_memory_equal(memory->samples, samples, stride * texels * sizeof(float));
        free(buffer);

        float *a = malloc(texels * LIGHTS * 3 * sizeof *a), *b = malloc(texels * LIGHTS * 3 * sizeof *b);
        for (int v = 0; v < VIEWS; v++) {
            assert_int_equal(enc_data_view(&set_context, memory, v, a), BTF_OK);
            assert_int_equal(enc_data_view(&set_context, scratch, v, b), BTF_OK);
            assert_memory_equal(a, b, texels * LIGHTS * 3 * sizeof *a);
        }
        assert_true(a[(2 * texels + 7) * 3 + 1] == set_sample(memory, VIEWS - 1, 2, 1, 2, 1));
        free(a);
        free(b);
        enc_data_destroy(&scratch);
    }
    enc_data_destroy(&memory);
}

SET_TEST(test_data) {
    const enc_direction list[2] = {enc_direction_from_angles(0, 0), enc_direction_from_angles(30, 0)};
    float in[2 * 2 * 3 * 2], buffer[2 * 2 * 3 * 2];
    for (int i = 0; i < 24; i++) {
        in[i] = (float)i;
    }
    for (int k = 0; k < 2; k++) {
        enc_data *data;
        const float *out;
        set_context.memory = k ? 1 : 0;
        assert_int_equal(enc_data_create(&set_context, 3, 1, 2, list, 2, list, &data), BTF_OK);
        assert_int_equal(enc_data_store_texels(&set_context, data, 1, 2, in), BTF_OK);
        assert_int_equal(enc_data_texels(&set_context, data, 1, 2, buffer, &out), BTF_OK);
        assert_memory_equal(out, in, sizeof in);
        assert_int_equal(enc_data_texels(&set_context, data, 0, 1, buffer, &out), BTF_OK);
        for (int i = 0; i < 12; i++) {
            assert_true(out[i] == 0.0f);
        }
        enc_data_destroy(&data);
    }
    enc_data *data;
    set_context.memory = 1;
    assert_int_equal(enc_data_create(&set_context, 0, 1, 2, list, 2, list, &data), BTF_ERROR_USAGE);
    assert_int_equal(enc_data_create(&set_context, 1, 16385, 2, list, 2, list, &data), BTF_ERROR_USAGE);
    assert_int_equal(enc_data_create(&set_context, 1, 1, 257, list, 2, list, &data), BTF_ERROR_USAGE);
    enc_direction many[256];
    for (int i = 0; i < 256; i++) {
        many[i] = list[i % 2];
    }
    all_messages[0] = '\0';
    assert_int_equal(enc_data_create(&set_context, 16384, 16384, 256, many, 256, many, &data),
                     BTF_ERROR_IO);
    assert_non_null(strstr(all_messages, "GB are free"));
    const char *old = getenv("TMPDIR");
    char *kept = old ? strdup(old) : NULL;
    setenv("TMPDIR", "/nowhere/at/all", 1);
    assert_int_equal(enc_data_create(&set_context, 3, 1, 2, list, 2, list, &data), BTF_ERROR_IO);
    assert_non_null(strstr(all_messages, "/nowhere/at/all"));
    if (kept) {
        setenv("TMPDIR", kept, 1);
    } else {
        unsetenv("TMPDIR");
    }
    free(kept);
}

static void add_to_archive(struct archive *archive, const char *name, const void *data, size_t size) {
    struct archive_entry *entry = archive_entry_new();
    archive_entry_set_pathname(entry, name);
    archive_entry_set_size(entry, (la_int64_t)size);
    archive_entry_set_filetype(entry, AE_IFREG);
    archive_entry_set_perm(entry, 0644);
    assert_int_equal(archive_write_header(archive, entry), ARCHIVE_OK);
    assert_int_equal(archive_write_data(archive, data, size), (la_ssize_t)size);
    archive_entry_free(entry);
}

/* Packs the set into `path`: lights outside, views inside, and names that would leave a folder if
 * extracted, every second one as some programs of Windows write them. */
static void write_archive(const char *path, bool zip) {
    struct archive *archive = archive_write_new();
    if (zip) {
        archive_write_set_format_zip(archive);
    } else {
        archive_write_set_format_pax_restricted(archive);
        archive_write_add_filter_gzip(archive);
    }
    assert_int_equal(archive_write_open_filename(archive, path), ARCHIVE_OK);
    add_to_archive(archive, "readme.txt", "hello", 5);
    for (int l = 0; l < LIGHTS; l++) {
        for (int v = 0; v < VIEWS; v++) {
            char name[PATH];
            size_t size;
            void *data = read_whole_file(set_name_of(UBO, v, l, "png"), &size);
            snprintf(name, sizeof name, "%s/tv%g_pv%g/tl%g pl%g.png", l % 2 ? "../../.." : "/absolute",
                     set_views[v][0], set_views[v][1], set_lights[l][0], set_lights[l][1]);
            for (char *p = name; *p && l % 2; p++) {
                *p = *p == '/' ? '\\' : *p;
            }
            add_to_archive(archive, name, data, size);
            free(data);
            snprintf(name, sizeof name, "__MACOSX%c._tv%g_pv%g tl%g pl%g.png", l % 2 ? '\\' : '/',
                     set_views[v][0], set_views[v][1], set_lights[l][0], set_lights[l][1]);
            add_to_archive(archive, name, "x", 1);
        }
    }
    assert_int_equal(archive_write_free(archive), ARCHIVE_OK);
}

SET_TEST(test_archives) {
    const enc_read_options options = {0};
    set_write(UBO);
    for (int zip = 0; zip < 2; zip++) {
        char path[PATH];
        snprintf(path, sizeof path, "%s/set.%s", temporary_folder, zip ? "zip" : "tar.gz");
        write_archive(path, zip);
        for (size_t memory = 0; memory < 6000; memory += 2500) {
            enc_data *data = NULL;
            set_context.memory = memory;
            if (enc_read(&set_context, path, &options, &data) != BTF_OK) {
                fail_msg("%s", all_messages);
            }
            assert_true((data->samples == NULL) == (memory > 0));
            set_expect(data, 1e-7);
            enc_data_destroy(&data);
        }
        size_t size;
        size_t whole = 0;
        void *bytes = read_whole_file(path, &size);
        for (size_t n = 0; n < size; n += 97) {
            enc_data *data = NULL;
            all_messages[0] = '\0';
            write_whole_file(path, bytes, n);
            const btf_result result = enc_read(&set_context, path, &options, &data);
            if (result == BTF_OK) {
                set_expect(data, 1e-7); /* the bytes missing at the end held no image */
                enc_data_destroy(&data);
                whole++;
                continue;
            }
            assert_int_equal(result, BTF_ERROR_BAD_FILE);
            assert_non_null(strstr(all_messages, zip ? "set.zip" : "set.tar.gz"));
        }
        free(bytes);
        print_message("%s: %zu of %zu truncations left every image whole\n", path, whole, (size + 96) / 97);
        assert_true(whole < size / 97 / 2);
    }
    set_expect_refused("/dev/null", &options, BTF_ERROR_BAD_FILE, "/dev/null", NULL);
    set_expect_refused(set_name_of(UBO, 0, 0, "png"), &options, BTF_ERROR_BAD_FILE,
                       "neither a directory nor a zip", NULL);
}

/* The path of a file of the shared data, or NULL where it is absent. */
static const char *shared_file(const char *name) {
    static char path[4096];
    const char *shared = getenv("BTF_SHARED"), *root = getenv("BTF_SOURCE_ROOT");
    if (shared) {
        snprintf(path, sizeof path, "%s/data/%s", shared, name);
    } else {
        snprintf(path, sizeof path, "%s/../shared/data/%s", root ? root : ".", name);
    }
    if (access(path, R_OK) == 0) {
        return path;
    }
    print_message("skipped: %s is absent\n", path);
    return NULL;
}

SET_TEST(test_bricks) {
    const char *path = shared_file("BRICKS64.zip");
    if (!path) {
        skip();
    }
    enc_data *data = NULL;
    assert_int_equal(enc_read(&set_context, path, &(enc_read_options){0}, &data), BTF_OK);
    assert_int_equal(data->width, 64);
    assert_int_equal(data->height, 64);
    assert_int_equal(data->n_views, 81);
    assert_int_equal(data->n_lights, 81);
    assert_float_equal(data->lights[80].theta, 75, 0);
    assert_float_equal(data->lights[80].phi, 345, 0);
    /* an independent reader's values (Pillow) */
    assert_float_equal(set_sample(data, 0, 0, 0, 0, 0), 0.35640013f, 1e-7);
    assert_float_equal(set_sample(data, 5, 7, 10, 20, 1), 0.08021982f, 1e-7);
    assert_float_equal(set_sample(data, 80, 80, 63, 63, 2), 0.038204372f, 1e-7);
    assert_float_equal(set_sample(data, 40, 12, 33, 1, 0), 0.4072402f, 1e-7);
    const size_t count = 81 * 3 * (size_t)64 * 64;
    float *view = malloc(count * sizeof *view);
    assert_non_null(view);
    const double sums[2] = {120436.44909772754, 127598.78268555214};
    for (int i = 0; i < 2; i++) {
        double sum = 0;
        assert_int_equal(enc_data_view(&set_context, data, i * 80, view), BTF_OK);
        for (size_t k = 0; k < count; k++) {
            sum += view[k];
        }
        assert_float_equal(sum, sums[i], 1e-3);
    }
    free(view);
    enc_data_destroy(&data);
}

SET_TEST(test_wallpaper) {
    const char *path = shared_file("UBO_WALLPAPER256_top.zip");
    if (!path) {
        skip();
    }
    enc_data *data = NULL;
    assert_int_equal(enc_read(&set_context, path, &(enc_read_options){.size = {64, 64}}, &data), BTF_OK);
    assert_int_equal(data->width, 64);
    assert_int_equal(data->n_views, 1);
    assert_int_equal(data->n_lights, 81);
    assert_int_equal(data->top_view, 0);
    enc_data_destroy(&data);
}

RUN_TESTS(NULL, NULL)
