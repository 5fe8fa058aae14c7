/* SPDX-License-Identifier: GPL-3.0-or-later
 * reference.c - reference of experiments: the middle of the range of the present strokes, their
 * moving joints and ranges, and the possible channels.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "planning.h"

enum { LOOKS = 400 };
static const double marker_arm = 0.1;   /* of an angle seen as a place [m] */
static const double force_error = 0.01; /* of a force sensor, of the largest force */
static const double nearly_all = 0.9;   /* of a travel, for its time */
static const double both_ways = 0.2;    /* of the larger way; less is noise of the records */

double plan__rounded(double value)
{
    char text[LAB_NUMBER];
    snprintf(text, sizeof text, "%.3g", value);
    return strtod(text, NULL);
}

const lab_used *plan__used(const lab_used *list, int n, const char *name)
{
    for (int i = 0; i < n; i++) {
        if (strcmp(list[i].name, name) == 0) {
            return &list[i];
        }
    }
    return NULL;
}

/* @return e->nset: it leaves that number */
static int find_set(const lab_experiment *e, const char *name)
{
    int i = 0;
    while (i < e->nset && strcmp(e->set[i].name, name) != 0) {
        i++;
    }
    return i;
}

const lab_planned_set *plan__set_of(const lab_experiment *e, const char *name)
{
    int i = find_set(e, name);
    return i < e->nset ? &e->set[i] : NULL;
}

int plan__set(lab_experiment *e, const char *name, const char *unit, double value)
{
    int i = find_set(e, name);
    if (i < e->nset) {
        e->set[i].value = value;
        return 1;
    }
    if (e->nset == LAB_PLAN_SETS) {
        return 0;
    }
    lab_planned_set *s = &e->set[e->nset++];
    snprintf(s->name, sizeof s->name, "%s", name);
    s->unit = unit;
    s->value = value;
    return 1;
}

/* the present strokes, in the middle of their settings and drives */
static void middle(plan__reference *b)
{
    const lab_conditions *c = &b->d->conditions;
    lab_experiment *e = &b->base;
    *e = (lab_experiment){.faster = 1, .feasible = 1, .name = "the same again"};
    snprintf(e->why, sizeof e->why, "a record like those so far, to compare with");
    for (int i = 0; i < c->nsetting; i++) {
        double lo = c->setting[i].lo, hi = c->setting[i].hi;
        int both = lo < 0.0 && hi > 0.0 && strstr(c->setting[i].name, ".initial.") != NULL;
        double value = both      ? plan__rounded(-lo > hi ? lo : hi) // between them lies rest
                       : lo < hi ? plan__rounded(0.5 * (lo + hi))
                                 : lo;
        plan__set(e, c->setting[i].name, c->setting[i].unit, value);
    }
    int k = c->ninput > 0 ? stein_find_input(b->m, c->input[0].name) : -1;
    if (k >= 0) {
        const stein_input *input = &b->m->inputs[k];
        double lo = c->input[0].lo, hi = c->input[0].hi;
        int both = input->kind != STEIN_INPUT_MOTION && fmin(-lo, hi) > both_ways * fmax(-lo, hi);
        snprintf(e->input, sizeof e->input, "%s", input->name);
        e->shape = both ? LAB_SHAPE_SWING : LAB_SHAPE_RISE;
        e->zero = both || input->kind != STEIN_INPUT_MOTION ? 0.0 : lo;
        e->size = both || input->kind != STEIN_INPUT_MOTION ? fmax(fabs(lo), fabs(hi)) : hi - lo;
        e->time = 0.25 * c->until;
    }
}

void plan__signal(void *ctx, double t, double u[3])
{
    const lab_experiment *e = ctx;
    double h = 1e-3 * e->time, y[3];
    for (int i = 0; i < 3; i++) {
        y[i] = e->zero + e->size * lab_shape_at(e->shape, e->time, t + (i - 1) * h);
    }
    u[0] = y[1];
    u[1] = (y[2] - y[0]) / (2.0 * h);
    u[2] = (y[2] - 2.0 * y[1] + y[0]) / (h * h);
}

/* the cause's parameters, in the model it is simulated in */
static void parameters(const plan__model *side, const lab_experiment *e, int with_effect, double *p)
{
    const stein_model *m = lab_equations(side->model);
    const lab_posterior *q = &side->s->posterior;
    memcpy(p, lab_parameters(side->model), sizeof *p * (size_t)m->np);
    for (int i = 0; i < q->n; i++) {
        int k = stein_find_param(m, q->number[i].name);
        if (k >= 0) {
            p[k] = q->number[i].value;
        }
    }
    for (int i = 0; with_effect && i < e->nset; i++) {
        int k = stein_find_param(m, e->set[i].name);
        if (k >= 0) {
            p[k] = e->set[i].value;
        }
    }
    if (with_effect) {
        plan__model_apply(side, -1, 0.0, p);
    }
}

typedef struct look {
    plan__reference *b;
    const stein_model *m; /* simulated */
    int *joint;           /* [nq of the file] in it, -1: none */
    double *range;        /* [nchannel of the file] largest reading */
    int *channel;         /* in it */
    int *contact;         /* [ncontact of the file] in it */
} look;

static void take(look *l, stein_sim *sim, int first)
{
    plan__reference *b = l->b;
    for (int j = 0; j < b->m->nq; j++) {
        double q = l->joint[j] >= 0 ? stein_q(sim)[l->joint[j]] : 0.0;
        b->rest[j] = first ? q : b->rest[j];
        b->low[j] = first ? q : fmin(b->low[j], q);
        b->high[j] = first ? q : fmax(b->high[j], q);
        b->fast[j] = l->joint[j] >= 0 ? fmax(b->fast[j], fabs(stein_qd(sim)[l->joint[j]])) : 0.0;
    }
    for (int k = 0; k < b->m->ncontact; k++) {
        double depth = 0.0, speed;
        if (l->contact[k] >= 0) {
            stein_deformation(sim, l->contact[k], &depth, &speed);
        }
        b->deep[k] = fmax(b->deep[k], depth);
    }
    for (int k = 0; k < b->m->nchannel; k++) {
        if (l->channel[k] >= 0) {
            l->range[k] = fmax(l->range[k], fabs(stein_read(sim, l->channel[k])));
        }
    }
}

/* farthest way from rest, with its sign */
double plan__travel(const plan__reference *b, int j)
{
    double up = b->high[j] - b->rest[j], down = b->low[j] - b->rest[j];
    return up >= -down ? up : down;
}

/* simulate the base once (twice: what it reaches, then when) */
static stein_status run_base(look *l, stein_sim *sim, const double *p, stein_err *err)
{
    plan__reference *b = l->b;
    double until = b->d->conditions.until;
    stein_status status = STEIN_OK;
    for (int pass = 0; status == STEIN_OK && pass < 2; pass++) {
        status = stein_try_all(sim, p, err);
        status = status == STEIN_OK ? stein_reset(sim, err) : status;
        if (status == STEIN_OK && pass == 0) {
            take(l, sim, 1);
        }
        for (int i = 1; status == STEIN_OK && i <= LOOKS; i++) {
            status = stein_run(sim, until * i / LOOKS, err);
            if (pass == 0 && status == STEIN_OK) {
                take(l, sim, 0);
            }
            for (int j = 0; pass == 1 && status == STEIN_OK && j < b->m->nq; j++) {
                double way = plan__travel(b, j);
                double q = l->joint[j] >= 0 ? stein_q(sim)[l->joint[j]] - b->rest[j] : 0.0;
                if (!isfinite(b->when[j]) && q / way >= nearly_all) {
                    b->when[j] = until * i / LOOKS;
                }
            }
        }
    }
    return status;
}

/* A force can be weighed at a support on the ground: at a stop, at a string. Between two
 * things that move there is no room for a load cell. */
static int stands(const stein_model *m, int contact)
{
    const stein_spot *spot = &m->spots[m->contacts[contact].first_spot];
    return spot->side[0].frame < 0 || spot->side[1].frame < 0;
}

static int could_see(const stein_model *m, const stein_channel *c)
{
    if (stein_reads_place((int)c->read)) {
        return 1;
    }
    return c->read == STEIN_READ_FORCE && stands(m, c->index) ? 2 : 0;
}

/* channels that are or could be measured */
static void outputs(plan__reference *b, const double *range)
{
    const lab_conditions *c = &b->d->conditions;
    double length = INFINITY; // noise of a place
    for (int i = 0; i < c->nchannel; i++) {
        double by = strcmp(c->channel[i].unit, "rad") == 0 ? marker_arm
                    : strcmp(c->channel[i].unit, "m") == 0 ? 1.0
                                                           : (double)INFINITY;
        length = fmin(length, c->channel[i].noise * by);
    }
    for (int measured = 1; measured >= 0; measured--) {
        for (int k = 0; k < b->m->nchannel && b->noutput < PLAN_OUTPUTS; k++) {
            const stein_channel *channel = &b->m->channels[k];
            const lab_used *u = plan__used(c->channel, c->nchannel, channel->name);
            int angle = strcmp(channel->unit, "rad") == 0, kind = could_see(b->m, channel);
            double noise = u != NULL   ? u->noise
                           : kind == 1 ? length / (angle ? marker_arm : 1.0)
                           : kind == 2 ? force_error * range[k]
                                       : (double)NAN;
            if ((u != NULL) == measured && isfinite(noise) && noise > 0.0) {
                plan__output *output = &b->output[b->noutput++];
                snprintf(output->name, sizeof output->name, "%s", channel->name);
                output->noise = noise;
                output->reach = range[k];
                output->measured = measured;
            }
        }
    }
}

stein_status plan__reference_make(plan__reference *b, const plan__model *cause,
                                  const lab_diagnosis *d, const stein_model *m,
                                  const lab_plan_def *def, stein_err *err)
{
    const stein_model *own = lab_equations(cause->model);
    size_t nq = (size_t)m->nq, nc = (size_t)m->nchannel, nk = (size_t)m->ncontact;
    *b = (plan__reference){.d = d, .m = m, .def = def};
    b->p = calloc((size_t)m->np + 1, sizeof *b->p);
    b->low = calloc(5 * nq + nk + 1, sizeof *b->low);
    look l = {.b = b,
              .m = own,
              .joint = calloc(nq + 1, sizeof *l.joint),
              .range = calloc(nc + 1, sizeof *l.range),
              .channel = calloc(nc + 1, sizeof *l.channel),
              .contact = calloc(nk + 1, sizeof *l.contact)};
    double *p = calloc((size_t)own->np + 1, sizeof *p);
    stein_sim *sim = NULL;
    int memory = b->p && b->low && l.joint && l.range && l.channel && l.contact && p;
    stein_status status = memory ? lab_sim(cause->model, NULL, &sim, err) : lab__no_memory(err);
    if (memory && status == STEIN_OK) {
        b->high = b->low + nq;
        b->rest = b->high + nq;
        b->when = b->rest + nq;
        b->fast = b->when + nq;
        b->deep = b->fast + nq;
        for (int j = 0; j < m->nq; j++) {
            l.joint[j] = stein_find_body(own, m->bodies[j].name);
            b->when[j] = INFINITY;
        }
        for (int k = 0; k < m->ncontact; k++) {
            l.contact[k] = stein_find_contact(own, m->contacts[k].name);
        }
        for (int k = 0; k < m->nchannel; k++) {
            l.channel[k] = stein_find_channel(own, m->channels[k].name);
        }
        middle(b);
        parameters(cause, &b->base, 0, p);
        for (int i = 0; i < m->np; i++) {
            int k = stein_find_param(own, m->params[i].name);
            b->p[i] = k >= 0 ? p[k] : m->params[i].value;
        }
        parameters(cause, &b->base, 1, p);
        status = b->base.input[0] != '\0'
                     ? stein_drive(sim, b->base.input, plan__signal, &b->base, err)
                     : STEIN_OK;
        status = status == STEIN_OK ? run_base(&l, sim, p, err) : status;
        outputs(b, l.range);
    }
    stein_sim_destroy(sim);
    free(l.joint);
    free(l.range);
    free(l.channel);
    free(l.contact);
    free(p);
    return status;
}

void plan__reference_free(plan__reference *b)
{
    free(b->p);
    free(b->low);
}
