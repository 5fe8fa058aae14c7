/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_seen.c - could it have been seen? Detectability of an absent effect is confirmed by adding
 * the effect.
 */
#include "rotor_support.h"

Suite *seen_suite(void);

static const char *const start[] = {"wheel.initial.position=0.2 rad"};

/* detectable amount of quadratic drag where there is none */
static double detectable(void)
{
    rotor r = rotor_diagnosed("wheel.drag=0", start, 1);
    ck_assert_int_eq(r.d->verdict, LAB_VERDICT_EXPLAINED);
    const lab_suspect *s = rotor_suspect(&r, "quadratic_drag");
    ck_assert_int_eq(s->power.presence, LAB_ABSENT);
    double amount = s->power.detectable;
    ck_assert(amount > 0.0 && amount < s->candidate.limit);
    ck_assert(s->power.upper < amount && fabs(s->power.amount) < 3.0 * s->power.sd);
    printf("quadratic drag would be named from %.3g of %.3g N m s^2/rad^2 on\n", amount,
           s->candidate.limit);
    rotor_free(&r);
    return amount;
}

/* presence of quadratic drag of that amount */
static lab_presence with(double amount, double *upper, int *named)
{
    char truth[60];
    snprintf(truth, sizeof truth, "wheel.drag=%.17g", amount);
    rotor r = rotor_diagnosed(truth, start, 1);
    const lab_suspect *s = rotor_suspect(&r, "quadratic_drag");
    lab_presence presence = s->power.presence;
    *named = s - r.d->suspect < r.d->ncause + r.d->nrival;
    *upper = s->power.upper;
    rotor_free(&r);
    return presence;
}

START_TEST(a_detectable_effect_is_named_when_it_is_present)
{
    double amount = detectable(), upper;
    int named;
    with(amount, &upper, &named);
    ck_assert(named);
    ck_assert_int_ne(with(0.02 * amount, &upper, &named), LAB_PRESENT);
    ck_assert(!named);
    ck_assert(upper > 0.02 * amount && upper < amount);
}
END_TEST

START_TEST(every_suspect_has_a_presence_and_its_reason)
{
    rotor r = rotor_diagnosed("wheel.drag=1e-4 N m s^2/rad^2", start, 1);
    int count[LAB_PRESENCES] = {0};
    for (int i = 0; i < r.d->nsuspect; i++) {
        const lab_suspect *s = &r.d->suspect[i];
        count[s->power.presence]++;
        ck_assert_ptr_nonnull(s->power.because);
        if (s->power.presence == LAB_ABSENT) {
            ck_assert(s->power.detectable <= s->candidate.limit);
            ck_assert(s->power.upper < s->power.detectable);
        }
    }
    ck_assert_int_eq(count[LAB_PRESENT], r.d->ncause);
    ck_assert_int_eq(count[LAB_PRESENT], 1);
    ck_assert_int_eq(count[LAB_NOT_JUDGED], 0);
    ck_assert_int_gt(count[LAB_ABSENT], 0);
    // as much as a marker may be glued off
    ck_assert_int_eq(rotor_suspect(&r, "sensor_offset")->power.presence, LAB_WEAK);
    ck_assert_int_eq(rotor_suspect(&r, "viscous_friction")->power.presence, LAB_WEAK); // its twin
    rotor_free(&r);
}
END_TEST

/* within 10 mrad it would be where somebody has glued a marker */
START_TEST(an_offset_far_beyond_the_prior_of_a_marker_is_a_cause)
{
    rotor r = rotor_diagnosed("angle.sensor.offset=80 mrad", start, 1);
    ck_assert_int_eq(r.d->verdict, LAB_VERDICT_SENSOR);
    ck_assert_int_eq(r.d->ncause, 1);
    ck_assert_str_eq(r.d->suspect[0].candidate.effect->kind, "sensor_offset");
    ck_assert_double_eq_tol(r.d->suspect[0].amount, 0.08, 0.015);
    rotor_free(&r);
}
END_TEST

Suite *seen_suite(void)
{
    Suite *s = suite_create("seen");
    TCase *tc = tcase_create("seen");
    tcase_set_timeout(tc, 120);
    tcase_add_checked_fixture(tc, make_folder, remove_folder);
    tcase_add_test(tc, a_detectable_effect_is_named_when_it_is_present);
    tcase_add_test(tc, every_suspect_has_a_presence_and_its_reason);
    tcase_add_test(tc, an_offset_far_beyond_the_prior_of_a_marker_is_a_cause);
    suite_add_tcase(s, tc);
    return s;
}
