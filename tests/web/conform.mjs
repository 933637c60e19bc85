/* Conformance in a browser, then the example in plain WebGL2: conform.mjs chromium|firefox PACKAGE VECTORS GOLDEN.
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
    // Chromium's SwiftShader keeps the order of operations even where it need not
    noticesZero: browser === 'firefox',
};
const folders = { '/page/': join(here, 'page'), '/package/': packageFolder, '/vectors/': vectors, '/golden/': golden };
const posts = { '/case': ({ name, wrong }) => report(name, wrong), '/note': (line) => console.log(line) };
report('conformance came to its end', await runPage(browser, '/page/index.html', folders, posts, job));

const examples = join(here, '../../decoder/web/examples');
const exampleFolders = { '/page/': join(here, 'page'), '/package/': packageFolder, '/example/openbtf/': packageFolder,
    '/example/': [examples, golden] };
report('the example came to its end', await runPage(browser, '/page/example.html', exampleFolders, posts,
    { material: 'v1-tight.btf.exr', damaged: 'expected.txt' }));
process.exit(exitCode());
