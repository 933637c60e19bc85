/* Evaluates a shader on arguments, bit for bit, in WebGL2: arguments and results are integer textures.
 *
 * SPDX-License-Identifier: MIT
 */
const VERTEX = `#version 300 es
void main() {
    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
`;

/* `call` is an expression for the radiance at uv, l, v, level and random. */
const main = (call) => `
uniform highp usampler2DArray test_arguments;
uniform highp int test_level;
uniform highp uint test_number;
out highp uvec4 test_result;
void main() {
    ivec2 p = ivec2(gl_FragCoord.xy);
    uvec4 a = texelFetch(test_arguments, ivec3(p, 0), 0), b = texelFetch(test_arguments, ivec3(p, 1), 0);
    vec2 uv = uintBitsToFloat(a.xy);
    vec3 l = uintBitsToFloat(uvec3(a.zw, b.x)), v = uintBitsToFloat(b.yzw);
    test_result = uvec4(floatBitsToUint(${call}), 1u);
}
`;
const CALLS = {
    radiance: 'btf_evaluate_level(uv, l, v, test_level)',
    picked: 'btf_evaluate_stochastic_level(uv, l, v, test_level, btf_random(uvec3(p, test_number)))',
};

export function context() {
    const gl = document.createElement('canvas').getContext('webgl2');
    if (!gl) {
        throw new Error('this browser gives no WebGL2 context');
    }
    return gl;
}

/** Releases a context, since browsers keep few at a time. */
export function release(gl) {
    gl.getExtension('WEBGL_lose_context')?.loseContext();
}

/** A program for a decoder's text; `plane` is radiance or picked. */
export function program(gl, source, plane) {
    const result = gl.createProgram();
    const shaders = [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, `#version 300 es\n${source}${main(CALLS[plane])}`]].map(([kind, text]) => {
        const shader = gl.createShader(kind);
        gl.shaderSource(shader, text);
        gl.compileShader(shader);
        gl.attachShader(result, shader);
        return shader;
    });
    gl.linkProgram(result);
    if (!gl.getProgramParameter(result, gl.LINK_STATUS)) {
        throw new Error(`not linked: ${gl.getProgramInfoLog(result)} ${shaders.map((shader) => gl.getShaderInfoLog(shader)).join(' ')}`);
    }
    shaders.forEach((shader) => gl.deleteShader(shader));
    return result;
}

/** A texture of words, four a texel, `layers` of an array where they are given. */
function texture(gl, width, height, layers, words) {
    const target = layers ? gl.TEXTURE_2D_ARRAY : gl.TEXTURE_2D;
    const name = gl.createTexture();
    gl.bindTexture(target, name);
    gl.texParameteri(target, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(target, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    if (layers) {
        gl.texImage3D(target, 0, gl.RGBA32UI, width, height, layers, 0, gl.RGBA_INTEGER, gl.UNSIGNED_INT, words);
    } else {
        gl.texImage2D(target, 0, gl.RGBA32UI, width, height, 0, gl.RGBA_INTEGER, gl.UNSIGNED_INT, words);
    }
    return name;
}

/**
 * Draws width x height evaluations.
 * @param args [2][height][width][4] words: uv and two of light, then the third of light and view
 * @returns [height * width][4] words, of which the last is 1
 */
export function draw(gl, textures, linked, width, height, args, level, number) {
    gl.activeTexture(gl.TEXTURE0);
    const given = texture(gl, width, height, 2, args);
    const unit = textures.bind(linked, 1) + 1;
    gl.activeTexture(gl.TEXTURE0 + unit);
    const target = texture(gl, width, height, 0, null);
    const framebuffer = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, target, 0);
    gl.useProgram(linked);
    gl.uniform1i(gl.getUniformLocation(linked, 'test_arguments'), 0);
    gl.uniform1i(gl.getUniformLocation(linked, 'test_level'), level);
    gl.uniform1ui(gl.getUniformLocation(linked, 'test_number'), number);
    gl.viewport(0, 0, width, height);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    const words = new Uint32Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA_INTEGER, gl.UNSIGNED_INT, words);
    const error = gl.getError();
    gl.deleteFramebuffer(framebuffer);
    gl.deleteTexture(target);
    gl.deleteTexture(given);
    if (error || words[3] !== 1 || words[words.length - 1] !== 1) {
        throw new Error(`not drawn, WebGL error 0x${error.toString(16)}`);
    }
    return words;
}
