/* SPDX-License-Identifier: GPL-3.0-or-later
 * main.c - second FROM UNTIL EVERY: mechanisms FROM, FROM + EVERY ... below UNTIL, opened from
 * their files as any other, against the peer: where they start, and after a motion of 20 ms. A line
 * each
 *
 *      number  bodies  kind  error of accelerations  error of loops  condition of loops
 *
 * with the largest difference relative to the largest acceleration, for tests/second.sh.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "second.h"
#include "stein/lab.h"
#include "stein/stein.h"

static int fail(int number, const char *what, const char *text)
{
    fprintf(stderr, "second: mechanism %d: %s: %s\n", number, what, text);
    return -1;
}

/** The worst of the states of a mechanism. */
typedef struct worst {
    double off, open, condition;
} worst;

/* where the simulation stands. @return 0, or -1 */
static int compare(const draw *d, int number, stein_sim *sim, worst *w)
{
    double ours[MOST_BODIES], size = 0.0, off = 0.0;
    peer_state theirs;
    char text[300];
    stein_err err;
    if (stein_acceleration(sim, stein_time(sim), stein_q(sim), stein_qd(sim), ours, &err) !=
        STEIN_OK) {
        return fail(number, "here", err.msg);
    }
    if (peer_look(d, stein_q(sim), stein_qd(sim), &theirs, text, sizeof text) != 0) {
        return fail(number, "Simbody", text);
    }
    for (int i = 0; i < d->n; i++) {
        size = fmax(size, fabs(theirs.qdd[i]));
        off = fmax(off, fabs(ours[i] - theirs.qdd[i]));
        off = isfinite(ours[i]) && isfinite(theirs.qdd[i]) ? off : (double)INFINITY;
    }
    w->off = fmax(w->off, off / size);
    w->open = fmax(w->open, theirs.open);
    w->condition = fmax(w->condition, theirs.condition);
    return 0;
}

static const char *kind_of(const draw *d)
{
    int closed = d->nloop > 0 || d->joint >= 0;
    return d->planar ? (closed ? "closed-plane" : "tree-plane")
                     : (closed ? "closed-space" : "tree-space");
}

/* @return 0, or -1 */
static int run(int number)
{
    draw d;
    char name[40], path[80];
    lab_options options = lab_options_default();
    lab_model *model = NULL;
    stein_sim *sim = NULL;
    stein_err err;
    worst w = {0.0, 0.0, 0.0};
    draw_make(&d, number);
    snprintf(name, sizeof name, "second%d", number);
    snprintf(path, sizeof path, "%s.yaml", name);
    if (draw_write(&d, name, path) != 0) {
        return fail(number, path, "cannot be written");
    }
    int made = lab_open(&model, path, &options, &err) == STEIN_OK &&
               lab_sim(model, NULL, &sim, &err) == STEIN_OK;
    int status = made ? compare(&d, number, sim, &w) : fail(number, "here", err.msg);
    if (status == 0 && stein_run(sim, 0.02, &err) != STEIN_OK) {
        status = fail(number, "here", err.msg);
    }
    status = status == 0 ? compare(&d, number, sim, &w) : status;
    if (status == 0) {
        printf("%d\t%d\t%s\t%.2e\t%.2e\t%.1e\n", number, d.n, kind_of(&d), w.off, w.open,
               w.condition);
        fflush(stdout);
    }
    stein_sim_destroy(sim);
    lab_close(model);
    unlink(path);
    return status;
}

int main(int argc, char **argv)
{
    int failed = 0;
    if (argc != 4) {
        fprintf(stderr, "usage: second FROM UNTIL EVERY\n");
        return 2;
    }
    int every = atoi(argv[3]), until = atoi(argv[2]);
    for (int number = atoi(argv[1]); every > 0 && number < until; number += every) {
        failed |= run(number) != 0;
    }
    return failed;
}
