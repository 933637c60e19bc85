/* No request leaves the page: the last part, which looks back on all before it.
 *
 * SPDX-License-Identifier: MIT
 */
import { asked, refused } from './frame.js';
import { report } from './post.js';

export async function run() {
    const own = performance.getEntriesByType('resource').map(({ name }) => name);
    const away = [...own, ...asked].filter((url) => !url.startsWith('data:') && !url.startsWith('blob:') && new URL(url).origin !== location.origin);
    await report('no request leaves the page', own.length ? [...away, ...refused].join(' ') : 'the browser lists no request');
    // the control: one that tries to is seen
    const seen = new Promise((resolve) => { document.addEventListener('securitypolicyviolation', resolve, { once: true }); });
    await fetch('http://openbtf.invalid/').catch(() => {});
    await seen;
    await report('control: a request that would leave is noticed', refused.length ? '' : 'it was not');
}
