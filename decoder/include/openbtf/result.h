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

/** How a call ended: BTF_OK, or an error of BTF_RESULT_LIST. */
typedef enum btf_result {
#define BTF_RESULT_ENUM(name, value, exit_code, text) name = value,
    BTF_RESULT_LIST(BTF_RESULT_ENUM)
#undef BTF_RESULT_ENUM
} btf_result;

/** @return a static English text, e.g. "bad file"; "unknown result" for a value off the list. */
const char *btf_result_text(btf_result result);

/** @return the exit code of the tools for @p result, the third column of BTF_RESULT_LIST; each tool's --help lists
 * them. */
int btf_result_exit_code(btf_result result);

/** The severity of a message. */
typedef enum btf_log_level {
    BTF_LOG_ERROR = 0,   /**< the reason for which the call fails */
    BTF_LOG_WARNING = 1, /**< the call goes on, but its result may not be the one wanted */
    BTF_LOG_INFO = 2,    /**< progress or a choice that was made */
} btf_log_level;

/** Receives one complete message, without a newline; @p message is valid during the call only. It is called from the
 * thread that called the library, never from another. */
typedef void (*btf_log_callback)(void *user, btf_log_level level, const char *message);

/** The receiver of messages. A null pointer to btf_log, or a null callback, drops them. */
typedef struct btf_log {
    btf_log_callback callback; /**< receives each message */
    void *user;                /**< handed to callback */
} btf_log;

#ifdef __cplusplus
}
#endif
#endif
