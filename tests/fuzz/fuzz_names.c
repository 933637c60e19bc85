/* Fuzz target: bytes as the path of an image, from which its directions are read.
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
    if (size) {
        memcpy(path, data, size);
    }
    path[size] = '\0';
    enc_name name;
    const enc_name_verdict verdict = enc_names_parse(path, &name);
    FUZZ_CHECK((verdict == ENC_NAME_BAD) <= (name.why != NULL && name.bad[0]));
    for (int minus = 0; minus < 2 && verdict == ENC_NAME_READ; minus++) {
        const enc_angles angles = enc_names_angles(&name, minus);
        FUZZ_CHECK(isfinite(angles.theta_light) && isfinite(angles.phi_light));
        FUZZ_CHECK(isfinite(angles.theta_view) && isfinite(angles.phi_view));
    }
    double number = 0;
    if (enc_names_number(path, size % 2, &number)) {
        FUZZ_CHECK(isfinite(number));
    }
    FUZZ_CHECK(!(enc_names_is_image(path) && enc_names_is_foreign_image(path)));
    free(path);
    return 0;
}
