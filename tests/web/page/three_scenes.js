/* Builds the scenes of scenes.mjs in three.js, and compares pictures with those that btf-render drew. The page's import
 * map chooses the build of three.
 *
 * SPDX-License-Identifier: MIT
 */
import * as THREE from 'three';
import { pixelsOf } from './frame.js';
import { bytes, note, picture, report } from './post.js';

/* The prefix of the cases' names. */
export const ENGINE = 'WebGPURenderer' in THREE ? 'three-webgpu' : 'three';

/* The difference, of 255, above which a pixel counts as far from btf-render's. btf-render casts rays in double
 * precision, where three interpolates over triangles in single precision: silhouettes, edges of shadows and levels of
 * detail differ in some pixels. */
const NEAR = 2;

/** theta from z, phi from x towards y, degrees. */
function direction(theta, phi) {
    const [t, p] = [theta, phi].map(THREE.MathUtils.degToRad);
    return new THREE.Vector3(Math.sin(t) * Math.cos(p), Math.sin(t) * Math.sin(p), Math.cos(t));
}

function cameraOf({ view, zoom, fov = 30 }) {
    const half = 1 / zoom, distance = fov ? half / Math.tan(THREE.MathUtils.degToRad(fov / 2)) : 4;
    const camera = fov ? new THREE.PerspectiveCamera(fov, 1, 0.1, 20) : new THREE.OrthographicCamera(-half, half, half, -half, 0.1, 20);
    camera.position.copy(direction(...view)).multiplyScalar(distance);
    camera.lookAt(0, 0, 0);
    return camera;
}

/* The meshes as btf-render has them: the u of three's sphere begins elsewhere, and runs around it once, not twice. */
function meshesOf({ mesh, squares, repeat }, material) {
    if (mesh === 'sphere') {
        material.repeat.set(2 * repeat, repeat);
        const sphere = new THREE.Mesh(new THREE.SphereGeometry(1, 128, 64), material);
        sphere.rotation.y = -Math.PI / 2;
        return [sphere];
    }
    material.repeat.set(repeat, repeat);
    return (squares ?? [{ z: 0, half: 1 }]).map(({ z, half }) => {
        const plane = new THREE.Mesh(new THREE.PlaneGeometry(2 * half, 2 * half), material);
        plane.position.z = z;
        return plane;
    });
}

function lightOf({ at, theta, phi, intensity, colour = [1, 1, 1] }, shadows) {
    const three = Math.PI * intensity;
    const light = at ? new THREE.PointLight('white', three) : new THREE.DirectionalLight('white', three);
    light.color.setRGB(...colour);
    light.position.copy(at ? new THREE.Vector3(...at) : direction(theta, phi).multiplyScalar(3));
    light.castShadow = Boolean(shadows);
    light.shadow.mapSize.set(1024, 1024);
    light.shadow.normalBias = 0.01;
    if (!at) {
        Object.assign(light.shadow.camera, { left: -1.1, right: 1.1, bottom: -1.1, top: 1.1, near: 0.5, far: 6 });
    }
    return light;
}

/** A scene of scenes.mjs with the material. */
export function build(scene, material) {
    const world = new THREE.Scene();
    material.side = THREE.DoubleSide;
    for (const mesh of meshesOf(scene, material)) {
        mesh.castShadow = mesh.receiveShadow = true;
        world.add(mesh);
    }
    world.add(...scene.lights.map((light) => lightOf(light, scene.shadows)));
    return world;
}

export function drawn(renderer, scene, world) {
    renderer.toneMapping = scene.tone ? THREE.ReinhardToneMapping : THREE.NoToneMapping;
    renderer.shadowMap.enabled = true;
    renderer.shadowMap.type = THREE.BasicShadowMap;
    renderer.render(world, cameraOf(scene));
    return pixelsOf(renderer.domElement);
}

async function pictureOf({ picture }) {
    const image = await createImageBitmap(new Blob([await bytes(`/scenes/${picture}`)]), { colorSpaceConversion: 'none' });
    return pixelsOf(image);
}

/** Compares two pictures over the pixels that are not empty in both. */
function compare(a, b) {
    const seen = [];
    for (let i = 0; i < a.length; i += 4) {
        if (a[i] + a[i + 1] + a[i + 2] + b[i] + b[i + 1] + b[i + 2] > 0) {
            seen.push(Math.max(...[0, 1, 2].map((c) => Math.abs(a[i + c] - b[i + c]))));
        }
    }
    const far = seen.filter((difference) => difference > NEAR).length;
    return { far: far / seen.length, mean: seen.reduce((sum, x) => sum + x, 0) / seen.length, count: seen.length };
}

/** Reports a comparison: at most `share` of the pixels far apart, and enough of them lit. */
export async function near(name, a, b, share) {
    const { far, mean, count } = compare(a, b);
    const text = `${(100 * far).toFixed(2)} % of ${count} pixels are more than ${NEAR} of 255 apart, ${mean.toFixed(2)} in the mean`;
    await note(`${ENGINE}: ${name}: ${text}`);
    await report(`${ENGINE}: ${name}: at most ${100 * share} % of the pixels more than ${NEAR} of 255 apart`, far <= share && count > 1000 ? '' : text);
}

/** Reports a control: two pictures that must differ in half of their pixels. */
export async function far(name, a, b) {
    const share = compare(a, b).far;
    await report(`${ENGINE}: ${name}: more than half of the pixels differ`, share > 0.5 ? '' : `${(100 * share).toFixed(2)} %`);
}

const isDark = (pixels, i) => pixels[i] + pixels[i + 1] + pixels[i + 2] === 0;

/** Pixels that are lit in one picture and dark in another. */
function darkened(lit, dark) {
    const found = new Set();
    for (let i = 0; i < lit.length; i += 4) {
        if (!isDark(lit, i) && isDark(dark, i)) {
            found.add(i);
        }
    }
    return found;
}

export async function compareScenes(renderer, material, scenes) {
    for (const scene of scenes) {
        const world = build(scene, material);
        const theirs = await pictureOf(scene), ours = drawn(renderer, scene, world);
        await picture(`${ENGINE} ${scene.name}`, ours, renderer.domElement.width);
        // tangents computed by triangle are those of a sphere of 128 by 64 facets, and so differ more
        await near(scene.name, ours, theirs, scene.mesh === 'sphere' ? 0.2 : 0.02);
        if (scene.mesh === 'sphere') {
            const sphere = world.children[0];
            sphere.geometry = sphere.geometry.clone(); // three's WebGPURenderer reads a geometry's attributes only once
            sphere.geometry.computeTangents();
            await near(`${scene.name}, with tangents`, drawn(renderer, scene, world), theirs, 0.02);
        }
        if (scene.shadows) {
            world.children.forEach((object) => { object.castShadow = false; });
            const lit = drawn(renderer, scene, world);
            const [a, b] = [darkened(lit, ours), darkened(lit, theirs)];
            const both = Array.from(a).filter((i) => b.has(i)).length, either = a.size + b.size - both;
            const text = `${a.size} pixels darkened, ${b.size} by btf-render, ${both} by both`;
            await note(`${ENGINE}: ${scene.name}: ${text}`);
            await report(`${ENGINE}: ${scene.name}: falls where btf-render's does, 95 % of it`, both > 200 && both >= 0.95 * either ? '' : text);
        }
    }
}

/** Inside its cone a spot light is a point light; outside it is dark. */
export async function compareSpot(renderer, material, scene) {
    const world = build({ ...scene, shadows: false }, material);
    const point = world.children.find((child) => child.isPointLight);
    const all = drawn(renderer, scene, world);
    const spot = new THREE.SpotLight('white', point.intensity, 0, 0.25);
    spot.position.copy(point.position);
    world.remove(point);
    world.add(spot);
    const ours = drawn(renderer, scene, world);
    let lit = 0, dark = 0, other = 0;
    for (let i = 0; i < all.length; i += 4) {
        if (!isDark(all, i)) {
            const same = [0, 1, 2].every((c) => Math.abs(all[i + c] - ours[i + c]) <= 1);
            [lit, dark, other] = [lit + same, dark + (!same && isDark(ours, i)), other + (!same && !isDark(ours, i))];
        }
    }
    const text = `${lit} pixels as under a point light, ${dark} dark, ${other} neither`;
    await note(`${ENGINE}: spot: ${text}`);
    await report(`${ENGINE}: a spot light is a point light within its cone, and dark outside`, lit > 1000 && dark > 1000 && other < 0.01 * lit ? '' : text);
}

/** Two materials in one scene keep their programs and textures apart. */
export async function compareTwo(renderer, scene, material, other) {
    const alone = [material, other].map((shown) => drawn(renderer, scene, build(scene, shown)));
    const world = build(scene, material);
    const right = new THREE.Mesh(new THREE.PlaneGeometry(1, 2), other);
    world.children[0].geometry = new THREE.PlaneGeometry(1, 2);
    world.children[0].position.x = -0.5;
    right.position.x = 0.5;
    right.receiveShadow = true;
    world.add(right);
    for (const [plane, first] of [[world.children[0], 0], [right, 0.5]]) { // halves of the square's uv
        const { uv } = plane.geometry.attributes;
        for (let i = 0; i < uv.count; i++) {
            uv.setX(i, first + uv.getX(i) / 2);
        }
    }
    const both = drawn(renderer, scene, world);
    const onlyLeft = both.slice(), onlyRight = both.slice();
    const [left, rest] = alone.map((pixels) => pixels.slice());
    for (let i = 0; i < both.length; i += 4) { // seen from straight above, the left half is the left half
        const [blank, blankOf] = (i / 4) % renderer.domElement.width < renderer.domElement.width / 2 ? [onlyRight, rest] : [onlyLeft, left];
        blank.fill(0, i, i + 3);
        blankOf.fill(0, i, i + 3);
    }
    await near('two materials, the left', onlyLeft, left, 0.02);
    await near('two materials, the right', onlyRight, rest, 0.02);
    await far('control: the two materials differ', ...alone);
}

/** How many pixels are lit. */
const litOf = (pixels) => Array.from({ length: pixels.length / 4 }, (_, i) => !isDark(pixels, 4 * i)).filter(Boolean).length;

/** `opacity` acts where `transparent` is set, as of three's own materials, and when it changes. */
export async function compareOpacity(renderer, scene, material) {
    const whole = drawn(renderer, scene, build(scene, material));
    const glass = material.clone(), opaque = material.clone();
    Object.assign(glass, { transparent: true, opacity: 0 });
    opaque.opacity = 0;
    const world = build(scene, glass);
    const lit = litOf(drawn(renderer, scene, world));
    await report(`${ENGINE}: of opacity 0 nothing is seen`, lit === 0 ? '' : `${lit} pixels are lit`);
    glass.opacity = 1;
    await near('of opacity 1, what was transparent', drawn(renderer, scene, world), whole, 0);
    await near('opacity without transparent', drawn(renderer, scene, build(scene, opaque)), whole, 0);
    glass.dispose();
    opaque.dispose();
}

/** Checks code and message of the error that `body` throws. */
async function refuses(name, pattern, body) {
    let said = 'nothing is refused';
    try {
        body();
    } catch (error) {
        said = `${error.code} ${error.message}`;
    }
    await report(`${ENGINE}: refused: ${name}`, pattern.test(said) ? '' : said);
}

/** Arguments that a material of either renderer refuses. Closes `other`. */
export async function refusesArguments(BTFMaterial, btf, other) {
    await refuses('an option that is none', /^USAGE .*picks/, () => new BTFMaterial(btf, { decode: { picks: 'all' } }));
    await refuses('three repeats', /^USAGE repeat/, () => new BTFMaterial(btf, { repeat: [1, 2, 3] }));
    other.close();
    await refuses('a material that is closed', /^USAGE the material is closed/, () => new BTFMaterial(other));
}
