/* Evaluates a decoder's WGSL in a fragment shader, where engines call it, a pixel an evaluation.
 *
 * SPDX-License-Identifier: MIT
 */
const MAIN = `
@group(1) @binding(0) var<storage, read> test_arguments: array<vec4u>;
@vertex
fn test_vertex(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(select(-1.0, 3.0, i == 1u), select(-1.0, 3.0, i == 2u), 0.0, 1.0);
}
@fragment
fn test_fragment(@builtin(position) position: vec4f) -> @location(0) vec4u {
    let i = u32(position.y) * SIDEu + u32(position.x);
    let a = test_arguments[i];
    let b = test_arguments[SIDEu * SIDEu + i];
    let value = btf_evaluate(bitcast<vec2f>(a.xy), bitcast<vec3f>(vec3u(a.zw, b.x)), bitcast<vec3f>(b.yzw));
    return vec4u(bitcast<vec3u>(value), 1u);
}
`;

/**
 * Draws side x side evaluations, of a multiple of 16.
 * @param args [2][side * side][4] words, as pack() gives them
 * @returns [side * side][4] words, of which the last is 1
 */
export async function draw(gpu, source, { layout, bindGroup }, args, side) {
    const own = gpu.createBindGroupLayout({ entries: [{ binding: 0, visibility: GPUShaderStage.FRAGMENT, buffer: { type: 'read-only-storage' } }] });
    const module = gpu.createShaderModule({ code: source + MAIN.replaceAll('SIDE', String(side)) });
    const pipeline = await gpu.createRenderPipelineAsync({
        layout: gpu.createPipelineLayout({ bindGroupLayouts: [layout, own] }),
        vertex: { module, entryPoint: 'test_vertex' },
        fragment: { module, entryPoint: 'test_fragment', targets: [{ format: 'rgba32uint' }] },
    });
    const given = gpu.createBuffer({ size: args.byteLength, usage: GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_DST });
    const read = gpu.createBuffer({ size: 16 * side * side, usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST });
    const target = gpu.createTexture({ size: [side, side], format: 'rgba32uint', usage: GPUTextureUsage.RENDER_ATTACHMENT | GPUTextureUsage.COPY_SRC });
    gpu.queue.writeBuffer(given, 0, args);
    const encoder = gpu.createCommandEncoder();
    const pass = encoder.beginRenderPass({ colorAttachments: [{ view: target.createView(), loadOp: 'clear', storeOp: 'store' }] });
    pass.setPipeline(pipeline);
    pass.setBindGroup(0, bindGroup);
    pass.setBindGroup(1, gpu.createBindGroup({ layout: own, entries: [{ binding: 0, resource: { buffer: given } }] }));
    pass.draw(3);
    pass.end();
    encoder.copyTextureToBuffer({ texture: target }, { buffer: read, bytesPerRow: 16 * side }, [side, side]);
    gpu.queue.submit([encoder.finish()]);
    await read.mapAsync(GPUMapMode.READ);
    const words = new Uint32Array(read.getMappedRange().slice(0));
    given.destroy();
    read.destroy();
    target.destroy();
    if (words[3] !== 1 || words[words.length - 1] !== 1) {
        throw new Error('nothing was drawn');
    }
    return words;
}
