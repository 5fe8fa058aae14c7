/* SPDX-License-Identifier: GPL-3.0-or-later
 * memory.c - malloc and its relatives, which can be made to fail, and their callers.
 *
 * A place that requests memory is a new combination of the last four calls on the stack.
 */
#define _GNU_SOURCE /* dladdr */
#include <dlfcn.h>
#include <errno.h>
#include <execinfo.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "faults.h"

extern void *__libc_malloc(size_t size);
extern void *__libc_calloc(size_t n, size_t size);
extern void *__libc_realloc(void *block, size_t size);
extern void __libc_free(void *block);

static atomic_long asked, live, fail_at, refused;
static atomic_int for_good, forgetful;

/* ---- places: the first allocation of each ---- */

enum { FRAMES = 7, BELOW = 3, PLACES = 1 << 14 }; /* of these frames three are here */
static uint64_t place[PLACES];                    /* hashed; 0: no caller */
static long first_at[PLACES];
static int places;
static atomic_int noting;

static void note_place(long n)
{
    void *frame[FRAMES];
    atomic_store(&noting, 0); // reading the stack may request memory
    int depth = backtrace(frame, FRAMES);
    size_t known = depth > BELOW ? (size_t)(depth - BELOW) : 0;
    uint64_t hash = lab__hash(STEIN_HASH, frame + BELOW, known * sizeof *frame);
    size_t at = hash % PLACES;
    while (place[at] != 0 && place[at] != hash) {
        at = (at + 1) % PLACES;
    }
    if (place[at] == 0 && places < PLACES / 2) {
        place[at] = hash;
        first_at[places++] = n;
    }
    atomic_store(&asked, n); // nor is it counted
    atomic_store(&noting, 1);
}

enum { DEEP = 16, ASKING = 3 };   /* as many frames are here */
static void *refused_frame[DEEP]; /* caller of the first refused block */
static int refused_depth;

/* Does the caller leak the outer part of an incomplete object? GSL does, and libyaml of a
   sequence or mapping that it was about to put into a document. That is not ours to mend. */
static int forgets(void *const *frame, int depth)
{
    Dl_info info;
    if (depth > ASKING && dladdr(frame[ASKING], &info) != 0 &&
        strstr(info.dli_fname, "/libgsl.") != NULL) {
        return 1;
    }
    return depth > ASKING + 1 && dladdr(frame[ASKING + 1], &info) != 0 && info.dli_sname != NULL &&
           strcmp(info.dli_sname, "yaml_parser_load") == 0;
}

static void note_refused(void)
{
    void *frame[DEEP];
    int depth = backtrace(frame, DEEP);
    if (atomic_fetch_add(&refused, 1) == 0) {
        memcpy(refused_frame, frame, sizeof frame);
        refused_depth = depth;
    }
    if (forgets(frame, depth)) {
        atomic_store(&forgetful, 1);
    }
}

/* does this allocation fail? fail_at 0: none does */
static int fails(void)
{
    long n = atomic_fetch_add(&asked, 1) + 1, at = atomic_load(&fail_at);
    if (atomic_load(&noting)) {
        note_place(n);
    }
    int now = at > 0 && (atomic_load(&for_good) ? n >= at : n == at);
    if (now) {
        note_refused();
        errno = ENOMEM;
    }
    return now;
}

void *malloc(size_t size)
{
    void *block = fails() ? NULL : __libc_malloc(size);
    atomic_fetch_add(&live, block != NULL);
    return block;
}

void *calloc(size_t n, size_t size)
{
    void *block = fails() ? NULL : __libc_calloc(n, size);
    atomic_fetch_add(&live, block != NULL);
    return block;
}

void *realloc(void *was, size_t size)
{
    void *block = fails() ? NULL : __libc_realloc(was, size);
    atomic_fetch_add(&live, block != NULL && was == NULL);
    return block;
}

void free(void *block)
{
    atomic_fetch_sub(&live, block != NULL);
    __libc_free(block);
}

/* ---- controls ---- */

void memory_begin(void)
{
    void *frame[FRAMES];
    (void)backtrace(frame, FRAMES); // loads what it needs
}

void memory_fail(long at, int good)
{
    atomic_store(&asked, 0);
    atomic_store(&refused, 0);
    atomic_store(&forgetful, 0);
    atomic_store(&for_good, good);
    atomic_store(&fail_at, at);
}

void memory_calm(void)
{
    atomic_store(&fail_at, 0);
    atomic_store(&noting, 0);
}

long memory_live(void)
{
    for (int i = 0; i < 2; i++) { // told and forgotten: a message of the linker is kept till then
        (void)dlerror();
    }
    return atomic_load(&live);
}

long memory_refused(void)
{
    return atomic_load(&refused);
}

int memory_forgetful(void)
{
    return atomic_load(&forgetful);
}

void memory_who(void)
{
    backtrace_symbols_fd(refused_frame, refused_depth, STDOUT_FILENO);
}

void memory_note(void)
{
    memset(place, 0, sizeof place);
    places = 0;
    memory_fail(0, 0);
    atomic_store(&noting, 1);
}

int memory_places(const long **first)
{
    *first = first_at;
    return places;
}
