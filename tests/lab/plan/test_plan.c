/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_plan.c - the next experiment: odds agree with dense algebra. Two drags that strokes at one
 * angle cannot separate are separated by the proposed stroke, whichever is true.
 */
#include <gsl/gsl_blas.h>
#include <gsl/gsl_linalg.h>
#include <math.h>

#include "planning.h"
#include "rotor_support.h"

Suite *plan_suite(void);

/* ---- odds ---- */

enum { ROWS = 40, NP = 3, NZ = 2 };

/* two models of one channel whose columns partly agree */
static void make_views(double Y[2][ROWS], double P[2][NP * ROWS], double Z[2][NZ * ROWS],
                       plan__prediction *v)
{
    for (int m = 0; m < 2; m++) {
        for (int i = 0; i < ROWS; i++) {
            double t = (i + 0.5) / ROWS;
            Y[m][i] = m == 0 ? 3.1 * sin(5.0 * t) : 2.9 * sin(5.0 * t) + 9.7 * t * t;
            P[m][i] = 2.3 * sin(5.0 * t);
            P[m][ROWS + i] = 0.7 * cos(3.0 * t);
            P[m][2 * ROWS + i] = m == 0 ? 0.9 * t * t : 1.1 * t;
            Z[m][i] = 30.0;
            Z[m][ROWS + i] = 0.8 * exp(-2.0 * t);
        }
        v[m] = (plan__prediction){.rows = ROWS,
                                  .until = ROWS,
                                  .noutput = 1,
                                  .np = NP,
                                  .nz = NZ,
                                  .y = Y[m],
                                  .P = P[m],
                                  .Z = Z[m]};
    }
}

/* V of a model and ln|V| */
static gsl_matrix *variance(const double *P, const double *Z, gsl_matrix *inverse, double *logdet)
{
    gsl_matrix *V = gsl_matrix_alloc(ROWS, ROWS);
    for (size_t i = 0; i < ROWS; i++) {
        for (size_t k = 0; k < ROWS; k++) {
            double sum = i == k ? 1.0 : 0.0;
            for (size_t c = 0; c < NP; c++) {
                sum += P[c * ROWS + i] * P[c * ROWS + k];
            }
            for (size_t c = 0; c < NZ; c++) {
                sum += Z[c * ROWS + i] * Z[c * ROWS + k];
            }
            gsl_matrix_set(V, i, k, sum);
        }
    }
    gsl_matrix_memcpy(inverse, V);
    ck_assert_int_eq(gsl_linalg_cholesky_decomp1(inverse), 0);
    *logdet = 0.0;
    for (size_t i = 0; i < ROWS; i++) {
        *logdet += 2.0 * log(gsl_matrix_get(inverse, i, i));
    }
    gsl_linalg_cholesky_invert(inverse);
    return V;
}

START_TEST(odds_of_draws_are_those_of_dense_algebra)
{
    static double Y[2][ROWS], P[2][NP * ROWS], Z[2][NZ * ROWS];
    plan__prediction v[2];
    plan__pair pair;
    lab_experiment e = {.faster = 1};
    const unsigned char use[] = {1};
    double expected = INFINITY, logdet[2];
    make_views(Y, P, Z, v);
    gsl_matrix *V[2], *W[2];
    for (int m = 0; m < 2; m++) {
        W[m] = gsl_matrix_alloc(ROWS, ROWS);
        V[m] = variance(P[m], Z[m], W[m], &logdet[m]);
    }
    // E 2 ln odds = d'V_B^-1 d + tr(V_B^-1 V_A) - n + ln|V_B| - ln|V_A|
    for (int a = 0; a < 2; a++) {
        double sum = logdet[1 - a] - logdet[a] - ROWS;
        for (size_t i = 0; i < ROWS; i++) {
            for (size_t k = 0; k < ROWS; k++) {
                double w = gsl_matrix_get(W[1 - a], i, k);
                sum += w * (gsl_matrix_get(V[a], k, i) + (Y[0][i] - Y[1][i]) * (Y[0][k] - Y[1][k]));
            }
        }
        expected = fmin(expected, sum);
    }
    ck_assert_stein(plan__pair_make(&pair, NULL, &v[0], &v[1], err));
    ck_assert_stein(plan__odds(&pair, use, 2.0 * log(100.0), 64, 1, &e, err));
    printf("odds: %.3f by draws, %.3f by dense algebra, worst %.3f, %d repeats\n", e.odds, expected,
           e.odds_worst, e.repeats);
    fflush(stdout);
    ck_assert_close(e.odds, expected, 0.1, 0.1);
    ck_assert(e.odds_worst < e.odds);
    ck_assert_int_gt(e.repeats, 1);
    lab_experiment of_four = e; // none of four may be left, nine times of ten
    ck_assert_stein(plan__odds(&pair, use, 2.0 * log(100.0), 64, 4, &of_four, err));
    ck_assert(of_four.odds == e.odds);
    ck_assert(of_four.odds_worst < e.odds_worst);
    ck_assert_int_ge(of_four.repeats, e.repeats);
    plan__pair_free(&pair);
    for (int m = 0; m < 2; m++) {
        gsl_matrix_free(V[m]);
        gsl_matrix_free(W[m]);
    }
}
END_TEST

START_TEST(unpredictable_samples_carry_no_evidence)
{
    static double Y[2][ROWS], P[2][NP * ROWS], Z[2][NZ * ROWS];
    plan__prediction v[2];
    plan__pair pair;
    const unsigned char use[] = {1};
    lab_experiment e[3];
    make_views(Y, P, Z, v);
    for (int k = 0; k < 3; k++) {
        v[0].until = k == 0 ? ROWS : ROWS / 2; // the earlier end of both models
        for (int i = ROWS / 2; k == 2 && i < ROWS; i++) {
            Y[0][i] += 1e3;
        }
        e[k] = (lab_experiment){.faster = 1};
        ck_assert_stein(plan__pair_make(&pair, NULL, &v[0], &v[1], err));
        ck_assert_stein(plan__odds(&pair, use, 2.0 * log(100.0), 64, 1, &e[k], err));
        plan__pair_free(&pair);
    }
    ck_assert(e[1].odds < e[0].odds);
    ck_assert(e[2].odds == e[1].odds);
    ck_assert(e[2].odds_worst == e[1].odds_worst);
}
END_TEST

START_TEST(models_with_equal_predictions_are_never_separated)
{
    static double Y[2][ROWS], P[2][NP * ROWS], Z[2][NZ * ROWS];
    plan__prediction v[2];
    plan__pair pair;
    lab_experiment e = {.faster = 1};
    const unsigned char use[] = {1};
    make_views(Y, P, Z, v);
    for (int i = 0; i < ROWS; i++) { // they differ by what an offset can imitate
        Y[1][i] = Y[0][i] + 0.3;
    }
    v[1].P = P[0];
    ck_assert_stein(plan__pair_make(&pair, NULL, &v[0], &v[1], err));
    ck_assert_stein(plan__odds(&pair, use, 2.0 * log(100.0), 64, 1, &e, err));
    ck_assert(fabs(e.odds) < 0.05);
    ck_assert_int_eq(e.repeats, 0);
    plan__pair_free(&pair);
}
END_TEST

/* Two models that differ only in the effect of one number of the file: by 1 % of hundreds of
 * noises; then the same of a number of their effects. */
START_TEST(the_column_of_a_number_of_the_file_is_the_same_in_both)
{
    static double Y[ROWS], D[2][ROWS], Z[ROWS], one[] = {1.0};
    static const char *name[2][1] = {{"wheel.mass"}, {"amount"}};
    const unsigned char use[] = {1};
    double odds[2];
    for (int i = 0; i < ROWS; i++) {
        D[0][i] = 300.0 * sin(0.2 * i);
        D[1][i] = D[0][i] + 3.0 * cos(0.1 * i);
    }
    for (int k = 0; k < 2; k++) {
        plan__prediction v[2];
        plan__pair pair;
        lab_experiment e = {.faster = 1};
        for (int m = 0; m < 2; m++) {
            v[m] = (plan__prediction){.rows = ROWS,
                                      .until = ROWS,
                                      .noutput = 1,
                                      .np = 1,
                                      .nz = 1,
                                      .y = Y,
                                      .P = D[m],
                                      .Z = Z,
                                      .name = name[k],
                                      .D = D[m],
                                      .L = one};
        }
        ck_assert_stein(plan__pair_make(&pair, NULL, &v[0], &v[1], err));
        ck_assert_stein(plan__odds(&pair, use, 2.0 * log(100.0), 64, 1, &e, err));
        plan__pair_free(&pair);
        odds[k] = e.odds;
    }
    printf("3 of 300 noises: 2 ln odds %.3g of a mass, %.3g of an amount\n", odds[0], odds[1]);
    fflush(stdout);
    ck_assert(fabs(odds[0]) < 0.05); // a factor of K is jittered
    ck_assert_double_gt(odds[1], 10.0);
}
END_TEST

/* ---- two drags ---- */

static const char *const truth[] = {"wheel.drag=1e-4 N m s^2/rad^2",
                                    "wheel.damping=3.2e-4 N m s/rad"};
static const char *const kind[] = {"quadratic_drag", "viscous_friction"};
static const char *const start[] = {"wheel.initial.position=0.2 rad", NULL};

static lab_plan *planned_for(const rotor *r, const lab_diagnosis *d, double odds)
{
    lab_plan *plan = NULL;
    lab_options options = cache_here(NULL);
    lab_plan_def def = lab_plan_def_default();
    def.threads = 2;
    def.wanted = odds;
    def.options = &options;
    ck_assert_stein(lab_plan_make(&plan, in_folder("rotor.yaml"), r->model, d, &def, err));
    return plan;
}

static lab_plan *planned(const rotor *r, const lab_diagnosis *d)
{
    return planned_for(r, d, lab_plan_def_default().wanted);
}

/* the first one with that in its name */
static const lab_experiment *named(const lab_plan *plan, const char *name)
{
    for (int i = 0; i < plan->n; i++) {
        if (strstr(plan->experiment[i].name, name) != NULL) {
            return &plan->experiment[i];
        }
    }
    ck_abort_msg("no experiment \"%s\"", name);
    return NULL;
}

START_TEST(the_proposed_stroke_separates_two_drags)
{
    rotor r = rotor_diagnosed(truth[_i], start, 1);
    const lab_suspect *right = rotor_suspect(&r, kind[_i]),
                      *other = rotor_suspect(&r, kind[1 - _i]);
    ck_assert_int_eq(r.d->ncause, 1);
    ck_assert_int_ge(r.d->nrival, 1);
    ck_assert(right - r.d->suspect < 1 + r.d->nrival && other - r.d->suspect < 1 + r.d->nrival);

    lab_plan *plan = planned(&r, r.d);
    lab_experiment best = plan->experiment[0];
    const lab_experiment *same = named(plan, "the same again");
    printf("%s: %s, 2 ln odds %.3g, worst %.3g, %d repeats; the same again %.3g, %d repeats\n",
           kind[_i], best.name, best.odds, best.odds_worst, best.repeats, same->odds,
           same->repeats);
    ck_assert_int_eq(best.nset, 1);
    ck_assert_str_eq(best.set[0].name, "wheel.initial.position");
    ck_assert(best.set[0].value != 0.2);
    ck_assert_int_eq(best.repeats, 2); // one would be enough
    ck_assert(same->repeats == 0 || same->repeats > 8);
    ck_assert_ptr_nonnull(r.d->next); // the diagnosis states it, too
    ck_assert_str_eq(r.d->next->name, best.name);
    lab_plan_destroy(plan);
    rotor_free(&r);

    // made, it names the right one alone
    char more[80];
    snprintf(more, sizeof more, "wheel.initial.position=%.17g rad", best.set[0].value);
    const char *const both[] = {start[0], more};
    r = rotor_diagnosed(truth[_i], both, 2);
    ck_assert_int_eq(r.d->nrival, 0);
    ck_assert_str_eq(r.d->suspect[0].candidate.effect->kind, kind[_i]);
    ck_assert_ptr_null(r.d->next);
    rotor_free(&r);
}
END_TEST

/* 2 ln odds between a candidate and itself with all numbers `far` standard deviations away, along
 * the correlation with its first number; straight 1: seen along derivatives only */
static double odds_of_itself(const rotor *r, plan__reference *b, const lab_experiment *e,
                             double far, int straight)
{
    lab_suspect there = r->d->suspect[0];
    lab_posterior q = there.posterior;
    plan__model side[2];
    plan__prediction v[2];
    plan__pair pair;
    lab_experiment x = *e;
    unsigned char use[PLAN_OUTPUTS] = {1};
    q.number = malloc(sizeof *q.number * (size_t)q.n);
    ck_assert_ptr_nonnull(q.number);
    for (int i = 0; i < q.n; i++) {
        double by = far * q.correlation[i * q.n] * there.posterior.number[i].sd;
        q.number[i] = there.posterior.number[i];
        q.number[i].value =
            q.number[i].logarithmic ? q.number[i].value * exp(by) : q.number[i].value + by;
    }
    there.posterior = q;
    for (int k = 0; k < 2; k++) {
        ck_assert_stein(plan__model_open(&side[k], k == 0 ? &r->d->suspect[0] : &there,
                                         in_folder("rotor.yaml"), r->model, NULL, err));
        ck_assert_stein(plan__predict(&v[k], b, &side[k], e, 0, err));
    }
    plan__stage *stage[] = {v[0].stage, v[1].stage};
    for (int k = 0; k < 2 && straight; k++) {
        v[k].stage = NULL;
    }
    ck_assert_stein(plan__pair_make(&pair, b, &v[0], &v[1], err));
    ck_assert_stein(plan__odds(&pair, use, 2.0 * log(100.0), 64, 1, &x, err));
    plan__pair_free(&pair);
    for (int k = 0; k < 2; k++) {
        v[k].stage = stage[k];
        plan__prediction_free(&v[k]);
        plan__model_close(&side[k]);
    }
    free(q.number);
    return x.odds;
}

START_TEST(curvature_on_the_way_to_other_numbers_is_no_evidence)
{
    rotor r = rotor_diagnosed(truth[0], start, 1);
    plan__model cause;
    plan__reference b;
    lab_plan_def def = lab_plan_def_default();
    lab_experiment *list = NULL;
    int n = 0;
    ck_assert_stein(
        plan__model_open(&cause, &r.d->suspect[0], in_folder("rotor.yaml"), r.model, NULL, err));
    ck_assert_stein(plan__reference_make(&b, &cause, r.d, lab_equations(r.model), &def, err));
    ck_assert_stein(plan__experiments(&b, &cause, 1, &list, &n, err));
    const lab_experiment *high = list;
    while (high < list + n && strstr(high->name, "400 mrad") == NULL) {
        high++;
    }
    ck_assert(high < list + n);
    double far = 480.0, straight = odds_of_itself(&r, &b, high, far, 1),
           refitted = odds_of_itself(&r, &b, high, far, 0);
    printf("the same model %g sd away: 2 ln odds %.4g along derivatives, %.4g refitted\n", far,
           straight, refitted);
    fflush(stdout);
    ck_assert_double_lt(refitted, 0.95 * straight);
    ck_assert_double_gt(refitted, 0.0);
    free(list);
    plan__reference_free(&b);
    plan__model_close(&cause);
    rotor_free(&r);
}
END_TEST

static int things(const lab_experiment *e)
{
    int n = 1;
    for (const char *c = e->name; *c != '\0'; c++) {
        n += c[0] == ',' && strncmp(c, ", too", 5) != 0 && strncmp(c, ", then", 6) != 0;
    }
    return n;
}

/* the same numbers set, in whatever order, before the same camera */
static int are_same(const lab_experiment *a, const lab_experiment *b)
{
    int same = a->nset == b->nset && a->faster == b->faster && strcmp(a->channel, b->channel) == 0;
    for (int i = 0; same && i < a->nset; i++) {
        const lab_planned_set *s = plan__set_of(b, a->set[i].name);
        same = s != NULL && s->value == a->set[i].value;
    }
    return same;
}

/* ---- an instrument by itself ---- */

/* A scale with a gain that is off by a +- s, against a correct one: with u = c'y/|c|, c what the 11
 * readings show of the gain beside an unknown zero, u is N(a |c|, 1 + s^2 |c|^2) or N(0, 1). */
START_TEST(readings_of_a_check_agree_with_a_scale)
{
    static const char *const gain[] = {"angle.sensor.gain=1.02", NULL};
    rotor r = rotor_with(gain, start, 1);
    const lab_suspect *with = rotor_suspect(&r, "sensor_gain");
    const lab_posterior *q = &with->posterior;
    plan__model side[2];
    plan__prediction v[2];
    plan__pair pair;
    unsigned char use[] = {1};
    lab_experiment e = {.faster = 1, .ncheck = 1};
    e.check[0] = (lab_check){.by = LAB_CHECK_SCALE,
                             .of = "angle",
                             .n = 2,
                             .number = {{"angle.sensor.gain", 1.0}, {"angle.sensor.square", 0.0}},
                             .noise = 0.03,
                             .reach = 2.0};
    ck_assert_ptr_eq(with, &r.d->suspect[0]);
    for (int k = 0; k < 2; k++) {
        ck_assert_stein(plan__model_open(&side[k], &r.d->suspect[k], in_folder("rotor.yaml"),
                                         r.model, NULL, err));
        ck_assert_stein(plan__check_prediction(&v[k], &side[k], &e, err));
    }
    ck_assert_str_eq(r.d->suspect[1].candidate.effect->kind, "preload");
    ck_assert_stein(plan__pair_make(&pair, NULL, &v[0], &v[1], err));
    ck_assert_stein(plan__odds(&pair, use, 2.0 * log(100.0), 64, 1, &e, err));
    double c2 = 0.0, a = 0.0, s = 0.0;
    for (int i = 0; i < 11; i++) {
        c2 += pow((0.2 * i - 1.0) / 0.03, 2.0);
    }
    for (int i = 0; i < q->n; i++) {
        a = strcmp(q->number[i].name, "amount") == 0 ? q->number[i].value : a;
        s = strcmp(q->number[i].name, "amount") == 0 ? q->number[i].sd : s;
    }
    double V = 1.0 + s * s * c2, d2 = a * a * c2;
    double expected = fmin(d2 + V - 1.0 - log(V), d2 / V + 1.0 / V - 1.0 + log(V));
    printf("a scale: %.3f by draws, %.3f expected\n", e.odds, expected);
    ck_assert_double_gt(expected, 1.0);
    ck_assert_close(e.odds, expected, 0.1, 0.1);
    plan__pair_free(&pair);
    for (int k = 0; k < 2; k++) {
        plan__prediction_free(&v[k]);
        plan__model_close(&side[k]);
    }
    rotor_free(&r);
}
END_TEST

/* A felt that is e^0.1 +- 0.02 as stiff in a press, and a length that is 1 mm +- 0.2 mm longer,
 * with calipers: what the readings are in their noise, and by what they are uncertain. */
START_TEST(readings_of_a_felt_and_of_a_length_are_those_of_the_file_and_more)
{
    lab_model *model = NULL;
    lab_options options = cache_here(NULL);
    ck_assert_stein(lab_open(&model, "models/stein1788.yaml", &options, err));
    const stein_model *m = lab_equations(model);
    const double *file = lab_parameters(model);
    double b = file[stein_find_param(m, "loops.normal.b")],
           c = file[stein_find_param(m, "loops.normal.c")], reach = 2e-3;
    static const struct {
        const char *kind, *place;
        double amount, sd;
    } what[] = {{"contact_stiffness", "loops", 0.1, 0.02},
                {"wrong_parameter", "key.front.x", 1e-3, 2e-4}};
    lab_experiment e = {.faster = 1, .ncheck = 2};
    e.check[0] = (lab_check){.by = LAB_CHECK_PRESS,
                             .of = "loops",
                             .n = 2,
                             .number = {{"loops.normal.b", b}, {"loops.normal.c", c}},
                             .noise = 5e-3,
                             .reach = reach};
    e.check[1] = (lab_check){.by = LAB_CHECK_CALIPERS,
                             .of = "key.front.x",
                             .n = 1,
                             .number = {{"key.front.x", file[stein_find_param(m, "key.front.x")]}},
                             .noise = 5e-5};
    lab_candidate *list = NULL;
    int n = 0;
    ck_assert_stein(lab_candidates(&list, &n, model, err));
    for (int k = 0; k < 2; k++) {
        struct lab_uncertain number[] = {{.value = what[k].amount, .sd = what[k].sd}};
        snprintf(number[0].name, sizeof number[0].name, "amount");
        double one = 1.0;
        lab_suspect s = {.posterior = {.n = 1, .number = number, .correlation = &one}};
        for (int i = 0; i < n; i++) {
            int it = strcmp(list[i].effect->kind, what[k].kind) == 0 &&
                     strcmp(list[i].place, what[k].place) == 0;
            s.candidate = it ? list[i] : s.candidate;
        }
        plan__model side;
        plan__prediction v;
        ck_assert_stein(plan__model_open(&side, &s, "models/stein1788.yaml", model, NULL, err));
        ck_assert_stein(plan__check_prediction(&v, &side, &e, err));
        ck_assert_int_eq(v.rows, 12);
        double most = (b * reach + c) * reach;
        for (int i = 0; i < 11; i++) {
            double x = reach * i / 10.0, F = (b * x + c) * x, noise = 5e-3 * (F + 0.1 * most);
            double up = k == 0 ? exp(0.1) : 1.0, by = k == 0 ? sinh(0.02) : 0.0;
            ck_assert_close(v.y[i], up * F / noise, 1e-9, 1e-9);
            ck_assert_close(v.P[i], up * by * F / noise, 1e-6, 1e-9);
            ck_assert_close(v.Z[i], (2.0 * b * x + b * 1e-5 + c) * 1e-5 / noise, 1e-6, 0.0);
        }
        ck_assert_close(v.y[11], k == 1 ? 20.0 : 0.0, 1e-6, 1e-6);
        ck_assert_close(v.P[11], k == 1 ? 4.0 : 0.0, 1e-6, 1e-6);
        ck_assert(v.Z[11] == 0.0 && v.Z[12 + 11] == 0.0);
        plan__prediction_free(&v);
        plan__model_close(&side);
    }
    free(list);
    lab_close(model);
}
END_TEST

/* An instrument and what it is not: the plan proposes to check it, and the stated result decides,
 * whichever is true. */
START_TEST(a_check_of_the_instrument_settles_it)
{
    static const char *const there[] = {"angle.sensor.gain=1.02", "wheel.preload=3.3e-3 N m"};
    static const char *const found[] = {"angle.sensor.gain=1.02", "angle.sensor.gain=1"};
    const char *other[] = {there[_i], NULL};
    rotor r = rotor_diagnosed(there[_i], start, 1);
    int with = 0;
    for (int i = 0; i < r.d->ncause + r.d->nrival; i++) {
        with |= strcmp(r.d->suspect[i].candidate.effect->kind, "sensor_gain") == 0;
    }
    ck_assert(with && r.d->nrival > 0);
    lab_plan *plan = planned(&r, r.d);
    const lab_experiment *e = named(plan, "angle beside a scale");
    ck_assert_int_eq(e->ncheck, 1);
    ck_assert_int_eq(e->check[0].by, LAB_CHECK_SCALE);
    ck_assert_str_eq(e->check[0].of, "angle");
    ck_assert_ptr_nonnull(strstr(e->why, "# known angle.sensor.gain, # known angle.sensor.square"));
    ck_assert_int_eq(e->repeats, 1);
    ck_assert_int_eq(lab_plan_stroke(in_folder("no.csv"), e, 0, in_folder("rotor.yaml"), r.model,
                                     r.d, NULL, NULL),
                     STEIN_EINVAL); // there is none
    lab_plan_destroy(plan);
    rotor_free(&r);

    r = rotor_stated(_i == 0 ? other + 1 : other, start, 1, found[_i]);
    ck_assert_str_eq(rotor_suspect(&r, "sensor_gain")->why, "every record states it");
    if (_i == 0) {
        ck_assert_int_eq(r.d->verdict, LAB_VERDICT_EXPLAINED);
    } else {
        ck_assert_str_eq(r.d->suspect[0].candidate.effect->kind, "preload");
        ck_assert_int_eq(r.d->nrival, 0);
    }
    rotor_free(&r);
}
END_TEST

/* ---- a part that comes off ---- */

#define LEVER(MORE)                                       \
    "mechanism: lever\n"                                  \
    "bodies:\n"                                           \
    "  wheel:\n"                                          \
    "    joint: R y\n"                                    \
    "    mass: 0.4 kg\n"                                  \
    "    inertia: {yy: 2.1e-3 kg m^2 +- 0.1 %}\n"         \
    "    spring: {k: 0.83 N m/rad +- 0.1 %}\n"            \
    "    initial: {position: 0.2 rad}\n"                  \
    "    points: {rim: [50 mm, 0, 0]}\n"                  \
    "inputs:\n"                                           \
    "  push: {force: wheel.rim, direction: [0, 0, -1]}\n" \
    "outputs:\n"                                          \
    "  angle: {joint: wheel, read: position}\n"           \
    "simulation: {dt: 0.2 ms, until: 0.7 s}\n" MORE
static const char lever[] = LEVER("");
static const char with_wire[] = LEVER("points: {wheel_wire: [50 mm, 0, 50 mm]}\n"
                                      "links:\n"
                                      "  wheel_wire: {from: frame.wheel_wire, "
                                      "to: wheel.rim, k: 0 N/m, length: 49 mm}\n");

/* so many of the strokes were played without a wire, in a world where that is `there`, diagnosed
 * without one */
static rotor lever_diagnosed(const char *there, int without)
{
    const char *what[] = {there, NULL}, *told[ROTOR_STROKES][3] = {{NULL}};
    for (int s = 0; s < without; s++) {
        told[s][0] = "wheel_wire.k=0";
    }
    return rotor_filmed(lever, with_wire, what, told);
}

static int is_left(const rotor *r, const char *who)
{
    const lab_suspect *s = rotor_suspect(r, who);
    return s - r->d->suspect < r->d->ncause + r->d->nrival;
}

/* A wire, a stiffer spring and others: the plan offers a stroke without a wire, and one such stroke
 * decides whether it was a wire. Without a stroke with a wire nothing is known about it. */
START_TEST(removable_parts_are_taken_off)
{
    static const char *const there[] = {"wheel_wire.k=24 N/m", "wheel.spring.k=0.87 N m/rad"};
    rotor r = lever_diagnosed(there[_i], 0);
    ck_assert(is_left(&r, "wire") && r.d->nrival > 0);
    lab_plan *plan = planned(&r, r.d);
    const lab_experiment *e = named(plan, "wheel without wire");
    ck_assert_int_eq(e->feasible, 1);
    ck_assert_double_eq(plan__set_of(e, "wheel_wire.k")->value, 0.0);
    for (int k = 0; k < 2; k++) { // both sides can be filmed, and what is said of it read again
        lab_data *stroke = NULL;
        lab_data_options o = lab_data_options_default(lab_equations(r.model));
        lab_options options = cache_here(NULL);
        lab_plan_def def = lab_plan_def_default();
        def.options = &options;
        ck_assert_stein(lab_plan_stroke(in_folder("next.csv"), e, k, in_folder("rotor.yaml"),
                                        r.model, r.d, &def, err));
        ck_assert_stein(lab_data_open(&stroke, in_folder("next.csv"), &o, err));
        ck_assert(lab_data_without(stroke, "wheel_wire.k"));
        lab_data_close(stroke);
    }
    lab_plan_destroy(plan);
    rotor_free(&r);

    r = lever_diagnosed(there[_i], 1);
    ck_assert_int_eq(is_left(&r, "wire"), _i == 0);
    ck_assert_int_eq(strcmp(r.d->suspect[0].candidate.effect->kind, "wire") == 0, _i == 0);
    ck_assert(_i == 1 || r.d->nrival == 0);
    rotor_free(&r);

    r = lever_diagnosed(there[_i], ROTOR_STROKES);
    ck_assert_str_eq(rotor_suspect(&r, "wire")->why, "every record was made without it");
    rotor_free(&r);
}
END_TEST

START_TEST(where_one_stroke_is_not_enough_things_are_done_at_once)
{
    rotor r = rotor_diagnosed(truth[0], start, 1);
    lab_plan *plan = planned_for(&r, r.d, INFINITY);
    double alone = 0.0;
    int most = 1;
    ck_assert_int_ne(plan->experiment[0].repeats, 1);
    for (int i = 0; i < plan->n; i++) {
        const lab_experiment *e = &plan->experiment[i];
        int n = things(e);
        alone = n == 1 ? fmax(alone, e->odds) : alone;
        most = n > most ? n : most;
        for (int k = 0; k < i; k++) {
            ck_assert_msg(!are_same(e, &plan->experiment[k]), "%s twice", e->name);
        }
    }
    ck_assert_int_eq(most, 3);
    ck_assert_int_gt(things(&plan->experiment[0]), 1);
    ck_assert_double_gt(plan->experiment[0].odds, 1.1 * alone);
    lab_plan_destroy(plan);
    rotor_free(&r);
}
END_TEST

START_TEST(changes_of_two_experiments_are_combined)
{
    lab_experiment base = {.faster = 1}, a, b, to;
    plan__set(&base, "load.mass", "kg", 0.1);
    plan__set(&base, "stop", "m", 0.0);
    a = b = base;
    ck_assert_int_eq(plan__together(&to, &a, &b, &base), 0); // b is the base
    plan__set(&a, "load.mass", "kg", 0.2);
    plan__set(&b, "stop", "m", 1e-3);
    a.beyond = 2.5;
    b.beyond = 2.0;
    a.all = b.all = 1; // what was found of one is not known of both
    ck_assert_int_eq(plan__together(&to, &a, &b, &base), 1);
    ck_assert_double_eq(to.set[0].value, 0.2);
    ck_assert_double_eq(to.set[1].value, 1e-3);
    ck_assert_double_eq(to.beyond, 5.0);
    ck_assert_int_eq(to.all, 0);
    plan__set(&b, "load.mass", "kg", 0.3);
    ck_assert_int_eq(plan__together(&to, &a, &b, &base), 0); // both set the load
    b = base;
    snprintf(b.input, sizeof b.input, "finger");
    b.shape = LAB_SHAPE_BACK;
    b.size = 2.0;
    b.faster = 10;
    ck_assert_int_eq(plan__together(&to, &a, &b, &base), 1);
    ck_assert_str_eq(to.input, "finger");
    ck_assert_double_eq(to.size, 2.0);
    ck_assert_double_eq(to.set[0].value, 0.2);
    ck_assert_int_eq(to.faster, 10);
    ck_assert_int_eq(plan__together(&to, &to, &b, &base), 0); // one finger, one camera
    memset(a.name, 'a', sizeof a.name - 1);                   // what comes last is said whole
    a.name[sizeof a.name - 1] = '\0';
    b = base;
    b.faster = 10;
    snprintf(b.name, sizeof b.name, "a camera");
    ck_assert_int_eq(plan__together(&to, &a, &b, &base), 1);
    ck_assert_int_eq((int)strlen(to.name), LAB_PLAN_TEXT - 1);
    ck_assert_str_eq(to.name + LAB_PLAN_TEXT - 1 - strlen("a, a camera"), "a, a camera");
    b = a = base;
    snprintf(a.channel, sizeof a.channel, "angle");
    snprintf(b.channel, sizeof b.channel, "height");
    ck_assert_int_eq(plan__together(&to, &a, &b, &base), 0);
}
END_TEST

START_TEST(a_plan_begins_where_the_numbers_of_a_rival_were_found)
{
    static const char *const loose[] = {"wheel.backlash.k=0.3 N m/rad",
                                        "wheel.backlash.gap=0.09 rad", NULL};
    rotor r = rotor_with(loose, start, 1);
    int sides = 0;
    for (int i = 0; i < r.d->ncause + r.d->nrival; i++) {
        const lab_suspect *s = &r.d->suspect[i];
        for (int k = 0; k < s->posterior.n; k++) {
            if (strcmp(s->posterior.number[k].name, "side") == 0) {
                ck_assert_int_gt(s->nnumber, 1);
                ck_assert_double_eq_tol(s->posterior.number[k].value, s->number[1].value,
                                        1e-9 * fabs(s->number[1].value));
                ck_assert_double_eq(s->candidate.side[0].value, s->number[1].value);
                sides++;
            }
        }
    }
    ck_assert_int_gt(sides, 0);
    rotor_free(&r);
}
END_TEST

START_TEST(invalid_correlations_are_reported)
{
    rotor r = rotor_diagnosed(truth[0], start, 1);
    const lab_posterior *q = &r.d->suspect[0].posterior;
    ck_assert_int_gt(q->n, 1);
    q->correlation[1] = q->correlation[q->n] = 5.0;
    lab_plan *plan = planned(&r, r.d);
    ck_assert_int_gt(plan->n, 0);
    for (int i = 0; i < plan->n; i++) {
        ck_assert_int_eq(plan->experiment[i].feasible, 0);
        ck_assert_ptr_nonnull(strstr(plan->experiment[i].why, "correlations of its numbers"));
    }
    lab_plan_destroy(plan);
    rotor_free(&r);
}
END_TEST

START_TEST(an_instrument_that_is_no_output_is_refused)
{
    static const char *const no[] = {"thermometer"};
    rotor r = rotor_diagnosed(truth[0], start, 1);
    lab_plan *plan = NULL;
    stein_err why = {STEIN_OK, ""};
    lab_plan_def def = lab_plan_def_default();
    def.instrument = no;
    def.ninstrument = 1;
    ck_assert_int_eq(lab_plan_make(&plan, in_folder("rotor.yaml"), r.model, r.d, &def, &why),
                     STEIN_ENAME);
    ck_assert_ptr_nonnull(strstr(why.msg, "thermometer"));
    ck_assert_ptr_null(plan);
    rotor_free(&r);
}
END_TEST

/* a kind at a place of the piano action, open as a side */
static void side_of(plan__model *side, const lab_suspect *none, const char *effect,
                    const char *place, const lab_model *model)
{
    lab_candidate *candidate = NULL;
    int n = 0, found = 0;
    lab_suspect s = *none;
    ck_assert_stein(lab_candidates(&candidate, &n, model, err));
    for (int i = 0; i < n; i++) {
        int it = strcmp(candidate[i].effect->kind, effect) == 0 &&
                 strcmp(candidate[i].place, place) == 0;
        s.candidate = it ? candidate[i] : s.candidate;
        found += it;
    }
    free(candidate);
    ck_assert_int_eq(found, 1);
    lab_options options = cache_here(NULL);
    ck_assert_stein(plan__model_open(side, &s, "models/stein1788.yaml", model, &options, err));
    side->s = none;
}

/* experiments of the piano action, driven by forces between these, for sides: kind, place [n] */
static lab_experiment *experiments_for(const char *const (*who)[2], int nside,
                                       const lab_model *model, double lo, double hi,
                                       const lab_plan_def *def, int *n)
{
    lab_used output = {.name = "string_distance", .unit = "m", .hi = 0.04, .noise = 1e-5};
    lab_used finger = {.name = "finger", .unit = "N", .lo = lo, .hi = hi};
    lab_diagnosis d = {.conditions = {.from = 0.0,
                                      .until = 0.12,
                                      .interval = 2.5e-4,
                                      .nchannel = 1,
                                      .channel = &output,
                                      .ninput = 1,
                                      .input = &finger}};
    lab_suspect s = {.gain = NAN};
    plan__reference b;
    plan__model side[4];
    lab_experiment *list = NULL;
    for (int k = 0; k < nside; k++) {
        side_of(&side[k], &s, who[k][0], who[k][1], model);
    }
    ck_assert_stein(plan__reference_make(&b, &side[0], &d, lab_equations(model), def, err));
    ck_assert_stein(plan__experiments(&b, side, nside, &list, n, err));
    plan__reference_free(&b);
    for (int k = 0; k < nside; k++) {
        plan__model_close(&side[k]);
    }
    return list;
}

static lab_experiment *experiments_of(const lab_model *model, double lo, double hi,
                                      const lab_plan_def *def, int *n)
{
    static const char *const who[][2] = {{"viscous_friction", "hammer"}};
    return experiments_for(who, 1, model, lo, hi, def, n);
}

/* the experiment of just that name, NULL: there is none */
static const lab_experiment *called(const lab_experiment *list, int n, const char *name)
{
    const lab_experiment *e = NULL;
    for (int i = 0; i < n; i++) {
        e = strcmp(list[i].name, name) == 0 ? &list[i] : e;
    }
    return e;
}

/* A stiffer joint, a wire and a damper: each part comes off by itself, and both at once. */
START_TEST(all_that_comes_off_is_taken_off_at_once)
{
    static const char *const who[][2] = {
        {"joint_stiffness", "key"}, {"wire", "key"}, {"string_damper", "key"}};
    static const char wire[] = "key without wire: key_wire.k = 0",
                      damper[] = "key without string_damper: key_damper.normal.F0 = 0";
    lab_plan_def def = lab_plan_def_default();
    lab_model *model = NULL;
    ck_assert_stein(lab_open(&model, "models/stein1788.yaml", NULL, err));
    for (int nside = 1; nside <= 3; nside++) {
        char both[2 * LAB_PLAN_TEXT];
        int n = 0;
        lab_experiment *list = experiments_for(who, nside, model, 0.0, 1.2, &def, &n);
        snprintf(both, sizeof both, "%s, %s", wire, damper);
        const lab_experiment *e = called(list, n, both);
        ck_assert_int_eq(called(list, n, wire) != NULL, nside > 1);
        ck_assert_int_eq(called(list, n, damper) != NULL, nside > 2);
        ck_assert_int_eq(e != NULL, nside > 2);
        if (e != NULL) {
            ck_assert_double_eq(plan__set_of(e, "key_wire.k")->value, 0.0);
            ck_assert_double_eq(plan__set_of(e, "key_damper.normal.F0")->value, 0.0);
        }
        free(list);
    }
    lab_close(model);
}
END_TEST

START_TEST(proposed_experiments_are_feasible)
{
    static const char *const with_sensor[] = {"string_force", "dip_force", "hammer_angle"};
    static const char *const between_parts[] = {"notch_force", "load_force"};
    int n = 0, seen = 0;
    lab_model *model = NULL;
    lab_plan_def def = lab_plan_def_default();
    ck_assert_stein(lab_open(&model, "models/stein1788.yaml", NULL, err));
    lab_experiment *list =
        experiments_of(model, -0.005, 1.2, &def, &n); // noise around 0 pulls at nothing
    for (int i = 0; i < n; i++) {
        ck_assert_int_ne(list[i].shape, LAB_SHAPE_SWING);
        for (int k = 0; k < 3; k++) {
            seen += strcmp(list[i].channel, with_sensor[k]) == 0;
        }
        for (int k = 0; k < 2; k++) {
            ck_assert_str_ne(list[i].channel, between_parts[k]);
        }
    }
    ck_assert_int_eq(seen, 3);
    free(list);
    list = experiments_of(model, -1.1, 1.2, &def, &n);
    ck_assert_int_eq(list[0].shape, LAB_SHAPE_SWING);
    free(list);
    for (def.ninstrument = 0; def.ninstrument < 2; def.ninstrument++) {
        def.instrument = &with_sensor[2];
        seen = 0;
        list = experiments_of(model, -1.1, 1.2, &def, &n);
        for (int i = 0; i < n; i++) {
            int measured = list[i].channel[0] != '\0';
            ck_assert(!measured || strcmp(list[i].channel, with_sensor[2]) == 0);
            seen += measured;
        }
        ck_assert_int_eq(seen, def.ninstrument);
        free(list);
    }
    lab_close(model);
}
END_TEST

START_TEST(the_report_names_the_next_experiment_and_lists_detectable_effects)
{
    rotor r = rotor_diagnosed(truth[0], start, 1);
    const char *path = in_folder("report.html");
    char *text = NULL;
    size_t size = 0;
    ck_assert_stein(lab_diagnosis_page(path, r.d, err));
    ck_assert_stein(lab__read_file(path, &text, &size, err));
    ck_assert_ptr_nonnull(strstr(text, "Best of the experiments tried: <b>wheel.initial.position"));
    ck_assert_ptr_nonnull(strstr(text, "<section id=\"seen\">"));
    ck_assert_ptr_nonnull(strstr(text, "1 present: "));
    free(text);
    rotor_free(&r);
}
END_TEST

START_TEST(a_diagnosis_is_planned_for_from_its_file_as_from_memory)
{
    rotor r = rotor_diagnosed(truth[0], start, 1);
    lab_diagnosis *d = NULL;
    const char *path = in_folder("diagnosis.json");
    ck_assert_stein(lab_diagnosis_json(path, r.d, err));
    ck_assert_stein(lab_diagnosis_read(&d, path, r.model, err));
    ck_assert_int_eq(d->verdict, r.d->verdict);
    ck_assert_int_eq(d->nsuspect, 1 + r.d->nrival);
    ck_assert_int_eq(d->conditions.nchannel, 1);
    ck_assert(d->conditions.until == r.d->conditions.until);
    lab_plan *a = planned(&r, r.d), *b = planned(&r, d);
    ck_assert_int_eq(a->n, b->n);
    for (int i = 0; i < a->n; i++) {
        ck_assert_str_eq(a->experiment[i].name, b->experiment[i].name);
        ck_assert(a->experiment[i].odds == b->experiment[i].odds);
        ck_assert_int_eq(a->experiment[i].repeats, b->experiment[i].repeats);
    }
    lab_plan_destroy(a);
    lab_plan_destroy(b);
    lab_diagnosis_destroy(d);

    // without a rival there is nothing to plan
    int nrival = r.d->nrival;
    lab_plan *none = NULL;
    r.d->nrival = 0;
    ck_assert_stein(lab_plan_make(&none, in_folder("rotor.yaml"), r.model, r.d, NULL, err));
    ck_assert_int_eq(none->n, 0);
    ck_assert_int_eq(none->nrival, 0);
    lab_plan_destroy(none);
    r.d->nrival = nrival;
    rotor_free(&r);
}
END_TEST

Suite *plan_suite(void)
{
    Suite *s = suite_create("plan");
    TCase *tc = tcase_create("plan");
    tcase_set_timeout(tc, 240);
    tcase_add_checked_fixture(tc, make_folder, remove_folder);
    tcase_add_test(tc, odds_of_draws_are_those_of_dense_algebra);
    tcase_add_test(tc, unpredictable_samples_carry_no_evidence);
    tcase_add_test(tc, models_with_equal_predictions_are_never_separated);
    tcase_add_test(tc, the_column_of_a_number_of_the_file_is_the_same_in_both);
    tcase_add_test(tc, curvature_on_the_way_to_other_numbers_is_no_evidence);
    tcase_add_loop_test(tc, the_proposed_stroke_separates_two_drags, 0, 2);
    tcase_add_test(tc, readings_of_a_check_agree_with_a_scale);
    tcase_add_test(tc, readings_of_a_felt_and_of_a_length_are_those_of_the_file_and_more);
    tcase_add_loop_test(tc, a_check_of_the_instrument_settles_it, 0, 2);
    tcase_add_loop_test(tc, removable_parts_are_taken_off, 0, 2);
    tcase_add_test(tc, all_that_comes_off_is_taken_off_at_once);
    tcase_add_test(tc, where_one_stroke_is_not_enough_things_are_done_at_once);
    tcase_add_test(tc, changes_of_two_experiments_are_combined);
    tcase_add_test(tc, a_plan_begins_where_the_numbers_of_a_rival_were_found);
    tcase_add_test(tc, invalid_correlations_are_reported);
    tcase_add_test(tc, an_instrument_that_is_no_output_is_refused);
    tcase_add_test(tc, proposed_experiments_are_feasible);
    tcase_add_test(tc, the_report_names_the_next_experiment_and_lists_detectable_effects);
    tcase_add_test(tc, a_diagnosis_is_planned_for_from_its_file_as_from_memory);
    suite_add_tcase(s, tc);
    return s;
}
