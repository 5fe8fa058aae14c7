/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_diagnosis_show.c - contents of a diagnosis: phases, departures, missing forces.
 */
#include "diagnosing.h"
#include "fit_support.h"

Suite *show_suite(void);

static const char action[] = "models/stein1788.yaml";

/* ---- strokes of the action, made by the core ---- */

enum { STROKES = 8 };

/* a fit to strokes in which something is hidden, with little that could imitate it */
typedef struct shown {
    fitted f;
    lab_fit_def def;
    fit__problem p;
    double *x, *r, *J, *time;
    const char **phase;
    lab_diagnosis d;
} shown;

static void film_strokes(const char *data[STROKES + 1], const char *const *truth)
{
    static const char *const load[] = {"load.mass=70 g", "load.mass=100 g", "load.mass=140 g"};
    static const char *const shift[] = {"pawl.stop_shift=-0.6 mm", "pawl.stop_shift=-0.2 mm"};
    static char kept[STROKES][200];
    for (int i = 0; i < STROKES; i++) {
        const char *const told[] = {load[i % 3], shift[i % 2], NULL};
        char name[32];
        film m = {.model = action,
                  .truth = truth,
                  .told = told,
                  .channels = "string_distance key_dip",
                  .rate = 2000.0,
                  .from = -0.004,
                  .until = 0.11,
                  .noise = 12e-6,
                  .seed = 40 + (unsigned long long)i};
        snprintf(name, sizeof name, "stroke%d.csv", i);
        snprintf(kept[i], sizeof kept[i], "%s", take(name, &m));
        data[i] = kept[i];
    }
    data[STROKES] = NULL;
}

/* fit the free numbers, then make all displays */
static void show(shown *s, const char *const *truth)
{
    static const char *const names[] = {"notch.friction.A", "hammer.inertia.yy", NULL};
    const char *data[STROKES + 1];
    int failed = 0;
    film_strokes(data, truth);
    open_fit(&s->f, action, NULL, data);
    s->def = free_these(names);
    s->def.drive_scatter = 0.0;
    ck_assert_stein(fit__problem_make(&s->p, s->f.model, s->f.data, &s->def, err));
    size_t nu = (size_t)s->p.nu, frames = diag__frame(&s->p, s->p.nstroke);
    double *room = calloc(3 * nu, sizeof *room);
    fit__state state = {
        .x = room, .step = room + nu, .scale = room + 2 * nu, .mu = 1e-3, .nu = 2.0};
    for (size_t k = 0; k < nu; k++) {
        state.step[k] = s->p.step[k];
    }
    ck_assert_stein(fit__minimise(&s->p, &state, 1e-2, 1e-5, 20, NULL, NULL, err));
    s->x = room;
    s->r = calloc(fit__offset(&s->p, s->p.nstroke), sizeof *s->r);
    s->J = calloc(fit__columns(&s->p), sizeof *s->J);
    s->phase = calloc(frames, sizeof *s->phase);
    s->time = calloc(frames, sizeof *s->time);
    s->d = (lab_diagnosis){.verdict = LAB_VERDICT_EXPLAINED};
    ck_assert_stein(fit__residuals(&s->p, s->x, s->r, &failed, err));
    ck_assert_int_eq(failed, 0);
    ck_assert_stein(fit__sensitivities(&s->p, s->x, s->r, s->J, err));
    ck_assert_stein(diag__phases(&s->p, s->x, s->phase, s->time, err));
    ck_assert_stein(diag__show(&s->d, &s->p, s->x, s->r, s->J, s->phase, s->time, err));
}

static void drop_shown(shown *s)
{
    lab_diagnosis *d = malloc(sizeof *d);
    *d = s->d;
    lab_diagnosis_destroy(d);
    fit__problem_free(&s->p);
    drop(&s->f);
    free(s->x);
    free(s->r);
    free(s->J);
    free(s->time);
    free(s->phase);
}

static const lab_departure *hottest(const lab_diagnosis *d, int is_force)
{
    const lab_departure *hot = NULL;
    for (int i = 0; i < d->ndeparture; i++) {
        const lab_departure *r = &d->departure[i];
        hot = r->is_force == is_force && isfinite(r->z) && (hot == NULL || r->z > hot->z) ? r : hot;
    }
    ck_assert_ptr_nonnull(hot);
    return hot;
}

static const lab_departure *departure(const lab_diagnosis *d, const char *place, const char *phase)
{
    for (int i = 0; i < d->ndeparture; i++) {
        if (strcmp(d->departure[i].place, place) == 0 &&
            strcmp(d->departure[i].phase, phase) == 0) {
            return &d->departure[i];
        }
    }
    ck_abort_msg("no departure of %s in %s", place, phase);
    return NULL;
}

/* ---- phases ---- */

/* time at which a phase begins in a stroke; NAN */
static double begins(const shown *s, int stroke, const char *phase)
{
    size_t row = diag__frame(&s->p, stroke);
    for (int i = 0; i < s->p.stroke[stroke].n; i++) {
        if (strcmp(s->phase[row + (size_t)i], phase) == 0) {
            return s->time[row + (size_t)i];
        }
    }
    return NAN;
}

START_TEST(nothing_hidden_nothing_shown)
{
    shown s;
    show(&s, NULL);
    const lab_departure *channel = hottest(&s.d, 0), *force = hottest(&s.d, 1);
    ck_assert_msg(channel->z < 4.0, "%s %s: %g", channel->place, channel->phase, channel->z);
    ck_assert_msg(force->z < 4.0, "%s %s: %g", force->place, force->phase, force->z);
    for (int i = 0; i < s.d.nlatent; i++) {
        const lab_latent *l = &s.d.latent[i];
        for (int k = 0; k < l->n; k++) {
            ck_assert_msg(fabs(l->force[k]) < 4.0 * l->sd[k], "%s at %g s", l->joint, l->t[k]);
        }
    }
    // phases come in order, and at the times of the stroke's events
    lab_stroke stroke;
    lab_stroke_def def = lab_stroke_def_default(lab_equations(s.f.model));
    stein_sim *sim = NULL;
    ck_assert_stein(lab_sim(s.f.model, NULL, &sim, err));
    ck_assert_stein(stein_set(sim, "load.mass", 0.14, err));
    ck_assert_stein(stein_set(sim, "pawl.stop_shift", -0.6e-3, err));
    ck_assert_stein(stein_reset(sim, err));
    def.until = 0.11;
    ck_assert_stein(lab_strike(sim, &def, &stroke, err));
    double frame = 1.0 / 2000.0;
    double flight = begins(&s, 2, "free flight"), string = begins(&s, 2, "string");
    ck_assert(flight >= stroke.escape_time - 1e-4 && flight < stroke.escape_time + 1.5 * frame);
    ck_assert(string >= stroke.impact_time - 1e-4 && string < stroke.impact_time + 1.5 * frame);
    ck_assert(begins(&s, 2, "rest") <= 0.0 && begins(&s, 2, "drive i") < 2.0 * frame);
    ck_assert(begins(&s, 2, "drive iii") > begins(&s, 2, "drive i"));
    ck_assert(begins(&s, 2, "fall") > string);
    ck_assert_msg(begins(&s, 1, "re-arm") > begins(&s, 1, "fall"), "%g", begins(&s, 1, "re-arm"));
    ck_assert(isnan(begins(&s, 2, "motion")));
    stein_sim_destroy(sim);
    drop_shown(&s);
}
END_TEST

START_TEST(a_mechanism_without_stroke_rests_or_moves)
{
    static const char *const names[] = {"rod.damping", NULL};
    static const char *const held[] = {"rod.initial.position=0 deg", NULL};
    film m = {.model = "models/pendulum.yaml",
              .channels = "angle",
              .rate = 40.0,
              .until = 2.0,
              .noise = 1e-3,
              .seed = 3};
    static char first[200];
    snprintf(first, sizeof first, "%s", take("swing.csv", &m));
    m.told = held;
    const char *data[] = {first, take("still.csv", &m), NULL};
    fitted f;
    fit__problem p;
    open_fit(&f, m.model, NULL, data);
    lab_fit_def def = free_these(names);
    def.initial = 0;
    ck_assert_stein(fit__problem_make(&p, f.model, f.data, &def, err));
    double *x = calloc((size_t)p.nu, sizeof *x);
    const char **phase = calloc(diag__frame(&p, 2), sizeof *phase);
    ck_assert_stein(diag__phases(&p, x, phase, NULL, err));
    for (int i = 0; i < p.stroke[0].n; i++) {
        ck_assert_str_eq(phase[i], i == 0 ? "rest" : "motion");
        ck_assert_str_eq(phase[p.stroke[0].n + i], "rest");
    }
    fit__problem_free(&p);
    drop(&f);
    free(x);
    free(phase);
}
END_TEST

/* ---- departures ---- */

/* correlated noise, a constant that differs in every stroke, and a part common to all */
static void fill_residual(const fit__problem *p, double *r, double memory, double scatter,
                          double alike, unsigned long long *seed)
{
    for (int s = 0; s < p->nstroke; s++) {
        double last = gauss(seed), own = scatter * gauss(seed);
        for (int i = 0; i < p->stroke[s].n; i++) {
            last = memory * last + sqrt(1.0 - memory * memory) * gauss(seed);
            r[fit__offset(p, s) + (size_t)i] = last + own + alike;
        }
    }
}

/* in how many of 300 sets of residuals is the departure larger than z? */
static int count_departures(const fit__problem *p, double memory, double scatter, double alike,
                            double z)
{
    unsigned long long seed = 11;
    int above = 0;
    double *r = calloc(fit__offset(p, p->nstroke), sizeof *r);
    const char **phase = calloc(diag__frame(p, p->nstroke), sizeof *phase);
    for (size_t i = 0; i < diag__frame(p, p->nstroke); i++) {
        phase[i] = diag__phase[diag__phase_index("motion")];
    }
    for (int set = 0; set < 300; set++) {
        lab_departure *list = NULL;
        int n = 0;
        fill_residual(p, r, memory, scatter, alike, &seed);
        ck_assert_stein(diag__departures(p, r, phase, &list, &n, err));
        ck_assert_int_eq(n, 1);
        above += list[0].z > z;
        free(list);
    }
    free(r);
    free(phase);
    return above;
}

START_TEST(correlated_noise_is_no_departure_but_a_repeated_residual_is)
{
    static const char *const names[] = {"rod.damping", NULL};
    film m = {.model = "models/pendulum.yaml",
              .channels = "angle",
              .rate = 60.0,
              .until = 1.0,
              .noise = 1e-3,
              .seed = 3};
    const char *file = take("swing.csv", &m), *data[9];
    fitted f;
    fit__problem p;
    for (int i = 0; i < 9; i++) {
        data[i] = i < 8 ? file : NULL;
    }
    open_fit(&f, m.model, NULL, data);
    lab_fit_def def = free_these(names);
    ck_assert_stein(fit__problem_make(&p, f.model, f.data, &def, err));
    // and where two sets of residuals differ most
    double *r = calloc(2 * fit__offset(&p, 8), sizeof *r), *other = r + fit__offset(&p, 8);
    const char **phase = calloc(diag__frame(&p, 8), sizeof *phase);
    for (size_t i = 0; i < diag__frame(&p, 8); i++) {
        phase[i] = diag__phase[i % 4];
    }
    ck_assert_ptr_null(diag__phase_shown(&p, r, other, phase));
    other[1] = 0.5;
    other[4 * 7 + 2] = -0.7;
    ck_assert_str_eq(diag__phase_shown(&p, r, other, phase), diag__phase[2]);
    free(r);
    free(phase);
    int white = count_departures(&p, 0.0, 0.0, 0.0, 2.0);
    int slow = count_departures(&p, 0.8, 0.0, 0.0, 2.0);
    int scattered = count_departures(&p, 0.3, 1.0, 0.0, 2.0);
    int there = count_departures(&p, 0.3, 0.0, 0.6, 3.0);
    printf("departures: z > 2 in %d, %d, %d of 300 without (14 expected), z > 3 in %d with\n",
           white, slow, scattered, there);
    ck_assert(white <= 26 && slow <= 26 && scattered <= 26);
    ck_assert_int_ge(there, 270);
    fit__problem_free(&p);
    drop(&f);
}
END_TEST

/* ---- missing forces ---- */

START_TEST(a_hidden_drag_is_missing_at_its_joint_with_its_size)
{
    static const char *const truth[] = {"hammer.drag=1e-6 N m s^2/rad^2", NULL};
    const double k = 1e-6;
    shown s;
    show(&s, truth);
    const lab_departure *hot = hottest(&s.d, 1);
    ck_assert_str_eq(hot->place, "hammer");
    ck_assert_msg(hot->z > 4.0, "%g", hot->z);
    ck_assert_double_lt(departure(&s.d, "hammer", "free flight")->size, 0.0); // it goes up
    ck_assert_double_gt(departure(&s.d, "hammer", "fall")->size, 0.0);
    // over time: against the true torque of the true stroke
    int inside = 0, points = 0, hammer = stein_find_body(lab_equations(s.f.model), "hammer");
    double size = 0.0;
    for (int i = 0; i < s.d.nlatent; i++) {
        const lab_latent *l = &s.d.latent[i];
        int stroke = 0;
        while (strcmp(s.p.stroke[stroke].data->file, l->file) != 0) {
            stroke++;
        }
        stein_sim *sim = NULL;
        ck_assert_stein(lab_sim(s.f.model, NULL, &sim, err));
        const lab_data *data = s.p.stroke[stroke].data;
        for (int n = 0; n < data->nset; n++) {
            ck_assert_stein(stein_set(sim, data->set[n].name, data->set[n].value, err));
        }
        ck_assert_stein(stein_set(sim, "hammer.drag", k, err));
        ck_assert_stein(stein_reset(sim, err));
        for (int n = 0; strcmp(l->joint, "hammer") == 0 && n < l->n; n++) {
            ck_assert_stein(stein_run(sim, fmax(l->t[n], stein_time(sim)), err));
            double w = stein_qd(sim)[hammer], T = -k * fabs(w) * w;
            inside += fabs(l->force[n] - T) < 3.0 * l->sd[n];
            size = fmax(size, fabs(T));
            points++;
        }
        stein_sim_destroy(sim);
    }
    printf("missing force: %d of %d points within their band, up to %.2g N m\n", inside, points,
           size);
    ck_assert_int_gt(points, 100);
    ck_assert_int_gt(inside, points * 85 / 100);
    drop_shown(&s);
}
END_TEST

START_TEST(a_hidden_preload_is_missing_at_its_joint_with_its_size)
{
    static const char *const truth[] = {"key.preload=1.3 mN m", NULL};
    shown s;
    show(&s, truth);
    const lab_departure *hot = hottest(&s.d, 1), *key = departure(&s.d, "key", "drive iii");
    ck_assert_str_eq(hot->place, "key");
    ck_assert_msg(hot->z > 4.0, "%s: %g", hot->phase, hot->z);
    ck_assert_msg(fabs(key->size - 1.3e-3) < 3.0 * key->sd + 0.1e-3, "%g +- %g", key->size,
                  key->sd);
    drop_shown(&s);
}
END_TEST

Suite *show_suite(void)
{
    Suite *suite = suite_create("show");
    TCase *shows = tcase_create("shows");
    tcase_add_checked_fixture(shows, make_folder, remove_folder);
    tcase_set_timeout(shows, 900);
    tcase_add_test(shows, nothing_hidden_nothing_shown);
    tcase_add_test(shows, a_mechanism_without_stroke_rests_or_moves);
    tcase_add_test(shows, correlated_noise_is_no_departure_but_a_repeated_residual_is);
    tcase_add_test(shows, a_hidden_drag_is_missing_at_its_joint_with_its_size);
    tcase_add_test(shows, a_hidden_preload_is_missing_at_its_joint_with_its_size);
    suite_add_tcase(suite, shows);
    return suite;
}
