/* Reads Radiance HDR images (RGBE; G. Ward, "Real Pixels", Graphics Gems II, 1991).
 *
 * SPDX-License-Identifier: MIT
 */
const MOST_PIXELS = 2 ** 25;
const MOST_HEADER = 65536, MOST_LINE = 4096; // bytes

class Bytes {
    constructor(data) {
        this.data = data;
        this.at = 0;
    }

    next() {
        if (this.at >= this.data.length) {
            throw new Error('the file ends before its last pixel');
        }
        return this.data[this.at++];
    }

    /** A line of text without its end. */
    line() {
        const length = this.data.subarray(this.at, Math.min(this.at + MOST_LINE, MOST_HEADER)).indexOf(10);
        if (length < 0) {
            throw new Error(`the header does not end: at most ${MOST_HEADER} bytes are read, and ${MOST_LINE} of a line`);
        }
        const end = this.at + length;
        const text = String.fromCharCode(...this.data.subarray(this.at, end));
        this.at = end + 1;
        return text.trimEnd();
    }
}

/* A row whose four components are packed one after the other, in runs and literals. */
function packedRow(bytes, row, width) {
    for (let component = 0; component < 4; component++) {
        for (let x = 0; x < width;) {
            const count = bytes.next();
            const run = count > 128;
            const length = run ? count - 128 : count;
            if (length === 0 || length > width - x) {
                throw new Error(`a run of ${length} pixels where ${width - x} are left of a row`);
            }
            const value = run ? bytes.next() : 0;
            for (let i = 0; i < length; i++) {
                row[4 * x++ + component] = run ? value : bytes.next();
            }
        }
    }
}

/* A row pixel by pixel; (1, 1, 1, n) repeats the pixel before n times, several of them in base 256. */
function plainRow(bytes, row, width, first) {
    let shift = 0;
    for (let x = 0, pixel = first; x < width; pixel = undefined) {
        const [r, g, b, e] = pixel ?? [bytes.next(), bytes.next(), bytes.next(), bytes.next()];
        if (r === 1 && g === 1 && b === 1 && x > 0) {
            const count = shift < 24 ? e << shift : width;
            if (count > width - x) {
                throw new Error('a run is longer than its row');
            }
            for (let i = 0; i < count; i++, x++) {
                row.copyWithin(4 * x, 4 * x - 4, 4 * x);
            }
            shift += 8;
        } else {
            row.set([r, g, b, e], 4 * x++);
            shift = 0;
        }
    }
}

/**
 * Reads an image.
 * @param data Uint8Array of the whole file
 * @returns {width, height, pixels: Float32Array [height][width][3], linear, row 0 the top}
 * Throws an Error whose message says what is wrong with the file.
 */
export function readHdr(data) {
    const bytes = new Bytes(data);
    if (!/^#\?/.test(bytes.line())) {
        throw new Error('not a Radiance HDR image: it does not begin with #?');
    }
    let format = '32-bit_rle_rgbe', exposure = 1;
    for (let line = bytes.line(); line !== ''; line = bytes.line()) {
        const [, name, value] = /^(\w+)\s*=\s*(.*)$/.exec(line) ?? [];
        if (name === 'FORMAT') {
            format = value;
        } else if (name === 'EXPOSURE' && Number(value) > 0) {
            exposure *= Number(value);
        }
    }
    if (format !== '32-bit_rle_rgbe') {
        throw new Error(`its FORMAT is ${format}, and 32-bit_rle_rgbe is read`);
    }
    const size = /^-Y (\d+) \+X (\d+)$/.exec(bytes.line());
    if (!size) {
        throw new Error('its rows do not go from the top down, left to right (-Y height +X width)');
    }
    const [height, width] = [Number(size[1]), Number(size[2])];
    if (!width || !height || width * height > MOST_PIXELS) {
        throw new Error(`${width} x ${height} pixels; at most ${MOST_PIXELS} are read`);
    }
    if (height > width) {
        throw new Error(`${width} x ${height} pixels: an environment of latitude and longitude is wider than high`);
    }
    const pixels = new Float32Array(3 * width * height), row = new Uint8Array(4 * width);
    for (let y = 0; y < height; y++) {
        const first = [bytes.next(), bytes.next(), bytes.next(), bytes.next()];
        if (first[0] === 2 && first[1] === 2 && first[2] < 128 && 256 * first[2] + first[3] === width) {
            packedRow(bytes, row, width);
        } else {
            plainRow(bytes, row, width, first);
        }
        for (let x = 0; x < width; x++) {
            const factor = row[4 * x + 3] ? 2 ** (row[4 * x + 3] - 136) / exposure : 0;
            for (let c = 0; c < 3; c++) {
                pixels[3 * (y * width + x) + c] = row[4 * x + c] * factor;
            }
        }
    }
    return { width, height, pixels };
}
