/* Fuzz target: bytes as a list of inputs (encoder/job/batch.h) and as a table of displaced lights
 * (encoder/input/light_positions.h). An accepted list must name inputs and distinct outputs; an accepted table,
 * directions above the horizon.
 *
 * SPDX-License-Identifier: MIT
 */
#include "fuzz.h"

#include "encoder/job/batch.h"
#include "encoder/input/light_positions.h"

#include <math.h>
#include <string.h>

static int messages;

static void count_message(void *user, btf_log_level level, const char *message) {
    (void)user;
    messages += level == BTF_LOG_ERROR && message[0] != 0;
}
static const enc_context context = {.log = {count_message, NULL}, .threads = 1};

static void check_list(const char *path) {
    enc_batch batch;
    messages = 0;
    const btf_result result = enc_batch_read(&context, path, &batch);
    FUZZ_CHECK(messages == (result != BTF_OK) && (batch.count > 0) == (result == BTF_OK));
    for (size_t i = 0; i < batch.count; i++) {
        const char *name = batch.names[i];
        FUZZ_CHECK(name[0] && !strchr(name, '/') && strcmp(name, ".") != 0 && strcmp(name, "..") != 0);
        FUZZ_CHECK(batch.inputs[i][0] && !strchr(batch.inputs[i], '\n'));
        for (size_t j = 0; j < i; j++) {
            FUZZ_CHECK(strcmp(batch.names[j], name) != 0);
        }
    }
    enc_batch_clear(&batch);
}

static void check_table(const char *path, bool clockwise) {
    enc_direction list[4];
    for (int i = 0; i < 4; i++) {
        list[i] = enc_direction_from_angles(i ? 30 : 0, 90 * i);
    }
    enc_data *data = NULL;
    FUZZ_CHECK(enc_data_create(&context, 1, 1, 4, list, 4, list, &data) == BTF_OK);
    const enc_read_options options = {.azimuth_cw = clockwise, .azimuth_offset = clockwise ? 90 : 0};
    messages = 0;
    const btf_result result = enc_coincident_read(&context, path, &options, data);
    FUZZ_CHECK(messages == (result != BTF_OK));
    for (int v = 0; v < 4 && result == BTF_OK; v++) {
        const enc_moved_light *moved = &data->moved_light[v];
        const float *d = moved->actual.xyz;
        FUZZ_CHECK(moved->index < 4);
        if (moved->index < 0) {
            continue;
        }
        FUZZ_CHECK(d[2] > 0 && fabsf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - 1) < 1e-5f);
        FUZZ_CHECK(moved->actual.phi >= 0 && moved->actual.phi < 360);
    }
    enc_data_destroy(&data);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const char *path = fuzz_file(data, size);
    check_list(path);
    check_table(path, size % 2);
    return 0;
}
