/* SPDX-License-Identifier: GPL-3.0-or-later
 * answer.c - the sealed answer of a set, as JSON, in the form of the answers of tests/reality:
 *
 *   kind, place, class      what is hidden; class as in the verdicts of a diagnosis, unusable_model
 *                           where the set-up is wrong
 *   parameters              name: {value, unit}; of a number of the file {value, file}
 *   also                    kind, place, class and size of a second one, else null
 *   law_curve               of a law in no table: values over what the records visit
 *   alike                   what these records cannot tell from it
 *   level, wrong_start      name, target, reached; wrong_start: tolerances are not stated
 *   truth, records          all that differs from the file, all that was not told
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "world.h"

enum { CURVE = 41 };

static double amount(const answer *a, const effect *e)
{
    if (e->kind->site == 'c' &&
        (e->kind->offset == N_C || e->kind->offset == N_D || e->kind->offset == N_MU)) {
        int law = a->m->contact[e->index].law;
        int of = e->kind->offset != N_C || a->m->number[law + N_C].stated ? e->kind->offset : N_B;
        return log(a->p[law + of] / a->m->number[law + of].file);
    }
    if (e->kind->site == 's' && e->kind->offset == S_OFFSET) {
        return a->p[a->m->channel[e->index].law + S_OFFSET]; // with the error that it had before
    }
    return e->size;
}

/* what is smaller than in the file is not missing */
static const char *class_of(const effect *e)
{
    return !e->kind->both && e->size < 0.0 ? "wrong_parameter" : e->kind->cls;
}

static void put_size(FILE *f, const answer *a, const effect *e)
{
    if (strchr("bp", e->kind->site) != NULL) {
        const number *n = &a->told->number[e->index];
        fprintf(f, "\"%s\": {\"value\": %.10g, \"unit\": \"%s\", \"file\": %.10g}", n->name,
                a->p[e->index], n->unit, n->file);
        return;
    }
    fprintf(f, "\"%s\": {\"value\": %.10g, \"unit\": \"%s\"}", e->kind->size, amount(a, e),
            e->unit);
    if (e->kind->side >= 0) {
        fprintf(f, ", \"side\": {\"value\": %.10g}", e->side);
    }
}

static void put_effect(FILE *f, const answer *a)
{
    const effect *e = &a->e[0];
    if (*a->w.name != '\0') {
        fprintf(f,
                "  \"kind\": \"%s\",\n  \"place\": \"%s\",\n  \"class\": \"unusable_model\",\n"
                "  \"parameters\": {},\n",
                a->w.name, a->w.place);
    } else if (e->kind == NULL) {
        fprintf(f, "  \"kind\": null,\n  \"place\": null,\n  \"class\": \"explained\",\n"
                   "  \"parameters\": {},\n");
    } else {
        fprintf(f, "  \"kind\": \"%s\",\n  \"place\": \"%s\",\n  \"class\": \"%s\",\n",
                e->kind->name, e->place, class_of(e));
        fprintf(f, "  \"parameters\": {");
        put_size(f, a, e);
        fprintf(f, "},\n");
    }
    e = &a->e[1];
    if (e->kind == NULL) {
        fprintf(f, "  \"also\": null,\n");
    } else {
        fprintf(f,
                "  \"also\": {\"kind\": \"%s\", \"place\": \"%s\", \"class\": \"%s\", \"size\": "
                "{\"value\": %.10g, \"unit\": \"%s\"}},\n",
                e->kind->name, e->place, class_of(e), amount(a, e), e->unit);
    }
}

/* the law alone over what is visited */
static void put_curve(FILE *f, const answer *a)
{
    const effect *e = &a->e[0];
    if (e->kind == NULL || !e->kind->outside) {
        fprintf(f, "  \"law_curve\": null,\n");
        return;
    }
    int b = e->index, of_speed = e->kind->offset == J_ROOT, turns = a->m->body[b].type == 'R';
    double law[J_SIZE] = {0.0}, x[CURVE];
    memcpy(law + J_BUMP, a->p + a->m->body[b].law + J_BUMP, sizeof(double) * (J_SIZE - J_BUMP));
    law[J_W] = law[J_VT] = 1.0;
    fprintf(
        f,
        "  \"law_curve\": {\"site\": \"joint\", \"place\": \"%s\", \"of\": \"%s\", \"at_unit\": "
        "\"%s\", \"unit\": \"%s\",\n    \"at\": [",
        e->place, of_speed ? "speed" : "position",
        of_speed ? (turns ? "rad/s" : "m/s") : (turns ? "rad" : "m"), turns ? "N m" : "N");
    for (int i = 0; i < CURVE; i++) {
        double u = 2.0 * i / (CURVE - 1) - 1.0;
        x[i] = of_speed ? 1.5 * a->x.qd[b] * u : a->x.mid[b] + a->x.q[b] * u;
        fprintf(f, "%s%.9g", i > 0 ? ", " : "", x[i]);
    }
    fprintf(f, "],\n    \"value\": [");
    for (int i = 0; i < CURVE; i++) {
        fprintf(f, "%s%.9g", i > 0 ? ", " : "",
                law_joint(law, of_speed ? 0.0 : x[i], of_speed ? x[i] : 0.0));
    }
    fprintf(f, "]},\n");
}

static void put_alike(FILE *f, const answer *a)
{
    fprintf(f, "  \"alike\": [");
    for (int i = 0; i < a->nalike; i++) {
        const effect *e = &a->alike[i];
        fprintf(f, "%s\n    {\"kind\": \"%s\", \"place\": \"%s\", \"size\": %.4g}",
                i > 0 ? "," : "", e->kind->name, e->place, e->size);
    }
    fprintf(f, "],\n");
}

static void put_truth(FILE *f, const answer *a)
{
    int n = 0;
    fprintf(f, "  \"truth\": {");
    for (int i = 0; i < a->m->nnumber; i++) {
        const number *N = &a->m->number[i];
        if (fabs(a->p[i] - N->file) > 0.0) {
            fprintf(f, "%s\n    \"%s\": {\"value\": %.12g, \"file\": %.12g, \"unit\": \"%s\"}",
                    n++ > 0 ? "," : "", N->name, a->p[i], N->file, N->unit);
        }
    }
    fprintf(f, "\n  },\n");
}

static void put_numbers(FILE *f, const char *name, const double *x, int n)
{
    fprintf(f, "\"%s\": [", name);
    for (int i = 0; i < n; i++) {
        fprintf(f, "%s%.10g", i > 0 ? ", " : "", x[i]);
    }
    fprintf(f, "]");
}

static void put_records(FILE *f, const answer *a)
{
    const design *d = a->d;
    fprintf(f,
            "  \"design\": {\"rate\": %g, \"tolerances\": %d, \"noise_told\": %d, \"moving\": %d, "
            "\"told\": %d, \"one_long\": %d, \"joint_sd\": %.3g, \"drift\": %.3g, ",
            d->rate, d->tolerances, d->noise_told, d->moving, d->told, d->one_long, d->joint_sd,
            d->drift);
    fprintf(f, "\"noise\": {");
    for (int i = 0; i < a->m->nchannel; i++) {
        fprintf(f, "%s\"%s\": %.4g", i > 0 ? ", " : "", a->m->channel[i].name, d->sensor[i].sd);
    }
    fprintf(f, "}},\n  \"records\": [");
    for (int i = 0; i < d->nfit + d->nheld; i++) {
        const setup *s = &d->record[i];
        fprintf(f, "%s\n    {\"file\": \"%s_%02d.csv\", \"before\": %.6g, ", i > 0 ? "," : "",
                i < d->nfit ? "fit" : "held", i < d->nfit ? i + 1 : i - d->nfit + 1, s->before);
        put_numbers(f, "q", s->q, a->m->nbody);
        fprintf(f, ", ");
        put_numbers(f, "qd", s->qd, a->m->nbody);
        fprintf(f, ", ");
        put_numbers(f, "joint_friction", s->joint_scatter, a->m->nbody);
        fprintf(f, "}");
    }
    fprintf(f, "\n  ]\n}\n");
}

int write_answer(const char *path, const answer *a)
{
    FILE *f = fopen(path, "w");
    if (f == NULL) {
        perror(path);
        return -1;
    }
    fprintf(f, "{\n  \"seed\": %lu,\n  \"mechanism\": \"%s\",\n", a->seed, a->told->name);
    put_effect(f, a);
    put_curve(f, a);
    put_alike(f, a);
    fprintf(f,
            "  \"level\": {\"name\": \"%s\", \"target\": %.10g, \"reached\": %.6g, \"met\": %s},\n",
            a->level, a->target, a->reached, a->met ? "true" : "false");
    fprintf(f, "  \"wrong_start\": %s,\n", a->d->tolerances ? "false" : "true");
    put_truth(f, a);
    put_records(f, a);
    return fclose(f) == 0 ? 0 : -1;
}
