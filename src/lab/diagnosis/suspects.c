/* SPDX-License-Identifier: GPL-3.0-or-later
 * suspects.c - what each candidate would change in the strokes.
 *
 *      G = (r(x0, a) - r(x0)) / a
 *
 * with x0 the fit without it and r the weighted residuals of all strokes. An effect may begin
 * one-sided or with zero slope (a gap that is never reached), so a derivative at a = 0 says little:
 * G is a secant, and a is chosen from what it does - the films change by a fifth of the noise
 * (RMS): less is rounded by the steps of the integrator, more is bent. Of a number that is fitted
 * anyhow, within its tolerance, G is the derivative that the fit has.
 *
 * What a part does is far from linear in its amount: a link that bends a little follows slowly, one
 * that bends more rings. Parts change the films by one noise, and have a second secant of a smaller
 * amount; the one that looks more like the residual counts (rank.c). So do numbers that have no
 * sign, one of the other sign, where the strokes begin: a key that lies on its rest follows it up,
 * and its pawl follows it down.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "searching.h"
#include "structure.h"

static const double wanted = 0.2;    /* RMS change [noise] */
static const double of_part = 1.0;   /* the same of a part */
static const double exact = 0.01;    /* of what is read alone: the strokes stay as they are */
static const double visible = 0.01;  /* less than that at the limit shows in no record */
static const double smallest = 1e-6; /* amount [limits] */
static const char unseen[] = "it would not show in these strokes";
static const double smaller = 0.2; /* amount of a part's second secant, in that of the first */
static const double about = 1.6;   /* factor by which a scanned amount may be another one */
enum { SIZINGS = 5, SCANNED = 32, SCAN_ROUNDS = 3 };

fit__problem *diag__problem(diag *d, const diag__suspect *s)
{
    return s->fit != NULL ? s->fit : &d->p;
}

/* ---- simulating with a suspect ---- */

typedef struct trial {
    const fit__problem *p;
    const double *x, *r0; /* of the null fit, all unknowns */
    diag__suspect **suspect;
    const int *stroke;
    int nstroke;
    unsigned char *failed; /* [suspects*strokes] */
    double *square;        /* [suspects*strokes] sums of squares of the change */
} trial;

stein_status diag__begin_with(const fit__problem *problem, fit__bench *b, const diag__suspect *s,
                              const double *x0, double amount, int stroke, double *y)
{
    fit__problem p = *problem; // this simulation's: with the suspect in it
    fit__unknown *unknown = malloc(sizeof *unknown * (size_t)p.nu);
    stein_status status = STEIN_ENOMEM;
    if (unknown != NULL) {
        memcpy(unknown, p.unknown, sizeof *unknown * (size_t)p.nu);
        memcpy(b->x, x0, sizeof *b->x * (size_t)p.nu);
        memset(b->x + p.amount, 0, sizeof *b->x * FIT__NUMBERS);
        p.unknown = unknown;
        fit__problem_try(&p, &s->s.candidate);
        b->x[p.amount] = amount;
        status = fit__begin(&p, b, stroke, b->x, y, NULL);
    }
    free(unknown);
    return status;
}

/* one suspect on one stroke */
static stein_status ask(void *ctx, fit__bench *b, int job)
{
    const trial *t = ctx;
    const diag__suspect *s = t->suspect[job / t->nstroke];
    int stroke = t->stroke[job % t->nstroke];
    return diag__begin_with(t->p, b, s, t->x, s->step, stroke, s->G + fit__offset(t->p, stroke));
}

static void take(void *ctx, fit__bench *b, int job, int failed)
{
    trial *t = ctx;
    const diag__suspect *s = t->suspect[job / t->nstroke];
    int stroke = t->stroke[job % t->nstroke];
    const fit__stroke *data = &t->p->stroke[stroke];
    size_t at = fit__offset(t->p, stroke), n = (size_t)data->nch * (size_t)data->n;
    (void)b;
    t->failed[job] = (unsigned char)failed;
    if (failed) {
        return;
    }
    fit__weigh(data, s->G + at);
    t->square[job] = 0.0;
    for (size_t i = at; i < at + n; i++) {
        s->G[i] -= t->r0[i];
        t->square[job] += s->G[i] * s->G[i];
        s->G[i] /= s->step;
    }
}

static int samples_of(const fit__problem *p, const int *stroke, int n)
{
    int sum = 0;
    for (int i = 0; i < n; i++) {
        sum += p->stroke[stroke[i]].samples;
    }
    return sum > 0 ? sum : 1;
}

/* RMS change of suspect i over the strokes of a trial, INFINITY when one failed */
static double change_of(const trial *t, int i)
{
    double sum = 0.0;
    for (int k = 0; k < t->nstroke; k++) {
        sum += t->failed[i * t->nstroke + k] ? (double)INFINITY : t->square[i * t->nstroke + k];
    }
    return sqrt(sum / samples_of(t->p, t->stroke, t->nstroke));
}

static stein_status try_all(diag *d, trial *t, int nsuspect, stein_err *err)
{
    size_t jobs = (size_t)nsuspect * (size_t)t->nstroke;
    t->failed = calloc(jobs + 1, 1);
    t->square = calloc(jobs + 1, sizeof *t->square);
    d->out->strokes_simulated += (int)jobs;
    return t->failed != NULL && t->square != NULL ? fit__many(t->p, (int)jobs, ask, take, t, err)
                                                  : lab__no_memory(err);
}

static void trial_free(trial *t)
{
    free(t->failed);
    free(t->square);
}

/* ---- the size of the secant ---- */

/* The change of the films that a secant is taken from. Most of what a time base or a lens that
 * bends does, other numbers can do as well: what it leaves of a residual is a hundredth of itself,
 * and a secant that is bent by a hundredth hides it. Their strokes are the same to the bit, so
 * theirs may be short. */
static double change_for(const diag__suspect *s)
{
    lab_site site = s->s.candidate.effect->site;
    int read = site == LAB_AT_CHANNEL || site == LAB_AT_MARKER || site == LAB_AT_CLOCK;
    return read ? exact : s->model != NULL ? of_part : wanted;
}

/* a new step for one that made this change. @return 1 when it will do as it is */
static int resize(diag__suspect *s, double change)
{
    double aim = change_for(s);
    if (!isfinite(change)) {
        s->step *= 0.1;
        return 0;
    }
    if (change > 0.15 * aim && change < 6.0 * aim) {
        return 1;
    }
    if (change < aim && s->step >= 1.0) {
        s->s.why = change < visible ? unseen : NULL;
        return 1;
    }
    double factor = change > 0.0 ? aim / change : 20.0;
    s->step = fmin(1.0, s->step * fmin(fmax(factor, 1e-3), 20.0));
    return 0;
}

/* steps of those suspects, from one stroke */
static stein_status size_steps(diag *d, const fit__problem *p, diag__suspect **list, int n,
                               stein_err *err)
{
    int middle = p->nstroke / 2;
    diag__suspect **open = malloc(sizeof *open * (size_t)(n + 1));
    stein_status status = open != NULL ? STEIN_OK : lab__no_memory(err);
    for (int i = 0; status == STEIN_OK && i < n; i++) {
        open[i] = list[i];
        list[i]->step = list[i]->step > 0.0 ? list[i]->step : list[i]->s.candidate.start;
    }
    for (int round = 0; status == STEIN_OK && n > 0 && round < SIZINGS; round++) {
        trial t = {.p = p, .x = d->x, .r0 = d->r, .suspect = open, .stroke = &middle, .nstroke = 1};
        status = try_all(d, &t, n, err);
        int left = 0;
        for (int i = 0; status == STEIN_OK && i < n; i++) {
            int done = resize(open[i], change_of(&t, i));
            if (!done && open[i]->step < smallest) {
                open[i]->s.why = "no amount of it can be simulated";
                done = 1;
            }
            if (!done) {
                open[left++] = open[i];
            }
        }
        n = left;
        trial_free(&t);
    }
    free(open);
    return status;
}

/* G with the steps as they are; `why` of those with which not all strokes can be simulated */
static stein_status secants(diag *d, const fit__problem *p, diag__suspect **list, int n,
                            stein_err *err)
{
    int *stroke = malloc(sizeof *stroke * (size_t)(p->nstroke + 1));
    if (stroke == NULL) {
        return lab__no_memory(err);
    }
    for (int s = 0; s < p->nstroke; s++) {
        stroke[s] = s;
    }
    trial t = {
        .p = p, .x = d->x, .r0 = d->r, .suspect = list, .stroke = stroke, .nstroke = p->nstroke};
    stein_status status = try_all(d, &t, n, err);
    for (int i = 0; status == STEIN_OK && i < n; i++) {
        if (!isfinite(change_of(&t, i))) {
            list[i]->s.why = "not all strokes can be simulated with it";
        }
    }
    trial_free(&t);
    free(stroke);
    return status;
}

/* of the scanned amounts the one that the residual asks for most, all else refitted linearly; it
 * has to ask for about that amount. @return -1: of none */
static int best_amount(const diag *d, const double *const *column, stein_status *status,
                       stein_err *err)
{
    double score[SCANNED], epc[SCANNED], info[SCANNED], corr[SCANNED * SCANNED], most = 0.0;
    lab__mixed m = {.nf = 0};
    int best = -1;
    *status = diag__mixed_at(&m, &d->p, d->x, d->J, d->r, column, SCANNED, err);
    if (*status == STEIN_OK) {
        double *beta = malloc(sizeof *beta * (size_t)(m.nf + 1));
        if (beta == NULL) {
            *status = lab__no_memory(err);
        } else {
            lab__mixed_scatter(&m, NULL, 0, SCAN_ROUNDS, beta, NULL);
            lab__mixed_weigh(&m); // of all columns
            lab__mixed_score(&m, score, epc, info, corr);
        }
        free(beta);
    }
    for (int k = 0; *status == STEIN_OK && k < SCANNED; k++) {
        double wish = epc[k] * SCANNED / (k + 1);
        if (score[k] > most && wish > 1.0 / about && wish < about) {
            most = score[k];
            best = k;
        }
    }
    lab__mixed_free(&m);
    return best;
}

/* What is there or not - a coupling that lets go - does nothing up to an amount and much beyond it,
 * so neither a derivative nor a small change says how much of it there is. Its step is one of many
 * amounts; where the residual asks for none of them it stays. */
static stein_status scan_step(diag *d, const fit__problem *p, diag__suspect *s, stein_err *err)
{
    size_t rows = fit__offset(p, p->nstroke);
    const double *column[SCANNED];
    double *room = calloc(rows * SCANNED + 1, sizeof *room), kept = s->step;
    stein_status status = room != NULL ? STEIN_OK : lab__no_memory(err);
    for (int k = 0; status == STEIN_OK && k < SCANNED; k++) {
        s->step = (k + 1.0) / SCANNED;
        status = secants(d, p, &s, 1, err);
        column[k] = room + (size_t)k * rows;
        if (s->s.why == NULL) { // else a column of zeros
            memcpy(room + (size_t)k * rows, s->G, sizeof *room * rows);
        }
        s->s.why = NULL;
    }
    int best = status == STEIN_OK ? best_amount(d, column, &status, err) : -1;
    s->step = best >= 0 ? (best + 1.0) / SCANNED : kept;
    s->scanned = best >= 0;
    free(room);
    return status;
}

static stein_status make_column(double **column, const fit__problem *p, stein_err *err)
{
    if (*column == NULL) {
        *column = calloc(fit__offset(p, p->nstroke) + 1, sizeof **column);
    }
    return *column != NULL ? STEIN_OK : lab__no_memory(err);
}

/* ---- numbers that the fit moves anyhow ---- */

int diag__number_of(const diag *d, const diag__suspect *s)
{
    const lab_candidate *c = &s->s.candidate;
    int plain =
        c->move == LAB_MOVE_ADD || c->move == LAB_MOVE_RELATIVE || c->move == LAB_MOVE_SCALE;
    for (int k = 0; plain && s->model == NULL && c->nparam == 1 && k < d->nname; k++) {
        if (d->p.unknown[k].index == c->param[0] && d->p.unknown[k].prior) {
            return k;
        }
    }
    return -1;
}

/* Of such a number G is what the fit knows of it, the derivative J. A secant would differ from that
 * by its curvature, and thousands of samples would take the difference for knowledge: that the
 * number cannot be wrong since the fit has moved it already, however far outside its tolerance. */
static void take_derivative(const diag *d, diag__suspect *s, int k)
{
    const fit__problem *p = &d->p;
    const fit__unknown *u = &p->unknown[k];
    double per_x = u->sd * fit__slope(u, d->x[k]); // of the number
    double per_amount =
        s->s.candidate.limit * (s->s.candidate.move == LAB_MOVE_ADD ? 1.0 : fit__value(u, d->x[k]));
    double square = 0.0;
    for (int t = 0; t < p->nstroke; t++) {
        const fit__stroke *o = &p->stroke[t];
        const double *j = d->J + fit__column(p, t, k);
        double *G = s->G + fit__offset(p, t);
        for (int i = 0; i < o->nch * o->n; i++) {
            G[i] = j[i] * per_amount / per_x;
            square += G[i] * G[i];
        }
    }
    int shows = sqrt(square / fmax(1.0, p->samples)) >= visible; // at the limit
    s->s.why = shows ? NULL : unseen;
}

/* G of suspects that are simulated in the same problem */
static stein_status change_all(diag *d, const fit__problem *p, diag__suspect **list, int n,
                               stein_err *err)
{
    stein_status status = STEIN_OK;
    int left = 0, asked = 0;
    for (int i = 0; status == STEIN_OK && i < n; i++) {
        int k = diag__number_of(d, list[i]);
        status = make_column(&list[i]->G, p, err);
        if (status == STEIN_OK && k >= 0) {
            take_derivative(d, list[i], k);
        } else {
            list[asked++] = list[i];
        }
    }
    n = asked;
    status = status == STEIN_OK ? size_steps(d, p, list, n, err) : status;
    for (int i = 0; i < n; i++) {
        if (status == STEIN_OK && list[i]->s.candidate.effect->site == LAB_AT_LINK) {
            list[i]->s.why = NULL; // one stroke may not show it
            status = scan_step(d, p, list[i], err);
        }
    }
    for (int i = 0; i < n; i++) {
        if (list[i]->s.why == NULL) {
            list[left++] = list[i];
        }
    }
    return status == STEIN_OK ? secants(d, p, list, left, err) : status;
}

void diag__swap_secants(diag__suspect *s)
{
    double *G = s->G, step = s->step;
    s->G = s->small;
    s->step = s->small_step;
    s->small = G;
    s->small_step = step;
}

/* both secants of a part */
static stein_status change_part(diag *d, diag__suspect *s, stein_err *err)
{
    stein_status status = change_all(d, s->fit, &s, 1, err);
    if (status != STEIN_OK || s->s.why != NULL) {
        return status;
    }
    status = make_column(&s->small, s->fit, err);
    s->small_step = smaller * s->step;
    if (status == STEIN_OK) {
        diag__swap_secants(s);
        status = secants(d, s->fit, &s, 1, err);
        diag__swap_secants(s);
    }
    if (s->s.why != NULL) { // without the small one
        free(s->small);
        s->small = NULL;
        s->s.why = NULL;
    }
    return status;
}

/* Second secants of the other sign, of numbers that have none. Those that a fit has derivatives of
 * stay as they are. */
static stein_status other_sides(diag *d, diag__suspect **list, int n, stein_err *err)
{
    stein_status status = STEIN_OK;
    int left = 0;
    for (int i = 0; status == STEIN_OK && i < n; i++) {
        diag__suspect *s = list[i];
        if (s->s.why == NULL && s->s.candidate.effect->both_signs && diag__number_of(d, s) < 0) {
            status = make_column(&s->small, &d->p, err);
            s->small_step = -s->step;
            diag__swap_secants(s);
            list[left++] = s;
        }
    }
    status = status == STEIN_OK ? secants(d, &d->p, list, left, err) : status;
    for (int i = 0; i < left; i++) {
        diag__swap_secants(list[i]);
        if (list[i]->s.why != NULL) { // one side will do
            free(list[i]->small);
            list[i]->small = NULL;
            list[i]->s.why = NULL;
        }
    }
    return status;
}

/* ---- who is asked ---- */

stein_status diag__read_again(const lab_dataset *set, const lab_model *model, lab_dataset **to,
                              stein_err *err)
{
    lab_data_options options = lab_data_options_default(lab_equations(model));
    const char **file = malloc(sizeof *file * (size_t)(set->n + 1));
    if (file == NULL) {
        return lab__no_memory(err);
    }
    for (int i = 0; i < set->n; i++) {
        file[i] = set->stroke[i]->file;
    }
    stein_status status = set->n > 0 ? lab_dataset_open(to, file, set->n, &options, err) : STEIN_OK;
    free(file);
    return status;
}

/* the accepted causes in the mechanism with a part of its own */
static stein_status bind_accepted(const diag *d, diag__suspect *s, stein_err *err)
{
    stein_status status = STEIN_OK;
    s->beside = malloc(sizeof *s->beside * FIT__ACCEPTED);
    if (s->beside == NULL) {
        return lab__no_memory(err);
    }
    for (int i = 0; status == STEIN_OK && i < d->naccepted; i++) {
        s->beside[i] = d->accepted[i];
        status = lab_candidate_bind(&s->beside[i], s->model, err);
    }
    return status;
}

/* the mechanism with the part, beside all that it has, and the strokes in it */
static stein_status open_part(diag *d, diag__suspect *s, stein_err *err)
{
    stein_err why = {STEIN_OK, ""};
    stein_status status = lab__candidate_open_in(&s->s.candidate, &s->model, d->model, d->file,
                                                 d->def->options, &why);
    status = status == STEIN_OK ? bind_accepted(d, s, &why) : status;
    status =
        status == STEIN_OK ? diag__read_again(d->fit_data, s->model, &s->fit_data, &why) : status;
    status =
        status == STEIN_OK ? diag__read_again(d->held_data, s->model, &s->held_data, &why) : status;
    if (status == STEIN_OK) {
        s->fit = calloc(1, sizeof *s->fit);
        status = s->fit != NULL ? fit__problem_make_with(s->fit, s->model, s->fit_data, &d->fit_def,
                                                         s->beside, d->naccepted, &why)
                                : STEIN_ENOMEM;
    }
    if (status == STEIN_ENOMEM) {
        return lab__no_memory(err);
    }
    if (status == STEIN_OK && s->fit->nu == d->p.nu) {
        s->fit->tolerance = d->p.tolerance;
        return STEIN_OK;
    }
    s->never = "its part cannot be added";
    if (d->def->report != NULL) {
        char *line =
            lab__text("%s at %s: %s", s->s.candidate.effect->kind, s->s.candidate.place,
                      why.msg[0] != '\0' ? why.msg : "its strokes would begin in other ways");
        if (line != NULL) {
            d->def->report(d->def->ctx, line);
        }
        free(line);
    }
    return STEIN_OK;
}

/* ---- the list ---- */

stein_status diag__suspects(diag *d, stein_err *err)
{
    lab_candidate *list = NULL;
    stein_status status = diag__list(d, &list, err);
    if (status != STEIN_OK) {
        return status;
    }
    d->suspect = calloc((size_t)d->n + 1, sizeof *d->suspect);
    if (d->suspect == NULL) {
        free(list);
        return lab__no_memory(err);
    }
    for (int i = 0; status == STEIN_OK && i < d->n; i++) {
        diag__suspect *s = &d->suspect[i];
        s->s = (lab_suspect){.candidate = list[i],
                             .score = NAN,
                             .gain = NAN,
                             .held_out = NAN,
                             .chi2_dof = NAN,
                             .own_ratio = NAN,
                             .own_lo = NAN,
                             .own_hi = NAN};
        s->never = diag__untestable(d, &list[i]);
        s->objective = s->swap = s->near = s->stuck = s->unheeded = INFINITY;
        s->early = NAN;
        if (s->never == NULL && list[i].effect->needs != NULL) {
            status = open_part(d, s, err);
        }
        s->s.why = s->never;
    }
    free(list);
    return status;
}

stein_status diag__changes(diag *d, stein_err *err)
{
    diag__suspect **base = malloc(sizeof *base * (size_t)(d->n + 1));
    int nbase = 0;
    for (int i = 0; base != NULL && i < d->n; i++) {
        diag__suspect *s = &d->suspect[i];
        s->s.why = s->never;
        s->s.score = NAN;
        if (s->never == NULL && s->fit == NULL && (d->p.given == NULL || s->promising)) {
            base[nbase++] = s;
        }
    }
    for (int i = 0; i < nbase; i++) {
        free(base[i]->small);
        base[i]->small = NULL;
        base[i]->step = fabs(base[i]->step);
    }
    stein_status status =
        base != NULL ? change_all(d, &d->p, base, nbase, err) : lab__no_memory(err);
    if (status == STEIN_OK && isfinite(d->p.horizon)) {
        nbase = 0;
        for (int i = 0; i < d->n; i++) {
            if (d->suspect[i].never == NULL && d->suspect[i].fit == NULL) {
                base[nbase++] = &d->suspect[i];
            }
        }
        status = other_sides(d, base, nbase, err);
    }
    free(base);
    for (int i = 0; status == STEIN_OK && i < d->n; i++) {
        diag__suspect *s = &d->suspect[i];
        if (s->fit != NULL && s->never == NULL && d->p.given == NULL) {
            s->fit->horizon = d->p.horizon;
            status = change_part(d, s, err);
        }
        if (d->p.given == NULL || (s->promising && s->fit == NULL)) {
            s->unseen = s->s.why; // s.why is written again by who ranks and fits
        }
    }
    return status;
}

void diag__suspects_free(diag *d)
{
    for (int i = 0; d->suspect != NULL && i < d->n; i++) {
        diag__suspect *s = &d->suspect[i];
        if (s->fit != NULL) {
            fit__problem_free(s->fit);
        }
        free(s->fit);
        lab_dataset_close(s->fit_data);
        lab_dataset_close(s->held_data);
        lab_close(s->model);
        free(s->beside);
        free(s->G);
        free(s->small);
        free(s->x);
        free(s->start);
        free(s->early_G);
        free(s->led);
        free(s->begins);
        free(s->settled);
    }
    free(d->suspect);
}
