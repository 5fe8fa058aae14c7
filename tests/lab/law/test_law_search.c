/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_law_search.c - the steps of the search for a law: scores while an observer holds the model
 * near the records, the end of the fit of a curve, messages about it. Normal equations of which
 * most unknowns stay.
 *
 * The law is a hump of potential on a pendulum's way: slow swings turn back before it, fast ones go
 * over. Without it no fit is anywhere near the swings.
 */
#include <gsl/gsl_linalg.h>
#include <string.h>

#include "curve_fitting.h"
#include "suites.h"
#include "swings.h"

enum { HUMP_POINTS = 25 };
static const double height = 0.006, middle = 0.1, width = 0.2; /* J, rad */

/* torque of the hump */
static double hump(double q)
{
    double u = (q - middle) / width;
    return 2.0 * height / width * u * exp(-u * u);
}

/* the pendulum with it. @return the file's path */
static const char *humped(void)
{
    char *text = NULL, list[2][HUMP_POINTS * 24] = {"", ""};
    size_t size = 0;
    for (int k = 0; k < HUMP_POINTS; k++) {
        double q = middle + 0.05 * (k - HUMP_POINTS / 2);
        char word[2][24];
        snprintf(word[0], sizeof word[0], "%s%.4f rad", k > 0 ? ", " : "", q);
        snprintf(word[1], sizeof word[1], "%s%.8f N m", k > 0 ? ", " : "", hump(q));
        strcat(list[0], word[0]);
        strcat(list[1], word[1]);
    }
    ck_assert_stein(lab__read_file(pendulum, &text, &size, err));
    const char *path = in_folder("humped.yaml");
    FILE *f = fopen(path, "w");
    ck_assert_ptr_nonnull(f);
    fprintf(f, "%s\ntables:\n  hump: {joint: rod, of: position, at: [%s], torque: [%s]}\n", text,
            list[0], list[1]);
    ck_assert_int_eq(fclose(f), 0);
    free(text);
    return path;
}

/* the search for a law, up to where it ends; the null hypothesis has this row */
typedef struct bench {
    fitted f;
    lab_options options;
    lab_diagnose_def def;
    diag__problem q;
    diag__table t;
    diag__row *null;
    diag__laws laws;
} bench;

static void search_bench(bench *b, const char *file)
{
    const diag__proposal none = {.h = {.n = 0}, .parent = -1, .by = &diag__step_null};
    b->options = cache_here(NULL);
    b->def = lab_diagnose_def_default();
    b->def.options = &b->options;
    ck_assert_stein(diag__problem_open(&b->q, file, b->f.model, b->f.data, &b->def, err));
    ck_assert_stein(diag__evaluate(&b->q, &b->t, &none, &b->null, err));
    ck_assert_ptr_null(b->null->failed);
    ck_assert_stein(diag__laws_find(&b->q, b->null, &b->laws, err));
    ck_assert_int_gt(b->laws.n, 0);
}

/* the swings over the hump */
static void open_bench(bench *b)
{
    const char *data[SWINGS + 1] = {NULL};
    char with[200];
    memset(b, 0, sizeof *b);
    snprintf(with, sizeof with, "%s", humped());
    for (int i = 0; i < SWINGS; i++) {
        data[i] = film_swing(i, with, NULL, 2700);
    }
    open_fit(&b->f, pendulum, NULL, data);
    search_bench(b, pendulum);
}

static void close_bench(bench *b)
{
    diag__laws_free(&b->laws);
    diag__table_free(&b->t);
    diag__problem_close(&b->q);
    drop(&b->f);
}

static const diag__site *rod_position(const diag__curves *w)
{
    for (int i = 0; i < w->nsite; i++) {
        if (w->site[i].kind == STEIN_TABLE_POSITION) {
            return &w->site[i];
        }
    }
    ck_abort_msg("no site");
    return NULL;
}

START_TEST(a_law_that_decides_where_strokes_go_is_found)
{
    bench b;
    open_bench(&b);
    const diag__curves *w = &b.laws.all;
    const diag__curve *c = &b.laws.curve[0];
    double worst = 0.0;
    ck_assert_double_gt(b.null->chi2_dof, 20.0);
    ck_assert(c->fitted && c->site == rod_position(w));
    ck_assert_double_lt(diag__curve_chi2_dof(w, c), 1.15);
    for (int k = 0; k < c->site->n; k++) {
        double is = fit__value(&w->p.unknown[c->site->first + k], c->x[c->site->first + k]);
        worst = fmax(worst, fabs(is - hump(c->site->at[k])));
    }
    printf("without a law %.0f, with it %.3f; it is off by %.4f of %.4f N m at most\n",
           b.null->chi2_dof, diag__curve_chi2_dof(w, c), worst, hump(middle + 0.7 * width));
    ck_assert_double_lt(worst, 0.05 * hump(middle + 0.7 * width));
    close_bench(&b);
}
END_TEST

START_TEST(where_the_model_is_held_near_the_records_the_right_curve_scores_most)
{
    bench b;
    open_bench(&b);
    diag__curves *w = &b.laws.all;
    diag__curve score[40];
    ck_assert_int_le(w->nsite, 40);
    ck_assert_stein(diag__stand(w, 0.05, err));
    ck_assert_stein(diag__stand_derive(w, err));
    ck_assert_stein(diag__curve_scores(w, score, err));
    diag__curve_sort(score, w->nsite);
    ck_assert(score[0].site == rod_position(w));
    ck_assert_double_gt(score[0].gain, 30.0);
    for (int i = 1; i < w->nsite; i++) {
        ck_assert_double_le(score[i].gain, score[i - 1].gain);
    }
    close_bench(&b);
}
END_TEST

START_TEST(the_step_of_a_number_that_is_held_stays)
{
    bench b;
    open_bench(&b);
    fit__problem *p = &b.laws.all.p;
    const diag__site *s = rod_position(&b.laws.all);
    const diag__site *o = s > b.laws.all.site ? s - 1 : s + 1;
    double *J = calloc(fit__columns(p), sizeof *J); // nothing changes anything
    double held = p->step[o->first + o->pinned], moves = p->step[s->first + s->pinned];
    diag__curve_free_only(&b.laws.all, s);
    fit__choose_steps(p, J);
    ck_assert_double_eq(p->step[o->first + o->pinned], held);
    ck_assert_double_gt(p->step[s->first + s->pinned], moves);
    free(J);
    close_bench(&b);
}
END_TEST

START_TEST(a_fit_settles_where_it_is_and_leaves_the_problem_as_it_was)
{
    bench b;
    open_bench(&b);
    diag__curves *w = &b.laws.all;
    diag__curve *c = &b.laws.curve[0];
    double tolerance = w->p.tolerance, gain = c->gain, chi2 = diag__curve_chi2_dof(w, c);
    size_t size = sizeof *w->p.step * (size_t)w->p.nu;
    double *step = malloc(size);
    memcpy(step, w->p.step, size);
    ck_assert_stein(diag__curve_settle(w, c, err));
    ck_assert(c->fitted);
    ck_assert_double_eq(w->p.tolerance, tolerance);
    ck_assert_int_eq(w->p.central, 0);
    ck_assert_mem_eq(step, w->p.step, size);
    ck_assert_double_gt(c->gain, gain - 5.0);
    ck_assert_double_le(diag__curve_chi2_dof(w, c), chi2 + 0.01);
    free(step);
    close_bench(&b);
}
END_TEST

/* H dx = -g of the unknowns that move, once in full */
START_TEST(normal_equations_contain_the_moving_unknowns)
{
    bench b;
    open_bench(&b);
    diag__curves *s = &b.laws.all;
    fit__problem *p = &s->p;
    const diag__site *o = rod_position(s);
    ck_assert_stein(diag__stand(s, 0.05, err));
    ck_assert_stein(diag__stand_derive(s, err));
    int at[200], n = 0, rows = (int)fit__offset(p, p->nstroke);
    diag__curve_free_only(s, o);
    for (int u = 0; u < p->nu; u++) {
        if (!p->unknown[u].idle) {
            ck_assert_int_lt(n, 200);
            at[n++] = u;
        }
    }
    ck_assert_int_lt(n, p->nu - 20);
    fit__normal normal;
    ck_assert_stein(fit__normal_make(&normal, p, err));
    fit__normal_fill(&normal, p, s->x, s->r, s->J, 1);
    double *dx = malloc(sizeof *dx * (size_t)p->nu);
    for (int u = 0; u < p->np; u++) { // or a curve without a prior has no solution
        if (normal.row[u] >= 0) {
            *gsl_matrix_ptr(normal.A, (size_t)normal.row[u], (size_t)normal.row[u]) += 1.0;
        }
    }
    ck_assert_int_eq(fit__normal_factor(&normal, p, 0.0, NULL), 0);
    fit__normal_step(&normal, p, dx);

    gsl_matrix *H = gsl_matrix_calloc((size_t)n, (size_t)n),
               *J = gsl_matrix_calloc((size_t)rows, (size_t)n);
    gsl_vector *g = gsl_vector_calloc((size_t)n);
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < p->nstroke; k++) {
            const fit__stroke *t = &p->stroke[k];
            int own = at[i] - t->first, column = at[i] < p->np ? at[i] : p->np + own;
            for (int j = 0; (at[i] < p->np || (own >= 0 && own < t->own)) && j < t->nch * t->n;
                 j++) {
                gsl_matrix_set(J, fit__offset(p, k) + (size_t)j, (size_t)i,
                               s->J[fit__column(p, k, column) + (size_t)j]);
            }
        }
    }
    for (int i = 0; i < n; i++) {
        const fit__unknown *u = &p->unknown[at[i]];
        double sum = u->prior ? s->x[at[i]] : 0.0;
        for (int j = 0; j < rows; j++) {
            sum += gsl_matrix_get(J, (size_t)j, (size_t)i) * s->r[j];
        }
        gsl_vector_set(g, (size_t)i, -sum);
        for (int k = 0; k < n; k++) {
            double h = i == k ? (double)(u->prior != 0) + (at[i] < p->np) : 0.0;
            for (int j = 0; j < rows; j++) {
                h += gsl_matrix_get(J, (size_t)j, (size_t)i) *
                     gsl_matrix_get(J, (size_t)j, (size_t)k);
            }
            gsl_matrix_set(H, (size_t)i, (size_t)k, h);
        }
    }
    ck_assert_int_eq(gsl_linalg_cholesky_decomp1(H), 0);
    gsl_linalg_cholesky_svx(H, g);
    double most = 0.0;
    for (int i = 0; i < n; i++) {
        most = fmax(most, fabs(gsl_vector_get(g, (size_t)i)));
    }
    ck_assert_double_gt(most, 0.1);
    for (int i = 0, u = 0; u < p->nu; u++) {
        double is = i < n && at[i] == u ? gsl_vector_get(g, (size_t)i++) : 0.0;
        ck_assert_double_eq_tol(dx[u], is, 1e-6 * most);
    }
    gsl_matrix_free(H);
    gsl_matrix_free(J);
    gsl_vector_free(g);
    fit__normal_free(&normal);
    free(dx);
    close_bench(&b);
}
END_TEST

/* a fit in which nothing of all strokes moves at all */
START_TEST(normal_equations_of_strokes_own_numbers_alone_have_a_solution)
{
    bench b;
    open_bench(&b);
    diag__curves *s = &b.laws.all;
    fit__problem *p = &s->p;
    ck_assert_stein(diag__stand(s, 0.05, err));
    ck_assert_stein(diag__stand_derive(s, err));
    for (int u = 0; u < p->np; u++) {
        p->unknown[u].idle = 1;
    }
    fit__normal normal;
    ck_assert_stein(fit__normal_make(&normal, p, err));
    fit__normal_fill(&normal, p, s->x, s->r, s->J, 1);
    ck_assert_int_eq(normal.n, 0);
    double *dx = malloc(sizeof *dx * (size_t)p->nu), moved = 0.0;
    ck_assert_int_eq(fit__normal_factor(&normal, p, 0.0, NULL), 0);
    fit__normal_step(&normal, p, dx);
    for (int u = 0; u < p->nu; u++) {
        ck_assert(isfinite(dx[u]) && (u >= p->np || dx[u] == 0.0));
        moved = fmax(moved, fabs(dx[u]));
    }
    ck_assert_double_gt(moved, 0.0);
    fit__normal_free(&normal);
    free(dx);
    close_bench(&b);
}
END_TEST

/* a pendulum with a spring of unknown stiffness and unknown damping */
static const char *sprung(void)
{
    static const char spring[] = "    spring: {k: 0.02 N m/rad +- 5 %, theta0: 0.5 rad}\n"
                                 "    damping: 1.5e-4 N m s/rad +- 0.2e-4 N m s/rad\n";
    char *text = NULL;
    size_t size = 0;
    ck_assert_stein(lab__read_file(pendulum, &text, &size, err));
    char *damping = strstr(text, "    damping:");
    ck_assert_ptr_nonnull(damping);
    const char *path = in_folder("sprung.yaml");
    FILE *f = fopen(path, "w");
    ck_assert_ptr_nonnull(f);
    fprintf(f, "%.*s%s%s", (int)(damping - text), text, spring, strchr(damping, '\n') + 1);
    ck_assert_int_eq(fclose(f), 0);
    free(text);
    return path;
}

/* dr/dp = sum_k dT/dp dr/df_k of every stroke, and it has been that nearly when it was simulated */
static void check_same(const fit__problem *p, const diag__site *s, int u, const double *weight,
                       const double *was, const double *is, int changes)
{
    for (int i = 0; i < p->nstroke; i++) {
        int n = p->stroke[i].nch * p->stroke[i].n;
        double off = 0.0, apart = 0.0, all = 0.0;
        for (int j = 0; j < n; j++) {
            double sum = 0.0, now = is[fit__column(p, i, u) + (size_t)j];
            double then = was[fit__column(p, i, u) + (size_t)j];
            for (int k = 0; k < s->n; k++) {
                sum += weight[k] * is[fit__column(p, i, s->first + k) + (size_t)j];
            }
            off += changes ? (now - sum) * (now - sum) : (now - then) * (now - then);
            apart += (now - then) * (now - then);
            all += now * now;
        }
        ck_assert_double_gt(all, 0.0);
        ck_assert_double_le(off, 1e-16 * all);
        ck_assert_double_lt(apart, 1e-3 * all);
        ck_assert(!changes || apart > 0.0);
    }
}

START_TEST(a_spring_and_its_curve_have_exactly_the_same_effect)
{
    const char *data[SWINGS + 1] = {NULL};
    bench b;
    memset(&b, 0, sizeof b);
    char file[200];
    snprintf(file, sizeof file, "%s", sprung());
    for (int i = 0; i < SWINGS; i++) {
        data[i] = film_swing(i, file, NULL, 2800);
    }
    open_fit(&b.f, file, NULL, data);
    search_bench(&b, file);
    diag__curves *w = &b.laws.all;
    int spring = -1, damping = -1;
    for (int i = 0; i < b.q.nname; i++) {
        spring = strcmp(b.q.name[i], "rod.spring.k") == 0 ? i : spring;
        damping = strcmp(b.q.name[i], "rod.damping") == 0 ? i : damping;
    }
    ck_assert(spring >= 0 && damping >= 0);
    ck_assert_stein(diag__stand(w, 0.0, err));
    fit__problem *p = &w->p;
    double *J = malloc(2 * sizeof *J * fit__columns(p)), *was = J + fit__columns(p);
    for (int kind = STEIN_TABLE_POSITION; kind <= STEIN_TABLE_SPEED; kind++) {
        const diag__site *s = &w->site[0];
        while (s->kind != (stein_table_kind)kind) {
            s++;
            ck_assert(s < w->site + w->nsite);
        }
        double weight[CURVE_POINTS], *x = w->x;
        for (int k = 0; k < s->n; k++) {
            const fit__unknown *uk = &p->unknown[spring], *ub = &p->unknown[damping];
            double of_k = fit__value(uk, x[spring]) * uk->sd; // of logarithms
            double of_b = fit__value(ub, x[damping]) * ub->sd;
            weight[k] = kind == STEIN_TABLE_POSITION ? -(s->at[k] - 0.5) * of_k : -s->at[k] * of_b;
        }
        ck_assert(p->unknown[spring].log && p->unknown[damping].log);
        diag__curve_free_only(w, s);
        ck_assert_stein(fit__sensitivities(p, x, w->r, J, err));
        memcpy(was, J, sizeof *J * fit__columns(p));
        ck_assert_stein(diag__same_as_curve(w, s, x, J, err));
        check_same(p, s, kind == STEIN_TABLE_POSITION ? spring : damping, weight, was, J, 1);
        check_same(p, s, kind == STEIN_TABLE_POSITION ? damping : spring, weight, was, J, 0);
    }
    free(J);
    close_bench(&b);
}
END_TEST

/* Data that show the integral of a law up to each point, with noise: M, c. */
static void measure(const diag__site *s, const double *truth, unsigned long long *seed,
                    diag__reduced *q)
{
    *q = (diag__reduced){.n = s->n};
    for (int i = 0; i < s->n; i++) {
        double seen = gauss(seed);
        q->index[i] = i;
        for (int a = 0; a <= i; a++) {
            seen += truth[a];
        }
        for (int a = 0; a <= i; a++) {
            q->c[a] += seen;
            for (int b = 0; b <= i; b++) {
                q->M[a * s->n + b] += 1.0;
            }
        }
    }
}

/* share of the points with the truth in the band about f */
static double covered(const diag__reduced *q, const double *truth)
{
    int inside = 0;
    for (int i = 0; i < q->n; i++) {
        inside += fabs(q->f[i] - truth[i]) < 1.959964 * sqrt(q->cov[i * q->n + i]);
    }
    return (double)inside / q->n;
}

START_TEST(a_band_does_not_take_for_granted_how_smooth_the_law_is)
{
    enum { LAWS = 60 };
    diag__site s = {.n = HUMP_POINTS};
    diag__reduced q;
    unsigned long long seed = 4100;
    double chosen = 0.0, spread = 0.0;
    for (int i = 0; i < s.n; i++) {
        s.at[i] = (double)i / (s.n - 1);
    }
    for (int k = 0; k < LAWS; k++) {
        double truth[HUMP_POINTS], f[HUMP_POINTS], tall = 1.0 + 0.5 * (k % 4);
        double peak = 0.15 + 0.1 * (k % 7) / 7.0;
        for (int i = 0; i < s.n; i++) { // a hump in a felt
            double u = s.at[i] / peak;
            truth[i] = tall * pow(u, 4.0) * exp(2.0 - 2.0 * u * u);
        }
        measure(&s, truth, &seed, &q);
        diag__curve_choose(&s, &q);
        memcpy(f, q.f, sizeof f);
        double alone = covered(&q, truth), gained = q.gained;
        diag__curve_spread(&s, &q);
        ck_assert_mem_eq(q.f, f, sizeof f); // about the same law
        ck_assert_double_eq(q.gained, gained);
        chosen += alone / LAWS;
        spread += covered(&q, truth) / LAWS;
    }
    printf("of %d laws bands hold %.1f %% of the truth, with the best prior alone %.1f %%\n", LAWS,
           100.0 * spread, 100.0 * chosen);
    ck_assert_double_lt(chosen, 0.9);
    ck_assert_double_gt(spread, 0.9);
    ck_assert_double_lt(spread, 0.99);
}
END_TEST

/* residuals of noise, and of a wave as large */
START_TEST(the_residual_beyond_noise_is_correlated_from_sample_to_sample)
{
    bench b;
    open_bench(&b);
    const fit__problem *p = &b.null->p;
    size_t rows = fit__offset(p, p->nstroke);
    double *r = malloc(sizeof *r * rows);
    unsigned long long seed = 4200;
    ck_assert(fit__noise_given(p));
    for (int wave = 0; wave < 2; wave++) {
        for (size_t i = 0; i < rows; i++) {
            r[i] = wave ? sqrt(2.0) * sin(0.05 * (double)i) : gauss(&seed);
        }
        ck_assert_double_eq(fit__inflation(p, r), 1.0); // the noise is what was stated
        double memory = fit__memory(p, r);
        ck_assert(wave ? memory > 10.0 : memory < 2.0);
    }
    free(r);
    close_bench(&b);
}
END_TEST

Suite *law_search_suite(void)
{
    Suite *suite = suite_create("law_search");
    TCase *tc = tcase_create("law_search");
    tcase_add_checked_fixture(tc, make_folder, remove_folder);
    tcase_set_timeout(tc, 120);
    tcase_add_test(tc, a_law_that_decides_where_strokes_go_is_found);
    tcase_add_test(tc, where_the_model_is_held_near_the_records_the_right_curve_scores_most);
    tcase_add_test(tc, the_step_of_a_number_that_is_held_stays);
    tcase_add_test(tc, a_fit_settles_where_it_is_and_leaves_the_problem_as_it_was);
    tcase_add_test(tc, a_spring_and_its_curve_have_exactly_the_same_effect);
    tcase_add_test(tc, normal_equations_contain_the_moving_unknowns);
    tcase_add_test(tc, normal_equations_of_strokes_own_numbers_alone_have_a_solution);
    tcase_add_test(tc, a_band_does_not_take_for_granted_how_smooth_the_law_is);
    tcase_add_test(tc, the_residual_beyond_noise_is_correlated_from_sample_to_sample);
    suite_add_tcase(suite, tc);
    return suite;
}
