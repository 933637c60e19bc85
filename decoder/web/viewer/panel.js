/* The settings beside the picture: each control shows a member of the state and changes it.
 *
 * SPDX-License-Identifier: MIT
 */
import { MESHES } from './meshes.js';
import { EFFECTS, MEMBERS } from './state.js';

const byId = (id) => document.getElementById(id);
const NAMES = { plane: 'Plane', sphere: 'Sphere', cylinder: 'Tube', torus: 'Torus', cloth: 'Cloth' };
const WORDS = {
    shadow: 'Shadow', shift: 'Shift', hidden: 'Hidden', gain: 'Gain', residual: 'Residual', relief: 'Relief', gloss: 'Gloss',
};
/* The meaning of each effect, for those who hover over or hear its name. */
const MEANINGS = {
    shadow: 'Where the surface shadows itself', shift: 'Texels move as the view changes', hidden: 'Points that others hide from a view',
    gain: 'Brightness of each texel by view', residual: 'What the rest of the model leaves over', relief: 'A height map that moves texels between the sampled views',
    gloss: 'Highlights that follow the view between the samples',
};

function element(name, attributes = {}, ...children) {
    const made = document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) {
        if (key in made && key !== 'for') {
            made[key] = value;
        } else {
            made.setAttribute(key, value);
        }
    }
    made.append(...children);
    return made;
}

/** Bytes for people: 1.2 MB. */
export function bytesText(bytes) {
    const units = ['B', 'kB', 'MB', 'GB'];
    let value = Math.abs(bytes), unit = 0;
    while (value >= 999.5 && unit < 3) {
        value /= 1000;
        unit += 1;
    }
    return `${bytes < 0 ? '−' : ''}${unit && value < 99.5 ? value.toFixed(1) : Math.round(value)} ${units[unit]}`;
}

const signed = (value, digits) => `${value < -0.5 * 10 ** -digits ? '−' : '+'}${Math.abs(value).toFixed(digits)}`;

const decibels = (psnr) => `${psnr.toFixed(1)} dB`;

/** The controls whose ids are members of the state. */
const CONTROLS = ['repeat', 'zoom', 'sun', 'lightTheta', 'lightPhi', 'environment', 'strength', 'turn', 'backdrop', 'exposure', 'interpolation',
    'filter', 'picks', 'level', 'units', 'math', 'compare'];

function valueOf(control, member) {
    if (control.type === 'checkbox') {
        return control.checked ? control.dataset.on : control.dataset.off;
    }
    if (member.list) {
        return control.value;
    }
    return control.dataset.log ? 2 ** Number(control.value) : Number(control.value);
}

function textOf(control, value) {
    if (control.dataset.log) {
        return `${value.toFixed(value < 10 ? 2 : 1)}×`;
    }
    if (control.dataset.unit === '°') {
        return `${Math.round(value)}°`;
    }
    const text = control.dataset.signed !== undefined ? signed(value, 2) : String(Number(value.toFixed(2)));
    return text + (control.dataset.unit ?? '');
}

export class Panel {
    #state;
    #change;
    #info;
    #rows = new Map(); // of effects: cells

    /** @param change called with the member that the user changed */
    constructor(state, change) {
        this.#state = state;
        this.#change = change;
        for (const name of CONTROLS) {
            byId(name).addEventListener('input', () => this.#read(name));
        }
        byId('mesh').append(...MESHES.map((mesh) => element('label', {}, element('input', { type: 'radio', name: 'mesh', value: mesh, className: 'unseen',
            oninput: () => {
                state.mesh = mesh;
                change('mesh');
            } }), NAMES[mesh])));
        this.show();
    }

    #read(name) {
        const control = byId(name);
        let value = valueOf(control, MEMBERS[name]);
        if (name === 'units' && value >= this.#info?.components) {
            value = 0; // all
        }
        this.#state[name] = value;
        this.#showOutput(name);
        this.#change(name);
    }

    #showOutput(name) {
        const output = document.querySelector(`output[for=${name}]`);
        if (output && name === 'units') {
            output.textContent = this.#state.units ? `${this.#state.units} of ${this.#info?.components ?? 0}` : 'all';
        } else if (output) {
            output.textContent = textOf(byId(name), this.#state[name]);
            byId(name).setAttribute('aria-valuetext', output.textContent);
        }
    }

    /** Makes every control show the state. */
    show() {
        const state = this.#state;
        for (const name of CONTROLS) {
            const control = byId(name), value = state[name];
            if (control.type === 'checkbox') {
                control.checked = value === control.dataset.on;
            } else if (control.dataset.log) {
                control.value = String(Math.log2(value));
            } else if (name === 'units') {
                control.value = String(value || this.#info?.components || 1);
            } else {
                control.value = String(value);
            }
            this.#showOutput(name);
        }
        document.querySelectorAll('#mesh input').forEach((input) => { input.checked = input.value === state.mesh; });
        document.querySelectorAll('[data-needs=environment]').forEach((part) => { part.hidden = state.environment === 'none'; });
        for (const [effect, { input, row }] of this.#rows) {
            input.checked = !state.out.includes(effect);
            row.classList.toggle('off', !input.checked);
        }
    }

    /** Says that there is an environment of the user's. */
    nameEnvironment(name) {
        const option = document.querySelector('#environment option[value=own]');
        option.disabled = false;
        option.textContent = name;
    }

    /** Shows what a material is: its facts, its effects, its levels. */
    setMaterial(title, info, quality, textureBytes) {
        this.#info = info;
        const full = quality.of(info.effects);
        const facts = [
            ['Name', title],
            ['Texels', `${info.width} × ${info.height}${info.levels > 1 ? `, ${info.levels} levels` : ''}`],
            ['Directions', `${info.viewCount} views × ${info.lightCount} lights`],
            ['On the GPU', bytesText(textureBytes)],
            ['PSNR at samples', full.samples === undefined ? 'not in the file' : decibels(full.samples)],
            ['Between, estimated', full.between === undefined ? 'not in the file' : decibels(full.between)],
            ['Encoded by', `${info.method || 'unknown'}, format ${info.version}`],
        ];
        byId('facts').replaceChildren(...facts.flatMap(([name, value]) => [element('dt', {}, name), element('dd', {}, value)]));
        this.#makeEffects(info);
        byId('level').replaceChildren(element('option', { value: '-1' }, info.levels > 1 ? 'By pixel' : 'The only one'),
            ...(info.levels > 1 ? Array.from({ length: info.levels }, (_, level) => element('option', { value: String(level) },
                `${level}: ${Math.max(info.width >> level, 1)} × ${Math.max(info.height >> level, 1)} texels`)) : []));
        byId('level').disabled = info.levels < 2;
        byId('units-row').hidden = !info.effects.includes('residual') || info.components < 2;
        byId('units').max = String(info.components || 1);
        const bare = info.colour === 'none' ? 'Only the residual' : 'Every effect left out';
        // where the residual is all that there is, it is not left out
        const leftOut = info.effects.filter((effect) => effect !== 'residual' || info.colour !== 'none');
        byId('compare').replaceChildren(...[['off', 'No line'], ['full', 'Everything decoded'], ...(leftOut.length ? [['bare', bare]] : []),
            ...leftOut.map((effect) => [effect, `Without ${WORDS[effect].toLowerCase()}`]),
        ].map(([value, text]) => element('option', { value }, text)));
        this.show();
    }

    #makeEffects(info) {
        this.#rows.clear();
        const rows = EFFECTS.filter((effect) => info.effects.includes(effect)).map((effect) => {
            const input = element('input', { type: 'checkbox', className: 'switch', id: `effect-${effect}`, oninput: () => this.toggle(effect) });
            const label = element('label', { for: `effect-${effect}`, title: MEANINGS[effect] }, input, WORDS[effect]);
            const [db, bytes, time] = [0, 1, 2].map(() => element('td', {}, '–'));
            const row = element('tr', {}, element('th', { scope: 'row' }, label), db, bytes, time);
            this.#rows.set(effect, { row, input, db, bytes, time });
            return row;
        });
        document.querySelector('#effects tbody').replaceChildren(...rows);
    }

    /** Switches an effect, as the user did. */
    toggle(effect) {
        const { out } = this.#state;
        this.#state.out = out.includes(effect) ? out.filter((other) => other !== effect) : [...out, effect];
        this.#change('out');
    }

    /**
     * Fills the table of effects.
     * @param costs of effectCosts()
     * @param whole {between, samples, bytes} of what is decoded now
     * @param times milliseconds by effect, and of the whole under ''; undefined: not measured
     */
    setCosts(costs, whole, times) {
        const key = whole.between !== undefined || costs.some(({ between }) => between !== undefined) ? 'between' : 'samples';
        for (const { effect, empty, ...cost } of costs) {
            const { db, bytes, time } = this.#rows.get(effect);
            const gained = cost[key];
            db.textContent = empty ? 'all' : gained === undefined ? '–' : signed(gained, 1);
            db.title = cost.samples === undefined ? '' : `${signed(cost.samples, 2)} dB at the samples`;
            bytes.textContent = bytesText(cost.bytes);
            time.textContent = times?.[effect] === undefined ? '–' : `${signed(times[effect], 1)} ms`;
        }
        byId('db-head').textContent = 'dB';
        const total = element('tr', {}, element('th', { scope: 'row' }, 'As set'), element('td', {}, whole[key] === undefined ? '–' : whole[key].toFixed(1)),
            element('td', {}, bytesText(whole.bytes)), element('td', {}, times?.[''] === undefined ? '–' : `${times[''].toFixed(1)} ms`));
        document.querySelector('#effects tfoot').replaceChildren(total);
        byId('db-note').textContent = [
            key === 'between' ? 'dB (sRGB) that an effect gains between the samples, as the encoder estimated it; bytes of textures that it reads.'
                : 'dB (sRGB) that an effect gains at the samples, as the encoder measured it; bytes of textures that it reads.',
            times ? 'Milliseconds of a picture of 512 × 512, one light, on this device.' : '',
        ].join(' ').trim();
    }
}
