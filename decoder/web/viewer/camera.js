/* The viewer's camera and light: directions by angles, and the matrix to the screen. World and angles are those of btf-render and
 * btf-view: x to the right, y up, z towards the camera at angles 0; theta from z, phi from x towards y, degrees.
 *
 * SPDX-License-Identifier: MIT
 */
const DEGREE = Math.PI / 180;
const FIELD = 30; // degrees of the shorter side, as btf-view's

export const clamp = (x, low, high) => Math.min(Math.max(x, low), high);
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const scale = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
export const unit = (a) => scale(a, 1 / (Math.hypot(...a) || 1));

/** The unit vector at angles in degrees. */
export function direction(theta, phi) {
    const [t, p] = [theta * DEGREE, phi * DEGREE];
    return [Math.sin(t) * Math.cos(p), Math.sin(t) * Math.sin(p), Math.cos(t)];
}

/** [theta, phi] in degrees of a unit vector. */
export function angles([x, y, z]) {
    return [Math.acos(clamp(z, -1, 1)) / DEGREE, Math.atan2(y, x) / DEGREE];
}

/**
 * A direction turned about the picture's axes, as longitude round y and latitude, which stops short of the poles.
 * @param dx, dy in radians
 * @returns [theta, phi]
 */
export function turned(theta, phi, dx, dy) {
    const [x, y, z] = direction(theta, phi);
    const longitude = Math.atan2(x, z) + dx;
    const latitude = clamp(Math.asin(clamp(y, -1, 1)) + dy, -89 * DEGREE, 89 * DEGREE);
    return angles([Math.cos(latitude) * Math.sin(longitude), Math.sin(latitude), Math.cos(latitude) * Math.cos(longitude)]);
}

/**
 * Where a picture is seen from.
 * @param zoom the shorter side shows 2 / zoom of the world at the origin
 * @param shift of the picture, in pixels, for samples within a pixel
 * @returns {eye, right, up, back: unit vectors but for eye; tangents: half the picture at distance 1, across and up;
 *   matrix: world to clip, [16] by column}
 */
export function camera({ theta, phi, zoom }, width, height, shift = [0, 0]) {
    const back = direction(theta, phi);
    // +y is up; from straight above or below, where that says nothing, the limit along phi
    const across = cross([0, 1, 0], back);
    const right = Math.hypot(...across) > 1e-6 ? unit(across) : [1, 0, 0];
    const up = cross(back, right);
    const distance = 1 / zoom / Math.tan((FIELD / 2) * DEGREE);
    const eye = scale(back, distance);
    const shorter = Math.min(width, height);
    const tangents = [width, height].map((side) => (side / shorter) * Math.tan((FIELD / 2) * DEGREE));
    const near = Math.max(distance - 2, distance / 50), far = distance + 2;
    const rows = [
        scale(right, 1 / tangents[0]), scale(up, 1 / tangents[1]),
        scale(back, -(far + near) / (far - near)), scale(back, -1),
    ];
    const matrix = new Float32Array(16);
    for (let column = 0; column < 3; column++) {
        rows.forEach((row, i) => { matrix[4 * column + i] = row[column]; });
    }
    matrix[14] = ((far + near) * distance - 2 * far * near) / (far - near);
    matrix[15] = distance;
    // a shift in pixels is one in clip space times w
    for (let column = 0; column < 4; column++) {
        matrix[4 * column] += (2 * shift[0] / width) * matrix[4 * column + 3];
        matrix[4 * column + 1] += (2 * shift[1] / height) * matrix[4 * column + 3];
    }
    return { eye, right, up, back, tangents, matrix };
}
