/* The viewer in a browser without a WebDriver: a page shows the viewer in a frame and uses it by events:
 * test_engine.mjs BROWSER VIEWER GOLDEN.
 *
 * GOLDEN: tests/data/golden.
 *
 * SPDX-License-Identifier: MIT
 */
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { needPrograms, runPage } from '../browser.mjs';
import { exitCode, report } from '../harness.mjs';

const [browser, viewer, golden] = process.argv.slice(2);
needPrograms(browser);
const here = dirname(fileURLToPath(import.meta.url));
// served under /example/, because the viewer has an inline script, which the policy allows only there
const folders = { '/page/': join(here, 'page'), '/example/': dirname(resolve(viewer)), '/golden/': golden };
const posts = { '/case': ({ name, wrong }) => report(name, wrong), '/note': (line) => console.log(line) };
report(`${browser}: the page came to its end`, await runPage(browser, '/page/index.html', folders, posts, { golden: 'v2-all.btf.exr' }));
process.exit(exitCode());
