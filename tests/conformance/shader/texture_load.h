/* Reads the texture files of btf-shader as another program would: written from the specifications of KTX 2.0, of the
 * Khronos data format descriptor and of DDS, and not from the code that writes the files. Every field is checked.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TEST_TEXTURE_LOAD_H
#define OPENBTF_TEST_TEXTURE_LOAD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { LOADED_LEVELS = 15 };

/* A texture as a file says it is. */
typedef struct loaded {
    uint32_t vulkan, dxgi; /* the format: its number in KTX, its number in DDS files; the other is 0 */
    uint32_t width, height, layers; /* of the finest level */
    bool is_array;                  /* a DDS file of one layer does not say */
    uint32_t levels;
    size_t texel;                       /* bytes */
    size_t size[LOADED_LEVELS];         /* bytes of a level */
    unsigned char *data[LOADED_LEVELS]; /* [layer][row][column], malloc'ed */
} loaded;

/* Each reads the bytes of a file. False, with a message on stderr, where the file breaks a rule. */
bool load_ktx2(const char *name, const unsigned char *bytes, size_t size, loaded *out);
bool load_dds(const char *name, const unsigned char *bytes, size_t size, loaded *out);

/* The whole file, malloc'ed; NULL with a message on stderr. */
unsigned char *load_file(const char *path, size_t *out_size);
void loaded_free(loaded *t);

#endif
