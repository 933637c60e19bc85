/* Messages of a page to the server that runs the test.
 *
 * SPDX-License-Identifier: MIT
 */
export const post = (path, value) => fetch(path, { method: 'POST', body: JSON.stringify(value) });

/** Reports a case: it passed where `wrong` is empty; else `wrong` says why it failed. */
export const report = (name, wrong = '') => post('/case', { name, wrong });

/** A line for the log. */
export const note = (line) => post('/note', line);

/** Sends a picture, [side][side][4] bytes, for people who look at the test's pictures (BTF_PICTURES of
 * run_browser.mjs). */
export async function picture(name, pixels, side) {
    const canvas = document.createElement('canvas');
    canvas.width = canvas.height = side;
    canvas.getContext('2d').putImageData(new ImageData(new Uint8ClampedArray(pixels), side, side), 0, 0);
    await post('/picture', { name, url: canvas.toDataURL() });
}

async function get(path) {
    const response = await fetch(path);
    if (!response.ok) {
        throw new Error(`${path}: the server answers ${response.status}`);
    }
    return response;
}
export const json = async (path) => (await get(path)).json();
export const bytes = async (path) => (await get(path)).arrayBuffer();
