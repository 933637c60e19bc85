/* Two handles: a ball that shows and moves the light, and the line of a split picture.
 *
 * SPDX-License-Identifier: MIT
 */
import { clamp, direction, angles } from './camera.js';

const SIDE = 96; // of the ball in CSS pixels

/** Drags on an element: `moved` gets the place within it, 0..1 from the upper left corner. */
function listenDrag(element, moved, frame = element) {
    const at = (event) => {
        const { left, top, width, height } = frame.getBoundingClientRect();
        moved((event.clientX - left) / width, (event.clientY - top) / height);
    };
    element.addEventListener('pointerdown', (event) => {
        element.setPointerCapture(event.pointerId);
        at(event);
        event.stopPropagation();
    });
    element.addEventListener('pointermove', (event) => {
        if (element.hasPointerCapture(event.pointerId)) {
            at(event);
        }
    });
}

/** The ball, drawn on a small canvas: it is lit as the model is, and the light is where it is brightest. */
export class Ball {
    #canvas;
    #state;

    constructor(canvas, state, change) {
        this.#canvas = canvas;
        this.#state = state;
        canvas.width = canvas.height = 2 * SIDE;
        listenDrag(canvas, (x, y) => {
            const [px, py] = [2 * x - 1, 1 - 2 * y];
            const length = Math.hypot(px, py), most = 0.98;
            const [lx, ly] = length > most ? [(px * most) / length, (py * most) / length] : [px, py];
            const [theta, phi] = angles([lx, ly, Math.sqrt(1 - lx * lx - ly * ly)]);
            Object.assign(state, { lightTheta: theta, lightPhi: phi });
            change('light');
        });
        this.draw();
    }

    draw() {
        const to = this.#canvas.getContext('2d'), r = SIDE - 8;
        const [x, y, z] = direction(this.#state.lightTheta, this.#state.lightPhi);
        to.setTransform(1, 0, 0, 1, SIDE, SIDE);
        to.clearRect(-SIDE, -SIDE, 2 * SIDE, 2 * SIDE);
        const behind = z < 0;
        const glow = to.createRadialGradient(0.72 * r * x, -0.72 * r * y, 0, 0, 0, r);
        glow.addColorStop(0, behind ? '#4a4238' : '#f6d9ac');
        glow.addColorStop(0.35, behind ? '#332f2b' : '#a58454');
        glow.addColorStop(1, '#1d1c1e');
        to.fillStyle = glow;
        to.beginPath();
        to.arc(0, 0, r, 0, 7);
        to.fill();
        to.strokeStyle = '#5b5853';
        to.lineWidth = 2;
        to.stroke();
        to.beginPath();
        to.arc(r * x, -r * y, 10, 0, 7);
        to.fillStyle = behind ? '#1d1c1e' : '#fff';
        to.strokeStyle = '#e8b15c';
        to.lineWidth = 4;
        to.fill();
        to.stroke();
    }
}

/** The line between the two parts of a split picture: an element with role slider over the picture. */
export class SplitLine {
    #element;
    #state;

    constructor(element, frame, state, change) {
        this.#element = element;
        this.#state = state;
        listenDrag(element, (x) => {
            state.split = clamp(x, 0, 1);
            change('split');
        }, frame);
        element.addEventListener('keydown', (event) => {
            const step = { ArrowLeft: -0.02, ArrowRight: 0.02, ArrowDown: -0.02, ArrowUp: 0.02, Home: -1, End: 1 }[event.key];
            if (step) {
                state.split = clamp(state.split + step, 0, 1);
                event.preventDefault();
                change('split');
            }
        });
        this.draw();
    }

    draw() {
        const { split, compare } = this.#state;
        this.#element.hidden = compare === 'off';
        this.#element.style.left = `${100 * split}%`;
        this.#element.setAttribute('aria-valuenow', String(Math.round(100 * split)));
    }
}
