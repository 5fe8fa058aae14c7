/* SPDX-License-Identifier: GPL-3.0-or-later
 * plan.c - from rivals to the experiment that separates them.
 *
 * Several causes are one hypothesis, and so is a rival with the causes beside it. The cause and
 * each rival predict every experiment (predict.c), and every pair of cause and rival has its odds
 * (expected_evidence.c). The value of an experiment is given by the rival that it separates least
 * from the cause: max-min.
 *
 *      worth = odds / ((4 + strokes) * beyond * left)
 *
 * To set up something else takes as long as four strokes. A check of an instrument counts as one.
 *
 * odds are those wanted, up to three times as much where one stroke settles it all even when it
 * goes badly; more is no better: numbers from the tail of the posterior can promise any odds.
 *
 * beyond: the farther a stroke goes from those so far, the more else may be wrong about it. A model
 * that explains strokes of 100 g need not explain a hammer that is twice as heavy.
 *
 * left: a rival may be true, and then it has to be separated from the others. An experiment that
 * separates only the cause from its k rivals, or the rivals from each other only with more than 12
 * strokes (an afternoon), decides one of k cases.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "functions.h"
#include "planning.h"

static const double plenty = 3.0; /* times the odds wanted, in logarithms */
static const double setup = 4.0;  /* strokes */
enum { MOST = 64, AT_ONCE = 3, BASES = 3, COMBINED = 10, FEW = 4, RIVALS_TOO = 12 };
enum { SIDES = 1 + LAB_PLAN_RIVALS, PAIRS = SIDES * (SIDES - 1) / 2 };

lab_plan_def lab_plan_def_default(void)
{
    return (lab_plan_def){.wanted = 100.0, .rivals = LAB_PLAN_RIVALS, .threads = 1};
}

typedef struct planner {
    const lab_diagnosis *d;
    const lab_plan_def *def;
    plan__model side[SIDES];
    int suspect[SIDES]; /* of the diagnosis */
    int nside;
    plan__reference reference;
    plan__pair pair[PAIRS]; /* of the present motion: cause and rivals, then rivals */
    int known;              /* pairs of the present motion are there */
    stein_err why;          /* why not */
} planner;

static int same_motion(const lab_experiment *a, const lab_experiment *b)
{
    int same = a->ncheck == 0 && b->ncheck == 0 && a->nset == b->nset &&
               strcmp(a->input, b->input) == 0 && a->shape == b->shape && a->zero == b->zero &&
               a->size == b->size && a->time == b->time && a->faster == b->faster;
    for (int i = 0; same && i < a->nset; i++) {
        const lab_planned_set *s = plan__set_of(b, a->set[i].name);
        same = s != NULL && s->value == a->set[i].value;
    }
    return same;
}

static void forget(planner *p)
{
    for (int k = 0; k < PAIRS; k++) {
        plan__pair_free(&p->pair[k]);
    }
    p->known = 0;
}

/* pairs of cause and rivals, and of rivals, for the motion of an experiment; p->known stays 0 when
 * one of them cannot be simulated. @return OK, ENOMEM */
static stein_status predict(planner *p, const lab_experiment *e, stein_err *err)
{
    plan__prediction view[SIDES];
    memset(view, 0, sizeof view);
    forget(p);
    p->why = (stein_err){STEIN_OK, ""};
    stein_status status = STEIN_OK;
    for (int k = 0; status == STEIN_OK && k < p->nside; k++) {
        status = e->ncheck > 0 ? plan__check_prediction(&view[k], &p->side[k], e, &p->why)
                               : plan__predict(&view[k], &p->reference, &p->side[k], e, 0, &p->why);
    }
    int n = 0;
    for (int i = 0; i < p->nside; i++) {
        for (int k = i + 1; status == STEIN_OK && k < p->nside; k++) {
            status = plan__pair_make(&p->pair[n++], &p->reference, &view[i], &view[k], &p->why);
        }
    }
    p->known = status == STEIN_OK;
    for (int k = 0; k < p->nside; k++) {
        plan__prediction_free(&view[k]);
    }
    return fit__forgive(status, err);
}

/* of two pairs: a is harder to separate than b, by the same experiment */
static int harder(const lab_experiment *a, const lab_experiment *b)
{
    int na = a->repeats > 0 ? a->repeats : MOST + 1, nb = b->repeats > 0 ? b->repeats : MOST + 1;
    return na != nb ? na > nb : a->repeats > 0 ? a->odds_worst < b->odds_worst : a->odds < b->odds;
}

static stein_status odds(planner *p, int pair, const unsigned char *use, int most,
                         lab_experiment *e, stein_err *err)
{
    return plan__odds(&p->pair[pair], use, 2.0 * stein__log_of(p->def->wanted), most, p->nside - 1,
                      e, err);
}

static stein_status judge(planner *p, lab_experiment *e, stein_err *err)
{
    unsigned char use[PLAN_OUTPUTS] = {0};
    stein_status status = STEIN_OK;
    lab_experiment worst = *e;
    if (!p->known) {
        e->feasible = 0;
        e->odds = e->odds_worst = NAN;
        snprintf(e->why, sizeof e->why, "%.*s", LAB_PLAN_TEXT - 1, p->why.msg);
        return STEIN_OK;
    }
    for (int c = 0; c < p->reference.noutput; c++) {
        use[c] = e->ncheck > 0 ? c == 0 // readings are one channel
                               : p->reference.output[c].measured ||
                                     strcmp(p->reference.output[c].name, e->channel) == 0;
    }
    for (int k = 0; status == STEIN_OK && k < p->nside - 1; k++) {
        lab_experiment one = *e;
        one.against = p->suspect[k + 1];
        status = odds(p, k, use, MOST, &one, err);
        worst = k == 0 || harder(&one, &worst) ? one : worst;
    }
    lab_experiment all = worst;
    int npair = p->nside * (p->nside - 1) / 2;
    all.all = all.repeats > 0 && all.repeats <= RIVALS_TOO;
    for (int k = p->nside - 1; status == STEIN_OK && all.all && k < npair; k++) {
        lab_experiment one = all;
        status = odds(p, k, use, RIVALS_TOO, &one, err);
        all = harder(&one, &all) ? one : all;
        all.all = all.repeats > 0;
    }
    *e = all.all ? all : worst;
    return status;
}

/* in units of the odds wanted; an experiment that needs too many strokes has a negative value,
 * lower with less information */
static double worth(const planner *p, const lab_experiment *e)
{
    double wanted = 2.0 * stein__log_of(p->def->wanted);
    double odds = e->repeats == 1 && e->all ? fmin(e->odds_worst / wanted, plenty) : 1.0;
    double strokes = setup + e->repeats * fmax(1.0, e->ncheck);
    return !e->feasible     ? -INFINITY
           : e->repeats > 0 ? odds / (strokes * e->beyond * (e->all ? 1 : p->nside - 1))
                            : -1.0 / (1.0 + fmax(e->odds, 0.0));
}

/* best first; equals keep their order */
static void sort(const planner *p, lab_plan *plan)
{
    for (int i = 1; i < plan->n; i++) {
        lab_experiment e = plan->experiment[i];
        double w = worth(p, &e);
        int k = i;
        for (; k > 0 && w > worth(p, &plan->experiment[k - 1]); k--) {
            plan->experiment[k] = plan->experiment[k - 1];
        }
        plan->experiment[k] = e;
    }
}

/* the experiments from `first` on, then all by their worth */
static stein_status judge_from(planner *p, lab_plan *plan, int first, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (int i = first; status == STEIN_OK && i < plan->n; i++) {
        lab_experiment *e = &plan->experiment[i];
        if (p->def->progress != NULL) {
            p->def->progress(p->def->ctx, (double)i / plan->n, "experiments");
        }
        if (i == first || !same_motion(e, &plan->experiment[i - 1])) {
            status = predict(p, e, err);
        }
        status = status == STEIN_OK ? judge(p, e, err) : status;
    }
    forget(p);
    sort(p, plan);
    return status;
}

static int is_planned(const lab_plan *plan, const lab_experiment *e)
{
    for (int i = 0; i < plan->n; i++) {
        const lab_experiment *o = &plan->experiment[i];
        if (same_motion(o, e) && strcmp(o->channel, e->channel) == 0) {
            return 1;
        }
    }
    return 0;
}

/* one of the best with each of the best single things [n], `most` of them, behind the others */
static void add_to(planner *p, lab_plan *plan, const lab_experiment *base,
                   const lab_experiment *one, int n, int most)
{
    for (int i = 0; i < n && most > 0; i++) {
        lab_experiment *e = &plan->experiment[plan->n];
        if (one[i].feasible && plan__together(e, base, &one[i], &p->reference.base) &&
            !is_planned(plan, e)) {
            plan->n++;
            most--;
        }
    }
}

static int one_tells(const lab_experiment *e)
{
    return e->all && e->repeats == 1;
}

/* The best ones with each of the next best things done as well, and the best of those once more:
 * a second change may enlarge the effect of the first one. Where one record separates,
 * no combination is needed. */
static stein_status combine(planner *p, lab_plan *plan, stein_err *err)
{
    stein_status status = STEIN_OK;
    int single = plan->n, quick = p->def->quick;
    int bases = quick ? 1 : BASES, levels = quick ? 1 : AT_ONCE - 1, most = quick ? FEW : COMBINED;
    if (single < 1 || one_tells(&plan->experiment[0])) {
        return STEIN_OK;
    }
    lab_experiment *one = malloc(sizeof *one * (size_t)single);
    if (one == NULL) {
        return lab__no_memory(err);
    }
    memcpy(one, plan->experiment, sizeof *one * (size_t)single);
    for (int k = 0, on = 1; status == STEIN_OK && on && k < levels; k++) {
        lab_experiment best[BASES];
        int n = plan->n, nbest = 0;
        size_t size = sizeof *one * (size_t)(n + bases * most);
        lab_experiment *e = realloc(plan->experiment, size);
        if (e == NULL) {
            status = lab__no_memory(err);
            break;
        }
        plan->experiment = e;
        for (int i = 0; nbest < bases && i < n; i++) {
            best[nbest] = e[i];
            nbest += e[i].ncheck == 0;
        }
        for (int i = 0; i < nbest; i++) {
            add_to(p, plan, &best[i], one, single, most);
        }
        status = judge_from(p, plan, n, err);
        on = nbest > 0 && worth(p, &best[0]) < worth(p, &plan->experiment[0]) &&
             !one_tells(&plan->experiment[0]);
    }
    free(one);
    return status;
}

/* Where one stroke is enough two are made: nine of ten would, one may be lost, and two show how
 * alike strokes are. */
static void make_twice(lab_plan *plan)
{
    for (int i = 0; i < plan->n; i++) {
        lab_experiment *e = &plan->experiment[i];
        e->repeats = e->ncheck == 0 && e->repeats == 1 ? 2 : e->repeats;
    }
}

/* the causes and the first rivals with known numbers, each with those beside it */
static stein_status open_sides(planner *p, lab_plan *plan, const char *file, const lab_model *model,
                               stein_err *err)
{
    const lab_diagnosis *d = p->d;
    if (d->ncause > 0 && d->nrival > 0 && d->suspect[0].posterior.n < 1) {
        return lab__fail(err, STEIN_EINVAL,
                         "the diagnosis (%s) does not have the numbers of its cause and their "
                         "uncertainty (\"posterior\"): diagnose again",
                         lab_verdict_text(d->verdict));
    }
    stein_status status = STEIN_OK;
    for (int i = 0; status == STEIN_OK && i < d->ncause + d->nrival; i++) {
        if (i > 0 && (i < d->ncause || d->suspect[i].posterior.n < 1)) {
            continue; // the first cause has the numbers of all, a rival those of its hypothesis
        }
        if (p->nside > p->def->rivals) {
            plan->left_out++;
            continue;
        }
        status =
            plan__model_open(&p->side[p->nside], &d->suspect[i], file, model, p->def->options, err);
        p->suspect[p->nside++] = i;
    }
    plan->nrival = p->nside - 1;
    return status;
}

static stein_status check(const lab_plan_def *def, const stein_model *m, stein_err *err)
{
    for (int i = 0; def->instrument != NULL && i < def->ninstrument; i++) {
        if (stein_find_channel(m, def->instrument[i]) < 0) {
            return lab__fail(err, STEIN_ENAME, "no output \"%s\" in %s", def->instrument[i],
                             m->name);
        }
    }
    const char *bad = def->threads < 1                                   ? "threads"
                      : !(def->wanted > 1.0)                             ? "wanted"
                      : def->rivals < 1 || def->rivals > LAB_PLAN_RIVALS ? "rivals"
                                                                         : NULL;
    return bad == NULL ? STEIN_OK
                       : lab__fail(err, STEIN_EINVAL, "lab_plan_def.%s is out of range", bad);
}

stein_status lab_plan_make(lab_plan **out, const char *file, const lab_model *model,
                           const lab_diagnosis *d, const lab_plan_def *def, stein_err *err)
{
    lab_plan_def none = lab_plan_def_default();
    planner p = {.d = d, .def = def != NULL ? def : &none};
    lab_plan *plan = calloc(1, sizeof *plan);
    struct timespec begin, end;
    clock_gettime(CLOCK_MONOTONIC, &begin);
    if (plan == NULL) {
        return lab__no_memory(err);
    }
    plan->wanted = p.def->wanted;
    plan->most = MOST;
    stein_status status = check(p.def, lab_equations(model), err);
    if (status == STEIN_OK && (d->ncause < 1 || d->nrival < 1)) {
        *out = plan; // nothing to separate
        return STEIN_OK;
    }
    status = status == STEIN_OK ? open_sides(&p, plan, file, model, err) : status;
    if (status == STEIN_OK) {
        status =
            plan__reference_make(&p.reference, &p.side[0], d, lab_equations(model), p.def, err);
    }
    if (status == STEIN_OK) {
        status = plan__experiments(&p.reference, p.side, p.nside, &plan->experiment, &plan->n, err);
    }
    status = status == STEIN_OK ? judge_from(&p, plan, 0, err) : status;
    status = status == STEIN_OK ? combine(&p, plan, err) : status;
    make_twice(plan);
    plan->strokes = p.reference.strokes;
    plan__reference_free(&p.reference);
    for (int k = 0; k < p.nside; k++) {
        plan__model_close(&p.side[k]);
    }
    clock_gettime(CLOCK_MONOTONIC, &end);
    plan->seconds =
        (double)(end.tv_sec - begin.tv_sec) + 1e-9 * (double)(end.tv_nsec - begin.tv_nsec);
    if (status != STEIN_OK) {
        lab_plan_destroy(plan);
        return lab__stop_end(status, &(lab__stop){p.def->stop, p.def->ctx}, err);
    }
    *out = plan;
    return STEIN_OK;
}

void lab_plan_destroy(lab_plan *plan)
{
    if (plan != NULL) {
        free(plan->experiment);
        free(plan);
    }
}
