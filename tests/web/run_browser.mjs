/* Runs the tests in a browser, in one page: conformance, openbtf/webgl, openbtf/three against btf-render, the examples.
 *
 *     run_browser.mjs chromium|firefox PACKAGE VECTORS GOLDEN NODE_MODULES BTF_RENDER SCRATCH [PART...]
 *
 * PACKAGE: the folder of the npm package. VECTORS: what vectors.py wrote. GOLDEN: tests/data/golden. NODE_MODULES: what npm.sh fetched.
 * SCRATCH: a folder for pictures of btf-render. PART: only these, of the files of page/; default all but those of WebGPU, those of
 * engines in Chromium alone. BTF_PICTURES in the environment: a folder, which gets the pictures that the tests of three.js and of the
 * examples look at.
 *
 * SPDX-License-Identifier: MIT
 */
import { readdirSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { WEBGPU, needPrograms, needWebGPU, runPage } from './browser.mjs';
import { exitCode, report } from './harness.mjs';
import { SCENES, SIDE, drawScenes, fileOf } from './scenes.mjs';

const [browser, packageFolder, vectors, golden, modules, btfRender, scratch, ...parts] = process.argv.slice(2);
needPrograms(browser);
const here = dirname(fileURLToPath(import.meta.url));
const MATERIAL = 'v1-tight.btf.exr';
// engines draw alike in all browsers, so they are tested in one
const ENGINES = browser === 'chromium' ? ['three', 'three_example', 'babylon_example'] : [];
const job = {
    parts: parts.length ? parts : ['conform', 'state', 'webgl_example', ...ENGINES, 'requests'],
    golden: readdirSync(golden).filter((name) => name.endsWith('.btf.exr')).sort(),
    // Chromium's SwiftShader does not use the freedom to reorder, so a missing run-time zero changes nothing there
    noticesZero: browser === 'firefox',
    material: MATERIAL,
    other: 'v1-components.btf.exr',
    damaged: 'expected.txt',
    scenes: SCENES.map((scene) => ({ ...scene, picture: fileOf(scene) })),
    side: SIDE,
};
if (job.parts.some((part) => part.startsWith('three_webgpu'))) {
    needWebGPU(browser);
    WEBGPU.chromium.push(...WEBGPU.chromiumCanvas);
}
if (job.parts.includes('three') || job.parts.includes('three_webgpu')) {
    drawScenes(btfRender, join(golden, MATERIAL), scratch);
}
const folders = {
    '/page/': join(here, 'page'), '/package/': packageFolder, '/vectors/': vectors, '/golden/': golden, '/scenes/': scratch,
    '/three/': join(modules, 'three/build'),
    // examples find the packages beside them
    '/example/': [join(here, '../../decoder/web/examples'), golden, join(modules, 'babylonjs')], '/example/openbtf/': packageFolder,
    '/example/three/': join(modules, 'three/build'), '/example/three/addons/': join(modules, 'three/examples/jsm'),
};
const start = Date.now();
const say = (line) => console.log(`[${((Date.now() - start) / 1000).toFixed(0)} s] ${line}`);
const posts = {
    '/case': ({ name, wrong }) => report(name, wrong),
    '/note': say,
    '/picture': ({ name, url }) => {
        if (process.env.BTF_PICTURES) {
            writeFileSync(join(process.env.BTF_PICTURES, `${browser}-${name.replaceAll(/[ ,]+/g, '-')}.png`), Buffer.from(url.split(',')[1], 'base64'));
        }
    },
};
// the control, a line that main.js prints; then, of Chromium alone, since Firefox prints what scripts report as errors and no more: the
// request that requests.js sees refused, what three says of the context that it loses, and Babylon of its version
const EXPECTED = browser === 'chromium'
    ? { requests: [/openbtf\.invalid/], three: [/Context Lost/, /Context Restored/], babylon_example: [/Babylon\.js v/] } : {};
const expected = [/control: a line of the console/, ...job.parts.flatMap((part) => EXPECTED[part] ?? [])];
report(`the page in ${browser} comes to its end, without an error in the console`,
    await runPage(browser, '/page/index.html', folders, posts, job, expected));
process.exit(exitCode());
