/* Materials of nothing but limits, on GPUs: the same bits as the reference, or the device is not supported.
 *
 * SPDX-License-Identifier: MIT
 */
#include "bits.h"
#include "cases.h"

#include "tests/conformance/check.h"
#include "tests/conformance/variant.h"

#include <stdio.h>
#include <string.h>

/* All specs on one device. argv[1] names it. */
int main(int argc, char **argv) {
    const context_device *device = context_devices;
    while (device->name != NULL && (argc < 2 || strcmp(device->name, argv[1]) != 0)) {
        device++;
    }
    if (device->name == NULL) {
        fprintf(stderr, "test_decoder_gpu: expected the name of a device\n");
        return 1;
    }
    char why[300] = "", title[120];
    snprintf(title, sizeof title, "Materials of nothing but limits on the device %s against the reference.",
             device->name);
    cases_title(title);
    context_prepare(device);
    gpu *g = gpu_create(device, why, sizeof why);
    for (int i = 0; i < BITS_SPECS; i++) {
        const synthetic_spec s = bits_spec(i);
        const char *const expected = "the same finite bits at random and extreme arguments";
        char input[160];
        snprintf(input, sizeof input, "%s, %s, %s, %s, %u lobes%s, every parameter at a limit",
                 s.layout == BTF_LAYOUT_PAPER ? "paper" : "tight",
                 s.domain == BTF_DOMAIN_SQRT ? "square root" : "linear",
                 s.colour == BTF_COLOUR_RGB ? "RGB lobes" : "one colour",
                 s.half_float ? "halves" : "floats", s.lobes,
                 i < BITS_FACTORS             ? ""
                 : s.blend == BTF_BLEND_ROOTS ? ", factors blended as roots"
                                              : ", factors");
        if (g == NULL) {
            cases_skip(input, expected, why);
            continue;
        }
        random_state r = {(uint64_t)i + 31};
        bits_desc d;
        btf_material *material = NULL;
        bits_begin(&s, &d);
        bits_fill(&r, &d);
        btf_result result = btf_material_create(&d.desc, NULL, &material);
        const btf_shader_options shader = {.struct_size = sizeof shader,
                                           .interpolation =
                                               i & 1 ? BTF_INTERPOLATION_LINEAR : BTF_INTERPOLATION_NEAREST,
                                           .filter = i & 2 ? BTF_FILTER_BILINEAR : BTF_FILTER_TEXEL};
        const check_subject subject = {
            .gpu = g, .material = material, .shader = &shader, .label = "limits"};
        check_outcome outcome = {0};
        if (result == BTF_OK) {
            result = check_radiance(&subject, (uint64_t)i, 4000, &outcome);
        }
        cases_add(input, expected, result == BTF_OK && outcome.different == 0 && outcome.evaluated == 4000,
                  "%llu of %llu differ", (unsigned long long)outcome.different,
                  (unsigned long long)outcome.evaluated);
        btf_material_close(&material);
        bits_end(&d);
    }
    gpu_destroy(&g);
    return cases_result();
}
