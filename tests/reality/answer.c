/* SPDX-License-Identifier: GPL-3.0-or-later
 * answer.c - the sealed answer of a set, as JSON.
 *
 *   kind, place, class      what is hidden; class as in the verdicts of a diagnosis
 *   also                    kind, place and class of a second one, else null
 *   law_curve               of a law in no table: where it acts, over what, its values over the
 *                           range that the strokes to fit have visited
 *   parameters              name: {value, unit}, the first is the size; `sets` tells the value that
 * a parameter of the file takes, when the effect is a wrong one level                   name,
 * target and reached size (RMS after refitting / noise of a sample), dense: the same by another
 * route (only with --verify), met redrawn                 what was drawn before and cannot reach
 * the level truth                   the parameters that differ from the file's scatter, strokes
 * what was not told about each stroke
 */
#include <math.h>
#include <string.h>

#include "reality.h"

static void effect_part(FILE *f, const answer *a)
{
    const effect *e = &a->w->hidden;
    if (e->kind == NULL) {
        fprintf(f, "  \"kind\": null,\n  \"place\": null,\n  \"class\": \"explained\",\n"
                   "  \"parameters\": {},\n");
        return;
    }
    int own = effect_own_parameter(e, a->w->m);
    fprintf(f, "  \"kind\": \"%s\",\n  \"place\": \"%s\",\n  \"class\": \"%s\",\n", e->kind->name,
            e->place, e->kind->verdict);
    fprintf(f, "  \"law\": \"%s\",\n  \"parameters\": {\n", e->kind->law);
    if (own >= 0) {
        const mech_param *p = &a->w->m->params[own];
        fprintf(f,
                "    \"%s\": {\"value\": %.10g, \"unit\": \"%s\", \"file\": %.10g, "
                "\"true_otherwise\": %.10g}",
                p->name, effect_value(e, a->w), p->unit, p->value, a->w->p[own]);
    } else {
        fprintf(f, "    \"%s\": {\"value\": %.10g, \"unit\": \"%s\"}", e->kind->size,
                effect_size(e), e->kind->unit);
    }
    for (int i = 0; i < SIDES && e->kind->side[i].name != NULL; i++) {
        const char *unit = e->kind->side[i].unit;
        fprintf(f, ",\n    \"%s\": {\"value\": %.10g, \"unit\": \"%s\"}", e->kind->side[i].name,
                e->side[i], *unit == '\0' ? "rad" : unit);
    }
    fprintf(f, "\n  },\n");
}

/* a law over what the strokes to fit have visited; "law_curve": null where there is none */
static void curve_part(FILE *f, const answer *a)
{
    const effect *e = &a->w->hidden;
    if (e->kind == NULL || !effect_is_outside(e)) {
        fprintf(f, "  \"law_curve\": null,\n");
        return;
    }
    known_law law;
    outside_law(e, &a->seen, &law);
    fprintf(f,
            "  \"law_curve\": {\"site\": \"%s\", \"place\": \"%s\", \"of\": \"%s\", "
            "\"at_unit\": \"%s\", \"unit\": \"%s\",\n    \"at\": [",
            law.site, e->place, law.of, law.at_unit, law.unit);
    for (int i = 0; i < law.n; i++) {
        fprintf(f, "%s%.9g", i > 0 ? ", " : "", law.at[i]);
    }
    fprintf(f, "],\n    \"value\": [");
    for (int i = 0; i < law.n; i++) {
        fprintf(f, "%s%.9g", i > 0 ? ", " : "", law.value[i]);
    }
    fprintf(f, "]},\n");
}

static void also_part(FILE *f, const effect *e)
{
    if (e == NULL) {
        fprintf(f, "  \"also\": null,\n");
        return;
    }
    fprintf(f,
            "  \"also\": {\"kind\": \"%s\", \"place\": \"%s\", \"class\": \"%s\", \"law\": "
            "\"%s\", \"size\": {\"value\": %.10g, \"unit\": \"%s\"}},\n",
            e->kind->name, e->place, e->kind->verdict, e->kind->law, effect_size(e), e->kind->unit);
}

static void level_part(FILE *f, const answer *a)
{
    fprintf(f, "  \"level\": {\"name\": \"%s\", \"target\": %.10g, \"reached\": %.6g, ", a->level,
            a->target, a->reached);
    if (a->dense >= 0.0) {
        fprintf(f, "\"dense\": %.6g, ", a->dense);
    }
    fprintf(f, "\"met\": %s},\n  \"redrawn\": [", a->met ? "true" : "false");
    for (int i = 0; i < a->nredrawn; i++) {
        fprintf(f,
                "%s\n    {\"kind\": \"%s\", \"place\": \"%s\", \"reached\": %.4g, "
                "\"why\": \"%s\"}",
                i > 0 ? "," : "", a->redrawn[i].kind, a->redrawn[i].place, a->redrawn[i].reached,
                a->redrawn[i].why);
    }
    fprintf(f, "],\n");
}

static void truth_part(FILE *f, const answer *a)
{
    int n = 0;
    fprintf(f, "  \"truth\": {");
    for (int i = 0; i < a->w->m->nparam; i++) {
        const mech_param *p = &a->w->m->params[i];
        if (fabs(a->w->p[i] - p->value) > 0.0) {
            fprintf(f, "%s\n    \"%s\": {\"value\": %.12g, \"file\": %.12g, \"unit\": \"%s\"}",
                    n++ > 0 ? "," : "", p->name, a->w->p[i], p->value, p->unit);
        }
    }
    fprintf(f, "\n  },\n");
}

static void strokes_part(FILE *f, const design *d)
{
    fprintf(f,
            "  \"scatter\": {\"present\": %s, \"joint_friction\": %.4g, \"contact_friction\": "
            "%.4g, \"drive\": %.4g, \"trigger\": %.4g},\n",
            d->scatter ? "true" : "false", d->joint_scatter, d->contact_scatter, d->drive_scatter,
            d->jitter);
    fprintf(f, "  \"strokes\": [");
    for (int i = 0; i < STROKES; i++) {
        const setting *s = &d->stroke[i];
        fprintf(f,
                "%s\n    {\"file\": \"%s_%02d.csv\", \"joint_friction\": %.6g, "
                "\"contact_friction\": %.6g, \"drive\": %.6g, \"trigger\": %.6g, \"offset\": "
                "[%.6g, %.6g, %.6g]}",
                i > 0 ? "," : "", i < FIT ? "fit" : "held", i < FIT ? i + 1 : i - FIT + 1,
                s->joint_friction, s->contact_friction, s->drive, s->trigger, s->offset[0],
                s->offset[1], s->offset[2]);
    }
    fprintf(f, "\n  ]\n}\n");
}

int answer_write(const char *path, const answer *a)
{
    const camera *c = &a->d->camera;
    FILE *f = fopen(path, "w");
    if (f == NULL) {
        perror(path);
        return -1;
    }
    fprintf(f, "{\n  \"seed\": %lu,\n", a->seed);
    effect_part(f, a);
    curve_part(f, a);
    also_part(f, a->w->hidden.also);
    level_part(f, a);
    fprintf(f, "  \"wrong_start\": %s,\n", a->d->wrong_start ? "true" : "false");
    fprintf(f, "  \"camera\": {\"rate\": %.10g, \"pixel\": %.10g},\n  \"noise\": {", c->rate,
            c->pixel);
    for (int j = 0; j < c->seen; j++) {
        fprintf(f, "%s\"%s\": %.6g", j > 0 ? ", " : "", seen_name[j], camera_noise(c, j));
    }
    fprintf(f, "},\n");
    truth_part(f, a);
    strokes_part(f, a->d);
    return fclose(f) == 0 ? 0 : -1;
}
