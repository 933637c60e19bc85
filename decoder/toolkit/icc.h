/* The name of a colour profile.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_ICC_H
#define OPENBTF_TOOLS_ICC_H

#include "image_info.h"

/* Heeds the profile that a file of `format` ("PNG") embeds: one whose description names sRGB (and does not call it
 * linear) sets that transfer function, any other leaves a note that names it. data[size]: the profile, which
 * may be damaged; name: what the file calls it, for one without a description; may be NULL. */
void icc_heed(image_info *info, const char *format, const unsigned char *data, size_t size, const char *name);

#endif
