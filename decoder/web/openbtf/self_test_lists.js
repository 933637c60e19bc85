/* A texture of lists for the self-tests of WebGL and WebGPU, which read it as lists of shifts and gains are read.
 *
 * SPDX-License-Identifier: MIT
 */

/** Bytes [layer][texel][2] and number of layers, of side x side texels: layers 0 and 1 name a layer in each half of a byte;
 * layers from 2 on have a word of their own in each texel. */
export function lists(side) {
    const layers = 16, texels = side * side;
    const bytes = new Uint8Array(layers * texels * 2);
    for (let i = 0; i < texels; i++) {
        for (let view = 0; view < 3; view++) {
            bytes[((view >> 1) * texels + i) * 2] |= (2 + ((i + 5 * view) % 14)) << (4 * (view % 2));
        }
        for (let layer = 2; layer < layers; layer++) {
            const word = (layer * texels + i) * 1021;
            bytes[(layer * texels + i) * 2] = word;
            bytes[(layer * texels + i) * 2 + 1] = word >> 8;
        }
    }
    return [bytes, layers];
}
