/* Section `decode`: time per pixel and accuracy for every set of effects, directions, filter and kind of mathematics,
 * on every GL device and on the CPU, and those of peers. All of it is measured in one process. * Accuracy is that of
 * the device's own pixels: samples drawn at random from the data are decoded by the same shader that is timed.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decode_cpu.h"
#include "decode_gl.h"
#include "decode_peer_runs.h"

#include "tests/bench/readme.h"

#include <stdlib.h>
#include <string.h>

static btf_result run_device(decoding *d, const context_device *device) {
    char why[300];
    decode_rig rig;
    btf_result result = rig_create(device, d->repeats, &d->run->context->log, why, sizeof why, &rig);
    if (result != BTF_OK) {
        enc_log(d->run->context, BTF_LOG_INFO, "  %s: %s", device->name, why);
        fprintf(d->run->summary,
                "Device %s is not available: %s.\n"
                "\n",
                device->name, why);
        return result == BTF_ERROR_UNSUPPORTED ? BTF_OK : result;
    }
    decode_table_device(d->table, device->name, gpu_name(rig.gpu), rig.software);
    enc_log(d->run->context, BTF_LOG_INFO, "  %s: %s", device->name, gpu_name(rig.gpu));
    const btf_material *tables = NULL;
    for (int i = 0; i < DECODE_MATERIALS && result == BTF_OK; i++) {
        const decode_material *m = &d->materials[i];
        if (!m->name) {
            continue;
        }
        result = decode_gl_material(d, &rig, device->name, m, !d->run->quick);
        if (d->table->devices == 1 && !strchr(m->name, ';')) {
            decode_gl_sizes(d, &rig, device->name, m);
        }
        tables = tables ? tables : m->encoded.material;
    }
    if (result == BTF_OK && d->run->methods & BENCH_METHOD_PEERS) {
        result = decode_peers_run(d, &rig, device->name, tables);
    }
    rig_destroy(&rig);
    return result;
}

/* With --quick, one device for each shading language, since each keeps arithmetic exact in another way. */
static bool in_quick(const context_device *device) {
    static const char *const names[] = {"osmesa", "egl", "egl-es300", "glfw"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        if (strcmp(device->name, names[i]) == 0) {
            return true;
        }
    }
    return false;
}

/* Runs every device but softpipe: OSMesa can load one driver a process, and softpipe only interprets shaders. Devices
 * that name no driver use that of the user's environment. */
static btf_result run_devices(decoding *d) {
    const char *set = getenv("GALLIUM_DRIVER");
    char *users = set ? strdup(set) : NULL;
    btf_result result = BTF_OK;
    for (const context_device *device = context_devices; device->name && result == BTF_OK; device++) {
        const bool interprets = device->gallium_driver && strcmp(device->gallium_driver, "softpipe") == 0;
        if (users) {
            setenv("GALLIUM_DRIVER", users, 1);
        } else {
            unsetenv("GALLIUM_DRIVER");
        }
        const char *only = d->run->device;
        if (only ? strcmp(only, device->name) == 0 : !interprets && (!d->run->quick || in_quick(device))) {
            result = run_device(d, device);
        }
    }
    free(users);
    return result;
}

static btf_result measure(decoding *d) {
    const bench_held *held = d->run->held;
    btf_result result = decode_materials_create(d->run, d->materials);
    if (result == BTF_OK) {
        result = decode_probes_create(d->run->context, held->train, &d->trained);
    }
    if (result == BTF_OK && held->sets[2]) {
        result = decode_probes_create(d->run->context, held->sets[2], &d->held);
    }
    if (result == BTF_OK && d->run->truth->count > 0) {
        result = decode_probes_between(d->run->context, d->run->truth, &d->between);
    }
    if (result == BTF_OK) {
        result = decode_peers_find_ranks(d);
    }
    if (result == BTF_OK) {
        result = run_devices(d);
    }
    for (int i = 0; i < DECODE_MATERIALS && result == BTF_OK; i++) {
        const decode_material *m = &d->materials[i];
        if (m->name && d->run->methods & BENCH_METHOD_REFERENCE) {
            result = decode_cpu_run(d, m);
        }
    }
    return result;
}

btf_result bench_section_decode(const bench_run *run) {
    decoding d = {.run = run,
                  .repeats = run->repeats > BENCH_DECODE_REPEATS ? run->repeats : BENCH_DECODE_REPEATS,
                  .table = calloc(1, sizeof(decode_table)),
                  .floor = calloc(RIG_PIXELS, GPU_INPUTS * sizeof(uint32_t))};
    btf_result result =
        d.table && d.floor ? BTF_OK : enc_fail(run->context, BTF_ERROR_MEMORY, "bench: out of memory");
    if (result == BTF_OK) {
        result = measure(&d);
    }
    if (result == BTF_OK) {
        result = decode_table_write(run, d.table);
    }
    if (result == BTF_OK && d.table->devices > 0) {
        result = bench_readme_decode(run, d.table);
    }
    decode_materials_clear(d.materials);
    for (int i = 0; i < PEER_CODECS; i++) {
        pca_codec_clear(&d.components[i].codec);
    }
    decode_probes_clear(&d.trained);
    decode_probes_clear(&d.held);
    decode_probes_clear(&d.between);
    free(d.floor);
    free(d.table);
    return result;
}
