/* Conformance: decodes in WebGL2 and compares every bit with test vectors and with the reference decoder in the page.
 *
 * Compiling shaders takes most of the time: no two vectors have the same text.
 *
 * SPDX-License-Identifier: MIT
 */
import { open } from '/package/index.js';
import { selfTest, upload } from '/package/webgl.js';
import { make, pack } from './arguments.js';
import { changed, differing, optionsOf, plane, WANTED } from './compare.js';
import { context, draw, program, release } from './draw.js';
import { bytes, json, note, report } from './post.js';

/* The size of the picture in which materials are compared: 3 * 512 * 336 values are more than 500,000. */
const WIDE = 512, HIGH = 336;
/* Variants by which materials are decoded, in turn. */
const VARIANTS = [
    { interpolation: 'linear', filter: 'texel' },
    { interpolation: 'nearest', filter: 'bilinear' },
    { interpolation: 'linear', filter: 'steep' },
];

/** Counts the values of a vector's planes that differ. `change` rewrites the shader text. */
async function replay(gl, vector, planes, change = (text) => text) {
    const material = await open(await bytes(`/vectors/${vector.material}`));
    const data = new Uint32Array(await bytes(`/vectors/${vector.data}`));
    const args = pack(plane(data, 0, 2), plane(data, 2, 3), plane(data, 5, 3));
    let different = 0;
    for (const name of planes) {
        const options = { ...optionsOf(vector, material.info), picks: name === 'picked' ? 'all' : 'none' };
        const textures = upload(gl, material, options);
        const linked = program(gl, change(material.source(options)), name);
        const got = draw(gl, textures, linked, vector.side, data.length / 14 / vector.side, args, vector.level, vector.number);
        different += differing(got, plane(data, WANTED[name], 3), data.length / 14);
        gl.deleteProgram(linked);
        textures.destroy();
    }
    material.close();
    return different;
}

/** Compares every vector's radiance, and for a third of them, which have every effect and filter, that of picked
 * neighbours. */
async function compareVectors(gl, vectors) {
    for (const part of [0, 1, 2]) {
        const list = vectors.filter((_, i) => i % 3 === part);
        const planes = part === 0 ? ['radiance', 'picked'] : ['radiance'];
        const wrong = [];
        for (const [index, vector] of list.entries()) {
            const different = await replay(gl, vector, planes);
            if (different) {
                wrong.push(`${vector.material} (${vector.about}): ${different} values differ`);
            }
            if (index % 10 === 9) {
                await note(`vectors ${part + 1} of 3: ${index + 1} of ${list.length}`);
            }
        }
        await report(`vectors ${part + 1} of 3: ${list.length} vectors, ${planes.join(' and ')}, 0 bits differ`, wrong.join('\n'));
    }
}

/* How many vectors a control decodes where the browser cannot notice the change: enough to see that the text
 * compiles. */
const UNNOTICED = 2;

/** A wrong text must be noticed with some vector; the first that notices ends the control. */
async function control(gl, name, vectors, change, noticed) {
    let different = 0, count = 0;
    for (const vector of noticed ? vectors : vectors.slice(0, UNNOTICED)) {
        different += await replay(gl, vector, ['radiance'], change);
        count += 1;
        if (different) {
            break;
        }
    }
    await report(`control: ${name}${noticed ? ' is noticed' : ''}`, noticed && !different ? 'no value differs, and some must' : '');
    await note(`control ${name}: ${different} values of ${count} vectors differ`);
}

async function compareReference(gl, materials) {
    for (const [index, name] of materials.entries()) {
        const material = await open(await bytes(`/golden/${name}`));
        const options = VARIANTS[index % VARIANTS.length];
        const level = index % material.info.levels;
        const { uv, light, view } = make(material, WIDE * HIGH, 77 + index);
        const textures = upload(gl, material, options);
        const linked = program(gl, material.source(options), 'radiance');
        const got = draw(gl, textures, linked, WIDE, HIGH, pack(uv, light, view), level, 0);
        const reference = material.evaluate(uv, light, view, { ...options, level, reference: true });
        const different = differing(got, new Uint32Array(reference.buffer), WIDE * HIGH);
        const label = `reference: ${name} level ${level} ${options.interpolation} ${options.filter}, ${3 * WIDE * HIGH} values`;
        await report(`${label}, 0 bits differ`, different ? `${different} values differ` : '');
        gl.deleteProgram(linked);
        textures.destroy();
        material.close();
    }
}

export async function run(job) {
    const gl = context();
    const renderer = gl.getExtension('WEBGL_debug_renderer_info');
    await note(`${navigator.userAgent}; ${renderer ? gl.getParameter(renderer.UNMASKED_RENDERER_WEBGL) : gl.getParameter(gl.RENDERER)}`);
    const { failures, names } = await selfTest(gl);
    await report('self-test', failures ? names.join(', ') : '');
    await compareReference(gl, job.golden);
    const vectors = await json('/vectors/vectors.json');
    await compareVectors(gl, vectors);
    const zero = vectors.filter((_, i) => i % 4 === 0);
    await control(gl, 'a zero that the compiler knows', zero, (text) => `#define BTF_ZERO 0u\n${text}`, job.noticesZero);
    const shift = vectors.filter(({ effects, about }) => effects.includes('shift') && !about.startsWith('1x1')).slice(0, 4);
    await control(gl, 'swapped shift bytes', shift, (text) => changed(changed(changed(text, 'btf_shift_of(codes.y)', 'swap'),
        'btf_shift_of(codes.z)', 'btf_shift_of(codes.y)'), 'swap', 'btf_shift_of(codes.z)'), true);
    release(gl);
}
