/* Section `shaders`: decoding times of random materials.
 *
 * SPDX-License-Identifier: MIT
 */
#include "bench.h"
#include "tests/bench/decode/decode_bench.h"

#include <stdlib.h>

btf_result bench_section_shaders(const bench_run *run) {
    enum { REPEATS = 7 };
    FILE *csv = NULL;
    bench_decode *measured = calloc(1, sizeof *measured);
    if (!measured) {
        return BTF_ERROR_MEMORY;
    }
    btf_result result = bench_decode_run(REPEATS, NULL, 0, &run->context->log, measured);
    if (result == BTF_ERROR_UNSUPPORTED) { /* no context: the other sections still count */
        fprintf(run->summary, "No OpenGL context on this machine.\n\n");
        result = BTF_OK;
    } else if (result == BTF_OK && (result = bench_open(run, "shaders", "csv", &csv)) == BTF_OK) {
        bench_decode_print(measured, run->summary, csv);
        fclose(csv);
    }
    free(measured);
    return result;
}
