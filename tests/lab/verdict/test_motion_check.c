/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_motion_check.c - the motion-driven check: forces under a measured motion support a correct
 * model, contradict a wrong one, and are reported as undecided where noise hides the difference.
 *
 * The strokes are filmed by the independent program (tests/reality). What is fitted here is little,
 * so that each model's best is quickly found: two inertias, the effect, the strokes' own.
 */
#include <math.h>

#include "fit_support.h"
#include "motion.h"
#include "suites.h"

enum { STROKES = 6 };
static const char action[] = "models/stein1788.yaml";

/* ---- strokes and models ---- */

/* strokes, and a model fitted to them without and with an effect */
typedef struct models {
    fitted f;
    lab_fit_def def;
    lab_candidate effect;
    fit__problem p[2];
    double *room[2];
    diag__side side[2];
    const char **phase;
    lab_motion out;
} models;

static void fit_model(models *m, int i, const lab_candidate *effect)
{
    fit__problem *p = &m->p[i];
    int failed = 0;
    ck_assert_stein(fit__problem_make_with(p, m->f.model, m->f.data, &m->def, NULL, 0, err));
    fit__problem_try(p, effect);
    p->tolerance = 1e-9;
    size_t nu = (size_t)p->nu, rows = fit__offset(p, p->nstroke);
    double *x = m->room[i] = calloc(3 * nu + rows + 1, sizeof *x);
    fit__state state = {.x = x, .step = x + nu, .scale = x + 2 * nu, .mu = 1e-3, .nu = 2.0};
    for (size_t k = 0; k < nu; k++) {
        state.step[k] = p->step[k];
    }
    if (effect != NULL) {
        x[p->amount] = 0.1;
    }
    ck_assert_stein(fit__minimise(p, &state, 1e-2, 1e-5, 12, NULL, NULL, err));
    ck_assert_stein(fit__residuals(p, x, x + 3 * nu, &failed, err));
    ck_assert_int_eq(failed, 0);
    m->side[i] = (diag__side){p, x, x + 3 * nu};
}

/* both models fitted (by m->def), and the check of them; kind NULL: nothing is added */
static void fit_and_ask(models *m, const char *kind, const char *place, lab_verdict verdict)
{
    fit_model(m, 0, NULL);
    m->phase = calloc(diag__frame(&m->p[0], m->p[0].nstroke), sizeof *m->phase);
    ck_assert_stein(diag__phases(&m->p[0], m->side[0].x, m->phase, NULL, err));
    if (kind != NULL) {
        m->effect = candidate(m->f.model, kind, place);
        fit_model(m, 1, &m->effect);
    }
    ck_assert_stein(diag__motion_check(&m->side[0], kind != NULL ? &m->side[1] : NULL, m->phase,
                                       verdict, 0, &m->out, err));
}

static void ask(models *m, const char *kind, const char *place, lab_verdict verdict)
{
    static const char *const names[] = {"hammer.inertia.yy", "key.inertia.yy", NULL};
    m->def = free_these(names);
    m->def.scatter = 0;
    fit_and_ask(m, kind, place, verdict);
}

static void show(const models *m)
{
    const lab_motion *o = &m->out;
    for (int i = 0; i < 2 && m->side[i].p != NULL; i++) {
        printf("  chi2/dof %.3f", fit__chi2_dof(m->side[i].p, m->side[i].r));
    }
    printf("\n  %s: %s; %d strokes\n", lab_motion_text(o->says), o->why, o->strokes);
    const lab_motion_part *part[] = {&o->of_force, &o->of_channels, &o->all};
    for (int i = 0; i < 3 && o->nrow > 0; i++) {
        printf("  %s: %.2f -> %.2f, z %.1f -> %.1f, share %.3f +- %.3f\n",
               lab_motion_text(part[i]->says), part[i]->before, part[i]->after, part[i]->z_before,
               part[i]->z_after, part[i]->share, part[i]->share_sd);
    }
    for (int i = 0; i < o->nrow; i++) {
        const lab_motion_row *r = &o->row[i];
        printf("    %-16s %-12s %5d there %.3g before %.3g after %.3g noise %.3g; mean %.2g %.2g "
               "+- %.2g\n",
               r->channel != NULL ? r->channel : "force", r->phase != NULL ? r->phase : "all",
               r->samples, r->present, r->before, r->after, r->noise, r->mean_before, r->mean_after,
               r->mean_sd);
    }
}

static void drop_models(models *m)
{
    for (int i = 0; i < 2; i++) {
        if (m->side[i].p != NULL) {
            fit__problem_free(&m->p[i]);
        }
        free(m->room[i]);
    }
    free(m->phase);
    diag__motion_free(&m->out);
    drop(&m->f);
}

/* ---- strokes of the piano action ---- */

static char *held[2][STROKES + 1]; /* friction at the key's pin, far above the noise; nothing */

/* both sets, once for all tests */
static void film_sets(void)
{
    static const char *const hidden[] = {"--seed 5 --kind coulomb_friction --place key --level L1",
                                         "--seed 5 --null"};
    const char *build = getenv("STEIN_BUILD");
    make_folder();
    for (int k = 0; k < 2; k++) {
        char *set = lab__text("%s/%s", folder, k == 0 ? "friction" : "nothing");
        char *command = lab__text("%s/reality --model %s --clean %s -o %s >%s/said 2>&1",
                                  build != NULL ? build : "build", action, hidden[k], set, folder);
        ck_assert_int_eq(system(command), 0);
        for (int i = 0; i < STROKES; i++) {
            held[k][i] = lab__text("%s/held_%02d.csv", set, i + 1);
        }
        free(command);
        free(set);
    }
}

static void drop_sets(void)
{
    for (int i = 0; i < 2 * STROKES; i++) {
        free(held[i / STROKES][i % STROKES]);
    }
    remove_folder();
}

/* the check of a set with an effect (NULL: none) added */
static void open_set(models *m, int set, const char *kind, const char *place, lab_verdict verdict)
{
    *m = (models){.phase = NULL};
    open_fit(&m->f, action, NULL, (const char *const *)held[set]);
    ask(m, kind, place, verdict);
    printf("%s, %s at %s:\n", set == 0 ? "friction at the key" : "nothing hidden",
           kind != NULL ? kind : "nothing", place != NULL ? place : "-");
    show(m);
    ck_assert_int_eq(m->out.strokes, STROKES);
    ck_assert_str_eq(m->out.input, "key_motion");
    ck_assert_str_eq(m->out.channel, "key_dip");
    ck_assert_str_eq(m->out.force, "key_force");
    ck_assert_str_eq(m->out.unit, "N m");
}

START_TEST(the_right_cause_is_supported)
{
    models m;
    open_set(&m, 0, "coulomb_friction", "key", LAB_VERDICT_MISSING_EFFECT);
    const lab_motion *o = &m.out;
    ck_assert_int_eq(o->says, LAB_MOTION_SUPPORTS);
    ck_assert_int_eq(o->of_force.says, LAB_MOTION_SUPPORTS);
    ck_assert_double_lt(o->of_force.share_sd, 0.15); // and not because nothing could be seen
    ck_assert_double_lt(fabs(o->of_force.share - 1.0), 3.0 * o->of_force.share_sd);
    ck_assert_double_lt(fabs(o->of_channels.share - 1.0), 3.0 * o->of_channels.share_sd);
    ck_assert_double_gt(o->of_force.z_before, 4.0);
    ck_assert_double_lt(o->of_force.z_after, 3.0);
    ck_assert_double_lt(o->row[0].after, 0.85 * o->row[0].before);
    // what is left is the noise that was foretold
    ck_assert_close(o->row[0].after, o->row[0].noise, 0.25, 0.0);
    ck_assert_double_lt(fabs(o->row[0].mean_after), 4.0 * o->row[0].mean_sd);
    ck_assert_double_gt(fabs(o->row[0].mean_before), 5.0 * o->row[0].mean_sd);
    drop_models(&m);
}
END_TEST

START_TEST(a_law_of_another_form_is_contradicted)
{
    models m; // a torque that does not turn round with the motion: positions, too, like it better
    open_set(&m, 0, "preload", "key", LAB_VERDICT_MISSING_EFFECT);
    ck_assert_double_lt(fit__chi2_dof(&m.p[1], m.side[1].r),
                        0.8 * fit__chi2_dof(&m.p[0], m.side[0].r));
    ck_assert_int_eq(m.out.says, LAB_MOTION_CONTRADICTS);
    drop_models(&m);
}
END_TEST

START_TEST(a_model_without_the_effect_departs)
{
    models m;
    open_set(&m, 0, NULL, NULL, LAB_VERDICT_EXPLAINED); // which is wrong
    ck_assert_int_eq(m.out.says, LAB_MOTION_CONTRADICTS);
    ck_assert_double_gt(m.out.of_force.z_before, 4.0);
    ck_assert(isnan(m.out.row[0].after));
    drop_models(&m);
    open_set(&m, 0, NULL, NULL, LAB_VERDICT_UNKNOWN_EFFECT);
    ck_assert_int_eq(m.out.says, LAB_MOTION_SUPPORTS);
    drop_models(&m);
}
END_TEST

START_TEST(nothing_departs_where_nothing_is_hidden)
{
    models m;
    open_set(&m, 1, NULL, NULL, LAB_VERDICT_EXPLAINED);
    const lab_motion *o = &m.out;
    ck_assert_int_eq(o->says, LAB_MOTION_SUPPORTS);
    ck_assert_double_lt(fabs(o->of_force.z_before), 4.0);
    ck_assert_double_lt(fabs(o->all.z_before), 4.0);
    ck_assert_close(o->row[0].before, o->row[0].noise, 0.25, 0.0);
    for (int i = 0; i < o->nrow; i++) {
        const lab_motion_row *r = &o->row[i];
        ck_assert_msg(fabs(r->mean_before) < 4.0 * r->mean_sd, "%s, %s",
                      r->channel != NULL ? r->channel : "force", r->phase);
    }
    // the load's weight at its lever and what it takes to speed it up
    ck_assert(o->n > 300 && o->row[0].present > 0.1 && o->row[0].present < 1.0);
    drop_models(&m);
}
END_TEST

START_TEST(an_effect_below_noise_cannot_be_decided)
{
    models m; // fitted where there is none: so small that no force shows it
    open_set(&m, 1, "coulomb_friction", "key", LAB_VERDICT_MISSING_EFFECT);
    ck_assert_int_eq(m.out.says, LAB_MOTION_CANNOT_TELL);
    ck_assert_double_gt(m.out.of_force.share_sd, 1.0);
    drop_models(&m);
}
END_TEST

START_TEST(it_draws_the_same_twice)
{
    models a, b;
    open_set(&a, 0, NULL, NULL, LAB_VERDICT_UNKNOWN_EFFECT);
    open_set(&b, 0, NULL, NULL, LAB_VERDICT_UNKNOWN_EFFECT);
    ck_assert_int_eq(memcmp(&a.out.of_force, &b.out.of_force, sizeof a.out.of_force), 0);
    ck_assert_int_eq(memcmp(a.out.before, b.out.before, sizeof(double) * (size_t)a.out.n), 0);
    drop_models(&a);
    drop_models(&b);
}
END_TEST

/* ---- a motion that was prescribed, with its force ---- */

static const char axis[] = "mechanism: axis\n"
                           "bodies:\n"
                           "  slide: {joint: T x, mass: 95 kg, coulomb: {T: 0 N, w: 5 mm/s}}\n"
                           "inputs:\n"
                           "  slide_motion: {motion: slide, idle: hold}\n"
                           "outputs:\n"
                           "  slide_force: {input: slide_motion, read: force}\n"
                           "  place: {joint: slide, read: position}\n"
                           "simulation: {dt: 1 ms, until: 2 s}\n";

/* it begins and ends gently: where a record breaks off in motion smoothing errs */
static double swing(double t)
{
    double s = sin(2.617994 * t);
    return 0.015 * (1.0 - cos(9.5 * t)) * s * s * s * s;
}

/* a slide that is swung 30 mm to and fro, with friction; measured: place and force */
static const char *film_axis(const char *name, double friction, int with_force)
{
    const char *path = in_folder(name);
    unsigned long long seed = 11;
    FILE *f = fopen(path, "w");
    ck_assert_ptr_nonnull(f);
    fprintf(f, "# noise slide_motion: 2e-6\n%stime [s],slide_motion [m],%s\n",
            with_force ? "# noise slide_force: 0.5\n" : "# noise place: 2e-6\n",
            with_force ? "slide_force [N]" : "place [m]");
    for (int i = 0; i < 1200; i++) {
        double t = 1e-3 * i, h = 1e-4, x = swing(t), before = swing(t - h), after = swing(t + h);
        double v = (after - before) / (2.0 * h), a = (after - 2.0 * x + before) / (h * h);
        double force = 95.0 * a + friction * tanh(v / 5e-3) + 0.5 * gauss(&seed);
        fprintf(f, "%.17g,%.17g,%.17g\n", t, x + 2e-6 * gauss(&seed),
                with_force ? force : x + 2e-6 * gauss(&seed));
    }
    ck_assert_int_eq(fclose(f), 0);
    return path;
}

static void ask_axis(models *m, const char *const *data, const char *kind, lab_verdict verdict)
{
    static const char *const names[] = {"slide.mass", NULL};
    *m = (models){.phase = NULL};
    open_fit(&m->f, in_folder("axis.yaml"), NULL, data);
    m->def = free_these(names);
    m->def.scatter = 0;
    fit_and_ask(m, kind, "slide", verdict);
}

START_TEST(a_recorded_force_is_compared)
{
    models m;
    write_file("axis.yaml", axis);
    const char *const data[] = {film_axis("a.csv", 20.0, 1), NULL};
    ask_axis(&m, data, "coulomb_friction", LAB_VERDICT_MISSING_EFFECT);
    show(&m);
    ck_assert_int_eq(m.out.says, LAB_MOTION_SUPPORTS);
    ck_assert_ptr_null(m.out.channel);
    ck_assert_str_eq(m.out.unit, "N");
    ck_assert_close(m.out.row[0].before, 20.0, 0.2, 0.0);
    ck_assert_close(m.out.row[0].after, m.out.row[0].noise, 0.5, 0.0);
    ck_assert_double_lt(fabs(m.out.of_force.share - 1.0), 0.05);
    drop_models(&m);
    // viscous friction is not it
    ask_axis(&m, data, "viscous_friction", LAB_VERDICT_MISSING_EFFECT);
    show(&m);
    ck_assert_int_eq(m.out.says, LAB_MOTION_CONTRADICTS);
    drop_models(&m);
}
END_TEST

/* ---- where there is no way ---- */

static void ck_assert_no_way(models *m, const char *phrase)
{
    ck_assert_int_eq(m->out.says, LAB_MOTION_NOT_DONE);
    ck_assert_msg(strstr(m->out.why, phrase) != NULL, "%s", m->out.why);
    drop_models(m);
}

static void ask_film(models *m, const char *model, const char *channels, lab_verdict verdict)
{
    static const char *const names[] = {NULL};
    film f = {.model = model,
              .channels = channels,
              .rate = 1000.0,
              .until = 0.05,
              .noise = 1e-5,
              .seed = 3};
    const char *const data[] = {take("film.csv", &f), NULL};
    *m = (models){.phase = NULL};
    open_fit(&m->f, model, NULL, data);
    m->def = free_these(names);
    fit_and_ask(m, NULL, NULL, verdict);
}

START_TEST(an_impossible_check_states_its_reason)
{
    models m;
    ask_film(&m, action, "string_distance key_dip", LAB_VERDICT_NOT_CONVERGED);
    ck_assert_no_way(&m, "no fit has converged");
    ask_film(&m, action, "string_distance hammer_height", LAB_VERDICT_EXPLAINED);
    ck_assert_no_way(&m, "no measured channel shows the motion of key alone");
    ask_film(&m, "models/pendulum.yaml", "angle", LAB_VERDICT_EXPLAINED);
    ck_assert_no_way(&m, "the file has no input that prescribes a motion");
    ask_film(&m, write_file("falling.yaml", falling), "gap", LAB_VERDICT_EXPLAINED);
    ck_assert_no_way(&m, "no output is the force that lift needs");
    write_file("axis.yaml", axis);
    const char *const data[] = {film_axis("b.csv", 0.0, 0), NULL};
    ask_axis(&m, data, NULL, LAB_VERDICT_EXPLAINED);
    ck_assert_no_way(&m, "no channel of theirs is the force that it needed");
}
END_TEST

Suite *motion_check_suite(void)
{
    Suite *suite = suite_create("motion_check");
    TCase *strokes = tcase_create("strokes");
    tcase_add_unchecked_fixture(strokes, film_sets, drop_sets);
    tcase_set_timeout(strokes, 120);
    tcase_add_test(strokes, the_right_cause_is_supported);
    tcase_add_test(strokes, a_law_of_another_form_is_contradicted);
    tcase_add_test(strokes, a_model_without_the_effect_departs);
    tcase_add_test(strokes, nothing_departs_where_nothing_is_hidden);
    tcase_add_test(strokes, an_effect_below_noise_cannot_be_decided);
    tcase_add_test(strokes, it_draws_the_same_twice);
    suite_add_tcase(suite, strokes);
    TCase *ways = tcase_create("ways");
    tcase_add_checked_fixture(ways, make_folder, remove_folder);
    tcase_set_timeout(ways, 120);
    tcase_add_test(ways, a_recorded_force_is_compared);
    tcase_add_test(ways, an_impossible_check_states_its_reason);
    suite_add_tcase(suite, ways);
    return suite;
}
