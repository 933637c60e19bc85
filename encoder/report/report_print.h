/* A report as tables, for people.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_REPORT_PRINT_H
#define OPENBTF_ENCODER_REPORT_PRINT_H

#include "report.h"

void enc_report_print(const enc_report *report, FILE *out);

#endif
