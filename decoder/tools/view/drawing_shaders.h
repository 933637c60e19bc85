/* The GLSL that a drawing puts around the decoder's: for the mesh, for each kind of decode, and for the original's
 * images.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_VIEW_DRAWING_SHADERS_H
#define OPENBTF_TOOLS_VIEW_DRAWING_SHADERS_H

static const char vertex_text[] = "layout(location = 0) in vec3 position;\n"
                                  "layout(location = 1) in vec3 normal;\n"
                                  "layout(location = 2) in vec2 uv;\n"
                                  "layout(location = 3) in vec4 tangent;\n"
                                  "uniform mat4 view_to_clip;\n"
                                  "out vec3 f_position, f_normal;\n"
                                  "out vec2 f_uv;\n"
                                  "out vec4 f_tangent;\n"
                                  "void main() {\n"
                                  "    f_position = position;\n"
                                  "    f_normal = normal;\n"
                                  "    f_uv = uv;\n"
                                  "    f_tangent = tangent;\n"
                                  "    gl_Position = view_to_clip * vec4(position, 1.0);\n"
                                  "}\n";

/* Builds the frame as table.c does: turned to the viewer, the view raised to just above the horizon. */
static const char fragment_text[] =
    "in vec3 f_position, f_normal;\n"
    "in vec2 f_uv;\n"
    "in vec4 f_tangent;\n"
    "uniform vec3 eye, light;\n"
    "uniform float exposure, repeat;\n"
    "out vec4 colour;\n"
    "void main() {\n"
    "    view_steps = repeat * vec4(dFdx(f_uv), dFdy(f_uv));\n"
    "    vec3 n = normalize(f_normal), t = normalize(f_tangent.xyz - n * dot(n, f_tangent.xyz));\n"
    "    vec3 b = cross(n, t) * (f_tangent.w < 0.0 ? -1.0 : 1.0);\n"
    "    vec3 to_eye = normalize(eye - f_position), face = cross(dFdx(f_position), dFdy(f_position));\n"
    "    if (dot(face, to_eye) * dot(face, n) < 0.0)\n"
    "        n = -n;\n"
    "    vec3 v = vec3(dot(to_eye, t), dot(to_eye, b), dot(to_eye, n));\n"
    "    v = normalize(vec3(v.xy, max(v.z, 0.001)));\n"
    "    vec3 c = exposure * view_radiance(fract(f_uv * repeat), vec3(dot(light, t), dot(light, b), "
    "dot(light, n)), v);\n"
    "#ifdef VIEW_HISTORY\n"
    "    if (view_share < 1.0)\n"
    "        c = mix(texelFetch(view_history, ivec2(gl_FragCoord.xy), 0).rgb, c, view_share);\n"
    "    colour = vec4(c, 1.0);\n"
    "#else\n"
    "    c = clamp(c, 0.0, 1.0);\n"
    "    colour = vec4(mix(12.92 * c, 1.055 * pow(max(c, 0.0031308), vec3(1.0 / 2.4)) - 0.055,\n"
    "                      vec3(greaterThan(c, vec3(0.0031308)))), 1.0);\n"
    "#endif\n"
    "}\n";

/* Steps of uv to the next pixels, set by main. */
static const char steps_text[] = "vec4 view_steps;\n";

static const char material_text[] =
    "vec3 view_radiance(vec2 uv, vec3 l, vec3 v) { return btf_evaluate(uv, l, v); }\n";

static const char level_text[] =
    "vec3 view_radiance(vec2 uv, vec3 l, vec3 v) {\n"
    "    return btf_evaluate_level(uv, l, v, int(btf_level(view_steps.xy, view_steps.zw) + 0.5));\n"
    "}\n";

/* Decodes stochastically: one of the neighbours, and one of the two levels that a pixel lies between. */
static const char stochastic_text[] =
    "#define VIEW_HISTORY\n"
    "uniform sampler2D view_history;\n"
    "uniform float view_share;\n"
    "uniform int view_sample, view_levels;\n"
    "vec3 view_radiance(vec2 uv, vec3 l, vec3 v) {\n"
    "    float level = view_levels != 0 ? btf_level(view_steps.xy, view_steps.zw) : 0.0;\n"
    "    uvec3 random = btf_random(uvec3(uvec2(gl_FragCoord.xy), uint(view_sample)));\n"
    "    return btf_evaluate_stochastic_between(uv, l, v, level, random);\n"
    "}\n";

/* Looks up the images: a layer for each view, a tile in it for each light. */
static const char images_text[] =
    "uniform sampler2DArray view_images;\n"
    "uniform int view_columns;\n"
    "vec3 view_radiance(vec2 uv, vec3 l, vec3 v) {\n"
    "    if (!btf_is_above(l) || !btf_is_above(v))\n"
    "        return vec3(0.0);\n"
    "    btf_setting s = btf_prepare(l, v, BTF_NEAREST != 0, 0);\n"
    "    ivec2 size = ivec2(BTF_WIDTH, BTF_HEIGHT);\n"
    "    ivec2 x = ivec2(btf_coordinate(uv.x, BTF_WIDTH) >> 18u,\n"
    "                    BTF_HEIGHT - 1u - (btf_coordinate(uv.y, BTF_HEIGHT) >> 18u));\n"
    "    vec3 sum = vec3(0.0);\n"
    "    for (int a = 0; a < s.n; ++a)\n"
    "        for (int b = 0; b < s.n; ++b) {\n"
    "            int light = int(s.lights.index[b]);\n"
    "            ivec2 tile = ivec2(light % view_columns, light / view_columns) * size;\n"
    "            sum += float(s.views.weight[a] * s.lights.weight[b]) / 16777216.0 *\n"
    "                   texelFetch(view_images, ivec3(tile + x, int(s.views.index[a])), 0).rgb;\n"
    "        }\n"
    "    return sum;\n"
    "}\n";

#endif
