/* SPDX-License-Identifier: GPL-3.0-or-later
 * before_json.c - plan.json of records that are not made yet.
 */
#include <math.h>

#include "planning.h"

static void write_cause(lab__json *j, const lab_before *b, int i)
{
    const lab_before_cause *c = &b->cause[i];
    lab__json_open(j, NULL, '{');
    lab__json_text(j, "kind", c->candidate.effect->kind);
    lab__json_text(j, "place", c->candidate.place);
    lab__json_text(j, "unit", c->candidate.unit);
    lab__json_real(j, "limit", c->candidate.limit);
    lab__json_real(j, "nameable", c->nameable);
    lab__json_bool(j, "named", c->named);
    lab__json_text(j, "why", c->why[0] != '\0' ? c->why : NULL);
    lab__json_open(j, "not_told_from", '[');
    for (int k = 0; i < b->ncolumn && k < b->ncolumn; k++) {
        if (lab_before_mistaken(b, i, k)) {
            double below = b->apart[(size_t)i * (size_t)b->ncolumn + (size_t)k];
            lab__json_open(j, NULL, '{');
            lab__json_text(j, "kind", b->cause[k].candidate.effect->kind);
            lab__json_text(j, "place", b->cause[k].candidate.place);
            lab__json_real(j, "below", below <= 1.0 ? below * c->candidate.limit : (double)NAN);
            lab__json_close(j);
        }
    }
    lab__json_close(j);
    lab__json_close(j);
}

stein_status lab_before_json(const char *path, const lab_before *b, stein_err *err)
{
    lab__file file;
    stein_status status = lab__file_open(&file, path, err);
    if (status != STEIN_OK) {
        return status;
    }
    lab__json j = {.stream = file.stream};
    lab__json_open(&j, NULL, '{');
    lab__json_int(&j, "records", b->records);
    lab__json_open(&j, "causes", '[');
    for (int i = 0; i < b->n; i++) {
        write_cause(&j, b, i);
    }
    lab__json_close(&j);
    lab__json_open(&j, "help", '[');
    for (int i = 0; i < b->nhelp; i++) {
        const lab_before_help *h = &b->help[i];
        lab__json_open(&j, NULL, '{');
        lab__json_text(&j, "experiment", h->name);
        lab__json_text(&j, "why", h->why);
        lab__json_real(&j, "cost", h->cost);
        lab__json_int(&j, "causes_named", h->named);
        lab__json_int(&j, "pairs_told", h->told);
        lab__json_real(&j, "finer", h->finer);
        lab__json_text(&j, "most", h->most[0] != '\0' ? h->most : NULL);
        lab__json_real(&j, "most_finer", h->most_finer);
        lab__json_close(&j);
    }
    lab__json_close(&j);
    lab__json_int(&j, "tried", b->ntried);
    lab__json_int(&j, "strokes_simulated", (int)b->strokes);
    lab__json_real(&j, "seconds", b->seconds);
    lab__json_close(&j);
    return lab__file_close(&file, 1, err);
}
