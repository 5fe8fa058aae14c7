/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_search.c - diagnoses of the swings of a pendulum. An effect of a hundred noises is found; of
 * two effects hidden at once both are found, and one is not called two. Numbers out of their
 * tolerances are named. A step that is too coarse is reported, and is no physical effect. The
 * search ends where its budget does, reads no record that reports, and does not depend on how many
 * threads it has.
 */
#include <math.h>
#include <string.h>

#include "fit_support.h"
#include "search.h"
#include "stein/diagnose.h"
#include "added_parts.h"
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

/* one of the causes is that kind, and its number is right */
static void ck_assert_cause(const lab_diagnosis *d, const char *kind, double truth)
{
    for (int i = 0; i < d->ncause; i++) {
        const lab_suspect *s = &d->suspect[i];
        if (strcmp(s->candidate.effect->kind, kind) == 0) {
            const lab_cause_number *n = &s->number[0];
            printf("  %s %.4g (%.4g .. %.4g), true %.4g\n", kind, n->value, n->lo, n->hi, truth);
            ck_assert(fabs(n->value - truth) < 4.0 * n->sd);
            ck_assert(n->sd < 0.2 * fabs(truth));
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
    ck_assert_cause(d, "coulomb_friction", 2e-3);
    ck_assert_cause(d, "preload", 4e-3);
    ck_assert_double_lt(d->chi2_dof_after, 1.1);
    // and the file with both moves like that, which the diagnosis has checked itself
    ck_assert(d->verified.done && d->verified.same);
    ck_assert_double_lt(d->verified.file, 1.1);
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
START_TEST(the_first_cause_is_exchanged_for_a_better_one)
{
    static const char *const truth[] = {"rod.coulomb.T=2 mN m", "rod.drag=0.5 mN m s^2/rad^2",
                                        NULL};
    fitted f;
    lab_diagnosis *d = diagnose(&f, pendulum, truth, 1500);
    ck_assert_int_eq(d->ncause, 2);
    ck_assert_cause(d, "coulomb_friction", 2e-3);
    ck_assert_cause(d, "quadratic_drag", 0.5e-3);
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
    "    friction: {A: 0.3, vt: 5 mm/s}\n"
    "  dip:\n"
    "    between: [{point: key.below},\n"
    "      {line: {on: frame, at: [181 mm, 0, -17 mm], facing: 90 deg}}]\n"
    "    normal: {c: 12 kN/m, D: 5 s/m}\n"
    "    friction: {A: 0.3, vt: 5 mm/s}\n"
    "outputs: {key_dip: {point: key.front, read: z, sign: -1, zero: rest}}\n"
    "simulation: {dt: 20 us, until: 0.15 s}\n";

/* the lever with a felt on a board that gives way, in a separate file */
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

/* the group of what scatters with the friction of a contact */
static int group_of_contact(const lab_model *model, const char *name)
{
    const stein_model *m = lab_equations(model);
    int i = 0;
    while (strcmp(m->contacts[i].name, name) != 0) {
        i++;
    }
    return FIT__CONTACTS + FIT__GROUPS * (m->nq + i);
}

/* the same of a joint */
static int group_of_joint(const lab_model *model, const char *name)
{
    const stein_model *m = lab_equations(model);
    int i = 0;
    while (strcmp(m->bodies[i].name, name) != 0) {
        i++;
    }
    return FIT__JOINTS + FIT__GROUPS * i;
}

START_TEST(a_part_more_leaves_scatter_at_its_places)
{
    static const char *const contact[] = {"rest", "dip"};
    char file[200], board[200];
    lab_model *with = NULL, *without = NULL;
    lab_options options = cache_here(NULL);
    snprintf(file, sizeof file, "%s", write_file("lever.yaml", lever));
    on_a_board(board, file, 5e-6);
    ck_assert_stein(lab_open(&without, file, &options, err));
    ck_assert_stein(lab_open(&with, board, &options, err));
    fit__problem a = {.model = without, .places = 3}, b = {.model = with, .places = 4};
    for (int i = 0; i < 2; i++) {
        int in_a = group_of_contact(without, contact[i]);
        for (int k = 0; k < 2; k++) {
            int in_b = group_of_contact(with, contact[k]);
            ck_assert_int_eq(fit__same_group(&a, in_a, &b, in_b), i == k);
        }
        ck_assert(!fit__same_group(&a, in_a, &b, group_of_joint(with, "key")));
    }
    ck_assert(fit__same_group(&a, group_of_joint(without, "key"), &b, group_of_joint(with, "key")));
    ck_assert(fit__same_group(&a, FIT__DRIVE, &b, FIT__DRIVE));
    lab_close(with);
    lab_close(without);
}
END_TEST

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
    ck_assert_cause(d, "coulomb_friction", 3e-2);
    ck_assert_cause(d, "compliant_partner", compliance);
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
    ck_assert_cause(d, "coulomb_friction", 2e-3);
    lab_diagnosis_destroy(d);
    drop(&f);
}
END_TEST

/* Two channels of records with an unknown start, one of them late: the other one being early is the
 * same, and is no error of a sensor. */
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
    ck_assert_cause(d, "sensor_delay", 1e-3);
    ck_assert_int_eq(d->nrival, 0);
    lab_diagnosis_destroy(d);
    drop(&f);
}
END_TEST

/* the file with another line in the place of the line that begins so */
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

/* the diagnosis of swings with `mean` times the file's friction, which differs from swing to swing
 * by 1 % */
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

START_TEST(the_mean_of_scatter_is_tested)
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

START_TEST(a_number_far_out_of_its_tolerance_is_named_though_the_fit_has_moved_it)
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

START_TEST(a_step_that_is_too_coarse_is_reported_and_is_no_effect)
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

/* ---- gross effects ---- */

typedef struct gross {
    const char *truth, *kind;
    double amount;
} gross;
static const gross grosses[] = {{"rod.preload=60 mN m", "preload", 60e-3},
                                {"rod.coulomb.T=12 mN m", "coulomb_friction", 12e-3},
                                {"rod.spring.k=0.09 N m/rad", "joint_stiffness", 0.09}};
enum { GROSSES = sizeof grosses / sizeof *grosses };

/* without it the model leaves the swings within a second */
START_TEST(an_effect_of_a_hundred_noises_is_found)
{
    const gross *g = &grosses[_i];
    const char *const truth[] = {g->truth, NULL};
    fitted f;
    lab_diagnosis *d = diagnose(&f, pendulum, truth, 3100);
    ck_assert_double_gt(d->chi2_dof_before, 1e3);
    ck_assert_double_lt(d->chi2_dof_after, 1.1);
    ck_assert_int_eq(d->verdict, LAB_VERDICT_MISSING_EFFECT);
    ck_assert_int_eq(d->ncause, 1);
    ck_assert_cause(d, g->kind, g->amount);
    ck_assert_double_lt(d->gain.hi, 0.1);
    lab_diagnosis_destroy(d);
    drop(&f);
}
END_TEST

/* ---- the search by itself ---- */

enum { REPORTING = 3 };
static const unsigned char reports[SWINGS] = {0, 0, 1, 0, 1, 0, 0, 1, 0};

/* the diagnosis of the swings that f has open, with a trace */
static lab_diagnosis *traced(const fitted *f, int threads, long most_strokes, const char *trace)
{
    lab_options options = cache_here(NULL);
    lab_diagnose_def def = lab_diagnose_def_default();
    def.options = &options;
    def.threads = threads;
    def.held_out = reports;
    def.most_strokes = most_strokes;
    def.trace = trace;
    lab_diagnosis *d = NULL;
    ck_assert_stein(lab_diagnose(&d, pendulum, f->model, f->data, &def, err));
    return d;
}

/* a trace without how long its rows took; freed by the caller */
static char *rows_of(const char *path)
{
    static const char word[] = ",\"seconds\":";
    char *text = NULL;
    size_t size = 0;
    ck_assert_stein(lab__read_file(path, &text, &size, err));
    for (char *at = text; (at = strstr(at, word)) != NULL;) {
        char *end = at + strlen(word) + strcspn(at + strlen(word), ",}");
        memmove(at, end, strlen(end) + 1);
    }
    return text;
}

static int same_bits(double a, double b)
{
    return memcmp(&a, &b, sizeof a) == 0;
}

/* results of two diagnoses about the fitted records have the same bits */
static void ck_assert_same(const lab_diagnosis *a, const lab_diagnosis *b)
{
    ck_assert_int_eq(a->verdict, b->verdict);
    ck_assert_int_eq(a->ncause, b->ncause);
    ck_assert_int_eq(a->nrival, b->nrival);
    ck_assert_int_eq(a->nsuspect, b->nsuspect);
    ck_assert_int_eq(a->fits, b->fits);
    ck_assert(same_bits(a->chi2_dof_before, b->chi2_dof_before));
    ck_assert(same_bits(a->chi2_dof_after, b->chi2_dof_after));
    for (int i = 0; i < a->nsuspect; i++) {
        const lab_suspect *s = &a->suspect[i], *o = &b->suspect[i];
        ck_assert_str_eq(s->candidate.effect->kind, o->candidate.effect->kind);
        ck_assert_str_eq(s->candidate.place, o->candidate.place);
        ck_assert(same_bits(s->amount, o->amount) && same_bits(s->gain, o->gain));
        ck_assert(same_bits(s->power.sd, o->power.sd) && s->power.presence == o->power.presence);
        ck_assert_int_eq(s->nnumber, o->nnumber);
        for (int k = 0; k < s->nnumber; k++) {
            const lab_cause_number *n = &s->number[k], *m = &o->number[k];
            ck_assert(same_bits(n->value, m->value) && same_bits(n->sd, m->sd) &&
                      same_bits(n->lo, m->lo) && same_bits(n->hi, m->hi));
        }
    }
    ck_assert_int_eq(a->nvalue, b->nvalue);
    for (int i = 0; i < a->nvalue; i++) {
        ck_assert(same_bits(a->value[i].value, b->value[i].value));
        ck_assert(same_bits(a->value[i].sd, b->value[i].sd));
    }
}

static const char *const lossy[] = {"rod.coulomb.T=2 mN m", NULL};

/* swings with reporting records of another pendulum */
static void open_reporting(fitted *f, const char *const *elsewhere, unsigned long long seed)
{
    const char *data[SWINGS + 1] = {NULL};
    for (int i = 0; i < SWINGS; i++) {
        data[i] = reports[i] ? film_swing(i, pendulum, elsewhere, seed)
                             : film_swing(i, pendulum, lossy, 4100);
    }
    open_fit(f, pendulum, NULL, data);
}

/* the proposals of a trace are as many as it gives a fate; @return how many are tried */
static int ck_assert_counted(const char *trace)
{
    static const char word[] = "\"proposals\":", tried[] = "\"tried\":";
    int fits = 0;
    for (const char *at = trace; (at = strstr(at, word)) != NULL; at++) {
        int all = atoi(at + strlen(word)), sum = 0;
        const char *end = strchr(at, '}'), *is = strstr(at, tried);
        for (const char *c = at + strlen(word); (c = strchr(c, ':')) != NULL && c < end; c++) {
            sum += atoi(c + 1);
        }
        ck_assert_int_eq(all, sum);
        fits += is != NULL && is < end ? atoi(is + strlen(tried)) : 0;
    }
    return fits;
}

START_TEST(reporting_records_change_no_row_and_may_withdraw_a_cause)
{
    static const char *const other[] = {"rod.preload=80 mN m", "rod.drag=3 mN m s^2/rad^2", NULL};
    lab_diagnosis *d[2];
    char *rows[2];
    fitted f[2];
    open_reporting(&f[0], lossy, 4100);
    d[0] = traced(&f[0], 2, 0, in_folder("trace"));
    rows[0] = rows_of(in_folder("trace"));
    open_reporting(&f[1], other, 17);
    d[1] = traced(&f[1], 2, 0, in_folder("trace"));
    rows[1] = rows_of(in_folder("trace"));
    ck_assert_int_eq(d[0]->nheld, REPORTING);
    ck_assert_cause(d[0], "coulomb_friction", 2e-3);
    ck_assert_str_eq(rows[0], rows[1]);
    ck_assert_ptr_nonnull(strstr(rows[0], "\n{\"linearised\":"));
    ck_assert_int_gt(ck_assert_counted(rows[0]), 0);
    ck_assert_double_lt(d[0]->gain.hi, 0.9); // and they are read in the end
    ck_assert(!(d[1]->gain.ratio < 0.85));
    for (int i = 0; i < 2; i++) {
        free(rows[i]);
        lab_diagnosis_destroy(d[i]);
        drop(&f[i]);
    }
}
END_TEST

/* Strokes are counted row by row: a simulation more would show. */
START_TEST(a_search_simulates_no_record_that_reports)
{
    fitted f;
    open_reporting(&f, lossy, 4100);
    lab_diagnosis *d = traced(&f, 2, 0, in_folder("with.jsonl"));
    lab_diagnosis_destroy(d);
    char *with = rows_of(in_folder("with.jsonl"));

    lab_data *stroke[SWINGS];
    lab_dataset fit = {.n = 0, .stroke = stroke}; // those that report are not even there
    for (int i = 0; i < SWINGS; i++) {
        if (!reports[i]) {
            stroke[fit.n++] = f.data->stroke[i];
        }
    }
    lab_options options = cache_here(NULL);
    lab_diagnose_def def = lab_diagnose_def_default();
    def.options = &options;
    def.threads = 2;
    diag__problem q;
    diag__table t = {.n = 0};
    ck_assert_stein(diag__problem_open(&q, pendulum, f.model, &fit, &def, err));
    q.trace = fopen(in_folder("without.jsonl"), "w");
    ck_assert_ptr_nonnull(q.trace);
    ck_assert_stein(diag__search(&q, &t, err));
    ck_assert_int_eq(fclose(q.trace), 0);
    q.trace = NULL;
    char *without = rows_of(in_folder("without.jsonl"));
    ck_assert_str_eq(with, without);
    long strokes = 0;
    for (int i = 0; i < t.n; i++) {
        strokes += t.row[i]->strokes;
    }
    ck_assert_int_gt(strokes, 0);
    ck_assert_int_le(strokes, q.strokes);
    diag__table_free(&t);
    diag__problem_close(&q);
    free(with);
    free(without);
    drop(&f);
}
END_TEST

/* how far the hypothesis of one cause, or of none, follows the records [s] */
static double reach(diag__problem *q, const char *kind)
{
    diag__proposal p = {.h = {.n = 0}, .parent = -1, .amount = {0.1, NAN, NAN}};
    double until = NAN;
    for (int i = 0; kind != NULL && i < q->n; i++) {
        const lab_candidate *c = &q->candidate[i];
        if (strcmp(c->effect->kind, kind) == 0 && strcmp(c->place, "rod") == 0) {
            p.h = diag__with(p.h, i);
        }
    }
    p.side[0] = NAN;
    ck_assert_int_eq(p.h.n, kind != NULL);
    ck_assert_stein(diag__reach(q, &p, &until, err));
    printf("  %s: %g s\n", kind != NULL ? kind : "no cause", until);
    return until;
}

/* Forty seconds of a swing that friction slows down, and whose centre is 2 % lower than the file's:
 * without friction every fit loses the phase. */
START_TEST(a_missing_friction_follows_a_long_swing_furthest)
{
    static const char *const truth[] = {"rod.coulomb.T=6 mN m", "rod.centre.z=-177 mm",
                                        "rod.initial.position=140 deg", NULL};
    film m = {.model = pendulum,
              .truth = truth,
              .channels = "angle",
              .rate = 25.0,
              .until = 40.0,
              .noise = 1e-3,
              .silent = 1,
              .seed = 77};
    const char *data[] = {take("long.csv", &m), NULL};
    fitted f;
    open_fit(&f, pendulum, NULL, data);
    lab_options options = cache_here(NULL);
    lab_diagnose_def def = lab_diagnose_def_default();
    def.options = &options;
    diag__problem q;
    ck_assert_stein(diag__problem_open(&q, pendulum, f.model, f.data, &def, err));
    ck_assert(isinf(reach(&q, "coulomb_friction")));
    ck_assert_double_lt(reach(&q, NULL), 10.0);
    ck_assert_double_lt(reach(&q, "preload"), 10.0);
    ck_assert_double_lt(reach(&q, "hardening_spring"), 10.0);
    diag__problem_close(&q);
    drop(&f);
}
END_TEST

/* Eighty seconds from 120 deg of a pendulum that is damped more and swings 3.6 % more slowly than
 * its file says. A fit to all of it at once explains phases, and finds no viscous friction. */
START_TEST(a_long_swing_with_two_causes_is_searched_from_its_first_periods_on)
{
    static const char *const truth[] = {"rod.damping=9e-4 N m s/rad",
                                        "rod.pendulum.frequency=0.993 Hz",
                                        "rod.initial.position=120 deg", NULL};
    film m = {.model = pendulum,
              .truth = truth,
              .channels = "angle",
              .rate = 25.0,
              .until = 30.0,
              .noise = 2e-3,
              .silent = 1,
              .seed = 79};
    const char *data[] = {take("long.csv", &m), NULL};
    fitted f;
    open_fit(&f, pendulum, NULL, data);
    lab_options options = cache_here(NULL);
    lab_diagnose_def def = lab_diagnose_def_default();
    def.options = &options;
    lab_diagnosis *d = NULL;
    ck_assert_stein(lab_diagnose(&d, pendulum, f.model, f.data, &def, err));
    printf("thirty seconds: %s chi2/dof %.4g -> %.4g, %d fits\n", d->reason, d->chi2_dof_before,
           d->chi2_dof_after, d->fits);
    int viscous = 0;
    for (int i = 0; i < d->ncause; i++) {
        const lab_suspect *s = &d->suspect[i];
        viscous |= strcmp(s->candidate.effect->kind, "viscous_friction") == 0 &&
                   fabs(s->amount - 7.5e-4) < 0.75e-4;
    }
    ck_assert(viscous);
    ck_assert_double_lt(d->chi2_dof_after, 1.2);
    lab_diagnosis_destroy(d);
    drop(&f);
}
END_TEST

START_TEST(a_search_finds_the_same_on_any_number_of_threads)
{
    static const char *const truth[] = {"rod.coulomb.T=2 mN m", "rod.preload=4 mN m", NULL};
    lab_diagnosis *d[2];
    char *rows[2];
    fitted f;
    open_swings(&f, pendulum, truth, 500);
    for (int i = 0; i < 2; i++) {
        d[i] = traced(&f, 1 + i, 0, in_folder("trace"));
        rows[i] = rows_of(in_folder("trace"));
    }
    ck_assert_same(d[0], d[1]);
    ck_assert_str_eq(rows[0], rows[1]);
    ck_assert_int_eq(d[0]->strokes_simulated, d[1]->strokes_simulated);
    ck_assert(same_bits(d[0]->gain.ratio, d[1]->gain.ratio));
    for (int i = 0; i < 2; i++) {
        free(rows[i]);
        lab_diagnosis_destroy(d[i]);
    }
    drop(&f);
}
END_TEST

START_TEST(a_budget_ends_a_search_and_a_verdict_comes_all_the_same)
{
    fitted f;
    open_swings(&f, pendulum, lossy, 4100);
    lab_diagnosis *all = traced(&f, 2, 0, NULL), *few = traced(&f, 2, 1, NULL);
    printf("%d fits, %d strokes; with a budget of one stroke %d fits, %d strokes: %s\n", all->fits,
           all->strokes_simulated, few->fits, few->strokes_simulated, few->reason);
    ck_assert_cause(all, "coulomb_friction", 2e-3);
    ck_assert_int_eq(few->fits, 1);
    ck_assert_int_lt(few->strokes_simulated, all->strokes_simulated);
    ck_assert_int_ne(few->verdict, LAB_VERDICT_EXPLAINED);
    ck_assert_int_eq(few->ncause, 0);
    ck_assert_double_gt(few->chi2_dof_after, 1.1);
    lab_diagnosis_destroy(few);
    lab_diagnosis_destroy(all);
    drop(&f);
}
END_TEST

START_TEST(a_larger_budget_fits_no_fewer_hypotheses)
{
    static const long budget[] = {1, 400, 800, 1600, 0};
    static const char *const truth[] = {"rod.coulomb.T=2 mN m", "rod.preload=4 mN m", NULL};
    fitted f;
    int last = 0;
    open_swings(&f, pendulum, truth, 500);
    for (size_t i = 0; i < sizeof budget / sizeof *budget; i++) {
        lab_diagnosis *d = traced(&f, 2, budget[i], NULL);
        ck_assert_int_ge(d->fits, last);
        ck_assert_ptr_nonnull(lab_verdict_text(d->verdict));
        ck_assert_double_le(d->chi2_dof_after, d->chi2_dof_before);
        last = d->fits;
        lab_diagnosis_destroy(d);
    }
    ck_assert_int_ge(last, 2);
    drop(&f);
}
END_TEST

START_TEST(a_trace_that_cannot_be_opened_is_refused)
{
    fitted f;
    lab_diagnosis *d = NULL;
    lab_diagnose_def def = lab_diagnose_def_default();
    lab_options options = cache_here(NULL);
    open_swings(&f, pendulum, lossy, 4100);
    def.options = &options;
    def.trace = in_folder("nowhere/trace");
    stein_err why;
    ck_assert_int_eq(lab_diagnose(&d, pendulum, f.model, f.data, &def, &why), STEIN_EIO);
    ck_assert_ptr_nonnull(strstr(why.msg, "nowhere/trace"));
    ck_assert_ptr_null(d);
    drop(&f);
}
END_TEST

Suite *search_suite(void)
{
    Suite *suite = suite_create("search");
    TCase *tc = tcase_create("search");
    tcase_add_checked_fixture(tc, make_folder, remove_folder);
    tcase_set_timeout(tc, 600.0);
    tcase_add_test(tc, two_effects_at_once_are_both_found);
    tcase_add_test(tc, the_first_cause_is_exchanged_for_a_better_one);
    tcase_add_test(tc, a_part_more_leaves_scatter_at_its_places);
    tcase_add_test(tc, a_part_is_found_beside_another_cause);
    tcase_add_test(tc, one_effect_is_not_called_two);
    tcase_add_loop_test(tc, of_two_channels_the_late_one_is_named, 0, 2);
    tcase_add_test(tc, the_mean_of_scatter_is_tested);
    tcase_add_test(tc, a_number_far_out_of_its_tolerance_is_named_though_the_fit_has_moved_it);
    tcase_add_test(tc, a_step_that_is_too_coarse_is_reported_and_is_no_effect);
    suite_add_tcase(suite, tc);

    tc = tcase_create("gross");
    tcase_add_checked_fixture(tc, make_folder, remove_folder);
    tcase_set_timeout(tc, 600.0);
    tcase_add_loop_test(tc, an_effect_of_a_hundred_noises_is_found, 0, GROSSES);
    suite_add_tcase(suite, tc);

    tc = tcase_create("rules");
    tcase_add_checked_fixture(tc, make_folder, remove_folder);
    tcase_set_timeout(tc, 600.0);
    tcase_add_test(tc, reporting_records_change_no_row_and_may_withdraw_a_cause);
    tcase_add_test(tc, a_search_simulates_no_record_that_reports);
    tcase_add_test(tc, a_missing_friction_follows_a_long_swing_furthest);
    tcase_add_test(tc, a_long_swing_with_two_causes_is_searched_from_its_first_periods_on);
    tcase_add_test(tc, a_search_finds_the_same_on_any_number_of_threads);
    tcase_add_test(tc, a_budget_ends_a_search_and_a_verdict_comes_all_the_same);
    tcase_add_test(tc, a_larger_budget_fits_no_fewer_hypotheses);
    tcase_add_test(tc, a_trace_that_cannot_be_opened_is_refused);
    suite_add_tcase(suite, tc);
    return suite;
}
