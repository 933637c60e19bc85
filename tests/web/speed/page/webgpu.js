/* A square that WebGPU decodes.
 *
 * SPDX-License-Identifier: MIT
 */
import { upload } from '/package/webgpu.js';

const SHADER = `
@group(1) @binding(0) var<uniform> light: vec4f;
struct corner { @builtin(position) position: vec4f, @location(0) uv: vec2f }
@vertex fn square(@builtin(vertex_index) i: u32) -> corner {
    let uv = vec2f(vec2u(i & 1u, i >> 1u));
    return corner(vec4f(2.0 * uv - 1.0, 0.0, 1.0), uv);
}
@fragment fn shade(@location(0) uv: vec2f) -> @location(0) vec4f {
    return vec4f(btf_evaluate(uv, light.xyz, vec3f(0.0, 0.0, 1.0)), 1.0);
}`;

/** The same as webgl() of webgl.js, by WebGPU. */
export async function webgpu(material, math, side, step) {
    const adapter = await navigator.gpu.requestAdapter(), device = await adapter.requestDevice();
    step('device');
    const textures = await upload(device, material, { math, language: 'wgsl' });
    step('upload');
    const module = device.createShaderModule({ code: material.source({ math, language: 'wgsl' }) + SHADER });
    const own = device.createBindGroupLayout({ entries: [{ binding: 0, visibility: GPUShaderStage.FRAGMENT, buffer: {} }] });
    const pipeline = await device.createRenderPipelineAsync({
        layout: device.createPipelineLayout({ bindGroupLayouts: [textures.layout, own] }),
        vertex: { module, entryPoint: 'square' },
        fragment: { module, entryPoint: 'shade', targets: [{ format: 'rgba8unorm' }] },
        primitive: { topology: 'triangle-strip' },
    });
    step('compile');
    const target = device.createTexture({ size: [side, side], format: 'rgba8unorm', usage: GPUTextureUsage.RENDER_ATTACHMENT | GPUTextureUsage.COPY_SRC });
    const buffer = device.createBuffer({ size: 16, usage: GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST });
    const group = device.createBindGroup({ layout: own, entries: [{ binding: 0, resource: { buffer } }] });
    const { vendor, architecture, description } = adapter.info ?? {};
    return {
        name: [vendor, architecture, description].filter(Boolean).join(' '),
        draw: async (light) => {
            device.queue.writeBuffer(buffer, 0, Float32Array.of(...light, 0));
            const encoder = device.createCommandEncoder();
            const pass = encoder.beginRenderPass({ colorAttachments: [{ view: target.createView(), loadOp: 'clear', storeOp: 'store' }] });
            pass.setPipeline(pipeline);
            pass.setBindGroup(0, textures.bindGroup);
            pass.setBindGroup(1, group);
            pass.draw(4);
            pass.end();
            device.queue.submit([encoder.finish()]);
            await device.queue.onSubmittedWorkDone();
        },
        destroy: () => device.destroy(),
    };
}
