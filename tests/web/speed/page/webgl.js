/* A square that WebGL2 decodes.
 *
 * SPDX-License-Identifier: MIT
 */
import { upload } from '/package/webgl.js';

const VERTEX = `#version 300 es
out highp vec2 uv;
void main() {
    uv = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    gl_Position = vec4(2.0 * uv - 1.0, 0.0, 1.0);
}`;

/** Returns {draw: draws under a light and waits for the device, name: the device's name, destroy}; calls `step` after
 * each step. */
export async function webgl(material, math, side, step) {
    const canvas = new OffscreenCanvas(side, side);
    const gl = canvas.getContext('webgl2', { antialias: false });
    const info = gl.getExtension('WEBGL_debug_renderer_info');
    const textures = upload(gl, material, { math });
    step('upload');
    const program = gl.createProgram();
    const fragment = `#version 300 es
${material.source({ math })}
in highp vec2 uv;
uniform highp vec3 light;
out highp vec4 colour;
void main() {
    colour = vec4(btf_evaluate(uv, light, vec3(0.0, 0.0, 1.0)), 1.0);
}`;
    for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, fragment]]) {
        const shader = gl.createShader(kind);
        gl.shaderSource(shader, text);
        gl.compileShader(shader);
        gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
        throw new Error(gl.getProgramInfoLog(program));
    }
    gl.useProgram(program);
    textures.bind(program);
    step('compile');
    const place = gl.getUniformLocation(program, 'light'), pixel = new Uint8Array(4);
    return {
        name: info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : gl.getParameter(gl.RENDERER),
        draw: async (light) => {
            gl.uniform3fv(place, light);
            gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
            gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel); // waits
        },
        destroy: () => gl.getExtension('WEBGL_lose_context')?.loseContext(),
    };
}
