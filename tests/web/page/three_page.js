/* openbtf/three: compares scenes of scenes.mjs that three.js draws with the pictures that btf-render drew of them.
 *
 * SPDX-License-Identifier: MIT
 */
import * as THREE from 'three';
import { open } from '/package/index.js';
import { BTFMaterial } from '/package/three.js';
import { bytes, report } from './post.js';
import { build, compareOpacity, compareScenes, compareSpot, compareTwo, drawn, near, refusesArguments } from './three_scenes.js';

/** Textures are uploaded once, deleted, uploaded again, and come back after a lost context. */
async function livesAndDies(renderer, scene, material) {
    const gl = renderer.getContext();
    const count = (body) => {
        let made = 0;
        const create = gl.createTexture;
        gl.createTexture = () => { made += 1; return create.call(gl); };
        body();
        delete gl.createTexture;
        return made;
    };
    const world = build(scene, material);
    const first = drawn(renderer, scene, world);
    await report('three: textures are uploaded once', count(() => drawn(renderer, scene, world)) === 0 ? '' : 'and again');
    const held = material.uniforms.btf_sbrdf.value.sourceTexture;
    material.dispose();
    await report('three: dispose deletes the textures', gl.isTexture(held) ? 'one is left' : '');
    const copy = material.clone();
    await near('a clone', drawn(renderer, scene, build(scene, copy)), first, 0);
    copy.dispose();
    await near('after dispose', drawn(renderer, scene, world), first, 0);
    const extension = gl.getExtension('WEBGL_lose_context');
    const event = (name) => new Promise((resolve) => { renderer.domElement.addEventListener(name, resolve, { once: true }); });
    const [lost, restored] = [event('webglcontextlost'), event('webglcontextrestored')];
    extension.loseContext();
    await lost;
    await new Promise((resolve) => { setTimeout(resolve); }); // a context is restored in a task of its own
    extension.restoreContext();
    await restored;
    await near('after a lost context', drawn(renderer, scene, build(scene, material)), first, 0);
    await report('three: no WebGL error', gl.getError() ? `0x${gl.getError().toString(16)}` : '');
}

window.runThree = async ({ material: name, other, scenes, side }) => {
    const btf = await open(await bytes(`/golden/${name}`)), otherBtf = await open(await bytes(`/golden/${other}`));
    const renderer = new THREE.WebGLRenderer({ preserveDrawingBuffer: true });
    renderer.setSize(side, side, false);
    const material = new BTFMaterial(btf, { decode: { filter: 'bilinear' } });
    await compareScenes(renderer, material, scenes);
    await compareSpot(renderer, material, scenes.find(({ name: of }) => of === 'shadow of a point'));
    const above = { ...scenes[0], view: [0, 0] };
    await compareTwo(renderer, above, material, new BTFMaterial(otherBtf, { decode: { filter: 'bilinear' }, repeat: 2 }));
    await compareOpacity(renderer, scenes[0], material);
    await livesAndDies(renderer, scenes[0], material);
    await refusesArguments(BTFMaterial, btf, otherBtf);
    renderer.dispose();
    btf.close();
};
