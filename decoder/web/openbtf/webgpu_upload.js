/* OpenBTF in WebGPU: uploads a material's textures and makes the bind group that its WGSL reads. webgpu.d.ts documents every call but
 * uploadAtOnce() and standIns(), which are for this package alone.
 *
 * SPDX-License-Identifier: MIT
 */
import { textureNames } from './material.js';
import { OpenBTFError } from './module.js';
import { whole } from './records.js';
import { needDevice } from './webgpu_self_test.js';

/* Of each format: WebGPU's name, how a shader reads it. */
const FORMATS = {
    R8UI: ['r8uint', 'uint'],
    RG8UI: ['rg8uint', 'uint'],
    RGBA8UI: ['rgba8uint', 'uint'],
    RGBA8I: ['rgba8sint', 'sint'],
    RGBA16UI: ['rgba16uint', 'uint'],
    RGBA16F: ['rgba16float', 'unfilterable-float'],
    RGBA32F: ['rgba32float', 'unfilterable-float'],
    RGBA32UI: ['rgba32uint', 'uint'],
};

/* Bindings of a shader behind those of the material's textures: a fold, two tables of light sampling, then the zero. */
const ZERO_BEHIND = 3;
const ZERO_BYTES = 16;

/* Of the largest texel. */
const TEXEL_BYTES = 16;

function unsupported(message) {
    return new OpenBTFError('UNSUPPORTED', message);
}

/** Every way in which textures exceed the limits of a device, as text; null when they do not. */
function excess({ limits }, textures) {
    const hint = '; requestDevice() takes requiredLimits up to those of the adapter';
    for (const { name, width, height, layers, isArray } of textures) {
        const advice = name === 'maps' ? '; toTight() takes it apart' : hint;
        const side = Math.max(width, height);
        if (side > limits.maxTextureDimension2D) {
            return `${name}: a side of ${side} exceeds maxTextureDimension2D ${limits.maxTextureDimension2D}${advice}`;
        }
        if (isArray && layers > limits.maxTextureArrayLayers) {
            return `${name}: ${layers} layers exceed maxTextureArrayLayers ${limits.maxTextureArrayLayers}${hint}`;
        }
    }
    const names = new Set(textures.map(({ name }) => name));
    if (names.size > limits.maxSampledTexturesPerShaderStage) {
        return `${names.size} textures exceed maxSampledTexturesPerShaderStage ${limits.maxSampledTexturesPerShaderStage}${hint}`;
    }
    return null;
}

export function fits(device, material, options) {
    needDevice(device);
    return !excess(device, material.readTextures(options));
}

/** The textures of a material on a device. */
export class Textures {
    #textures = new Map(); // by name: GPUTexture
    #zero;
    #bytes = 0;
    #layoutEntries = [];
    #entries = [];
    #layout;
    #bindGroup;
    #device;

    constructor(device) {
        this.#device = device;
    }

    get bytes() {
        return this.#bytes;
    }

    get layoutEntries() {
        return this.#layoutEntries.map((entry) => ({ ...entry }));
    }

    get entries() {
        return this.#entries.map((entry) => ({ ...entry }));
    }

    get layout() {
        return this.#layout;
    }

    get bindGroup() {
        return this.#bindGroup;
    }

    texture(name) {
        return this.#textures.get(name) ?? null;
    }

    /** Adds a texture of `levels`, the finest first. */
    add(levels, binding, visibility) {
        const { name, format, width, height, layers, isArray } = levels[0];
        const [gpuFormat, sampleType] = FORMATS[format];
        const texture = this.#device.createTexture({
            label: `openbtf ${name}`,
            size: [width, height, layers],
            format: gpuFormat,
            mipLevelCount: levels.length,
            usage: GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_DST,
        });
        this.#textures.set(name, texture);
        levels.forEach((level, mipLevel) => {
            const bytesPerRow = level.data.byteLength / level.height / level.layers;
            this.#device.queue.writeTexture({ texture, mipLevel }, level.data, { bytesPerRow, rowsPerImage: level.height },
                [level.width, level.height, level.layers]);
            this.#bytes += level.data.byteLength;
        });
        const viewDimension = isArray ? '2d-array' : '2d';
        this.#layoutEntries.push({ binding, visibility, texture: { sampleType, viewDimension } });
        this.#entries.push({ binding, resource: texture.createView({ dimension: viewDimension }) });
    }

    /** Adds the zero that no compiler knows, and makes the group. Buffers begin as zeros. */
    finish(zeroBinding, visibility) {
        const device = this.#device;
        this.#zero = device.createBuffer({ label: 'openbtf zero', size: ZERO_BYTES, usage: GPUBufferUsage.UNIFORM });
        this.#layoutEntries.push({ binding: zeroBinding, visibility, buffer: { type: 'uniform' } });
        this.#entries.push({ binding: zeroBinding, resource: { buffer: this.#zero } });
        this.#layout = device.createBindGroupLayout({ label: 'openbtf', entries: this.#layoutEntries });
        this.#bindGroup = device.createBindGroup({ label: 'openbtf', layout: this.#layout, entries: this.#entries });
    }

    destroy() {
        this.#textures.forEach((texture) => texture.destroy());
        this.#textures.clear();
        this.#zero?.destroy();
        this.#bytes = 0;
    }
}

/**
 * Gives the textures to the device without waiting for its answer, for who draws in the same task.
 * @returns [textures, a promise that is kept once the device has taken them, or broken with what upload() throws]
 */
export function uploadAtOnce(device, material, options = {}, visibility = undefined) {
    needDevice(device);
    const stages = whole('visibility', visibility, GPUShaderStage.FRAGMENT | GPUShaderStage.COMPUTE);
    const list = material.readTextures(options);
    const wrong = excess(device, list);
    if (wrong) {
        throw unsupported(wrong);
    }
    const names = textureNames();
    const first = whole('option firstBinding', options.firstBinding);
    const zeroBinding = first + names.length + ZERO_BEHIND;
    if (zeroBinding > 0xFFFFFFFF) {
        throw new OpenBTFError('USAGE', `option firstBinding: ${first} puts the last binding at ${zeroBinding}, beyond ${0xFFFFFFFF}`);
    }
    const levels = new Map();
    for (const texture of list) {
        levels.set(texture.name, [...(levels.get(texture.name) ?? []), texture]);
    }
    const textures = new Textures(device);
    device.pushErrorScope('validation');
    device.pushErrorScope('out-of-memory');
    let thrown = null;
    try {
        levels.forEach((of, name) => textures.add(of, first + names.indexOf(name), stages));
        textures.finish(zeroBinding, stages);
    } catch (error) {
        thrown = error;
    }
    // at once: what the caller does next belongs to no scope of this function
    const scopes = Promise.all([device.popErrorScope(), device.popErrorScope()]);
    if (thrown) {
        scopes.catch(() => {}); // what was thrown says more
        textures.destroy();
        throw thrown;
    }
    return [textures, taken(textures, scopes)];
}

/** Waits for the device's answers. Where one is a refusal, the textures are destroyed. */
async function taken(textures, scopes) {
    let noMemory, refused;
    try {
        [noMemory, refused] = await scopes;
    } catch (lost) {
        textures.destroy();
        throw lost;
    }
    if (noMemory || refused) {
        textures.destroy();
        throw noMemory ? new OpenBTFError('MEMORY', `WebGPU has no memory left for textures: ${noMemory.message}`)
            : unsupported(`WebGPU refuses the textures: ${refused.message}`);
    }
}

/** Textures of one texel, of zeros, with the names and formats of a material's: for who must bind something where the device has refused those. */
export function standIns(device, list) {
    const textures = new Textures(device);
    list.forEach(({ name, format, isArray }, binding) => {
        textures.add([{ name, format, isArray, width: 1, height: 1, layers: 1, data: new Uint8Array(TEXEL_BYTES) }], binding, GPUShaderStage.FRAGMENT);
    });
    return textures;
}

export async function upload(device, material, options, visibility) {
    const [textures, settled] = uploadAtOnce(device, material, options, visibility);
    await settled;
    return textures;
}
