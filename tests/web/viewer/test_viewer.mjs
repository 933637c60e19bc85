/* The viewer and the gallery in Chromium, from file://, by real input events: test_viewer.mjs VIEWER GALLERY GOLDEN PICTURES
 * [PATTERN].
 *
 * VIEWER, GALLERY: the pages. GOLDEN: tests/data/golden. PICTURES: a folder for pictures of each feature, for people to
 * look at. PATTERN: a regular expression; only cases whose names match run.
 *
 * SPDX-License-Identifier: MIT
 */
import assert from 'node:assert/strict';
import { existsSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, truncateSync, writeFileSync, copyFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { needPrograms } from '../browser.mjs';
import { exitCode, test as run } from '../harness.mjs';
import { Browser } from './cdp.mjs';

const [viewer, gallery, golden, pictures] = process.argv.slice(2, 6).map((path) => resolve(path));
const pattern = new RegExp(process.argv[6] ?? '');
const SHIFT = 8;
needPrograms('chromium');
mkdirSync(pictures, { recursive: true });
const work = mkdtempSync(join(tmpdir(), 'openbtf-viewer-files-'));
const browser = new Browser();
const test = async (name, body) => (pattern.test(name) ? run(name, body) : undefined);
const url = (path, hash = '') => pathToFileURL(path).href + hash;

const at = (name) => `document.documentElement.dataset.${name}`;
const textOf = (page, selector) => page.evaluate(`document.querySelector(${JSON.stringify(selector)}).textContent`);
const said = (page) => page.evaluate(at('said'));
const picture = (page, name) => page.picture(join(pictures, `${name}.png`));

/** The state in the link, once it differs from `before` and has a member. It is written a moment after a change. */
async function link(page, before, member = '') {
    await page.until(`location.hash !== ${JSON.stringify(before)} && location.hash.includes(${JSON.stringify(member)})`);
    return page.evaluate("Object.fromEntries(location.hash.slice(1).split('&').map((part) => part.split('=')))");
}
const hash = (page) => page.evaluate('location.hash');

/** The picture alone, without the controls over it. */
async function drawn(page) {
    const box = await page.box('#canvas');
    return page.picture(null, { x: box.left + 0.2 * box.width, y: box.top + 0.2 * box.height, width: 0.6 * box.width, height: 0.55 * box.height });
}

/** Compares two pictures of one size: the mean difference of their values, of 255, and the number of the first one's
 * colours. */
function compared(page, a, b) {
    return page.evaluate(`(async () => {
        const values = async (data) => {
            const image = new Image();
            image.src = 'data:image/png;base64,' + data;
            await image.decode();
            const canvas = document.createElement('canvas');
            canvas.width = image.width;
            canvas.height = image.height;
            const to = canvas.getContext('2d');
            to.drawImage(image, 0, 0);
            return to.getImageData(0, 0, canvas.width, canvas.height).data;
        };
        const [a, b] = [await values('${a}'), await values('${b}')];
        let sum = 0;
        for (let i = 0; i < a.length; i++) { sum += Math.abs(a[i] - b[i]); }
        return { difference: sum / a.length, colours: new Set(new Uint32Array(a.buffer)).size };
    })()`);
}

/** Asserts that `body` changes the picture by at least `least`. */
async function changes(page, what, least, body) {
    await page.settled();
    const before = await drawn(page);
    await body();
    await page.settled();
    const { difference } = await compared(page, before, await drawn(page));
    assert.ok(difference > least, `${what} changes the picture by ${difference.toFixed(3)} of 255, less than ${least}`);
}

/** A page whose picture has been drawn. */
async function open(path, fragment = '', options = {}) {
    const page = await browser.open(url(path, fragment), options);
    await page.until(`${at('first')} || ${at('failed')}`);
    return page;
}

/** A small environment map with light from above, its rows run-length coded as most writers do. */
function hdrFile() {
    const [width, height] = [32, 16], rows = [];
    for (let y = 0; y < height; y++) {
        rows.push(2, 2, 0, width);
        const bright = y < height / 2 ? [200, 120, 60, 130] : [10, 20, 40, 126];
        bright.forEach((value) => rows.push(128 + width, value));
    }
    const path = join(work, 'evening.hdr');
    writeFileSync(path, Buffer.concat([Buffer.from(`#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y ${height} +X ${width}\n`, 'latin1'), Buffer.from(rows)]));
    return path;
}

const page = await open(viewer);

await test('viewer: a material is shown from file://, with nothing in the console', async () => {
    await page.settled();
    const data = await drawn(page);
    const { colours } = await compared(page, data, data);
    assert.ok(colours > 500, `${colours} colours`);
    await picture(page, '01-start');
    console.log(`first picture ${await page.evaluate(at('first'))} ms after the page was asked for, on this machine`);
    assert.deepEqual(page.errors, []);
});

await test('viewer: the self-test\'s verdict, and 0 bits differ from the reference decoder in the page', async () => {
    await page.until(at('exact'));
    assert.equal(await page.evaluate(at('exact')), 'true');
    assert.match(await textOf(page, '#verdict'), /^Exact: /);
    await page.click('#check-button');
    await page.until(at('different'));
    assert.match(await textOf(page, '#check'), /^12,288 values compared .* 0 bits differ\.$/);
});

await test('viewer: the pointer turns the model, with Shift or the right button the light, the wheel zooms', async () => {
    const { x, y } = await page.box('#canvas');
    await changes(page, 'a drag', 1, () => page.drag(x, y, 90, 30));
    let state = await link(page, '', 'phi=');
    assert.ok('theta' in state, JSON.stringify(state));
    assert.ok(!('lightPhi' in state));
    let before = await hash(page);
    await changes(page, 'a drag with Shift', 0.5, () => page.drag(x, y, 60, 40, { modifiers: SHIFT }));
    state = await link(page, before, 'lightPhi=');
    assert.ok('lightTheta' in state && 'lightPhi' in state, JSON.stringify(state));
    const turned = state.theta, lit = state.lightPhi;
    await page.drag(x, y, -50, 20, { button: 'right' });
    await page.until(`location.hash.includes('lightPhi=') && !location.hash.includes('lightPhi=${lit}')`);
    state = await link(page, '');
    assert.equal(state.theta, turned, 'the right button leaves the model');
    before = await hash(page);
    await page.send('Input.dispatchMouseEvent', { type: 'mouseWheel', x, y, deltaX: 0, deltaY: -120 });
    state = await link(page, before, 'zoom=');
    assert.ok(Number(state.zoom) > 0.95, JSON.stringify(state));
});

await test('viewer: keys turn, light, zoom, expose and choose', async () => {
    await page.click('#reset');
    await page.evaluate("document.getElementById('canvas').focus()");
    for (const [key, modifiers, member] of [['ArrowLeft', 0, 'phi'], ['ArrowUp', SHIFT, 'lightTheta'], ['+', 0, 'zoom'], ['.', 0, 'exposure'],
        ['m', 0, 'mesh'], ['n', 0, 'interpolation'], ['b', 0, 'filter'], ['s', 0, 'compare']]) {
        const before = await hash(page);
        await page.key(key, modifiers);
        await link(page, before, `${member}=`);
    }
    await page.key('r');
    await page.until("location.hash === ''");
});

await test('viewer: the ball moves the light', async () => {
    const { x, y } = await page.box('#ball');
    await changes(page, 'the ball', 0.5, () => page.drag(x, y, 20, 14));
    assert.ok('lightTheta' in await link(page, ''));
    await page.click('#reset');
});

for (const [index, mesh] of ['plane', 'sphere', 'cylinder', 'torus'].entries()) {
    await test(`viewer: the model ${mesh}`, async () => {
        await changes(page, mesh, 1, () => page.click(`#mesh label:nth-child(${index + 1})`));
        assert.equal((await link(page, '', 'mesh=')).mesh, mesh);
        await picture(page, `02-${mesh}`);
    });
}
await page.click('#reset');

await test('viewer: effects are switched, and say what they cost', async () => {
    const rows = await page.evaluate("[...document.querySelectorAll('#effects tbody tr')].map((row) => [...row.cells].map((cell) => cell.textContent))");
    assert.ok(rows.length >= 2, JSON.stringify(rows));
    for (const [effect, db, bytes] of rows) {
        assert.match(db, /^([+−]\d+\.\d|all|–)$/, effect);
        assert.match(bytes, /^\d+(\.\d)? (B|kB|MB)$/, effect);
    }
    assert.ok(rows.some(([, db]) => /\d/.test(db)));
    assert.match(await textOf(page, '#db-note'), /between the samples|at the samples/);
    for (const [effect] of rows.filter(([, db]) => db !== 'all')) {
        const id = `#effect-${effect.toLowerCase()}`;
        const bytes = await textOf(page, '#effects tfoot td:nth-child(3)');
        await changes(page, effect, 0.02, () => page.click(id));
        assert.equal((await link(page, '', 'out=')).out, effect.toLowerCase());
        await page.click(id);
        await page.until("location.hash === ''");
        assert.equal(await textOf(page, '#effects tfoot td:nth-child(3)'), bytes);
    }
});

await test('viewer: time is measured on this device', async () => {
    await page.click('#measure');
    await page.until(at('measured'));
    assert.ok(Number(await page.evaluate(at('measured'))) > 0);
    const times = await page.evaluate("[...document.querySelectorAll('#effects td:nth-child(4)')].map((cell) => cell.textContent)");
    assert.ok(times.filter((time) => /^[+−]?\d+\.\d ms$/.test(time)).length >= 2, times.join(', '));
    console.log(`512 x 512 pixels: ${await page.evaluate(at('measured'))} ms, on this machine`);
    await page.settled();
    await page.evaluate("document.getElementById('h-effects').scrollIntoView()");
    await picture(page, '03-effects');
});

await test('viewer: a split picture, whose line pointer and keys move', async () => {
    await changes(page, 'the split', 0.1, () => page.set('compare', 'bare'));
    let { x, y } = await page.box('#split-line');
    await page.drag(x, y, 80, 0);
    assert.ok(Number((await link(page, '', 'split=')).split) > 0.55);
    await page.evaluate("document.getElementById('split-line').focus()");
    const before = await hash(page);
    await page.key('ArrowLeft');
    await link(page, before);
    await page.settled();
    await picture(page, '04-split');
    ({ x, y } = await page.box('#canvas'));
    await page.click('#reset');
    assert.equal(await page.evaluate("document.getElementById('split-line').hidden"), true);
});

await test('viewer: exposure, directions, texels, neighbours and levels', async () => {
    await changes(page, 'exposure', 3, () => page.set('exposure', 1.5));
    await page.click('#reset');
    for (const [id, value] of [['interpolation', 'nearest'], ['filter', 'texel'], ['filter', 'steep'], ['picks', 'all'], ['level', '2']]) {
        await changes(page, `${id} ${value}`, 0.01, () => page.set(id, value));
        await picture(page, `05-${id}-${value}`);
        await page.click('#reset');
    }
});

await test('viewer: environments, also of a file that is dropped', async () => {
    for (const name of ['studio', 'sky']) {
        await changes(page, name, 1, () => page.set('environment', name));
        await picture(page, `06-${name}`);
    }
    await changes(page, 'a file', 1, async () => {
        await page.drop(hdrFile());
        await page.until("document.getElementById('environment').value === 'own'");
    });
    assert.match(await textOf(page, '#environment option[value=own]'), /^evening\.hdr$/);
    await picture(page, '06-own');
    writeFileSync(join(work, 'short.hdr'), '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16 +X 32\nxx');
    await page.drop(join(work, 'short.hdr'));
    await page.until("!document.getElementById('message').hidden");
    assert.match(await textOf(page, '#message-text'), /^short\.hdr: the file ends before its last pixel/);
    await page.click('#message-close');
    await page.click('#reset');
});

const good = readdirSync(golden).filter((name) => /^v2.*\.btf\.exr$/.test(name)).sort();

/** Drops a file that must be refused, in words that match, while the former material stays. */
async function refused(path, pattern) {
    const before = await page.evaluate(at('material'));
    await page.drop(path);
    await page.until("!document.getElementById('message').hidden");
    const message = await textOf(page, '#message-text');
    assert.match(message, pattern);
    assert.ok(message.includes(path.split('/').pop()) && message.endsWith(`${before} stays.`), message);
    assert.equal(await page.evaluate(at('material')), before);
    await picture(page, `07-refused-${path.split('/').pop().split('.')[0]}`);
    await page.click('#message-close');
    await page.settled();
}

await test('viewer: files that are dropped: good, damaged, wrong, 100 MB', async () => {
    const file = join(golden, good[0]), title = good[0].replace('.btf.exr', '');
    await page.drop(file);
    await page.until(`${at('material')} === ${JSON.stringify(title)}`);
    await page.settled();
    await picture(page, '07-dropped');
    const damaged = join(work, 'damaged.btf.exr'), bytes = readFileSync(file);
    writeFileSync(damaged, bytes.subarray(0, Math.floor(bytes.length / 2)));
    await refused(damaged, /^damaged\.btf\.exr: ./);
    const wrong = join(work, 'notes.txt');
    writeFileSync(wrong, 'these are notes, and no material');
    await refused(wrong, /not an OpenEXR file/);
    const large = join(work, 'large.btf.exr');
    writeFileSync(large, '');
    truncateSync(large, 100e6);
    await refused(large, /not an OpenEXR file/);
    // 100 MB after a header: the library gives the message
    const padded = join(work, 'padded.btf.exr');
    copyFileSync(damaged, padded);
    truncateSync(padded, 100e6);
    await refused(padded, /^padded\.btf\.exr: ./);
    const gigantic = join(work, 'gigantic.btf.exr');
    writeFileSync(gigantic, '');
    truncateSync(gigantic, 2 ** 31);
    await refused(gigantic, /2\.1 GB; this page opens files of at most 1\.1 GB/);
});

await test('viewer: 50 materials take the memory of two', async () => {
    let after;
    for (let i = 0; i < 50; i++) {
        const name = good[i % 2], title = name.replace('.btf.exr', '');
        await page.pick(join(golden, name));
        await page.until(`${at('material')} === ${JSON.stringify(title)}`);
        if (i === 3) {
            await page.settled();
            after = { memory: await page.evaluate(at('memory')), alive: await page.evaluate('window.alive') };
        }
    }
    await page.settled();
    assert.deepEqual({ memory: await page.evaluate(at('memory')), alive: await page.evaluate('window.alive') }, after);
    console.log(`bytes of the module: ${after.memory}; WebGL objects: ${JSON.stringify(after.alive)}`);
});

await test('viewer: a link gives the view again, and says that a file is not in it', async () => {
    await page.click('#copy');
    await page.until(`/not in it/.test(${at('said')})`);
    const other = await open(viewer, '#mesh=torus&theta=40&phi=-100&exposure=0.5&environment=sky&level=99&filter=none&nothing=1');
    await other.settled();
    assert.equal(await other.evaluate("document.querySelector('#mesh input:checked').value"), 'torus');
    assert.equal(await other.evaluate("document.getElementById('environment').value"), 'sky');
    assert.equal(await other.evaluate("document.getElementById('filter').value"), 'bilinear');
    assert.equal(await other.evaluate("document.getElementById('exposure').value"), '0.5');
    await other.click('#copy');
    await other.until(`/ink/.test(${at('said')})`);
    const copied = await other.evaluate("document.getElementById('link').value");
    assert.match(copied, /#mesh=torus&theta=40&phi=-100&/);
    assert.deepEqual(other.errors, []);
    await other.close();
});

await test('viewer: the picture is saved as PNG', async () => {
    await browser.send('Browser.setDownloadBehavior', { behavior: 'allow', downloadPath: work });
    await page.settled();
    await page.click('#save');
    await page.until(`/^Saved/.test(${at('said')})`);
    const file = join(work, (await said(page)).replace('Saved ', ''));
    // the browser renames a download to its name once it is complete
    while (!existsSync(file)) {
        await new Promise((done) => { setTimeout(done, 100); });
    }
    const bytes = readFileSync(file);
    assert.equal(bytes.subarray(1, 4).toString(), 'PNG');
    const { width, height } = await page.box('#canvas');
    assert.deepEqual([bytes.readUInt32BE(16), bytes.readUInt32BE(20)], await page.evaluate(`[${width}, ${height}].map((side) => Math.round(side * devicePixelRatio))`));
    const { colours } = await compared(page, bytes.toString('base64'), bytes.toString('base64'));
    assert.ok(colours > 100, `${colours} colours`);
});

await test('viewer: a lost device is drawn on again, with the environment of a file', async () => {
    await page.drop(hdrFile());
    await page.until("document.getElementById('environment').value === 'own'");
    await page.settled();
    await page.evaluate("window.lost = document.getElementById('canvas').getContext('webgl2').getExtension('WEBGL_lose_context'); window.lost.loseContext()");
    await page.until("!document.getElementById('message').hidden");
    await page.evaluate('window.lost.restoreContext()');
    await page.until("document.getElementById('message').hidden");
    await page.settled();
    const data = await drawn(page);
    assert.ok((await compared(page, data, data)).colours > 100);
    assert.equal(await page.evaluate("document.getElementById('environment').value"), 'own');
    await changes(page, 'the environment, put out', 1, () => page.set('environment', 'none'));
    await page.click('#measure');
    await page.until(`/ ms a picture of /.test(${at('said')}) || !document.getElementById('message').hidden`);
    assert.equal(await page.evaluate("document.getElementById('message').hidden"), true, await textOf(page, '#message-text'));
});

await test('viewer: every control has a name, texts have contrast, Tab goes in order', async () => {
    const { nodes } = await page.send('Accessibility.getFullAXTree');
    const nameless = nodes.filter(({ ignored, role, name, properties = [] }) => !ignored && role?.value !== 'RootWebArea' && !name?.value
        && properties.some((property) => property.name === 'focusable' && property.value.value)).map(({ role }) => role.value);
    assert.deepEqual(nameless, []);
    const pairs = await page.evaluate(`(() => {
        const style = getComputedStyle(document.documentElement);
        const luminance = (name) => {
            const rgb = [1, 3, 5].map((i) => parseInt(style.getPropertyValue(name).trim().slice(i, i + 2), 16) / 255).map((c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4));
            return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
        };
        const contrast = (a, b) => { const [x, y] = [luminance(a), luminance(b)].sort((p, q) => q - p); return (x + 0.05) / (y + 0.05); };
        return [['--text', '--surface', 4.5], ['--quiet', '--surface', 4.5], ['--quiet', '--ground', 4.5], ['--text', '--raised', 4.5], ['--edge', '--surface', 3], ['--accent', '--surface', 3]]
            .map(([a, b, least]) => [a, b, contrast(a, b), least]);
    })()`);
    for (const [a, b, contrast, least] of pairs) {
        assert.ok(contrast >= least, `${a} on ${b}: ${contrast.toFixed(2)}, at least ${least}`);
    }
    await page.evaluate("document.querySelector('h1 a').focus()");
    const order = [];
    for (let i = 0; i < 4; i++) {
        await page.key('Tab');
        order.push(await page.evaluate('document.activeElement.id || document.activeElement.name'));
    }
    assert.deepEqual(order, ['file', 'canvas', 'mesh', 'repeat']);
});

await test('viewer: no request has left the page, and one that would is stopped', async () => {
    assert.deepEqual(page.requests.filter((address) => !/^(file|data|blob):/.test(address)), []);
    const stopped = await page.evaluate(`new Promise((resolve) => {
        document.addEventListener('securitypolicyviolation', (event) => resolve(event.blockedURI), { once: true });
        fetch('http://openbtf.invalid/x').catch(() => {});
    })`);
    assert.match(stopped, /openbtf\.invalid/);
    page.errors = page.errors.filter((text) => !/openbtf\.invalid|CONTEXT_LOST_WEBGL|context (lost|restored)/i.test(text));
    assert.deepEqual(page.errors, []);
});
await page.close();

await test('viewer: a phone, by touch', async () => {
    const phone = await open(viewer, '', { width: 390, height: 844, mobile: true });
    await phone.settled();
    await picture(phone, '08-phone');
    assert.ok(await phone.evaluate('document.scrollingElement.scrollWidth <= 390'), 'nothing is wider than the screen');
    const { x, y } = await phone.box('#canvas');
    await phone.touch('touchStart', [[x, y]]);
    await phone.touch('touchMove', [[x + 50, y + 10]]);
    await phone.touch('touchEnd', []);
    let state = await link(phone, '', 'phi=');
    assert.ok('phi' in state && !('zoom' in state) && !('lightPhi' in state), JSON.stringify(state));
    const before = await hash(phone);
    await phone.touch('touchStart', [[x - 30, y], [x + 30, y]]);
    await phone.touch('touchMove', [[x - 60, y + 20], [x + 60, y + 20]]);
    await phone.touch('touchEnd', []);
    state = await link(phone, before, 'zoom=');
    assert.ok(Number(state.zoom) > 1.2 && 'lightPhi' in state, JSON.stringify(state));
    await phone.evaluate("document.getElementById('h-light').scrollIntoView()");
    await phone.settled();
    await picture(phone, '08-phone-panel');
    assert.deepEqual(phone.errors, []);
    await phone.close();
});

await test('viewer: says when there is no WebGL2', async () => {
    const without = await open(viewer, '', { before: `
        const get = HTMLCanvasElement.prototype.getContext;
        HTMLCanvasElement.prototype.getContext = function (kind, ...rest) { return /webgl/.test(kind) ? null : get.call(this, kind, ...rest); };` });
    assert.match(await textOf(without, '#message-text'), /gives no WebGL2/);
    await picture(without, '09-no-webgl2');
    assert.deepEqual(without.errors, []);
    await without.close();
});

await test('viewer: says when a limit is too small, with both numbers', async () => {
    const small = await open(viewer, '', { before: `
        const get = WebGL2RenderingContext.prototype.getParameter;
        WebGL2RenderingContext.prototype.getParameter = function (name) { return name === this.MAX_TEXTURE_SIZE ? 16 : get.call(this, name); };` });
    assert.match(await textOf(small, '#message-text'), /(width|height) \d+ exceeds MAX_TEXTURE_SIZE 16/);
    await picture(small, '09-limit');
    await small.close();
});

await test('viewer: less motion for those who ask for it', async () => {
    const calm = await open(viewer);
    await calm.send('Emulation.setEmulatedMedia', { features: [{ name: 'prefers-reduced-motion', value: 'reduce' }] });
    assert.match(await calm.evaluate("getComputedStyle(document.getElementById('hint')).transitionProperty + getComputedStyle(document.getElementById('hint')).transitionDuration"), /^(none|all)0s$/);
    await calm.close();
});

await test('gallery: cards, each of which opens in the viewer', async () => {
    const cards = await open(gallery);
    await cards.until("!document.getElementById('gallery').hidden");
    await picture(cards, '10-gallery');
    const titles = await cards.evaluate("[...document.querySelectorAll('#gallery h3')].map((title) => title.textContent)");
    assert.ok(titles.length >= 4, titles.join(', '));
    for (const [index, title] of titles.entries()) {
        if (index) {
            await cards.click('#gallery-open');
        }
        await cards.click(`#gallery li:nth-child(${index + 1}) a`);
        await cards.until(`${at('material')} === ${JSON.stringify(title)} && document.getElementById('gallery').hidden`);
        await cards.settled();
        await picture(cards, `10-gallery-${title.toLowerCase()}`);
    }
    const last = await hash(cards);
    assert.match(last, /material=/);
    assert.deepEqual(cards.errors, []);
    assert.deepEqual(cards.requests.filter((address) => !/^(file|data|blob):/.test(address)), []);
    await cards.close();
});

await browser.close();
rmSync(work, { recursive: true, force: true });
process.exit(exitCode());
