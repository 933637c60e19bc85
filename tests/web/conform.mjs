/* Conformance in a browser: conform.mjs chromium|firefox PACKAGE VECTORS GOLDEN.
 *
 * PACKAGE: the folder of the npm package. VECTORS: what vectors.py wrote. GOLDEN: tests/data/golden.
 *
 * SPDX-License-Identifier: MIT
 */
import { readdirSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { needPrograms, runPage } from './browser.mjs';
import { exitCode, report } from './harness.mjs';

const [browser, packageFolder, vectors, golden] = process.argv.slice(2);
needPrograms(browser);
const here = dirname(fileURLToPath(import.meta.url));
const job = {
    golden: readdirSync(golden).filter((name) => name.endsWith('.btf.exr')).sort(),
    planes: ['radiance', 'picked'],
    // Chromium's SwiftShader keeps the order of operations even where it need not
    noticesZero: browser === 'firefox',
};
const folders = { '/page/': join(here, 'page'), '/package/': packageFolder, '/vectors/': vectors, '/golden/': golden };
const posts = { '/case': ({ name, wrong }) => report(name, wrong), '/note': (line) => console.log(line) };
const wrong = await runPage(browser, '/page/index.html', folders, posts, job);
report('the page came to its end', wrong);
process.exit(exitCode());
