/* OpenBTF: a material in memory. index.d.ts says what each call takes and gives.
 *
 * SPDX-License-Identifier: MIT
 */
import { OpenBTFError, bytesAt, call, check, load, put, text, withMemory } from './module.js';
import { EVALUATE, effectBits, known, putEvaluations, putOptions, sceneBytes, whole } from './records.js';

/** By btf_format: the name, how the bytes are seen, channels. Halves are seen as their bits. */
export const FORMATS = [
    undefined, ['R8UI', Uint8Array, 1], ['RG8UI', Uint8Array, 2], ['RGBA8UI', Uint8Array, 4], ['RGBA8I', Int8Array, 4],
    ['RGBA16UI', Uint16Array, 4], ['RGBA16F', Uint16Array, 4], ['RGBA32F', Float32Array, 4], ['RGBA32UI', Uint32Array, 4],
];

/** Names of textures, by btf_texture_id. */
export function textureNames() {
    const names = [];
    for (let name; (name = text(call('texture_name', names.length)));) {
        names.push(name);
    }
    return names;
}

/* Bytes of btf_web_texture. */
const TEXTURE_BYTES = 28;

/** Opening is for this file alone; plans know the material and the scene that they are for. */
const KEY = Symbol('openbtf');
const plans = new WeakMap();

export class Material {
    #address;
    #info;

    constructor(key, address) {
        if (key !== KEY) {
            throw new OpenBTFError('USAGE', 'a Material is made by open()');
        }
        this.#address = address;
    }

    #open() {
        if (!this.#address) {
            throw new OpenBTFError('USAGE', 'the material is closed');
        }
        return this.#address;
    }

    get closed() {
        return !this.#address;
    }

    get info() {
        if (!this.#info) {
            const json = text(call('info', this.#open()));
            check();
            this.#info = freeze(JSON.parse(json));
        }
        this.#open();
        return this.#info;
    }

    get views() {
        return this.#directions(0, this.info.viewCount);
    }

    get lights() {
        return this.#directions(1, this.info.lightCount);
    }

    #directions(lights, count) {
        const bytes = bytesAt(call('directions', this.#open(), lights), 12 * count);
        return new Float32Array(bytes.slice().buffer);
    }

    textures(options) {
        return this.readTextures(options).map((texture) => ({ ...texture, data: texture.data.slice() }));
    }

    /** textures() without copies: `data` must be read before any other call, which may move it. */
    readTextures(options) {
        const address = this.#open();
        const read = options ? withMemory((allocate) => call('textures_read', address, putOptions(allocate, options))) : 0xFFFFFFFF;
        const components = options?.components ?? 0;
        const found = [];
        for (const [id, name] of textureNames().entries()) {
            for (let level = 0; (read >>> id) & 1 && level < this.info.levels; level++) {
                const record = call('get_texture', address, level, id, components);
                const words = new Uint32Array(bytesAt(record, TEXTURE_BYTES).slice().buffer);
                if (words[0]) {
                    found.push({ name, level, words });
                }
            }
        }
        // No call from here on: one that makes the memory grow would leave earlier arrays without their bytes.
        return found.map(({ name, level, words: [format, isArray, width, height, layers, data, size] }) => {
            const [formatName, Type, channels] = FORMATS[format];
            const bytes = bytesAt(data, size);
            return { name, level, format: formatName, isArray: isArray === 1, width, height, layers, channels,
                data: new Type(bytes.buffer, bytes.byteOffset, size / Type.BYTES_PER_ELEMENT) };
        });
    }

    source(options = {}) {
        const address = this.#open();
        return withMemory((allocate) => {
            const source = call('source', address, putOptions(allocate, options));
            check();
            return text(source);
        });
    }

    plan(scene = {}, tolerance = 0.5) {
        const address = this.#open();
        const bytes = sceneBytes(scene, tolerance);
        const json = withMemory((allocate) => text(call('plan', address, put(allocate, bytes))));
        check();
        const plan = freeze(JSON.parse(json));
        plans.set(plan, { material: this, bytes });
        return plan;
    }

    #sceneOf(plan) {
        const known = plans.get(plan);
        if (known?.material !== this) {
            throw new OpenBTFError('USAGE', 'not a plan that plan() of this material gave');
        }
        return known.bytes;
    }

    predict(plan, effects, components = 0) {
        const address = this.#open();
        const bytes = this.#sceneOf(plan);
        const bits = effectBits('effects', effects);
        const json = withMemory((allocate) => text(call('predict', address, put(allocate, bytes), bits, whole('components', components))));
        check();
        return JSON.parse(json);
    }

    restrict(plan) {
        const address = this.#open();
        const bytes = this.#sceneOf(plan);
        return made(withMemory((allocate) => call('restrict', address, put(allocate, bytes))));
    }

    toTight() {
        return made(call('to_tight', this.#open()));
    }

    evaluate(uv, light, view, options = {}) {
        const address = this.#open();
        known('options', options, EVALUATE);
        return withMemory((allocate) => {
            const { level, reference, random, ...decode } = options;
            const how = putOptions(allocate, decode, EVALUATE);
            const [evaluations, out, count] = putEvaluations(allocate, uv, light, view, options);
            call('evaluate', address, how, evaluations);
            check();
            return new Float32Array(bytesAt(out, 12 * count).slice().buffer);
        });
    }

    close() {
        if (this.#address) {
            call('close', this.#address);
            this.#address = 0;
        }
    }
}

/* A call's new material, or the error that it left. */
function made(address) {
    check();
    return new Material(KEY, address);
}

function freeze(value) {
    if (value && typeof value === 'object') {
        Object.values(value).forEach(freeze);
        Object.freeze(value);
    }
    return value;
}

export async function open(data) {
    if (!(data instanceof ArrayBuffer) && !ArrayBuffer.isView(data)) {
        const what = data === null ? 'null' : typeof data === 'object' ? data.constructor?.name ?? 'an object' : typeof data;
        throw new OpenBTFError('USAGE', `open takes an ArrayBuffer or a typed array, not ${what}`);
    }
    await load();
    const bytes = ArrayBuffer.isView(data) ? new Uint8Array(data.buffer, data.byteOffset, data.byteLength) : new Uint8Array(data);
    return made(withMemory((allocate) => call('open', put(allocate, bytes), bytes.byteLength)));
}
