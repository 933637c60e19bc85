/* What a page tells the server that runs the test.
 *
 * SPDX-License-Identifier: MIT
 */
export const post = (path, value) => fetch(path, { method: 'POST', body: JSON.stringify(value) });

/** A case: passed where `wrong` is empty, else it says what is wrong. */
export const report = (name, wrong = '') => post('/case', { name, wrong });

/** A line for the log. */
export const note = (line) => post('/note', line);

async function get(path) {
    const response = await fetch(path);
    if (!response.ok) {
        throw new Error(`${path}: the server answers ${response.status}`);
    }
    return response;
}
export const json = async (path) => (await get(path)).json();
export const bytes = async (path) => (await get(path)).arrayBuffer();
