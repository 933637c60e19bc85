/* OpenBTF in WebGPU: types and documentation of `openbtf/webgpu`. It uses the types of @webgpu/types, or of a TypeScript whose DOM
 * library has WebGPU.
 *
 *     const material = await open(bytes);
 *     const textures = await upload(device, material);
 *     const code = material.source({ language: 'wgsl' }) + yourShader; // which calls btf_evaluate
 *     const layout = device.createPipelineLayout({ bindGroupLayouts: [textures.layout] });
 *     ...
 *     pass.setBindGroup(0, textures.bindGroup);
 *
 * SPDX-License-Identifier: MIT
 */
import type { Material, ShaderOptions } from './index.js';

/** The textures of a material on a device. Levels of detail are mip levels; shaders read them by textureLoad alone. */
export class Textures {
    private constructor();
    /** Of all texels uploaded, of all levels. */
    readonly bytes: number;
    /** Textures at bindings firstBinding + their number, and the zero, at the bindings that source() writes. */
    readonly layout: GPUBindGroupLayout;
    /** The group that source() calls by option `group`: setBindGroup(group, bindGroup). */
    readonly bindGroup: GPUBindGroup;
    /** The entries that `layout` and `bindGroup` are made of, for a group of yours that has more in it. */
    readonly layoutEntries: GPUBindGroupLayoutEntry[];
    readonly entries: GPUBindGroupEntry[];
    /** A texture by its name in FORMAT.md, e.g. 'factor_texels'; null when it was not uploaded. */
    texture(name: string): GPUTexture | null;
    /** Destroys the textures; no command that reads them may be submitted any more. */
    destroy(): void;
}

/**
 * Uploads a material, which may be closed once the promise is kept.
 * @param options those of source(): only the textures that this shader reads, from binding firstBinding on. Default: all.
 * @param visibility GPUShaderStage bits. Default FRAGMENT | COMPUTE.
 * UNSUPPORTED: no GPUDevice, or more than its limits maxTextureDimension2D, maxTextureArrayLayers (256 unless more is
 * required) or maxSampledTexturesPerShaderStage (the message has both numbers); USAGE: a firstBinding whose last binding is
 * beyond 32 bits; MEMORY: WebGPU has none left. Nothing is left behind then, no error scope either.
 */
export function upload(device: GPUDevice, material: Material, options?: ShaderOptions, visibility?: GPUShaderStageFlags): Promise<Textures>;

/** Whether every texture that upload() would make is within the limits of the device; if not, that of toTight() may be. */
export function fits(device: GPUDevice, material: Material, options?: ShaderOptions): boolean;

/**
 * Tests whether this device adds, multiplies, converts and fetches as FORMAT.md section 8 demands, in a compute shader.
 * `failures` is 0 where exact decoding works here; else `names` says which rules fail, e.g. 'contraction' (BTF_SELF_TEST_LIST of
 * openbtf/shader.h). 'levels', 'factors' and 'lists' matter only to materials of several levels of detail, of factors, of lists
 * of points. UNSUPPORTED: a shader that the device refuses.
 */
export function selfTest(device: GPUDevice): Promise<{ failures: number; names: string[] }>;
