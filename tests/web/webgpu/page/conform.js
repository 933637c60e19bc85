/* Conformance in WebGPU: decodes by the WGSL of the library and compares every bit with test vectors and with the reference decoder in
 * the page. Posts cases to the server that runs the test.
 *
 * Compiling takes nearly all of the time, so that a pipeline serves every vector whose text is the same.
 *
 * SPDX-License-Identifier: MIT
 */
import { OpenBTFError, load, open } from '/package/index.js';
import { Textures, fits, selfTest, upload } from '/package/webgpu.js';
import { make, pack } from '/page/arguments.js';
import { WANTED, changed, differing, optionsOf, plane } from '/page/compare.js';
import { compile, device, evaluate } from './compute.js';
import { draw } from './fragment.js';

/* Evaluations of each material against the reference: 3 * 168,000 values are more than 500,000; the short form has an
 * eighth. */
const MANY = 168000, FEW = 21000;
/* Variants by which materials are decoded: each by one, in turn; in the long form each by all. */
const VARIANTS = [
    { interpolation: 'linear', filter: 'texel' },
    { interpolation: 'nearest', filter: 'bilinear' },
    { interpolation: 'linear', filter: 'steep' },
];
const WIDE = 500; // width of the picture for arguments without random numbers; any will do

const post = (path, value) => fetch(path, { method: 'POST', body: JSON.stringify(value) });
const report = (name, wrong = '') => post('/case', { name, wrong });
const note = (line) => post('/note', line);
const json = async (path) => (await fetch(path)).json();
const bytes = async (path) => (await fetch(path)).arrayBuffer();
const wgsl = (options) => ({ ...options, language: 'wgsl' });

/* Seconds so far for each kind of work: printed, never asserted. */
const spent = { compiling: 0, decoding: 0, 'the reference': 0 };

async function timed(what, body) {
    const start = performance.now();
    const result = await body();
    spent[what] += (performance.now() - start) / 1000;
    return result;
}

const tellTimes = (of) => note(`${of}: seconds so far: ${Object.entries(spent).map(([what, seconds]) => `${what} ${seconds.toFixed(1)}`).join(', ')}`);

/** A cache of pipelines by text and plane. WebGPU treats layouts with the same entries as the same. */
class Pipelines {
    #gpu;
    #compiled = new Map();
    asked = 0;

    constructor(gpu) {
        this.#gpu = gpu;
    }

    async get(source, layout, name) {
        const key = `${name}\n${source}`;
        this.asked += 1;
        if (!this.#compiled.has(key)) {
            this.#compiled.set(key, await timed('compiling', () => compile(this.#gpu, source, layout, name)));
        }
        return this.#compiled.get(key);
    }

    get size() {
        return this.#compiled.size;
    }
}

/** Values of a vector's planes that differ. `change` rewrites the shader text. */
async function replay(gpu, pipelines, vector, planes, change = (text) => text) {
    const material = await open(await bytes(`/vectors/${vector.material}`));
    const data = new Uint32Array(await bytes(`/vectors/${vector.data}`));
    const args = pack(plane(data, 0, 2), plane(data, 2, 3), plane(data, 5, 3));
    let different = 0;
    for (const name of planes) {
        const options = wgsl({ ...optionsOf(vector, material.info), picks: name === 'picked' ? 'all' : 'none' });
        const textures = await upload(gpu, material, options);
        const compiled = await pipelines.get(change(material.source(options)), textures.layout, name);
        const got = await timed('decoding', () => evaluate(gpu, textures.bindGroup, compiled, vector.side, args, vector.level, vector.number));
        different += differing(got, plane(data, WANTED[name], 3), data.length / 14);
        textures.destroy();
    }
    material.close();
    return different;
}

/** Every vector's radiance; of a third of them, which have every effect and filter, radiance of picked neighbours too. */
async function compareVectors(gpu, vectors) {
    const pipelines = new Pipelines(gpu);
    for (const part of [0, 1, 2]) {
        const list = vectors.filter((_, i) => i % 3 === part);
        const planes = part === 0 ? ['radiance', 'picked'] : ['radiance'];
        const wrong = [];
        for (const [index, vector] of list.entries()) {
            const different = await replay(gpu, pipelines, vector, planes);
            if (different) {
                wrong.push(`${vector.material} (${vector.about}): ${different} values differ`);
            }
            if (index % 10 === 9) {
                await tellTimes(`vectors ${part + 1} of 3: ${index + 1} of ${list.length}`);
            }
        }
        await report(`vectors ${part + 1} of 3: ${list.length} vectors, ${planes.join(' and ')}, 0 bits differ`, wrong.join('\n'));
    }
    await note(`${pipelines.size} pipelines compiled for ${pipelines.asked} planes of vectors`);
}

async function compareReference(gpu, materials, long) {
    for (const [index, name] of materials.entries()) {
        const material = await open(await bytes(`/golden/${name}`));
        const level = index % material.info.levels, count = long ? MANY : FEW;
        const { uv, light, view } = make(material, count, 77 + index);
        for (const variant of long ? VARIANTS : [VARIANTS[index % VARIANTS.length]]) {
            const options = wgsl(variant);
            const textures = await upload(gpu, material, options);
            const compiled = await timed('compiling', () => compile(gpu, material.source(options), textures.layout, 'radiance'));
            const got = await timed('decoding', () => evaluate(gpu, textures.bindGroup, compiled, WIDE, pack(uv, light, view), level, 0));
            const reference = await timed('the reference', () => material.evaluate(uv, light, view, { ...variant, level, reference: true }));
            const different = differing(got, new Uint32Array(reference.buffer), count);
            const lit = reference.reduce((sum, value) => sum + (value > 0 ? 1 : 0), 0);
            const label = `reference: ${name} level ${level} ${variant.interpolation} ${variant.filter}, ${3 * count} values`;
            const wrong = lit > count ? '' : `${lit} values are not 0: too few to compare`;
            await report(`${label}, 0 bits differ`, different ? `${different} values differ` : wrong);
            textures.destroy();
        }
        material.close();
        await tellTimes(name);
    }
}

/** A wrong text must be noticed. Without `noticed`, for a browser that cannot notice it, the number of differing values
 * is only printed. */
async function control(gpu, name, vectors, change, noticed) {
    const pipelines = new Pipelines(gpu);
    let different = 0, count = 0;
    for (const vector of noticed ? vectors : vectors.slice(0, 2)) {
        different += await replay(gpu, pipelines, vector, ['radiance'], change);
        count += 1;
        if (different) {
            break;
        }
    }
    await report(`control: ${name}${noticed ? ' is noticed' : ''}`, noticed && !different ? 'no value differs, and some must' : '');
    await note(`control ${name}: ${different} values of ${count} vectors differ`);
}

/* Compares a * b + a * c of 65,536 triples, by the library's two functions, with float arithmetic that rounds each
 * operation. */
async function protection(gpu, source, layout, bindGroup, protects) {
    const count = 65536;
    const code = `${source}
@group(1) @binding(0) var<storage, read> given: array<u32>;
@group(1) @binding(1) var<storage, read_write> sums: array<u32>;
@compute @workgroup_size(64)
fn sum(@builtin(global_invocation_id) id: vec3u) {
    let a = bitcast<f32>(given[3u * id.x]);
    let b = bitcast<f32>(given[3u * id.x + 1u]);
    let c = bitcast<f32>(given[3u * id.x + 2u]);
    sums[id.x] = bitcast<u32>(${protects ? 'btf_add_f32_f32(btf_mul_f32_f32(a, b), btf_mul_f32_f32(a, c))' : 'a * b + a * c'});
}`;
    const numbers = new Float32Array(3 * count);
    let state = 12345;
    for (let i = 0; i < numbers.length; i++) {
        state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
        numbers[i] = 1 + state / 2 ** 32;
    }
    const layouts = [layout, gpu.createBindGroupLayout({ entries: ['read-only-storage', 'storage'].map((type, binding) => ({ binding, visibility: GPUShaderStage.COMPUTE, buffer: { type } })) })];
    const pipeline = await gpu.createComputePipelineAsync({ layout: gpu.createPipelineLayout({ bindGroupLayouts: layouts }),
        compute: { module: gpu.createShaderModule({ code }), entryPoint: 'sum' } });
    const given = gpu.createBuffer({ size: numbers.byteLength, usage: GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_DST });
    const sums = gpu.createBuffer({ size: 4 * count, usage: GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_SRC });
    const read = gpu.createBuffer({ size: 4 * count, usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST });
    gpu.queue.writeBuffer(given, 0, numbers);
    const encoder = gpu.createCommandEncoder();
    const pass = encoder.beginComputePass();
    pass.setPipeline(pipeline);
    pass.setBindGroup(0, bindGroup);
    pass.setBindGroup(1, gpu.createBindGroup({ layout: layouts[1], entries: [given, sums].map((buffer, binding) => ({ binding, resource: { buffer } })) }));
    pass.dispatchWorkgroups(count / 64);
    pass.end();
    encoder.copyBufferToBuffer(sums, 0, read, 0, 4 * count);
    gpu.queue.submit([encoder.finish()]);
    await read.mapAsync(GPUMapMode.READ);
    const got = new Float32Array(read.getMappedRange());
    let different = 0;
    for (let i = 0; i < count; i++) {
        const [a, b, c] = numbers.subarray(3 * i, 3 * i + 3);
        different += got[i] !== Math.fround(Math.fround(a * b) + Math.fround(a * c)) ? 1 : 0;
    }
    [given, sums, read].forEach((buffer) => buffer.destroy());
    return different;
}

async function compareProtection(gpu, name) {
    const material = await open(await bytes(`/golden/${name}`));
    const options = wgsl({});
    const textures = await upload(gpu, material, options);
    const source = material.source(options);
    const kept = await protection(gpu, source, textures.layout, textures.bindGroup, true);
    const plain = await protection(gpu, source, textures.layout, textures.bindGroup, false);
    textures.destroy();
    material.close();
    await report('a * b + a * c of 65,536 triples: with the zero, 0 sums differ', kept ? `${kept} differ` : '');
    await report('control: the same without btf_mul and btf_add is noticed', plain ? '' : 'no sum differs, and some must');
    await note(`a * b + a * c of 65,536 triples without them: ${plain} sums differ`);
}

/** Drawing gives the bits that a compute shader gives. */
async function compareDrawn(gpu, name) {
    const side = 128;
    const material = await open(await bytes(`/golden/${name}`));
    const { uv, light, view } = make(material, side * side, 3);
    const textures = await upload(gpu, material, wgsl({}), GPUShaderStage.FRAGMENT);
    const got = await draw(gpu, material.source(wgsl({})), textures, pack(uv, light, view), side);
    const different = differing(got, new Uint32Array(material.evaluate(uv, light, view, { reference: true }).buffer), side * side);
    textures.destroy();
    material.close();
    await report(`drawn: ${name}, ${3 * side * side} values, 0 bits differ`, different ? `${different} values differ` : '');
}

/** Checks uploads that are refused, and the properties of an upload. */
async function checkUpload(gpu, name) {
    const material = await open(await bytes(`/golden/${name}`));
    const refuses = async (pattern, body, code = 'UNSUPPORTED') => {
        try {
            await body();
        } catch (error) {
            return error instanceof OpenBTFError && error.code === code && pattern.test(error.message) ? '' : String(error.stack);
        }
        return 'nothing is refused';
    };
    await report('upload refuses what is no device', await refuses(/^device: not a GPUDevice/, () => upload({}, material)));
    const limited = Object.create(gpu, { limits: { value: { maxTextureDimension2D: 2, maxTextureArrayLayers: 256, maxSampledTexturesPerShaderStage: 16 } } });
    await report('upload refuses a texture that is too large, with both numbers',
        await refuses(/: a side of \d+ exceeds maxTextureDimension2D 2; /, () => upload(limited, material)) || (fits(limited, material) ? 'fits says yes' : ''));
    await report('upload refuses bindings beyond 32 bits', await refuses(/^option firstBinding: 4294967290 /,
        () => upload(gpu, material, wgsl({ firstBinding: 4294967290 })), 'USAGE'));
    const textures = await upload(gpu, material, wgsl({ group: 0, firstBinding: 40 }));
    const sum = material.textures(wgsl({})).reduce((total, { data }) => total + data.byteLength, 0);
    const bindings = textures.layoutEntries.map(({ binding }) => binding);
    await report('bytes uploaded', textures instanceof Textures && textures.bytes === sum ? '' : `${textures.bytes}, not ${sum}`);
    await report('bindings from firstBinding on', bindings.every((binding) => binding >= 40 && binding <= 63) && bindings.at(-1) === 63 && fits(gpu, material) ? '' : String(bindings));
    const compiled = await compile(gpu, material.source(wgsl({ firstBinding: 40, prefix: 'stone' })).replaceAll('stone_', 'btf_'), textures.layout, 'radiance');
    const { uv, light, view } = make(material, 2000, 5);
    const got = await evaluate(gpu, textures.bindGroup, compiled, WIDE, pack(uv, light, view), 0, 0);
    const different = differing(got, new Uint32Array(material.evaluate(uv, light, view).buffer), 2000);
    await report('another prefix and first binding, 0 bits differ', different ? `${different} values differ` : '');
    textures.destroy();
    await report('destroy() leaves nothing', textures.bytes === 0 && textures.texture('sbrdf') === null ? '' : `${textures.bytes} bytes`);
    material.close();
}

/** Checks that the browser compiles the texts of all variants, as test_wgsl wrote them. */
async function compileTexts(gpu) {
    const texts = await json('/texts/texts.json');
    const wrong = [];
    for (const [index, name] of texts.entries()) {
        const module = gpu.createShaderModule({ code: await (await fetch(`/texts/${name}`)).text() });
        const { messages } = await module.getCompilationInfo();
        const error = messages.find(({ type }) => type === 'error');
        if (error) {
            wrong.push(`${name}, line ${error.lineNum}: ${error.message}`);
        }
        if (index % 50 === 49) {
            await note(`texts: ${index + 1} of ${texts.length}`);
        }
    }
    await report(`${texts.length} texts of variants compile`, wrong.slice(0, 5).join('\n') || (texts.length > 50 ? '' : 'too few'));
}

async function run() {
    const job = await json('/job');
    await load('/package/openbtf.wasm');
    const { device: gpu, name } = await device();
    await note(`${navigator.userAgent}; ${name}`);
    const { failures, names } = await selfTest(gpu);
    await report('self-test', failures ? names.join(', ') : '');
    await checkUpload(gpu, 'v1-tight.btf.exr');
    await compareProtection(gpu, 'v1-tight.btf.exr');
    await compareDrawn(gpu, 'v2-relief.btf.exr');
    if (job.texts) {
        await compileTexts(gpu);
    }
    await compareReference(gpu, job.golden, job.long);
    const vectors = await json('/vectors/vectors.json');
    await compareVectors(gpu, job.long ? vectors : vectors.filter((_, i) => i % 5 === 0));
    const zero = vectors.filter((_, i) => i % 4 === 0);
    // a module-scope constant replaces the uniform
    await control(gpu, 'a zero that the compiler knows', zero, (text) => text.replace(/@group\(0\) @binding\(23\) var<uniform> btf_zero: u32;/, 'const btf_zero = 0u;'), job.noticesZero);
    const shift = vectors.filter(({ effects, about }) => effects.includes('shift') && !about.startsWith('1x1')).slice(0, 4);
    await control(gpu, 'swapped shift bytes', shift, (text) => changed(changed(changed(text, 'btf_shift_of(codes.y)', 'swap'),
        'btf_shift_of(codes.z)', 'btf_shift_of(codes.y)'), 'swap', 'btf_shift_of(codes.z)'), true);
}

const fail = (error) => post('/done', error?.stack ? `${error.message}\n${error.stack}` : String(error));
window.addEventListener('error', ({ error, message }) => fail(error ?? message));
window.addEventListener('unhandledrejection', ({ reason }) => fail(reason));
run().then(() => post('/done', ''), fail);
