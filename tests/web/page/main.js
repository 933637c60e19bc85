/* The page of the tests in a browser: runs the parts that the job names one after the other, each a script beside this
 * file with a function run(job). One page serves all parts, since starting a browser takes seconds.
 *
 * SPDX-License-Identifier: MIT
 */
import { load } from '/package/index.js';
import { watch } from './frame.js';
import { json, note, post } from './post.js';

const fail = (error) => post('/done', error?.stack ? `${error.message}\n${error.stack}` : String(error));
window.addEventListener('error', ({ error, message }) => fail(error ?? message));
window.addEventListener('unhandledrejection', ({ reason }) => fail(reason));
performance.setResourceTimingBufferSize(10000);
watch(document);

async function run() {
    console.error('control: a line of the console'); // the test expects this line, which shows that it sees errors
    const job = await json('/job');
    await load('/package/openbtf.wasm');
    for (const part of job.parts) {
        const start = performance.now();
        await (await import(`./${part}.js`)).run(job);
        await note(`${part}: ${((performance.now() - start) / 1000).toFixed(1)} s`);
    }
}

run().then(() => post('/done', ''), fail);
