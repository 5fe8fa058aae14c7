/* SPDX-License-Identifier: MIT
 * inertia.c - inertias that no body can have, and their treatment by the file or an option.
 *
 * The principal moments A, B, C of any body obey A <= B + C: each is a sum over two of three
 * squares. Tables of numbers often do not, by rounding, or because a slim body was given the moment
 * of a disc. Equations can be made with those, too (`accept`); or all three become their mean
 * (`balance`, as MuJoCo's balanceinertia does).
 */
#include <math.h>
#include <string.h>

#include "reader.h"

void mech__read_inertia(mech__reader *rd)
{
    static const char *const words[] = {"refuse", "accept", "balance"};
    const mech__node *node = mech__get(rd->root, "inertia");
    int choice =
        node ? mech__choice(rd, node, "treatment of inertias", "refuse accept balance") : 0;

    for (int i = 0; i < rd->nset; i++) {
        if (strcmp(rd->set[i].name, "inertia") == 0) {
            rd->set_used[i] = 1;
            for (choice = 2; choice >= 0 && strcmp(words[choice], rd->set[i].value) != 0;) {
                choice--;
            }
            if (choice < 0) {
                mech__problem_at(rd, NULL,
                                 "set inertia = \"%s\": expected one of refuse accept balance",
                                 mech__shown(rd, rd->set[i].value));
            }
        }
    }
    rd->inertia = choice < 0 ? MECH__REFUSE : (mech__inertia)choice;
}

/** Cyclic Jacobi rotations. */
void mech__principal(const mech_scalar I[6], double value[3])
{
    double A[3][3] = {{I[0].value, I[3].value, I[4].value},
                      {I[3].value, I[1].value, I[5].value},
                      {I[4].value, I[5].value, I[2].value}};

    for (int sweep = 0; sweep < 30; sweep++) {
        for (int p = 0; p < 3; p++) {
            int j = (p + 1) % 3, k = (p + 2) % 3;

            if (A[j][k] == 0.0) {
                continue;
            }
            double angle = 0.5 * atan2(2.0 * A[j][k], A[j][j] - A[k][k]);
            double c = cos(angle), s = sin(angle);

            for (int i = 0; i < 3; i++) {
                double x = A[i][j], y = A[i][k];

                A[i][j] = c * x + s * y;
                A[i][k] = c * y - s * x;
            }
            for (int i = 0; i < 3; i++) {
                double x = A[j][i], y = A[k][i];

                A[j][i] = c * x + s * y;
                A[k][i] = c * y - s * x;
            }
        }
    }
    for (int i = 0; i < 3; i++) {
        value[i] = A[i][i];
    }
}

int mech__violates_triangle(const mech_scalar I[6])
{
    double v[3];

    mech__principal(I, v);
    return I[0].kind != MECH_ZERO && I[1].kind != MECH_ZERO && I[2].kind != MECH_ZERO &&
           2.0 * fmax(v[0], fmax(v[1], v[2])) > (v[0] + v[1] + v[2]) * (1.0 + 1e-9);
}

/** All three moments of a body become their mean, products of inertia 0. */
static void balance(mech__reader *rd, int body)
{
    const mech_body *b = &rd->m->bodies[body];
    const mech__node *node = mech__get(rd->body_node[body], "inertia");
    double mean = (b->inertia[0].value + b->inertia[1].value + b->inertia[2].value) / 3.0;

    for (int e = 0; e < 6; e++) {
        if (b->inertia[e].kind == MECH_FORMULA) {
            mech__problem_at(rd, node ? node : rd->body_node[body],
                             "the inertia of %s has a formula, which cannot be balanced, expected "
                             "numbers",
                             b->name);
            return;
        }
    }
    for (int e = 0; e < 6; e++) {
        if (b->inertia[e].kind == MECH_PARAM) {
            int i = b->inertia[e].index;
            rd->values[i] = rd->m->params[i].value = e < 3 ? mean : 0.0;
        }
    }
    mech__warn_at(rd, node ? node : rd->body_node[body],
                  "the inertia of %s is balanced: all three moments are %g kg m^2", b->name, mean);
}

/** Numbers that depend on others take their values again. */
static void evaluate_again(mech__reader *rd)
{
    for (const mech__slot *s = rd->slots; s; s = s->next) {
        if (s->to && s->to->kind == MECH_PARAM) {
            s->to->value = rd->values[s->to->index];
        } else if (s->to && s->to->kind == MECH_FORMULA) {
            const mech_formula *f = &rd->m->formulas[s->to->index];
            s->to->value = mech__evaluate(f->steps, f->nsteps, rd->values);
        }
    }
}

void mech__balance(mech__reader *rd)
{
    int any = 0;

    for (int i = 0; rd->inertia == MECH__BALANCE && !rd->nomem && i < rd->m->nbody; i++) {
        if (!mech__failed(rd, rd->m->bodies[i].name) &&
            mech__violates_triangle(rd->m->bodies[i].inertia)) {
            balance(rd, i);
            any = 1;
        }
    }
    if (any) {
        evaluate_again(rd);
    }
}
