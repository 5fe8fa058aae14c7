/* SPDX-License-Identifier: MIT
 * status.h - error codes and messages: the only way libstein reports a failure.
 *
 * Fallible calls return a stein_status and take a last, nullable `stein_err *`, which receives
 * the code again and one sentence that names file:line:column, field, joint or time. Out-parameters
 * stay untouched on failure. Nothing prints, exits, aborts or sets errno.
 */
#ifndef STEIN_STATUS_H
#define STEIN_STATUS_H

#ifdef __cplusplus
extern "C" {
#endif

/** Every code once: the enum and stein_status_text() are both expanded from this list. */
#define STEIN_STATUS_LIST(X)                                                   \
    X(OK, "success")                                                           \
    X(EINVAL, "invalid argument")                                              \
    X(ENAME, "no such name in the model")                                      \
    X(ENOMEM, "out of memory")                                                 \
    X(ENONFINITE, "the state is no longer finite")                             \
    X(ESINGULAR, "the mass matrix is singular")                                \
    X(ECHATTER, "too many contact events within one step")                     \
    X(ESETTLE, "no static equilibrium found")                                  \
    X(EIO, "file cannot be read or written")                                   \
    X(EPARSE, "the mechanism file is not valid")                               \
    X(EGENERATE, "the equations cannot be generated")                          \
    X(ECOMPILE, "the generated equations cannot be compiled")                  \
    X(ELOAD, "the compiled equations cannot be loaded")                        \
    X(ESTALE, "the compiled equations belong to another mechanism or version") \
    X(ESTOPPED, "stopped by its caller")                                       \
    X(ECLOSE, "a loop cannot be closed")

typedef enum stein_status {
#define STEIN_STATUS_ENUM(code, text) STEIN_##code,
    STEIN_STATUS_LIST(STEIN_STATUS_ENUM)
#undef STEIN_STATUS_ENUM
        STEIN_STATUS_COUNT
} stein_status;

/** What went wrong, in one sentence without a newline. Filled only on failure. */
typedef struct stein_err {
    stein_status code;
    char msg[240];
} stein_err;

/** Fixed text of a code ("unknown status" for a number that is none). Static storage. */
const char *stein_status_text(stein_status code);

#ifdef __cplusplus
}
#endif
#endif
