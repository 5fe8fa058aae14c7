/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_outside.c - the laws that are in no table of effects (tests/reality/outside.c). They agree
 * with their formulas, they are no sum of effects of the table, and the sealed answer has them in
 * the range of the strokes. Requested strokes are made in the same world.
 */
#include <gsl/gsl_multifit.h>

#include "reality_support.h"
#include "stein/law.h"

enum { POINTS = 64, MOST = 200 };

/* number k of a list of the answer's law */
static int law_list(const char *answer, const char *key, double *to)
{
    char quoted[40];
    int n = 0;
    snprintf(quoted, sizeof quoted, "\"%s\": [", key);
    const char *at = strstr(answer, "\"law_curve\"");
    at = at != NULL ? strstr(at, quoted) : NULL;
    ck_assert_msg(at != NULL, "no %s of the law in the answer", key);
    for (at += strlen(quoted); n < MOST && *at != ']'; n++) {
        char *end;
        to[n] = strtod(at, &end);
        ck_assert(end > at);
        at = end + strspn(end, ", ");
    }
    return n;
}

/* ---- the same as a table of the core ---- */

typedef struct hidden {
    double size, first, second; /* as --stroke prints them */
} hidden;

static double bump(const hidden *h, double q)
{
    double u = (q - h->first) / h->second;
    return h->size * exp(-u * u);
}

static double hump(const hidden *h, double x)
{
    double u = x / h->first;
    return h->size * u * u * u * u * exp(2.0 - 2.0 * u * u);
}

static hidden strike(const char *kind, const char *place, double amount, const char *csv)
{
    hidden h;
    ck_assert_int_eq(run("--stroke --dx -0.3 --kind %s --place %s --amount %g -o %s", kind, place,
                         amount, in_folder(csv)),
                     0);
    char *said = read_all(in_folder("said"));
    ck_assert_int_eq(sscanf(said, "%lf %lf %lf", &h.size, &h.first, &h.second), 3);
    free(said);
    return h;
}

/* the action with the law as a table of many points */
static stein_sim *with_table(lab_model **model, const char *head, const char *what,
                             double (*law)(const hidden *, double), const hidden *h, double lo,
                             double hi)
{
    char *text = read_all(model_file);
    FILE *f = fopen(in_folder("law.yaml"), "w");
    ck_assert_ptr_nonnull(f);
    fprintf(f, "%s\ntables:\n  law: {%s, at: [", text, head);
    for (int i = 0; i < POINTS; i++) {
        fprintf(f, "%s%.12g", i > 0 ? ", " : "", lo + (hi - lo) * i / (POINTS - 1));
    }
    fprintf(f, "], %s: [", what);
    for (int i = 0; i < POINTS; i++) {
        fprintf(f, "%s%.12g", i > 0 ? ", " : "", law(h, lo + (hi - lo) * i / (POINTS - 1)));
    }
    fprintf(f, "]}\n");
    ck_assert_int_eq(fclose(f), 0);
    free(text);
    stein_sim *sim = NULL;
    ck_assert_stein(lab_open(model, in_folder("law.yaml"), NULL, err));
    ck_assert_stein(lab_sim(*model, NULL, &sim, err));
    ck_assert_stein(stein_set(sim, "pawl.stop_shift", -0.3e-3, err));
    ck_assert_stein(stein_reset(sim, err));
    return sim;
}

START_TEST(state_laws_are_tables_of_the_core)
{
    lab_model *model = NULL;
    hidden h = strike("torque_bump", "hammer", 0.3, "a.csv");
    read_table(&film, in_folder("a.csv"));
    stein_sim *sim = with_table(&model, "joint: hammer, of: position", "torque", bump, &h,
                                h.first - 4.0 * h.second, h.first + 4.0 * h.second);
    compare(sim, "a bump of torque");
    stein_sim_destroy(sim);
    lab_close(model);
    h = strike("felt_hump", "dip", 0.2, "a.csv");
    read_table(&film, in_folder("a.csv"));
    sim = with_table(&model, "contact: dip, of: depth", "force", hump, &h, 0.0, 3.0 * h.first);
    compare(sim, "a hump of force");
    stein_sim_destroy(sim);
    lab_close(model);
}
END_TEST

/* ---- a memory ---- */

/* the dip felt of the core with the memory beside it: m from event to event in closed form */
typedef struct felt {
    const stein_sim *sim;
    int dip, touching;
    double share, time, since, memory; /* memory at the last event */
    double normal[STEIN_NORMAL_SIZE], friction[STEIN_FRICTION_SIZE], below[2];
} felt;

static double memory_at(const felt *f, double t)
{
    double left = exp(-(t - f->since) / f->time);
    return f->touching ? 1.0 - (1.0 - f->memory) * left : f->memory * left;
}

static void remember(void *ctx, stein_sim *sim, const stein_event *event)
{
    felt *f = ctx;
    int begin = event->kind == STEIN_EVENT_CONTACT_BEGIN;
    (void)sim;
    if (event->index == f->dip && (begin || event->kind == STEIN_EVENT_CONTACT_END)) {
        f->memory = memory_at(f, event->time);
        f->since = event->time;
        f->touching = begin;
    }
}

/* what the felt does not carry any more: virtual work of its normal force and friction */
static void relax(void *ctx, double t, const double *q, const double *qd, double *Q)
{
    const felt *f = ctx;
    double x, xdot;
    if (!f->touching || !stein_deformation(f->sim, f->dip, &x, &xdot)) {
        return;
    }
    double N = f->share * memory_at(f, t) * stein_normal_force(f->normal, x, xdot);
    double c = cos(-q[0]), s = sin(-q[0]);
    double X = f->below[0] * c - f->below[1] * s, Z = f->below[0] * s + f->below[1] * c;
    Q[0] += X * N + Z * N * stein_friction(f->friction, Z * qd[0]);
}

static double value_of(const stein_sim *sim, const char *name)
{
    double value = 0.0;
    ck_assert_stein(stein_get(sim, name, &value, err));
    return value;
}

START_TEST(a_relaxing_felt_is_the_same_in_the_core)
{
    static const char *const normal[] = {"a", "b", "c", "D"}; // as the block begins
    stein_sim *sim = make_sim(&stein_model_stein1788, STEIN_RK4, 0.0);
    strike("relaxing_contact", "dip", 0.0, "none.csv");
    hidden h = strike("relaxing_contact", "dip", 0.4, "some.csv");
    felt f = {.sim = sim, .share = h.size, .time = h.first};
    f.dip = stein_find_contact(&stein_model_stein1788, "dip");
    ck_assert_int_ge(f.dip, 0);
    for (int i = 1; i < 4; i++) {
        char name[40];
        snprintf(name, sizeof name, "dip.normal.%s", normal[i]);
        f.normal[i] = value_of(sim, name);
    }
    f.friction[0] = value_of(sim, "dip.friction.A");
    f.friction[1] = value_of(sim, "dip.friction.vt");
    f.below[0] = value_of(sim, "key.below.x");
    f.below[1] = value_of(sim, "key.below.z");
    ck_assert_stein(stein_set(sim, "pawl.stop_shift", -0.3e-3, err));
    ck_assert_stein(stein_reset(sim, err));
    stein_on_event(sim, remember, &f);
    stein_on_force(sim, relax, &f);
    read_table(&film, in_folder("none.csv"));
    read_table(&other, in_folder("some.csv"));
    double off = 0.0, size = 0.0, early = 0.0;
    for (int i = 0; i < other.rows; i++) {
        double dip = 0.0, change = fabs(other.cell[i][2] - film.cell[i][2]);
        ck_assert_stein(stein_run(sim, other.cell[i][0], err));
        ck_assert_stein(stein_read_name(sim, "key_dip", &dip, err));
        off = fmax(off, fabs(dip - other.cell[i][2]));
        size = fmax(size, change);
        early = f.since > 0.0 ? early : fmax(early, change);
    }
    printf("a felt that relaxes by %.0f %% in %.1f ms: %.1e m at the dip, %.1e m before it is "
           "touched; core against reality %.1e m\n",
           100.0 * h.size, 1e3 * h.first, size, early, off);
    stein_sim_destroy(sim);
    ck_assert_double_gt(size, 5e-5);
    ck_assert_double_le(early, 1e-8);
    ck_assert_double_le(off, 1e-6);
}
END_TEST

/* ---- no sum of what the table has ---- */

typedef double base_fn(double x, double range, int k);

/* over a joint's position: preload, spring, hardening spring */
static double of_joint(double q, double range, int k)
{
    double u = q / range;
    return k == 0 ? 1.0 : k == 1 ? u : u * u * u;
}

/* over the depth: the polynomial's terms, the exponent's change */
static double of_felt(double x, double range, int k)
{
    double u = fmax(x / range, 1e-9);
    return k < 3 ? pow(u, k + 1) : u * log(u);
}

/* share of the law (rms) that no sum of n functions explains */
static double left_over(const double *at, const double *value, int m, base_fn *base, int n)
{
    gsl_matrix *X = gsl_matrix_alloc((size_t)m, (size_t)n);
    gsl_matrix *cov = gsl_matrix_alloc((size_t)n, (size_t)n);
    gsl_vector *y = gsl_vector_alloc((size_t)m), *c = gsl_vector_alloc((size_t)n);
    gsl_multifit_linear_workspace *w = gsl_multifit_linear_alloc((size_t)m, (size_t)n);
    double chi2 = 0.0, all = 0.0;
    for (int i = 0; i < m; i++) {
        gsl_vector_set(y, (size_t)i, value[i]);
        all += value[i] * value[i];
        for (int k = 0; k < n; k++) {
            gsl_matrix_set(X, (size_t)i, (size_t)k, base(at[i], at[m - 1], k));
        }
    }
    ck_assert_int_eq(gsl_multifit_linear(X, y, c, cov, &chi2, w), 0);
    gsl_multifit_linear_free(w);
    gsl_matrix_free(X);
    gsl_matrix_free(cov);
    gsl_vector_free(y);
    gsl_vector_free(c);
    return sqrt(chi2 / all);
}

/* @return share of the law in the answer that no sum of the table's laws explains */
static double outsideness(const char *kind, const char *place, int seed, base_fn *base, int n)
{
    double at[MOST], value[MOST];
    ck_assert_int_eq(run("--seed %d --clean --kind %s --place %s --amount 0.02 -o %s", seed, kind,
                         place, in_folder("set")),
                     0);
    char *answer = read_all(in_folder("set/answer.json"));
    int m = law_list(answer, "at", at);
    ck_assert_int_eq(law_list(answer, "value", value), m);
    ck_assert_int_gt(m, 100);
    ck_assert_ptr_nonnull(strstr(answer, "\"class\": \"unknown_effect\""));
    free(answer);
    return left_over(at, value, m, base, n);
}

START_TEST(no_sum_of_known_laws_is_one_of_these)
{
    static const char *const joint[] = {"key", "hammer", "pawl"};
    static const char *const felts[] = {"dip", "loops", "string", "stop"};
    for (int i = 0; i < 3; i++) { // preload, both springs
        double left = outsideness("torque_bump", joint[i], 41 + i, of_joint, 3);
        printf("bump at %s: %.0f %% is no preload and no spring\n", joint[i], 100.0 * left);
        ck_assert_double_gt(left, 0.35);
    }
    for (int i = 0; i < 4; i++) { // stiffnesses, gap, exponent
        double left = outsideness("felt_hump", felts[i], 41 + i, of_felt, 4);
        printf("hump at %s: %.0f %% is no polynomial and no exponent\n", felts[i], 100.0 * left);
        ck_assert_double_gt(left, 0.15);
    }
}
END_TEST

/* ---- requested strokes ---- */

/* mean of a column over the last hundred frames, less that before the release */
static double travel(const char *path, int column)
{
    double sum[2] = {0.0, 0.0};
    int n[2] = {0, 0};
    read_table(&film, path);
    for (int i = 0; i < film.rows; i++) {
        double x = film.cell[i][column], t = film.cell[i][0];
        int k = t < -1e-3 ? 0 : i >= film.rows - 100 ? 1 : -1;
        if (k >= 0 && !isnan(x)) {
            sum[k] += x;
            n[k]++;
        }
    }
    return sum[1] / n[1] - sum[0] / n[0];
}

START_TEST(further_strokes_are_made_in_the_same_world)
{
    static const char set[] = "--seed 51 --clean --kind viscous_friction --place key --amount 0.3";
    ck_assert_int_eq(run("%s -o %s", set, in_folder("set")), 0);
    ck_assert_int_eq(run("%s --next 2 --set pawl.stop_shift=-0.7e-3 --set load.mass=0.07 -o %s",
                         set, in_folder("next")),
                     0);
    double was = travel(in_folder("set/fit_01.csv"), 2);
    double is = travel(in_folder("next/next_02.csv"), 2);
    ck_assert_int_eq(access(in_folder("next/next_03.csv"), R_OK), -1);
    char *text = read_all(in_folder("next/next_01.csv"));
    ck_assert_ptr_nonnull(strstr(text, "# set pawl.stop_shift: -0.7 mm\n# set load.mass: 70 g\n"));
    free(text);
    // another load, a heavier hammer, no string; a key that is moved there and back
    ck_assert_int_eq(run("%s --next 1 --set load.mass=0.14 --set hammer.mass=4e-3 -o %s", set,
                         in_folder("next")),
                     0);
    double other_load = travel(in_folder("next/next_01.csv"), 2);
    text = read_all(in_folder("next/next_01.csv"));
    ck_assert_ptr_nonnull(strstr(text, "# set hammer.mass: 0.004 kg\n"));
    free(text);
    ck_assert_int_eq(run("%s --next 1 --drive key_motion,there_and_back,0.02,0.03 -o %s", set,
                         in_folder("next")),
                     0);
    double back = travel(in_folder("next/next_01.csv"), 2);
    ck_assert_int_eq(film.columns, 4);
    ck_assert_close(film.cell[film.rows - 1][3], film.cell[0][3], 1e-9, 1e-12);
    printf("dip in the end: %.4f mm, in a further stroke %.4f; 140 g %.4f; there and back %.4f\n",
           1e3 * was, 1e3 * is, 1e3 * other_load, 1e3 * back);
    ck_assert_double_le(fabs(was - is), 10e-6);
    ck_assert_double_gt(other_load - was, 50e-6);
    ck_assert_double_le(fabs(back), 10e-6);
}
END_TEST

START_TEST(an_instrument_that_the_laboratory_lacks_is_refused)
{
    static const char *const asked[] = {"--set hammer.colour=3",  "--set hammer.mass=heavy",
                                        "--drive pedal,rise,1,1", "--drive finger,swing,1,0.1",
                                        "--drive finger,rise,1",  "--drive finger,rise,1,0"};
    for (size_t i = 0; i < sizeof asked / sizeof *asked; i++) {
        ck_assert_int_eq(run("--null --seed 1 --next 1 %s -o %s", asked[i], in_folder("next")),
                         3 << 8);
        char *text = read_all(in_folder("messages"));
        ck_assert_ptr_nonnull(strstr(text, "cannot be filmed"));
        free(text);
    }
}
END_TEST

START_TEST(sets_of_twins_are_made_of_one_stroke)
{
    ck_assert_int_eq(run("--seed 61 --twins --kind preload --place hammer --amount 0.01 -o %s",
                         in_folder("set")),
                     0);
    char *first = read_all(in_folder("set/fit_01.csv"));
    size_t told = (size_t)(strstr(first, "# noise") - first);
    for (int i = 0; i < FIT + HELD; i++) {
        char name[40];
        snprintf(name, sizeof name, "set/%s_%02d.csv", i < FIT ? "fit" : "held",
                 i < FIT ? i + 1 : i - FIT + 1);
        char *text = read_all(in_folder(name));
        ck_assert_int_eq(strncmp(first, text, told), 0);
        ck_assert(i == 0 || strcmp(first, text) != 0);
        free(text);
    }
    free(first);
}
END_TEST

Suite *outside_suite(void)
{
    Suite *suite = suite_create("outside");
    TCase *tc = tcase_create("outside");
    tcase_set_timeout(tc, 300);
    tcase_add_unchecked_fixture(tc, cache_in_build, NULL);
    tcase_add_checked_fixture(tc, make_folder, remove_folder);
    tcase_add_test(tc, state_laws_are_tables_of_the_core);
    tcase_add_test(tc, a_relaxing_felt_is_the_same_in_the_core);
    tcase_add_test(tc, no_sum_of_known_laws_is_one_of_these);
    tcase_add_test(tc, further_strokes_are_made_in_the_same_world);
    tcase_add_test(tc, an_instrument_that_the_laboratory_lacks_is_refused);
    tcase_add_test(tc, sets_of_twins_are_made_of_one_stroke);
    suite_add_tcase(suite, tc);
    return suite;
}
