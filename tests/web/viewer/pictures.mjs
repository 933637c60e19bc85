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
for (const [name, path, fragment] of [['web-viewer', viewer, '#compare=bare'], ['web-gallery', gallery, '']]) {
    const page = await browser.open(pathToFileURL(path).href + fragment, { width: 1000, height: 600, scale: 1 });
    await page.until(`document.documentElement.dataset.exact && document.documentElement.dataset.samples >= ${name === 'web-viewer' ? 2 : 1}`);
    await page.evaluate(name === 'web-viewer' ? "document.getElementById('h-effects').scrollIntoView(), document.getElementById('said').textContent = ''" : '0');
    await page.picture(join(out, `${name}.png`));
    await page.close();
}
await browser.close();
