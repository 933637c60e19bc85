/* OpenBTF: result codes and the message callback shared by every call that can fail.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RESULT_H
#define OPENBTF_RESULT_H

#ifdef __cplusplus
extern "C" {
#endif

/** The one list of result codes: name, value, exit code of the tools, text. */
#define BTF_RESULT_LIST(X)                                                                                 \
    X(BTF_OK, 0, 0, "ok")                                                                                  \
    X(BTF_ERROR_USAGE, 1, 1, "invalid argument")                                                           \
    X(BTF_ERROR_IO, 2, 2, "input or output failed")                                                        \
    X(BTF_ERROR_BAD_FILE, 3, 3, "bad file")                                                                \
    X(BTF_ERROR_INTERNAL, 4, 4, "internal error")                                                          \
    X(BTF_ERROR_MEMORY, 5, 4, "out of memory")                                                             \
    X(BTF_ERROR_UNSUPPORTED, 6, 5, "not supported")                                                        \
    X(BTF_ERROR_DIFFERENT, 7, 7, "difference found")                                                       \
    X(BTF_ERROR_INTERRUPTED, 8, 130, "interrupted")

typedef enum btf_result {
#define BTF_RESULT_ENUM(name, value, exit_code, text) name = value,
    BTF_RESULT_LIST(BTF_RESULT_ENUM)
#undef BTF_RESULT_ENUM
} btf_result;

/** @return a static English text, e.g. "bad file"; "unknown result" for a value off the list. */
const char *btf_result_text(btf_result result);

/** @return the process exit code documented for @p result (see README.md, "Exit codes"). */
int btf_result_exit_code(btf_result result);

typedef enum btf_log_level {
    BTF_LOG_ERROR = 0,
    BTF_LOG_WARNING = 1,
    BTF_LOG_INFO = 2,
} btf_log_level;

/** Receives one complete message without a newline; @p message is valid during the call only.
 *  May be called from the thread that called the library, never from another. */
typedef void (*btf_log_callback)(void *user, btf_log_level level, const char *message);

/** Where messages go. A null pointer to btf_log, or a null callback, drops them. */
typedef struct btf_log {
    btf_log_callback callback;
    void *user;
} btf_log;

#ifdef __cplusplus
}
#endif
#endif
