/* OpenBTF in three.js with its WebGPURenderer: types and documentation of `openbtf/three-webgpu`.
 *
 *     import { open } from 'openbtf';
 *     import { BTFMaterial } from 'openbtf/three-webgpu';
 *
 *     const material = await open(await (await fetch('bricks.btf.exr')).arrayBuffer());
 *     scene.add(new Mesh(new SphereGeometry(1, 64, 32), new BTFMaterial(material, { repeat: 3 })));
 *
 * For WebGPURenderer of three 0.187 where it draws by WebGPU; `openbtf/three` is for WebGLRenderer. Without a bundler an import map has
 * to say where `three` and `three/webgpu` are: both are build/three.webgpu.js.
 *
 * SPDX-License-Identifier: MIT
 */
import type { Material as ThreeMaterial, Vector2 } from 'three';
import { NodeMaterial } from 'three/webgpu';
import type { WebGPURenderer } from 'three/webgpu';
import type { DecodeOptions, Material } from './index.js';
import type { BTFMaterialOptions } from './three.js';

export type { BTFMaterialOptions } from './three.js';

/**
 * A node material of three.js that shows a BTF, by the WGSL of the library.
 *
 * Lights, tone mapping, fog, geometry, intensities and levels of detail are as BTFMaterial of `openbtf/three` documents them: the two
 * draw the same picture of what is opaque. What is transparent three's two renderers blend apart: WebGPURenderer in linear values,
 * before the tone is mapped, WebGLRenderer after. `alphaTest` and `alphaHash` act here. Nodes of NodeMaterial that move vertices, cut
 * fragments or change what comes out act here too, e.g. `positionNode`, `maskNode`, `outputNode`; those that say what a surface is made
 * of, such as `colorNode` and `normalNode`, do not.
 *
 * WebGPURenderer looks at which attributes a geometry has when it first draws it: computeTangents() belongs in front of that. It keeps
 * a picture in halves, of which the largest is 65504, until the tone is mapped; where a light and a material exceed that,
 * `new WebGPURenderer({ outputBufferType: FloatType })` draws it; what is transparent then needs a device with float32-blendable.
 *
 * Textures: a material takes up to 13 of the 16 that WebGPU lets a shader have; what is left is for shadow maps and cookies.
 *
 * Where the textures of a material cannot be uploaded while a scene is rendered, render() throws nothing: the material is drawn black,
 * the browser's console says why, once, and nothing is uploaded again before upload() or dispose(). Who awaits upload() first gets the
 * error.
 *
 * Errors are OpenBTFError of `openbtf`.
 */
export class BTFMaterial extends NodeMaterial {
    /**
     * @param material open; it is read when the textures are uploaded, by the first render. It may be closed after that.
     * USAGE: an option that is unknown or wrong, a material that is closed.
     */
    constructor(material: Material, options?: BTFMaterialOptions);
    /** The material that it shows. */
    readonly btf: Material;
    /** As given. */
    readonly decode: Readonly<DecodeOptions & { math?: 'exact' | 'fast' }>;
    /** Copies along u and v, which may be changed. */
    readonly repeat: Vector2;
    /**
     * Uploads the textures to the renderer's device now, once; rendering does so by itself. Of use before close(), or to see whether
     * the device can hold them: as upload() of `openbtf/webgpu`, UNSUPPORTED or MEMORY. After a failure it tries again. UNSUPPORTED,
     * too, of a WebGPURenderer that draws by WebGL since it found no WebGPU; USAGE of one that has not been initialised (await
     * renderer.init()).
     * @returns bytes of the textures, once the device has taken them
     */
    upload(renderer: WebGPURenderer): Promise<number>;
    /** With textures of its own, so that a mesh more is better given the same material. */
    clone(): this;
    copy(source: ThreeMaterial): this;
    /** Destroys the textures on every device. The next render uploads them again. */
    dispose(): void;
}
