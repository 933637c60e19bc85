/* Fuzz target: the file of a cost model.
 *
 * SPDX-License-Identifier: MIT
 */
#include "fuzz.h"

#include <openbtf/cost.h>

#include <math.h>
#include <string.h>

static void count(void *user, btf_log_level level, const char *message) {
    (void)level;
    (void)message;
    ++*(int *)user;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    int messages = 0;
    const btf_log log = {count, &messages};
    const btf_decode_counts ones = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
    btf_cost_model model;
    char *text = malloc(size ? size : 1); /* of exactly that size, so that a read beyond it is noticed */
    FUZZ_CHECK(text != NULL);
    if (size) {
        memcpy(text, data, size);
    }
    const btf_result result = btf_cost_model_read(text, size, "costs", &log, &model);
    FUZZ_CHECK(result == BTF_OK || (result == BTF_ERROR_BAD_FILE && messages == 1));
    if (result == BTF_OK) {
        const double cost = btf_cost_of(&ones, &model);
        FUZZ_CHECK(isfinite(cost) && cost > 0 && messages == 0);
        FUZZ_CHECK(memchr(model.device, 0, sizeof model.device) != NULL);
#define FUZZ_PRICE(price, name, count) FUZZ_CHECK(model.price >= 0 && model.price <= 1e6);
        BTF_COST_LIST(FUZZ_PRICE)
    }
    free(text);
    return 0;
}
