/* SPDX-License-Identifier: GPL-3.0-or-later
 * functions_wide.h - the elementary functions of so many lanes, for arrays: functions_wide.c,
 * compiled once for each number of lanes.
 */
#ifndef TEST_LANES_FUNCTIONS_WIDE_H
#define TEST_LANES_FUNCTIONS_WIDE_H

enum { LANE_SIN, LANE_COS, LANE_TANH, LANE_EXP, LANE_LOG, LANE_POWER, LANE_FUNCTIONS };

/** Functions of x [n], powers of |x| to the y [n]; n is a multiple of 8. out [LANE_FUNCTIONS][n] */
typedef void lane_functions(const double *x, const double *y, int n, double *out);

lane_functions lane_functions_2;
#if STEIN_WIDEST >= 8 // other processors are tested with two lanes
lane_functions lane_functions_4, lane_functions_8;
#endif

#endif
