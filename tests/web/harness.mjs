/* Cases of the tests of decoder/web, printed in the form that tests/summary.py counts.
 *
 * SPDX-License-Identifier: MIT
 */
let failures = 0;

/** Reports a case: it passed where `wrong` is empty; else `wrong` says why it failed. */
export function report(name, wrong = '') {
    console.log(`[ RUN      ] ${name}`);
    if (wrong) {
        console.log(wrong);
        failures += 1;
    }
    console.log(wrong ? `[  FAILED  ] ${name}` : `[       OK ] ${name}`);
}

/** Runs a case; it fails with the error that `body` throws. */
export async function test(name, body) {
    try {
        await body();
        report(name);
    } catch (error) {
        report(name, error.stack ?? String(error));
    }
}

/** The exit code of the cases so far. */
export function exitCode() {
    return failures ? 1 : 0;
}
