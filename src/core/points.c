/* SPDX-License-Identifier: MIT
 * points.c - how points of bodies that leave the plane move along a direction of q and qd, for the
 * derivatives of forces that act there (derivative.c).
 *
 *      dx = J dq      dJ = H dq      dv = J dqd + dJ qd
 *
 * H_ij = d2x / dq_i dq_j is in the generated Jdot qd, which is the quadratic form of it in qd. So
 *
 *      H_ii = (Jdot qd)(e_i)      2 H_ij = (Jdot qd)(e_i + e_j) - H_ii - H_jj
 *
 * is exact, and nothing more has to be generated.
 */
#include <string.h>

#include "slopes.h"

int stein__points_matter(const stein_model *model)
{
    int found = 0;
    for (int i = 0; i < model->nlink; i++) {
        const stein_link *link = &model->links[i];
        found |= model->points[link->point[0]].at < 0 || model->points[link->point[1]].at < 0;
    }
    for (int i = 0; i < model->ninput; i++) {
        const stein_input *input = &model->inputs[i];
        found |= input->kind == STEIN_INPUT_POINT && model->points[input->index].at < 0;
    }
    return found;
}

void stein__points_carve(stein__points *p, stein__arena *a, const stein_model *m)
{
    int rows = stein__points_matter(m) ? 3 * m->npoint : 0, n = rows > 0 ? m->nq : 0;
    double **const vector[] = {&p->x, &p->v, &p->a, &p->dx, &p->dv};
    double **const matrix[] = {&p->J, &p->dJ, &p->waste};
    for (size_t i = 0; i < sizeof vector / sizeof *vector; i++) {
        *vector[i] = stein__carve_doubles(a, rows);
    }
    for (size_t i = 0; i < sizeof matrix / sizeof *matrix; i++) {
        *matrix[i] = stein__carve_doubles(a, rows * n);
    }
    p->H = stein__carve_doubles(a, rows * n * n);
    p->unit = stein__carve_doubles(a, n);
}

/* Jdot qd with the speeds in unit, into p->a */
static void form(stein_derivative *s)
{
    stein__points *p = &s->points;
    const stein_sim *sim = s->sim;
    s->model->point(sim->xq, p->unit, sim->sc, sim->d, p->dx, p->dv, p->waste, p->a);
}

void stein__points_place(stein_derivative *s)
{
    stein__points *p = &s->points;
    const stein_model *model = s->model;
    int n = model->nq, rows = 3 * model->npoint;
    memcpy(p->x, s->sim->px, sizeof *p->x * (size_t)rows);
    memcpy(p->v, s->sim->pv, sizeof *p->v * (size_t)rows);
    memcpy(p->J, s->sim->pJ, sizeof *p->J * (size_t)(rows * n));
    memset(p->unit, 0, sizeof *p->unit * (size_t)n);
    for (int i = 0; i < n; i++) {
        p->unit[i] = 1.0;
        form(s);
        memcpy(p->H + (i * n + i) * rows, p->a, sizeof *p->a * (size_t)rows);
        for (int j = 0; j < i; j++) {
            const double *ii = p->H + (i * n + i) * rows, *jj = p->H + (j * n + j) * rows;
            double *ij = p->H + (i * n + j) * rows, *ji = p->H + (j * n + i) * rows;
            p->unit[j] = 1.0;
            form(s);
            p->unit[j] = 0.0;
            for (int k = 0; k < rows; k++) {
                ij[k] = ji[k] = 0.5 * (p->a[k] - ii[k] - jj[k]);
            }
        }
        p->unit[i] = 0.0;
    }
}

void stein__points_along(stein_derivative *s)
{
    stein__points *p = &s->points;
    const double *qd = s->sim->xqd;
    int n = s->model->nq, rows = 3 * s->model->npoint;
    memset(p->dJ, 0, sizeof *p->dJ * (size_t)(rows * n));
    for (int i = 0; i < n; i++) {
        for (int j = 0; s->dq[i] != 0.0 && j < n; j++) {
            const double *ij = p->H + (i * n + j) * rows;
            for (int k = 0; k < rows; k++) {
                p->dJ[k * n + j] += ij[k] * s->dq[i];
            }
        }
    }
    for (int k = 0; k < rows; k++) {
        p->dx[k] = p->dv[k] = 0.0;
        for (int j = 0; j < n; j++) {
            p->dx[k] += p->J[k * n + j] * s->dq[j];
            p->dv[k] += p->J[k * n + j] * s->dqd[j] + p->dJ[k * n + j] * qd[j];
        }
    }
}
