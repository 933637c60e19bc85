/* Pictures of the viewer and the gallery for the documents: pictures.mjs VIEWER GALLERY OUT. Writes OUT/web-viewer.png and
 * OUT/web-gallery.png, by Chromium.
 *
 * SPDX-License-Identifier: MIT
 */
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { needPrograms } from '../browser.mjs';
import { Browser } from './cdp.mjs';

const [viewer, gallery, out] = process.argv.slice(2).map((path) => resolve(path));
needPrograms('chromium');
const browser = new Browser();
const open = (path, fragment) => browser.open(pathToFileURL(path).href + fragment, { width: 920, height: 560, scale: 1 });

const cards = await open(gallery, '');
await cards.until("!document.getElementById('gallery').hidden");
await cards.picture(join(out, 'web-gallery.png'));
await cards.close();

const page = await open(viewer, '#compare=shift&split=0.46&zoom=0.85');
await page.until('document.documentElement.dataset.exact && document.documentElement.dataset.samples >= 1');
// hide the frame rate, which is that of a software device
await page.evaluate("document.getElementById('rate').hidden = true, document.getElementById('hint').classList.add('gone'), document.getElementById('h-effects').scrollIntoView()");
await page.until("getComputedStyle(document.getElementById('hint')).opacity === '0'");
await page.picture(join(out, 'web-viewer.png'));
await page.close();
await browser.close();
