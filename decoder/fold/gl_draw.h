/* Draws in a GL context of the caller's: programs, and saving and restoring all state that drawing changes.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_GL_DRAW_H
#define OPENBTF_GL_DRAW_H

#include "decoder/gl_functions.h"

#pragma GCC visibility push(hidden)

enum { BTFI_CAPABILITY_COUNT = 18, BTFI_PACK_COUNT = 4 };

/* The state that drawing touches. */
typedef struct btfi_gl_state {
    uint8_t enabled[BTFI_CAPABILITY_COUNT], mask[4];
    int32_t polygon_mode[2]; /* front, back; core contexts have one mode, and may fill in only the first */
    float viewport[4];
    int32_t draw, read, array, program, texture, texture_array, unit, sampler, pack_buffer,
        pack[BTFI_PACK_COUNT];
    btfi_gl_unpack unpack;
} btfi_gl_state;

/* The first saves the state in *s and sets what drawing into integer textures needs; the second restores it. Where the
 * context has a state for each draw buffer or viewport, only that of the first one is touched. */
void btfi_gl_save_state(const btfi_gl_functions *gl, btfi_gl_state *s);
void btfi_gl_restore_state(const btfi_gl_functions *gl, const btfi_gl_state *s);

/* Sets the viewport that is drawn in, from 0, 0. */
void btfi_gl_viewport(const btfi_gl_functions *gl, uint32_t width, uint32_t height);

/* The line of the newest GLSL that the context claims. */
void btfi_gl_version(const btfi_gl_functions *gl, char *out_line, size_t size);

/* A program that fills the viewport from a fragment shader of `count` pieces, the first of which is its
 * version; 0 when GL refuses it, with a message on log that names it `what`. */
uint32_t btfi_gl_program(const btfi_gl_functions *gl, int count, const char *const *fragment_parts,
                         const char *what, const btf_log *log);

#pragma GCC visibility pop

#endif
