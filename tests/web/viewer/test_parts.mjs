/* The parts of the viewer that need no browser: links, environments, models, camera.
 *
 * SPDX-License-Identifier: MIT
 */
import assert from 'node:assert/strict';
import { angles, camera, cross, direction, dot, turned } from '../../../decoder/web/viewer/camera.js';
import { Sampler, madeEnvironment, shrunk } from '../../../decoder/web/viewer/environment.js';
import { readHdr } from '../../../decoder/web/viewer/hdr.js';
import { MESHES, VERTEX_FLOATS, mesh } from '../../../decoder/web/viewer/meshes.js';
import { hashOf, initialState, stateOf } from '../../../decoder/web/viewer/state.js';
import { exitCode, test } from '../harness.mjs';

const near = (a, b, tolerance, what) => assert.ok(Math.abs(a - b) <= tolerance, `${what}: ${a}, not ${b} within ${tolerance}`);

await test('viewer parts: a link gives the state again', () => {
    assert.equal(hashOf(initialState()), '');
    const state = { ...initialState(), mesh: 'torus', theta: 33.3, out: ['shadow', 'gain'], material: 'a&b=c', exposure: -1.25, level: 0, compare: 'full' };
    assert.deepEqual(stateOf(`#${hashOf(state)}`), state);
    assert.equal(stateOf(hashOf({ ...state, environment: 'own' })).environment, 'none', 'a file of the user is in no link');
});

await test('viewer parts: a link that is wrong gives what it may', () => {
    const state = stateOf('#theta=1e9&phi=&zoom=-4&mesh=cube&out=gain+nonsense&__proto__=1&constructor=2&exposure=NaN&turn=12&material=%E0%A4%A');
    assert.deepEqual(state, { ...initialState(), theta: 180, zoom: 0.2, out: ['gain'], turn: 12 });
});

/** A file of Radiance's with these rows. */
const hdr = (width, height, rows, header = 'FORMAT=32-bit_rle_rgbe\n') => Buffer.concat([
    Buffer.from(`#?RADIANCE\n${header}\n-Y ${height} +X ${width}\n`, 'latin1'), Buffer.from(rows)]);

await test('viewer parts: .hdr files, packed and plain', () => {
    const packed = readHdr(hdr(8, 1, [2, 2, 0, 8, 136, 128, 136, 64, 8, 0, 1, 2, 3, 4, 5, 6, 7, 136, 129]));
    assert.deepEqual([packed.width, packed.height], [8, 1]);
    assert.deepEqual([...packed.pixels.slice(9, 12)], [1, 0.5, 3 / 128]);
    const plain = readHdr(hdr(3, 2, [128, 64, 32, 129, 1, 1, 1, 2, 0, 0, 0, 0, 128, 0, 0, 130, 128, 0, 0, 129], 'EXPOSURE=2\n'));
    assert.deepEqual([...plain.pixels.slice(0, 9)], [0.5, 0.25, 0.125, 0.5, 0.25, 0.125, 0.5, 0.25, 0.125]);
    assert.deepEqual([...plain.pixels.slice(9, 18)], [0, 0, 0, 1, 0, 0, 0.5, 0, 0]);
});

await test('viewer parts: .hdr files that are wrong are refused in words', () => {
    for (const [data, pattern] of [
        [Buffer.from('no image\n'), /does not begin with/],
        [Buffer.from('#?RADIANCE\n'), /header does not end/],
        [hdr(8, 4, [2, 2, 0, 8, 136]), /ends before its last pixel/],
        [hdr(8, 1, [2, 2, 0, 8, 137, 1]), /a run of 9 pixels where 8 are left/],
        [hdr(2, 1, [1, 2, 3, 4, 1, 1, 1, 9]), /a run is longer than its row/],
        [hdr(2, 1, [], 'FORMAT=32-bit_rle_xyze\n'), /FORMAT is 32-bit_rle_xyze/],
        [hdr(99999, 99999, []), /99999 x 99999 pixels; at most/],
        [hdr(1000, 20000, []), /^Error: 1000 x 20000 pixels: .* wider than high/],
        [hdr(8, 4, [], 'A=1\n'.repeat(20000)), /header does not end: at most 65536 bytes/],
        [hdr(8, 4, [], `A=${'1'.repeat(5000)}\n`), /header does not end/],
    ]) {
        assert.throws(() => readHdr(data), pattern);
    }
});

/* Irradiance over pi on a surface of a normal, by summing all pixels. */
function summed({ width, height, pixels }, normal) {
    const out = [0, 0, 0];
    for (let y = 0; y < height; y++) {
        const angle = (Math.cos((Math.PI * y) / height) - Math.cos((Math.PI * (y + 1)) / height)) * ((2 * Math.PI) / width);
        for (let x = 0; x < width; x++) {
            const theta = (Math.PI * (y + 0.5)) / height, longitude = ((2 * (x + 0.5)) / width - 1) * Math.PI;
            const d = [Math.sin(theta) * Math.sin(longitude), Math.cos(theta), -Math.sin(theta) * Math.cos(longitude)];
            const weight = (angle * Math.max(dot(d, normal), 0)) / Math.PI;
            out.forEach((_, c) => { out[c] += weight * pixels[3 * (y * width + x) + c]; });
        }
    }
    return out;
}

await test('viewer parts: the lights of an environment add up to it', () => {
    for (const image of [madeEnvironment('studio'), madeEnvironment('sky'), shrunk(madeEnvironment('sky'), 64)]) {
        const sampler = new Sampler(image);
        for (const normal of [[0, 1, 0], [0, 0, 1], [0.6, 0, -0.8]]) {
            const sum = [0, 0, 0], samples = 2000;
            for (let number = 0; number < samples; number++) {
                for (const { at, colour } of sampler.lights(number, 4, 0)) {
                    sum.forEach((_, c) => { sum[c] += (colour[c] * Math.max(dot(at, normal), 0)) / samples; });
                }
            }
            const wanted = summed(image, normal);
            sum.forEach((value, c) => near(value, wanted[c], 0.02 * wanted[c] + 0.002, `channel ${c} on ${normal}`));
        }
    }
    const turned90 = new Sampler(madeEnvironment('sky')).lights(0, 1, 90)[0].at, at = new Sampler(madeEnvironment('sky')).lights(0, 1, 0)[0].at;
    near(turned90[0], -at[2], 1e-6, 'turned by 90 degrees to the right');
});

await test('viewer parts: models have unit frames, lie within a cube, and face outwards', () => {
    for (const name of MESHES) {
        const { vertices, triangles } = mesh(name);
        const vertex = (i) => vertices.subarray(VERTEX_FLOATS * i, VERTEX_FLOATS * (i + 1));
        for (let i = 0; i < vertices.length / VERTEX_FLOATS; i++) {
            const v = vertex(i), normal = v.subarray(3, 6), tangent = v.subarray(8, 11);
            assert.ok(v.subarray(0, 3).every((x) => Math.abs(x) <= 1.0001), name);
            near(dot(normal, normal), 1, 1e-4, `${name}: normal`);
            near(dot(tangent, tangent), 1, 1e-4, `${name}: tangent`);
            near(dot(normal, tangent), 0, 1e-3, `${name}: normal on tangent`);
        }
        for (let i = 0; i < triangles.length; i += 3) {
            const [a, b, c] = [0, 1, 2].map((k) => vertex(triangles[i + k]));
            const edge = (p) => [p[0] - a[0], p[1] - a[1], p[2] - a[2]];
            assert.ok(dot(cross(edge(b), edge(c)), a.subarray(3, 6)) >= -1e-7, `${name}: triangle ${i / 3} faces inwards`);
        }
        assert.ok(vertices.length / VERTEX_FLOATS <= 65536, name);
    }
});

await test('viewer parts: the camera sees the origin in its middle, +y up, +x on the right', () => {
    const project = ({ matrix }, p) => {
        const clip = [0, 1, 2, 3].map((row) => p.reduce((sum, x, column) => sum + matrix[4 * column + row] * x, matrix[12 + row]));
        return clip.map((x) => x / clip[3]);
    };
    const front = camera({ theta: 0, phi: 0, zoom: 1 }, 400, 200);
    const middle = project(front, [0, 0, 0]);
    near(middle[0], 0, 1e-6, 'x');
    near(middle[1], 0, 1e-6, 'y');
    near(project(front, [0, 1, 0])[1], 1, 1e-5, 'the shorter side shows 2 / zoom');
    near(project(front, [1, 0, 0])[0], 0.5, 1e-5, 'the longer side shows more');
    assert.ok(project(front, [0, 0, 0.5])[2] < project(front, [0, 0, -0.5])[2], 'what is near is in front');
    near(project(camera({ theta: 0, phi: 0, zoom: 1 }, 400, 200, [0.5, 0]), [0, 0, 0])[0], 0.5 / 200, 1e-6, 'half a pixel to the right');
    const [theta, phi] = angles(direction(37, -110));
    near(theta, 37, 1e-9, 'theta');
    near(phi, -110, 1e-9, 'phi');
    const [over] = turned(10, 90, 0, 10);
    near(over, 89, 1e-6, 'a drag stops short of the pole');
});

process.exit(exitCode());
