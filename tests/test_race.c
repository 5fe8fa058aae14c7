/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_race.c - what shortens a search: a race to an early horizon, fits that are given up on their
 * way, nothing twice from where it brought nothing, strokes that are fitted one by one; and a law
 * gains nothing by what a null fit has left where it should not be.
 */
#include <string.h>

#include "curve.h"
#include "suites.h"
#include "swing_bench.h"

/* the swings with their suspects and the null fit; the mechanism's numbers are known */
static void open_bench(bench *b, const char *const *truth, int threads, unsigned long long seed)
{
    memset(b, 0, sizeof *b);
    open_swings(&b->f, pendulum, truth, seed);
    begin_bench(b, pendulum, NULL, 0, threads);
    ck_assert_stein(diag__changes(&b->d, err));
    ck_assert_stein(diag__rank(&b->d, err));
}

static diag__suspect *suspect(diag *d, const char *kind)
{
    for (int i = 0; i < d->n; i++) {
        if (strcmp(d->suspect[i].s.candidate.effect->kind, kind) == 0) {
            return &d->suspect[i];
        }
    }
    ck_abort_msg("no suspect %s", kind);
    return NULL;
}

static const char *const friction[] = {"rod.coulomb.T=0.5 mN m", NULL};
static const char *const nothing[] = {"rod.coulomb.T=0 N m", NULL};

START_TEST(what_is_missing_wins_the_race)
{
    bench b;
    open_bench(&b, friction, 1, 2100);
    diag *d = &b.d;
    ck_assert_stein(diag__look_early(d, err));
    ck_assert_double_gt(d->early.z, 3.0);
    ck_assert_double_lt(d->early.horizon, 0.7 * diag__longest(&d->p));
    int lined_up = 0, on = 0;
    for (int i = 0; i < d->n; i++) {
        lined_up += isfinite(d->suspect[i].early);
    }
    ck_assert_stein(diag__race(d, err));
    diag__suspect *s = suspect(d, "coulomb_friction");
    double n = d->early.samples, shown = s->early * s->s.candidate.limit;
    printf("race of %d to %.2f s: the null fit leaves %.0f of %.0f, friction of %.3f mN m %.0f\n",
           lined_up, d->early.horizon, d->early.objective, n, 1e3 * shown, s->early_left);
    ck_assert_double_gt(d->early.objective, 1.2 * n);
    ck_assert_double_lt(s->early_left, n + 5.0 * sqrt(2.0 * n));
    ck_assert_double_eq_tol(shown, 0.5e-3, 0.2e-3);
    ck_assert_double_eq(s->start[d->p.amount], s->early);
    ck_assert_int_eq(diag__beginner(d), (int)(s - d->suspect)); // nobody else explains it
    ck_assert_double_eq(s->begins[d->p.amount], s->early);
    for (int i = 0; i < d->n; i++) {
        on += isfinite(d->suspect[i].early);
        ck_assert(!isfinite(d->suspect[i].early) || d->suspect[i].early_left >= s->early_left);
    }
    ck_assert(on >= 1 && on <= 3 && lined_up > on);
    close_bench(&b);
}
END_TEST

/* where nothing is missing everybody leaves noise */
START_TEST(who_explains_no_more_than_others_do_is_no_begin)
{
    bench b;
    open_bench(&b, nothing, 1, 2900);
    diag *d = &b.d;
    ck_assert_stein(diag__look_early(d, err));
    d->p.horizon = d->early.horizon = 0.3 * diag__longest(&d->p);
    d->early.samples = diag__samples(&d->p);
    d->early.objective = 2.0 * d->early.samples; // as if something were
    d->p.horizon = INFINITY;
    for (int i = 0; i < d->n; i++) {
        d->suspect[i].early = d->suspect[i].never == NULL ? 0.0 : NAN;
    }
    ck_assert_stein(diag__race(d, err));
    ck_assert_int_eq(diag__beginner(d), -1);
    close_bench(&b);
}
END_TEST

START_TEST(a_race_that_leaves_more_than_noise_says_that_one_suspect_is_not_enough)
{
    diag d = {.early = {.samples = 2000.0, .left = 0.0}};
    ck_assert(!diag__is_beyond_one(&d)); // there was none
    d.early.left = 2100.0;
    ck_assert(!diag__is_beyond_one(&d)); // 5 % more are little
    d.early.left = 2600.0;
    ck_assert(diag__is_beyond_one(&d));
    d.early = (diag__early){.samples = 50.0, .left = 65.0};
    ck_assert(!diag__is_beyond_one(&d)); // the same share of few samples may be chance
}
END_TEST

/* Where one of two leads, a hasty search leaves races and fits along the swings for later; where
 * its leader is all that is missing, there is nothing to leave. */
START_TEST(a_hasty_search_waits_where_its_leader_leaves_more)
{
    static const char *const two[] = {"rod.coulomb.T=2 mN m", "rod.preload=4 mN m", NULL};
    bench b;
    diag *d = &b.d;
    open_bench(&b, two, 2, 500);
    d->hasty = 1;
    ck_assert_stein(diag__search(d, err));
    double first = d->suspect[0].objective;
    ck_assert(d->put_off && !d->raced && diag__is_more(d, d->suspect[0].s.chi2_dof));
    for (int i = 0; i < d->n; i++) {
        ck_assert(!d->suspect[i].begun);
    }
    ck_assert_stein(diag__refit_on(d, err));
    ck_assert(!d->put_off && d->raced);
    ck_assert_double_le(d->suspect[0].objective, first);
    close_bench(&b);

    open_bench(&b, friction, 2, 2100);
    d->hasty = 1;
    ck_assert_stein(diag__search(d, err));
    ck_assert_str_eq(d->suspect[0].s.candidate.effect->kind, "coulomb_friction");
    ck_assert(!d->put_off && d->raced);
    close_bench(&b);
}
END_TEST

/* whatever its score, it is fitted from there */
START_TEST(who_led_elsewhere_is_asked_again)
{
    static const char kind[] = "viscous_asymmetry";
    for (int known = 0; known < 2; known++) {
        bench b;
        diag *d = &b.d;
        open_bench(&b, friction, 2, 2100);
        lab_candidate led = suspect(d, kind)->s.candidate;
        double *x = malloc(sizeof *x * (size_t)d->p.nu);
        memcpy(x, d->x, sizeof *x * (size_t)d->p.nu);
        d->hasty = 1;
        d->known = known ? &led : NULL;
        d->known_x = x;
        ck_assert_stein(diag__search(d, err));
        ck_assert_int_eq(suspect(d, kind)->s.refitted, known);
        ck_assert_str_eq(d->suspect[0].s.candidate.effect->kind, "coulomb_friction");
        free(x);
        close_bench(&b);
    }
}
END_TEST

/* along the swings from the file's own numbers with an effect, NULL: without. @return fits */
static int follow(diag *d, const lab_candidate *effect, diag__pursuit *c)
{
    size_t nu = (size_t)d->p.nu, rows = fit__offset(&d->p, d->p.nstroke);
    double *room = calloc(nu + rows + fit__columns(&d->p), sizeof *room);
    fit__end e = {.x = room, .r = room + nu, .J = room + nu + rows};
    fit__problem_try(&d->p, effect);
    ck_assert_stein(diag__follow(d, &d->p, &e, c, err));
    ck_assert(d->p.horizon == (double)INFINITY);
    fit__problem_try(&d->p, NULL);
    free(room);
    return e.fits;
}

START_TEST(a_fit_that_explains_nothing_of_what_shows_early_is_given_up)
{
    bench b;
    open_bench(&b, friction, 1, 2200);
    diag *d = &b.d;
    diag__pursuit without = {.null = &d->null_marks}, with = without;
    int fits = follow(d, NULL, &without);
    ck_assert_int_lt(fits, follow(d, &suspect(d, "coulomb_friction")->s.candidate, &with));
    ck_assert_int_eq(without.given_up, 1);
    ck_assert_int_eq(with.given_up, 0);

    double most[DIAG_HORIZONS];
    for (int h = 0; h < DIAG_HORIZONS; h++) {
        most[h] = 10.0; // nothing ends as near as that
    }
    diag__pursuit near = {.most = most};
    ck_assert_int_eq(follow(d, NULL, &near), 1);
    ck_assert_int_eq(near.given_up, 1);
    close_bench(&b);
}
END_TEST

/* a drag that explains a part of the friction: followed to its end when nothing holds it, given up
 * sooner by what the friction passes */
static void is_given_up(diag *d, diag__pursuit free, diag__pursuit held)
{
    const lab_candidate *drag = &suspect(d, "quadratic_drag")->s.candidate;
    diag__pursuit right = held;
    int whole = follow(d, drag, &free), fits = follow(d, drag, &held);
    ck_assert_int_eq(free.given_up, 0);
    ck_assert_int_eq(held.given_up, 1);
    ck_assert_int_lt(fits, whole);
    (void)follow(d, &suspect(d, "coulomb_friction")->s.candidate, &right);
    ck_assert_int_eq(right.given_up, 0);
}

START_TEST(a_fit_that_is_to_leave_but_noise_is_given_up_where_it_leaves_more)
{
    bench b;
    open_bench(&b, friction, 1, 2200);
    diag *d = &b.d;
    ck_assert_stein(diag__look_early(d, err));
    is_given_up(d, (diag__pursuit){.null = &d->null_marks},
                (diag__pursuit){.null = &d->null_marks, .to_noise = 1, .first = d->early.horizon});
    close_bench(&b);
}
END_TEST

START_TEST(a_fit_that_falls_behind_the_best_one_is_given_up)
{
    bench b;
    open_bench(&b, friction, 1, 2200);
    diag *d = &b.d;
    diag__suspect *best = suspect(d, "coulomb_friction");
    ck_assert_stein(diag__from_the_file(d, best, 0.1, err));
    ck_assert_double_lt(best->s.chi2_dof, 1.1);
    double most[DIAG_HORIZONS];
    diag__ahead(&d->p, best->r, best->left, most);
    for (int h = 1; h < DIAG_HORIZONS; h++) {
        ck_assert_double_gt(most[h], most[h - 1]); // who goes on may leave more
    }
    ck_assert_double_gt(most[0], 0.1 * best->left);
    ck_assert_double_lt(most[DIAG_HORIZONS - 1], best->left + 50.0);
    is_given_up(d, (diag__pursuit){.most = NULL}, (diag__pursuit){.most = most});
    close_bench(&b);
}
END_TEST

/* a third of the strokes may be strays; would they leave what the others do, were they back? */
START_TEST(strays_that_come_back_leave_what_others_do)
{
    bench b;
    open_bench(&b, nothing, 1, 2700);
    const fit__problem *p = &b.d.p;
    double *r = calloc(fit__offset(p, p->nstroke) + 1, sizeof *r), room[SWINGS];
    for (int s = 0; s < p->nstroke; s++) {
        r[fit__offset(p, s)] = s < p->nstroke / 3 ? 1000.0 : 2.0;
    }
    ck_assert_double_eq_tol(diag__come_back(p, r, room), 4.0 * p->nstroke, 1e-9);
    r[fit__offset(p, p->nstroke - 1)] = 100.0; // one too many: it counts
    ck_assert_double_gt(diag__come_back(p, r, room), 1e4);
    free(r);
    close_bench(&b);
}
END_TEST

START_TEST(what_has_brought_nothing_is_not_done_again_from_there)
{
    bench b;
    open_bench(&b, friction, 1, 2300);
    diag *d = &b.d;
    diag__suspect *s = suspect(d, "viscous_friction"); // explains some of it, and leaves more
    ck_assert_stein(diag__from_the_file(d, s, 0.1, err));
    ck_assert_int_eq(s->s.refitted, 1);
    s->ended = 0;
    s->stuck = s->unheeded = s->objective;
    int fits = b.out->fits;
    ck_assert_stein(diag__to_the_end(d, s, err));
    ck_assert_stein(diag__recall(d, s, err));
    ck_assert_int_eq(b.out->fits, fits);
    s->stuck = s->objective + 100.0;
    ck_assert_stein(diag__to_the_end(d, s, err));
    ck_assert_int_gt(b.out->fits, fits);
    close_bench(&b);
}
END_TEST

START_TEST(strokes_one_by_one_end_where_they_end_whoever_is_beside_them)
{
    double kept[400];
    int fits = 0;
    for (int threads = 1; threads <= 2; threads++) {
        bench b;
        open_bench(&b, nothing, threads, 2400);
        diag *d = &b.d;
        static const double as_stated[DIAG_CLASSES] = {1.0, 1.0, 1.0};
        double *x = calloc((size_t)d->p.nu + fit__offset(&d->p, SWINGS) + 1, sizeof *x);
        memcpy(x, d->x, sizeof *x * (size_t)d->p.nu);
        // by that measure every one is a stray, and is asked from all starts
        diag__singles s = {
            .d = d, .p = &d->p, .D = as_stated, .x = x, .r = x + d->p.nu, .middle = 0.1};
        ck_assert_stein(diag__fit_singles(&s, NULL, err));
        double deviance[SWINGS];
        ck_assert_stein(diag__deviance(&s, deviance, err));
        for (int i = 0; i < SWINGS; i++) {
            ck_assert(isfinite(deviance[i]));
        }
        int starts = 0;
        for (int k = d->p.np; k < d->p.nu; k++) {
            starts += 2 * (d->p.unknown[k].kind == FIT__SCATTER);
        }
        ck_assert_int_ge(starts, 2 * SWINGS);
        ck_assert_int_ge(s.fits, SWINGS + starts);
        ck_assert_int_le(d->p.nu, 400);
        ck_assert_double_lt(fit__chi2(&d->p, s.r), 1.2 * d->p.samples);
        if (threads == 1) {
            memcpy(kept, x, sizeof *x * (size_t)d->p.nu);
            fits = s.fits;
        }
        ck_assert_mem_eq(kept, x, sizeof *x * (size_t)d->p.nu);
        ck_assert_int_eq(s.fits, fits);
        free(x);
        close_bench(&b);
    }
}
END_TEST

static const char *const two[] = {"rod.coulomb.T=2 mN m", "rod.preload=4 mN m", NULL};

/* A first search has led nowhere, but one suspect explains how the swings begin with that amount.
 * @return causes that are found so */
static int begin_as(const char *kind, double amount, diag__found *f, bench *b)
{
    open_bench(b, two, 1, 2800);
    diag *d = &b->d;
    diag__held before = {.rmse = NAN};
    diag__suspect *s = suspect(d, kind);
    for (int i = 0; i < d->n; i++) {
        d->suspect[i].objective = INFINITY;
    }
    ck_assert_stein(
        diag__likelihood(&d->p, d->x, d->J, d->r, d->null_D, d->sd, &d->null_objective, NULL, err));
    ck_assert_stein(diag__held_out(d, NULL, &before, err));
    ck_assert_stein(diag__several(d, &before, f, err));
    ck_assert_int_eq(f->n, 0); // nobody was fitted
    diag__found_free(f);
    s->begins = calloc((size_t)d->p.nu, sizeof *s->begins);
    s->begins[d->p.amount] = amount / s->s.candidate.limit;
    ck_assert_int_eq(diag__beginner(d), (int)(s - d->suspect));
    ck_assert_stein(diag__several(d, &before, f, err));
    diag__held_free(&before);
    return f->n;
}

START_TEST(what_explains_how_strokes_begin_is_one_of_two_though_fits_of_whole_ones_led_nowhere)
{
    bench b;
    diag__found found;
    ck_assert_int_eq(begin_as("coulomb_friction", 2e-3, &found, &b), 2);
    ck_assert_str_eq(found.cause[0].candidate.effect->kind, "coulomb_friction");
    ck_assert_str_eq(found.cause[1].candidate.effect->kind, "preload");
    ck_assert_double_lt(found.chi2_dof, 1.1);
    diag__verdict(&b.d, &found);
    ck_assert_int_eq(b.out->verdict, LAB_VERDICT_MISSING_EFFECT);
    diag__found_free(&found);
    found.held = (diag__held){.x = NULL};
    close_bench(&b);

    ck_assert_int_eq(begin_as("quadratic_drag", 1e-4, &found, &b), 0);
    ck_assert_int_eq(suspect(&b.d, "quadratic_drag")->s.refitted, 0); // and is where it was
    diag__found_free(&found);
    close_bench(&b);
}
END_TEST

/* Two act: who leads in a race of the first one explains the beginning, and beside it a second race
 * finds the other one. Of one alone nothing is left to a second one. */
START_TEST(two_causes_are_found_in_the_order_in_which_strokes_show_them)
{
    for (int n = 1; n <= 2; n++) {
        bench b;
        diag *d = &b.d;
        open_bench(&b, n == 2 ? two : friction, 2, 2800);
        ck_assert_stein(diag__look_early(d, err));
        ck_assert_stein(diag__race(d, err));
        int leading = 0;
        for (int i = 0; i < d->n; i++) {
            leading += d->suspect[i].led != NULL;
        }
        diag__pair pair;
        ck_assert_stein(diag__along(d, &pair, err));
        ck_assert_int_ge(leading, 1);
        ck_assert(n == 2 || pair.first < 0);
        if (n == 2) {
            ck_assert_int_ge(pair.first, 0);
            const char *first = d->suspect[pair.first].s.candidate.effect->kind,
                       *second = pair.second.effect->kind;
            printf("%d lead; %s, then %s\n", leading, first, second);
            ck_assert(strcmp(first, "coulomb_friction") == 0 || strcmp(first, "preload") == 0);
            ck_assert(strcmp(second, "coulomb_friction") == 0 || strcmp(second, "preload") == 0);
            ck_assert_str_ne(first, second);
        }
        free(pair.x);
        close_bench(&b);
    }
}
END_TEST

/* the same from the race to the verdict, with a search of whole swings in which nobody was fitted
 */
START_TEST(a_pair_along_the_strokes_is_searched_for_again_and_stands)
{
    bench b;
    diag *d = &b.d;
    open_bench(&b, two, 2, 2800);
    diag__held before = {.rmse = NAN};
    diag__found found;
    ck_assert_stein(diag__look_early(d, err));
    ck_assert_stein(diag__race(d, err));
    ck_assert_stein(diag__changes(d, err));
    ck_assert_stein(diag__rank(d, err));
    ck_assert_stein(
        diag__likelihood(&d->p, d->x, d->J, d->r, d->null_D, d->sd, &d->null_objective, NULL, err));
    ck_assert_stein(diag__held_out(d, NULL, &before, err));
    ck_assert_stein(diag__two_along(d, &before, &found, err));
    ck_assert_int_eq(found.n, 2);
    ck_assert_double_lt(found.chi2_dof, 1.1);
    for (int i = 0; i < 2; i++) {
        double x[FIT__NUMBERS], sd[FIT__NUMBERS];
        const lab_candidate *c = &found.cause[i].candidate;
        int rubs = strcmp(c->effect->kind, "coulomb_friction") == 0;
        diag__amount(&found, i, x, sd);
        ck_assert(rubs || strcmp(c->effect->kind, "preload") == 0);
        ck_assert_double_eq_tol(x[0] * c->limit, rubs ? 2e-3 : 4e-3, 4.0 * sd[0] * c->limit);
    }
    diag__found_free(&found);
    diag__held_free(&before);
    close_bench(&b);
}
END_TEST

/* A null fit found a stroke's friction two sd off and yet no scatter: with the variances it says,
 * that number costs millions, and any curve would gain them by letting it go. */
START_TEST(a_law_gains_nothing_by_numbers_beyond_their_variances)
{
    bench b;
    open_bench(&b, nothing, 1, 2500);
    diag *d = &b.d;
    int k = d->p.np;
    while (d->p.unknown[k].kind != FIT__SCATTER) {
        k++;
    }
    d->x[k] = 2.0;
    for (int i = 0; i < LAB_SCATTERS; i++) {
        d->null_D[i] = 1e-9;
    }
    diag__held before = {.rmse = 1.0};
    diag__found found = {.n = 0, .end = d};
    b.out->verdict = LAB_VERDICT_UNKNOWN_EFFECT;
    diag__suspect *part = suspect(d, "axis_translation"); // as if it had been fitted
    part->s.refitted = 1;
    part->objective = 0.0;
    part->s.chi2_dof = 7.5;
    ck_assert_stein(diag__unknown_law(d, &before, &found, err));
    ck_assert_ptr_nonnull(d->curves);
    ck_assert_int_gt(d->curves->nsite, 0);
    printf("the best curve gains %.1f\n", d->curves->curve[0].gain);
    ck_assert_double_lt(d->curves->curve[0].gain, 30.0);
    ck_assert_ptr_nonnull(strstr(b.out->reason, "No state function of those tried explains it"));
    ck_assert_ptr_nonnull(
        strstr(b.out->reason, "Nor does a degree of freedom more: axis_translation at rod leaves "
                              "chi2/dof 7.5."));
    b.found = found;
    close_bench(&b);
}
END_TEST

/* as in a fit of numbers (strays.c), with a curve beside them */
START_TEST(a_swing_that_the_fit_of_a_law_has_lost_is_called_back)
{
    enum { LOST = 4 };
    bench b;
    open_bench(&b, nothing, 1, 2600);
    diag *d = &b.d;
    diag__held before = {.rmse = 1.0};
    diag__found found = {.n = 0, .end = d};
    ck_assert_stein(diag__unknown_law(d, &before, &found, err));
    diag__curves *w = d->curves;
    diag__curve *c = &w->curve[0];
    ck_assert(c->fitted);
    ck_assert_double_lt(diag__curve_chi2_dof(d, w, c), 1.2);

    int k = w->p.stroke[LOST].first, failed = 0;
    while (w->p.unknown[k].kind != FIT__OFFSET) {
        k++;
    }
    double kept = c->x[k];
    c->x[k] += 5.0;
    ck_assert_stein(fit__residuals(&w->p, c->x, c->r, &failed, err));
    ck_assert_double_gt(diag__curve_chi2_dof(d, w, c), 1.5);
    c->gain -= 1000.0; // of where it stands now
    double lost = c->gain;
    int strays = 0, better = 0;
    ck_assert_stein(diag__curve_recall(d, w, c, INFINITY, 1, &strays, &better, err));
    ck_assert(strays == 1 && better);
    ck_assert_double_lt(fabs(c->x[k] - kept), 1.0);
    ck_assert_double_lt(diag__curve_chi2_dof(d, w, c), 1.2);
    ck_assert_double_gt(c->gain, lost);

    ck_assert_stein(diag__curve_recall(d, w, c, INFINITY, 1, &strays, &better, err));
    ck_assert_int_eq(better, 0); // nobody is lost now, and it has ended
    b.found = found;
    close_bench(&b);
}
END_TEST

Suite *race_suite(void)
{
    Suite *suite = suite_create("race");
    TCase *tc = tcase_create("race");
    tcase_add_checked_fixture(tc, make_folder, remove_folder);
    tcase_set_timeout(tc, 60);
    tcase_add_test(tc, what_is_missing_wins_the_race);
    tcase_add_test(tc, who_explains_no_more_than_others_do_is_no_begin);
    tcase_add_test(tc, a_race_that_leaves_more_than_noise_says_that_one_suspect_is_not_enough);
    tcase_add_test(tc, a_hasty_search_waits_where_its_leader_leaves_more);
    tcase_add_test(tc, who_led_elsewhere_is_asked_again);
    tcase_add_test(tc, a_fit_that_explains_nothing_of_what_shows_early_is_given_up);
    tcase_add_test(tc, a_fit_that_is_to_leave_but_noise_is_given_up_where_it_leaves_more);
    tcase_add_test(tc, a_fit_that_falls_behind_the_best_one_is_given_up);
    tcase_add_test(tc, strays_that_come_back_leave_what_others_do);
    tcase_add_test(
        tc, what_explains_how_strokes_begin_is_one_of_two_though_fits_of_whole_ones_led_nowhere);
    tcase_add_test(tc, two_causes_are_found_in_the_order_in_which_strokes_show_them);
    tcase_add_test(tc, a_pair_along_the_strokes_is_searched_for_again_and_stands);
    tcase_add_test(tc, what_has_brought_nothing_is_not_done_again_from_there);
    tcase_add_test(tc, strokes_one_by_one_end_where_they_end_whoever_is_beside_them);
    tcase_add_test(tc, a_swing_that_the_fit_of_a_law_has_lost_is_called_back);
    tcase_add_test(tc, a_law_gains_nothing_by_numbers_beyond_their_variances);
    suite_add_tcase(suite, tc);
    return suite;
}
