/* Light from all around: two environments made by formula and those of .hdr files, and directional lights that stand for them.
 *
 * An environment is an image of latitude and longitude: row 0 is up (+y), the middle column ahead (-z, where the camera at angles 0
 * looks), columns grow to the right (+x), as for btf-render --environment.
 *
 * SPDX-License-Identifier: MIT
 */
import { dot, unit } from './camera.js';

const { PI } = Math;
const LUMINANCE = [0.2126, 0.7152, 0.0722];
const mix = (a, b, t) => a.map((x, i) => x + (b[i] - x) * t);
const smooth = (low, high, x) => {
    const t = Math.min(Math.max((x - low) / (high - low), 0), 1);
    return t * t * (3 - 2 * t);
};

/* Radiance of a clear sky with a low sun over dark ground. */
function sky(d) {
    const sun = unit([0.55, 0.5, 0.67]);
    const towards = Math.max(dot(d, sun), 0);
    const above = mix([0.75, 0.86, 1], [0.16, 0.3, 0.62], smooth(0, 0.8, d[1]));
    const below = mix([0.3, 0.28, 0.25], [0.1, 0.09, 0.08], smooth(0, 0.6, -d[1]));
    const base = mix(below, above, smooth(-0.02, 0.03, d[1]));
    const glow = 1.2 * towards ** 12 + 90 * smooth(0.9965, 0.9985, towards);
    return base.map((x, i) => x + glow * [1, 0.86, 0.66][i]);
}

/* Radiance of a dark studio with three soft boxes: a warm one from the left, a large cool one above, a narrow one behind on the right. */
const BOXES = [
    { at: [-0.75, 0.35, 0.55], width: 0.42, colour: [7.5, 6.6, 5.4] },
    { at: [0.15, 0.97, 0.15], width: 0.6, colour: [2.6, 2.9, 3.3] },
    { at: [0.85, 0.1, -0.5], width: 0.22, colour: [5, 6, 8] },
];
function studio(d) {
    const out = mix([0.035, 0.035, 0.04], [0.09, 0.09, 0.1], smooth(-1, 1, d[1]));
    for (const { at, width, colour } of BOXES) {
        const inside = smooth(Math.cos(width * 1.15), Math.cos(width * 0.85), dot(d, unit(at)));
        colour.forEach((x, i) => { out[i] += x * inside; });
    }
    return out;
}

/** The direction to the middle of a pixel, or to a fraction of it. */
function directionOf(x, y, width, height) {
    const theta = (PI * y) / height, longitude = ((2 * x) / width - 1) * PI;
    return [Math.sin(theta) * Math.sin(longitude), Math.cos(theta), -Math.sin(theta) * Math.cos(longitude)];
}

function paint(radiance, width = 256, height = 128) {
    const pixels = new Float32Array(3 * width * height);
    for (let y = 0, at = 0; y < height; y++) {
        for (let x = 0; x < width; x++, at += 3) {
            pixels.set(radiance(directionOf(x + 0.5, y + 0.5, width, height)), at);
        }
    }
    return { width, height, pixels };
}

const MADE = { sky, studio };
const made = new Map();

/** An environment made by formula, 'sky' or 'studio': {width, height, pixels}. */
export function madeEnvironment(name) {
    if (!made.has(name)) {
        made.set(name, paint(MADE[name]));
    }
    return made.get(name);
}

/** An image no wider than `most`, by means of whole blocks of pixels; the same one where it is already. */
export function shrunk(image, most = 2048) {
    const by = Math.ceil(image.width / most);
    if (by <= 1) {
        return image;
    }
    const width = Math.floor(image.width / by), height = Math.max(1, Math.floor(image.height / by));
    const pixels = new Float32Array(3 * width * height), share = 1 / (by * by);
    for (let y = 0; y < height * by && y < image.height; y++) {
        for (let x = 0; x < width * by; x++) {
            const from = 3 * (y * image.width + x), to = 3 * (Math.floor(y / by) * width + Math.floor(x / by));
            for (let c = 0; c < 3; c++) {
                pixels[to + c] += share * image.pixels[from + c];
            }
        }
    }
    return { width, height, pixels };
}

/** Solid angle of a pixel of row y. */
function solidAngle(y, width, height) {
    return (Math.cos((PI * y) / height) - Math.cos((PI * (y + 1)) / height)) * ((2 * PI) / width);
}

/* The first index whose running sum is above `value`. */
function find(sums, from, count, value) {
    let low = 0, high = count - 1;
    while (low < high) {
        const middle = (low + high) >> 1;
        if (sums[from + middle] > value) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    return low;
}

/* Two-dimensional points that fill the unit square evenly, however many are taken (M. Roberts, "The unreasonable effectiveness of
 * quasirandom sequences", 2018): multiples of 1 / g and 1 / g^2, where g^3 = g + 1. */
const point = (n) => [(0.5 + n * 0.7548776662466927) % 1, (0.5 + n * 0.5698402909980532) % 1];

/** Draws directions of an environment with a probability proportional to what comes from there. */
export class Sampler {
    #image;
    #rows; // running sums of the rows' energy
    #columns; // of each row, running sums of its pixels' energy

    constructor(image) {
        const { width, height, pixels } = image;
        this.#image = image;
        this.#rows = new Float64Array(height);
        this.#columns = new Float64Array(width * height);
        let total = 0;
        for (let y = 0; y < height; y++) {
            let row = 0;
            const angle = solidAngle(y, width, height);
            for (let x = 0; x < width; x++) {
                row += angle * this.#luminance(y * width + x, pixels);
                this.#columns[y * width + x] = row;
            }
            total += row;
            this.#rows[y] = total;
        }
        this.total = total;
    }

    /* Of a pixel; values that are negative or no number count as 0. */
    #luminance(index, pixels) {
        let sum = 0;
        for (let c = 0; c < 3; c++) {
            const value = pixels[3 * index + c];
            sum += value > 0 && value < 1e30 ? value * LUMINANCE[c] : 0;
        }
        return sum;
    }

    /**
     * Directional lights that together stand for the environment; over rising `number` their mean comes as near as one likes.
     * @param turn degrees to the right
     * @returns [{at: unit vector to the light, colour: irradiance over pi at normal incidence}]
     */
    lights(number, count, turn) {
        const { width, height, pixels } = this.#image, found = [];
        for (let i = 0; i < count && this.total > 0; i++) {
            const [u, v] = point(number * count + i);
            const y = find(this.#rows, 0, height, v * this.total);
            const inRow = this.#columns[y * width + width - 1];
            const x = find(this.#columns, y * width, width, u * inRow);
            const index = y * width + x;
            const weight = this.total / (this.#luminance(index, pixels) * count * PI);
            // a place within the pixel by what is left of the two numbers
            const before = [y ? this.#rows[y - 1] : 0, x ? this.#columns[index - 1] : 0];
            const within = [
                (u * inRow - before[1]) / (this.#columns[index] - before[1] || 1),
                (v * this.total - before[0]) / (this.#rows[y] - before[0] || 1),
            ];
            const d = directionOf(x + within[0] + (turn / 360) * width, y + within[1], width, height);
            found.push({ at: d, colour: [0, 1, 2].map((c) => weight * Math.max(pixels[3 * index + c], 0)) });
        }
        return found;
    }
}
