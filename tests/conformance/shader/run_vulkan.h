/* Runs the decoder of a folder of btf-shader in a compute shader of Vulkan.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TEST_RUN_VULKAN_H
#define OPENBTF_TEST_RUN_VULKAN_H

#include "exported.h"

/* `code` is SPIR-V of code_size bytes, with the entry point `main` of groups of 64, textures in set 0 and records in set 1
 * at binding 0; `count` is a multiple of 64. Ends the process as a skipped test (77) without a device, and with 4, after a
 * message, where it refuses something. */
void run_vulkan(const exported *e, const uint32_t *code, size_t code_size, uint32_t *records, size_t count);

#endif
