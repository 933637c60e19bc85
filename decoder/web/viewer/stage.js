/* When the viewer draws what: a draft at once while something changes, as small as the device needs to keep up; then the picture in
 * full, band by band; then more samples of it, until it is smooth. Nothing is drawn while nothing changes and the picture is done.
 *
 * SPDX-License-Identifier: MIT
 */
import { clamp } from './camera.js';

const DRAFT_MS = 40; // what a draft may take: 25 a second
const BAND_MS = 30; // what a band may take, so that a pointer that moves does not wait long
const MOST_BANDS = 16; // of a sample: each draws all vertices, and waits for the device
const SETTLE_MS = 150; // without a change after which drafts give way to the picture
const SMALLEST = 0.12; // a draft's side, of the picture's
/** Samples of a picture at most: of neighbours picked at random or an environment's lights more are needed than of edges alone. */
const SAMPLES = { edges: 16, lights: 256, picks: 256 };

export function samplesOf(state) {
    return state.picks !== 'none' ? SAMPLES.picks : state.environment !== 'none' ? SAMPLES.lights : SAMPLES.edges;
}

export class Stage {
    #renderer;
    #canvas;
    #state;
    #report;
    #failed;
    #requested = 0;
    #changed = true; // since the latest draft
    #changedAt = 0;
    #scale = 0.5; // of drafts
    #pixelMs = 0; // of a pixel, from drafts and bands
    #fence = null; // of what the device draws now: { done, begun, pixels }
    #sample = 0; // complete ones in the mean
    #row = 0; // of the sample that is being drawn
    #paused = false;
    #waiting = []; // those who wait for a finished sample
    #shown = []; // times of the latest pictures
    #firstPicture = 0;

    /**
     * @param state the object that is shown; who changes it calls change()
     * @param report called with {samples, of, moving, fps, frameMs, scale, compiling} when they change
     * @param failed called with an Error that drawing ended with
     */
    constructor(renderer, canvas, state, report, failed) {
        this.#renderer = renderer;
        this.#canvas = canvas;
        this.#state = state;
        this.#report = report;
        this.#failed = failed;
    }

    /** Milliseconds after the page was asked for at which the first picture was drawn; 0 before. */
    get firstPicture() {
        return this.#firstPicture;
    }

    /** The state, the size or the material has changed. */
    change() {
        this.#changed = true;
        this.#changedAt = performance.now();
        this.#sample = this.#row = 0;
        this.#request();
    }

    /** Only how the mean is shown has changed: exposure, or what is behind the model. */
    reshow() {
        if (this.#sample) {
            this.#renderer.show(this.#state);
        } else {
            this.change();
        }
    }

    /** Forgets how long pixels took: a change of the shader makes it another. */
    forgetTime() {
        this.#pixelMs = 0;
    }

    /** Nothing is drawn until resume(): others use the device. */
    pause() {
        this.#paused = true;
    }

    resume() {
        this.#paused = false;
        this.change();
    }

    stop() {
        cancelAnimationFrame(this.#requested);
        this.#requested = 0;
        this.#paused = true;
    }

    /** Shows the picture in full, once it has a sample; then calls `use` in the same task, in which the canvas can be read. */
    async withPicture(use) {
        if (!this.#sample || this.#changed) {
            this.#request();
            await new Promise((resolve) => { this.#waiting.push(resolve); });
        }
        this.#renderer.show(this.#state);
        return use();
    }

    /** The picture's size in pixels: the canvas as it lies in the page, at most two pixels a CSS pixel. */
    size() {
        const ratio = Math.min(window.devicePixelRatio || 1, 2);
        return [this.#canvas.clientWidth, this.#canvas.clientHeight].map((side) => clamp(Math.round(side * ratio), 1, 4096));
    }

    #request() {
        if (!this.#requested) {
            this.#requested = requestAnimationFrame((now) => {
                this.#requested = 0;
                try {
                    this.#frame(now);
                } catch (error) { // the next change tries again
                    this.#fence = null;
                    this.#changed = true;
                    this.#failed(error);
                }
            });
        }
    }

    #frame(now) {
        if (this.#paused || !this.#renderer.hasMaterial) {
            return;
        }
        if (this.#fence) {
            if (!this.#fence.done()) {
                this.#request();
                return;
            }
            this.#measured(performance.now() - this.#fence.begun, this.#fence.pixels);
        }
        const [width, height] = this.size();
        if (width !== this.#canvas.width || height !== this.#canvas.height) {
            this.#canvas.width = width;
            this.#canvas.height = height;
        }
        if (this.#renderer.resize(width, height)) {
            this.#changed = true;
            this.#sample = this.#row = 0;
        }
        if (!this.#renderer.prepare(this.#state)) {
            this.#say({ compiling: true });
            this.#request();
            return;
        }
        if (this.#changed) {
            this.#draft(width, height);
        } else if (now - this.#changedAt < SETTLE_MS && this.#scale < 1) {
            this.#request();
        } else {
            this.#refine(width, height);
        }
    }

    #measured(ms, pixels) {
        const each = ms / pixels;
        this.#pixelMs = this.#pixelMs ? 0.6 * this.#pixelMs + 0.4 * each : each;
        this.#fence = null;
    }

    #draft(width, height) {
        if (this.#pixelMs) {
            this.#scale = clamp(Math.sqrt(DRAFT_MS / (this.#pixelMs * width * height)), SMALLEST, 1);
        }
        // a few sizes, so that drafts do not shimmer
        const scale = this.#scale > 0.85 ? 1 : Math.ceil(this.#scale * 16) / 16;
        const draft = [width, height].map((side) => Math.max(1, Math.round(side * scale)));
        this.#changed = false;
        const begun = performance.now();
        this.#renderer.drawSample(this.#state, ...draft, 0);
        this.#renderer.show(this.#state, draft);
        this.#fence = { done: this.#renderer.fence(), begun, pixels: draft[0] * draft[1] };
        this.#sample = this.#row = 0;
        this.#drawn(begun);
        this.#say({ moving: true, scale });
        this.#request();
    }

    #refine(width, height) {
        const most = this.#renderer.floats ? samplesOf(this.#state) : 1;
        if (this.#sample >= most) {
            this.#say({ moving: false });
            return;
        }
        const rows = this.#pixelMs ? clamp(Math.floor(BAND_MS / (this.#pixelMs * width)), Math.ceil(height / MOST_BANDS), height) : Math.ceil(height / 8);
        const to = Math.min(height, this.#row + rows);
        const begun = performance.now();
        this.#renderer.drawSample(this.#state, width, height, this.#sample, this.#row, to);
        const pixels = width * (to - this.#row);
        this.#row = to;
        if (to === height) {
            this.#renderer.accumulate(this.#sample);
            this.#sample += 1;
            this.#row = 0;
            this.#renderer.show(this.#state);
            this.#say({ moving: false });
            this.#waiting.splice(0).forEach((resolve) => resolve());
        }
        this.#fence = { done: this.#renderer.fence(), begun, pixels };
        this.#request();
    }

    #drawn(at) {
        this.#firstPicture ||= at;
        this.#shown = [...this.#shown.filter((time) => at - time < 1000), at];
    }

    #say(what) {
        const [width, height] = this.size(), shown = this.#shown;
        const fps = shown.length > 2 ? (1000 * (shown.length - 1)) / (shown.at(-1) - shown[0]) : 0;
        this.#report({ samples: this.#sample, of: samplesOf(this.#state), moving: false, compiling: false, scale: this.#scale,
            fps, frameMs: this.#pixelMs * width * height, ...what });
    }
}
