/* Options that openbtf/three and openbtf/three-webgpu share. Neither build of three is imported here.
 *
 * SPDX-License-Identifier: MIT
 */
import { OpenBTFError } from './module.js';
import { known } from './records.js';

/* Options of decoding that the materials' shader texts can take: a direction that is fixed or picked at random needs other text. */
const DECODE = ['leaveOut', 'components', 'interpolation', 'filter', 'math'];

/** Copies along u and v of option `repeat`. */
function repeatOf(value) {
    const repeat = typeof value === 'number' ? [value, value] : Array.from(value ?? []);
    if (repeat.length !== 2 || !repeat.every((x) => typeof x === 'number' && Number.isFinite(x))) {
        throw new OpenBTFError('USAGE', `repeat: not a number or two: ${JSON.stringify(value)}`);
    }
    return repeat;
}

/** The options of a material, checked: { repeat: [u, v], decode, parameters: those of three's }. */
export function readOptions({ repeat = 1, decode = {}, ...parameters } = {}) {
    known('decode', decode, DECODE);
    return { repeat: repeatOf(repeat), decode: { ...decode }, parameters };
}
