/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_settle.c - a cause has its numbers from what of its strokes can be predicted: a ball dances
 * on a plate that shakes, and after a few bounces it answers to its numbers more finely than any
 * measurement tells them. The hidden number has to lie in its interval all the same.
 */
#include <math.h>

#include "fit_support.h"
#include "stein/diagnose.h"

Suite *settle_suite(void);

enum { STROKES = 9, LONG = 400, SHORT = 80 };
static const double interval = 3e-3, weight = 3.1e-3 * 9.81, pixel = 2e-5;
static const double hidden = 0.3; /* logarithm of the true damping over that of the file */

static const char ball[] = "mechanism: ball\n"
                           "bodies:\n"
                           "  ball: {joint: T z, mass: 3.1 g, initial: {position: 20 mm},\n"
                           "    points: {foot: [0, 0, 0]}}\n"
                           "contacts:\n"
                           "  plate:\n"
                           "    between:\n"
                           "      - {point: ball.foot}\n"
                           "      - {line: {on: frame, at: [0, 0, 0], facing: 90 deg}}\n"
                           "    normal: {c: 3 kN/m, D: 0.1 s/m}\n"
                           "inputs:\n"
                           "  shake: {torque: ball}\n"
                           "outputs:\n"
                           "  height: {joint: ball, read: position}\n"
                           "simulation: {dt: 20 us, until: 1.2 s}\n";

typedef struct dance {
    double strength; /* of the shaking, in weights */
    int samples;
    const char *number; /* what is hidden */
    double value;
    const char *settings; /* "# set" lines of all strokes */
    char path[STROKES][200];
    lab_model *model;
    lab_dataset *data;
    lab_diagnosis *d;
} dance;

/* the force of the plate's shaking at sample i [N] */
static double shaking(const dance *c, int i)
{
    return c->strength * weight * sin(55.0 * interval * i);
}

/* the same between the samples: straight */
static void act(void *ctx, double t, const double *q, const double *qd, double *Q)
{
    const dance *c = ctx;
    int i = (int)floor(t / interval);
    double u = t / interval - i;
    (void)q;
    (void)qd;
    Q[0] += (1.0 - u) * shaking(c, i) + u * shaking(c, i + 1);
}

/* a film of all channels in which one number of the file is another one */
static void make_stroke(dance *c, int s, unsigned long long *seed)
{
    const stein_model *m = lab_equations(c->model);
    stein_sim_def def = lab_def(c->model);
    stein_sim *sim = NULL;
    double start = 0.012 + 0.002 * ((s * 4) % 9);
    def.dt = 5e-6;
    ck_assert_stein(lab_sim(c->model, &def, &sim, err));
    ck_assert_stein(stein_set(sim, "ball.initial.position", start, err));
    ck_assert_stein(stein_set(sim, c->number, c->value, err));
    ck_assert_stein(stein_reset(sim, err));
    stein_on_force(sim, act, c);
    snprintf(c->path[s], sizeof c->path[s], "%s/stroke%d.csv", folder, s);
    FILE *f = fopen(c->path[s], "w");
    ck_assert_ptr_nonnull(f);
    fprintf(f, "# set ball.initial.position: %.17g\n%s", start, c->settings);
    for (int k = 1; k < m->nchannel; k++) { // all but the time
        fprintf(f, "# noise %s: %g\n", m->channels[k].name, pixel);
    }
    fprintf(f, "time [s]");
    for (int k = 1; k < m->nchannel; k++) {
        fprintf(f, ",%s [m]", m->channels[k].name);
    }
    fprintf(f, ",shake [N]\n");
    for (int i = 0; i <= c->samples; i++) {
        if (i > 0) {
            ck_assert_stein(stein_run(sim, interval * i, err));
        }
        fprintf(f, "%.17g", interval * i);
        for (int k = 1; k < m->nchannel; k++) {
            fprintf(f, ",%.17g", stein_read(sim, k) + pixel * gauss(seed));
        }
        fprintf(f, ",%.17g\n", shaking(c, i));
    }
    ck_assert_int_eq(fclose(f), 0);
    stein_sim_destroy(sim);
}

static void open_dance(dance *c, const char *text, int seed)
{
    unsigned long long random = 1788ULL + (unsigned long long)seed;
    const char *path[STROKES], *file = write_file("dance.yaml", text);
    lab_options options = cache_here(NULL);
    ck_assert_stein(lab_open(&c->model, file, &options, err));
    for (int s = 0; s < STROKES; s++) {
        make_stroke(c, s, &random);
        path[s] = c->path[s];
    }
    examine(file, c->model, path, STROKES, &c->data, &c->d);
}

/* the damping of the plate is another one */
static void open_ball(dance *c, int samples, int seed)
{
    *c = (dance){.strength = 0.8,
                 .samples = samples,
                 .number = "plate.normal.D",
                 .value = 0.1 * exp(hidden),
                 .settings = ""};
    open_dance(c, ball, seed);
}

static void close_dance(dance *c)
{
    lab_diagnosis_destroy(c->d);
    lab_dataset_close(c->data);
    lab_close(c->model);
}

static const char *unpredicted(const dance *c)
{
    for (int i = 0; i < c->d->nfinding; i++) {
        if (strstr(c->d->finding[i], "cannot be predicted to their end") != NULL) {
            return c->d->finding[i];
        }
    }
    return NULL;
}

static void check_damping(const dance *c)
{
    ck_assert_int_eq(c->d->verdict, LAB_VERDICT_WRONG_PARAMETER);
    ck_assert_int_eq(c->d->ncause, 1);
    const lab_suspect *s = &c->d->suspect[0];
    const lab_cause_number *n = &s->number[0];
    ck_assert_str_eq(s->candidate.effect->kind, "contact_damping");
    ck_assert_str_eq(s->candidate.place, "plate");
    ck_assert_msg(n->lo <= hidden && hidden <= n->hi, "%g: %.8g .. %.8g", hidden, n->lo, n->hi);
    ck_assert_double_lt(n->hi - n->lo, 0.01); // and the interval says something
}

/* Without the end of its strokes being cut off the interval is 1e-6 wide, and 7e-5 beside. */
START_TEST(a_dance_that_nobody_can_predict_has_an_interval_that_holds)
{
    for (int seed = 0; seed < 2; seed++) {
        dance c;
        open_ball(&c, LONG, seed);
        ck_assert_ptr_nonnull(unpredicted(&c));
        ck_assert_ptr_nonnull(strstr(unpredicted(&c), " of 6 strokes"));
        check_damping(&c);
        close_dance(&c);
    }
}
END_TEST

START_TEST(bounces_that_follow_their_numbers_are_used_to_their_end)
{
    dance c;
    open_ball(&c, SHORT, 3);
    ck_assert_ptr_null(unpredicted(&c));
    check_damping(&c);
    close_dance(&c);
}
END_TEST

/* ---- a cause that shows only behind what can be predicted ---- */

static const char falls[] = "mechanism: falls\n"
                            "bodies:\n"
                            "  ball: {joint: T z, mass: 3.1 g, initial: {position: 20 mm},\n"
                            "    points: {foot: [0, 0, 0]}}\n"
                            "  stone: {joint: T z, mass: 1 kg, initial: {position: 5 m},\n"
                            "    points: {foot: [0, 0, 0]}}\n"
                            "contacts:\n"
                            "  plate:\n"
                            "    between:\n"
                            "      - {point: ball.foot}\n"
                            "      - {line: {on: frame, at: [0, 0, 0], facing: 90 deg}}\n"
                            "    normal: {c: 3 kN/m, D: 0.1 s/m +- 10 %}\n"
                            "  floor:\n"
                            "    between:\n"
                            "      - {point: stone.foot}\n"
                            "      - {line: {on: frame, at: [0, 0, 0], facing: 90 deg}}\n"
                            "    normal: {c: 2000 kN/m, D: 0.1 s/m}\n"
                            "inputs:\n"
                            "  shake: {torque: ball}\n"
                            "outputs:\n"
                            "  height: {joint: ball, read: position}\n"
                            "  level: {joint: stone, read: position}\n"
                            "simulation: {dt: 20 us, until: 1.2 s}\n";
static const double deeper = 0.2e-3; /* the floor, than the file says [m] */

/* the ball dances, the stone meets the floor after a second */
START_TEST(what_shows_only_where_nothing_can_be_predicted_keeps_its_number)
{
    dance c = {.strength = 1.6,
               .samples = LONG,
               .number = "floor.gap",
               .value = deeper,
               .settings = "# set stone.initial.position: 5\n"};
    open_dance(&c, falls, 0);
    ck_assert_msg(c.d->ncause == 1, "%s", c.d->reason);
    const lab_suspect *s = &c.d->suspect[0];
    const lab_cause_number *n = &s->number[0];
    ck_assert_str_eq(s->candidate.effect->kind, "contact_gap");
    ck_assert_str_eq(s->candidate.place, "floor");
    ck_assert_ptr_nonnull(unpredicted(&c));
    ck_assert_msg(strstr(unpredicted(&c), "contact_gap at floor shows only behind that") != NULL,
                  "%s: %g .. %g", unpredicted(&c), n->lo, n->hi);
    ck_assert_msg(n->lo <= deeper && deeper <= n->hi, "%g .. %g", n->lo, n->hi);
    ck_assert_double_lt(n->hi - n->lo, 0.2 * deeper);
    close_dance(&c);
}
END_TEST

Suite *settle_suite(void)
{
    Suite *s = suite_create("settle");
    TCase *t = tcase_create("settle");
    tcase_set_timeout(t, 300); // minutes under the sanitizers
    tcase_add_unchecked_fixture(t, cache_in_build, NULL);
    tcase_add_checked_fixture(t, make_folder, remove_folder);
    tcase_add_test(t, a_dance_that_nobody_can_predict_has_an_interval_that_holds);
    tcase_add_test(t, what_shows_only_where_nothing_can_be_predicted_keeps_its_number);
    tcase_add_test(t, bounces_that_follow_their_numbers_are_used_to_their_end);
    suite_add_tcase(s, t);
    return s;
}
