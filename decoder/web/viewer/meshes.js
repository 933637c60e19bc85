/* The viewer's models, made by formula: plane, sphere, cylinder, torus and a cloth that hangs in folds. All lie within [-1, 1] on
 * each axis. Plane, sphere, torus and cloth have the shapes and texture coordinates of btf-view's plane, sphere, torus and drape.
 *
 * SPDX-License-Identifier: MIT
 */
import { unit } from './camera.js';

const { sin, cos, PI } = Math;

/* The height of the cloth, which hangs from its upper edge: folds deepen downwards. */
function clothHeight(x, y) {
    const hang = 0.5 * (1 - y);
    return 0.13 * hang * sin(5.5 * x + 0.8 * sin(2.1 * y)) + 0.035 * hang * cos(9 * x - 1.7 * y) + 0.1 * cos(1.9 * x + 0.4)
        + 0.05 * sin(2.3 * y);
}

/* By name: the point at (s, t) in [0, 1]^2 as [position, unit normal, unit tangent along +u], how finely it is divided, and how often
 * the material lies along s and t. */
const SURFACES = {
    plane: { divide: [1, 1], repeat: [1, 1], at: (s, t) => [[2 * s - 1, 2 * t - 1, 0], [0, 0, 1], [1, 0, 0]] },
    sphere: {
        divide: [96, 64], repeat: [2, 1],
        at(s, t) {
            const longitude = (2 * s - 1) * PI, latitude = (t - 0.5) * PI;
            const p = [cos(latitude) * sin(longitude), sin(latitude), cos(latitude) * cos(longitude)];
            return [p, p, [cos(longitude), 0, -sin(longitude)]];
        },
    },
    cylinder: {
        divide: [96, 1], repeat: [2, 1],
        at(s, t) {
            const radius = 0.62, longitude = (2 * s - 1) * PI;
            const normal = [sin(longitude), 0, cos(longitude)];
            return [[radius * normal[0], 1.9 * t - 0.95, radius * normal[2]], normal, [cos(longitude), 0, -sin(longitude)]];
        },
    },
    torus: {
        divide: [128, 64], repeat: [2, 1],
        at(s, t) {
            const major = 0.68, minor = 0.3, lean = 0.9; // leans towards the camera, so that the hole is seen
            const a = 2 * PI * s, b = 2 * PI * t;
            const leant = ([x, y, z]) => [x, cos(lean) * y + sin(lean) * z, cos(lean) * z - sin(lean) * y];
            const normal = [cos(a) * cos(b), sin(a) * cos(b), sin(b)];
            return [leant([major * cos(a) + minor * normal[0], major * sin(a) + minor * normal[1], minor * normal[2]]), leant(normal),
                leant([-sin(a), cos(a), 0])];
        },
    },
    cloth: {
        divide: [96, 96], repeat: [1, 1],
        at(s, t) {
            const step = 1e-4, x = 2 * s - 1, y = 2 * t - 1;
            const dx = (clothHeight(x + step, y) - clothHeight(x - step, y)) / (2 * step);
            const dy = (clothHeight(x, y + step) - clothHeight(x, y - step)) / (2 * step);
            return [[0.9 * x, 0.9 * y, 0.9 * clothHeight(x, y)], unit([-dx, -dy, 1]), unit([1, 0, dx])];
        },
    },
};

export const MESHES = Object.keys(SURFACES);

/** Floats of a vertex: position 3, normal 3, uv 2, tangent 3. */
export const VERTEX_FLOATS = 11;

/**
 * A model by name.
 * @returns {vertices: Float32Array [count][VERTEX_FLOATS], triangles: Uint16Array [count][3], counter-clockwise from outside}
 */
export function mesh(name) {
    const { divide: [columns, rows], repeat, at } = SURFACES[name];
    const vertices = [], triangles = [];
    for (let j = 0; j <= rows; j++) {
        for (let i = 0; i <= columns; i++) {
            const [s, t] = [i / columns, j / rows];
            const [position, normal, tangent] = at(s, t);
            vertices.push(...position, ...normal, s * repeat[0], t * repeat[1], ...tangent);
        }
    }
    for (let j = 0; j < rows; j++) {
        for (let i = 0; i < columns; i++) {
            const a = j * (columns + 1) + i, b = a + columns + 1;
            triangles.push(a, a + 1, b + 1, a, b + 1, b);
        }
    }
    return { vertices: Float32Array.from(vertices), triangles: Uint16Array.from(triangles) };
}
