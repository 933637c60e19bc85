/* Uses every type of the package as a user of TypeScript does. The file is compiled and never run. A line after
 * @ts-expect-error must not compile.
 *
 * SPDX-License-Identifier: MIT
 */
import { DoubleSide, Mesh, PlaneGeometry, Vector2, WebGLRenderer } from 'three';
import { WebGPURenderer } from 'three/webgpu';
import { Material, OpenBTFError, load, memoryBytes, open } from 'openbtf';
import type { Info, Plan, ShaderOptions, Texture } from 'openbtf';
import { BTFMaterial } from 'openbtf/three';
import { BTFMaterial as BTFNodeMaterial } from 'openbtf/three-webgpu';
import { Textures, fits, selfTest, upload } from 'openbtf/webgl';

export async function use(gl: WebGL2RenderingContext, renderer: WebGLRenderer, program: WebGLProgram): Promise<number> {
    await load(new URL('https://example.org/openbtf.wasm'));
    const material: Material = await open(new Uint8Array(1));
    const info: Info = material.info;
    const options: ShaderOptions = { leaveOut: ['shadow'], interpolation: 'nearest', filter: 'steep', fixedView: [0, 0, 1], picks: 'view' };
    const list: Texture[] = material.textures(options);
    const plan: Plan = material.plan({ view: { theta: [0, 60] }, lights: 2 }, 1);
    const small = material.restrict(plan);
    const psnr: number = material.predict(plan, ['gain']).psnrLinear;
    const radiance: Float32Array = small.evaluate([0, 0], [0, 0, 1], new Float32Array(3), { level: 1, reference: true });
    const textures: Textures = upload(gl, material.toTight(), plan.shader);
    const units: number = textures.bind(program, 1, 'btf');
    const { failures, names } = await selfTest(gl);
    const shown = new BTFMaterial(material, { repeat: [2, 1], side: DoubleSide, decode: { filter: 'bilinear', math: 'fast' } });
    const repeat: Vector2 = shown.repeat;
    const bytes: number = shown.upload(renderer);
    const mesh = new Mesh(new PlaneGeometry(), shown.clone());
    const nodes = new BTFNodeMaterial(material, { repeat: 2, side: DoubleSide, decode: { interpolation: 'nearest' } });
    const taken: number = await nodes.upload(new WebGPURenderer()) + nodes.repeat.x + new Mesh(new PlaneGeometry(), nodes).id;

    // @ts-expect-error: a name that is no effect
    material.source({ leaveOut: ['shadows'] });
    // @ts-expect-error: made by open() alone
    new Material();
    // @ts-expect-error: read only
    info.width = 1;
    // @ts-expect-error: BTFMaterial has no stochastic decode
    new BTFMaterial(material, { decode: { picks: 'all' } });
    // @ts-expect-error: a renderer of the other kind
    await nodes.upload(renderer);
    // @ts-expect-error: open() takes bytes and no path
    await open('bricks.btf.exr');

    try {
        material.close();
    } catch (error) {
        if (error instanceof OpenBTFError && error.code === 'USAGE') {
            return error.result;
        }
    }
    const source: string = small.source();
    return source.length + list.length + psnr + radiance.length + units + failures + names.length + bytes + repeat.x + mesh.id
        + taken + memoryBytes() + Number(fits(gl, small)) + Number(material.closed);
}
