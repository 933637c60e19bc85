/* Arguments for comparisons: mostly directions of the hemisphere and coordinates within the image, some extreme.
 *
 * SPDX-License-Identifier: MIT
 */

/** A seeded generator of words (xorshift32). */
export function words(seed) {
    let state = seed | 1;
    return () => {
        state ^= state << 13;
        state ^= state >>> 17;
        state ^= state << 5;
        return state >>> 0;
    };
}

/* Zeros, denormals, around 1 and 2, 2^-24, infinite, NaN, the largest. */
const EXTREMES = Float32Array.from([0, -0, 1e-45, 1, -1, 2 ** -24, 2, 4096, -4096, Infinity, -Infinity, NaN, 3e38, 0.5, 0.999999940395]);

function direction(next, samples, out, at) {
    const kind = next() % 32;
    if (kind === 0) {
        for (let i = 0; i < 3; i++) {
            out[at + i] = EXTREMES[next() % EXTREMES.length];
        }
    } else if (kind < 4) {
        const sample = 3 * (next() % (samples.length / 3));
        out.set(samples.subarray(sample, sample + 3), at);
    } else {
        const z = kind < 6 ? next() / 2 ** 32 / 50 : next() / 2 ** 32;
        const phi = (2 * Math.PI * next()) / 2 ** 32;
        const s = Math.sqrt(1 - z * z);
        out.set([s * Math.cos(phi), s * Math.sin(phi), z], at);
    }
}

/** {uv, light, view}: `count` arguments for a material. */
export function make(material, count, seed) {
    const next = words(seed);
    const uv = new Float32Array(2 * count), light = new Float32Array(3 * count), view = new Float32Array(3 * count);
    const { views, lights } = material;
    for (let i = 0; i < count; i++) {
        for (let c = 0; c < 2; c++) {
            const kind = next() % 16;
            uv[2 * i + c] = kind === 0 ? EXTREMES[next() % EXTREMES.length] : kind < 3 ? (8 * next()) / 2 ** 32 - 4 : next() / 2 ** 32;
        }
        direction(next, lights, light, 3 * i);
        direction(next, views, view, 3 * i);
    }
    return { uv, light, view };
}

/** Arguments as draw() takes them: [2][count][4] words. */
export function pack(uv, light, view) {
    const [a, b, c] = [uv, light, view].map((array) => new Uint32Array(array.buffer, array.byteOffset, array.length));
    const count = a.length / 2;
    const out = new Uint32Array(8 * count);
    for (let i = 0; i < count; i++) {
        out.set([a[2 * i], a[2 * i + 1], b[3 * i], b[3 * i + 1]], 4 * i);
        out.set([b[3 * i + 2], c[3 * i], c[3 * i + 1], c[3 * i + 2]], 4 * (count + i));
    }
    return out;
}
