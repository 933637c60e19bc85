/* OpenBTF: how the library fails: messages, and the code that a check answers with. Names that its files
 * share and users do not see begin with btfi_.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RESULT_INTERNAL_H
#define OPENBTF_RESULT_INTERNAL_H

#include <openbtf/result.h>

#pragma GCC visibility push(hidden)

/* Sends a message to log (which may be NULL) and returns `result`. */
btf_result btfi_fail(const btf_log *log, btf_result result, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Where a check reports, and the code that a failure has: BTF_ERROR_BAD_FILE when reading, BTF_ERROR_USAGE
 * when creating. */
typedef struct btfi_check {
    const btf_log *log;
    btf_result code;
} btfi_check;

#pragma GCC visibility pop

#endif
