/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_realtime.c - guarantees for a real-time host: no system call, no allocation, errno
 * unchanged. Parameters from another thread arrive whole, late or never, but never torn, and never
 * faster than their pace.
 */
#define _DEFAULT_SOURCE // syscall
#include <errno.h>
#include <float.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>
#if defined __linux__
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#endif

#include "sanitized.h"
#include "stein/handover.h"
#include "support.h"

/* steps of the sandboxed run; one stroke, and the calls at its end */
enum { STEPS = SANITIZED ? 100000 : 1000000, STROKE = 12000, RELEASE = 9000, RETUNE = 500 };

/* ---- the sandbox ---- */

/* everything that a host may do between two blocks of sound, on a simulation that never ends */
typedef struct host {
    stein_sim *sim;
    stein_handover *handover;
    void *start;  /* state at the beginning of a stroke */
    double push;  /* input without a signal: calls of the hooks */
    double heard; /* sum of the readings */
    int events, retunes;
} host;

static void on_event(void *ctx, stein_sim *sim, const stein_event *event)
{
    host *h = ctx;
    h->events++;
    h->heard += stein_time(sim) - event->time;
}

static void on_force(void *ctx, double t, const double *q, const double *qd, double *Q)
{
    (void)t;
    (void)q;
    host *h = ctx;
    h->push = -1e-6 * qd[0];
    Q[0] += h->push;
}

static void host_open(host *h)
{
    memset(h, 0, sizeof *h);
    h->sim = make_sim(&stein_model_stein1788, STEIN_RK4, 20e-6);
    ck_assert_stein(stein_handover_create(&h->handover, &stein_model_stein1788, NULL, err));
    h->start = malloc(stein_state_size(h->sim));
    stein_save(h->sim, h->start);
    stein_on_event(h->sim, on_event, h);
    stein_on_force(h->sim, on_force, h);
}

static void host_close(host *h)
{
    stein_handover_destroy(h->handover);
    stein_sim_destroy(h->sim);
    free(h->start);
}

static stein_status host_step(host *h, int i)
{
    stein_status status = STEIN_OK;
    stein_err err;
    if (i % RETUNE == 0) {
        double dx = 1e-3 * (0.2 - 1.2 * (double)(i / RETUNE % 7) / 6.0);
        stein_handover_pace(h->handover, "pawl.stop_shift", 0.05, NULL);
        stein_handover_set(h->handover, "pawl.stop_shift", dx, NULL);
        stein_handover_publish(h->handover);
    }
    h->retunes += stein_handover_take(h->handover, h->sim);
    if (i % STROKE == RELEASE) {
        stein_load_lift(h->sim);
    }
    if (i % STROKE == 0 && i % (2 * STROKE) != 0) {
        status = stein_reset(h->sim, &err);
    } else if (i % STROKE == 0) {
        status = stein_restore(h->sim, h->start, &err);
    }
    status = status == STEIN_OK ? stein_step(h->sim, &err) : status;
    h->heard += stein_read(h->sim, 1);
    return status;
}

/* a hash of all bits of the result (FNV-1a) */
static unsigned long long fingerprint(const host *h)
{
    unsigned char state[1024];
    unsigned long long hash = 0xcbf29ce484222325ull;
    size_t size = stein_state_size(h->sim);
    ck_assert_uint_le(size, sizeof state);
    stein_save(h->sim, state);
    for (size_t i = 0; i < size; i++) {
        hash = (hash ^ state[i]) * 0x100000001b3ull;
    }
    double numbers[] = {h->heard, (double)h->events, (double)h->retunes};
    for (size_t i = 0; i < sizeof numbers; i++) {
        hash = (hash ^ ((const unsigned char *)numbers)[i]) * 0x100000001b3ull;
    }
    return hash;
}

typedef struct answer {
    unsigned long long hash;
    int status, steps, events, retunes, errno_after;
} answer;

static answer play(host *h)
{
    answer a = {.status = STEIN_OK};
    errno = 4711;
    while (a.steps < STEPS && a.status == STEIN_OK) {
        a.status = (int)host_step(h, a.steps);
        a.steps += a.status == STEIN_OK;
    }
    a.errno_after = errno;
    a.hash = fingerprint(h);
    a.events = h->events;
    a.retunes = h->retunes;
    return a;
}

#if defined __linux__
/* in a process that may read, write and exit, and is killed for anything else; meanwhile the same
 * outside, unless `outside` is NULL. @return 1 it lived, 0 it was killed, -1 no sandbox here */
static int in_sandbox(answer *a, answer *outside, int misbehave)
{
    int pipes[2], status = -1;
    host h;
    host_open(&h);
    ck_assert_int_eq(pipe(pipes), 0);
    pid_t child = fork();
    if (child == 0) {
        if (prctl(PR_SET_SECCOMP, SECCOMP_MODE_STRICT) != 0) {
            _exit(77);
        }
        if (misbehave) {
            (void)getppid();
        }
        answer mine = play(&h);
        ssize_t written = write(pipes[1], &mine, sizeof mine);
        syscall(SYS_exit, written == (ssize_t)sizeof mine ? 0 : 1);
    }
    close(pipes[1]);
    if (outside != NULL) {
        *outside = play(&h);
    }
    ssize_t got = read(pipes[0], a, sizeof *a);
    close(pipes[0]);
    ck_assert_int_eq(waitpid(child, &status, 0), child);
    host_close(&h);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 77) {
        return -1; // no seccomp here
    }
    return WIFEXITED(status) && WEXITSTATUS(status) == 0 && got == (ssize_t)sizeof *a;
}

START_TEST(a_million_steps_make_no_system_call_and_leave_errno_alone)
{
    answer boxed = {0}, outside = {0};
    int fine = in_sandbox(&boxed, &outside, 0);
    if (fine < 0) {
        puts("test_realtime: no seccomp here, system calls are not tested");
        return;
    }
    ck_assert_int_eq(fine, 1);
    ck_assert_int_eq(boxed.status, STEIN_OK);
    ck_assert_int_eq(boxed.steps, STEPS);
    ck_assert_int_eq(boxed.errno_after, 4711);
    ck_assert_int_gt(boxed.events, STEPS / 2000);    // strokes with contacts and escapements
    ck_assert_int_gt(boxed.retunes, STEPS / RETUNE); // on their way for several steps
    ck_assert(outside.hash == boxed.hash);
}
END_TEST

START_TEST(the_sandbox_kills_for_one_system_call)
{
    answer a;
    int fine = in_sandbox(&a, NULL, 1);
    ck_assert_int_le(fine, 0);
}
END_TEST
#endif

START_TEST(failures_leave_errno_alone_too)
{
    stein_sim_def def = stein_sim_def_default(&stein_model_bouncing_ball);
    def.dt = 1.0;
    stein_sim *sim;
    stein_err told = {STEIN_OK, ""};
    ck_assert_stein(stein_sim_create(&sim, &stein_model_bouncing_ball, &def, err));
    ck_assert_stein(stein_set(sim, "floor.normal.c", 1e308, err));
    errno = 4711;
    stein_status status = STEIN_OK;
    for (int i = 0; i < 100 && status == STEIN_OK; i++) {
        status = stein_step(sim, &told);
    }
    ck_assert(status != STEIN_OK && told.msg[0] != '\0');
    ck_assert_int_eq(errno, 4711);
    stein_sim_destroy(sim);
    // numbers in messages come without libm
    static const struct {
        double dt;
        const char *text;
    } shown[] = {
        {-5e-324, "-4.94065646e-324 s"},     {-DBL_MAX, "-1.79769313e308 s"}, {-1e9, "-1e9 s"},
        {-0.999999999999, "-1 s"},           {-123456789.0, "-123456789 s"},  {-1e-4, "-0.0001 s"},
        {-9.87654321e-5, "-9.87654321e-5 s"}};
    for (int i = 0; i < 7; i++) {
        def.dt = shown[i].dt;
        ck_assert_int_eq(stein_sim_create(&sim, &stein_model_pendulum, &def, &told), STEIN_EINVAL);
        ck_assert_msg(strstr(told.msg, shown[i].text) != NULL, "%s: %s", shown[i].text, told.msg);
    }
    ck_assert_int_eq(errno, 4711);
}
END_TEST

/* ---- the hand-over ---- */

static double value(const stein_sim *sim, const char *name)
{
    double v = NAN;
    ck_assert_stein(stein_get(sim, name, &v, err));
    return v;
}

START_TEST(the_last_published_set_is_taken_and_other_values_are_untouched)
{
    stein_sim *sim = make_sim(&stein_model_stein1788, STEIN_RK4, 0.0);
    stein_handover *h;
    ck_assert_stein(stein_handover_create(&h, stein_sim_model(sim), NULL, err));
    double mass = value(sim, "hammer.mass"), k = value(sim, "pawl.spring.k");
    ck_assert_int_eq(stein_handover_take(h, sim), 0); // nothing there
    ck_assert_stein(stein_handover_set(h, "pawl.stop_shift", -0.371e-3, err));
    ck_assert_int_eq(stein_handover_take(h, sim), 0); // not yet
    stein_handover_publish(h);
    ck_assert_stein(stein_handover_set(h, "pawl.stop_shift", -0.513e-3, err));
    ck_assert_stein(stein_handover_set(h, "pawl.spring.k", 1.07 * k, err));
    stein_handover_publish(h);
    ck_assert_stein(stein_set(sim, "hammer.mass", 1.1 * mass, err));
    ck_assert_int_eq(stein_handover_take(h, sim), 1);
    ck_assert(value(sim, "pawl.stop_shift") == -0.513e-3);
    ck_assert(value(sim, "pawl.spring.k") == 1.07 * k);
    ck_assert(value(sim, "hammer.mass") == 1.1 * mass);
    ck_assert_int_eq(stein_handover_take(h, sim), 0); // once
    stein_handover_publish(h);
    ck_assert_int_eq(stein_handover_take(h, sim), 0); // the same again changes nothing

    // it is the simulation that stein_set would have made
    stein_sim *other = make_sim(&stein_model_stein1788, STEIN_RK4, 0.0);
    ck_assert_stein(stein_set(other, "pawl.stop_shift", -0.513e-3, err));
    ck_assert_stein(stein_set(other, "pawl.spring.k", 1.07 * k, err));
    ck_assert_stein(stein_set(other, "hammer.mass", 1.1 * mass, err));
    ck_assert_stein(stein_reset(sim, err));
    ck_assert_stein(stein_reset(other, err));
    ck_assert_stein(stein_run(sim, 0.06, err));
    ck_assert_stein(stein_run(other, 0.06, err));
    ck_assert_int_eq(memcmp(stein_q(sim), stein_q(other), 4 * sizeof(double)), 0);
    stein_handover_destroy(h);
    stein_sim_destroy(sim);
    stein_sim_destroy(other);
}
END_TEST

START_TEST(a_pace_is_kept_in_simulated_time_and_the_end_is_met_exactly)
{
    stein_sim *sim = make_sim(&stein_model_stein1788, STEIN_RK4, 10e-6);
    stein_handover *h;
    ck_assert_stein(stein_handover_create(&h, stein_sim_model(sim), NULL, err));
    ck_assert_stein(stein_set(sim, "pawl.stop_shift", 0.1e-3, err));
    ck_assert_int_eq(stein_handover_take(h, sim), 0);
    ck_assert_stein(stein_handover_set(h, "pawl.stop_shift", -0.237e-3, err));
    ck_assert_stein(stein_handover_pace(h, "pawl.stop_shift", 0.11, err));
    stein_handover_publish(h);
    int changes = 0, steps = 0;
    double before = 0.1e-3;
    for (; steps < 1000; steps++) {
        changes += stein_handover_take(h, sim);
        double now = value(sim, "pawl.stop_shift");
        ck_assert(now <= before && before - now <= 0.11 * 10e-6 * (1.0 + 1e-9));
        before = now;
        ck_assert_stein(stein_step(sim, err));
    }
    ck_assert(before == -0.237e-3);
    ck_assert_int_eq(changes, 307); // 0.337 mm in pieces of 1.1 um
    // turned round on the way, and no way back in time
    ck_assert_stein(stein_handover_set(h, "pawl.stop_shift", 0.2e-3, err));
    stein_handover_publish(h);
    for (int i = 0; i < 50; i++) {
        stein_handover_take(h, sim);
        ck_assert_stein(stein_step(sim, err));
    }
    ck_assert_close(value(sim, "pawl.stop_shift"), -0.237e-3 + 50 * 1.1e-6, 0.0, 1e-12);
    ck_assert_stein(stein_reset(sim, err));
    ck_assert_int_eq(stein_handover_take(h, sim), 0);
    // at once again
    ck_assert_stein(stein_handover_pace(h, "pawl.stop_shift", (double)INFINITY, err));
    stein_handover_publish(h);
    ck_assert_int_eq(stein_handover_take(h, sim), 1);
    ck_assert(value(sim, "pawl.stop_shift") == 0.2e-3);
    stein_handover_destroy(h);
    stein_sim_destroy(sim);
}
END_TEST

/* the most kinetic energy after the pawl's stop was pushed by 0.5 mm into the pawl at rest [J] */
static double disturbance(double rate)
{
    stein_sim *sim = make_sim(&stein_model_stein1788, STEIN_RK4, 10e-6);
    stein_handover *h;
    double most = 0.0;
    ck_assert_stein(stein_handover_create(&h, stein_sim_model(sim), NULL, err));
    stein_load_lift(sim);
    ck_assert_stein(stein_run(sim, 0.05, err));
    stein_handover_take(h, sim);
    ck_assert_stein(stein_handover_set(h, "pawl.stop_shift", -0.5e-3, err));
    ck_assert_stein(stein_handover_pace(h, "pawl.stop_shift", rate, err));
    stein_handover_publish(h);
    for (int i = 0; i < 10000; i++) {
        double kinetic, potential;
        stein_handover_take(h, sim);
        ck_assert_stein(stein_step(sim, err));
        stein_energy(sim, stein_q(sim), stein_qd(sim), &kinetic, &potential);
        most = fmax(most, kinetic);
    }
    ck_assert(value(sim, "pawl.stop_shift") == -0.5e-3);
    stein_handover_destroy(h);
    stein_sim_destroy(sim);
    return most;
}

START_TEST(a_pace_keeps_energy_out_of_a_closed_contact)
{
    double sudden = disturbance((double)INFINITY), slow = disturbance(0.01);
    ck_assert_msg(sudden > 100.0 * slow, "%.3g J at once, %.3g J slowly", sudden, slow);
}
END_TEST

START_TEST(mistakes_are_reported_and_change_nothing)
{
    stein_sim *sim = make_sim(&stein_model_pendulum, STEIN_RK4, 0.0);
    stein_handover *h = NULL;
    stein_err told;
    stein_sim_def def = stein_sim_def_default(&stein_model_pendulum);
    def.release = NULL;
    ck_assert_int_eq(stein_handover_create(&h, &stein_model_pendulum, &def, &told), STEIN_EINVAL);
    ck_assert(strstr(told.msg, "release") != NULL && h == NULL);
    ck_assert_stein(stein_handover_create(&h, &stein_model_pendulum, NULL, err));
    ck_assert_int_eq(stein_handover_set(h, "rod.mas", 1.0, &told), STEIN_ENAME);
    ck_assert(strstr(told.msg, "rod.mas") != NULL);
    ck_assert_int_eq(stein_handover_set(h, "rod.mass", NAN, &told), STEIN_EINVAL);
    ck_assert_int_eq(stein_handover_pace(h, "rod.mass", 0.0, &told), STEIN_EINVAL);
    ck_assert_int_eq(stein_handover_pace(h, "rod.mass", NAN, &told), STEIN_EINVAL);
    ck_assert_int_eq(stein_handover_pace(h, "rod.mas", 1.0, NULL), STEIN_ENAME);
    stein_handover_publish(h);
    ck_assert_int_eq(stein_handover_take(h, sim), 0);
    stein_handover_destroy(h);
    stein_handover_destroy(NULL);
    stein_sim_destroy(sim);
}
END_TEST

/* ---- from another thread ---- */

typedef struct writer {
    stein_handover *handover;
    int sets;
} writer;

/* two parameters that belong together */
static void *publish(void *ctx)
{
    const writer *w = ctx;
    for (int i = 1; i <= w->sets; i++) {
        stein_handover_set(w->handover, "rod.mass", i, NULL);
        stein_handover_set(w->handover, "rod.damping", 2.0 * i, NULL);
        stein_handover_publish(w->handover);
    }
    return NULL;
}

START_TEST(sets_of_another_thread_come_whole_and_in_order)
{
    stein_sim *sim = make_sim(&stein_model_pendulum, STEIN_RK4, 0.0);
    writer w = {.sets = 20000};
    ck_assert_stein(stein_handover_create(&w.handover, &stein_model_pendulum, NULL, err));
    pthread_t thread;
    ck_assert_int_eq(pthread_create(&thread, NULL, publish, &w), 0);
    double last = 0.0;
    while (last < w.sets) {
        if (stein_handover_take(w.handover, sim)) {
            double mass = value(sim, "rod.mass");
            ck_assert(value(sim, "rod.damping") == 2.0 * mass);
            ck_assert(mass > last);
            last = mass;
        }
    }
    pthread_join(thread, NULL);
    stein_handover_destroy(w.handover);
    stein_sim_destroy(sim);
}
END_TEST

/* ---- the work of a step ---- */

/* evaluations of a step of RK4: 4 for the step, two located events, the rest repeated and then
 * implicit; every trial is checked for contacts that are too stiff */
enum { MOST_EVALUATIONS = 31, GESTURES = SANITIZED ? 60 : 600 };

static void count(void *ctx, double t, const double *q, const double *qd, double *Q)
{
    (void)t, (void)q, (void)qd, (void)Q;
    ++*(int *)ctx;
}

static void push_key(void *ctx, double t, double u[3])
{
    (void)t;
    u[0] = *(const double *)ctx;
}

/* in 0..1 */
static double share_of(unsigned long long *seed)
{
    *seed = *seed * 6364136223846793005ull + 1442695040888963407ull;
    return (double)(*seed >> 11) * 0x1p-53;
}

/* another regulation, within the ranges of the file, in the middle of a motion */
static void turn(stein_sim *of, unsigned long long *seed)
{
    static const struct {
        const char *name;
        double from, to;
    } hand[] = {{"pawl.stop_shift", -1.4e-3, 0.4e-3},
                {"pawl.spring.k", 0.01, 0.1},
                {"notch.friction.A", 0.05, 0.6},
                {"pawl.notch_angle", 1.22, 2.09}};
    for (int i = 0; i < 4; i++) {
        double value = hand[i].from + share_of(seed) * (hand[i].to - hand[i].from);
        if (share_of(seed) < 0.3) {
            ck_assert_stein(stein_set(of, hand[i].name, value, err));
        }
    }
}

START_TEST(the_work_of_a_step_is_bounded_and_none_fails)
{
    static const double rate[] = {48000.0, 12000.0};
    stein_sim *of = make_sim(&stein_model_stein1788, STEIN_RK4, 1.0 / rate[_i]);
    unsigned long long seed = 1788;
    double finger = 0.0;
    int evaluations = 0, most = 0;
    stein_on_force(of, count, &evaluations);
    ck_assert_stein(stein_drive(of, "finger", push_key, &finger, err));
    for (int k = 0; k < GESTURES; k++) {
        finger = fmax(0.0, 20.0 * share_of(&seed) - 8.0);
        turn(of, &seed);
        if (share_of(&seed) < 0.5) {
            stein_load_lift(of);
        } else {
            ck_assert_stein(stein_load_place(of, err));
        }
        int steps = (int)(rate[_i] * (0.01 + 0.1 * share_of(&seed)));
        for (int i = 0; i < steps; i++) {
            evaluations = 0;
            ck_assert_stein(stein_step(of, err));
            most = evaluations > most ? evaluations : most;
        }
    }
    printf("%g Hz: %d evaluations in the longest step\n", rate[_i], most);
    ck_assert_int_gt(most, 9); // there were events
    ck_assert_int_le(most, MOST_EVALUATIONS);
    stein_sim_destroy(of);
}
END_TEST

Suite *realtime_suite(void)
{
    Suite *s = suite_create("realtime");
    TCase *t = tcase_create("realtime");
    tcase_set_timeout(t, 120);
#if defined __linux__
    tcase_add_test(t, a_million_steps_make_no_system_call_and_leave_errno_alone);
    tcase_add_test(t, the_sandbox_kills_for_one_system_call);
#endif
    tcase_add_test(t, failures_leave_errno_alone_too);
    tcase_add_loop_test(t, the_work_of_a_step_is_bounded_and_none_fails, 0, 2);
    tcase_add_test(t, the_last_published_set_is_taken_and_other_values_are_untouched);
    tcase_add_test(t, a_pace_is_kept_in_simulated_time_and_the_end_is_met_exactly);
    tcase_add_test(t, a_pace_keeps_energy_out_of_a_closed_contact);
    tcase_add_test(t, mistakes_are_reported_and_change_nothing);
    tcase_add_test(t, sets_of_another_thread_come_whole_and_in_order);
    suite_add_tcase(s, t);
    return s;
}
