/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_order.c - which suspect leads a search, and which ones the data cannot tell from it, by what
 * their fits have reached and what their derivatives promise.
 */
#include <math.h>
#include <string.h>

#include "fit_support.h"
#include "searching.h"
#include "stein/diagnose.h"
#include "suites.h"

enum { SUSPECTS = 4, AMOUNT = 0 };

/* a search of one unknown, the amount, and no strokes, whose noise counts as stated */
typedef struct search {
    diag d;
    diag__suspect suspect[SUSPECTS];
    double x[SUSPECTS][1], sd[SUSPECTS][1];
    lab_diagnosis out;
} search;

/* fits that ended at objectives of so much, with the amount of each at half its limit */
static void begin(search *s, const char *const *kind, const char *place, const double *objective)
{
    memset(s, 0, sizeof *s);
    s->d = (diag){.suspect = s->suspect, .n = SUSPECTS, .out = &s->out};
    s->d.p.amount = AMOUNT;
    for (int i = 0; i < SUSPECTS; i++) {
        diag__suspect *a = &s->suspect[i];
        a->s.candidate.effect = lab_effect_find(kind[i]);
        ck_assert_ptr_nonnull(a->s.candidate.effect);
        snprintf(a->s.candidate.place, sizeof a->s.candidate.place, "%s", place);
        a->s.candidate.limit = 1.0;
        a->x = s->x[i];
        a->sd = s->sd[i];
        a->x[AMOUNT] = 0.5;
        a->s.refitted = a->s.possible = a->ended = 1;
        a->objective = a->promised = objective[i];
        a->s.gain = 1000.0 - objective[i];
        a->s.chi2_dof = 1.0;
    }
}

static const char *leader(const search *s)
{
    return s->d.suspect[0].s.candidate.effect->kind;
}

static const char *const joint[SUSPECTS] = {"viscous_friction", "coulomb_friction",
                                            "hardening_spring", "joint_stiffness"};

START_TEST(the_least_objective_leads)
{
    search s;
    begin(&s, joint, "key", (const double[]){30.0, 10.0, 20.0, 40.0});
    diag__sort(&s.d);
    ck_assert_str_eq(leader(&s), "coulomb_friction");
    ck_assert_str_eq(s.d.suspect[3].s.candidate.effect->kind, "joint_stiffness");
}

START_TEST(an_amount_that_is_not_physical_has_reached_nothing)
{
    search s;
    begin(&s, joint, "key", (const double[]){30.0, 10.0, 20.0, 40.0});
    s.x[1][AMOUNT] = -0.1; // a friction that drives
    s.x[2][AMOUNT] = 2.5;  // limits
    diag__sort(&s.d);
    ck_assert_str_eq(leader(&s), "viscous_friction");
    for (int i = 2; i < SUSPECTS; i++) {
        ck_assert(isinf(s.d.suspect[i].objective));
        ck_assert_str_eq(s.d.suspect[i].s.why, "its amount is not physical");
    }
}

/* the first step of a fit may find nothing with derivatives of elsewhere, a hair below 0 */
START_TEST(a_fit_that_has_found_no_step_keeps_its_promise)
{
    search s;
    begin(&s, joint, "key", (const double[]){30.0, 1010.0, 20.0, 40.0});
    s.x[1][AMOUNT] = -1e-9;
    s.suspect[1].ended = 0;
    s.suspect[1].promised = 5.0;
    diag__sort(&s.d);
    const diag__suspect *last = &s.d.suspect[SUSPECTS - 1];
    ck_assert_str_eq(last->s.candidate.effect->kind, "coulomb_friction");
    ck_assert_double_eq(last->objective, 1010.0);
    ck_assert_ptr_null(last->s.why);
}

START_TEST(a_name_goes_before_its_number)
{
    static const char *const law[SUSPECTS] = {"wrong_parameter", "contact_gap", "contact_stiffness",
                                              "contact_damping"};
    search s;
    begin(&s, law, "stop", (const double[]){10.0, 30.0, 11.5, 40.0});
    snprintf(s.suspect[0].s.candidate.place, LAB_PLACE, "stop.normal.c");
    diag__sort(&s.d);
    ck_assert_str_eq(leader(&s), "contact_stiffness");
    begin(&s, law, "stop", (const double[]){10.0, 30.0, 12.5, 40.0});
    snprintf(s.suspect[0].s.candidate.place, LAB_PLACE, "stop.normal.c");
    diag__sort(&s.d);
    ck_assert_str_eq(leader(&s), "wrong_parameter");
}

START_TEST(rivals_come_near_or_promise_to)
{
    static const struct {
        double objective[SUSPECTS], promised; /* of the third one */
        int n;
    } cases[] = {{{0.0, 9.0, 9.4, 60.0}, 9.4, 1},   // 9.2 is convincing
                 {{0.0, 9.5, 10.0, 60.0}, 10.0, 0}, // nobody
                 {{0.0, 20.0, 26.8, 60.0}, 1.9, 2}, // all before one that promises are rivals, too
                 {{0.0, 20.0, 58.0, 60.0}, 9.0, 2}, // 50 are forgiven
                 {{0.0, 20.0, 60.0, 70.0}, 0.0, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        search s;
        begin(&s, joint, "key", cases[i].objective);
        s.suspect[2].promised = cases[i].promised;
        ck_assert_msg(diag__rivals(&s.d) == cases[i].n, "case %zu: %d rivals, not %d", i,
                      diag__rivals(&s.d), cases[i].n);
    }
}

START_TEST(nobody_is_a_rival_of_nobody)
{
    search s;
    begin(&s, joint, "key", (const double[]){0.0, 1.0, 2.0, 3.0});
    s.suspect[1].s.possible = 0; // ends the list
    ck_assert_int_eq(diag__rivals(&s.d), 0);
    s.suspect[0].s.refitted = 0;
    ck_assert_int_eq(diag__rivals(&s.d), 0);
    s.d.n = 0;
    ck_assert_int_eq(diag__rivals(&s.d), 0);
}

Suite *order_suite(void)
{
    Suite *suite = suite_create("order");
    TCase *tc = tcase_create("order");
    tcase_add_test(tc, the_least_objective_leads);
    tcase_add_test(tc, an_amount_that_is_not_physical_has_reached_nothing);
    tcase_add_test(tc, a_fit_that_has_found_no_step_keeps_its_promise);
    tcase_add_test(tc, a_name_goes_before_its_number);
    tcase_add_test(tc, rivals_come_near_or_promise_to);
    tcase_add_test(tc, nobody_is_a_rival_of_nobody);
    suite_add_tcase(suite, tc);
    return suite;
}
