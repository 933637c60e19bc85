/* OpenBTF in WebGPU: the self-test of a device, rule by rule as decoder/gl_self_test.c runs it. Four invocations run for each.
 *
 * SPDX-License-Identifier: MIT
 */
import { lists } from './self_test_lists.js';
import { OpenBTFError, call, check, load, text } from './module.js';

const SIDE = 2; // invocations run in such blocks
const RAN = 0x42544621; // every invocation says that it ran
const SPREAD = 0x9E3779B9;
const ZERO_BINDING = 23; // as the text of the library has it

/* `wrong` gives the bits of rules that fail at p, which is 0 or 1 in x and y. */
const MAIN = `
@group(1) @binding(0) var<storage, read_write> self_test_result: array<vec2u, ${SIDE * SIDE}>;
@compute @workgroup_size(${SIDE}, ${SIDE})
fn main(@builtin(local_invocation_id) p: vec3u) {
    self_test_result[${SIDE}u * p.y + p.x] = vec2u(wrong(p.xy), ${RAN}u);
}
`;

/* Arithmetic; the rules are in the text of the library. */
const ARITHMETIC = `
fn wrong(p: vec2u) -> u32 {
    return btf_self_test(btf_zero ^ (p.x >> 1u));
}
`;

/* Neighbours fetch from different mip levels, together and while the first of them rests. */
const LEVELS = `
@group(0) @binding(0) var texels: texture_2d<u32>;
fn wrong_level(level: i32) -> u32 {
    return textureLoad(texels, vec2i(0), level).x ^ (0x1234567u << u32(level));
}
fn wrong(p: vec2u) -> u32 {
    let at = vec2i(p);
    var sum = wrong_level((at.x + 2 * at.y) % 3);
    if (at.x + at.y > 0) {
        sum |= wrong_level(2 - at.x - at.y) | wrong_level(0);
    }
    return select(0u, 128u, sum != 0u);
}
`;

/* Neighbours fetch texels of 128 bits from different layers of an array, as factors do. */
const ARRAY = `
@group(0) @binding(0) var texels: texture_2d_array<u32>;
fn wrong(p: vec2u) -> u32 {
    var sum = vec4u(0u);
    for (var i = 0u; i < 3u; i++) {
        let layer = (p.x + 2u * p.y + i) % 3u;
        let texel = 4u * (2u * (2u * layer + p.y) + p.x);
        sum |= textureLoad(texels, vec2i(p), i32(layer), 0) ^ ((vec4u(texel) + vec4u(1u, 2u, 3u, 4u)) * ${SPREAD}u);
    }
    return select(0u, 256u, any(sum != vec4u(0u)));
}
`;

/* Neighbours fetch half a byte and then the layer that it names, as lists of points do. */
const LISTS = `
@group(0) @binding(0) var texels: texture_2d_array<u32>;
fn wrong(p: vec2u) -> u32 {
    var sum = 0u;
    for (var view = 0u; view < 3u; view++) {
        let layer = (textureLoad(texels, vec2i(p), i32(view >> 1u), 0).x >> ((view & 1u) << 2u)) & 15u;
        let bytes = textureLoad(texels, vec2i(p), i32(layer), 0).xy;
        let named = 2u + (p.x + 2u * p.y + 5u * view) % 14u;
        sum |= layer ^ named;
        sum |= (bytes.x + 256u * bytes.y) ^ (((named * 4u + p.y * 2u + p.x) * 1021u) & 0xFFFFu);
    }
    return select(0u, 512u, sum != 0u);
}
`;

/** Refuses what is no device. */
export function needDevice(device) {
    if (typeof GPUDevice === 'undefined' || !(device instanceof GPUDevice)) {
        throw new OpenBTFError('UNSUPPORTED',
            'device: not a GPUDevice; (await navigator.gpu.requestAdapter()).requestDevice() gives one where there is WebGPU');
    }
}

/* Runs code with a first bind group of one entry, and gives the bits of the rules that failed. */
async function run(device, code, binding, layoutEntry, resource) {
    const entry = { binding, visibility: GPUShaderStage.COMPUTE, ...layoutEntry };
    const size = 8 * SIDE * SIDE;
    const result = device.createBuffer({ size, usage: GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_SRC });
    const read = device.createBuffer({ size, usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST });
    const layouts = [
        device.createBindGroupLayout({ entries: [entry] }),
        device.createBindGroupLayout({ entries: [{ binding: 0, visibility: GPUShaderStage.COMPUTE, buffer: { type: 'storage' } }] }),
    ];
    try {
        const pipeline = await device.createComputePipelineAsync({
            layout: device.createPipelineLayout({ bindGroupLayouts: layouts }),
            compute: { module: device.createShaderModule({ code: code + MAIN }), entryPoint: 'main' },
        });
        const encoder = device.createCommandEncoder();
        const pass = encoder.beginComputePass();
        pass.setPipeline(pipeline);
        pass.setBindGroup(0, device.createBindGroup({ layout: layouts[0], entries: [{ binding, resource }] }));
        pass.setBindGroup(1, device.createBindGroup({ layout: layouts[1], entries: [{ binding: 0, resource: { buffer: result } }] }));
        pass.dispatchWorkgroups(1);
        pass.end();
        encoder.copyBufferToBuffer(result, 0, read, 0, size);
        device.queue.submit([encoder.finish()]);
        await read.mapAsync(GPUMapMode.READ);
        const words = new Uint32Array(read.getMappedRange().slice(0));
        let failures = 0;
        for (let i = 0; i < words.length; i += 2) {
            if (words[i + 1] !== RAN) {
                throw new Error('the device did not run a shader');
            }
            failures |= words[i];
        }
        return failures;
    } finally {
        result.destroy();
        read.destroy();
    }
}

/* Runs with a texture of `levels`, each a size and data, of an array where `layers` is given. */
async function runWith(device, code, format, bytesPerTexel, levels, layers) {
    const side = levels[0][0];
    const texture = device.createTexture({ size: [side, side, layers ?? 1], format, mipLevelCount: levels.length,
        usage: GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_DST });
    const viewDimension = layers ? '2d-array' : '2d';
    levels.forEach(([size, data], mipLevel) => {
        device.queue.writeTexture({ texture, mipLevel }, data, { bytesPerRow: size * bytesPerTexel, rowsPerImage: size }, [size, size, layers ?? 1]);
    });
    try {
        return await run(device, code, 0, { texture: { sampleType: 'uint', viewDimension } }, texture.createView({ dimension: viewDimension }));
    } finally {
        texture.destroy();
    }
}

async function testAll(device) {
    const source = text(call('self_test_wgsl'));
    check();
    const zero = device.createBuffer({ size: 16, usage: GPUBufferUsage.UNIFORM });
    let failures = 0;
    try {
        failures = await run(device, source + ARITHMETIC, ZERO_BINDING, { buffer: { type: 'uniform' } }, { buffer: zero });
    } finally {
        zero.destroy();
    }
    failures |= await runWith(device, LEVELS, 'rgba32uint', 16, [4, 2, 1].map((size, level) => [size, new Uint32Array(4 * size * size).fill(0x1234567 << level)]));
    const spread = Uint32Array.from({ length: 3 * SIDE * SIDE * 4 }, (_, i) => Math.imul(i + 1, SPREAD));
    failures |= await runWith(device, ARRAY, 'rgba32uint', 16, [[SIDE, spread]], 3);
    const [bytes, layers] = lists(SIDE);
    return failures | await runWith(device, LISTS, 'rg8uint', 2, [[SIDE, bytes]], layers);
}

export async function selfTest(device) {
    needDevice(device);
    await load();
    device.pushErrorScope('validation');
    let failures, thrown;
    try {
        failures = await testAll(device);
    } catch (error) {
        thrown = error;
    }
    const refused = await device.popErrorScope();
    if (thrown || refused) {
        throw new OpenBTFError('UNSUPPORTED', `self-test: ${(thrown ?? refused).message}`);
    }
    return { failures, names: failures ? text(call('self_test_names', failures)).split(/,\s*/) : [] };
}
