/* SPDX-License-Identifier: GPL-3.0-or-later
 * check_loops.c - the loops and couplings of stein check: their points, the remaining degrees of
 * freedom, and the closed start positions. For that the equations are compiled.
 */
#include "cli.h"

static const char *kind_of(const mech_loop *l)
{
    static const char *const text[] = {"meet", "rod", "slot", "weld", "coupling"};
    return l->kind == MECH_WELD && l->axis >= 0 ? "hinge" : text[l->kind];
}

static const char *end_of(const mechanism *m, const mech_loop *l, int k)
{
    return l->kind == MECH_COUPLING ? m->bodies[l->index[k]].name : m->points[l->index[k]].name;
}

static void print_loop(const mechanism *m, const mech_loop *l)
{
    char value[CLI_TEXT], offset[CLI_TEXT];
    const char *a = end_of(m, l, 0), *b = end_of(m, l, 1);
    int slides = l->kind == MECH_COUPLING && m->bodies[l->index[0]].type == 'T';
    printf("  %-16s ", l->name);
    switch (l->kind) {
    case MECH_ROD:
        printf("%s and %s are %s apart\n", a, b, cli_quantity(value, l->length.value, "m"));
        break;
    case MECH_SLOT: printf("%s slides along %c of %s\n", b, "xyz"[l->axis], a); break;
    case MECH_WELD:
        printf("%s is welded to %s", b, a);
        printf(l->axis < 0 ? "\n" : ", but turns about %c\n", "xyz"[l->axis < 0 ? 0 : l->axis]);
        break;
    case MECH_COUPLING:
        printf("%s is %g times %s plus %s\n", a, l->ratio.value, b,
               cli_quantity(offset, l->offset.value, slides ? "m" : "rad"));
        break;
    default: printf("%s meets %s\n", a, b);
    }
}

static void print_text(const mechanism *m, const stein_sim *sim)
{
    int n = stein_freedom(sim);
    printf("\nloops and couplings (%d), %d degree%s of freedom\n", m->nloop, n, n == 1 ? "" : "s");
    for (int i = 0; i < m->nloop; i++) {
        print_loop(m, &m->loops[i]);
    }
    printf("\nstart positions, closed\n");
    for (int j = 0; j < m->nbody; j++) {
        char q[CLI_TEXT], given[CLI_TEXT];
        const char *unit = m->bodies[j].type == 'R' ? "rad" : "m";
        if (m->bodies[j].ball) {
            continue; // in angles of a chart
        }
        printf("  %-16s %-28s from %s\n", m->bodies[j].name, cli_quantity(q, stein_q(sim)[j], unit),
               cli_quantity(given, m->bodies[j].q0.value, unit));
    }
}

static void print_json(const mechanism *m, const stein_sim *sim, lab__json *out)
{
    lab__json_open(out, "loops", '[');
    for (int i = 0; i < m->nloop; i++) {
        lab__json_open(out, NULL, '{');
        lab__json_text(out, "name", m->loops[i].name);
        lab__json_text(out, "kind", kind_of(&m->loops[i]));
        lab__json_text(out, "from", end_of(m, &m->loops[i], 0));
        lab__json_text(out, "to", end_of(m, &m->loops[i], 1));
        lab__json_close(out);
    }
    lab__json_close(out);
    lab__json_int(out, "freedom", stein_freedom(sim));
    lab__json_open(out, "start", '{');
    for (int j = 0; j < m->nbody; j++) {
        if (m->bodies[j].ball) {
            continue;
        }
        lab__json_real(out, m->bodies[j].name, stein_q(sim)[j]);
    }
    lab__json_close(out);
}

int cli_check_loops(const cli_args *args, const mechanism *m, lab__json *out)
{
    lab_model *model = NULL;
    stein_sim *sim = NULL;
    stein_err err = {STEIN_OK, ""};
    if (m->nloop == 0) {
        return CLI_OK;
    }
    stein_status status = cli_open(&model, args, &err);
    status = status == STEIN_OK ? lab_sim(model, NULL, &sim, &err) : status;
    if (status == STEIN_OK && out != NULL) {
        print_json(m, sim, out);
        cli_put_reactions(out, sim);
        cli_warn_reactions(sim);
    } else if (status == STEIN_OK) {
        print_text(m, sim);
        cli_warn_reactions(sim);
    }
    stein_sim_destroy(sim);
    lab_close(model);
    return status == STEIN_OK ? CLI_OK : cli_failed(status, &err);
}
