/* SPDX-License-Identifier: MIT
 * processor.c - how many doubles this processor works on at once.
 *
 * Asked of the processor itself: the compilers' own question needs a library of theirs, and the
 * core needs none. An operating system that does not keep the wide registers counts as not having
 * them.
 */
#include "lane.h"

#if defined __x86_64__
#include <cpuid.h>

static unsigned kept_registers(void)
{
    unsigned low, high;
    __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    return low;
}

int stein__processor_lanes(void)
{
    enum { OSXSAVE = 1 << 27, AVX2 = 1 << 5, AVX512F = 1 << 16, AVX512DQ = 1 << 17 };
    const unsigned avx512vl = 1u << 31, halves = 0x06, wholes = 0xe6;
    unsigned a, b, c, d;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !(c & OSXSAVE) ||
        (kept_registers() & halves) != halves || !__get_cpuid_count(7, 0, &a, &b, &c, &d)) {
        return 2;
    }
    int wide = (b & AVX512F) && (b & AVX512DQ) && (b & avx512vl);
    return wide && (kept_registers() & wholes) == wholes ? 8 : b & AVX2 ? 4 : 2;
}

#else

int stein__processor_lanes(void)
{
    return 2; // SSE2 and NEON; elsewhere the compiler takes them apart
}

#endif
