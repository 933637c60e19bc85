/* openbtf/webgl in a context of the user's: it restores state, tells its bytes and frees its memory.
 *
 * SPDX-License-Identifier: MIT
 */
import { memoryBytes, open } from '/package/index.js';
import { selfTest, upload } from '/package/webgl.js';
import { context, release } from './draw.js';
import { bytes, report } from './post.js';

/** All state that a user may have set is restored. */
async function restoresState(gl, name) {
    const buffer = gl.createBuffer(), texture = gl.createTexture(), other = gl.createTexture(), framebuffer = gl.createFramebuffer();
    const array = gl.createVertexArray(), sampler = gl.createSampler();
    gl.activeTexture(gl.TEXTURE3);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, other);
    gl.bindSampler(3, sampler);
    gl.bindBuffer(gl.PIXEL_UNPACK_BUFFER, buffer);
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.bindVertexArray(array);
    gl.enable(gl.BLEND);
    gl.enable(gl.SCISSOR_TEST);
    gl.colorMask(true, false, true, false);
    gl.viewport(1, 2, 3, 4);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 8);
    gl.pixelStorei(gl.UNPACK_ROW_LENGTH, 7);
    gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, true);
    gl.pixelStorei(gl.PACK_ROW_LENGTH, 9);
    const names = ['ACTIVE_TEXTURE', 'TEXTURE_BINDING_2D', 'TEXTURE_BINDING_2D_ARRAY', 'SAMPLER_BINDING', 'PIXEL_UNPACK_BUFFER_BINDING',
        'PIXEL_PACK_BUFFER_BINDING', 'DRAW_FRAMEBUFFER_BINDING', 'READ_FRAMEBUFFER_BINDING', 'VERTEX_ARRAY_BINDING', 'BLEND', 'SCISSOR_TEST',
        'COLOR_WRITEMASK', 'VIEWPORT', 'UNPACK_ALIGNMENT', 'UNPACK_ROW_LENGTH', 'UNPACK_FLIP_Y_WEBGL', 'UNPACK_PREMULTIPLY_ALPHA_WEBGL',
        'PACK_ROW_LENGTH', 'CURRENT_PROGRAM'];
    const state = () => names.map((parameter) => gl.getParameter(gl[parameter])).map((value) => (ArrayBuffer.isView(value) || Array.isArray(value) ? String(Array.from(value)) : value));
    const before = state();
    const material = await open(await bytes(`/golden/${name}`));
    const textures = upload(gl, material);
    const { failures } = await selfTest(gl);
    const after = state();
    const wrong = names.filter((_, i) => before[i] !== after[i]);
    await report('upload and self-test put state back', wrong.join(', '));
    await report('self-test passes under that state', failures ? `failures ${failures}` : '');
    const sum = material.textures().reduce((total, { data }) => total + data.byteLength, 0);
    await report('bytes uploaded', textures.bytes === sum ? '' : `${textures.bytes}, not ${sum}`);
    textures.destroy();
    material.close();
}

/** Loading and closing again and again takes no more memory than once. */
async function freesMemory(gl, name) {
    const data = await bytes(`/golden/${name}`);
    let after1;
    for (let i = 0; i < 50; i++) {
        const material = await open(data);
        upload(gl, material).destroy();
        material.close();
        after1 ??= memoryBytes();
    }
    await report('50 materials opened and closed take the memory of one', memoryBytes() === after1 ? '' : `${memoryBytes()} bytes, after the first ${after1}`);
}

export async function run(job) {
    const gl = context();
    await restoresState(gl, job.golden[0]);
    await freesMemory(gl, job.golden[0]);
    release(gl);
}
