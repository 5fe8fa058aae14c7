/* SPDX-License-Identifier: GPL-3.0-or-later
 * curve_site.c - where an unknown law could act, and the states that the records visit there.
 *
 * The n points of a curve are quantiles of a distribution g, the mean of two: the visited states,
 * and the uniform distribution over their range,
 *
 *      g(x) = 1/2 (x - lo)/(hi - lo) + 1/2 share of visits below x,     g(x_k) = k/(n - 1)
 *
 * So speeds near 0, where friction changes its sign, have as many points as the free swing. A force
 * over depth begins at 0: an open contact does not push.
 */
#include <gsl/gsl_sort.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "curve.h"

enum { MOST_VISITS = 4096, FEWEST_VISITS = 40, FEWEST_POINTS = 7 };
static const double nearest = 0.25; /* of the even distance */

const char *diag__site_word(stein_table_kind kind, const stein_model *m, int index)
{
    return kind <= STEIN_TABLE_SPEED ? "joint" : index < m->ncontact ? "contact" : "notch";
}

const char *diag__site_of(stein_table_kind kind)
{
    static const char *const word[] = {"position", "speed", "depth", "rate"};
    return word[kind];
}

const char *diag__site_what(const diag__site *s)
{
    return s->kind == STEIN_TABLE_RATE                 ? "factor"
           : s->kind == STEIN_TABLE_DEPTH || s->slides ? "force"
                                                       : "torque";
}

const char *diag__site_at_unit(const diag__site *s)
{
    static const char *const turns[] = {"rad", "rad/s", "m", "m/s"};
    static const char *const slides[] = {"m", "m/s", "m", "m/s"};
    return (s->slides ? slides : turns)[s->kind];
}

const char *diag__site_unit(const diag__site *s)
{
    return s->kind == STEIN_TABLE_RATE                 ? "1"
           : s->kind == STEIN_TABLE_DEPTH || s->slides ? "N"
                                                       : "N m";
}

/* ---- visits ---- */

/* values of one state in one stroke: every stride-th */
typedef struct visits {
    double v[MOST_VISITS];
    int n, stride, skip;
} visits;

typedef struct job {
    const fit__problem *p;
    const double *x; /* all unknowns */
    const stein_model *m;
    int nstate;
    visits *seen; /* [nstroke*nstate]: joints' positions, speeds, surfaces' depths, rates */
} job;

typedef struct watcher {
    job *j;
    const stein_sim *sim;
    visits *seen; /* of the stroke */
} watcher;

static void visit(visits *s, double value)
{
    if (s->skip++ % s->stride != 0) {
        return;
    }
    if (s->n == MOST_VISITS) {
        for (int i = 0; i < MOST_VISITS / 2; i++) {
            s->v[i] = s->v[2 * i];
        }
        s->n = MOST_VISITS / 2;
        s->stride *= 2;
    }
    s->v[s->n++] = value;
}

static void touch(watcher *w)
{
    const stein_model *m = w->j->m;
    double x, xdot;
    for (int i = 0; i < m->ncontact + m->nnotch; i++) {
        if (stein_deformation(w->sim, i, &x, &xdot)) {
            visit(&w->seen[2 * m->nq + 2 * i], x);
            visit(&w->seen[2 * m->nq + 2 * i + 1], xdot);
        }
    }
}

static void watch(void *ctx, stein_sim *sim, int i)
{
    watcher *w = ctx;
    const double *q = stein_q(sim), *qd = stein_qd(sim);
    (void)i;
    for (int k = 0; k < w->j->m->nq; k++) {
        visit(&w->seen[2 * k], q[k]);
        visit(&w->seen[2 * k + 1], qd[k]);
    }
    touch(w);
}

static void one_stroke(void *ctx, fit__bench *b, int stroke)
{
    job *j = ctx;
    const fit__problem *p = j->p;
    const fit__stroke *s = &p->stroke[stroke];
    watcher w = {j, b->sim, j->seen + (size_t)stroke * (size_t)j->nstate};
    double *y = malloc(sizeof *y * ((size_t)s->nch * (size_t)s->n + 1));
    if (y != NULL) {
        b->watch = watch;
        b->watch_ctx = &w;
        fit__simulate(p, b, stroke, j->x, y, NULL);
        b->watch = NULL;
    }
    free(y);
}

/* ---- points ---- */

/* all visits of a state, sorted. @return how many */
static int gather(const job *j, int state, double *to)
{
    int n = 0;
    for (int s = 0; s < j->p->nstroke; s++) {
        const visits *v = &j->seen[(size_t)s * (size_t)j->nstate + (size_t)state];
        memcpy(to + n, v->v, sizeof *to * (size_t)v->n);
        n += v->n;
    }
    gsl_sort(to, 1, (size_t)n);
    return n;
}

/* the smallest x with g(x) >= want */
static double place_of(const double *v, int n, double lo, double hi, double want)
{
    double a = lo, b = hi;
    for (int i = 0; i < 60; i++) {
        double x = 0.5 * (a + b);
        int below = 0, above = n;
        while (above > below) {
            int middle = (below + above) / 2;
            if (v[middle] <= x) {
                below = middle + 1;
            } else {
                above = middle;
            }
        }
        double g = 0.5 * (x - lo) / (hi - lo) + 0.5 * (double)below / n;
        if (g < want) {
            a = x;
        } else {
            b = x;
        }
    }
    return b;
}

/* few digits are enough for a point */
static double rounded(double x, double range)
{
    double digits = pow(10.0, 4.0 - floor(log10(range)));
    return round(x * digits) / digits;
}

static void count(diag__site *s, const double *v, int n)
{
    memset(s->seen, 0, sizeof s->seen);
    for (int i = 0; i < n; i++) {
        int best = 0;
        for (int k = 1; k < s->n; k++) {
            best = fabs(v[i] - s->at[k]) < fabs(v[i] - s->at[best]) ? k : best;
        }
        s->seen[best]++;
    }
}

/* @param most  points, by the samples that there are
 * @return 0, or -1 when the strokes visit too little of it */
static int place_points(diag__site *s, const double *v, int n, int most)
{
    if (n < FEWEST_VISITS) {
        return -1;
    }
    double lo = s->pinned ? 0.0 : v[0], hi = v[n - 1];
    if (!(hi > lo)) {
        return -1;
    }
    int points = s->kind <= STEIN_TABLE_SPEED ? CURVE_POINTS : CURVE_CONTACT_POINTS;
    s->n = most < points ? most : points;
    double least = nearest * (hi - lo) / (s->n - 1);
    s->at[0] = lo;
    s->at[s->n - 1] = hi;
    for (int k = 1; k < s->n - 1; k++) {
        double x = place_of(v, n, lo, hi, (double)k / (s->n - 1));
        s->at[k] = fmin(fmax(x, s->at[k - 1] + least), hi - least * (s->n - 1 - k));
    }
    for (int k = 0; k < s->n; k++) {
        s->at[k] = rounded(s->at[k], hi - lo);
    }
    count(s, v, n);
    return 0;
}

/* ---- the list ---- */

static int is_taken(const stein_model *m, const char *name)
{
    for (int i = 0; i < m->ntable; i++) {
        if (strcmp(m->tables[i].name, name) == 0) {
            return 1;
        }
    }
    return 0;
}

static diag__site new_site(const stein_model *m, stein_table_kind kind, int index)
{
    diag__site s = {.kind = kind, .index = index, .pinned = kind == STEIN_TABLE_DEPTH};
    const char *place = kind <= STEIN_TABLE_SPEED ? m->bodies[index].name
                        : index < m->ncontact     ? m->contacts[index].name
                                                  : m->notches[index - m->ncontact].name;
    snprintf(s.place, sizeof s.place, "%s", place);
    s.slides = kind <= STEIN_TABLE_SPEED && m->bodies[index].type == 'T';
    for (int k = 1; k < 100; k++) {
        char name[3 * MECH_NAME];
        snprintf(name, sizeof name, "%.16s_%s_law", place, diag__site_of(kind));
        size_t end = strlen(name);
        if (k > 1) {
            snprintf(name + end, sizeof name - end, "%d", k);
        }
        snprintf(s.table, sizeof s.table, "%.32s", name);
        if (!is_taken(m, s.table)) {
            break;
        }
    }
    return s;
}

static int is_driven(const fit__problem *p, int joint)
{
    const stein_model *m = lab_equations(p->model);
    const fit__stroke *s = &p->stroke[0];
    for (int k = 0; k < s->nsignal; k++) {
        const stein_input *input = &m->inputs[s->signal[k].input];
        if (input->kind == STEIN_INPUT_MOTION && input->index == joint) {
            return 1;
        }
    }
    return 0;
}

static stein_status look(job *j, stein_err *err)
{
    size_t n = (size_t)j->p->nstroke * (size_t)j->nstate;
    j->seen = calloc(n + 1, sizeof *j->seen);
    if (j->seen == NULL) {
        return lab__no_memory(err);
    }
    for (size_t i = 0; i < n; i++) {
        j->seen[i].stride = 1;
    }
    return fit__parallel(j->p, j->p->nstroke, one_stroke, j, err);
}

stein_status diag__sites(const fit__problem *of, const double *x, diag__site **list, int *n,
                         stein_err *err)
{
    fit__problem p = *of;
    const stein_model *m = lab_equations(p.model);
    p.gain = diag__rung[0];
    job j = {.p = &p, .x = x, .m = m, .nstate = 2 * (m->nq + m->ncontact + m->nnotch)};
    size_t most = (size_t)p.nstroke * MOST_VISITS;
    int points = p.samples / (2 * j.nstate); // all curves stand in one problem
    double *v = malloc(sizeof *v * (most + 1));
    diag__site *site = calloc((size_t)j.nstate + 1, sizeof *site);
    stein_status status = v != NULL && site != NULL ? look(&j, err) : lab__no_memory(err);
    *n = 0;
    for (int state = 0; status == STEIN_OK && state < j.nstate; state++) {
        int joint = state < 2 * m->nq, index = joint ? state / 2 : state / 2 - m->nq;
        int kind = (joint ? STEIN_TABLE_POSITION : STEIN_TABLE_DEPTH) + state % 2;
        if (joint && (index == m->load.body || is_driven(&p, index))) {
            continue;
        }
        site[*n] = new_site(m, (stein_table_kind)kind, index);
        *n += place_points(&site[*n], v, gather(&j, state, v),
                           points > FEWEST_POINTS ? points : FEWEST_POINTS) == 0;
    }
    free(v);
    free(j.seen);
    if (status != STEIN_OK) {
        free(site);
        return status;
    }
    *list = site;
    return STEIN_OK;
}
