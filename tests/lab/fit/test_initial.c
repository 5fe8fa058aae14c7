/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_initial.c - initial states come from the records, and faults that prevent it are named.
 *
 * The records begin in mid-motion; the mechanism's file only states the start of its own run.
 */
#include <math.h>

#include "fit_support.h"
#include "fitting.h"

Suite *initial_suite(void);

static const char rod[] = "models/pendulum.yaml", two[] = "models/double_pendulum.yaml";

/* a problem without free parameters; its strokes' initial states are all that is unknown */
typedef struct posed {
    fitted f;
    fit__problem p;
    fit__bench bench;
    double *x; /* zeros */
} posed;

static void pose(posed *o, const char *model, const char *const *data)
{
    static lab_fit_def def;
    def = lab_fit_def_default();
    def.offset = 0.0;
    open_fit(&o->f, model, NULL, data);
    ck_assert_stein(fit__problem_make_open(&o->p, o->f.model, o->f.data, &def, err));
    ck_assert_stein(fit__bench_make(&o->bench, &o->p, err));
    o->x = calloc((size_t)o->p.nu + 1, sizeof *o->x);
    ck_assert_ptr_nonnull(o->x);
}

static void unpose(posed *o)
{
    fit__bench_free(&o->bench);
    fit__problem_free(&o->p);
    free(o->x);
    drop(&o->f);
}

static const fit__unknown *unknown_of(const posed *o, fit__kind kind, int index)
{
    for (int k = o->p.np; k < o->p.nu; k++) {
        if (o->p.unknown[k].kind == kind && o->p.unknown[k].index == index) {
            return &o->p.unknown[k];
        }
    }
    return NULL;
}

/* state of a model with these values at T */
static void state_at(const char *model, const char *const *set, double T, double *q, double *qd)
{
    lab_options options = cache_here(NULL);
    lab_model *m = NULL;
    stein_sim *sim = NULL;
    options.set = set;
    while (set[options.nset] != NULL) {
        options.nset++;
    }
    ck_assert_stein(lab_open(&m, model, &options, err));
    stein_sim_def def = lab_def(m);
    ck_assert_stein(lab_sim(m, &def, &sim, err));
    ck_assert_stein(stein_run(sim, T, err));
    for (int j = 0; j < lab_equations(m)->nq; j++) {
        q[j] = stein_q(sim)[j];
        qd[j] = stein_qd(sim)[j];
    }
    stein_sim_destroy(sim);
    lab_close(m);
}

/* what the estimate is off by, in the sd that the problem has as the unknown's scale */
static double off_by(const posed *o, fit__kind kind, int joint, double truth)
{
    const fit__unknown *u = unknown_of(o, kind, joint);
    const stein_model *m = lab_equations(o->f.model);
    char name[100];
    snprintf(name, sizeof name, "%s.initial.%s", m->bodies[joint].name,
             kind == FIT__POSITION ? "position" : "speed");
    int i = stein_find_param(m, name);
    double file = i >= 0 ? lab_parameters(o->f.model)[i] : 0.0;
    ck_assert_ptr_nonnull(u);
    return fabs(file + fit__value(u, 0.0) - truth) / u->sd;
}

/* ---- the state ---- */

static const char *const swing_truth[] = {"rod.initial.position=71 deg", NULL};

START_TEST(a_record_that_begins_in_mid_swing_starts_within_its_noise)
{
    static const double noise[] = {1.7e-4, 2.3e-3}, rate[] = {47.0, 230.0, 910.0};
    film m = {.model = rod,
              .truth = swing_truth,
              .channels = "angle",
              .rate = rate[_i % 3],
              .from = 0.37,
              .until = 2.9,
              .noise = noise[_i / 3],
              .seed = 17u + (unsigned)_i};
    const char *data[] = {take("mid.csv", &m), NULL};
    posed o;
    double q, qd;
    pose(&o, rod, data);
    state_at(rod, swing_truth, 0.37, &q, &qd);
    ck_assert_double_lt(off_by(&o, FIT__POSITION, 0, q), 4.0);
    ck_assert_double_lt(off_by(&o, FIT__SPEED, 0, qd), 4.0);
    ck_assert_int_eq(unknown_of(&o, FIT__SPEED, 0)->prior, 0);
    ck_assert(o.p.stroke[0].origin == 0.37);
    ck_assert_double_lt(fit__misfit(&o.p, &o.bench, 0, o.x, o.p.stroke[0].window), 4.0);
    unpose(&o);
}
END_TEST

static const char *const tumble[] = {"upper.initial.position=-80 deg", "upper.initial.speed=3.1",
                                     "lower.initial.position=37 deg", "lower.initial.speed=-2.3",
                                     NULL};

static film tumbling(const char *channels, unsigned seed)
{
    return (film){.model = two,
                  .truth = tumble,
                  .channels = channels,
                  .rate = 240.0,
                  .from = 0.21,
                  .until = 1.2,
                  .noise = 2.7e-4,
                  .seed = seed};
}

START_TEST(the_state_of_an_arm_comes_from_the_coordinates_of_its_tip)
{
    film m = tumbling("tip_x tip_z", 5u + (unsigned)_i);
    const char *data[] = {take("tip.csv", &m), NULL};
    posed o;
    double q[2], qd[2];
    pose(&o, two, data);
    state_at(two, tumble, 0.21, q, qd);
    for (int j = 0; j < 2; j++) {
        ck_assert_double_lt(off_by(&o, FIT__POSITION, j, q[j]), 4.0);
        ck_assert_double_lt(off_by(&o, FIT__SPEED, j, qd[j]), 4.0);
    }
    ck_assert_double_lt(fit__misfit(&o.p, &o.bench, 0, o.x, 0.2), 25.0);
    unpose(&o);
}
END_TEST

START_TEST(a_joint_that_no_channel_shows_begins_near_the_files_state_with_a_wide_prior)
{
    film m = tumbling("upper_angle", 3);
    const char *data[] = {take("half.csv", &m), NULL};
    posed o;
    double q[2], qd[2];
    pose(&o, two, data);
    state_at(two, tumble, 0.21, q, qd);
    ck_assert_double_lt(off_by(&o, FIT__POSITION, 0, q[0]), 4.0);
    ck_assert_double_lt(off_by(&o, FIT__SPEED, 0, qd[0]), 4.0);
    const fit__unknown *u = unknown_of(&o, FIT__POSITION, 1), *v = unknown_of(&o, FIT__SPEED, 1);
    ck_assert_int_eq(u->prior && v->prior, 1);
    ck_assert(u->sd >= 0.5 && v->sd >= 5.0);
    ck_assert(fabs(u->start) <= u->sd && fabs(v->start) <= v->sd);
    unpose(&o);
}
END_TEST

START_TEST(a_joint_that_has_no_channel_is_found_through_the_others_point)
{
    film m = tumbling("upper_angle tip_x", 4);
    const char *data[] = {take("mixed.csv", &m), NULL};
    posed o;
    double q[2], qd[2];
    pose(&o, two, data);
    state_at(two, tumble, 0.21, q, qd);
    ck_assert_double_lt(off_by(&o, FIT__POSITION, 1, q[1]), 4.0);
    ck_assert_double_lt(off_by(&o, FIT__SPEED, 1, qd[1]), 4.0);
    unpose(&o);
}
END_TEST

START_TEST(a_speed_may_be_measured_itself)
{
    film m = {.model = rod,
              .truth = swing_truth,
              .channels = "rate",
              .rate = 200.0,
              .from = 0.37,
              .until = 1.9,
              .noise = 3.1e-3,
              .seed = 8};
    const char *data[] = {take("gyro.csv", &m), NULL};
    posed o;
    double q, qd;
    pose(&o, rod, data);
    state_at(rod, swing_truth, 0.37, &q, &qd);
    ck_assert_double_lt(off_by(&o, FIT__SPEED, 0, qd), 7.0); // its position is not known
    ck_assert_int_eq(unknown_of(&o, FIT__POSITION, 0)->prior, 1);
    unpose(&o);
}
END_TEST

START_TEST(an_angle_that_jumps_by_whole_turns_is_followed_across)
{
    static const char turning[] = "time [s],angle [rad]\n";
    const char *path = in_folder("turning.csv");
    FILE *f = fopen(path, "w");
    ck_assert_ptr_nonnull(f);
    fprintf(f, "# noise angle: 1 mrad\n%s", turning);
    unsigned long long seed = 7;
    for (int i = 0; i < 200; i++) {
        double a = 3.02 + 6.3 * 0.005 * i + 1e-3 * gauss(&seed);
        fprintf(f, "%.17g,%.17g\n", 0.005 * i, remainder(a, 2.0 * 3.14159265358979323846));
    }
    ck_assert_int_eq(fclose(f), 0);
    const char *data[] = {path, NULL};
    posed o;
    pose(&o, rod, data);
    ck_assert_double_lt(off_by(&o, FIT__POSITION, 0, 3.02), 4.0);
    ck_assert_double_lt(off_by(&o, FIT__SPEED, 0, 6.3), 6.0);
    unpose(&o);
}
END_TEST

/* both as measured by a tracker, against the frame and within +-180 deg; the lower joint counts the
 * other way */
static const char bodies[] =
    "mechanism: bodies\n"
    "bodies:\n"
    "  upper: {joint: R -y, mass: 147 g, centre: [0, 0, -155 mm], inertia: {yy: 1.17e-3},\n"
    "          points: {end: [0, 0, -310 mm]}}\n"
    "  lower: {parent: upper, at: upper.end, joint: R y, mass: 110.25 g,\n"
    "          centre: [0, 0, -116.25 mm], inertia: {yy: 4.97e-4}}\n"
    "outputs:\n"
    "  upper_seen: {body: upper, read: angle}\n"
    "  lower_seen: {body: lower, read: angle, sign: -1}\n"
    "simulation: {dt: 0.5 ms, until: 2 s, integrator: dp5}\n";

START_TEST(the_state_of_an_arm_comes_from_the_angles_of_its_bodies)
{
    static const double q[2] = {2.7, 0.9}, qd[2] = {11.0, -9.0}, whole = 6.283185307179586;
    char model[300];
    snprintf(model, sizeof model, "%s", write_file("bodies.yaml", bodies));
    lab_options options = cache_here(NULL);
    lab_model *m = NULL;
    stein_sim *sim = NULL;
    ck_assert_stein(lab_open(&m, model, &options, err));
    ck_assert_stein(lab_sim(m, NULL, &sim, err));
    ck_assert_stein(stein_set_state(sim, 0.0, q, qd, err));
    const char *path = in_folder("seen.csv"), *data[] = {path, NULL};
    FILE *f = fopen(path, "w");
    ck_assert_ptr_nonnull(f);
    fprintf(f, "# noise upper_seen: 0.5 mrad\n# noise lower_seen: 0.5 mrad\n"
               "time [s],upper_seen [rad],lower_seen [rad]\n");
    unsigned long long seed = 7;
    double travel = 0.0;
    for (int i = 0; i < 300; i++) {
        ck_assert_stein(stein_run(sim, 0.004 * i, err));
        double a = stein_q(sim)[0], b = stein_q(sim)[0] - stein_q(sim)[1];
        travel = fmax(travel, fabs(b - (q[0] - q[1])));
        fprintf(f, "%.17g,%.17g,%.17g\n", 0.004 * i, remainder(a + 5e-4 * gauss(&seed), whole),
                remainder(-b + 5e-4 * gauss(&seed), whole));
    }
    ck_assert_int_eq(fclose(f), 0);
    ck_assert(travel > 1.5 * whole); // it wraps
    stein_sim_destroy(sim);
    lab_close(m);
    posed o;
    pose(&o, model, data);
    for (int j = 0; j < 2; j++) {
        ck_assert_double_lt(off_by(&o, FIT__POSITION, j, q[j]), 4.0);
        ck_assert_double_lt(off_by(&o, FIT__SPEED, j, qd[j]), 4.0);
        ck_assert_int_eq(unknown_of(&o, FIT__POSITION, j)->prior, 0);
    }
    ck_assert_double_lt(fit__misfit(&o.p, &o.bench, 0, o.x, 0.2), 25.0);
    unpose(&o);
}
END_TEST

START_TEST(stated_settings_of_a_stroke_are_not_estimated)
{
    film m = {.model = rod,
              .told = swing_truth,
              .channels = "angle",
              .rate = 200.0,
              .from = 0.1,
              .until = 1.9,
              .noise = 1e-3,
              .seed = 9};
    const char *data[] = {take("told.csv", &m), NULL};
    posed o;
    pose(&o, rod, data);
    ck_assert_ptr_null(unknown_of(&o, FIT__POSITION, 0));
    ck_assert_ptr_null(unknown_of(&o, FIT__SPEED, 0));
    ck_assert(o.p.stroke[0].origin == 0.0); // the state is the state at the trigger
    ck_assert_double_lt(fit__misfit(&o.p, &o.bench, 0, o.x, 1.8), 1.4);
    unpose(&o);
}
END_TEST

START_TEST(a_mechanism_that_is_held_until_the_trigger_starts_there)
{
    film m = {.model = rod,
              .truth = swing_truth,
              .channels = "angle",
              .rate = 200.0,
              .from = -0.5,
              .until = 1.9,
              .noise = 1e-3,
              .seed = 10};
    const char *data[] = {take("held.csv", &m), NULL};
    posed o;
    pose(&o, rod, data);
    ck_assert(o.p.stroke[0].origin == 0.0);
    ck_assert_double_lt(off_by(&o, FIT__POSITION, 0, 71.0 * 3.14159265358979323846 / 180.0), 4.0);
    ck_assert_double_lt(off_by(&o, FIT__SPEED, 0, 0.0), 4.0);
    unpose(&o);
}
END_TEST

START_TEST(a_mechanism_that_settles_is_left_as_it_is)
{
    static const char action[] = "models/stein1788.yaml";
    film m = {.model = action,
              .channels = "string_distance",
              .rate = 2000.0,
              .until = 0.05,
              .noise = 1e-5,
              .seed = 2};
    const char *data[] = {take("action.csv", &m), NULL};
    posed o;
    pose(&o, action, data);
    for (int k = o.p.np; k < o.p.nu; k++) {
        fit__kind kind = o.p.unknown[k].kind;
        ck_assert(kind != FIT__POSITION && kind != FIT__SPEED);
    }
    unpose(&o);
}
END_TEST

/* the arm with a hinge in its lower rod, that no channel shows */
static const char hinged[] =
    "mechanism: hinged\n"
    "bodies:\n"
    "  upper: {joint: R -y, mass: 147 g, centre: [0, 0, -155 mm], inertia: {yy: 1.17e-3},\n"
    "          points: {end: [0, 0, -310 mm]}}\n"
    "  lower: {parent: upper, at: upper.end, joint: R -y, mass: 60 g, centre: [0, 0, -60 mm],\n"
    "          inertia: {yy: 1e-4}, points: {hinge: [0, 0, -116 mm]}}\n"
    "  outer: {parent: lower, at: lower.hinge, joint: R -y, mass: 50.25 g,\n"
    "          centre: [0, 0, -60 mm], inertia: {yy: 1e-4}, spring: {k: 8.1 N m/rad}}\n"
    "outputs:\n"
    "  upper_angle: {joint: upper, read: position}\n"
    "  lower_angle: {joint: lower, read: position}\n"
    "simulation: {dt: 0.2 ms, until: 2 s, integrator: dp5}\n";

START_TEST(a_part_with_a_joint_of_its_own_begins_at_the_same_record)
{
    film m = tumbling("upper_angle lower_angle", 6);
    char model[300];
    snprintf(model, sizeof model, "%s", write_file("hinged.yaml", hinged));
    const char *data[] = {take("base.csv", &m), NULL};
    posed o;
    double q[2], qd[2];
    pose(&o, model, data);
    state_at(two, tumble, 0.21, q, qd);
    for (int j = 0; j < 2; j++) {
        ck_assert_double_lt(off_by(&o, FIT__POSITION, j, q[j]), 4.0);
        ck_assert_double_lt(off_by(&o, FIT__SPEED, j, qd[j]), 4.0);
    }
    ck_assert_int_eq(unknown_of(&o, FIT__POSITION, 2)->prior, 1);
    ck_assert(isfinite(fit__misfit(&o.p, &o.bench, 0, o.x, 0.2)));
    unpose(&o);
}
END_TEST

/* ---- set-ups that are wrong ---- */

/* the arm as a separate file, in which tests change a word */
static const char arm[] =
    "mechanism: arm\n"
    "gravity: [0, 0, -9.81 m/s^2]\n"
    "bodies:\n"
    "  upper: {joint: R -y, mass: 147 g, centre: [0, 0, -155 mm], inertia: {yy: 1.17e-3},\n"
    "          points: {end: [0, 0, -310 mm]}}\n"
    "  lower: {parent: upper, at: upper.end, joint: R -y, mass: 110.25 g,\n"
    "          centre: [0, 0, -116.25 mm], inertia: {yy: 4.97e-4}}\n"
    "outputs:\n"
    "  upper_angle: {joint: upper, read: position}\n"
    "  lower_angle: {joint: lower, read: position}\n"
    "simulation: {dt: 0.5 ms, until: 2 s, integrator: dp5}\n";

typedef struct slip {
    const char *was, *is;    /* in the mechanism's file */
    double a[2][2], zero[2]; /* recorded angles = a (true ones) + zero */
    const char *said;        /* NULL: nothing */
    double slow;             /* recorded times are so much longer; 0: unchanged */
} slip;

#define AS_IS        \
    {                \
        {1.0, 0.0},  \
        {            \
            0.0, 1.0 \
        }            \
    }
static const slip slips[] = {
    {"arm\n", "arm\n", AS_IS, {0.0, 0.0}, NULL, 0.0},
    {"mass: 147 g", "mass: 162 g", AS_IS, {0.0, 0.0}, NULL, 0.0},
    {"upper.end, joint: R -y",
     "upper.end, joint: R y",
     AS_IS,
     {0.0, 0.0},
     "joint: R -y would fit ",
     0.0},
    {"0, 0, -9.81",
     "0, -9.81, 0",
     AS_IS,
     {0.0, 0.0},
     "gravity: [0, 0, -9.81] m/s^2 would fit ",
     0.0},
    {"arm\n",
     "arm\n",
     {{1.0, 0.0}, {0.0, -1.0}},
     {0.0, 0.0},
     "lower_angle runs against the sense of joint lower; joint: R y would fit ",
     0.0},
    {"arm\n",
     "arm\n",
     {{0.0, 1.0}, {1.0, 0.0}},
     {0.0, 0.0},
     "upper_angle and lower_angle are exchanged; ",
     0.0},
    {"arm\n",
     "arm\n",
     {{1.0, 0.0}, {1.0, 1.0}},
     {0.0, 0.0},
     "lower_angle is the angle of its body against the frame, not of its joint; ",
     0.0},
    {"{joint: lower, read: position}",
     "{body: lower, read: angle}",
     {{1.0, 0.0}, {1.0, 1.0}},
     {0.0, 0.0},
     NULL,
     0.0},
    {"{joint: lower, read: position}",
     "{body: lower, read: angle}",
     AS_IS,
     {0.0, 0.0},
     "lower_angle is the angle of its joint, not of its body against the frame; upper_angle taken "
     "in "
     "would fit ",
     0.0},
    {"{joint: upper, read: position}",
     "{body: upper, read: angle, sign: -1}",
     {{-1.0, 0.0}, {1.0, 1.0}},
     {0.0, 0.0},
     "lower_angle is the angle of its body against the frame, not of its joint; upper_angle taken "
     "in "
     "would fit ",
     0.0},
    {"arm\n",
     "arm\n",
     AS_IS,
     {3.14159265358979, 0.0},
     "upper_angle counts from elsewhere; with 180 deg added",
     0.0},
    {"arm\n", "arm\n", AS_IS, {2.3, 0.0}, "upper_angle swings about 2.", 0.0},
    {"arm\n",
     "arm\n",
     {{1.0, 0.0}, {0.0, 57.2957795}},
     {0.0, 0.0},
     "lower_angle is in another unit; divided by 57.3 ",
     0.0},
    {"arm\n", "arm\n", AS_IS, {0.0, 0.0}, "times as slowly as the model", 9.0},
    {"arm\n", "arm\n", AS_IS, {0.0, 0.0}, "times as slowly as the model", 3.0},
};

static const char *record_of(const slip *w, int which)
{
    static char kept[2][300];
    static const char *const other[] = {"upper.initial.position=63 deg", "upper.initial.speed=-1.7",
                                        "lower.initial.position=-41 deg", "lower.initial.speed=2.9",
                                        NULL};
    lab_options options = cache_here(NULL);
    lab_model *model = NULL;
    stein_sim *sim = NULL;
    options.set = which ? other : tumble;
    options.nset = 4;
    ck_assert_stein(lab_open(&model, two, &options, err));
    stein_sim_def def = lab_def(model);
    ck_assert_stein(lab_sim(model, &def, &sim, err));
    snprintf(kept[which], sizeof kept[which], "%s", in_folder(which ? "b.csv" : "a.csv"));
    FILE *f = fopen(kept[which], "w");
    ck_assert_ptr_nonnull(f);
    fprintf(f, "time [s],upper_angle [rad],lower_angle [rad]\n");
    unsigned long long seed = 31u + (unsigned)which;
    for (int i = 0; i < 240; i++) {
        ck_assert_stein(stein_run(sim, 0.005 * i, err));
        const double *q = stein_q(sim);
        fprintf(f, "%.17g", 0.005 * i * (w->slow > 0.0 ? w->slow : 1.0));
        for (int c = 0; c < 2; c++) {
            fprintf(f, ",%.17g",
                    w->a[c][0] * q[0] + w->a[c][1] * q[1] + w->zero[c] +
                        5e-4 * (w->a[c][0] + w->a[c][1]) * gauss(&seed));
        }
        fprintf(f, "\n");
    }
    ck_assert_int_eq(fclose(f), 0);
    stein_sim_destroy(sim);
    lab_close(model);
    return kept[which];
}

START_TEST(the_error_of_a_set_up_is_named)
{
    const slip *w = &slips[_i];
    const char *at = strstr(arm, w->was);
    char text[2000], model[300];
    ck_assert_ptr_nonnull(at);
    snprintf(text, sizeof text, "%.*s%s%s", (int)(at - arm), arm, w->is, at + strlen(w->was));
    snprintf(model, sizeof model, "%s", write_file("arm.yaml", text));
    const char *data[] = {record_of(w, 0), record_of(w, 1), NULL};
    posed o;
    fit__finding *list = NULL;
    int n = -1, named = 0;
    pose(&o, model, data);
    double *was = malloc(sizeof *was * (size_t)(2 * 240));
    memcpy(was, o.p.stroke[1].y, sizeof *was * 480);
    ck_assert_stein(fit__setup(&o.p, &list, &n, err));
    for (int i = 0; i < n; i++) {
        named |= w->said != NULL && strstr(list[i].text, w->said) != NULL;
        ck_assert(list[i].after < list[i].before);
    }
    ck_assert_msg(w->said == NULL ? n == 0 : named, "%d findings, the first: %s", n,
                  n > 0 ? list[0].text : "");
    ck_assert_int_eq(memcmp(was, o.p.stroke[1].y, sizeof *was * 480), 0);
    free(was);
    fit__setup_free(list, n);
    unpose(&o);
}
END_TEST

Suite *initial_suite(void)
{
    Suite *s = suite_create("initial");
    TCase *state = tcase_create("state"), *setup = tcase_create("setup");
    tcase_add_checked_fixture(state, make_folder, remove_folder);
    tcase_add_loop_test(state, a_record_that_begins_in_mid_swing_starts_within_its_noise, 0, 6);
    tcase_add_loop_test(state, the_state_of_an_arm_comes_from_the_coordinates_of_its_tip, 0, 3);
    tcase_add_test(state,
                   a_joint_that_no_channel_shows_begins_near_the_files_state_with_a_wide_prior);
    tcase_add_test(state, a_joint_that_has_no_channel_is_found_through_the_others_point);
    tcase_add_test(state, a_speed_may_be_measured_itself);
    tcase_add_test(state, an_angle_that_jumps_by_whole_turns_is_followed_across);
    tcase_add_test(state, the_state_of_an_arm_comes_from_the_angles_of_its_bodies);
    tcase_add_test(state, stated_settings_of_a_stroke_are_not_estimated);
    tcase_add_test(state, a_mechanism_that_is_held_until_the_trigger_starts_there);
    tcase_add_test(state, a_mechanism_that_settles_is_left_as_it_is);
    tcase_add_test(state, a_part_with_a_joint_of_its_own_begins_at_the_same_record);
    tcase_set_timeout(state, 60);
    tcase_add_checked_fixture(setup, make_folder, remove_folder);
    tcase_add_loop_test(setup, the_error_of_a_set_up_is_named, 0,
                        (int)(sizeof slips / sizeof *slips));
    tcase_set_timeout(setup, 60);
    suite_add_tcase(s, state);
    suite_add_tcase(s, setup);
    return s;
}
