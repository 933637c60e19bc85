/* Fuzz target: what the path of an image says of its directions.
 *
 * SPDX-License-Identifier: MIT
 */
#include "fuzz.h"

#include "encoder/input/names.h"

#include <math.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    char *path = malloc(size + 1);
    FUZZ_CHECK(path != NULL);
    if (size)
        memcpy(path, data, size);
    path[size] = '\0';
    enc_angles angles = {0};
    if (enc_names_parse(path, &angles)) {
        FUZZ_CHECK(isfinite(angles.theta_light) && isfinite(angles.phi_light));
        FUZZ_CHECK(isfinite(angles.theta_view) && isfinite(angles.phi_view));
    }
    enc_names_is_image(path);
    free(path);
    return 0;
}
