/* The types of GLSL that the decoder uses, and of what its operators and functions give.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_WGSL_TYPES_H
#define OPENBTF_WGSL_TYPES_H

#include "tree.h"

#pragma GCC visibility push(hidden)

btfi_type btfi_type_of(btfi_base base, unsigned size);

/* The type of this name, of base VOID and size 1 for "void"; size 0: it names none. Structs are the caller's to look up. */
btfi_type btfi_named_type(const btfi_token *name);

int btfi_types_equal(btfi_type a, btfi_type b);

/* A bool, number or vector of them. */
int btfi_is_plain(btfi_type t);

/* The type of a `mark` b; size 0: GLSL has no such operation. */
btfi_type btfi_binary_type(const btfi_token *mark, btfi_type a, btfi_type b);

/* The type that the language's function of this name gives for arguments of these types; size 0: it is none of those known. */
btfi_type btfi_builtin_type(const btfi_token *name, const btfi_type *arguments, size_t count);

/* Whether a name is that of a function that btfi_builtin_type() knows. */
int btfi_is_builtin(const btfi_token *name);

/* Whether the function of this name gives the bits of its argument as a value of another type. */
int btfi_keeps_bits(const btfi_token *name);

/* a `mark` b of + - * / %, wrapped at 64 bits; returns 0 where the mark is another one or b divides by 0. */
int btfi_arithmetic(char mark, int64_t a, int64_t b, int64_t *out_value);

/* Whether a mark compares: == != < > <= >= */
int btfi_compares(const btfi_token *mark);

#pragma GCC visibility pop

#endif
