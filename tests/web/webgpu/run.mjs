/* Conformance in WebGPU, then the example in plain WebGPU: run.mjs chromium|firefox PACKAGE VECTORS GOLDEN TEXTS [--long].
 *
 * PACKAGE: the folder of the npm package. VECTORS: what vectors.py wrote. GOLDEN: tests/data/golden. TEXTS: what test_wgsl --write wrote, or
 * - for none. --long: every vector, and at least 500,000 values a material and variant.
 *
 * SPDX-License-Identifier: MIT
 */
import { readdirSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { WEBGPU, needPrograms, needWebGPU, runPage } from '../browser.mjs';
import { exitCode, report } from '../harness.mjs';

const [browser, packageFolder, vectors, golden, texts, long] = process.argv.slice(2);
needPrograms(browser);
needWebGPU(browser);
const here = dirname(fileURLToPath(import.meta.url));
const job = {
    golden: readdirSync(golden).filter((name) => name.endsWith('.btf.exr')).sort(),
    // Chromium's SwiftShader does not use the freedom to reorder, so a missing run-time zero changes nothing there
    noticesZero: browser === 'firefox',
    texts: texts !== '-',
    long: long === '--long',
    material: 'v1-tight.btf.exr',
    damaged: 'expected.txt',
};
const folders = { '/page/': join(here, '../page'), '/webgpu/': join(here, 'page'), '/package/': packageFolder, '/vectors/': vectors, '/golden/': golden,
    '/texts/': texts, '/example/openbtf/': packageFolder, '/example/': [join(here, '../../../decoder/web/examples'), golden] };
const start = Date.now();
const posts = {
    '/case': ({ name, wrong }) => report(name, wrong),
    '/note': (line) => console.log(`[${((Date.now() - start) / 1000).toFixed(0)} s] ${line}`),
};
report(`the page in ${browser} comes to its end`, await runPage(browser, '/webgpu/index.html', folders, posts, job));
WEBGPU.chromium.push(...WEBGPU.chromiumCanvas);
report(`the example in ${browser} comes to its end`, await runPage(browser, '/webgpu/example.html', folders, posts, job));
process.exit(exitCode());
