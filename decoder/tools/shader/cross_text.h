/* SPIRV-Cross writes whole shaders; these functions make libraries of them, of names that do not meet those of others.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_SHADER_CROSS_TEXT_H
#define OPENBTF_SHADER_CROSS_TEXT_H

#include <openbtf/result.h>

/* The texts one after the other, up to a NULL. Freed by the caller; NULL without memory. */
char *cross_join(const char *const *texts);

/* A copy in which every word that begins with `from` ("P_") begins with the prefix and an underscore. Freed by the
 * caller, too; NULL without memory. */
char *cross_replace_prefix(const char *text, const char *from, const char *prefix);

/* The library of HLSL: the decoder's textures and functions alone, without the entry point and its buffer. Names of
 * constants that SPIRV-Cross made up get the prefix. *out_text is freed by the caller. Errors, on the log:
 * BTF_ERROR_MEMORY, BTF_ERROR_INTERNAL (the text is not as this function knows it from SPIRV-Cross 0.54). */
btf_result cross_hlsl(const char *text, const char *prefix, const btf_log *log, char **out_text);

/* The library in Metal's language, with its kernel only where PREFIX_ENTRY is defined. SPIRV-Cross protects products
 * as fma(l, r, 0), which makes +0 of -0, and passes over those of a vector and a number: here all become fma(l, r,
 * -0). Errors likewise. */
btf_result cross_msl(const char *text, const char *prefix, const btf_log *log, char **out_text);

#endif
