/* A report as a JSON file.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_REPORT_JSON_H
#define OPENBTF_ENCODER_REPORT_JSON_H

#include "report.h"

/* Writes the report; the file is whole or absent. `options` becomes the JSON member "options": alternating
 * names and values, NULL at the end. Errors: BTF_ERROR_IO, BTF_ERROR_MEMORY. */
btf_result enc_report_write(const enc_context *context, const enc_report *report,
                            const char *const *options, const char *path);

#endif
