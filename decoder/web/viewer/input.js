/* Pointer, wheel and keyboard on the picture.
 *
 * One pointer turns the model, with the right button or Shift it moves the light; two fingers zoom, and move the light by what they
 * move together.
 *
 * SPDX-License-Identifier: MIT
 */
import { clamp, turned } from './camera.js';
import { MEMBERS } from './state.js';

const DEGREE = Math.PI / 180;
const STEP = 5; // degrees that a key turns by

const within = (name, value) => clamp(value, MEMBERS[name].low, MEMBERS[name].high);

/** Turns the model by a drag, in parts of the picture's shorter side. */
export function orbit(state, dx, dy) {
    [state.theta, state.phi] = turned(state.theta, state.phi, -dx * Math.PI, dy * Math.PI);
}

/** Moves the light by a drag, likewise. */
export function moveLight(state, dx, dy) {
    [state.lightTheta, state.lightPhi] = turned(state.lightTheta, state.lightPhi, dx * Math.PI, -dy * Math.PI);
}

export function zoomBy(state, factor) {
    state.zoom = within('zoom', state.zoom * factor);
}

export function expose(state, stops) {
    state.exposure = within('exposure', state.exposure + stops);
}

/**
 * Listens on the picture's element.
 * @param change called with what was done: 'orbit', 'light' or 'zoom'
 */
export function listenPointers(element, state, change) {
    const pointers = new Map();
    const place = ({ clientX, clientY }) => [clientX, clientY];
    const shorter = () => Math.max(Math.min(element.clientWidth, element.clientHeight), 1);

    element.addEventListener('contextmenu', (event) => event.preventDefault());
    element.addEventListener('pointerdown', (event) => {
        element.setPointerCapture(event.pointerId);
        element.focus({ preventScroll: true });
        pointers.set(event.pointerId, place(event));
        event.preventDefault();
    });
    const leave = (event) => pointers.delete(event.pointerId);
    ['pointerup', 'pointercancel', 'lostpointercapture'].forEach((name) => element.addEventListener(name, leave));

    element.addEventListener('pointermove', (event) => {
        const before = pointers.get(event.pointerId);
        if (!before) {
            return;
        }
        const now = place(event);
        const [dx, dy] = [0, 1].map((i) => (now[i] - before[i]) / shorter());
        pointers.set(event.pointerId, now);
        if (pointers.size > 1) {
            const other = [...pointers].find(([id]) => id !== event.pointerId)[1];
            const length = (from) => Math.max(Math.hypot(from[0] - other[0], from[1] - other[1]), 1);
            zoomBy(state, length(now) / length(before));
            moveLight(state, dx / 2, dy / 2);
            change('zoom');
        } else if (event.buttons & 2 || event.shiftKey) {
            moveLight(state, dx, dy);
            change('light');
        } else {
            orbit(state, dx, dy);
            change('orbit');
        }
    });
    element.addEventListener('wheel', (event) => {
        event.preventDefault();
        const pixels = event.deltaMode === 0 ? event.deltaY : event.deltaY * 30;
        zoomBy(state, Math.exp(-clamp(pixels, -200, 200) / 600));
        change('zoom');
    }, { passive: false });
}

/* By key: what it does with the state, and the name of it. Shift makes arrows move the light. */
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

/**
 * Listens for keys on the picture's element.
 * @param actions by key: functions, beside turning, zooming and exposing
 */
export function listenKeys(element, state, change, actions) {
    element.addEventListener('keydown', (event) => {
        if (event.ctrlKey || event.metaKey || event.altKey) {
            return;
        }
        const arrow = ARROWS[event.key];
        const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
        if (arrow) {
            const [dx, dy] = arrow.map((part) => (part * STEP * DEGREE) / Math.PI);
            (event.shiftKey ? moveLight : orbit)(state, dx, dy);
            change(event.shiftKey ? 'light' : 'orbit');
        } else if (key === '+' || key === '=' || key === '-') {
            zoomBy(state, key === '-' ? 1 / 1.1 : 1.1);
            change('zoom');
        } else if (key === ',' || key === '.') {
            expose(state, key === ',' ? -0.25 : 0.25);
            change('exposure');
        } else if (Object.hasOwn(actions, key)) {
            actions[key]();
        } else {
            return;
        }
        event.preventDefault();
    });
}
