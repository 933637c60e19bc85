/* What a page tells the server that runs the test.
 *
 * SPDX-License-Identifier: MIT
 */
export const post = (path, value) => fetch(path, { method: 'POST', body: JSON.stringify(value) });

/** A case: passed where `wrong` is empty, else it says what is wrong. */
export const report = (name, wrong = '') => post('/case', { name, wrong });

/** A line for the log. */
export const note = (line) => post('/note', line);

export const json = async (path) => (await fetch(path)).json();
export const bytes = async (path) => (await fetch(path)).arrayBuffer();
