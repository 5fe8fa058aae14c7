/* SPDX-License-Identifier: GPL-3.0-or-later
 * swings.h - a pendulum that was filmed nine times, from further out each time.
 */
#ifndef SWINGS_H
#define SWINGS_H

#include "fit_support.h"

enum { SWINGS = 9 };
static const char pendulum[] = "models/pendulum.yaml";

/* swing i of a model, filmed. @return its path, which stays until the next film of it */
static inline const char *film_swing(int i, const char *model, const char *const *truth,
                                     unsigned long long seed)
{
    static char kept[SWINGS][200];
    char start[60], name[40];
    snprintf(start, sizeof start, "rod.initial.position=%d deg", 12 + 6 * i);
    const char *const told[] = {start, NULL};
    film m = {.model = model,
              .truth = truth,
              .told = told,
              .channels = "angle",
              .rate = 100.0,
              .until = 4.0,
              .noise = 1e-3,
              .seed = seed + (unsigned long long)i};
    snprintf(name, sizeof name, "swing%d.csv", i);
    snprintf(kept[i], sizeof kept[i], "%s", take(name, &m));
    return kept[i];
}

/* @param model  the file that is fitted; the swings are made by models/pendulum.yaml */
static inline void open_swings(fitted *f, const char *model, const char *const *truth,
                               unsigned long long seed)
{
    const char *data[SWINGS + 1] = {NULL};
    for (int i = 0; i < SWINGS; i++) {
        data[i] = film_swing(i, pendulum, truth, seed);
    }
    open_fit(f, model, NULL, data);
}

#endif
