/* openbtf/three and openbtf/three-webgpu without a renderer, in Node.js: test_three.mjs GOLDEN, run in a folder where
 * the package and three are installed.
 *
 * SPDX-License-Identifier: MIT
 */
import assert from 'node:assert/strict';
import { readFileSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { setFlagsFromString } from 'node:v8';
import { runInNewContext } from 'node:vm';
import { open } from 'openbtf';
import { BTFMaterial } from 'openbtf/three';
import { BTFMaterial as BTFNodeMaterial } from 'openbtf/three-webgpu';
import { ShaderMaterial } from 'three';
import { NodeMaterial } from 'three/webgpu';
import { exitCode, test } from './harness.mjs';

await test('a material of three', async () => {
    const btf = await open(readFileSync(join(process.argv[2], 'v1-paper.btf.exr')));
    const material = new BTFMaterial(btf, { repeat: 2, name: 'paper' });
    assert.ok(material instanceof ShaderMaterial);
    assert.equal(material.name, 'paper');
    assert.deepEqual(material.repeat.toArray(), [2, 2]);
    const names = new Set(btf.textures({}).map(({ name }) => `btf_${name}`));
    assert.deepEqual(new Set(Object.keys(material.uniforms).filter((name) => name.startsWith('btf_'))), names);
    assert.ok(material.fragmentShader.startsWith(btf.source()));
    assert.throws(() => new BTFMaterial(btf, { decode: { filter: 'cubic' } }), { code: 'USAGE' });
    btf.close();
    assert.throws(() => material.clone(), { code: 'USAGE', message: 'the material is closed' });
});

await test('materials take at most the textures that the documents say', async () => {
    for (const name of readdirSync(process.argv[2]).filter((of) => of.endsWith('.btf.exr'))) {
        const btf = await open(readFileSync(join(process.argv[2], name)));
        const count = new Set(btf.textures({}).map(({ name: of }) => of)).size;
        assert.ok(count <= 13, `${name}: ${count}`);
        btf.close();
    }
});

/** A stand-in for the part of a GPUDevice that makes textures. It counts them and the handlers of its loss, and refuses
 * textures while `refuses` is set. */
class Device {
    queue = { writeTexture() {} };
    limits = { maxTextureDimension2D: 8192, maxTextureArrayLayers: 2048, maxSampledTexturesPerShaderStage: 16 };
    refuses = false;
    textures = [];
    reactions = 0;

    constructor() {
        const lost = new Promise((resolve) => { this.lose = resolve; });
        this.lost = { then: (...reactions) => { this.reactions += 1; return lost.then(...reactions); } };
    }

    get held() {
        return this.textures.filter(({ destroyed }) => !destroyed).length;
    }

    createTexture(description) {
        const texture = { ...description, destroyed: false, createView: () => ({}), destroy() { texture.destroyed = true; } };
        this.textures.push(texture);
        return texture;
    }

    createBuffer() {
        return { destroy() {} };
    }

    createBindGroupLayout() {}

    createBindGroup() {}

    pushErrorScope() {}

    async popErrorScope() {
        return this.refuses ? { message: 'no' } : null;
    }
}
const constants = new Proxy({}, { get: () => 1 });
Object.assign(globalThis, { GPUDevice: Device, GPUTextureUsage: constants, GPUBufferUsage: constants, GPUShaderStage: constants });
const rendererOf = (device) => ({ backend: { isWebGPUBackend: true, device } });
const settled = () => new Promise((resolve) => { setTimeout(resolve); });

/** The errors that the console shows while a function runs and until its promises have settled. */
async function saidDuring(body) {
    const { error } = console, said = [];
    console.error = (text) => said.push(text);
    try {
        await body();
        await settled();
    } finally {
        console.error = error;
    }
    return said;
}

await test('a node material whose textures are refused', async () => {
    const btf = await open(readFileSync(join(process.argv[2], 'v1-paper.btf.exr')));
    const material = new BTFNodeMaterial(btf);
    const device = new Device(), renderer = rendererOf(device);
    const count = new Set(btf.textures({}).map(({ name }) => name)).size;
    const frames = async (number) => {
        for (let i = 0; i < number; i++) {
            material.decoderNode.updateBefore({ renderer });
            await settled();
        }
    };
    let disposed = 0;
    material.addEventListener('dispose', () => { disposed += 1; });
    // the device refuses later
    device.refuses = true;
    const said = await saidDuring(() => frames(3));
    assert.deepEqual(said, ['openbtf/three-webgpu: a material is drawn black: WebGPU has no memory left for textures: no']);
    assert.equal(device.textures.length, 2 * count, 'once, then what stands in');
    assert.ok(device.textures.slice(0, count).every(({ destroyed }) => destroyed) && device.held === count);
    assert.ok(device.textures.slice(count).every(({ size }) => String(size) === '1,1,1'));
    assert.equal(disposed, 1, 'three asks for the textures again');
    // upload() tries again, and its caller alone is told
    assert.deepEqual(await saidDuring(() => assert.rejects(material.upload(renderer), { code: 'MEMORY' })), []);
    assert.equal(device.textures.length, 4 * count);
    assert.deepEqual(await saidDuring(() => frames(3)), []);
    assert.equal(device.textures.length, 4 * count);
    device.refuses = false;
    assert.ok(await material.upload(renderer) > 0);
    await frames(2);
    assert.deepEqual([device.textures.length, device.held], [5 * count, count]);
    material.dispose();
    assert.equal(device.held, 0);
    // the device's limits refuse at once; dispose() forgets the refusal
    device.limits.maxTextureDimension2D = 1;
    const limited = await saidDuring(() => frames(3));
    assert.deepEqual([limited.length, device.textures.length, device.held], [1, 6 * count, count]);
    assert.match(limited[0], /drawn black: .* exceeds maxTextureDimension2D 1/);
    await assert.rejects(material.upload(renderer), { code: 'UNSUPPORTED' });
    material.dispose();
    device.limits.maxTextureDimension2D = 8192;
    await frames(2);
    assert.deepEqual([device.textures.length, device.held], [8 * count, count]);
    material.dispose();
    btf.close();
});

await test('a device keeps no node material, and says once that it is lost', async () => {
    const btf = await open(readFileSync(join(process.argv[2], 'v1-paper.btf.exr')));
    const device = new Device(), renderer = rendererOf(device);
    const kept = new BTFNodeMaterial(btf), other = new BTFNodeMaterial(btf);
    const gone = await (async () => {
        const material = new BTFNodeMaterial(btf);
        await material.upload(renderer);
        material.dispose();
        await material.upload(renderer);
        material.dispose();
        return new WeakRef(material);
    })();
    await kept.upload(renderer);
    await other.upload(renderer);
    assert.equal(device.reactions, 1);
    setFlagsFromString('--expose-gc');
    const collect = runInNewContext('gc');
    for (let i = 0; i < 10 && gone.deref(); i++) {
        await settled();
        collect();
    }
    assert.ok(!gone.deref(), 'what was disposed of is kept');
    device.lose();
    await settled();
    assert.equal(device.held, 0);
    const next = new Device();
    await kept.upload(rendererOf(next));
    assert.ok(next.held > 0);
    kept.dispose();
    btf.close();
});

await test('a node material of three', async () => {
    const btf = await open(readFileSync(join(process.argv[2], 'v1-paper.btf.exr')));
    const material = new BTFNodeMaterial(btf, { repeat: [2, 3], name: 'paper', decode: { filter: 'bilinear' } });
    assert.ok(material instanceof NodeMaterial && material.type === 'BTFMaterial' && material.name === 'paper');
    assert.deepEqual(material.repeat.toArray(), [2, 3]);
    assert.deepEqual(material.decode, { filter: 'bilinear' });
    const copy = material.clone();
    assert.deepEqual([copy.repeat.toArray(), copy.decode, copy.btf, copy.name], [[2, 3], { filter: 'bilinear' }, btf, 'paper']);
    assert.notEqual(copy.repeat, material.repeat);
    assert.notEqual(copy.customProgramCacheKey(), material.customProgramCacheKey(), 'two materials do not share a shader');
    assert.throws(() => new BTFNodeMaterial(btf, { decode: { filter: 'cubic' } }), { code: 'USAGE' });
    await assert.rejects(material.upload({}), { code: 'UNSUPPORTED', message: /^renderer: not a WebGPURenderer/ });
    btf.close();
    assert.throws(() => material.clone(), { code: 'USAGE', message: 'the material is closed' });
});

process.exit(exitCode());
