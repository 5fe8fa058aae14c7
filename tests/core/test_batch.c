/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_batch.c - simulations in lanes against the same ones alone: to the last bit.
 */
#include <string.h>

#include "twins.h"

/* ---- strokes ---- */

/* every law that a file may leave out, in some of the places */
static void complicate(stein_sim *sim, int i)
{
    static const struct {
        const char *name;
        double value;
    } law[] = {
        {"string.normal.p", 0.31},       {"notch.friction.B1", 0.52}, {"notch.friction.B2", 0.13},
        {"notch.normal.h", 0.11},        {"pawl.coulomb.T", 1.3e-4},  {"string.adhesion.F", 0.12},
        {"string.adhesion.range", 1e-5}, {"pawl.asymmetry", 0.21},    {"pawl.damping", 1.7e-6},
        {"hammer.drag", 1.9e-7},         {"pawl.backlash.k", 0.023},  {"pawl.backlash.gap", 0.011},
        {"hammer.spring.k3", 1.1e-4},    {"dip.normal.F0", 0.013},    {"loops.gap", 1.2e-5},
        {"key.friction.B1", 0.29},       {"stop.normal.p", -0.17},    {"key.preload", 1.4e-3},
    };
    for (int k = 0; k < (int)(sizeof law / sizeof *law); k++) {
        if ((k + i) % 3 != 0) {
            set(sim, law[k].name, law[k].value * (1.0 + 0.013 * i));
        }
    }
    regulate(sim, i);
}

static void play(stein_integrator integrator, int width, void (*shape)(stein_sim *, int))
{
    const stein_model *model = &stein_model_stein1788;
    twins t;
    if (!has_width(model, width)) {
        return;
    }
    make_twins(&t, model, integrator, width, shape);
    run_twins(&t, 0.061, 0.9e-3);
    for (int i = 0; i < PLACES; i += 2) { // the load of some is lifted
        stein_load_lift(t.alone[i]);
        stein_load_lift(stein_batch_sim(t.batch, i));
    }
    run_twins(&t, 0.023, 0.41e-3);
    drop_twins(&t);
}

START_TEST(strokes_in_lanes_have_the_bits_of_strokes_alone)
{
    play(_i % 2 ? STEIN_DP5 : STEIN_RK4, widths[_i / 2], regulate);
}
END_TEST

START_TEST(so_have_strokes_with_every_law)
{
    play(_i % 2 ? STEIN_RK4 : STEIN_DP5, widths[_i / 2], complicate);
}
END_TEST

/* ---- steps of controlled error ---- */

enum { LOOKS = 60 };

/* looks at times that do not depend on steps */
typedef struct eye {
    double every;
    int n;
    double seen[LOOKS][3];
} eye;

static double look(void *ctx, stein_sim *sim)
{
    eye *e = ctx;
    ck_assert_int_lt(e->n, LOOKS);
    e->seen[e->n][0] = stein_time(sim);
    e->seen[e->n][1] = stein_read(sim, stein_find_channel(stein_sim_model(sim), "hammer_height"));
    e->seen[e->n][2] = stein_read(sim, stein_find_channel(stein_sim_model(sim), "notch_force"));
    e->n++;
    return e->n * e->every;
}

static void mix(stein_sim *sim, int i);

/* paces that differ, some of them with a look function */
static void set_paces(stein_pace *pace, eye *e)
{
    for (int i = 0; i < PLACES; i++) {
        e[i] = (eye){.every = 1.7e-3 + 1e-4 * i};
        pace[i] = (stein_pace){.tolerance = i % 3 ? 1e-9 : 3e-7,
                               .longest = 1e-3,
                               .h = 1e-5,
                               .next = 0.0,
                               .look = i % 2 ? look : NULL,
                               .ctx = &e[i]};
    }
}

static void pace_twins(int width, void (*shape)(stein_sim *, int))
{
    static eye of_alone[PLACES], of_rider[PLACES];
    stein_pace alone[PLACES], rider[PLACES];
    double t_end[PLACES];
    twins t;
    if (!has_width(&stein_model_stein1788, width)) {
        return;
    }
    make_twins(&t, &stein_model_stein1788, STEIN_DP5, width, shape);
    set_paces(alone, of_alone);
    set_paces(rider, of_rider);
    for (int part = 0; part < 2; part++) {
        for (int i = 0; i < PLACES; i++) {
            t_end[i] = 0.043 * (part + 1) + 0.7e-3 * i;
            ck_assert_stein(stein_run_adaptive(t.alone[i], t_end[i], &alone[i], err));
        }
        ck_assert_stein(stein_batch_run_adaptive(t.batch, t_end, rider, NULL, err));
        compare_twins(&t);
        for (int i = 0; i < PLACES; i++) {
            ck_assert(alone[i].h == rider[i].h && alone[i].next == rider[i].next);
            ck_assert_int_eq(of_alone[i].n, of_rider[i].n);
            ck_assert_int_eq(of_alone[i].n > 10, i % 2);
            ck_assert(memcmp(of_alone[i].seen, of_rider[i].seen, sizeof of_alone[i].seen) == 0);
        }
    }
    drop_twins(&t);
}

START_TEST(controlled_steps_in_lanes_have_the_bits_of_those_alone)
{
    static void (*const shape[])(stein_sim *, int) = {regulate, complicate, mix};
    pace_twins(widths[_i % 4], shape[_i / 4]);
}
END_TEST

START_TEST(a_pace_that_is_out_of_range_is_refused_for_its_place_alone)
{
    static eye e[PLACES];
    stein_pace pace[PLACES];
    stein_status status[PLACES];
    stein_err err;
    double t_end[PLACES];
    twins t;
    make_twins(&t, &stein_model_stein1788, STEIN_DP5, stein_batch_width(&stein_model_stein1788),
               regulate);
    set_paces(pace, e);
    pace[1].tolerance = 0.0;
    for (int i = 0; i < PLACES; i++) {
        t_end[i] = i == 3 ? -1.0 : 0.002;
    }
    ck_assert_int_eq(stein_batch_run_adaptive(t.batch, t_end, pace, status, &err), STEIN_EINVAL);
    ck_assert(strstr(err.msg, "tolerance 0") != NULL);
    for (int i = 0; i < PLACES; i++) {
        ck_assert_int_eq(status[i], i == 1 || i == 3 ? STEIN_EINVAL : STEIN_OK);
        ck_assert(stein_time(t.rider[i]) == (i == 1 || i == 3 ? 0.0 : 0.002));
    }
    drop_twins(&t);
}
END_TEST

/* ---- other mechanisms ---- */

static void push_about(stein_sim *sim, int i)
{
    unsigned long long seed = 99 + (unsigned long long)i;
    double q[16], qd[16];
    int nq = stein_sim_model(sim)->nq;
    for (int j = 0; j < nq; j++) {
        q[j] = stein_q(sim)[j] + 0.02 * noise(&seed);
        qd[j] = 0.3 * noise(&seed);
    }
    ck_assert_stein(stein_set_state(sim, 0.0, q, qd, err));
}

START_TEST(every_mechanism_moves_in_lanes_as_alone)
{
    int seen = 0;
    for (int m = 0; stein_models[m] != NULL; m++) {
        const stein_model *model = stein_models[m];
        stein_sim *sim = NULL;
        twins t;
        if (stein_sim_create(&sim, model, NULL, NULL) != STEIN_OK) {
            continue; // equations only, M is singular
        }
        stein_sim_destroy(sim);
        if (has_width(model, widths[_i])) {
            make_twins(&t, model, STEIN_RK4, widths[_i], push_about);
            run_twins(&t, 300.3 * model->dt, 7.7 * model->dt);
            drop_twins(&t);
            seen++;
        }
    }
    ck_assert(seen >= 5 || !has_width(&stein_model_stein1788, widths[_i]));
}
END_TEST

/* far angles of one lane use other branches of sine and cosine than its neighbour
 */
static void turn_far(stein_sim *sim, int i)
{
    static const double angle[] = {0.1, 0.9, -2.5, 44.0, 3e4, -2e6, 1e12, 0.7853981633974483};
    double q[2] = {angle[i % 8], 0.3}, qd[2] = {7.0 * i, -3.0};
    ck_assert_stein(stein_set_state(sim, 0.0, q, qd, err));
}

START_TEST(angles_of_any_size_turn_in_lanes_as_alone)
{
    twins t;
    if (has_width(&stein_model_double_pendulum, widths[_i])) {
        make_twins(&t, &stein_model_double_pendulum, STEIN_DP5, widths[_i], turn_far);
        run_twins(&t, 0.2, 0.01);
        drop_twins(&t);
    }
}
END_TEST

/* ---- simulations in lanes and alone ---- */

static void press(void *ctx, double t, const double *q, const double *qd, double *Q)
{
    (void)ctx, (void)t, (void)q, (void)qd;
    Q[0] += 1e-3;
}

static void finger(void *ctx, double t, double u[3])
{
    (void)ctx;
    u[0] = 0.7 * (t < 0.01 ? t / 0.01 : 1.0);
}

static void key_motion(void *ctx, double t, double u[3])
{
    (void)ctx;
    u[0] = 0.01 * sin(90.0 * t);
    u[1] = 0.9 * cos(90.0 * t);
    u[2] = -81.0 * sin(90.0 * t);
}

static void mix(stein_sim *sim, int i)
{
    regulate(sim, i);
    if (i % 4 == 1) {
        stein_on_force(sim, press, NULL);
    } else if (i % 4 == 2) {
        ck_assert_stein(stein_drive(sim, "finger", finger, NULL, err));
    } else if (i % 8 == 3) {
        ck_assert_stein(stein_drive(sim, "key_motion", key_motion, NULL, err));
    }
}

START_TEST(those_that_cannot_ride_run_alone_beside_those_that_can)
{
    twins t;
    if (has_width(&stein_model_stein1788, widths[_i])) {
        make_twins(&t, &stein_model_stein1788, STEIN_RK4, widths[_i], mix);
        run_twins(&t, 0.012, 0.1e-3);
        // a simulation without its hook enters a lane again, one with a new hook leaves it
        for (int i = 0; i < PLACES; i++) {
            stein_on_force(t.alone[i], i % 3 ? NULL : press, NULL);
            stein_on_force(stein_batch_sim(t.batch, i), i % 3 ? NULL : press, NULL);
        }
        run_twins(&t, 0.009, 0.1e-3);
        drop_twins(&t);
    }
}
END_TEST

START_TEST(a_place_is_filled_again_while_others_go_on)
{
    const stein_model *model = &stein_model_stein1788;
    int n = stein_batch_width(model), next = 0;
    stein_batch *batch = NULL;
    double until[PLACES];
    int place[8];
    twins t;
    make_twins(&t, model, STEIN_RK4, 1, regulate); // its batch stays unused
    ck_assert_stein(stein_batch_create(&batch, model, NULL, n, 0, err));
    for (int i = 0; i < PLACES; i++) {
        ck_assert_stein(stein_batch_put(t.batch, i, NULL, err));
        until[i] = 0.004 + 0.0007 * ((7 * i) % 5);
        ck_assert_stein(stein_run(t.alone[i], until[i], err));
    }
    for (int k = 0; k < n; k++) {
        place[k] = next;
        ck_assert_stein(stein_batch_put(batch, k, next < PLACES ? t.rider[next] : NULL, err));
        next++;
    }
    for (int done = 0; done < PLACES;) {
        for (int k = 0; k < n; k++) {
            int i = place[k];
            if (i < PLACES && until[i] - stein_time(t.rider[i]) <= stein_dt(t.rider[i])) {
                ck_assert_stein(stein_run(stein_batch_sim(batch, k), until[i], err));
                place[k] = next;
                ck_assert_stein(
                    stein_batch_put(batch, k, next < PLACES ? t.rider[next] : NULL, err));
                next++;
                done++;
            }
        }
        ck_assert_stein(stein_batch_step(batch, NULL, err));
    }
    stein_batch_destroy(batch);
    for (int i = 0; i < PLACES; i++) {
        ck_assert_stein(stein_batch_put(t.batch, i, t.rider[i], err));
    }
    compare_twins(&t);
    drop_twins(&t);
}
END_TEST

START_TEST(several_steps_in_one_go_end_with_the_first_event)
{
    const stein_model *model = &stein_model_stein1788;
    enum { MOST = 700, ALL = 4200 };
    long taken, all = 0, calls = 0;
    stein_batch *batch = NULL;
    twins t;
    if (!has_width(model, widths[_i])) {
        return;
    }
    int n = widths[_i];
    make_twins(&t, model, STEIN_RK4, n, regulate);
    ck_assert_stein(stein_batch_create(&batch, model, NULL, n, n, err));
    for (int i = 0; i < n; i++) {
        ck_assert_stein(stein_batch_put(t.batch, i, NULL, err));
        ck_assert_stein(stein_batch_put(batch, i, t.rider[i], err));
    }
    for (; all < ALL; all += taken, calls++) {
        ck_assert_stein(stein_batch_steps(batch, MOST, &taken, NULL, err));
        ck_assert(taken >= 1 && taken <= MOST);
        for (int i = 0; i < n; i++) {
            int heard_of = t.of_alone[i].n;
            for (long k = 0; k < taken; k++) {
                ck_assert_int_eq(t.of_alone[i].n, heard_of); // none but in the last one
                ck_assert_stein(stein_step(t.alone[i], err));
            }
        }
    }
    ck_assert(n == 1 ? calls == ALL : calls >= ALL / MOST && calls < ALL / 10);
    for (int i = 0; i < n; i++) {
        ck_assert_stein(stein_batch_put(batch, i, NULL, err));
        ck_assert_stein(stein_batch_put(t.batch, i, t.rider[i], err));
    }
    compare_twins(&t);
    stein_batch_destroy(batch);

    // several groups go on together
    ck_assert_stein(stein_batch_steps(t.batch, MOST, &taken, NULL, err));
    ck_assert_int_eq(taken, 1);
    for (int i = 0; i < PLACES; i++) {
        ck_assert_stein(stein_step(t.alone[i], err));
    }
    compare_twins(&t);
    drop_twins(&t);
}
END_TEST

START_TEST(looking_changes_nothing_and_changes_between_steps_count)
{
    twins t;
    if (!has_width(&stein_model_stein1788, widths[_i])) {
        return;
    }
    make_twins(&t, &stein_model_stein1788, STEIN_DP5, widths[_i], regulate);
    for (int n = 0; n < 400; n++) {
        for (int i = 0; i < PLACES; i++) {
            ck_assert_stein(stein_step(t.alone[i], err));
        }
        ck_assert_stein(stein_batch_step(t.batch, NULL, err));
        double eq, eqd, eq_rider, eqd_rider;
        int i = n % PLACES;
        stein_sim *rider = stein_batch_look(t.batch, i);
        ck_assert(stein_read(rider, 2) == stein_read(t.alone[i], 2));
        ck_assert_stein(stein_step_error(t.alone[i], &eq, &eqd, err));
        ck_assert_stein(stein_step_error(rider, &eq_rider, &eqd_rider, err));
        ck_assert(eq == eq_rider && eqd == eqd_rider);
        if (n % 50 == 20) {
            set(t.alone[i], "load.mass", 0.1 + 1e-4 * n);
            set(stein_batch_sim(t.batch, i), "load.mass", 0.1 + 1e-4 * n);
        }
    }
    compare_twins(&t);
    drop_twins(&t);
}
END_TEST

/* ---- trouble ---- */

static void blow_up(stein_sim *sim, int i)
{
    double q[8], qd[8];
    regulate(sim, i);
    if (i == 2 || i == 5) {
        memcpy(q, stein_q(sim), sizeof *q * 4);
        memcpy(qd, stein_qd(sim), sizeof *qd * 4);
        qd[1] = i == 2 ? 1e155 : 1e200;
        ck_assert_stein(stein_set_state(sim, 0.0, q, qd, err));
    }
}

START_TEST(a_simulation_that_fails_fails_alone_with_the_words_it_always_has)
{
    stein_status alone[PLACES], rider[PLACES];
    stein_err first = {STEIN_OK, ""}, said;
    twins t;
    if (!has_width(&stein_model_stein1788, widths[_i])) {
        return;
    }
    make_twins(&t, &stein_model_stein1788, STEIN_RK4, widths[_i], blow_up);
    double t_end[PLACES];
    for (int i = PLACES - 1; i >= 0; i--) {
        t_end[i] = i == 7 ? -1.0 : 0.003; // there is no way back in time
        alone[i] = stein_run(t.alone[i], t_end[i], &said);
        first = alone[i] != STEIN_OK && i != 7 ? said : first;
    }
    ck_assert_int_eq(stein_batch_run(t.batch, t_end, rider, &said), alone[2]);
    for (int i = 0; i < PLACES; i++) {
        ck_assert_int_eq(rider[i], alone[i]);
        ck_assert_int_eq(rider[i], i == 2 || i == 5 ? STEIN_ENONFINITE
                                   : i == 7         ? STEIN_EINVAL
                                                    : STEIN_OK);
    }
    ck_assert_str_eq(
        said.msg,
        "cannot run to t = -1 s from t = 0 s: expected a time that is still to come"); // the first
                                                                                       // to be
                                                                                       // known
    t_end[7] = 0.003;
    ck_assert_stein(stein_run(t.alone[7], t_end[7], err));
    ck_assert_int_eq(stein_batch_run(t.batch, t_end, rider, &said), alone[2]);
    ck_assert_str_eq(said.msg, first.msg);
    for (int i = 0; i < PLACES; i++) {
        if (alone[i] == STEIN_OK || i == 7) {
            ck_assert(stein_time(stein_batch_look(t.batch, i)) == 0.003);
            ck_assert(memcmp(stein_q(t.alone[i]), stein_q(t.rider[i]), 32) == 0);
        }
    }
    drop_twins(&t);
}
END_TEST

START_TEST(a_batch_is_one_block_and_refuses_other_simulations)
{
    const stein_model *model = &stein_model_stein1788;
    stein_sim_def def = stein_sim_def_default(model);
    stein_batch *batch = NULL;
    stein_err err;
    int live = 0;
    def.ctx = &live;
    def.alloc = count_alloc;
    def.release = count_release;
    ck_assert_int_eq(stein_batch_create(&batch, model, &def, 0, 0, &err), STEIN_EINVAL);
    ck_assert_int_eq(stein_batch_create(&batch, model, &def, 4, 3, &err), STEIN_EINVAL);
    ck_assert_int_eq(stein_batch_create(&batch, model, &def, 4, 16, &err), STEIN_EINVAL);
    ck_assert(strstr(err.msg, "16 lanes") != NULL);
    def.integrator = (stein_integrator)7;
    ck_assert_int_eq(stein_batch_create(&batch, model, &def, 4, 0, &err), STEIN_EINVAL);
    def.integrator = STEIN_RK4;
    def.alloc = no_memory;
    ck_assert_int_eq(stein_batch_create(&batch, model, &def, 4, 0, &err), STEIN_ENOMEM);
    def.alloc = count_alloc;
    ck_assert_ptr_null(batch);
    ck_assert_int_eq(live, 0);
    ck_assert_int_eq(stein_batch_create(&batch, model, &def, 4, 0, &err), STEIN_OK);
    ck_assert_int_eq(live, 1);

    stein_sim *sim = make_sim(model, STEIN_DP5, 0.0);
    stein_sim *other = make_sim(&stein_model_pendulum, STEIN_RK4, 0.0);
    ck_assert_int_eq(stein_batch_put(batch, 1, sim, &err), STEIN_EINVAL); // another integrator
    ck_assert_int_eq(stein_batch_put(batch, 1, other, &err), STEIN_EINVAL);
    ck_assert(strstr(err.msg, "pendulum") != NULL);
    ck_assert_int_eq(stein_batch_put(batch, 4, NULL, &err), STEIN_EINVAL);
    ck_assert_int_eq(stein_batch_put(batch, -1, NULL, &err), STEIN_EINVAL);
    ck_assert_ptr_null(stein_batch_sim(batch, 1));
    ck_assert_ptr_null(stein_batch_look(batch, 9));
    ck_assert_int_eq(stein_batch_step(batch, NULL, &err), STEIN_OK); // the place is empty
    stein_sim_destroy(sim);
    stein_sim_destroy(other);
    stein_batch_destroy(batch);
    stein_batch_destroy(NULL);
    ck_assert_int_eq(live, 0);
}
END_TEST

Suite *batch_suite(void)
{
    Suite *suite = suite_create("batch");
    TCase *tc = tcase_create("batch");
    tcase_set_timeout(tc, 120.0);
    tcase_add_loop_test(tc, strokes_in_lanes_have_the_bits_of_strokes_alone, 0, 8);
    tcase_add_loop_test(tc, so_have_strokes_with_every_law, 0, 8);
    tcase_add_loop_test(tc, controlled_steps_in_lanes_have_the_bits_of_those_alone, 0, 12);
    tcase_add_test(tc, a_pace_that_is_out_of_range_is_refused_for_its_place_alone);
    tcase_add_loop_test(tc, every_mechanism_moves_in_lanes_as_alone, 0, 4);
    tcase_add_loop_test(tc, angles_of_any_size_turn_in_lanes_as_alone, 0, 4);
    tcase_add_loop_test(tc, those_that_cannot_ride_run_alone_beside_those_that_can, 0, 4);
    tcase_add_test(tc, a_place_is_filled_again_while_others_go_on);
    tcase_add_loop_test(tc, several_steps_in_one_go_end_with_the_first_event, 0, 4);
    tcase_add_loop_test(tc, looking_changes_nothing_and_changes_between_steps_count, 0, 4);
    tcase_add_loop_test(tc, a_simulation_that_fails_fails_alone_with_the_words_it_always_has, 0, 4);
    tcase_add_test(tc, a_batch_is_one_block_and_refuses_other_simulations);
    suite_add_tcase(suite, tc);
    return suite;
}
