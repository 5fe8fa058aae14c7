/* SPDX-License-Identifier: MIT
 * functions.h - what of the core the generator, the reader of mechanism files and the laboratory
 * call: the elementary functions one by one, and what kind of mechanism a model is. The functions
 * have the same bits with any libm, and errors below 1 ulp.
 * Included by: this folder, gen, src/model, src/lab.
 */
#ifndef STEIN_FUNCTIONS_H
#define STEIN_FUNCTIONS_H

#include "stein/model.h"

double stein__sin(double x);
double stein__cos(double x);
double stein__tan(double x);
double stein__exp_of(double x);
double stein__log_of(double x);
double stein__tanh_of(double x);
/** x^y for x > 0. */
double stein__power(double x, double y);

/** Has it bodies that turn in all directions, or contacts in space? (Inline: libstein.so shows
 *  libsteinlab.so its public functions only.) */
static inline int stein__in_space(const stein_model *model)
{
    int any = model->nball > 0;
    for (int i = 0; i < model->nspot; i++) {
        any |= model->spots[i].side[0].kind == STEIN_SPHERE;
    }
    return any;
}

#endif
