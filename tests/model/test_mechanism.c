/* SPDX-License-Identifier: MIT
 * test_mechanism.c - the reader of mechanism files: numbers, units, and what a good file becomes.
 * Refusals are in
 * test_refusals.c, broken files in test_hostile.c.
 */
#include <locale.h>
#include <stdlib.h>
#include <string.h>

#include "mechanism_cases.h"
#include "stein/model.h"

void refusal_cases(Suite *suite);
void hostile_cases(Suite *suite);

static const double pi = 3.14159265358979323846;

static double number(const mechanism *m, const char *name)
{
    int i = mech_find_param(m, name, NULL);

    ck_assert_msg(i >= 0, "no parameter %s", name);
    return m->params[i].value;
}

/* ---- quantities ---- */

typedef struct quantity_case {
    const char *text, *unit;
    double value; /* [SI] */
} quantity_case;

static const quantity_case quantities[] = {
    {"82 g", "kg", 0.082},
    {"7.2 mm", "m", 0.0072},
    {"0.0072", "m", 0.0072},
    {"-1.25mm", "m", -0.00125},
    {"+3.7 kN/m", "N/m", 3700.0},
    {"5e3 N/m", "N/m", 5e3},
    {"4.13e-2 N m/rad", "N m/rad", 0.0413},
    {"4.13e-2 N m", "N m/rad", 0.0413},
    {"41.3 mN*m", "N m/rad", 0.0413},
    {"5.17e2 g m^2", "kg m^2", 0.517},
    {"3.3 1/m", "1/m", 3.3},
    {"3.3 /m", "1/m", 3.3},
    {"0.3 s m^-1", "s/m", 0.3},
    {"7 N/mm^2", "N/m^2", 7e6},
    {"1.7 kHz", "Hz", 1700.0},
    {"90 deg", "rad", 1.5707963267948966},
    {"180 deg/s", "rad/s", 3.141592653589793},
    {"12.5 %", "1", 0.125},
    {".5", "1", 0.5},
    {"2.E-1", "1", 0.2},
    {" 3 ", "kg", 3.0},
    {"2.2250738585072014e-308", "1", 2.2250738585072014e-308},
    {"1.7976931348623157e308", "1", 1.7976931348623157e308},
    {"9007199254740993", "1", 9007199254740992.0},
    {"0e99999", "m", 0.0},
    {"101.325 kPa", "Pa", 101325.0},
    {"9.81 N s^2/kg/s^2", "m/s^2", 9.81},
    {"50 mN m/A", "N m/A", 0.05},
    {"0.05 V s", "N m/A", 0.05},
    {"0.05 V s/rad", "V s/rad", 0.05},
    {"12 V/mA", "ohm", 12000.0},
    {"470 mohm", "V/A", 0.47},
    {"24 V * A", "J/s", 24.0},
};

static mech_dim dim_of(const char *unit)
{
    mech_dim dim = {.kg = 0};

    ck_assert_msg(mech_parse_unit(unit, &dim, NULL) == 0, "%s", unit);
    return dim;
}

static void check_quantities(void)
{
    for (size_t i = 0; i < sizeof quantities / sizeof quantities[0]; i++) {
        const quantity_case *c = &quantities[i];
        double value = 0.0;
        stein_err err = {STEIN_OK, ""};

        ck_assert_msg(mech_parse_quantity(c->text, dim_of(c->unit), &value, &err) == STEIN_OK, "%s",
                      err.msg);
        ck_assert_msg(value == c->value, "%s = %.17g, expected %.17g", c->text, value, c->value);
    }
}

START_TEST(a_unit_gives_the_same_bits_as_the_number_in_si)
{
    check_quantities();
}
END_TEST

START_TEST(a_german_locale_changes_no_number)
{
    static const char *const names[] = {"de_DE.UTF-8", "de_DE.utf8", "de_DE", "fr_FR.UTF-8"};
    const char *set = NULL;

    for (size_t i = 0; !set && i < sizeof names / sizeof names[0]; i++) {
        set = setlocale(LC_ALL, names[i]);
    }
    check_quantities();
    mechanism *m = read_ok(good, NULL, 0);
    ck_assert(number(m, "hammer.mass") == 0.00331); /* parsed by the compiler */
    mech_free(m);
    setlocale(LC_ALL, "C");
}
END_TEST

START_TEST(values_without_the_expected_unit_are_refused)
{
    static const struct {
        const char *text, *unit, *words;
    } wrong[] = {
        {"8,2e-2", "kg", "decimal point"},
        {"0x1p3", "1", "hexadecimal"},
        {"nan", "m", "finite"},
        {"-inf", "m", "finite"},
        {".inf", "m", "finite"},
        {"", "m", "expected a number"},
        {"--3 m", "m", "expected a number"},
        {"3 m m m extra", "m^3", "unknown unit \"extra\""},
        {"3 m; 4 m", "m", "unexpected text"},
        {"1e309", "m", "too large"},
        {"1e308 km", "m", "too large"},
        {"1e-400", "m", "too small"},
        {"4.9e-324", "m", "too small"},
        {"3 mm", "kg", "the unit is m, expected kg"},
        {"3 N m rad", "N m/rad", "the unit is"},
        {"0.3 rad", "1", "expected a pure number"},
        {"3 %", "m", "the unit is %"},
        {"3 %", "rad", "the unit is %"},
        {"4 Nm", "N m", "did you mean \"N m\"?"},
        {"4 Nms", "N m s", "did you mean \"N m s\"?"},
        {"4 mNms/rad", "N m s/rad", "did you mean \"mN m s/rad\"?"},
        {"4 Nmm", "N m", "did you mean \"N mm\"?"},
        {"4 kgm^2", "kg m^2", "did you mean \"kg m^2\"?"},
        {"4 kgm2", "kg m^2", "did you mean \"kg m^2\"?"},
        {"4 kg cm2", "kg m^2", "did you mean \"kg cm^2\"?"},
        {"4 m/s2", "m/s^2", "did you mean \"m/s^2\"?"},
        {"4 rad/Nm", "rad/N/m", "did you mean \"rad/N/m\"?"},
        {"4 Ohm", "ohm", "did you mean \"ohm\"?"},
        {"4 V", "J", "the unit is V, expected"},
        {"4 ohm", "V/A^2", "the unit is ohm, expected"},
        {"4 KG", "kg", "did you mean \"kg\"?"},
        {"220 gg", "kg", "did you mean \"g\"?"},
        {"3 mmm", "m", "did you mean \"mm\"?"},
        {"4 furlong", "m", "unknown unit \"furlong\", expected one of"},
        {"4 m^x", "m", "whole number"},
        {"4 m^99", "m", "too large"},
        {"4 N/m s", "N s/m", "ambiguous"},
        {"1234567890123456789012345678901234567890123456789012345678901", "m", "digits"},
    };

    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        double value = 4.75;
        stein_err err = {STEIN_OK, ""};

        ck_assert_msg(mech_parse_quantity(wrong[i].text, dim_of(wrong[i].unit), &value, &err) ==
                          STEIN_EPARSE,
                      "accepted: %s", wrong[i].text);
        ck_assert_msg(strstr(err.msg, wrong[i].words) != NULL, "%s, expected \"%s\"", err.msg,
                      wrong[i].words);
        ck_assert(value == 4.75);
        ck_assert_int_eq(mech_parse_quantity(wrong[i].text, dim_of(wrong[i].unit), &value, NULL),
                         STEIN_EPARSE);
    }
}
END_TEST

START_TEST(a_unit_text_gives_dimension_and_factor)
{
    mech_dim dim = {9, 9, 9, 9, 9};
    double factor = 0.0;

    ck_assert_int_eq(mech_parse_unit("mN mm/deg", &dim, &factor), 0);
    ck_assert(dim.kg == 1 && dim.m == 2 && dim.s == -2 && dim.rad == -1);
    ck_assert_close(factor, 1e-6 * 180.0 / pi, 1e-15, 0.0);
    ck_assert_int_eq(mech_parse_unit("1", &dim, &factor), 0);
    ck_assert(factor == 1.0 && dim.kg == 0 && dim.rad == 0);
    ck_assert_int_eq(mech_parse_unit("%", &dim, &factor), 0);
    ck_assert(factor == 0.01);
    static const char *const none[] = {"", "furlong", "N/", "m^", "2 m", "m)", "N/m s"};
    for (size_t i = 0; i < sizeof none / sizeof none[0]; i++) {
        ck_assert_int_eq(mech_parse_unit(none[i], &dim, &factor), -1);
    }
    ck_assert(factor == 0.01); /* untouched */
}
END_TEST

/* ---- what a good file becomes ---- */

START_TEST(parents_come_first_and_references_are_indices)
{
    mechanism *m = read_ok(good, NULL, 0);
    static const char *const order[] = {"key", "hammer", "pawl", "load"};

    ck_assert_str_eq(m->name, "demo");
    ck_assert_str_eq(m->file, "demo.yaml");
    ck_assert_int_eq(m->nbody, 4);
    for (int i = 0; i < 4; i++) {
        ck_assert_str_eq(m->bodies[i].name, order[i]);
    }
    ck_assert_int_eq(m->bodies[1].parent, 0);
    ck_assert(m->bodies[1].type == 'R' && m->bodies[1].axis == 'y' && m->bodies[1].sign == -1);
    ck_assert_int_eq(m->stroke_string, 0);
    ck_assert_int_eq(m->stroke_notch, 0);
    ck_assert_int_eq(m->links[0].point[0], m->npoint - 1);
    ck_assert_str_eq(m->points[m->links[0].point[1]].name, "key.front");
    ck_assert_int_eq(m->notches[0].catcher, 2);
    ck_assert_int_eq(m->notches[0].beak, 1);
    ck_assert(m->inputs[1].kind == STEIN_INPUT_MOTION && m->inputs[1].hold == 1);
    ck_assert(m->channels[1].read == STEIN_READ_VZ && m->channels[1].sign == -1);
    ck_assert_int_eq(m->channels[1].from_rest, 1);
    ck_assert_str_eq(m->channels[1].unit, "m/s");
    ck_assert_str_eq(m->channels[2].unit, "N m");
    ck_assert(m->integrator == 1 && m->settle == 1 && m->dt == 13e-6 && m->until == 0.29);
    mech_free(m);
}
END_TEST

START_TEST(a_literal_zero_of_the_geometry_vanishes_and_one_of_a_law_stays)
{
    mechanism *m = read_ok(good, NULL, 0);

    ck_assert_int_eq(m->gravity[0].kind, MECH_ZERO);
    ck_assert_int_eq(m->bodies[0].centre[1].kind, MECH_ZERO);
    ck_assert_int_eq(m->bodies[2].mass.kind, MECH_PARAM);
    ck_assert_int_eq(m->bodies[2].inertia[0].kind, MECH_ZERO); /* absent */
    ck_assert_int_eq(mech_find_param(m, "key.centre.y", NULL), -1);
    ck_assert(number(m, "string.normal.c") == 0.0);
    ck_assert(number(m, "key.friction.B1") == 0.0 && number(m, "key.friction.B2") == 1.0);
    ck_assert(number(m, "pawl.initial.position") == 0.0);
    ck_assert(number(m, "notch.corner.lean") == 0.0);
    ck_assert(number(m, "stop.line.z") == 0.0);
    ck_assert(number(m, "tie.damping") == 0.0);
    mech_free(m);
}
END_TEST

START_TEST(parameters_know_unit_tolerance_and_place)
{
    mechanism *m = read_ok(good, NULL, 0);
    const mech_param *p = &m->params[mech_find_param(m, "key.mass", NULL)];
    const char *suggestion = NULL;

    ck_assert_str_eq(p->unit, "kg");
    ck_assert(p->value == 0.0713 && p->declared == 0);
    ck_assert_close(p->tolerance, 0.02 * 0.0713, 1e-15, 0.0);
    ck_assert(p->line == 18 && p->column == 11);
    p = &m->params[mech_find_param(m, "string.height", NULL)];
    ck_assert(p->declared == 1 && p->tolerance == 0.0002 && strcmp(p->unit, "m") == 0);
    p = &m->params[mech_find_param(m, "string.normal.a", NULL)];
    ck_assert_str_eq(p->unit, "N/m^3");
    ck_assert_int_eq(mech_find_param(m, "key.mas", &suggestion), -1);
    ck_assert_str_eq(suggestion, "key.mass");
    ck_assert_int_eq(mech_find_param(m, "no.such.thing", &suggestion), -1);
    ck_assert_ptr_null(suggestion);
    mech_free(m);
}
END_TEST

START_TEST(a_formula_follows_the_parameters_it_is_made_of)
{
    mechanism *m = read_ok(good, NULL, 0);
    mech_scalar x = m->contacts[1].spot[0].side[1].at[0];
    double p[200] = {0.0};

    ck_assert_int_eq(x.kind, MECH_FORMULA);
    ck_assert_close(x.value, -0.121 + 0.00031, 1e-15, 0.0);
    ck_assert_str_eq(m->formulas[x.index].name, "stop.line.x");
    ck_assert_str_eq(m->formulas[x.index].text, "-121 mm + pawl.stop_shift");
    p[mech_find_param(m, "pawl.stop_shift", NULL)] = -0.0127;
    ck_assert_close(mech_value(m, x, p), -0.121 - 0.0127, 1e-15, 0.0);
    ck_assert(mech_value(m, (mech_scalar){MECH_ZERO, 0, 0.0}, p) == 0.0);

    /* a reference alone is the parameter itself */
    mech_scalar z = m->contacts[0].spot[0].side[1].at[2];
    ck_assert_int_eq(z.kind, MECH_PARAM);
    ck_assert_str_eq(m->params[z.index].name, "string.height");
    mech_free(m);

    /* what is shown of a formula is one line with single blanks */
    char *text = changed("radius: 1.9 mm}", "radius: \"string.height \\t*\\n 2\"}");
    m = read_ok(text, NULL, 0);
    x = m->contacts[1].spot[0].side[0].radius;
    ck_assert_str_eq(m->formulas[x.index].text, "string.height * 2");
    mech_free(m);
    free(text);
}
END_TEST

START_TEST(formulas_compute_with_units_functions_and_each_other)
{
    const struct {
        const char *text;
        double value;
    } cases[] = {
        {"2 * (string.height - 3 mm) / 4", 2.0 * (0.0437 - 0.003) / 4.0},
        {"0 + string.height", 0.0437},
        {"string.height * sin(30 deg + key.initial.position)", 0.0437 * 0.5},
        {"sqrt(string.height * pawl.stop_shift)", sqrt(0.0437 * 0.00031)},
        {"cos(0.3) * 1 m - tan(0.2 rad) * 1 m", cos(0.3) - tan(0.2)},
        {"key.front.x - hammer.beak.x", 0.177 + 0.0119},
        {"-stop.line.x + 1 mm", 0.121 - 0.00031 + 0.001},
        {"1 m * tie.k / 31 N * 1 m", 3.0},
        {"2 * 3 mm - 1mm", 0.005},
        {"hammer.centre.y - -2 mm", 0.002},
        {"pawl.spring.k / 1 N", 0.0413},
        {"1 mm + sin(0) * string.height + cos(0) * 2 mm", 0.003},
        {"\"string.height\\t*\\n2\"", 0.0874},
    };

    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char to[120];

        snprintf(to, sizeof to, "radius: %s}", cases[i].text);
        char *text = changed("radius: 1.9 mm}", to);
        mechanism *m = read_ok(text, NULL, 0);
        ck_assert_close(m->contacts[1].spot[0].side[0].radius.value, cases[i].value, 1e-9, 0.0);
        mech_free(m);
        free(text);
    }
}
END_TEST

START_TEST(a_formula_needs_no_more_stack_than_its_reader_has)
{
    char *fits = changed("radius: 1.9 mm}", "radius: 1 mm*(1-(1-(1-(1-(1-(1-(1-(1-(1-(1-(1-(1-(1-"
                                            "key.mass/1kg)))))))))))))}");
    mechanism *m = read_ok(fits, NULL, 0);
    double p[200] = {0.0};

    p[mech_find_param(m, "key.mass", NULL)] = 0.375;
    ck_assert_close(mech_value(m, m->contacts[1].spot[0].side[0].radius, p), 0.625e-3, 1e-14, 0.0);
    mech_free(m);
    free(fits);
}
END_TEST

START_TEST(the_load_is_a_body_and_a_contact)
{
    mechanism *m = read_ok(good, NULL, 0);
    const mech_body *b = &m->bodies[m->load_body];
    const mech_contact *c = &m->contacts[m->load_contact];

    ck_assert(strcmp(b->name, "load") == 0 && strcmp(c->name, "load") == 0);
    ck_assert(b->parent == -1 && b->type == 'T' && b->axis == 'z' && b->sign == 1);
    ck_assert(b->at[0].kind == MECH_ZERO && b->at[2].kind == MECH_ZERO);
    ck_assert_str_eq(m->params[b->q0.index].name, "load.initial.position");
    ck_assert_int_eq(c->nspot, 1);
    ck_assert_int_eq(c->spot[0].side[0].body, 0);
    ck_assert_str_eq(m->params[c->spot[0].side[0].at[0].index].name, "key.front.x");
    ck_assert_int_eq(c->spot[0].side[1].body, m->load_body);
    ck_assert(c->spot[0].side[1].is_line == 1 && c->spot[0].side[1].has_extent == 0);
    ck_assert_close(c->spot[0].side[1].facing.value, -pi / 2.0, 1e-15, 0.0);
    ck_assert(number(m, "load.mass") == 0.097 && number(m, "load.normal.c") == 2.61e4);
    mech_free(m);
}
END_TEST

START_TEST(a_point_comes_before_the_line_it_touches)
{
    mechanism *m = read_ok(good, NULL, 0);
    const mech_spot *stop = &m->contacts[1].spot[0]; /* the file names the line first */

    ck_assert(stop->side[0].is_line == 0 && stop->side[1].is_line == 1);
    ck_assert_str_eq(m->params[stop->side[0].radius.index].name, "stop.circle.radius");
    ck_assert_int_eq(m->contacts[0].spot[0].side[0].radius.kind, MECH_ZERO);
    mech_free(m);
}
END_TEST

START_TEST(a_name_is_reserved_only_where_it_means_something)
{
    static const char text[] = "mechanism: cart\nbodies:\n"
                               "  load: {joint: T +x, mass: 1.3 kg}\n"
                               "  key: {joint: R y, inertia: {yy: 0.2 kg m^2}}\n"
                               "inputs: {push: {motion: load}, turn: {motion: key}}\n";
    mechanism *m = read_ok(text, NULL, 0);
    ck_assert_str_eq(m->bodies[0].name, "load");
    ck_assert_int_eq(m->load_body, -1);
    ck_assert(m->bodies[0].sign == 1 && m->bodies[0].axis == 'x');
    ck_assert_int_eq(m->ninput, 2);
    ck_assert(m->inputs[0].index == 0 && m->inputs[1].index == 1);
    mech_free(m);
}
END_TEST

START_TEST(a_contact_may_have_a_constant_force_alone)
{
    char *text = changed("normal: {c: 1.57e3 N/m}", "normal: {F0: 1.3 N}");
    mechanism *m = read_ok(text, NULL, 0);
    ck_assert(number(m, "stop.normal.F0") == 1.3);
    mech_free(m);
    free(text);
}
END_TEST

START_TEST(a_line_touches_a_line_with_both_ends)
{
    char *text = changed("{circle: {at: pawl.back, radius: 1.9 mm}}",
                         "{line: {at: pawl.back, facing: 3 deg, extent: [-7 mm, 0]}}");
    char *first = strstr(text, "facing: 180 deg}}");
    mechanism *m = NULL;

    memcpy(first, "facing: 0,extent:", 17); /* same length: the first line gets one, too */
    char *whole = malloc(strlen(text) + 32);
    sprintf(whole, "%.*s [-3 mm, 9 mm]}}%s", (int)(first + 17 - text), text, first + 17);
    m = read_ok(whole, NULL, 0);
    const mech_contact *c = &m->contacts[1];
    ck_assert_int_eq(c->nspot, 2);
    for (int i = 0; i < 2; i++) {
        ck_assert(c->spot[i].side[0].is_line == 1 && c->spot[i].side[0].end == 2 * i - 1);
        ck_assert(c->spot[i].side[1].is_line == 1 && c->spot[i].side[1].end == 0);
        ck_assert_int_eq(c->spot[i].side[1].body, 2);
    }
    ck_assert(number(m, "stop.line.extent.hi") == 0.009);
    ck_assert(number(m, "stop.line2.extent.lo") == -0.007);
    ck_assert(number(m, "stop.line2.extent.hi") == 0.0);
    mech_free(m);
    free(text);
    free(whole);
}
END_TEST

START_TEST(a_swing_on_the_joint_gives_the_inertia)
{
    char *text = changed("inertia: {yy: 3.17e-6 kg m^2}", "pendulum: {frequency: 1.43 Hz}");
    mechanism *m = read_ok(text, NULL, 0);
    mech_scalar yy = m->bodies[1].inertia[1];
    double mass = 0.00331, d = hypot(0.0573, 0.0029), w = 2.0 * pi * 1.43, p[200];

    ck_assert_int_eq(yy.kind, MECH_FORMULA);
    ck_assert_close(yy.value, mass * 9.81 * d / (w * w) - mass * d * d, 1e-12, 0.0);
    for (int i = 0; i < m->nparam; i++) {
        p[i] = m->params[i].value;
    }
    p[mech_find_param(m, "hammer.mass", NULL)] *= 2.0;
    ck_assert_close(mech_value(m, yy, p), 2.0 * yy.value, 1e-14, 0.0);
    mech_free(m);
    free(text);
}
END_TEST

/* ---- overrides ---- */

START_TEST(an_override_replaces_the_number_of_the_file)
{
    mech_set set[] = {{"hammer.mass", "3.9g"},
                      {"pawl.stop_shift", "-0.00021"},
                      {"string.height", "44.1 mm +- 0.3 mm"},
                      {"hammer.mass", "4.07 g"}}; /* the last one counts */
    mechanism *m = read_ok(good, set, 4), *plain = read_ok(good, NULL, 0);

    ck_assert(number(m, "hammer.mass") == 0.00407);
    ck_assert(number(m, "pawl.stop_shift") == -0.00021);
    ck_assert(m->params[mech_find_param(m, "string.height", NULL)].tolerance == 0.0003);
    ck_assert_int_eq(m->nparam, plain->nparam);
    ck_assert_str_eq(m->input_hash, plain->input_hash);
    mech_free(m);
    mech_free(plain);
}
END_TEST

START_TEST(an_override_of_a_structural_zero_makes_a_parameter_and_back)
{
    mech_set grow[] = {{"hammer.centre.y", "1.3 mm"}, {"pawl.inertia.xx", "1e-6"}};
    mech_set vanish[] = {{"hammer.centre.z", "0 mm"}, {"pawl.damping", "3e-6"}};
    mechanism *m = read_ok(good, grow, 2);

    ck_assert(number(m, "hammer.centre.y") == 0.0013);
    ck_assert_int_eq(m->bodies[2].inertia[0].kind, MECH_PARAM);
    mech_free(m);
    m = read_ok(good, vanish, 2);
    ck_assert_int_eq(m->bodies[1].centre[2].kind, MECH_ZERO);
    ck_assert(m->bodies[2].joint[STEIN_JOINT_B].value != 0.0); /* absent from the file */
    mech_free(m);
}
END_TEST

START_TEST(every_effect_is_a_parameter_that_does_nothing_until_it_is_stated)
{
    static const struct {
        const char *path, *set;
        double neutral;
    } effect[] = {{"pawl.spring.k3", "0.23 N m/rad^3", 0.0},
                  {"key.drag", "3e-6", 0.0},
                  {"key.preload", "1.3 mN m", 0.0},
                  {"key.coulomb.T", "2 mN m", 0.0},
                  {"key.backlash.gap", "0.3 deg", 0.0},
                  {"string.normal.p", "0.21", 0.0},
                  {"string.normal.h", "0.11", 0.0},
                  {"string.gap", "0.2 mm", 0.0},
                  {"string.adhesion.F", "0.3 N", 0.0},
                  {"notch.gap", "10 um", 0.0},
                  {"distance.sensor.gain", "1.02", 1.0},
                  {"distance.sensor.square", "2 1/m", 0.0},
                  {"clock.error", "0.1 %", 0.0}};
    mechanism *plain = read_ok(good, NULL, 0);
    for (size_t i = 0; i < sizeof effect / sizeof *effect; i++) {
        int at = mech_find_param(plain, effect[i].path, NULL);
        ck_assert_msg(at >= 0, "%s", effect[i].path);
        ck_assert(plain->params[at].value == effect[i].neutral && !plain->params[at].stated);
        mech_set set = {effect[i].path, effect[i].set};
        mechanism *m = read_ok(good, &set, 1);
        ck_assert(m->params[at].value != effect[i].neutral && m->params[at].stated);
        ck_assert_int_eq(m->nparam, plain->nparam);
        mech_free(m);
    }
    mech_free(plain);
}
END_TEST

/* ---- files ---- */

START_TEST(the_same_file_gives_the_same_hash_and_another_one_another)
{
    mechanism *m = NULL;
    char *text = changed("3.31 g", "3.32 g");

    m = read_ok("mechanism: a\nbodies: {b: {joint: T z, mass: 1}}\n", NULL, 0);
    ck_assert_str_eq(m->input_hash, "55ea57e58a43242c");
    mech_free(m);
    mechanism *a = read_ok(good, NULL, 0), *b = read_ok(text, NULL, 0);
    ck_assert_str_ne(a->input_hash, b->input_hash);
    mech_free(a);
    mech_free(b);
    free(text);
}
END_TEST

START_TEST(the_regulation_names_parameters_with_their_ranges)
{
    char *text = changed("stroke:", "regulation:\n"
                                    "  about: for the technician\n"
                                    "  pawl.stop_shift: {from: -1.3 mm, to: 0.37 mm, label: stop}\n"
                                    "  notch.corner.angle: {from: 71 deg, to: 2}\n"
                                    "stroke:");
    mechanism *m = read_ok(text, NULL, 0);

    ck_assert_int_eq(m->ndial, 2);
    ck_assert_int_eq(m->dials[0].param, mech_find_param(m, "pawl.stop_shift", NULL));
    ck_assert_double_eq(m->dials[0].from, -1.3e-3);
    ck_assert_double_eq(m->dials[0].to, 0.37e-3);
    ck_assert_str_eq(m->dials[0].label, "stop");
    ck_assert_close(m->dials[1].from, 71.0 * acos(-1.0) / 180.0, 1e-15, 0.0);
    ck_assert_double_eq(m->dials[1].to, 2.0);
    ck_assert_str_eq(m->dials[1].label, "notch.corner.angle");
    mech_free(m);
    free(text);
}
END_TEST

START_TEST(texts_of_the_file_are_kept)
{
    mechanism *m = read_ok(good, NULL, 0);

    ck_assert_int_eq(m->nabout, 2);
    ck_assert_str_eq(m->abouts[0].section, "parameters");
    ck_assert_str_eq(m->abouts[0].entry, "string.height");
    ck_assert_str_eq(m->abouts[0].text, "over the rest");
    ck_assert_str_eq(m->abouts[1].section, "bodies");
    ck_assert_str_eq(m->abouts[1].entry, "key");
    ck_assert_str_eq(m->abouts[1].text, "the lever");
    ck_assert_int_eq(m->ndial, 0);
    mech_free(m);
}
END_TEST

START_TEST(absent_sections_have_defaults)
{
    mechanism *m = read_ok("mechanism: a\nbodies: {b: {joint: T -z, mass: 1.7}}\n", NULL, 0);

    ck_assert(number(m, "gravity.z") == -9.81);
    ck_assert(m->dt == 1e-5 && m->until == 1.0 && m->integrator == 2 && m->settle == 0);
    ck_assert(m->load_body == -1 && m->load_contact == -1);
    ck_assert(m->stroke_string == -1 && m->stroke_notch == -1);
    ck_assert(m->bodies[0].type == 'T' && m->bodies[0].sign == -1);
    mech_free(m);
}
END_TEST

START_TEST(a_file_that_cannot_be_read_is_an_error_of_its_own)
{
    mechanism *m = NULL;
    stein_err err = {STEIN_OK, ""};

    ck_assert_int_eq(mech_read(&m, "no/such/file.yaml", NULL, 0, NULL, NULL, &err), STEIN_EIO);
    ck_assert(strstr(err.msg, "no/such/file.yaml") != NULL && err.code == STEIN_EIO);
    ck_assert_int_eq(mech_read(&m, ".", NULL, 0, NULL, NULL, NULL), STEIN_EIO);
    ck_assert_ptr_null(m);
}
END_TEST

START_TEST(every_model_of_the_project_is_valid)
{
    static const char *const files[] = {"pendulum",       "double_pendulum", "bouncing_ball",
                                        "block_on_slope", "newtons_cradle",  "stein1788"};

    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        char path[60];
        mechanism *m = NULL;

        snprintf(path, sizeof path, "models/%s.yaml", files[i]);
        ck_assert_stein(mech_read(&m, path, NULL, 0, NULL, NULL, err));
        ck_assert_str_eq(m->name, files[i]);
        ck_assert_str_eq(m->file, path);
        mech_free(m);
    }
    mech_free(NULL);
}
END_TEST

Suite *mechanism_suite(void)
{
    Suite *suite = suite_create("mechanism");
    TCase *tc = tcase_create("mechanism");
    tcase_set_timeout(tc, 30.0);
    tcase_add_test(tc, a_unit_gives_the_same_bits_as_the_number_in_si);
    tcase_add_test(tc, a_german_locale_changes_no_number);
    tcase_add_test(tc, values_without_the_expected_unit_are_refused);
    tcase_add_test(tc, a_unit_text_gives_dimension_and_factor);
    tcase_add_test(tc, parents_come_first_and_references_are_indices);
    tcase_add_test(tc, a_literal_zero_of_the_geometry_vanishes_and_one_of_a_law_stays);
    tcase_add_test(tc, parameters_know_unit_tolerance_and_place);
    tcase_add_test(tc, a_formula_follows_the_parameters_it_is_made_of);
    tcase_add_test(tc, formulas_compute_with_units_functions_and_each_other);
    tcase_add_test(tc, a_formula_needs_no_more_stack_than_its_reader_has);
    tcase_add_test(tc, the_load_is_a_body_and_a_contact);
    tcase_add_test(tc, a_point_comes_before_the_line_it_touches);
    tcase_add_test(tc, a_name_is_reserved_only_where_it_means_something);
    tcase_add_test(tc, a_contact_may_have_a_constant_force_alone);
    tcase_add_test(tc, a_line_touches_a_line_with_both_ends);
    tcase_add_test(tc, a_swing_on_the_joint_gives_the_inertia);
    tcase_add_test(tc, an_override_replaces_the_number_of_the_file);
    tcase_add_test(tc, every_effect_is_a_parameter_that_does_nothing_until_it_is_stated);
    tcase_add_test(tc, an_override_of_a_structural_zero_makes_a_parameter_and_back);
    tcase_add_test(tc, the_same_file_gives_the_same_hash_and_another_one_another);
    tcase_add_test(tc, the_regulation_names_parameters_with_their_ranges);
    tcase_add_test(tc, texts_of_the_file_are_kept);
    tcase_add_test(tc, absent_sections_have_defaults);
    tcase_add_test(tc, a_file_that_cannot_be_read_is_an_error_of_its_own);
    tcase_add_test(tc, every_model_of_the_project_is_valid);
    suite_add_tcase(suite, tc);
    refusal_cases(suite);
    hostile_cases(suite);
    return suite;
}
