/* Starts a headless browser on a page that this script serves, and passes on what the page posts.
 *
 * A page has also failed where the browser prints an error about it: of a script, of WebGL, of a file that it asked for
 * and did not get.
 *
 * SPDX-License-Identifier: MIT
 */
import { execFileSync, spawn, spawnSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { mkdtempSync, readdirSync, rmSync, writeFileSync, readFileSync, existsSync } from 'node:fs';
import { createServer } from 'node:http';
import { tmpdir } from 'node:os';
import { extname, join, normalize } from 'node:path';

const TYPES = { '.html': 'text/html', '.js': 'text/javascript', '.json': 'application/json', '.wasm': 'application/wasm' };
/* The content security policy: a page may reach its own server alone, and compile WebAssembly. Of inline scripts only
 * import maps run, and those of examples. */
const POLICY = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self' 'unsafe-inline'; connect-src 'self'; img-src 'self' data:; frame-src 'self'";
const EXAMPLE_POLICY = POLICY.replace("'wasm-unsafe-eval'", "'wasm-unsafe-eval' 'unsafe-inline'");

/* Settings without first-run pages and services of the browsers' makers; WebGL2 in software. */
const FIREFOX = {
    'webgl.force-enabled': true, 'browser.shell.checkDefaultBrowser': false, 'browser.startup.homepage_override.mstone': 'ignore',
    'datareporting.policy.dataSubmissionEnabled': false, 'toolkit.telemetry.enabled': false, 'app.normandy.enabled': false,
    'browser.aboutwelcome.enabled': false, 'network.captive-portal-service.enabled': false, 'network.connectivity-service.enabled': false,
    'extensions.getAddons.cache.enabled': false, 'browser.safebrowsing.malware.enabled': false, 'browser.safebrowsing.phishing.enabled': false,
    'media.gmp-manager.updateEnabled': false, 'toolkit.startup.max_resumed_crashes': -1, 'dom.max_script_run_time': 0,
    'dom.max_chrome_script_run_time': 0, 'extensions.update.enabled': false, 'devtools.console.stdout.content': true,
};
export const CHROMIUM = ['--headless', '--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--no-first-run',
    '--disable-background-networking', '--disable-component-update', '--disable-sync', '--disable-dev-shm-usage', '--disable-gpu-watchdog',
    '--disable-hang-monitor', '--enable-logging=stderr'];
/* Lines that the browsers print of a page's console: [level, text]. */
const CONSOLE = {
    chromium: /^\[[^\]]*:(INFO|WARNING|ERROR):CONSOLE[^\]]*\] (.*)$/gm,
    firefox: /^(console\.(?:error|assert)|JavaScript error): (.*)$/gm,
};

/** Settings for WebGPU in software: Chromium's on SwiftShader, Firefox's on lavapipe. */
export const WEBGPU = {
    chromium: ['--enable-unsafe-webgpu', '--use-webgpu-adapter=swiftshader'],
    // Chromium shows WebGPU in a canvas only if it draws the page by Vulkan, too
    chromiumCanvas: ['--enable-features=Vulkan', '--use-vulkan=swiftshader', '--ignore-gpu-blocklist'],
    firefox: { 'dom.webgpu.enabled': true, 'gfx.webgpu.ignore-blocklist': true },
};
const LAVAPIPE = '/usr/share/vulkan/icd.d/lvp_icd.x86_64.json';

const PACKAGES = { chromium: [['chromium', 'chromium']], firefox: [['firefox-esr', 'firefox-esr'], ['xvfb-run', 'xvfb'], ['xauth', 'xauth']] };

/** Ends the process with a message where a program is missing that the tests need. */
export function needPrograms(browser) {
    for (const [program, name] of PACKAGES[browser]) {
        if (spawnSync('sh', ['-c', `command -v ${program}`]).status !== 0) {
            console.log(`${program} is missing: apt-get install ${name}, or run tests/run.sh --core, which leaves the tests of decoder/web out`);
            process.exit(1);
        }
    }
}

/** Skips the test, with the reason, where the browser's version has no WebGPU. */
export function needWebGPU(browser) {
    if (browser === 'firefox') {
        const version = execFileSync('firefox-esr', ['--version'], { encoding: 'utf8' });
        const number = Number(/(\d+)\./.exec(version)?.[1]);
        if (number < 141) { // Firefox's releases before 141 refuse WebGPU, whatever the preferences say
            console.log(`skipped: ${version.trim()} has no WebGPU, which releases of Firefox have from 141 on`);
            process.exit(77);
        }
    }
}

function commandOf(browser, profile, url) {
    if (browser === 'chromium') {
        return ['chromium', ...CHROMIUM, ...WEBGPU.chromium, `--user-data-dir=${profile}`, url];
    }
    writeFileSync(join(profile, 'user.js'), Object.entries({ ...FIREFOX, ...WEBGPU.firefox }).map(([name, value]) => `user_pref("${name}", ${JSON.stringify(value)});\n`).join(''));
    return ['xvfb-run', '-a', 'firefox-esr', '--no-remote', '--new-instance', '--profile', profile, url];
}

function body(request) {
    return new Promise((resolve, reject) => {
        const parts = [];
        request.on('data', (part) => parts.push(part)).on('end', () => resolve(Buffer.concat(parts).toString())).on('error', reject);
    });
}

/** The policy for a file; import maps in it are let through by their hash. */
function policyOf(pathname, data) {
    if (pathname.startsWith('/example/')) {
        return EXAMPLE_POLICY;
    }
    if (!pathname.endsWith('.html')) {
        return POLICY;
    }
    const maps = Array.from(String(data).matchAll(/<script type="importmap">([^]*?)<\/script>/g), ([, text]) => text);
    return POLICY.replace('script-src', ['script-src', ...maps.map((text) => `'sha256-${createHash('sha256').update(text).digest('base64')}'`)].join(' '));
}

/* Lines about how fast a browser draws are no errors. */
const HARMLESS = [/GL Driver Message \(OpenGL, Performance/];

/** The faults in a browser's console: lines in `said` that are not expected, and expected lines that are missing. */
function consoleErrors(browser, said, expected) {
    const lines = Array.from(said.matchAll(CONSOLE[browser]), ([line]) => line).filter((line) => !HARMLESS.some((known) => known.test(line)));
    const wrong = lines.filter((line) => !expected.some((pattern) => pattern.test(line)));
    const missing = expected.filter((pattern) => !lines.some((line) => pattern.test(line)));
    return [...wrong.map((line) => `console: ${line}`), ...missing.map((pattern) => `the console does not say ${pattern}`)].join('\n');
}

/** Core seconds of the running processes of a group and of their ended children. */
function coreSeconds(group) {
    let ticks = 0;
    for (const pid of readdirSync('/proc').filter((name) => /^\d+$/.test(name))) {
        try {
            const fields = readFileSync(`/proc/${pid}/stat`, 'utf-8').replace(/^.*\) /s, '').split(' ');
            if (Number(fields[2]) === group) { // fields 11 to 14: user and system time, own and children's, in 1/100 s
                ticks += [11, 12, 13, 14].reduce((sum, i) => sum + Number(fields[i]), 0);
            }
        } catch {
            // the process has just ended
        }
    }
    return ticks / 100;
}

/* A page that posts nothing for so long has hung: the longest step between two posts takes seconds, or minutes on a
 * busy machine. */
const SILENT_MINUTES = 60;

/**
 * Runs a page in a browser until it posts to /done.
 * @param folders {'/prefix/': folder, or several} that are served
 * @param posts {'/path': function of what was posted, parsed}
 * @param job the answer to GET /job; GET /core-seconds is answered with those that the browser has used
 * @param expected patterns, each of a line that the browser's console must print; any other line there is an error
 * @returns '' or what went wrong: what was posted to /done, or the console's errors
 */
export async function runPage(browser, page, folders, posts, job, expected = []) {
    const profile = mkdtempSync(join(tmpdir(), 'openbtf-browser-'));
    let end;
    const done = new Promise((resolve) => { end = resolve; });
    let last = 'nothing was posted', lastTime = Date.now();
    const server = createServer(async (request, response) => {
        const { pathname } = new URL(request.url, 'http://localhost');
        const answer = (status, data, type = 'text/plain') => {
            response.writeHead(status, { 'Content-Type': type, 'Content-Security-Policy': policyOf(pathname, data), 'Cache-Control': 'no-store' });
            response.end(data);
        };
        if (request.method === 'POST') {
            const text = await body(request);
            [last, lastTime] = [`${pathname} ${text.slice(0, 300)}`, Date.now()];
            answer(204);
            if (pathname === '/done') {
                end(JSON.parse(text));
            } else {
                posts[pathname]?.(JSON.parse(text));
            }
            return;
        }
        if (pathname === '/job') {
            answer(200, JSON.stringify(job), 'application/json');
            return;
        }
        if (pathname === '/core-seconds') { // used by the browser so far, for pages that measure
            answer(200, String(coreSeconds(child.pid)));
            return;
        }
        if (pathname === '/favicon.ico') { // browsers ask for it by themselves
            answer(204);
            return;
        }
        const prefix = Object.keys(folders).filter((name) => pathname.startsWith(name)).sort((a, b) => b.length - a.length)[0];
        const file = [folders[prefix] ?? []].flat().map((folder) => join(folder, normalize(`/${pathname.slice(prefix.length)}`))).find(existsSync);
        if (file) {
            answer(200, readFileSync(file), TYPES[extname(file)] ?? 'application/octet-stream');
        } else {
            answer(404, 'not found');
        }
    });
    await new Promise((resolve) => { server.listen(0, '127.0.0.1', resolve); });
    const [command, ...args] = commandOf(browser, profile, `http://127.0.0.1:${server.address().port}${page}`);
    const child = spawn(command, args, { stdio: ['ignore', 'pipe', 'pipe'], detached: true, env: { ...process.env, HOME: profile, VK_ICD_FILENAMES: LAVAPIPE } });
    let said = '';
    for (const stream of [child.stdout, child.stderr]) {
        stream.setEncoding('utf8'); // a character may come in two parts
        stream.on('data', (data) => { said += data; });
    }
    const exited = new Promise((resolve) => { child.on('exit', (code, signal) => resolve(`${browser} ended by itself (${code ?? signal}):\n${said.slice(-4000)}`)); });
    const watchdog = setInterval(() => {
        if (Date.now() - lastTime > SILENT_MINUTES * 60000) {
            end(`no word from the page for ${SILENT_MINUTES} minutes; the last was ${last}`);
        }
    }, 1000);
    // the browser is a process group of its own, which has to be ended when this process is
    const stop = () => {
        try {
            process.kill(-child.pid, 'SIGTERM');
        } catch {
            // it has ended already
        }
    };
    process.on('exit', stop);
    ['SIGINT', 'SIGTERM', 'SIGHUP'].forEach((signal) => process.on(signal, () => process.exit(1)));
    const result = await Promise.race([done, exited]);
    clearInterval(watchdog);
    console.log(`core seconds of ${browser}: ${coreSeconds(child.pid).toFixed(0)}`);
    stop();
    await exited;
    server.closeAllConnections?.();
    server.close();
    rmSync(profile, { recursive: true, force: true, maxRetries: 10, retryDelay: 200 });
    return result || consoleErrors(browser, said, expected);
}
