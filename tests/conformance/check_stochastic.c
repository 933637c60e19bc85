/* Stochastic decode against the reference, bit for bit: given random numbers, and the blend that they
 * converge to.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cases.h"
#include "check_internal.h"
#include "decoder/toolkit/reference_view.h"
#include "variant.h"

#include <stdio.h>

/* Columns of elements alternate between a choice and the blend of all. CHECK_KIND is 0 for the entry points of level 0,
 * 1 for those of a level, 2 for those between two. Of the columns with choices, one in eight has random numbers whose
 * bits are all ones or all zeros, and one in eight an arbitrary float as the level. */
static const char body[] =
    "uvec4 check(uvec4 a, uvec4 b) {\n"
    "    vec2 uv = uintBitsToFloat(a.xy);\n"
    "    vec3 l = vec3(uintBitsToFloat(a.zw), uintBitsToFloat(b.x)), v = uintBitsToFloat(b.yzw);\n"
    "    uvec2 at = uvec2(gl_FragCoord.xy);\n"
    "    uvec3 random = btf_random(uvec3(at, CHECK_SEED));\n"
    "    float level = float(random.y & 0xFFFu) * uintBitsToFloat(0x3B800000u) - 1.0;\n"
    "    if ((at.x & 15u) % 9u == 3u)\n"
    "        level = uintBitsToFloat(random.y);\n"
    "    if ((at.x & 7u) == 5u)\n"
    "        random = uvec3(0u) - (random & 1u);\n"
    "    vec3 radiance;\n"
    "#if CHECK_KIND == 0\n"
    "    if ((at.x & 2u) == 0u)\n"
    "        radiance = btf_evaluate_stochastic(uv, l, v, random);\n"
    "    else\n"
    "        radiance = btf_evaluate_radiance_blend(uv, l, v);\n"
    "#endif\n"
    "#if CHECK_KIND == 1\n"
    "    int whole = int(at.x) % (int(BTF_LEVELS) + 2) - 1;\n"
    "    if ((at.x & 2u) == 0u)\n"
    "        radiance = btf_evaluate_stochastic_level(uv, l, v, whole, random);\n"
    "    else\n"
    "        radiance = btf_evaluate_radiance_blend_level(uv, l, v, whole);\n"
    "#endif\n"
    "#if CHECK_KIND == 2\n"
    "    if ((at.x & 2u) == 0u)\n"
    "        radiance = btf_evaluate_stochastic_between(uv, l, v, level, random);\n"
    "    else\n"
    "        radiance = btf_evaluate_radiance_blend_between(uv, l, v, level);\n"
    "#endif\n"
    "    return uvec4(floatBitsToUint(radiance), 0u);\n"
    "}\n";

/* The materials of all levels, and how they are decoded. */
typedef struct subject {
    btf_ref_material levels[BTF_MAX_LEVELS];
    uint32_t count;
    btf_ref_options options;
    int picks, kind;
    uint32_t seed;
} subject;

static void expect(const subject *s, uint32_t x, uint32_t y, const uint32_t *input, uint32_t *out) {
    const uint32_t counter[3] = {x, y, s->seed};
    uint32_t random[3];
    float f[CASE_WORDS], rgb[3];
    memcpy(f, input, sizeof f);
    btf_ref_random(counter, random);
    float level =
        (x & 15) % 9 == 3 ? float_of_bits(random[1]) : (float)(random[1] & 0xFFF) * 0x1p-8f - 1.0f;
    if ((x & 7) == 5) {
        for (int i = 0; i < 3; ++i) {
            random[i] = 0u - (random[i] & 1);
        }
    }
    uint32_t i = 0;
    if (s->kind == 1) {
        const uint32_t asked = x % (s->count + 2); /* the level that is asked for, plus 1 */
        i = asked == 0 ? 0 : asked > s->count ? s->count - 1 : asked - 1;
    }
    if (s->kind == 2 && (x & 2)) {
        btf_ref_evaluate_radiance_blend_between(s->levels, s->count, &s->options, s->picks, level, f[0],
                                                f[1], f + 2, f + 5, rgb);
    } else if (s->kind == 2) {
        btf_ref_evaluate_stochastic_between(s->levels, s->count, &s->options, s->picks, level, f[0], f[1],
                                            f + 2, f + 5, random, rgb);
    } else if (x & 2) {
        btf_ref_evaluate_radiance_blend(&s->levels[i], &s->options, s->picks, f[0], f[1], f + 2, f + 5,
                                        rgb);
    } else {
        btf_ref_evaluate_stochastic(&s->levels[i], &s->options, s->picks, f[0], f[1], f + 2, f + 5, random,
                                    rgb);
    }
    memcpy(out, rgb, sizeof rgb);
    out[3] = 0;
}

btf_result check_stochastic(const check_subject *of, uint64_t seed, uint64_t count,
                            check_outcome *outcome) {
    check_session session;
    btf_shader_options shader = *of->shader;
    check_subject altered = *of;
    subject s = {.seed = (uint32_t)(seed & 0xFFFFFF)};
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(of->material, &info);
    s.count = info.levels;
    for (uint32_t level = 0; level < info.levels; ++level) {
        reference_view(of->material, level, &s.levels[level]);
    }
    if (shader.picks == BTF_PICK_NONE) {
        shader.picks = (btf_picks)(1 + seed / 3 % 3);
    }
    s.picks = (int)shader.picks;
    s.kind = info.levels > 1 ? 1 + (int)(seed % 2) : seed % 8 == 0 ? 2 : 0;
    s.options = variant_reference_options(&shader);
    altered.shader = &shader;
    char text[sizeof body + 100];
    snprintf(text, sizeof text, "#define CHECK_SEED %uu\n#define CHECK_KIND %d\n%s", s.seed, s.kind, body);
    btf_result result = check_begin(&altered, text, &session);
    if (result != BTF_OK) {
        return result;
    }
    random_state r = {seed};
    const uint64_t batch = (uint64_t)GPU_SIDE * GPU_SIDE;
    for (uint64_t first = 0; first < count && result == BTF_OK; first += batch) {
        size_t n = (size_t)(count - first < batch ? count - first : batch);
        for (size_t i = 0; i < n; ++i) {
            uint32_t *input = session.inputs + GPU_INPUTS * i;
            case_make(&r, of->material, input);
            expect(&s, (uint32_t)(i % GPU_SIDE), (uint32_t)(i / GPU_SIDE), input,
                   session.expected + GPU_OUTPUTS * i);
        }
        result = check_batch(&session, "stochastic", first, n, 3, outcome);
    }
    check_end(&session);
    return result;
}
