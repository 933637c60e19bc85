/* openbtf/three and openbtf/three-webgpu without a renderer, in Node.js: test_three.mjs GOLDEN, from a folder where the package and three are installed.
 *
 * SPDX-License-Identifier: MIT
 */
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
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
