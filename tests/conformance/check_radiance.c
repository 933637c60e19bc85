/* Radiance against the reference: bit for bit with exact math, as an error with fast math.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cases.h"
#include "check_internal.h"
#include "decoder/toolkit/reference_view.h"
#include "variant.h"

#include <math.h>
#include <stdlib.h>

/* Calls the entry point for nearest directions, which replaces the macro that selects them. */
static const char body_nearest[] =
    "uvec4 check(uvec4 a, uvec4 b) {\n"
    "    vec2 uv = uintBitsToFloat(a.xy);\n"
    "    vec3 l = vec3(uintBitsToFloat(a.zw), uintBitsToFloat(b.x));\n"
    "    return uvec4(floatBitsToUint(btf_evaluate_nearest(uv, l, uintBitsToFloat(b.yzw))), 0u);\n"
    "}\n";

/* Element i of a batch, in column i % GPU_SIDE, asks for level element_level(). */
static const char body_level[] =
    "uvec4 check(uvec4 a, uvec4 b) {\n"
    "    vec2 uv = uintBitsToFloat(a.xy);\n"
    "    vec3 l = vec3(uintBitsToFloat(a.zw), uintBitsToFloat(b.x));\n"
    "    int level = int(gl_FragCoord.x) % (int(BTF_LEVELS) + 2) - 1;\n"
    "    return uvec4(floatBitsToUint(btf_evaluate_level(uv, l, uintBitsToFloat(b.yzw), level)), 0u);\n"
    "}\n";

/* The level that the decoder must take for element i, which asks for one of -1 .. levels. */
static uint32_t element_level(size_t i, uint32_t levels) {
    uint32_t asked = (uint32_t)(i % GPU_SIDE % (levels + 2)); /* the level that is asked for, plus 1 */
    return asked == 0 ? 0 : asked > levels ? levels - 1 : asked - 1;
}

static void reference(const btf_ref_material *material, const btf_ref_options *options,
                      const uint32_t *input, uint32_t *out) {
    float f[CASE_WORDS], rgb[3];
    memcpy(f, input, sizeof f);
    btf_ref_evaluate(material, options, f[0], f[1], f + 2, f + 5, rgb);
    memcpy(out, rgb, sizeof rgb);
    out[3] = 0;
}

btf_result check_radiance(const check_subject *subject, uint64_t seed, uint64_t count,
                          check_outcome *outcome) {
    check_session session;
    /* Half of the nearest variants go through the entry of that name. */
    btf_shader_options shader = *subject->shader;
    check_subject altered = *subject;
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(subject->material, &info);
    btf_ref_material levels[BTF_MAX_LEVELS];
    for (uint32_t level = 0; level < info.levels; ++level) {
        reference_view(subject->material, level, &levels[level]);
    }
    int by_entry = shader.interpolation == BTF_INTERPOLATION_NEAREST && (seed & 1) && info.levels == 1;
    btf_ref_options options = variant_reference_options(&shader);
    if (by_entry) {
        shader.interpolation = BTF_INTERPOLATION_LINEAR;
    }
    altered.shader = &shader;
    btf_result result = check_begin(&altered,
                                    info.levels > 1 ? body_level
                                    : by_entry      ? body_nearest
                                                    : gpu_evaluate_body,
                                    &session);
    if (result != BTF_OK) {
        return result;
    }
    random_state r = {seed};
    const uint64_t batch = (uint64_t)GPU_SIDE * GPU_SIDE;
    for (uint64_t first = 0; first < count && result == BTF_OK; first += batch) {
        size_t n = (size_t)(count - first < batch ? count - first : batch);
        for (size_t i = 0; i < n; ++i) {
            uint32_t level = info.levels > 1 ? element_level(i, info.levels) : 0;
            case_make(&r, subject->material, session.inputs + GPU_INPUTS * i);
            reference(&levels[level], &options, session.inputs + GPU_INPUTS * i,
                      session.expected + GPU_OUTPUTS * i);
        }
        result = check_batch(&session, "radiance", first, n, 3, outcome);
    }
    check_end(&session);
    return result;
}

/* The rank of a float among all floats, so that differences of ranks are ULP. */
static int64_t place(uint32_t bits) {
    return bits >> 31 ? -(int64_t)(bits & 0x7FFFFFFFu) : (int64_t)bits;
}

static void add_error(check_fast *f, uint32_t exact_bits, uint32_t fast_bits) {
    int64_t ulp = llabs(place(exact_bits) - place(fast_bits));
    int bin = 0;
    while (bin < 33 && ulp >> bin) {
        ++bin;
    }
    f->ulp_counts[bin]++;
    double exact = (double)float_of_bits(exact_bits),
           absolute = fabs((double)float_of_bits(fast_bits) - exact);
    double relative = absolute / fmax(exact, 0x1p-10);
    f->worst_absolute = fmax(f->worst_absolute, absolute);
    f->worst_relative = fmax(f->worst_relative, relative);
    f->mean_relative += relative;
    f->beyond += relative > CHECK_FAST_BOUND;
}

btf_result check_fast_math(const check_subject *subject, uint64_t seed, uint64_t count, check_fast *out) {
    check_session session;
    btf_result result = check_begin(subject, gpu_evaluate_body, &session);
    if (result != BTF_OK) {
        return result;
    }
    btf_ref_options options = variant_reference_options(subject->shader);
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(subject->material, &info);
    random_state r = {seed};
    const uint64_t batch = (uint64_t)GPU_SIDE * GPU_SIDE;
    for (uint64_t first = 0; first < count && result == BTF_OK; first += batch) {
        size_t n = (size_t)(count - first < batch ? count - first : batch);
        for (size_t i = 0; i < n; ++i) {
            float f[CASE_WORDS];
            f[0] = (float)random_between(&r, 0, 1);
            f[1] = (float)random_between(&r, 0, 1);
            for (int d = 2; d < 8; d += 3) {
                double z = random_between(&r, 0.05, 1), phi = random_between(&r, 0, 2 * M_PI),
                       s = sqrt(1 - z * z);
                f[d] = (float)(s * cos(phi));
                f[d + 1] = (float)(s * sin(phi));
                f[d + 2] = (float)z;
            }
            memcpy(session.inputs + GPU_INPUTS * i, f, sizeof f);
            reference(&session.reference, &options, session.inputs + GPU_INPUTS * i,
                      session.expected + GPU_OUTPUTS * i);
        }
        result = gpu_run(subject->gpu, session.program, n, session.inputs, session.actual, subject->log);
        for (size_t i = 0; i < n && result == BTF_OK; ++i) {
            for (int c = 0; c < 3; ++c) {
                add_error(out, session.expected[GPU_OUTPUTS * i + (size_t)c],
                          session.actual[GPU_OUTPUTS * i + (size_t)c]);
            }
        }
        out->evaluated += n;
    }
    check_end(&session);
    return result;
}
