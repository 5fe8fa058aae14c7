/* SPDX-License-Identifier: GPL-3.0-or-later
 * main.c - command line of the independent source of measurements.
 *
 *   reality --model FILE --seed N [--level L0|L1|L2|L3 | --null] -o DIR
 *           [--kind KIND [--place PLACE] [--amount A]] [--rate HZ] [--pixel UM] [--any-camera]
 *           [--hammer] [--clean | --rough] [--verify] [--unknown | --outside | --twins]
 *           [--answer PATH]
 *       one set: DIR/fit_01.csv .. fit_12.csv, held_01.csv .. held_06.csv and the sealed answer,
 *       DIR/answer.json or PATH. Without --kind the effect is drawn too; with --amount its size is
 *       A times the kind's limit, without a search. --clean: true numbers are the file's and no
 *       scatter; --rough: wrong numbers and scatter; without either every set with an effect is
 *       rough and every other null set is. --any-camera draws 1 to 10 kHz and 5 to 50 um. --unknown
 *       draws among the laws that are in no table of effects, --outside among those of outside.c,
 *       --twins among the kinds that others are easily taken for,
 *       all strokes made in the same way.
 *   reality ... --next N [--set NAME=VALUE]... [--drive INPUT,SHAPE,SIZE,TIME] -o DIR
 *       N strokes more of the set that the same seed and options have made, set and driven as
 *       asked for (SI; SHAPE rise or there_and_back; --rate, --hammer as said):
 *       DIR/next_01.csv ... Exit 3 where this laboratory cannot do it.
 *   reality --model FILE --stroke [--dx MM] [--load G] [--kind KIND --place PLACE --amount A] -o
 * CSV one exact stroke every 50 us: no camera, no scatter; for comparisons reality --list kinds,
 * places, laws reality --model FILE --survey -o TXT for every kind and place the size that makes
 * L1, L2, L3 with the file's own numbers
 */
#include <errno.h>
#include <gsl/gsl_errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "reality.h"

typedef struct options {
    const char *model, *level, *kind, *place, *out, *answer;
    unsigned long seed;
    double rate, pixel, dx, load, amount;
    int null, unknown, list, stroke, clean, rough, verify, hammer, any_camera, survey, also,
        outside, twins;
    asked next;
} options;

enum { OK, FAILED, USAGE };

static int usage(const char *why, const char *what)
{
    fprintf(stderr,
            "reality: %s%s\nusage: reality --model FILE --seed N [--level L0|L1|L2|L3] "
            "[--kind KIND [--place PLACE]] [--also] -o DIR   (or --list, --stroke)\n",
            why, what);
    return USAGE;
}

static void list_kinds(const effect_kind *k)
{
    for (; k->name != NULL; k++) {
        printf("%-20s %-15s %s [%s]: %s\n    places: %s%s\n", k->name, k->verdict, k->size,
               *k->unit == '\0' ? "of the parameter" : k->unit, k->law, k->places,
               k->drawn ? "" : "\n    only when asked for by name");
    }
}

static int list(void)
{
    list_kinds(effect_kinds);
    list_kinds(outside_kinds);
    return OK;
}

/* ---- options ---- */

static int flag(options *o, const char *name)
{
    const struct {
        const char *name;
        int *to;
    } flags[] = {
        {"--null", &o->null},     {"--unknown", &o->unknown}, {"--list", &o->list},
        {"--stroke", &o->stroke}, {"--clean", &o->clean},     {"--rough", &o->rough},
        {"--verify", &o->verify}, {"--hammer", &o->hammer},   {"--any-camera", &o->any_camera},
        {"--survey", &o->survey}, {"--also", &o->also},       {"--outside", &o->outside},
        {"--twins", &o->twins}};
    for (size_t i = 0; i < sizeof flags / sizeof *flags; i++) {
        if (strcmp(name, flags[i].name) == 0) {
            *flags[i].to = 1;
            return 1;
        }
    }
    return 0;
}

static int text(options *o, const char *name, const char *value)
{
    const struct {
        const char *name, **to;
    } texts[] = {{"--model", &o->model},     {"--level", &o->level}, {"--kind", &o->kind},
                 {"--place", &o->place},     {"-o", &o->out},        {"--answer", &o->answer},
                 {"--drive", &o->next.drive}};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        if (strcmp(name, texts[i].name) == 0) {
            *texts[i].to = value;
            return 1;
        }
    }
    return 0;
}

static int number(options *o, const char *name, const char *value)
{
    const struct {
        const char *name;
        double *to;
    } numbers[] = {{"--rate", &o->rate},
                   {"--pixel", &o->pixel},
                   {"--dx", &o->dx},
                   {"--load", &o->load},
                   {"--amount", &o->amount}};
    char *end;
    if (strcmp(name, "--set") == 0 && o->next.nset < OVERRIDES + 2) {
        o->next.set[o->next.nset++] = value;
        return 1;
    }
    if (strcmp(name, "--next") == 0) {
        long n = strtol(value, &end, 10);
        o->next.repeats = (int)n;
        return *end == '\0' && n >= 1 && n <= 99;
    }
    if (strcmp(name, "--seed") == 0) {
        o->seed = strtoul(value, &end, 10);
        return *value != '\0' && *end == '\0';
    }
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        if (strcmp(name, numbers[i].name) == 0) {
            *numbers[i].to = strtod(value, &end);
            return *value != '\0' && *end == '\0' && isfinite(*numbers[i].to);
        }
    }
    return 0;
}

static int parse(options *o, int argc, char **argv)
{
    *o = (options){
        .level = "L1", .seed = 1, .rate = standard_camera.rate, .pixel = 20.0, .load = 100.0};
    for (int i = 1; i < argc; i++) {
        if (flag(o, argv[i])) {
            continue;
        }
        if (i + 1 >= argc || !(text(o, argv[i], argv[i + 1]) || number(o, argv[i], argv[i + 1]))) {
            return usage("what is ", argv[i]);
        }
        i++;
    }
    if (!o->list && (o->model == NULL || o->out == NULL)) {
        return usage("--model and -o are needed", "");
    }
    if (!(o->rate >= 100.0 && o->rate <= 1e5 && o->pixel > 0.0 && o->load > 0.0)) {
        return usage("--rate, --pixel or --load out of range", "");
    }
    return OK;
}

/* ---- one exact stroke ---- */

static int write_stroke(const char *path, const film *f, const camera *c)
{
    FILE *out = fopen(path, "w");
    if (out == NULL) {
        perror(path);
        return FAILED;
    }
    fprintf(out, "time [s],string_distance [m],key_dip [m],hammer_angle [rad]\n");
    for (int i = 0; i < f->n; i++) {
        fprintf(out, "%.17g,%.17g,%.17g,%.17g\n", i / c->rate, f->y[i][0], f->y[i][1], f->y[i][2]);
    }
    return fclose(out) == 0 ? OK : FAILED;
}

static int one_stroke(const options *o, world *w, gsl_rng *rng)
{
    camera c = {.rate = 20000.0,
                .pixel = 0.0,
                .arm = 1.0,
                .before = 0.0,
                .until = 0.12,
                .seen = 3,
                .accuracy = standard_camera.accuracy};
    setting s = {.dx = 1e-3 * o->dx, .load = 1e-3 * o->load};
    if (o->kind != NULL) {
        effect_draw(&w->hidden, effect_find(o->kind), o->place, w->m, rng);
        w->hidden.amount *= o->amount;
        s.touch = effect_touch(&w->hidden);
        s.load = s.touch > 0 ? 5e-3 : s.load;
        s.touch_size = s.touch == 1 ? 1.2 : 0.039;
        s.touch_time = s.touch == 1 ? 0.03 : 0.07;
    }
    film f;
    if (film_take(&f, w, &w->hidden, w->p, &s, &c) != 0) {
        fprintf(stderr, "reality: the stroke cannot be computed\n");
        return FAILED;
    }
    int status = write_stroke(o->out, &f, &c);
    film_free(&f);
    if (status == OK && o->kind != NULL) {
        const effect *e = &w->hidden;
        printf("%.17g %.17g %.17g %.17g\n", effect_value(e, w), e->side[0], e->side[1], e->side[2]);
    }
    return status;
}

/* ---- a set ---- */

static const struct {
    const char *name;
    double target;
} levels[] = {{"L0", 0.0}, {"L1", 2.0}, {"L2", 0.5}, {"L3", 0.15}};

static double target_of(const char *level)
{
    for (size_t i = 0; i < sizeof levels / sizeof *levels; i++) {
        if (strcmp(level, levels[i].name) == 0) {
            return levels[i].target;
        }
    }
    return -1.0;
}

static const effect_kind *any_kind(const options *o, gsl_rng *rng)
{
    const effect_kind *table = o->outside ? outside_kinds : effect_kinds;
    unsigned long n = 0;
    while (table[n].name != NULL) {
        n++;
    }
    for (;;) {
        const effect_kind *k = &table[gsl_rng_uniform_int(rng, n)];
        int is_unknown = strcmp(k->verdict, "unknown_effect") == 0;
        if (o->outside || o->unknown ? is_unknown
                                     : k->drawn && (!o->twins || effect_has_twins(k))) {
            return k;
        }
    }
}

/* an effect that the strokes of this kind can show at all */
static void draw(const options *o, effect *e, const mechanism *m, int touch, gsl_rng *rng)
{
    for (;;) {
        const effect_kind *kind = o->kind != NULL ? effect_find(o->kind) : any_kind(o, rng);
        effect_draw(e, kind, o->place, m, rng);
        int needs = effect_touch(e), load = strcmp(kind->name, "unknown_load") == 0;
        if (touch < 0 || (needs > 0 ? needs == touch : !load || touch == 0)) {
            return;
        }
    }
}

/* One set in five is played by a finger or a prescribed motion, whatever is hidden. */
static int choose_touch(const options *o, const mechanism *m, gsl_rng *rng)
{
    effect e;
    double u = gsl_rng_uniform(rng);
    int touch = u < 0.1 ? 1 : u < 0.2 ? 2 : 0;
    if (o->null) {
        return touch;
    }
    draw(o, &e, m, -1, rng);
    int needs = effect_touch(&e);
    return needs > 0 ? needs : o->kind != NULL ? 0 : touch;
}

/* a wrong number within its stated tolerance is none */
static int within_tolerance(const world *w, const effect *e)
{
    int own = effect_own_parameter(e, w->m);
    return own >= 0 &&
           fabs(effect_value(e, w) - w->m->params[own].value) < 3.0 * w->m->params[own].tolerance;
}

static void note_redrawn(answer *a, const effect *e, const char *why)
{
    if (a->nredrawn < MAX_REDRAWN) {
        a->redrawn[a->nredrawn].kind = e->kind->name;
        memcpy(a->redrawn[a->nredrawn].place, e->place, sizeof e->place);
        a->redrawn[a->nredrawn].reached = a->reached;
        a->redrawn[a->nredrawn++].why = why;
    }
}

/* a second effect: a missing one at another place, of the same size as alone */
static int hide_second(const options *o, world *w, answer *a, refit *r, gsl_rng *rng)
{
    options any = *o;
    any.kind = any.place = NULL;
    for (int i = 0; i < MAX_REDRAWN; i++) {
        effect e;
        double reached = 0.0;
        draw(&any, &e, w->m, a->d->touch, rng);
        if (strcmp(e.kind->verdict, "missing_effect") == 0 && e.kind != w->hidden.kind &&
            strcmp(e.place, w->hidden.place) != 0 &&
            refit_scale(r, &e, a->target, &reached) == NULL) {
            w->second = e;
            w->hidden.also = &w->second;
            return 1;
        }
    }
    return 0;
}

/* draw effects until one reaches the level within its limits */
static int hide(const options *o, world *w, answer *a, gsl_rng *rng)
{
    effect e;
    int tries = o->kind == NULL ? MAX_REDRAWN : o->place == NULL ? 8 : 3;
    if (o->kind != NULL && o->amount > 0.0) {
        draw(o, &w->hidden, w->m, a->d->touch, rng);
        w->hidden.amount *= o->amount;
        a->level = "given";
        a->target = 0.0;
        a->met = 1;
        return OK;
    }
    refit *r = refit_create(w, a->d);
    if (r == NULL) {
        fprintf(stderr, "reality: the strokes without effect cannot be computed\n");
        return FAILED;
    }
    for (int i = 0; i < tries; i++) {
        draw(o, &e, w->m, a->d->touch, rng);
        a->reached = 0.0;
        const char *why = refit_beside(r, &e) == 0 ? refit_scale(r, &e, a->target, &a->reached)
                                                   : "the laws of its place cannot be refitted";
        if (why == NULL && within_tolerance(w, &e)) {
            why = "within its tolerance";
        }
        if (why == NULL) {
            a->met = 1;
            break;
        }
        if (i + 1 < tries) {
            note_redrawn(a, &e, why);
        }
    }
    w->hidden = e;
    int status = o->verify && a->met ? refit_size_dense(r, &a->dense) : 0;
    if (o->also) {
        a->met = a->met && hide_second(o, w, a, r, rng);
    }
    refit_free(r);
    return status == 0 ? OK : FAILED;
}

static gsl_rng *stream(unsigned long seed, unsigned long k)
{
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    gsl_rng_set(rng, (seed * 2654435761ul + k * 40503ul + 1ul) & 0xfffffffful);
    return rng;
}

static int write_set(const options *o, const world *w, const design *d, answer *a, gsl_rng *rng)
{
    char path[4096];
    for (int i = 0; i < JOINTS; i++) {
        a->seen.low[i] = 1e9;
        a->seen.high[i] = -1e9;
    }
    for (int i = 0; i < STROKES; i++) {
        snprintf(path, sizeof path, "%s/%s_%02d.csv", o->out, i < FIT ? "fit" : "held",
                 i < FIT ? i + 1 : i - FIT + 1);
        if (camera_write(path, w, d, &d->stroke[i], rng, i < FIT ? &a->seen : NULL) != 0) {
            return FAILED;
        }
    }
    snprintf(path, sizeof path, "%s/answer.json", o->out);
    return answer_write(o->answer != NULL ? o->answer : path, a) == 0 ? OK : FAILED;
}

static void choose_camera(const options *o, design *d, gsl_rng *rng)
{
    d->camera = standard_camera;
    d->camera.seen = o->hammer && o->next.repeats == 0 ? 3 : 2; // of the set
    d->camera.rate = o->next.repeats > 0 ? standard_camera.rate : o->rate;
    d->camera.pixel = 1e-6 * o->pixel;
    double rate = 1000.0 * pow(10.0, gsl_rng_uniform(rng));
    double pixel = 5e-6 * pow(10.0, gsl_rng_uniform(rng));
    if (o->any_camera) {
        d->camera.rate = 100.0 * floor(rate / 100.0 + 0.5);
        d->camera.pixel = 1e-6 * floor(1e6 * pixel + 0.5);
    }
}

/* more strokes in the same world: the effect was drawn as for the set */
static int write_next(const options *o, const world *w, design *d)
{
    gsl_rng *scene = stream(o->seed, 4), *noise = stream(o->seed, 5);
    d->camera.rate = o->rate;
    d->camera.seen = o->hammer ? 3 : 2;
    int status = next_write(o->out, &o->next, w, d, scene, noise);
    gsl_rng_free(scene);
    gsl_rng_free(noise);
    return status == 0 || status == 3 ? status : FAILED;
}

static int one_set(const options *o, world *w)
{
    design d = {.drive_scatter = 0.003, .jitter = 50e-6, .marker = 1e-4};
    answer a = {.w = w,
                .d = &d,
                .level = o->null ? "L0" : o->level,
                .seed = o->seed,
                .target = o->null ? 0.0 : target_of(o->level),
                .dense = -1.0,
                .met = o->null};
    gsl_rng *scene = stream(o->seed, 1), *hidden = stream(o->seed, 2), *noise = stream(o->seed, 3);
    int rough = gsl_rng_uniform(scene) < 0.5 || !o->null;
    d.scatter = d.wrong_start = o->rough || (rough && !o->clean);
    d.joint_scatter = 0.03 + 0.07 * gsl_rng_uniform(scene);
    d.contact_scatter = 0.03 + 0.07 * gsl_rng_uniform(scene);
    choose_camera(o, &d, scene);
    design_strokes(&d, choose_touch(o, w->m, hidden));
    if (o->twins) {
        design_alike(&d, (int)gsl_rng_uniform_int(hidden, 9));
    }
    design_scatter(&d, scene);
    design_truth(&d, w, scene);
    int status = o->null ? OK : hide(o, w, &a, hidden);
    if (status == OK && mkdir(o->out, 0777) != 0 && errno != EEXIST) {
        perror(o->out);
        status = FAILED;
    }
    if (status == OK && o->next.repeats > 0) {
        status = write_next(o, w, &d);
    } else if (status == OK) {
        status = write_set(o, w, &d, &a, noise);
    }
    gsl_rng_free(scene);
    gsl_rng_free(hidden);
    gsl_rng_free(noise);
    return status;
}

/* ---- what can be hidden ---- */

static void survey_effect(FILE *f, refit *r, const world *w, const effect_kind *kind,
                          const char *place)
{
    static const double target[] = {2.0, 0.5, 0.15};
    fprintf(f, "%-20s %-20s", kind->name, place);
    for (int k = 0; k < 3; k++) {
        effect e;
        double reached = 0.0;
        gsl_rng *rng = stream(1, 2);
        effect_draw(&e, kind, place, w->m, rng);
        gsl_rng_free(rng);
        const char *why = refit_scale(r, &e, target[k], &reached);
        fprintf(f, " %10.3g (%.3f)%s", effect_value(&e, w), reached,
                why != NULL               ? "-"
                : within_tolerance(w, &e) ? "t"
                                          : " ");
    }
    fprintf(f, "\n");
    fflush(f);
}

static int survey(const options *o, const world *w)
{
    design d = {.drive_scatter = 0.003,
                .jitter = 50e-6,
                .marker = 1e-4,
                .joint_scatter = 0.065,
                .contact_scatter = 0.065,
                .camera = standard_camera};
    FILE *f = fopen(o->out, "w");
    int status = f != NULL ? OK : FAILED;
    for (int touch = 0; status == OK && touch < 3; touch++) {
        design_strokes(&d, touch);
        refit *r = refit_create(w, &d);
        status = r != NULL ? OK : FAILED;
        for (const effect_kind *k = effect_kinds; status == OK && k->name != NULL; k++) {
            char place[MECH_PATH];
            for (int i = 0; effect_nth_place(k, i, place); i++) {
                effect e = {.kind = k};
                snprintf(e.place, sizeof e.place, "%s", place);
                if (effect_touch(&e) == touch && (o->kind == NULL || effect_find(o->kind) == k)) {
                    survey_effect(f, r, w, k, place);
                }
            }
        }
        refit_free(r);
    }
    return status == OK && fclose(f) == 0 ? OK : FAILED;
}

static int check_effect(options *o)
{
    double target = target_of(o->level);
    o->null = o->null || (o->kind == NULL && !(target > 0.0));
    if (target < 0.0) {
        return usage("no such level: ", o->level);
    }
    if (o->kind != NULL && effect_find(o->kind) == NULL) {
        return usage("no such kind (see --list): ", o->kind);
    }
    if (o->place != NULL &&
        (o->kind == NULL || !effect_has_place(effect_find(o->kind), o->place))) {
        return usage("the kind has no such place (see --list): ", o->place);
    }
    return OK;
}

int main(int argc, char **argv)
{
    options o;
    int status = parse(&o, argc, argv);
    if (status != OK || o.list) {
        return status != OK ? status : list();
    }
    status = check_effect(&o);
    if (status != OK) {
        return status;
    }
    gsl_set_error_handler_off();
    mechanism *m = NULL;
    stein_err err = {STEIN_OK, ""};
    if (mech_read(&m, o.model, NULL, 0, NULL, NULL, &err) != STEIN_OK) {
        fprintf(stderr, "reality: %s\n", err.msg);
        return FAILED;
    }
    world w = {.m = m, .p = malloc(sizeof(double) * (size_t)m->nparam)};
    status = w.p != NULL ? OK : FAILED;
    for (int i = 0; status == OK && i < m->nparam; i++) {
        w.p[i] = m->params[i].value;
    }
    if (status == OK && o.stroke) {
        gsl_rng *rng = stream(o.seed, 2);
        status = one_stroke(&o, &w, rng);
        gsl_rng_free(rng);
    } else if (status == OK && o.survey) {
        status = survey(&o, &w);
    } else if (status == OK) {
        status = one_set(&o, &w);
    }
    free(w.p);
    mech_free(m);
    return status;
}
