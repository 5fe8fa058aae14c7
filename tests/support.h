/* SPDX-License-Identifier: GPL-3.0-or-later
 * support.h - what the test suites share.
 */
#ifndef SUPPORT_H
#define SUPPORT_H

#include <check.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "stein/stein.h"
#include "suites.h"

/** |a - b| <= rtol |b| + atol, with the figures in the message (Check's own are absolute and
 * strict). */
#define ck_assert_close(a, b, rtol, atol)                                                    \
    do {                                                                                     \
        double close_a = (a), close_b = (b), close_r = (rtol), close_t = (atol);             \
        ck_assert_msg(fabs(close_a - close_b) <= close_r * fabs(close_b) + close_t,          \
                      "%s = %.17g, expected %s = %.17g, off by %.3g (rtol %g, atol %g)", #a, \
                      close_a, #b, close_b, close_a - close_b, close_r, close_t);            \
    } while (0)

/** A call that must succeed; its message otherwise. */
#define ck_assert_stein(call)                                                               \
    do {                                                                                    \
        stein_err stein_e = {STEIN_OK, ""};                                                 \
        stein_err *err = &stein_e;                                                          \
        stein_status stein_s = (call);                                                      \
        ck_assert_msg(stein_s == STEIN_OK, "%s: %s: %s", #call, stein_status_text(stein_s), \
                      err->msg);                                                            \
    } while (0)

/** max |a - b| <= rtol max |b|, over n numbers. @return how far they are off, relative to max |b|
 */
static inline double assert_near(const char *what, const double *a, const double *b, int n,
                                 double rtol)
{
    double off = 0.0, size = 0.0;
    for (int i = 0; i < n; i++) {
        off = fmax(off, fabs(a[i] - b[i]));
        size = fmax(size, fabs(b[i]));
    }
    ck_assert_msg(off <= rtol * size + 1e-300, "%s: off by %.3g of %.3g", what, off, size);
    return size > 0.0 ? off / size : 0.0;
}

/** A simulation with the model's defaults, or the test fails. */
static inline stein_sim *make_sim(const stein_model *model, stein_integrator integrator, double dt)
{
    stein_sim_def def = stein_sim_def_default(model);
    def.integrator = integrator;
    if (dt > 0.0) {
        def.dt = dt;
    }
    stein_sim *sim = NULL;
    ck_assert_stein(stein_sim_create(&sim, model, &def, err));
    return sim;
}

/** Allocators that count the blocks that live, *(int *)ctx, and one that has none. */
static inline void *count_alloc(void *ctx, size_t size)
{
    ++*(int *)ctx;
    return malloc(size);
}

static inline void count_release(void *ctx, void *block)
{
    --*(int *)ctx;
    free(block);
}

static inline void *no_memory(void *ctx, size_t size)
{
    (void)ctx, (void)size;
    return NULL;
}

/** 0 in `make check`, which takes a share of the cases; the number SOAK in `make soak`, which takes
 * all. */
static inline int soaks(void)
{
    const char *times = getenv("SOAK");
    return times != NULL ? (int)strtol(times, NULL, 10) : 0;
}

/** So many times the cases of `make check` in `make soak`. */
static inline int soak(int quick)
{
    return soaks() > 0 ? quick * soaks() : quick;
}

/** Deterministic numbers in [-1, 1) (splitmix64), for high-entropy test inputs. */
static inline double noise(unsigned long long *seed)
{
    unsigned long long z = (*seed += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    z ^= z >> 31;
    return (double)(z >> 11) * 0x1p-52 - 1.0;
}

#endif
