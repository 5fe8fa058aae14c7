/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_suspicions.c - columns in the wrong unit, with the wrong sign, exchanged; a wrong clock; a
 * record of another mechanism: told before anything is fitted.
 *
 * Every record is compared with the model as it is (data_trial.c). Where that fits, nothing is
 * asked. Where it does not, the readings that slips lead to are tried: factors of 1000 and 100, the
 * factor between degrees and radians, the opposite sign, two columns exchanged, milliseconds for
 * seconds. A reading is suspected when what was far off fits with it:
 *
 *   - the misfit of the affected channels falls below `fits` and by the factor `better`, or
 *   - channels that could not be compared (misfit above `apart`) move about as they should, by the
 *     right amount within 25 %;
 *
 * in two thirds of the records that do not fit, or, where most records do fit, in that one. A model
 * that is merely wrong does not do so: two motions that have nothing in common have a misfit of
 * 0.7, and no factor of 1000 brings that to 0.25.
 *
 * A linear model whose initial state is unknown follows its data at any scale. There the travel is
 * compared with the largest length of the model's file.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data_trial.h"

static const double fits = 0.25, better = 3.0, apart = 0.9, nearly = 0.45, within = 1.25;
static const double foreign = 0.6, well = 0.15;   /* misfit of a foreign record; median of all */
static const double beyond = 30.0, inside = 3.0;  /* travel in largest lengths of the model */
static const double degrees = 57.295779513082321; /* in a radian */
enum {
    PATIENCE = 200000, /* evaluations of the equations for one trial */
    TESTED = 6,        /* records that a reading is tried on */
    READINGS = 400,
    FEW = 4 /* records; fewer do not show which of them is foreign */
};

/* a reading in terms of names, for records whose columns are in different orders */
typedef struct guess {
    const char *a, *b, *unit; /* NULL: none */
    double factor, time;
    int tested, accepted;    /* records */
    int first;               /* record that it was accepted in first, -1: none */
    double off, then, score; /* sums over the records in which it was accepted */
    double travel, predicted;
} guess;

typedef struct audit {
    const lab_model *model;
    const lab_dataset *data;
    data__match **plain; /* [n] of each record, as it is read */
    data__match *other;  /* room for one more */
    guess *guess;        /* [READINGS] */
    int nguess;
    lab_doubts *out;
    stein_status status;
    stein_err *err;
} audit;

/* ---- trials ---- */

static void try(audit *a, int record, data__reading reading, data__match *match)
{
    long patience = PATIENCE;
    if (a->status != STEIN_OK) {
        return;
    }
    a->status = data__try(a->model, a->data->stroke[record], reading, match, &patience, a->err);
    a->status = a->status == STEIN_EINVAL ? STEIN_OK : a->status; // no output: nothing to compare
}

/* is the column among those that the guess is about? */
static int affects(const guess *g, const lab_data *d, int k)
{
    const lab_column *c = &d->column[k];
    if (g->unit != NULL) {
        return strcmp(c->unit, g->unit) == 0;
    }
    int column = g->a != NULL ? (int)(lab_data_column(d, g->a) - d->column) : -1;
    return column < 0 || d->column[column].role == LAB_INPUT || k == column ||
           (g->b != NULL && strcmp(c->name, g->b) == 0);
}

static int applies(const guess *g, const lab_data *d, data__reading *reading)
{
    const lab_column *a = g->a != NULL ? lab_data_column(d, g->a) : NULL;
    const lab_column *b = g->b != NULL ? lab_data_column(d, g->b) : NULL;
    *reading = data__as_it_is();
    reading->column = a != NULL ? (int)(a - d->column) : -1;
    reading->other = b != NULL ? (int)(b - d->column) : -1;
    reading->unit = g->unit;
    reading->factor = g->factor;
    reading->time = g->time;
    return (g->a == NULL || a != NULL) && (g->b == NULL || b != NULL);
}

/* what a guess does for one record */
typedef struct effect {
    int channels;                    /* affected */
    double off, then;                /* means over the affected channels */
    double least_off, most_then;     /* of them */
    double all_off, all_then;        /* means over all channels */
    double ratio, travel, predicted; /* travel over predicted, worst; of the first affected one */
} effect;

static effect compare(const guess *g, const lab_data *d, const data__match *plain,
                      const data__match *then)
{
    effect e = {.least_off = INFINITY, .ratio = 1.0, .travel = NAN, .predicted = NAN};
    int all = 0;
    for (int k = 0; k < d->ncolumn; k++) {
        if (!plain[k].compared || !then[k].compared) {
            continue;
        }
        all++;
        e.all_off += plain[k].off;
        e.all_then += then[k].off;
        if (!affects(g, d, k)) {
            continue;
        }
        double ratio = then[k].travel / then[k].predicted;
        ratio = ratio > 1.0 ? ratio : 1.0 / ratio;
        e.travel = e.channels == 0 ? plain[k].travel : e.travel;
        e.predicted = e.channels == 0 ? then[k].predicted : e.predicted;
        e.channels++;
        e.off += plain[k].off;
        e.then += then[k].off;
        e.least_off = fmin(e.least_off, plain[k].off);
        e.most_then = fmax(e.most_then, then[k].off);
        e.ratio = isfinite(ratio) ? fmax(e.ratio, ratio) : (double)INFINITY;
    }
    e.off /= fmax(1.0, e.channels);
    e.then /= fmax(1.0, e.channels);
    e.all_off /= fmax(1.0, all);
    e.all_then /= fmax(1.0, all);
    return e;
}

static int is_accepted(const effect *e)
{
    int fitting = e->most_then < fits && e->off > better * e->then + 0.1;
    int sized = e->most_then < nearly && e->least_off > apart && e->ratio < within;
    return e->channels > 0 && (fitting || sized) && e->all_then < e->all_off;
}

static void try_guess(audit *a, guess *g, int record)
{
    const lab_data *d = a->data->stroke[record];
    data__reading reading;
    if (!applies(g, d, &reading)) {
        return;
    }
    try(a, record, reading, a->other);
    effect e = compare(g, d, a->plain[record], a->other);
    g->tested++;
    if (a->status == STEIN_OK && is_accepted(&e)) {
        g->first = g->accepted == 0 ? record : g->first;
        g->travel = g->accepted == 0 ? e.travel : g->travel;
        g->predicted = g->accepted == 0 ? e.predicted : g->predicted;
        g->accepted++;
        g->off += e.off;
        g->then += e.then;
        g->score += e.all_then;
    }
}

/* ---- what slips lead to ---- */

static void offer(audit *a, guess g)
{
    if (a->nguess < READINGS) {
        g.first = -1;
        a->guess[a->nguess++] = g;
    }
}

/* are there several columns of this unit, and is this the first? */
static int begins_group(const lab_data *d, int k)
{
    int before = 0, same = 0;
    for (int i = 0; i < d->ncolumn; i++) {
        int equal = strcmp(d->column[i].unit, d->column[k].unit) == 0;
        before += equal && i < k;
        same += equal;
    }
    return before == 0 && same > 1;
}

static void offer_all(audit *a, const lab_data *d)
{
    a->nguess = 0;
    offer(a, (guess){.factor = 1.0, .time = 1e-3});
    offer(a, (guess){.factor = 1.0, .time = 1e3});
    for (int k = 0; k < d->ncolumn; k++) {
        const lab_column *c = &d->column[k];
        double odd = strcmp(c->unit, "rad") == 0 || strcmp(c->unit, "rad/s") == 0 ? degrees : 100.0;
        double factor[] = {1e-3, 1e3, 1.0 / odd, odd, -1.0};
        for (int i = 0; i < 5; i++) {
            offer(a, (guess){.a = c->name, .factor = factor[i], .time = 1.0});
            if (i < 4 && begins_group(d, k)) {
                offer(a, (guess){.unit = c->unit, .factor = factor[i], .time = 1.0});
            }
        }
        for (int i = k + 1; i < d->ncolumn; i++) {
            const lab_column *b = &d->column[i];
            if (strcmp(c->unit, b->unit) == 0 && c->role == b->role) {
                offer(a, (guess){.a = c->name, .b = b->name, .factor = 1.0, .time = 1.0});
            }
        }
    }
}

/* ---- words ---- */

/* what a factor says of a unit: the numbers are in one unit under a title that states another */
static const char *units_of(char *to, const char *unit, double factor)
{
    static const struct {
        const char *unit, *small;
        double factor;
    } known[] = {{"m", "mm", 1e-3},
                 {"m", "cm", 1e-2},
                 {"rad", "deg", 1.0 / 57.295779513082321},
                 {"rad", "mrad", 1e-3},
                 {"s", "ms", 1e-3},
                 {"N", "mN", 1e-3},
                 {"N m", "mN m", 1e-3},
                 {"m/s", "mm/s", 1e-3},
                 {"m/s", "cm/s", 1e-2},
                 {"rad/s", "deg/s", 1.0 / 57.295779513082321}};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        double up = factor / known[i].factor, down = factor * known[i].factor;
        if (strcmp(known[i].unit, unit) == 0 && fabs(up - 1.0) < 1e-6) {
            snprintf(to, DATA_SHOWN, "as %s instead of %s", known[i].small, unit);
            return to;
        }
        if (strcmp(known[i].unit, unit) == 0 && fabs(down - 1.0) < 1e-6) {
            snprintf(to, DATA_SHOWN, "as %s instead of %s", unit, known[i].small);
            return to;
        }
    }
    snprintf(to, DATA_SHOWN, "times %.4g", factor);
    return to;
}

/* names of the columns of one unit */
static void list_columns(char *to, size_t room, const lab_data *d, const char *unit)
{
    size_t n = 0;
    *to = '\0';
    for (int k = 0; k < d->ncolumn && n + 2 * DATA_SHOWN < room; k++) {
        if (strcmp(d->column[k].unit, unit) == 0) {
            n += (size_t)snprintf(to + n, room - n, "%s%s", n > 0 ? ", " : "", d->column[k].name);
        }
    }
}

static char *describe(const audit *a, const guess *g, const char *records)
{
    const lab_data *d = a->data->stroke[g->first];
    const lab_column *c = g->a != NULL ? lab_data_column(d, g->a) : NULL;
    char unit[DATA_SHOWN], x[DATA_SHOWN], y[DATA_SHOWN], names[400], misfit[80];
    snprintf(misfit, sizeof misfit, "misfit %.2f, then %.2g%s", g->off / g->accepted,
             g->then / g->accepted, records);
    if (g->time != 1.0) {
        return lab__text("%s: time: the record lasts %s, the model moves on another time scale; "
                         "read %s it fits (%s)",
                         d->file, data__quantity(x, d->time[d->nrow - 1] - d->time[0], "s"),
                         units_of(unit, "s", g->time), misfit);
    }
    if (g->b != NULL) {
        return lab__text("%s: %s and %s: each fits the prediction of the other; exchanged they fit "
                         "(%s)",
                         d->file, g->a, g->b, misfit);
    }
    if (g->factor < 0.0) {
        return lab__text("%s: %s: moves against the model; with the opposite sign it fits: check "
                         "the sign of the sensor and the sense of the joint (%s)",
                         d->file, g->a, misfit);
    }
    const char *si = g->unit != NULL ? g->unit : c->unit;
    list_columns(names, sizeof names, d, si);
    if (g->unit == NULL && c->role == LAB_INPUT) {
        return lab__text("%s: %s: with this input the model moves far from the record; read %s it "
                         "fits (%s)",
                         d->file, g->a, units_of(unit, si, g->factor), misfit);
    }
    return lab__text("%s: %s: %s of travel, the model moves %s; read %s it fits (%s)", d->file,
                     g->unit != NULL ? names : g->a, data__quantity(x, g->travel, si),
                     data__quantity(y, g->predicted, si), units_of(unit, si, g->factor), misfit);
}

/* ---- suspicions ---- */

static void add(audit *a, lab_doubt doubt)
{
    lab_doubt *grown = realloc(a->out->item, sizeof *grown * ((size_t)a->out->n + 1));
    if (grown != NULL) {
        a->out->item = grown;
    }
    if (grown == NULL || doubt.text == NULL) {
        free(doubt.text);
        a->status = lab__no_memory(a->err);
        return;
    }
    grown[a->out->n++] = doubt;
    a->out->grave |= doubt.grave;
}

static void tell(audit *a, const guess *g, int records)
{
    const lab_data *d = a->data->stroke[g->first];
    char many[60] = "";
    if (a->data->n > 1) {
        snprintf(many, sizeof many, "; %d of %d records", records, a->data->n);
    }
    data__reading reading;
    applies(g, d, &reading);
    add(a, (lab_doubt){.kind = g->time != 1.0    ? LAB_DOUBT_TIME
                               : g->b != NULL    ? LAB_DOUBT_SWAPPED
                               : g->factor < 0.0 ? LAB_DOUBT_SIGN
                                                 : LAB_DOUBT_SCALE,
                       .grave = 1,
                       .stroke = g->first,
                       .records = records,
                       .column = reading.column,
                       .other = reading.other,
                       .factor = g->time != 1.0 ? g->time : g->factor,
                       .off = g->off / g->accepted,
                       .then = g->then / g->accepted,
                       .text = describe(a, g, many)});
}

/* do two guesses speak of the same column? */
static int overlap(const guess *g, const guess *h, const lab_data *d)
{
    for (int k = 0; k < d->ncolumn; k++) {
        if (affects(g, d, k) && affects(h, d, k)) {
            return 1;
        }
    }
    return 0;
}

/* the best guesses that enough of the tested records accept, each column once.
 * @return how many were told */
static int tell_best(audit *a, int records, double share)
{
    int told = 0;
    for (;;) {
        guess *best = NULL;
        for (int i = 0; i < a->nguess; i++) {
            guess *g = &a->guess[i];
            if (g->accepted > 0 && g->accepted >= share * g->tested &&
                (best == NULL || g->score / g->accepted < best->score / best->accepted)) {
                best = g;
            }
        }
        if (best == NULL || a->status != STEIN_OK) {
            return told;
        }
        tell(a, best, records);
        told++;
        const lab_data *d = a->data->stroke[best->first];
        guess done = *best;
        for (int i = 0; i < a->nguess; i++) {
            a->guess[i].accepted = overlap(&done, &a->guess[i], d) ? 0 : a->guess[i].accepted;
        }
    }
}

/* ---- records ---- */

/* mean and worst misfit of the channels that show places; of all, where none does */
static double misfit(const audit *a, int record, double *worst)
{
    const lab_data *d = a->data->stroke[record];
    double sum[2] = {0.0}, most[2] = {0.0};
    int n[2] = {0};
    for (int k = 0; k < d->ncolumn; k++) {
        const data__match *m = &a->plain[record][k];
        for (int i = 0; m->compared && i < 1 + m->place; i++) {
            sum[i] += m->off;
            most[i] = fmax(most[i], m->off);
            n[i]++;
        }
    }
    int i = n[1] > 0;
    *worst = most[i];
    return n[i] > 0 ? sum[i] / n[i] : 0.0;
}

static void tell_foreign(audit *a, int record, double own, double median)
{
    const lab_data *d = a->data->stroke[record];
    add(a, (lab_doubt){.kind = LAB_DOUBT_ALIEN,
                       .stroke = record,
                       .records = 1,
                       .column = -1,
                       .other = -1,
                       .factor = 1.0,
                       .off = own,
                       .then = NAN,
                       .text = lab__text("%s: all columns: the motion cannot be reproduced (misfit "
                                         "%.2f, the median of all records %.2g); a record of "
                                         "another mechanism, or of other settings than it states, "
                                         "would look so",
                                         d->file, own, median)});
}

static void judge(audit *a, double *off, double *worst, double *sorted)
{
    int n = a->data->n, nbad = 0, *bad = malloc(sizeof *bad * (size_t)n);
    if (bad == NULL) {
        a->status = lab__no_memory(a->err);
        return;
    }
    for (int r = 0; r < n; r++) {
        sorted[r] = off[r];
        if (worst[r] > fits) {
            bad[nbad++] = r;
        }
    }
    qsort(sorted, (size_t)n, sizeof *sorted, data__compare);
    double median = sorted[(n - 1) / 2];
    int most = 2 * nbad > n, tested = nbad < TESTED ? nbad : TESTED, told = 0;
    if (most) {
        offer_all(a, a->data->stroke[bad[0]]);
        for (int i = 0; i < a->nguess; i++) {
            for (int k = 0; k < tested; k++) {
                // two that do not fit are enough
                if (k < 2 || a->guess[i].accepted > 0) {
                    try_guess(a, &a->guess[i], bad[k * nbad / tested]);
                }
            }
        }
        told = tell_best(a, nbad, 2.0 / 3.0);
    }
    for (int i = 0; !most && i < nbad && a->status == STEIN_OK; i++) {
        offer_all(a, a->data->stroke[bad[i]]);
        for (int k = 0; k < a->nguess; k++) {
            try_guess(a, &a->guess[k], bad[i]);
        }
        told = tell_best(a, 1, 1.0);
        if (told == 0 && n >= FEW && median < well && off[bad[i]] > foreign) {
            tell_foreign(a, bad[i], off[bad[i]], median);
        }
    }
    free(bad);
}

/* ---- lengths ---- */

/* largest length of the file: what the mechanism can reach is not far from it */
static double largest_length(const lab_model *model)
{
    const stein_model *m = lab_equations(model);
    double largest = 0.0;
    for (int i = 0; i < m->np; i++) {
        if (strcmp(m->params[i].unit, "m") == 0) {
            largest = fmax(largest, fabs(lab_parameters(model)[i]));
        }
    }
    return largest;
}

/* a linear model fits at any scale: then its lengths decide */
static void judge_travel(audit *a, int record, int k)
{
    const lab_data *d = a->data->stroke[record];
    const data__match *m = &a->plain[record][k];
    double reach = largest_length(a->model), travel = m->travel;
    if (!m->compared || !m->place || m->off > fits || strcmp(d->column[k].unit, "m") != 0 ||
        !(reach > 0.0) || travel < beyond * reach || 1e-3 * travel > inside * reach) {
        return;
    }
    guess g = {.a = d->column[k].name, .factor = 1e-3, .time = 1.0};
    data__reading reading;
    applies(&g, d, &reading);
    try(a, record, reading, a->other);
    if (a->status != STEIN_OK || a->other[k].off > fits) {
        return; // gravity, say, tells the scale
    }
    char x[DATA_SHOWN], y[DATA_SHOWN];
    add(a, (lab_doubt){.kind = LAB_DOUBT_SCALE,
                       .grave = 1,
                       .stroke = record,
                       .records = a->data->n,
                       .column = k,
                       .other = -1,
                       .factor = 1e-3,
                       .off = m->off,
                       .then = a->other[k].off,
                       .text = lab__text("%s: %s: %s of travel, the largest length of the model is "
                                         "%s; read as mm instead of m it would suit",
                                         d->file, d->column[k].name, data__quantity(x, travel, "m"),
                                         data__quantity(y, reach, "m"))});
}

/* ---- the whole ---- */

static int by_severity(const void *a, const void *b)
{
    const lab_doubt *p = a, *q = b;
    int grave = q->grave - p->grave, many = (q->records > p->records) - (q->records < p->records);
    return grave != 0  ? grave
           : many != 0 ? many
                       : (p->stroke > q->stroke) - (p->stroke < q->stroke);
}

static void look(audit *a, double *room)
{
    int n = a->data->n;
    for (int r = 0; r < n && a->status == STEIN_OK; r++) {
        try(a, r, data__as_it_is(), a->plain[r]);
        room[r] = misfit(a, r, &room[n + r]);
    }
    if (a->status == STEIN_OK) {
        judge(a, room, room + n, room + 2 * n);
    }
    for (int k = 0; k < a->data->stroke[0]->ncolumn && a->status == STEIN_OK; k++) {
        judge_travel(a, 0, k);
    }
    if (a->out->n > 1) {
        qsort(a->out->item, (size_t)a->out->n, sizeof *a->out->item, by_severity);
    }
}

stein_status lab_doubts_find(lab_doubts **doubts, const lab_model *model, const lab_dataset *data,
                             stein_err *err)
{
    audit a = {.model = model, .data = data, .status = STEIN_OK, .err = err};
    size_t n = (size_t)data->n;
    double *room = calloc(3 * n + 1, sizeof *room);
    a.out = calloc(1, sizeof *a.out);
    a.guess = calloc(READINGS, sizeof *a.guess);
    a.plain = calloc(n + 1, sizeof *a.plain);
    a.other = calloc(DATA_COLUMNS, sizeof *a.other);
    int memory =
        room != NULL && a.out != NULL && a.guess != NULL && a.plain != NULL && a.other != NULL;
    for (size_t r = 0; memory && r < n; r++) {
        a.plain[r] = calloc((size_t)data->stroke[r]->ncolumn + 1, sizeof **a.plain);
        memory = a.plain[r] != NULL;
    }
    if (!memory) {
        a.status = lab__no_memory(err);
    } else if (n > 0) {
        look(&a, room);
    }
    for (size_t r = 0; a.plain != NULL && r < n; r++) {
        free(a.plain[r]);
    }
    free(a.plain);
    free(a.other);
    free(a.guess);
    free(room);
    if (a.status != STEIN_OK) {
        lab_doubts_free(a.out);
        return a.status;
    }
    *doubts = a.out;
    return STEIN_OK;
}

void lab_doubts_free(lab_doubts *doubts)
{
    for (int i = 0; doubts != NULL && i < doubts->n; i++) {
        free(doubts->item[i].text);
    }
    if (doubts != NULL) {
        free(doubts->item);
        free(doubts);
    }
}

stein_status lab_suspicions(char ***finding, int *n, const lab_model *model,
                            const lab_dataset *data, stein_err *err)
{
    lab_doubts *doubts = NULL;
    stein_status status = lab_doubts_find(&doubts, model, data, err);
    if (status != STEIN_OK) {
        return status;
    }
    char **text = doubts->n > 0 ? calloc((size_t)doubts->n, sizeof *text) : NULL;
    if (doubts->n > 0 && text == NULL) {
        lab_doubts_free(doubts);
        return lab__no_memory(err);
    }
    *n = doubts->n;
    for (int i = 0; i < *n; i++) { // handed over
        text[i] = doubts->item[i].text;
        doubts->item[i].text = NULL;
    }
    *finding = text;
    lab_doubts_free(doubts);
    return STEIN_OK;
}

void lab_suspicions_free(char **finding, int n)
{
    for (int i = 0; i < n; i++) {
        free(finding[i]);
    }
    free(finding);
}
