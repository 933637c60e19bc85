/* Checks that no request left the page. It is the last part, so that it covers all parts before it.
 *
 * SPDX-License-Identifier: MIT
 */
import { asked, refused } from './frame.js';
import { report } from './post.js';

export async function run() {
    const own = performance.getEntriesByType('resource').map(({ name }) => name);
    const away = [...own, ...asked].filter((url) => !url.startsWith('data:') && !url.startsWith('blob:') && new URL(url).origin !== location.origin);
    await report('no request leaves the page', own.length ? [...away, ...refused].join(' ') : 'the browser lists no request');
    // the control: a request to elsewhere is noticed
    const seen = new Promise((resolve) => { document.addEventListener('securitypolicyviolation', resolve, { once: true }); });
    await fetch('http://openbtf.invalid/').catch(() => {});
    await seen;
    await report('control: a request that would leave is noticed', refused.length ? '' : 'it was not');
}
