/* Opens pages, such as the examples, in frames.
 *
 * SPDX-License-Identifier: MIT
 */

/** All URLs that pages in closed frames asked for. */
export const asked = [];

/** URLs that a page's policy blocked, here and in the frames. */
export const refused = [];

/** Listens to a document's refused requests. */
export function watch(of) {
    of.addEventListener('securitypolicyviolation', (event) => refused.push(event.blockedURI));
}

/** A page in a frame, once it has loaded. */
export async function openFrame(url, width = 600, height = 600) {
    const frame = document.createElement('iframe');
    Object.assign(frame, { width, height, src: url });
    const loaded = new Promise((resolve) => { frame.onload = resolve; });
    document.body.append(frame);
    await loaded;
    watch(frame.contentDocument);
    return frame;
}

/** The text of the element with id `status`, once it is another than 'Loading'. */
export async function statusOf(frame) {
    const status = frame.contentDocument.getElementById('status');
    if (status.textContent === 'Loading') {
        await new Promise((resolve) => {
            new MutationObserver(resolve).observe(status, { childList: true, characterData: true, subtree: true });
        });
    }
    return status.textContent;
}

/** The canvas as [height][width][4] bytes. It has to be copied in the task that draws it, since it is empty after
 * that. */
export function pixelsOf(canvas) {
    const copy = document.createElement('canvas');
    [copy.width, copy.height] = [canvas.width, canvas.height];
    const to = copy.getContext('2d');
    to.drawImage(canvas, 0, 0);
    return to.getImageData(0, 0, copy.width, copy.height).data;
}

/** Closes a frame. */
export function closeFrame(frame) {
    asked.push(...frame.contentWindow.performance.getEntriesByType('resource').map(({ name }) => name));
    frame.remove();
}
