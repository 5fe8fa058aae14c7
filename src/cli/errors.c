/* SPDX-License-Identifier: GPL-3.0-or-later
 * errors.c - the errors of a run (errors.h).
 */
#include "errors.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>

static const char *const unit[LAB_KINDS] = {"m", "rad"};
/* A contact that begins so often in a run, and so often in one step on average, chatters. */
static const int often = 1000;
static const double steps_between = 20.0;

static int is_doubtful(const lab__errors *e)
{
    return !(e->made_share <= LAB_DOUBTFUL) || !(e->energy_share <= LAB_DOUBTFUL);
}

static int is_jumping(const cli_errors *c)
{
    return c->drive != NULL && lab_drive_doubt(c->drive) != NULL;
}

/* A large deviation is the motion's own where the steps make no errors that count. */
static int is_wrong(const cli_errors *c)
{
    const lab__errors *e = lab__accuracy_errors(c->trust);
    return is_jumping(c) || !e->known || !(e->made_share <= LAB_WRONG) ||
           !(e->energy_share <= LAB_WRONG) || (is_doubtful(e) && e->deviation_share > LAB_WRONG);
}

/* has the mechanism joints of this kind that moved? */
static int has_kind(const lab__errors *e, int kind)
{
    return e->range[kind] > 0.0;
}

/* how many steps were implicit, and why */
static void stiffness_line(FILE *f, const cli_errors *c)
{
    const stein_step_counts *n = &c->steps;
    int always = c->integrator == STEIN_IMPLICIT;
    if (n->implicit > 0) {
        fprintf(f, "  %lld of %lld steps implicit", n->implicit, n->taken);
    } else if (n->refused != NULL) {
        fprintf(f, "  no step implicit: %s", n->refused);
    } else {
        return;
    }
    if (always || !(n->rate > 0.0)) {
        fprintf(f, "\n");
    } else {
        fprintf(f, "%s from %.3g s on a motion that decays at %.1e 1/s limited the explicit ones\n",
                n->implicit > 0 ? ":" : ",", n->first, n->rate);
    }
}

void cli_errors_line(FILE *f, const cli_errors *c)
{
    stiffness_line(f, c);
    const lab__errors *e = lab__accuracy_errors(c->trust);
    const char *before = "  error of positions ";
    for (int k = 0; e->known && k < LAB_KINDS; k++) {
        if (has_kind(e, k)) {
            fprintf(f, "%s%.1g %s", before, e->deviation[k], unit[k]);
            before = ", ";
        }
    }
    if (!e->known) {
        fprintf(f, "%snot known", before);
    } else if (!has_kind(e, LAB_SLIDES) && !has_kind(e, LAB_TURNS)) {
        fprintf(f, "%s0", before);
    }
    fprintf(f, "; energy unexplained %.1g of %.3g J\n", fabs(e->energy.unexplained),
            e->energy.scale);
}

/* ---- JSON ---- */

static void put_kinds(lab__json *out, const char *name, const double *value)
{
    lab__json_open(out, name, '{');
    for (int k = 0; k < LAB_KINDS; k++) {
        lab__json_real(out, unit[k], value[k]);
    }
    lab__json_close(out);
}

static void put_work(lab__json *out, const cli_errors *c, stein_work_kind kind, const char *what,
                     int index, const char *name)
{
    double work = lab__accuracy_work(c->trust, kind, index);
    if (work != 0.0) {
        char *key = lab__text("%s %s", name, what);
        if (key != NULL) {
            lab__json_real(out, key, work);
            free(key);
        }
    }
}

static void put_works(lab__json *out, const cli_errors *c)
{
    const stein_model *m = c->model;
    for (int i = 0; i < m->ninput; i++) {
        put_work(out, c, STEIN_WORK_INPUT, "input", i, m->inputs[i].name);
    }
    for (int i = 0; i < m->nq; i++) {
        put_work(out, c, STEIN_WORK_JOINT, "joint", i, m->bodies[i].name);
    }
    for (int i = 0; i < m->ncontact + m->nnotch; i++) {
        const char *name = i < m->ncontact ? m->contacts[i].name : m->notches[i - m->ncontact].name;
        put_work(out, c, STEIN_WORK_NORMAL, "normal", i, name);
        put_work(out, c, STEIN_WORK_FRICTION, "friction", i, name);
    }
    for (int i = 0; i < m->nlink; i++) {
        put_work(out, c, STEIN_WORK_LINK, "link", i, m->links[i].name);
    }
}

static void put_steps(lab__json *out, const cli_errors *c)
{
    const stein_step_counts *n = &c->steps;
    lab__json_open(out, "integration", '{');
    lab__json_int(out, "steps", (int)fmin((double)n->taken, INT_MAX));
    lab__json_int(out, "implicit", (int)fmin((double)n->implicit, INT_MAX));
    if (n->rate > 0.0) {
        lab__json_real(out, "stiff_from", n->first);
        lab__json_real(out, "rate", n->rate);
    } else {
        lab__json_null(out, "stiff_from");
        lab__json_null(out, "rate");
    }
    if (n->refused != NULL) {
        lab__json_text(out, "refused", n->refused);
    } else {
        lab__json_null(out, "refused");
    }
    lab__json_int(out, "singular", (int)fmin((double)c->passes, INT_MAX));
    lab__json_close(out);
}

void cli_errors_json(lab__json *out, const cli_errors *c)
{
    const lab__errors *e = lab__accuracy_errors(c->trust);
    const stein_energy_total *s = &e->energy;
    if (lab__is_controlled(c->integrator)) {
        put_steps(out, c);
    }
    lab__json_open(out, "errors", '{');
    put_kinds(out, "deviation", e->deviation);
    put_kinds(out, "steps", e->made);
    lab__json_real(out, "deviation_share", e->deviation_share);
    lab__json_real(out, "steps_share", e->made_share);
    lab__json_real(out, "energy_share", e->energy_share);
    if (isnan(e->lost)) {
        lab__json_null(out, "lost");
    } else {
        lab__json_real(out, "lost", e->lost);
    }
    lab__json_close(out);
    lab__json_open(out, "energy", '{');
    lab__json_real(out, "begin", s->begin);
    lab__json_real(out, "end", s->now);
    lab__json_real(out, "inputs", s->inputs);
    lab__json_real(out, "dissipated", s->dissipated);
    lab__json_real(out, "stored", s->stored);
    lab__json_real(out, "other", s->other);
    lab__json_real(out, "taken", s->taken);
    lab__json_real(out, "unexplained", s->unexplained);
    lab__json_real(out, "scale", s->scale);
    lab__json_open(out, "work", '{');
    put_works(out, c);
    lab__json_close(out);
    lab__json_close(out);
    lab__json_bool(out, "trusted", !is_wrong(c));
}

/* ---- warnings ---- */

static const char *contact_name(const stein_model *m, int k)
{
    return k < m->ncontact ? m->contacts[k].name : m->notches[k - m->ncontact].name;
}

static int is_stiff(const cli_errors *c)
{
    return !lab__is_controlled(c->integrator) && c->stiffest * c->dt > 1.0;
}

void cli_errors_gimbal(const cli_errors *c)
{
    const lab__errors *e = lab__accuracy_errors(c->trust);
    if (e->gimbal < 1.0) {
        fprintf(
            stderr,
            "stein: gimbal lock: the axes of hinges \"%s\" and \"%s\" are nearly parallel at "
            "%g s, where their speeds are without bound; another order of axes carries the body "
            "through\n",
            c->model->bodies[e->hinge[0]].name, c->model->bodies[e->hinge[1]].name, e->gimbal_time);
    }
}

/* more ways to move meet where a loop is singular */
static void warn_of_passes(const cli_errors *c)
{
    if (c->passes > 0) {
        fprintf(stderr,
                "stein: the loops are singular at %.6g s (%lld such positions are passed), where "
                "the motion may go on in more than one way; a small error there selects another\n",
                c->passed, c->passes);
    }
}

/* the steps are too coarse: how much, why, what helps */
static void warn_of_steps(const cli_errors *c, const lab__errors *e)
{
    if (is_stiff(c)) {
        fprintf(
            stderr,
            "stein: the step of %g s is too long: at %g s contact \"%s\" needs %.2g s or less\n",
            c->dt, c->stiff_time, contact_name(c->model, c->stiff_contact), 1.0 / c->stiffest);
    }
    cli_errors_gimbal(c);
    warn_of_passes(c);
    fprintf(stderr,
            "stein: %s: ", is_wrong(c) ? "do not trust the result" : "the result is not accurate");
    if (!e->known) {
        fprintf(stderr, "its error is not known, a run with a small tolerance failed\n");
        return;
    }
    fprintf(stderr,
            "errors of the steps add up to %.2g %% of the motion, %.2g %% of the energy is "
            "unexplained; ",
            100.0 * e->made_share, 100.0 * e->energy_share);
    if (lab__is_controlled(c->integrator)) {
        int other = c->integrator == STEIN_CONTROLLED && c->model->nrow == 0;
        fprintf(stderr, "use --tolerance %.0e%s\n", 0.01 * c->tolerance,
                other ? " or --integrator implicit" : "");
    } else {
        double half = 0.5 * c->dt, needed = is_stiff(c) ? 0.5 / c->stiffest : half;
        fprintf(stderr, "use --integrator controlled, or --dt %.1g\n", fmin(half, needed));
    }
}

static void warn_of_growth(const lab__errors *e)
{
    fprintf(
        stderr,
        "stein: positions are not determined after %.3g s: the motion amplifies small "
        "differences, errors of the steps of %.1g of its range have grown to %.1g; energies and "
        "averages may be used, positions not\n",
        e->lost, e->made_share, e->deviation_share);
}

static void warn_of_chatter(const cli_errors *c)
{
    fprintf(stderr,
            "stein: contact \"%s\" chatters: it began %d times, every %.2g s; give it damping "
            "(normal: {D: ..}), or friction a larger turning speed (vt)\n",
            contact_name(c->model, c->busiest), c->begins, c->until / c->begins);
}

int cli_errors_warn(const cli_errors *c)
{
    const lab__errors *e = lab__accuracy_errors(c->trust);
    if (is_jumping(c)) {
        fprintf(stderr, "stein: do not trust the result: %s\n", lab_drive_doubt(c->drive));
    } else if (is_wrong(c) || is_doubtful(e)) {
        warn_of_steps(c, e);
    } else if (e->deviation_share > LAB_WRONG) {
        cli_errors_gimbal(c);
        warn_of_passes(c);
        warn_of_growth(e);
    }
    if (c->begins > often && c->until / c->begins < steps_between * c->dt) {
        warn_of_chatter(c);
    }
    return is_wrong(c);
}
