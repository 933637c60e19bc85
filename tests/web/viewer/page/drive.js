/* Uses the viewer in a frame by events that this script makes, so that no WebDriver is needed, and posts what it saw.
 *
 * SPDX-License-Identifier: MIT
 */
const post = (path, value) => fetch(path, { method: 'POST', body: JSON.stringify(value) });
const HANG_MS = 3000000; // a wait of 50 minutes counts as a hang, also on a busy machine; browser.mjs waits for longer

async function until(what, condition) {
    const end = Date.now() + HANG_MS;
    while (!condition()) {
        if (Date.now() > end) {
            throw new Error(`${what}: not within ${HANG_MS / 1000} s`);
        }
        await new Promise((resolve) => { setTimeout(resolve, 50); });
    }
}

const check = (name, good, wrong) => post('/case', { name: `viewer: ${name}`, wrong: good ? '' : wrong || 'not so' });

/** The viewer in a frame: its window and document, the state that it keeps in attributes, and its uncaught errors. */
class Viewer {
    errors = [];

    static async open() {
        const frame = document.createElement('iframe');
        Object.assign(frame, { width: 900, height: 560, src: '/example/viewer.html' });
        document.body.append(frame);
        await new Promise((resolve) => { frame.onload = resolve; });
        return new Viewer(frame);
    }

    constructor({ contentWindow, contentDocument }) {
        this.inside = contentWindow;
        this.page = contentDocument;
        this.data = contentDocument.documentElement.dataset;
        contentWindow.addEventListener('error', (event) => this.errors.push(event.message));
        contentWindow.addEventListener('unhandledrejection', (event) => this.errors.push(String(event.reason)));
    }

    byId(id) {
        return this.page.getElementById(id);
    }

    said(id) {
        return this.byId(id).textContent;
    }

    get hash() {
        return this.inside.location.hash;
    }

    settled() {
        return until('the picture', () => this.data.samples >= 1 && ['refining', 'done'].includes(this.data.state));
    }

    async set(id, value) {
        const control = this.byId(id);
        control.value = value;
        control.dispatchEvent(new this.inside.Event('input', { bubbles: true }));
        await until(id, () => this.hash.includes(`${id}=${value}`) && this.data.samples >= 1);
    }

    key(key, shiftKey = false) {
        this.byId('canvas').dispatchEvent(new this.inside.KeyboardEvent('keydown', { key, shiftKey, bubbles: true }));
    }

    /** Drops a file on the picture. */
    drop(name, bytes) {
        const dataTransfer = new this.inside.DataTransfer();
        dataTransfer.items.add(new this.inside.File([bytes], name));
        for (const type of ['dragenter', 'dragover', 'drop']) {
            this.byId('canvas').dispatchEvent(new this.inside.DragEvent(type, { dataTransfer, bubbles: true, cancelable: true }));
        }
    }
}

async function checkKeys(viewer) {
    const keys = [['ArrowLeft', false, 'phi'], ['ArrowUp', true, 'lightTheta'], ['+', false, 'zoom'], ['.', false, 'exposure'], ['m', false, 'mesh'],
        ['n', false, 'interpolation'], ['b', false, 'filter'], ['s', false, 'compare']];
    for (const [key, shift, member] of keys) {
        const before = viewer.hash;
        viewer.key(key, shift);
        await until(`the key ${key}`, () => viewer.hash !== before && viewer.hash.includes(`${member}=`));
    }
    viewer.key('r');
    await until('the key r', () => viewer.hash === '');
    await check('keys turn, light, zoom, expose, choose and go back', true);
}

/** Drops files: a good one is shown; for a damaged and a wrong one a message says why, and the material stays. */
async function checkFiles(viewer, golden) {
    const good = new Uint8Array(await (await fetch(`/golden/${golden}`)).arrayBuffer()), title = golden.replace('.btf.exr', '');
    viewer.drop(golden, good);
    await until('the file that is dropped', () => viewer.data.material === title);
    await viewer.settled();
    await check('a file that is dropped is shown', viewer.byId('message').hidden, viewer.said('message-text'));
    const refused = [['damaged.btf.exr', good.subarray(0, good.length >> 1), /^damaged\.btf\.exr: ./],
        ['notes.txt', new TextEncoder().encode('these are notes, and no material'), /not an OpenEXR file/]];
    for (const [name, bytes, pattern] of refused) {
        viewer.drop(name, bytes);
        await until(`a message of ${name}`, () => !viewer.byId('message').hidden);
        const message = viewer.said('message-text');
        await check(`${name} is refused in words, and the material stays`,
            pattern.test(message) && message.endsWith(`${title} stays.`) && viewer.data.material === title, message);
        viewer.byId('message-close').click();
    }
    await viewer.settled();
}

/** Checks the picture that the viewer saves. */
async function checkPicture(viewer) {
    const { URL: urls, HTMLAnchorElement: Anchor } = viewer.inside, { createObjectURL } = urls;
    let saved, name;
    urls.createObjectURL = (blob) => {
        saved = blob;
        return createObjectURL.call(urls, blob);
    };
    Anchor.prototype.click = function () { name = this.download; };
    viewer.byId('save').click();
    await until('the picture is saved', () => name);
    urls.createObjectURL = createObjectURL;
    delete Anchor.prototype.click;
    const image = await createImageBitmap(saved), canvas = new OffscreenCanvas(image.width, image.height), to = canvas.getContext('2d');
    to.drawImage(image, 0, 0);
    const colours = new Set(new Uint32Array(to.getImageData(0, 0, image.width, image.height).data.buffer)).size;
    const { clientWidth, clientHeight } = viewer.byId('canvas');
    await check('the picture is saved as PNG, of the size of the canvas', saved.type === 'image/png' && /^[\w.-]+\.png$/.test(name) && colours > 100
        && image.width / image.height > 0.9 * clientWidth / clientHeight && image.width / image.height < 1.1 * clientWidth / clientHeight,
        `${name}, ${saved.type}, ${image.width} x ${image.height} of ${clientWidth} x ${clientHeight}, ${colours} colours`);
}

async function run() {
    const { golden } = await (await fetch('/job')).json();
    const viewer = await Viewer.open(), { data } = viewer;
    await until('the first picture', () => data.first || data.failed);
    await check('a material is shown', data.first && !data.failed, data.failed);
    await until('the self-test', () => data.exact);
    await check('the self-test passes', data.exact === 'true', viewer.said('verdict'));
    viewer.byId('check-button').click();
    await until('the comparison', () => viewer.said('check'));
    await check('0 bits differ from the reference decoder', data.different === '0', viewer.said('check'));
    viewer.byId('measure').click();
    await until('the measurement', () => data.measured || !viewer.byId('message').hidden);
    await check('times of effects are measured', Number(data.measured) > 0, viewer.said('message-text'));
    await checkKeys(viewer);
    for (const [id, value] of [['environment', 'sky'], ['picks', 'all'], ['compare', 'bare']]) {
        await viewer.set(id, value);
    }
    await check('environment, picked neighbours and a split picture are drawn', viewer.byId('message').hidden, viewer.said('message-text'));
    viewer.byId('reset').click();
    await checkFiles(viewer, golden);
    await checkPicture(viewer);
    await check('no error', viewer.errors.length === 0, viewer.errors.join('; '));
    await post('/note', `${navigator.userAgent}: ${viewer.said('device')} First picture after ${data.first} ms; ${data.measured} ms for 512 x 512 pixels, on this machine`);
}

run().then(() => post('/done', ''), (error) => post('/done', `${error.message}\n${error.stack}`));
