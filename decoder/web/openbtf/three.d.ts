/* OpenBTF in three.js: types and documentation of `openbtf/three`.
 *
 *     import { open } from 'openbtf';
 *     import { BTFMaterial } from 'openbtf/three';
 *
 *     const material = await open(await (await fetch('bricks.btf.exr')).arrayBuffer());
 *     scene.add(new Mesh(new SphereGeometry(1, 64, 32), new BTFMaterial(material, { repeat: 3 })));
 *
 * For WebGLRenderer of three 0.187; `openbtf/three-webgpu` is for its WebGPURenderer.
 *
 * SPDX-License-Identifier: MIT
 */
import type { Material as ThreeMaterial, MaterialParameters, Vector2, WebGLRenderer } from 'three';
import { ShaderMaterial } from 'three';
import type { DecodeOptions, Material } from './index.js';

/** As of MaterialParameters of three, e.g. `side`, and: */
export interface BTFMaterialOptions extends MaterialParameters {
    /** Copies of the material along the geometry's unit of u and of v, one number for both. Default 1. */
    repeat?: number | readonly [number, number];
    /** How to decode; `math` as of ShaderOptions. Default: everything, exact, three neighbouring directions, one texel. */
    decode?: DecodeOptions & { math?: 'exact' | 'fast' };
}

/**
 * A material of three.js that shows a BTF.
 *
 * Lights: directional, sun, point and spot lights, their shadows, cookies, distances and cones, as many as the scene has, are
 * three's; each is one decode a pixel. A light of three's intensity pi at normal incidence shows the material's own values, as
 * intensity 1 of btf-render does: three's lights give irradiance, and a white diffuse surface reflects 1 / pi of it. Light that
 * comes from everywhere (ambient, hemisphere, rectangular lights, light probes, environment maps) adds nothing: a BTF has no
 * closed form for it. Let several directional lights stand for it.
 *
 * Tone mapping, exposure, colour space, fog, clipping planes, skinning, morph targets, instances and batches are three's. So is `opacity`,
 * which acts where `transparent` is set; `alphaTest`, `alphaHash` and `vertexColors` do nothing.
 *
 * Geometry: needs `normal` and `uv`. With `tangent` (four numbers, as of computeTangents()) the frame of the surface is that of
 * the vertices, blended; without, it follows in each pixel from how uv lies on the triangle, so that it is slightly faceted.
 * Seen from behind (side: DoubleSide or BackSide) a surface is lit from there. Levels of detail follow from the derivatives of uv.
 *
 * Texture units: a material takes up to 13 of the 16 that every device has; what is left is for shadow maps and cookies.
 *
 * Errors are OpenBTFError of `openbtf`.
 */
export class BTFMaterial extends ShaderMaterial {
    /**
     * @param material open; it is read when the textures are uploaded, by the first render. It may be closed after that, and then
     *   a lost WebGL context does not come back.
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
     * Uploads the textures to the renderer's context now, once; rendering does so by itself. Of use before close(), or to see whether
     * the device can hold them: as upload() of `openbtf/webgl`, UNSUPPORTED or MEMORY.
     * @returns bytes of the textures
     */
    upload(renderer: WebGLRenderer): number;
    /** With textures of its own, so that a mesh more is better given the same material. */
    clone(): this;
    copy(source: ThreeMaterial): this;
    /** Deletes the textures in every context. The next render uploads them again. */
    dispose(): void;
}
