/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_fit.c - the fit finds the numbers in the data, with their uncertainty, and reports when it
 * does not.
 */
#include <signal.h>
#include <sys/wait.h>

#include "fit_support.h"

static const char pendulum[] = "models/pendulum.yaml";
static const char action[] = "models/stein1788.yaml";

/* ---- the small problem: a pendulum from two angles, 10 s ---- */

static const char *const swings_free[] = {"rod.pendulum.frequency", "rod.damping", NULL};
static const char *const swings_truth[] = {"rod.pendulum.frequency=1.1 Hz",
                                           "rod.damping=1.8e-4 N m s/rad", NULL};

static film swing(const char *const *truth, const char *const *told, unsigned long long seed)
{
    return (film){.model = pendulum,
                  .truth = truth,
                  .told = told,
                  .channels = "angle",
                  .rate = 17.0,
                  .until = 9.0,
                  .noise = 2e-3,
                  .seed = seed};
}

/* paths of two swings of so many seconds, closed by NULL */
static void swings(const char *data[3], const char *const *truth, unsigned long long seed,
                   double until)
{
    static const char *const small[] = {"rod.initial.position=20 deg", NULL};
    static const char *const large[] = {"rod.initial.position=43 deg", NULL};
    static char kept[2][200];
    film a = swing(truth, small, seed), b = swing(truth, large, seed + 1000);
    a.until = b.until = until;
    snprintf(kept[0], sizeof kept[0], "%s", take("small.csv", &a));
    snprintf(kept[1], sizeof kept[1], "%s", take("large.csv", &b));
    data[0] = kept[0];
    data[1] = kept[1];
    data[2] = NULL;
}

static void two_swings(const char *data[3], const char *const *truth, unsigned long long seed)
{
    swings(data, truth, seed, 9.0);
}

START_TEST(wrong_parameters_are_corrected_and_the_search_agrees_with_itself)
{
    const char *data[3];
    fitted f;
    two_swings(data, swings_truth, 1);
    open_fit(&f, pendulum, NULL, data);
    lab_fit_def def = free_these(swings_free);
    ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
    ck_assert_status(f.fit, LAB_FIT_CONVERGED);
    ck_assert_found(f.fit, "rod.pendulum.frequency", 1.1, 3.0);
    ck_assert_found(f.fit, "rod.damping", 1.8e-4, 3.0);
    ck_assert_int_eq(f.fit->npair, 0);
    ck_assert(f.fit->gradient < 1e-3 && f.fit->sensitivity_error < 1e-4);
    drop(&f);
}
END_TEST

/* short swings: coverage is a matter of how many there are, not of how long they take */
START_TEST(intervals_hold_the_truth_19_times_in_20)
{
    int inside = 0, repeats = soaks() > 0 ? 120 : 80;
    for (int i = 0; i < repeats; i++) {
        const char *data[3];
        fitted f;
        swings(data, swings_truth, 77 + (unsigned long long)i, 4.0);
        open_fit(&f, pendulum, NULL, data);
        lab_fit_def def = free_these(swings_free);
        def.starts = 1;
        ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
        const lab_fit_value *v = f.fit->value;
        inside += v[0].lo <= 1.1 && 1.1 <= v[0].hi;
        inside += v[1].lo <= 1.8e-4 && 1.8e-4 <= v[1].hi;
        drop(&f);
    }
    double share = inside / (2.0 * repeats);
    printf("intervals: %.1f %% of %d hold the truth\n", 100.0 * share, 2 * repeats);
    ck_assert_msg(share > 0.91 && share < 0.985, "%.3f", share); // 95 +- 1.4 % of 240
}
END_TEST

START_TEST(the_ladder_leads_out_of_a_false_minimum)
{
    static const char *const far[] = {"rod.pendulum.frequency=0.83 Hz", NULL};
    static const char *const names[] = {"rod.pendulum.frequency", NULL};
    const char *data[3];
    fitted f;
    two_swings(data, far, 5);
    open_fit(&f, pendulum, NULL, data);
    lab_fit_def def = free_these(names);
    def.starts = 1; // from the file, without ladder
    ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
    ck_assert_msg(f.fit->chi2_dof > 100.0, "no false minimum: chi2/dof %g", f.fit->chi2_dof);
    ck_assert_int_ne(f.fit->status, LAB_FIT_CONVERGED);
    lab_fit_destroy(f.fit);
    def.starts = 3;
    ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
    ck_assert_found(f.fit, "rod.pendulum.frequency", 0.83, 3.0);
    ck_assert_status(f.fit, LAB_FIT_CONVERGED);
    drop(&f);
}
END_TEST

/* all results of a fit about its free parameters, bit for bit */
static int is_same(const lab_fit *a, const lab_fit *b)
{
    int same = a->nvalue == b->nvalue && a->status == b->status && a->chi2 == b->chi2;
    for (int k = 0; same && k < a->nvalue; k++) {
        same = a->value[k].value == b->value[k].value && a->value[k].sd == b->value[k].sd;
    }
    return same;
}

START_TEST(searches_that_agree_need_no_ladder)
{
    static const char *const rubbed[] = {"rod.coulomb.T=2e-3 N m", NULL};
    const char *data[3];
    fitted f;
    two_swings(data, rubbed, 8); // a misfit: no residual is so small that it ends the search
    open_fit(&f, pendulum, NULL, data);
    lab_fit_def def = free_these(swings_free);
    ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
    lab_fit *with = f.fit;
    ck_assert_int_eq(with->nstart, def.starts);
    for (int i = 0; i < with->nstart; i++) {
        ck_assert(with->start[i].agrees);
    }
    def.ladder = 0;
    ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
    ck_assert(is_same(with, f.fit));
    lab_fit_destroy(with);
    drop(&f);
}
END_TEST

START_TEST(searches_that_disagree_are_not_called_converged)
{
    static const char *const far[] = {"rod.pendulum.frequency=0.83 Hz", NULL};
    static const char *const names[] = {"rod.pendulum.frequency", NULL};
    const char *data[3];
    fitted f;
    two_swings(data, far, 5);
    open_fit(&f, pendulum, NULL, data);
    lab_fit_def def = free_these(names);
    def.ladder = 0;
    def.starts = 5;
    ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
    ck_assert_status(f.fit, LAB_FIT_NOT_CONVERGED);
    ck_assert_ptr_nonnull(strstr(f.fit->reason, "searches"));
    drop(&f);
}
END_TEST

START_TEST(a_model_that_lacks_something_is_a_misfit)
{
    static const char *const rubbed[] = {"rod.coulomb.T=2e-3 N m", NULL};
    const char *data[3];
    fitted f;
    two_swings(data, rubbed, 8);
    open_fit(&f, pendulum, NULL, data);
    lab_fit_def def = free_these(swings_free);
    ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
    ck_assert_status(f.fit, LAB_FIT_MISFIT);
    drop(&f);
}
END_TEST

START_TEST(parameters_that_the_data_cannot_separate_are_named)
{
    // the angle depends only on damping over mass: the inertia comes from the frequency
    static const char *const names[] = {"rod.mass", "rod.damping", "rod.tip.x", NULL};
    static const char *const set[] = {"rod.mass=213 g +- 20 g", "rod.tip.x=1 mm", NULL};
    static const char *const profile[] = {"rod.damping"};
    const char *data[3];
    fitted f;
    two_swings(data, NULL, 9);
    open_fit(&f, pendulum, set, data);
    lab_fit_def def = free_these(names);
    def.profile = profile;
    def.nprofile = 1;
    ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
    ck_assert_int_eq(f.fit->npair, 1);
    ck_assert_int_eq(f.fit->pair[0].a, 0);
    ck_assert_int_eq(f.fit->pair[0].b, 1);
    ck_assert(f.fit->pair[0].correlation > 0.999);
    ck_assert_close(fabs(f.fit->weakest[0]), 0.95, 0.1,
                    0.0); // mostly the number with the narrower prior
    ck_assert(f.fit->value[2].unseen && !f.fit->value[0].unseen && !f.fit->value[1].unseen);
    ck_assert(isinf(f.fit->value[2].data_sd));
    // the prior of the mass bounds both: 20 g of 213 g are 9.4 %
    const lab_fit_value *v = value_of(f.fit, "rod.damping");
    ck_assert_close(v->sd / v->value, 20.0 / 213.0, 0.1, 0.0);
    ck_assert(v->profiled);
    ck_assert_close(v->profile_hi / v->profile_lo, v->hi / v->lo, 0.03, 0.0);
    drop(&f);
}
END_TEST

START_TEST(a_profile_without_end_is_open)
{
    static const char *const names[] = {"rod.mass", "rod.damping", NULL};
    static const char *const profile[] = {"rod.damping"};
    const char *data[3];
    fitted f;
    two_swings(data, NULL, 9);
    static const char *const set[] = {"rod.mass=213 g +- 1000 g", NULL};
    open_fit(&f, pendulum, set, data);
    lab_fit_def def = free_these(names);
    def.starts = 1;
    def.profile = profile;
    def.nprofile = 1;
    ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
    ck_assert(isinf(f.fit->value[1].profile_hi) && f.fit->value[1].profile_hi > 0.0);
    drop(&f);
}
END_TEST

START_TEST(single_bad_frames_get_little_weight)
{
    const char *data[3];
    fitted f;
    two_swings(data, swings_truth, 21);
    // every 25th sample is off by 50 noises
    FILE *from = fopen(data[0], "r"), *to = fopen(in_folder("spoilt.csv"), "w");
    char line[200];
    for (int i = 0; fgets(line, sizeof line, from) != NULL; i++) {
        double t, y;
        if (i % 25 == 20 && sscanf(line, "%lf,%lf", &t, &y) == 2) {
            fprintf(to, "%.17g,%.17g\n", t, y + 0.1);
        } else {
            fputs(line, to);
        }
    }
    fclose(from);
    fclose(to);
    char spoilt[200];
    snprintf(spoilt, sizeof spoilt, "%s", in_folder("spoilt.csv"));
    data[0] = spoilt;
    open_fit(&f, pendulum, NULL, data);
    lab_fit_def def = free_these(swings_free);
    ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
    ck_assert_status(f.fit, LAB_FIT_MISFIT);
    lab_fit_destroy(f.fit);
    def.robust = 1;
    ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
    ck_assert_status(f.fit, LAB_FIT_CONVERGED);
    ck_assert_found(f.fit, "rod.pendulum.frequency", 1.1, 3.0);
    ck_assert_found(f.fit, "rod.damping", 1.8e-4, 3.0);
    ck_assert_int_ge(f.fit->residual[0].downweighted, 5);
    ck_assert_int_le(f.fit->residual[1].downweighted, 4);
    drop(&f);
}
END_TEST

START_TEST(an_unstated_initial_state_is_found)
{
    static const char *const start[] = {"rod.pendulum.frequency=1.1 Hz",
                                        "rod.initial.position=0.44 rad",
                                        "rod.initial.speed=-0.7 rad/s", NULL};
    static const char *const names[] = {"rod.pendulum.frequency", NULL};
    film m = swing(start, NULL, 4);
    m.silent = 1;
    const char *data[] = {take("loose.csv", &m), NULL};
    fitted f;
    open_fit(&f, pendulum, NULL, data);
    lab_fit_def def = free_these(names);
    ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
    ck_assert_status(f.fit, LAB_FIT_CONVERGED);
    ck_assert_found(f.fit, "rod.pendulum.frequency", 1.1, 3.0);
    const lab_fit_stroke *s = &f.fit->stroke[0];
    ck_assert_str_eq(s->value[0].name, "initial position rod");
    ck_assert_close(s->value[0].value, 0.44 - acos(-1.0) / 6.0, 0.0, 4.0 * s->value[0].sd);
    ck_assert_close(s->value[1].value, -0.7, 0.0, 4.0 * s->value[1].sd);
    // the noise is not stated either: the residual did
    ck_assert(!f.fit->noise_given);
    ck_assert_close(f.fit->residual[0].noise, 2e-3, 0.15, 0.0);
    drop(&f);
}
END_TEST

/* ---- instruments with a wrong time ---- */

/* a swing at a height that is known, seen twice */
static film watched(unsigned long long seed)
{
    static const char *const height[] = {"rod.initial.position=33 deg", NULL};
    film m = swing(swings_truth, height, seed);
    m.channels = "angle tip_x";
    m.noise = 4e-4;
    return m;
}

START_TEST(a_time_base_that_is_wrong_by_1_percent_is_found)
{
    // the damping determines the time, the frequency alone would not
    static const char *const names[] = {"clock.error", "rod.damping", NULL};
    static const char *const set[] = {"rod.pendulum.frequency=1.1 Hz", NULL};
    for (int sign = -1; sign <= 1; sign += 2) {
        film m = watched(51);
        m.base = 0.01 * sign;
        const char *data[] = {take("wrong_rate.csv", &m), NULL};
        fitted f;
        open_fit(&f, pendulum, set, data);
        lab_fit_def def = free_these(names);
        ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
        ck_assert_status(f.fit, LAB_FIT_CONVERGED);
        ck_assert_found(f.fit, "clock.error", 0.01 * sign, 3.0);
        ck_assert_found(f.fit, "rod.damping", 1.8e-4, 3.0);
        ck_assert(value_of(f.fit, "clock.error")->sd < 1e-4);
        drop(&f);
    }
}
END_TEST

START_TEST(an_instrument_that_lags_by_1_ms_is_found_even_on_a_wrong_time_base)
{
    static const char *const names[] = {"tip_x.sensor.delay", "clock.error", "rod.damping", NULL};
    static const char *const set[] = {"rod.pendulum.frequency=1.1 Hz", NULL};
    film m = watched(52);
    m.lag = 1e-3;
    for (int wrong = 0; wrong <= 1; wrong++) {
        m.base = -0.01 * wrong;
        const char *data[] = {take("late.csv", &m), NULL};
        fitted f;
        open_fit(&f, pendulum, set, data);
        lab_fit_def def = free_these(names);
        ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
        ck_assert_status(f.fit, LAB_FIT_CONVERGED);
        ck_assert_found(f.fit, "tip_x.sensor.delay", 1e-3, 3.0);
        ck_assert_found(f.fit, "clock.error", m.base, 3.0);
        ck_assert(value_of(f.fit, "tip_x.sensor.delay")->sd < 1e-4);
        drop(&f);
    }
}
END_TEST

/* ---- the action ---- */

static const char *const wrong[] = {
    "pawl.spring.k=0.029 N m/rad +- 10 %", "notch.friction.A=0.285 +- 10 %",
    "hammer.inertia.yy=4.2e-6 kg m^2 +- 10 %", "string.normal.c=5600 N/m +- 10 %", NULL};
static const char *const right[] = {"pawl.spring.k", "notch.friction.A", "hammer.inertia.yy",
                                    "string.normal.c", NULL};

/* three strokes on cameras whose clocks run by themselves */
static void three_strokes(char path[3][200], const double *clock)
{
    static const char *const dx[3][2] = {{"pawl.stop_shift=-0.7 mm", NULL},
                                         {"pawl.stop_shift=-0.3 mm", NULL},
                                         {"pawl.stop_shift=0 mm", NULL}};
    for (int i = 0; i < 3; i++) {
        film m = {.model = action,
                  .told = dx[i],
                  .channels = "string_distance key_dip",
                  .rate = 2000.0,
                  .from = -0.01,
                  .until = 0.1,
                  .noise = 12e-6,
                  .clock = clock[i],
                  .unsynchronised = 1,
                  .seed = 100 + (unsigned long long)i};
        char name[32];
        snprintf(name, sizeof name, "stroke%d.csv", i);
        snprintf(path[i], sizeof path[i], "%s", take(name, &m));
    }
}

START_TEST(an_action_that_is_wrong_by_10_percent_is_found_from_camera_data)
{
    static const double clock[] = {-3.1e-3, 0.17e-3, 8.3e-3},
                        truth[] = {0.03224, 0.3133, 3.874e-6, 5142.0};
    char path[3][200];
    fitted f;
    three_strokes(path, clock);
    const char *data[] = {path[0], path[1], path[2], NULL};
    open_fit(&f, action, wrong, data);
    lab_fit_def def = free_these(right);
    ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
    ck_assert_status(f.fit, LAB_FIT_CONVERGED);
    for (int k = 0; k < 4; k++) {
        ck_assert_found(f.fit, right[k], truth[k], 3.0);
        printf("%-18s %.6g +- %.2g (truth %.6g)\n", right[k], f.fit->value[k].value,
               f.fit->value[k].sd, truth[k]);
    }
    for (int s = 0; s < 3; s++) {
        const lab_fit_value *tau = &f.fit->stroke[s].value[0];
        ck_assert_str_eq(tau->name, "trigger");
        ck_assert_close(tau->value, clock[s], 0.0, 4.0 * tau->sd);
        ck_assert(tau->sd < 20e-6);
        ck_assert_close(f.fit->stroke[s].value[1].value, 0.0, 0.0,
                        4.0 * f.fit->stroke[s].value[1].sd);
    }
    drop(&f);
}
END_TEST

/* ---- the same result, whatever happens ---- */

START_TEST(threads_do_not_change_a_bit)
{
    const char *data[3];
    fitted f;
    two_swings(data, swings_truth, 31);
    open_fit(&f, pendulum, NULL, data);
    lab_fit_def def = free_these(swings_free);
    def.threads = 1;
    ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
    lab_fit *one = f.fit;
    def.threads = 7;
    ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
    ck_assert(is_same(one, f.fit));
    lab_fit_destroy(one);
    drop(&f);
}
END_TEST

typedef struct fuse {
    int left;
} fuse;

static void burn(void *ctx, double fraction, const char *step)
{
    fuse *f = ctx;
    (void)step;
    ck_assert(fraction >= 0.0 && fraction <= 1.0);
    if (f->left-- == 0) {
        raise(SIGKILL);
    }
}

START_TEST(a_fit_that_is_killed_goes_on_to_the_same_bits)
{
    const char *data[3];
    char journal[200];
    fitted f;
    snprintf(journal, sizeof journal, "%s", in_folder("fit.journal"));
    two_swings(data, swings_truth, 41);
    open_fit(&f, pendulum, NULL, data);
    lab_fit_def def = free_these(swings_free);
    def.robust = 1;
    ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
    lab_fit *whole = f.fit;
    int killed = 0;
    for (int round = 0; round < 100; round++) {
        pid_t child = fork();
        if (child == 0) {
            fuse lit = {round % 3};
            lab_fit *part = NULL;
            def.journal = journal;
            def.progress = burn;
            def.ctx = &lit;
            _exit(lab_fit_run(&part, f.model, f.data, &def, NULL) == STEIN_OK ? 0 : 1);
        }
        int how;
        ck_assert_int_eq(waitpid(child, &how, 0), child);
        if (!WIFSIGNALED(how)) {
            ck_assert_int_eq(WEXITSTATUS(how), 0);
            break;
        }
        killed++;
    }
    ck_assert_int_ge(killed, 3);
    def.journal = journal;
    ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
    ck_assert(f.fit->resumed && is_same(whole, f.fit));
    lab_fit *other = NULL;
    def.robust = 0; // another fit must not take this journal
    ck_assert_int_eq(lab_fit_run(&other, f.model, f.data, &def, NULL), STEIN_ESTALE);
    ck_assert_ptr_null(other);
    lab_fit_destroy(whole);
    drop(&f);
}
END_TEST

/* ---- refusals ---- */

static void ck_assert_refused(const fitted *f, const lab_fit_def *def, stein_status status,
                              const char *part)
{
    lab_fit *fit = NULL;
    stein_err err = {STEIN_OK, ""};
    ck_assert_int_eq(lab_fit_run(&fit, f->model, f->data, def, &err), status);
    ck_assert_ptr_null(fit);
    ck_assert_msg(strstr(err.msg, part) != NULL, "\"%s\" lacks \"%s\"", err.msg, part);
}

static void put_file(const char *path, const char *text, size_t n)
{
    FILE *f = fopen(path, "wb");
    ck_assert(f != NULL && fwrite(text, 1, n, f) == n && fclose(f) == 0);
}

START_TEST(a_journal_that_is_cut_damaged_or_old_is_refused)
{
    const char *data[3];
    char journal[200], *text = NULL;
    size_t size = 0;
    fitted f;
    snprintf(journal, sizeof journal, "%s", in_folder("fit.journal"));
    two_swings(data, swings_truth, 41);
    open_fit(&f, pendulum, NULL, data);
    lab_fit_def def = free_these(swings_free);
    def.journal = journal;
    ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
    ck_assert_stein(lab__read_file(journal, &text, &size, err));
    for (size_t n = 0; n < size; n += n < 12 ? 1 : 37) {
        put_file(journal, text, n);
        ck_assert_refused(&f, &def, STEIN_EPARSE, n < 11 ? "is no journal" : "is damaged");
    }
    for (size_t at = 12; at < size; at += 29) {
        text[at] ^= 1;
        put_file(journal, text, size);
        ck_assert_refused(&f, &def, STEIN_EPARSE, "is damaged");
        text[at] ^= 1;
    }
    text[10] = '1';
    put_file(journal, text, size);
    ck_assert_refused(&f, &def, STEIN_ESTALE, "format 1, this version reads 4");
    text[10] = '4';
    put_file(journal, text, size);
    lab_fit_destroy(f.fit);
    ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
    ck_assert(f.fit->resumed);
    free(text);
    drop(&f);
}
END_TEST

START_TEST(impossible_fits_are_refused_with_a_reason)
{
    static const char *const none[] = {"rod.mas", NULL}, *const told[] = {"rod.initial.position",
                                                                          NULL};
    static const char *const twice[] = {"rod.damping", "rod.damping", NULL};
    const char *data[3];
    fitted f;
    two_swings(data, swings_truth, 51);
    open_fit(&f, pendulum, NULL, data);
    lab_fit_def def = free_these(none);
    ck_assert_refused(&f, &def, STEIN_ENAME, "rod.mas");
    def = free_these(told);
    ck_assert_refused(&f, &def, STEIN_EINVAL, "every record sets it");
    def = free_these(twice);
    ck_assert_refused(&f, &def, STEIN_EINVAL, "twice");
    def = free_these(swings_free);
    def.starts = 0;
    ck_assert_refused(&f, &def, STEIN_EINVAL, "starts");
    def = free_these(swings_free);
    def.profile = none;
    def.nprofile = 1;
    ck_assert_refused(&f, &def, STEIN_EINVAL, "not free");
    drop(&f);
}
END_TEST

START_TEST(more_unknowns_than_samples_are_refused)
{
    static const char *const names[] = {"rod.damping", "rod.mass", "rod.pendulum.frequency", NULL};
    film m = swing(NULL, NULL, 3);
    m.until = 4.0 / m.rate;
    const char *data[] = {take("short.csv", &m), NULL};
    fitted f;
    open_fit(&f, pendulum, NULL, data);
    lab_fit_def def = free_these(names);
    ck_assert_refused(&f, &def, STEIN_EINVAL, "cannot determine");
    drop(&f);
}
END_TEST

Suite *fit_suite(void)
{
    Suite *suite = suite_create("fit");
    TCase *small = tcase_create("pendulum"), *same = tcase_create("same"),
          *big = tcase_create("action");
    tcase_add_checked_fixture(small, make_folder, remove_folder);
    tcase_add_checked_fixture(same, make_folder, remove_folder);
    tcase_add_checked_fixture(big, make_folder, remove_folder);
    tcase_set_timeout(small, 900);
    tcase_set_timeout(same, 900);
    tcase_set_timeout(big, 900);
    tcase_add_test(small, wrong_parameters_are_corrected_and_the_search_agrees_with_itself);
    tcase_add_test(small, intervals_hold_the_truth_19_times_in_20);
    tcase_add_test(small, the_ladder_leads_out_of_a_false_minimum);
    tcase_add_test(small, searches_that_agree_need_no_ladder);
    tcase_add_test(small, searches_that_disagree_are_not_called_converged);
    tcase_add_test(small, a_model_that_lacks_something_is_a_misfit);
    tcase_add_test(small, parameters_that_the_data_cannot_separate_are_named);
    tcase_add_test(small, a_profile_without_end_is_open);
    tcase_add_test(small, single_bad_frames_get_little_weight);
    tcase_add_test(small, an_unstated_initial_state_is_found);
    tcase_add_test(small, a_time_base_that_is_wrong_by_1_percent_is_found);
    tcase_add_test(small, an_instrument_that_lags_by_1_ms_is_found_even_on_a_wrong_time_base);
    tcase_add_test(small, a_journal_that_is_cut_damaged_or_old_is_refused);
    tcase_add_test(small, impossible_fits_are_refused_with_a_reason);
    tcase_add_test(small, more_unknowns_than_samples_are_refused);
    tcase_add_test(same, threads_do_not_change_a_bit);
    tcase_add_test(same, a_fit_that_is_killed_goes_on_to_the_same_bits);
    tcase_add_test(big, an_action_that_is_wrong_by_10_percent_is_found_from_camera_data);
    suite_add_tcase(suite, small);
    suite_add_tcase(suite, same);
    suite_add_tcase(suite, big);
    return suite;
}
