/* A small set of images in a folder of its own, for the tests of the reader, and checks of the result of reading it.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_IMAGE_SET_H
#define OPENBTF_TESTS_IMAGE_SET_H

#include "encoder/input/reader.h"
#include "messages.h"
#include "temporary.h"

enum { W = 5, H = 4, VIEWS = 4, LIGHTS = 5, PATH = 512 };

/* Theta and phi in degrees, in paper order. */
extern const double set_views[VIEWS][2], set_lights[LIGHTS][2];
extern const btf_log set_no_log;

/* The log of the context is log_keep. */
extern enc_context set_context;
/* Makes temporary_folder, forgets messages, gives the context its defaults: set-up of a cmocka test. */
int set_make_folder(void **state);
#define SET_TEST(name) TEST_WITH(name, set_make_folder, remove_temporary_folder)

/* The 8-bit code of a sample, and all of an image: [row][column][channel]. */
unsigned char set_code(int v, int l, int row, int column, int c);
void set_make_codes(int v, int l, unsigned char codes[W * H * 3]);

/* The name of an image by one of these naming schemes; valid until the next call. */
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
