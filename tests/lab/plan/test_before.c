/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_before.c - before anything is measured: statements of matrices written by hand; the
 * statements about a pendulum hold in a diagnosis of such records.
 */
#include <math.h>

#include "fit_support.h"
#include "planning.h"
#include "stein/plan.h"

Suite *before_suite(void);

static const char pendulum[] = "models/pendulum.yaml";

/* ---- matrices ---- */

/* (sqrt(25 + ln(1 + I)) + 1.645) / sqrt(I), (sqrt(9.2) + 1.645) / sqrt(I) by themselves */
static double named(double info)
{
    return (sqrt(25.0 + log(1.0 + info)) + 1.645) / sqrt(info);
}

static double excluded(double info)
{
    return (sqrt(9.2) + 1.645) / sqrt(info);
}

START_TEST(orthogonal_columns_are_separated_by_their_own_information)
{
    const double I[] = {400.0, 0.0, 0.0, 90.0};
    const int cause[] = {0, 1};
    double nameable[2], apart[4];
    plan__tell(I, 2, cause, 2, nameable, apart);
    ck_assert_close(nameable[0], named(400.0), 1e-14, 0.0);
    ck_assert_close(nameable[1], named(90.0), 1e-14, 0.0);
    ck_assert_close(apart[1], excluded(400.0), 1e-14, 0.0);
    ck_assert_close(apart[2], excluded(90.0), 1e-14, 0.0);
    ck_assert(apart[0] == 0.0 && apart[3] == 0.0);
}
END_TEST

START_TEST(equal_directions_are_not_separated_at_any_size)
{
    const double I[] = {400.0, 1200.0, 1200.0, 3600.0}; // the second is three times the first
    const int cause[] = {0, 1};
    double nameable[2], apart[4];
    plan__tell(I, 2, cause, 2, nameable, apart);
    ck_assert(isinf(apart[1]) && isinf(apart[2]));
    ck_assert_close(nameable[1], named(3600.0), 1e-14, 0.0);
}
END_TEST

START_TEST(the_part_that_another_cause_does_not_imitate_separates_them)
{
    const double rho = 0.83, I[] = {400.0, rho * 600.0, rho * 600.0, 900.0};
    const int cause[] = {0, 1};
    double nameable[2], apart[4];
    plan__tell(I, 2, cause, 2, nameable, apart);
    ck_assert_close(apart[1], excluded(400.0 * (1.0 - rho * rho)), 1e-12, 0.0);
    ck_assert_close(apart[2], excluded(900.0 * (1.0 - rho * rho)), 1e-12, 0.0);
}
END_TEST

START_TEST(any_column_of_a_cause_may_imitate_and_the_best_one_acts)
{
    // cause 1 has two columns: one at a right angle to cause 0, the other one along it
    const double I[] = {400.0, 0.0, 380.0, 0.0, 90.0, 0.0, 380.0, 0.0, 361.0};
    const int cause[] = {0, 1, 1};
    double nameable[3], apart[9];
    plan__tell(I, 3, cause, 3, nameable, apart);
    ck_assert(isinf(apart[1]));
    ck_assert_close(nameable[1], named(361.0), 1e-14, 0.0);
    ck_assert(isinf(nameable[2]) && isinf(apart[2 * 3 + 0])); // a cause without a column
}
END_TEST

/* ---- planned records ---- */

static lab_model *model;

static void open_pendulum(void)
{
    make_folder();
    cache_in_build();
    lab_options options = cache_here(NULL);
    ck_assert_stein(lab_open(&model, pendulum, &options, err));
}

static void close_pendulum(void)
{
    lab_close(model);
    remove_folder();
}

static stein_status asks(const char *records, const char *channel, const char *noise,
                         lab_before **out, stein_err *err)
{
    lab_options options = cache_here(NULL);
    const lab_before_def def = {.records = records,
                                .channel = &channel,
                                .nchannel = 1,
                                .noise = &noise,
                                .nnoise = noise != NULL,
                                .no_help = 1,
                                .threads = 1,
                                .options = &options};
    return lab_before_make(out, pendulum, model, &def, err);
}

START_TEST(errors_of_the_planned_records_are_reported)
{
    static const struct {
        const char *records, *channel, *noise, *said;
        stein_status status;
    } wrong[] = {
        {"", "angle", NULL, "records: none", STEIN_EINVAL},
        {"10 s", "angle", NULL, "expected [N x] TIME at RATE", STEIN_EINVAL},
        {"0 x 10 s at 50 Hz", "angle", NULL, "1 to 100 records", STEIN_EINVAL},
        {"10 s at 0.1 Hz", "angle", NULL, "expected 8 to", STEIN_EINVAL},
        {"10 kg at 50 Hz", "angle", NULL, "kg", STEIN_EINVAL},
        {"10 s at 50 Hz with rod.initial.position", "angle", NULL, "NAME=VALUE", STEIN_EINVAL},
        {"10 s at 50 Hz with rod.lenght=1 m", "angle", NULL, "rod.lenght", STEIN_ENAME},
        {"10 s at 50 Hz", "angel", NULL, "no output \"angel\"", STEIN_ENAME},
        {"10 s at 50 Hz", "angle", "tip_x=1 mm", "tip_x", STEIN_EINVAL},
        {"10 s at 50 Hz", "angle", "angle=0 rad", "positive", STEIN_EINVAL},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        lab_before *b = NULL;
        stein_err why = {STEIN_OK, ""};
        ck_assert_int_eq(asks(wrong[i].records, wrong[i].channel, wrong[i].noise, &b, &why),
                         wrong[i].status);
        ck_assert_msg(strstr(why.msg, wrong[i].said) != NULL, "%s", why.msg);
        ck_assert_ptr_null(b);
    }
}
END_TEST

static int index_of(const lab_before *b, const char *kind, const char *place)
{
    int k = 0;
    while (k < b->n && (strcmp(b->cause[k].candidate.effect->kind, kind) != 0 ||
                        strcmp(b->cause[k].candidate.place, place) != 0)) {
        k++;
    }
    ck_assert_msg(k < b->n, "%s at %s is no candidate", kind, place);
    return k;
}

static const char three[] = "2 x 8 s at 50 Hz; 8 s at 50 Hz with rod.initial.position=40 deg";

START_TEST(a_clock_is_not_separated_from_the_frequency_of_a_pendulum_and_frictions_are)
{
    lab_before *b = NULL;
    ck_assert_stein(asks(three, "angle", NULL, &b, err));
    int clock = index_of(b, "time_base", "clock"),
        frequency = index_of(b, "wrong_parameter", "rod.pendulum.frequency"),
        viscous = index_of(b, "viscous_friction", "rod"),
        drag = index_of(b, "quadratic_drag", "rod"), gain = index_of(b, "sensor_gain", "rate");
    ck_assert_int_eq(b->records, 3);
    ck_assert(b->cause[clock].named && b->cause[frequency].named && b->cause[viscous].named);
    ck_assert(!lab_before_told(b, clock, frequency));
    ck_assert(lab_before_told(b, clock, viscous) && lab_before_told(b, viscous, drag));
    ck_assert_str_eq(b->cause[gain].why, "the channel was not measured");
    ck_assert(isnan(b->cause[gain].nameable));
    lab_before_destroy(b);
}
END_TEST

START_TEST(more_noise_needs_larger_causes_in_proportion)
{
    lab_before *fine = NULL, *coarse = NULL;
    ck_assert_stein(asks(three, "angle", "angle=1 mrad", &fine, err));
    ck_assert_stein(asks(three, "angle", "angle=4 mrad", &coarse, err));
    double a = fine->cause[index_of(fine, "sensor_gain", "angle")].nameable,
           b = coarse->cause[index_of(coarse, "sensor_gain", "angle")].nameable;
    printf("  a gain is named from %.3g on, from %.3g on at four times the noise\n", a, b);
    ck_assert_close(b / a, 4.0, 0.1, 0.0); // the logarithm in the threshold: a few percent
    a = fine->cause[index_of(fine, "viscous_friction", "rod")].nameable;
    b = coarse->cause[index_of(coarse, "viscous_friction", "rod")].nameable;
    ck_assert(b > a && b < 1.2 * a); // scatter from record to record is what limits a friction
    lab_before_destroy(fine);
    lab_before_destroy(coarse);
}
END_TEST

/* does a diagnosis of six records with this much of a candidate name it, or a set that
 * has it? @param alone  without what could stand in a cause's place */
static int is_named(const lab_candidate *c, double amount, unsigned long long seed, int alone)
{
    static const char *const start[] = {"rod.initial.position=40 deg", NULL};
    const stein_param *p = &lab_equations(model)->params[c->param[0]];
    char truth[64], path[6][200];
    const char *of[] = {truth, NULL}, *file[7] = {NULL};
    snprintf(truth, sizeof truth, "%s=%.17g", p->name, p->value + amount);
    for (int i = 0; i < 6; i++) {
        char name[32];
        film m = {.model = pendulum,
                  .truth = of,
                  .told = i % 2 == 1 ? start : NULL,
                  .channels = "angle",
                  .rate = 50.0,
                  .until = 8.0,
                  .noise = 1e-3,
                  .seed = seed + (unsigned long long)i};
        snprintf(name, sizeof name, "swing%d.csv", i);
        snprintf(path[i], sizeof path[i], "%s", take(name, &m));
        file[i] = path[i];
    }
    fitted f;
    lab_diagnosis *d = NULL;
    lab_options options = cache_here(NULL);
    lab_diagnose_def def = lab_diagnose_def_default();
    def.options = &options;
    open_fit(&f, pendulum, NULL, file);
    ck_assert_stein(lab_diagnose(&d, pendulum, f.model, f.data, &def, err));
    printf("  %s = %.3g: %s\n", p->name, p->value + amount, d->reason);
    int yes = 0;
    for (int i = 0; d->ncause > 0 && i < d->ncause + (alone ? 0 : d->nrival); i++) {
        const lab_candidate *s = &d->suspect[i].candidate;
        yes |= s->effect == c->effect && strcmp(s->place, c->place) == 0;
    }
    lab_diagnosis_destroy(d);
    drop(&f);
    return yes;
}

START_TEST(a_diagnosis_names_a_nameable_amount_and_not_a_far_smaller_one)
{
    static const char *const kind[] = {"preload", "viscous_friction"};
    static const char six[] = "8 s at 50 Hz; 8 s at 50 Hz with rod.initial.position=40 deg;"
                              "8 s at 50 Hz; 8 s at 50 Hz with rod.initial.position=40 deg;"
                              "8 s at 50 Hz; 8 s at 50 Hz with rod.initial.position=40 deg";
    lab_before *b = NULL;
    ck_assert_stein(asks(six, "angle", "angle=1 mrad", &b, err));
    for (unsigned k = 0; k < 2; k++) {
        const lab_before_cause *c = &b->cause[index_of(b, kind[k], "rod")];
        ck_assert(is_named(&c->candidate, 1.3 * c->nameable, 11, 0));
        ck_assert(!is_named(&c->candidate, 0.3 * c->nameable, 21, 1));
    }
    lab_before_destroy(b);
}
END_TEST

START_TEST(another_start_or_another_channel_helps)
{
    const char *channel = "angle";
    lab_options options = cache_here(NULL);
    const lab_before_def def = {.records = "2 x 8 s at 50 Hz",
                                .channel = &channel,
                                .nchannel = 1,
                                .threads = 2,
                                .options = &options};
    lab_before *b = NULL;
    int marker = 0, start = 0;
    ck_assert_stein(lab_before_make(&b, pendulum, model, &def, err));
    for (int i = 0; i < b->nhelp; i++) {
        const lab_before_help *h = &b->help[i];
        marker |= strncmp(h->name, "tip_x measured", 14) == 0 && h->cost == 4.0 && h->told > 0;
        start |= strstr(h->name, "rod.initial.position") != NULL && h->told > 0;
        ck_assert(i == 0 ||
                  (h[-1].named + h[-1].told) / h[-1].cost >= (h->named + h->told) / h->cost);
    }
    ck_assert(marker && start);
    const char *path = in_folder("plan.json");
    char *text = NULL;
    size_t size = 0;
    ck_assert_stein(lab_before_json(path, b, err));
    ck_assert_stein(lab__read_file(path, &text, &size, err));
    ck_assert_ptr_nonnull(strstr(text, "\"experiment\": \"tip_x measured, too\""));
    ck_assert_ptr_nonnull(strstr(text, "\"below\": "));
    free(text);
    lab_before_destroy(b);
}
END_TEST

Suite *before_suite(void)
{
    Suite *s = suite_create("before");
    TCase *tc = tcase_create("matrices");
    tcase_add_test(tc, orthogonal_columns_are_separated_by_their_own_information);
    tcase_add_test(tc, equal_directions_are_not_separated_at_any_size);
    tcase_add_test(tc, the_part_that_another_cause_does_not_imitate_separates_them);
    tcase_add_test(tc, any_column_of_a_cause_may_imitate_and_the_best_one_acts);
    suite_add_tcase(s, tc);
    tc = tcase_create("records");
    tcase_add_checked_fixture(tc, open_pendulum, close_pendulum);
    tcase_set_timeout(tc, 60.0);
    tcase_add_test(tc, errors_of_the_planned_records_are_reported);
    tcase_add_test(tc, a_clock_is_not_separated_from_the_frequency_of_a_pendulum_and_frictions_are);
    tcase_add_test(tc, more_noise_needs_larger_causes_in_proportion);
    tcase_add_test(tc, a_diagnosis_names_a_nameable_amount_and_not_a_far_smaller_one);
    tcase_add_test(tc, another_start_or_another_channel_helps);
    suite_add_tcase(s, tc);
    return s;
}
