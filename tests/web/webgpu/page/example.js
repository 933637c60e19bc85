/* Runs decoder/web/examples/webgpu.html in a frame, moves the pointer over it, and compares pixels with the reference decoder.
 *
 * SPDX-License-Identifier: MIT
 */
import { open } from '/package/index.js';

const SIDE = 512;

/** Opens the example with a material, and waits until it no longer says that it loads. */
async function show(name) {
    const frame = document.createElement('iframe');
    frame.width = frame.height = 600;
    frame.src = `/example/webgpu.html?${name}`;
    document.body.append(frame);
    await new Promise((resolve) => { frame.onload = resolve; });
    const status = frame.contentDocument.getElementById('status');
    if (status.textContent === 'Loading') {
        await new Promise((resolve) => { new MutationObserver(resolve).observe(status, { childList: true, characterData: true, subtree: true }); });
    }
    return { frame, said: status.textContent, canvas: frame.contentDocument.getElementById('canvas') };
}

/** The picture with the pointer at a pixel; it is read in the task in which it is drawn. */
function lit({ frame, canvas }, x, y) {
    const copy = document.createElement('canvas');
    copy.width = copy.height = SIDE;
    const rectangle = canvas.getBoundingClientRect();
    canvas.dispatchEvent(new frame.contentWindow.PointerEvent('pointermove', { clientX: rectangle.left + x, clientY: rectangle.top + y, bubbles: true }));
    const to = copy.getContext('2d');
    to.drawImage(canvas, 0, 0);
    return to.getImageData(0, 0, SIDE, SIDE).data;
}

/** Returns '' or a text on how the pixels differ from the reference by more than rounding, under the light over a
 * pixel. */
async function compare(pixels, name, x, y) {
    const material = await open(await (await fetch(`/golden/${name}`)).arrayBuffer());
    const light = [x / 256 - 1, 1 - y / 256, 0];
    light[2] = Math.sqrt(1 - light[0] ** 2 - light[1] ** 2);
    let most = 0;
    for (let row = 5; row < SIDE; row += 50) {
        for (let column = 3; column < SIDE; column += 50) {
            const rgb = material.evaluate([(column + 0.5) / SIDE, 1 - (row + 0.5) / SIDE], light, [0, 0, 1], { reference: true });
            for (let c = 0; c < 3; c++) {
                most = Math.max(most, Math.abs(pixels[4 * (row * SIDE + column) + c] - 255 * Math.min(rgb[c], 1) ** (1 / 2.2)));
            }
        }
    }
    material.close();
    const colours = new Set(new Uint32Array(pixels.buffer)).size;
    return most <= 1 && colours > 10 ? '' : `${most} of 255 apart, ${colours} colours`;
}

const post = (path, value) => fetch(path, { method: 'POST', body: JSON.stringify(value) });
const report = (name, wrong = '') => post('/case', { name, wrong });

async function run() {
    const { material: name, damaged } = await (await fetch('/job')).json();
    const shown = await show(name);
    await report('example: a material is shown', /^\d+ x \d+ texels, \d+ bytes$/.test(shown.said) ? '' : shown.said);
    for (const [x, y] of [[300, 200], [120, 330]]) {
        await report(`example: lit from ${x}, ${y}, its pixels are the reference's`, await compare(lit(shown, x, y), name, x, y));
    }
    const refused = await show(damaged);
    await report('example: a file that is no material is refused in words', /not an OpenEXR file/.test(refused.said) ? '' : refused.said);
}

run().then(() => post('/done', ''), (error) => post('/done', `${error.message}\n${error.stack}`));
