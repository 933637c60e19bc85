/* OpenBTF in JavaScript: opens materials, hands out their textures and shader text, evaluates them. index.d.ts documents
 * every call; openbtf/webgl uploads to WebGL2, openbtf/webgpu to WebGPU.
 *
 * SPDX-License-Identifier: MIT
 */
export { OpenBTFError, load, memoryBytes } from './module.js';
export { Material, open } from './material.js';
