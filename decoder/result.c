/* OpenBTF: result codes: their texts, their exit codes, and the message that goes with one.
 *
 * SPDX-License-Identifier: MIT
 */
#include "result.h"

#include <stdarg.h>
#include <stdio.h>

btf_result btfi_fail(const btf_log *log, btf_result result, const char *format, ...) {
    if (log && log->callback) {
        char message[1024];
        va_list arguments;
        va_start(arguments, format);
        vsnprintf(message, sizeof message, format, arguments);
        va_end(arguments);
        log->callback(log->user, BTF_LOG_ERROR, message);
    }
    return result;
}

const char *btf_result_text(btf_result result) {
    switch (result) {
#define RESULT_TEXT(name, value, exit_code, text)                                                          \
    case name:                                                                                             \
        return text;
        BTF_RESULT_LIST(RESULT_TEXT)
#undef RESULT_TEXT
    }
    return "unknown result";
}

int btf_result_exit_code(btf_result result) {
    switch (result) {
#define RESULT_EXIT_CODE(name, value, exit_code, text)                                                     \
    case name:                                                                                             \
        return exit_code;
        BTF_RESULT_LIST(RESULT_EXIT_CODE)
#undef RESULT_EXIT_CODE
    }
    return btf_result_exit_code(BTF_ERROR_INTERNAL);
}
