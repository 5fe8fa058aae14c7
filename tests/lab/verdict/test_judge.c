/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_judge.c - the verdict of tables written by hand: the rules at the head of judge.c, each
 * where it applies and where it does not. Nothing is simulated.
 *
 * Objectives are -2 ln p, amounts are in limits. A cause that is nothing special has an amount of
 * ten standard deviations.
 */
#include <math.h>

#include "suites.h"
#include "verdict.h"

enum { A = 3, B = 7, C = 11, D = 12 }; /* candidates */
static const diag__setting plain = {
    .most_noise = 1.13, .stated = 1, .freedom = 8.0, .records = 9, .tolerances = 4};
static const double far_left = 3.0, noise_left = 1.02; /* chi2/dof */

static diag__evidence none(double objective, double chi2_dof)
{
    return (diag__evidence){.objective = objective,
                            .likelihood = objective,
                            .chi2_dof = chi2_dof,
                            .relative = 0.3,
                            .memory = 20.0,
                            .converged = 1,
                            .possible = 1};
}

static diag__evidence with(diag__evidence e, int cause)
{
    int i = e.n++;
    e.cause[i] = cause;
    e.amount[i] = 0.37;
    e.sd[i] = 0.037;
    e.named[i] = 1;
    e.place[i] = cause;
    return e;
}

static diag__evidence one(int a, double objective, double chi2_dof)
{
    return with(none(objective, chi2_dof), a);
}

static diag__evidence two(int a, int b, double objective, double chi2_dof)
{
    return with(one(a, objective, chi2_dof), b);
}

/* ---- 1: what a cause has to gain ---- */

START_TEST(a_model_that_leaves_noise_is_explained)
{
    const diag__evidence e[] = {none(1000.0, noise_left), one(A, 980.0, noise_left)};
    diag__judgement j = diag__judge(e, 2, &plain);
    ck_assert_int_eq(j.finding, DIAG_EXPLAINED);
    ck_assert_int_eq(j.best, 0);
    ck_assert_int_eq(j.null, 0);
    ck_assert_int_eq(j.nrival, 0);
}
END_TEST

START_TEST(a_cause_is_named_from_a_gain_of_25_on)
{
    const double gain[] = {24.9, 25.1};
    for (int i = 0; i < 2; i++) {
        const diag__evidence e[] = {none(1000.0, noise_left), one(A, 1000.0 - gain[i], noise_left)};
        diag__judgement j = diag__judge(e, 2, &plain);
        ck_assert_int_eq(j.finding, i ? DIAG_NAMED : DIAG_EXPLAINED);
        ck_assert_int_eq(j.best, i);
        ck_assert_double_eq_tol(j.gain, i ? gain[i] : 0.0, 1e-9);
    }
}
END_TEST

START_TEST(a_cause_that_explains_most_but_not_beyond_doubt_is_the_nearest)
{
    const double objective[] = {980.0, 980.0, 1001.0, 970.0}, left[] = {1.5, 2.5, 1.5, 1.5};
    for (int i = 0; i < 4; i++) {
        const diag__evidence e[] = {none(1000.0, far_left), one(A, 990.0, 2.9),
                                    one(B, objective[i], left[i])};
        diag__judgement j = diag__judge(e, 3, &plain);
        ck_assert_int_eq(j.finding, i == 3 ? DIAG_NAMED : DIAG_NO_CAUSE);
        ck_assert_int_eq(j.nearest, i == 0 ? 2 : -1);
        ck_assert(i != 0 || fabs(j.near - 0.75) < 1e-9);
    }
}
END_TEST

START_TEST(two_causes_at_once_have_to_gain_twice_as_much)
{
    const diag__evidence null = none(1000.0, far_left);
    diag__evidence both = two(A, B, 1000.0 - 49.0, noise_left);
    ck_assert_int_eq(diag__gains(&both, &null, &plain), 0);
    both.objective = 1000.0 - 51.0;
    ck_assert_int_eq(diag__gains(&both, &null, &plain), 1);
}
END_TEST

/* ---- 2: numbers with a tolerance ---- */

START_TEST(a_number_far_out_of_its_tolerance_is_named_though_it_gains_little)
{
    const double z[] = {2.9, 3.2}; // 4 numbers: 1 % is at 3.02
    for (int i = 0; i < 2; i++) {
        diag__evidence e[] = {none(1000.0, noise_left), one(A, 995.0, noise_left)};
        e[1].tolerated[0] = 1;
        e[1].amount[0] = -0.1 * z[i];
        e[1].sd[0] = 0.1;
        ck_assert_int_eq(diag__judge(e, 2, &plain).finding, i ? DIAG_NAMED : DIAG_EXPLAINED);
        e[1].tolerated[0] = 0;
        ck_assert_int_eq(diag__judge(e, 2, &plain).finding, DIAG_EXPLAINED);
    }
}
END_TEST

START_TEST(of_more_numbers_one_may_be_further_off_by_chance)
{
    const diag__setting many = {.most_noise = 1.13, .freedom = 8.0, .records = 9, .tolerances = 40};
    diag__evidence e[] = {none(1000.0, noise_left), one(A, 995.0, noise_left)};
    e[1].tolerated[0] = 1;
    e[1].amount[0] = 0.32;
    e[1].sd[0] = 0.1;
    ck_assert_int_eq(diag__gains(&e[1], &e[0], &plain), 1);
    ck_assert_int_eq(diag__gains(&e[1], &e[0], &many), 0);
}
END_TEST

START_TEST(a_number_out_of_its_tolerance_that_gains_nothing_is_not_named)
{
    diag__evidence e[] = {none(1000.0, noise_left), one(A, 1001.0, noise_left)};
    e[1].tolerated[0] = e[1].scatters[0] = 1;
    ck_assert_int_eq(diag__judge(e, 2, &plain).finding, DIAG_EXPLAINED);
}
END_TEST

START_TEST(a_number_within_two_sd_of_its_file_is_not_out_of_its_tolerance)
{
    diag__evidence e[] = {none(1000.0, noise_left), one(A, 990.0, noise_left)};
    e[1].tolerated[0] = 1;
    e[1].amount[0] = 0.4;
    e[1].sd[0] = 0.1;
    ck_assert_int_eq(diag__gains(&e[1], &e[0], &plain), 1);
    e[1].sd[0] = 0.2; // z is 2
    ck_assert_int_eq(diag__gains(&e[1], &e[0], &plain), 0);
}
END_TEST

/* ---- 3: means of what scatters ---- */

START_TEST(the_mean_of_scatter_is_judged_by_the_number_of_records)
{
    diag__evidence e[] = {none(1000.0, noise_left), one(A, 990.0, noise_left)};
    e[1].scatters[0] = 1;
    e[1].amount[0] = 0.6;
    e[1].sd[0] = 0.1;
    const int records[] = {1, 4, 9}; // t of 1e-3: of 3 degrees 12.9, of 8 5.04
    for (int i = 0; i < 3; i++) {
        const diag__setting s = {.most_noise = 1.13,
                                 .freedom = records[i] - 1.0,
                                 .records = records[i],
                                 .tolerances = 4};
        ck_assert_int_eq(diag__judge(e, 2, &s).finding, i == 2 ? DIAG_NAMED : DIAG_EXPLAINED);
    }
    e[1].amount[0] = 0.49;
    ck_assert_int_eq(diag__judge(e, 2, &plain).finding, DIAG_EXPLAINED);
}
END_TEST

/* ---- 4: how many causes ---- */

START_TEST(a_second_cause_that_gains_nothing_is_not_named)
{
    const diag__evidence e[] = {none(1000.0, far_left), one(A, 400.0, noise_left),
                                two(A, B, 380.0, noise_left)};
    diag__judgement j = diag__judge(e, 3, &plain);
    ck_assert_int_eq(j.finding, DIAG_NAMED);
    ck_assert_int_eq(j.best, 1);
    ck_assert_double_eq_tol(j.gain, 600.0, 1e-9);
}
END_TEST

START_TEST(a_second_cause_that_gains_is_named)
{
    const diag__evidence e[] = {two(A, B, 300.0, noise_left), one(A, 400.0, 1.3),
                                none(1000.0, far_left), one(B, 700.0, 1.9)};
    diag__judgement j = diag__judge(e, 4, &plain);
    ck_assert_int_eq(j.finding, DIAG_NAMED);
    ck_assert_int_eq(j.best, 0);
    ck_assert_int_eq(j.null, 2);
}
END_TEST

START_TEST(a_pair_is_named_though_neither_of_its_causes_gains_alone)
{
    const diag__evidence e[] = {none(1000.0, far_left), one(A, 990.0, far_left),
                                one(B, 999.0, far_left), two(A, B, 300.0, noise_left)};
    ck_assert_int_eq(diag__judge(e, 4, &plain).best, 3);
}
END_TEST

START_TEST(a_third_cause_has_to_gain_over_the_best_pair)
{
    diag__evidence e[] = {none(1000.0, far_left), one(A, 600.0, 2.0), two(A, B, 300.0, noise_left),
                          with(two(A, B, 290.0, noise_left), C)};
    ck_assert_int_eq(diag__judge(e, 4, &plain).best, 2);
    e[3].objective = 270.0;
    ck_assert_int_eq(diag__judge(e, 4, &plain).best, 3);
}
END_TEST

START_TEST(a_number_of_the_file_beside_a_cause_is_judged_by_its_own_amount)
{
    diag__evidence e[] = {none(1000.0, far_left), one(A, 400.0, noise_left),
                          two(A, B, 392.0, noise_left)};
    e[2].tolerated[1] = 1;
    e[2].amount[1] = 0.4;
    e[2].sd[1] = 0.1;
    ck_assert_int_eq(diag__judge(e, 3, &plain).best, 2);
    e[2].tolerated[1] = 0;
    e[2].tolerated[0] = 1; // that is not what it has more
    ck_assert_int_eq(diag__judge(e, 3, &plain).best, 1);
}
END_TEST

START_TEST(the_best_row_of_a_hypothesis_stands_for_it)
{
    const diag__evidence e[] = {none(1000.0, far_left), one(A, 800.0, 2.0),
                                one(A, 400.0, noise_left), one(A, 600.0, 1.7),
                                none(1010.0, far_left)};
    diag__judgement j = diag__judge(e, 5, &plain);
    ck_assert_int_eq(j.best, 2);
    ck_assert_int_eq(j.null, 0);
    ck_assert_int_eq(j.nrival, 0); // other rows of the same hypothesis are no rivals of it
}
END_TEST

START_TEST(an_impossible_hypothesis_is_never_best)
{
    diag__evidence e[] = {none(1000.0, far_left), one(A, 400.0, noise_left),
                          one(B, 500.0, noise_left)};
    e[1].possible = 0;
    diag__judgement j = diag__judge(e, 3, &plain);
    ck_assert_int_eq(j.best, 2);
    ck_assert_int_eq(j.nrival, 0);
}
END_TEST

START_TEST(a_named_effect_is_preferred_to_a_number_of_the_same_element)
{
    diag__evidence e[] = {none(1000.0, far_left), one(A, 400.0, noise_left),
                          one(B, 401.5, noise_left)};
    e[1].named[0] = 0;
    e[1].place[0] = e[2].place[0];
    diag__judgement j = diag__judge(e, 3, &plain);
    ck_assert_int_eq(j.best, 2);
    ck_assert_int_eq(j.nrival, 1); // the number stays its rival
    ck_assert_int_eq(j.rival[0], 1);

    e[1].place[0] = A; // of another element
    ck_assert_int_eq(diag__judge(e, 3, &plain).best, 1);
    e[1].place[0] = e[2].place[0];
    e[2].objective = 403.0; // that fits worse
    ck_assert_int_eq(diag__judge(e, 3, &plain).best, 1);
    e[2].objective = 401.5;
    e[1].named[0] = 1; // an effect as well
    ck_assert_int_eq(diag__judge(e, 3, &plain).best, 1);
}
END_TEST

START_TEST(a_number_without_a_tolerance_is_preferred_to_the_clock)
{
    diag__evidence e[] = {none(1000.0, far_left), one(A, 400.0, noise_left),
                          one(B, 406.0, noise_left)};
    e[1].clock[0] = 1;
    e[2].named[0] = 0;
    diag__judgement j = diag__judge(e, 3, &plain);
    ck_assert_int_eq(j.best, 2);
    ck_assert_int_eq(j.nrival, 1); // the clock stays its rival
    ck_assert_int_eq(j.rival[0], 1);

    e[2].objective = 412.0; // that fits worse
    ck_assert_int_eq(diag__judge(e, 3, &plain).best, 1);
    e[2].objective = 406.0;
    e[2].tolerated[0] = 1; // known as well as is stated
    ck_assert_int_eq(diag__judge(e, 3, &plain).best, 1);
    e[2].tolerated[0] = 0;
    e[1].clock[0] = 0; // no clock
    ck_assert_int_eq(diag__judge(e, 3, &plain).best, 1);
    e[1].clock[0] = e[2].named[0] = 1; // an effect of the table
    ck_assert_int_eq(diag__judge(e, 3, &plain).best, 1);
    e[2].gain[0] = 1; // the scale of a channel
    ck_assert_int_eq(diag__judge(e, 3, &plain).best, 2);
}
END_TEST

START_TEST(of_named_effects_that_fit_as_well_as_a_number_the_best_one_is_preferred)
{
    diag__evidence e[] = {none(1000.0, far_left), one(B, 401.9, noise_left),
                          one(A, 400.0, noise_left), one(C, 401.2, noise_left)};
    e[2].named[0] = 0;
    for (int i = 1; i < 4; i++) {
        e[i].place[0] = A;
    }
    ck_assert_int_eq(diag__judge(e, 4, &plain).best, 3);
}
END_TEST

/* ---- 5: rivals ---- */

START_TEST(rivals_are_within_odds_of_1_to_100_and_sorted)
{
    const diag__evidence e[] = {none(1000.0, far_left), one(C, 406.0, noise_left),
                                one(A, 400.0, noise_left), one(B, 403.0, noise_left),
                                one(D, 409.4, noise_left)};
    diag__judgement j = diag__judge(e, 5, &plain);
    ck_assert_int_eq(j.best, 2);
    ck_assert_int_eq(j.nrival, 2);
    ck_assert_int_eq(j.rival[0], 3);
    ck_assert_int_eq(j.rival[1], 1);
}
END_TEST

/* priors of amounts alone do not decide between causes that fit as well */
START_TEST(a_cause_that_fits_as_well_is_a_rival_whatever_its_prior)
{
    for (int i = 0; i < 2; i++) {
        diag__evidence e[] = {none(1000.0, far_left), one(A, 400.0, noise_left),
                              one(B, 417.0, noise_left)};
        e[2].likelihood = i ? 401.0 : 403.0;
        diag__judgement j = diag__judge(e, 3, &plain);
        ck_assert_int_eq(j.best, 1);
        ck_assert_int_eq(j.nrival, i);
    }
}
END_TEST

START_TEST(rivals_come_within_what_a_cause_has_to_gain_if_more_than_noise_is_left)
{
    const double left[] = {noise_left, far_left};
    for (int i = 0; i < 2; i++) {
        const diag__evidence e[] = {none(2000.0, 100.0), one(A, 1000.0, left[i]),
                                    one(B, 1024.0, left[i]), one(C, 1026.0, left[i])};
        diag__judgement j = diag__judge(e, 4, &plain);
        ck_assert_int_eq(j.best, 1);
        ck_assert_int_eq(j.nrival, i);
        ck_assert_int_eq(j.rival[0], i ? 2 : 0);
    }
}
END_TEST

START_TEST(a_tie_is_between_rivals)
{
    const diag__evidence e[] = {none(1000.0, far_left), one(B, 400.0, noise_left),
                                one(A, 400.0, noise_left)};
    diag__judgement j = diag__judge(e, 3, &plain);
    ck_assert_int_eq(j.finding, DIAG_NAMED);
    ck_assert_int_eq(j.best, 1); // the first one of the table, whatever it is
    ck_assert_int_eq(j.nrival, 1);
    ck_assert_int_eq(j.rival[0], 2);
}
END_TEST

START_TEST(a_rival_with_several_rows_is_listed_once)
{
    diag__evidence e[] = {none(1000.0, far_left),    one(A, 400.0, noise_left),
                          one(B, 405.0, noise_left), one(B, 402.0, noise_left),
                          one(B, 402.0, noise_left), one(A, 401.0, noise_left)};
    diag__judgement j = diag__judge(e, 6, &plain);
    ck_assert_int_eq(j.nrival, 1);
    ck_assert_int_eq(j.rival[0], 3);
}
END_TEST

/* a fit of the same hypothesis from another start may have ended at an amount of the wrong sign */
START_TEST(an_impossible_row_does_not_hide_a_possible_rival)
{
    diag__evidence e[] = {none(1000.0, far_left), one(A, 400.0, noise_left),
                          one(B, 402.0, noise_left), one(B, 399.0, noise_left)};
    e[3].possible = 0;
    diag__judgement j = diag__judge(e, 4, &plain);
    ck_assert_int_eq(j.best, 1);
    ck_assert_int_eq(j.nrival, 1);
    ck_assert_int_eq(j.rival[0], 2);
}
END_TEST

START_TEST(rivals_have_as_many_causes)
{
    const diag__evidence e[] = {none(1000.0, far_left), one(A, 405.0, noise_left),
                                two(A, B, 300.0, noise_left), two(B, C, 305.0, noise_left),
                                with(two(A, B, 301.0, noise_left), C)};
    diag__judgement j = diag__judge(e, 5, &plain);
    ck_assert_int_eq(j.best, 2);
    ck_assert_int_eq(j.nrival, 1);
    ck_assert_int_eq(j.rival[0], 3);
}
END_TEST

START_TEST(a_rival_whose_amount_may_be_0_is_none)
{
    diag__evidence e[] = {none(1000.0, far_left), two(A, B, 300.0, noise_left),
                          two(A, C, 305.0, noise_left)};
    ck_assert_int_eq(diag__judge(e, 3, &plain).nrival, 1);
    e[2].sd[1] = e[2].amount[1];
    ck_assert_int_eq(diag__judge(e, 3, &plain).nrival, 0);
}
END_TEST

START_TEST(no_more_rivals_are_listed_than_there_is_room_for)
{
    diag__evidence e[DIAG_RIVALS + 6];
    int n = 0;
    e[n++] = none(1000.0, far_left);
    for (int i = 0; i < DIAG_RIVALS + 5; i++, n++) {
        e[n] = one(20 + i, 400.0 + 0.01 * i, noise_left);
    }
    diag__judgement j = diag__judge(e, n, &plain);
    ck_assert_int_eq(j.nrival, DIAG_RIVALS);
    for (int i = 0; i < j.nrival; i++) {
        ck_assert_int_eq(j.rival[i], 2 + i);
    }
}
END_TEST

/* ---- 6: intervals, and what is left ---- */

/* of a pair: what is lost without one of them was not fitted, or is little */
START_TEST(a_cause_whose_interval_contains_0_is_not_named)
{
    const double z[] = {1.9, 2.1};
    for (int i = 0; i < 2; i++) {
        diag__evidence e[] = {none(1000.0, 2.0), two(A, B, 900.0, 1.3), one(A, 920.0, 1.35)};
        e[1].amount[1] = 0.1 * z[i];
        e[1].sd[1] = 0.1;
        e[2].possible = 0;
        diag__judgement j = diag__judge(e, 3, &plain);
        ck_assert_int_eq(j.finding, i ? DIAG_NAMED : DIAG_NO_CAUSE);
        e[1].amount[1] *= -1.0;
        ck_assert_int_eq(diag__judge(e, 3, &plain).finding, j.finding);
        e[1].sd[1] *= sqrt(1.5);
        ck_assert_int_eq(diag__judge(e, 3, &plain).finding, DIAG_NO_CAUSE);
    }
}
END_TEST

/* uncertain numbers beside an amount make its derivative uncertain */
START_TEST(an_interval_that_contains_0_gives_way_to_the_ratio_of_likelihoods)
{
    for (int i = 0; i < 2; i++) {
        diag__evidence e[] = {none(1000.0, 2.0), two(A, B, 900.0, 1.3),
                              one(A, i ? 930.0 : 920.0, 1.2)};
        e[1].sd[1] = e[1].amount[1];
        diag__judgement j = diag__judge(e, 3, &plain);
        ck_assert_int_eq(j.finding, DIAG_NAMED);
        ck_assert_int_eq(j.best, i ? 1 : 2); // 20 is too little for a cause more
    }
}
END_TEST

START_TEST(of_a_pair_both_intervals_have_to_exclude_0)
{
    diag__evidence e[] = {none(1000.0, far_left), two(A, B, 500.0, 1.2)};
    ck_assert_int_eq(diag__judge(e, 2, &plain).finding, DIAG_NAMED);
    e[1].sd[1] = e[1].amount[1];
    ck_assert_int_eq(diag__judge(e, 2, &plain).finding, DIAG_NO_CAUSE);
}
END_TEST

/* nothing can be named, but the file's own model leaves more than noise all the same */
START_TEST(a_model_that_leaves_more_than_noise_is_never_explained)
{
    diag__evidence e[] = {none(1000.0, far_left), one(A, 500.0, noise_left)};
    e[1] = two(A, B, 500.0, noise_left);
    e[1].sd[0] = e[1].amount[0];
    ck_assert_int_eq(diag__judge(e, 2, &plain).finding, DIAG_NO_CAUSE);
    e[0].chi2_dof = 1.1;
    ck_assert_int_eq(diag__judge(e, 2, &plain).finding, DIAG_EXPLAINED);
}
END_TEST

START_TEST(a_cause_that_leaves_most_of_the_misfit_is_not_named)
{
    const double left[] = {5.6, 5.4};
    for (int i = 0; i < 2; i++) {
        diag__evidence e[] = {none(9000.0, 10.0), one(A, 4000.0, left[i])};
        diag__judgement j = diag__judge(e, 2, &plain);
        ck_assert_int_eq(j.finding, i ? DIAG_NAMED : DIAG_MOST_LEFT);
        ck_assert_double_eq_tol(j.share, (10.0 - left[i]) / 9.0, 1e-12);
    }
}
END_TEST

START_TEST(up_to_the_threshold_of_noise_a_misfit_is_noise)
{
    for (int i = 0; i < 2; i++) {
        const diag__evidence e[] = {none(1000.0, i ? 1.131 : 1.129)};
        ck_assert_int_eq(diag__judge(e, 1, &plain).finding, i ? DIAG_NO_CAUSE : DIAG_EXPLAINED);
    }
    // a small misfit has to be explained by as much, unless noise is left
    const diag__evidence e[] = {none(1000.0, 1.14), one(A, 900.0, 1.12)};
    ck_assert_int_eq(diag__judge(e, 2, &plain).finding, DIAG_NAMED);
}
END_TEST

START_TEST(more_than_noise_without_a_cause_that_gains_has_no_cause)
{
    const diag__evidence e[] = {none(1000.0, far_left), one(A, 990.0, 2.9)};
    diag__judgement j = diag__judge(e, 2, &plain);
    ck_assert_int_eq(j.finding, DIAG_NO_CAUSE);
    ck_assert_int_eq(j.best, 0);
}
END_TEST

/* ---- fits that have not ended ---- */

START_TEST(a_fit_that_has_not_converged_is_no_verdict_on_physics)
{
    diag__evidence e[] = {none(9000.0, 10.0), one(A, 4000.0, 5.6)};
    e[0].converged = 0;
    ck_assert_int_eq(diag__judge(e, 1, &plain).finding, DIAG_NOT_CONVERGED);
    ck_assert_int_eq(diag__judge(e, 2, &plain).finding, DIAG_MOST_LEFT);
    e[1].converged = 0;
    ck_assert_int_eq(diag__judge(e, 2, &plain).finding, DIAG_NOT_CONVERGED);
}
END_TEST

START_TEST(a_fit_that_leaves_noise_is_one_to_judge_by_whether_it_has_ended_or_not)
{
    diag__evidence e[] = {none(9000.0, 10.0), one(A, 400.0, noise_left)};
    e[0].converged = e[1].converged = 0;
    ck_assert_int_eq(diag__judge(e, 2, &plain).finding, DIAG_NAMED);
    e[0].chi2_dof = noise_left;
    ck_assert_int_eq(diag__judge(e, 1, &plain).finding, DIAG_EXPLAINED);
}
END_TEST

START_TEST(a_table_without_the_null_hypothesis_has_no_verdict)
{
    diag__evidence e[] = {none(1000.0, far_left), one(A, 400.0, noise_left)};
    ck_assert_int_eq(diag__judge(e + 1, 1, &plain).finding, DIAG_NOT_CONVERGED);
    ck_assert_int_eq(diag__judge(e, 0, &plain).finding, DIAG_NOT_CONVERGED);
    e[0].possible = 0; // it has failed
    ck_assert_int_eq(diag__judge(e, 2, &plain).finding, DIAG_NOT_CONVERGED);
}
END_TEST

/* ---- 9: one record alone ---- */

static diag__evidence of_one_record(int cause, double objective, double z)
{
    diag__evidence e = one(cause, objective, noise_left);
    e.single[0] = 1;
    e.sd[0] = e.amount[0] / z;
    return e;
}

/* Student's t with 7 degrees of freedom exceeds 11.04 in one of 9e4 records */
START_TEST(one_record_alone_is_named_only_beyond_doubt)
{
    const double z[] = {8.0, 10.9, 11.2, 20.0};
    for (int i = 0; i < 4; i++) {
        const diag__evidence e[] = {none(1000.0, noise_left), of_one_record(A, 900.0, z[i])};
        diag__judgement j = diag__judge(e, 2, &plain);
        ck_assert_int_eq(j.best, z[i] > 11.0);
        ck_assert_int_eq(j.finding, z[i] > 11.0 ? DIAG_NAMED : DIAG_EXPLAINED);
    }
    // it has to gain as all others do
    const diag__evidence e[] = {none(1000.0, noise_left), of_one_record(A, 976.0, 20.0)};
    ck_assert_int_eq(diag__judge(e, 2, &plain).best, 0);
}
END_TEST

START_TEST(of_few_records_none_is_the_odd_one)
{
    diag__setting few = plain;
    for (few.records = 1; few.records < 4; few.records++) {
        const diag__evidence e[] = {none(1000.0, noise_left), of_one_record(A, 900.0, 50.0)};
        ck_assert_int_eq(diag__judge(e, 2, &few).best, 0);
    }
}
END_TEST

START_TEST(a_doubtful_record_does_not_hide_a_cause)
{
    const diag__evidence e[] = {none(1000.0, far_left), of_one_record(A, 900.0, 5.0),
                                one(B, 910.0, noise_left)};
    diag__judgement j = diag__judge(e, 3, &plain);
    ck_assert_int_eq(j.best, 2);
    ck_assert_int_eq(j.finding, DIAG_NAMED);
}
END_TEST

/* ---- 7: far off ---- */

START_TEST(a_best_hypothesis_far_from_the_records_is_no_usable_model)
{
    diag__evidence e[] = {none(1e6, 4000.0), one(A, 1e4, 51.0)};
    ck_assert_int_eq(diag__judge(e, 1, &plain).finding, DIAG_FAR_OFF);
    ck_assert_int_eq(diag__judge(e, 2, &plain).finding, DIAG_FAR_OFF); // though it explains 99 %
    e[1].chi2_dof = 49.0;
    ck_assert_int_eq(diag__judge(e, 2, &plain).finding, DIAG_NAMED);
}
END_TEST

START_TEST(a_misfit_that_is_small_beside_the_motion_is_no_unusable_model)
{
    diag__evidence e[] = {none(1e6, 4000.0), one(A, 1e4, 51.0)};
    e[0].relative = e[1].relative = 0.01;
    ck_assert_int_eq(diag__judge(e, 2, &plain).finding, DIAG_NAMED);
    e[1].relative = 0.21;
    ck_assert_int_eq(diag__judge(e, 2, &plain).finding, DIAG_FAR_OFF);
}
END_TEST

START_TEST(a_white_residual_is_noise_where_none_was_stated)
{
    diag__evidence e[] = {none(1000.0, 10.0), one(A, 900.0, 9.0)};
    diag__setting unstated = plain;
    unstated.stated = 0;
    ck_assert_int_eq(diag__judge(e, 2, &unstated).finding, DIAG_MOST_LEFT);
    e[1].memory = 1.5;
    ck_assert_int_eq(diag__judge(e, 2, &unstated).finding, DIAG_NAMED);
    ck_assert_int_eq(diag__judge(e, 2, &plain).finding, DIAG_MOST_LEFT);
}
END_TEST

START_TEST(a_model_that_is_far_off_is_reported_whether_its_fit_has_ended_or_not)
{
    diag__evidence e[] = {none(1e6, 4000.0)};
    e[0].converged = 0;
    ck_assert_int_eq(diag__judge(e, 1, &plain).finding, DIAG_FAR_OFF);
}
END_TEST

/* ---- the order of rows ---- */

START_TEST(a_verdict_does_not_depend_on_the_order_of_the_table)
{
    const diag__evidence e[] = {
        none(1000.0, far_left),        one(A, 600.0, 2.0),           one(B, 620.0, 2.1),
        two(A, B, 300.0, noise_left),  two(B, C, 303.0, noise_left), two(A, C, 305.0, noise_left),
        with(two(A, B, 290.0, 1.0), C)};
    enum { N = sizeof e / sizeof *e };
    for (int shift = 0; shift < N; shift++) {
        diag__evidence turned[N];
        for (int i = 0; i < N; i++) {
            turned[i] = e[(N - 1 - i + shift) % N];
        }
        diag__judgement j = diag__judge(turned, N, &plain);
        ck_assert_int_eq(j.finding, DIAG_NAMED);
        ck_assert_double_eq(turned[j.best].objective, 300.0);
        ck_assert_int_eq(j.nrival, 2);
        ck_assert_double_eq(turned[j.rival[0]].objective, 303.0);
        ck_assert_double_eq(turned[j.rival[1]].objective, 305.0);
    }
}
END_TEST

Suite *judge_suite(void)
{
    Suite *suite = suite_create("judge");
    TCase *tc = tcase_create("judge");
    tcase_add_test(tc, a_model_that_leaves_noise_is_explained);
    tcase_add_test(tc, a_cause_is_named_from_a_gain_of_25_on);
    tcase_add_test(tc, two_causes_at_once_have_to_gain_twice_as_much);
    tcase_add_test(tc, a_cause_that_explains_most_but_not_beyond_doubt_is_the_nearest);
    tcase_add_test(tc, a_number_far_out_of_its_tolerance_is_named_though_it_gains_little);
    tcase_add_test(tc, of_more_numbers_one_may_be_further_off_by_chance);
    tcase_add_test(tc, a_number_out_of_its_tolerance_that_gains_nothing_is_not_named);
    tcase_add_test(tc, a_number_within_two_sd_of_its_file_is_not_out_of_its_tolerance);
    tcase_add_test(tc, the_mean_of_scatter_is_judged_by_the_number_of_records);
    tcase_add_test(tc, a_second_cause_that_gains_nothing_is_not_named);
    tcase_add_test(tc, a_second_cause_that_gains_is_named);
    tcase_add_test(tc, a_pair_is_named_though_neither_of_its_causes_gains_alone);
    tcase_add_test(tc, a_third_cause_has_to_gain_over_the_best_pair);
    tcase_add_test(tc, a_number_of_the_file_beside_a_cause_is_judged_by_its_own_amount);
    tcase_add_test(tc, the_best_row_of_a_hypothesis_stands_for_it);
    tcase_add_test(tc, an_impossible_hypothesis_is_never_best);
    tcase_add_test(tc, a_named_effect_is_preferred_to_a_number_of_the_same_element);
    tcase_add_test(tc, a_number_without_a_tolerance_is_preferred_to_the_clock);
    tcase_add_test(tc, of_named_effects_that_fit_as_well_as_a_number_the_best_one_is_preferred);
    tcase_add_test(tc, rivals_are_within_odds_of_1_to_100_and_sorted);
    tcase_add_test(tc, a_cause_that_fits_as_well_is_a_rival_whatever_its_prior);
    tcase_add_test(tc, rivals_come_within_what_a_cause_has_to_gain_if_more_than_noise_is_left);
    tcase_add_test(tc, a_tie_is_between_rivals);
    tcase_add_test(tc, a_rival_with_several_rows_is_listed_once);
    tcase_add_test(tc, an_impossible_row_does_not_hide_a_possible_rival);
    tcase_add_test(tc, rivals_have_as_many_causes);
    tcase_add_test(tc, a_rival_whose_amount_may_be_0_is_none);
    tcase_add_test(tc, no_more_rivals_are_listed_than_there_is_room_for);
    tcase_add_test(tc, a_cause_whose_interval_contains_0_is_not_named);
    tcase_add_test(tc, an_interval_that_contains_0_gives_way_to_the_ratio_of_likelihoods);
    tcase_add_test(tc, of_a_pair_both_intervals_have_to_exclude_0);
    tcase_add_test(tc, a_model_that_leaves_more_than_noise_is_never_explained);
    tcase_add_test(tc, a_cause_that_leaves_most_of_the_misfit_is_not_named);
    tcase_add_test(tc, up_to_the_threshold_of_noise_a_misfit_is_noise);
    tcase_add_test(tc, more_than_noise_without_a_cause_that_gains_has_no_cause);
    tcase_add_test(tc, a_fit_that_has_not_converged_is_no_verdict_on_physics);
    tcase_add_test(tc, a_fit_that_leaves_noise_is_one_to_judge_by_whether_it_has_ended_or_not);
    tcase_add_test(tc, a_table_without_the_null_hypothesis_has_no_verdict);
    tcase_add_test(tc, a_best_hypothesis_far_from_the_records_is_no_usable_model);
    tcase_add_test(tc, a_model_that_is_far_off_is_reported_whether_its_fit_has_ended_or_not);
    tcase_add_test(tc, a_misfit_that_is_small_beside_the_motion_is_no_unusable_model);
    tcase_add_test(tc, a_white_residual_is_noise_where_none_was_stated);
    tcase_add_test(tc, a_verdict_does_not_depend_on_the_order_of_the_table);
    tcase_add_test(tc, one_record_alone_is_named_only_beyond_doubt);
    tcase_add_test(tc, of_few_records_none_is_the_odd_one);
    tcase_add_test(tc, a_doubtful_record_does_not_hide_a_cause);
    suite_add_tcase(suite, tc);
    return suite;
}
