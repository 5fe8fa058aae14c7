/* SPDX-License-Identifier: GPL-3.0-or-later
 * libcheck.c - blocks of libcheck begin as zeros: clang's memory sanitizer does not track the
 * writes of that library into them, and would report them as uninitialised. Linked with
 * VARIANT=memory only.
 */
#include <stdlib.h>

#include <sanitizer/msan_interface.h>

void *__wrap_emalloc(size_t n);
void *__wrap_erealloc(void *block, size_t n);

void *__wrap_emalloc(size_t n)
{
    void *block = calloc(1, n);
    if (block == NULL) {
        abort();
    }
    return block;
}

void *__wrap_erealloc(void *block, size_t n)
{
    block = realloc(block, n);
    if (block == NULL) {
        abort();
    }
    __msan_unpoison(block, n);
    return block;
}
