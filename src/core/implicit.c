/* SPDX-License-Identifier: MIT
 * implicit.c - steps of motions that are too stiff for explicit ones.
 *
 * Rodas5P (Steinebach 2023, "Construction of Rosenbrock-Wanner method Rodas5P and numerical
 * benchmarks within the Julia Differential Equations package", BIT 63:27): eight stages, order 5
 * with an embedded method of order 4, both L-stable, and stiffly accurate. A step solves linear
 * systems with one matrix, there is no iteration that might fail. Of y = {q, qd} and f = {qd, qdd},
 * in the form of Hairer & Wanner 1996, IV.7,
 *
 *      (1/(h gamma) - f_y) u_i = f(t_i, y0 + sum of a_ij u_j) + sum of c_ij/h u_j
 *      y1 = y0 + sum of a_8j u_j + u_8, whose error estimate is u_8
 *
 * with the exact f_y = {0, 1; A, B}, A and B being qdd by q and by qd where the step begins. With
 * g = 1/(h gamma) and r = {r_q, r_qd} on the right there are nq unknowns,
 *
 *      (g - B - A/g) u_qd = r_qd + A r_q / g,    u_q = (u_qd + r_q) / g
 *
 * Order 5 rather than Rodas4's 4: with the default tolerance of 1e-12 a step its steps are four
 * times as long, at 8 stages against 6. Errors control the next step by the same exponents as
 * those of Dormand & Prince. Rejected: BDF, which begins again with order 1 at every
 * contact; implicit Runge-Kutta, whose Newton iterations cost more here than exact derivatives.
 */
#include <math.h>
#include <string.h>

#include "slopes.h"

enum { STAGES = 8 };

static const double gamma_ = 0.21193756319429014;
static const double when[STAGES] = {
    0.0, 0.6358126895828704, 0.4095798393397535, 0.9769306725060716, 0.4288403609558664, 1.0, 1.0,
    1.0};
static const double a[STAGES][STAGES - 1] = {
    {0.0},
    {3.0},
    {2.849394379747939, 0.45842242204463923},
    {-6.954028509809101, 2.489845061869568, -10.358996098473584},
    {2.8029986275628964, 0.5072464736228206, -0.3988312541770524, -0.04721187230404641},
    {-7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256,
     0.030198172008377946},
    {-7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256,
     0.030198172008377946, 1.0},
    {-7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256,
     0.030198172008377946, 1.0, 1.0}};
static const double c[STAGES][STAGES - 1] = {
    {0.0},
    {-14.155112264123755},
    {-17.97296035885952, -2.859693295451294},
    {147.12150275711716, -1.41221402718213, 71.68940251302358},
    {165.43517024871676, -0.4592823456491126, 42.90938336958603, -5.961986721573306},
    {24.854864614690072, -3.0009227002832186, 47.4931110020768, 5.5814197821558125,
     -0.6610691825249471},
    {30.91273214028599, -3.1208243349937974, 77.79954646070892, 34.28646028294783,
     -19.097331116725623, -28.087943162872662},
    {37.80277123390563, -3.2571969029072276, 112.26918849496327, 66.9347231244047,
     -40.06618937091002, -54.66780262877968, -9.48861652309627}};

/* dense output: see dense_output.c */
static const double dense[3][STAGES] = {
    {25.948786856663858, -2.5579724845846235, 10.433815404888879, -2.3679251022685204,
     0.524948541321073, 1.1241088310450404, 0.4272876194431874, -0.17202221070155493},
    {-9.91568850695171, -0.9689944594115154, 3.0438037242978453, -24.495224566215796,
     20.176138334709044, 15.98066361424651, -6.789040303419874, -6.710236069923372},
    {11.419903575922262, 2.8879645146136994, 72.92137995996029, 80.12511834622643,
     -52.072871366152654, -59.78993625266729, -0.15582684282751913, 4.883087185713722}};

typedef struct work {
    stein__implicit door; /* comes first */
    stein_derivative *slopes;
    double *A, *B, *W; /* [nq*nq] */
    double *u;         /* [STAGES][2*nq] */
    double *z;         /* [2*nq] */
} work;

static work *work_of(const stein_sim *sim)
{
    return (work *)(void *)sim->implicit;
}

static size_t layout(work *s, const stein_model *m)
{
    work measured = {.slopes = NULL};
    stein__arena arena = {(unsigned char *)s, 0};
    int n = m->nq;
    s = s != NULL ? s : &measured;
    stein__carve(&arena, sizeof *s);
    s->A = stein__carve_doubles(&arena, n * n);
    s->B = stein__carve_doubles(&arena, n * n);
    s->W = stein__carve_doubles(&arena, n * n);
    s->u = stein__carve_doubles(&arena, STAGES * 2 * n);
    s->door.dense = stein__carve_doubles(&arena, 3 * 2 * n);
    s->z = stein__carve_doubles(&arena, 2 * n);
    s->slopes = stein__carve(&arena, stein__derivative_size(m));
    return arena.used;
}

/* ---- a step ---- */

/* A and B where the step begins; one that is tried again finds them there */
static stein_status derive(stein_sim *sim, stein_err *err)
{
    work *s = work_of(sim);
    stein_status status = STEIN_OK;
    if (!s->door.placed) {
        status = stein__derivative_at(s->slopes, sim, sim->head->t, sim->q, sim->qd, NULL, err);
    }
    if (status == STEIN_OK && !s->door.placed) {
        stein_derivative_by_state(s->slopes, s->A, s->B);
        s->door.placed = 1;
    }
    return status;
}

static int factor(stein_sim *sim, double g)
{
    const work *s = work_of(sim);
    int n = sim->model->nq;
    for (int i = 0; i < n * n; i++) {
        s->W[i] = (i % (n + 1) == 0 ? g : 0.0) - s->B[i] - s->A[i] / g;
    }
    return stein__factor_general(n, s->W, sim->pivot);
}

/* x += sum of w_j u_j over the first m stages */
static void add_stages(const work *s, int size, const double *w, int m, double *x)
{
    for (int j = 0; j < m; j++) {
        const double *u = s->u + j * size;
        for (int i = 0; w[j] != 0.0 && i < size; i++) {
            x[i] += w[j] * u[i];
        }
    }
}

/* u_i from f = {xqd, qdd} of its stage, qdd being in the second half of u_i */
static void solve_stage(stein_sim *sim, int i, double h, double g)
{
    const work *s = work_of(sim);
    int n = sim->model->nq;
    double *u = s->u + i * 2 * n, *uq = u, *uqd = u + n, over_h[STAGES - 1];
    copy(uq, sim->xqd, n);
    for (int j = 0; j < i; j++) {
        over_h[j] = c[i][j] / h;
    }
    add_stages(s, 2 * n, over_h, i, u);
    for (int k = 0; k < n; k++) {
        double sum = 0.0;
        for (int j = 0; j < n; j++) {
            sum += s->A[k * n + j] * uq[j];
        }
        uqd[k] += sum / g;
    }
    stein__substitute_general(n, s->W, sim->pivot, uqd);
    for (int k = 0; k < n; k++) {
        uq[k] = (uqd[k] + uq[k]) / g;
    }
}

static stein_status make_stages(stein_sim *sim, double t, double h, double g, stein_err *err)
{
    const work *s = work_of(sim);
    int n = sim->model->nq;
    stein_status status = STEIN_OK;
    for (int i = 0; status == STEIN_OK && i < STAGES; i++) {
        double *qdd = s->u + i * 2 * n + n;
        copy(sim->xq, sim->q0, n);
        copy(sim->xqd, sim->qd0, n);
        add_stages(s, 2 * n, a[i], i, sim->x);
        if (i == 0) {
            copy(qdd, sim->qdd0, n);
        } else {
            sim->inside = 1;
            status = stein__evaluate(sim, t + when[i] * h, sim->xq, sim->xqd, qdd, err);
            sim->inside = 0;
        }
        solve_stage(sim, i, h, g);
    }
    return status;
}

static stein_status trial(stein_sim *sim, double h, stein_err *err)
{
    const work *s = work_of(sim);
    int n = sim->model->nq;
    double t = sim->head->t, g = 1.0 / (h * gamma_);
    const double *last = s->u + (STAGES - 1) * 2 * n;
    copy(sim->q0, sim->q, n);
    copy(sim->qd0, sim->qd, n);
    copy(sim->qdd0, sim->qdd, n);
    stein_status status = derive(sim, err);
    if (status == STEIN_OK && factor(sim, g) != 0) {
        status = stein__fail(err, STEIN_ESINGULAR,
                             "an implicit step of %g s at t = %g s is singular", h, t);
    }
    status = status == STEIN_OK ? make_stages(sim, t, h, g, err) : status;
    if (status != STEIN_OK) {
        return status;
    }
    memset(s->door.dense, 0, sizeof *s->door.dense * (size_t)(3 * 2 * n));
    for (int i = 0; i < 3; i++) {
        add_stages(s, 2 * n, dense[i], STAGES, s->door.dense + i * 2 * n);
    }
    for (int i = 0; i < n; i++) { // the last stage is still in x
        sim->q1[i] = sim->xq[i] + last[i];
        sim->qd1[i] = sim->xqd[i] + last[n + i];
    }
    status = stein__evaluate(sim, t + h, sim->q1, sim->qd1, sim->qdd1, err);
    sim->eq = sim->eqd = 0.0;
    for (int i = 0; i < n; i++) {
        sim->eq = fabs(last[i]) > sim->eq || isnan(last[i]) ? fabs(last[i]) : sim->eq;
        sim->eqd =
            fabs(last[n + i]) > sim->eqd || isnan(last[n + i]) ? fabs(last[n + i]) : sim->eqd;
    }
    return status;
}

/* h rho of the last step's f_y, by a power iteration in {q, h qd} */
static double h_rho(const stein_sim *sim, double h)
{
    enum { ALL = 12, COUNTED = 6 };
    const work *s = work_of(sim);
    int n = sim->model->nq;
    double *x = s->z, *w = s->z + n, growth = 0.0;
    for (int i = 0; i < n; i++) {
        x[i] = 1.0;
        w[i] = 1.0 / (1.0 + i); // no symmetry
    }
    for (int k = 0; k < ALL; k++) {
        double most = 0.0, *next = s->u; // stages are not needed any more
        for (int i = 0; i < n; i++) {
            next[i] = 0.0;
            for (int j = 0; j < n; j++) {
                next[i] += h * (s->B[i * n + j] * w[j] + h * s->A[i * n + j] * x[j]);
            }
        }
        for (int i = 0; i < n; i++) {
            x[i] = w[i];
            w[i] = next[i];
            most = fmax(most, fmax(fabs(x[i]), fabs(w[i])));
        }
        if (!(most > 0.0)) {
            return 0.0;
        }
        for (int i = 0; i < n; i++) {
            x[i] /= most;
            w[i] /= most;
        }
        growth += k >= ALL - COUNTED ? stein__log(most) : 0.0;
    }
    return stein__exp(growth / COUNTED);
}

size_t stein__implicit_size(const stein_model *model, stein_integrator integrator)
{
    int wanted = stein__is_controlled(integrator) && stein__derivative_size(model) > 0;
    return wanted ? layout(NULL, model) : 0;
}

void stein__implicit_make(stein_sim *sim, void *block)
{
    work *s = block;
    if (s == NULL) { // what layout alone measures
        return;
    }
    (void)layout(s, sim->model);
    s->door.trial = trial;
    s->door.h_rho = h_rho;
    s->slopes = stein__derivative_make(s->slopes, sim->model);
    sim->implicit = &s->door;
}
