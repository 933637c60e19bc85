/* Runs decoder/web/examples/webgl.html in a frame, moves the pointer over it, and compares pixels with the reference
 * decoder.
 *
 * SPDX-License-Identifier: MIT
 */
import { open } from '/package/index.js';
import { closeFrame, openFrame, pixelsOf, statusOf } from './frame.js';
import { bytes, report } from './post.js';

const SIDE = 512;

/** Opens the example with a material, and waits until it no longer says that it loads. */
async function example(name) {
    const frame = await openFrame(`/example/webgl.html?${name}`);
    return { frame, said: await statusOf(frame), canvas: frame.contentDocument.getElementById('canvas') };
}

/** The picture with the pointer at a pixel. */
function lit({ frame, canvas }, x, y) {
    const rectangle = canvas.getBoundingClientRect();
    canvas.dispatchEvent(new frame.contentWindow.PointerEvent('pointermove', { clientX: rectangle.left + x, clientY: rectangle.top + y, bubbles: true }));
    return pixelsOf(canvas);
}

/** The greatest difference from the reference, of 255, over some pixels, under the light over a pixel. */
async function difference(pixels, name, x, y) {
    const material = await open(await bytes(`/example/${name}`));
    const light = [x / 256 - 1, 1 - y / 256, 0];
    light[2] = Math.sqrt(1 - light[0] ** 2 - light[1] ** 2);
    let most = 0;
    for (let row = 5; row < SIDE; row += 50) {
        for (let column = 3; column < SIDE; column += 50) {
            const uv = [(column + 0.5) / SIDE, 1 - (row + 0.5) / SIDE];
            const rgb = material.evaluate(uv, light, [0, 0, 1], { reference: true });
            for (let c = 0; c < 3; c++) {
                most = Math.max(most, Math.abs(pixels[4 * (row * SIDE + column) + c] - 255 * Math.min(rgb[c], 1) ** (1 / 2.2)));
            }
        }
    }
    material.close();
    return most;
}

export async function run({ material, damaged }) {
    const shown = await example(material);
    await report('example: a material is shown', /^\d+ x \d+ texels, \d+ bytes$/.test(shown.said) ? '' : shown.said);
    for (const [x, y] of [[300, 200], [120, 330]]) {
        const pixels = lit(shown, x, y);
        const most = await difference(pixels, material, x, y);
        const colours = new Set(new Uint32Array(pixels.buffer)).size;
        await report(`example: lit from ${x}, ${y}, its pixels are the reference's`, most <= 1 && colours > 10 ? '' : `${most} of 255 apart, ${colours} colours`);
    }
    closeFrame(shown.frame);
    const refused = await example(damaged);
    await report('example: a file that is no material is refused in words', /not an OpenEXR file/.test(refused.said) ? '' : refused.said);
    closeFrame(refused.frame);
}
