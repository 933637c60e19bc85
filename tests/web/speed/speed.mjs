/* Times of the viewer and of decoding a square of 512 x 512 pixels, in browsers that draw by software here; timing passes and fails
 * nothing, so that this is no test:
 *
 *     speed.mjs PACKAGE VIEWER MATERIAL [ENGINE...]
 *
 * PACKAGE: the folder of the npm package. VIEWER: viewer.html. MATERIAL: the .btf.exr of the square. ENGINE: of the list below; default
 * all. Prints what it saw and how busy the machine was, then rows of a table.
 *
 * SPDX-License-Identifier: MIT
 */
import { execFileSync } from 'node:child_process';
import { cpus, loadavg } from 'node:os';
import { basename, dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { CHROMIUM, WEBGPU, needPrograms, runPage } from '../browser.mjs';

/* By name: browser, parts of the page, flags of Chromium that take the place of those of browser.mjs. Chromium's WebGPU takes no other
 * device than SwiftShader here: of Mesa's lavapipe it says "No available adapters". */
const MESA = { '--use-angle=swiftshader': '--use-angle=gl-egl', '--enable-unsafe-swiftshader': '--ignore-gpu-blocklist' };
const ENGINES = {
    'chromium-webgl': ['chromium', ['viewer', 'webgl'], {}],
    'chromium-webgl-mesa': ['chromium', ['viewer', 'webgl'], MESA],
    'firefox-webgl': ['firefox', ['viewer', 'webgl'], {}],
    'chromium-webgpu': ['chromium', ['webgpu'], {}],
    'firefox-webgpu': ['firefox', ['webgpu'], {}],
};

const [packageFolder, viewer, material, ...asked] = process.argv.slice(2);
const unknown = asked.filter((name) => !(name in ENGINES));
if (!material || unknown.length) {
    console.error(`speed.mjs PACKAGE VIEWER MATERIAL [ENGINE...]: of ${Object.keys(ENGINES).join(', ')}${unknown.length ? `; not ${unknown.join(', ')}` : ''}`);
    process.exit(1);
}
const here = dirname(fileURLToPath(import.meta.url));
const folders = { '/page/': join(here, '../page'), '/speed/': join(here, 'page'), '/package/': packageFolder, '/example/': dirname(resolve(viewer)),
    '/material/': dirname(resolve(material)) };
const given = [CHROMIUM.slice(), WEBGPU.chromium.slice()];
const load = () => loadavg()[0].toFixed(1);
const number = (value) => (value === undefined ? '' : value.toPrecision(2).replace(/^(\d)\.?(\d)?e\+(\d)$/, (_, x, y = '0', zeros) => `${x}${y}${'0'.repeat(zeros - 1)}`));
const seconds = (ms, cores) => (ms === undefined ? '' : `${number(ms / 1000)}${cores === undefined ? '' : ` (${number(cores)})`}`);

const versions = { chromium: ['chromium', ['--version']], firefox: ['firefox-esr', ['--version']] };
for (const [browser, [program, args]] of Object.entries(versions)) {
    needPrograms(browser);
    console.log(execFileSync(program, args, { encoding: 'utf8', stdio: ['ignore', 'pipe', 'ignore'] }).trim());
}
console.log(`${cpus()[0].model}, ${cpus().length} cores`);

const rows = [];
for (const name of asked.length ? asked : Object.keys(ENGINES)) {
    const [browser, parts, flags] = ENGINES[name];
    [CHROMIUM, WEBGPU.chromium].forEach((list, i) => list.splice(0, list.length, ...given[i].map((flag) => flags[flag] ?? flag)));
    const values = {}, before = load();
    const wrong = await runPage(browser, '/speed/index.html', folders, { '/value': ({ name: of, value }) => { values[of] = value; } }, { parts, material: basename(material) });
    const busy = `${before} to ${load()}`;
    console.log(`${name}, load ${busy}: ${JSON.stringify(values)}${wrong ? `\n${name} failed: ${wrong}` : ''}`);
    const square = values.webgl ?? values.webgpu ?? {};
    const { viewer: shown } = values;
    rows.push([name, square.name ?? '', seconds(shown?.first, shown?.cores), seconds(shown?.picture), seconds(square['exact first'], square['exact first cores']),
        ...['exact', 'fast'].map((math) => seconds(square[`${math} picture`], square[`${math} picture cores`])), busy]);
}
console.log('\nSeconds, in brackets core seconds of the browser:');
console.log(`| engine | device | viewer: first picture | a picture | square: first picture | a picture, exact | fast | load |\n|${' --- |'.repeat(8)}`);
rows.forEach((row) => console.log(`| ${row.join(' | ')} |`));
