/* SPDX-License-Identifier: GPL-3.0-or-later
 * mujoco.h - the simple piano tree in MuJoCo, where it is installed (BENCH_MUJOCO).
 */
#ifndef BENCH_MUJOCO_H
#define BENCH_MUJOCO_H

#include "bench.h"

/** Cases "M and c" and "forward dynamics" of piano3 by MuJoCo, checked against `sim`.
 *  @param q, qd  [n][3], which stay where they are */
void mujoco_add(stein_sim *sim, const double (*q)[3], const double (*qd)[3], int n);
/** Their ratios to the generated ones. */
void mujoco_rows(const bench_case *mass_bias, const bench_case *forward);

#endif
