/* SPDX-License-Identifier: GPL-3.0-or-later
 * rotor_support.h - strokes of the wheel of rotor.h with noise, and their diagnosis.
 */
#ifndef ROTOR_SUPPORT_H
#define ROTOR_SUPPORT_H

#include "fit_support.h"
#include "rotor.h"
#include "stein/diagnose.h"

enum { ROTOR_STROKES = 6 };

/** A model, its strokes and their diagnosis. */
typedef struct rotor {
    lab_model *model;
    lab_dataset *data;
    lab_diagnosis *d;
} rotor;

static inline void rotor_free(rotor *r)
{
    lab_diagnosis_destroy(r->d);
    lab_dataset_close(r->data);
    lab_close(r->model);
}

/** Strokes of a mechanism with `truth` ("NAME=VALUE", closed by NULL) in them, diagnosed.
 *  @param text  of the mechanism that is diagnosed
 *  @param real of the filmed one
 *  @param told  of each stroke, closed by NULL: written as `# set`, and so */
static inline rotor rotor_filmed(const char *text, const char *real, const char *const *truth,
                                 const char *told[ROTOR_STROKES][3])
{
    rotor r = {NULL, NULL, NULL};
    const char *path[ROTOR_STROKES];
    char file[100], filmed[100], kept[ROTOR_STROKES][100];
    snprintf(file, sizeof file, "%s", write_file("rotor.yaml", text));
    snprintf(filmed, sizeof filmed, "%s", write_file("real.yaml", real));
    for (int s = 0; s < ROTOR_STROKES; s++) {
        char name[20];
        snprintf(name, sizeof name, "s%d.csv", s);
        film m = {.model = filmed,
                  .truth = truth,
                  .told = told[s],
                  .channels = "angle",
                  .rate = 200.0,
                  .until = 0.7,
                  .noise = 1e-3,
                  .seed = 17ULL + (unsigned long long)s};
        snprintf(kept[s], sizeof kept[s], "%s", take(name, &m));
        path[s] = kept[s];
    }
    lab_options options = cache_here(NULL);
    ck_assert_stein(lab_open(&r.model, file, &options, err));
    examine(file, r.model, path, ROTOR_STROKES, &r.data, &r.d);
    return r;
}

/** The same of the rotor.
 *  @param start   "wheel.initial.position=..." of stroke s is start[s % n]
 *  @param stated  one thing more that is so and that every stroke states; NULL: none */
static inline rotor rotor_stated(const char *const *truth, const char *const *start, int n,
                                 const char *stated)
{
    const char *told[ROTOR_STROKES][3];
    for (int s = 0; s < ROTOR_STROKES; s++) {
        told[s][0] = start[s % n], told[s][1] = stated, told[s][2] = NULL;
    }
    return rotor_filmed(rotor_text, rotor_text, truth, told);
}

/** The same with nothing stated. */
static inline rotor rotor_with(const char *const *truth, const char *const *start, int n)
{
    return rotor_stated(truth, start, n, NULL);
}

/** The same with one thing in them. */
static inline rotor rotor_diagnosed(const char *truth, const char *const *start, int n)
{
    const char *one[] = {truth, NULL};
    return rotor_with(one, start, n);
}

/** A candidate by its kind. */
static inline const lab_suspect *rotor_suspect(const rotor *r, const char *kind)
{
    for (int i = 0; i < r->d->nsuspect; i++) {
        if (strcmp(r->d->suspect[i].candidate.effect->kind, kind) == 0) {
            return &r->d->suspect[i];
        }
    }
    ck_abort_msg("no suspect %s", kind);
    return NULL;
}

#endif
