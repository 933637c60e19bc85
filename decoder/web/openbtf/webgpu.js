/* OpenBTF in WebGPU: what webgpu.d.ts documents.
 *
 * SPDX-License-Identifier: MIT
 */
export { selfTest } from './webgpu_self_test.js';
export { Textures, fits, upload } from './webgpu_upload.js';
