/* Programs of the viewer: compiled in the background where the browser can, and kept for the next time.
 *
 * SPDX-License-Identifier: MIT
 */
const KEPT = 24; // variants of a material's shader; the one unused for longest goes

/** A program that may not have been linked yet. */
class Linking {
    #gl;
    #parallel;
    #shaders;
    #linked = false;
    #locations = new Map();

    constructor(gl, parallel, vertex, fragment) {
        this.#gl = gl;
        this.#parallel = parallel;
        this.program = gl.createProgram();
        this.#shaders = [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]].map(([kind, text]) => {
            const shader = gl.createShader(kind);
            gl.shaderSource(shader, text);
            gl.compileShader(shader);
            gl.attachShader(this.program, shader);
            return shader;
        });
        gl.linkProgram(this.program);
    }

    /** Whether finish() would return without waiting. */
    get ready() {
        return this.#linked || !this.#parallel || this.#gl.getProgramParameter(this.program, this.#parallel.COMPLETION_STATUS_KHR);
    }

    /** Waits for the link. Throws an Error with what the device says where it fails. */
    finish() {
        const gl = this.#gl;
        if (this.#linked) {
            return this;
        }
        if (!gl.getProgramParameter(this.program, gl.LINK_STATUS) && !gl.isContextLost()) {
            const said = [gl.getProgramInfoLog(this.program), ...this.#shaders.map((shader) => gl.getShaderInfoLog(shader))];
            throw new Error(`this device does not compile the shader: ${said.filter(Boolean).join(' ').slice(0, 600)}`);
        }
        this.#shaders.forEach((shader) => gl.deleteShader(shader));
        this.#linked = true;
        return this;
    }

    at(name) {
        if (!this.#locations.has(name)) {
            this.#locations.set(name, this.#gl.getUniformLocation(this.program, name));
        }
        return this.#locations.get(name);
    }

    destroy() {
        if (!this.#linked) {
            this.#shaders.forEach((shader) => this.#gl.deleteShader(shader));
        }
        this.#gl.deleteProgram(this.program);
    }
}

/** Programs by key. */
export class Programs {
    #gl;
    #parallel;
    #kept = new Map(); // the latest used last

    constructor(gl) {
        this.#gl = gl;
        this.#parallel = gl.getExtension('KHR_parallel_shader_compile');
    }

    /** The program of a key; `texts` gives vertex and fragment shader where it is not there yet. */
    get(key, texts) {
        let program = this.#kept.get(key);
        this.#kept.delete(key);
        program ??= new Linking(this.#gl, this.#parallel, ...texts());
        this.#kept.set(key, program);
        if (this.#kept.size > KEPT) {
            const [oldest, gone] = this.#kept.entries().next().value;
            this.#kept.delete(oldest);
            gone.destroy();
        }
        return program;
    }

    clear() {
        this.#kept.forEach((program) => program.destroy());
        this.#kept.clear();
    }
}
