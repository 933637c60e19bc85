/* OpenBTF in JavaScript: types and documentation of `openbtf`.
 *
 * Directions are unit vectors of the tangent frame (x along +u, y along +v, z the normal), to the viewer and to the light.
 * Texture coordinates: (0, 0) is the lower left corner of the image, which repeats beyond [0, 1). Colours are linear Rec. 709.
 *
 * SPDX-License-Identifier: MIT
 */

/** Name of a result code of the library. */
export type Code = 'USAGE' | 'IO' | 'BAD_FILE' | 'INTERNAL' | 'MEMORY' | 'UNSUPPORTED' | 'DIFFERENT' | 'INTERRUPTED';

/**
 * A call that failed. `message` is the library's, e.g. "part sbrdf: missing".
 *
 * USAGE: an argument, which the message names. BAD_FILE: not a material, or damaged. UNSUPPORTED: a material of a newer
 * version, a device that cannot. MEMORY: none left. IO: the WebAssembly module could not be fetched. INTERNAL: a defect; the
 * module cannot be used any more.
 */
export class OpenBTFError extends Error {
    readonly name: 'OpenBTFError';
    /** The result code by name. */
    readonly code: Code;
    /** The result code by number (openbtf/result.h). */
    readonly result: number;
    constructor(code: Code, message: string);
}

/** Effects: parts of the model that a file may hold and a decoder may leave out. */
export type Effect = 'shadow' | 'shift' | 'hidden' | 'gain' | 'residual' | 'relief' | 'gloss';

/** A direction: three numbers, a unit vector. */
export type Direction = readonly [number, number, number] | Float32Array;

/** How to decode. */
export interface DecodeOptions {
    /** Effects not to decode. Default: none, all that the file has are decoded. */
    leaveOut?: readonly Effect[];
    /** At most so many components of the residual, or units, where its store is factors. Default 0: all. */
    components?: number;
    /** Directions: three neighbouring views and lights, blended (default), or the nearest. */
    interpolation?: 'linear' | 'nearest';
    /** Texels: the one that holds uv (default), four blended, or four with weights that leave a texel's middle half to itself. */
    filter?: 'texel' | 'bilinear' | 'steep';
}

/** How to decode in a shader. */
export interface ShaderOptions extends DecodeOptions {
    /** Arithmetic: the same bits on every device (default), or the device's own log2, exp2 and order. */
    math?: 'exact' | 'fast';
    /** The shader enables an extension that brings `precise`. WebGL2 has none. Default false. */
    havePrecise?: boolean;
    /** Of all names, so that two materials fit one program: lower-case letters, digits, single underscores. Default 'btf'. */
    prefix?: string;
    /** The one direction to the viewer that the shader will be handed. Its neighbours become constants. */
    fixedView?: Direction;
    /** Likewise to the light. */
    fixedLight?: Direction;
    /**
     * Neighbours of which one is picked at random in place of blending all. Other than 'none' (default),
     * btf_evaluate_stochastic(uv, l, v, random) stands in place of btf_evaluate.
     */
    picks?: 'none' | 'view' | 'light' | 'all';
    /** GLSL for WebGL2 (default), or WGSL for WebGPU, which has the same functions. */
    language?: 'glsl' | 'wgsl';
    /** Of WGSL: the group of its resources. Default 0. */
    group?: number;
    /** Of WGSL: the binding of its first texture. The decoder takes 24 numbers from there on. Default 0. */
    firstBinding?: number;
}

/** How to evaluate. */
export interface EvaluateOptions extends DecodeOptions {
    /** Level of detail, 0 the finest (default); beyond the last it is the last. */
    level?: number;
    /** By the reference decoder, one by one. Default false: by the library, which is faster and gives the same bits. */
    reference?: boolean;
    /** As of ShaderOptions, by the reference decoder; then `random` is needed. */
    picks?: 'none' | 'view' | 'light' | 'all';
    /** [count][3] random numbers of 32 bits: of the view, the light, the texel. */
    random?: Uint32Array | readonly number[];
}

/** Which directions occur. Without members: all. */
export interface Range {
    /** Least and greatest elevation from the normal, degrees within 0..90. */
    theta?: readonly [number, number];
    /** Azimuths, counter-clockwise from the first to the second, degrees within -360..360; equal: all. */
    phi?: readonly [number, number];
    /** This direction alone; theta and phi are not read. */
    direction?: Direction;
}

/** From where a material is seen and lit. Without members: anything, one light, a texel a pixel. */
export interface Scene {
    view?: Range;
    light?: Range;
    /** Side of a texel on the screen in pixels, where it is largest. Default 1. */
    pixels?: number;
    /** Evaluations a pixel. Default 1. */
    lights?: number;
    /** true: never nearest directions, which jump when view or light move. */
    interpolate?: boolean;
}

/** How to decode a scene, and what that costs. PSNR in dB over the directions of the scene, as the encoder measured it. */
export interface Plan {
    /** For source() and upload() of the material and of its restriction. */
    readonly shader: ShaderOptions;
    readonly effects: readonly Effect[];
    /** Of the residual decoded; units, where its store is factors. */
    readonly components: number;
    /** Of detail; finer ones are not needed. */
    readonly level: number;
    /** Sampled directions that the scene can reach. */
    readonly views: number;
    readonly lights: number;
    /** Bytes of the restricted material's textures, and of the whole one's. */
    readonly gpuBytes: number;
    readonly fullGpuBytes: number;
    /** Nanoseconds a pixel of the machine that the model was fitted on: only the ratio means something. */
    readonly cost: number;
    readonly fullCost: number;
    /** false: the file has no table of errors; everything is decoded, PSNR is 0. */
    readonly measured: boolean;
    readonly psnrLinear: number;
    readonly psnrSrgb: number;
    readonly fullPsnrLinear: number;
    readonly fullPsnrSrgb: number;
    /** Between the samples, estimated; 0 where the file has no such table. */
    readonly betweenPsnrLinear: number;
    readonly betweenPsnrSrgb: number;
    readonly fullBetweenPsnrLinear: number;
    readonly fullBetweenPsnrSrgb: number;
}

/** One row of the errors that the encoder measured, dB over all samples clipped to [0, 1]. */
export interface MaterialError {
    readonly psnrLinear: number;
    readonly psnrSrgb: number;
    /** Of the textures that are read. */
    readonly gpuBytes: number;
}

/** The properties of a material: btf_material_info of openbtf/material.h, which explains each. */
export interface Info {
    /** The oldest version of the format that holds the material. */
    readonly version: number;
    /** Texels of level 0. */
    readonly width: number;
    readonly height: number;
    /** Sampled directions. */
    readonly viewCount: number;
    readonly lightCount: number;
    /** Levels of detail, at least 1. */
    readonly levels: number;
    readonly layout: 'paper' | 'tight';
    readonly domain: 'linear' | 'sqrt';
    readonly colour: 'mono' | 'rgb' | 'none';
    readonly blend: 'radiance' | 'roots';
    readonly halfFloat: boolean;
    readonly lobes: number;
    readonly effects: readonly Effect[];
    readonly centres: number;
    readonly store: 'components' | 'factors';
    readonly components: number;
    /** Of each of five classes: units, words of C1, words of C2. */
    readonly factorClasses: readonly (readonly [number, number, number])[];
    readonly pointStore: 'separate' | 'packed' | 'lists';
    readonly pointEntries: number;
    readonly radianceScale: number;
    readonly shadowScale: number;
    readonly gainScale: number;
    readonly centreScale: number;
    readonly horizonScale: number;
    readonly gainBase: number;
    readonly gainStep: number;
    readonly reliefBase: number;
    readonly reliefStep: number;
    readonly reliefSteps: number;
    readonly reliefLevel: number;
    readonly reliefEnd: number;
    readonly glossShare: number;
    readonly atlasWidth: number;
    readonly atlasHeight: number;
    /** Of all textures of all levels but those that tableBytes counts. */
    readonly gpuBytes: number;
    /** Of direction tables, view_vectors, and scales of the residual. */
    readonly tableBytes: number;
    /** The encoder's method, its options, and the data set; '' when not given. */
    readonly method: string;
    readonly options: string;
    readonly source: string;
    /** By effects decoded, and by level of detail; empty when not measured. */
    readonly errors: readonly (MaterialError & { readonly effects: readonly Effect[] })[];
    readonly levelErrors: readonly (MaterialError & { readonly level: number })[];
    /**
     * The encoder's estimate of the error between the samples, over all elevations (btf_between_errors of openbtf/material.h): what
     * was left out and predicted, and effects that were not decoded. Neighbours are twice as far away then as for a direction between
     * samples, so that PSNR, in dB, is understated. Empty when not estimated.
     */
    readonly betweenErrors: readonly {
        /** Of detail. */
        readonly level: number;
        readonly leftOut: 'view' | 'light' | 'both';
        readonly without: readonly ('relief' | 'gloss')[];
        readonly psnrLinear: number;
        readonly psnrSrgb: number;
    }[];
}

/** A texture of FORMAT.md section 3, ready to upload. */
export interface Texture {
    /** e.g. 'factor_texels'; the sampler is named 'btf_' and this. */
    readonly name: string;
    /** Of detail: the mip level to upload it to. */
    readonly level: number;
    readonly format: 'R8UI' | 'RG8UI' | 'RGBA8UI' | 'RGBA8I' | 'RGBA16UI' | 'RGBA16F' | 'RGBA32F' | 'RGBA32UI';
    /** true: a 2D array texture, also with one layer. */
    readonly isArray: boolean;
    readonly width: number;
    readonly height: number;
    readonly layers: number;
    readonly channels: number;
    /** [layer][row][column][channel], tightly packed, row 0 the top of the image. Halves (RGBA16F) as their bits. */
    readonly data: Uint8Array | Int8Array | Uint16Array | Uint32Array | Float32Array;
}

/** An open material. It holds memory of the module until close(). Calls on a closed one throw USAGE. */
export class Material {
    private constructor();
    readonly closed: boolean;
    /** Frozen; made when it is first read. */
    readonly info: Info;
    /** A copy of the sampled directions to the viewer, [viewCount][3]. */
    readonly views: Float32Array;
    /** Likewise to the light, [lightCount][3]. */
    readonly lights: Float32Array;
    /**
     * Copies of textures, those of a name together by rising level.
     * @param options only those that the shader of these options reads, with as much of the residual. Default: all.
     */
    textures(options?: ShaderOptions): Texture[];
    /**
     * The text that decodes the material, in GLSL a library without #version, main, and names but those with the prefix. It goes
     * behind `#version 300 es` and in front of everything else of yours. Then call
     * `vec3 btf_evaluate(vec2 uv, vec3 l, vec3 v)` or `vec3 btf_evaluate_level(vec2 uv, vec3 l, vec3 v, int level)`: radiance,
     * cosine included, for an irradiance of pi at normal incidence. Leave the uniform `btf_zero` unset: it must be 0.
     * With `language: 'wgsl'` it is the same in WGSL, `fn btf_evaluate(uv: vec2f, l: vec3f, v: vec3f) -> vec3f`, for anywhere in
     * a module; openbtf/webgpu gives the bind group that it reads.
     */
    source(options?: ShaderOptions): string;
    /**
     * The cheapest way to decode a scene within a tolerance.
     * @param tolerance dB below the full decode where the scene looks. Default 0.5.
     */
    plan(scene?: Scene, tolerance?: number): Plan;
    /** PSNR that the file predicts for the scene of a plan decoded with other effects. UNSUPPORTED: it was not measured. */
    predict(plan: Plan, effects: readonly Effect[], components?: number): { psnrLinear: number; psnrSrgb: number };
    /** A material with only what a plan reads; the same bits within its scene. To be closed as well. */
    restrict(plan: Plan): Material;
    /** A copy in layout tight, for devices whose textures are too small for the atlas of layout paper. To be closed as well. */
    toTight(): Material;
    /**
     * Radiance.
     * @param uv [count][2] texture coordinates
     * @param light [count][3] directions to the light, or [3], one for all
     * @param view [count][3] directions to the viewer, or [3], one for all
     * @returns [count][3] linear Rec. 709, cosine included, for an irradiance of pi at normal incidence; 0 below the horizon
     */
    evaluate(uv: Float32Array | readonly number[], light: Float32Array | readonly number[],
        view: Float32Array | readonly number[], options?: EvaluateOptions): Float32Array;
    /** Frees the material's memory. A second time it does nothing. */
    close(): void;
}

/**
 * Loads the WebAssembly module, once; open() does so by itself. Call it first to say where the module is.
 * @param source a URL, a Response, the bytes, or a compiled module. Default: openbtf.wasm beside the script.
 */
export function load(source?: string | URL | Response | ArrayBuffer | ArrayBufferView | WebAssembly.Module): Promise<void>;

/** Opens the bytes of a *.btf.exr file, which are copied. BAD_FILE, UNSUPPORTED or MEMORY where that fails. */
export function open(data: ArrayBuffer | ArrayBufferView): Promise<Material>;

/** Bytes of the module's memory in all. It grows with what is open, is used again, and never shrinks. */
export function memoryBytes(): number;
