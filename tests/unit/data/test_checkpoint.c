/* Checkpoints (encoder/data/checkpoint.h): a step that was kept is read back, a damaged one counts as missing, a
 * checkpoint of other data or options is refused, and every stage of `--method paper` (encoder/paper/steps.h) and of
 * `--method joint` (encoder/factor/steps.h) gives the same result when it is read from one.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/data/checkpoint.h"
#include "encoder/factor/factor.h"
#include "encoder/factor/steps.h"
#include "encoder/paper/paper.h"
#include "tests/support/image_files.h"
#include "tests/sample/sample.h"
#include "tests/support/messages.h"
#include "tests/support/temporary.h"
#include "tests/support/test.h"

#include <dirent.h>
#include <sys/stat.h>
#include <unistd.h>

static enc_context context = {.log = {keep_message, NULL}, .threads = 1};

static int set_up(void **state) {
    last_message[0] = '\0';
    context.checkpoint = NULL;
    return make_temporary_folder(state);
}

/* Two texels of one view and two lights. */
static enc_data *tiny(float first) {
    const enc_direction view = enc_direction_from_angles(0, 0);
    const enc_direction lights[2] = {enc_direction_from_angles(0, 0), enc_direction_from_angles(30, 0)};
    enc_data *data = NULL;
    assert_int_equal(enc_data_create(&context, 2, 1, 1, &view, 2, lights, &data), BTF_OK);
    data->samples[0] = first;
    return data;
}

static btf_result open_for(float first, const char *options, bool resume) {
    enc_data *data = tiny(first);
    const btf_result result =
        enc_checkpoint_open(&context, temporary_folder, options, data, resume, &context.checkpoint);
    enc_data_destroy(&data);
    return result;
}

static void put_numbers(const char *name, int from, int count) {
    enc_blob blob = {0};
    for (int i = 0; i < count; i++) {
        const int number = from + i;
        enc_blob_put(&blob, &number, sizeof number);
    }
    assert_int_equal(enc_checkpoint_put(&context, name, &blob), BTF_OK);
    assert_null(blob.bytes);
}

static bool get_numbers(const char *name, int from, int count) {
    enc_blob blob;
    if (!enc_checkpoint_get(&context, name, &blob)) {
        return false;
    }
    for (int i = 0; i < count; i++) {
        int number;
        enc_blob_take(&blob, &number, sizeof number);
        assert_false(blob.failed);
        assert_int_equal(number, from + i);
    }
    int more = 1;
    enc_blob_take(&blob, &more, sizeof more);
    assert_true(blob.failed);
    assert_int_equal(more, 0);
    enc_blob_clear(&blob);
    return true;
}

TEST_WITH(test_keeps, set_up, remove_temporary_folder) {
    enc_blob blob = {0};
    assert_false(
        enc_checkpoint_get(&context, "a", &blob)); /* without a checkpoint: nothing, and no error */
    put_numbers("a", 1, 1);
    assert_int_equal(open_for(0.5f, "x=1", false), BTF_OK);
    assert_false(enc_checkpoint_get(&context, "a", &blob));
    put_numbers("a", 10, 5000);
    put_numbers("b", 20, 3);
    put_numbers("b", 30, 0);
    put_numbers("b", 40, 2); /* replaces the first */
    assert_true(get_numbers("a", 10, 5000));
    enc_checkpoint_close(&context.checkpoint, false);
    assert_int_equal(open_for(0.5f, "x=1", true), BTF_OK);
    assert_true(get_numbers("a", 10, 5000));
    assert_true(get_numbers("b", 40, 2));
    enc_checkpoint_close(&context.checkpoint, true);
    assert_int_equal(access(temporary_folder, F_OK), -1);
}

TEST_WITH(test_whose, set_up, remove_temporary_folder) {
    assert_int_equal(open_for(0.5f, "x=1", true), BTF_OK); /* there is none yet: no error */
    put_numbers("a", 1, 3);
    enc_checkpoint_close(&context.checkpoint, false);
    assert_int_equal(open_for(0.5f, "x=1", false), BTF_ERROR_USAGE);
    assert_non_null(strstr(last_message, "--resume"));
    assert_int_equal(open_for(0.5f, "x=2", true), BTF_ERROR_USAGE);
    assert_non_null(strstr(last_message, "other data, of other options"));
    assert_int_equal(open_for(0.25f, "x=1", true), BTF_ERROR_USAGE);
    assert_non_null(strstr(last_message, temporary_folder));
    assert_int_equal(open_for(0.5f, "x=1", true), BTF_OK);
    enc_checkpoint_close(&context.checkpoint, false);
}

/* A step that is cut short anywhere, or has any byte changed, counts as missing. */
TEST_WITH(test_damage, set_up, remove_temporary_folder) {
    char path[320];
    size_t size;
    assert_int_equal(open_for(0.5f, "x=1", false), BTF_OK);
    put_numbers("a", 7, 9);
    snprintf(path, sizeof path, "%s/a.btf-step", temporary_folder);
    unsigned char *bytes = read_whole_file(path, &size);
    enc_blob blob;
    for (size_t i = 0; i < size; i++) {
        write_whole_file(path, bytes, i);
        last_message[0] = '\0';
        assert_false(enc_checkpoint_get(&context, "a", &blob));
        assert_non_null(strstr(last_message, "a.btf-step"));
        bytes[i] ^= 1;
        write_whole_file(path, bytes, size);
        bytes[i] ^= 1;
        assert_false(enc_checkpoint_get(&context, "a", &blob));
    }
    write_whole_file(path, bytes, size);
    assert_true(get_numbers("a", 7, 9));
    free(bytes);
    enc_checkpoint_close(&context.checkpoint, true);
}

/* A relief that a few directions see. */
static enc_data *bricks(void) {
    enc_direction list[7] = {enc_direction_from_angles(0, 0)};
    for (int i = 0; i < 6; i++) {
        list[1 + i] = enc_direction_from_angles(45, 60 * i);
    }
    const sample_options options = {
        .width = 12, .height = 12, .grid = 128, .views = list, .lights = list, .n_views = 7, .n_lights = 7};
    enc_data *data = NULL;
    assert_int_equal(sample_render(&options, &data, NULL), BTF_OK);
    return data;
}

/* Checks that all steps are kept, and removes all but the first `left`. */
static void leave_steps(const char *const *steps, int count, int left) {
    for (int i = 0; i < count; i++) {
        char path[320];
        snprintf(path, sizeof path, "%s/%s.btf-step", temporary_folder, steps[i]);
        assert_int_equal(access(path, F_OK), 0);
        if (i >= left) {
            remove(path);
        }
    }
}

/* The method after all steps, after each number of them, and without. */
TEST_WITH(test_paper, set_up, remove_temporary_folder) {
    enc_data *data = bricks();
    const enc_paper_options paper = enc_paper_options_default();
    static const char *const steps[] = {"fit", "shadow", "flow", "refine", "cluster"};
    enc_solution plain;
    enc_paper_stats stats;
    assert_int_equal(enc_paper(&context, data, &paper, &plain, NULL, &stats), BTF_OK);
    assert_true(plain.n_centres > 0);
    assert_int_equal(
        enc_checkpoint_open(&context, temporary_folder, "paper", data, false, &context.checkpoint), BTF_OK);
    /* the first encode finds no step, the next all of them, the others ever fewer */
    for (int left = 5; left >= -1; left--) {
        enc_solution found;
        assert_int_equal(enc_paper(&context, data, &paper, &found, NULL, &stats), BTF_OK);
        const size_t texels = enc_solution_texels(&found), points = texels * 7;
        assert_memory_equal(found.sbrdf->values, plain.sbrdf->values,
                            texels * enc_sbrdf_stride(3, false) * sizeof(float));
        assert_memory_equal(found.shadow, plain.shadow, texels * 7);
        assert_memory_equal(found.shift, plain.shift, 2 * points);
        assert_memory_equal(found.gain, plain.gain, points);
        assert_memory_equal(found.centre, plain.centre, points * sizeof *plain.centre);
        assert_int_equal(found.n_centres, plain.n_centres);
        assert_memory_equal(found.centre_codes, plain.centre_codes, plain.n_centres * 21);
        enc_solution_clear(&found);
        leave_steps(steps, 5, left);
    }
    enc_checkpoint_close(&context.checkpoint, true);
    enc_solution_clear(&plain);
    enc_data_destroy(&data);
}

static void compare_factors(const enc_factors *a, const enc_factors *b) {
    const size_t texels = (size_t)a->width * (size_t)a->height, points = texels * (size_t)a->n_views;
    assert_int_equal(a->n_units, b->n_units);
    assert_memory_equal(a->classes, b->classes, sizeof a->classes);
    assert_memory_equal(a->texels, b->texels, 16 * texels * (size_t)a->n_u_texels);
    assert_memory_equal(a->directions, b->directions,
                        (size_t)16 * (size_t)a->n_units * (size_t)a->n_views * (size_t)a->n_lights);
    assert_memory_equal(a->scales, b->scales, (size_t)16 * (size_t)a->n_units);
    assert_int_equal(!a->shift, !b->shift);
    if (a->shift) {
        assert_memory_equal(a->shift, b->shift, 2 * points);
        assert_memory_equal(a->gain, b->gain, points);
    }
    assert_true(a->trials[1].error.srgb == b->trials[1].error.srgb && a->bytes == b->bytes);
}

enum { BUDGET = 6500 };
static const enc_factor_options both = {
    .budget = BUDGET, .sweeps = 2, .match = ENC_FACTOR_CHOOSE_MATCH, .gain = true};

/* The same for factors, without match and with it. */
TEST_WITH(test_factors, set_up, remove_temporary_folder) {
    static const char *const steps[] = {"components-0", "factors-0", "match-0", "matched-0"};
    enc_data *data = bricks();
    enc_factors *plain;
    assert_int_equal(enc_factor_encode(&context, data, &both, &plain), BTF_OK);
    assert_int_equal(plain->n_trials, 2);
    assert_false(plain->trials[1].omitted);
    assert_int_equal(enc_checkpoint_open(&context, temporary_folder, "x", data, false, &context.checkpoint),
                     BTF_OK);
    for (int left = 4; left >= -1; left--) {
        enc_factors *found;
        assert_int_equal(enc_factor_encode(&context, data, &both, &found), BTF_OK);
        compare_factors(found, plain);
        enc_factors_destroy(&found);
        leave_steps(steps, 4, left);
    }
    enc_checkpoint_close(&context.checkpoint, true);
    enc_factors_destroy(&plain);
    enc_data_destroy(&data);
}

/* Components of a checkpoint are used, unless they or their plan are unusable. */
TEST_WITH(test_wrong_components, set_up, remove_temporary_folder) {
    enc_data *data = bricks();
    const enc_factor_matrix m = enc_factor_matrix_of(&context, data);
    enc_components found[ENC_FACTOR_CHANNELS] = {{0}}, taken[ENC_FACTOR_CHANNELS] = {{0}};
    const size_t rank[ENC_FACTOR_CHANNELS] = {10, 4, 4};
    const enc_unspent unspent = {0};
    enc_factor_plan good = {{{2, 1, 1}}}, plan;
    enc_unspent out;
    assert_int_equal(enc_checkpoint_open(&context, temporary_folder, "x", data, false, &context.checkpoint),
                     BTF_OK);
    assert_int_equal(enc_components_find(&m, rank, 1, found), BTF_OK);
    for (int wrong = 0; wrong < 4; wrong++) {
        const float u = found[0].u[3];
        plan = good;
        plan.words[1][0] += wrong == 1 ? 40 : 0; /* calls for more components than there are */
        plan.words[0][0] += wrong == 2;          /* leaves a unit incomplete */
        found[0].u[3] = wrong == 3 ? NAN : u;
        assert_int_equal(enc_factor_keep_components(&m, 0, found, &plan, &unspent), BTF_OK);
        assert_int_equal(enc_factor_take_components(&m, 0, taken, &plan, &out), wrong == 0);
        found[0].u[3] = u;
        assert_int_equal(taken[0].rank, wrong == 0 ? 10 : 0);
        for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
            enc_components_clear(&taken[c]);
        }
    }
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        enc_components_clear(&found[c]);
    }
    enc_checkpoint_close(&context.checkpoint, true);
    enc_data_destroy(&data);
}

RUN_TESTS(NULL, NULL)
