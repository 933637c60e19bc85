/* OpenBTF in three.js with its WebGPURenderer: a node material that three's own lights, shadows, tone mapping, fog and colour space act
 * on. three_webgpu.d.ts documents it. Three declares and binds the textures, as external ones that openbtf/webgpu has uploaded; the
 * decoder's WGSL is put behind its declarations.
 *
 * SPDX-License-Identifier: MIT
 */
import {
    BackSide, CodeNode, DoubleSide, ExternalTexture, FloatType, HalfFloatType, IntType, LightingModel, NearestFilter, NodeMaterial,
    NodeUpdateType, TSL, UnsignedIntType, Vector2,
} from 'three/webgpu';
import { OpenBTFError } from './module.js';
import { readOptions } from './three_options.js';
import { standIns, uploadAtOnce } from './webgpu_upload.js';

const {
    bool, frontFacing, modelViewMatrix, normalViewGeometry, positionView, positionViewDirection, tangentGeometry, tangentLocal, texture,
    uniform, uv, vec4, wgslFn,
} = TSL;

/* The level of detail at a place of the surface, and its tangent frame in the camera's space as (tangent, bitangent, normal). Seen
 * from behind, its normal is turned. A geometry without tangents gets them from where position and uv move between neighbouring
 * pixels: dp = dp/du du + dp/dv dv, solved for dp/du and dp/dv but for a positive factor. */
const LEVEL = `
fn openbtf_level(uv: vec2f) -> i32 {
    return i32(btf_level(dpdx(uv), dpdy(uv)) + 0.5);
}
`;
const FRAME = `
fn openbtf_frame(uv: vec2f, position: vec3f, normal: vec3f, given: vec4f, behind: bool) -> mat3x3f {
    let outward = normalize(normal);
    let px = dpdx(position);
    let py = dpdy(position);
    let ux = dpdx(uv);
    let uy = dpdy(uv);
    let turned = select(1.0, -1.0, ux.x * uy.y < uy.x * ux.y);
    var along = given.xyz;
    var handedness = given.w;
    if (dot(along, along) == 0.0) {
        along = turned * (px * uy.y - py * ux.y);
        handedness = dot(cross(outward, along), turned * (py * ux.x - px * uy.x));
    }
    let across = along - outward * dot(along, outward);
    let size = length(across);
    let axis = select(vec3f(0.0, 1.0, 0.0), vec3f(1.0, 0.0, 0.0), abs(outward.x) < 0.6);
    var tangent = normalize(axis - outward * dot(axis, outward));
    if (size > 0.0) {
        tangent = across / size;
    }
    let bitangent = cross(outward, tangent) * select(1.0, -1.0, handedness < 0.0);
    return mat3x3f(tangent, bitangent, select(outward, -outward, behind));
}
`;
/* To the viewer, in the frame. Interpolated normals look away at the silhouette. */
const VIEW = `
fn openbtf_view(frame: mat3x3f, direction: vec3f) -> vec3f {
    let view = direction * frame;
    return normalize(vec3f(view.xy, max(view.z, 0.001)));
}
`;
/* Radiance under one of three's lights: colour is the irradiance at normal incidence that arrives, shadows and distance included, and
 * btf_evaluate_level gives the radiance, cosine included, for an irradiance of pi. In shadow nothing is decoded: that is what costs. Nor is
 * anything where the device has refused the textures: then what is bound is no material. */
const DIRECT = `
fn openbtf_direct(uv: vec2f, level: i32, frame: mat3x3f, view: vec3f, direction: vec3f, colour: vec3f, present: u32) -> vec3f {
    if (present == 0u || all(colour == vec3f(0.0))) {
        return vec3f(0.0);
    }
    return btf_evaluate_level(uv, normalize(direction * frame), view, level) * colour * ${1 / Math.PI};
}
`;
/* What three takes a texture of each format for. */
const TYPES = {
    R8UI: UnsignedIntType, RG8UI: UnsignedIntType, RGBA8UI: UnsignedIntType, RGBA8I: IntType, RGBA16UI: UnsignedIntType,
    RGBA16F: HalfFloatType, RGBA32F: FloatType, RGBA32UI: UnsignedIntType,
};

/** The node of a texture that upload() gives later. Nearest filters: three makes no sampler for it. */
function textureNode({ name, format, isArray }) {
    const external = new ExternalTexture();
    Object.assign(external, { name, type: TYPES[format], isArrayTexture: isArray, minFilter: NearestFilter, magFilter: NearestFilter, generateMipmaps: false });
    return texture(external).setName(`btf_${name}`);
}

/* A line by which the decoder's text declares a texture or the zero. */
const DECLARATION = /^@group\(\d+\) @binding\(\d+\) var[^;]*;$/gm;

/** The decoder's text among three's: three declares what it binds, under names that it chooses. Before an object is drawn, the textures
 * of the device that draws it are put in place. */
class DecoderNode extends CodeNode {
    #text;
    #bound;
    #upload;

    static get type() {
        return 'DecoderNode';
    }

    /** @param bound [[name in the text, node]] */
    constructor(text, bound, upload) {
        super('', [], 'wgsl');
        this.updateBeforeType = NodeUpdateType.OBJECT;
        this.#text = text.replace(DECLARATION, '');
        this.#bound = bound;
        this.#upload = upload;
    }

    updateBefore({ renderer }) {
        this.#upload(renderer);
    }

    generate(builder) {
        const names = new Map(this.#bound.map(([name, node]) => [name, node.build(builder, 'property')]));
        const code = builder.getCodeFromNode(this, this.getNodeType(builder));
        code.code = this.#text.replace(/\bbtf_\w+/g, (name) => names.get(name) ?? name);
        return code.code;
    }
}

/** Radiance under each of three's lights, of which direct() is told one after the other. */
class Lighting extends LightingModel {
    #functions;
    #repeat;
    #present;
    #surface;

    constructor(functions, repeat, present) {
        super();
        this.#functions = functions;
        this.#repeat = repeat;
        this.#present = present;
    }

    start(builder) {
        const { level, frame, view } = this.#functions;
        const { side } = builder.material;
        const place = uv().mul(this.#repeat).toVar();
        const given = builder.geometry.hasAttribute('tangent')
            ? vec4(modelViewMatrix.mul(vec4(tangentLocal, 0)).xyz, tangentGeometry.w).toVarying()
            : vec4(0, 0, 0, 1);
        const axes = frame({
            uv: place, position: positionView, normal: normalViewGeometry, given,
            behind: side === DoubleSide ? frontFacing.not() : bool(side === BackSide),
        }).toVar();
        this.#surface = {
            uv: place, level: level({ uv: place }).toVar(), frame: axes,
            view: view({ frame: axes, direction: positionViewDirection }).toVar(),
        };
        super.start(builder);
    }

    direct({ lightDirection, lightColor, reflectedLight }) {
        reflectedLight.directDiffuse.addAssign(this.#functions.direct({
            ...this.#surface, direction: lightDirection, colour: lightColor, present: this.#present,
        }));
    }
}

/** The device of a renderer. */
function deviceOf(renderer) {
    if (renderer?.backend?.isWebGPUBackend !== true) {
        throw new OpenBTFError('UNSUPPORTED', renderer?.isWebGPURenderer
            ? 'renderer: it draws by WebGL here, not by WebGPU; openbtf/three is for WebGLRenderer'
            : 'renderer: not a WebGPURenderer; openbtf/three is for WebGLRenderer');
    }
    if (!renderer.backend.device) {
        throw new OpenBTFError('USAGE', 'renderer: it has no device yet; await renderer.init()');
    }
    return renderer.backend.device;
}

export class BTFMaterial extends NodeMaterial {
    #btf;
    #decode;
    #options;
    #functions;
    #list; // of the textures: name, format, isArray
    #externals; // by name
    #repeat;
    #present = uniform(1, 'uint'); // 0 while stand-ins are shown
    #uploads = new Map(); // by device, see #start()
    #shown; // the textures that #externals hold now
    #reference = new WeakRef(this);
    static #references = new WeakMap(); // by device: those of the materials that have textures on it

    static get type() {
        return 'BTFMaterial';
    }

    constructor(btf, options) {
        const { repeat, decode, parameters } = readOptions(options);
        super();
        this.#btf = btf;
        this.#decode = decode;
        this.#options = { ...decode, language: 'wgsl' };
        const list = btf.readTextures(this.#options).filter(({ level }) => level === 0);
        const nodes = list.map((read) => [`btf_${read.name}`, textureNode(read)]);
        this.#list = list.map(({ name, format, isArray }) => ({ name, format, isArray }));
        this.#externals = new Map(list.map(({ name }, i) => [name, nodes[i][1].value]));
        this.#repeat = uniform(new Vector2(...repeat));
        // a property, so that three tells two materials apart
        this.decoderNode = new DecoderNode(btf.source(this.#options), [...nodes, ['btf_zero', uniform(0, 'uint').setName('btf_zero')]],
            (renderer) => this.#show(deviceOf(renderer)));
        this.#functions = Object.fromEntries(Object.entries({ level: LEVEL, frame: FRAME, view: VIEW, direct: DIRECT })
            .map(([name, text]) => [name, wgslFn(text, [this.decoderNode])]));
        this.colorNode = vec4(0, 0, 0, 1); // nothing reads it but its opacity
        this.lights = true;
        this.setValues(parameters);
    }

    get btf() {
        return this.#btf;
    }

    get decode() {
        return this.#decode;
    }

    get repeat() {
        return this.#repeat.value;
    }

    setup(builder) {
        deviceOf(builder.renderer);
        super.setup(builder);
    }

    setupLightingModel() {
        return new Lighting(this.#functions, this.#repeat, this.#present);
    }

    /** Puts the textures of a device in place. Nothing is uploaded where that has failed before. */
    #show(device) {
        const held = this.#uploads.get(device) ?? this.#start(device);
        if (this.#shown !== held.textures) {
            this.#shown = held.textures;
            this.#present.value = held.failed ? 0 : 1;
            this.#externals.forEach((external, name) => { external.sourceTexture = held.textures.texture(name); });
        }
        return held;
    }

    /** Uploads the textures: { textures, settled: a promise as of uploadAtOnce(), failed, awaited: whether a caller learns of a failure }. */
    #start(device) {
        const held = { textures: null, settled: null, failed: false, awaited: false };
        try {
            [held.textures, held.settled] = uploadAtOnce(device, this.#btf, this.#options, GPUShaderStage.FRAGMENT);
        } catch (error) {
            Object.assign(held, { textures: standIns(device, this.#list), settled: Promise.reject(error), failed: true });
        }
        held.settled.catch((error) => this.#fail(device, held, error));
        this.#uploads.set(device, held);
        BTFMaterial.#referencesOn(device).add(this.#reference);
        return held;
    }

    /** Has stand-ins drawn from now on, and says so once. Textures that the device refused would take the whole picture with them. */
    #fail(device, held, { message }) {
        if (this.#uploads.get(device) !== held) {
            return; // disposed of meanwhile, or the device is lost
        }
        if (!held.failed) {
            Object.assign(held, { textures: standIns(device, this.#list), failed: true });
            this.#forget();
        }
        if (!held.awaited) {
            console.error(`openbtf/three-webgpu: a material is drawn black: ${message}`);
        }
    }

    /** References to the materials that have textures on a device, which are dropped when it is lost. Its promise keeps what reacts to it as
     * long as the device is there: so one function does for all materials, and keeps none of them. */
    static #referencesOn(device) {
        const references = BTFMaterial.#references.get(device) ?? new Set();
        if (!BTFMaterial.#references.has(device)) {
            BTFMaterial.#references.set(device, references);
            device.lost.then(() => references.forEach((reference) => reference.deref()?.#drop(device)));
        }
        references.forEach((reference) => reference.deref() ?? references.delete(reference));
        return references;
    }

    async upload(renderer) {
        const device = deviceOf(renderer);
        if (this.#uploads.get(device)?.failed) {
            this.#drop(device);
            this.#forget();
        }
        const held = this.#show(device);
        held.awaited = true;
        await held.settled;
        return held.textures.bytes;
    }

    #drop(device) {
        this.#uploads.get(device)?.textures.destroy();
        this.#uploads.delete(device);
        BTFMaterial.#references.get(device)?.delete(this.#reference);
        this.#shown = undefined;
    }

    /** Has three forget what it holds of the material, and ask for its textures again. */
    #forget() {
        super.dispose();
        this.#externals.forEach((external) => external.dispose());
    }

    clone() {
        return new this.constructor(this.#btf, { decode: this.#decode }).copy(this);
    }

    copy(source) {
        const { decoderNode } = this;
        super.copy(source);
        this.decoderNode = decoderNode;
        if (source.repeat) {
            this.repeat.copy(source.repeat);
        }
        return this;
    }

    dispose() {
        this.#forget();
        Array.from(this.#uploads.keys()).forEach((device) => this.#drop(device));
    }
}
