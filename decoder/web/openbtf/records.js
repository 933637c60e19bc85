/* OpenBTF: options, scenes and arrays of the user's as the module takes them: checked, in records of 32-bit words.
 *
 * SPDX-License-Identifier: MIT
 */
import { OpenBTFError, put } from './module.js';

/** Effects by bit (FORMAT.md section 3). */
export const EFFECTS = ['shadow', 'shift', 'hidden', 'gain', 'residual', 'relief', 'gloss'];

const CHOICES = {
    interpolation: ['linear', 'nearest'],
    filter: ['texel', 'bilinear', 'steep'],
    math: ['exact', 'fast'],
    picks: ['none', 'view', 'light', 'all'],
    language: ['glsl', 'wgsl'],
};

/** Options of source(), of openbtf/webgl and openbtf/webgpu; evaluate() takes those in EVALUATE. */
export const DECODE = ['leaveOut', 'components', 'interpolation', 'filter', 'math', 'havePrecise', 'prefix', 'fixedView', 'fixedLight', 'picks',
    'language', 'group', 'firstBinding'];
export const EVALUATE = ['leaveOut', 'components', 'interpolation', 'filter', 'picks', 'level', 'reference', 'random'];

function usage(message) {
    return new OpenBTFError('USAGE', message);
}

function choice(name, value) {
    const index = value === undefined ? 0 : CHOICES[name].indexOf(value);
    if (index < 0) {
        throw usage(`option ${name}: ${JSON.stringify(value)} is none of ${CHOICES[name].join(', ')}`);
    }
    return index;
}

/** A whole number of 32 bits. */
export function whole(name, value, otherwise = 0) {
    if (value === undefined) {
        return otherwise;
    }
    if (!Number.isInteger(value) || value < 0 || value > 0xFFFFFFFF) {
        throw usage(`${name}: ${value} is no whole number from 0 to ${0xFFFFFFFF}`);
    }
    return value;
}

function finite(name, value) {
    if (typeof value !== 'number' || !Number.isFinite(value)) {
        throw usage(`${name}: ${value} is no finite number`);
    }
    return value;
}

function vector(name, value, length) {
    if (value?.length !== length) {
        throw usage(`${name}: not ${length} numbers`);
    }
    return Array.from(value, (x) => finite(name, x));
}

/** The mask of an array of names of effects. */
export function effectBits(name, list = []) {
    let bits = 0;
    if (!Array.isArray(list)) {
        throw usage(`${name}: not an array of names of effects`);
    }
    for (const effect of list) {
        const bit = EFFECTS.indexOf(effect);
        if (bit < 0) {
            throw usage(`${name}: ${JSON.stringify(effect)} is none of ${EFFECTS.join(', ')}`);
        }
        bits |= 1 << bit;
    }
    return bits;
}

/** Refuses members that nothing reads: they are mistyped. */
export function known(what, object, names) {
    if (object === null || typeof object !== 'object') {
        throw usage(`${what}: not an object`);
    }
    for (const name of Object.keys(object)) {
        if (!names.includes(name)) {
            throw usage(`${what}: ${name} is none of ${names.join(', ')}`);
        }
    }
}

/** A record that is written word by word. */
class Words {
    constructor(count) {
        this.view = new DataView(new ArrayBuffer(4 * count));
        this.at = 0;
    }

    integers(...values) {
        for (const value of values) {
            this.view.setUint32(this.at, value, true);
            this.at += 4;
        }
        return this;
    }

    floats(...values) {
        for (const value of values) {
            this.view.setFloat32(this.at, value, true);
            this.at += 4;
        }
        return this;
    }

    /** The bytes; every word must have been written. */
    bytes() {
        if (this.at !== this.view.byteLength) {
            throw new OpenBTFError('INTERNAL', `a record of ${this.at} bytes, not ${this.view.byteLength}`);
        }
        return new Uint8Array(this.view.buffer);
    }
}

/** Options as a btf_web_options in the module's memory. `names`: those that the caller of this may give. */
export function putOptions(allocate, options = {}, names = DECODE) {
    known('options', options, names);
    const { prefix, fixedView, fixedLight } = options;
    if (prefix !== undefined && typeof prefix !== 'string') {
        throw usage('option prefix: not a string');
    }
    const words = new Words(18)
        .integers(effectBits('option leaveOut', options.leaveOut), whole('option components', options.components))
        .integers(choice('interpolation', options.interpolation), choice('filter', options.filter))
        .integers(choice('math', options.math), options.havePrecise ? 1 : 0, (fixedView ? 1 : 0) | (fixedLight ? 2 : 0))
        .floats(...(fixedView ? vector('option fixedView', fixedView, 3) : [0, 0, 0]))
        .floats(...(fixedLight ? vector('option fixedLight', fixedLight, 3) : [0, 0, 0]))
        .integers(choice('picks', options.picks), choice('language', options.language))
        .integers(whole('option group', options.group), whole('option firstBinding', options.firstBinding))
        .integers(prefix === undefined ? 0 : put(allocate, new TextEncoder().encode(`${prefix}\0`)));
    return put(allocate, words.bytes());
}

function range(words, name, value = {}) {
    known(`scene ${name}`, value, ['theta', 'phi', 'direction']);
    const { theta = [0, 0], phi = [0, 0], direction } = value;
    words.floats(...vector(`scene ${name}.theta`, theta, 2), ...vector(`scene ${name}.phi`, phi, 2));
    words.integers(direction ? 1 : 0);
    words.floats(...(direction ? vector(`scene ${name}.direction`, direction, 3) : [0, 0, 0]));
}

/** A scene as the bytes of a btf_web_scene. */
export function sceneBytes(scene = {}, tolerance = 0.5) {
    known('scene', scene, ['view', 'light', 'pixels', 'lights', 'interpolate']);
    const words = new Words(20);
    range(words, 'view', scene.view);
    range(words, 'light', scene.light);
    words.floats(finite('scene pixels', scene.pixels ?? 0));
    words.integers(whole('scene lights', scene.lights), scene.interpolate ? 1 : 0);
    words.floats(finite('tolerance', tolerance));
    return words.bytes();
}

/** A typed array of the numbers of an array, itself where it is of that type. */
export function typed(Type, name, value) {
    if (value instanceof Type) {
        return value;
    }
    if (!Array.isArray(value) && !ArrayBuffer.isView(value)) {
        throw usage(`${name}: not an array of numbers`);
    }
    return Type.from(value);
}

/** Arguments of evaluate() as a btf_web_evaluations in the module's memory: [its address, that of the result, count]. */
export function putEvaluations(allocate, uv, lights, views, options) {
    const arrays = [['uv', uv], ['light', lights], ['view', views]].map(([name, value]) => typed(Float32Array, name, value));
    const count = arrays[0].length / 2;
    if (!Number.isInteger(count)) {
        throw usage(`uv: ${arrays[0].length} numbers are no pairs`);
    }
    const once = ['light', 'view'].map((name, i) => {
        const { length } = arrays[i + 1];
        if (length !== 3 && length !== 3 * count) {
            throw usage(`${name}: ${length} numbers, neither 3 nor 3 for each of ${count} texture coordinates`);
        }
        return length === 3 && count !== 1;
    });
    let random = 0;
    if ((options.picks ?? 'none') !== 'none') {
        const numbers = typed(Uint32Array, 'option random', options.random);
        if (numbers.length !== 3 * count) {
            throw usage(`option random: ${numbers.length} numbers, not 3 for each of ${count} texture coordinates`);
        }
        random = put(allocate, numbers);
    }
    const [atUv, atLights, atViews] = arrays.map((array) => put(allocate, array));
    const out = allocate(12 * count);
    const words = new Words(9)
        .integers(count, atUv, atLights, atViews, (once[1] ? 1 : 0) | (once[0] ? 2 : 0), whole('option level', options.level))
        .integers(options.reference ? 1 : 0, random, out);
    return [put(allocate, words.bytes()), out, count];
}
