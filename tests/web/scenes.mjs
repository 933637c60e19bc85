/* Scenes that btf-render and three.js must draw alike, and the calls of btf-render that draw them. * Both have x to the
 * right, y up, and z to the default camera. A light's intensity of 1 in btf-render is one of pi in three.
 *
 * SPDX-License-Identifier: MIT
 */
import { spawnSync } from 'node:child_process';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';

export const SIDE = 192;

/* A square at height z, of half a side, with its copy of the unit of uv. */
const square = (z, half) => ({ z, half });
/* The ground and a smaller square over it. btf-render scales what it reads into the unit sphere: this is there already, for the
 * ground's corners have length 1, and the box around all is centred. */
const HIGH = 0.2;
const SQUARES = [square(-HIGH, Math.sqrt((1 - HIGH ** 2) / 2)), square(HIGH, 0.25)];

/** Scenes. A light comes from a direction, in degrees, or from a point; `reach` is the half angle of a cone towards the origin. */
export const SCENES = [
    { name: 'plane', mesh: 'plane', zoom: 1, repeat: 2, view: [35, -70], lights: [{ theta: 40, phi: 120, intensity: 1.5 }] },
    { name: 'plane with reinhard', mesh: 'plane', zoom: 1, repeat: 2, view: [20, 30], tone: 'reinhard',
        lights: [{ theta: 30, phi: 10, intensity: 4, colour: [1, 0.8, 0.6] }] },
    { name: 'plane in parallel projection', mesh: 'plane', zoom: 1, repeat: 2, view: [50, 200], fov: 0,
        lights: [{ theta: 20, phi: 90, intensity: 1.5 }] },
    { name: 'plane from behind', mesh: 'plane', zoom: 1, repeat: 2, view: [150, 20], lights: [{ theta: 130, phi: 60, intensity: 1.5 }] },
    { name: 'sphere', mesh: 'sphere', zoom: 0.9, repeat: 3, view: [40, -60],
        lights: [{ theta: 50, phi: 100, intensity: 1.2, colour: [1, 0.7, 0.4] }, { at: [1.2, -0.8, 2], intensity: 4 }] },
    { name: 'shadow', mesh: 'squares', squares: SQUARES, zoom: 0.9, repeat: 2, view: [30, -80], shadows: true,
        lights: [{ theta: 50, phi: 20, intensity: 1.5 }] },
    { name: 'shadow of a point', mesh: 'squares', squares: SQUARES, zoom: 0.9, repeat: 2, view: [30, -80], shadows: true,
        lights: [{ at: [0.9, 0.5, 1.2], intensity: 3 }] },
];

/* The squares as a Wavefront file. */
function objOf(squares) {
    const lines = ['vn 0 0 1', 'vt 0 0', 'vt 1 0', 'vt 1 1', 'vt 0 1'];
    squares.forEach(({ z, half }, i) => {
        for (const [x, y] of [[-1, -1], [1, -1], [1, 1], [-1, 1]]) {
            lines.push(`v ${x * half} ${y * half} ${z}`);
        }
        lines.push(`f ${[1, 2, 3, 4].map((k) => `${4 * i + k}/${k}/1`).join(' ')}`);
    });
    return `${lines.join('\n')}\n`;
}

/** The name of a scene's picture. */
export const fileOf = ({ name }) => `${name.replaceAll(' ', '-')}.png`;

/** Has btf-render draw every scene into FOLDER. Ends the process with a message where it fails. */
export function drawScenes(btfRender, material, folder) {
    for (const scene of SCENES) {
        let { mesh } = scene;
        if (scene.squares) {
            mesh = join(folder, 'squares.obj');
            writeFileSync(mesh, objOf(scene.squares));
        }
        const args = [material, '-o', join(folder, fileOf(scene)), '--mesh', mesh, '--size', SIDE, '--view', scene.view.join(','),
            '--zoom', scene.zoom, '--repeat', scene.repeat, '--fov', scene.fov ?? 30, '--filter', 'bilinear', '--device', 'reference', '--quiet'];
        for (const { at, theta, phi, intensity, colour = [1, 1, 1] } of scene.lights) {
            args.push(at ? '--point' : '--light', [...(at ?? [theta, phi]), intensity, ...colour].join(','));
        }
        if (scene.tone) {
            args.push('--tone', scene.tone);
        }
        if (scene.shadows) {
            args.push('--cast-shadows');
        }
        const { status, stderr } = spawnSync(btfRender, args.map(String), { encoding: 'utf-8' });
        if (status !== 0) {
            console.log(`btf-render ${args.join(' ')}: exit code ${status}\n${stderr}`);
            process.exit(1);
        }
    }
}
