/* Costs and gains of each effect of a material: dB that the encoder measured or estimated, bytes that a decode reads, and time on
 * this device.
 *
 * SPDX-License-Identifier: MIT
 */
const mseOf = (psnr) => 10 ** (-psnr / 10);
const psnrOf = (mse) => -10 * Math.log10(Math.max(mse, 1e-10));
const same = (a, b) => a.length === b.length && a.every((effect) => b.includes(effect));

/** Bytes of the textures that a decode of these options reads, tables included. */
export function bytesRead(material, options) {
    return material.readTextures(options).reduce((sum, { data }) => sum + data.byteLength, 0);
}

/* PSNR, sRGB-coded, against the samples, of a way to decode that the encoder measured; undefined of any other. */
function atSamples(info, effects) {
    return info.errors.find((row) => same(row.effects, effects))?.psnrSrgb;
}

/* A plan that leaves nothing out, to ask the file's tables with; null where they say nothing. */
function fullPlan(material) {
    try {
        const plan = material.plan({ interpolate: true }, 0);
        return plan.measured ? plan : null;
    } catch {
        return null;
    }
}

/**
 * PSNR (sRGB-coded) between the samples of ways to decode: what the full decode loses there by the encoder's estimate, and what a
 * way adds to that against the samples and what lies between them interpolated. Relief and gloss, whose worth that does not know,
 * are compared by the estimate alone.
 */
class Between {
    #material;
    #plan;
    #full; // mean squared error of the full decode; 0: the file does not say
    #base; // what the tables predict of the full decode
    #without = {}; // of the decode without relief, without gloss

    constructor(material) {
        this.#material = material;
        this.#plan = fullPlan(material);
        this.#full = this.#plan?.fullBetweenPsnrSrgb > 0 ? mseOf(this.#plan.fullBetweenPsnrSrgb) : 0;
        this.#base = this.#full ? this.#predicted(material.info.effects, material.info.effects.includes('residual') ? material.info.components : 0) : undefined;
        const rows = material.info.betweenErrors.filter(({ level, leftOut }) => level === 0 && leftOut === 'both');
        const all = rows.find(({ without }) => without.length === 0);
        for (const { without: [effect], psnrSrgb } of all ? rows : []) {
            if (effect) {
                this.#without[effect] = mseOf(psnrSrgb) - mseOf(all.psnrSrgb);
            }
        }
    }

    get known() {
        return this.#full > 0;
    }

    #predicted(effects, units) {
        try {
            return mseOf(this.#material.predict(this.#plan, effects, units).psnrSrgb);
        } catch {
            return undefined; // not measured
        }
    }

    psnr(effects, units) {
        const { info } = this.#material;
        const asked = [...effects, ...['relief', 'gloss'].filter((effect) => info.effects.includes(effect) && !effects.includes(effect))];
        const count = effects.includes('residual') ? units || info.components : 0;
        if (!this.#full || this.#base === undefined) {
            return undefined;
        }
        const way = this.#predicted(asked, count);
        if (way === undefined) {
            return undefined;
        }
        let mse = this.#full + Math.max(way - this.#base, 0);
        for (const effect of ['relief', 'gloss']) {
            if (info.effects.includes(effect) && !effects.includes(effect)) {
                if (this.#without[effect] === undefined) {
                    return undefined;
                }
                mse += this.#without[effect];
            }
        }
        return psnrOf(mse);
    }
}

/** Reads a file's tables of errors: how near its material comes to the samples. */
export class Quality {
    #material;
    #between;

    constructor(material) {
        this.#material = material;
        this.#between = new Between(material);
    }

    /**
     * Of a way to decode.
     * @returns {between, samples}: PSNR in dB, sRGB-coded, between the samples (estimated) and at them; undefined where the file does
     *   not say
     */
    of(effects, units = 0) {
        const { info } = this.#material;
        const whole = !effects.includes('residual') || !units || units >= info.components;
        return { between: this.#between.psnr(effects, units), samples: whole ? atSamples(info, effects) : undefined };
    }
}

/**
 * For each effect of the material, what the decode of `options` gains or would gain by it.
 * @returns [{effect, on, between, samples: dB gained, bytes, empty: whether nothing would be left without it}]
 */
export function effectCosts(material, quality, options) {
    const { info } = material;
    const current = info.effects.filter((effect) => !options.leaveOut.includes(effect));
    return info.effects.map((effect) => {
        const without = current.filter((other) => other !== effect);
        const withIt = info.effects.filter((other) => other === effect || without.includes(other));
        const [a, b] = [withIt, without].map((effects) => quality.of(effects, options.components));
        const gained = (key) => (a[key] === undefined || b[key] === undefined ? undefined : a[key] - b[key]);
        const [more, less] = [withIt, without].map((effects) => bytesRead(material,
            { ...options, leaveOut: info.effects.filter((other) => !effects.includes(other)) }));
        return { effect, on: current.includes(effect), between: gained('between'), samples: gained('samples'), bytes: more - less,
            empty: effect === 'residual' && info.colour === 'none' };
    });
}

const SIDE = 512; // of the picture that times are told of
const LARGE = 256, SMALL = 128; // of those that are timed
const ROUNDS = 3;

/* Milliseconds of `repeats` samples in a row, until the device is done with them. */
async function timeSamples(renderer, state, side, repeats) {
    const begun = performance.now();
    for (let i = 0; i < repeats; i++) {
        renderer.drawSample(state, side, side, 0);
    }
    const done = renderer.fence();
    while (!done()) {
        await new Promise((resolve) => { setTimeout(resolve, 1); });
    }
    return performance.now() - begun;
}

/**
 * Times pictures of states in turn, so that what else the device does falls on all.
 * @param states of which the first is compared with each other
 * @param progress called with how many of how many times are taken
 * @returns milliseconds of a picture of 512 x 512 of each, the median of three
 */
export async function timeStates(renderer, states, progress) {
    const times = states.map(() => []);
    for (const state of states) {
        while (!renderer.prepare(state)) {
            await new Promise((resolve) => { requestAnimationFrame(resolve); });
        }
    }
    renderer.resize(LARGE, LARGE);
    await timeSamples(renderer, states[0], LARGE, 1); // warms up
    const first = await timeSamples(renderer, states[0], LARGE, 1);
    // a slow device draws fewer pixels; a quick one several pictures, for its clock tells a few milliseconds only
    const side = first > 60 ? SMALL : LARGE, repeats = Math.round(Math.min(Math.max(80 / Math.max(first, 0.5), 1), 64));
    for (let round = 0; round < ROUNDS; round++) {
        for (const [index, state] of states.entries()) {
            times[index].push(((await timeSamples(renderer, state, side, repeats)) / repeats) * (SIDE / side) ** 2);
            progress(round * states.length + index + 1, ROUNDS * states.length);
        }
    }
    return times.map((list) => list.sort((a, b) => a - b)[1]);
}
