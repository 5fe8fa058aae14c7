/* SPDX-License-Identifier: GPL-3.0-or-later
 * check.c - checks that `stein plan` proposes, made in the world of the set: instruments, lengths,
 * masses, felts by themselves.
 *
 * True values are in the answer; values that are not hidden are the file's (the plan repeats them).
 * A plumb line, a scale, a light, a clock, calipers, a knife edge, a balance and a press measure
 * them with the noise that the plan assumes. A scale is read at 11 places and a parabola drawn
 * through the readings; a press as well, and through those a law that has the file's powers, from
 * where the felt seems to begin:
 *
 *      reading - x = zero + error x + k2 x^2
 *      F = ((a x' + b) x' + c) x' (x'/0.1 mm)^p,  x' = x + u,  u ~ N(0, 10 um)
 *
 * What was found is stated in copies of the strokes, "# known NAME: VALUE", and nothing else in
 * them is changed.
 */
#include <gsl/gsl_multifit.h>
#include <gsl/gsl_randist.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "hidden.h"

enum { VALUES = 11, HEAD = 1000, MOST = 4 };
static const double least = 0.1, begins = 1e-5, unit = 1e-4; /* of a press: check.c of the plan */

/* numbers of instruments, what the answer calls what is hidden there, and when all is right */
static const struct {
    const char *tail, *kind, *name;
    double right;
} numbers[] = {{"sensor.tilt", "camera_tilt", "tilt", 0.0},
               {"sensor.gain", "sensor_gain", "error", 1.0},
               {"sensor.square", "sensor_nonlinearity", "k2", 0.0},
               {"sensor.delay", "sensor_delay", "delay", 0.0},
               {"clock.error", "time_base", "error", 0.0}};
enum { NUMBERS = sizeof numbers / sizeof *numbers };

static int ends(const char *name, const char *tail)
{
    size_t n = strlen(name), t = strlen(tail);
    return n >= t && strcmp(name + n - t, tail) == 0;
}

/* of an instrument, -1: of none */
static int kind_of(const char *number)
{
    for (int k = 0; k < NUMBERS; k++) {
        if (ends(number, numbers[k].tail)) {
            return k;
        }
    }
    return -1;
}

static double hidden_number(const tree *answer, const char *name)
{
    return tree_number(tree_get(tree_get(answer, "parameters"), name), "value");
}

static int is_press(const tree *check)
{
    return strcmp(tree_text(check, "beside"), "a press") == 0;
}

/* is what is hidden at the thing that is looked at, and would the check show it? */
static int is_hidden(const tree *answer, const tree *check, const char *number)
{
    const char *kind = tree_text(answer, "kind");
    int k = kind_of(number);
    int here = strcmp(tree_text(answer, "place"), tree_text(check, "instrument")) == 0;
    int of_felt = strcmp(kind, "contact_stiffness") == 0 || strcmp(kind, "contact_exponent") == 0;
    return (k >= 0 && here && strcmp(kind, numbers[k].kind) == 0) ||
           (is_press(check) && here && of_felt) || isfinite(hidden_number(answer, number));
}

/* how far off an instrument's number is */
static double off_by(const tree *answer, const tree *check, const char *number)
{
    return is_hidden(answer, check, number) ? hidden_number(answer, numbers[kind_of(number)].name)
                                            : 0.0;
}

/* a number of the mechanism */
static double truth(const tree *answer, const char *number, double file)
{
    double hidden = hidden_number(answer, number);
    double other = tree_number(tree_get(tree_get(answer, "truth"), number), "value");
    return isfinite(hidden) ? hidden : isfinite(other) ? other : file;
}

static void state(char head[HEAD], const char *number, double value)
{
    size_t n = strlen(head);
    snprintf(head + n, HEAD - n, "# known %s: %.9g\n", number, value);
}

/* The parabola through readings at 0, R/10 .. R by its orthogonal parts: with u = 10 x/R - 5,
 * y = a0 + a1 u + a2 (u^2 - 10), sum u^2 = 110, sum (u^2 - 10)^2 = 858. */
static void parabola(const double *y, double reach, double *error, double *k2)
{
    double a1 = 0.0, a2 = 0.0;
    for (int i = 0; i < VALUES; i++) {
        double u = i - 5.0;
        a1 += y[i] * u / 110.0;
        a2 += y[i] * (u * u - 10.0) / 858.0;
    }
    *error = (10.0 * a1 - 100.0 * a2) / reach;
    *k2 = 100.0 * a2 / (reach * reach);
}

/* ---- a felt ---- */

/* a law: what stands before each power of x, and the exponent */
typedef struct felt {
    double of[4]; /* [0] unused: of x, x^2, x^3 */
    double p;
} felt;

static double force(const felt *f, double x)
{
    x = fmax(x, 0.0);
    double straight = ((f->of[3] * x + f->of[2]) * x + f->of[1]) * x;
    return f->p != 0.0 ? straight * pow(x / unit, f->p) : straight;
}

/* the power that a number stands before, 0: it is the exponent */
static int power_of(const char *number)
{
    return ends(number, ".a") ? 3 : ends(number, ".b") ? 2 : ends(number, ".c") ? 1 : 0;
}

/* Readings of the true felt, and a law with the powers of the file's through them, each weighed by
 * its noise; where it begins is one unknown more. @return 0, -1: no law */
static int press(felt *found, const felt *file, const felt *real, double noise, double reach,
                 int times, gsl_rng *rng)
{
    int power[3], n = 0, status = -1;
    for (int k = 1; k < 4; k++) {
        if (file->of[k] != 0.0) {
            power[n++] = k;
        }
    }
    gsl_matrix *X = gsl_matrix_calloc(VALUES, (size_t)n + 1),
               *C = gsl_matrix_alloc((size_t)n + 1, (size_t)n + 1);
    gsl_vector *y = gsl_vector_calloc(VALUES), *w = gsl_vector_calloc(VALUES),
               *c = gsl_vector_alloc((size_t)n + 1);
    gsl_multifit_linear_workspace *room = gsl_multifit_linear_alloc(VALUES, (size_t)n + 1);
    double shift = gsl_ran_gaussian(rng, begins / sqrt(times)), all = force(file, reach), chi2;
    for (int i = 1; i < VALUES; i++) {
        size_t r = (size_t)i;
        double x = reach * i / (VALUES - 1), sd = noise * (force(file, x) + least * all);
        gsl_vector_set(y, r, force(real, x + shift) + gsl_ran_gaussian(rng, sd / sqrt(times)));
        gsl_vector_set(w, r, times / (sd * sd));
        for (int k = 0; k < n; k++) {
            gsl_matrix_set(X, r, (size_t)k, pow(x, power[k]));
        }
        gsl_matrix_set(X, r, (size_t)n, (force(file, x + begins) - force(file, x)));
    }
    // that it begins within 10 um, in the place of the reading at 0, which has no information
    gsl_matrix_set(X, 0, (size_t)n, 1.0);
    gsl_vector_set(w, 0, times);
    if (n > 0 && gsl_multifit_wlinear(X, w, y, c, C, &chi2, room) == 0) {
        status = 0;
        *found = (felt){.p = 0.0};
        for (int k = 0; k < n; k++) {
            found->of[power[k]] = gsl_vector_get(c, (size_t)k);
        }
    }
    gsl_matrix_free(X);
    gsl_matrix_free(C);
    gsl_vector_free(y);
    gsl_vector_free(w);
    gsl_vector_free(c);
    gsl_multifit_linear_free(room);
    return status;
}

/* the law that is there */
static felt real_felt(const felt *file, const tree *check, const tree *answer)
{
    felt real = *file;
    const char *kind = tree_text(answer, "kind");
    const tree *list = tree_get(check, "numbers");
    for (const tree *c = list != NULL ? list->child : NULL; c != NULL; c = c->next) {
        int k = power_of(c->text);
        real.of[k] = k > 0 ? truth(answer, c->text, file->of[k]) : 0.0;
    }
    if (strcmp(tree_text(answer, "place"), tree_text(check, "instrument")) == 0) {
        double scale =
            strcmp(kind, "contact_stiffness") == 0 ? exp(hidden_number(answer, "log_scale")) : 1.0;
        for (int k = 1; k < 4; k++) {
            real.of[k] *= scale;
        }
        real.p = strcmp(kind, "contact_exponent") == 0 ? hidden_number(answer, "p") : 0.0;
    }
    return real;
}

static int make_press(char head[HEAD], const tree *check, const tree *answer, int times,
                      gsl_rng *rng)
{
    const tree *list = tree_get(check, "numbers"), *values = tree_get(check, "file");
    double noise = tree_number(check, "noise"), reach = tree_number(check, "reach");
    felt file = {.p = 0.0}, found;
    const tree *v = values != NULL ? values->child : NULL;
    for (const tree *c = list->child; c != NULL && v != NULL; c = c->next, v = v->next) {
        file.of[power_of(c->text)] = power_of(c->text) > 0 ? v->number : 0.0;
    }
    felt real = real_felt(&file, check, answer);
    if (!(noise > 0.0) || !(reach > 0.0) ||
        press(&found, &file, &real, noise, reach, times, rng) != 0) {
        return -1;
    }
    for (const tree *c = list->child; c != NULL; c = c->next) {
        state(head, c->text, power_of(c->text) > 0 ? found.of[power_of(c->text)] : 0.0);
    }
    return 0;
}

/* ---- a check ---- */

static int make_scale(char head[HEAD], const tree *check, const tree *answer, double noise,
                      gsl_rng *rng)
{
    const tree *first = tree_get(check, "numbers")->child;
    double reach = tree_number(check, "reach"), y[VALUES], error, k2;
    if (!ends(first->text, numbers[1].tail) || first->next == NULL ||
        !ends(first->next->text, numbers[2].tail) || !(reach > 0.0)) {
        return -1;
    }
    for (int i = 0; i < VALUES; i++) {
        double x = reach * i / (VALUES - 1);
        y[i] = off_by(answer, check, first->text) * x +
               off_by(answer, check, first->next->text) * x * x + gsl_ran_gaussian(rng, noise);
    }
    parabola(y, reach, &error, &k2);
    state(head, first->text, numbers[1].right + error);
    state(head, first->next->text, numbers[2].right + k2);
    return 0;
}

/* one check, so many times. @return 0, -1: this laboratory lacks it */
static int make(char head[HEAD], const tree *check, const tree *answer, int times, gsl_rng *rng)
{
    const tree *list = tree_get(check, "numbers"), *first = list != NULL ? list->child : NULL;
    const tree *file = tree_get(check, "file");
    double noise = tree_number(check, "noise") / sqrt(times);
    int k = first != NULL ? kind_of(first->text) : -1;
    if (first == NULL || !(noise > 0.0) || file == NULL || file->child == NULL) {
        return -1;
    }
    if (is_press(check)) {
        return make_press(head, check, answer, times, rng);
    }
    if (first->next != NULL) {
        return make_scale(head, check, answer, noise, rng);
    }
    double value = k >= 0 ? numbers[k].right + off_by(answer, check, first->text)
                          : truth(answer, first->text, file->child->number);
    state(head, first->text, value + gsl_ran_gaussian(rng, noise));
    return 0;
}

int check_make(const tree *checks, const tree *answer, int times, const char *set, const char *to)
{
    char head[HEAD] = "";
    double number = tree_number(answer, "seed");
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    int status = rng != NULL ? process_folder(to) : -1;
    if (rng != NULL) {
        gsl_rng_set(rng, isfinite(number) ? (unsigned long)number : 0);
    }
    for (const tree *c = checks->child; status == 0 && c != NULL; c = c->next) {
        status = make(head, c, answer, times, rng);
    }
    for (int i = 0; status == 0 && i < FIT + HELD; i++) {
        char from[PATH + 20], copy[PATH + 20];
        const char *name = i < FIT ? "fit" : "held";
        int number_of = i < FIT ? i + 1 : i - FIT + 1;
        snprintf(from, sizeof from, "%s/%s_%02d.csv", set, name, number_of);
        snprintf(copy, sizeof copy, "%s/%s_%02d.csv", to, name, number_of);
        status = process_copy(head, from, copy);
    }
    gsl_rng_free(rng);
    return status;
}

int check_covers(const tree *checks, const tree *answer)
{
    for (const tree *c = checks->child; c != NULL; c = c->next) {
        const tree *list = tree_get(c, "numbers");
        for (const tree *n = list != NULL ? list->child : NULL; n != NULL; n = n->next) {
            if (is_hidden(answer, c, n->text)) {
                return 1;
            }
        }
    }
    return 0;
}
