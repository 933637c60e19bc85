/* Compares this device with the reference decoder in the page, bit for bit.
 *
 * SPDX-License-Identifier: MIT
 */
import { upload } from '../openbtf/webgl.js';
import { direction } from './camera.js';
import { SCREEN_VERTEX } from './shaders.js';

const SIDE = 64; // of the block of values

const FRAGMENT = (source) => `#version 300 es
${source}
uniform highp sampler2D arguments_a, arguments_b;
out highp uvec4 bits;
void main() {
    ivec2 p = ivec2(gl_FragCoord.xy);
    highp vec4 a = texelFetch(arguments_a, p, 0), b = texelFetch(arguments_b, p, 0);
    bits = uvec4(floatBitsToUint(btf_evaluate(a.xy, vec3(a.zw, b.x), b.yzw)), 1u);
}
`;

/* Pseudo-random numbers in [0, 1), the same for every run. */
function numbers() {
    let state = 1;
    return () => {
        state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
        return state / 2 ** 32;
    };
}

function link(gl, fragment) {
    const program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, SCREEN_VERTEX], [gl.FRAGMENT_SHADER, fragment]]) {
        const shader = gl.createShader(kind);
        gl.shaderSource(shader, text);
        gl.compileShader(shader);
        gl.attachShader(program, shader);
        gl.deleteShader(shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
        const said = gl.getProgramInfoLog(program);
        gl.deleteProgram(program);
        throw new Error(`this device does not compile the shader: ${said}`);
    }
    return program;
}

function texture(gl, unit, internal, format, type, data) {
    const made = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, made);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    gl.texImage2D(gl.TEXTURE_2D, 0, internal, SIDE, SIDE, 0, format, type, data);
    return made;
}

/**
 * Decodes 64 x 64 arguments on the device and by the reference decoder.
 * @param options of the shader, exact and without picks
 * @returns {values: how many were compared, different: how many of them differ in a bit}
 */
export function compareWithReference(gl, material, options) {
    const count = SIDE * SIDE, random = numbers();
    const uv = new Float32Array(2 * count), light = new Float32Array(3 * count), view = new Float32Array(3 * count);
    const a = new Float32Array(4 * count), b = new Float32Array(4 * count);
    for (let i = 0; i < count; i++) {
        uv.set([random(), random()], 2 * i);
        light.set(direction(90 * random(), 360 * random()), 3 * i);
        view.set(direction(90 * random(), 360 * random()), 3 * i);
        a.set([uv[2 * i], uv[2 * i + 1], light[3 * i], light[3 * i + 1]], 4 * i);
        b.set([light[3 * i + 2], ...view.subarray(3 * i, 3 * i + 3)], 4 * i);
    }
    const wanted = new Uint32Array(material.evaluate(uv, light, view, { leaveOut: options.leaveOut, components: options.components,
        interpolation: options.interpolation, filter: options.filter, reference: true }).buffer);
    const made = [];
    let textures, program, framebuffer, array;
    try {
        textures = upload(gl, material, options);
        program = link(gl, FRAGMENT(material.source(options)));
        framebuffer = gl.createFramebuffer();
        array = gl.createVertexArray();
        made.push(texture(gl, 0, gl.RGBA32UI, gl.RGBA_INTEGER, gl.UNSIGNED_INT, null));
        gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
        gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, made[0], 0);
        gl.bindTexture(gl.TEXTURE_2D, null);
        const unit = textures.bind(program, 2);
        made.push(texture(gl, 0, gl.RGBA32F, gl.RGBA, gl.FLOAT, a), texture(gl, 1, gl.RGBA32F, gl.RGBA, gl.FLOAT, b));
        gl.useProgram(program);
        gl.uniform1i(gl.getUniformLocation(program, 'arguments_a'), 0);
        gl.uniform1i(gl.getUniformLocation(program, 'arguments_b'), 1);
        gl.bindVertexArray(array);
        gl.viewport(0, 0, SIDE, SIDE);
        gl.drawArrays(gl.TRIANGLES, 0, 3);
        const bits = new Uint32Array(4 * count);
        gl.readPixels(0, 0, SIDE, SIDE, gl.RGBA_INTEGER, gl.UNSIGNED_INT, bits);
        if (unit < 1 || bits[3] !== 1 || bits.at(-1) !== 1) {
            throw new Error('this device did not draw the values');
        }
        let different = 0;
        for (let i = 0; i < count; i++) {
            for (let c = 0; c < 3; c++) {
                different += bits[4 * i + c] !== wanted[3 * i + c] ? 1 : 0;
            }
        }
        return { values: 3 * count, different };
    } finally {
        made.forEach((name) => gl.deleteTexture(name));
        gl.deleteFramebuffer(framebuffer ?? null);
        gl.deleteVertexArray(array ?? null);
        gl.deleteProgram(program ?? null);
        textures?.destroy();
    }
}
