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
 * with f_y = {0, 1; A, B}, A and B being qdd by q and by qd where the step begins: exact, or by
 * differences where the equations have no derivatives (loops, friction that sticks, bodies and
 * contacts in space). There qdd is that of M qdd + c = Q + J^T lambda with J qdd = -Jdot qd, also
 * beside h = 0, and a step ends on h = 0 as explicit ones do. With
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

enum { STAGES = 8, LEVELS = 6 };

/* lengths of differences [rad or m, rad/s or m/s]: from the longest by this factor, LEVELS times;
 * rounding of qdd, of its largest element */
static const double longest = 0x1p-8, shorter = 0x1p-6, rounding = 0x1p-50;

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
    /* [nq] of differences: qdd at the place, ahead and behind; slopes and bends of two lengths;
     * how far off the slope is that was taken */
    double *at, *ahead, *behind, *slope[2], *bend[2], *off;
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
    if (stein__derivative_size(m) > 0) {
        s->slopes = stein__carve(&arena, stein__derivative_size(m));
        return arena.used;
    }
    double **const vector[] = {&s->at,       &s->ahead,   &s->behind,  &s->slope[0],
                               &s->slope[1], &s->bend[0], &s->bend[1], &s->off};
    for (size_t i = 0; i < sizeof vector / sizeof *vector; i++) {
        *vector[i] = stein__carve_doubles(&arena, n);
    }
    return arena.used;
}

/* ---- differences ---- */

/* qdd where coordinate or speed k of the state is h further. */
static stein_status look(stein_sim *sim, int k, double h, double *qdd, stein_err *err)
{
    int n = sim->model->nq;
    double *y = k < n ? &sim->q0[k] : &sim->qd0[k - n], here = *y;
    *y += h;
    sim->inside = INSIDE; // guards are not asked for
    stein_status status = stein__evaluate(sim, sim->head->t, sim->q0, sim->qd0, qdd, err);
    sim->inside = AT_END;
    *y = here;
    return status;
}

/* central differences of length h, and how far the curve bends off the line */
static stein_status differences(stein_sim *sim, int k, double h, double *slope, double *bend,
                                stein_err *err)
{
    const work *s = work_of(sim);
    int n = sim->model->nq;
    double y = k < n ? sim->q0[k] : sim->qd0[k - n], length = (y + h) - (y - h); // as rounded
    stein_status status = look(sim, k, h, s->ahead, err);
    status = status == STEIN_OK ? look(sim, k, -h, s->behind, err) : status;
    for (int i = 0; i < n && status == STEIN_OK; i++) {
        slope[i] = (s->ahead[i] - s->behind[i]) / length;
        bend[i] = ((s->ahead[i] - s->at[i]) - (s->at[i] - s->behind[i])) / h;
    }
    return status;
}

/* Column k of {A, B}. Of each element the extrapolated difference (Richardson) at that length at
 * which it is off by least: short where a contact is pressed in by little. Where there is a kink
 * within the length, the bend does not halve with it. */
static stein_status derive_column(stein_sim *sim, int k, double size, stein_err *err)
{
    const work *s = work_of(sim);
    int n = sim->model->nq, j = k % n;
    double *to = k < n ? s->A : s->B, h = longest;
    stein_status status = STEIN_OK;
    for (int i = 0; i < n; i++) {
        s->off[i] = INFINITY;
        to[i * n + j] = 0.0;
    }
    int found = 0; // did a length give differences? A long one may leave the limits of a mechanism
    for (int level = 0; level < LEVELS; level++, h *= shorter) {
        status = STEIN_OK;
        for (int half = 0; half < 2 && status == STEIN_OK; half++) {
            status = differences(sim, k, half ? 0.5 * h : h, s->slope[half], s->bend[half], err);
        }
        found |= status == STEIN_OK;
        for (int i = 0; i < n && status == STEIN_OK; i++) {
            double off = fabs(s->slope[1][i] - s->slope[0][i]) +
                         fabs(2.0 * s->bend[1][i] - s->bend[0][i]) + rounding * size / h;
            if (off < s->off[i]) {
                s->off[i] = off;
                to[i * n + j] = (4.0 * s->slope[1][i] - s->slope[0][i]) / 3.0;
            }
        }
    }
    return found ? STEIN_OK : status;
}

static stein_status derive_by_differences(stein_sim *sim, stein_err *err)
{
    const work *s = work_of(sim);
    int n = sim->model->nq;
    double size = 0.0;
    stein_status status = look(sim, 0, 0.0, s->at, err);
    for (int i = 0; i < n; i++) {
        size = fmax(size, fabs(s->at[i]));
    }
    for (int k = 0; k < 2 * n && status == STEIN_OK; k++) {
        status = derive_column(sim, k, size, err);
    }
    return status;
}

/* ---- a step ---- */

/* A and B where the step begins; one that is tried again finds them there */
static stein_status derive(stein_sim *sim, stein_err *err)
{
    work *s = work_of(sim);
    stein_status status = STEIN_OK;
    if (s->door.placed) {
        return STEIN_OK;
    }
    if (s->slopes == NULL) {
        sim->fresh = STALE;
        status = derive_by_differences(sim, err);
    } else {
        status = stein__derivative_at(s->slopes, sim, sim->head->t, sim->q, sim->qd, NULL, err);
        if (status == STEIN_OK) {
            stein_derivative_by_state(s->slopes, s->A, s->B);
        }
    }
    s->door.placed = status == STEIN_OK;
    return status;
}

/* the end of a step in {xq, xqd} to where loops are closed and what sticks is at rest */
static stein_status project(stein_sim *sim, double t, stein_err *err)
{
    stein_status status = STEIN_OK;
    if (sim->model->nrow > 0) {
        status = stein__loops_project(sim, t, err);
    }
    if (status == STEIN_OK && sim->model->nstick > 0) {
        status = stein__stick_project(sim, t, err);
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
        sim->xq[i] += last[i];
        sim->xqd[i] += last[n + i];
    }
    status = project(sim, t + h, err);
    if (status != STEIN_OK) {
        return status;
    }
    copy(sim->q1, sim->xq, n);
    copy(sim->qd1, sim->xqd, n);
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
    return stein__is_controlled(integrator) ? layout(NULL, model) : 0;
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
    if (s->slopes != NULL) {
        s->slopes = stein__derivative_make(s->slopes, sim->model);
    }
    sim->implicit = &s->door;
}
