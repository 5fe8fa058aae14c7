/* SPDX-License-Identifier: MIT
 * main.c - drops the lever of rocker.yaml on its felt; its equations are linked in, no file is
 * read.
 */
#include <stdio.h>
#include <stein/sim.h>

extern const stein_model stein_model_rocker; /* rocker.c, written by steingen */

typedef struct touches {
    int n;
    double first; /* [s] */
} touches;

static void on_event(void *ctx, stein_sim *sim, const stein_event *event)
{
    touches *t = ctx;
    (void)sim;
    if (event->kind == STEIN_EVENT_CONTACT_BEGIN) {
        t->first = t->n == 0 ? event->time : t->first;
        t->n++;
    }
}

int main(void)
{
    stein_sim *sim = NULL;
    stein_err err;
    touches t = {0, 0.0};
    double force;
    if (stein_sim_create(&sim, &stein_model_rocker, NULL, &err) != STEIN_OK) {
        return fprintf(stderr, "%s\n", err.msg), 1;
    }
    stein_on_event(sim, on_event, &t);
    if (stein_run(sim, 1.0, &err) != STEIN_OK ||
        stein_read_name(sim, "felt_force", &force, &err) != STEIN_OK) {
        return fprintf(stderr, "%s\n", err.msg), 1;
    }
    printf("on the felt after %.3f ms, %d touches, at rest with %.4f N\n", 1e3 * t.first, t.n,
           force);
    stein_sim_destroy(sim);
    return 0;
}
