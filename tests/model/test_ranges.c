/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_ranges.c - what a parameter can be: the reader of files, the generated tables and every
 * function that sets a number use the same ranges, and a refusal changes nothing.
 */
#include <string.h>

#include "lab_support.h"
#include "stein/handover.h"

static stein_range range_of(const stein_model *m, const char *name)
{
    int i = stein_find_param(m, name);
    ck_assert_msg(i >= 0, "%s", name);
    return m->params[i].range;
}

START_TEST(equations_contain_the_ranges_of_their_parameters)
{
    const stein_model *m = &stein_model_stein1788;
    ck_assert_int_eq(range_of(m, "hammer.mass"), STEIN_NOT_NEGATIVE);
    ck_assert_int_eq(range_of(m, "string.friction.A"), STEIN_NOT_NEGATIVE);
    ck_assert_int_eq(range_of(m, "string.friction.B1"), STEIN_NOT_NEGATIVE); // would drive
    ck_assert_int_eq(range_of(m, "key.friction.B1"), STEIN_NOT_NEGATIVE);
    ck_assert_int_eq(range_of(m, "key.damping"), STEIN_NOT_NEGATIVE);
    ck_assert_int_eq(range_of(m, "string.friction.vt"), STEIN_POSITIVE);
    ck_assert_int_eq(range_of(m, "pawl.notch_angle"), STEIN_WEDGE);
    ck_assert_int_eq(range_of(m, "pawl.stop_shift"), STEIN_ANY);
    ck_assert_int_eq(range_of(m, "pawl.spring.theta0"), STEIN_ANY);
}
END_TEST

/* a value outside of a range, and one in it that is not the file's */
static double outside(stein_range range)
{
    return range == STEIN_POSITIVE ? 0.0 : range == STEIN_WEDGE ? 3.15 : -1e-9;
}

static double inside(stein_range range, double value)
{
    return range == STEIN_WEDGE ? 1.234 : fabs(value) + 0.37;
}

static void refused(stein_status status, const stein_err *why, const stein_param *p)
{
    static const char *const expected[] = {"finite number", "at least 0", "more than 0",
                                           "less than 3.14159"};
    ck_assert_int_eq(status, STEIN_EINVAL);
    ck_assert_msg(strstr(why->msg, p->name) != NULL && strstr(why->msg, expected[p->range]) != NULL,
                  "%s", why->msg);
    ck_assert_msg(strcmp(p->unit, "1") == 0 || strstr(why->msg, p->unit) != NULL, "%s", why->msg);
}

/* set one number by name; then all of them, with that one wrong */
static void refuses(stein_sim *sim, const stein_param *p, int i, double wrong, double *all)
{
    const stein_model *m = stein_sim_model(sim);
    stein_err why = {STEIN_OK, ""};
    double before, after;
    ck_assert_stein(stein_get(sim, p->name, &before, err));
    refused(stein_set(sim, p->name, wrong, &why), &why, p);
    for (int k = 0; k < m->np; k++) {
        all[k] = inside(m->params[k].range, m->params[k].value);
    }
    all[i] = wrong;
    refused(stein_set_all(sim, all, &why), &why, p);
    for (int k = 0; k < m->np; k++) {
        ck_assert_stein(stein_get(sim, m->params[k].name, &after, err));
        ck_assert_msg(k != i ? after == m->params[k].value : after == before, "%s",
                      m->params[k].name);
    }
}

START_TEST(a_value_out_of_range_is_refused_by_name_and_nothing_changes)
{
    static const double no_number[] = {NAN, HUGE_VAL, -HUGE_VAL};
    int ranged = 0;
    for (int k = 0; stein_models[k] != NULL; k++) {
        const stein_model *m = stein_models[k];
        stein_sim *sim = make_sim(m, STEIN_RK4, 0.0);
        double *all = malloc(sizeof *all * (size_t)(m->np + 1));
        ck_assert_ptr_nonnull(all);
        for (int i = 0; i < m->np; i++) {
            const stein_param *p = &m->params[i];
            for (int n = 0; n < 3; n++) {
                refuses(sim, p, i, no_number[n], all);
            }
            if (p->range != STEIN_ANY) {
                refuses(sim, p, i, outside(p->range), all);
                ranged++;
            }
        }
        for (int i = 0; i < m->np; i++) {
            all[i] = inside(m->params[i].range, m->params[i].value);
        }
        ck_assert_stein(stein_set_all(sim, all, err));
        free(all);
        stein_sim_destroy(sim);
    }
    ck_assert_int_gt(ranged, 100);
}
END_TEST

START_TEST(the_least_that_is_allowed_is_taken)
{
    stein_sim *sim = make_sim(&stein_model_stein1788, STEIN_RK4, 0.0);
    ck_assert_stein(stein_set(sim, "string.friction.A", 0.0, err));
    ck_assert_stein(stein_set(sim, "string.friction.vt", 5e-324, err));
    ck_assert_stein(stein_set(sim, "pawl.notch_angle", 3.1415926535897927, err));
    ck_assert_stein(stein_set(sim, "hammer.mass", -0.0, err));
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(a_search_may_try_any_finite_number)
{
    const stein_model *m = &stein_model_stein1788;
    stein_sim *sim = make_sim(m, STEIN_RK4, 0.0);
    double *p = malloc(sizeof *p * (size_t)m->np), back;
    stein_err why;
    ck_assert_ptr_nonnull(p);
    for (int i = 0; i < m->np; i++) {
        p[i] = m->params[i].value;
    }
    int at = stein_find_param(m, "string.friction.A");
    p[at] = -0.013;
    ck_assert_stein(stein_try_all(sim, p, err));
    ck_assert_stein(stein_get(sim, "string.friction.A", &back, err));
    ck_assert(back == -0.013);
    p[at] = NAN;
    ck_assert_int_eq(stein_try_all(sim, p, &why), STEIN_EINVAL);
    ck_assert_ptr_nonnull(strstr(why.msg, "string.friction.A"));
    ck_assert_stein(stein_get(sim, "string.friction.A", &back, err));
    ck_assert(back == -0.013);
    free(p);
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(handed_over_values_are_checked_when_published)
{
    const stein_model *m = &stein_model_stein1788;
    stein_sim *sim = make_sim(m, STEIN_RK4, 0.0);
    stein_handover *h = NULL;
    stein_err why;
    double before, after;
    ck_assert_stein(stein_get(sim, "load.mass", &before, err));
    ck_assert_stein(stein_handover_create(&h, m, NULL, err));
    refused(stein_handover_set(h, "load.mass", -0.1, &why), &why,
            &m->params[stein_find_param(m, "load.mass")]);
    refused(stein_handover_set(h, "string.friction.vt", 0.0, &why), &why,
            &m->params[stein_find_param(m, "string.friction.vt")]);
    stein_handover_publish(h);
    ck_assert_int_eq(stein_handover_take(h, sim), 0);
    ck_assert_stein(stein_get(sim, "load.mass", &after, err));
    ck_assert(after == before);
    stein_handover_destroy(h);
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(a_model_with_a_value_out_of_range_makes_no_simulation)
{
    const stein_model *of = &stein_model_pendulum;
    stein_param *params = malloc(sizeof *params * (size_t)of->np);
    stein_model m = *of;
    stein_sim *sim = NULL;
    stein_err why;
    ck_assert_ptr_nonnull(params);
    memcpy(params, of->params, sizeof *params * (size_t)of->np);
    m.params = params;
    int at = stein_find_param(of, "rod.mass");
    params[at].value = -0.2;
    refused(stein_sim_create(&sim, &m, NULL, &why), &why, &params[at]);
    ck_assert_ptr_null(sim);
    free(params);
}
END_TEST

/* a declared number that stands for a mass and for a speed has to be both; one in a formula is free
 */
START_TEST(a_declared_parameter_has_the_range_of_its_uses)
{
    static const char text[] = "mechanism: m\n"
                               "parameters:\n"
                               "  x.mass: 1 kg\n"
                               "  x.speed: 1 cm/s\n"
                               "  x.length: 3 cm\n"
                               "bodies:\n"
                               "  b:\n"
                               "    joint: T z\n"
                               "    mass: x.mass\n"
                               "    centre: [0, 0, x.length + 2 mm]\n"
                               "    friction: {A: 1 N, vt: x.speed}\n"
                               "    damping: 2 * x.mass / (1 s)\n"
                               "outputs: {z: {joint: b, read: position}}\n";
    mechanism *m = NULL;
    ck_assert_stein(mech_read_text(&m, "m.yaml", text, sizeof text - 1, NULL, 0, NULL, NULL, err));
    static const stein_range expected[] = {STEIN_NOT_NEGATIVE, STEIN_POSITIVE, STEIN_ANY};
    static const char *const name[] = {"x.mass", "x.speed", "x.length"};
    for (int i = 0; i < 3; i++) {
        int at = mech_find_param(m, name[i], NULL);
        ck_assert_int_ge(at, 0);
        ck_assert_int_eq(m->params[at].range, expected[i]);
    }
    mech_free(m);
}
END_TEST

/* the wheel of many vehicle models, slim with the moment of a disc, and one that goes by it */
static const char wheel[] =
    "mechanism: wheels\n"
    "%s"
    "bodies:\n"
    "  wheel: {joint: R y, mass: 15 kg, inertia: {xx: 0.1, yy: 0.8, zz: %s}}\n"
    "  hub: {parent: wheel, joint: R x, mass: 1 kg, inertia: {xx: 0.5 * "
    "wheel.inertia.yy, yy: 0.2, zz: 0.3}}\n";

typedef struct told {
    char text[400];
    int n;
} told;

static void tell(void *ctx, const char *message)
{
    told *t = ctx;
    if (t->n++ == 0) {
        snprintf(t->text, sizeof t->text, "%s", message);
    }
}

static void check_told(const told *t, const char *words)
{
    ck_assert_msg(strstr(t->text, words) != NULL, "%s", t->text);
}

/* @param set  value of an override, NULL: none */
static mechanism *read_wheel(const char *key, const char *zz, const char *set, told *t)
{
    char text[600];
    mech_set given = {"inertia", set};
    mechanism *m = NULL;
    stein_err why;
    *t = (told){.n = 0};
    snprintf(text, sizeof text, wheel, key, zz);
    stein_status status =
        mech_read_text(&m, "w.yaml", text, strlen(text), &given, set != NULL, tell, t, &why);
    ck_assert_int_eq(status, m != NULL ? STEIN_OK : STEIN_EPARSE);
    return m;
}

START_TEST(inertias_that_no_body_has_are_refused_taken_or_balanced)
{
    told t;
    ck_assert_ptr_null(read_wheel("", "0.1", NULL, &t));
    check_told(&t, "w.yaml:3:45: the inertia of wheel is not possible");
    check_told(&t, "expected another one, or inertia: accept or balance");
    ck_assert_ptr_null(read_wheel("inertia: accept\n", "0.1", "refuse", &t));

    mechanism *m = read_wheel("", "0.1", "accept", &t);
    ck_assert_ptr_nonnull(m);
    ck_assert_int_eq(t.n, 1);
    check_told(&t, "the inertia of wheel is accepted");
    ck_assert(m->bodies[0].inertia[1].value == 0.8 && m->bodies[1].inertia[0].value == 0.4);
    mech_free(m);

    m = read_wheel("inertia: balance\n", "0.3", NULL, &t);
    ck_assert_ptr_nonnull(m);
    ck_assert_int_eq(t.n, 1);
    check_told(&t, "balanced: all three moments are 0.4 kg m^2");
    for (int e = 0; e < 3; e++) {
        int i = m->bodies[0].inertia[e].index;
        ck_assert_close(m->params[i].value, 0.4, 1e-15, 0.0);
        ck_assert_close(m->bodies[0].inertia[e].value, 0.4, 1e-15, 0.0);
    }
    ck_assert_close(m->bodies[1].inertia[0].value, 0.2, 1e-15, 0.0); // follows
    mech_free(m);
}
END_TEST

START_TEST(an_impossible_treatment_of_an_inertia_is_reported)
{
    told t;
    ck_assert_ptr_null(read_wheel("inertia: ignore\n", "0.1", NULL, &t));
    check_told(&t, "expected one of refuse accept balance");
    ck_assert_ptr_null(read_wheel("", "0.1", "maybe", &t));
    check_told(&t, "set inertia = \"maybe\"");
    ck_assert_ptr_null(read_wheel("", "0.125 * wheel.inertia.yy", "balance", &t));
    check_told(&t, "has a formula, which cannot be balanced");
    ck_assert_ptr_null(read_wheel("", "-0.1", "accept", &t));
    check_told(&t, "negative");
}
END_TEST

Suite *ranges_suite(void)
{
    Suite *suite = suite_create("ranges");
    TCase *tc = tcase_create("ranges");
    tcase_set_timeout(tc, 60);
    tcase_add_test(tc, equations_contain_the_ranges_of_their_parameters);
    tcase_add_test(tc, a_value_out_of_range_is_refused_by_name_and_nothing_changes);
    tcase_add_test(tc, the_least_that_is_allowed_is_taken);
    tcase_add_test(tc, a_search_may_try_any_finite_number);
    tcase_add_test(tc, handed_over_values_are_checked_when_published);
    tcase_add_test(tc, a_model_with_a_value_out_of_range_makes_no_simulation);
    tcase_add_test(tc, a_declared_parameter_has_the_range_of_its_uses);
    tcase_add_test(tc, inertias_that_no_body_has_are_refused_taken_or_balanced);
    tcase_add_test(tc, an_impossible_treatment_of_an_inertia_is_reported);
    suite_add_tcase(suite, tc);
    return suite;
}
