/* Drives Chromium by the DevTools protocol over a pipe: pages, real input events, pictures of the screen. Needs no npm
 * package.
 *
 * SPDX-License-Identifier: MIT
 */
import { spawn } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { CHROMIUM } from '../browser.mjs';

const HANG_MS = 3600000; // a wait of an hour counts as a hang, also on a busy machine
/* Pixels of the screen for a CSS pixel: few, because software draws them. BTF_PICTURES_SCALE=1 gives pictures for
 * people. */
const SCALE = Number(process.env.BTF_PICTURES_SCALE ?? 0.25);
const sleep = (ms) => new Promise((resolve) => { setTimeout(resolve, ms); });

/* A script that runs before those of the page and counts its live WebGL objects. */
const COUNT_OBJECTS = `(() => {
    window.alive = {};
    for (const kind of ['Texture', 'Buffer', 'Program', 'Shader', 'Framebuffer', 'Renderbuffer', 'VertexArray']) {
        window.alive[kind] = 0;
        const gl = WebGL2RenderingContext.prototype, live = new WeakSet();
        const [create, remove] = [gl['create' + kind], gl['delete' + kind]];
        gl['create' + kind] = function (...values) { const made = create.apply(this, values); live.add(made); window.alive[kind] += 1; return made; };
        gl['delete' + kind] = function (object) { if (object && live.delete(object)) { window.alive[kind] -= 1; } return remove.call(this, object); };
    }
})();`;

export class Browser {
    #child;
    #profile = mkdtempSync(join(tmpdir(), 'openbtf-viewer-'));
    #next = 1;
    #waiting = new Map();
    #rest = '';
    #pages = new Map();
    #said = '';

    constructor() {
        this.#child = spawn('chromium', [...CHROMIUM, '--remote-debugging-pipe', '--hide-scrollbars', '--window-size=1000,720', '--allow-file-access-from-files=false',
            `--user-data-dir=${this.#profile}`], { stdio: ['ignore', 'ignore', 'pipe', 'pipe', 'pipe'], detached: true, env: { ...process.env, HOME: this.#profile } });
        // a character may come in two parts
        this.#child.stderr.setEncoding('utf8');
        this.#child.stdio[4].setEncoding('utf8');
        this.#child.stderr.on('data', (data) => { this.#said = (this.#said + data).slice(-2000); });
        this.#child.stdio[4].on('data', (text) => this.#received(text));
        this.#child.stdio[3].on('error', () => {}); // the browser has ended: its exit event tells
        this.#child.on('exit', (code) => this.#waiting.forEach(({ reject }) => reject(new Error(`chromium ended (${code}): ${this.#said}`))));
        process.on('exit', () => this.#kill());
        ['SIGINT', 'SIGTERM', 'SIGHUP'].forEach((signal) => process.on(signal, () => process.exit(1)));
    }

    #kill() {
        try {
            process.kill(-this.#child.pid, 'SIGTERM');
        } catch {
            // it has ended
        }
    }

    #received(text) {
        const messages = (this.#rest + text).split('\0');
        this.#rest = messages.pop();
        for (const message of messages.map((one) => JSON.parse(one))) {
            if (message.id) {
                const { resolve, reject, method } = this.#waiting.get(message.id);
                this.#waiting.delete(message.id);
                if (message.error) {
                    reject(new Error(`${method}: ${message.error.message}`));
                } else {
                    resolve(message.result);
                }
            } else {
                this.#pages.get(message.sessionId)?.heard(message.method, message.params);
            }
        }
    }

    send(method, params = {}, sessionId) {
        const id = this.#next++;
        return new Promise((resolve, reject) => {
            this.#waiting.set(id, { resolve, reject, method });
            this.#child.stdio[3].write(`${JSON.stringify({ id, method, params, sessionId })}\0`);
        });
    }

    /** A new page of a URL. @param before script that runs in front of the page's own */
    async open(url, { before = '', width = 960, height = 540, mobile = false, scale = SCALE } = {}) {
        const { targetId } = await this.send('Target.createTarget', { url: 'about:blank' });
        const { sessionId } = await this.send('Target.attachToTarget', { targetId, flatten: true });
        const page = new Page(this, sessionId, targetId);
        this.#pages.set(sessionId, page);
        for (const domain of ['Page', 'Runtime', 'Log', 'Network', 'DOM']) {
            await page.send(`${domain}.enable`);
        }
        await page.send('Page.addScriptToEvaluateOnNewDocument', { source: COUNT_OBJECTS + before });
        await page.send('Emulation.setDeviceMetricsOverride', { width, height, deviceScaleFactor: scale, mobile });
        if (mobile) {
            await page.send('Emulation.setTouchEmulationEnabled', { enabled: true, maxTouchPoints: 3 });
        }
        await page.send('Page.navigate', { url });
        return page;
    }

    async close() {
        const gone = new Promise((resolve) => { this.#child.on('exit', resolve); });
        this.#kill();
        await gone;
        rmSync(this.#profile, { recursive: true, force: true, maxRetries: 10, retryDelay: 200 });
    }
}

class Page {
    /** Faults of the page: uncaught errors and console messages of the level error or warning. */
    errors = [];
    /** URLs that the page asked for. */
    requests = [];

    constructor(browser, session, target) {
        this.browser = browser;
        this.session = session;
        this.target = target;
    }

    heard(method, params) {
        if (method === 'Runtime.exceptionThrown') {
            this.errors.push(params.exceptionDetails.exception?.description ?? params.exceptionDetails.text);
        } else if (method === 'Runtime.consoleAPICalled' && ['error', 'warning', 'assert'].includes(params.type)) {
            this.errors.push(params.args.map(({ value, description }) => value ?? description).join(' '));
        } else if (method === 'Log.entryAdded' && ['error', 'warning'].includes(params.entry.level)) {
            this.errors.push(`${params.entry.text} ${params.entry.url ?? ''}`);
        } else if (method === 'Network.requestWillBeSent') {
            this.requests.push(params.request.url);
        }
    }

    send(method, params) {
        return this.browser.send(method, params, this.session);
    }

    /** The value of an expression, which may be a promise. */
    async evaluate(expression) {
        const { result, exceptionDetails } = await this.send('Runtime.evaluate', { expression, awaitPromise: true, returnByValue: true, userGesture: true });
        if (exceptionDetails) {
            throw new Error(`${expression.slice(0, 200)}: ${exceptionDetails.exception?.description ?? exceptionDetails.text}`);
        }
        return result.value;
    }

    /** Waits until an expression is true. */
    async until(expression) {
        const end = Date.now() + HANG_MS;
        while (!(await this.evaluate(`Boolean(document.body && (${expression}))`))) {
            if (Date.now() > end) {
                const state = await this.evaluate('JSON.stringify({ ...document.documentElement.dataset, message: document.getElementById("message-text")?.textContent })');
                throw new Error(`not within ${HANG_MS / 1000} s: ${expression}; ${state}; ${this.errors.join('; ')}`);
            }
            await sleep(50);
        }
    }

    /** Waits until the picture has been drawn in full with the current settings. */
    async settled() {
        await sleep(50);
        await this.until("document.documentElement.dataset.samples >= 1 && ['refining', 'done'].includes(document.documentElement.dataset.state)");
    }

    /** Writes a picture of the page to a file and gives it as base64. */
    async picture(path, clip) {
        const { data } = await this.send('Page.captureScreenshot', { format: 'png', ...(clip ? { clip: { ...clip, scale: 1 } } : {}) });
        if (path) {
            writeFileSync(path, Buffer.from(data, 'base64'));
        }
        return data;
    }

    /** Scrolls to an element and returns its box: {x, y: its centre, left, top, width, height}, in CSS pixels. */
    async box(selector) {
        return this.evaluate(`(() => {
            const element = document.querySelector(${JSON.stringify(selector)});
            element.scrollIntoView({ block: 'nearest' });
            const { left, top, width, height } = element.getBoundingClientRect();
            return { left, top, width, height, x: left + width / 2, y: top + height / 2 };
        })()`);
    }

    async mouse(type, x, y, { button = 'left', modifiers = 0, pressed = false } = {}) {
        const buttons = pressed || type === 'mousePressed' ? { left: 1, right: 2 }[button] : 0;
        await this.send('Input.dispatchMouseEvent', { type, x, y, button: type === 'mouseMoved' && !pressed ? 'none' : button, buttons, modifiers,
            clickCount: type === 'mouseMoved' ? 0 : 1 });
    }

    async click(selector) {
        const { x, y } = await this.box(selector);
        await this.mouse('mouseMoved', x, y);
        await this.mouse('mousePressed', x, y);
        await this.mouse('mouseReleased', x, y);
    }

    /** Presses at a place, moves by (dx, dy) in a few steps, and lets go. */
    async drag(x, y, dx, dy, options = {}) {
        await this.mouse('mouseMoved', x, y, { modifiers: options.modifiers });
        await this.mouse('mousePressed', x, y, options);
        for (let i = 1; i <= 4; i++) {
            await this.mouse('mouseMoved', x + (dx * i) / 4, y + (dy * i) / 4, { ...options, pressed: true });
        }
        await this.mouse('mouseReleased', x + dx, y + dy, options);
    }

    async touch(type, points) {
        await this.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
    }

    async key(key, modifiers = 0) {
        const code = { ArrowLeft: 37, ArrowUp: 38, ArrowRight: 39, ArrowDown: 40, Tab: 9, Escape: 27, Home: 36, End: 35 }[key] ?? key.toUpperCase().charCodeAt(0);
        const text = key.length === 1 && !modifiers ? key : undefined;
        await this.send('Input.dispatchKeyEvent', { type: 'keyDown', key, windowsVirtualKeyCode: code, modifiers, text });
        await this.send('Input.dispatchKeyEvent', { type: 'keyUp', key, windowsVirtualKeyCode: code, modifiers });
    }

    /** Drops files on the middle of the picture. */
    async drop(...files) {
        const { x, y } = await this.box('#canvas');
        const data = { items: [], files, dragOperationsMask: 1 };
        for (const type of ['dragEnter', 'dragOver', 'drop']) {
            await this.send('Input.dispatchDragEvent', { type, x, y, data });
        }
    }

    /** Picks files by the page's file input. */
    async pick(...files) {
        const { root } = await this.send('DOM.getDocument');
        const { nodeId } = await this.send('DOM.querySelector', { nodeId: root.nodeId, selector: '#file' });
        await this.send('DOM.setFileInputFiles', { nodeId, files });
    }

    /** Sets a control, with the events that a user's choice gives. */
    async set(id, value) {
        await this.evaluate(`(() => {
            const control = document.getElementById(${JSON.stringify(id)});
            control.value = ${JSON.stringify(String(value))};
            control.dispatchEvent(new Event('input', { bubbles: true }));
        })()`);
    }

    async close() {
        await this.browser.send('Target.closeTarget', { targetId: this.target });
    }
}
