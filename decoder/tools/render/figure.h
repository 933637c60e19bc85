/* Figure 13 of the paper: the original beside what each part of the method gives, with errors.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RENDER_FIGURE_H
#define OPENBTF_RENDER_FIGURE_H

#include "picture.h"

enum { FIGURE_COLUMNS = 4, FIGURE_GAIN = 4 };

/* pictures[4] = original, SBRDF, STVS, full, of one size. Above: the pictures; below: |difference| to the
 * original times FIGURE_GAIN; each with a caption. Prints a line of PSNR (over the pixels of mask) for each
 * on stdout. Errors: BTF_ERROR_IO, BTF_ERROR_MEMORY. */
btf_result figure_write(const picture *pictures, const unsigned char *mask, const char *path, tone t,
                        btf_log log);

#endif
