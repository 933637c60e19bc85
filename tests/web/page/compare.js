/* Helpers of comparisons: options and planes of test vectors, counts of differing bits, wrong texts.
 *
 * SPDX-License-Identifier: MIT
 */

/** Counts the values of `count` evaluations whose bits differ; `want` has three words each, `got` four. */
export function differing(got, want, count) {
    let different = 0;
    for (let i = 0; i < count; i++) {
        for (let c = 0; c < 3; c++) {
            different += got[4 * i + c] !== want[3 * i + c] ? 1 : 0;
        }
    }
    return different;
}

/** The options of a vector. */
export function optionsOf(vector, info) {
    const decoded = vector.effects === 'none' || vector.effects === '' ? [] : vector.effects.split(',');
    return {
        leaveOut: info.effects.filter((effect) => !decoded.includes(effect)),
        components: vector.components,
        interpolation: vector.interpolation,
        filter: vector.filter,
    };
}

/** A vector's words of one plane, [count][size], from plane `first` of its 14. */
export function plane(data, first, size) {
    const count = data.length / 14;
    const out = new Uint32Array(size * count);
    for (let i = 0; i < count; i++) {
        out.set(data.subarray(14 * i + first, 14 * i + first + size), size * i);
    }
    return out;
}

/** The offsets of the planes that are compared. */
export const WANTED = { radiance: 8, picked: 11 };

/** Replaces text that must be there. */
export function changed(text, from, to) {
    if (!text.includes(from)) {
        throw new Error(`the shader has no '${from}'`);
    }
    return text.replaceAll(from, to);
}
