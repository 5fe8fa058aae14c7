/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_titles.c - a title of a column: its name and its unit.
 *
 *      angle [deg]    angle (deg)    angle / deg    angle, deg    angle_deg    angle
 *
 * A suffix counts as a unit only if the title is no name of the model and the title without the
 * suffix is one. So "key_m" stays the channel of that name. An identifier has no room for "/" and
 * "^": "rad_s" and "rad_per_s" are rad/s, "N_m" is N m, "m_s2" is m/s^2; of the readings that are
 * units the one of the wanted quantity counts.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data_internal.h"
#include "reader.h"

/* other spellings of units */
static const char *usual_unit(const char *unit)
{
    static const char *const same[][2] = {
        {"degrees", "deg"},  {"degree", "deg"},      {"\xc2\xb0", "deg"}, {"radians", "rad"},
        {"radian", "rad"},   {"seconds", "s"},       {"second", "s"},     {"sec", "s"},
        {"msec", "ms"},      {"milliseconds", "ms"}, {"usec", "us"},      {"\xc2\xb5s", "us"},
        {"\xce\xbcs", "us"}, {"\xc2\xb5m", "um"},    {"\xce\xbcm", "um"}, {"metres", "m"},
        {"meters", "m"},     {"Nm", "N m"},          {"-", "1"}};
    for (size_t i = 0; i < sizeof same / sizeof *same; i++) {
        if (strcmp(unit, same[i][0]) == 0) {
            return same[i][1];
        }
    }
    return unit;
}

int data__unit(const char *unit, const char *wanted, int *exp10, double *factor)
{
    mech_dim found, expected;
    double f, w;
    if (mech_parse_unit(unit, &found, &f) != 0) {
        return 2;
    }
    if (mech_parse_unit(wanted, &expected, &w) != 0 || !mech__dim_fits(found, expected)) {
        return 1;
    }
    char power[16];
    double back = NAN;
    f /= w;
    int k = (int)lround(log10(f));
    snprintf(power, sizeof power, "1e%d", k);
    mech_parse_quantity(power, (mech_dim){.kg = 0}, &back, NULL);
    *exp10 = back == f ? k : 0;
    *factor = back == f ? 1.0 : f;
    return 0;
}

/* ---- names ---- */

/* equal, ignoring upper and lower case of ASCII? */
static int is_alike(const char *a, const char *b)
{
    for (; *a != '\0' && *b != '\0'; a++, b++) {
        int letter = (*a >= 'a' && *a <= 'z') || (*a >= 'A' && *a <= 'Z');
        if (*a != *b && !(letter && (*a ^ *b) == 0x20)) {
            return 0;
        }
    }
    return *a == *b;
}

int data__is_time(const stein_model *m, const char *name)
{
    static const char *const word[] = {"time", "timestamp", "seconds"};
    if (stein_find_channel(m, name) > 0 || stein_find_input(m, name) >= 0) {
        return 0;
    }
    for (size_t i = 0; i < sizeof word / sizeof *word; i++) {
        if (is_alike(name, word[i])) {
            return 1;
        }
    }
    return strcmp(name, "t") == 0;
}

/* an output or input as the model spells it; where several differ by case only, the exact one */
static const char *spelled(const stein_model *m, const char *name)
{
    const char *found = NULL;
    int n = 0;
    if (stein_find_channel(m, name) >= 0 || stein_find_input(m, name) >= 0) {
        return name;
    }
    for (int i = 1; i < m->nchannel + m->ninput; i++) { // 0 is the time
        const char *other = i < m->nchannel ? m->channels[i].name : m->inputs[i - m->nchannel].name;
        if (is_alike(name, other)) {
            n += found == NULL || strcmp(found, other) != 0;
            found = other;
        }
    }
    return n == 1 ? found : NULL;
}

const char *data__wanted_unit(const stein_model *m, const char *name)
{
    const char *own = spelled(m, name);
    int input = own != NULL ? stein_find_input(m, own) : -1;
    int channel = own != NULL ? stein_find_channel(m, own) : -1;
    return input >= 0               ? m->inputs[input].unit
           : channel >= 0           ? m->channels[channel].unit
           : data__is_time(m, name) ? "s"
                                    : NULL;
}

/* ---- suffixes ---- */

/* text of a suffix as a unit: its last "_" as "/" (or none), the others as blanks, "_per_" as "/",
 * a digit behind a letter as a power */
static void spell(char *to, const char *suffix, int divided)
{
    const char *last = divided ? strrchr(suffix, '_') : NULL;
    size_t n = 0;
    for (const char *s = suffix; *s != '\0' && n + 3 < DATA_SHOWN; s++) {
        int digit = *s >= '0' && *s <= '9' && s > suffix && s[-1] != '_' && s[-1] != '^';
        if (strncmp(s, "_per_", 5) == 0) {
            to[n++] = '/';
            s += 4;
            continue;
        }
        if (digit) {
            to[n++] = '^';
        }
        to[n++] = (char)(*s != '_' ? *s : s == last ? '/' : ' ');
    }
    to[n] = '\0';
}

/* @return 2 a unit of the wanted quantity, 1 another unit, 0 none */
static int suffix_unit(const char *suffix, const char *wanted, char unit[DATA_SHOWN])
{
    char text[3][DATA_SHOWN];
    int best = 0, exp10;
    double factor;
    snprintf(text[0], DATA_SHOWN, "%s", usual_unit(suffix));
    spell(text[1], suffix, 0);
    spell(text[2], suffix, strstr(suffix, "_per_") == NULL);
    for (int i = 0; i < 3; i++) {
        int wrong = data__unit(text[i], wanted, &exp10, &factor);
        if (2 - wrong > best) {
            best = 2 - wrong;
            memcpy(unit, text[i], DATA_SHOWN);
        }
    }
    return best;
}

/* the longest name before a "_" that is followed by a unit */
static int cut_suffix(const stein_model *m, char *name, char *unit)
{
    char front[DATA_SHOWN];
    memcpy(front, name, DATA_SHOWN);
    for (char *bar = strrchr(front, '_'); bar != NULL; bar = strrchr(front, '_')) {
        *bar = '\0';
        const char *wanted = data__wanted_unit(m, front);
        if (wanted != NULL && suffix_unit(name + (bar - front) + 1, wanted, unit) > 0) {
            memcpy(name, front, DATA_SHOWN);
            return 1;
        }
    }
    return 0;
}

int data__cut_time(const char *name, char unit[], int *has_unit)
{
    char found[DATA_SHOWN];
    int exp10;
    double factor;
    const char *bar = strrchr(name, '_');
    if (*has_unit == 0 && bar != NULL && suffix_unit(bar + 1, "s", found) == 2) {
        snprintf(unit, DATA_SHOWN, "%s", found);
        *has_unit = 1;
        return 1;
    }
    return *has_unit > 0 && data__unit(unit, "s", &exp10, &factor) == 0;
}

/* ---- titles ---- */

/* without blanks around it, made printable */
static void trim(char to[DATA_SHOWN], const char *from, const char *end)
{
    while (from < end && (*from == ' ' || *from == '\t')) {
        from++;
    }
    while (end > from && (end[-1] == ' ' || end[-1] == '\t')) {
        end--;
    }
    data__shown(to, from, (size_t)(end - from));
}

void data__cut_unit(data__cell cell, char unit[])
{
    char inside[DATA_SHOWN];
    const char *s = cell.s, *end = cell.s + cell.n;
    int bracket = cell.n > 1 && ((*s == '[' && end[-1] == ']') || (*s == '(' && end[-1] == ')'));
    trim(inside, s + bracket, end - bracket);
    snprintf(unit, DATA_SHOWN, "%s", usual_unit(inside));
}

/* "angle / deg" and "angle, deg": the text after the sign is the unit of the name before it */
static int cut_sign(const stein_model *m, char *name, char *unit)
{
    char front[DATA_SHOWN], behind[DATA_SHOWN];
    const char *sign = strpbrk(name, "/,");
    if (sign == NULL) {
        return 0;
    }
    trim(front, name, sign);
    trim(behind, sign + 1, name + strlen(name));
    if (data__wanted_unit(m, front) == NULL) {
        return 0;
    }
    memcpy(name, front, DATA_SHOWN);
    snprintf(unit, DATA_SHOWN, "%s", usual_unit(behind));
    return 1;
}

int data__cut_title(const stein_model *m, data__cell cell, char name[], char unit[])
{
    char inside[DATA_SHOWN];
    const char *end = cell.s + cell.n, *open = memchr(cell.s, '[', cell.n);
    open = open != NULL ? open : memchr(cell.s, '(', cell.n);
    trim(name, cell.s, open != NULL ? open : end);
    *unit = '\0';
    int cut = open == NULL && data__wanted_unit(m, name) == NULL &&
              (cut_sign(m, name, unit) || cut_suffix(m, name, unit));
    const char *own = spelled(m, name);
    if (own != NULL && own != name) {
        snprintf(name, DATA_SHOWN, "%s", own);
    }
    if (open == NULL) {
        return cut;
    }
    const char *shut = memchr(open, *open == '[' ? ']' : ')', (size_t)(end - open));
    trim(inside, open + 1, shut != NULL ? shut : end);
    snprintf(unit, DATA_SHOWN, "%s", usual_unit(inside));
    return shut == NULL || shut + 1 != end ? -1 : 1;
}
