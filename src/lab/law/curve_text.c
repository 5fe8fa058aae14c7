/* SPDX-License-Identifier: GPL-3.0-or-later
 * curve_text.c - tables in the text of a mechanism file.
 */
#include <math.h>
#include <stdlib.h>

#include "curve.h"

enum { ROW = 6 }; /* numbers on a line */

/* "[1, 2]"; with sd "[1 +- 0.1, 2 +- 0.1]": bare numbers are SI */
static void write_list(FILE *f, const double *v, const double *sd, int n)
{
    char text[LAB_NUMBER];
    for (int i = 0; i < n; i++) {
        const char *before = i == 0 ? "[" : i % ROW == 0 ? ",\n" : ", ";
        fprintf(f, "%s%s", before, lab__number(text, v[i]));
        if (sd != NULL && sd[i] > 0.0 && isfinite(sd[i])) {
            double digits = pow(10.0, 2.0 - floor(log10(sd[i])));
            fprintf(f, " +- %s", lab__number(text, ceil(sd[i] * digits) / digits));
        }
    }
    fputc(']', f);
}

stein_status lab__table_add(lab__yaml_edit *s, const char *table, const char *word,
                            const char *place, const char *of, const char *what, int n,
                            const double *at, const double *value, const double *sd, stein_err *err)
{
    char *entry = NULL;
    FILE *f = lab__text_open(&entry);
    if (f == NULL) {
        return lab__no_memory(err);
    }
    fprintf(f, "%s: {%s: %s, of: %s,\nat: ", table, word, place, of);
    write_list(f, at, NULL, n);
    fprintf(f, ",\n%s: ", what);
    write_list(f, value, sd, n);
    fputc('}', f);
    stein_status status = lab__text_close(f, &entry, err);
    status = status == STEIN_OK ? lab__yaml_edit_add(s, "tables", entry, err) : status;
    free(entry);
    return status;
}

stein_status lab__law_text(const lab_law *law, const char *text, size_t size, char **out,
                           size_t *nout, stein_err *err)
{
    lab__yaml_edit *s = NULL;
    stein_status status = lab__yaml_edit_begin(&s, text, size, err);
    if (status != STEIN_OK) {
        return status;
    }
    status = lab__table_add(s, law->table, law->site, law->place, law->of, law->what, law->n,
                            law->at, law->value, law->sd, err);
    status = status == STEIN_OK ? lab__yaml_edit_text(s, out, nout, err) : status;
    lab__yaml_edit_end(s);
    return status;
}
