/* OpenBTF in WebGL2: the self-test of a device, as decoder/gl_self_test.c runs it. Four pixels are drawn into a framebuffer
 * of RGBA32UI for each rule.
 *
 * SPDX-License-Identifier: MIT
 */
import { lists } from './self_test_lists.js';
import { OpenBTFError, call, load, text } from './module.js';
import { keepDrawState } from './webgl_state.js';

const SIDE = 2; // pixels are drawn in such blocks
const DRAWN = 0x42544621; // every pixel says that it was drawn
const SPREAD = 0x9E3779B9;

const VERTEX = `#version 300 es
void main() {
    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
`;
const HEAD = `#version 300 es
precision highp float;
precision highp int;
`;

/* Arithmetic; the rules are in the text of the library. */
const ARITHMETIC = `
uniform highp uint btf_runtime_zero;
out highp uvec4 btf_result;
void main() {
    uint zero = btf_runtime_zero ^ (uint(gl_FragCoord.x) >> 1u);
    btf_result = uvec4(btf_self_test(zero), ${DRAWN}u, 0u, 0u);
}
`;

/* Neighbouring pixels fetch from different mip levels, together and while the first of them rests. */
const LEVELS = `${HEAD}
uniform highp usampler2D btf_texels;
out highp uvec4 btf_result;
uint wrong(int level) {
    return texelFetch(btf_texels, ivec2(0), level).x ^ (0x1234567u << uint(level));
}
void main() {
    ivec2 p = ivec2(gl_FragCoord.xy);
    uint sum = wrong((p.x + 2 * p.y) % 3);
    if (p.x + p.y > 0)
        sum |= wrong(2 - p.x - p.y) | wrong(0);
    btf_result = uvec4(sum != 0u ? 128u : 0u, ${DRAWN}u, 0u, 0u);
}
`;

/* Neighbouring pixels fetch texels of 128 bits from different layers of an array, as factors do. */
const ARRAY = `${HEAD}
uniform highp usampler2DArray btf_texels;
out highp uvec4 btf_result;
void main() {
    ivec2 p = ivec2(gl_FragCoord.xy);
    uvec4 wrong = uvec4(0u);
    for (int i = 0; i < 3; ++i) {
        ivec3 at = ivec3(p, (p.x + 2 * p.y + i) % 3);
        uint texel = uint(4 * (2 * (2 * at.z + at.y) + at.x));
        wrong |= texelFetch(btf_texels, at, 0) ^ (uvec4(texel) + uvec4(1u, 2u, 3u, 4u)) * ${SPREAD}u;
    }
    btf_result = uvec4(wrong != uvec4(0u) ? 256u : 0u, ${DRAWN}u, 0u, 0u);
}
`;

/* Neighbouring pixels fetch half a byte and then the layer that it names, as lists of points do. */
const LISTS = `${HEAD}
uniform highp usampler2DArray btf_texels;
out highp uvec4 btf_result;
void main() {
    uvec2 p = uvec2(gl_FragCoord.xy);
    uint wrong = 0u;
    for (uint view = 0u; view < 3u; ++view) {
        uint layer = (texelFetch(btf_texels, ivec3(p, view >> 1u), 0).x >> ((view & 1u) << 2u)) & 15u;
        uvec2 bytes = texelFetch(btf_texels, ivec3(p, layer), 0).xy;
        uint named = 2u + (p.x + 2u * p.y + 5u * view) % 14u;
        wrong |= layer ^ named;
        wrong |= (bytes.x + 256u * bytes.y) ^ ((named * 4u + p.y * 2u + p.x) * 1021u & 0xFFFFu);
    }
    btf_result = uvec4(wrong != 0u ? 512u : 0u, ${DRAWN}u, 0u, 0u);
}
`;

function refuse(message) {
    throw new OpenBTFError('UNSUPPORTED', `self-test: ${message}`);
}

function compile(gl, kind, source, program) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) {
        refuse(`the context does not compile a shader: ${gl.getShaderInfoLog(shader)}`);
    }
    return shader;
}

/* Draws with a fragment shader and gives the bits of the rules that failed. The texture is bound on the active unit. */
function run(gl, fragment) {
    const program = gl.createProgram();
    const shaders = [];
    try {
        shaders.push(compile(gl, gl.VERTEX_SHADER, VERTEX, program));
        shaders.push(compile(gl, gl.FRAGMENT_SHADER, fragment, program));
        gl.linkProgram(program);
        if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
            refuse(`the context does not link a program: ${gl.getProgramInfoLog(program)}`);
        }
        gl.useProgram(program);
        gl.uniform1i(gl.getUniformLocation(program, 'btf_texels'), gl.getParameter(gl.ACTIVE_TEXTURE) - gl.TEXTURE0);
        gl.drawArrays(gl.TRIANGLES, 0, 3);
        const pixels = new Uint32Array(4 * SIDE * SIDE);
        gl.readPixels(0, 0, SIDE, SIDE, gl.RGBA_INTEGER, gl.UNSIGNED_INT, pixels);
        const error = gl.getError();
        let failures = 0;
        for (let i = 0; i < pixels.length; i += 4) {
            if (error || pixels[i + 1] !== DRAWN) {
                refuse(`the context did not draw (WebGL error 0x${error.toString(16)})`);
            }
            failures |= pixels[i];
        }
        return failures;
    } finally {
        shaders.forEach((shader) => gl.deleteShader(shader));
        gl.deleteProgram(program);
    }
}

/* Runs with a texture of `levels`, each a size and data, of an array where `layers` is given. */
function runWith(gl, fragment, format, levels, layers) {
    const target = layers ? gl.TEXTURE_2D_ARRAY : gl.TEXTURE_2D;
    const texture = gl.createTexture();
    gl.bindTexture(target, texture);
    gl.texParameteri(target, gl.TEXTURE_MIN_FILTER, levels.length > 1 ? gl.NEAREST_MIPMAP_NEAREST : gl.NEAREST);
    gl.texParameteri(target, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    gl.texParameteri(target, gl.TEXTURE_MAX_LEVEL, levels.length - 1);
    levels.forEach(([size, data], level) => {
        if (layers) {
            gl.texImage3D(target, level, ...[format[0], size, size, layers, 0, format[1], format[2], data]);
        } else {
            gl.texImage2D(target, level, ...[format[0], size, size, 0, format[1], format[2], data]);
        }
    });
    try {
        return run(gl, fragment);
    } finally {
        gl.deleteTexture(texture);
    }
}

function testAll(gl) {
    const words = [gl.RGBA32UI, gl.RGBA_INTEGER, gl.UNSIGNED_INT];
    let failures = run(gl, `#version 300 es\n${text(call('self_test_source'))}${ARITHMETIC}`);
    failures |= runWith(gl, LEVELS, words, [4, 2, 1].map((size, level) => [size, new Uint32Array(4 * size * size).fill(0x1234567 << level)]));
    failures |= runWith(gl, ARRAY, words, [[SIDE, Uint32Array.from({ length: 3 * SIDE * SIDE * 4 }, (_, i) => Math.imul(i + 1, SPREAD))]], 3);
    const [bytes, layers] = lists(SIDE);
    return failures | runWith(gl, LISTS, [gl.RG8UI, gl.RG_INTEGER, gl.UNSIGNED_BYTE], [[SIDE, bytes]], layers);
}

export async function selfTest(gl) {
    await load();
    const restore = keepDrawState(gl, SIDE);
    const texture = gl.createTexture();
    const framebuffer = gl.createFramebuffer();
    try {
        gl.bindTexture(gl.TEXTURE_2D, texture);
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
        gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32UI, SIDE, SIDE, 0, gl.RGBA_INTEGER, gl.UNSIGNED_INT, null);
        gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
        gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
        if (gl.checkFramebufferStatus(gl.FRAMEBUFFER) !== gl.FRAMEBUFFER_COMPLETE) {
            refuse('the context refuses a framebuffer of format RGBA32UI');
        }
        const failures = testAll(gl);
        return { failures, names: failures ? text(call('self_test_names', failures)).split(/,\s*/) : [] };
    } finally {
        gl.deleteFramebuffer(framebuffer);
        restore();
        gl.deleteTexture(texture);
    }
}
