/* SPDX-License-Identifier: GPL-3.0-or-later
 * check.c - checks of instruments that `stein plan` asks for, made in the world of the set.
 *
 * What is true is in the answer; a plumb line, a scale, a light, a clock show it with the noise
 * that the plan counts with. A scale is read at 11 places and a parabola drawn through the
 * readings:
 *
 *      reading - x = zero + error x + k2 x^2
 *
 * What was found is stated in copies of the strokes, "# set NAME: VALUE", and nothing else in them
 * is changed.
 */
#include <gsl/gsl_randist.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "hidden.h"

enum { VALUES = 11, HEAD = 1000 };

/* numbers of instruments, what the answer calls them, and what they are when all is right */
static const struct {
    const char *tail, *kind, *name;
    double right;
} numbers[] = {{"sensor.tilt", "camera_tilt", "tilt", 0.0},
               {"sensor.gain", "sensor_gain", "error", 1.0},
               {"sensor.square", "sensor_nonlinearity", "k2", 0.0},
               {"sensor.delay", "sensor_delay", "delay", 0.0},
               {"clock.error", "time_base", "error", 0.0}};
enum { NUMBERS = sizeof numbers / sizeof *numbers };

static int kind_of(const char *number)
{
    for (int k = 0; k < NUMBERS; k++) {
        size_t n = strlen(number), tail = strlen(numbers[k].tail);
        if (n >= tail && strcmp(number + n - tail, numbers[k].tail) == 0) {
            return k;
        }
    }
    return -1;
}

/* is it what is hidden? */
static int is_hidden(const tree *answer, const tree *check, int k)
{
    return k >= 0 && strcmp(tree_text(answer, "kind"), numbers[k].kind) == 0 &&
           strcmp(tree_text(answer, "place"), tree_text(check, "instrument")) == 0;
}

/* how far off that number is */
static double truth(const tree *answer, const tree *check, int k)
{
    const tree *number = tree_get(tree_get(answer, "parameters"), numbers[k].name);
    return is_hidden(answer, check, k) ? tree_number(number, "value") : 0.0;
}

static void state(char head[HEAD], const tree *number, double value)
{
    size_t n = strlen(head);
    snprintf(head + n, HEAD - n, "# set %s: %.9g\n", number->text, value);
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

/* one check, so many times. @return 0, -1: this laboratory has no such thing */
static int make(char head[HEAD], const tree *check, const tree *answer, int times, gsl_rng *rng)
{
    const tree *list = tree_get(check, "numbers"), *first = list != NULL ? list->child : NULL;
    double noise = tree_number(check, "noise") / sqrt(times), reach = tree_number(check, "reach");
    double y[VALUES], error, k2;
    int k = first != NULL ? kind_of(first->text) : -1;
    if (k < 0 || !(noise > 0.0)) {
        return -1;
    }
    if (first->next == NULL) {
        double off = truth(answer, check, k) + gsl_ran_gaussian(rng, noise);
        state(head, first, numbers[k].right + off);
        return 0;
    }
    int other = kind_of(first->next->text);
    if (strcmp(numbers[k].name, "error") != 0 || other < 0 || !(reach > 0.0)) {
        return -1;
    }
    for (int i = 0; i < VALUES; i++) {
        double x = reach * i / (VALUES - 1);
        y[i] = truth(answer, check, k) * x + truth(answer, check, other) * x * x +
               gsl_ran_gaussian(rng, noise);
    }
    parabola(y, reach, &error, &k2);
    state(head, first, numbers[k].right + error);
    state(head, first->next, numbers[other].right + k2);
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
            if (is_hidden(answer, c, kind_of(n->text))) {
                return 1;
            }
        }
    }
    return 0;
}
