/* Where the viewer draws before the screen: one sample of the picture, and the mean of all so far.
 *
 * SPDX-License-Identifier: MIT
 */

/** Formats that this device can draw to: of a sample and of the mean. Without floats there is no mean of several samples. */
export function formats(gl) {
    if (gl.getExtension('EXT_color_buffer_float')) {
        return { sample: gl.RGBA16F, mean: gl.RGBA32F, floats: true };
    }
    if (gl.getExtension('EXT_color_buffer_half_float')) {
        return { sample: gl.RGBA16F, mean: gl.RGBA16F, floats: true };
    }
    return { sample: gl.RGBA8, mean: gl.RGBA8, floats: false };
}

class Target {
    constructor(gl, format, width, height, withDepth, filter) {
        this.texture = gl.createTexture();
        this.framebuffer = gl.createFramebuffer();
        gl.activeTexture(gl.TEXTURE0);
        gl.bindTexture(gl.TEXTURE_2D, this.texture);
        gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
        for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) {
            gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
        }
        for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) {
            gl.texParameteri(gl.TEXTURE_2D, name, filter);
        }
        gl.bindFramebuffer(gl.FRAMEBUFFER, this.framebuffer);
        gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.texture, 0);
        if (withDepth) {
            this.depth = gl.createRenderbuffer();
            gl.bindRenderbuffer(gl.RENDERBUFFER, this.depth);
            gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT24, width, height);
            gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, this.depth);
        }
    }

    destroy(gl) {
        gl.deleteTexture(this.texture);
        gl.deleteFramebuffer(this.framebuffer);
        gl.deleteRenderbuffer(this.depth ?? null);
    }
}

/** A sample with depth and two means, of which one is read and one written. */
export class Targets {
    #gl;
    #formats;
    #means = [];
    #latest = 0;

    constructor(gl) {
        this.#gl = gl;
        this.#formats = formats(gl);
        this.width = this.height = 0;
    }

    get floats() {
        return this.#formats.floats;
    }

    /** Makes them of a size; true where that changed. */
    resize(width, height) {
        if (width === this.width && height === this.height) {
            return false;
        }
        this.destroy();
        const { sample, mean } = this.#formats;
        this.sample = new Target(this.#gl, sample, width, height, true, this.#gl.LINEAR);
        this.#means = [0, 1].map(() => new Target(this.#gl, mean, width, height, false, this.#gl.NEAREST));
        this.width = width;
        this.height = height;
        return true;
    }

    get mean() {
        return this.#means[this.#latest];
    }

    /** The mean that is written next; it becomes `mean`. */
    nextMean() {
        this.#latest = 1 - this.#latest;
        return this.#means[this.#latest];
    }

    destroy() {
        [this.sample, ...this.#means].forEach((target) => target?.destroy(this.#gl));
        this.sample = undefined;
        this.#means = [];
        this.width = this.height = 0;
    }
}
