/* Materials that must be accepted, or refused with the message that says why.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_REFUSALS_H
#define OPENBTF_TESTS_REFUSALS_H

#include "exr_edit.h"
#include "messages.h"
#include <openbtf/material.h>
#include <stdbool.h>

/* All functions below log to log_keep, and fail where a refusal gives no message. */

/* Creating must succeed; where it does not, the refusal is printed. */
btf_material *create_accepted(const btf_material_desc *desc);

/* Creating must fail, with a log and without, with a message that holds `text`. */
void create_refused(const btf_material_desc *desc, const char *text);

/* The info of an accepted material; and whether it has a texture. */
btf_material_info accepted_info(const btf_material *material);
bool accepted_texture(const btf_material *material, btf_texture_id id);

/* A file in memory, freed with btf_free: of a material; as one to be edited. */
typedef struct saved {
    void *data;
    size_t size;
} saved;
saved save_material(const btf_material *material);
edit_file *take(const saved *file);

/* The edited file must open. */
btf_material *open_accepted(edit_file *file);
void file_accepted(edit_file *file);

/* Saves, opens, frees the edited file. */
btf_result open_edited(edit_file *file, btf_material **out_material);

/* The edited file must be refused with this code and a message that holds `text`. */
void refused_as(edit_file *file, btf_result code, const char *text);
/* The same with BTF_ERROR_BAD_FILE. */
void file_refused(edit_file *file, const char *text);
/* The file must be refused after `change`, an expression in which it is `e`. */
#define EDIT_REFUSED(file, change, text)                                                                   \
    do {                                                                                                   \
        edit_file *e = file;                                                                               \
        change;                                                                                            \
        file_refused(e, text);                                                                             \
    } while (0)
/* file_refused after a change of the floatvector openbtf.`name`: of one number (from the end where index is below
 * 0), or of their count. */
void number_refused(edit_file *file, const char *name, int index, float value, const char *text);
void count_refused(edit_file *file, const char *name, int count, const char *text);

#endif
