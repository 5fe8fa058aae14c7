/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_events.c - times of events as data: a ball without a recorded height.
 *
 * The times come from flights in closed form, with linear drag b where there is some,
 *
 *      z(t) = (v0 + g/k)(1 - exp(-k t))/k - g t/k,    k = b/m,
 *
 * and from the contact alone, m x'' = m g - c x (1 + D x') - b x', by Runge-Kutta in steps of
 * 0.1 us. Nothing of the core is in them.
 */
#include "fit_support.h"
#include "fitting.h"
#include "stein/diagnose.h"
#include "suites.h"

static const char *const ball = "models/bouncing_ball.yaml";
enum { DROPS = 5, BOUNCES = 6, MOST = 60 };
enum { UNKNOWN_HEIGHT, KNOWN_HEIGHT, UNKNOWN_CLOCK }; /* what is stated of a drop */

typedef struct world {
    double g, D, b; /* [m/s^2], [s/m], [N s/m] */
    double height;  /* of the first drop [m]; 0: 0.15, the following ones 0.1 more each */
    double noise;   /* of a time [s] */
    double late;    /* the clock is ahead by this [s] */
    int end;        /* times at which the ball leaves the floor */
} world;

static const world truth = {.g = 9.81, .D = 0.14};
static const double mass = 0.0461, stiffness = 52e3;

/* seconds until a ball at h with speed v upwards is at 0, and its speed downwards there */
static double fly(const world *w, double h, double v, double *hit)
{
    double k = w->b / mass, t = (v + sqrt(v * v + 2.0 * w->g * h)) / w->g;
    *hit = sqrt(v * v + 2.0 * w->g * h);
    for (int i = 0; k > 0.0 && i < 50; i++) {
        double e = exp(-k * t), z = h + (v + w->g / k) * (1.0 - e) / k - w->g * t / k;
        *hit = -((v + w->g / k) * e - w->g / k);
        t += z / *hit;
    }
    return t;
}

static void slope(const world *w, const double s[2], double d[2])
{
    d[0] = s[1];
    d[1] = w->g - stiffness * s[0] * (1.0 + w->D * s[1]) / mass - w->b * s[1] / mass;
}

/* seconds on the floor. @param v  speed downwards, in; upwards, out */
static double press(const world *w, double *v)
{
    static const double h = 1e-7;
    double s[2] = {0.0, *v}, t = 0.0;
    for (;;) {
        double k[4][2], at[2], next[2];
        slope(w, s, k[0]);
        for (int i = 1; i < 4; i++) {
            for (int j = 0; j < 2; j++) {
                at[j] = s[j] + (i < 3 ? 0.5 : 1.0) * h * k[i - 1][j];
            }
            slope(w, at, k[i]);
        }
        for (int j = 0; j < 2; j++) {
            next[j] = s[j] + h / 6.0 * (k[0][j] + 2.0 * k[1][j] + 2.0 * k[2][j] + k[3][j]);
        }
        if (next[0] <= 0.0) {
            double share = s[0] / (s[0] - next[0]);
            *v = -(s[1] + share * (next[1] - s[1]));
            return t + share * h;
        }
        s[0] = next[0];
        s[1] = next[1];
        t += h;
    }
}

/* the first n times */
static void bounce(const world *w, double height, int n, double *time)
{
    double v, t = fly(w, height, 0.0, &v);
    for (int i = 0; i < n; i++) {
        double on = press(w, &v);
        time[i] = w->end ? t + on : t;
        t += on + fly(w, 0.0, v, &v);
    }
}

static double height_of(const world *w, int i)
{
    return (w->height > 0.0 ? w->height : 0.15) + 0.1 * i;
}

/* a record of drop i, in the folder of the test. @return its path */
static const char *hear_ball(const char *name, const world *w, int i, int n, int head)
{
    double time[MOST];
    unsigned long long seed = 31u * (unsigned)i + 7u;
    const char *path = in_folder(name);
    FILE *f = fopen(path, "w");
    ck_assert_ptr_nonnull(f);
    bounce(w, height_of(w, i), n, time);
    if (head >= KNOWN_HEIGHT) {
        fprintf(f, "# known drop.height: %g m\n", height_of(w, i));
    }
    if (head == UNKNOWN_CLOCK) {
        fprintf(f, "# trigger: unsynchronised\n");
    }
    if (w->noise > 0.0) {
        fprintf(f, "# noise floor_force: %g s\n", w->noise);
    }
    fprintf(f, "# events floor_force: %s\nevent,floor_force [ms]\n", w->end ? "end" : "begin");
    for (int k = 0; k < n; k++) {
        fprintf(f, "%d,%.5f\n", k + 1, 1e3 * (time[k] - w->late + w->noise * gauss(&seed)));
    }
    ck_assert_int_eq(fclose(f), 0);
    return path;
}

/* records of all drops. @param path  [n + 1] */
static void hear_all(const world *w, int n, int head, char (*room)[200], const char **path)
{
    for (int i = 0; i < n; i++) {
        char name[40];
        snprintf(name, sizeof name, "drop%d.csv", i);
        snprintf(room[i], sizeof room[i], "%s", hear_ball(name, w, i, BOUNCES, head));
        path[i] = room[i];
    }
    path[n] = NULL;
}

static void ck_assert_inside(const lab_fit *fit, const char *name, double value)
{
    const lab_fit_value *v = value_of(fit, name);
    printf("  %s: %.6g (%.6g .. %.6g), true %.6g\n", name, v->value, v->lo, v->hi, value);
    ck_assert(v->lo <= value && value <= v->hi && v->sd < 0.05 * fabs(value));
}

/* ---- predictions ---- */

static void predict(const fit__problem *p, int stroke, double *y)
{
    fit__bench b;
    ck_assert_stein(fit__bench_make(&b, p, err));
    ck_assert_stein(fit__simulate(p, &b, stroke, b.x, y, err));
    fit__bench_free(&b);
}

START_TEST(predicted_times_are_those_of_the_closed_form)
{
    for (int end = 0; end < 2; end++) {
        world w = truth;
        fitted f;
        fit__problem p;
        lab_fit_def def = lab_fit_def_default();
        double y[2 * BOUNCES], time[BOUNCES];
        w.end = end;
        const char *path[] = {hear_ball("drop.csv", &w, 1, BOUNCES, KNOWN_HEIGHT), NULL};
        open_fit(&f, ball, NULL, path);
        ck_assert_stein(fit__problem_make_open(&p, f.model, f.data, &def, err));
        ck_assert_int_eq(p.stroke[0].nsampled, 0);
        ck_assert_int_eq(p.samples, BOUNCES);
        predict(&p, 0, y);
        bounce(&w, height_of(&w, 1), BOUNCES, time);
        for (int i = 0; i < BOUNCES; i++) {
            ck_assert_close(y[i], time[i], 0.0, 2e-8);
        }
        fit__problem_free(&p);
        drop(&f);
    }
}
END_TEST

/* A recorded force that presses the ball down all the time is gravity; steps end at its samples, on
 * to the end of the record. */
START_TEST(times_under_a_recorded_force_are_those_of_the_closed_form)
{
    static const char pushed[] = "mechanism: pushed\n"
                                 "bodies:\n"
                                 "  ball:\n"
                                 "    joint: T z\n"
                                 "    mass: 46.1 g\n"
                                 "    initial: {position: 321.3 mm}\n"
                                 "    points: {top: [0, 0, 0]}\n"
                                 "contacts:\n"
                                 "  floor:\n"
                                 "    between:\n"
                                 "      - {circle: {on: ball, at: [0, 0, 0], radius: 21.3 mm}}\n"
                                 "      - {line: {on: frame, at: [0, 0, 0], facing: 90 deg}}\n"
                                 "    normal: {c: 52 kN/m, D: 0.14 s/m}\n"
                                 "inputs: {push: {force: ball.top, direction: [0, 0, -1]}}\n"
                                 "outputs: {floor_gap: {contact: floor, read: gap}}\n"
                                 "simulation: {dt: 10 us, until: 2 s, integrator: rk4}\n";
    world w = {.g = 9.81 + 0.05 / 0.0461, .D = 0.14};
    double time[BOUNCES], y[BOUNCES + 4];
    char model[200], text[600];
    fitted f;
    fit__problem p;
    lab_fit_def def = lab_fit_def_default();
    bounce(&w, 0.3, BOUNCES, time);
    size_t n = (size_t)snprintf(text, sizeof text,
                                "# set ball.initial.position: 321.3 mm\n"
                                "# events floor_gap: begin\ntime [s],push [N],floor_gap [s]\n");
    for (int i = 0; i < BOUNCES; i++) {
        n += (size_t)snprintf(text + n, sizeof text - n, "%g,0.05,%.9f\n", 0.36 * i, time[i]);
    }
    snprintf(model, sizeof model, "%s", write_file("pushed.yaml", pushed));
    const char *path[] = {write_file("pushed.csv", text), NULL};
    open_fit(&f, model, NULL, path);
    ck_assert_stein(fit__problem_make_open(&p, f.model, f.data, &def, err));
    predict(&p, 0, y);
    for (int i = 0; i < BOUNCES; i++) {
        ck_assert_close(y[i], time[i], 0.0, 2e-8);
    }
    fit__problem_free(&p);
    drop(&f);
}
END_TEST

typedef struct told {
    int n, contact;
    double begin[MOST];
} told;

static void note_begin(void *ctx, stein_sim *sim, const stein_event *e)
{
    told *t = ctx;
    (void)sim;
    if (e->kind == STEIN_EVENT_PHASE && e->index == t->contact && e->phase != 0 && t->n < MOST) {
        t->begin[t->n++] = e->time;
    }
}

/* the beak under the roof of the pawl's notch: the phase leaves 0 */
START_TEST(times_of_a_notch_are_those_of_its_phases)
{
    const stein_model *m = &stein_model_stein1788;
    int phase = 0;
    while (phase < m->nchannel && m->channels[phase].read != STEIN_READ_NOTCH_PHASE) {
        phase++;
    }
    ck_assert_int_lt(phase, m->nchannel);
    stein_sim_def def = stein_sim_def_default(m);
    stein_sim *sim = NULL;
    told t = {.contact = m->channels[phase].index};
    def.integrator = STEIN_DP5;
    ck_assert_stein(stein_sim_create(&sim, m, &def, err));
    int on = stein_notch_phase(sim, t.contact) > 0;
    stein_on_event(sim, note_begin, &t);
    ck_assert_stein(stein_run(sim, 0.1, err));
    stein_sim_destroy(sim);
    char text[400];
    double first = 0.0;
    for (int i = 0; i < t.n && !(first > 0.0); i++) {
        first = !on || i > 0 ? t.begin[i] : 0.0;
    }
    ck_assert(first > 0.0);
    snprintf(text, sizeof text, "# events %s: begin\n%s [s]\n%.9f\n", m->channels[phase].name,
             m->channels[phase].name, first + 1e-3);
    const char *path[] = {write_file("notch.csv", text), NULL};
    fitted f;
    fit__problem p;
    lab_fit_def how = lab_fit_def_default();
    double y[8];
    open_fit(&f, "models/stein1788.yaml", NULL, path);
    ck_assert_stein(fit__problem_make_open(&p, f.model, f.data, &how, err));
    predict(&p, 0, y);
    ck_assert_close(y[0], first, 0.0, 1e-6);
    fit__problem_free(&p);
    drop(&f);
}
END_TEST

START_TEST(lanes_and_single_simulations_have_the_same_times)
{
    char room[DROPS][200];
    const char *path[DROPS + 1];
    double *r[2] = {NULL, NULL};
    size_t n = 0;
    fitted f;
    hear_all(&truth, DROPS, KNOWN_HEIGHT, room, path);
    const char *const set[] = {"floor.normal.h=0.95", NULL};
    open_fit(&f, ball, set, path);
    for (int k = 0; k < 2; k++) {
        lab_fit_def def = lab_fit_def_default();
        fit__problem p;
        int failed = 0;
        def.lanes = k;
        ck_assert_stein(fit__problem_make_open(&p, f.model, f.data, &def, err));
        double *x = calloc((size_t)p.nu + 1, sizeof *x);
        n = fit__offset(&p, p.nstroke);
        r[k] = calloc(n + 1, sizeof **r);
        ck_assert_stein(fit__residuals(&p, x, r[k], &failed, err));
        ck_assert_int_eq(failed, 0);
        int lacking[DROPS];
        ck_assert_stein(fit__lacking(&p, x, lacking, err));
        ck_assert_int_gt(lacking[0], 0); // their times are the same, too
        free(x);
        fit__problem_free(&p);
    }
    ck_assert_int_eq(memcmp(r[0], r[1], sizeof **r * n), 0);
    free(r[0]);
    free(r[1]);
    drop(&f);
}
END_TEST

/* ---- events that the simulation lacks ---- */

/* a floor that dissipates a share of the energy in every bounce, at most nearly all of it */
START_TEST(events_that_are_missing_come_and_go_without_a_jump)
{
    enum { STEPS = 400 };
    world w = truth;
    fitted f;
    fit__problem p;
    fit__bench b;
    lab_fit_def def = lab_fit_def_default();
    double y[MOST], before[MOST], worst = 0.0, gap;
    int lacked = 0, least = 0, most = 0;
    static const char *const names[] = {"floor.normal.h", NULL};
    static const char *const set[] = {"floor.normal.h=0.1", NULL};
    const char *path[] = {hear_ball("drop.csv", &w, 1, BOUNCES, KNOWN_HEIGHT), NULL};
    open_fit(&f, ball, set, path);
    def.free = names;
    def.nfree = 1;
    ck_assert_stein(fit__problem_make_open(&p, f.model, f.data, &def, err));
    ck_assert_stein(fit__bench_make(&b, &p, err));
    double *x = calloc((size_t)p.nu + 1, sizeof *x);
    gap = p.stroke[0].event[0].shortest;
    for (int k = 0; k <= STEPS; k++) {
        x[0] = (log(0.02) + k * log(0.95 / 0.02) / STEPS - p.unknown[0].start) / p.unknown[0].sd;
        ck_assert_stein(fit__simulate(&p, &b, 0, x, y, err));
        ck_assert_stein(fit__lacking(&p, x, &lacked, err));
        most = lacked > most ? lacked : most;
        least = k == 0 || lacked < least ? lacked : least;
        for (int i = 0; i < BOUNCES; i++) {
            ck_assert(isfinite(y[i]));
            worst = k > 0 ? fmax(worst, fabs(y[i] - before[i])) : worst;
            before[i] = y[i];
        }
    }
    printf("  %d to %d of %d lacking, a step of 1 %% in h moves a time by at most %.3g ms\n", least,
           most, BOUNCES, 1e3 * worst);
    ck_assert_int_eq(least, 0);
    ck_assert_int_ge(most, 4);
    ck_assert(worst < 0.2 * gap);
    free(x);
    fit__bench_free(&b);
    fit__problem_free(&p);
    drop(&f);
}
END_TEST

/* forty bounces were measured, and the ball of the model comes to rest much earlier */
START_TEST(a_ball_at_rest_is_not_simulated_for_ever)
{
    world w = {.g = 9.81, .D = 0.01, .height = 0.3};
    fitted f;
    fit__problem p;
    fit__bench b;
    lab_fit_def def = lab_fit_def_default();
    double y[MOST];
    int lacked = 0;
    const char *path[] = {hear_ball("drop.csv", &w, 0, 40, KNOWN_HEIGHT), NULL};
    const char *const set[] = {"floor.normal.h=0.5", NULL};
    open_fit(&f, ball, set, path);
    ck_assert_stein(fit__problem_make_open(&p, f.model, f.data, &def, err));
    ck_assert_stein(fit__bench_make(&b, &p, err));
    ck_assert_stein(fit__simulate(&p, &b, 0, b.x, y, err));
    ck_assert_stein(fit__lacking(&p, b.x, &lacked, err));
    double length = f.data->stroke[0]->time[f.data->stroke[0]->nrow - 1];
    printf(
        "  %d of 40 are lacking; the simulation of %.3g s took %lld trials and ended at %.3g s\n",
        lacked, length, stein_trials(b.sim), stein_time(b.sim));
    ck_assert_int_gt(lacked, 20);
    for (int i = 40 - lacked; i < 40; i++) { // where it came to rest
        ck_assert_close(y[i], y[40 - lacked - 1], 0.0, 0.01);
    }
    ck_assert(stein_trials(b.sim) < 200000);
    fit__bench_free(&b);
    fit__problem_free(&p);
    drop(&f);
}
END_TEST

/* ---- fits ---- */

static void fit_ball(fitted *f, const char *const *set, const char *const *path,
                     const char *const *names)
{
    open_fit(f, ball, set, path);
    lab_fit_def def = free_these(names);
    ck_assert_stein(lab_fit_run(&f->fit, f->model, f->data, &def, err));
    ck_assert_status(f->fit, LAB_FIT_CONVERGED);
}

START_TEST(restitution_and_gravity_are_found_from_times_alone)
{
    static const char *const names[] = {"floor.normal.D", "gravity.z", NULL};
    static const char *const from[] = {"floor.normal.D=0.5", NULL}; // three bounces are missing
    world w = {.g = 9.79, .D = 0.163, .noise = 2e-4};
    char room[DROPS][200];
    const char *path[DROPS + 1];
    fitted f;
    hear_all(&w, DROPS, KNOWN_HEIGHT, room, path);
    fit_ball(&f, from, path, names);
    ck_assert_inside(f.fit, "gravity.z", -w.g);
    for (int s = 0; s < f.fit->nstroke; s++) {
        ck_assert_int_eq(f.fit->stroke[s].lacking, 0);
        ck_assert_str_eq(f.fit->residual[s].channel, "floor_force");
        ck_assert_str_eq(f.fit->residual[s].unit, "s");
        ck_assert(f.fit->residual[s].rms < 2.0 * w.noise);
    }
    // a floor is not twice the same, and the file's 0.5 weighs as what it is: the prior is wide
    ck_assert_close(value_of(f.fit, "floor.normal.D")->value, w.D, 0.06, 0.0);
    drop(&f);
}
END_TEST

START_TEST(drop_height_and_restitution_are_found_from_times_alone)
{
    static const char *const names[] = {"floor.normal.D", "drop.height", NULL};
    world w = {.g = 9.81, .D = 0.15, .noise = 2e-4, .height = 0.31};
    char first[200];
    fitted f;
    snprintf(first, sizeof first, "%s", hear_ball("a.csv", &w, 0, BOUNCES, UNKNOWN_HEIGHT));
    const char *path[] = {first, NULL};
    fit_ball(&f, NULL, path, names);
    ck_assert_inside(f.fit, "drop.height", w.height);
    ck_assert_inside(f.fit, "floor.normal.D", w.D);
    drop(&f);
}
END_TEST

START_TEST(the_clock_of_times_is_found)
{
    static const char *const names[] = {"floor.normal.D", NULL};
    world w = {.g = 9.81, .D = 0.14, .noise = 1e-4, .late = 1.7e-3};
    char room[DROPS][200];
    const char *path[DROPS + 1];
    fitted f;
    hear_all(&w, DROPS, UNKNOWN_CLOCK, room, path);
    fit_ball(&f, NULL, path, names);
    for (int s = 0; s < DROPS; s++) {
        const lab_fit_value *v = f.fit->stroke[s].value;
        ck_assert_str_eq(v->name, "trigger");
        ck_assert_close(v->value, w.late, 0.0, 4e-4);
    }
    drop(&f);
}
END_TEST

/* height at 20 /s, and the touch-downs by their sound: what the film does not show */
START_TEST(samples_and_times_stand_side_by_side)
{
    static const char *const names[] = {"floor.normal.D", "gravity.z", NULL};
    world w = {.g = 9.77, .D = 0.15};
    double time[BOUNCES];
    const char *path[] = {in_folder("film.csv"), NULL};
    FILE *f = fopen(path[0], "w");
    unsigned long long seed = 5;
    bounce(&w, 0.4, BOUNCES, time);
    fprintf(f, "# known drop.height: 0.4 m\n# noise height: 2 mm\n# noise floor_force: 0.1 ms\n"
               "# events floor_force: begin\ntime [s],height [m],floor_force [s]\n");
    for (int i = 0; i < 6; i++) { // before the first bounce
        double t = 0.05 * i, z = 0.4213 - 0.5 * w.g * t * t + 2e-3 * gauss(&seed);
        fprintf(f, "%.3f,%.6f,%.7f\n", t, z, time[i] + 1e-4 * gauss(&seed));
    }
    ck_assert_int_eq(fclose(f), 0);
    fitted k;
    fit_ball(&k, NULL, path, names);
    ck_assert_int_eq(k.fit->samples, 12);
    ck_assert_inside(k.fit, "gravity.z", -w.g);
    ck_assert_inside(k.fit, "floor.normal.D", w.D);
    ck_assert_str_eq(k.fit->residual[1].channel, "floor_force");
    drop(&k);
}
END_TEST

/* ---- diagnoses ---- */

static void find_hidden(const world *w, const char *kind, const char *place, double size)
{
    enum { FEW = 3 };
    char room[FEW][200];
    const char *path[FEW + 1];
    lab_model *model = NULL;
    lab_dataset *data = NULL;
    lab_diagnosis *d = NULL;
    lab_options options = cache_here(NULL);
    hear_all(w, FEW, KNOWN_HEIGHT, room, path);
    ck_assert_stein(lab_open(&model, ball, &options, err));
    examine(ball, model, path, FEW, &data, &d);
    printf("  %s\n", d->reason);
    ck_assert_int_eq(d->ncause, 1);
    const lab_suspect *found = NULL;
    for (int i = 0; i < d->ncause + d->nrival; i++) {
        const lab_candidate *c = &d->suspect[i].candidate;
        found = strcmp(c->effect->kind, kind) == 0 && strcmp(c->place, place) == 0 ? &d->suspect[i]
                                                                                   : found;
    }
    ck_assert_msg(found != NULL, "%s at %s is neither a cause nor a rival", kind, place);
    printf("  %s at %s: %.4g (%.4g .. %.4g), true %.4g\n", kind, place, found->number[0].value,
           found->number[0].lo, found->number[0].hi, size);
    ck_assert_close(found->number[0].value, size, 0.12, 0.0);
    lab_diagnosis_destroy(d);
    lab_dataset_close(data);
    lab_close(model);
}

START_TEST(a_hidden_damping_is_named_from_times_of_bounces)
{
    static const world w = {.g = 9.81, .D = 0.14, .b = 0.02, .noise = 2e-4};
    find_hidden(&w, "viscous_friction", "ball", w.b);
}
END_TEST

START_TEST(a_wrong_gravity_is_named_from_times_of_bounces)
{
    static const world w = {.g = 9.0, .D = 0.14, .noise = 2e-4}; // a rail that is not upright
    find_hidden(&w, "preload", "ball", mass * (9.81 - 9.0));
}
END_TEST

Suite *events_suite(void)
{
    Suite *s = suite_create("events");
    TCase *t = tcase_create("times of events");
    tcase_set_timeout(t, 600);
    tcase_add_checked_fixture(t, make_folder, remove_folder);
    tcase_add_test(t, predicted_times_are_those_of_the_closed_form);
    tcase_add_test(t, times_under_a_recorded_force_are_those_of_the_closed_form);
    tcase_add_test(t, times_of_a_notch_are_those_of_its_phases);
    tcase_add_test(t, lanes_and_single_simulations_have_the_same_times);
    tcase_add_test(t, events_that_are_missing_come_and_go_without_a_jump);
    tcase_add_test(t, a_ball_at_rest_is_not_simulated_for_ever);
    tcase_add_test(t, restitution_and_gravity_are_found_from_times_alone);
    tcase_add_test(t, drop_height_and_restitution_are_found_from_times_alone);
    tcase_add_test(t, the_clock_of_times_is_found);
    tcase_add_test(t, samples_and_times_stand_side_by_side);
    tcase_add_test(t, a_hidden_damping_is_named_from_times_of_bounces);
    tcase_add_test(t, a_wrong_gravity_is_named_from_times_of_bounces);
    suite_add_tcase(s, t);
    return s;
}
