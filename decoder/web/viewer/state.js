/* The view that is shown, as one plain object, and the same as the text behind # of a link.
 *
 * SPDX-License-Identifier: MIT
 */
import { clamp } from './camera.js';
import { MESHES } from './meshes.js';

export const EFFECTS = ['shadow', 'shift', 'hidden', 'gain', 'residual', 'relief', 'gloss'];
export const ENVIRONMENTS = ['none', 'studio', 'sky', 'own'];

const number = (otherwise, low, high, digits = 2) => ({ otherwise, low, high, digits });
const choice = (otherwise, list) => ({ otherwise, list });

/* Each member: what it is without a word, and what else it may be. Their order is the link's. */
export const MEMBERS = {
    material: { otherwise: '', text: true }, // of those in the page; '': the first
    mesh: choice('cloth', MESHES),
    theta: number(25, 0, 180, 1), // of the camera, degrees
    phi: number(55, -180, 180, 1),
    zoom: number(0.95, 0.2, 8),
    repeat: number(2, 0.25, 16), // of the material on the model
    sun: number(1, 0, 4), // irradiance of the light over pi, at normal incidence
    lightTheta: number(48, 0, 180, 1),
    lightPhi: number(125, -180, 180, 1),
    environment: choice('none', ENVIRONMENTS),
    strength: number(1, 0, 8), // of the environment
    turn: number(0, -180, 180, 1), // of the environment, degrees to the right
    backdrop: choice('on', ['on', 'off']), // the environment behind the model
    exposure: number(0, -6, 6), // stops
    out: { otherwise: [], effects: true }, // effects left out
    units: number(0, 0, 65535, 0), // of the residual at most; 0: all
    interpolation: choice('linear', ['linear', 'nearest']),
    filter: choice('bilinear', ['texel', 'bilinear', 'steep']),
    level: number(-1, -1, 16, 0), // of detail; -1: by pixel
    picks: choice('none', ['none', 'view', 'light', 'all']),
    math: choice('exact', ['exact', 'fast']),
    compare: choice('off', ['off', 'full', 'bare', ...EFFECTS]), // what the right part of a split picture shows
    split: number(0.5, 0, 1),
};

/** The state before anything was asked for. */
export function initialState() {
    return Object.fromEntries(Object.entries(MEMBERS).map(([name, { otherwise }]) => [name, Array.isArray(otherwise) ? [] : otherwise]));
}

function read(member, text) {
    if (member.text) {
        return text.slice(0, 80);
    }
    if (member.effects) {
        return EFFECTS.filter((effect) => text.split('+').includes(effect));
    }
    if (member.list) {
        return member.list.includes(text) ? text : undefined;
    }
    const value = text.trim() === '' ? NaN : Number(text);
    return Number.isFinite(value) ? clamp(value, member.low, member.high) : undefined;
}

/** The state that a link's text (with or without #) describes; what it does not say, or says wrongly, is the initial state's. */
export function stateOf(hash) {
    const state = initialState();
    for (const part of hash.replace(/^#/, '').split('&')) {
        const [name, value = ''] = part.split('=');
        if (Object.hasOwn(MEMBERS, name)) {
            let text = '';
            try {
                text = decodeURIComponent(value);
            } catch {
                // a % that encodes nothing
            }
            state[name] = read(MEMBERS[name], text) ?? state[name];
        }
    }
    return state;
}

/** The text of a state, '' for the initial one. Without the user's own files, which no link can hold. */
export function hashOf(state) {
    const parts = [];
    for (const [name, member] of Object.entries(MEMBERS)) {
        let value = state[name];
        if (member.digits !== undefined) {
            value = Number(value.toFixed(member.digits));
        } else if (member.effects) {
            value = value.join('+');
        } else if (value === 'own') {
            value = member.otherwise;
        }
        if (String(value) !== String(member.otherwise)) {
            parts.push(`${name}=${encodeURIComponent(value).replaceAll('%2B', '+')}`);
        }
    }
    return parts.join('&');
}
