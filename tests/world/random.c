/* SPDX-License-Identifier: GPL-3.0-or-later
 * random.c - random numbers: xoshiro256** (Blackman, Vigna 2018), seeded by splitmix64.
 */
#include <math.h>

#include "world.h"

static const double two_pi = 6.283185307179586;

static unsigned long long turned(unsigned long long x, int k)
{
    return (x << k) | (x >> (64 - k));
}

static unsigned long long next(chance *c)
{
    unsigned long long *s = c->s, result = turned(s[1] * 5, 7) * 9, t = s[1] << 17;
    s[2] ^= s[0];
    s[3] ^= s[1];
    s[1] ^= s[2];
    s[0] ^= s[3];
    s[2] ^= t;
    s[3] = turned(s[3], 45);
    return result;
}

void chance_seed(chance *c, unsigned long long seed)
{
    for (int i = 0; i < 4; i++) {
        seed += 0x9e3779b97f4a7c15u;
        unsigned long long z = seed;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        c->s[i] = z ^ (z >> 31);
    }
}

double chance_uniform(chance *c, double lo, double hi)
{
    return lo + (hi - lo) * (double)(next(c) >> 11) * 0x1p-53;
}

/* Box and Muller, one of the pair */
double chance_normal(chance *c)
{
    double u = 1.0 - chance_uniform(c, 0.0, 1.0), v = chance_uniform(c, 0.0, two_pi);
    return sqrt(-2.0 * log(u)) * cos(v);
}

double chance_log(chance *c, double lo, double hi)
{
    return exp(chance_uniform(c, log(lo), log(hi)));
}

int chance_pick(chance *c, int n)
{
    int k = (int)chance_uniform(c, 0.0, n);
    return k < n ? k : n - 1;
}

int chance_coin(chance *c, double p)
{
    return chance_uniform(c, 0.0, 1.0) < p;
}
