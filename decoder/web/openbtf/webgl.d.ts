/* OpenBTF in WebGL2: types and documentation of `openbtf/webgl`.
 *
 *     const material = await open(bytes);
 *     const textures = upload(gl, material);
 *     const text = '#version 300 es\n' + material.source() + yourShader; // which calls btf_evaluate
 *     ...
 *     textures.bind(program);
 *
 * Every call puts state of yours back, but for what bind() says that it sets. Errors of WebGL that were pending before
 * upload() and selfTest() are taken off its queue.
 *
 * SPDX-License-Identifier: MIT
 */
import type { Material, ShaderOptions } from './index.js';

/** The textures of a material in a context. Levels of detail are mip levels; nothing filters. */
export class Textures {
    private constructor();
    /** Of all texels uploaded, of all levels. */
    readonly bytes: number;
    /** A texture by its name in FORMAT.md, e.g. 'factor_texels'; null when it was not uploaded. */
    texture(name: string): WebGLTexture | null;
    /** Its target, TEXTURE_2D or TEXTURE_2D_ARRAY; null when it was not uploaded. */
    target(name: string): GLenum | null;
    /**
     * Points the samplers of a linked program at the textures. Sets the uniforms, and the bindings of units firstUnit and
     * following, where they stay until you bind others; sampler objects of these units are unbound. USAGE where the program
     * reads a texture that was not uploaded.
     * @param prefix as of the shader's options. Default 'btf'.
     * @returns how many units that are
     */
    bind(program: WebGLProgram, firstUnit?: number, prefix?: string): number;
    /** Deletes the textures. */
    destroy(): void;
}

/**
 * Uploads a material, which may be closed afterwards.
 * @param options only the textures that the shader of these options reads. Default: all.
 * UNSUPPORTED: no WebGL2, a lost context, or a texture that exceeds MAX_TEXTURE_SIZE or MAX_ARRAY_TEXTURE_LAYERS (the message
 * has both numbers); MEMORY: WebGL has none left. Nothing is left behind then.
 */
export function upload(gl: WebGL2RenderingContext, material: Material, options?: ShaderOptions): Textures;

/** Whether every texture that upload() would make is within the limits of the context; if not, that of toTight() may be. */
export function fits(gl: WebGL2RenderingContext, material: Material, options?: ShaderOptions): boolean;

/**
 * Tests whether this device adds, multiplies, converts and fetches as FORMAT.md section 8 demands. `failures` is 0 where
 * exact decoding works here; else `names` says which rules fail, e.g. 'contraction' (BTF_SELF_TEST_LIST of openbtf/shader.h).
 * 'levels', 'factors' and 'lists' matter only to materials of several levels of detail, of factors, of lists of points.
 * UNSUPPORTED: a shader or framebuffer that the context refuses.
 */
export function selfTest(gl: WebGL2RenderingContext): Promise<{ failures: number; names: string[] }>;
