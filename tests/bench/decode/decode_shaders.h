/* GLSL of the decode benchmark: bodies for gpu_program, each `uvec4 check(uvec4 a, uvec4 b)`.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_DECODE_SHADERS_H
#define OPENBTF_TESTS_BENCH_DECODE_SHADERS_H

/* Inputs: u, v, light, view. */
static const char bench_body_decode[] =
    "uvec4 check(uvec4 a, uvec4 b) {\n"
    "    vec2 uv = uintBitsToFloat(a.xy);\n"
    "    vec3 l = vec3(uintBitsToFloat(a.zw), uintBitsToFloat(b.x));\n"
    "    return uvec4(floatBitsToUint(btf_evaluate(uv, l, uintBitsToFloat(b.yzw))), 0u);\n"
    "}\n";

/* The same fetches, added up: texel in a.xy; of views, then lights, the first two neighbours in a.zw, the
 * third and the records that a look-up tries in b.xy, the addresses of the first records in b.zw. */
static const char bench_body_floor[] =
    "uint floor_table(highp usampler2D table, uint first, uint tried) {\n"
    "    uvec4 sum = btf_table(table, first >> 1u);\n"
    "    for (uint i = 0u; i < tried; ++i, first += 3u)\n"
    "        sum += btf_table(table, first) + btf_table(table, first + 1u);\n"
    "    sum += btf_table(table, first - 1u);\n"
    "    return sum.x + sum.y + sum.z + sum.w;\n"
    "}\n"
    "uvec4 check(uvec4 a, uvec4 b) {\n"
    "    uvec3 views = uvec3(a.z, a.z >> 16u, b.x) & 65535u, lights = uvec3(a.w, a.w >> 16u, b.y) & "
    "65535u;\n"
    "    uint t = floor_table(btf_view_table, b.z, b.x >> 16u);\n"
    "    t += floor_table(btf_light_table, b.w, b.y >> 16u);\n"
    "    vec4 s = vec4(0.0);\n"
    "    const int n = BTF_NEAREST != 0 ? 1 : 3;\n"
    "    for (int i = 0; i < n; ++i) {\n"
    "        uvec3 codes = btf_view_codes(a.xy, views[i], 0);\n"
    "#if BTF_HIDDEN\n"
    "        if (codes.x == 0u) {\n"
    "            for (int j = 0; j < n; ++j) {\n"
    "                ivec2 at = ivec2(btf_centre(btf_centre_index(codes), lights[j]));\n"
    "#if BTF_LAYOUT_TIGHT\n"
    "                t += texelFetch(btf_centres, at, 0).x;\n"
    "#else\n"
    "                t += texelFetch(btf_maps, at, 0).x;\n"
    "#endif\n"
    "            }\n"
    "            continue;\n"
    "        }\n"
    "#endif\n"
    "        uvec2 x = btf_source(a.xy, codes, 0);\n"
    "        t += codes.x;\n"
    "#if BTF_COLOUR == 0\n"
    "        for (int j = 0; j < 1 + BTF_LOBES; ++j)\n"
    "            s += btf_parameters(x, j, 0);\n"
    "#endif\n"
    "#if BTF_COLOUR == 1\n"
    "        for (int j = 0; j < (3 + 3 * BTF_LOBES + 3) / 4 + BTF_LOBES; ++j)\n"
    "            s += btf_parameters(x, j, 0);\n"
    "#endif\n"
    "#if BTF_SHADOW\n"
    "        for (int j = 0; j < n; ++j)\n"
    "            t += btf_shadow_code(x, lights[j], 0);\n"
    "#endif\n"
    "#if BTF_COMPONENTS > 0\n"
    "        ivec4 r = ivec4(0);\n"
    "        for (int g = 0; g < (BTF_COMPONENTS + 3) / 4; ++g) {\n"
    "            r += texelFetch(btf_residual_texels, ivec3(x, g), 0);\n"
    "            s += texelFetch(btf_residual_scales, ivec2(g, 0), 0);\n"
    "            for (int j = 0; j < n; ++j)\n"
    "                r += btf_direction_components(lights[j], views[i], 3 * g) +\n"
    "                     btf_direction_components(lights[j], views[i], 3 * g + 1) +\n"
    "                     btf_direction_components(lights[j], views[i], 3 * g + 2);\n"
    "        }\n"
    "        s += vec4(r);\n"
    "#endif\n"
    "    }\n"
    "    return uvec4(floatBitsToUint(s.xyz + s.w), t);\n"
    "}\n";

/* PCA: U of the texel once, V of three views by three lights, summed in floats. */
static const char bench_body_pca[] =
    "uvec4 check(uvec4 a, uvec4 b) {\n"
    "    vec2 uv = uintBitsToFloat(a.xy);\n"
    "    vec3 l = vec3(uintBitsToFloat(a.zw), uintBitsToFloat(b.x)), v = uintBitsToFloat(b.yzw);\n"
    "    btf_setting s = btf_prepare(l, v, false, 0);\n"
    "    uvec2 x = uvec2(btf_coordinate(uv.x, BTF_WIDTH), btf_coordinate(uv.y, BTF_HEIGHT)) >> 18u;\n"
    "    x.y = BTF_HEIGHT - 1u - x.y;\n"
    "    vec3 sum = vec3(0.0);\n"
    "    for (int g = 0; g < (BTF_COMPONENTS + 3) / 4; ++g) {\n"
    "        vec4 u = vec4(texelFetch(btf_residual_texels, ivec3(x, g), 0)) *\n"
    "                 texelFetch(btf_residual_scales, ivec2(g, 0), 0);\n"
    "        vec4 red = vec4(0.0), green = vec4(0.0), blue = vec4(0.0);\n"
    "        for (int i = 0; i < 3; ++i)\n"
    "            for (int j = 0; j < 3; ++j) {\n"
    "                float w = float(s.views.weight[i] * s.lights.weight[j]);\n"
    "                red += w * vec4(btf_direction_components(s.lights.index[j], s.views.index[i], 3 * "
    "g));\n"
    "                green += w * vec4(btf_direction_components(s.lights.index[j], s.views.index[i], 3 * g "
    "+ 1));\n"
    "                blue += w * vec4(btf_direction_components(s.lights.index[j], s.views.index[i], 3 * g "
    "+ 2));\n"
    "            }\n"
    "        sum += vec3(dot(u, red), dot(u, green), dot(u, blue));\n"
    "    }\n"
    "    return uvec4(floatBitsToUint(max(sum * 5.9604644775390625e-8, 0.0)), 0u);\n"
    "}\n";

static const char bench_body_phong[] =
    "uniform sampler2D peer_albedo, peer_normal;\n"
    "uvec4 check(uvec4 a, uvec4 b) {\n"
    "    vec2 uv = uintBitsToFloat(a.xy);\n"
    "    vec3 l = vec3(uintBitsToFloat(a.zw), uintBitsToFloat(b.x)), v = uintBitsToFloat(b.yzw);\n"
    "    vec3 n = normalize(texture(peer_normal, uv).xyz * 2.0 - 1.0);\n"
    "    vec3 colour = texture(peer_albedo, uv).xyz * max(dot(n, l), 0.0);\n"
    "    colour += texture(peer_albedo, uv).w * pow(max(dot(reflect(-l, n), v), 0.0), 40.0);\n"
    "    return uvec4(floatBitsToUint(colour), 0u);\n"
    "}\n";

/* Images, a layer a view, each a sheet of lights. */
static const char bench_body_lookup[] =
    "uniform highp sampler2DArray peer_images;\n"
    "uvec4 check(uvec4 a, uvec4 b) {\n"
    "    vec2 uv = uintBitsToFloat(a.xy);\n"
    "    vec3 l = vec3(uintBitsToFloat(a.zw), uintBitsToFloat(b.x)), v = uintBitsToFloat(b.yzw);\n"
    "    btf_setting s = btf_prepare(l, v, false, 0);\n"
    "    uvec2 x = uvec2(btf_coordinate(uv.x, BTF_WIDTH), btf_coordinate(uv.y, BTF_HEIGHT)) >> 18u;\n"
    "    x.y = BTF_HEIGHT - 1u - x.y;\n"
    "    uint columns = uint(textureSize(peer_images, 0).x) / BTF_WIDTH;\n"
    "    vec3 sum = vec3(0.0);\n"
    "    for (int i = 0; i < 3; ++i)\n"
    "        for (int j = 0; j < 3; ++j) {\n"
    "            uint light = s.lights.index[j];\n"
    "            uvec2 at = uvec2(light % columns, light / columns) * uvec2(BTF_WIDTH, BTF_HEIGHT) + x;\n"
    "            float w = float(s.views.weight[i] * s.lights.weight[j]);\n"
    "            sum += w * texelFetch(peer_images, ivec3(at, s.views.index[i]), 0).xyz;\n"
    "        }\n"
    "    return uvec4(floatBitsToUint(sum * 5.9604644775390625e-8), 0u);\n"
    "}\n";

#endif
