/* SPDX-License-Identifier: GPL-3.0-or-later
 * sign_error.c - a sign that all records have wrong, as a cause: the gain of the instrument is -1.
 *
 * Nothing has been fitted then, so the number has no interval; but it can be written, and the file
 * with it reads the records as they are.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "verdict.h"

/* the output that is mirrored in all records, and nothing else is wrong; NULL: there is none, or it
 * is one of two that the records cannot tell apart */
static const char *mirrored(const lab_dataset *data, const lab_doubts *doubts)
{
    const lab_doubt *first = &doubts->item[0];
    int others = 0;
    for (int i = 1; i < doubts->n; i++) {
        others |= doubts->item[i].grave;
    }
    if (others || first->kind != LAB_DOUBT_SIGN || first->records < data->n || first->column < 0 ||
        first->other >= 0) {
        return NULL;
    }
    const lab_column *c = &data->stroke[first->stroke]->column[first->column];
    return c->role == LAB_OUTPUT ? c->name : NULL;
}

stein_status diag__name_sign_error(const lab_model *model, const lab_dataset *data,
                                   const lab_doubts *doubts, lab_diagnosis *o, stein_err *err)
{
    const char *channel = mirrored(data, doubts);
    lab_candidate *list = NULL;
    int n = 0;
    stein_status status = channel != NULL ? lab_candidates(&list, &n, model, err) : STEIN_OK;
    for (int i = 0; status == STEIN_OK && i < n; i++) {
        if (strcmp(list[i].effect->kind, "sensor_gain") != 0 ||
            strcmp(list[i].place, channel) != 0) {
            continue;
        }
        o->suspect = calloc(1, sizeof *o->suspect);
        if (o->suspect == NULL) {
            status = lab__no_memory(err);
            break;
        }
        double amount = 1.0 / doubts->item[0].factor - 1.0; // gain = 1 + error
        o->suspect[0] = diag__suspect(&list[i]);
        o->suspect[0].amount = amount;
        o->suspect[0].possible = o->suspect[0].nnumber = 1;
        o->suspect[0].number[0] = (lab_cause_number){
            .unit = list[i].unit, .value = amount, .sd = NAN, .lo = NAN, .hi = NAN};
        snprintf(o->suspect[0].number[0].name, sizeof o->suspect[0].number[0].name, "%s",
                 list[i].effect->size);
        o->nsuspect = o->ncause = 1;
    }
    free(list);
    return status;
}
