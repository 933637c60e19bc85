/* Uses the viewer in a frame, and posts what it saw.
 *
 * SPDX-License-Identifier: MIT
 */
const post = (path, value) => fetch(path, { method: 'POST', body: JSON.stringify(value) });
const HANG_MS = 3000000; // a wait of 50 minutes has hung, also on a busy machine; browser.mjs waits for longer

async function until(what, condition) {
    const end = Date.now() + HANG_MS;
    while (!condition()) {
        if (Date.now() > end) {
            throw new Error(`${what}: not within ${HANG_MS / 1000} s`);
        }
        await new Promise((resolve) => { setTimeout(resolve, 50); });
    }
}

async function run() {
    const errors = [];
    const frame = document.createElement('iframe');
    frame.width = 900;
    frame.height = 560;
    frame.src = '/example/viewer.html';
    document.body.append(frame);
    await new Promise((resolve) => { frame.onload = resolve; });
    const { contentWindow: inside, contentDocument: page } = frame, { dataset } = page.documentElement;
    inside.addEventListener('error', (event) => errors.push(event.message));
    inside.addEventListener('unhandledrejection', (event) => errors.push(String(event.reason)));
    const said = (id) => page.getElementById(id).textContent;
    const check = (name, good, wrong) => post('/case', { name, wrong: good ? '' : wrong || 'not so' });

    await until('the first picture', () => dataset.first || dataset.failed);
    await check('viewer: a material is shown', dataset.first && !dataset.failed, dataset.failed);
    await until('the self-test', () => dataset.exact);
    await check('viewer: the self-test passes', dataset.exact === 'true', said('verdict'));
    page.getElementById('check-button').click();
    await until('the comparison', () => said('check'));
    await check('viewer: 0 bits differ from the reference decoder', dataset.different === '0', said('check'));
    page.getElementById('measure').click();
    await until('the measurement', () => dataset.measured || !page.getElementById('message').hidden);
    await check('viewer: times of effects are measured', Number(dataset.measured) > 0, said('message-text'));
    page.getElementById('canvas').dispatchEvent(new inside.KeyboardEvent('keydown', { key: 'ArrowLeft', bubbles: true }));
    await until('the link', () => inside.location.hash.includes('phi='));
    for (const [id, value] of [['environment', 'sky'], ['picks', 'all'], ['compare', 'bare']]) {
        const control = page.getElementById(id);
        control.value = value;
        control.dispatchEvent(new inside.Event('input', { bubbles: true }));
        await until(id, () => inside.location.hash.includes(`${id}=${value}`) && dataset.samples >= 1);
    }
    await check('viewer: environment, picked neighbours and a split picture are drawn', page.getElementById('message').hidden, said('message-text'));
    await check('viewer: no error', errors.length === 0, errors.join('; '));
    await post('/note', `${navigator.userAgent}: ${said('device')} First picture after ${dataset.first} ms; ${dataset.measured} ms for 512 x 512 pixels, on this machine`);
}

run().then(() => post('/done', ''), (error) => post('/done', `${error.message}\n${error.stack}`));
