/* Draws a material on a model, in samples: a draft while something moves, then one after the other in the picture's own size, whose
 * mean is shown. A sample may be drawn in bands, so that a slow device stays usable.
 *
 * SPDX-License-Identifier: MIT
 */
import { fits, upload } from '../openbtf/webgl.js';
import { camera, direction } from './camera.js';
import { Sampler, madeEnvironment, shrunk } from './environment.js';
import { VERTEX_FLOATS, mesh } from './meshes.js';
import { Programs } from './programs.js';
import { MEAN_FRAGMENT, MODEL_VERTEX, MOST_LIGHTS, PICTURE_FRAGMENT, SCREEN_VERTEX, modelFragment } from './shaders.js';
import { Targets } from './targets.js';

/** Lights of an environment in one sample. */
const ENVIRONMENT_LIGHTS = 4;

const halton = (index, base) => {
    let [result, share] = [0, 1];
    for (let i = index; i > 0; i = Math.floor(i / base)) {
        share /= base;
        result += share * (i % base);
    }
    return result;
};

/** Options of the shader of a state; `out` are the effects left out. */
export function shaderOptions(state, out = state.out) {
    return { leaveOut: out, components: state.units, interpolation: state.interpolation, filter: state.filter, math: state.math,
        picks: state.picks };
}

/** The effects that the right part of a split picture leaves out; null where the picture is not split. */
export function comparedOut(state, info) {
    switch (state.compare) {
    case 'off':
        return null;
    case 'full':
        return [];
    case 'bare': // where there is no SBRDF the residual is the material
        return info.effects.filter((effect) => effect !== 'residual' || info.colour !== 'none');
    default:
        return info.effects.includes(state.compare) ? [...new Set([...state.out, state.compare])] : null;
    }
}

export class Renderer {
    #gl;
    #programs;
    #fixed; // programs that every material uses
    #targets;
    #material;
    #textures;
    #mesh = {};
    #environments = new Map(); // by name: { image, texture, sampler }
    #view; // of the latest sample
    #empty;

    constructor(gl) {
        this.#gl = gl;
        this.#programs = new Programs(gl);
        this.#fixed = new Programs(gl);
        this.#targets = new Targets(gl);
        this.#empty = gl.createVertexArray();
        gl.getExtension('OES_texture_float_linear');
    }

    get gl() {
        return this.#gl;
    }

    /** Whether means of several samples can be drawn here. */
    get floats() {
        return this.#targets.floats;
    }

    get hasMaterial() {
        return Boolean(this.#textures);
    }

    /** Bytes of the material's textures. */
    get textureBytes() {
        return this.#textures?.bytes ?? 0;
    }

    /**
     * Shows another material, which stays open and is the caller's. Where it does not fit, as OpenBTFError says, the former stays.
     * @returns the material that is drawn: the given one, or the same in layout tight where that alone fits, to be closed by the caller
     */
    setMaterial(material) {
        const apart = material.info.layout === 'paper' && !fits(this.#gl, material) ? material.toTight() : null;
        let textures;
        try {
            textures = upload(this.#gl, apart ?? material);
        } catch (error) {
            apart?.close();
            throw error;
        }
        this.#textures?.destroy();
        this.#programs.clear();
        this.#textures = textures;
        this.#material = apart ?? material;
        return this.#material;
    }

    #useMesh(name) {
        const gl = this.#gl;
        if (this.#mesh.name === name) {
            return;
        }
        const { vertices, triangles } = mesh(name);
        gl.deleteVertexArray(this.#mesh.array ?? null);
        this.#mesh.buffers?.forEach((buffer) => gl.deleteBuffer(buffer));
        const array = gl.createVertexArray(), buffers = [gl.createBuffer(), gl.createBuffer()];
        gl.bindVertexArray(array);
        gl.bindBuffer(gl.ARRAY_BUFFER, buffers[0]);
        gl.bufferData(gl.ARRAY_BUFFER, vertices, gl.STATIC_DRAW);
        gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffers[1]);
        gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, triangles, gl.STATIC_DRAW);
        [[3, 0], [3, 3], [2, 6], [3, 8]].forEach(([size, offset], index) => {
            gl.enableVertexAttribArray(index);
            gl.vertexAttribPointer(index, size, gl.FLOAT, false, 4 * VERTEX_FLOATS, 4 * offset);
        });
        this.#mesh = { name, array, buffers, count: triangles.length };
    }

    /** Sets the user's own environment, {width, height, pixels} as of hdr.js. */
    setOwnEnvironment(image) {
        this.#forgetEnvironment('own');
        this.#addEnvironment('own', shrunk(image));
    }

    /** The user's own environment, no wider than it is drawn; null where there is none. */
    get ownEnvironment() {
        return this.#environments.get('own')?.image ?? null;
    }

    #forgetEnvironment(name) {
        this.#gl.deleteTexture(this.#environments.get(name)?.texture ?? null);
        this.#environments.delete(name);
    }

    #addEnvironment(name, image) {
        const gl = this.#gl, { width, height, pixels } = image;
        const rgba = new Float32Array(4 * width * height);
        for (let i = 0; i < width * height; i++) {
            for (let c = 0; c < 3; c++) {
                const value = pixels[3 * i + c];
                rgba[4 * i + c] = value > 0 ? Math.min(value, 60000) : 0; // halves reach 65504
            }
        }
        const texture = gl.createTexture();
        gl.activeTexture(gl.TEXTURE0);
        gl.bindTexture(gl.TEXTURE_2D, texture);
        gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA16F, width, height, 0, gl.RGBA, gl.FLOAT, rgba);
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.REPEAT);
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
        this.#environments.set(name, { image, texture, sampler: new Sampler(image) });
    }

    #environment(state) {
        const name = state.environment;
        if (name === 'none' || (name === 'own' && !this.#environments.has('own'))) {
            return null;
        }
        if (!this.#environments.has(name)) {
            this.#addEnvironment(name, madeEnvironment(name));
        }
        return this.#environments.get(name);
    }

    #lights(state, number) {
        const lights = state.sun > 0 ? [{ at: direction(state.lightTheta, state.lightPhi), colour: [state.sun, state.sun, state.sun] }] : [];
        const environment = this.#environment(state);
        if (environment && state.strength > 0) {
            for (const { at, colour } of environment.sampler.lights(number, ENVIRONMENT_LIGHTS, state.turn)) {
                lights.push({ at, colour: colour.map((x) => x * state.strength) });
            }
        }
        return lights.slice(0, MOST_LIGHTS);
    }

    #program(state, out) {
        const options = shaderOptions(state, out);
        return this.#programs.get(JSON.stringify(options), () => [MODEL_VERTEX, modelFragment(this.#material.source(options), state.picks)]);
    }

    /** Begins to compile what a state needs. @returns whether all is there. Throws where it cannot be. */
    prepare(state) {
        const outs = [state.out, comparedOut(state, this.#material.info)].filter(Boolean);
        const programs = outs.map((out) => this.#program(state, out));
        if (!programs.every((program) => program.ready)) {
            return false;
        }
        programs.forEach((program) => program.finish());
        return true;
    }

    #drawModel(state, out, width, height, number, view) {
        const gl = this.#gl, program = this.#program(state, out).finish();
        const lights = this.#lights(state, number);
        gl.useProgram(program.program);
        this.#textures.bind(program.program, 1);
        gl.uniformMatrix4fv(program.at('view_to_clip'), false, view.matrix);
        gl.uniform3fv(program.at('eye'), view.eye);
        gl.uniform1f(program.at('repeat'), state.repeat);
        gl.uniform1i(program.at('number'), number);
        gl.uniform1i(program.at('level'), state.level < 0 ? -1 : Math.min(state.level, this.#material.info.levels - 1));
        gl.uniform1i(program.at('lights'), lights.length);
        if (lights.length) {
            gl.uniform3fv(program.at('light_at'), lights.flatMap(({ at }) => at));
            gl.uniform3fv(program.at('light_colour'), lights.flatMap(({ colour }) => colour));
        }
        gl.drawElements(gl.TRIANGLES, this.#mesh.count, gl.UNSIGNED_SHORT, 0);
    }

    /**
     * Draws rows [from, to) of a sample of `width` x `height` pixels into the sample's target; prepare() came before.
     * @param number of the sample; each lies elsewhere in its pixel and has other lights of the environment
     */
    drawSample(state, width, height, number, from = 0, to = height) {
        const gl = this.#gl;
        const shift = number ? [halton(number, 2) - 0.5, halton(number, 3) - 0.5] : [0, 0];
        const view = camera(state, width, height, shift);
        this.#view = view;
        this.#useMesh(state.mesh);
        gl.bindFramebuffer(gl.FRAMEBUFFER, this.#targets.sample.framebuffer);
        gl.viewport(0, 0, width, height);
        gl.enable(gl.SCISSOR_TEST);
        gl.scissor(0, from, width, to - from);
        gl.clearColor(0, 0, 0, 0);
        gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
        gl.enable(gl.DEPTH_TEST);
        gl.bindVertexArray(this.#mesh.array);
        const compared = comparedOut(state, this.#material.info);
        const middle = compared ? Math.round(state.split * width) : width;
        for (const [out, left, right] of [[state.out, 0, middle], [compared, middle, width]]) {
            if (right > left && out) {
                gl.scissor(left, from, right - left, to - from);
                this.#drawModel(state, out, width, height, number, view);
            }
        }
        gl.disable(gl.SCISSOR_TEST);
        gl.disable(gl.DEPTH_TEST);
    }

    #screen(name, fragment) {
        const program = this.#fixed.get(name, () => [SCREEN_VERTEX, fragment]).finish();
        this.#gl.useProgram(program.program);
        this.#gl.bindVertexArray(this.#empty);
        return program;
    }

    #bind(unit, texture) {
        const gl = this.#gl;
        gl.activeTexture(gl.TEXTURE0 + unit);
        gl.bindTexture(gl.TEXTURE_2D, texture);
        gl.bindSampler(unit, null);
    }

    /** Adds the sample, number 0 being the first, to the mean. */
    accumulate(number) {
        const gl = this.#gl, program = this.#screen('mean', MEAN_FRAGMENT);
        this.#bind(0, this.#targets.mean.texture);
        this.#bind(1, this.#targets.sample.texture);
        gl.bindFramebuffer(gl.FRAMEBUFFER, this.#targets.nextMean().framebuffer);
        gl.viewport(0, 0, this.#targets.width, this.#targets.height);
        gl.uniform1i(program.at('mean'), 0);
        gl.uniform1i(program.at('latest'), 1);
        gl.uniform1f(program.at('share'), 1 / (number + 1));
        gl.drawArrays(gl.TRIANGLES, 0, 3);
    }

    /** Makes the targets fit a picture. @returns whether what was drawn is lost. */
    resize(width, height) {
        return this.#targets.resize(width, height);
    }

    /** Shows the mean, or, as a draft, the lower left width x height pixels of the sample, enlarged. */
    show(state, draft = null) {
        const gl = this.#gl, { width, height, mean, sample } = this.#targets, environment = this.#environment(state);
        const backdrop = Boolean(environment) && state.backdrop === 'on';
        const program = this.#screen('picture', PICTURE_FRAGMENT);
        const view = this.#view ?? camera(state, width, height);
        this.#bind(0, draft ? sample.texture : mean.texture);
        this.#bind(1, environment?.texture ?? sample.texture);
        gl.bindFramebuffer(gl.FRAMEBUFFER, null);
        gl.viewport(0, 0, width, height);
        gl.uniform1i(program.at('image'), 0);
        gl.uniform1i(program.at('environment'), 1);
        gl.uniform2f(program.at('size'), width, height);
        gl.uniform2f(program.at('used'), ...(draft ?? [width, height]));
        gl.uniform1f(program.at('exposure'), 2 ** state.exposure);
        gl.uniform1f(program.at('strength'), state.strength);
        gl.uniform1f(program.at('turn'), (state.turn * Math.PI) / 180);
        gl.uniform3fv(program.at('right'), view.right);
        gl.uniform3fv(program.at('up'), view.up);
        gl.uniform3fv(program.at('back'), view.back);
        gl.uniform2fv(program.at('tangents'), view.tangents);
        gl.uniform1i(program.at('draft'), draft ? 1 : 0);
        gl.uniform1i(program.at('backdrop'), backdrop ? 1 : 0);
        gl.drawArrays(gl.TRIANGLES, 0, 3);
    }

    /** A fence behind what was drawn so far. @returns a function: whether the device is done. */
    fence() {
        const gl = this.#gl, sync = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
        gl.flush();
        let done = false;
        return () => {
            if (!done && (gl.isContextLost() || !sync || gl.getSyncParameter(sync, gl.SYNC_STATUS) === gl.SIGNALED)) {
                gl.deleteSync(sync);
                done = true;
            }
            return done;
        };
    }

    /** Frees what was made. */
    destroy() {
        const gl = this.#gl;
        this.#textures?.destroy();
        this.#programs.clear();
        this.#fixed.clear();
        this.#targets.destroy();
        [...this.#environments.keys()].forEach((name) => this.#forgetEnvironment(name));
        gl.deleteVertexArray(this.#mesh.array ?? null);
        gl.deleteVertexArray(this.#empty);
        this.#mesh.buffers?.forEach((buffer) => gl.deleteBuffer(buffer));
    }
}
