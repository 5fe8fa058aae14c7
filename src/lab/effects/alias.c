/* SPDX-License-Identifier: GPL-3.0-or-later
 * alias.c - equivalent candidates.
 *
 * The equations depend on parameters p only through the derived constants d = setup(p). So two
 * candidates are the same cause when they move d along the same line,
 *
 *      dd/da = (d(p + 2 e) - d(p + e)) / e         e: a small amount of the candidate
 *
 * in a form in which equal physics has equal numbers:
 *
 *      a line moved by u along its normal n        =  a gap of -u (along the line: nothing)
 *      a spring's zero moved by u, or k by dk      =  a preload k u + dk q0 (and dk)
 *      a point moved by u along the line's normal  =  a gap of u
 *      a felt's force moved by da x^3 + db x^2 + dc x  =  by dc' x
 *      a tracked point moved so that its only reading changes by g of itself  =  a gain of g
 *
 * The first two are exact for the laws of law.h: place and speeds of a spot depend on the point,
 * not on the line's depth, and a torque -k (q - q0) is linear. A line with ends, or a spring that
 * hardens, has no such alias. The third holds where a body hardly turns while it touches, a key on
 * its felts, and no output shows the gap when it does not: turned by a there, its point lies
 *
 *      u cos(a) + v sin(a)      v: how much it was moved along the line
 *
 * farther off, and at a depth x beside r of the lever has one that is longer by v, for friction one
 * that is longer by u. They are the same where (a + x/r) |v/u| + x/r + a^2/2 is below a hundredth.
 * The fourth holds where a felt is hardly pressed: of all straight lines the nearest one down to
 * the deepest d has dc' = dc + 3/4 db d + 3/5 da d^2, and is off by |db d/4 + 2/5 da d^2| d there.
 * They are the same where that is below a hundredth of dc' d. Data show a hundredth of a cause only
 * if the cause is hundreds of its sd. The last one is exact: the point is nothing but what one
 * channel reads, and in some postures apart the reading with the moved point is 1 + g times that
 * without (compared numerically: the point of a pendulum along its rod, the pin at zero).
 * Consequences of a formula of the file (string.height) need no separate rule. A comparison of
 * predictions would find the pairs that data cannot separate, which is another question: it depends
 * on the data and has an interval.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "added_parts.h"
#include "functions.h"

static const double small_amount = 1e-5; /* of the limit */
static const double alike = 1e-6;        /* relative difference of two directions */
static const double rounding = 1e-13, residue = 1e-9;
static const double hardly = 1e-2; /* of both effects */

enum { POSTURES = 6 };

typedef struct compass {
    const lab_model *model;
    const stein_model *m;
    const double *base;      /* parameters of the file */
    double *p, *d1, *d2;     /* [np], [nd], [nd] */
    double *way;             /* [n*nd] directions */
    lab__touching *touching; /* [ncontact + nnotch] */
} compass;

/* ---- directions ---- */

/* does an output show how far a contact's sides are apart, also where they do not touch? */
static int is_watched(const stein_model *m, int contact)
{
    for (int i = 0; i < m->nchannel; i++) {
        if (m->channels[i].read == STEIN_READ_GAP && m->channels[i].index == contact) {
            return 1;
        }
    }
    return 0;
}

/* Is a channel the place of a point that nothing else uses? */
static int reads_alone(const stein_model *m, int channel)
{
    const stein_channel *own = &m->channels[channel];
    int alone = own->read >= STEIN_READ_X && own->read <= STEIN_READ_VZ, point = own->index;
    for (int i = 0; alone && i < m->nchannel; i++) {
        const stein_channel *c = &m->channels[i];
        alone =
            i == channel || c->read < STEIN_READ_X || c->read > STEIN_READ_VZ || c->index != point;
    }
    for (int i = 0; alone && i < m->ninput; i++) {
        alone = m->inputs[i].kind != STEIN_INPUT_POINT || m->inputs[i].index != point;
    }
    for (int i = 0; alone && i < m->nlink; i++) {
        alone = m->links[i].point[0] != point && m->links[i].point[1] != point;
    }
    return alone;
}

/* is an output, an input or a link at the point? else it is only a name, what touches has its own
 */
static int is_used(const stein_model *m, int point)
{
    int used = 0;
    for (int i = 0; i < m->nchannel; i++) {
        const stein_channel *c = &m->channels[i];
        used |= c->read >= STEIN_READ_X && c->read <= STEIN_READ_VZ && c->index == point;
    }
    for (int i = 0; i < m->ninput; i++) {
        used |= m->inputs[i].kind == STEIN_INPUT_POINT && m->inputs[i].index == point;
    }
    for (int i = 0; i < m->nlink; i++) {
        used |= m->links[i].point[0] == point || m->links[i].point[1] == point;
    }
    return used;
}

static void leave_names(const compass *k, double *way)
{
    for (int i = 0; i < k->m->npoint; i++) {
        int at = k->m->points[i].at;
        if (at >= 0 && !is_used(k->m, i)) {
            memset(way + at, 0, 3 * sizeof *way);
        }
    }
}

/* the only spot of its contact, on a line without ends, whose normal stays */
static int is_endless(const compass *k, const stein_spot *spot, const double *way)
{
    const double *line = k->d1 + spot->side[1].d, *move = way + spot->side[1].d;
    return spot->side[1].kind == STEIN_LINE && k->m->contacts[spot->contact].nspot == 1 &&
           !isfinite(line[STEIN_SHAPE_LO]) && !isfinite(line[STEIN_SHAPE_HI]) &&
           move[STEIN_SHAPE_NX] == 0.0 && move[STEIN_SHAPE_NZ] == 0.0;
}

static void fold_points(const compass *k, double *way)
{
    for (int i = 0; i < k->m->nspot; i++) {
        const stein_spot *spot = &k->m->spots[i];
        const lab__touching *t = &k->touching[spot->contact];
        const double *line = k->d1 + spot->side[1].d, *point = k->d1 + spot->side[0].d;
        double *move = way + spot->side[0].d;
        double lever = hypot(point[STEIN_SHAPE_X], point[STEIN_SHAPE_Z]);
        if (!t->touch || !is_endless(k, spot, way) || is_watched(k->m, spot->contact) ||
            move[STEIN_SHAPE_R] != 0.0) {
            continue;
        }
        double x = t->c * move[STEIN_SHAPE_X] - t->s * move[STEIN_SHAPE_Z];
        double z = t->s * move[STEIN_SHAPE_X] + t->c * move[STEIN_SHAPE_Z];
        double u = line[STEIN_SHAPE_NX] * x + line[STEIN_SHAPE_NZ] * z;
        double v = line[STEIN_SHAPE_NZ] * x - line[STEIN_SHAPE_NX] * z;
        double deep = t->depth / lever;
        double off = (t->turns + deep) * fabs(v / u) + deep + 0.5 * t->turns * t->turns;
        if (off < hardly) { // not where nothing moves
            move[STEIN_SHAPE_X] = move[STEIN_SHAPE_Z] = 0.0;
            way[k->m->contacts[spot->contact].normal + STEIN_NORMAL_GAP] += u;
        }
    }
}

static void fold_lines(const compass *k, double *way)
{
    for (int i = 0; i < k->m->nspot; i++) {
        const stein_spot *spot = &k->m->spots[i];
        const stein_contact *contact = &k->m->contacts[spot->contact];
        const double *line = k->d1 + spot->side[1].d;
        double *move = way + spot->side[1].d;
        if (!is_endless(k, spot, way)) {
            continue;
        }
        double x = move[STEIN_SHAPE_X], z = move[STEIN_SHAPE_Z];
        double up = line[STEIN_SHAPE_NX] * x + line[STEIN_SHAPE_NZ] * z;
        move[STEIN_SHAPE_X] = move[STEIN_SHAPE_Z] = 0.0;
        way[contact->normal + STEIN_NORMAL_GAP] -= fabs(up) > residue * hypot(x, z) ? up : 0.0;
    }
}

/* @param law  in d */
static void fold_felt(const lab__touching *t, double *law)
{
    double d = t->depth, b = law[STEIN_NORMAL_B] * d, a = law[STEIN_NORMAL_A] * d * d;
    double slope = law[STEIN_NORMAL_C] + 0.75 * b + 0.6 * a, off = 0.25 * b + 0.4 * a;
    if (t->touch && fabs(off) < hardly * fabs(slope)) {
        law[STEIN_NORMAL_A] = law[STEIN_NORMAL_B] = 0.0;
        law[STEIN_NORMAL_C] = slope;
    }
}

static void fold_felts(const compass *k, double *way)
{
    for (int i = 0; i < k->m->ncontact; i++) {
        fold_felt(&k->touching[i], way + k->m->contacts[i].normal);
    }
    for (int i = 0; i < k->m->nnotch; i++) {
        fold_felt(&k->touching[k->m->ncontact + i], way + k->m->notches[i].normal);
    }
}

static void fold_springs(const compass *k, double *way)
{
    for (int j = 0; j < k->m->nq; j++) {
        const double *law = k->d1 + k->m->bodies[j].joint;
        double *move = way + k->m->bodies[j].joint;
        if (law[STEIN_JOINT_K3] != 0.0 || move[STEIN_JOINT_K3] != 0.0) {
            continue;
        }
        double a = law[STEIN_JOINT_K] * move[STEIN_JOINT_Q0];
        double b = move[STEIN_JOINT_K] * law[STEIN_JOINT_Q0];
        double torque = fabs(a + b) > 1e-8 * (fabs(a) + fabs(b)) ? a + b : 0.0;
        move[STEIN_JOINT_PRELOAD] += torque;
        move[STEIN_JOINT_Q0] = 0.0;
    }
}

/* all readings and accelerations in some postures, with parameters p. @param to [POSTURES][nchannel
 * + nq] @return 0: they cannot be taken */
static int postures(const compass *k, const double *p, double *to)
{
    stein_sim *sim = NULL;
    stein_err why;
    size_t nq = (size_t)k->m->nq, n = (size_t)k->m->nchannel + nq;
    double *q = calloc(2 * nq + 1, sizeof *q);
    int ok = q != NULL && lab_sim(k->model, NULL, &sim, &why) == STEIN_OK &&
             stein_set_all(sim, p, &why) == STEIN_OK;
    for (size_t i = 0; ok && i < POSTURES; i++) {
        for (size_t j = 0; j < nq; j++) { // no two of them alike, none a multiple of another
            q[j] = 0.9 * stein__sin(1.0 + 2.3 * (double)i + 1.7 * (double)j);
            q[nq + j] = 1.1 * stein__sin(2.0 + 1.9 * (double)i + 2.9 * (double)j);
        }
        ok = stein_set_state(sim, 0.0, q, q + nq, &why) == STEIN_OK;
        for (int c = 0; ok && c < k->m->nchannel; c++) {
            to[i * n + (size_t)c] = stein_read(sim, c);
        }
        if (ok) {
            memcpy(to + i * n + (size_t)k->m->nchannel, stein_qdd(sim), sizeof *to * nq);
        }
    }
    stein_sim_destroy(sim);
    free(q);
    return ok;
}

/* Relative change of a channel's reading from one set of postures to the other; NAN: it is not the
 * same in all of them, or something else changes as well. */
static double gain_of(const compass *k, const double *plain, const double *moved, int channel)
{
    size_t n = (size_t)k->m->nchannel + (size_t)k->m->nq, at = (size_t)channel;
    double most = 0.0, sum = 0.0, square = 0.0;
    int only = 1;
    for (size_t i = 0; i < POSTURES * n; i++) {
        if (i % n == at) {
            sum += plain[i] * (moved[i] - plain[i]);
            square += plain[i] * plain[i];
        } else {
            only &= moved[i] == plain[i] || (isnan(moved[i]) && isnan(plain[i]));
        }
    }
    double gain = only && square > 0.0 ? sum / square : (double)NAN;
    for (size_t i = at; i < POSTURES * n; i += n) {
        most = fmax(most, fabs(moved[i] - (1.0 + gain) * plain[i]));
    }
    return most <= alike * fabs(gain) * sqrt(square) ? gain : (double)NAN;
}

/* does a way move a side of a contact? */
static int moves_side(const compass *k, const double *way)
{
    int moves = k->m->nnotch > 0; // no place of a notch is a reading alone
    for (int i = 0; i < 2 * k->m->nspot; i++) {
        const double *side = way + k->m->spots[i / 2].side[i % 2].d;
        for (int n = 0; n < STEIN_SHAPE_SIZE && side + n < way + k->m->nd; n++) {
            moves |= side[n] != 0.0;
        }
    }
    return moves;
}

/* a tracked point whose only reading changes in proportion: the way of that channel's gain, of the
 * candidates kept so far. @return 0: out of memory */
static int fold_reading(compass *k, const lab_candidate *c, const lab_candidate *kept, int nkept,
                        double *way)
{
    size_t n = (size_t)k->m->nchannel + (size_t)k->m->nq;
    double *plain = NULL;
    for (int g = 0; g < nkept && c->effect->site == LAB_AT_PARAMETER; g++) {
        if (strcmp(kept[g].effect->kind, "sensor_gain") != 0 ||
            !reads_alone(k->m, kept[g].channel) || moves_side(k, way)) {
            continue;
        }
        plain = malloc(sizeof *plain * 2 * POSTURES * n);
        if (plain == NULL) {
            return 0;
        }
        memcpy(k->p, k->base, sizeof *k->p * (size_t)k->m->np);
        int ok = postures(k, k->p, plain);
        lab_candidate_apply(c, c->limit, k->p);
        ok = ok && postures(k, k->p, plain + POSTURES * n);
        double by =
            ok ? gain_of(k, plain, plain + POSTURES * n, kept[g].channel) / c->limit : (double)NAN;
        for (int i = 0; isfinite(by) && by != 0.0 && i < k->m->nd; i++) {
            way[i] = by * k->way[(size_t)g * (size_t)k->m->nd + (size_t)i];
        }
        free(plain);
    }
    return 1;
}

static void find_way(compass *k, const lab_candidate *c, double *way)
{
    size_t size = sizeof *k->p * (size_t)k->m->np;
    double e = small_amount * c->limit;
    memcpy(k->p, k->base, size);
    lab_candidate_apply(c, 2.0 * e, k->p);
    stein_setup(k->m, k->p, k->d2);
    memcpy(k->p, k->base, size);
    lab_candidate_apply(c, e, k->p);
    stein_setup(k->m, k->p, k->d1);
    for (int i = 0; i < k->m->nd; i++) {
        double change = k->d2[i] - k->d1[i];
        int none = !isfinite(change) || fabs(change) <= rounding * fabs(k->d1[i]);
        way[i] = none ? 0.0 : change / e;
    }
    leave_names(k, way);
    fold_lines(k, way);
    fold_points(k, way);
    fold_springs(k, way);
    fold_felts(k, way);
}

static int leads_nowhere(const double *way, int n)
{
    int i = 0;
    while (i < n && way[i] == 0.0) {
        i++;
    }
    return i == n;
}

static int parallel(const double *a, const double *b, int n)
{
    int first = 0;
    while (first < n && a[first] == 0.0 && b[first] == 0.0) {
        first++;
    }
    if (first == n || a[first] == 0.0 || b[first] == 0.0) {
        return 0;
    }
    for (int i = first; i < n; i++) {
        double scaled = b[i] * (a[first] / b[first]);
        if (!(fabs(a[i] - scaled) <= alike * fmax(fabs(a[i]), fabs(scaled)))) {
            return 0;
        }
    }
    return 1;
}

/* ---- the list ---- */

static void note(lab_candidate *kept, const lab_candidate *same)
{
    size_t n = strlen(kept->alias), more = strlen(same->place) + (n > 0);
    if (same->effect->site == LAB_AT_PARAMETER && n + more < sizeof kept->alias) {
        snprintf(kept->alias + n, sizeof kept->alias - n, "%s%s", n > 0 ? " " : "", same->place);
    }
}

stein_status lab__aliases(lab_candidate *list, int *n, const lab_model *model, stein_err *err)
{
    const stein_model *m = lab_equations(model);
    size_t np = (size_t)m->np, nd = (size_t)m->nd;
    compass k = {.model = model, .m = m, .base = lab_parameters(model)};
    k.p = malloc(sizeof *k.p * (np + 2 * nd + (size_t)*n * nd + 1));
    k.touching = malloc(sizeof *k.touching * (size_t)(m->ncontact + m->nnotch + 1));
    stein_status status = k.p != NULL && k.touching != NULL ? lab__touchings(k.touching, model, err)
                                                            : lab__no_memory(err);
    if (status != STEIN_OK) {
        free(k.p);
        free(k.touching);
        return status;
    }
    k.d1 = k.p + np, k.d2 = k.d1 + nd, k.way = k.d2 + nd;
    int kept = 0;
    for (int i = 0; i < *n; i++) {
        const lab_candidate c = list[i];
        double *way = k.way + (size_t)kept * nd;
        int same = -1, open = c.nparam > 0;
        memset(way, 0, sizeof *way * nd); // a part has no alias
        if (open) {
            find_way(&k, &c, way);
            if (!fold_reading(&k, &c, list, kept, way)) {
                free(k.p);
                free(k.touching);
                return lab__no_memory(err);
            }
        }
        for (int j = 0; open && same < 0 && j < kept; j++) {
            same = parallel(k.way + (size_t)j * nd, way, m->nd) ? j : -1;
        }
        if (same >= 0) {
            note(&list[same], &c);
        } else if (!open || !leads_nowhere(way, m->nd)) {
            list[kept++] = c;
        }
    }
    *n = kept;
    free(k.p);
    free(k.touching);
    return STEIN_OK;
}
