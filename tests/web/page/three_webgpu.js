/* openbtf/three-webgpu, in a frame, since import maps belong to a page.
 *
 * SPDX-License-Identifier: MIT
 */
import { closeFrame, openFrame } from './frame.js';

export async function run(job) {
    const frame = await openFrame('/page/three_webgpu.html');
    await frame.contentWindow.runThree(job);
    closeFrame(frame);
}
