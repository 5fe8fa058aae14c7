/* SPDX-License-Identifier: MIT
 * functions.h - the elementary functions one by one, for who is in no hurry: the generator, the
 * reader of mechanism files, the laboratory. The same bits with any libm; errors below 1 ulp.
 * Included by: this folder, gen, src/model, src/lab.
 */
#ifndef STEIN_FUNCTIONS_H
#define STEIN_FUNCTIONS_H

double stein__sin(double x);
double stein__cos(double x);
double stein__tan(double x);
double stein__exp_of(double x);
double stein__log_of(double x);
double stein__tanh_of(double x);
/** x^y for x > 0. */
double stein__power(double x, double y);

#endif
