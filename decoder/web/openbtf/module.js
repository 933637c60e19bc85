/* OpenBTF: loads the WebAssembly module, hands arguments over, and turns its refusals into errors.
 *
 * The exports are those of decoder/web/wasm/exports.h in OpenBTF's sources. There is one instance a page or process.
 *
 * SPDX-License-Identifier: MIT
 */

/* The interface that this file was written for: BTF_WEB_INTERFACE. */
const INTERFACE = 2;

/** Names of the result codes, by number (openbtf/result.h). */
const CODES = ['OK', 'USAGE', 'IO', 'BAD_FILE', 'INTERNAL', 'MEMORY', 'UNSUPPORTED', 'DIFFERENT', 'INTERRUPTED'];

/**
 * A call that failed.
 * `code` is the name of the library's result code, e.g. 'BAD_FILE', and `result` its number.
 */
export class OpenBTFError extends Error {
    constructor(code, message) {
        super(message);
        this.name = 'OpenBTFError';
        this.code = code;
        this.result = CODES.indexOf(code);
    }
}

let wasm; // the exports, once there are any
let loading; // a promise of them
let provider; // gives the module's bytes where nothing else was asked for
let stopped; // why the module cannot be called any more

/** Says where the module comes from when load() is not told; what node.js does. */
export function provide(give) {
    provider = give;
}

/* The C library may ask for files. There are none: 52 is ENOSYS, by the WASI numbers that it goes by. */
function importsOf(module) {
    const imports = {};
    for (const { module: from, name } of WebAssembly.Module.imports(module)) {
        imports[from] ??= {};
        imports[from][name] = from === 'env' ? () => -52 : () => 52;
    }
    (imports.env ??= {}).emscripten_notify_memory_growth = () => {};
    return imports;
}

async function moduleOf(source) {
    if (source instanceof WebAssembly.Module) {
        return source;
    }
    if (typeof source === 'string' || source instanceof URL) {
        source = await fetch(source);
    }
    if (typeof Response !== 'undefined' && source instanceof Response) {
        if (!source.ok) {
            throw new OpenBTFError('IO', `${source.url}: the server answers ${source.status}`);
        }
        source = await source.arrayBuffer();
    }
    return WebAssembly.compile(source);
}

async function instantiate(source) {
    const given = source ?? (provider ? await provider() : new URL('./openbtf.wasm', import.meta.url));
    const module = await moduleOf(given);
    const instance = await WebAssembly.instantiate(module, importsOf(module));
    instance.exports._initialize();
    const version = instance.exports.btf_web_interface();
    if (version !== INTERFACE) {
        throw new OpenBTFError('INTERNAL', `openbtf.wasm is of interface ${version}, the script of ${INTERFACE}`);
    }
    wasm = instance.exports;
}

/**
 * Loads the WebAssembly module, once; open() does so by itself.
 * @param source where it is, or its bytes: a URL, a Response, an ArrayBuffer or typed array, a WebAssembly.Module.
 *   Default: openbtf.wasm beside this file. Read by the first call alone.
 */
export async function load(source) {
    loading ??= instantiate(source).catch((error) => {
        loading = undefined;
        throw error;
    });
    await loading;
}

/** Calls an export. A trap ends the module: its memory is in no known state then. */
export function call(name, ...values) {
    if (!wasm) {
        throw new OpenBTFError('USAGE', 'the module is not loaded yet: await load() first');
    }
    if (stopped) {
        throw new OpenBTFError('INTERNAL', `the module has stopped before: ${stopped}`);
    }
    try {
        return wasm[`btf_web_${name}`](...values);
    } catch (error) {
        stopped = error.message;
        throw new OpenBTFError('INTERNAL', `the module has stopped: ${stopped}`);
    }
}

/** Throws what the last call said, where it failed. */
export function check() {
    const result = call('result');
    if (result) {
        throw new OpenBTFError(CODES[result] ?? 'INTERNAL', text(call('message')));
    }
}

/** The text at an address; undefined for 0. */
export function text(address) {
    if (!address) {
        return undefined;
    }
    const bytes = new Uint8Array(wasm.memory.buffer, address >>> 0);
    return new TextDecoder().decode(bytes.subarray(0, bytes.indexOf(0)));
}

/** Bytes of the module's memory. Any later call may move the memory: they are for use at once. */
export function bytesAt(address, size) {
    return new Uint8Array(wasm.memory.buffer, address >>> 0, size);
}

/** Bytes of the module's memory in all: it grows and never shrinks. */
export function memoryBytes() {
    return wasm ? wasm.memory.buffer.byteLength : 0;
}

/** Runs `use` with a function that allocates memory of so many bytes, all freed in the end. */
export function withMemory(use) {
    const addresses = [];
    const allocate = (size) => {
        const address = size < 2 ** 32 ? call('allocate', size) >>> 0 : 0;
        if (!address) {
            throw new OpenBTFError('MEMORY', `out of memory for ${size} bytes`);
        }
        addresses.push(address);
        return address;
    };
    try {
        return use(allocate);
    } finally {
        if (!stopped) {
            addresses.forEach((address) => call('release', address));
        }
    }
}

/** Copies a typed array to memory of the module. */
export function put(allocate, array) {
    const address = allocate(array.byteLength);
    bytesAt(address, array.byteLength).set(new Uint8Array(array.buffer, array.byteOffset, array.byteLength));
    return address;
}
