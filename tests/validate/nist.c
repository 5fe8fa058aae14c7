/* SPDX-License-Identifier: GPL-3.0-or-later
 * nist.c - the minimiser of `stein fit` (minimise.c, normal.c) on the 27 nonlinear regressions of
 * NIST's Statistical Reference Datasets, from both starts (https://www.itl.nist.gov/div898/strd).
 *
 * This program is linked with the minimiser alone; residuals and derivatives come from here. An
 * unknown counts in |start|, without a prior. Residuals count in the root mean square of y at
 * first, then in what is left of them; what an unknown is off by counts from where the last search
 * ended. Derivatives are exact: dy/db of y(b + i h) with h = 1e-20. Models are in long double: the
 * residuals of Lanczos1 are 1e-13 of its y, which leaves 3 of 16 digits.
 */
#include <complex.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fitting.h"
#include "validate.h"

static const double bar = 1e-6; /* of a parameter that is found, relative */
enum { MOST_B = 9, MOST_N = 300, ITERATIONS = 3000 };
typedef long double real;
typedef long double complex number;

/** A data set with its certified values. */
typedef struct dataset {
    const char *name;
    number (*model)(const number *b, const real *x);
    int level;                        /* of difficulty, 0 to 2, as its file says */
    int np, n;                        /* parameters, observations */
    double start[2][MOST_B];          /* of both starts */
    double value[MOST_B], sd[MOST_B]; /* certified */
    real y[MOST_N], x[MOST_N][2];
    double noise; /* unit of residuals */
} dataset;

/* ---- models, as the files state them ---- */

static number bennett5(const number *b, const real *x)
{
    return b[0] * cpowl(b[1] + x[0], -1.0 / b[2]);
}

static number saturation(const number *b, const real *x)
{
    return b[0] * (1.0 - cexpl(-b[1] * x[0]));
}

static number chwirut(const number *b, const real *x)
{
    return cexpl(-b[0] * x[0]) / (b[1] + b[2] * x[0]);
}

static number danwood(const number *b, const real *x)
{
    return b[0] * cpowl(x[0], b[1]);
}

static number enso(const number *b, const real *x)
{
    real turn = 2.0L * acosl(-1.0L) * x[0];
    return b[0] + b[1] * cosl(turn / 12.0) + b[2] * sinl(turn / 12.0) + b[4] * ccosl(turn / b[3]) +
           b[5] * csinl(turn / b[3]) + b[7] * ccosl(turn / b[6]) + b[8] * csinl(turn / b[6]);
}

static number eckerle4(const number *b, const real *x)
{
    number u = (x[0] - b[2]) / b[1];
    return b[0] / b[1] * cexpl(-0.5 * u * u);
}

static number gauss(const number *b, const real *x)
{
    number u = (x[0] - b[3]) / b[4], v = (x[0] - b[6]) / b[7];
    return b[0] * cexpl(-b[1] * x[0]) + b[2] * cexpl(-u * u) + b[5] * cexpl(-v * v);
}

static number cubics(const number *b, const real *x)
{
    return (b[0] + x[0] * (b[1] + x[0] * (b[2] + x[0] * b[3]))) /
           (1.0 + x[0] * (b[4] + x[0] * (b[5] + x[0] * b[6])));
}

static number kirby2(const number *b, const real *x)
{
    return (b[0] + x[0] * (b[1] + x[0] * b[2])) / (1.0 + x[0] * (b[3] + x[0] * b[4]));
}

static number lanczos(const number *b, const real *x)
{
    return b[0] * cexpl(-b[1] * x[0]) + b[2] * cexpl(-b[3] * x[0]) + b[4] * cexpl(-b[5] * x[0]);
}

static number mgh09(const number *b, const real *x)
{
    return b[0] * (x[0] * x[0] + x[0] * b[1]) / (x[0] * x[0] + x[0] * b[2] + b[3]);
}

static number mgh10(const number *b, const real *x)
{
    return b[0] * cexpl(b[1] / (x[0] + b[2]));
}

static number mgh17(const number *b, const real *x)
{
    return b[0] + b[1] * cexpl(-x[0] * b[3]) + b[2] * cexpl(-x[0] * b[4]);
}

static number misra1b(const number *b, const real *x)
{
    number u = 1.0 + b[1] * x[0] / 2.0;
    return b[0] * (1.0 - 1.0 / (u * u));
}

static number misra1c(const number *b, const real *x)
{
    return b[0] * (1.0 - 1.0 / csqrtl(1.0 + 2.0 * b[1] * x[0]));
}

static number misra1d(const number *b, const real *x)
{
    return b[0] * b[1] * x[0] / (1.0 + b[1] * x[0]);
}

static number nelson(const number *b, const real *x) /* of log y */
{
    return b[0] - b[1] * x[0] * cexpl(-b[2] * x[1]);
}

static number rat42(const number *b, const real *x)
{
    return b[0] / (1.0 + cexpl(b[1] - b[2] * x[0]));
}

static number rat43(const number *b, const real *x)
{
    return b[0] / cpowl(1.0 + cexpl(b[1] - b[2] * x[0]), 1.0 / b[3]);
}

static number roszman1(const number *b, const real *x)
{
    return b[0] - b[1] * x[0] - catanl(b[2] / (x[0] - b[3])) / acosl(-1.0L);
}

static const struct {
    const char *name;
    number (*model)(const number *b, const real *x);
} sets[] = {
    {"Bennett5", bennett5}, {"BoxBOD", saturation}, {"Chwirut1", chwirut},   {"Chwirut2", chwirut},
    {"DanWood", danwood},   {"ENSO", enso},         {"Eckerle4", eckerle4},  {"Gauss1", gauss},
    {"Gauss2", gauss},      {"Gauss3", gauss},      {"Hahn1", cubics},       {"Kirby2", kirby2},
    {"Lanczos1", lanczos},  {"Lanczos2", lanczos},  {"Lanczos3", lanczos},   {"MGH09", mgh09},
    {"MGH10", mgh10},       {"MGH17", mgh17},       {"Misra1a", saturation}, {"Misra1b", misra1b},
    {"Misra1c", misra1c},   {"Misra1d", misra1d},   {"Nelson", nelson},      {"Rat42", rat42},
    {"Rat43", rat43},       {"Roszman1", roszman1}, {"Thurber", cubics},
};
enum { SETS = sizeof sets / sizeof *sets };

/* ---- files: values in lines 41 on, data in lines 61 on ---- */

static void read_line(dataset *d, const char *line, int number_of_line)
{
    const char *equal = strchr(line, '=');
    double v[4];
    real row[3];
    if (strstr(line, "Average Level") != NULL || strstr(line, "Higher Level") != NULL) {
        d->level = strstr(line, "Higher") != NULL ? 2 : 1;
    }
    if (number_of_line > 40 && number_of_line < 58 && equal != NULL && d->np < MOST_B &&
        sscanf(equal + 1, "%lf %lf %lf %lf", &v[0], &v[1], &v[2], &v[3]) == 4) {
        d->start[0][d->np] = v[0];
        d->start[1][d->np] = v[1];
        d->value[d->np] = v[2];
        d->sd[d->np++] = v[3];
    }
    if (number_of_line > 60 && d->n < MOST_N &&
        sscanf(line, "%Lf %Lf %Lf", &row[0], &row[1], &row[2]) >= 2) {
        d->y[d->n] = d->model == nelson ? logl(row[0]) : row[0];
        d->x[d->n][0] = row[1];
        d->x[d->n++][1] = row[2];
    }
}

static void read_set(dataset *d)
{
    char path[64], line[300];
    snprintf(path, sizeof path, "tests/validate/nist/%s.dat", d->name);
    FILE *f = fopen(path, "r");
    if (f == NULL) {
        fprintf(stderr, "validate: %s cannot be read\n", path);
        exit(EXIT_FAILURE);
    }
    for (int i = 1; fgets(line, sizeof line, f) != NULL; i++) {
        read_line(d, line, i);
    }
    fclose(f);
}

/* ---- what the minimiser asks for ---- */

static dataset set; /* the one at hand */

static void values(const fit__problem *p, const double *x, number *b)
{
    for (int k = 0; k < p->np; k++) {
        b[k] = p->unknown[k].start + (real)p->unknown[k].sd * x[k];
    }
}

stein_status fit__residuals(const fit__problem *p, const double *x, double *r, int *failed,
                            stein_err *err)
{
    number b[MOST_B];
    (void)err;
    values(p, x, b);
    *failed = 0;
    for (int i = 0; i < set.n; i++) {
        r[i] = (double)(set.y[i] - creall(set.model(b, set.x[i]))) / set.noise;
        *failed |= !isfinite(r[i]);
    }
    return STEIN_OK;
}

stein_status fit__sensitivities(const fit__problem *p, const double *x, const double *r, double *J,
                                stein_err *err)
{
    const real h = 1e-20L;
    number b[MOST_B];
    (void)r, (void)err;
    for (int k = 0; k < p->np; k++) {
        values(p, x, b);
        b[k] += h * I;
        for (int i = 0; i < set.n; i++) {
            J[k * set.n + i] =
                -(double)(cimagl(set.model(b, set.x[i])) / h) * p->unknown[k].sd / set.noise;
        }
    }
    return STEIN_OK;
}

size_t fit__offset(const fit__problem *p, int stroke)
{
    return stroke > 0 ? (size_t)p->stroke[0].n : 0;
}

size_t fit__column(const fit__problem *p, int stroke, int k)
{
    (void)stroke;
    return (size_t)k * (size_t)p->stroke[0].n;
}

size_t fit__columns(const fit__problem *p)
{
    return fit__column(p, 0, p->np);
}

double fit__chi2(const fit__problem *p, const double *r)
{
    return lab__dot(r, r, (size_t)p->stroke[0].n);
}

double fit__chi2_dof(const fit__problem *p, const double *r)
{
    return fit__chi2(p, r) / (p->stroke[0].n - p->np);
}

double fit__priors(const fit__problem *p, const double *x)
{
    (void)p, (void)x;
    return 0.0;
}

double fit__prior_weight(const fit__unknown *u, double x, double tempered)
{
    (void)u, (void)x;
    return tempered;
}

void fit__choose_steps(fit__problem *p, const double *J)
{
    (void)p, (void)J; // derivatives are exact
}

/* ---- one search ---- */

/* largest relative difference to what is certified */
static double worst_of(const double *ours, const double *certified)
{
    double worst = 0.0;
    for (int k = 0; k < set.np; k++) {
        worst = fmax(worst, fabs(ours[k] / certified[k] - 1.0));
    }
    return isfinite(worst) ? worst : 1.0;
}

/* standard deviations from the normal equations at the minimum */
static void deviations(fit__problem *p, const double *x, double *sd)
{
    static double r[MOST_N], J[MOST_B * MOST_N];
    fit__normal n;
    int failed;
    (void)fit__normal_make(&n, p, NULL);
    (void)fit__residuals(p, x, r, &failed, NULL);
    (void)fit__sensitivities(p, x, r, J, NULL);
    fit__normal_fill(&n, p, x, r, J, 0);
    for (int k = 0; k < set.np; k++) {
        sd[k] = NAN;
    }
    if (fit__normal_factor(&n, p, 0.0, NULL) == 0 && gsl_linalg_cholesky_invert(n.S) == 0) {
        for (int k = 0; k < set.np; k++) {
            sd[k] = p->unknown[k].sd *
                    sqrt(gsl_matrix_get(n.S, (size_t)k, (size_t)k) * fit__chi2_dof(p, r));
        }
    }
    fit__normal_free(&n);
}

/* @param error  out: of the parameters, of their standard deviations */
static void search(int start, double error[2])
{
    fit__unknown unknown[MOST_B];
    fit__stroke stroke = {.n = set.n, .nch = 1};
    double x[MOST_B] = {0.0}, step[MOST_B] = {0.0}, scale[MOST_B], ours[MOST_B] = {0.0},
           sd[MOST_B] = {0.0}, squares = 0.0;
    fit__problem p = {.stroke = &stroke,
                      .nstroke = 1,
                      .unknown = unknown,
                      .np = set.np,
                      .nu = set.np,
                      .step = step,
                      .fixed = -1,
                      .flat = -1,
                      .central = 1};
    memset(unknown, 0, sizeof unknown);
    for (int k = 0; k < set.np; k++) {
        unknown[k] = (fit__unknown){.stroke = -1, .start = 0.0, .sd = fabs(set.start[start][k])};
        x[k] = copysign(1.0, set.start[start][k]);
    }
    for (int i = 0; i < set.n; i++) {
        squares += (double)(set.y[i] * set.y[i]);
    }
    set.noise = sqrt(squares / set.n);
    for (int pass = 0; pass < 3; pass++) {
        memset(scale, 0, sizeof scale);
        fit__state s = {.x = x, .step = step, .scale = scale, .mu = 1e-3, .nu = 2.0};
        stein_err err;
        (void)fit__minimise(&p, &s, pass == 0 ? 1e-10 : 1e-18, 0.0, ITERATIONS, NULL, NULL, &err);
        set.noise *= sqrt(s.objective / (set.n - set.np)); // what is left is noise
        for (int k = 0; k < set.np; k++) { // what is added from here on has all of its digits
            ours[k] = unknown[k].start += unknown[k].sd * x[k];
            x[k] = 0.0;
        }
    }
    deviations(&p, x, sd);
    error[0] = worst_of(ours, set.value);
    error[1] = worst_of(sd, set.sd);
}

/** Searches of one level of difficulty. */
typedef struct tally {
    int all, found;
    double worst, worst_sd;                     /* of those that were found */
    double error[2 * SETS], error_sd[2 * SETS]; /* of each search */
} tally;

/* the picture of the next row: errors, and the bar */
static void draw_errors(const double *error, int n)
{
    for (int i = 0; i < n; i++) {
        validate_point(VALIDATE_DOTS, i + 1, log10(fmax(error[i], 1e-16)));
        validate_point(VALIDATE_SECOND, i + 1, log10(bar));
    }
    validate_axes("search", "log10 of the error; bar");
}

/* observations of the set at hand, and what fits them */
static void draw_set(const double *certified)
{
    number b[MOST_B];
    for (int k = 0; k < set.np; k++) {
        b[k] = certified[k];
    }
    for (int i = 0; i < set.n; i++) {
        validate_point(VALIDATE_DOTS, (double)set.x[i][0], (double)set.y[i]);
        validate_point(VALIDATE_LINE, (double)set.x[i][0], (double)creall(set.model(b, set.x[i])));
    }
    validate_axes(set.name, "y");
}

/* The bars are those of the whole: every minimum from both starts, 6 digits, deviations too. */
static void tell(const tally *t, const char *level)
{
    char problem[120], ours[64];
    snprintf(problem, sizeof problem, "nonlinear regression, %s difficulty: minima missed", level);
    snprintf(ours, sizeof ours, "%d of %d found", t->found, t->all);
    validate_row(problem, "NIST StRD, both starts", "certified values", ours, t->all - t->found,
                 0.0);
    draw_errors(t->error, t->all);
    snprintf(ours, sizeof ours, "off by %.1e", t->worst);
    validate_row("parameters, relative, of the minima found", "NIST StRD", "certified values", ours,
                 t->worst, bar);
    draw_errors(t->error_sd, t->all);
    snprintf(ours, sizeof ours, "off by %.1e", t->worst_sd);
    validate_row("standard deviations, relative, of the minima found", "NIST StRD",
                 "certified values", ours, t->worst_sd, bar);
}

/* both starts of the set at hand */
static void run_set(tally *t, int tells)
{
    for (int start = 0; start < 2; start++) {
        double error[2];
        search(start, error);
        t->error[t->all] = error[0];
        t->error_sd[t->all++] = error[1];
        if (error[0] <= bar) {
            t->found++;
            t->worst = fmax(t->worst, error[0]);
            t->worst_sd = fmax(t->worst_sd, error[1]);
        }
        if (tells) {
            fprintf(stderr, "%-10s start %d: parameters %.1e, standard deviations %.1e\n", set.name,
                    start + 1, error[0], error[1]);
        }
    }
}

int main(int argc, char **argv)
{
    static const char *const level[] = {"lower", "average", "higher"};
    static const char *const shown[] = {"Gauss1", "ENSO", "Thurber"};
    int tells = argc > 1 && strcmp(argv[1], "-v") == 0;
    (void)gsl_set_error_handler_off();
    for (int k = 0; k < 3; k++) {
        tally t = {0};
        for (int i = 0; i < SETS; i++) {
            set = (dataset){.name = sets[i].name, .model = sets[i].model};
            read_set(&set);
            if (set.level != k) {
                continue;
            }
            run_set(&t, tells);
            if (strcmp(set.name, shown[k]) == 0) {
                draw_set(set.value);
            }
        }
        tell(&t, level[k]);
    }
    return validate_failed() > 0 ? EXIT_FAILURE : EXIT_SUCCESS;
}
