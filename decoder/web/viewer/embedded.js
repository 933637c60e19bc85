/* Data that the page holds beside its text: the WebAssembly module and materials, as base64 in elements of their own.
 *
 * SPDX-License-Identifier: MIT
 */
const byId = (id) => document.getElementById(id);

/** The bytes of an element's base64, unpacked where it says that they are gzip. */
async function bytesOf(element) {
    const text = atob(element.textContent.trim());
    const bytes = Uint8Array.from(text, (letter) => letter.charCodeAt(0));
    if (element.dataset.packed !== 'gzip') {
        return bytes;
    }
    if (typeof DecompressionStream === 'undefined') {
        throw new Error('This browser cannot unpack the page: it has no DecompressionStream (Chrome 80, Firefox 113, Safari 16.4 have).');
    }
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'));
    return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** The bytes of openbtf.wasm. */
export const moduleBytes = () => bytesOf(byId('module'));

/** Materials in the page, in its order: [{name, title, about}]. */
export function materials() {
    return [...document.querySelectorAll('script[data-material]')].map(({ dataset }) => ({ name: dataset.material, title: dataset.title,
        about: dataset.about }));
}

/** The bytes of one of them. */
export const materialBytes = (name) => bytesOf([...document.querySelectorAll('script[data-material]')].find(({ dataset }) => dataset.material === name));
