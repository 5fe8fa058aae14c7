/* SPDX-License-Identifier: GPL-3.0-or-later
 * xml.c - texts and units as XML 1.0.
 */
#include <string.h>

#include "fmu.h"

/* U+FFFE and U+FFFF are no characters of XML */
static int is_noncharacter(const unsigned char *c)
{
    return c[0] == 0xef && c[1] == 0xbf && (c[2] == 0xbe || c[2] == 0xbf);
}

void fmu__escape(FILE *f, const char *text)
{
    for (const unsigned char *c = (const unsigned char *)text; *c != '\0'; c++) {
        switch (*c) {
        case '&': fputs("&amp;", f); break;
        case '<': fputs("&lt;", f); break;
        case '>': fputs("&gt;", f); break;
        case '"': fputs("&quot;", f); break;
        case '\'': fputs("&#39;", f); break;
        case '\t':
        case '\n':
        case '\r': putc(' ', f); break;
        default:
            if (is_noncharacter(c)) {
                putc('?', f);
                c += 2;
            } else {
                putc(*c < ' ' || *c == 127 ? '?' : *c, f);
            }
        }
    }
}

void fmu__attribute(FILE *f, const char *name, const char *text)
{
    fprintf(f, " %s=\"", name);
    fmu__escape(f, text);
    putc('"', f);
}

void fmu__attribute_number(FILE *f, const char *name, double value)
{
    char text[LAB_NUMBER];
    fprintf(f, " %s=\"%s\"", name, lab__number(text, value));
}

/* is the unit of variable i one that none before it has? */
static int is_new(const fmu_list *list, int i)
{
    for (int k = 0; k < i; k++) {
        if (!list->v[k].boolean && strcmp(list->v[k].unit, list->v[i].unit) == 0) {
            return 0;
        }
    }
    return !list->v[i].boolean && strcmp(list->v[i].unit, "1") != 0;
}

static void exponent(FILE *f, const char *unit, int n)
{
    if (n != 0) {
        fprintf(f, " %s=\"%d\"", unit, n);
    }
}

/* units that people like to read: how many of them make an SI unit */
static const struct shown {
    const char *unit, *shown;
    double factor;
} shown[] = {{"m", "mm", 1e3},
             {"s", "ms", 1e3},
             {"kg", "g", 1e3},
             {"rad", "deg", 180.0 / 3.14159265358979323846}};

void fmu__units(FILE *f, const fmu_list *list)
{
    fputs("  <UnitDefinitions>\n", f);
    for (int i = 0; i < list->n; i++) {
        mech_dim dim;
        double factor = 1.0;
        if (!is_new(list, i) || mech_parse_unit(list->v[i].unit, &dim, &factor) != 0) {
            continue;
        }
        fputs("    <Unit", f);
        fmu__attribute(f, "name", list->v[i].unit);
        fputs(">\n      <BaseUnit", f);
        exponent(f, "kg", dim.kg);
        exponent(f, "m", dim.m);
        exponent(f, "s", dim.s);
        exponent(f, "rad", dim.rad);
        exponent(f, "A", dim.A);
        if (factor != 1.0) {
            fmu__attribute_number(f, "factor", factor);
        }
        fputs("/>\n", f);
        for (size_t k = 0; k < sizeof shown / sizeof *shown; k++) {
            if (strcmp(shown[k].unit, list->v[i].unit) == 0) {
                fprintf(f, "      <DisplayUnit name=\"%s\"", shown[k].shown);
                fmu__attribute_number(f, "factor", shown[k].factor);
                fputs("/>\n", f);
            }
        }
        fputs("    </Unit>\n", f);
    }
    fputs("  </UnitDefinitions>\n", f);
}
