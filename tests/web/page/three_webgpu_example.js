/* decoder/web/examples/three-webgpu.html, tested as three.html is.
 *
 * SPDX-License-Identifier: MIT
 */
import { runExample } from './three_example.js';

export const run = (job) => runExample('three-webgpu', job);
