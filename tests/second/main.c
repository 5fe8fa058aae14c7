/* SPDX-License-Identifier: GPL-3.0-or-later
 * main.c - second FROM UNTIL EVERY [contacts]: mechanisms FROM, FROM + EVERY ... below UNTIL,
 * opened from their files as any other, against the peer: where they start, and after a motion of
 * 20 ms. With `contacts` they touch where they start, and the peer moves for 50 ms, too. A line
 * each
 *
 *      number  bodies  kind  error of accelerations  error of loops  condition of loops  of motion
 *
 * with the largest difference relative to the largest acceleration, for tests/second.sh. That of
 * the motion is one of positions [rad or m]; 0 where there is none to compare.
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
    double off, open, condition, motion;
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

static int has_dry(const draw *d)
{
    int dry = 0;
    for (int i = 0; i < d->ncontact; i++) {
        dry |= d->contact[i].dry;
    }
    return dry;
}

static const char *kind_of(const draw *d)
{
    int closed = d->nloop > 0 || d->joint >= 0;
    if (d->ncontact > 0) {
        return has_dry(d) ? "contacts-dry" : d->planar ? "contacts-plane" : "contacts-space";
    }
    return d->planar ? (closed ? "closed-plane" : "tree-plane")
                     : (closed ? "closed-space" : "tree-space");
}

/* Both move, and accelerations are compared again. Dry friction is smoothed differently near rest:
 * only where it starts, sliding, it is the same. @return 0, or -1 */
static int move(const draw *d, int number, stein_sim *sim, worst *w)
{
    double q[MOST_BODIES], qd[MOST_BODIES], until = d->ncontact > 0 ? 0.05 : 0.02;
    char text[300];
    stein_err err;
    if (has_dry(d)) {
        return 0;
    }
    memcpy(q, stein_q(sim), sizeof *q * (size_t)d->n);
    memcpy(qd, stein_qd(sim), sizeof *qd * (size_t)d->n);
    if (stein_run(sim, until, &err) != STEIN_OK) {
        return fail(number, "here", err.msg);
    }
    if (d->ncontact > 0 && peer_move(d, until, q, qd, text, sizeof text) != 0) {
        return fail(number, "Simbody", text);
    }
    for (int i = 0; d->ncontact > 0 && i < d->n; i++) {
        w->motion = fmax(w->motion, fabs(stein_q(sim)[i] - q[i]));
    }
    return compare(d, number, sim, w);
}

/* @return 0, or -1 */
static int run(int number, int contacts)
{
    draw d;
    char name[40], path[80];
    lab_options options = lab_options_default();
    lab_model *model = NULL;
    stein_sim *sim = NULL;
    stein_err err;
    worst w = {0.0, 0.0, 0.0, 0.0};
    draw_make(&d, number);
    if (contacts) {
        draw_touch(&d);
    }
    snprintf(name, sizeof name, "second%d", number);
    snprintf(path, sizeof path, "%s.yaml", name);
    if (draw_write(&d, name, path) != 0) {
        return fail(number, path, "cannot be written");
    }
    int made = lab_open(&model, path, &options, &err) == STEIN_OK &&
               lab_sim(model, NULL, &sim, &err) == STEIN_OK;
    int status = made ? compare(&d, number, sim, &w) : fail(number, "here", err.msg);
    status = status == 0 ? move(&d, number, sim, &w) : status;
    if (status == 0) {
        printf("%d\t%d\t%s\t%.2e\t%.2e\t%.1e\t%.1e\n", number, d.n, kind_of(&d), w.off, w.open,
               w.condition, w.motion);
        fflush(stdout);
    }
    stein_sim_destroy(sim);
    lab_close(model);
    unlink(path);
    return status;
}

int main(int argc, char **argv)
{
    int failed = 0, contacts = argc == 5 && strcmp(argv[4], "contacts") == 0;
    if (argc != 4 && !contacts) {
        fprintf(stderr, "usage: second FROM UNTIL EVERY [contacts]\n");
        return 2;
    }
    int every = atoi(argv[3]), until = atoi(argv[2]);
    for (int number = atoi(argv[1]); every > 0 && number < until; number += every) {
        failed |= run(number, contacts) != 0;
    }
    return failed;
}
