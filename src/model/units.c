/* SPDX-License-Identifier: MIT
 * units.c - numbers and units as text: "82 g", "7.2 mm", "4e-2 N m/rad", "0.0072".
 *
 * The power of ten of the unit is added to the exponent of the number before the one conversion by
 * strtod, so "7.2 mm" and "0.0072" give the same bits. The grammar is checked here and the
 * conversion runs in the "C" locale: neither a German locale nor "0x1p3", "inf" or "8,2" gets by.
 *
 *   number  = digits [ "." digits ] [ "e" [sign] digits ]
 *   unit    = [ "1" ] "/" factor ... | factor { ("*" | " " | "/") factor } | "%"
 *   factor  = name [ "^" [ "-" ] digits ]
 */
#include <errno.h>
#include <float.h>
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "reader.h"

static const double degree = 3.14159265358979323846 / 180.0;

enum { MAX_EXPONENT = 20, MAX_DIGITS = 60, MAX_PARTS = 4, SPELLED = 60 };

typedef struct unit {
    const char *name;
    signed char kg, m, s, rad, A;
    signed char exp10; /* power of ten of the factor */
    signed char deg;   /* power of pi/180 */
} unit;

static const unit units[] = {
    {"m", 0, 1, 0, 0, 0, 0, 0},      {"mm", 0, 1, 0, 0, 0, -3, 0},
    {"um", 0, 1, 0, 0, 0, -6, 0},    {"cm", 0, 1, 0, 0, 0, -2, 0},
    {"km", 0, 1, 0, 0, 0, 3, 0},     {"kg", 1, 0, 0, 0, 0, 0, 0},
    {"g", 1, 0, 0, 0, 0, -3, 0},     {"mg", 1, 0, 0, 0, 0, -6, 0},
    {"s", 0, 0, 1, 0, 0, 0, 0},      {"ms", 0, 0, 1, 0, 0, -3, 0},
    {"us", 0, 0, 1, 0, 0, -6, 0},    {"rad", 0, 0, 0, 1, 0, 0, 0},
    {"mrad", 0, 0, 0, 1, 0, -3, 0},  {"deg", 0, 0, 0, 1, 0, 0, 1},
    {"Hz", 0, 0, -1, 0, 0, 0, 0},    {"kHz", 0, 0, -1, 0, 0, 3, 0},
    {"N", 1, 1, -2, 0, 0, 0, 0},     {"mN", 1, 1, -2, 0, 0, -3, 0},
    {"kN", 1, 1, -2, 0, 0, 3, 0},    {"J", 1, 2, -2, 0, 0, 0, 0},
    {"mJ", 1, 2, -2, 0, 0, -3, 0},   {"Pa", 1, -1, -2, 0, 0, 0, 0},
    {"kPa", 1, -1, -2, 0, 0, 3, 0},  {"MPa", 1, -1, -2, 0, 0, 6, 0},
    {"A", 0, 0, 0, 0, 1, 0, 0},      {"mA", 0, 0, 0, 0, 1, -3, 0},
    {"V", 1, 2, -3, 0, -1, 0, 0},    {"mV", 1, 2, -3, 0, -1, -3, 0},
    {"ohm", 1, 2, -3, 0, -2, 0, 0},  {"mohm", 1, 2, -3, 0, -2, -3, 0},
    {"kohm", 1, 2, -3, 0, -2, 3, 0},
};
enum { NUNITS = sizeof units / sizeof units[0] };

/** A unit while it is read: exponents are int, so that they can be checked before they are cut. */
typedef struct product {
    int kg, m, s, rad, A, exp10, deg;
} product;

static int is_digit(char c)
{
    return c >= '0' && c <= '9';
}

static int is_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

static const char *skip_blanks(const char *s)
{
    while (*s == ' ' || *s == '\t' || *s == '\n') {
        s++;
    }
    return s;
}

static const unit *find_unit(const char *name, size_t length)
{
    for (int i = 0; i < NUNITS; i++) {
        if (strlen(units[i].name) == length && memcmp(units[i].name, name, length) == 0) {
            return &units[i];
        }
    }
    return NULL;
}

/** Length of a word that can only be a unit: letters, no reference and no function. */
static size_t unit_word(const char *s)
{
    size_t n = 0;

    while (is_letter(s[n])) {
        n++;
    }
    if (is_digit(s[n]) || s[n] == '_' || s[n] == '.' || *skip_blanks(s + n) == '(') {
        return 0;
    }
    return n;
}

static int same_kind(const unit *a, const unit *b)
{
    return a->kg == b->kg && a->m == b->m && a->s == b->s && a->rad == b->rad;
}

/** Splits a word into names of units: "Nms" into "N", "m", "s". The first one is as long as
 *  possible, the others are short, and no two of a kind are neighbours: "mNm" is mN m, "Nmm" is
 *  N mm. @return their number, 0: none */
static int split_units(const char *s, size_t n, const unit *before, const unit *part[MAX_PARTS],
                       int count)
{
    for (size_t k = 1; k <= n && count < MAX_PARTS; k++) {
        size_t length = before ? k : n + 1 - k;
        const unit *u = find_unit(s, length);

        if (!u || (before && same_kind(before, u))) {
            continue;
        }
        part[count] = u;
        if (length == n) {
            return count + 1;
        }
        int all = split_units(s + length, n - length, u, part, count + 1);

        if (all > 0) {
            return all;
        }
    }
    return 0;
}

/** Letters of "cm2", a power that lacks its "^"; 0: it is none. Names have a point, "m2.mass". */
static size_t bare_power(const char *s)
{
    const unit *part[MAX_PARTS];
    size_t n = 0, digits = 0;

    while (is_letter(s[n])) {
        n++;
    }
    while (is_digit(s[n + digits])) {
        digits++;
    }
    char next = s[n + digits];

    return n > 0 && digits > 0 && !is_letter(next) && next != '_' && next != '.' &&
                   *skip_blanks(s + n + digits) != '(' && split_units(s, n, NULL, part, 0) > 0
               ? n
               : 0;
}

/** "kgm^2" as "kg m^2", "kg cm2" as "kg cm^2": a unit from `from`, of which a word at s is split.
 *  @return 0: the word is no product of units */
static int respell(const char *from, const char *s, size_t n, char to[SPELLED])
{
    const unit *part[MAX_PARTS];
    int parts = split_units(s, n, NULL, part, 0);
    const char *between = s > from && s[-1] == '/' ? "/" : " ";
    size_t used = 0;

    for (const char *c = from; c < s && used + 1 < SPELLED; c++) {
        to[used++] = *c;
    }
    to[used] = '\0';
    for (int i = 0; i < parts; i++) {
        used += (size_t)snprintf(to + used, SPELLED - used, "%s%s", i > 0 ? between : "",
                                 part[i]->name);
        used = used < SPELLED ? used : SPELLED - 1;
    }
    for (const char *c = s + n; is_letter(*c) || is_digit(*c) || (*c && strchr("^/*-", *c)); c++) {
        if (is_digit(*c) && is_letter(c[-1]) && used + 1 < SPELLED) {
            to[used++] = '^';
        }
        if (used + 1 < SPELLED) {
            to[used++] = *c;
        }
    }
    to[used] = '\0';
    return parts;
}

/** "Nm" is meant as "N m", "gg" as "g" (two masses are no product), "KG" as "kg".
 *  @param from  where the unit begins of which the word at s is a part */
static void unknown_unit(const char *from, const char *s, size_t n, char why[MECH__WHY])
{
    char word[32] = "", better[SPELLED];
    mech__nearest near = {word, NULL, 0};
    int shown = n < sizeof word ? (int)n : (int)sizeof word - 1;

    memcpy(word, s, (size_t)shown);
    for (size_t i = 1; i < n; i++) {
        const unit *first = find_unit(s, i), *second = find_unit(s + i, n - i);

        if (first && second && same_kind(first, second)) {
            snprintf(why, MECH__WHY, "unknown unit \"%s\", did you mean \"%s\"?", word,
                     strlen(first->name) < strlen(second->name) ? second->name : first->name);
            return;
        }
    }
    if (respell(from, s, n, better) > 0) {
        snprintf(why, MECH__WHY, "unknown unit \"%s\", did you mean \"%s\"?", word, better);
        return;
    }
    for (int i = 0; i < NUNITS; i++) {
        mech__offer(&near, units[i].name);
    }
    if (near.best) {
        snprintf(why, MECH__WHY, "unknown unit \"%s\", did you mean \"%s\"?", word, near.best);
    } else {
        snprintf(why, MECH__WHY,
                 "unknown unit \"%s\", expected one of m mm um cm km kg g mg s ms "
                 "us rad mrad deg Hz kHz N mN kN J mJ Pa kPa MPa A mA V mV ohm mohm kohm",
                 word);
    }
}

/** One factor "mm^2" at s of a unit from `from`, to the power sign. @return bytes used, -1 on
 * error, 0 when none is here */
static int factor_at(const char *from, const char *s, int sign, product *u, char why[MECH__WHY])
{
    char better[SPELLED];
    size_t n = unit_word(s), letters = bare_power(s);
    const unit *f = find_unit(s, n);
    const char *end = s + n;
    int power = 0;

    if (letters > 0 && respell(from, s, letters, better) > 0) {
        snprintf(why, MECH__WHY, "a power needs \"^\" in a unit, did you mean \"%s\"?", better);
        return -1;
    }
    if (n == 0) {
        return 0;
    }
    if (!f) {
        unknown_unit(from, s, n, why);
        return -1;
    }
    if (*end != '^') {
        power = 1;
    } else {
        int minus = end[1] == '-';

        end += 1 + minus;
        if (!is_digit(*end)) {
            snprintf(why, MECH__WHY, "after \"^\" a whole number is expected");
            return -1;
        }
        for (; is_digit(*end); end++) {
            power = power > MAX_EXPONENT ? power : 10 * power + (*end - '0');
        }
        sign = minus ? -sign : sign;
    }
    power *= sign;
    u->kg += power * f->kg;
    u->m += power * f->m;
    u->s += power * f->s;
    u->rad += power * f->rad;
    u->A += power * f->A;
    u->exp10 += power * f->exp10;
    u->deg += power * f->deg;
    if (abs(power) > MAX_EXPONENT || abs(u->kg) > MAX_EXPONENT || abs(u->m) > MAX_EXPONENT ||
        abs(u->s) > MAX_EXPONENT || abs(u->rad) > MAX_EXPONENT || abs(u->A) > MAX_EXPONENT) {
        snprintf(why, MECH__WHY, "the powers of the unit are too large");
        return -1;
    }
    return (int)(end - s);
}

/** Unit at s (which may begin with blanks). Stops before operators of a formula around it.
 *  @return bytes used, 0 when no unit is here, -1 on error */
static int unit_at(const char *s, product *u, char why[MECH__WHY], const char **bad)
{
    const char *at = skip_blanks(s), *begin = at;
    const char *after_one = *at == '1' ? skip_blanks(at + 1) : at;
    int divided = 0;
    int used;

    memset(u, 0, sizeof *u);
    *bad = at;
    if (*after_one == '/') {
        const char *name = skip_blanks(after_one + 1);

        if (unit_word(name) == 0 && bare_power(name) == 0) {
            return 0;
        }
        *bad = name;
        used = factor_at(at, name, -1, u, why);
        at = name;
        divided = 1;
    } else {
        used = factor_at(at, at, 1, u, why);
    }
    while (used > 0) {
        at += used;
        const char *next = skip_blanks(at);
        char op = *next;

        if (op == '*' || op == '/') {
            next = skip_blanks(next + 1);
        } else if (next == at) {
            return (int)(at - s);
        }
        if (unit_word(next) == 0 && bare_power(next) == 0) {
            return (int)(at - s);
        }
        *bad = next;
        if (divided && op != '*' && op != '/') {
            snprintf(why, MECH__WHY,
                     "a blank after \"/\" is ambiguous in a unit: write the "
                     "products first, as in \"N s/m\"");
            return -1;
        }
        divided = divided || op == '/';
        used = factor_at(begin, next, op == '/' ? -1 : 1, u, why);
        at = next;
    }
    return used;
}

static mech_dim product_dim(const product *u)
{
    mech_dim dim = {(signed char)u->kg, (signed char)u->m, (signed char)u->s, (signed char)u->rad,
                    (signed char)u->A};

    return dim;
}

/** Value of a text that is known to be a decimal number, in the "C" locale. */
static double decimal(const char *text)
{
    int saved = errno;
    locale_t c = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    locale_t before = c ? uselocale(c) : (locale_t)0;
    double value = c ? strtod(text, NULL) : NAN;

    if (c) {
        uselocale(before);
        freelocale(c);
    }
    errno = saved;
    return value;
}

/** Length of the number at s, 0 when there is none. */
static size_t number_length(const char *s, size_t *mantissa)
{
    size_t n = 0, digits = 0;

    for (; is_digit(s[n]); n++) {
        digits++;
    }
    if (s[n] == '.') {
        for (n++; is_digit(s[n]); n++) {
            digits++;
        }
    }
    if (digits == 0) {
        return 0;
    }
    *mantissa = n;
    if (s[n] == 'e' || s[n] == 'E') {
        size_t k = n + 1 + (s[n + 1] == '+' || s[n + 1] == '-');

        if (is_digit(s[k])) {
            for (n = k; is_digit(s[n]); n++) {
            }
        }
    }
    return n;
}

/** Number of `mantissa` characters and the exponent after it, times 10^exp10 (pi/180)^deg. */
static int convert(const char *s, size_t mantissa, size_t length, const product *u, double *value,
                   char why[MECH__WHY])
{
    char text[MAX_DIGITS + 16];
    int exponent = 0, minus = 0, zero = 1;

    if (mantissa > MAX_DIGITS) {
        snprintf(why, MECH__WHY, "the number has more than %d digits", MAX_DIGITS);
        return -1;
    }
    for (size_t i = 0; i < mantissa; i++) {
        zero = zero && (s[i] == '0' || s[i] == '.');
    }
    for (size_t i = mantissa + 1; i < length; i++) {
        minus = minus || s[i] == '-';
        if (is_digit(s[i]) && exponent < 10000) {
            exponent = 10 * exponent + (s[i] - '0');
        }
    }
    exponent = (minus ? -exponent : exponent) + u->exp10;
    snprintf(text, sizeof text, "%.*se%d", (int)mantissa, s, exponent);
    double v = decimal(text);

    for (int i = abs(u->deg); i > 0; i--) {
        v = u->deg > 0 ? v * degree : v / degree;
    }
    if (!isfinite(v) || (!zero && fabs(v) < DBL_MIN)) {
        snprintf(why, MECH__WHY, "the number is too %s", isfinite(v) ? "small" : "large");
        return -1;
    }
    *value = v;
    return 0;
}

static int starts_with_word(const char *s, const char *word)
{
    size_t n = strlen(word);

    for (size_t i = 0; i < n; i++) {
        if ((s[i] | 0x20) != word[i]) {
            return 0;
        }
    }
    return 1;
}

static void no_number(const char *s, char why[MECH__WHY])
{
    const char *word = *s == '.' ? s + 1 : s;

    if (starts_with_word(word, "nan") || starts_with_word(word, "inf")) {
        snprintf(why, MECH__WHY, "the number must be finite");
    } else if (*s == '\0') {
        snprintf(why, MECH__WHY, "the value ends too early, expected a number");
    } else {
        snprintf(why, MECH__WHY, "expected a number here");
    }
}

int mech__quantity_at(const char *s, mech__quantity *q, char why[MECH__WHY], const char **bad)
{
    size_t mantissa = 0;
    size_t n = number_length(s, &mantissa);
    product u = {.kg = 0};
    int used;

    *bad = s;
    memset(q, 0, sizeof *q);
    if (n == 0) {
        no_number(s, why);
        return -1;
    }
    if (s[n] == ',') {
        snprintf(why, MECH__WHY, "a comma in a number: write a decimal point");
        *bad = s + n;
        return -1;
    }
    if (n == 1 && s[0] == '0' && (s[1] == 'x' || s[1] == 'X')) {
        snprintf(why, MECH__WHY, "hexadecimal numbers are not allowed, expected a decimal number");
        return -1;
    }
    const char *after = skip_blanks(s + n);

    if (*after == '%') {
        q->percent = 1;
        u.exp10 = -2;
        used = (int)(after + 1 - (s + n));
    } else {
        used = unit_at(s + n, &u, why, bad);
    }
    if (used < 0) {
        return -1;
    }
    q->has_unit = used > 0;
    q->dim = product_dim(&u);
    *bad = s;
    if (convert(s, mantissa, n, &u, &q->value, why) != 0) {
        return -1;
    }
    return (int)n + used;
}

int mech__dim_same(mech_dim a, mech_dim b)
{
    return a.kg == b.kg && a.m == b.m && a.s == b.s && a.A == b.A;
}

int mech__dim_fits(mech_dim found, mech_dim expected)
{
    return mech__dim_same(found, expected) && (found.rad == 0 || found.rad == expected.rad);
}

static void append_power(char text[MECH_UNIT], const char *before, const char *name, int power)
{
    size_t n = strlen(text);

    if (power == 1) {
        snprintf(text + n, MECH_UNIT - n, "%s%s", before, name);
    } else {
        snprintf(text + n, MECH_UNIT - n, "%s%s^%d", before, name, power);
    }
}

void mech__unit_text(mech_dim dim, char text[MECH_UNIT])
{
    static const char *const usual[] = {
        "1",     "rad",   "m",     "kg",        "s",   "N",     "N m",   "N m/rad", "N/m",
        "N/m^2", "N/m^3", "N s/m", "N m s/rad", "m/s", "rad/s", "m/s^2", "rad/s^2", "kg m^2",
        "s/m",   "1/s",   "1/m",   "N s",       "V",   "A",     "ohm",   "N m/A",   "V s/rad",
    };
    static const char *const names[] = {"kg", "m", "s", "rad", "A"};
    int power[] = {dim.kg, dim.m, dim.s, dim.rad, dim.A};

    for (size_t i = 0; i < sizeof usual / sizeof usual[0]; i++) {
        mech_dim d = {.kg = 0};

        mech_parse_unit(usual[i], &d, NULL);
        if (memcmp(&d, &dim, sizeof d) == 0) {
            snprintf(text, MECH_UNIT, "%s", usual[i]);
            return;
        }
    }
    text[0] = '\0';
    for (int i = 0; i < 5; i++) {
        if (power[i] > 0) {
            append_power(text, text[0] ? " " : "", names[i], power[i]);
        }
    }
    if (text[0] == '\0') {
        snprintf(text, MECH_UNIT, "1");
    }
    for (int i = 0; i < 5; i++) {
        if (power[i] < 0) {
            append_power(text, "/", names[i], -power[i]);
        }
    }
}

int mech_parse_unit(const char *text, mech_dim *dim, double *factor)
{
    char why[MECH__WHY];
    const char *bad;
    product u = {.kg = 0};
    double value = 1.0;
    int used = 0;

    if (strcmp(text, "%") == 0) {
        u.exp10 = -2;
    } else if (strcmp(text, "1") != 0) {
        used = unit_at(text, &u, why, &bad);
        if (used <= 0 || *skip_blanks(text + used) != '\0') {
            return -1;
        }
    }
    if (factor && convert("1", 1, 1, &u, &value, why) != 0) {
        return -1;
    }
    *dim = product_dim(&u);
    if (factor) {
        *factor = value;
    }
    return 0;
}

static stein_status quantity_error(stein_err *err, const char *text, const char *why)
{
    if (err) {
        err->code = STEIN_EPARSE;
        snprintf(err->msg, sizeof err->msg, "\"%.60s\": %.170s", text, why);
        mech__one_line(err->msg);
    }
    return STEIN_EPARSE;
}

stein_status mech_parse_quantity(const char *text, mech_dim dim, double *value, stein_err *err)
{
    char why[MECH__WHY] = "", found[MECH_UNIT], expected[MECH_UNIT];
    const char *s = skip_blanks(text), *bad;
    int minus = *s == '-';
    mech__quantity q;

    s = *s == '-' || *s == '+' ? skip_blanks(s + 1) : s;
    int used = mech__quantity_at(s, &q, why, &bad);

    if (used < 0) {
        return quantity_error(err, text, why);
    }
    mech__unit_text(dim, expected);
    if (*skip_blanks(s + used) != '\0') {
        snprintf(why, sizeof why, "unexpected text after the number, expected a number in %s",
                 expected);
        return quantity_error(err, text, why);
    }
    if (q.has_unit && (!mech__dim_fits(q.dim, dim) || (q.percent && dim.rad != 0))) {
        mech__unit_text(q.dim, found);
        snprintf(why, sizeof why, "the unit is %s, expected %s", q.percent ? "%" : found,
                 strcmp(expected, "1") ? expected : "a pure number");
        return quantity_error(err, text, why);
    }
    *value = minus ? -q.value : q.value;
    return STEIN_OK;
}
