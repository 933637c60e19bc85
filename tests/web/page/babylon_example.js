/* Runs decoder/web/examples/babylon.html in a frame and compares pixels with the reference decoder. Babylon's picking
 * finds the point that a pixel shows; its tangent frame is computed from the positions and uv of the triangle.
 *
 * SPDX-License-Identifier: MIT
 */
import { open } from '/package/index.js';
import { closeFrame, openFrame, pixelsOf, statusOf } from './frame.js';
import { bytes, note, picture, report } from './post.js';

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const unit = (a) => a.map((x) => x / Math.hypot(...a));
const minus = (a, b) => a.map((x, i) => x - b[i]);
const list = ({ x, y, z }) => [x, y, z];

/** Returns [uv, light, view] of a hit, the directions in its tangent frame. */
function argumentsOf(pick, mesh, lamp, eye) {
    const indices = mesh.getIndices().slice(3 * pick.faceId, 3 * pick.faceId + 3);
    const positions = mesh.getVerticesData('position'), uvs = mesh.getVerticesData('uv');
    const [p, q, r] = Array.from(indices, (i) => Array.from(positions.slice(3 * i, 3 * i + 3)));
    const [a, b, c] = Array.from(indices, (i) => Array.from(uvs.slice(2 * i, 2 * i + 2)));
    const [e, f, g, h] = [minus(q, p), minus(r, p), minus(b, a), minus(c, a)];
    const n = unit(list(pick.getNormal(false, true)));
    const turned = Math.sign(g[0] * h[1] - h[0] * g[1]);
    const along = e.map((x, i) => turned * (x * h[1] - f[i] * g[1])), across = e.map((x, i) => turned * (f[i] * g[0] - x * h[0]));
    const t = unit(minus(along, n.map((x) => x * dot(n, along))));
    const cross = [n[1] * t[2] - n[2] * t[1], n[2] * t[0] - n[0] * t[2], n[0] * t[1] - n[1] * t[0]];
    const s = cross.map((x) => x * Math.sign(dot(cross, across)));
    const local = (v) => [dot(v, t), dot(v, s), dot(v, n)];
    const at = pick.getTextureCoordinates();
    return [[6 * at.x, 3 * at.y], local(unit(lamp)), local(unit(minus(eye, list(pick.pickedPoint))))];
}

/** The picture that the example draws in its next frame. */
function nextPicture(scene, canvas) {
    return new Promise((resolve) => { scene.onAfterRenderObservable.addOnce(() => resolve(pixelsOf(canvas))); });
}

export async function run({ material: name, damaged }) {
    const frame = await openFrame(`/example/babylon.html?${name}`);
    const said = await statusOf(frame);
    await report('babylon example: a material is shown', /^\d+ x \d+ texels, \d+ bytes$/.test(said) ? '' : said);
    const canvas = frame.contentDocument.getElementById('canvas');
    const scene = frame.contentWindow.BABYLON.EngineStore.LastCreatedScene;
    const pixels = await nextPicture(scene, canvas);
    await picture('babylon example', pixels, canvas.width);
    const material = await open(await bytes(`/golden/${name}`));
    const [sphere] = scene.meshes, side = canvas.width;
    let compared = 0, near = 0, lit = 0, mirrored = 0;
    for (let y = 16; y < side; y += 24) {
        for (let x = 16; x < side; x += 24) {
            const pick = scene.pick(x + 0.5, y + 0.5);
            if (pick.hit) {
                const [uv, light, view] = argumentsOf(pick, sphere, [0.5, 0.6, -0.8], list(scene.activeCamera.position));
                const isNear = (l) => Array.from(material.evaluate(uv, l, view, { reference: true }), (value) => 255 * Math.min(value, 1) ** (1 / 2.2))
                    .every((value, c) => Math.abs(value - pixels[4 * (y * side + x) + c]) <= 8);
                compared += 1;
                lit += pixels[4 * (y * side + x)] > 5 ? 1 : 0;
                near += isNear(light) ? 1 : 0;
                mirrored += isNear([-light[0], light[1], light[2]]) ? 1 : 0;
            }
        }
    }
    material.close();
    const text = `${near} of ${compared} pixels, ${lit} of them lit; ${mirrored} with the frame mirrored`;
    await note(`babylon example: the reference's within 8 of 255: ${text}`);
    // neighbouring texels differ by more than that, and a pixel between two may show either
    await report("babylon example: eight of ten pixels are the reference's within 8 of 255", near >= 0.8 * compared && lit > 50 ? '' : text);
    await report('babylon example: control: a frame that is mirrored is noticed', mirrored < 0.6 * compared ? '' : text);
    closeFrame(frame);
    const refused = await openFrame(`/example/babylon.html?${damaged}`);
    const message = await statusOf(refused);
    await report('babylon example: a file that is no material is refused in words', /not an OpenEXR file/.test(message) ? '' : message);
    closeFrame(refused);
}
