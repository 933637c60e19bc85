/* Describes this device in words: its name, its limits, the verdict of the self-test.
 *
 * SPDX-License-Identifier: MIT
 */

/* In words, what is wrong on a device that fails a rule of the self-test (BTF_SELF_TEST_LIST of openbtf/shader.h). */
const RULES = {
    contraction: 'products and sums are rounded once',
    reassociation: 'sums or products are regrouped',
    rounding: 'sums or products are not rounded to nearest even',
    flush: 'small numbers become zero',
    conversion: 'integers and floats do not convert exactly',
    integer: 'integers of 32 bits wrap, shift or divide otherwise',
    elementary: 'logarithm and exponential give other bits',
    levels: 'texels come from wrong levels of detail',
    factors: 'packed factors are fetched wrongly',
    lists: 'lists of points are fetched wrongly',
};

/** The verdict of selfTest(): {exact, words}. */
export function verdict({ failures, names }) {
    if (!failures) {
        return { exact: true, words: 'Exact: this device passes every rule of the self-test, so it decodes to the bits that the format defines.' };
    }
    const reasons = names.map((name) => (RULES[name] ? `${RULES[name]} (${name})` : name));
    return { exact: false, words: `Not exact: ${reasons.join(', ')}. The picture may differ from what the format defines, and quicker arithmetic is used.` };
}

/** The name of the device that draws, as the browser tells it. */
export function deviceName(gl) {
    const name = String(gl.getParameter(gl.RENDERER));
    // Firefox says it there already, and warns of those who ask for more
    const extension = /^WebKit/.test(name) ? gl.getExtension('WEBGL_debug_renderer_info') : null;
    return extension ? String(gl.getParameter(extension.UNMASKED_RENDERER_WEBGL)) : name;
}

/** Limits that a material may meet. */
export function limits(gl) {
    return `Textures of at most ${gl.getParameter(gl.MAX_TEXTURE_SIZE)} texels a side and ${gl.getParameter(gl.MAX_ARRAY_TEXTURE_LAYERS)} layers.`;
}

/** A WebGL2 context for a canvas. Throws an Error in words for the page where there is none. */
export function contextOf(canvas) {
    const gl = canvas.getContext('webgl2', { alpha: true, premultipliedAlpha: true, antialias: false, depth: false, powerPreference: 'high-performance' });
    if (!gl) {
        const old = canvas.getContext('webgl') ? 'It has WebGL 1, which is too old. ' : '';
        throw new Error(`This browser gives no WebGL2, which draws the material. ${old}Turn hardware acceleration on, update the browser or the graphics driver, or try another browser.`);
    }
    return gl;
}

