/* SPDX-License-Identifier: MIT
 * sanitizer.h - memory written by a library without instrumentation of clang's memory sanitizer.
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
