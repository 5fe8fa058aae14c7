/* SPDX-License-Identifier: MIT
 * text.c - the growing text of the emitted file, its hash (FNV-1a, 64 bit), numbers and names.
 */
#include <locale.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "gen_internal.h"

uint64_t hash_bytes(uint64_t hash, const void *at, size_t n)
{
    const unsigned char *byte = at;
    for (size_t i = 0; i < n; i++) {
        hash = (hash ^ byte[i]) * UINT64_C(1099511628211);
    }
    return hash;
}

void text_init(text *x)
{
    *x = (text){.hash = GEN_HASH};
}

static void append(text *x, const char *s, size_t n, int hashed)
{
    if (x->failed) {
        return;
    }
    if (x->n + n + 1 > x->cap) {
        size_t cap = 2 * (x->n + n + 1) + 4096;
        char *grown = realloc(x->s, cap);
        if (!grown) {
            x->failed = 1;
            return;
        }
        x->s = grown;
        x->cap = cap;
    }
    memcpy(x->s + x->n, s, n);
    x->n += n;
    x->s[x->n] = '\0';
    x->hash = hashed ? hash_bytes(x->hash, s, n) : x->hash;
}

static void append_format(text *x, const char *format, va_list ap, int hashed)
{
    char small[512];
    va_list again;
    va_copy(again, ap);
    int n = vsnprintf(small, sizeof small, format, ap);
    if (n < 0) {
        x->failed = 1;
    } else if ((size_t)n < sizeof small) {
        append(x, small, (size_t)n, hashed);
    } else {
        char *big = malloc((size_t)n + 1);
        if (big) {
            vsnprintf(big, (size_t)n + 1, format, again);
            append(x, big, (size_t)n, hashed);
        }
        x->failed |= !big;
        free(big);
    }
    va_end(again);
}

void text_add(text *x, const char *format, ...)
{
    va_list ap;
    va_start(ap, format);
    append_format(x, format, ap, !x->quiet);
    va_end(ap);
}

void text_quiet(text *x, const char *format, ...)
{
    va_list ap;
    va_start(ap, format);
    append_format(x, format, ap, 0);
    va_end(ap);
}

void text_number(char out[32], double value)
{
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(out, 32, "%.*g", digits, value);
        if (strtod(out, NULL) == value) {
            break;
        }
    }
    const char *point = localeconv()->decimal_point;
    char *comma = strstr(out, point);
    if (comma && strcmp(point, ".") != 0) {
        size_t n = strlen(point);
        *comma = '.';
        memmove(comma + 1, comma + n, strlen(comma + n) + 1);
    }
    if (!strpbrk(out, ".en")) { /* keep it a double in C */
        size_t n = strlen(out);
        snprintf(out + n, 32 - n, ".0");
    }
}

void text_literal(text *x, const char *s)
{
    text_add(x, "\"");
    for (; *s; s++) {
        unsigned char c = (unsigned char)*s;
        if (c == '"' || c == '\\' || c == '?') {
            text_add(x, "\\%c", c);
        } else if (c >= ' ' && c < 127) {
            text_add(x, "%c", c);
        } else {
            text_add(x, "\\%03o", c);
        }
    }
    text_add(x, "\"");
}

const char *text_safe(const char *s)
{
    const char *p = s;
    while ((*p >= 'A' && *p <= 'Z') || (*p >= 'a' && *p <= 'z') || (*p >= '0' && *p <= '9') ||
           *p == '_' || *p == '.') {
        p++;
    }
    return *s && !*p ? s : "?";
}
