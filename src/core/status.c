/* SPDX-License-Identifier: MIT
 * status.c - texts of the codes, and the formatter of messages.
 *
 * The core has no stdio (it also runs where there is none), so messages are put together by a
 * formatter of thirty lines for %s, %d and %g (9 significant digits, scientific).
 */
#include <math.h>
#include <stdarg.h>
#include <stddef.h>

#include "core.h"
#include "stein/version.h"

const char *stein_version(void)
{
    return STEIN_VERSION;
}

const char *stein_status_text(stein_status code)
{
    static const char *const text[] = {
#define STATUS_TEXT(name, words) words,
        STEIN_STATUS_LIST(STATUS_TEXT)
#undef STATUS_TEXT
    };
    return (int)code >= 0 && code < STEIN_STATUS_COUNT ? text[code] : "unknown status";
}

typedef struct out {
    char *at, *end;
} out;

static void put(out *o, char c)
{
    if (o->at < o->end) {
        *o->at++ = c;
    }
}

static void put_text(out *o, const char *s)
{
    for (; *s != '\0'; s++) { // a name may be anything: one line, nothing for a terminal to obey
        put(o, (char)((unsigned char)*s < ' ' || *s == 127 ? '?' : *s));
    }
}

static void put_int(out *o, int v)
{
    char digits[12];
    int n = 0;
    unsigned u = v < 0 ? 0u - (unsigned)v : (unsigned)v;
    do {
        digits[n++] = (char)('0' + u % 10u);
        u /= 10u;
    } while (u != 0u);
    if (v < 0) {
        put(o, '-');
    }
    while (n > 0) {
        put(o, digits[--n]);
    }
}

/* v = m 10^e with 1 <= m < 10, by halves: libm's powers and logarithms write errno. @return e */
static int decimal(double *v)
{
    static const double power[] = {1e256, 1e128, 1e64, 1e32, 1e16, 1e8, 1e4, 1e2, 1e1};
    static const int exponent[] = {256, 128, 64, 32, 16, 8, 4, 2, 1};
    int e = 0;
    for (int i = 0; *v >= 10.0 && i < 9; i++) {
        if (*v >= power[i]) {
            *v /= power[i];
            e += exponent[i];
        }
    }
    for (int i = 0; *v < 1.0 && i < 9; i++) {
        if (*v * power[i] < 10.0) {
            *v *= power[i];
            e -= exponent[i];
        }
    }
    return e;
}

/* 9 significant digits without trailing zeros; scientific outside 1e-4 .. 1e9 */
static void put_double(out *o, double v)
{
    if (isnan(v)) {
        put_text(o, "nan");
        return;
    }
    if (v < 0.0) {
        put(o, '-');
        v = -v;
    }
    if (isinf(v)) {
        put_text(o, "inf");
        return;
    }
    if (v == 0.0) {
        put(o, '0');
        return;
    }
    int e = decimal(&v); // 1 <= v < 10, but for rounding
    double scaled = floor(v * 1e8 + 0.5);
    if (scaled >= 1e9) {
        scaled = floor(scaled / 10.0 + 0.5);
        e++;
    }
    char digit[9];
    long long m = (long long)scaled;
    for (int i = 8; i >= 0; i--, m /= 10) {
        digit[i] = (char)('0' + m % 10);
    }
    int n = 9;
    while (n > 1 && digit[n - 1] == '0') {
        n--;
    }
    int scientific = e < -4 || e >= 9;
    int point = scientific ? 0 : e; /* digit after which the decimal point stands */
    if (point < 0) {
        put_text(o, "0.");
        for (int i = -1; i > point; i--) {
            put(o, '0');
        }
    }
    for (int i = 0; i < n || i <= point; i++) {
        put(o, (char)(i < n ? digit[i] : '0'));
        if (i == point && i + 1 < n) {
            put(o, '.');
        }
    }
    if (scientific) {
        put(o, 'e');
        put_int(o, e);
    }
}

stein_status stein__fail(stein_err *err, stein_status code, const char *format, ...)
{
    if (err == NULL) {
        return code;
    }
    out o = {err->msg, err->msg + sizeof err->msg - 1};
    va_list args;
    va_start(args, format);
    for (const char *f = format; *f != '\0'; f++) {
        if (*f != '%') {
            put(&o, *f);
            continue;
        }
        switch (*++f) {
        case 's': put_text(&o, va_arg(args, const char *)); break;
        case 'd': put_int(&o, va_arg(args, int)); break;
        default: put_double(&o, va_arg(args, double)); break;
        }
    }
    va_end(args);
    *o.at = '\0';
    err->code = code;
    return code;
}
