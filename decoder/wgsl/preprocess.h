/* The preprocessor of GLSL: conditions are resolved and macros expanded.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_WGSL_PREPROCESS_H
#define OPENBTF_WGSL_PREPROCESS_H

#include "tokens.h"

#include <openbtf/result.h>

#pragma GCC visibility push(hidden)

/* The tokens of a text that are left, an END behind the last; btfi_tokens_free frees them, after an error as well. Their
 * texts are parts of `glsl`, which has to last as long. GL_ES and WGSL are defined, and __VERSION__ as 300. Known are
 * #define of names and of functions, #if, #ifdef, #ifndef, #else, #endif, #undef. Errors, with a message of
 * `message_size` bytes at most: BTF_ERROR_UNSUPPORTED (another directive, a condition that is no integer expression of
 * numbers and defined names, a macro's arguments), BTF_ERROR_MEMORY. */
btf_result btfi_preprocess(const char *glsl, btfi_tokens *out_tokens, char *message, size_t message_size);

#pragma GCC visibility pop

#endif
