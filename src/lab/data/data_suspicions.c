/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_suspicions.c - columns in the wrong unit, with the wrong sign, exchanged; a wrong clock; a
 * record of another mechanism: reported before any fit.
 *
 * Every record is compared with the model (data_compare.c). Where that fits, nothing is
 * asked. Where it does not, the readings that slips produce are tried. They are factors of 1000 and
 * 100, the factor between degrees and radians, the opposite sign, two columns exchanged,
 * milliseconds for seconds, alone or with degrees or thousandths. A reading is a suspicion when a
 * record that was far off fits with it:
 *
 *   - the misfit of the affected channels falls below `fits` and by the factor `better`, or
 *   - channels that could not be compared (misfit above `apart`) move about as they should, by the
 *     right amount within 25 %;
 *
 * and is better than a straight line, in two thirds of the records that do not fit, or, where most
 * records do fit, in that one. A model that is merely wrong does not do so: two motions that have
 * nothing in common have a misfit of 0.7, and no factor of 1000 brings that to 0.25.
 *
 * Measured: 68 slips were put into one or all records of a pendulum, a double arm, a thrown cube,
 * the action and the double pendulum. 64 were named; the others do not change the motion. 17
 * correct sets, and 105 of their records alone, gave none. 83 sets compared with models of which
 * one to four numbers were wrong by factors of 0.3 to 3 gave one. Counted by hand, with an earlier
 * estimate of the initial state; of 36 slips repeated with this one, the same 33 are named by both.
 *
 * A linear model with an unknown initial state follows its data at any scale. There the travel is
 * compared with the largest length of the model's file.
 */
#include <gsl/gsl_sort.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data_misreadings.h"

/* Misfits. Two unrelated motions have 0.7; a right reading of the records named above has at most
 * 0.08, and a model may lack more than theirs. */
static const double fits = 0.25;         /* a reading fits */
static const double fits_adapted = 0.15; /* the same where the initial state helped it */
static const double apart = 0.9;         /* sizes that cannot be compared */
static const double nearly = 0.45;       /* moves about as it should */
static const double asked = 0.12,
                    not_asked = 0.05;           /* of a record that is asked about always, never */
static const double foreign = 0.6, well = 0.15; /* of a foreign record; median of all then */
static const double odd_sign = 0.45; /* a sensor seldom changes its sign for one record */
/* factors */
static const double better = 3.0;   /* misfit before over misfit of the reading */
static const double usual = 5.0;    /* of the median record: between never and always asked */
static const double within = 1.25;  /* of the travel */
static const double straight = 0.5; /* share of a straight line's misfit */
static const double alike = 3.0;    /* misfits of two units that are both possible */
static const double longest = 50.0,
                    shortest = 500.0;             /* a record over a run of the model, and back */
static const double beyond = 30.0, inside = 3.0;  /* travel over the largest length of the model */
static const double degrees = 57.295779513082321; /* in a radian */
enum {
    PATIENCE = 200000, /* evaluations of the equations for one trial */
    TESTED = 6,        /* records that a reading is tried on */
    READINGS = 400,
    FEW = 4 /* records; fewer do not show which of them is foreign */
};

/* ---- trials ---- */

static void try(data__suspects *a, int record, data__reading reading, data__match *match)
{
    long patience = PATIENCE;
    if (a->status != STEIN_OK) {
        return;
    }
    a->status = data__try(a->model, a->data->stroke[record], reading, match, &patience, a->err);
    a->status = a->status == STEIN_EINVAL ? STEIN_OK : a->status; // no output: nothing to compare
}

/* is the column among those that the guess is about? */
static int affects(const data__guess *g, const lab_data *d, int k)
{
    const lab_column *c = &d->column[k];
    if (g->unit != NULL) {
        return strcmp(c->unit, g->unit) == 0;
    }
    int column = g->a != NULL ? (int)(lab_data_column(d, g->a) - d->column) : -1;
    return column < 0 || d->column[column].role == LAB_INPUT || k == column ||
           (g->b != NULL && strcmp(c->name, g->b) == 0);
}

int data__reading_of(const data__guess *g, const lab_data *d, data__reading *reading)
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

/* result of a guess for one record */
typedef struct effect {
    int adapted;                     /* the initial state was taken from the record */
    int channels;                    /* affected */
    double off, then;                /* means over the affected channels */
    double least_off, most_then;     /* of them */
    double all_off, all_then;        /* means over all channels */
    double line;                     /* mean misfit of straight lines in the affected channels */
    double worst;                    /* largest misfit then, of all channels */
    double ratio, travel, predicted; /* travel over predicted, worst; of the first affected one */
} effect;

static effect compare(const data__guess *g, const lab_data *d, int all_affected,
                      const data__match *plain, const data__match *then)
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
        e.worst = fmax(e.worst, then[k].off);
        e.adapted |= plain[k].adapted;
        if (!all_affected && !affects(g, d, k)) {
            continue;
        }
        double ratio = then[k].travel / then[k].predicted;
        ratio = ratio > 1.0 ? ratio : 1.0 / ratio;
        e.travel = e.channels == 0 ? plain[k].travel : e.travel;
        e.predicted = e.channels == 0 ? then[k].predicted : e.predicted;
        e.channels++;
        e.off += plain[k].off;
        e.then += then[k].off;
        e.line += then[k].line;
        e.least_off = fmin(e.least_off, plain[k].off);
        e.most_then = fmax(e.most_then, then[k].off);
        e.ratio = isfinite(ratio) ? fmax(e.ratio, ratio) : (double)INFINITY;
    }
    e.off /= fmax(1.0, e.channels);
    e.then /= fmax(1.0, e.channels);
    e.line /= fmax(1.0, e.channels);
    e.all_off /= fmax(1.0, all);
    e.all_then /= fmax(1.0, all);
    return e;
}

static int is_accepted(const data__guess *g, const effect *e)
{
    int fitting =
        e->most_then < (e->adapted ? fits_adapted : fits) && e->off > better * e->then + 0.1;
    int sized = e->most_then < nearly && e->least_off > apart && e->ratio < within;
    // a friction or damping that is wrong decays otherwise; a wrong unit misses the motion
    fitting &= !e->adapted || g->factor == 1.0 || g->factor < 0.0 || e->off > nearly;
    // a body that is thrown hard enough moves straight on, whatever the forces
    int calmer = fabs(g->factor) < 1.0;
    int curved = calmer || !e->adapted || e->then < straight * e->line;
    return e->channels > 0 && (fitting || (sized && !e->adapted)) && curved &&
           e->all_then < e->all_off;
}

/* would the record last about as long as a run of the model? */
static int lasts_long_enough(const data__guess *g, const lab_data *d)
{
    double length = g->time * (d->time[d->nrow - 1] - d->time[0]), until = d->model->until;
    return g->time == 1.0 || (length < longest * until && length > until / shortest);
}

static void try_guess(data__suspects *a, data__guess *g, int record)
{
    const lab_data *d = a->data->stroke[record];
    data__reading reading;
    if (!data__reading_of(g, d, &reading) || !lasts_long_enough(g, d)) {
        return;
    }
    try(a, record, reading, a->other);
    // through an adapted initial state a wrong column spoils the others
    effect e = compare(g, d, 0, a->plain[record], a->other);
    effect all = compare(g, d, 1, a->plain[record], a->other);
    int spoils = all.adapted && is_accepted(g, &all) && all.off > e.off;
    g->tested++;
    if (a->status == STEIN_OK && (spoils || is_accepted(g, &e))) {
        e.off = spoils ? all.off : e.off;
        g->first = g->accepted == 0 ? record : g->first;
        g->travel = g->accepted == 0 ? e.travel : g->travel;
        g->predicted = g->accepted == 0 ? e.predicted : g->predicted;
        g->accepted++;
        g->cured += e.worst < fits;
        g->off += e.off;
        g->then += e.then;
        g->score += e.all_then;
    }
}

/* ---- readings that slips produce ---- */

static void offer(data__suspects *a, data__guess g)
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

static int is_first(const lab_data *d, int k)
{
    int i = 0;
    while (strcmp(d->column[i].unit, d->column[k].unit) != 0) {
        i++;
    }
    return i == k;
}

static void offer_all(data__suspects *a, const lab_data *d)
{
    a->nguess = 0;
    offer(a, (data__guess){.factor = 1.0, .time = 1e-3});
    offer(a, (data__guess){.factor = 1.0, .time = 1e3});
    for (int k = 0; k < d->ncolumn; k++) {
        const lab_column *c = &d->column[k];
        if (c->role == LAB_EVENT_TIMES) {
            continue;
        }
        double odd = strcmp(c->unit, "rad") == 0 || strcmp(c->unit, "rad/s") == 0 ? degrees : 100.0;
        double factor[] = {1e-3, 1e3, 1.0 / odd, odd, -1.0};
        for (int i = 0; i < 5; i++) {
            offer(a, (data__guess){.a = c->name, .factor = factor[i], .time = 1.0});
            // milliseconds and degrees come from one program without units
            if ((i == 0 || i == 2) && is_first(d, k)) {
                offer(a, (data__guess){.unit = c->unit, .factor = factor[i], .time = 1e-3});
            }
            if (i < 4 && begins_group(d, k)) {
                offer(a, (data__guess){.unit = c->unit, .factor = factor[i], .time = 1.0});
            }
        }
        for (int i = k + 1; i < d->ncolumn; i++) {
            const lab_column *b = &d->column[i];
            if (strcmp(c->unit, b->unit) == 0 && c->role == b->role) {
                offer(a, (data__guess){.a = c->name, .b = b->name, .factor = 1.0, .time = 1.0});
            }
        }
    }
}

/* ---- the best of them ---- */

/* do two guesses speak of the same column? */
static int overlap(const data__guess *g, const data__guess *h, const lab_data *d)
{
    for (int k = 0; k < d->ncolumn; k++) {
        if (affects(g, d, k) && affects(h, d, k)) {
            return 1;
        }
    }
    return 0;
}

/* the best guess that enough of the tested records accept; NULL: none */
static data__guess *best_guess(data__suspects *a, double share, int alone)
{
    data__guess *best = NULL;
    for (int i = 0; i < a->nguess; i++) {
        data__guess *g = &a->guess[i];
        int likely = !alone || g->factor > 0.0 || g->off > odd_sign * g->accepted;
        if (likely && g->accepted > 0 && g->accepted >= share * g->tested &&
            (best == NULL || g->score / g->accepted < best->score / best->accepted)) {
            best = g;
        }
    }
    return best;
}

/* The other units in which the same columns fit about as well, since small swings have one shape at
 * any scale. Degrees are the usual ones and come first.
 * @return the guess to tell, with the others in `also` */
static data__guess with_other_units(const data__suspects *a, const data__guess *best, double share)
{
    const data__guess *first = best, *list[DATA_UNITS];
    int n = 0;
    for (int i = 0; i < a->nguess; i++) {
        const data__guess *g = &a->guess[i];
        int same = g->a == best->a && g->b == best->b && g->unit == best->unit &&
                   g->time == best->time && g->factor > 0.0 && best->factor > 0.0 &&
                   g->factor != 1.0 && (g->factor < 1.0) == (best->factor < 1.0);
        if (same && n < DATA_UNITS && g->accepted > 0 && g->accepted >= share * g->tested &&
            g->then * best->accepted <= alike * best->then * g->accepted) {
            list[n++] = g;
            first = g->factor == 1.0 / degrees ? g : first;
        }
    }
    data__guess told = *first;
    for (int i = 0; i < n; i++) {
        if (list[i] != first) {
            told.also[told.nalso++] = list[i]->factor;
        }
    }
    return told;
}

/* Another column whose sign explains all of it, too: two pendulums swing alike to both sides. */
static const char *other_sign(const data__suspects *a, const data__guess *best)
{
    for (int i = 0; i < a->nguess && best->factor < 0.0 && best->cured == best->accepted; i++) {
        const data__guess *g = &a->guess[i];
        if (g != best && g->factor < 0.0 && 2 * g->cured >= best->cured) {
            return g->a;
        }
    }
    return NULL;
}

/* The best guesses that enough of the tested records accept, each column once, until every channel
 * fits. @return number of reports */
static int tell_best(data__suspects *a, int records, double share, int alone)
{
    int told = 0;
    data__guess *best = best_guess(a, share, alone);
    while (best != NULL && a->status == STEIN_OK) {
        data__guess done = *best, told_as = with_other_units(a, best, share);
        data__tell_guess(a, &told_as, other_sign(a, best), records, alone);
        told++;
        if (done.cured == done.accepted) {
            break;
        }
        for (int i = 0; i < a->nguess; i++) {
            data__guess *g = &a->guess[i];
            g->accepted = overlap(&done, g, a->data->stroke[done.first]) ? 0 : g->accepted;
        }
        best = best_guess(a, share, alone);
    }
    return told;
}

/* ---- records ---- */

/* mean and worst misfit of the channels that show places or speeds; of all, where none does */
static double misfit(const data__suspects *a, int record, double *worst)
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

/* readings that most of the records that do not fit agree on */
static void judge_all(data__suspects *a, const int *bad, int nbad)
{
    int tested = nbad < TESTED ? nbad : TESTED;
    offer_all(a, a->data->stroke[bad[0]]);
    for (int i = 0; i < a->nguess; i++) {
        for (int k = 0; k < tested; k++) {
            // two that do not fit are enough
            if (k < 2 || a->guess[i].accepted > 0) {
                try_guess(a, &a->guess[i], bad[k * nbad / tested]);
            }
        }
    }
    tell_best(a, nbad, 2.0 / 3.0, 0);
}

/* fault of one record, while most fit */
static void judge_one(data__suspects *a, int record, double own, double median)
{
    offer_all(a, a->data->stroke[record]);
    for (int k = 0; k < a->nguess; k++) {
        try_guess(a, &a->guess[k], record);
    }
    if (tell_best(a, 1, 1.0, 1) == 0 && a->data->n >= FEW && median < well && own > foreign) {
        data__tell_foreign(a, record, own, median);
    }
}

static void judge(data__suspects *a, double *off, double *worst, double *sorted)
{
    int n = a->data->n, nbad = 0, *bad = malloc(sizeof *bad * (size_t)n);
    if (bad == NULL) {
        a->status = lab__no_memory(a->err);
        return;
    }
    memcpy(sorted, worst, sizeof *sorted * (size_t)n);
    gsl_sort(sorted, 1, (size_t)n);
    double limit = fmin(asked, fmax(not_asked, usual * sorted[(n - 1) / 2]));
    for (int r = 0; r < n; r++) {
        if (worst[r] > limit) {
            bad[nbad++] = r;
        }
    }
    memcpy(sorted, off, sizeof *sorted * (size_t)n);
    gsl_sort(sorted, 1, (size_t)n);
    if (2 * nbad > n) {
        judge_all(a, bad, nbad);
    } else {
        for (int i = 0; i < nbad && a->status == STEIN_OK; i++) {
            judge_one(a, bad[i], off[bad[i]], sorted[(n - 1) / 2]);
        }
    }
    free(bad);
}

/* ---- lengths ---- */

/* largest length of the file: the reach of the mechanism is not far from it */
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
static void judge_travel(data__suspects *a, int record, int k)
{
    const lab_data *d = a->data->stroke[record];
    const data__match *m = &a->plain[record][k];
    double reach = largest_length(a->model), travel = m->travel;
    if (!m->compared || !m->place || m->off > fits || strcmp(d->column[k].unit, "m") != 0 ||
        !(reach > 0.0) || travel < beyond * reach || 1e-3 * travel > inside * reach) {
        return;
    }
    data__guess g = {.a = d->column[k].name, .factor = 1e-3, .time = 1.0};
    data__reading reading;
    data__reading_of(&g, d, &reading);
    try(a, record, reading, a->other);
    if (a->status != STEIN_OK || a->other[k].off > fits) {
        return; // gravity, for example, determines the scale
    }
    data__tell_travel(a, record, k, reach, a->other[k].off);
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

static void look(data__suspects *a, double *room)
{
    int n = a->data->n;
    for (int r = 0; r < n && a->status == STEIN_OK; r++) {
        try(a, r, data__as_it_is(), a->plain[r]);
        room[r] = misfit(a, r, &room[n + r]);
    }
    if (a->status == STEIN_OK) {
        judge(a, room, room + n, room + 2 * n);
    }
    for (int k = 0; a->out->n == 0 && k < a->data->stroke[0]->ncolumn; k++) {
        judge_travel(a, 0, k);
    }
    if (a->out->n > 1) {
        qsort(a->out->item, (size_t)a->out->n, sizeof *a->out->item, by_severity);
    }
}

stein_status lab_doubts_find(lab_doubts **doubts, const lab_model *model, const lab_dataset *data,
                             stein_err *err)
{
    data__suspects a = {.model = model, .data = data, .status = STEIN_OK, .err = err};
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
