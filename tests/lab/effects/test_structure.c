/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_structure.c - effects that need a part: the extended mechanism is the file's with the part
 * in it. It moves as in the independent program, and as the file's mechanism where the part has no
 * effect.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lab_support.h"
#include "added_parts.h"

Suite *structure_suite(void);

static const char file[] = "models/stein1788.yaml";
enum { SAMPLES = 400, CHANNELS = 24 };

static const struct {
    const char *kind, *place;
} parts[] = {
    {"elastic_hinge", "key"},        {"elastic_hinge", "hammer"},   {"axis_translation", "key"},
    {"compliant_partner", "string"}, {"compliant_partner", "rest"}, {"compliant_partner", "dip"},
    {"compliant_partner", "stop"},   {"string_damper", "key"},      {"wire", "key"}};
enum { PARTS = sizeof parts / sizeof *parts };

static lab_model *open_file(const char *path)
{
    lab_model *model = NULL;
    ck_assert_stein(lab_open(&model, path, NULL, err));
    return model;
}

/* ---- where they sit ---- */

START_TEST(parts_sit_where_the_mechanism_has_room_for_them)
{
    lab_model *model = open_file(file);
    lab_candidate *list = NULL;
    int n = 0, needy = 0;
    ck_assert_stein(lab_candidates(&list, &n, model, err));
    for (int i = 0; i < n; i++) {
        const lab_candidate *c = &list[i];
        if (c->effect->needs == NULL) {
            continue;
        }
        int known = 0;
        for (int k = 0; k < PARTS; k++) {
            known += strcmp(c->effect->kind, parts[k].kind) == 0 &&
                     strcmp(c->place, parts[k].place) == 0;
        }
        ck_assert_msg(known == 1, "%s at %s", c->effect->kind, c->place);
        ck_assert(c->limit > 0.0 && c->side[0].lo <= c->side[0].value &&
                  c->side[0].value < c->side[0].hi);
        ck_assert(c->side[1].name == NULL ||
                  (c->side[1].lo < c->side[1].value && c->side[1].value < c->side[1].hi));
        ck_assert_int_eq(c->nparam, 0);
        needy++;
    }
    ck_assert_int_eq(needy, PARTS);
    free(list);
    lab_close(model);
}
END_TEST

START_TEST(a_link_bends_like_a_uniform_bar)
{
    lab_model *model = open_file(file);
    const mechanism *m = lab__mechanism(model);
    lab__bent key, hammer;
    ck_assert_int_eq(lab__bend(&key, m, 0), 0);
    ck_assert_int_eq(lab__bend(&hammer, m, 1), 0);
    ck_assert_close(hammer.at.x, 45e-3, 0.05, 0.0); // between the beak and the shank's rest
    ck_assert_close(key.at.x, -49.4e-3, 0.01, 0.0); // between pin and Kapsel
    ck_assert(!lab__is_beyond(&hammer, (lab__vec){44e-3, -3e-3}));
    ck_assert(lab__is_beyond(&hammer, (lab__vec){107.7e-3, 16.33e-3}));
    ck_assert(lab__is_beyond(&key, (lab__vec){-73.6e-3, 16.03e-3}));
    ck_assert_close(key.mass, 0.45, 0.1, 0.0);
    ck_assert_close(hammer.mass, 0.6, 0.1, 0.0);
    // where its mass really lies is found with it: the value of tests/reality is in the range
    lab_candidate c = candidate(model, "elastic_hinge", "hammer");
    ck_assert_str_eq(c.side[2].name, "mass_ratio");
    ck_assert_close(c.side[2].value, hammer.mass / (1.0 - hammer.mass), 1e-2, 0.0);
    ck_assert(c.side[2].lo < 0.55 / 0.45 && 0.55 / 0.45 < c.side[2].hi);
    ck_assert_str_eq(c.side[3].name, "inertia_ratio");
    ck_assert(c.side[3].lo < 0.23 && 0.23 < c.side[3].hi);
    lab_close(model);
}
END_TEST

/* ---- the text ---- */

/* every comment of the file is there, and every line that had to stay */
static void compare_lines(const char *before, const char *after)
{
    int lines = 0, changed = 0;
    for (const char *line = before; *line != '\0';) {
        size_t n = strcspn(line, "\n");
        char *text = lab__text("%.*s\n", (int)n, line), *comment = strchr(text, '#');
        ck_assert_msg(comment == NULL || strstr(after, comment) != NULL, "%s", comment);
        changed += strstr(after, text) == NULL;
        lines++;
        line += n + (line[n] == '\n');
        free(text);
    }
    ck_assert_int_le(changed, 4);
    ck_assert_int_gt(lines, 100);
}

START_TEST(the_rest_of_the_file_stays)
{
    lab_model *model = open_file(file);
    const stein_model *m = lab_equations(model);
    char *text = NULL;
    size_t size = 0;
    ck_assert_stein(lab__read_file(file, &text, &size, err));
    for (int k = 0; k < PARTS; k++) {
        lab_candidate c = candidate(model, parts[k].kind, parts[k].place);
        lab_model *extended = NULL;
        char *out = NULL;
        size_t nout = 0;
        ck_assert_stein(
            lab__structure_text(&c, c.limit, lab__mechanism(model), text, size, &out, &nout, err));
        compare_lines(text, out);
        free(out);
        ck_assert_stein(lab_candidate_open(&c, &extended, file, NULL, err));
        const stein_model *x = lab_equations(extended);
        ck_assert_int_eq(x->nchannel, m->nchannel);
        ck_assert_int_eq(x->ninput, m->ninput);
        for (int i = 0; i < m->nchannel; i++) {
            ck_assert_str_eq(x->channels[i].name, m->channels[i].name);
            ck_assert_int_eq(x->channels[i].from_rest, m->channels[i].from_rest);
        }
        for (int i = 0; i < m->np; i++) {
            int at = stein_find_param(x, m->params[i].name);
            ck_assert_msg(at >= 0, "%s: %s is lost", parts[k].kind, m->params[i].name);
            ck_assert_str_eq(x->params[at].unit, m->params[i].unit);
            ck_assert(x->params[at].value == m->params[i].value);
            ck_assert(x->params[at].tolerance == m->params[i].tolerance);
            ck_assert_int_eq(x->params[at].stated, m->params[i].stated);
        }
        for (int i = 0; i < x->np; i++) {
            int old = stein_find_param(m, x->params[i].name) >= 0;
            ck_assert(old || !(x->params[i].tolerance > 0.0)); // the fit frees no more than it did
        }
        lab_close(extended);
    }
    free(text);
    lab_close(model);
}
END_TEST

/* sections in braces, crowded, absent; a joint at a point of the frame; two lines of comments */
static const char terse[] =
    "mechanism: terse\n"
    "points: {post: [0, 0, 31 mm]}\n"
    "bodies: {arm: {joint: R y, at: frame.post, mass: 91 g, centre: [47 mm, 0, 0], inertia: {yy: "
    "7.3e-5 kg m^2}, points: {tip: [103 mm, 0, 0], heel: [-11 mm, 0, 0], end: [113 mm, 0, 0]}}}\n"
    "# about\n"
    "# the pad\n"
    "contacts:\n"
    "  # \xC3\xA4lter\n"
    "  pad: {between: [{line: {on: frame, at: [0, 0, 0], facing: 90 deg}}, {point: arm.tip}],\n"
    "        normal: {c: 4.1e3 N/m, D: 1 s/m}}  # f\xC3\xBCr den Arm\n"
    "inputs: {push: {force: arm.end, direction: [0, 0, -1]}}\n"
    "outputs: {height: {point: arm.tip, read: z}}\n"
    "simulation: {dt: 20 us, until: 0.1 s}";

START_TEST(any_style_of_file_takes_a_part)
{
    static const struct {
        const char *kind, *place, *words;
    } wanted[] = {{"elastic_hinge", "arm", "part_of: arm"},
                  {"axis_translation", "arm", "parent: arm_axis"},
                  {"compliant_partner", "pad", "on: pad_partner"},
                  {"string_damper", "arm", "arm_damper.x0"},
                  {"wire", "arm", "\nlinks:\n  arm_wire"}};
    make_folder();
    for (size_t k = 0; k < sizeof wanted / sizeof *wanted; k++) {
        lab_model *model = open_text(terse, NULL, 0), *extended = NULL;
        lab_candidate c = candidate(model, wanted[k].kind, wanted[k].place);
        lab_options options = cache_here(NULL);
        char *out = NULL;
        size_t size = 0;
        ck_assert_stein(lab__structure_text(&c, c.limit, lab__mechanism(model), terse,
                                            strlen(terse), &out, &size, err));
        ck_assert_msg(strstr(out, wanted[k].words) != NULL, "%s", out);
        ck_assert_ptr_nonnull(strstr(out, "\xC3\xA4lter\n"));
        ck_assert_stein(lab_candidate_open(&c, &extended, in_folder("model.yaml"), &options, err));
        ck_assert_int_ge(c.param[0], 0);
        free(out);
        lab_close(extended);
        lab_close(model);
    }
    remove_folder();
}
END_TEST

START_TEST(a_part_is_added_once)
{
    lab_model *model = open_file(file), *extended = NULL;
    lab_candidate c = candidate(model, "wire", "key"), again = c, none = c;
    lab__site site[LAB_SITES];
    stein_err why = {STEIN_OK, ""};
    ck_assert_stein(lab_candidate_open(&c, &extended, file, NULL, err));
    ck_assert_int_eq(lab__sites(lab__mechanism(extended), "wire", site), 0);
    char *text = NULL;
    size_t size = 0;
    ck_assert_int_eq(
        lab__structure_text(&again, 1.0, lab__mechanism(extended), "", 0, &text, &size, &why),
        STEIN_EINVAL);
    ck_assert_int_eq(lab_candidate_bind(&again, model, &why), STEIN_ENAME);
    strcpy(none.place, "pawl");
    ck_assert_int_eq(lab_candidate_open(&none, &extended, file, NULL, &why), STEIN_EINVAL);
    ck_assert_ptr_nonnull(strstr(why.msg, "wire at pawl"));
    lab_close(extended);
    lab_close(model);
}
END_TEST

/* any two go into one file, the second one at a place of the first one's mechanism */
START_TEST(parts_go_together)
{
    lab_model *model = open_file(file);
    char *text = NULL, *one = NULL, *two = NULL;
    size_t size = 0, none = 0, ntwo = 0;
    ck_assert_stein(lab__read_file(file, &text, &size, err));
    for (int a = 0; a < PARTS; a++) {
        lab_candidate first = candidate(model, parts[a].kind, parts[a].place);
        mechanism *m = NULL, *both = NULL;
        ck_assert_stein(lab__structure_text(&first, first.limit, lab__mechanism(model), text, size,
                                            &one, &none, err));
        ck_assert_stein(mech_read_text(&m, file, one, none, NULL, 0, NULL, NULL, err));
        for (int b = 0; b < PARTS; b++) {
            lab_candidate second = candidate(model, parts[b].kind, parts[b].place);
            if (a == b) {
                continue;
            }
            ck_assert_stein(
                lab__structure_text(&second, second.limit, m, one, none, &two, &ntwo, err));
            ck_assert_stein(mech_read_text(&both, file, two, ntwo, NULL, 0, NULL, NULL, err));
            ck_assert_int_ge(both->nbody + both->nlink + both->ncontact,
                             m->nbody + m->nlink + m->ncontact + 1);
            mech_free(both);
            free(two);
        }
        mech_free(m);
        free(one);
    }
    free(text);
    lab_close(model);
}
END_TEST

/* the places of an extended mechanism have sound ranges too: weights of parts are formulas */
START_TEST(an_extended_mechanism_has_candidates_of_its_own)
{
    lab_model *model = open_file(file), *extended = NULL;
    lab_candidate c = candidate(model, "elastic_hinge", "hammer");
    lab_candidate plain = candidate(model, "compliant_partner", "string");
    ck_assert_stein(lab_candidate_open(&c, &extended, file, NULL, err));
    lab_candidate again = candidate(extended, "compliant_partner", "string");
    ck_assert_close(again.side[0].value, plain.side[0].value, 0.5, 0.0);
    ck_assert_close(again.limit, plain.limit, 1e-9, 0.0);
    candidate(extended, "coulomb_friction", "hammer_outer");
    lab_close(extended);
    lab_close(model);
}
END_TEST

/* ---- the motion ---- */

typedef struct trace {
    int n, nch;
    double y[SAMPLES][CHANNELS];
} trace;

static stein_status take(void *ctx, stein_sim *sim)
{
    trace *t = ctx;
    ck_assert_int_lt(t->n, SAMPLES);
    t->nch = stein_sim_model(sim)->nchannel;
    for (int c = 0; c < t->nch; c++) {
        t->y[t->n][c] = stein_read(sim, c);
    }
    t->n++;
    return STEIN_OK;
}

static void run(trace *t, const lab_model *model, const double *p, double dt, double until)
{
    stein_sim *sim = NULL;
    stein_sim_def def = lab_def(model);
    def.dt = dt;
    ck_assert_stein(lab_sim(model, &def, &sim, err));
    ck_assert_stein(stein_set_all(sim, p, err));
    ck_assert_stein(stein_reset(sim, err));
    lab_stroke_def stroke = lab_stroke_def_default(lab_equations(model));
    stroke.until = until;
    stroke.every = 5e-4;
    stroke.sample = take;
    stroke.ctx = t;
    memset(t, 0, sizeof *t);
    ck_assert_stein(lab_simulate(sim, &stroke, err));
    stein_sim_destroy(sim);
}

/* largest difference of what is where [m, rad], by its range; forces and phases jump at events */
static double difference(const trace *a, const trace *b)
{
    static const char *const name[] = {"string_distance", "key_angle", "hammer_angle", "pawl_angle",
                                       "key_dip"};
    double most = 0.0;
    ck_assert_int_eq(a->n, b->n);
    for (size_t k = 0; k < sizeof name / sizeof *name; k++) {
        double low = INFINITY, high = -INFINITY, off = 0.0;
        int c = stein_find_channel(&stein_model_stein1788, name[k]);
        for (int i = 0; i < a->n; i++) {
            low = fmin(low, a->y[i][c]), high = fmax(high, a->y[i][c]);
            off = fmax(off, fabs(a->y[i][c] - b->y[i][c]));
        }
        most = fmax(most, off / (high - low));
    }
    return most;
}

static double *copy_of(const lab_model *model)
{
    size_t size = sizeof(double) * (size_t)lab_equations(model)->np;
    double *p = malloc(size);
    ck_assert_ptr_nonnull(p);
    memcpy(p, lab_parameters(model), size);
    return p;
}

static trace before, now;

START_TEST(a_force_or_stiffness_of_zero_is_the_mechanism_without_it)
{
    lab_model *model = open_file(file);
    run(&before, model, lab_parameters(model), 1e-5, 0.12);
    for (int k = 0; k < PARTS; k++) {
        lab_candidate c = candidate(model, parts[k].kind, parts[k].place);
        lab_model *extended = NULL;
        if (strcmp(c.effect->size, "compliance") == 0) {
            continue;
        }
        ck_assert_stein(lab_candidate_open(&c, &extended, file, NULL, err));
        double *p = copy_of(extended);
        lab_candidate_apply(&c, 0.0, p);
        ck_assert_mem_eq(p, lab_parameters(extended),
                         sizeof *p * (size_t)lab_equations(extended)->np);
        run(&now, extended, p, 1e-5, 0.12);
        ck_assert_double_le(difference(&before, &now), 1e-12);
        lab_candidate_apply(&c, 0.1 * c.limit, p);
        run(&now, extended, p, 1e-5, 0.12);
        ck_assert_double_ge(difference(&before, &now), 1e-3);
        free(p);
        lab_close(extended);
    }
    lab_close(model);
}
END_TEST

/* loop: a part each. Up to the escapement, or just past the part's own contact, differences are
 * proportional to the compliance: the base stroke is the limit. */
START_TEST(a_compliance_towards_zero_is_the_mechanism_without_it)
{
    static const double amount[] = {1e-2, 1e-3, 1e-4};
    double off[3];
    lab_model *model = open_file(file), *extended = NULL;
    lab_candidate c = candidate(model, parts[_i].kind, parts[_i].place);
    int late = strcmp(c.place, "string") == 0 || strcmp(c.place, "dip") == 0;
    double until = late ? 0.07 : 0.045;
    if (strcmp(c.effect->size, "compliance") == 0) {
        run(&before, model, lab_parameters(model), 2e-6, until);
        ck_assert_stein(lab_candidate_open(&c, &extended, file, NULL, err));
        double *p = copy_of(extended);
        for (int i = 0; i < 3; i++) {
            lab_candidate_apply(&c, amount[i] * c.limit, p);
            run(&now, extended, p, 2e-6, until);
            off[i] = difference(&before, &now);
        }
        printf("%s at %s: %.1e, %.1e, %.1e of the range\n", parts[_i].kind, parts[_i].place, off[0],
               off[1], off[2]);
        ck_assert_double_le(off[2], 0.2 * off[1]);
        ck_assert_double_le(off[1], 0.3 * off[0]);
        ck_assert_double_le(off[2], 5e-3);
        ck_assert_double_ge(off[0], 1e-9);
        free(p);
        lab_close(extended);
    }
    lab_close(model);
}
END_TEST

/* the inner piece is the rest of the whole, for every change of the whole */
START_TEST(a_cut_link_is_weighed_as_a_whole)
{
    lab_model *model = open_file(file), *extended = NULL;
    lab_candidate c = candidate(model, "elastic_hinge", "key");
    ck_assert_stein(lab_candidate_open(&c, &extended, file, NULL, err));
    static const char *const name[] = {"key.mass", "key.centre.x", "key.inertia.yy"};
    static const double factor[] = {1.07, 0.91, 1.11};
    double *p = copy_of(model), *x = copy_of(extended);
    for (int i = 0; i < 3; i++) {
        p[stein_find_param(lab_equations(model), name[i])] *= factor[i];
        x[stein_find_param(lab_equations(extended), name[i])] *= factor[i];
    }
    lab_candidate_apply(&c, 1e-4 * c.limit, x);
    run(&before, model, p, 2e-6, 0.04);
    run(&now, extended, x, 2e-6, 0.04);
    ck_assert_double_le(difference(&before, &now), 2e-3);
    free(p);
    free(x);
    lab_close(extended);
    lab_close(model);
}
END_TEST

/* ---- the independent program ---- */

/* numbers of the parts as tests/reality has them; NULL: its sentences, in their order */
static const struct {
    int open; /* above: the seat of an axis, which is softer there by a factor */
    const char *kind, *place, *name[3];
    struct {
        const char *name;
        double value;
    } fixed[7];
} twins[] = {
    {0,
     "elastic_hinge",
     "hammer",
     {"hammer_outer.compliance", "hammer_outer.damping_ratio", NULL},
     {{"hammer_outer.mass_ratio", 0.55 / 0.45},
      {"hammer_outer.inertia_ratio", 0.230216943846894},
      {"hammer_outer.apart.x", 0.0266 / 0.45},
      {"hammer_outer.apart.z", 0.001 / 0.45},
      {"hammer_outer.place", 1.0},
      {"hammer_outer.link.x", 0.045},
      {"hammer_outer.link.z", 0.0}}},
    {0,
     "elastic_hinge",
     "key",
     {"key_outer.compliance", "key_outer.damping_ratio", NULL},
     {{"key_outer.mass_ratio", 0.6 / 0.4},
      {"key_outer.inertia_ratio", 1.0353313475743},
      {"key_outer.apart.x", -0.0568 / 0.4},
      {"key_outer.apart.z", 0.0},
      {"key_outer.place", 1.0},
      {"key_outer.link.x", -0.04},
      {"key_outer.link.z", 0.0}}},
    {0,
     "axis_translation",
     "key",
     {"key_axis.compliance", "key_axis.damping_ratio", "key_axis.lift"},
     {{NULL, 0}}},
    {1,
     "axis_translation",
     "key",
     {"key_axis.compliance", "key_axis.damping_ratio", "key_axis.lift"},
     {{NULL, 0}}},
    {0,
     "compliant_partner",
     "string",
     {"string_partner.compliance", "string_partner.mass", "string_partner.damping_ratio"},
     {{NULL, 0}}},
    {0,
     "string_damper",
     "key",
     {"key_damper.normal.F0", "key_damper.x0", "key_damper.k_to_F0"},
     {{NULL, 0}}},
    {0, "wire", "key", {"key_wire.k", "key_wire.reach", "key_wire.stretch"}, {{NULL, 0}}},
};

static void set(lab_model *model, double *p, const char *name, double value)
{
    int i = stein_find_param(lab_equations(model), name);
    ck_assert_msg(i >= 0, "no number %s", name);
    p[i] = value;
}

/* one exact stroke; what the effect's numbers are goes to value[3] */
static void reality(size_t i, double value[3])
{
    const char *build = getenv("STEIN_BUILD");
    char command[800];
    int axis = strcmp(twins[i].kind, "axis_translation") == 0;
    for (int seed = 1; seed < 20; seed++) { // until one has an axis of that kind
        snprintf(command, sizeof command,
                 "%s/reality --model %s --stroke --seed %d --dx -0.3 --kind %s --place %s "
                 "--amount 0.1 -o %s >%s",
                 build != NULL ? build : "build", file, seed, twins[i].kind, twins[i].place,
                 in_folder("a.csv"), in_folder("said"));
        ck_assert_int_eq(system(command), 0);
        FILE *f = fopen(in_folder("said"), "r");
        ck_assert_ptr_nonnull(f);
        ck_assert_int_eq(fscanf(f, "%lf %lf %lf", &value[0], &value[1], &value[2]), 3);
        fclose(f);
        if (!axis || (value[2] > 2.0) == twins[i].open) {
            value[2] -= axis; // softer by a factor, or by so much more
            return;
        }
    }
    ck_abort_msg("no seed with such an axis");
}

/* largest differences up to the first rebound [m] */
static void follow(stein_sim *sim, double worst[2])
{
    char line[200];
    FILE *f = fopen(in_folder("a.csv"), "r");
    int rows = 0, struck = 0;
    ck_assert_ptr_nonnull(f);
    worst[0] = worst[1] = 0.0;
    while (!struck && fgets(line, sizeof line, f) != NULL) {
        double t, y[2], value = 0.0;
        if (sscanf(line, "%lf,%lf,%lf", &t, &y[0], &y[1]) != 3) {
            continue;
        }
        ck_assert_stein(stein_run(sim, t, err));
        for (int k = 0; k < 2; k++) {
            ck_assert_stein(
                stein_read_name(sim, k == 0 ? "string_distance" : "key_dip", &value, err));
            worst[k] = fmax(worst[k], fabs(value - y[k]));
        }
        struck = y[0] < 0.0;
        rows++;
    }
    fclose(f);
    ck_assert_int_gt(rows, 600);
    ck_assert(struck);
}

/* loop: a kind each */
START_TEST(parts_move_as_in_the_independent_program)
{
    lab_model *model = open_file(file), *extended = NULL;
    lab_candidate c = candidate(model, twins[_i].kind, twins[_i].place);
    double value[3], worst[2];
    stein_sim *sim = NULL;
    make_folder();
    reality((size_t)_i, value);
    ck_assert_stein(lab_candidate_open(&c, &extended, file, NULL, err));
    double *p = copy_of(extended);
    for (int k = 0; k < 3 && twins[_i].name[k] != NULL; k++) {
        set(extended, p, twins[_i].name[k], value[k]);
    }
    for (int k = 0; k < 7 && twins[_i].fixed[k].name != NULL; k++) {
        set(extended, p, twins[_i].fixed[k].name, twins[_i].fixed[k].value);
    }
    set(extended, p, "pawl.stop_shift", -0.3e-3);
    stein_sim_def def = lab_def(extended);
    def.dt = 4e-6;
    ck_assert_stein(lab_sim(extended, &def, &sim, err));
    ck_assert_stein(stein_set_all(sim, p, err));
    ck_assert_stein(stein_reset(sim, err));
    follow(sim, worst);
    printf("%s at %s against reality: distance %.1e m, dip %.1e m\n", twins[_i].kind,
           twins[_i].place, worst[0], worst[1]);
    ck_assert_double_le(worst[0], 1e-6);
    ck_assert_double_le(worst[1], 1e-6);
    stein_sim_destroy(sim);
    free(p);
    remove_folder();
    lab_close(extended);
    lab_close(model);
}
END_TEST

Suite *structure_suite(void)
{
    Suite *suite = suite_create("structure");
    TCase *tc = tcase_create("structure");
    tcase_set_timeout(tc, 120);
    tcase_add_checked_fixture(tc, cache_in_build, NULL);
    tcase_add_test(tc, parts_sit_where_the_mechanism_has_room_for_them);
    tcase_add_test(tc, a_link_bends_like_a_uniform_bar);
    tcase_add_test(tc, the_rest_of_the_file_stays);
    tcase_add_test(tc, any_style_of_file_takes_a_part);
    tcase_add_test(tc, a_part_is_added_once);
    tcase_add_test(tc, parts_go_together);
    tcase_add_test(tc, an_extended_mechanism_has_candidates_of_its_own);
    tcase_add_test(tc, a_force_or_stiffness_of_zero_is_the_mechanism_without_it);
    tcase_add_loop_test(tc, a_compliance_towards_zero_is_the_mechanism_without_it, 0, PARTS);
    tcase_add_test(tc, a_cut_link_is_weighed_as_a_whole);
    tcase_add_loop_test(tc, parts_move_as_in_the_independent_program, 0,
                        (int)(sizeof twins / sizeof *twins));
    suite_add_tcase(suite, tc);
    return suite;
}
