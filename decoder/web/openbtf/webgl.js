/* OpenBTF in WebGL2: uploads a material's textures and points a program's samplers at them. webgl.d.ts documents every
 * call. State of yours is put back: bindings, pixel storage, and in the self-test all that a draw needs.
 *
 * SPDX-License-Identifier: MIT
 */
import { OpenBTFError } from './module.js';
import { whole } from './records.js';
import { keepProgram, keepUploadState } from './webgl_state.js';

export { selfTest } from './webgl_self_test.js';

/* Of each format: internal format, format, type. */
const GL_FORMATS = {
    R8UI: ['R8UI', 'RED_INTEGER', 'UNSIGNED_BYTE'],
    RG8UI: ['RG8UI', 'RG_INTEGER', 'UNSIGNED_BYTE'],
    RGBA8UI: ['RGBA8UI', 'RGBA_INTEGER', 'UNSIGNED_BYTE'],
    RGBA8I: ['RGBA8I', 'RGBA_INTEGER', 'BYTE'],
    RGBA16UI: ['RGBA16UI', 'RGBA_INTEGER', 'UNSIGNED_SHORT'],
    RGBA16F: ['RGBA16F', 'RGBA', 'HALF_FLOAT'],
    RGBA32F: ['RGBA32F', 'RGBA', 'FLOAT'],
    RGBA32UI: ['RGBA32UI', 'RGBA_INTEGER', 'UNSIGNED_INT'],
};

/** Every way in which a texture exceeds the limits of a context, as text; null when it does not. */
function excess(gl, texture) {
    const side = gl.getParameter(gl.MAX_TEXTURE_SIZE);
    const layers = gl.getParameter(gl.MAX_ARRAY_TEXTURE_LAYERS);
    const advice = texture.name === 'maps' ? ' (toTight() takes it apart)' : '';
    for (const size of ['width', 'height']) {
        if (texture[size] > side) {
            return `${texture.name}: ${size} ${texture[size]} exceeds MAX_TEXTURE_SIZE ${side}${advice}`;
        }
    }
    if (texture.isArray && texture.layers > layers) {
        return `${texture.name}: ${texture.layers} layers exceed MAX_ARRAY_TEXTURE_LAYERS ${layers}`;
    }
    return null;
}

function webgl2(gl) {
    if (typeof WebGL2RenderingContext === 'undefined' || !(gl instanceof WebGL2RenderingContext)) {
        throw new OpenBTFError('UNSUPPORTED', 'gl: not a WebGL2 context; canvas.getContext("webgl2") gives one where there is WebGL2');
    }
    if (gl.isContextLost()) {
        throw new OpenBTFError('UNSUPPORTED', 'gl: the context is lost');
    }
}

export function fits(gl, material, options) {
    webgl2(gl);
    return material.readTextures(options).every((texture) => !excess(gl, texture));
}

/** The textures of a material in a context. */
export class Textures {
    #gl;
    #textures = new Map(); // by name: { texture, target }
    #bytes = 0;

    constructor(gl) {
        this.#gl = gl;
    }

    get bytes() {
        return this.#bytes;
    }

    texture(name) {
        return this.#textures.get(name)?.texture ?? null;
    }

    target(name) {
        return this.#textures.get(name)?.target ?? null;
    }

    /** Adds a texture of `levels`, the finest first. Bindings and pixel storage are the caller's. */
    add(levels) {
        const gl = this.#gl;
        const { name, isArray } = levels[0];
        const target = isArray ? gl.TEXTURE_2D_ARRAY : gl.TEXTURE_2D;
        const texture = gl.createTexture();
        this.#textures.set(name, { texture, target });
        gl.bindTexture(target, texture);
        gl.texParameteri(target, gl.TEXTURE_MIN_FILTER, levels.length > 1 ? gl.NEAREST_MIPMAP_NEAREST : gl.NEAREST);
        gl.texParameteri(target, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
        gl.texParameteri(target, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
        gl.texParameteri(target, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
        gl.texParameteri(target, gl.TEXTURE_BASE_LEVEL, 0);
        gl.texParameteri(target, gl.TEXTURE_MAX_LEVEL, levels.length - 1);
        levels.forEach(({ format, width, height, layers, data }, level) => {
            const [internal, layout, type] = GL_FORMATS[format].map((constant) => gl[constant]);
            if (isArray) {
                gl.texImage3D(target, level, internal, width, height, layers, 0, layout, type, data);
            } else {
                gl.texImage2D(target, level, internal, width, height, 0, layout, type, data);
            }
            this.#bytes += data.byteLength;
        });
        const error = gl.getError();
        if (error) {
            const { width, height, layers } = levels[0];
            throw new OpenBTFError(error === gl.OUT_OF_MEMORY ? 'MEMORY' : 'UNSUPPORTED',
                `${name}: WebGL refuses ${width} x ${height} x ${layers} texels with error 0x${error.toString(16)}`);
        }
    }

    bind(program, firstUnit = 0, prefix = 'btf') {
        const gl = this.#gl;
        const restoreProgram = keepProgram(gl);
        const active = gl.getParameter(gl.ACTIVE_TEXTURE);
        const missing = [];
        let units = 0;
        whole('firstUnit', firstUnit);
        gl.useProgram(program);
        const count = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS);
        for (let i = 0; i < count; i++) {
            const { name, type } = gl.getActiveUniform(program, i);
            const known = this.#textures.get(name.startsWith(`${prefix}_`) ? name.slice(prefix.length + 1) : '');
            if (known) {
                gl.activeTexture(gl.TEXTURE0 + firstUnit + units);
                gl.bindTexture(known.target, known.texture);
                gl.bindSampler(firstUnit + units, null);
                gl.uniform1i(gl.getUniformLocation(program, name), firstUnit + units);
                units++;
            } else if (name.startsWith(`${prefix}_`) && SAMPLERS.some((sampler) => gl[sampler] === type)) {
                missing.push(name);
            }
        }
        restoreProgram();
        gl.activeTexture(active);
        if (missing.length) {
            throw new OpenBTFError('USAGE', `the program reads ${missing.join(', ')}, which was not uploaded`);
        }
        return units;
    }

    destroy() {
        for (const { texture } of this.#textures.values()) {
            this.#gl.deleteTexture(texture);
        }
        this.#textures.clear();
        this.#bytes = 0;
    }
}

const SAMPLERS = ['SAMPLER_2D', 'SAMPLER_2D_ARRAY', 'INT_SAMPLER_2D_ARRAY', 'UNSIGNED_INT_SAMPLER_2D', 'UNSIGNED_INT_SAMPLER_2D_ARRAY'];

export function upload(gl, material, options) {
    webgl2(gl);
    const levels = new Map();
    for (const texture of material.readTextures(options)) {
        const wrong = excess(gl, texture);
        if (wrong) {
            throw new OpenBTFError('UNSUPPORTED', wrong);
        }
        levels.set(texture.name, [...(levels.get(texture.name) ?? []), texture]);
    }
    const textures = new Textures(gl);
    const restore = keepUploadState(gl);
    try {
        levels.forEach((list) => textures.add(list));
    } catch (error) {
        textures.destroy();
        throw error;
    } finally {
        restore();
    }
    return textures;
}
