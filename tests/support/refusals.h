/* Materials that must be refused, with the message that says why.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_REFUSALS_H
#define OPENBTF_TESTS_REFUSALS_H

#include "exr_edit.h"
#include <openbtf/material.h>

/* The last message that log_keep heard. */
extern char last_message[2048];
extern const btf_log log_keep;

/* Creating must fail, with a log and without, with a message that holds `text`. */
void create_refused(const btf_material_desc *desc, const char *text);

/* Saves, opens, frees the edited file. */
btf_result open_edited(edit_file *file, btf_material **out_material);

/* The edited file must be refused with this code and a message that holds `text`. */
void refused_as(edit_file *file, btf_result code, const char *text);

#endif
