/* SPDX-License-Identifier: GPL-3.0-or-later
 * watch.c - a command again whenever one of its files changes.
 *
 * Time and size of files are polled, which every file system has; an editor that replaces
 * a file leaves none for a moment, which is no change yet.
 */
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

#include "cli.h"

static const struct timespec between = {.tv_nsec = 200000000}; /* two looks */

typedef struct seen {
    struct timespec time;
    off_t size;
} seen;

/* @return 1 when the file is there and differs from what was seen, which is then the new */
static int changed(const char *path, seen *s)
{
    struct stat now;
    if (stat(path, &now) != 0 ||
        (now.st_mtim.tv_sec == s->time.tv_sec && now.st_mtim.tv_nsec == s->time.tv_nsec &&
         now.st_size == s->size)) {
        return 0;
    }
    *s = (seen){now.st_mtim, now.st_size};
    return 1;
}

static const char *wait_for_change(const cli_args *args, seen *file)
{
    for (;;) {
        for (int i = 0; i < args->noperand; i++) {
            if (changed(args->operand[i], &file[i])) {
                return args->operand[i];
            }
        }
        nanosleep(&between, NULL);
    }
}

int cli_watch(const cli_args *args, int (*run)(const cli_args *args))
{
    stein_err err = {STEIN_OK, ""};
    seen *file = calloc((size_t)args->noperand, sizeof *file);
    int there = 0;
    if (file == NULL) {
        return cli_failed(lab__no_memory(&err), &err);
    }
    for (int i = 0; i < args->noperand; i++) {
        there |= changed(args->operand[i], &file[i]);
    }
    int code = run(args);
    while (there && cli_finish(CLI_OK) == CLI_OK) {
        const char *path = wait_for_change(args, file);
        fprintf(stderr, "---- %s has changed\n", path);
        code = run(args);
    }
    free(file);
    return code;
}
