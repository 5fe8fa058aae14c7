/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_hypotheses.c - hypotheses as values, the table of rows, linear models written by hand and
 * the proposals from them, and the trace. Nothing is simulated.
 */
#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lab_support.h"
#include "proposals.h"
#include "suites.h"

enum { COULOMB, PRELOAD, DRAG, MASS, CLOCK, DELAY, CENTRE, KINDS, MOST = 12 };

/* ---- elements of tables ---- */

/* a problem that has nothing but candidates */
typedef struct world {
    lab_candidate candidate[KINDS];
    diag__problem q;
    diag__table t;
} world;

static void make_world(world *w)
{
    static const char *const kind[KINDS] = {
        "coulomb_friction", "preload",      "quadratic_drag", "mass",
        "time_base",        "sensor_delay", "centre"};
    *w = (world){.q = {.n = KINDS}};
    for (int i = 0; i < KINDS; i++) {
        lab_candidate *c = &w->candidate[i];
        *c = (lab_candidate){.effect = lab_effect_find(kind[i]), .place = "rod", .limit = 2.0};
        ck_assert_ptr_nonnull(c->effect);
        for (int k = 0; k < LAB_SIDES; k++) {
            c->side[k].param = -1;
        }
    }
    w->q.candidate = w->candidate;
}

static diag__hypothesis set_of(int n, const int *cause)
{
    diag__hypothesis h = {.n = 0};
    for (int i = 0; i < n; i++) {
        h = diag__with(h, cause[i]);
    }
    return h;
}
#define HYPOTHESIS(...) \
    set_of((int)(sizeof((int[]){__VA_ARGS__}) / sizeof(int)), (int[]){__VA_ARGS__})

/* a row of the table with these amounts [limits], standard deviations of a tenth */
static diag__row *add_row(world *w, diag__hypothesis h, double objective, const double *amount)
{
    diag__row *row = calloc(1, sizeof *row);
    size_t np = DIAG_CAUSES * FIT__NUMBERS;
    ck_assert_ptr_nonnull(row);
    row->x = calloc(2 * np, sizeof *row->x);
    ck_assert_ptr_nonnull(row->x);
    row->sd = row->x + np;
    row->h = h;
    row->objective = objective;
    row->chi2_dof = 1.0;
    row->converged = 1;
    row->by = &diag__propose_add;
    row->parent = -1;
    for (int i = 0; i < h.n; i++) {
        row->cause[i] = w->candidate[h.cause[i]];
        row->x[diag__unknown_at(row, i)] = amount != NULL ? amount[i] : 0.5;
        row->sd[diag__unknown_at(row, i)] = 0.1 * row->x[diag__unknown_at(row, i)];
    }
    ck_assert_stein(diag__table_add(&w->t, row, err));
    return row;
}

/* a world with one fitted row, of 300 samples */
static diag__row *only_row(world *w, diag__hypothesis h, double objective)
{
    make_world(w);
    diag__row *row = add_row(w, h, objective, NULL);
    row->p.samples = 300;
    return row;
}

/* the model has lost its records */
static diag__row *add_failed(world *w, diag__hypothesis h, const char *why)
{
    diag__row *row = add_row(w, h, INFINITY, NULL);
    row->chi2_dof = INFINITY;
    row->failed = lab__text("%s", why);
    return row;
}

/* ---- hypotheses ---- */

START_TEST(a_hypothesis_is_the_same_in_whatever_order_its_causes_come)
{
    static const int order[6][3] = {{2, 5, 9}, {2, 9, 5}, {5, 2, 9},
                                    {5, 9, 2}, {9, 2, 5}, {9, 5, 2}};
    const diag__hypothesis all = set_of(3, order[0]);
    for (int i = 0; i < 6; i++) {
        diag__hypothesis h = set_of(3, order[i]);
        ck_assert(diag__equals(&h, &all));
        for (int k = 0; k < 3; k++) {
            ck_assert_int_eq(h.cause[k], order[0][k]);
        }
    }
}
END_TEST

START_TEST(a_cause_is_in_a_hypothesis_once)
{
    diag__hypothesis h = HYPOTHESIS(4, 7);
    ck_assert_int_eq(diag__with(h, 4).n, 2);
    ck_assert(diag__has(&h, 4) && diag__has(&h, 7) && !diag__has(&h, 5));
}
END_TEST

START_TEST(a_hypothesis_has_no_more_causes_than_there_is_room_for)
{
    diag__hypothesis h = {.n = 0};
    for (int k = 0; k < DIAG_CAUSES + 2; k++) {
        h = diag__with(h, k);
    }
    ck_assert_int_eq(h.n, DIAG_CAUSES);
    ck_assert(!diag__has(&h, DIAG_CAUSES));
}
END_TEST

START_TEST(a_cause_that_is_taken_away_leaves_the_hypothesis_without_it)
{
    diag__hypothesis h = HYPOTHESIS(4, 7, 1), less = HYPOTHESIS(1, 7), none = {.n = 0};
    diag__hypothesis without = diag__without(h, 4);
    ck_assert(diag__equals(&without, &less));
    without = diag__without(h, 5); // which it has not
    ck_assert(diag__equals(&without, &h));
    without = diag__without(diag__without(less, 1), 7);
    ck_assert(diag__equals(&without, &none));
}
END_TEST

START_TEST(hypotheses_are_equal_only_with_the_same_causes)
{
    diag__hypothesis a = HYPOTHESIS(1, 2), b = HYPOTHESIS(1, 3), c = HYPOTHESIS(1);
    ck_assert(!diag__equals(&a, &b) && !diag__equals(&a, &c) && diag__equals(&a, &a));
}
END_TEST

START_TEST(a_cause_comes_and_goes_and_the_hypothesis_is_a_value)
{
    const diag__hypothesis h = HYPOTHESIS(3, 6);
    diag__hypothesis more = diag__with(h, 5), back = diag__without(more, 5);
    ck_assert_int_eq(h.n, 2);
    ck_assert(diag__equals(&back, &h));
}
END_TEST

START_TEST(numbers_of_one_element_are_related)
{
    lab_candidate a = {.place = "stop"}, b = {.place = "stop.normal.c"}, c = {.place = "stopper"};
    ck_assert(diag__related(&a, &b) && diag__related(&b, &a) && diag__related(&a, &a));
    ck_assert(!diag__related(&a, &c) && !diag__related(&c, &b));
}
END_TEST

/* ---- causes of a part of the records ---- */

START_TEST(a_cause_of_a_part_of_the_records_is_another_cause)
{
    const lab_data data = {.number = 7};
    lab_data *list[] = {(lab_data *)&data, (lab_data *)&data, (lab_data *)&data};
    const lab_dataset fitted = {3, list};
    world w;
    make_world(&w);
    w.q.records = 9;
    w.q.fitted = &fitted;
    int one = diag__in_record(&w.q, MASS, 5), from = diag__from_record(&w.q, MASS, 5);
    const int cause[] = {MASS, one, from};
    const int begin[] = {0, 5, 5}, end[] = {0, 5, 0};
    for (int i = 0; i < 3; i++) {
        lab_candidate c = diag__candidate(&w.q, cause[i]);
        ck_assert_ptr_eq(diag__base(&w.q, cause[i]), &w.candidate[MASS]);
        ck_assert(c.from == begin[i] && c.until == end[i]);
        ck_assert_int_eq(diag__is_scoped(&w.q, cause[i]), i > 0);
        ck_assert_double_eq_tol(diag__price(&w.q, cause[i]), i > 0 ? 2.0 * log(3.0) : 0.0, 1e-12);
        for (int r = 1; r <= 9; r++) {
            ck_assert_int_eq(lab_candidate_acts(&c, r), i == 0 || (i == 1 ? r == 5 : r >= 5));
        }
        for (int k = 0; k < i; k++) {
            lab_candidate other = diag__candidate(&w.q, cause[k]);
            ck_assert_int_ne(cause[i], cause[k]);
            ck_assert(!diag__is_same(&c, &other));
        }
    }
}
END_TEST

START_TEST(changes_of_a_hypothesis_begin_at_one_record)
{
    world w;
    make_world(&w);
    w.q.records = 9;
    diag__hypothesis same = HYPOTHESIS(diag__from_record(&w.q, MASS, 5),
                                       diag__from_record(&w.q, CENTRE, 5), COULOMB),
                     apart = HYPOTHESIS(diag__from_record(&w.q, MASS, 5),
                                        diag__from_record(&w.q, CENTRE, 6)),
                     beside = HYPOTHESIS(diag__from_record(&w.q, MASS, 5),
                                         diag__in_record(&w.q, CENTRE, 2));
    ck_assert(diag__is_coherent(&w.q, &same) && diag__is_coherent(&w.q, &beside));
    ck_assert(!diag__is_coherent(&w.q, &apart));
}
END_TEST

/* ---- the table ---- */

START_TEST(the_best_row_of_a_hypothesis_stands_for_it)
{
    world w;
    make_world(&w);
    diag__hypothesis a = HYPOTHESIS(COULOMB), b = HYPOTHESIS(PRELOAD), none = {.n = 0};
    add_row(&w, none, 900.0, NULL);
    add_row(&w, a, 500.0, NULL);
    diag__row *best = add_row(&w, a, 400.0, NULL);
    add_row(&w, a, 450.0, NULL);
    ck_assert_ptr_eq(diag__find(&w.t, &a), best);
    ck_assert_ptr_null(diag__find(&w.t, &b));
    ck_assert_ptr_eq(diag__best(&w.q, &w.t, 1), best);
    ck_assert_ptr_eq(diag__best(&w.q, &w.t, -1), best);
    ck_assert_ptr_eq(diag__best(&w.q, &w.t, 0), w.t.row[0]);
    ck_assert_ptr_null(diag__best(&w.q, &w.t, 2));
    ck_assert_int_eq(diag__index(&w.t, best), 2);
    ck_assert_int_eq(diag__index(&w.t, NULL), -1);
    diag__table_free(&w.t);
}
END_TEST

START_TEST(impossible_rows_are_never_the_best)
{
    const double negative[] = {-0.5}, huge[] = {3.1}, both[] = {0.4, -0.3};
    world w;
    make_world(&w);
    diag__row *fits[] = {add_row(&w, HYPOTHESIS(COULOMB), 100.0, negative),
                         add_row(&w, HYPOTHESIS(PRELOAD), 101.0, huge),
                         add_row(&w, HYPOTHESIS(MASS, COULOMB), 102.0, (double[]){-0.4, 0.3}),
                         add_row(&w, HYPOTHESIS(COULOMB, DRAG), 103.0, both),
                         add_failed(&w, HYPOTHESIS(DRAG), "it falls")};
    // candidates come by number: friction is the first one of them
    ck_assert_int_eq(fits[2]->h.cause[0], COULOMB);
    fits[1]->chi2_dof = 50.0; // far from noise
    for (int i = 0; i < 5; i++) {
        ck_assert_msg(!diag__is_possible(&w.q, fits[i]), "row %d", i);
    }
    ck_assert_ptr_null(diag__best(&w.q, &w.t, -1));
    diag__row *possible = add_row(&w, HYPOTHESIS(PRELOAD), 700.0, negative); // to either side
    ck_assert(diag__is_possible(&w.q, possible));
    ck_assert_ptr_eq(diag__best(&w.q, &w.t, -1), possible);
    diag__table_free(&w.t);
}
END_TEST

/* A plausible size is a guess: what leaves noise may be ten times as large, and of no other sign.
 */
START_TEST(an_amount_that_explains_everything_may_be_larger_than_plausible)
{
    const double large[] = {29.0}, huge[] = {31.0}, negative[] = {-0.5};
    world w;
    make_world(&w);
    diag__row *row = add_row(&w, HYPOTHESIS(PRELOAD), 100.0, large);
    ck_assert(diag__is_possible(&w.q, row));
    row->chi2_dof = 50.0;
    ck_assert(!diag__is_possible(&w.q, row));
    ck_assert(!diag__is_possible(&w.q, add_row(&w, HYPOTHESIS(PRELOAD), 100.0, huge)));
    ck_assert(!diag__is_possible(&w.q, add_row(&w, HYPOTHESIS(COULOMB), 100.0, negative)));
    diag__table_free(&w.t);
}
END_TEST

START_TEST(an_amount_is_possible_within_its_sign_and_size)
{
    world w;
    make_world(&w);
    ck_assert(diag__thinkable(&w.candidate[COULOMB], 0.5));
    ck_assert(!diag__thinkable(&w.candidate[COULOMB], -0.5));
    ck_assert(!diag__thinkable(&w.candidate[COULOMB], 0.0));
    ck_assert(diag__thinkable(&w.candidate[PRELOAD], -0.5));
    ck_assert(!diag__thinkable(&w.candidate[PRELOAD], 3.5));
    ck_assert(diag__thinkable(&w.candidate[CLOCK], 3.5)); // gravity and lengths are its aliases
    ck_assert(!diag__thinkable(&w.candidate[PRELOAD], NAN));
}
END_TEST

START_TEST(the_incumbent_has_a_cause_more_only_where_that_gains)
{
    world w;
    make_world(&w);
    diag__row *null = add_row(&w, (diag__hypothesis){.n = 0}, 1000.0, NULL);
    ck_assert_ptr_eq(diag__incumbent(&w.q, &w.t), null);
    add_row(&w, HYPOTHESIS(COULOMB), 1000.0 - diag__least_gain + 1.0, NULL);
    ck_assert_ptr_eq(diag__incumbent(&w.q, &w.t), null);
    diag__row *one = add_row(&w, HYPOTHESIS(PRELOAD), 1000.0 - diag__least_gain - 1.0, NULL);
    ck_assert_ptr_eq(diag__incumbent(&w.q, &w.t), one);
    add_row(&w, HYPOTHESIS(COULOMB, PRELOAD), one->objective - diag__least_gain + 1.0, NULL);
    ck_assert_ptr_eq(diag__incumbent(&w.q, &w.t), one);
    diag__row *two = add_row(&w, HYPOTHESIS(DRAG, PRELOAD), 700.0, NULL);
    ck_assert_ptr_eq(diag__incumbent(&w.q, &w.t), two);
    diag__table_free(&w.t);
}
END_TEST

/* ---- linear models ---- */

enum { COLUMNS = 6 };
typedef struct model {
    diag__linear l;
    int cause[COLUMNS];
    double step[COLUMNS], I[COLUMNS * COLUMNS], s[COLUMNS];
    const char *unseen[KINDS];
} model;

/* columns of these candidates, each as long as `size`, alike by `likeness`; the residual belongs to
 * the true amounts. The first `own` belong to the row. */
static void make_model(model *m, const diag__row *row, int own, int n, const int *cause,
                       double size, const double *likeness, const double *truth)
{
    *m = (model){.l = {.row = row,
                       .own = own,
                       .n = n,
                       .cause = m->cause,
                       .step = m->step,
                       .I = m->I,
                       .s = m->s,
                       .unseen = m->unseen,
                       .samples = 300.0}};
    for (int i = 0; i < n; i++) {
        m->cause[i] = cause[i];
        for (int k = 0; k < n; k++) {
            m->I[i * n + k] = size * likeness[i * n + k];
            m->s[i] += size * likeness[i * n + k] * truth[k];
        }
    }
    m->l.square = 300.0;
    for (int i = 0; i < n; i++) {
        m->l.square += truth[i] * m->s[i];
    }
}

START_TEST(the_gain_of_one_column_is_that_of_its_closed_form)
{
    double I[] = {24.7}, s[] = {13.9}, amount[DIAG_CAUSES + 1];
    int set[] = {0};
    diag__linear l = {.n = 1, .I = I, .s = s};
    double gain = diag__linear_gain(&l, set, 1, amount);
    ck_assert_double_eq_tol(amount[0], 13.9 / 25.7, 1e-12);
    ck_assert_double_eq_tol(gain, 13.9 * 13.9 / 25.7 - log(25.7), 1e-12);
    ck_assert_double_eq(diag__linear_gain(&l, set, 0, amount), 0.0);
}
END_TEST

/* (I + 1)^-1 s by Cramer's rule, ln det (I + 1) */
START_TEST(the_gain_of_two_columns_is_that_of_their_closed_form)
{
    double I[] = {24.7, 3.0, -11.3, 3.0, 5.5, 0.7, -11.3, 0.7, 37.1}, s[] = {13.9, 2.1, -29.3};
    int set[] = {2, 0};
    double a = 37.1 + 1.0, b = -11.3, c = 24.7 + 1.0, det = a * c - b * b;
    double first = (c * -29.3 - b * 13.9) / det, second = (a * 13.9 - b * -29.3) / det;
    double amount[DIAG_CAUSES + 1];
    diag__linear l = {.n = 3, .I = I, .s = s};
    double gain = diag__linear_gain(&l, set, 2, amount);
    ck_assert_double_eq_tol(amount[0], first, 1e-12);
    ck_assert_double_eq_tol(amount[1], second, 1e-12);
    ck_assert_double_eq_tol(gain, -29.3 * first + 13.9 * second - log(det), 1e-10);
}
END_TEST

START_TEST(columns_without_a_common_solution_gain_nothing)
{
    double I[] = {1.0, 5.0, 5.0, 1.0}, s[] = {1.0, 1.0}, amount[DIAG_CAUSES + 1];
    int set[] = {0, 1};
    diag__linear l = {.n = 2, .I = I, .s = s};
    ck_assert(diag__linear_gain(&l, set, 2, amount) == -(double)INFINITY);
}
END_TEST

START_TEST(columns_are_as_alike_as_the_angle_between_them)
{
    double I[] = {4.0, -3.0, 0.0, -3.0, 9.0, 0.0, 0.0, 0.0, 0.0};
    diag__linear l = {.n = 3, .I = I};
    ck_assert_double_eq_tol(diag__likeness(&l, 0, 1), 0.5, 1e-12); // of whatever sign
    ck_assert_double_eq_tol(diag__likeness(&l, 1, 1), 1.0, 1e-12);
    ck_assert_double_eq(diag__likeness(&l, 0, 2), 0.0); // that changes nothing
}
END_TEST

static const double apart[] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

START_TEST(a_free_linear_model_expects_the_gain_of_all_records)
{
    world w;
    model m;
    make_world(&w);
    diag__row *row = add_row(&w, HYPOTHESIS(MASS), 2000.0, NULL);
    row->p.samples = 900; // three times those that were used
    make_model(&m, row, 1, 3, (int[]){MASS, PRELOAD, DRAG}, 400.0, apart, (double[]){0.1, 0.7, 0});
    int own[] = {0}, more[] = {0, 1};
    double amount[DIAG_CAUSES + 1], has = diag__linear_gain(&m.l, own, 1, amount),
                                    gain = diag__linear_gain(&m.l, more, 2, amount);
    ck_assert_double_eq_tol(diag__expected(&m.l, more, 2, amount, gain),
                            2000.0 - 3.0 * (gain - has), 1e-9);
    diag__linear_gain(&m.l, own, 1, amount);
    ck_assert_double_eq_tol(diag__expected(&m.l, own, 1, amount, has), 2000.0, 1e-9); // unchanged
    diag__table_free(&w.t);
}
END_TEST

/* with the observer the linear model gives the share of the misfit that is explained, not the
 * amount */
START_TEST(a_held_linear_model_expects_no_less_than_noise)
{
    world w;
    model m;
    double r[300], chi2 = 0.0;
    make_world(&w);
    diag__row *row = add_row(&w, (diag__hypothesis){.n = 0}, 50000.0, NULL);
    fit__stroke stroke = {.n = 300, .nch = 1, .samples = 300, .given = (int[]){1}};
    for (int i = 0; i < 300; i++) {
        r[i] = 13.0 * sin(0.37 * i);
        chi2 += r[i] * r[i];
    }
    row->p.stroke = &stroke;
    row->p.nstroke = 1;
    row->p.samples = 300;
    row->r = r;
    make_model(&m, row, 0, 3, (int[]){MASS, PRELOAD, DRAG}, 400.0, apart, (double[]){0.1, 0.7, 0});
    m.l.gain = 0.05;
    double last = row->objective;
    ck_assert_double_eq_tol(diag__expected(&m.l, NULL, 0, NULL, 0.0), last, 1e-9);
    for (double gain = 10.0; gain < 1e6; gain *= 3.0) {
        double expected = diag__expected(&m.l, NULL, 0, NULL, gain);
        ck_assert_double_le(expected, last);
        ck_assert_double_ge(expected, row->objective - (chi2 - 300.0) - 1e-6);
        last = expected;
    }
    row->p.stroke = NULL;
    row->p.nstroke = 0;
    row->r = NULL;
    diag__table_free(&w.t);
}
END_TEST

/* what an amount's freedom costs is not a share of the misfit: with large noise it is most of a
 * gain
 */
START_TEST(where_noise_is_estimated_the_residual_counts_by_its_logarithm)
{
    world w;
    model m;
    make_world(&w);
    diag__row *row = add_row(&w, (diag__hypothesis){.n = 0}, 5000.0, NULL);
    row->p.samples = 900;
    row->memory = 9.0;
    row->chi2_dof = 1e4;
    row->scale = sqrt(row->chi2_dof * row->memory);
    make_model(&m, row, 0, 3, (int[]){MASS, PRELOAD, DRAG}, 1e5, apart,
               (double[]){5.5e-3, 6e-4, 0});
    m.l.square = 4.0;
    for (int gain = 0; gain < 2; gain++) {
        int first[] = {0}, second[] = {1};
        double amount[DIAG_CAUSES + 1];
        m.l.gain = gain ? 0.05 : 0.0;
        double cost = log(1e5 + 1.0), of = 550.0 * 550.0 / (1e5 + 1.0) / 4.0;
        double fall = diag__linear_gain(&m.l, first, 1, amount);
        double most = diag__expected(&m.l, first, 1, amount, fall);
        ck_assert_double_lt(fall, 0.0); // and yet it is worth a fit
        ck_assert_double_eq_tol(most, 5000.0 + 100.0 * log(1.0 - of) + cost, 1.0);
        fall = diag__linear_gain(&m.l, second, 1, amount);
        ck_assert_double_gt(diag__expected(&m.l, second, 1, amount, fall), most);
    }
    diag__table_free(&w.t);
}
END_TEST

/* ---- proposers ---- */

static int propose(const diag__proposer *by, const world *w, const model *m, diag__proposal *list,
                   int most)
{
    int n = by->propose(&w->q, &w->t, &m->l, list, most);
    ck_assert_int_le(n, most);
    for (int i = 0; i < n; i++) {
        ck_assert_ptr_eq(list[i].by, by);
        ck_assert(i == 0 || by->removes || by->restarts ||
                  list[i].expected >= list[i - 1].expected);
        for (int k = 1; k < list[i].h.n; k++) {
            ck_assert_int_lt(list[i].h.cause[k - 1], list[i].h.cause[k]);
        }
    }
    return n;
}

START_TEST(one_cause_more_is_proposed_in_the_order_of_its_gain)
{
    world w;
    model m;
    diag__proposal list[MOST];
    diag__row *row = only_row(&w, (diag__hypothesis){.n = 0}, 2000.0);
    make_model(&m, row, 0, 3, (int[]){COULOMB, MASS, PRELOAD}, 400.0, apart,
               (double[]){0.2, 0.3, -0.9});
    ck_assert_int_eq(propose(&diag__propose_add, &w, &m, list, MOST), 3);
    const int order[] = {PRELOAD, MASS, COULOMB};
    const double amount[] = {-0.9, 0.3, 0.2};
    for (int i = 0; i < 3; i++) {
        ck_assert_int_eq(list[i].h.n, 1);
        ck_assert_int_eq(list[i].h.cause[0], order[i]);
        ck_assert_double_eq_tol(list[i].amount[0], 400.0 / 401.0 * amount[i], 1e-12);
        ck_assert_double_lt(list[i].expected, 2000.0);
        ck_assert(isnan(list[i].amount[1]));
    }
    ck_assert_int_eq(propose(&diag__propose_add, &w, &m, list, 2), 2);
    diag__table_free(&w.t);
}
END_TEST

START_TEST(impossible_causes_are_not_proposed)
{
    world w;
    model m;
    diag__proposal list[MOST];
    diag__row *row = only_row(&w, (diag__hypothesis){.n = 0}, 2000.0);
    make_model(&m, row, 0, 3, (int[]){COULOMB, MASS, PRELOAD}, 400.0, apart,
               (double[]){-0.2, 0.3, 3.9});
    ck_assert_int_eq(propose(&diag__propose_add, &w, &m, list, MOST), 1);
    ck_assert_int_eq(list[0].h.cause[0], MASS);
    diag__table_free(&w.t);
}
END_TEST

START_TEST(equal_directions_are_proposed_once)
{
    const double twins[] = {1, 0.995, 0.2, 0.995, 1, 0.2, 0.2, 0.2, 1};
    world w;
    model m;
    diag__proposal list[MOST];
    diag__row *row = only_row(&w, (diag__hypothesis){.n = 0}, 2000.0);
    make_model(&m, row, 0, 3, (int[]){CENTRE, PRELOAD, MASS}, 400.0, twins,
               (double[]){0.6, 0, 0.1});
    ck_assert_int_eq(propose(&diag__propose_add, &w, &m, list, MOST), 2);
    ck_assert_int_eq(list[0].h.cause[0], CENTRE);
    ck_assert_int_eq(list[1].h.cause[0], MASS);
    diag__table_free(&w.t);
}
END_TEST

START_TEST(a_cause_more_comes_beside_those_of_the_row)
{
    world w;
    model m;
    diag__proposal list[MOST];
    diag__row *row = only_row(&w, HYPOTHESIS(MASS), 2000.0);
    // columns are not in the order of candidates: amounts go with their causes
    make_model(&m, row, 1, 3, (int[]){MASS, PRELOAD, CENTRE}, 400.0, apart,
               (double[]){-0.4, 0.7, 0.1});
    ck_assert_int_eq(propose(&diag__propose_add, &w, &m, list, MOST), 2);
    ck_assert_int_eq(list[0].h.n, 2);
    ck_assert_int_eq(list[0].h.cause[0], PRELOAD);
    ck_assert_int_eq(list[0].h.cause[1], MASS);
    ck_assert_double_eq_tol(list[0].amount[0], 0.7 * 400.0 / 401.0, 1e-12);
    ck_assert_double_eq_tol(list[0].amount[1], -0.4 * 400.0 / 401.0, 1e-12);
    diag__table_free(&w.t);
}
END_TEST

START_TEST(nothing_is_proposed_beside_as_many_causes_as_can_act)
{
    const double four[] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    world w;
    model m;
    diag__proposal list[MOST];
    diag__row *row = only_row(&w, HYPOTHESIS(COULOMB, PRELOAD, MASS), 2000.0);
    make_model(&m, row, 3, 4, (int[]){COULOMB, PRELOAD, MASS, CENTRE}, 400.0, four,
               (double[]){0.3, 0.3, 0.3, 0.7});
    ck_assert_int_eq(propose(&diag__propose_add, &w, &m, list, MOST), 0);
    ck_assert_int_eq(propose(&diag__propose_pair, &w, &m, list, MOST), 0);
    ck_assert_int_gt(propose(&diag__propose_exchange, &w, &m, list, MOST), 0);
    diag__table_free(&w.t);
}
END_TEST

/* Friction and drag act against each other: each alone explains little of what both do, and less
 * than a bystander does. */
START_TEST(a_pair_is_found_that_single_columns_hide)
{
    const double likeness[] = {1, -0.9, 0.1, -0.9, 1, 0.1, 0.1, 0.1, 1};
    world w;
    model m;
    diag__proposal list[MOST];
    diag__row *row = only_row(&w, (diag__hypothesis){.n = 0}, 9000.0);
    make_model(&m, row, 0, 3, (int[]){DRAG, COULOMB, MASS}, 1e4, likeness, (double[]){1, 1, 0});
    ck_assert_int_gt(propose(&diag__propose_add, &w, &m, list, MOST), 0);
    ck_assert_int_eq(list[0].h.cause[0], MASS);
    double alone = list[0].expected;
    ck_assert_int_gt(propose(&diag__propose_pair, &w, &m, list, MOST), 0);
    diag__hypothesis both = HYPOTHESIS(COULOMB, DRAG);
    ck_assert(diag__equals(&list[0].h, &both));
    ck_assert_double_eq_tol(list[0].amount[0], 1.0, 0.01);
    ck_assert_double_eq_tol(list[0].amount[1], 1.0, 0.01);
    ck_assert_double_lt(list[0].expected, alone - 1000.0);
    diag__table_free(&w.t);
}
END_TEST

START_TEST(two_of_the_same_direction_are_no_pair)
{
    const double likeness[] = {1, 0.97, 0.97, 1};
    world w;
    model m;
    diag__proposal list[MOST];
    diag__row *row = only_row(&w, (diag__hypothesis){.n = 0}, 9000.0);
    make_model(&m, row, 0, 2, (int[]){PRELOAD, CENTRE}, 1e4, likeness, (double[]){1, -1});
    ck_assert_int_eq(propose(&diag__propose_pair, &w, &m, list, MOST), 0);
    diag__table_free(&w.t);
}
END_TEST

/* a part has two columns, of two sizes */
START_TEST(two_columns_of_one_candidate_are_no_pair)
{
    const double likeness[] = {1, 0.5, 0.5, 1};
    world w;
    model m;
    diag__proposal list[MOST];
    diag__row *row = only_row(&w, (diag__hypothesis){.n = 0}, 9000.0);
    make_model(&m, row, 0, 2, (int[]){PRELOAD, PRELOAD}, 1e4, likeness, (double[]){1, 1});
    ck_assert_int_eq(propose(&diag__propose_pair, &w, &m, list, MOST), 0);
    diag__table_free(&w.t);
}
END_TEST

/* what explains the same as the row's cause is its rival, all else refitted */
START_TEST(another_cause_is_proposed_in_the_place_of_one)
{
    const double likeness[] = {1, 0, 0.97, 0, 1, 0, 0.97, 0, 1};
    world w;
    model m;
    diag__proposal list[MOST];
    diag__row *row = only_row(&w, HYPOTHESIS(PRELOAD, MASS), 2000.0);
    make_model(&m, row, 2, 3, (int[]){PRELOAD, MASS, CENTRE}, 400.0, likeness,
               (double[]){0.5, 0.8, 0});
    int n = propose(&diag__propose_exchange, &w, &m, list, MOST);
    ck_assert_int_eq(n, 2);
    diag__hypothesis rival = HYPOTHESIS(MASS, CENTRE), worse = HYPOTHESIS(PRELOAD, CENTRE);
    ck_assert(diag__equals(&list[0].h, &rival) && diag__equals(&list[1].h, &worse));
    ck_assert_double_gt(list[0].expected, 2000.0); // it does not do quite as well
    ck_assert_double_gt(list[1].expected, list[0].expected + 50.0);
    ck_assert_double_eq_tol(list[0].amount[1], 0.97 * 0.5, 0.01);
    diag__table_free(&w.t);
}
END_TEST

START_TEST(nothing_is_exchanged_where_there_is_no_cause)
{
    world w;
    model m;
    diag__proposal list[MOST];
    diag__row *row = only_row(&w, (diag__hypothesis){.n = 0}, 2000.0);
    make_model(&m, row, 0, 3, (int[]){PRELOAD, MASS, CENTRE}, 400.0, apart, (double[]){1, 1, 1});
    ck_assert_int_eq(propose(&diag__propose_exchange, &w, &m, list, MOST), 0);
    ck_assert_int_eq(propose(&diag__propose_drop, &w, &m, list, MOST), 0);
    ck_assert_int_eq(propose(&diag__propose_restart, &w, &m, list, MOST), 0);
    diag__table_free(&w.t);
}
END_TEST

START_TEST(each_of_several_causes_is_left_out_once)
{
    world w;
    model m;
    diag__proposal list[MOST];
    diag__row *row = only_row(&w, HYPOTHESIS(PRELOAD, DRAG, MASS), 2000.0);
    make_model(&m, row, 3, 3, (int[]){PRELOAD, DRAG, MASS}, 400.0, apart, (double[]){0.5, 0, 0.8});
    ck_assert_int_eq(propose(&diag__propose_drop, &w, &m, list, MOST), 3);
    for (int i = 0; i < 3; i++) {
        diag__hypothesis less = diag__without(row->h, row->h.cause[i]);
        ck_assert(diag__equals(&list[i].h, &less));
    }
    // of the drag nothing is there: without it the freedom of one amount is saved
    ck_assert_double_lt(list[1].expected, 2000.0);
    ck_assert_double_gt(list[0].expected, 2050.0);
    ck_assert_double_gt(list[2].expected, 2050.0);
    diag__table_free(&w.t);
}
END_TEST

START_TEST(a_single_cause_is_not_left_out_again)
{
    world w;
    model m;
    diag__proposal list[MOST];
    make_world(&w);
    diag__row *row = add_row(&w, HYPOTHESIS(PRELOAD), 2000.0, NULL); // the null row is there
    row->p.samples = 300;
    make_model(&m, row, 1, 3, (int[]){PRELOAD, DRAG, MASS}, 400.0, apart, (double[]){0.5, 0, 0.8});
    ck_assert_int_eq(propose(&diag__propose_drop, &w, &m, list, MOST), 0);
    diag__table_free(&w.t);
}
END_TEST

START_TEST(a_fit_begins_again_where_its_linear_model_predicts_another_amount)
{
    world w;
    model m;
    diag__proposal list[MOST];
    make_world(&w);
    const double is[] = {0.5};
    diag__row *row = add_row(&w, HYPOTHESIS(PRELOAD), 2000.0, is);
    row->p.samples = 300;
    make_model(&m, row, 1, 3, (int[]){PRELOAD, DRAG, MASS}, 400.0, apart, (double[]){0.51, 0, 0});
    ck_assert_int_eq(propose(&diag__propose_restart, &w, &m, list, MOST), 0); // it stands there
    make_model(&m, row, 1, 3, (int[]){PRELOAD, DRAG, MASS}, 400.0, apart, (double[]){1.4, 0, 0});
    ck_assert_int_eq(propose(&diag__propose_restart, &w, &m, list, MOST), 1);
    ck_assert(diag__equals(&list[0].h, &row->h));
    ck_assert_double_eq_tol(list[0].amount[0], 1.4, 0.01);
    diag__table_free(&w.t);
}
END_TEST

START_TEST(a_number_beside_an_amount_begins_further_up_and_further_down)
{
    world w;
    model m;
    diag__proposal list[MOST];
    make_world(&w);
    const double is[] = {0.5};
    diag__row *row = add_row(&w, HYPOTHESIS(COULOMB), 2000.0, is);
    row->p.samples = 300;
    row->cause[0].side[0] = (lab_side){.name = "w", .param = 5, .lo = 0.01, .hi = 1.0};
    row->x[diag__unknown_at(row, 0) + 1] = 0.3;
    make_model(&m, row, 1, 3, (int[]){COULOMB, DRAG, MASS}, 400.0, apart, (double[]){0.5, 0, 0});
    ck_assert_int_eq(propose(&diag__propose_restart, &w, &m, list, MOST), 2);
    ck_assert_double_lt(list[0].side[0], 0.3 - 0.5);
    ck_assert_double_gt(list[1].side[0], 0.3 + 0.5);
    ck_assert(isnan(list[0].amount[0])); // all else as the row has it
    diag__table_free(&w.t);
}
END_TEST

/* ---- trace ---- */

static void skip_space(const char **s)
{
    while (isspace((unsigned char)**s)) {
        ++*s;
    }
}

/* a value of JSON (RFC 8259); no escapes are expected in texts. @return 0: it is none */
static int json_value(const char **s);

static int json_text(const char **s)
{
    if (**s != '"') {
        return 0;
    }
    for (++*s; **s != '"'; ++*s) {
        if (**s == '\0' || **s == '\\' || (unsigned char)**s < ' ') {
            return 0;
        }
    }
    ++*s;
    return 1;
}

static int json_list(const char **s, char close)
{
    ++*s;
    skip_space(s);
    for (int first = 1; **s != close; first = 0) {
        if (!first && *(*s)++ != ',') {
            return 0;
        }
        skip_space(s);
        if (close == '}' && (!json_text(s) || *(*s)++ != ':')) {
            return 0;
        }
        if (!json_value(s)) {
            return 0;
        }
    }
    ++*s;
    return 1;
}

static int json_value(const char **s)
{
    static const char *const word[] = {"true", "false", "null"};
    int ok = 0;
    skip_space(s);
    if (**s == '{' || **s == '[') {
        ok = json_list(s, **s == '{' ? '}' : ']');
    } else if (**s == '"') {
        ok = json_text(s);
    } else if (**s == '-' || isdigit((unsigned char)**s)) {
        char *end = NULL;
        (void)strtod(*s, &end);
        ok = end != *s && strncmp(*s, "-i", 2) != 0 && strncmp(*s, "-n", 2) != 0;
        *s = end;
    }
    for (int i = 0; !ok && i < 3; i++) {
        ok = strncmp(*s, word[i], strlen(word[i])) == 0;
        *s += ok ? strlen(word[i]) : 0;
    }
    skip_space(s);
    return ok;
}

START_TEST(a_trace_is_one_object_a_row)
{
    static const char *const has[] = {
        "\"row\":",      "\"source\":",   "\"parent\":",    "\"hypothesis\":",
        "\"evidence\":", "\"chi2_dof\":", "\"remainder\":", "\"converged\":",
        "\"possible\":", "\"strokes\":",  "\"seconds\":"};
    world w;
    char line[4000];
    make_world(&w);
    add_row(&w, (diag__hypothesis){.n = 0}, 2000.0, NULL);
    add_row(&w, HYPOTHESIS(PRELOAD), 1200.0, NULL)->parent = 0;
    add_row(&w, HYPOTHESIS(DRAG, PRELOAD, MASS), 900.0, (double[]){0.1, -0.2, 0.3})->strokes = 1788;
    add_failed(&w, HYPOTHESIS(CENTRE, COULOMB), "\"it\" falls\n");
    FILE *f = fopen(in_folder("trace"), "w+");
    ck_assert_ptr_nonnull(f);
    for (int i = 0; i < w.t.n; i++) {
        ck_assert_stein(diag__trace_row(f, &w.q, &w.t, w.t.row[i]));
    }
    rewind(f);
    for (int i = 0; i < w.t.n; i++) {
        ck_assert_ptr_nonnull(fgets(line, sizeof line, f));
        const char *s = line;
        ck_assert_msg(line[0] == '{' && json_value(&s) && *s == '\0', "no JSON: %s", line);
        text_has(line, has, sizeof has / sizeof *has);
        char row[20];
        snprintf(row, sizeof row, "\"row\":%d,", i);
        ck_assert_ptr_nonnull(strstr(line, row));
        int causes = 0;
        for (const char *at = line; (at = strstr(at, "\"kind\":")) != NULL; at++) {
            causes++;
        }
        ck_assert_int_eq(causes, w.t.row[i]->h.n);
        if (i == 1) { // half of a limit of 2
            const char *const is[] = {"\"kind\":\"preload\",\"place\":\"rod\"", "\"amount\":1,",
                                      "\"evidence\":-600,", "\"parent\":0,", "\"possible\":true"};
            text_has(line, is, sizeof is / sizeof *is);
        } else if (i == 2) {
            const char *const is[] = {"\"possible\":false", "\"strokes\":1788,"};
            text_has(line, is, sizeof is / sizeof *is);
        } else if (i == 3) {
            const char *const is[] = {"\"evidence\":null", "\"chi2_dof\":null", "\"amount\":null"};
            text_has(line, is, sizeof is / sizeof *is);
        }
    }
    ck_assert_ptr_null(fgets(line, sizeof line, f));
    fclose(f);
    diag__table_free(&w.t);
}
END_TEST

START_TEST(a_proposer_without_proposals_differs_from_one_that_is_ranked_out)
{
    const diag__counted of[] = {
        {.by = &diag__propose_add, .n = {[DIAG_TRIED] = 2, [DIAG_UNEXPECTED] = 5, [DIAG_FULL] = 1}},
        {.by = &diag__propose_merge}};
    char line[600];
    FILE *f = fopen(in_folder("proposals"), "w+");
    ck_assert_ptr_nonnull(f);
    ck_assert_stein(diag__trace_proposals(f, 3, 1, of, 2));
    rewind(f);
    ck_assert_ptr_nonnull(fgets(line, sizeof line, f));
    ck_assert_str_eq(line,
                     "{\"linearised\":3,\"held\":true,\"proposers\":["
                     "{\"proposer\":\"A\",\"proposals\":8,\"tried\":2,\"unexpected\":5,\"full\":1},"
                     "{\"proposer\":\"M\",\"proposals\":0}]}\n");
    fclose(f);
}
END_TEST

START_TEST(letters_of_proposers_are_unique)
{
    const diag__proposer *const all[] = {
        &diag__propose_moved, &diag__propose_add,   &diag__propose_pair, &diag__propose_exchange,
        &diag__propose_merge, &diag__propose_drop,  &diag__propose_twin, &diag__propose_restart,
        &diag__step_null,     &diag__step_settings, &diag__step_noise,   &diag__step_bodies,
        &diag__step_single,   &diag__step_longer,   &diag__step_factor};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        for (size_t k = 0; k < i; k++) {
            ck_assert_int_ne(all[i]->letter, all[k]->letter);
            ck_assert_str_ne(all[i]->name, all[k]->name);
        }
    }
}
END_TEST

START_TEST(a_trace_that_cannot_be_written_is_reported)
{
    world w;
    make_world(&w);
    diag__row *row = add_row(&w, (diag__hypothesis){.n = 0}, 2000.0, NULL);
    FILE *f = fopen("/dev/full", "w");
    ck_assert_ptr_nonnull(f);
    ck_assert_int_eq(diag__trace_row(f, &w.q, &w.t, row), STEIN_EIO);
    ck_assert_int_eq(diag__trace_proposals(f, 0, 0, NULL, 0), STEIN_EIO);
    fclose(f);
    diag__table_free(&w.t);
}
END_TEST

Suite *hypotheses_suite(void)
{
    Suite *suite = suite_create("hypotheses");
    TCase *tc = tcase_create("values");
    tcase_add_test(tc, a_hypothesis_is_the_same_in_whatever_order_its_causes_come);
    tcase_add_test(tc, a_cause_is_in_a_hypothesis_once);
    tcase_add_test(tc, a_hypothesis_has_no_more_causes_than_there_is_room_for);
    tcase_add_test(tc, a_cause_that_is_taken_away_leaves_the_hypothesis_without_it);
    tcase_add_test(tc, hypotheses_are_equal_only_with_the_same_causes);
    tcase_add_test(tc, a_cause_comes_and_goes_and_the_hypothesis_is_a_value);
    tcase_add_test(tc, numbers_of_one_element_are_related);
    suite_add_tcase(suite, tc);

    tc = tcase_create("table");
    tcase_add_test(tc, a_cause_of_a_part_of_the_records_is_another_cause);
    tcase_add_test(tc, changes_of_a_hypothesis_begin_at_one_record);
    tcase_add_test(tc, the_best_row_of_a_hypothesis_stands_for_it);
    tcase_add_test(tc, impossible_rows_are_never_the_best);
    tcase_add_test(tc, an_amount_that_explains_everything_may_be_larger_than_plausible);
    tcase_add_test(tc, an_amount_is_possible_within_its_sign_and_size);
    tcase_add_test(tc, the_incumbent_has_a_cause_more_only_where_that_gains);
    suite_add_tcase(suite, tc);

    tc = tcase_create("linear");
    tcase_add_test(tc, the_gain_of_one_column_is_that_of_its_closed_form);
    tcase_add_test(tc, the_gain_of_two_columns_is_that_of_their_closed_form);
    tcase_add_test(tc, columns_without_a_common_solution_gain_nothing);
    tcase_add_test(tc, columns_are_as_alike_as_the_angle_between_them);
    tcase_add_test(tc, a_free_linear_model_expects_the_gain_of_all_records);
    tcase_add_test(tc, a_held_linear_model_expects_no_less_than_noise);
    tcase_add_test(tc, where_noise_is_estimated_the_residual_counts_by_its_logarithm);
    suite_add_tcase(suite, tc);

    tc = tcase_create("proposers");
    tcase_add_test(tc, one_cause_more_is_proposed_in_the_order_of_its_gain);
    tcase_add_test(tc, impossible_causes_are_not_proposed);
    tcase_add_test(tc, equal_directions_are_proposed_once);
    tcase_add_test(tc, a_cause_more_comes_beside_those_of_the_row);
    tcase_add_test(tc, nothing_is_proposed_beside_as_many_causes_as_can_act);
    tcase_add_test(tc, a_pair_is_found_that_single_columns_hide);
    tcase_add_test(tc, two_of_the_same_direction_are_no_pair);
    tcase_add_test(tc, two_columns_of_one_candidate_are_no_pair);
    tcase_add_test(tc, another_cause_is_proposed_in_the_place_of_one);
    tcase_add_test(tc, nothing_is_exchanged_where_there_is_no_cause);
    tcase_add_test(tc, each_of_several_causes_is_left_out_once);
    tcase_add_test(tc, a_single_cause_is_not_left_out_again);
    tcase_add_test(tc, a_fit_begins_again_where_its_linear_model_predicts_another_amount);
    tcase_add_test(tc, a_number_beside_an_amount_begins_further_up_and_further_down);
    suite_add_tcase(suite, tc);

    tc = tcase_create("trace");
    tcase_add_checked_fixture(tc, make_folder, remove_folder);
    tcase_add_test(tc, a_trace_is_one_object_a_row);
    tcase_add_test(tc, a_proposer_without_proposals_differs_from_one_that_is_ranked_out);
    tcase_add_test(tc, letters_of_proposers_are_unique);
    tcase_add_test(tc, a_trace_that_cannot_be_written_is_reported);
    suite_add_tcase(suite, tc);
    return suite;
}
