/* SPDX-License-Identifier: MIT
 * sanitizer.h - memory that a library wrote which clang's memory sanitizer does not see into.
 * Without that sanitizer these are nothing.
 * Included by: this folder.
 */
#ifndef SANITIZER_H
#define SANITIZER_H

#if defined __has_feature
#if __has_feature(memory_sanitizer)
#include <sanitizer/msan_interface.h>
#define WRITTEN(object)     __msan_unpoison(&(object), sizeof(object))
#define WRITTEN_TEXT(at, n) __msan_unpoison(at, n)
#endif
#endif

#ifndef WRITTEN
#define WRITTEN(object)     ((void)0)
#define WRITTEN_TEXT(at, n) ((void)0)
#endif

#endif
