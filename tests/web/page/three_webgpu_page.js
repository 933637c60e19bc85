/* openbtf/three-webgpu: compares scenes of scenes.mjs that three's WebGPURenderer draws with the pictures that
 * btf-render drew of them.
 *
 * SPDX-License-Identifier: MIT
 */
import * as THREE from 'three';
import { OpenBTFError, open } from '/package/index.js';
import { BTFMaterial } from '/package/three_webgpu.js';
import { bytes, report } from './post.js';
import { build, compareOpacity, compareScenes, compareSpot, compareTwo, drawn, far, near, refusesArguments } from './three_scenes.js';

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

/** A device that refuses the textures is asked once; a picture goes on without the material, until upload() is called. */
async function survivesRefusal(renderer, scene, material) {
    const { device } = renderer.backend;
    const first = drawn(renderer, scene, build(scene, material));
    const other = material.clone();
    const world = build(scene, other);
    const { error } = console, said = [], errors = [];
    const listen = ({ error: { message } }) => errors.push(message);
    device.addEventListener('uncapturederror', listen);
    console.error = (text) => said.push(text);
    let made = 0, refused = 0; // refused: how many of the next error scopes report a refusal, those of our textures
    const { createTexture } = device;
    device.createTexture = function (description) {
        if (description.label?.startsWith('openbtf ')) {
            made += 1;
            refused = 2;
        }
        return createTexture.call(this, description);
    };
    device.popErrorScope = function () {
        const answer = Object.getPrototypeOf(this).popErrorScope.call(this);
        refused -= 1;
        return refused < 0 ? answer : answer.then(() => ({ message: 'there is too much of it' }));
    };
    drawn(renderer, scene, world);
    delete device.popErrorScope;
    const count = made;
    await device.queue.onSubmittedWorkDone();
    await new Promise((resolve) => { setTimeout(resolve); });
    // beside a material that the device has taken
    const both = build(scene, other);
    const beside = build(scene, material).children[0];
    beside.position.x = 0.5;
    both.add(beside);
    const after = made;
    const black = drawn(renderer, scene, world);
    const pictures = [drawn(renderer, scene, both), drawn(renderer, scene, both)];
    await device.queue.onSubmittedWorkDone();
    await new Promise((resolve) => { setTimeout(resolve); });
    console.error = error;
    device.createTexture = createTexture;
    const dark = (pixels) => pixels.every((value, i) => i % 4 === 3 || value === 0);
    await report('three-webgpu: textures that the device refuses are uploaded once', count > 0 && made === after ? '' : `${count}, then ${made - after} more`);
    await report('three-webgpu: the material is black then', dark(black) ? '' : 'it is not');
    await report('three-webgpu: what else there is is drawn', pictures.every((pixels) => !dark(pixels)) ? '' : 'it is not');
    await report('three-webgpu: the console says why, once', said.length === 1 && /drawn black: .*there is too much of it/.test(said[0]) ? '' : JSON.stringify(said));
    await report('three-webgpu: the device finds nothing else wrong', errors.join('\n'));
    await other.upload(renderer);
    await near('after upload() of what was refused', drawn(renderer, scene, build(scene, other)), first, 0);
    device.removeEventListener('uncapturederror', listen);
    other.dispose();
}

/* Frames are in floats by default, because the golden material is noise with values beyond the range of the halves that
 * three uses. */
async function rendererOf(side, outputBufferType = THREE.FloatType) {
    const renderer = new THREE.WebGPURenderer({ outputBufferType });
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
    // not every device blends floats; under less light the values are within the range of halves
    const halves = await rendererOf(side, THREE.HalfFloatType);
    await compareOpacity(halves, { ...scenes[0], lights: scenes[0].lights.map((light) => ({ ...light, intensity: 0.01 * light.intensity })) }, material);
    halves.dispose();
    await livesAndDies(renderer, scenes[0], material);
    await survivesRefusal(renderer, scenes[0], material);
    await refusesArguments(BTFMaterial, btf, otherBtf);
    renderer.dispose();
    btf.close();
};
