/* SPDX-License-Identifier: GPL-3.0-or-later
 * box.c - steps in a process that is killed for any system call but read, write and exit: an FMU
 * keeps the core's promise between two communication points.
 */
#define _DEFAULT_SOURCE // syscall
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>
#if defined __linux__
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#endif

#include "importer.h"

enum { NO_BOX = 77, STEPS = 400 };

/* half a second with everything that may happen between steps. @return 0 */
static int play(unit *u, const char *force, const variable *tunable, void **state)
{
    const double tick = 1e-3;
    double t = 0.0, reached, y[OUTPUTS];
    int bad = 0;
    for (int i = 0; i < STEPS; i++, t += tick) {
        bad |= force != NULL && unit_put(u, force, 0.01 * (i % 5)) != OK;
        bad |= tunable != NULL &&
               unit_set(u, tunable->reference, tunable->start * (1.0 - 1e-3 * (i % 3))) != OK;
        bad |= unit_step(u, t, tick, &reached) != OK || unit_outputs(u, y) == 0;
        if (i % 100 == 50) {
            bad |= unit_keep(u, state) != OK || unit_take(u, *state) != OK;
        }
    }
    return bad;
}

static const variable *first_tunable(const fmu *f)
{
    for (int i = 0; i < f->d.n; i++) {
        if (strcmp(f->d.v[i].variability, "tunable") == 0) {
            return &f->d.v[i];
        }
    }
    return NULL;
}

/* @return exit code of the process, -1: killed */
static int in_box(unit *u, const char *force, void **state, int misbehave)
{
#if defined __linux__
    const variable *tunable = first_tunable(u->f);
    fflush(stdout);
    pid_t child = fork();
    if (child == 0) {
        if (prctl(PR_SET_SECCOMP, SECCOMP_MODE_STRICT) != 0) {
            _exit(NO_BOX);
        }
        if (misbehave) {
            (void)getppid();
        }
        syscall(SYS_exit, play(u, force, tunable, state));
    }
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
#else
    (void)u, (void)force, (void)state, (void)misbehave, (void)play, (void)first_tunable;
    return NO_BOX;
#endif
}

void check_box(const fmu *f)
{
    unit u;
    void *state = NULL;
    const char *force = NULL;
    for (int i = 0; f->model != NULL && i < f->model->ninput; i++) {
        force = f->model->inputs[i].kind != STEIN_INPUT_MOTION ? f->model->inputs[i].name : force;
    }
    if (allocations() < 0) {
        return; // a sanitizer makes its own system calls
    }
    claim(unit_start(&u, f) == OK && unit_keep(&u, &state) == OK, "an instance and a state");
    int code = in_box(&u, force, &state, 0);
    if (code == NO_BOX) {
        printf("note: no seccomp here, system calls are not tested\n");
    } else {
        claim(code == 0, "%d steps without a system call: %s", STEPS,
              code < 0 ? "killed" : "they fail");
        claim(in_box(&u, force, &state, 1) == -1, "who makes one is killed");
    }
    unit_drop(&u, &state);
    unit_free(&u);
}
