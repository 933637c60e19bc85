/* Evaluates a decoder's WGSL on arguments, bit for bit, in a compute shader: arguments and results are storage buffers.
 *
 * SPDX-License-Identifier: MIT
 */

/* `call` is an expression for the radiance at uv, l, v, level and random; arguments are laid out by pack(). */
const main = (call) => `
struct test_settings {
    width: u32,
    count: u32,
    level: i32,
    number: u32,
}
@group(1) @binding(0) var<uniform> test_given: test_settings;
@group(1) @binding(1) var<storage, read> test_arguments: array<vec4u>;
@group(1) @binding(2) var<storage, read_write> test_result: array<vec4u>;
@compute @workgroup_size(64)
fn test_main(@builtin(global_invocation_id) id: vec3u) {
    let i = id.x;
    if (i >= test_given.count) {
        return;
    }
    let p = vec2u(i % test_given.width, i / test_given.width);
    let a = test_arguments[i];
    let b = test_arguments[test_given.count + i];
    let uv = bitcast<vec2f>(a.xy);
    let l = bitcast<vec3f>(vec3u(a.zw, b.x));
    let v = bitcast<vec3f>(b.yzw);
    let level = test_given.level;
    test_result[i] = vec4u(bitcast<vec3u>(${call}), 1u);
}
`;
const CALLS = {
    radiance: 'btf_evaluate_level(uv, l, v, level)',
    picked: 'btf_evaluate_stochastic_level(uv, l, v, level, btf_random(vec3u(p, test_given.number)))',
};

/** Returns a device with the default limits, and its description. */
export async function device() {
    const adapter = await navigator.gpu?.requestAdapter();
    if (!adapter) {
        throw new Error('this browser gives no WebGPU adapter');
    }
    const { vendor, architecture, description } = adapter.info ?? {};
    const made = await adapter.requestDevice();
    made.addEventListener('uncapturederror', ({ error }) => {
        throw new Error(`WebGPU: ${error.message}`);
    });
    return { device: made, name: [vendor, architecture, description].filter(Boolean).join(' ') || 'an adapter without a name' };
}

/** The layout of arguments and results, one for all pipelines of a device. */
function argumentLayout(gpu) {
    return gpu.createBindGroupLayout({
        entries: ['uniform', 'read-only-storage', 'storage'].map((type, binding) => ({ binding, visibility: GPUShaderStage.COMPUTE, buffer: { type } })),
    });
}

/** A pipeline for a decoder's text and its group's layout; `plane` is radiance or picked. A text that does not compile is an error with
 * the compiler's message. */
export async function compile(gpu, source, layout, plane) {
    const arguments_ = argumentLayout(gpu);
    const module = gpu.createShaderModule({ code: source + main(CALLS[plane]) });
    const { messages } = await module.getCompilationInfo();
    const errors = messages.filter(({ type }) => type === 'error');
    if (errors.length) {
        throw new Error(errors.slice(0, 5).map(({ lineNum, message }) => `line ${lineNum}: ${message}`).join('\n'));
    }
    const pipeline = await gpu.createComputePipelineAsync({
        layout: gpu.createPipelineLayout({ bindGroupLayouts: [layout, arguments_] }),
        compute: { module, entryPoint: 'test_main' },
    });
    return { pipeline, layout: arguments_ };
}

/**
 * Evaluates.
 * @param args [2][count][4] words, as pack() gives them
 * @param width of the picture whose pixels' random numbers are used
 * @returns [count][4] words, of which the last is 1
 */
export async function evaluate(gpu, bindGroup, compiled, width, args, level, number) {
    const count = args.length / 8, size = 16 * count;
    const given = gpu.createBuffer({ size: 16, usage: GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST });
    const read = gpu.createBuffer({ size: 2 * size, usage: GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_DST });
    const result = gpu.createBuffer({ size, usage: GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_SRC });
    const mapped = gpu.createBuffer({ size, usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST });
    gpu.queue.writeBuffer(given, 0, Uint32Array.of(width, count, level, number));
    gpu.queue.writeBuffer(read, 0, args);
    const encoder = gpu.createCommandEncoder();
    const pass = encoder.beginComputePass();
    pass.setPipeline(compiled.pipeline);
    pass.setBindGroup(0, bindGroup);
    pass.setBindGroup(1, gpu.createBindGroup({ layout: compiled.layout, entries: [given, read, result].map((buffer, binding) => ({ binding, resource: { buffer } })) }));
    pass.dispatchWorkgroups(Math.ceil(count / 64));
    pass.end();
    encoder.copyBufferToBuffer(result, 0, mapped, 0, size);
    gpu.queue.submit([encoder.finish()]);
    await mapped.mapAsync(GPUMapMode.READ);
    const words = new Uint32Array(mapped.getMappedRange().slice(0));
    [given, read, result, mapped].forEach((buffer) => buffer.destroy());
    if (words[3] !== 1 || words[words.length - 1] !== 1) {
        throw new Error('the shader did not run');
    }
    return words;
}
