/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_effects.c - the table of effects: names, places; every candidate of a mechanism is a
 * parameter that changes the prediction, and has no effect at its neutral value.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lab_support.h"
#include "stein/diagnose.h"
#include "added_parts.h"

Suite *effects_suite(void);

enum { SAMPLES = 200, MAX_CHANNELS = 32 };

/* names that other programs rely on, in no order */
static const char *const documented[] = {"viscous_friction",
                                         "coulomb_friction",
                                         "stiction_peak",
                                         "quadratic_drag",
                                         "viscous_asymmetry",
                                         "coulomb_asymmetry",
                                         "preload",
                                         "joint_stiffness",
                                         "hardening_spring",
                                         "backlash",
                                         "mass",
                                         "centre",
                                         "inertia",
                                         "armature",
                                         "elastic_hinge",
                                         "axis_translation",
                                         "contact_stiffness",
                                         "contact_exponent",
                                         "contact_damping",
                                         "contact_hysteresis",
                                         "contact_friction",
                                         "adhesion",
                                         "contact_gap",
                                         "compliant_partner",
                                         "string_damper",
                                         "wire",
                                         "one_sided_link",
                                         "let_off",
                                         "unknown_load",
                                         "input_gain",
                                         "input_delay",
                                         "sensor_gain",
                                         "sensor_offset",
                                         "sensor_delay",
                                         "time_base",
                                         "sensor_nonlinearity",
                                         "camera_tilt",
                                         "wrong_parameter",
                                         "wrong_setting"};

START_TEST(kinds_are_unique_and_as_documented)
{
    int n, known = (int)(sizeof documented / sizeof *documented), compliances = 0;
    const lab_effect *e = lab_effects(&n);
    ck_assert_int_eq(n, known);
    for (int i = 0; i < n; i++) {
        int found = 0;
        for (int k = 0; k < known; k++) {
            found += strcmp(e[i].kind, documented[k]) == 0;
        }
        ck_assert_msg(found == 1, "%s", e[i].kind);
        ck_assert_ptr_eq(lab_effect_find(e[i].kind), &e[i]);
        compliances += lab_effect_is_compliance(&e[i]);
        ck_assert((e[i].parameter == NULL) == (e[i].needs != NULL));
        ck_assert(*e[i].equation != '\0' && *e[i].looks != '\0');
    }
    ck_assert_ptr_null(lab_effect_find("magic"));
    ck_assert_int_eq(compliances, 3); // hinge, axis, partner
}
END_TEST

/* of one joint and one channel with scales that are no round numbers */
static double limit_of(const char *kind, lab_site site)
{
    double weight = 1.31, energy = 2.7, speed = 3.3, travel = 0.61, length = 0.17, range = 0.23;
    const lab__scales s = {.weight = &weight,
                           .energy = &energy,
                           .speed = &speed,
                           .travel = &travel,
                           .length = &length,
                           .range = &range,
                           .heaviness = 4.1};
    switch (site) {
    case LAB_AT_JOINT: return lab__joint_limit(kind, &s, 0);
    case LAB_AT_BODY: return lab__body_limit(kind, &s, 0, 0.37);
    case LAB_AT_CONTACT:
    case LAB_AT_SURFACE: return lab__contact_limit(kind, &s, 0.37);
    case LAB_AT_CHANNEL:
    case LAB_AT_MARKER: return lab__channel_limit(kind, &s, 0);
    case LAB_AT_INPUT: return lab__input_limit(kind);
    default: return NAN;
    }
}

START_TEST(every_kind_has_a_largest_size_and_an_unknown_one_has_none)
{
    int n, sized = 0;
    const lab_effect *e = lab_effects(&n);
    for (int i = 0; i < n; i++) {
        int elsewhere = e[i].needs != NULL || e[i].site == LAB_AT_LINK ||
                        e[i].site == LAB_AT_LOAD || e[i].site == LAB_AT_CLOCK ||
                        e[i].site == LAB_AT_PARAMETER || e[i].site == LAB_AT_SETTING;
        double limit = limit_of(e[i].kind, e[i].site);
        ck_assert_msg(elsewhere || (isfinite(limit) && limit > 0.0), "%s", e[i].kind);
        ck_assert_msg(isnan(limit_of("magic", e[i].site)), "%s", e[i].kind);
        sized += !elsewhere;
    }
    ck_assert_int_gt(sized, n / 2);
    ck_assert_double_eq(limit_of("joint_stiffness", LAB_AT_JOINT), 1.31 / 0.61);
}
END_TEST

/* one entry of the table holds all of a kind: no list by name beside it */
START_TEST(every_kind_has_a_family_and_a_share_is_of_a_number_that_another_kind_moves)
{
    static const char *const family[] = {"dissipation", "stiffness", "inertia", "geometry",
                                         "contact",     "drive",     "sensor",  "clock",
                                         "part",        "setting"};
    int n, members[sizeof family / sizeof *family] = {0};
    const lab_effect *e = lab_effects(&n);
    for (int i = 0; i < n; i++) {
        int known = 0, moved = e[i].share == NULL || strchr(e[i].share, '.') != NULL;
        for (size_t k = 0; k < sizeof family / sizeof *family; k++) {
            int is = strcmp(lab_effect_family(&e[i]), family[k]) == 0;
            members[k] += is;
            known += is;
        }
        for (int k = 0; k < n && !moved; k++) {
            moved = e[k].parameter != NULL && strcmp(e[k].parameter, e[i].share) == 0;
        }
        ck_assert_msg(known == 1, "%s", e[i].kind);
        ck_assert_msg(moved, "%s", e[i].kind);
        ck_assert_msg((strcmp(e[i].family, "part") == 0) ==
                          (e[i].needs != NULL && strcmp(e[i].family, "inertia") != 0),
                      "%s", e[i].kind);
        ck_assert_ptr_eq(lab_effect_share(&e[i]), e[i].share);
    }
    for (size_t k = 0; k < sizeof family / sizeof *family; k++) {
        ck_assert_msg(members[k] > 0, "%s", family[k]);
    }
    ck_assert_str_eq(lab_effect_family(NULL), "unknown");
}
END_TEST

START_TEST(kinds_that_are_hard_to_separate_exist)
{
    int n;
    const lab_effect *e = lab_effects(&n);
    for (int i = 0; i < n; i++) {
        char text[200], *rest = text;
        snprintf(text, sizeof text, "%s", e[i].twins);
        for (char *word = strtok_r(text, " ", &rest); word; word = strtok_r(NULL, " ", &rest)) {
            ck_assert_msg(lab_effect_find(word) != NULL, "%s: %s", e[i].kind, word);
        }
    }
}
END_TEST

/* ---- candidates of the piano action ---- */

static lab_model *open_file(const char *path)
{
    lab_model *model = NULL;
    lab_options options = lab_options_default();
    ck_assert_stein(lab_open(&model, path, &options, err));
    return model;
}

typedef struct trace {
    int n;
    double y[SAMPLES][MAX_CHANNELS];
} trace;

static stein_status take(void *ctx, stein_sim *sim)
{
    trace *t = ctx;
    if (t->n < SAMPLES) {
        for (int c = 0; c < stein_sim_model(sim)->nchannel; c++) {
            t->y[t->n][c] = stein_read(sim, c);
        }
        t->n++;
    }
    return STEIN_OK;
}

static void push(void *ctx, double t, double u[3])
{
    (void)ctx;
    u[0] = 2.0 * sin(40.0 * t), u[1] = 80.0 * cos(40.0 * t), u[2] = -3200.0 * sin(40.0 * t);
}

/* a key that is moved down and up again */
static void press(void *ctx, double t, double u[3])
{
    (void)ctx;
    u[0] = 0.02 * (1.0 - cos(60.0 * t)), u[1] = 1.2 * sin(60.0 * t), u[2] = 72.0 * cos(60.0 * t);
}

/* @param drive  0 load, 1 finger, 2 key motion */
static void run(trace *t, const lab_model *model, const double *p, int drive)
{
    stein_sim *sim = NULL;
    stein_sim_def def = lab_def(model);
    def.dt = 2e-5;
    ck_assert_stein(lab_sim(model, &def, &sim, err));
    ck_assert_stein(stein_set_all(sim, p, err));
    if (drive > 0) {
        ck_assert_stein(stein_drive(sim, drive == 1 ? "finger" : "key_motion",
                                    drive == 1 ? push : press, NULL, err));
    }
    ck_assert_stein(stein_reset(sim, err));
    lab_stroke_def stroke = lab_stroke_def_default(lab_equations(model));
    stroke.until = drive > 0 ? 0.1 : 0.2;
    stroke.release = drive > 0 ? NAN : 0.12;
    stroke.every = 1e-3;
    stroke.sample = take;
    stroke.ctx = t;
    memset(t, 0, sizeof *t);
    ck_assert_stein(lab_simulate(sim, &stroke, err));
    stein_sim_destroy(sim);
}

static double change(const trace *a, const trace *b, int nch)
{
    double most = 0.0;
    ck_assert_int_eq(a->n, b->n);
    for (int c = 1; c < nch; c++) {
        double low = INFINITY, high = -INFINITY, off = 0.0;
        for (int i = 0; i < a->n; i++) {
            low = fmin(low, a->y[i][c]), high = fmax(high, a->y[i][c]);
            off = fmax(off, fabs(a->y[i][c] - b->y[i][c]));
        }
        most = fmax(most, off / fmax(high - low, 1e-9));
    }
    return most;
}

static int drive_of(const lab_candidate *c)
{
    return strcmp(c->place, "finger") == 0                                             ? 1
           : strcmp(c->place, "key_motion") == 0 || strcmp(c->place, "key_force") == 0 ? 2
                                                                                       : 0;
}

START_TEST(every_candidate_changes_the_prediction)
{
    lab_model *model = open_file("models/stein1788.yaml");
    const stein_model *m = lab_equations(model);
    lab_candidate *list = NULL;
    int n = 0;
    static trace before[3], now;
    ck_assert_stein(lab_candidates(&list, &n, model, err));
    ck_assert_int_gt(n, 120);
    double *p = malloc(sizeof *p * (size_t)m->np);
    for (int d = 0; d < 3; d++) {
        run(&before[d], model, lab_parameters(model), d);
    }
    for (int i = _i; i < n; i += 4) {
        const lab_candidate *c = &list[i];
        size_t size = sizeof *p * (size_t)m->np;
        ck_assert(c->limit > 0.0 && isfinite(c->limit));
        if (c->effect->needs != NULL) {
            continue; // test_structure.c
        }
        memcpy(p, lab_parameters(model), size);
        lab_candidate_apply(c, 0.0, p);
        ck_assert_mem_eq(p, lab_parameters(model), size); // neutral: the very bits
        lab_candidate_apply(c, c->start * c->limit, p);
        ck_assert(memcmp(p, lab_parameters(model), size) != 0);
        if (c->effect->sampled) {
            continue; // whoever samples applies it
        }
        run(&now, model, p, drive_of(c));
        double moved = change(&before[drive_of(c)], &now, m->nchannel);
        ck_assert_msg(moved > 1e-9, "%s at %s changes nothing (%g)", c->effect->kind, c->place,
                      moved);
    }
    free(p);
    free(list);
    lab_close(model);
}
END_TEST

START_TEST(neutral_values_leave_a_stroke_bit_for_bit)
{
    lab_model *model = open_file("models/stein1788.yaml");
    const stein_model *m = lab_equations(model);
    lab_candidate *list = NULL;
    int n = 0;
    static trace a, b;
    ck_assert_stein(lab_candidates(&list, &n, model, err));
    double *p = malloc(sizeof *p * (size_t)m->np);
    memcpy(p, lab_parameters(model), sizeof *p * (size_t)m->np);
    for (int i = 0; i < n; i++) {
        lab_candidate_apply(&list[i], 0.0, p);
        if (list[i].side[0].param >= 0 && strcmp(list[i].effect->kind, "backlash") == 0) {
            p[list[i].side[0].param] = list[i].side[0].value; // a gap without a spring behind it
        }
    }
    run(&a, model, lab_parameters(model), 0);
    run(&b, model, p, 0);
    ck_assert_mem_eq(&a, &b, sizeof a);
    free(p);
    free(list);
    lab_close(model);
}
END_TEST

START_TEST(candidates_follow_the_structure)
{
    lab_model *model = open_file("models/falling_ball.yaml");
    lab_candidate *list = NULL;
    int n = 0, drag = 0;
    ck_assert_stein(lab_candidates(&list, &n, model, err));
    for (int i = 0; i < n; i++) {
        lab_site site = list[i].effect->site;
        ck_assert(site != LAB_AT_CONTACT && site != LAB_AT_SURFACE && site != LAB_AT_INPUT &&
                  site != LAB_AT_LOAD);
        int is_drag = strcmp(list[i].effect->kind, "quadratic_drag") == 0;
        ck_assert(!is_drag || list[i].limit > 3e-3); // a plastic ball with holes: 2.8e-3 N s^2/m^2
        drag += is_drag;
        for (int k = 0; k < i; k++) {
            ck_assert(list[i].effect != list[k].effect ||
                      strcmp(list[i].place, list[k].place) != 0);
        }
    }
    ck_assert_int_eq(drag, 1);
    free(list);
    lab_close(model);
}
END_TEST

START_TEST(a_spring_that_is_added_pulls_by_the_angle_alone)
{
    lab_model *model = open_file("models/stein1788.yaml");
    const stein_model *m = lab_equations(model);
    lab_candidate *list = NULL;
    int n = 0, k = stein_find_param(m, "pawl.spring.k"),
        q0 = stein_find_param(m, "pawl.spring.theta0");
    double *p = malloc(sizeof *p * (size_t)m->np);
    ck_assert_stein(lab_candidates(&list, &n, model, err));
    for (int i = 0; i < n; i++) {
        if (strcmp(list[i].effect->kind, "joint_stiffness") == 0 &&
            strcmp(list[i].place, "pawl") == 0) {
            memcpy(p, lab_parameters(model), sizeof *p * (size_t)m->np);
            double before = -p[k] * (0.1 - p[q0]);
            lab_candidate_apply(&list[i], 0.01, p);
            ck_assert_close(-p[k] * (0.1 - p[q0]), before - 0.01 * 0.1, 1e-12, 0.0);
        }
    }
    free(p);
    free(list);
    lab_close(model);
}
END_TEST

/* by kind and place in a list */
static const lab_candidate *find(const lab_candidate *list, int n, const char *kind,
                                 const char *place)
{
    for (int i = 0; i < n; i++) {
        if (strcmp(list[i].effect->kind, kind) == 0 && strcmp(list[i].place, place) == 0) {
            return &list[i];
        }
    }
    return NULL;
}

/* its length is as uncertain as the length of a rod that is drawn along x */
START_TEST(the_centre_of_a_rod_that_hangs_is_along_it)
{
    static const char *const centre[][2] = {{"[0, 0, -310 mm]", "rod.centre.z"},
                                            {"[310 mm, 0, 0]", "rod.centre.x"},
                                            {"[2 mm, 0, -310 mm]", "rod.centre.z"},
                                            {"[70 mm, 0, -310 mm]", "rod.centre.x"}};
    double limit = 0.0;
    cache_in_build();
    make_folder();
    for (size_t i = 0; i < sizeof centre / sizeof *centre; i++) {
        char text[300];
        snprintf(text, sizeof text,
                 "mechanism: rod\nbodies:\n  rod: {joint: R y, mass: 0.1 kg, centre: %s, inertia: "
                 "{yy: 8e-4 kg m^2}}\noutputs:\n  angle: {joint: rod, read: position}\n",
                 centre[i][0]);
        lab_model *model = open_text(text, NULL, 0);
        lab_candidate *list = NULL;
        int n = 0;
        ck_assert_stein(lab_candidates(&list, &n, model, err));
        const lab_candidate *c = find(list, n, "centre", "rod");
        ck_assert_ptr_nonnull(c);
        ck_assert_str_eq(lab_equations(model)->params[c->param[0]].name, centre[i][1]);
        ck_assert_ptr_null(find(list, n, "wrong_parameter", centre[i][1]));
        limit = i == 0 ? c->limit : limit;
        ck_assert(i != 1 || fabs(c->limit - limit) < 1e-12);
        free(list);
        lab_close(model);
    }
    remove_folder();
}
END_TEST

START_TEST(second_numbers_have_ranges)
{
    static const struct {
        const char *kind, *place, *name;
        double lo, hi;
        int log;
    } wanted[] = {{"coulomb_friction", "key", "key.coulomb.w", 0.002, 0.1, 1},
                  {"stiction_peak", "hammer", "hammer.friction.B2", 1e-4, 1.0, 1},
                  {"adhesion", "string", "string.adhesion.range", 3e-5, 2e-4, 1},
                  {"backlash", "pawl", "pawl.backlash.gap", 0.0, 0.1, 1}};
    lab_model *model = open_file("models/stein1788.yaml");
    const stein_model *m = lab_equations(model);
    lab_candidate *list = NULL;
    int n = 0;
    ck_assert_stein(lab_candidates(&list, &n, model, err));
    double *p = malloc(sizeof *p * (size_t)m->np);
    for (size_t i = 0; i < sizeof wanted / sizeof *wanted; i++) {
        const lab_candidate *c = find(list, n, wanted[i].kind, wanted[i].place);
        ck_assert_ptr_nonnull(c);
        ck_assert_int_eq(c->side[0].param, stein_find_param(m, wanted[i].name));
        ck_assert_str_eq(c->side[0].unit, m->params[c->side[0].param].unit);
        ck_assert(c->side[0].lo < c->side[0].value && c->side[0].value < c->side[0].hi);
        ck_assert(c->side[0].lo >= wanted[i].lo * (1 - 1e-12) &&
                  c->side[0].hi <= wanted[i].hi * (1 + 1e-12));
        ck_assert_int_eq(c->side[0].log, wanted[i].log);
        memcpy(p, lab_parameters(model), sizeof *p * (size_t)m->np);
        lab_candidate_apply(c, 0.1 * c->limit, p);
        ck_assert(p[c->side[0].param] == c->side[0].value);
    }
    free(p);
    free(list);
    lab_close(model);
}
END_TEST

START_TEST(equal_changes_are_one_candidate)
{
    static const struct {
        const char *kind, *place, *alias;
    } same[] = {{"contact_gap", "dip", "key.below.z dip.line.z"},
                {"contact_gap", "loops", "hammer.shank.z loops.line.z"},
                {"contact_gap", "stop", ""},
                {"contact_gap", "string", "string.height"},
                {"preload", "pawl", "pawl.spring.theta0"},
                {"preload", "key", ""},
                {"contact_stiffness", "stop", "stop.normal.c"},
                {"contact_stiffness", "load", "load.normal.c"},
                {"contact_stiffness", "notch", "notch.normal.c"},
                {"contact_stiffness", "dip", ""},
                {"contact_gap", "notch", ""}};
    /* other than these: a point that turns while it touches; a point beside; a measured gap; a
     * length of a line does nothing */
    static const char *const gone[] = {"dip.line.z",       "dip.line.x", "string.height",
                                       "notch.friction.A", "key.mass",   "key.rear.z"};
    // one of two numbers of a felt that is pressed far enough to show both
    static const char *const there[] = {"pawl.corner.z",   "key.below.x",  "pawl.back.z",
                                        "notch.beak.tilt", "dip.normal.c", "hammer.head.z"};
    lab_model *model = open_file("models/stein1788.yaml");
    lab_candidate *list = NULL;
    int n = 0;
    ck_assert_stein(lab_candidates(&list, &n, model, err));
    for (size_t i = 0; i < sizeof same / sizeof *same; i++) {
        const lab_candidate *c = find(list, n, same[i].kind, same[i].place);
        ck_assert_ptr_nonnull(c);
        ck_assert_str_eq(c->alias, same[i].alias);
    }
    for (size_t i = 0; i < sizeof gone / sizeof *gone; i++) {
        ck_assert_msg(find(list, n, "wrong_parameter", gone[i]) == NULL, "%s", gone[i]);
        ck_assert_msg(find(list, n, "wrong_parameter", there[i]) != NULL, "%s", there[i]);
    }
    free(list);
    lab_close(model);
}
END_TEST

/* A tracked point that only one channel reads, seen from an axis where that channel is 0, is the
 * channel's gain; not from another axis, nor where a second channel reads the point. */
START_TEST(the_place_of_a_tracked_point_is_the_gain_of_its_channel)
{
    static const char text[] = "mechanism: rod\nbodies:\n  rod: {joint: R -y, mass: 1 kg, centre: "
                               "[0, 0, -0.3], inertia: {yy: 0.02}, points: {tip: [0, 0, -0.5]}}\n"
                               "outputs:\n  angle: {joint: rod, read: position}\n  tip_x: {point: "
                               "rod.tip, read: x}\n";
    static const char aside[] =
        "mechanism: rod\nbodies:\n  rod: {joint: R -y, at: [0.1, 0, 0], "
        "mass: 1 kg, centre: [0, 0, -0.3], inertia: {yy: 0.02}, points: {tip: "
        "[0, 0, -0.5]}}\noutputs:\n  tip_x: {point: rod.tip, read: x}\n";
    char *both = lab__text("%s  tip_z: {point: rod.tip, read: z}\n", text);
    const char *file[] = {text, both, aside};
    make_folder();
    for (int i = 0; i < 3; i++) {
        lab_model *model = open_file(write_file("rod.yaml", file[i]));
        lab_candidate *list = NULL;
        int n = 0;
        ck_assert_stein(lab_candidates(&list, &n, model, err));
        const lab_candidate *gain = find(list, n, "sensor_gain", "tip_x");
        ck_assert_ptr_nonnull(gain);
        ck_assert_str_eq(gain->alias, i == 0 ? "rod.tip.z" : "");
        ck_assert_int_eq(find(list, n, "wrong_parameter", "rod.tip.z") == NULL, i == 0);
        free(list);
        lab_close(model);
    }
    free(both);
    remove_folder();
}
END_TEST

/* an alias is exact: moving either makes the same stroke */
START_TEST(an_alias_moves_alike)
{
    lab_model *model = open_file("models/stein1788.yaml");
    const stein_model *m = lab_equations(model);
    static const struct {
        const char *a, *b;
        double by, as;
    } pair[] = {{"dip.gap", "dip.line.z", 2e-4, -2e-4},
                {"string.gap", "string.height", 1e-4, 1e-4},
                {"stop.gap", "pawl.stop_shift", 1e-4, 1e-4},
                {"pawl.preload", "pawl.spring.theta0", 0.03224e-2, 1e-2}};
    static trace one, two;
    double *p = malloc(sizeof *p * (size_t)m->np), *q = malloc(sizeof *q * (size_t)m->np);
    for (size_t i = 0; i < sizeof pair / sizeof *pair; i++) {
        memcpy(p, lab_parameters(model), sizeof *p * (size_t)m->np);
        memcpy(q, lab_parameters(model), sizeof *q * (size_t)m->np);
        p[stein_find_param(m, pair[i].a)] += pair[i].by;
        q[stein_find_param(m, pair[i].b)] += pair[i].as;
        run(&one, model, p, 2);
        run(&two, model, q, 2);
        ck_assert_msg(change(&one, &two, m->nchannel) < 1e-7, "%s and %s: %g", pair[i].a, pair[i].b,
                      change(&one, &two, m->nchannel));
    }
    free(p);
    free(q);
    lab_close(model);
}
END_TEST

/* a point of a body that hardly turns where it touches is a gap, to a hundredth of what both do */
START_TEST(a_point_that_hardly_turns_moves_nearly_alike)
{
    lab_model *model = open_file("models/stein1788.yaml");
    const stein_model *m = lab_equations(model);
    static const char *const pair[][2] = {
        {"rest.gap", "key.rear.z"}, {"dip.gap", "key.below.z"}, {"loops.gap", "hammer.shank.z"}};
    static trace none, one, two;
    double *p = malloc(sizeof *p * (size_t)m->np);
    memcpy(p, lab_parameters(model), sizeof *p * (size_t)m->np);
    run(&none, model, p, 0);
    for (size_t i = 0; i < sizeof pair / sizeof *pair; i++) {
        trace *to[] = {&one, &two};
        for (int k = 0; k < 2; k++) {
            int param = stein_find_param(m, pair[i][k]);
            double was = p[param];
            p[param] += 1e-7;
            run(to[k], model, p, 0);
            p[param] = was;
        }
        double both = change(&none, &one, m->nchannel), off = change(&one, &two, m->nchannel);
        ck_assert_msg(both > 1e-4 && off < 1e-2 * both, "%s and %s: %g of %g", pair[i][0],
                      pair[i][1], off, both);
    }
    free(p);
    lab_close(model);
}
END_TEST

/* a felt that is hardly pressed is as stiff as its straight part, to a hundredth of what both do */
START_TEST(a_felt_that_is_hardly_pressed_is_straight)
{
    lab_model *model = open_file("models/stein1788.yaml");
    const stein_model *m = lab_equations(model);
    static const char *const straight[] = {"stop", "load", "notch"};
    static trace none, one, two;
    double *p = malloc(sizeof *p * (size_t)m->np);
    lab_candidate *list = NULL;
    int n = 0;
    ck_assert_stein(lab_candidates(&list, &n, model, err));
    memcpy(p, lab_parameters(model), sizeof *p * (size_t)m->np);
    run(&none, model, p, 0);
    for (size_t i = 0; i < sizeof straight / sizeof *straight; i++) {
        const lab_candidate *c = find(list, n, "contact_stiffness", straight[i]);
        char name[40];
        double small = 1e-4, off = INFINITY;
        snprintf(name, sizeof name, "%s.normal.c", straight[i]);
        lab_candidate_apply(c, small, p);
        run(&one, model, p, 0);
        double both = change(&none, &one, m->nchannel);
        for (int k = 0; k < 5; k++) { // the whole of it, and a little more for what is bent
            memcpy(p, lab_parameters(model), sizeof *p * (size_t)m->np);
            p[stein_find_param(m, name)] *= 1.0 + small * (1.0 + 0.01 * k);
            run(&two, model, p, 0);
            off = fmin(off, change(&one, &two, m->nchannel));
            memcpy(p, lab_parameters(model), sizeof *p * (size_t)m->np);
        }
        printf("stiffness of %s: %g, its straight part is off by %g\n", straight[i], both, off);
        ck_assert_msg(both > 1e-6 && off < 1e-2 * both, "%s: %g of %g", straight[i], off, both);
    }
    free(list);
    free(p);
    lab_close(model);
}
END_TEST

START_TEST(a_candidate_is_found_again_in_another_model)
{
    lab_model *model = open_file("models/stein1788.yaml");
    const stein_model *m = lab_equations(model);
    lab_candidate *list = NULL;
    int n = 0;
    ck_assert_stein(lab_candidates(&list, &n, model, err));
    for (int i = 0; i < n; i++) {
        lab_candidate c = list[i], lost = c;
        stein_err why = {STEIN_OK, ""};
        if (c.effect->needs != NULL) {
            continue;
        }
        c.nparam = 0, c.param[0] = c.side[0].param = c.joint = c.channel = -7;
        ck_assert_stein(lab_candidate_bind(&c, model, err));
        ck_assert_int_eq(c.nparam, list[i].nparam);
        for (int k = 0; k < c.nparam; k++) {
            ck_assert_str_eq(m->params[c.param[k]].name, m->params[list[i].param[k]].name);
        }
        ck_assert_int_eq(c.side[0].param, list[i].side[0].param);
        ck_assert_int_eq(c.joint, list[i].joint);
        ck_assert_int_eq(c.channel, list[i].channel);
        strcpy(lost.place, "nowhere");
        ck_assert_int_eq(lab_candidate_bind(&lost, model, &why), STEIN_ENAME);
    }
    free(list);
    lab_close(model);
}
END_TEST

Suite *effects_suite(void)
{
    Suite *suite = suite_create("effects");
    TCase *tc = tcase_create("effects");
    tcase_set_timeout(tc, 120);
    tcase_add_test(tc, kinds_are_unique_and_as_documented);
    tcase_add_test(tc, every_kind_has_a_largest_size_and_an_unknown_one_has_none);
    tcase_add_test(tc, every_kind_has_a_family_and_a_share_is_of_a_number_that_another_kind_moves);
    tcase_add_test(tc, kinds_that_are_hard_to_separate_exist);
    tcase_add_loop_test(tc, every_candidate_changes_the_prediction, 0, 4);
    tcase_add_test(tc, neutral_values_leave_a_stroke_bit_for_bit);
    tcase_add_test(tc, candidates_follow_the_structure);
    tcase_add_test(tc, second_numbers_have_ranges);
    tcase_add_test(tc, equal_changes_are_one_candidate);
    tcase_add_test(tc, the_place_of_a_tracked_point_is_the_gain_of_its_channel);
    tcase_add_test(tc, an_alias_moves_alike);
    tcase_add_test(tc, a_point_that_hardly_turns_moves_nearly_alike);
    tcase_add_test(tc, a_felt_that_is_hardly_pressed_is_straight);
    tcase_add_test(tc, a_candidate_is_found_again_in_another_model);
    tcase_add_test(tc, the_centre_of_a_rod_that_hangs_is_along_it);
    tcase_add_test(tc, a_spring_that_is_added_pulls_by_the_angle_alone);
    suite_add_tcase(suite, tc);
    return suite;
}
