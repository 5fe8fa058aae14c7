/* SPDX-License-Identifier: GPL-3.0-or-later
 * main.c - tests of an FMU: importer VERSION LIBRARY DESCRIPTION CSV [CHECK...]
 *
 * CSV is the output of `stein simulate` for the same mechanism. Failed claims are printed; the
 * last line is the numbers of both kinds.
 */
#include <math.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../sanitized.h"
#include "importer.h"

static atomic_int passed, failed;

void claim(int holds, const char *format, ...)
{
    if (holds) {
        atomic_fetch_add(&passed, 1);
        return;
    }
    va_list list;
    va_start(list, format);
    printf("FAILED: ");
    vprintf(format, list);
    printf("\n");
    va_end(list);
    atomic_fetch_add(&failed, 1);
}

int same(double a, double b)
{
    return memcmp(&a, &b, sizeof a) == 0;
}

/* The FMU uses this program's malloc; sanitizers have one of their own. */
#if SANITIZED
long allocations(void)
{
    return -1;
}

void fail_allocation(long n)
{
    (void)n;
}
#else
static atomic_long asked, fail_at;
extern void *__libc_malloc(size_t size);
extern void *__libc_calloc(size_t n, size_t size);
extern void *__libc_realloc(void *block, size_t size);

static int fails(void)
{
    return atomic_fetch_add(&asked, 1) + 1 == atomic_load(&fail_at);
}

void *malloc(size_t size)
{
    return fails() ? NULL : __libc_malloc(size);
}

void *calloc(size_t n, size_t size)
{
    return fails() ? NULL : __libc_calloc(n, size);
}

void *realloc(void *block, size_t size)
{
    return fails() ? NULL : __libc_realloc(block, size);
}

long allocations(void)
{
    return atomic_load(&asked);
}

void fail_allocation(long n)
{
    atomic_store(&fail_at, n > 0 ? atomic_load(&asked) + n : 0);
}
#endif

static const struct check {
    const char *name;
    void (*run)(const fmu *f);
} checks[] = {
    {"starts", check_starts},    {"refusals", check_refusals}, {"rest", check_rest},
    {"steps", check_steps},      {"states", check_states},     {"parameters", check_parameters},
    {"inputs", check_inputs},    {"discard", check_discard},   {"memory", check_memory},
    {"box", check_box},          {"slopes", check_slopes},     {"threads", check_threads},
    {"exchange", check_exchange}};

/* all of them, where none is named */
static int is_wanted(const char *name, int argc, char **argv)
{
    int wanted = argc == 5;
    for (int i = 5; i < argc; i++) {
        wanted |= strcmp(argv[i], name) == 0;
    }
    return wanted;
}

int main(int argc, char **argv)
{
    fmu f;
    if (argc < 5 || !fmu_open(&f, atoi(argv[1]), argv[2], argv[3])) {
        printf("usage: importer VERSION LIBRARY DESCRIPTION CSV [CHECK...]\n");
        return 2;
    }
    if (is_wanted("record", argc, argv)) {
        check_record(&f, argv[4]);
    }
    for (size_t i = 0; i < sizeof checks / sizeof *checks; i++) {
        if (is_wanted(checks[i].name, argc, argv)) {
            checks[i].run(&f);
        }
    }
    free(f.d.v);
    printf("%d %d\n", atomic_load(&passed), atomic_load(&failed));
    return 0;
}
