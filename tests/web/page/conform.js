/* The page of the conformance tests: decodes in WebGL2 and compares every bit with test vectors and with the reference decoder
 * in the page. Posts cases to the server that runs the test.
 *
 * SPDX-License-Identifier: MIT
 */
import { open, load, memoryBytes } from '/package/index.js';
import { selfTest, upload } from '/package/webgl.js';
import { make, pack } from './arguments.js';
import { context, draw, program } from './draw.js';

/* Of the compared values in a row: how large the picture is. 3 * 512 * 336 values are more than 500,000. */
const WIDE = 512, HIGH = 336;
/* Variants that materials are decoded by in turn. */
const VARIANTS = [
    { interpolation: 'linear', filter: 'texel' },
    { interpolation: 'nearest', filter: 'bilinear' },
    { interpolation: 'linear', filter: 'steep' },
];

const post = (path, value) => fetch(path, { method: 'POST', body: JSON.stringify(value) });
const report = (name, wrong = '') => post('/case', { name, wrong });
const json = async (path) => (await fetch(path)).json();
const bytes = async (path) => (await fetch(path)).arrayBuffer();

/** Of `count` evaluations, values whose bits differ; `want` has three words each, `got` four. */
function differing(got, want, count) {
    let different = 0;
    for (let i = 0; i < count; i++) {
        for (let c = 0; c < 3; c++) {
            different += got[4 * i + c] !== want[3 * i + c] ? 1 : 0;
        }
    }
    return different;
}

/** The options of a vector. */
function optionsOf(vector, info) {
    const decoded = vector.effects === 'none' || vector.effects === '' ? [] : vector.effects.split(',');
    return {
        leaveOut: info.effects.filter((effect) => !decoded.includes(effect)),
        components: vector.components,
        interpolation: vector.interpolation,
        filter: vector.filter,
    };
}

/** A vector's words of one plane, [count][size], from byte plane `first` of its 14. */
function plane(data, first, size) {
    const count = data.length / 14;
    const out = new Uint32Array(size * count);
    for (let i = 0; i < count; i++) {
        out.set(data.subarray(14 * i + first, 14 * i + first + size), size * i);
    }
    return out;
}

const WANTED = { radiance: 8, picked: 11 };

/** Values of a vector's plane that differ. `change` rewrites the shader text. */
async function replay(gl, vector, planes, change = (text) => text) {
    const material = await open(await bytes(`/vectors/${vector.material}`));
    const data = new Uint32Array(await bytes(`/vectors/${vector.data}`));
    const args = pack(plane(data, 0, 2), plane(data, 2, 3), plane(data, 5, 3));
    let different = 0;
    for (const name of planes) {
        const options = { ...optionsOf(vector, material.info), picks: name === 'picked' ? 'all' : 'none' };
        const textures = upload(gl, material, options);
        const linked = program(gl, change(material.source(options)), name);
        const got = draw(gl, textures, linked, vector.side, data.length / 14 / vector.side, args, vector.level, vector.number);
        different += differing(got, plane(data, WANTED[name], 3), data.length / 14);
        gl.deleteProgram(linked);
        textures.destroy();
    }
    material.close();
    return different;
}

/** Every vector's radiance; of a third of them, which have every effect and filter, radiance of picked neighbours too. */
async function compareVectors(gl, vectors) {
    for (const part of [0, 1, 2]) {
        const list = vectors.filter((_, i) => i % 3 === part);
        const planes = part === 0 ? ['radiance', 'picked'] : ['radiance'];
        const wrong = [];
        for (const vector of list) {
            const different = await replay(gl, vector, planes);
            if (different) {
                wrong.push(`${vector.material} (${vector.about}): ${different} values differ`);
            }
        }
        await report(`vectors ${part + 1} of 3: ${list.length} vectors, ${planes.join(' and ')}, 0 bits differ`, wrong.join('\n'));
    }
}

/** The first material of each kind is enough for a control: text that is wrong must be noticed. */
async function control(gl, name, vectors, change, noticed) {
    let different = 0;
    for (const vector of vectors) {
        different += await replay(gl, vector, ['radiance'], change);
    }
    const wrong = noticed && !different ? 'no value differs, and some must' : '';
    await report(`control: ${name}${noticed ? ' is noticed' : ''}`, wrong);
    await post('/note', `control ${name}: ${different} values of ${vectors.length} vectors differ`);
}

/** Replaces text that must be there. */
function changed(text, from, to) {
    if (!text.includes(from)) {
        throw new Error(`the shader has no '${from}'`);
    }
    return text.replaceAll(from, to);
}

async function compareReference(gl, materials) {
    for (const [index, name] of materials.entries()) {
        const material = await open(await bytes(`/golden/${name}`));
        const options = VARIANTS[index % VARIANTS.length];
        const level = index % material.info.levels;
        const { uv, light, view } = make(material, WIDE * HIGH, 77 + index);
        const textures = upload(gl, material, options);
        const linked = program(gl, material.source(options), 'radiance');
        const got = draw(gl, textures, linked, WIDE, HIGH, pack(uv, light, view), level, 0);
        const reference = material.evaluate(uv, light, view, { ...options, level, reference: true });
        const different = differing(got, new Uint32Array(reference.buffer), WIDE * HIGH);
        const label = `reference: ${name} level ${level} ${options.interpolation} ${options.filter}, ${3 * WIDE * HIGH} values`;
        await report(`${label}, 0 bits differ`, different ? `${different} values differ` : '');
        gl.deleteProgram(linked);
        textures.destroy();
        material.close();
    }
}

/** State that a user may have set must be what it was. */
async function restoresState(gl, name) {
    const buffer = gl.createBuffer(), texture = gl.createTexture(), other = gl.createTexture(), framebuffer = gl.createFramebuffer();
    const array = gl.createVertexArray(), sampler = gl.createSampler();
    gl.activeTexture(gl.TEXTURE3);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, other);
    gl.bindSampler(3, sampler);
    gl.bindBuffer(gl.PIXEL_UNPACK_BUFFER, buffer);
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.bindVertexArray(array);
    gl.enable(gl.BLEND);
    gl.enable(gl.SCISSOR_TEST);
    gl.colorMask(true, false, true, false);
    gl.viewport(1, 2, 3, 4);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 8);
    gl.pixelStorei(gl.UNPACK_ROW_LENGTH, 7);
    gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, true);
    gl.pixelStorei(gl.PACK_ROW_LENGTH, 9);
    const names = ['ACTIVE_TEXTURE', 'TEXTURE_BINDING_2D', 'TEXTURE_BINDING_2D_ARRAY', 'SAMPLER_BINDING', 'PIXEL_UNPACK_BUFFER_BINDING',
        'PIXEL_PACK_BUFFER_BINDING', 'DRAW_FRAMEBUFFER_BINDING', 'READ_FRAMEBUFFER_BINDING', 'VERTEX_ARRAY_BINDING', 'BLEND', 'SCISSOR_TEST',
        'COLOR_WRITEMASK', 'VIEWPORT', 'UNPACK_ALIGNMENT', 'UNPACK_ROW_LENGTH', 'UNPACK_FLIP_Y_WEBGL', 'UNPACK_PREMULTIPLY_ALPHA_WEBGL',
        'PACK_ROW_LENGTH', 'CURRENT_PROGRAM'];
    const state = () => names.map((parameter) => gl.getParameter(gl[parameter])).map((value) => (ArrayBuffer.isView(value) || Array.isArray(value) ? String(Array.from(value)) : value));
    const before = state();
    const material = await open(await bytes(`/golden/${name}`));
    const textures = upload(gl, material);
    const { failures } = await selfTest(gl);
    const after = state();
    const wrong = names.filter((_, i) => before[i] !== after[i]);
    await report('upload and self-test put state back', wrong.join(', '));
    await report('self-test passes under that state', failures ? `failures ${failures}` : '');
    const sum = material.textures().reduce((total, { data }) => total + data.byteLength, 0);
    await report('bytes uploaded', textures.bytes === sum ? '' : `${textures.bytes}, not ${sum}`);
    textures.destroy();
    material.close();
}

/** Loading and closing again and again takes no more memory than once. */
async function freesMemory(gl, name) {
    const data = await bytes(`/golden/${name}`);
    let after1;
    for (let i = 0; i < 50; i++) {
        const material = await open(data);
        upload(gl, material).destroy();
        material.close();
        after1 ??= memoryBytes();
    }
    await report('50 materials opened and closed take the memory of one', memoryBytes() === after1 ? '' : `${memoryBytes()} bytes, after the first ${after1}`);
}

/* Requests that the page's policy kept from leaving; those that left are in the browser's own list. */
const refused = [];
document.addEventListener('securitypolicyviolation', (event) => refused.push(event.blockedURI));

async function nothingLeaves() {
    const away = performance.getEntriesByType('resource').map((entry) => entry.name).filter((url) => new URL(url).origin !== location.origin);
    await report('no request leaves the page', [...away, ...refused].join(' '));
    // the control: one that tries to is seen
    const seen = new Promise((resolve) => document.addEventListener('securitypolicyviolation', resolve, { once: true }));
    await fetch('http://openbtf.invalid/').catch(() => {});
    await seen;
    await report('control: a request that would leave is noticed', refused.length ? '' : 'it was not');
}

async function run() {
    const job = await json('/job');
    const gl = context();
    await load('/package/openbtf.wasm');
    const renderer = gl.getExtension('WEBGL_debug_renderer_info');
    await post('/note', `${navigator.userAgent}; ${renderer ? gl.getParameter(renderer.UNMASKED_RENDERER_WEBGL) : gl.getParameter(gl.RENDERER)}`);
    const { failures, names } = await selfTest(gl);
    await report('self-test', failures ? names.join(', ') : '');
    await restoresState(context(), job.golden[0]);
    await compareReference(gl, job.golden);
    const vectors = await json('/vectors/vectors.json');
    await compareVectors(gl, vectors);
    const zero = vectors.filter((_, i) => i % 4 === 0);
    await control(gl, 'a zero that the compiler knows', zero, (text) => `#define BTF_ZERO 0u\n${text}`, job.noticesZero);
    const shift = vectors.filter(({ effects, about }) => effects.includes('shift') && !about.startsWith('1x1')).slice(0, 4);
    await control(gl, 'swapped shift bytes', shift, (text) => changed(changed(changed(text, 'btf_shift_of(codes.y)', 'swap'),
        'btf_shift_of(codes.z)', 'btf_shift_of(codes.y)'), 'swap', 'btf_shift_of(codes.z)'), true);
    await freesMemory(gl, job.golden[0]);
    await nothingLeaves();
}

run().then(() => post('/done', ''), (error) => post('/done', error.stack ? `${error.message}\n${error.stack}` : String(error)));
