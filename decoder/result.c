/* OpenBTF: texts and exit codes of the result codes.
 *
 * SPDX-License-Identifier: MIT
 */
#include <openbtf/result.h>

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
