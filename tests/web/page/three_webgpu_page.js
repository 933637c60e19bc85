/* openbtf/three-webgpu: scenes of scenes.mjs drawn by three's WebGPURenderer, against the pictures that btf-render drew of them.
 *
 * SPDX-License-Identifier: MIT
 */
import * as THREE from 'three';
import { OpenBTFError, open } from '/package/index.js';
import { BTFMaterial } from '/package/three_webgpu.js';
import { bytes, report } from './post.js';
import { build, compareScenes, compareSpot, compareTwo, drawn, far, near, refuses } from './three_scenes.js';

/** Textures are uploaded once, destroyed, uploaded again, and belong to a device each. */
async function livesAndDies(renderer, scene, material) {
    const { device } = renderer.backend;
    const made = [];
    device.createTexture = function (description) {
        const texture = Object.getPrototypeOf(this).createTexture.call(this, description);
        if (description.label?.startsWith('openbtf ')) {
            const { destroy } = texture;
            texture.destroy = () => { texture.destroyed = true; destroy.call(texture); };
            made.push(texture);
        }
        return texture;
    };
    const world = build(scene, material);
    const copy = material.clone();
    const first = drawn(renderer, scene, world);
    await report('three-webgpu: textures are uploaded once', made.length === 0 ? '' : 'and again');
    await near('a clone', drawn(renderer, scene, build(scene, copy)), first, 0);
    const bytesOf = await copy.upload(renderer);
    const sum = copy.btf.textures(copy.decode).reduce((total, { data }) => total + data.byteLength, 0);
    await report('three-webgpu: upload() tells the bytes', bytesOf === sum ? '' : `${bytesOf}, not ${sum}`);
    const count = made.length;
    copy.dispose();
    await report('three-webgpu: dispose destroys the textures', count > 0 && made.every(({ destroyed }) => destroyed) ? '' : `${count} were made, one is left`);
    await near('after dispose', drawn(renderer, scene, build(scene, copy)), first, 0);
    await report('three-webgpu: after dispose textures are uploaded again', made.length === 2 * count ? '' : `${made.length}, not ${2 * count}`);
    copy.dispose();
    material.repeat.set(7, 5);
    await far('control: another repeat', drawn(renderer, scene, world), first);
    const second = await rendererOf(renderer.domElement.width);
    await near('on a second device', drawn(second, scene, build(scene, material)), first, 0);
    second.dispose();
    await near('again on the first', drawn(renderer, scene, build(scene, material)), first, 0);
}

/* The golden material is noise, with values beyond what the halves hold in which three keeps a picture. */
async function rendererOf(side) {
    const renderer = new THREE.WebGPURenderer({ outputBufferType: THREE.FloatType });
    await renderer.init();
    renderer.setSize(side, side, false);
    return renderer;
}

window.runThree = async ({ material: name, other, scenes, side }) => {
    const btf = await open(await bytes(`/golden/${name}`)), otherBtf = await open(await bytes(`/golden/${other}`));
    const material = new BTFMaterial(btf, { decode: { filter: 'bilinear' } });
    const before = await material.upload(new THREE.WebGPURenderer()).then(() => 'nothing is refused', (error) => error);
    await report('three-webgpu: refused: a renderer without a device', before instanceof OpenBTFError && before.code === 'USAGE' ? '' : String(before));
    const renderer = await rendererOf(side);
    await report('three-webgpu: the renderer draws by WebGPU', renderer.backend.isWebGPUBackend ? '' : 'by WebGL');
    await compareScenes(renderer, material, scenes);
    await compareSpot(renderer, material, scenes.find(({ name: of }) => of === 'shadow of a point'));
    const above = { ...scenes[0], view: [0, 0] };
    await compareTwo(renderer, above, material, new BTFMaterial(otherBtf, { decode: { filter: 'bilinear' }, repeat: 2 }));
    await livesAndDies(renderer, scenes[0], material);
    await refuses('an option that is none', /^USAGE .*picks/, () => new BTFMaterial(btf, { decode: { picks: 'all' } }));
    await refuses('three repeats', /^USAGE repeat/, () => new BTFMaterial(btf, { repeat: [1, 2, 3] }));
    otherBtf.close();
    await refuses('a material that is closed', /^USAGE the material is closed/, () => new BTFMaterial(otherBtf));
    renderer.dispose();
    btf.close();
};
