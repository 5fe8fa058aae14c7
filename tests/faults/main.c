/* SPDX-License-Identifier: GPL-3.0-or-later
 * main.c - every allocation of every call of the library is made to fail: once, and from there on.
 *
 *     faults [NAME|all]
 *
 * Of calls that make millions, the first one of every place that makes some. Without a name a share
 * of these.
 *
 * malloc and its kin are defined in memory.c, so the libraries below ours (libyaml, GSL, stdio) use
 * them too. A call without memory has to end with an error and leave no block, no result and no
 * changed object; or it ends with the same result as with memory.
 */
#include <gsl/gsl_errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "faults.h"

static int wrong;

static void complain(const char *name, long at, int good, const char *what)
{
    printf("FAILED: %s, allocation %ld%s: %s\n", name, at, good ? " and all after it" : "", what);
    fflush(stdout);
    memory_who();
    wrong++;
}

/* @return 1 while there was an allocation to fail */
static int try_one(const call_entry *c, long at, int good, uint64_t expected)
{
    stein_err err = {STEIN_OK, ""};
    uint64_t result = 0;
    long before = memory_live();
    memory_fail(at, good);
    stein_status status = c->call(&result, &err);
    memory_calm();
    long after = memory_live();
    if (after != before && !memory_forgetful()) {
        char text[60];
        snprintf(text, sizeof text, "%ld blocks are left", after - before);
        complain(c->name, at, good, text);
    }
    if (status == STEIN_OK && result != expected && memory_refused() > 0 &&
        strcmp(c->name, "problems") != 0) {
        complain(c->name, at, good, "another result without an error");
    }
    if (status != STEIN_OK && (err.code != status || err.msg[0] == '\0')) {
        complain(c->name, at, good, "an error without a message");
    }
    return memory_refused() > 0;
}

static long fail_each(const call_entry *c, int good, uint64_t expected)
{
    long n = 0;
    while (try_one(c, n + 1, good, expected)) {
        n++;
    }
    return n;
}

/* the places that request memory in a call, *first allocation of each. @return their number */
static int find_places(const call_entry *c, const long **first)
{
    stein_err err;
    uint64_t result;
    memory_note();
    c->call(&result, &err);
    memory_calm();
    return memory_places(first);
}

/* the first allocation of every so many-th place. @return how many */
static long fail_places(const call_entry *c, int good, const long *first, int places, int stride,
                        uint64_t expected)
{
    long n = 0;
    for (int k = 0; k < places; k += stride, n++) {
        if (!try_one(c, first[k], good, expected)) {
            complain(c->name, first[k], good, "nobody asks for it any more");
        }
    }
    return n;
}

static void fail_all(const call_entry *c, int stride)
{
    stein_err err = {STEIN_OK, ""};
    uint64_t expected = 0;
    long n = 0;
    c->call(&expected, &err); // permanent buffers and caches exist now
    if (c->call(&expected, &err) != STEIN_OK) {
        printf("FAILED: %s: %s\n", c->name, err.msg);
        wrong++;
        return;
    }
    const long *first = NULL;
    int places = stride > 0 ? find_places(c, &first) : 0;
    for (int good = 0; good < 2; good++) {
        n += first != NULL ? fail_places(c, good, first, places, stride, expected)
                           : fail_each(c, good, expected);
    }
    printf("faults: %-9s %5ld allocations failed\n", c->name, n);
}

/* the selected ones of a table. @return their number */
static int choose(const call_entry *c, const char *name)
{
    int chosen = 0;
    for (; c->name != NULL; c++) {
        if (name == NULL ? c->by_place < NOT_ALL
                         : strcmp(name, "all") == 0 || strcmp(name, c->name) == 0) {
            fail_all(c, name == NULL ? c->by_place : c->by_place > 1);
            chosen++;
        }
    }
    return chosen;
}

int main(int argc, char **argv)
{
    const char *name = argc > 1 ? argv[1] : NULL;
    gsl_set_error_handler_off();
    setvbuf(stdout, NULL, _IOLBF, 0);
    memory_begin();
    files_make();
    if (choose(calls_core, name) + choose(calls_lab, name) == 0) {
        printf("FAILED: no call \"%s\"\n", name);
        wrong++;
    }
    wrong += files_remove();
    printf("faults: %d failed\n", wrong);
    return wrong == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
