/* The user's files: picked, dropped or pasted, read with a limit, and told apart by what they hold.
 *
 * SPDX-License-Identifier: MIT
 */
import { open } from '../openbtf/index.js';
import { readHdr } from './hdr.js';

/** Bytes of a file at most: it is copied once into the module's memory, which ends at 4 GB, and unpacked there. */
const MOST_BYTES = 2 ** 30;

const EXR = [0x76, 0x2f, 0x31, 0x01];

async function startsWith(file, bytes) {
    const head = new Uint8Array(await file.slice(0, bytes.length).arrayBuffer());
    return bytes.every((byte, i) => head[i] === byte);
}

/**
 * Opens a file.
 * @returns {material} or {environment: {width, height, pixels}}
 * Throws an Error or OpenBTFError that says why it cannot be used.
 */
export async function readFile(file) {
    if (file.size > MOST_BYTES) {
        throw new Error(`${(file.size / 1e9).toFixed(1)} GB; this page opens files of at most ${(MOST_BYTES / 1e9).toFixed(1)} GB`);
    }
    if (await startsWith(file, [...'#?'].map((letter) => letter.charCodeAt(0)))) {
        return { environment: readHdr(new Uint8Array(await file.arrayBuffer())) };
    }
    // what is no OpenEXR file is refused by its first bytes: the module's memory need not grow for the rest
    const part = (await startsWith(file, EXR)) ? file : file.slice(0, 4096);
    return { material: await open(await part.arrayBuffer()) };
}

/**
 * Listens for files: those dropped on the page, those picked by the input element.
 * @param got called with each File
 */
export function listenFiles(input, got) {
    const carriesFiles = (event) => [...(event.dataTransfer?.types ?? [])].includes('Files');
    let depth = 0; // of elements that a drag has entered and not left
    const hover = (over) => document.body.classList.toggle('dropping', over);
    addEventListener('dragenter', (event) => {
        depth += 1;
        hover(carriesFiles(event));
    });
    addEventListener('dragleave', () => {
        depth = Math.max(depth - 1, 0);
        hover(depth > 0);
    });
    addEventListener('dragover', (event) => {
        if (carriesFiles(event)) {
            event.preventDefault();
            event.dataTransfer.dropEffect = 'copy';
        }
    });
    addEventListener('drop', (event) => {
        depth = 0;
        hover(false);
        if (carriesFiles(event)) {
            event.preventDefault();
            [...event.dataTransfer.files].forEach(got);
        }
    });
    input.addEventListener('change', () => {
        [...input.files].forEach(got);
        input.value = ''; // so that the same file can be picked again
    });
}
