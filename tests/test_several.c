/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_several.c - diagnoses of the swings of a pendulum: two effects hidden at once are both
 * found; one is not called two; numbers out of their tolerances are told, or believed; a step that
 * is too coarse is told, and is no physics; a swing that a fit has lost is called back.
 */
#include "fit_support.h"
#include "searching.h"
#include "stein/diagnose.h"
#include "structure.h"
#include "suites.h"
#include "swings.h"

static lab_diagnosis *diagnosed(fitted *f, const char *model, const char *what)
{
    lab_options options = cache_here(NULL);
    lab_diagnose_def def = lab_diagnose_def_default();
    def.threads = 2;
    def.options = &options;
    lab_diagnosis *d = NULL;
    ck_assert_stein(lab_diagnose(&d, model, f->model, f->data, &def, err));
    printf("%s: %s, chi2/dof %.3f -> %.3f\n", what, d->reason, d->chi2_dof_before,
           d->chi2_dof_after);
    return d;
}

static lab_diagnosis *diagnose(fitted *f, const char *model, const char *const *truth,
                               unsigned long long seed)
{
    open_swings(f, model, truth, seed);
    return diagnosed(f, model, truth[0]);
}

/* one of the causes is that kind, its number is right and the held-out swings need it */
static void ck_assert_cause(const lab_diagnosis *d, const char *kind, double truth, int several)
{
    for (int i = 0; i < d->ncause; i++) {
        const lab_suspect *s = &d->suspect[i];
        if (strcmp(s->candidate.effect->kind, kind) == 0) {
            const lab_cause_number *n = &s->number[0];
            printf("  %s %.4g (%.4g .. %.4g), true %.4g; error %.3f of what it is without\n", kind,
                   n->value, n->lo, n->hi, truth, s->own_ratio);
            ck_assert(fabs(n->value - truth) < 4.0 * n->sd);
            ck_assert(n->sd < 0.2 * fabs(truth));
            ck_assert(several ? s->own_hi < 1.0 : isnan(s->own_ratio));
            return;
        }
    }
    ck_abort_msg("%s is not among the causes: %s", kind, d->reason);
}

START_TEST(two_effects_at_once_are_both_found)
{
    static const char *const truth[] = {"rod.coulomb.T=2 mN m", "rod.preload=4 mN m", NULL};
    fitted f;
    lab_diagnosis *d = diagnose(&f, pendulum, truth, 500);
    ck_assert_int_eq(d->verdict, LAB_VERDICT_MISSING_EFFECT);
    ck_assert_int_eq(d->ncause, 2);
    ck_assert_cause(d, "coulomb_friction", 2e-3, 1);
    ck_assert_cause(d, "preload", 4e-3, 1);
    ck_assert_double_lt(d->chi2_dof_after, 1.1);
    // and the file with both moves like that
    char *path = lab__text("%s", in_folder("both.yaml"));
    ck_assert_stein(lab_extend(path, pendulum, d, err));
    lab_model *both = NULL;
    lab_options options = cache_here(NULL);
    ck_assert_stein(lab_open(&both, path, &options, err));
    for (int i = 0; i < 2; i++) {
        const lab_suspect *s = &d->suspect[i];
        int k = stein_find_param(
            lab_equations(both),
            strcmp(s->candidate.effect->kind, "preload") == 0 ? "rod.preload" : "rod.coulomb.T");
        ck_assert_close(lab_parameters(both)[k], s->number[0].value, 1e-6, 0.0);
    }
    lab_close(both);
    free(path);
    lab_diagnosis_destroy(d);
    drop(&f);
}
END_TEST

/* A constant loss and one that grows with the square of speed look like viscous friction together,
 * which alone explains most and is found first. */
START_TEST(what_was_found_first_gives_way_to_what_does_better_beside_the_others)
{
    static const char *const truth[] = {"rod.coulomb.T=2 mN m", "rod.drag=0.5 mN m s^2/rad^2",
                                        NULL};
    fitted f;
    lab_diagnosis *d = diagnose(&f, pendulum, truth, 1500);
    ck_assert_int_eq(d->ncause, 2);
    ck_assert_cause(d, "coulomb_friction", 2e-3, 1);
    ck_assert_cause(d, "quadratic_drag", 0.5e-3, 1);
    lab_diagnosis_destroy(d);
    drop(&f);
}
END_TEST

/* a key that a load presses down onto its felt */
static const char lever[] =
    "mechanism: lever\n"
    "bodies:\n"
    "  key:\n"
    "    joint: R y\n"
    "    mass: 70 g +- 0.3 g\n"
    "    centre: [-32 mm, 0, 0]\n"
    "    inertia: {yy: 4.4e-4 kg m^2 +- 3 %}\n"
    "    points: {front: [181 mm, 0, 10 mm], rear: [-150 mm, 0, -10 mm],\n"
    "      below: [181 mm, 0, -10 mm]}\n"
    "load: {mass: 100 g, on: key.front, normal: {c: 55 kN/m, D: 17 s/m}}\n"
    "contacts:\n"
    "  rest:\n"
    "    between: [{point: key.rear},\n"
    "      {line: {on: frame, at: [-150 mm, 0, -10 mm], facing: 90 deg}}]\n"
    "    normal: {c: 4 kN/m, D: 5 s/m}\n"
    "  dip:\n"
    "    between: [{point: key.below},\n"
    "      {line: {on: frame, at: [181 mm, 0, -17 mm], facing: 90 deg}}]\n"
    "    normal: {c: 12 kN/m, D: 5 s/m}\n"
    "outputs: {key_dip: {point: key.front, read: z, sign: -1, zero: rest}}\n"
    "simulation: {dt: 20 us, until: 0.15 s}\n";

/* the lever whose felt lies on a board that gives way, in a file of its own */
static void on_a_board(char path[200], const char *file, double compliance)
{
    lab_model *model = NULL;
    lab_candidate *list = NULL;
    lab_options options = cache_here(NULL);
    char *with = NULL;
    size_t size = 0;
    int n = 0, k = 0;
    ck_assert_stein(lab_open(&model, file, &options, err));
    ck_assert_stein(lab_candidates(&list, &n, model, err));
    while (k < n && !(strcmp(list[k].effect->kind, "compliant_partner") == 0 &&
                      strcmp(list[k].place, "dip") == 0)) {
        k++;
    }
    ck_assert_int_lt(k, n);
    ck_assert_stein(lab__structure_text(&list[k], compliance, lab__mechanism(model), lever,
                                        strlen(lever), &with, &size, err));
    snprintf(path, 200, "%s", write_file("board.yaml", with));
    free(list);
    free(with);
    lab_close(model);
}

START_TEST(a_part_is_found_beside_another_cause)
{
    static const double compliance = 5e-6;
    static const char *const truth[] = {"key.coulomb.T=30 mN m", NULL};
    static char data_path[SWINGS][200];
    char file[200], board[200];
    const char *data[SWINGS + 1] = {NULL};
    snprintf(file, sizeof file, "%s", write_file("lever.yaml", lever));
    on_a_board(board, file, compliance);
    for (int i = 0; i < SWINGS; i++) {
        char name[40], load[40];
        snprintf(name, sizeof name, "press%d.csv", i);
        snprintf(load, sizeof load, "load.mass=%d g", 60 + 20 * i);
        const char *const told[] = {load, NULL};
        film m = {.model = board,
                  .truth = truth,
                  .told = told,
                  .channels = "key_dip",
                  .rate = 2000.0,
                  .until = 0.1,
                  .noise = 1e-5,
                  .seed = 1700 + (unsigned long long)i};
        snprintf(data_path[i], sizeof data_path[i], "%s", take(name, &m));
        data[i] = data_path[i];
    }
    fitted f;
    open_fit(&f, file, NULL, data);
    lab_diagnosis *d = diagnosed(&f, file, "lever");
    ck_assert_int_eq(d->ncause, 2);
    ck_assert_str_eq(d->suspect[1].candidate.effect->kind, "compliant_partner");
    ck_assert_cause(d, "coulomb_friction", 3e-2, 1);
    ck_assert_cause(d, "compliant_partner", compliance, 1);
    lab_diagnosis_destroy(d);
    drop(&f);
}
END_TEST

START_TEST(one_effect_is_not_called_two)
{
    static const char *const truth[] = {"rod.coulomb.T=2 mN m", NULL};
    fitted f;
    lab_diagnosis *d = diagnose(&f, pendulum, truth, 700);
    ck_assert_int_eq(d->verdict, LAB_VERDICT_MISSING_EFFECT);
    ck_assert_int_eq(d->ncause, 1);
    ck_assert_cause(d, "coulomb_friction", 2e-3, 0);
    lab_diagnosis_destroy(d);
    drop(&f);
}
END_TEST

/* Two channels of records that began nobody knows when, one of them late: that the other one is
 * ahead says the same, and is no sensor. */
START_TEST(of_two_channels_the_late_one_is_named)
{
    static const char *const channels[] = {"angle rate", "rate angle"}, *const late[] = {"rate",
                                                                                         "angle"};
    static const char *const truth[] = {NULL};
    static char path[SWINGS][200];
    const char *data[SWINGS + 1] = {NULL};
    for (int i = 0; i < SWINGS; i++) {
        char start[60], name[40];
        snprintf(start, sizeof start, "rod.initial.position=%d deg", 12 + 6 * i);
        snprintf(name, sizeof name, "late%d.csv", i);
        const char *const told[] = {start, NULL};
        film m = {.model = pendulum,
                  .truth = truth,
                  .told = told,
                  .channels = channels[_i],
                  .rate = 100.0,
                  .until = 2.0,
                  .noise = 1e-3,
                  .lag = 1e-3,
                  .unsynchronised = 1,
                  .seed = 2600 + (unsigned long long)i};
        snprintf(path[i], sizeof path[i], "%s", take(name, &m));
        data[i] = path[i];
    }
    fitted f;
    open_fit(&f, pendulum, NULL, data);
    lab_diagnosis *d = diagnosed(&f, pendulum, late[_i]);
    ck_assert_int_eq(d->ncause, 1);
    ck_assert_str_eq(d->suspect[0].candidate.place, late[_i]);
    ck_assert_cause(d, "sensor_delay", 1e-3, 0);
    ck_assert_int_eq(d->nrival, 0);
    lab_diagnosis_destroy(d);
    drop(&f);
}
END_TEST

/* the file with another line in the place of the one that begins so */
static void with_line(const char *path, const char *begins, const char *instead)
{
    char line[300];
    int found = 0;
    FILE *from = fopen(pendulum, "r"), *to = fopen(path, "w");
    ck_assert(from != NULL && to != NULL);
    while (fgets(line, sizeof line, from) != NULL) {
        int is_it = strncmp(line, begins, strlen(begins)) == 0;
        fputs(is_it ? instead : line, to);
        found += is_it;
    }
    fclose(from);
    ck_assert_int_eq(fclose(to), 0);
    ck_assert_int_eq(found, 1);
}

/* the diagnosis of swings whose friction is `mean` times that of the file, and differs from swing
 * to swing by 1 % */
static lab_diagnosis *with_mean(double mean, fitted *f)
{
    static char path[200];
    const char *data[SWINGS + 1] = {NULL};
    unsigned long long seed = 4711;
    snprintf(path, sizeof path, "%s", in_folder("friction.yaml"));
    with_line(path, "    damping:",
              "    damping: 1.5e-4 N m s/rad\n    coulomb: {T: 2 mN m, w: 0.05 rad/s}\n");
    for (int i = 0; i < SWINGS; i++) {
        char friction[60];
        snprintf(friction, sizeof friction, "rod.coulomb.T=%.9g mN m",
                 2.0 * mean * (1.0 + 0.01 * gauss(&seed)));
        const char *const truth[] = {friction, NULL};
        data[i] = film_swing(i, path, truth, 900);
    }
    open_fit(f, path, NULL, data);
    lab_options options = cache_here(NULL);
    lab_diagnose_def def = lab_diagnose_def_default();
    unsigned char held_out[SWINGS] = {0, 1, 0, 0, 1, 0, 0, 1, 0};
    def.held_out = held_out;
    def.options = &options;
    lab_diagnosis *d = NULL;
    ck_assert_stein(lab_diagnose(&d, path, f->model, f->data, &def, err));
    printf("friction %.2f of the file's: %s\n", mean, d->reason);
    return d;
}

START_TEST(the_mean_of_what_differs_by_itself_is_asked)
{
    fitted f;
    lab_diagnosis *d = with_mean(1.0, &f); // it differs, and that is all
    ck_assert_int_eq(d->verdict, LAB_VERDICT_EXPLAINED);
    lab_diagnosis_destroy(d);
    drop(&f);
    d = with_mean(1.15, &f); // every swing could have its own, but all are high
    ck_assert_int_eq(d->verdict, LAB_VERDICT_MISSING_EFFECT);
    ck_assert_str_eq(d->suspect[0].candidate.effect->kind, "coulomb_friction");
    ck_assert_double_eq_tol(d->suspect[0].number[0].value, 0.15 * 2e-3, 0.03 * 2e-3);
    ck_assert_double_lt(d->gain.ratio, 1.01); // the swings are predicted as well by their own ones
    lab_diagnosis_destroy(d);
    drop(&f);
}
END_TEST

START_TEST(a_number_far_out_of_its_tolerance_is_told_though_the_fit_has_moved_it)
{
    static const char *const inside[] = {"rod.damping=2.2 mN m s/rad", NULL};
    static const char *const outside[] = {"rod.damping=2.36 mN m s/rad", NULL};
    fitted f;
    char *model = lab__text("%s", in_folder("tolerance.yaml"));
    with_line(model, "    damping:", "    damping: 2 mN m s/rad +- 5 %\n");
    lab_diagnosis *d = diagnose(&f, model, inside, 1300); // by two
    ck_assert_int_eq(d->verdict, LAB_VERDICT_EXPLAINED);
    lab_diagnosis_destroy(d);
    drop(&f);
    d = diagnose(&f, model, outside, 1300); // by more than three: nothing is left but a long way
    ck_assert_double_lt(d->chi2_dof_before, 1.1);
    ck_assert_int_eq(d->ncause, 1);
    // a heavier rod is damped less, a lighter one more: the mass is a twin
    const char *kind = d->suspect[0].candidate.effect->kind;
    ck_assert(strcmp(kind, "viscous_friction") == 0 || strcmp(kind, "mass") == 0);
    lab_diagnosis_destroy(d);
    drop(&f);
    free(model);
}
END_TEST

/* friction that is missing is damping that is not there: the fit takes the damping far out of its
 * tolerance. Friction leads where that is believed, and the null fit is as it was. */
START_TEST(what_a_strained_fit_lacks_leads_where_its_numbers_are_believed)
{
    static const char *const truth[] = {"rod.damping=2 mN m s/rad", "rod.coulomb.T=1 mN m", NULL};
    static const char *name[] = {"rod.damping"};
    fitted f;
    char *model = lab__text("%s", in_folder("strained.yaml"));
    with_line(model, "    damping:", "    damping: 2 mN m s/rad +- 3 %\n");
    open_swings(&f, model, truth, 1500);
    lab_options options = cache_here(NULL);
    lab_diagnosis out = {.nfit = SWINGS};
    lab_diagnose_def def = lab_diagnose_def_default();
    def.options = &options;
    diag d = {.file = model,
              .model = f.model,
              .def = &def,
              .fit_data = f.data,
              .held_data = f.data,
              .out = &out};
    d.name = name;
    d.nname = 1;
    d.fit_def = lab_fit_def_default();
    d.fit_def.free = name;
    d.fit_def.nfree = 1;
    ck_assert_stein(diag__open_problem(&d, err));
    d.p.tolerance = 1e-9;
    ck_assert_stein(diag__suspects(&d, err));
    ck_assert_stein(diag__pursue(&d, err));
    ck_assert_stein(diag__changes(&d, err));
    ck_assert_stein(diag__rank(&d, err));
    ck_assert_int_eq(diag__is_strained(&d), 1);
    double x = d.x[0], objective = d.null_objective, limit = d.p.limit, shown = 0.0;
    ck_assert_stein(diag__look_believing(&d, err));
    ck_assert(d.x[0] == x && d.null_objective == objective && d.p.limit == limit);
    ck_assert_double_gt(x, 2.0); // tolerances
    int early = 0;
    for (int i = 0; i < d.n; i++) {
        const diag__suspect *s = &d.suspect[i];
        early += isfinite(s->early);
        if (strcmp(s->s.candidate.effect->kind, "coulomb_friction") == 0) {
            ck_assert_int_lt(i, 3);
            shown = s->early * s->s.candidate.limit;
        }
    }
    printf("strained by %.1f tolerances: %d lead, friction of %.4f mN m is one of them\n", x, early,
           1e3 * shown);
    ck_assert(early >= 1 && early <= 6);
    ck_assert_double_eq_tol(shown, 1e-3, 0.05e-3);
    diag__close(&d);
    drop(&f);
    free(model);
}
END_TEST

START_TEST(a_step_that_is_too_coarse_is_told_and_is_no_physics)
{
    static const char *const truth[] = {"rod.coulomb.T=0 N m", NULL};
    for (int coarse = 0; coarse < 2; coarse++) {
        fitted f;
        int told = 0;
        char *model = lab__text("%s", in_folder("stepped.yaml"));
        with_line(model, "simulation:",
                  coarse ? "simulation: {dt: 300 ms, until: 10 s}\n"
                         : "simulation: {dt: 10 ms, until: 10 s}\n");
        lab_diagnosis *d = diagnose(&f, model, truth, 900);
        ck_assert_int_eq(d->verdict, LAB_VERDICT_EXPLAINED);
        for (int i = 0; i < d->nfinding; i++) {
            told += strstr(d->finding[i], "too coarse") != NULL;
        }
        ck_assert_int_eq(told, coarse);
        lab_diagnosis_destroy(d);
        drop(&f);
        free(model);
    }
}
END_TEST

/* what the swings' own numbers have led to */
static double objective(fit__problem *p, const double *x, double *r)
{
    int failed = 0;
    ck_assert_stein(fit__residuals(p, x, r, &failed, err));
    ck_assert_int_eq(failed, 0);
    return fit__chi2(p, r) + fit__priors(p, x);
}

START_TEST(a_swing_that_a_fit_has_lost_is_called_back)
{
    static const char *const truth[] = {"rod.coulomb.T=0 N m", NULL};
    enum { LOST = 4 };
    fitted f;
    open_swings(&f, pendulum, truth, 1100);
    lab_diagnosis out = {.nfit = SWINGS};
    lab_diagnose_def def = lab_diagnose_def_default();
    diag d = {.model = f.model, .def = &def, .fit_data = f.data, .out = &out};
    d.fit_def = lab_fit_def_default();
    d.fit_def.offset = 1e-3;
    d.fit_def.scatter = 1;
    ck_assert_stein(diag__open_problem(&d, err));
    d.p.tolerance = 1e-9;
    ck_assert_stein(diag__pursue(&d, err));
    double settled = objective(&d.p, d.x, d.r);
    fit__end e = {.x = d.x, .J = d.J, .r = d.r};
    int found = -1;
    ck_assert_stein(diag__recall_strays(&d, &d.p, &e, 1, &found, err));
    ck_assert_int_eq(found, 0); // nobody is lost

    const fit__stroke *t = &d.p.stroke[LOST];
    int k = t->first;
    while (k < t->first + t->own && d.p.unknown[k].kind != FIT__OFFSET) {
        k++;
    }
    ck_assert_int_lt(k, t->first + t->own);
    double *own = &d.x[k], kept = *own;
    *own += 5.0;
    double lost = objective(&d.p, d.x, d.r);
    ck_assert_double_gt(lost, settled + 500.0);
    ck_assert_stein(diag__recall_strays(&d, &d.p, &e, 0, &found, err));
    ck_assert_int_eq(found, 1);
    ck_assert_double_lt(fabs(*own - kept), 1.0);
    ck_assert_double_lt(objective(&d.p, d.x, d.r), settled + 10.0);

    // no misfit, as nothing was seen of it, but a number that nobody believes
    double *none = calloc((size_t)(t->nch * t->n), sizeof *none);
    d.p.stroke[LOST].weight = none;
    settled = objective(&d.p, d.x, d.r);
    ck_assert_int_eq(diag__has_bent(&d.p, d.x), 0);
    *own = 8.0;
    (void)objective(&d.p, d.x, d.r);
    ck_assert_int_eq(diag__has_bent(&d.p, d.x), 1);
    ck_assert_stein(diag__recall_strays(&d, &d.p, &e, 0, &found, err));
    ck_assert_int_eq(found, 0);
    ck_assert_stein(diag__recall_strays(&d, &d.p, &e, 1, &found, err));
    ck_assert_int_eq(found, 1);
    ck_assert_int_eq(diag__has_bent(&d.p, d.x), 0);
    ck_assert_double_lt(objective(&d.p, d.x, d.r), settled + 10.0);
    d.p.stroke[LOST].weight = NULL;
    free(none);
    diag__close(&d);
    drop(&f);
}
END_TEST

Suite *several_suite(void)
{
    Suite *suite = suite_create("several");
    TCase *tc = tcase_create("several");
    tcase_add_checked_fixture(tc, make_folder, remove_folder);
    tcase_set_timeout(tc, 600.0);
    tcase_add_test(tc, two_effects_at_once_are_both_found);
    tcase_add_test(tc, what_was_found_first_gives_way_to_what_does_better_beside_the_others);
    tcase_add_test(tc, a_part_is_found_beside_another_cause);
    tcase_add_test(tc, one_effect_is_not_called_two);
    tcase_add_loop_test(tc, of_two_channels_the_late_one_is_named, 0, 2);
    tcase_add_test(tc, the_mean_of_what_differs_by_itself_is_asked);
    tcase_add_test(tc, a_number_far_out_of_its_tolerance_is_told_though_the_fit_has_moved_it);
    tcase_add_test(tc, what_a_strained_fit_lacks_leads_where_its_numbers_are_believed);
    tcase_add_test(tc, a_step_that_is_too_coarse_is_told_and_is_no_physics);
    tcase_add_test(tc, a_swing_that_a_fit_has_lost_is_called_back);
    suite_add_tcase(suite, tc);
    return suite;
}
