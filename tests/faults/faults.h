/* SPDX-License-Identifier: GPL-3.0-or-later
 * faults.h - shared by the files of this folder.
 *
 *   main.c       one failure after the other
 *   memory.c     malloc and its kin, which can be told to fail
 *   files.c      what the calls read
 *   calls.c      the calls: core, reader, generator
 *   calls_lab.c  the laboratory
 */
#ifndef FAULTS_H
#define FAULTS_H

#include <stdint.h>

#include "plot.h"
#include "sweep.h"

/* ---- memory.c ---- */

/** Before anything else. */
void memory_begin(void);
/** From now on the at-th allocation fails, and with for_good every one after it; 0: none does.
 *  Counts begin at 0. */
void memory_fail(long at, int for_good);
/** None fails any more, none is noted; the counts do not change. */
void memory_calm(void);
/** Blocks that are in use. */
long memory_live(void);
/** Allocations that were refused. */
long memory_refused(void);
/** 1: one was requested by a library that leaks blocks when it is refused. */
int memory_forgetful(void);
/** Print the caller of the first of them. */
void memory_who(void);
/** Record the places that request memory, until memory_calm(). */
void memory_note(void);
/** The first allocation of each place. @return how many */
int memory_places(const long **first);

/* ---- files.c ---- */

enum { FILES_PATH = 80 };
/** A temporary folder and its contents. */
typedef struct things {
    char folder[40], out[FILES_PATH], journal[FILES_PATH];
    const char *yaml;                           /* of the pendulum */
    char csv[FILES_PATH], swing[3][FILES_PATH]; /* of it: to fit; to diagnose */
    char rotor_yaml[FILES_PATH];                /* of a wheel whose drags look alike */
    char found[FILES_PATH];                     /* its diagnosis */
    char drive[FILES_PATH];                     /* of the action */
    char cc[FILES_PATH];                        /* a compiler that writes a line */
    const lab_model *action, *pendulum, *rotor; /* opened once, must not change */
    const lab_record *record;                   /* of a stroke of the action */
    lab_stroke stroke;
} things;
extern const things *const thing;

/** Make them, or end the program. */
void files_make(void);
/** @return 0 when the folder is gone */
int files_remove(void);
/** Defaults, with the cache in that folder. */
lab_options files_options(void);
/** Of a file, without memory: the call is over. */
uint64_t files_hash(const char *path);

/* ---- calls ---- */

/** A call: OK and a hash of the result, or an error. */
typedef stein_status call(uint64_t *result, stein_err *err);

/** The last one of a table has no name. */
typedef struct call_entry {
    const char *name;
    call *call;
    int by_place; /* not every allocation fails, but the first one of every so many-th place; of
                     every place, if the call is asked for. 0, and 1 if it is asked for: every one
                   */
} call_entry;
enum { NOT_ALL = 1 << 20 }; /* by_place of a call that takes a minute: none without its name */
extern const call_entry calls_core[], calls_lab[];

#endif
