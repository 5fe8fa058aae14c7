/* SPDX-License-Identifier: GPL-3.0-or-later
 * stop_sweep.c - one stroke at each of many positions of the pawl's stop, as the study needs it: a
 * batch that keeps the strokes themselves. (stein sweep keeps rows of a table: sweep/sweep.c.)
 */
#include <math.h>

#include "sweep.h"

static const char *const shift = "pawl.stop_shift";

typedef struct sweep {
    lab_point *point;
    int param;
} sweep;

static void set_point(void *ctx, int point, double *p)
{
    const sweep *s = ctx;
    p[s->param] = s->point[point].dx;
}

static stein_status keep_point(void *ctx, int point, stein_sim *sim, const lab_stroke *stroke,
                               stein_status status, stein_err *err)
{
    const sweep *s = ctx;
    lab_point *p = &s->point[point];
    (void)sim, (void)err;
    p->status = status;
    if (status == STEIN_OK) {
        p->stroke = *stroke;
    }
    return status == STEIN_ENOMEM ? STEIN_ENOMEM : STEIN_OK;
}

stein_status lab_sweep(const lab_model *model, lab_point *point, int n, int threads,
                       lab_progress_fn *progress, void *ctx, stein_err *err)
{
    const stein_model *equations = lab_equations(model);
    sweep s = {point, stein_find_param(equations, shift)};
    if (s.param < 0) {
        return lab__fail(err, STEIN_ENAME, "\"%s\" has no parameter %s, which the study varies",
                         equations->name, shift);
    }
    if (equations->stroke.string < 0) {
        return lab__fail(err, STEIN_EINVAL, "\"%s\" names no stroke, which the study needs",
                         equations->name);
    }
    stein_status status = lab__check_points(model, equations->until, NAN, err);
    if (status != STEIN_OK) {
        return status;
    }
    lab__steps steps;
    status = lab__steps_of(&steps, model, NULL, 0, err);
    if (status != STEIN_OK) {
        return status;
    }
    const lab_stroke_def def = lab_stroke_def_default(equations);
    const lab__batch batch = {.model = model,
                              .def = &def,
                              .steps = steps.tolerance > 0.0 ? &steps : NULL,
                              .n = n,
                              .threads = threads,
                              .set = set_point,
                              .run = keep_point,
                              .progress = progress,
                              .progress_ctx = ctx,
                              .ctx = &s};
    return lab__batch_run(&batch, err);
}
