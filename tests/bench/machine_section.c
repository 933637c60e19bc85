/* Section `machine`: what the processor and its memory could do at best, and how near the encoder's dense
 * kernel comes.
 *
 * SPDX-License-Identifier: MIT
 */
#include "bench.h"

#include "encoder/joint_gemm.h"

#include <stdlib.h>

/* Operations a second of the joint method's tile on operands that fit the first-level cache: k components,
 * all threads, best of some tries. 0: out of memory. */
static double tile_rate(int threads, size_t k) {
    enum { TRIES = 5, CALLS = 40000 };
    const enc_gemm_tile tile = enc_gemm_select();
    double best = 0;
    bool room = true;
    for (int try = 0; try < TRIES && room; try++) {
        const bench_clock start = bench_now();
#pragma omp parallel num_threads(threads)
        {
            float *a = enc_gemm_alloc(ENC_GEMM_M * k), *b = enc_gemm_alloc(ENC_GEMM_N * k);
            float *out = enc_gemm_alloc(ENC_GEMM_M * ENC_GEMM_N);
            if (a && b && out) {
                for (size_t i = 0; i < k * ENC_GEMM_N; i++) {
                    b[i] = 1.0f;
                }
                for (size_t i = 0; i < k * ENC_GEMM_M; i++) {
                    a[i] = 1.0f;
                }
                for (int call = 0; call < CALLS; call++) {
                    tile(k, a, b, out);
                }
            } else {
#pragma omp atomic write
                room = false;
            }
            free(a);
            free(b);
            free(out);
        }
        const double rate =
            2.0 * ENC_GEMM_M * ENC_GEMM_N * (double)k * CALLS * threads / (bench_now().wall - start.wall);
        best = rate > best ? rate : best;
    }
    return room ? best : 0;
}

btf_result bench_section_machine(const bench_run *run) {
    bench_limits limits;
    FILE *csv = NULL;
    btf_result result = bench_limits_measure(run->context, &limits);
    if (result != BTF_OK || (result = bench_open(run, "machine", "csv", &csv)) != BTF_OK) {
        return result;
    }
    const double tiles[] = {tile_rate(run->context->threads, 20), tile_rate(run->context->threads, 96)};
    fprintf(run->summary,
            "%d threads, best of some tries by the clock; a busy machine shows less.\n\n"
            "| limit | measured |\n| --- | --- |\n"
            "| memory, read and written | %.1f GB/s |\n| second-level cache, read and written | %.1f GB/s "
            "|\n| fused multiply-adds, %s | %.1f GFlop/s |\n"
            "| dense tile of the joint method, k = 20 | %.1f GFlop/s, %.0f %% of that |\n"
            "| dense tile of the joint method, k = 96 | %.1f GFlop/s, %.0f %% of that |\n\n",
            run->context->threads, 1e-9 * limits.memory, 1e-9 * limits.cache, limits.vectors,
            1e-9 * limits.flops, 1e-9 * tiles[0], 100 * tiles[0] / limits.flops, 1e-9 * tiles[1],
            100 * tiles[1] / limits.flops);
    fprintf(csv,
            "limit,value,unit\nmemory,%.4g,bytes/s\ncache,%.4g,bytes/s\nfma,%.4g,flop/s\n"
            "tile k=20,%.4g,flop/s\ntile k=96,%.4g,flop/s\n",
            limits.memory, limits.cache, limits.flops, tiles[0], tiles[1]);
    fclose(csv);
    return BTF_OK;
}
