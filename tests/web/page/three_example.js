/* Runs decoder/web/examples/three.html or three-webgpu.html in a frame, turns the camera with the pointer, and checks
 * the picture.
 *
 * SPDX-License-Identifier: MIT
 */
import { closeFrame, openFrame, pixelsOf, statusOf } from './frame.js';
import { picture, report } from './post.js';

/* For each example the function that draws to its canvas: [class, function, predicate of calls on that canvas]. */
const DRAWS = {
    three: ['WebGL2RenderingContext', 'drawElements', (gl, canvas) => gl.canvas === canvas],
    'three-webgpu': ['GPUCanvasContext', 'getCurrentTexture', (context, canvas) => context.canvas === canvas],
};

/** Calls `act`, which moves the camera, and returns the canvas once the example has drawn: in the task of the event or
 * in the next frame. */
function after(frame, canvas, example, act) {
    return new Promise((resolve) => {
        const [kind, name, draws] = DRAWS[example];
        const { prototype } = frame.contentWindow[kind];
        const call = prototype[name];
        let drawn = false;
        prototype[name] = function (...args) {
            if (!drawn && draws(this, canvas)) {
                drawn = true;
                queueMicrotask(() => { // the picture is complete when the task ends
                    prototype[name] = call;
                    resolve(pixelsOf(canvas));
                });
            }
            return call.apply(this, args);
        };
        act();
    });
}

function drag(frame, canvas, from, to) {
    const { left, top } = canvas.getBoundingClientRect();
    const send = (type, [x, y], target) => target.dispatchEvent(new frame.contentWindow.PointerEvent(type, { pointerId: 1, pointerType: 'mouse',
        button: 0, buttons: type === 'pointerup' ? 0 : 1, clientX: left + x, clientY: top + y, pageX: left + x, pageY: top + y, bubbles: true }));
    canvas.setPointerCapture = canvas.releasePointerCapture = () => {}; // they would throw: the pointer is simulated
    send('pointerdown', from, canvas);
    send('pointermove', to, canvas);
    send('pointerup', to, canvas);
}

const coloursOf = (pixels) => new Set(new Uint32Array(pixels.buffer)).size;

function differing(a, b) {
    let count = 0;
    for (let i = 0; i < a.length; i += 4) {
        count += a[i] !== b[i] || a[i + 1] !== b[i + 1] || a[i + 2] !== b[i + 2] ? 1 : 0;
    }
    return count;
}

/** Tests one of the two. */
export async function runExample(example, { material, damaged }) {
    const frame = await openFrame(`/example/${example}.html?${material}`);
    const said = await statusOf(frame);
    await report(`${example} example: a material is shown`, /^\d+ x \d+ texels, \d+ bytes$/.test(said) ? '' : said);
    const canvas = frame.contentDocument.getElementById('canvas');
    const first = await after(frame, canvas, example, () => drag(frame, canvas, [250, 250], [252, 250]));
    const second = await after(frame, canvas, example, () => drag(frame, canvas, [250, 250], [330, 250]));
    await report(`${example} example: the picture has many colours`, coloursOf(first) > 500 ? '' : `${coloursOf(first)}`);
    await picture(`${example} example`, first, canvas.width);
    const moved = differing(first, second);
    await report(`${example} example: dragging turns it`, moved > 10000 ? '' : `${moved} pixels changed`);
    closeFrame(frame);
    const refused = await openFrame(`/example/${example}.html?${damaged}`);
    const message = await statusOf(refused);
    await report(`${example} example: a file that is no material is refused in words`, /not an OpenEXR file/.test(message) ? '' : message);
    closeFrame(refused);
}

export const run = (job) => runExample('three', job);
