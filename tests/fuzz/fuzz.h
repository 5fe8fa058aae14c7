/* SPDX-License-Identifier: GPL-3.0-or-later
 * fuzz.h - shared by the fuzz targets. A target is one function of bytes; `make fuzz` links it
 * with clang's libFuzzer and lets it run, `make check` feeds it the kept files of
 * tests/fuzz/corpus/.
 *
 * A target fails when it crashes, hangs, trips a sanitizer, or when `must` does not hold.
 */
#ifndef FUZZ_H
#define FUZZ_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/** One input. @return 0 */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static inline void must(int holds, const char *what)
{
    if (!holds) {
        fprintf(stderr, "does not hold: %s\n", what);
        abort();
    }
}

/** A file of these bytes, by a path that can be opened; its descriptor is reused. */
const char *fuzz_file(const void *data, size_t size);

/** The next line of an input, as a separate string in `line`. @return 0 when there is none */
static inline int fuzz_line(const uint8_t **data, size_t *size, char *line, size_t room)
{
    if (*size == 0) {
        return 0;
    }
    const uint8_t *end = memchr(*data, '\n', *size);
    size_t n = end != NULL ? (size_t)(end - *data) : *size, take = n < room ? n : room - 1;
    memcpy(line, *data, take);
    line[take] = '\0';
    *data += n + (end != NULL);
    *size -= n + (end != NULL);
    return 1;
}

#endif
