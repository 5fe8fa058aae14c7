/* SPDX-License-Identifier: GPL-3.0-or-later
 * refit.h - what the two halves of the refit share: its columns (columns.c) and its steps
 * (refit.c).
 */
#ifndef REALITY_REFIT_H
#define REALITY_REFIT_H

#include "reality.h"

enum {
    MAX_COMMON = 40,
    N_TRIGGER = 0,
    N_OFFSET,
    N_DRIVE = N_OFFSET + SEEN,
    N_JOINTS,
    N_CONTACTS,
    OWN
};

/* what the numbers do to the film of one stroke, per prior sd */
typedef struct columns {
    double *X; /* [ncommon + OWN][rows] in units of noise */
    double *G; /* [ncommon + OWN][ncommon + OWN] X'X, lower half */
} columns;

typedef struct block {
    setting at;      /* told settings, no scatter */
    stroke play;     /* without effect at the true parameters */
    film base;       /* what is seen of it */
    film shown;      /* the same with the effect in question */
    columns first;   /* at the true parameters */
    columns renewed; /* where the refit stood; none: {NULL, NULL} */
    double own[OWN]; /* own numbers at which the columns are computed, in prior sd */
} block;

struct refit {
    const world *w;
    const design *d;
    camera camera;
    int nparam, common[MAX_COMMON]; /* parameter indices */
    effect known;                   /* what one outside of the table may be; kind NULL: nothing */
    int ncommon;                    /* parameters and `known` */
    int rows;                       /* per stroke: frames times channels */
    int like[FIT];                  /* repeats share films and columns: the first such stroke */
    block block[FIT];               /* of the first ones */
    double at[MAX_COMMON];          /* common numbers where the columns are taken */
    int use[MAX_COMMON + OWN];      /* columns that may be used against the effect */
    double *r, *before;             /* [FIT][rows] residuals, and those before a step */
    double *u, *low;                /* [unknowns] where the refit stands, where it begins */
    double amount;                  /* of the effect that `low` is of, 0: of none */
};

/** The columns that count. */
static inline const columns *columns_of(const block *b)
{
    return b->renewed.X != NULL ? &b->renewed : &b->first;
}

static inline double *column(const refit *r, const columns *c, int k)
{
    return c->X + (size_t)k * (size_t)r->rows;
}

/** Place of column k of stroke i among all unknowns. */
static inline size_t place(const refit *r, int i, int k)
{
    return (size_t)(k < r->ncommon ? k : k + i * OWN);
}

static inline double inner(const double *a, const double *b, int n)
{
    double s = 0.0;
    for (int i = 0; i < n; i++) {
        s += a[i] * b[i];
    }
    return s;
}

/** (b - a) times factor [noise of a sample], channel after channel. */
void refit_change(const refit *r, const film *a, const film *b, double factor, double *out);
/** Film of a stroke without effect at common[ncommon] and own[OWN], both in prior sd; offsets need
 *  no film. @return 0, -1: it cannot be simulated */
int refit_film(const refit *r, const block *b, const double *common, const double *own, film *f);
/** Columns of every stroke at the true parameters. @return 0, -1 */
int columns_create(refit *r);
/** Columns of every stroke at r->u. @return 0, -1: as they were */
int columns_renew(refit *r);
/** The column of the known law beside those that are there. */
int columns_known(refit *r);
/** Those at the true parameters again. */
void columns_reset(refit *r);
void columns_free(block *b);

#endif
