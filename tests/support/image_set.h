/* A small set of images in a folder of its own, for the tests of the reader, and what comes of reading it.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_IMAGE_SET_H
#define OPENBTF_TESTS_IMAGE_SET_H

#include "encoder/input/reader.h"

enum { W = 5, H = 4, VIEWS = 4, LIGHTS = 5, PATH = 512 };

/* Theta and phi in degrees, in paper order. */
extern const double set_views[VIEWS][2], set_lights[LIGHTS][2];
extern const btf_log set_no_log;

/* Made by set_make_folder, which also empties the messages and gives the context its defaults: set-up and
 * tear-down of a cmocka test. */
extern char set_folder[256];
extern char set_messages[8192]; /* of the context, a line each: level, text */
extern enc_context set_context;
int set_make_folder(void **state);
int set_remove_folder(void **state);

/* The 8-bit code of a sample, and all of an image: [row][column][channel]. */
unsigned char set_code(int v, int l, int row, int column, int c);
void set_make_codes(int v, int l, unsigned char codes[W * H * 3]);

/* The name of an image in one of the customs, made anew for each call. */
typedef enum custom { UBO, UTIA, BONN, FOLDERS } custom;
const char *set_name_of(custom naming, int v, int l, const char *extension);

/* Writes one image, or all, as 8-bit PNG. */
void set_write_png8(custom naming, int v, int l);
void set_write(custom naming);

/* Reads the folder; fails the test where that fails. */
enc_data *set_read_folder(const enc_read_options *options);

/* Fails unless reading is refused with this result and a message that holds all of the words (up to a
 * NULL). */
void set_expect_refused(const char *input, const enc_read_options *options, btf_result expected, ...);

float set_sample(const enc_data *data, int v, int l, int row, int column, int c);

/* Directions in order, and each sample within `tolerance` of the linear value of its code. */
void set_expect(const enc_data *data, double tolerance);

#endif
