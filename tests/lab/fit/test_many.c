/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_many.c - many runs, and fits, that take turns in a few lanes: alone they are the same to the
 * last bit.
 */
#include "fit_support.h"
#include "fitting.h"
#include "stein/batch.h"

/* ---- places of a batch that go to the next run while others are on their way ---- */

enum { RUNS = 13, PLACES = 5, LOOKS = 40 };

typedef struct one_run {
    stein_sim *sim;
    stein_pace pace;
    double t_end, seen[LOOKS];
    int n;
} one_run;

static double look(void *ctx, stein_sim *sim)
{
    one_run *r = ctx;
    ck_assert_int_lt(r->n, LOOKS);
    r->seen[r->n++] = stein_read(sim, stein_find_channel(stein_sim_model(sim), "hammer_height"));
    return 2.3e-3 * r->n;
}

/* strokes that differ in regulation and length; number 7 is asked for more than steps can do */
static void make_runs(one_run *r)
{
    for (int i = 0; i < RUNS; i++) {
        stein_sim_def def = stein_sim_def_default(&stein_model_stein1788);
        def.integrator = STEIN_DP5;
        r[i] = (one_run){.t_end = 0.031 + 0.0037 * (i * 5 % RUNS)};
        ck_assert_stein(stein_sim_create(&r[i].sim, &stein_model_stein1788, &def, err));
        ck_assert_stein(stein_set(r[i].sim, "pawl.stop_shift", -0.071e-3 * i, err));
        ck_assert_stein(stein_reset(r[i].sim, err));
        r[i].pace = (stein_pace){.tolerance = i == 7 ? 1e-26 : 1e-9,
                                 .longest = 1e-3,
                                 .h = 1e-5,
                                 .look = look,
                                 .ctx = &r[i]};
    }
}

static void take_turns(one_run *r, int width, stein_status *status, stein_err *failed)
{
    stein_sim_def def = stein_sim_def_default(&stein_model_stein1788);
    stein_batch *batch = NULL;
    int at[PLACES], next = 0, ended = 0, i = 0;
    def.integrator = STEIN_DP5;
    ck_assert_stein(stein_batch_create(&batch, &stein_model_stein1788, &def, PLACES, width, err));
    for (; i >= 0; ended++) {
        for (int k = next == 0 ? 0 : i; next < RUNS && (next < PLACES || k == i); k++) {
            at[k] = next++;
            ck_assert_stein(stein_batch_put(batch, k, r[at[k]].sim, err));
            ck_assert_stein(stein_batch_begin(batch, k, r[at[k]].t_end, &r[at[k]].pace, err));
        }
        stein_status done;
        stein_err why;
        i = stein_batch_go(batch, &done, &why);
        if (i >= 0) {
            status[at[i]] = done;
            *failed = done != STEIN_OK ? why : *failed;
        }
    }
    ck_assert_int_eq(ended, RUNS + 1);
    stein_batch_destroy(batch);
}

START_TEST(runs_that_take_turns_in_lanes_have_the_bits_of_runs_alone)
{
    static const int widths[] = {1, 2, 4, 8};
    static one_run alone[RUNS], rider[RUNS];
    stein_status status[RUNS];
    stein_err why = {STEIN_OK, ""}, failed = {STEIN_OK, ""};
    if (widths[_i] > stein_batch_width(&stein_model_stein1788)) {
        printf("no %d lanes on this processor: skipped\n", widths[_i]);
        return;
    }
    make_runs(alone);
    make_runs(rider);
    take_turns(rider, widths[_i], status, &failed);
    for (int i = 0; i < RUNS; i++) {
        one_run *a = &alone[i], *b = &rider[i];
        size_t size = sizeof(double) * (size_t)stein_model_stein1788.nq;
        ck_assert_int_eq(stein_run_adaptive(a->sim, a->t_end, &a->pace, &why), status[i]);
        ck_assert_int_eq(status[i], i == 7 ? STEIN_ECHATTER : STEIN_OK);
        ck_assert(stein_time(a->sim) == stein_time(b->sim));
        ck_assert(memcmp(stein_q(a->sim), stein_q(b->sim), size) == 0);
        ck_assert(memcmp(stein_qd(a->sim), stein_qd(b->sim), size) == 0);
        ck_assert_int_eq(stein_trials(a->sim), stein_trials(b->sim));
        ck_assert(a->pace.h == b->pace.h && a->pace.next == b->pace.next && a->n == b->n);
        ck_assert(memcmp(a->seen, b->seen, sizeof a->seen) == 0);
        ck_assert(i == 7 || a->n > 12);
        stein_sim_destroy(a->sim);
        stein_sim_destroy(b->sim);
    }
    ck_assert_str_eq(why.msg, failed.msg);
}
END_TEST

START_TEST(a_place_without_simulation_begins_no_run)
{
    stein_batch *batch = NULL;
    stein_pace pace = {.tolerance = 1e-9, .longest = 1e-3, .h = 1e-5};
    stein_status status = STEIN_EINVAL;
    stein_err why;
    ck_assert_stein(stein_batch_create(&batch, &stein_model_stein1788, NULL, 2, 0, err));
    for (int i = -1; i <= 2; i++) {
        ck_assert_int_eq(stein_batch_begin(batch, i, 0.1, &pace, &why), STEIN_EINVAL);
        ck_assert_ptr_nonnull(strstr(why.msg, "of a batch of 2 has no simulation to run"));
    }
    ck_assert_int_eq(stein_batch_go(batch, &status, &why), -1); // nothing is under way
    ck_assert_int_eq(status, STEIN_OK);
    stein_batch_destroy(batch);
}
END_TEST

/* ---- strokes of a fit ---- */

/* simulations of a fit, by one number of lanes and threads */
typedef struct asked {
    double *r, *J;
    int failed;
    stein_status status; /* of the derivatives */
    char why[sizeof((stein_err *)0)->msg];
} asked;

static asked ask(fit__problem *p, const double *x, int lanes, int threads)
{
    asked a = {.r = calloc(fit__offset(p, p->nstroke) + 1, sizeof *a.r),
               .J = calloc(fit__columns(p) + 1, sizeof *a.J)};
    stein_err why = {STEIN_OK, ""};
    p->lanes = lanes;
    p->threads = threads;
    ck_assert_stein(fit__residuals(p, x, a.r, &a.failed, err));
    a.status = fit__sensitivities(p, x, a.r, a.J, &why);
    memcpy(a.why, why.msg, sizeof a.why);
    return a;
}

static void forget(asked *a)
{
    free(a->r);
    free(a->J);
}

/* the same from all lanes and several threads as from one stroke after the other */
static void compare(fit__problem *p, const double *x, int failed, stein_status status)
{
    asked plain = ask(p, x, 1, 1);
    ck_assert_int_eq(plain.failed, failed);
    ck_assert_int_eq(plain.status, status);
    for (int threads = 1; threads <= 3; threads += 2) {
        asked wide = ask(p, x, 0, threads);
        ck_assert_int_eq(wide.failed, failed);
        ck_assert_int_eq(wide.status, status);
        ck_assert_str_eq(wide.why, plain.why);
        ck_assert(failed ||
                  memcmp(wide.r, plain.r, sizeof *wide.r * fit__offset(p, p->nstroke)) == 0);
        ck_assert(status != STEIN_OK ||
                  memcmp(wide.J, plain.J, sizeof *wide.J * fit__columns(p)) == 0);
        forget(&wide);
    }
    forget(&plain);
}

/* residuals of strokes that are simulated for themselves */
static void compare_alone(const fit__problem *p, const double *x)
{
    double *r = calloc(fit__offset(p, p->nstroke) + 1, sizeof *r);
    int failed;
    fit__bench b;
    ck_assert_stein(fit__residuals(p, x, r, &failed, err));
    ck_assert_stein(fit__bench_make(&b, p, err));
    for (int s = 0; s < p->nstroke; s++) {
        size_t n = (size_t)(p->stroke[s].nch * p->stroke[s].n);
        ck_assert_stein(fit__simulate(p, &b, s, x, b.y, err));
        fit__weigh(&p->stroke[s], b.y);
        ck_assert(memcmp(b.y, r + fit__offset(p, s), sizeof *r * n) == 0);
    }
    fit__bench_free(&b);
    free(r);
}

START_TEST(strokes_of_a_fit_are_the_same_alone_and_side_by_side)
{
    static const char *const data[] = {"models/strokes/stroke_01.csv",
                                       "models/strokes/stroke_05.csv",
                                       "models/strokes/stroke_14.csv", NULL};
    static const char *const names[] = {"pawl.spring.k", "key.centre.x", "hammer.friction.A", NULL};
    fit__problem p;
    fitted f;
    open_fit(&f, "models/stein1788.yaml", NULL, data);
    lab_fit_def def = free_these(names);
    ck_assert_stein(fit__problem_make(&p, f.model, f.data, &def, err));
    p.tolerance = 1e-9;
    double *x = calloc((size_t)p.nu + 1, sizeof *x);
    for (int k = 0; k < p.nu; k++) {
        x[k] = 0.11 * (k % 7 - 3);
    }
    p.central = _i;
    compare(&p, x, 0, STEIN_OK);
    compare_alone(&p, x);
    p.horizon = 0.037;
    compare(&p, x, 0, STEIN_OK);
    p.step[1] = 1e7; // on one side of it there is no equilibrium
    compare(&p, x, 0, STEIN_OK);
    x[1] = 1e7;
    compare(&p, x, p.nstroke, STEIN_ENONFINITE);
    free(x);
    fit__problem_free(&p);
    drop(&f);
}
END_TEST

/* a pushed pendulum, unchanged */
static const char *pushed(const char *name, double phase)
{
    const char *path = in_folder(name);
    FILE *to = fopen(path, "w");
    ck_assert_ptr_nonnull(to);
    fprintf(to, "# noise angle: 1e-3\ntime [s],push [N m],angle [rad]\n");
    for (int i = 0; i < 160; i++) {
        double t = 0.01 * i;
        fprintf(to, "%.17g,%.17g,%.17g\n", t, 0.03 * sin(7.1 * t + phase), 0.5 * cos(6.5 * t));
    }
    fclose(to);
    return path;
}

START_TEST(strokes_with_a_recorded_input_are_recovered)
{
    static const char *const names[] = {"rod.mass", "rod.damping", NULL};
    const char *data[] = {pushed("a.csv", 0.3), pushed("b.csv", 1.9), NULL};
    fit__problem p;
    fitted f;
    open_fit(&f, "models/pendulum.yaml", NULL, data);
    lab_fit_def def = free_these(names);
    ck_assert_stein(fit__problem_make(&p, f.model, f.data, &def, err));
    double *x = calloc((size_t)p.nu + 1, sizeof *x);
    ck_assert_int_eq(p.stroke[0].nsignal, 1);
    compare(&p, x, 0, STEIN_OK);
    compare_alone(&p, x);
    p.gain = 0.4; // down the ladder
    compare(&p, x, 0, STEIN_OK);
    free(x);
    fit__problem_free(&p);
    drop(&f);
}
END_TEST

START_TEST(a_stroke_of_many_stiff_runs_cannot_be_simulated)
{
    static const char *const names[] = {"rod.damping", NULL};
    const char *data[] = {pushed("a.csv", 0.3), NULL};
    fit__problem p;
    fitted f;
    fit__bench b;
    stein_err why;
    open_fit(&f, "models/pendulum.yaml", NULL, data);
    lab_fit_def def = free_these(names);
    ck_assert_stein(fit__problem_make(&p, f.model, f.data, &def, err));
    double *x = calloc((size_t)p.nu + 1, sizeof *x);
    p.gain = _i == 0 ? 0.0 : 0.4; // down the ladder
    ck_assert_stein(fit__bench_make(&b, &p, err));
    ck_assert_stein(fit__simulate(&p, &b, 0, x, b.y, err));
    long long usual = stein_trials(b.sim);
    const fit__unknown *u = &p.unknown[0];
    x[0] = ((u->log ? log(5e3) : 5e3) - u->start) / u->sd; // N m s/rad
    ck_assert_int_eq(fit__simulate(&p, &b, 0, x, b.y, &why), STEIN_ECHATTER);
    ck_assert_msg(strstr(why.msg, "the simulation is too stiff: steps of ") != NULL, "%s", why.msg);
    ck_assert(stein_time(b.sim) > 0.05); // no single run was too much
    ck_assert_int_gt(stein_trials(b.sim), 20 * usual);
    x[0] = 0.0;
    ck_assert_stein(fit__simulate(&p, &b, 0, x, b.y, err)); // the next stroke has its own limit
    fit__bench_free(&b);
    free(x);
    fit__problem_free(&p);
    drop(&f);
}
END_TEST

/* an action whose key goes down and stays there */
static const char *led(const char *name, double time)
{
    const char *path = in_folder(name);
    FILE *to = fopen(path, "w");
    ck_assert_ptr_nonnull(to);
    fprintf(to, "# noise string_distance: 1e-5\ntime [s],key_motion [rad],string_distance [m]\n");
    for (int i = 0; i < 160; i++) {
        double t = 0.5e-3 * i, u = fmin(t / time, 1.0);
        fprintf(to, "%.17g,%.17g,%.17g\n", t, 0.05 * u * u * u * (10.0 - 15.0 * u + 6.0 * u * u),
                0.039 * (1.0 - u));
    }
    fclose(to);
    return path;
}

START_TEST(so_are_those_with_a_recorded_motion)
{
    static const char *const names[] = {"hammer.mass", "pawl.spring.k", "key_motion.delay", NULL};
    const char *data[] = {led("a.csv", 0.041), led("b.csv", 0.063), NULL};
    fit__problem p;
    fitted f;
    open_fit(&f, "models/stein1788.yaml", NULL, data);
    lab_fit_def def = free_these(names);
    ck_assert_stein(fit__problem_make(&p, f.model, f.data, &def, err));
    double *x = calloc((size_t)p.nu + 1, sizeof *x);
    x[2] = 0.7;
    compare(&p, x, 0, STEIN_OK);
    compare_alone(&p, x);
    free(x);
    fit__problem_free(&p);
    drop(&f);
}
END_TEST

/* ---- fits that share seats ---- */

enum { FITS = 11, UNKNOWNS = 32 };

typedef struct apart {
    const fitted *f;
    const lab_fit_def *def;
    int fails; /* the piece that does */
    double x[FITS][UNKNOWNS], objective[FITS];
} apart;

/* fit i is a fit of a single stroke, from its own start */
static stein_status fit_apart(void *ctx, int i, fit__pool *pool, stein_err *failed)
{
    apart *a = ctx;
    lab_dataset one = {1, &a->f->data->stroke[i % 3]};
    fit__problem p;
    if (i == a->fails) {
        return lab__fail(failed, STEIN_ESINGULAR, "fit %d has had enough", i);
    }
    ck_assert_stein(fit__problem_make(&p, a->f->model, &one, a->def, err));
    ck_assert_int_le(p.nu, UNKNOWNS);
    double *room = calloc(fit__offset(&p, 1) + fit__columns(&p) + 1, sizeof *room);
    fit__end e = {.x = a->x[i], .r = room, .J = room + fit__offset(&p, 1)};
    p.tolerance = 1e-8;
    p.horizon = i % 4 == 3 ? 0.03 : INFINITY;
    p.pool = pool;
    e.x[i % p.nu] = 0.3;
    ck_assert_stein(fit__descend(&p, &e, 0, 0.3, 1, err));
    a->objective[i] = e.objective;
    free(room);
    fit__problem_free(&p);
    return STEIN_OK;
}

START_TEST(fits_that_share_seats_have_the_bits_of_fits_alone)
{
    static const char *const data[] = {"models/strokes/stroke_01.csv",
                                       "models/strokes/stroke_05.csv",
                                       "models/strokes/stroke_14.csv", NULL};
    static const char *const names[] = {"pawl.spring.k", "hammer.friction.A", NULL};
    static apart plain, shared;
    fit__problem all;
    fitted f;
    open_fit(&f, "models/stein1788.yaml", NULL, data);
    lab_fit_def def = free_these(names);
    ck_assert_stein(fit__problem_make(&all, f.model, f.data, &def, err));
    plain = (apart){.f = &f, .def = &def, .fails = -1};
    for (int i = 0; i < FITS; i++) {
        ck_assert_stein(fit_apart(&plain, i, NULL, err));
    }
    for (int threads = 1; threads <= 3; threads++) {
        shared = (apart){.f = &f, .def = &def, .fails = -1};
        all.threads = threads;
        all.lanes = threads == 2; // one seat for each thread; else as many as there are
        ck_assert_stein(fit__together(&all, FITS, fit_apart, &shared, err));
        ck_assert(memcmp(plain.x, shared.x, sizeof plain.x) == 0);
        ck_assert(memcmp(plain.objective, shared.objective, sizeof plain.objective) == 0);
    }
    ck_assert_double_ne(plain.objective[0], plain.objective[6]); // the same stroke, other starts
    stein_err why;
    shared = (apart){.f = &f, .def = &def, .fails = 4};
    ck_assert_int_eq(fit__together(&all, FITS, fit_apart, &shared, &why), STEIN_ESINGULAR);
    ck_assert_str_eq(why.msg, "fit 4 has had enough");
    ck_assert_stein(fit__together(&all, 0, fit_apart, &shared, err));
    fit__problem_free(&all);
    drop(&f);
}
END_TEST

START_TEST(lanes_that_the_processor_lacks_are_refused)
{
    static const char *const names[] = {"rod.mass", NULL};
    const char *data[] = {pushed("a.csv", 0.3), NULL};
    fitted f;
    lab_fit_def def = free_these(names);
    open_fit(&f, "models/pendulum.yaml", NULL, data);
    static const int bad[] = {-1, 3, 16};
    stein_err why;
    for (int i = 0; i < 3; i++) {
        def.lanes = bad[i];
        ck_assert_int_eq(lab_fit_run(&f.fit, f.model, f.data, &def, &why), STEIN_EINVAL);
        ck_assert_str_eq(why.msg, "lab_fit_def.lanes is out of range");
    }
    drop(&f);
}
END_TEST

Suite *many_suite(void)
{
    Suite *s = suite_create("many");
    TCase *turns = tcase_create("turns"), *fit = tcase_create("fit");
    tcase_add_loop_test(turns, runs_that_take_turns_in_lanes_have_the_bits_of_runs_alone, 0, 4);
    tcase_add_test(turns, a_place_without_simulation_begins_no_run);
    tcase_set_timeout(turns, 60);
    tcase_add_checked_fixture(fit, make_folder, remove_folder);
    tcase_add_loop_test(fit, strokes_of_a_fit_are_the_same_alone_and_side_by_side, 0, 2);
    tcase_add_test(fit, strokes_with_a_recorded_input_are_recovered);
    tcase_add_test(fit, so_are_those_with_a_recorded_motion);
    tcase_add_loop_test(fit, a_stroke_of_many_stiff_runs_cannot_be_simulated, 0, 2);
    tcase_add_test(fit, fits_that_share_seats_have_the_bits_of_fits_alone);
    tcase_add_test(fit, lanes_that_the_processor_lacks_are_refused);
    tcase_set_timeout(fit, 60);
    suite_add_tcase(s, turns);
    suite_add_tcase(s, fit);
    return s;
}
