/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_stroke.c - the stroke of the 1788 action: accuracy, events, the notch's memory, the load.
 * (The published facts of the regulation are in test_facts.c.)
 */
#include <stdlib.h>
#include <string.h>

#include "support.h"

enum { SAMPLES = 1900, MAX_EVENTS = 400 };
static const double sample_dt = 5e-5;

typedef struct stroke {
    int n;
    stein_event event[MAX_EVENTS];
    double distance[SAMPLES];
    double first_rebound; /* end of the first contact with the string [s] */
} stroke;

static void record(void *ctx, stein_sim *sim, const stein_event *event)
{
    stroke *s = ctx;
    int string = stein_sim_model(sim)->stroke.string;
    if (s->n < MAX_EVENTS) {
        s->event[s->n++] = *event;
    }
    if (event->kind == STEIN_EVENT_CONTACT_END && event->index == string &&
        s->first_rebound == 0.0) {
        s->first_rebound = event->time;
    }
}

static double time_of(const stroke *s, stein_event_kind kind)
{
    for (int i = 0; i < s->n; i++) {
        if (s->event[i].kind == kind) {
            return s->event[i].time;
        }
    }
    return NAN;
}

static void play(stroke *s, stein_integrator integrator, double dt, double shift)
{
    stein_sim *sim = make_sim(&stein_model_stein1788, integrator, dt);
    memset(s, 0, sizeof *s);
    ck_assert_stein(stein_set(sim, "pawl.stop_shift", shift, err));
    ck_assert_stein(stein_reset(sim, err));
    stein_on_event(sim, record, s);
    int channel = stein_find_channel(&stein_model_stein1788, "string_distance");
    for (int i = 0; i < SAMPLES; i++) {
        ck_assert_stein(stein_run(sim, i * sample_dt, err));
        s->distance[i] = stein_read(sim, channel);
    }
    stein_sim_destroy(sim);
}

static stroke coarse, fine;

static void compare_accuracy(stein_integrator integrator, double shift)
{
    double dt = stein_model_stein1788.dt, worst = 0.0, worst_time = 0.0;
    play(&coarse, integrator, dt, shift);
    play(&fine, integrator, dt / 16.0, shift);
    int last = (int)(fine.first_rebound / sample_dt);
    ck_assert_msg(last > 100 && last < SAMPLES, "no rebound at %g s", fine.first_rebound);
    for (int i = 0; i <= last; i++) {
        worst = fmax(worst, fabs(coarse.distance[i] - fine.distance[i]));
    }
    for (int i = 0; i < fine.n && fine.event[i].time <= fine.first_rebound; i++) {
        ck_assert_int_eq(coarse.event[i].kind, fine.event[i].kind);
        ck_assert_int_eq(coarse.event[i].index, fine.event[i].index);
        worst_time = fmax(worst_time, fabs(coarse.event[i].time - fine.event[i].time));
    }
    printf("stroke at dx = %+.2f mm, %s, dt %g s against dt/16: distance %.2e m, events %.2e s\n",
           1e3 * shift, integrator == STEIN_RK4 ? "RK4" : "DP5", dt, worst, worst_time);
    ck_assert(worst <= 1e-6);
    ck_assert(worst_time <= 1e-6);
}

START_TEST(a_stroke_is_accurate_to_a_micrometre_and_a_microsecond)
{
    static const double shift[] = {0.0, -0.613e-3, -1.2e-3, 0.17e-3};
    compare_accuracy(_i % 2 == 0 ? STEIN_RK4 : STEIN_DP5, shift[_i / 2]);
}
END_TEST

START_TEST(the_notch_goes_through_its_phases_in_the_order_of_the_paper)
{
    static const double shift[] = {-1.2e-3, -0.6e-3, 0.0};
    int seen[5] = {0};
    for (int k = 0; k < 3; k++) {
        play(&coarse, STEIN_RK4, stein_model_stein1788.dt, shift[k]);
        double escape = time_of(&coarse, STEIN_EVENT_ESCAPEMENT);
        int phase = 1; // the beak's end comes first, on the roof
        for (int i = 0; i < coarse.n && coarse.event[i].time < escape; i++) {
            const stein_event *e = &coarse.event[i];
            if (e->kind == STEIN_EVENT_PHASE && e->phase > 0) {
                ck_assert_msg(e->phase >= phase && e->phase <= 3, "dx = %g mm: phase %d after %d",
                              1e3 * shift[k], e->phase, phase);
                ck_assert(seen[1] || e->phase == 1);
                phase = e->phase;
                seen[phase] = 1;
            }
        }
        ck_assert_int_eq(phase, 3); // and the corner comes last
        ck_assert(isnan(time_of(&coarse, STEIN_EVENT_IMPACT)) ||
                  escape < time_of(&coarse, STEIN_EVENT_IMPACT));
    }
    ck_assert(seen[1] && seen[2] && seen[3]);
}
END_TEST

START_TEST(impact_follows_the_begin_of_the_strings_contact)
{
    play(&coarse, STEIN_RK4, stein_model_stein1788.dt, -0.2e-3);
    for (int i = 0; i < coarse.n; i++) {
        if (coarse.event[i].kind == STEIN_EVENT_IMPACT) {
            ck_assert_int_gt(i, 0);
            ck_assert_int_eq(coarse.event[i - 1].kind, STEIN_EVENT_CONTACT_BEGIN);
            ck_assert_int_eq(coarse.event[i - 1].index, coarse.event[i].index);
            ck_assert(coarse.event[i - 1].time == coarse.event[i].time);
            return;
        }
    }
    ck_abort_msg("no impact");
}
END_TEST

START_TEST(event_times_never_go_back)
{
    play(&coarse, STEIN_DP5, 2e-5, 0.19e-3);
    for (int i = 1; i < coarse.n; i++) {
        ck_assert(coarse.event[i].time >= coarse.event[i - 1].time);
    }
}
END_TEST

START_TEST(the_action_rests_in_equilibrium_until_the_load_comes)
{
    stein_sim *sim = make_sim(&stein_model_stein1788, STEIN_RK4, 0.0);
    double q[8];
    int nq = stein_model_stein1788.nq;
    memcpy(q, stein_q(sim), sizeof *q * (size_t)nq);
    ck_assert_int_eq(stein_load_present(sim), 1);
    ck_assert_int_eq(stein_notch_armed(sim, 0), 1);
    stein_load_lift(sim);
    ck_assert_int_eq(stein_load_present(sim), 0);
    ck_assert_stein(stein_run(sim, 0.1, err));
    for (int j = 0; j < nq; j++) {
        ck_assert_close(stein_q(sim)[j], q[j], 0.0, 1e-9);
    }
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(the_stroke_rearms_after_the_key_is_released)
{
    static const double shift[] = {-1.25e-3, -0.8e-3, -0.4e-3, 0.0, 0.1e-3, 0.2e-3};
    stein_sim *sim = make_sim(&stein_model_stein1788, STEIN_RK4, 0.0);
    ck_assert_stein(stein_set(sim, "pawl.stop_shift", shift[_i], err));
    ck_assert_stein(stein_reset(sim, err));
    memset(&coarse, 0, sizeof coarse);
    stein_on_event(sim, record, &coarse);
    ck_assert_stein(stein_run(sim, 0.25, err));
    ck_assert(!isnan(time_of(&coarse, STEIN_EVENT_ESCAPEMENT)));
    ck_assert_int_eq(stein_notch_armed(sim, 0), 0);
    stein_load_lift(sim);
    ck_assert_stein(stein_run(sim, 0.75, err));
    ck_assert(!isnan(time_of(&coarse, STEIN_EVENT_CAUGHT)));
    ck_assert_int_eq(stein_notch_armed(sim, 0), 1);
    ck_assert_int_eq(stein_notch_phase(sim, 0), 0);
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(a_load_that_is_put_back_strikes_as_the_first_time)
{
    stein_sim *sim = make_sim(&stein_model_stein1788, STEIN_RK4, 0.0);
    ck_assert_stein(stein_reset(sim, err));
    memset(&coarse, 0, sizeof coarse);
    stein_on_event(sim, record, &coarse);
    ck_assert_stein(stein_run(sim, 0.25, err));
    double escaped = time_of(&coarse, STEIN_EVENT_ESCAPEMENT);
    double struck = time_of(&coarse, STEIN_EVENT_IMPACT);
    stein_load_lift(sim);
    ck_assert_stein(stein_run(sim, 1.5, err));
    ck_assert_stein(stein_load_place(sim, err));
    ck_assert_int_eq(stein_load_present(sim), 1);
    memset(&coarse, 0, sizeof coarse);
    ck_assert_stein(stein_run(sim, 1.75, err));
    ck_assert_close(time_of(&coarse, STEIN_EVENT_ESCAPEMENT) - 1.5, escaped, 0.0, 1e-5);
    ck_assert_close(time_of(&coarse, STEIN_EVENT_IMPACT) - 1.5, struck, 0.0, 1e-5);
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(a_notch_out_of_range_has_no_phase)
{
    stein_sim *sim = make_sim(&stein_model_pendulum, STEIN_RK4, 0.0);
    ck_assert_int_eq(stein_notch_phase(sim, 0), -1);
    ck_assert_int_eq(stein_notch_phase(sim, -1), -1);
    ck_assert_int_eq(stein_notch_armed(sim, 3), 0);
    ck_assert_int_eq(stein_load_present(sim), 0);
    stein_load_lift(sim); // no load, no effect
    ck_assert_stein(stein_load_place(sim, err));
    ck_assert_int_eq(stein_load_present(sim), 0);
    ck_assert_stein(stein_step(sim, err));
    stein_sim_destroy(sim);
}
END_TEST

Suite *stroke_suite(void)
{
    Suite *suite = suite_create("stroke");
    TCase *tc = tcase_create("stroke");
    tcase_set_timeout(tc, 120.0);
    tcase_add_loop_test(tc, a_stroke_is_accurate_to_a_micrometre_and_a_microsecond, 0, 8);
    tcase_add_test(tc, the_notch_goes_through_its_phases_in_the_order_of_the_paper);
    tcase_add_test(tc, impact_follows_the_begin_of_the_strings_contact);
    tcase_add_test(tc, event_times_never_go_back);
    tcase_add_test(tc, the_action_rests_in_equilibrium_until_the_load_comes);
    tcase_add_loop_test(tc, the_stroke_rearms_after_the_key_is_released, 0, 6);
    tcase_add_test(tc, a_load_that_is_put_back_strikes_as_the_first_time);
    tcase_add_test(tc, a_notch_out_of_range_has_no_phase);
    suite_add_tcase(suite, tc);
    return suite;
}
