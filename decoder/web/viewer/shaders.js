/* The GLSL that the viewer puts around the decoder's: the model, the mean of its samples, and the picture on the screen.
 *
 * SPDX-License-Identifier: MIT
 */

/** Lights of one sample at most; they are uniforms. */
export const MOST_LIGHTS = 8;

export const MODEL_VERTEX = `#version 300 es
layout(location = 0) in highp vec3 position;
layout(location = 1) in highp vec3 normal;
layout(location = 2) in highp vec2 uv;
layout(location = 3) in highp vec3 tangent;
uniform highp mat4 view_to_clip;
out highp vec3 f_position, f_normal, f_tangent;
out highp vec2 f_uv;
void main() {
    f_position = position;
    f_normal = normal;
    f_tangent = tangent;
    f_uv = uv;
    gl_Position = view_to_clip * vec4(position, 1.0);
}
`;

/* One neighbour in place of all; each light and sample has random numbers of its own. */
const PICKED = `btf_evaluate_stochastic_between(at, l, v, detail,
            btf_random(uvec3(uvec2(gl_FragCoord.xy), uint(number * ${MOST_LIGHTS} + i))))`;
const BLENDED = 'btf_evaluate_level(at, l, v, int(detail + 0.5))';

/**
 * The fragment shader of the model behind a decoder's text.
 * Frames are turned to the viewer, and the view is raised to just above the horizon, as in btf-render and btf-view.
 */
export const modelFragment = (source, picks) => `#version 300 es
${source}
in highp vec3 f_position, f_normal, f_tangent;
in highp vec2 f_uv;
uniform highp vec3 eye, light_at[${MOST_LIGHTS}], light_colour[${MOST_LIGHTS}];
uniform highp float repeat;
uniform highp int lights, number, level;
out highp vec4 colour;
void main() {
    vec2 uv = f_uv * repeat, at = fract(uv);
    float detail = level < 0 ? btf_level(dFdx(uv), dFdy(uv)) : float(level);
    vec3 n = normalize(f_normal), t = normalize(f_tangent - n * dot(n, f_tangent)), b = cross(n, t);
    vec3 to_eye = normalize(eye - f_position), face = cross(dFdx(f_position), dFdy(f_position));
    if (dot(face, to_eye) * dot(face, n) < 0.0)
        n = -n;
    vec3 v = vec3(dot(to_eye, t), dot(to_eye, b), dot(to_eye, n));
    v = normalize(vec3(v.xy, max(v.z, 0.001)));
    vec3 sum = vec3(0.0);
    for (int i = 0; i < lights; ++i) {
        vec3 l = vec3(dot(light_at[i], t), dot(light_at[i], b), dot(light_at[i], n));
        sum += light_colour[i] * ${picks === 'none' ? BLENDED : PICKED};
    }
    colour = vec4(sum, 1.0);
}
`;

export const SCREEN_VERTEX = `#version 300 es
void main() {
    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
`;

/** The mean of one sample more. */
export const MEAN_FRAGMENT = `#version 300 es
uniform highp sampler2D mean, latest;
uniform highp float share;
out highp vec4 colour;
void main() {
    ivec2 p = ivec2(gl_FragCoord.xy);
    highp vec4 c = texelFetch(latest, p, 0);
    colour = share < 1.0 ? mix(texelFetch(mean, p, 0), c, share) : c;
}
`;

/* The picture: exposure, sRGB, and what is behind the model. A draft, which is smaller, is enlarged smoothly. */
export const PICTURE_FRAGMENT = `#version 300 es
precision highp float;
uniform highp sampler2D image, environment;
uniform vec2 size, used;
uniform float exposure, strength, turn;
uniform vec3 right, up, back;
uniform vec2 tangents;
uniform bool draft, backdrop;
out vec4 colour;
vec3 coded(vec3 c) {
    c = clamp(c, 0.0, 1.0);
    return mix(12.92 * c, 1.055 * pow(max(c, 0.0031308), vec3(1.0 / 2.4)) - 0.055, vec3(greaterThan(c, vec3(0.0031308))));
}
void main() {
    vec2 at = gl_FragCoord.xy / size;
    vec4 c = draft ? texture(image, clamp(at * used, vec2(0.5), used - 0.5) / vec2(textureSize(image, 0))) : texelFetch(image, ivec2(gl_FragCoord.xy), 0);
    vec3 behind = vec3(0.0);
    if (backdrop) {
        vec3 d = normalize(tangents.x * (2.0 * at.x - 1.0) * right + tangents.y * (2.0 * at.y - 1.0) * up - back);
        behind = strength * texture(environment, vec2(fract((atan(d.x, -d.z) - turn) / 6.28318530718 + 0.5), acos(clamp(d.y, -1.0, 1.0)) / 3.14159265359)).rgb;
        colour = vec4(coded(exposure * (c.rgb + (1.0 - c.a) * behind)), 1.0);
    } else {
        // a quiet ground in display values, so that exposure leaves it alone
        vec2 off = (at - vec2(0.5, 0.55)) * vec2(size.x / size.y, 1.0);
        vec3 ground = mix(vec3(0.125, 0.125, 0.14), vec3(0.045, 0.045, 0.05), smoothstep(0.1, 0.85, length(off)));
        // the ground's steps are finer than a display's: a little noise keeps them from showing
        ground += (fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5) / 255.0;
        colour = vec4(mix(ground, coded(exposure * c.rgb / max(c.a, 1e-6)), c.a), 1.0);
    }
}
`;
