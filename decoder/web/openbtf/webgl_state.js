/* OpenBTF in WebGL2: sets state aside and puts it back.
 *
 * SPDX-License-Identifier: MIT
 */

/* Pixel storage that an upload reads, with the values under which rows lie tightly and nothing is converted. */
const UNPACK = {
    UNPACK_ALIGNMENT: 1,
    UNPACK_ROW_LENGTH: 0,
    UNPACK_IMAGE_HEIGHT: 0,
    UNPACK_SKIP_PIXELS: 0,
    UNPACK_SKIP_ROWS: 0,
    UNPACK_SKIP_IMAGES: 0,
    UNPACK_FLIP_Y_WEBGL: false,
    UNPACK_PREMULTIPLY_ALPHA_WEBGL: false,
};
const PACK = { PACK_ALIGNMENT: 1, PACK_ROW_LENGTH: 0, PACK_SKIP_PIXELS: 0, PACK_SKIP_ROWS: 0 };

function keepStorage(gl, wanted) {
    const kept = Object.keys(wanted).map((name) => [gl[name], gl.getParameter(gl[name])]);
    Object.entries(wanted).forEach(([name, value]) => gl.pixelStorei(gl[name], value));
    return () => kept.forEach(([name, value]) => gl.pixelStorei(name, value));
}

/** @returns a function that makes the current program current again; one that was deleted ends when another takes its place. */
export function keepProgram(gl) {
    const current = gl.getParameter(gl.CURRENT_PROGRAM);
    const deleted = current && gl.getProgramParameter(current, gl.DELETE_STATUS);
    return () => gl.useProgram(deleted ? null : current);
}

/**
 * Sets pixel storage for tight rows and no unpack buffer, and takes pending errors off the queue.
 * @returns a function that puts these and the texture bindings of the active unit back.
 */
export function keepUploadState(gl) {
    const bound = gl.getParameter(gl.TEXTURE_BINDING_2D);
    const boundArray = gl.getParameter(gl.TEXTURE_BINDING_2D_ARRAY);
    const buffer = gl.getParameter(gl.PIXEL_UNPACK_BUFFER_BINDING);
    while (gl.getError() && !gl.isContextLost()) {
        // errors of earlier calls are not ours
    }
    gl.bindBuffer(gl.PIXEL_UNPACK_BUFFER, null);
    const restore = keepStorage(gl, UNPACK);
    return () => {
        restore();
        gl.bindBuffer(gl.PIXEL_UNPACK_BUFFER, buffer);
        gl.bindTexture(gl.TEXTURE_2D, bound);
        gl.bindTexture(gl.TEXTURE_2D_ARRAY, boundArray);
    };
}

/* Switches that would keep a draw from reaching every pixel as it is. */
const SWITCHES = ['BLEND', 'CULL_FACE', 'DEPTH_TEST', 'DITHER', 'POLYGON_OFFSET_FILL', 'RASTERIZER_DISCARD',
    'SAMPLE_ALPHA_TO_COVERAGE', 'SAMPLE_COVERAGE', 'SCISSOR_TEST', 'STENCIL_TEST'];

/**
 * Sets state for a draw of a triangle over a framebuffer of side `size`, with a vertex array of its own. The caller binds
 * a framebuffer and a program.
 * @returns a function that puts all of it back, framebuffers, program and upload state included.
 */
export function keepDrawState(gl, size) {
    const restoreUpload = keepUploadState(gl);
    const restorePack = keepStorage(gl, PACK);
    const restoreProgram = keepProgram(gl);
    const array = gl.getParameter(gl.VERTEX_ARRAY_BINDING);
    const draw = gl.getParameter(gl.DRAW_FRAMEBUFFER_BINDING);
    const read = gl.getParameter(gl.READ_FRAMEBUFFER_BINDING);
    const pack = gl.getParameter(gl.PIXEL_PACK_BUFFER_BINDING);
    const viewport = gl.getParameter(gl.VIEWPORT);
    const mask = gl.getParameter(gl.COLOR_WRITEMASK);
    const sampler = gl.getParameter(gl.SAMPLER_BINDING);
    const unit = gl.getParameter(gl.ACTIVE_TEXTURE) - gl.TEXTURE0;
    const switches = SWITCHES.map((name) => gl[name]).filter((name) => gl.isEnabled(name));
    switches.forEach((name) => gl.disable(name));
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    gl.bindSampler(unit, null);
    gl.colorMask(true, true, true, true);
    gl.viewport(0, 0, size, size);
    const own = gl.createVertexArray();
    gl.bindVertexArray(own);
    return () => {
        gl.bindVertexArray(array);
        gl.deleteVertexArray(own);
        gl.viewport(...viewport);
        gl.colorMask(...mask);
        gl.bindSampler(unit, sampler);
        gl.bindBuffer(gl.PIXEL_PACK_BUFFER, pack);
        switches.forEach((name) => gl.enable(name));
        gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, draw);
        gl.bindFramebuffer(gl.READ_FRAMEBUFFER, read);
        restoreProgram();
        restorePack();
        restoreUpload();
    };
}
