/* Measures this browser: the viewer in a frame, and a square of 512 x 512 decoded pixels, by WebGL2 and by WebGPU. Core
 * seconds are those of all of the browser's processes; they depend little on other load of the machine.
 *
 * SPDX-License-Identifier: MIT
 */
import { load, open } from '/package/index.js';
import { bytes, json, post } from '/page/post.js';
import { webgl } from './webgl.js';
import { webgpu } from './webgpu.js';

const SIDE = 512;
/* Pictures are timed one by one, until MOST have been drawn or ENOUGH_MS have passed. */
const MOST = 15, ENOUGH_MS = 20000;

const tell = (name, value) => post('/value', { name, value });

const coreSeconds = () => json('/core-seconds');

/** Times pictures: returns the median time, the mean core seconds, and the number of pictures. */
async function timePictures(draw) {
    const before = await coreSeconds(), times = [], begun = performance.now();
    while (times.length < MOST && (times.length < 3 || performance.now() - begun < ENOUGH_MS)) {
        const angle = times.length / 3, start = performance.now();
        await draw([0.5 * Math.cos(angle), 0.5 * Math.sin(angle), Math.sqrt(0.75)]);
        times.push(performance.now() - start);
    }
    return { ms: times.sort((a, b) => a - b)[times.length >> 1], cores: (await coreSeconds() - before) / times.length, of: times.length };
}

/* Times an API: first from the file's bytes to a finished picture, then picture by picture. */
async function timeSquare(api, data) {
    const times = {};
    for (const math of ['exact', 'fast']) {
        let last = performance.now();
        const begun = last;
        const step = (name) => {
            const now = performance.now();
            times[`${math} ${name}`] = now - last;
            last = now;
        };
        const before = await coreSeconds();
        const material = await open(data);
        step('open');
        const { draw, name, destroy } = await api(material, math, SIDE, step);
        await draw([0, 0, 1]);
        step('first draw');
        times[`${math} first`] = last - begun;
        times[`${math} first cores`] = await coreSeconds() - before;
        const { ms, cores, of } = await timePictures(draw);
        Object.assign(times, { [`${math} picture`]: ms, [`${math} picture cores`]: cores, [`${math} of`]: of, name });
        destroy();
        material.close();
    }
    return times;
}

async function timeViewer() {
    const before = await coreSeconds();
    const frame = Object.assign(document.createElement('iframe'), { width: 900, height: 560, src: '/example/viewer.html' });
    document.body.append(frame);
    await new Promise((resolve) => { frame.onload = resolve; });
    const page = frame.contentDocument, { dataset } = page.documentElement;
    const until = async (condition) => {
        while (!condition()) {
            await new Promise((resolve) => { setTimeout(resolve, 20); });
        }
    };
    await until(() => dataset.first || dataset.failed);
    if (dataset.failed) {
        throw new Error(`the viewer: ${dataset.failed}`);
    }
    const cores = await coreSeconds() - before;
    await until(() => dataset.exact);
    page.getElementById('measure').click();
    await until(() => dataset.measured);
    const times = { first: Number(dataset.first), cores, picture: Number(dataset.measured) };
    frame.remove();
    return times;
}

async function run() {
    const { parts, material } = await json('/job');
    await tell('agent', navigator.userAgent);
    await load('/package/openbtf.wasm');
    const data = await bytes(`/material/${material}`);
    for (const [name, time] of [['viewer', timeViewer], ['webgl', () => timeSquare(webgl, data)], ['webgpu', () => timeSquare(webgpu, data)]]) {
        if (parts.includes(name)) {
            await tell(name, await time());
        }
    }
}

run().then(() => post('/done', ''), (error) => post('/done', `${error.message}\n${error.stack}`));
