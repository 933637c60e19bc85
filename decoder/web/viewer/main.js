/* The viewer: puts its parts together.
 *
 * SPDX-License-Identifier: MIT
 */
import { load, memoryBytes, open } from '../openbtf/index.js';
import { selfTest } from '../openbtf/webgl.js';
import { compareWithReference } from './check.js';
import { Quality, bytesRead, effectCosts, timeStates } from './costs.js';
import { contextOf, deviceName, limits, verdict } from './device.js';
import { materialBytes, materials, moduleBytes } from './embedded.js';
import { listenFiles, readFile } from './files.js';
import { listenGallery } from './gallery.js';
import { listenKeys, listenPointers, moveLight } from './input.js';
import { bytesText, Panel } from './panel.js';
import { Renderer, comparedOut, shaderOptions } from './renderer.js';
import { copyLink, savePicture } from './share.js';
import { Stage } from './stage.js';
import { MEMBERS, hashOf, initialState, stateOf } from './state.js';
import { Ball, SplitLine } from './widgets.js';

const byId = (id) => document.getElementById(id);
const canvas = byId('canvas'), root = document.documentElement;

const state = stateOf(location.hash);
const inPage = materials();
let renderer, stage, panel, ball, splitLine;
let shown = null; // { material: open, asked: the one that was opened, title, name: of those in the page or '', quality }
let times; // milliseconds by effect, of the settings as they were measured
let timed = 0; // counts what makes such times untrue: another material, other settings, another context
let circling = 0; // the time of the latest step of a light that circles
let hashTimer = 0;
let loading = Promise.resolve(); // materials are opened one after the other

function say(text) {
    byId('said').textContent = text;
    note('said', text);
    clearTimeout(say.timer);
    say.timer = setTimeout(() => { byId('said').textContent = ''; }, 6000);
}

function complain(text) {
    byId('message-text').textContent = text;
    byId('message').hidden = false;
}

/** Tests read what the page is at from attributes of the root element. */
function note(name, value) {
    root.dataset[name] = String(value);
}

function report({ samples, of, moving, fps, frameMs, compiling, scale }) {
    note('state', compiling ? 'compiling' : moving ? 'moving' : samples >= of || (!renderer.floats && samples) ? 'done' : 'refining');
    note('samples', samples);
    if (stage?.firstPicture && !root.dataset.first) {
        note('first', Math.round(stage.firstPicture));
        byId('loading').classList.add('gone');
    }
    byId('fps').textContent = compiling ? 'Compiling the shader' : moving && fps ? `${fps < 9.5 ? fps.toFixed(1) : Math.round(fps)} frames a second`
        : frameMs ? `${frameMs < 9.5 ? frameMs.toFixed(1) : Math.round(frameMs)} ms a sample` : '–';
    byId('progress').textContent = compiling ? '' : moving ? (scale < 1 ? `draft, ${Math.round(100 * scale)} %` : '') : samples < of ? `${samples} of ${of} samples` : 'done';
}

function showCosts() {
    const options = shaderOptions(state), { material, quality } = shown;
    const effects = material.info.effects.filter((effect) => !state.out.includes(effect));
    panel.setCosts(effectCosts(material, quality, options), { ...quality.of(effects, state.units), bytes: bytesRead(material, options) }, times);
}

function showSplit() {
    splitLine.draw();
    const info = shown?.material.info, compared = info && comparedOut(state, info);
    const words = { full: 'everything decoded', bare: info?.colour === 'none' ? 'only the residual' : 'every effect left out' };
    byId('split-left').hidden = byId('split-right').hidden = !compared;
    byId('split-left').textContent = 'as set';
    byId('split-right').textContent = words[state.compare] ?? `without ${state.compare}`;
    for (const id of ['split-left', 'split-right']) {
        byId(id).style.left = `${100 * state.split}%`;
    }
}

function keepLink() {
    clearTimeout(hashTimer);
    hashTimer = setTimeout(() => {
        const hash = hashOf(state);
        // browsers that count such calls refuse too many: the link is then an older one
        try {
            history.replaceState(null, '', hash ? `#${hash}` : location.pathname + location.search);
        } catch {
            // nothing depends on it
        }
    }, 300);
}

const ONLY_SHOWN = ['exposure', 'backdrop'];
const SAME_TIME = ['theta', 'phi', 'zoom', 'orbit', 'light', 'lightTheta', 'lightPhi', 'mesh', 'repeat', 'exposure', 'backdrop', 'turn', 'strength', 'sun', 'split', 'circle'];

/** A member of the state has changed, or 'orbit', 'light'. */
function changed(what) {
    if (['lightTheta', 'lightPhi', 'light', 'circle', 'all'].includes(what)) {
        ball.draw();
    }
    if (!SAME_TIME.includes(what)) {
        times = undefined;
        timed += 1;
        stage.forgetTime();
    }
    if (shown && ['out', 'units', 'interpolation', 'filter', 'picks', 'math', 'all'].includes(what)) {
        showCosts();
    }
    panel.show();
    showSplit();
    byId('hint').classList.add('gone');
    if (ONLY_SHOWN.includes(what)) {
        stage.reshow();
    } else {
        note('state', 'moving');
        note('samples', 0);
        stage.change();
    }
    keepLink();
}

/** Shows an open material in place of the former, which is closed; where that fails the former stays. */
function show(material, title, name) {
    const drawn = renderer.setMaterial(material);
    const former = shown;
    shown = { material: drawn, asked: material, title, name, quality: new Quality(drawn) };
    if (former) {
        former.material.close();
        former.asked.close();
    }
    times = undefined;
    state.material = name === inPage[0]?.name ? '' : name;
    const { info } = drawn;
    state.out = state.out.filter((effect) => info.effects.includes(effect));
    state.units = state.units >= info.components ? 0 : state.units;
    state.level = Math.min(state.level, info.levels - 1) || (state.level === 0 && info.levels > 1 ? 0 : -1);
    if (state.compare !== 'full' && state.compare !== 'bare' && !info.effects.includes(state.compare)) {
        state.compare = 'off';
    }
    byId('material-title').textContent = title;
    document.title = `${title} – OpenBTF`;
    canvas.setAttribute('aria-label', `${title} on a model`);
    panel.setMaterial(title, info, shown.quality, renderer.textureBytes);
    note('material', title);
    note('memory', memoryBytes());
    note('bytes', renderer.textureBytes);
    changed('all');
    byId('hint').classList.toggle('gone', Boolean(former));
}

async function showFromPage(name) {
    const entry = inPage.find((one) => one.name === name) ?? inPage[0];
    if (name && entry.name !== name) {
        complain(`The link's material ${name} is not in this page: it shows ${entry.title} in place of it. Drop the file here to see it.`);
    }
    if (shown?.name !== entry.name) {
        const material = await open(await materialBytes(entry.name));
        try {
            show(material, entry.title, entry.name);
        } catch (error) {
            material.close();
            throw error;
        }
    }
}

/** A file of the user's: a material or an environment. */
function take(file) {
    loading = loading.then(async () => {
        say(`Opening ${file.name}`);
        const begun = performance.now();
        const { material, environment } = await readFile(file);
        if (environment) {
            renderer.setOwnEnvironment(environment);
            panel.nameEnvironment(file.name);
            state.environment = 'own';
            changed('environment');
            say(`${file.name}: ${environment.width} × ${environment.height} pixels of light`);
            return;
        }
        try {
            show(material, file.name.replace(/(\.btf)?\.exr$/i, ''), '');
        } catch (error) {
            material.close();
            throw error;
        }
        byId('message').hidden = true;
        say(`${file.name}: ${bytesText(file.size)}, opened in ${Math.round(performance.now() - begun)} ms`);
    }).catch((error) => {
        say('');
        complain(`${file.name}: ${error.message}.${shown ? ` ${shown.title} stays.` : ''}`.replace('..', '.'));
        note('refused', file.name);
    });
    return loading;
}

async function followLink() {
    Object.assign(state, stateOf(location.hash));
    if (state.environment === 'own') {
        state.environment = 'none';
    }
    await (loading = loading.then(() => showFromPage(state.material)).catch((error) => complain(error.message)));
    changed('all');
}

async function measure() {
    const button = byId('measure'), { info } = shown.material, { out } = state, begun = timed;
    const plain = { ...state, compare: 'off', environment: 'none', sun: state.sun || 1 };
    const current = info.effects.filter((effect) => !out.includes(effect));
    const costly = info.effects.filter((effect) => effect !== 'residual' || info.colour !== 'none' || current.length > 1);
    const flip = (effect) => (out.includes(effect) ? out.filter((other) => other !== effect) : [...out, effect]);
    button.disabled = true;
    stage.pause();
    try {
        const [now, ...others] = await timeStates(renderer, [plain, ...costly.map((effect) => ({ ...plain, out: flip(effect) }))],
            (done, of) => { button.textContent = `Measuring, ${done} of ${of}`; });
        if (timed !== begun || renderer.gl.isContextLost()) {
            throw new Error('the material, its settings or the graphics device changed meanwhile');
        }
        times = { '': now };
        costly.forEach((effect, i) => { times[effect] = out.includes(effect) ? others[i] - now : now - others[i]; });
        note('measured', now.toFixed(2));
        showCosts();
        say(`${now.toFixed(1)} ms a picture of 512 × 512: ${(1000 / now).toFixed(now > 100 ? 1 : 0)} a second`);
    } catch (error) {
        complain(`Measuring: ${error.message}`);
    } finally {
        button.textContent = 'Measure time on this device';
        button.disabled = false;
        stage.resume();
    }
}

function compare() {
    const options = { ...shaderOptions(state), math: 'exact', picks: 'none' };
    try {
        const { values, different } = compareWithReference(renderer.gl, shown.material, options);
        byId('check').textContent = different ? `${different} of ${values} values differ from the reference decoder in this page.`
            : `${values.toLocaleString('en')} values compared with the reference decoder in this page: 0 bits differ.`;
        note('different', different);
    } catch (error) {
        byId('check').textContent = `Not compared: ${error.message}`;
    }
    stage.change();
}

async function testDevice() {
    const { gl } = renderer;
    byId('device').textContent = `${deviceName(gl)}. ${limits(gl)}${renderer.floats ? '' : ' It draws no floats: pictures are of one sample.'}`;
    const result = await selfTest(gl);
    const { exact, words } = verdict(result);
    byId('verdict').textContent = words;
    byId('verdict').classList.add(exact ? 'good' : 'bad');
    note('exact', exact);
    // levels, factors and lists do not depend on how sums are rounded
    if (result.names.some((rule) => !['levels', 'factors', 'lists'].includes(rule)) && state.math === 'exact') {
        state.math = 'fast';
        changed('math');
    }
}

function circle(now) {
    if (!byId('circle').checked) {
        circling = 0;
        return;
    }
    const seconds = circling ? Math.min((now - circling) / 1000, 0.5) : 0;
    circling = now;
    moveLight(state, (40 * seconds) / 180, 0);
    changed('circle');
    requestAnimationFrame(circle);
}

function reset() {
    Object.assign(state, initialState(), { material: state.material });
    byId('circle').checked = false;
    changed('all');
    say('Reset');
}

function next(name, list = MEMBERS[name].list) {
    state[name] = list[(list.indexOf(state[name]) + 1) % list.length];
    changed(name);
    say(`${name}: ${state[name]}`);
}

function toggleCircle() {
    byId('circle').checked = !byId('circle').checked;
    requestAnimationFrame(circle);
}

const save = () => savePicture(stage, canvas, shown.title).then((name) => say(`Saved ${name}`), (error) => complain(`The picture: ${error.message}`));

function actions() {
    const toggles = Object.fromEntries(['shadow', 'shift', 'hidden', 'gain', 'residual', 'relief', 'gloss'].map((effect, i) => [String(i + 1), () => {
        if (shown.material.info.effects.includes(effect)) {
            panel.toggle(effect);
            say(`${effect} ${state.out.includes(effect) ? 'off' : 'on'}`);
        } else {
            say(`${effect} is not in this material`);
        }
    }]));
    return {
        ...toggles,
        0: () => {
            state.out = [];
            changed('out');
            say('All effects');
        },
        m: () => next('mesh'),
        n: () => next('interpolation'),
        b: () => next('filter'),
        s: () => next('compare', ['off', 'bare', 'full']),
        a: toggleCircle,
        p: save,
        r: reset,
    };
}

function listen() {
    listenPointers(canvas, state, changed);
    listenKeys(canvas, state, changed, actions());
    listenFiles(byId('file'), take);
    listenGallery();
    byId('message-close').addEventListener('click', () => { byId('message').hidden = true; });
    byId('measure').addEventListener('click', measure);
    byId('check-button').addEventListener('click', compare);
    byId('copy').addEventListener('click', async () => say(await copyLink(state, shown.name !== '')));
    byId('save').addEventListener('click', save);
    byId('reset').addEventListener('click', reset);
    byId('circle').addEventListener('input', () => requestAnimationFrame(circle));
    addEventListener('hashchange', followLink);
    new ResizeObserver(() => stage.change()).observe(canvas);
}

/** Draws anew after the device was lost. */
function listenLoss() {
    canvas.addEventListener('webglcontextlost', (event) => {
        event.preventDefault();
        stage.stop();
        complain('The graphics device was lost, and will be back in a moment.');
    });
    canvas.addEventListener('webglcontextrestored', () => {
        const { asked, material } = shown, own = renderer.ownEnvironment;
        timed += 1;
        begin(renderer.gl);
        if (own) {
            renderer.setOwnEnvironment(own);
        }
        const drawn = renderer.setMaterial(asked);
        if (material !== asked) {
            material.close();
        }
        Object.assign(shown, { material: drawn, quality: new Quality(drawn) });
        byId('message').hidden = true;
        stage.change();
    });
}

function begin(gl) {
    renderer = new Renderer(gl);
    stage = new Stage(renderer, canvas, state, report, (error) => complain(`Drawing: ${error.message}`));
}

async function run() {
    begin(contextOf(canvas));
    if (state.environment === 'own') {
        state.environment = 'none';
    }
    panel = new Panel(state, changed);
    ball = new Ball(byId('ball'), state, changed);
    splitLine = new SplitLine(byId('split-line'), byId('stage'), state, changed);
    await load(await moduleBytes());
    await showFromPage(state.material);
    listen();
    listenLoss();
    await new Promise((resolve) => { setTimeout(resolve, 300); });
    await testDevice();
}

run().catch((error) => {
    byId('loading').classList.add('gone');
    byId('hint').classList.add('gone');
    byId('message').classList.add('sole');
    byId('message-close').hidden = true;
    note('failed', error.message);
    complain(error.message);
    if (!shown) {
        byId('material-title').textContent = 'Not shown';
        byId('panel').querySelectorAll('input, select, button').forEach((control) => { control.disabled = true; });
        byId('file').disabled = true;
    }
});
