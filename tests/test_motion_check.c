/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_motion_check.c - the motion-driven check: forces under a measured motion support what is
 * right, depart where it is wrong, and say so where they cannot tell.
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

/* a set with something hidden: `film` is the end of the program's arguments */
static void film_set(const char *film, const char *const held[STROKES + 1], fitted *f)
{
    const char *build = getenv("STEIN_BUILD");
    char *command = lab__text("%s/reality --model %s --clean %s -o %s >%s 2>&1",
                              build != NULL ? build : "build", action, film, in_folder("set"),
                              in_folder("said"));
    ck_assert_int_eq(system(command), 0);
    open_fit(f, action, NULL, held);
    free(command);
}

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

static lab_candidate candidate(const lab_model *model, const char *kind, const char *place)
{
    lab_candidate *list = NULL, found = {.effect = NULL};
    int n = 0;
    ck_assert_stein(lab_candidates(&list, &n, model, err));
    for (int i = 0; i < n; i++) {
        if (strcmp(list[i].effect->kind, kind) == 0 && strcmp(list[i].place, place) == 0) {
            found = list[i];
        }
    }
    free(list);
    ck_assert_msg(found.effect != NULL, "there is no %s at %s", kind, place);
    return found;
}

static void fit_model(models *m, int i, const lab_candidate *effect)
{
    fit__problem *p = &m->p[i];
    int failed = 0;
    ck_assert_stein(fit__problem_make_with(p, m->f.model, m->f.data, &m->def, NULL, 0, err));
    fit__problem_try(p, effect);
    p->tolerance = 1e-9;
    size_t nu = (size_t)p->nu, rows = fit__offset(p, p->nstroke);
    double *x = m->room[i] = calloc(2 * nu + rows + 1, sizeof *x);
    fit__state state = {.x = x, .step = x + nu, .mu = 1e-3, .nu = 2.0};
    for (size_t k = 0; k < nu; k++) {
        state.step[k] = p->step[k];
    }
    if (effect != NULL) {
        x[p->amount] = 0.1;
    }
    ck_assert_stein(fit__minimise(p, &state, 1e-2, 1e-5, 12, NULL, NULL, err));
    ck_assert_stein(fit__residuals(p, x, x + 2 * nu, &failed, err));
    ck_assert_int_eq(failed, 0);
    m->side[i] = (diag__side){p, x, x + 2 * nu};
}

static void ask(models *m, const char *kind, const char *place, lab_verdict verdict)
{
    static const char *const names[] = {"hammer.inertia.yy", "key.inertia.yy", NULL};
    m->def = free_these(names);
    m->def.scatter = 0;
    fit_model(m, 0, NULL);
    m->phase = calloc(diag__row(&m->p[0], m->p[0].nstroke), sizeof *m->phase);
    ck_assert_stein(diag__phases(&m->p[0], m->side[0].x, m->phase, NULL, err));
    if (kind != NULL) {
        m->effect = candidate(m->f.model, kind, place);
        fit_model(m, 1, &m->effect);
    }
    ck_assert_stein(diag__motion_check(&m->side[0], kind != NULL ? &m->side[1] : NULL, m->phase,
                                       verdict, 0, &m->out, err));
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
