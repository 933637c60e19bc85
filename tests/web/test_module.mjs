/* The package `openbtf` in Node.js: test_module.mjs GOLDEN CORPUS, from a folder where the package is installed.
 *
 * GOLDEN: tests/data/golden. CORPUS: tests/fuzz/corpus/material.
 *
 * SPDX-License-Identifier: MIT
 */
import assert from 'node:assert/strict';
import { existsSync, readFileSync, readdirSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { Material, OpenBTFError, load, memoryBytes, open } from 'openbtf';
import * as webgl from 'openbtf/webgl';
import * as webgpu from 'openbtf/webgpu';
import { exitCode, test } from './harness.mjs';

const EFFECTS = ['shadow', 'shift', 'hidden', 'gain', 'residual', 'relief', 'gloss'];
const [golden, corpus] = process.argv.slice(2);
const file = (name) => readFileSync(join(golden, name));
const files = (folder) => readdirSync(folder).filter((name) => name.endsWith('.exr')).sort();

/** Checks that a call fails with this code and a message that matches, and returns the error. */
async function refuses(code, pattern, body) {
    try {
        await body();
    } catch (error) {
        assert.ok(error instanceof OpenBTFError, String(error.stack));
        assert.equal(error.code, code, error.message);
        assert.ok(error.result > 0);
        assert.match(error.message, pattern);
        return;
    }
    assert.fail(`nothing is refused, ${code} was expected`);
}

/* A few arguments for a material: texel centres, sampled directions and some between. */
function args(material, count) {
    const { views, lights } = material;
    const uv = Float32Array.from({ length: 2 * count }, (_, i) => ((i * 7919) % 1000) / 1000);
    const pick = (list) => Float32Array.from({ length: 3 * count }, (_, i) => list[(3 * ((7 * Math.floor(i / 3)) % (list.length / 3))) + (i % 3)]);
    return [uv, pick(lights), pick(views)];
}

const bits = (array) => Array.from(new Uint32Array(array.buffer, array.byteOffset, array.length));

await test('exports map', () => {
    const require = createRequire(import.meta.url);
    assert.ok(existsSync(require.resolve('openbtf/wasm')));
    assert.deepEqual(Object.keys(webgl).sort(), ['Textures', 'fits', 'selfTest', 'upload']);
    assert.throws(() => require.resolve('openbtf/module.js'));
    const folder = join(require.resolve('openbtf/package.json'), '..');
    for (const name of ['LICENSE', 'NOTICES.txt', 'README.md', 'index.d.ts', 'webgl.d.ts', 'three.d.ts']) {
        assert.ok(existsSync(join(folder, name)), name);
    }
    for (const holder of ['OpenEXR Project', 'Jean-loup Gailly', 'Rich Felker', 'Emscripten Authors']) {
        assert.ok(readFileSync(join(folder, 'NOTICES.txt'), 'utf-8').includes(holder), holder);
    }
});

await test('WGSL of a material', async () => {
    const material = await open(file('v2-relief.btf.exr'));
    const text = material.source({ language: 'wgsl', group: 1, firstBinding: 5, prefix: 'stone' });
    assert.match(text, /^fn stone_evaluate\(uv: vec2f, l: vec3f, v: vec3f\) -> vec3f \{$/m);
    assert.match(text, /^@group\(1\) @binding\(14\) var stone_view_table: texture_2d<u32>;$/m);
    assert.match(text, /^@group\(1\) @binding\(28\) var<uniform> stone_zero: u32;$/m);
    // the textures that openbtf/webgpu uploads are those that the text reads
    const declared = Array.from(text.matchAll(/var stone_(\w+): texture/g), ([, name]) => name);
    assert.deepEqual(declared.sort(), [...new Set(material.textures({}).map(({ name }) => name))].sort());
    assert.doesNotMatch(material.source({ language: 'wgsl', math: 'fast' }), /btf_zero/);
    await refuses('USAGE', /option language: "hlsl" is none of glsl, wgsl/, () => material.source({ language: 'hlsl' }));
    await refuses('USAGE', /option group: -1 is no whole number/, () => material.source({ language: 'wgsl', group: -1 }));
    material.close();
});

await test('WebGPU is asked for in words', async () => {
    assert.deepEqual(Object.keys(webgpu).sort(), ['Textures', 'fits', 'selfTest', 'upload']);
    const material = await open(file('v1-tight.btf.exr'));
    await refuses('UNSUPPORTED', /device: not a GPUDevice/, () => webgpu.upload({}, material));
    await refuses('UNSUPPORTED', /device: not a GPUDevice/, () => webgpu.fits({}, material));
    await refuses('UNSUPPORTED', /device: not a GPUDevice/, () => webgpu.selfTest({}));
    material.close();
});

await test('imports of the module', async () => {
    const path = createRequire(import.meta.url).resolve('openbtf/wasm');
    const module = await WebAssembly.compile(readFileSync(path));
    const names = new Set(WebAssembly.Module.imports(module).map(({ module: from, name }) => `${from}.${name}`));
    // what the C library asks for; each is refused but the note that memory has grown
    for (const name of names) {
        assert.match(name, /^(wasi_snapshot_preview1\.fd_|env\.(__syscall_|emscripten_notify_memory_growth$))/);
    }
});

for (const name of files(golden)) {
    await test(`open ${name}`, async () => {
        const material = await open(file(name));
        const { info } = material;
        assert.ok(Object.isFrozen(info) && Object.isFrozen(info.effects));
        assert.equal(info.version, name.startsWith('v1') ? 1 : 2);
        assert.equal(material.views.length, 3 * info.viewCount);
        assert.equal(material.lights.length, 3 * info.lightCount);
        const textures = material.textures();
        const bytes = textures.reduce((sum, { data }) => sum + data.byteLength, 0);
        assert.equal(bytes, info.gpuBytes + info.tableBytes);
        for (const t of textures) {
            assert.equal(t.data.length, t.width * t.height * t.layers * t.channels, t.name);
        }
        assert.match(material.source(), /vec3 btf_evaluate\(/);
        const [uv, light, view] = args(material, 50);
        for (const options of [{}, { filter: 'bilinear', interpolation: 'nearest' }, { leaveOut: info.effects.slice(0, 1), level: 1 }]) {
            const fast = material.evaluate(uv, light, view, options);
            assert.deepEqual(bits(fast), bits(material.evaluate(uv, light, view, { ...options, reference: true })));
            assert.ok(fast.length === 150 && fast.every((x) => x >= 0));
        }
        assert.ok(material.evaluate(uv, light, view).some((x) => x > 0));
        // one direction for all gives the same as that direction for each
        const all = (v) => Float32Array.from({ length: 150 }, (_, i) => v[i % 3]);
        const [l, v] = [light.slice(0, 3), view.slice(0, 3)];
        for (const reference of [false, true]) {
            const options = { reference };
            assert.deepEqual(bits(material.evaluate(uv, l, v, options)), bits(material.evaluate(uv, all(l), all(v), options)));
            assert.deepEqual(bits(material.evaluate(uv, l, view, options)), bits(material.evaluate(uv, all(l), view, options)));
            assert.deepEqual(bits(material.evaluate(uv, light, v, options)), bits(material.evaluate(uv, light, all(v), options)));
        }
        material.close();
    });
}

/* The bits that golden files decode to: tests/conformance/test_golden.c explains expected.txt. */
await test('golden bits', async () => {
    const materials = new Map();
    const lines = readFileSync(join(golden, 'expected.txt'), 'utf-8').trim().split('\n');
    for (const line of lines) {
        const [name, level, mask, components, interpolation, filter, ...hex] = line.split(' ');
        if (!materials.has(name)) {
            materials.set(name, await open(file(`${name}.btf.exr`)));
        }
        const words = Uint32Array.from(hex, (word) => parseInt(word, 16));
        const floats = new Float32Array(words.buffer);
        const leaveOut = EFFECTS.filter((_, bit) => !((mask >> bit) & 1));
        const options = { level: Number(level), components: Number(components), interpolation, filter, leaveOut };
        for (const reference of [false, true]) {
            const rgb = materials.get(name).evaluate(floats.slice(0, 2), floats.slice(2, 5), floats.slice(5, 8), { ...options, reference });
            assert.deepEqual(bits(rgb), Array.from(words.slice(8)), `${line} reference ${reference}`);
        }
    }
    assert.ok(lines.length > 100 && materials.size === files(golden).length);
    materials.forEach((material) => material.close());
});

await test('options, prefix and picks', async () => {
    const material = await open(file('v2-relief.btf.exr'));
    assert.match(material.source({ prefix: 'moss' }), /vec3 moss_evaluate\(/);
    assert.match(material.source({ fixedView: [0, 0, 1] }), /BTF_FIXED_VIEW [123]/);
    assert.match(material.source({ picks: 'all' }), /#define BTF_STOCHASTIC 3/);
    assert.ok(!material.textures({ leaveOut: ['relief', 'gloss'] }).some(({ name }) => name === 'heights' || name === 'view_vectors'));
    const [uv, light, view] = args(material, 4);
    const random = new Uint32Array(12).fill(0x80000000);
    assert.equal(material.evaluate(uv, light, view, { picks: 'all', random }).length, 12);
    material.close();
});

await test('wrong options are refused by name', async () => {
    const material = await open(file('v2-all.btf.exr'));
    const uv = [0.5, 0.5], up = [0, 0, 1];
    await refuses('USAGE', /filter: "nearest" is none of texel, bilinear, steep/, () => material.source({ filter: 'nearest' }));
    await refuses('USAGE', /leaveout is none of/, () => material.source({ leaveout: [] }));
    await refuses('USAGE', /"relieff" is none of shadow/, () => material.source({ leaveOut: ['relieff'] }));
    await refuses('USAGE', /prefix/, () => material.source({ prefix: 'A' }));
    await refuses('USAGE', /components: -1/, () => material.source({ components: -1 }));
    await refuses('USAGE', /fixedView: not 3 numbers/, () => material.source({ fixedView: [0, 1] }));
    await refuses('USAGE', /unit vector|fixed view|fixed_view|direction/i, () => material.source({ fixedView: [0, 0, 2] }));
    await refuses('USAGE', /level: 0.5/, () => material.evaluate(uv, up, up, { level: 0.5 }));
    await refuses('USAGE', /light: 4 numbers/, () => material.evaluate(uv, [0, 0, 1, 0], up));
    await refuses('USAGE', /uv: 3 numbers/, () => material.evaluate([0, 0, 0], up, up));
    await refuses('USAGE', /view: not an array/, () => material.evaluate(uv, up, 'up'));
    await refuses('USAGE', /random/, () => material.evaluate(uv, up, up, { picks: 'all' }));
    await refuses('USAGE', /math is none of/, () => material.evaluate(uv, up, up, { math: 'fast' }));
    await refuses('USAGE', /made by open/, () => new Material());
    material.close();
});

await test('layers of the residual', async () => {
    const material = await open(file('v1-components.btf.exr'));
    const layers = (components) => material.textures({ components }).find(({ name }) => name === 'residual_texels').layers;
    assert.equal(layers(4), 1);
    assert.equal(layers(5), 2);
    assert.equal(layers(0), Math.ceil(material.info.components / 4));
    material.close();
});

await test('plan and restriction', async () => {
    const material = await open(file('v2-relief.btf.exr'));
    const scene = { view: { theta: [0, 30] }, light: { direction: Array.from(material.lights.slice(0, 3)) } };
    const plan = material.plan(scene, 1);
    assert.ok(Object.isFrozen(plan.shader) && plan.gpuBytes <= plan.fullGpuBytes && plan.effects.length <= material.info.effects.length);
    const small = material.restrict(plan);
    assert.equal(small.info.gpuBytes, plan.gpuBytes);
    const light = material.lights.slice(0, 3), view = [0, 0, 1], uv = [0.3, 0.7, 0.1, 0.2];
    const { leaveOut, components, interpolation, filter } = plan.shader;
    const options = { leaveOut, components, interpolation, filter };
    assert.deepEqual(bits(small.evaluate(uv, light, view, options)), bits(material.evaluate(uv, light, view, { ...options, level: plan.level })));
    assert.ok(small.source(plan.shader).length > 0);
    await refuses('USAGE', /not a plan/, () => material.restrict({ ...plan }));
    await refuses('USAGE', /not a plan/, () => small.restrict(plan));
    await refuses('UNSUPPORTED', /did not measure/, () => material.predict(plan, ['shadow']));
    await refuses('USAGE', /scene/, () => material.plan({ view: { theta: [60, 30] } }));
    await refuses('USAGE', /sceen|none of view, light/, () => material.plan({ sceen: 1 }));
    small.close();
    material.close();
    const paper = await open(file('v1-paper.btf.exr'));
    const tight = paper.toTight();
    assert.equal(tight.info.layout, 'tight');
    assert.deepEqual(bits(tight.evaluate(uv, light, view)), bits(paper.evaluate(uv, light, view)));
    tight.close();
    paper.close();
});

await test('what is no material', async () => {
    for (const [value, name] of [[undefined, 'undefined'], [null, 'null'], ['text', 'string'], [[1, 2], 'Array'], [{}, 'Object']]) {
        await refuses('USAGE', new RegExp(`ArrayBuffer or a typed array, not ${name}`), () => open(value));
    }
    await refuses('BAD_FILE', /empty file/, () => open(new ArrayBuffer(0)));
    await refuses('BAD_FILE', /not an OpenEXR file/, () => open(new TextEncoder().encode('<!DOCTYPE html>')));
});

await test('files that are damaged', async () => {
    let refused = 0, opened = 0;
    const attempt = async (data) => {
        try {
            (await open(data)).close();
            opened += 1;
        } catch (error) {
            assert.ok(error instanceof OpenBTFError, error.stack);
            assert.ok(['BAD_FILE', 'UNSUPPORTED'].includes(error.code) && error.message.length > 5, `${error.code} ${error.message}`);
            refused += 1;
        }
    };
    for (const name of files(corpus)) {
        const data = readFileSync(join(corpus, name));
        await attempt(data);
        for (const cut of [8, 100, data.length >> 1, data.length - 1]) {
            await attempt(data.subarray(0, cut));
        }
        for (let at = 3; at < data.length; at += 1 + (data.length >> 5)) {
            const broken = new Uint8Array(data);
            broken[at] ^= 0xFF;
            await attempt(broken);
        }
    }
    assert.ok(opened >= files(corpus).length && refused > 10 * files(corpus).length, `${opened} opened, ${refused} refused`);
});

await test('compressions that lose bits', async () => {
    const data = new Uint8Array(file('v1-tight.btf.exr'));
    const text = Buffer.from(data);
    const name = Buffer.from('compression\0compression\0');
    for (const [method, code] of [['PXR24', 5], ['B44', 6], ['B44A', 7], ['DWAA', 8], ['DWAB', 9]]) {
        const changed = new Uint8Array(data);
        for (let at = text.indexOf(name); at >= 0; at = text.indexOf(name, at + 1)) {
            changed[at + name.length + 4] = code;
        }
        await refuses('BAD_FILE', /compression/, () => open(changed), method);
    }
});

await test('a closed material', async () => {
    const material = await open(file('v1-paper.btf.exr'));
    const plan = material.plan();
    material.close();
    material.close();
    assert.equal(material.closed, true);
    const up = [0, 0, 1];
    const calls = [() => material.info, () => material.views, () => material.lights, () => material.textures(), () => material.source(),
        () => material.plan(), () => material.restrict(plan), () => material.predict(plan, []), () => material.toTight(),
        () => material.evaluate([0, 0], up, up)];
    for (const call of calls) {
        await refuses('USAGE', /the material is closed/, call);
    }
});

await test('memory is used again', async () => {
    const data = file('v2-all.btf.exr');
    const once = async () => {
        const material = await open(data);
        material.textures();
        material.source();
        material.evaluate(...args(material, 100));
        material.restrict(material.plan()).close();
        material.close();
    };
    await once();
    const bytes = memoryBytes();
    for (let i = 0; i < 50; i++) {
        await once();
    }
    assert.equal(memoryBytes(), bytes);
});

await test('another module is not taken', async () => {
    await load('http://openbtf.invalid/never-fetched.wasm'); // ignored: the module was loaded by the first call
});

process.exit(exitCode());
