/* SPDX-License-Identifier: GPL-3.0-or-later
 * trace.c - what the search did, one JSON object a line: a row, or the proposals at a row.
 */
#include <math.h>
#include <stdio.h>

#include "search.h"

static void number(FILE *f, const char *name, double value)
{
    fprintf(f, isfinite(value) ? ",\"%s\":%.10g" : ",\"%s\":null", name, value);
}

stein_status diag__trace_row(FILE *f, const diag__problem *q, const diag__table *t,
                             const diag__row *row)
{
    fprintf(f, "{\"row\":%d,\"source\":\"%c\",\"parent\":%d,\"hypothesis\":[", diag__index(t, row),
            row->by->letter, row->parent);
    for (int i = 0; i < row->h.n; i++) {
        const lab_candidate of = diag__candidate(q, row->h.cause[i]), *c = &of;
        double sd = NAN, amount = row->failed == NULL ? diag__amount(row, i, &sd) : (double)NAN;
        fprintf(f, "%s{\"kind\":\"%s\",\"place\":\"%s\"", i > 0 ? "," : "", c->effect->kind,
                c->place);
        if (c->from > 0) {
            fprintf(f, ",\"from\":%d", c->from);
        }
        number(f, "amount", amount * c->limit);
        number(f, "sd", sd * c->limit);
        fputs("}", f);
    }
    fputs("]", f);
    number(f, "evidence", -0.5 * row->objective);
    number(f, "chi2_dof", row->chi2_dof);
    number(f, "remainder", sqrt(row->chi2_dof));
    fprintf(f, ",\"converged\":%s,\"possible\":%s,\"strokes\":%ld",
            row->converged ? "true" : "false", diag__is_possible(q, row) ? "true" : "false",
            row->strokes);
    number(f, "seconds", row->seconds);
    fputs("}\n", f);
    fflush(f);
    return ferror(f) ? STEIN_EIO : STEIN_OK;
}

stein_status diag__trace_proposals(FILE *f, int row, int held, const diag__counted *of, int n)
{
    static const char *const fate[] = {"tried",  "unexpected", "known", "often", "elsewhere",
                                       "behind", "full",       "found", "spent"};
    _Static_assert(sizeof fate / sizeof *fate == DIAG_FATES, "every fate has a word");
    fprintf(f, "{\"linearised\":%d,\"held\":%s,\"proposers\":[", row, held ? "true" : "false");
    for (int i = 0; i < n; i++) {
        int all = 0;
        for (int k = 0; k < DIAG_FATES; k++) {
            all += of[i].n[k];
        }
        fprintf(f, "%s{\"proposer\":\"%c\",\"proposals\":%d", i > 0 ? "," : "", of[i].by->letter,
                all);
        for (int k = 0; k < DIAG_FATES; k++) {
            if (of[i].n[k] > 0) {
                fprintf(f, ",\"%s\":%d", fate[k], of[i].n[k]);
            }
        }
        fputs("}", f);
    }
    fputs("]}\n", f);
    fflush(f);
    return ferror(f) ? STEIN_EIO : STEIN_OK;
}
