/* OpenBTF in Node.js: the same module, with openbtf.wasm read from beside it, for fetch() knows no files there.
 *
 * SPDX-License-Identifier: MIT
 */
import { readFile } from 'node:fs/promises';
import { provide } from './module.js';

provide(() => readFile(new URL('./openbtf.wasm', import.meta.url)));

export * from './index.js';
