/* Ranks that encode together (encoder/base/ranks.h): slices, transfers, failures; and that a joint and a
 * paper analysis by several ranks has the bits of one. The ranks are threads of this process, and their
 * transport is memory.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/base/ranks.h"
#include "encoder/input/notices.h"
#include "encoder/job/settings.h"
#include "tests/support/test.h"

#include <openbtf/material.h>
#include <pthread.h>

enum { MOST_RANKS = 5, SIDE = 12, VIEWS = 7, LIGHTS = 7 };

/* Memory that the ranks share. */
typedef struct room {
    int size;
    pthread_barrier_t barrier;
    uint64_t value[MOST_RANKS];
    void *array[MOST_RANKS];
    const size_t *bounds[MOST_RANKS];
} room;

typedef struct seat {
    room *in;
    int rank;
} seat;

static void meet(const seat *s) {
    pthread_barrier_wait(&s->in->barrier);
}

static void least(void *user, uint64_t *io_value) {
    const seat *s = user;
    s->in->value[s->rank] = *io_value;
    meet(s);
    for (int r = 0; r < s->in->size; r++) {
        *io_value = s->in->value[r] < *io_value ? s->in->value[r] : *io_value;
    }
    meet(s);
}

static void gather(void *user, void *array, const size_t *bounds) {
    const seat *s = user;
    s->in->array[s->rank] = array;
    meet(s);
    for (int r = 0; r < s->in->size; r++) {
        if (r != s->rank) {
            memcpy((char *)array + bounds[r], (char *)s->in->array[r] + bounds[r],
                   bounds[r + 1] - bounds[r]);
        }
    }
    meet(s);
}

static void exchange(void *user, const void *send, const size_t *send_bounds, void *receive,
                     const size_t *receive_bounds) {
    const seat *s = user;
    s->in->array[s->rank] = (void *)(uintptr_t)send;
    s->in->bounds[s->rank] = send_bounds;
    meet(s);
    for (int r = 0; r < s->in->size; r++) {
        const size_t *from = s->in->bounds[r], size = from[s->rank + 1] - from[s->rank];
        assert_int_equal(size, receive_bounds[r + 1] - receive_bounds[r]);
        memcpy((char *)receive + receive_bounds[r], (const char *)s->in->array[r] + from[s->rank], size);
    }
    meet(s);
}

static void sum(void *user, uint64_t *values, size_t count) {
    const seat *s = user;
    uint64_t *mine = malloc(count * sizeof *mine);
    memcpy(mine, values, count * sizeof *mine);
    s->in->array[s->rank] = mine;
    meet(s);
    memset(values, 0, count * sizeof *values);
    for (int r = 0; r < s->in->size; r++) {
        for (size_t i = 0; i < count; i++) {
            values[i] += ((const uint64_t *)s->in->array[r])[i];
        }
    }
    meet(s);
    free(mine);
}

static void broadcast(void *user, void *bytes, size_t size) {
    const seat *s = user;
    s->in->array[s->rank] = bytes;
    meet(s);
    if (s->rank > 0) {
        memcpy(bytes, s->in->array[0], size);
    }
    meet(s);
}

/* One rank: the function that it runs, and its arguments. */
typedef struct member {
    seat at;
    void (*run)(const enc_context *context, void *user);
    void *user;
    char log[512];
} member;

static void keep_message(void *user, btf_log_level level, const char *message) {
    char *log = user;
    if (level == BTF_LOG_ERROR) {
        snprintf(log + strlen(log), 512 - strlen(log), "%s\n", message);
    }
}

static void *run_member(void *argument) {
    member *m = argument;
    const enc_transport transport = {
        m->at.rank, m->at.in->size, m->at.in->size, &m->at, least, gather, exchange, sum, broadcast};
    enc_ranks *ranks = enc_ranks_create(&transport);
    const enc_context context = {
        .log = enc_ranks_log(ranks, (btf_log){keep_message, m->log}), .threads = 1, .ranks = ranks};
    m->run(&context, m->user);
    enc_ranks_destroy(&ranks);
    return NULL;
}

/* Runs `run` on `size` ranks, rank r with users[r]; logs may be NULL. */
static void run_ranks(int size, void (*run)(const enc_context *, void *), void *const *users,
                      char (*logs)[512]) {
    room in = {.size = size};
    member members[MOST_RANKS];
    pthread_t threads[MOST_RANKS];
    pthread_barrier_init(&in.barrier, NULL, (unsigned)size);
    for (int r = 0; r < size; r++) {
        members[r] = (member){{&in, r}, run, users[r], ""};
        assert_int_equal(pthread_create(&threads[r], NULL, run_member, &members[r]), 0);
    }
    for (int r = 0; r < size; r++) {
        pthread_join(threads[r], NULL);
        if (logs) {
            memcpy(logs[r], members[r].log, sizeof logs[r]);
        }
    }
    pthread_barrier_destroy(&in.barrier);
}

TEST(test_alone) {
    size_t first, end, count;
    int values[3] = {1, 2, 3};
    const enc_context context = {.threads = 1};
    const enc_context *const contexts[] = {NULL, &context};
    for (int i = 0; i < 2; i++) {
        const enc_context *c = contexts[i];
        enc_ranks_range(c, 17, &first, &end);
        assert_int_equal(first, 0);
        assert_int_equal(end, 17);
        assert_int_equal(enc_ranks_count(c), 1);
        assert_int_equal(enc_ranks_node_ranks(c), 1);
        assert_true(enc_ranks_leads(c));
        assert_int_equal(enc_ranks_agree(c, BTF_ERROR_IO), BTF_ERROR_IO);
        assert_int_equal(enc_ranks_gather(c, BTF_ERROR_MEMORY, values, sizeof *values, 3),
                         BTF_ERROR_MEMORY);
        assert_int_equal(enc_ranks_gather(c, BTF_OK, values, sizeof *values, 3), BTF_OK);
        assert_int_equal(values[2], 3);
        assert_int_equal(enc_ranks_broadcast(c, BTF_OK, values, sizeof values), BTF_OK);
        assert_true(enc_ranks_all(c, true));
        assert_false(enc_ranks_all(c, false));
        assert_null(enc_ranks_volumes(c, &count));
        assert_int_equal(count, 0);
    }
}

/* The slices of the ranks cover a range once, in order, and their sizes differ by at most one. */
static void check_ranges(const enc_context *context, void *user) {
    (void)user;
    const size_t size = (size_t)enc_ranks_count(context);
    for (size_t count = 0; count < 40; count++) {
        size_t before = 0, first, end;
        for (size_t r = 0; r < size; r++) {
            enc_ranks_range_of(context, (int)r, count, &first, &end);
            assert_int_equal(first, before);
            assert_true(end - first == count / size || end - first == count / size + 1);
            before = end;
        }
        assert_int_equal(before, count);
        enc_ranks_range(context, count, &first, &end);
        enc_ranks_range_of(context, enc_ranks_own(context), count, &before, &before);
        assert_int_equal(end, before);
    }
}

static void check_transfers(const enc_context *context, void *user) {
    (void)user;
    const size_t size = (size_t)enc_ranks_count(context), rank = (size_t)enc_ranks_own(context);
    uint16_t items[11][2], text = rank == 0 ? 4711 : 0;
    size_t first, end;
    memset(items, 0, sizeof items);
    enc_ranks_range(context, 11, &first, &end);
    for (size_t i = first; i < end; i++) {
        items[i][0] = (uint16_t)(100 + i);
    }
    assert_int_equal(enc_ranks_gather(context, BTF_OK, items, sizeof items[0], 11), BTF_OK);
    for (size_t i = 0; i < 11; i++) {
        assert_int_equal(items[i][0], 100 + i);
    }

    /* rank r hands s + 1 floats to rank s, which finds its own rank + 1 floats of each */
    float send[MOST_RANKS * MOST_RANKS], receive[MOST_RANKS * MOST_RANKS];
    size_t out[MOST_RANKS + 1] = {0}, in[MOST_RANKS + 1] = {0};
    for (size_t s = 0; s < size; s++) {
        out[s + 1] = out[s] + s + 1;
        in[s + 1] = in[s] + rank + 1;
        for (size_t i = out[s]; i < out[s + 1]; i++) {
            send[i] = (float)(100 * rank + 10 * s + i - out[s]);
        }
    }
    assert_int_equal(enc_ranks_exchange(context, BTF_OK, send, out, receive, in), BTF_OK);
    for (size_t s = 0; s < size; s++) {
        for (size_t i = 0; i <= rank; i++) {
            assert_true(receive[in[s] + i] == (float)(100 * s + 10 * rank + i));
        }
    }

    uint64_t sums[2] = {rank, 1};
    assert_int_equal(enc_ranks_sum(context, BTF_OK, sums, 2), BTF_OK);
    assert_int_equal(sums[0], size * (size - 1) / 2);
    assert_int_equal(sums[1], size);
    assert_int_equal(enc_ranks_broadcast(context, BTF_OK, &text, sizeof text), BTF_OK);
    assert_int_equal(text, 4711);
    assert_true(enc_ranks_all(context, true));
    assert_true(enc_ranks_all(context, rank + 1 < size) == (size == 0));

    size_t count;
    const enc_ranks_volume *volume = enc_ranks_volumes(context, &count);
    assert_int_equal(count, 1);
    const size_t others = size - 1, items_of_others = sizeof items - (end - first) * sizeof items[0];
    assert_int_equal(volume->received, items_of_others + others * (rank + 1) * sizeof(float) + sizeof sums +
                                           (rank > 0 ? sizeof text : 0));
}

TEST(test_ranges_and_transfers) {
    void *const users[MOST_RANKS] = {NULL};
    for (int size = 1; size <= MOST_RANKS; size++) {
        run_ranks(size, check_ranges, users, NULL);
        run_ranks(size, check_transfers, users, NULL);
    }
}

static void keep_all(void *user, btf_log_level level, const char *message) {
    char *log = user;
    (void)level;
    snprintf(log + strlen(log), 512 - strlen(log), "%s\n", message);
}

/* Warnings about images are told with the counts of all ranks; user is this rank's log. */
static void check_notices(const enc_context *context, void *user) {
    enc_notices *notices = enc_notices_create();
    const int rank = enc_ranks_own(context);
    enc_context mine = *context;
    char name[16];
    mine.log = (btf_log){keep_all, user};
    snprintf(name, sizeof name, "%d.png", 9 - rank);
    enc_notices_add(notices, BTF_LOG_WARNING, "profile", name, "a profile");
    if (rank == 1) {
        enc_notices_add(notices, BTF_LOG_WARNING, "gamma", name, "a gamma");
    }
    assert_int_equal(enc_notices_tell(&mine, BTF_OK, notices, "set"), BTF_OK);
    enc_notices_destroy(&notices);
}

TEST(test_notices) {
    char logs[3][512] = {"", "", ""};
    run_ranks(3, check_notices, (void *[]){logs[0], logs[1], logs[2]}, NULL);
    for (int r = 0; r < 3; r++) {
        assert_string_equal(logs[r], "set: 8.png: a gamma\nset: 3 images: 7.png: a profile\n");
    }
}

/* Rank 2 fails where the others have a gather before them, and says why; all leave with its result. */
static void fail_one(const enc_context *context, void *user) {
    (void)user;
    int values[4] = {0};
    btf_result result = BTF_OK;
    enc_ranks_begin(context);
    if (enc_ranks_own(context) == 2) {
        result = enc_fail(context, BTF_ERROR_BAD_FILE, "image 7: bad");
    } else {
        result = enc_ranks_gather(context, BTF_OK, values, sizeof *values, 4);
    }
    if (enc_ranks_own(context) != 2) {
        assert_int_equal(result, BTF_ERROR_BAD_FILE);
    }
    assert_int_equal(enc_ranks_agree(context, result), BTF_ERROR_BAD_FILE);
    assert_int_equal(enc_ranks_agree(context, BTF_OK), BTF_ERROR_BAD_FILE); /* no rank waits for another */
    assert_false(enc_ranks_all(context, true));
    enc_ranks_begin(context); /* the next job is not affected */
    assert_int_equal(enc_ranks_agree(context, BTF_OK), BTF_OK);
}

/* All ranks fail in the same way: rank 0 alone logs it, once. */
static void fail_all(const enc_context *context, void *user) {
    (void)user;
    const btf_result result = enc_fail(context, BTF_ERROR_IO, "data: not there");
    assert_int_equal(enc_ranks_agree(context, result), BTF_ERROR_IO);
}

TEST(test_failures) {
    void *const users[MOST_RANKS] = {NULL};
    char logs[MOST_RANKS][512];
    run_ranks(4, fail_one, users, logs);
    for (int r = 0; r < 4; r++) {
        assert_string_equal(logs[r], r == 2 ? "rank 2: image 7: bad\n" : "");
    }
    run_ranks(3, fail_all, users, logs);
    for (int r = 0; r < 3; r++) {
        assert_string_equal(logs[r], r == 0 ? "data: not there\n" : "");
    }
}

/* A relief's BTF without a relief: lobes that turn with the texel, shifted from view to view, and noise, so
 * that nothing is found exactly. still: texels stay where they are. stray: one value in 97 is far beyond
 * the others. */
static void fill(const enc_context *context, bool still, bool stray, enc_data *data) {
    size_t first, end;
    const size_t stride = enc_data_texel_stride(data);
    float *texel = malloc(stride * sizeof *texel);
    enc_ranks_range(context, enc_data_texel_count(data), &first, &end);
    for (size_t t = first; t < end; t++) {
        for (size_t v = 0; v < VIEWS; v++) {
            const size_t at = (t + (still ? 0 : 3 * v)) % (SIDE * SIDE);
            for (size_t c = 0; c < 3; c++) {
                for (size_t l = 0; l < LIGHTS; l++) {
                    const float *light = data->lights[l].xyz;
                    const float tilt = 0.5f * sinf((float)(at % SIDE)) * light[0] + 0.3f * light[1];
                    const float wave = 0.5f + 0.4f * cosf(0.9f * (float)at + (float)c);
                    const uint32_t mixed = (uint32_t)(((t * VIEWS + v) * 3 + c) * LIGHTS + l) * 2654435761u;
                    const float noise = (float)(mixed >> 16) / 65536.0f;
                    texel[(v * 3 + c) * LIGHTS + l] =
                        stray && mixed % 97 == 0
                            ? 65504.0f
                            : light[2] * wave * fmaxf(0.1f + tilt, 0.02f) + 0.05f * noise;
                }
            }
        }
        assert_int_equal(enc_data_store_texels(context, data, t, 1, texel), BTF_OK);
    }
    free(texel);
}

static enc_data *make_data(const enc_context *context, bool still, bool stray) {
    enc_direction list[VIEWS];
    enc_data *data = NULL;
    for (int i = 0; i < VIEWS; i++) {
        list[i] = enc_direction_from_angles(i ? 40.0 : 0.0, i ? 60.0 * (i - 1) : 0.0);
    }
    assert_int_equal(enc_data_create(context, SIDE, SIDE, VIEWS, list, LIGHTS, list, &data), BTF_OK);
    fill(context, still, stray, data);
    assert_int_equal(enc_data_complete(context, data, BTF_OK), BTF_OK);
    return data;
}

/* The result of an analysis. */
typedef struct found {
    bool paper, stray, match;
    enc_solution solution;
    size_t received;
} found;

static void analyse(const enc_context *context, void *user) {
    found *f = user;
    enc_data *data = make_data(context, f->paper, f->stray);
    if (f->paper) {
        enc_paper_options options = enc_paper_options_default();
        enc_paper_stats stats;
        options.effects &= ~(uint32_t)BTF_EFFECT_SHIFT; /* OpenCV's flow has threads of its own */
        options.effects &= ~(uint32_t)BTF_EFFECT_HIDDEN;
        options.fallback = true;
        assert_int_equal(enc_paper(context, data, &options, &f->solution, NULL, &stats), BTF_OK);
        assert_int_equal(stats.diffuse, f->stray);
    } else {
        const enc_job job = {.joint = enc_joint_options_default()};
        enc_factors_settings settings =
            enc_settings_of_factors(&job, data->width, data->height, data->n_views, data->n_lights);
        enc_factors_stats stats;
        settings.choose = !f->match;
        if (f->match) {
            settings.effects = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL;
            settings.budget = 60000;
        }
        assert_int_equal(enc_factors_solve(context, data, &settings, &f->solution, &stats), BTF_OK);
    }
    enc_data_destroy(&data);
    size_t count;
    const enc_ranks_volume *volumes = enc_ranks_volumes(context, &count);
    for (size_t i = 0; i < count; i++) {
        f->received += volumes[i].received;
    }
}

static void compare(const enc_solution *a, const enc_solution *b) {
    const size_t texels = SIDE * SIDE, points = texels * VIEWS;
    assert_int_equal(a->effects, b->effects);
    assert_int_equal(!a->sbrdf, !b->sbrdf);
    if (a->sbrdf) {
        assert_memory_equal(a->sbrdf->values, b->sbrdf->values,
                            texels * enc_sbrdf_stride(a->sbrdf->lobes, a->sbrdf->rgb) *
                                sizeof *a->sbrdf->values);
    }
    if (a->shadow) {
        assert_memory_equal(a->shadow, b->shadow, texels * LIGHTS);
    }
    if (a->shift) {
        assert_memory_equal(a->shift, b->shift, 2 * points);
    }
    if (a->gain) {
        assert_memory_equal(a->gain, b->gain, points);
    }
    assert_int_equal(a->factors.units, b->factors.units);
    if (a->factors.units > 0) {
        assert_memory_equal(a->factors.texels, b->factors.texels, 16 * texels * a->factors.layers);
        assert_memory_equal(a->factors.directions, b->factors.directions,
                            (size_t)16 * VIEWS * LIGHTS * a->factors.units);
        assert_memory_equal(a->factors.scales, b->factors.scales, 16 * a->factors.units);
    }
}

static void check_bits(found alone, const int *sizes, int count) {
    const enc_context context = {.threads = 1};
    analyse(&context, &alone);
    assert_true(alone.paper || alone.solution.factors.units > 0);
    assert_true(!alone.match || alone.solution.shift);
    for (int i = 0; i < count; i++) {
        found each[MOST_RANKS];
        void *users[MOST_RANKS];
        for (int r = 0; r < sizes[i]; r++) {
            each[r] = alone;
            each[r].solution = (enc_solution){0};
            users[r] = &each[r];
        }
        run_ranks(sizes[i], analyse, users, NULL);
        for (int r = 0; r < sizes[i]; r++) {
            compare(&alone.solution, &each[r].solution);
            assert_true(each[r].received > 0);
            enc_solution_clear(&each[r].solution);
        }
    }
    enc_solution_clear(&alone.solution);
}

TEST(test_joint_has_the_bits_of_one) {
    const int sizes[] = {2, 3};
    check_bits((found){.stray = false}, sizes, 2);
    check_bits((found){.match = true}, sizes, 2);
}

TEST(test_paper_has_the_bits_of_one) {
    const int sizes[] = {2, 5};
    check_bits((found){.paper = true}, sizes, 2);
    check_bits((found){.paper = true, .stray = true}, sizes, 2); /* with the diffuse fallback */
}

/* The worse of two results is the same whichever thread comes first, and only what went well twice is BTF_OK. */
TEST(test_keeps_the_worse_result) {
    for (int a = BTF_OK; a <= BTF_ERROR_INTERRUPTED; a++) {
        for (int b = BTF_OK; b <= BTF_ERROR_INTERRUPTED; b++) {
            btf_result first = (btf_result)a, second = (btf_result)b;
            enc_keep_worse(&first, (btf_result)b);
            enc_keep_worse(&second, (btf_result)a);
            assert_int_equal(first, second);
            assert_true(first == (btf_result)a || first == (btf_result)b);
            assert_true((first == BTF_OK) == (a == BTF_OK && b == BTF_OK));
        }
    }
    btf_result result = BTF_ERROR_MEMORY;
    enc_keep_worse(&result, BTF_ERROR_IO);
    assert_int_equal(result, BTF_ERROR_IO);
    enc_keep_worse(&result, BTF_ERROR_INTERRUPTED);
    assert_int_equal(result, BTF_ERROR_INTERRUPTED);
}

RUN_TESTS(NULL, NULL)
