/* SPDX-License-Identifier: MIT
 * test_refusals.c - every refusal of the mechanism reader, by the place and the words of its
 * message.
 *
 * Tables of changes to one good file. Every change must give exactly one problem, at the line and
 * column of a given piece of the changed text. So no mistake is reported twice.
 */
#include <stdlib.h>
#include <string.h>

#include "mechanism_cases.h"

void refusal_cases(Suite *suite);

START_TEST(an_unknown_key_is_named_with_the_one_that_was_meant)
{
    static const refusal r[] = {
        {"gravity:", "gravty:", "gravty",
         "unknown key \"gravty\" in the file, did you mean "
         "\"gravity\"?"},
        {"    mass: 3.9 g\n", "    mass: 3.9 g\n    mas: 3.9 g\n", "mas: 3.9",
         "unknown key \"mas\" in a body, did you mean \"mass\"?"},
        {"    mass: 3.9 g\n", "    mass: 3.9 g\n    colour: red\n", "colour",
         "unknown key \"colour\" in a body, expected one of parent part_of joint at"},
        {"vt: 11 mm/s}", "vt: 11 mm/s, b1: 2}", "b1: 2", "in friction|did you mean \"B1\"?"},
        {"theta0: -0.347 rad}", "x0: -0.347 rad}", "x0: -0.347",
         "the spring of a turning joint|theta0"},
        {"idle: hold", "ide: hold", "ide: hold", "in an input|did you mean \"idle\"?"},
        {"facing: 180 deg}", "facing: 180 deg, extend: [0, 1]}", "extend",
         "in a line|did you mean \"extent\"?"},
        {"settle: yes", "settel: yes", "settel", "in simulation|did you mean \"settle\"?"},
        {"about: over", "abuot: over", "abuot", "in a parameter"},
        {"gravity:", "a_name_that_is_much_too_long_to_be_meant_as_any_of_the_keys_of_a_file:",
         "a_name_that", "unknown key \"a_name_that_is_much_too_long"},
    };

    REFUSE_ALL(r);
}
END_TEST

START_TEST(a_missing_key_is_named_at_its_mapping)
{
    static const refusal r[] = {
        {"mechanism: demo\n", "", "gravity", "the file lacks \"mechanism\""},
        {"{k: 0.0413 N m/rad, theta0: -0.347 rad}", "{theta0: 1}", "spring: {theta0",
         "the spring of a turning joint lacks \"k\""},
        {"  pawl:\n    joint: R -y\n", "  pawl:\n", "pawl:\n", "a body lacks \"joint\""},
        {"  pawl:\n    joint: R -y\n", "  pawl:\n    preload: 1 N\n", "pawl:\n",
         "a body lacks \"joint\""}, // its unit is not known then
        {", length: 0.127 m", "", "tie:", "a link lacks \"length\""},
        {", k: 93 N/m", "", "tie:", "a link lacks \"k\""},
        {"from: frame.anchor, ", "", "tie:", "a link lacks \"from\""},
        {", radius: 1.9 mm", "", "circle:", "a circle lacks \"radius\""},
        {", facing: -90 deg", "", "line: {on: frame, at: [0, 0, s", "a line lacks \"facing\""},
        {"on: frame, at: [0, 0, s", "at: [0, 0, s", "line: {at", "a line lacks \"on\""},
        {"at: [0, 0, string.height], ", "", "line: {on", "a line lacks \"at\""},
        {", angle: 89 deg", "", "corner: {at", "corner lacks \"angle\""},
        {"    corner: {at: pawl.corner, angle: 89 deg}\n", "", "notch:\n    beak",
         "a notch lacks \"corner\""},
        {", vt: 11 mm/s", "", "friction: {A: 0.23", "friction lacks \"vt\""},
        {"A: 0.23, ", "", "friction: {vt", "friction lacks \"A\""},
        {"    normal: {c: 1.57e3 N/m}\n", "", "stop:\n", "a contact lacks \"normal\""},
        {"{a: 6.7e11 N/m^3, b: 2.9e7 N/m^2}", "{D: 0.3 s/m}", "normal: {D",
         "at least one of a, b and c"},
        {"    normal: {c: 1.57e3 N/m}\n", "    normal: 1.57e3 N/m\n", "1.57e3 N/m",
         "normal must be a mapping with the keys a b c D"},
        {"mass: 97 g, ", "", "load:", "the load lacks \"mass\""},
        {"on: key.front, ", "", "load:", "the load lacks \"on\""},
        {", direction: [0, 0, -1]", "", "finger:", "a force input lacks \"direction\""},
        {"read: gap", "sign: 1", "distance:", "an output lacks \"read\""},
        {"{string: string, notch: notch}", "{notch: notch}", "stroke:", "stroke lacks \"string\""},
    };

    REFUSE_ALL(r);
    static const char none[] = "mechanism: demo\n";
    refuse_text(none, sizeof none - 1, NULL, 0, "mechanism", "the mechanism lacks \"bodies\"");
    static const char empty[] = "mechanism: demo\nbodies: {}\n";
    refuse_text(empty, sizeof empty - 1, NULL, 0, "bodies", "at least one body");
}
END_TEST

START_TEST(a_number_of_the_wrong_kind_is_refused)
{
    static const refusal r[] = {
        {"3.9 g", "3.9 mm", "3.9 mm", "pawl.mass = \"3.9 mm\": the unit is m, expected kg"},
        {"3.9 g", "8,2e-2", ",2e-2", "write a decimal point"},
        {"3.9 g", ".nan", ".nan", "finite"},
        {"3.9 g", "inf", "inf", "finite"},
        {"3.9 g", "1e999", "1e999", "too large"},
        {"3.9 g", "1e-999", "1e-999", "too small"},
        {"3.9 g", "0x1f", "0x1f", "hexadecimal"},
        {"3.9 g", "0X1f", "0X1f", "hexadecimal"},
        {"3.9 g", "1e99999", "1e99999", "too large"},
        {"3.9 g", "\"3.9 kgg\"", "\"3.9 kgg\"", "unknown unit \"kgg\""},
        {"A: 0.23", "A: 1 rad^11 rad^11", "rad^11, vt", "the powers of the unit are too large"},
        {"radius: 1.9 mm", "radius: +- 1.9 mm", "+- 1.9", "expected a"},
        {"3.9 g", "3.9 g heavy", "heavy", "unknown unit \"heavy\""},
        {"3.9 g", "3.9 g 7", "7\n    inertia: {yy: 4.1", "unexpected text"},
        {"3.9 g", "3.9 kgg", "kgg", "unknown unit \"kgg\", did you mean \"kg\"?"},
        {"3.9 g", "-3.9 g", "-3.9 g", "pawl.mass|must not be negative"},
        {"3.9 g", "[3.9 g]", "[3.9 g]", "a single number [kg], found a list"},
        {"3.9 g", "{value: 3.9 g}", "{value: 3.9", "a single number [kg], found a mapping"},
        {"3.9 g", "\"\"", "\"\"", "expected a number"},
        {"3.9 g", "3.9 g +- 2 mm", "2 mm\n", "the tolerance needs the unit of its number"},
        {"3.9 g", "3.9 g +- 2", "2\n    inertia: {yy: 4.1", "the tolerance needs the unit"},
        {"3.9 g", "key.mass +- 2 g", "+- 2 g", "a tolerance belongs to a single number"},
        {"3.9 g", "3.9 g +-", "\n    inertia: {yy: 4.1", "expected a number"},
        {"0.0413 N m/rad", "41.3 N/m", "41.3 N/m", "the unit is N/m, expected N m/rad"},
        {"0.0413 N m/rad", "41.3 mNm/rad", "mNm/rad", "did you mean \"mN m/rad\"?"},
        {"1.3e-5 N m s/rad", "1 N s/m", "1 N s/m", "expected N m s/rad"},
        {"1.3e-5 N m s/rad", "-1e-5", "-1e-5", "key.damping|must not be negative"},
        {"A: 0.23", "A: 0.23 N", "0.23 N", "the unit is N, expected a pure number"},
        {"A: 0.23", "A: -0.23", "-0.23", "must not be negative"},
        {"vt: 11 mm/s", "vt: 0 mm/s", "0 mm/s", "string.friction.vt|greater than zero"},
        {"vt: 0.13 rad/s", "vt: 0.13 m/s", "0.13 m/s", "expected rad/s"},
        {"radius: 1.9 mm", "radius: -1.9 mm", "-1.9 mm", "must not be negative"},
        {"angle: 89 deg", "angle: 180 deg", "180 deg}\n    beak", "between 0 and 180 deg"},
        {"angle: 89 deg", "angle: 89 %", "89 %", "the unit is %, expected rad"},
        {"[0, 0, -9.81 m/s^2]", "[0, -9.81 m/s^2]", "[0, -9.81", "gravity|three numbers"},
        {"[0, 0, -9.81 m/s^2]", "0", "0\nparam", "gravity|three numbers"},
        {"dt: 13 us", "dt: 13 um", "13 um", "the unit is m, expected s"},
        {"dt: 13 us", "dt: 0", "0, until", "greater than zero"},
        {"until: 0.29 s", "until: -0.29 s", "-0.29 s", "greater than zero"},
        {"settle: yes", "settle: yes, tolerance: {distance: 1 N}", "1 N}", "expected m"},
        {"settle: yes", "settle: yes, tolerance: {distance: 0 um}", "0 um", "greater than zero"},
        {"settle: yes", "settle: yes, tolerance: {distanse: 1 um}", "distanse",
         "no output \"distanse\""},
        {"settle: yes", "settle: yes, tolerance: {dip: 1 um}", "dip: 1 um",
         "reads a position, angle, x, y, z or gap"},
        {"settle: yes", "settle: yes, tolerance: 1 um", "1 um", "expected a mapping"},
        {"[0, 0, -1]", "[0, 0, 0]", "finger:", "the direction of finger has no length"},
    };

    REFUSE_ALL(r);
}
END_TEST

START_TEST(a_formula_that_makes_no_sense_is_refused)
{
    static const refusal r[] = {
        {"radius: 1.9 mm", "radius: pawl.stop_shfit", "pawl.stop_shfit",
         "there is no number \"pawl.stop_shfit\", did you mean \"pawl.stop_shift\"?"},
        {"radius: 1.9 mm", "radius: height + 1 mm", "height +", "a name looks like owner.name"},
        {"radius: 1.9 mm", "radius: string.height + 3", "+ 3", "missing unit"},
        {"radius: 1.9 mm", "radius: 3 - string.height", "- string", "sum with one in m: missing"},
        {"radius: 1.9 mm", "radius: string.height + key.mass", "+ key.mass",
         "m and kg cannot be added"},
        {"radius: 1.9 mm", "radius: string.height * key.mass", "string.height *",
         "the unit is kg m, expected m"},
        {"radius: 1.9 mm", "radius: 2 * 3", "2 * 3", "the unit is missing, expected m"},
        {"radius: 1.9 mm", "radius: string.height ^ 2", "^ 2", "powers are for units only"},
        {"radius: 1.9 mm", "radius: string.height string.height", "string.height}",
         "expected an operator"},
        {"radius: 1.9 mm", "radius: (string.height * 2", "}}\n    normal: {c: 1.57",
         "expected \")\""},
        {"radius: 1.9 mm", "radius: string.height * ", " }}\n    normal: {c: 1.57", "expected a"},
        {"radius: 1.9 mm", "radius: sin(string.height) * 1 mm", "sin(", "pure number or an angle"},
        {"radius: 1.9 mm", "radius: sqrt(string.height)", "sqrt(", "odd powers"},
        {"radius: 1.9 mm", "radius: sqrt(3 kg) * 1 mm", "sqrt(", "odd powers"},
        {"radius: 1.9 mm", "radius: sqrt(3 s) * 1 mm", "sqrt(", "odd powers"},
        {"radius: 1.9 mm", "radius: exp(1) * 1 mm", "exp(", "expected sin, cos, tan or sqrt"},
        {"radius: 1.9 mm", "radius: 1 mm / sin(hammer.initial.position)", "1 mm / sin",
         "stop.circle.radius|not finite"},
        {"radius: 1.9 mm", "radius: 1 mm + stop.circle.radius", "stop.circle.radius}",
         "the formula refers to itself"},
        {"0.31 mm", "hammer.head.z", "hammer.head.z", "must be a number, not a formula"},
        {"0.31 mm", "{value: hammer.head.z}", "hammer.head.z", "not a formula"},
        {"radius: 1.9 mm", "radius: 3 m^9 * 1 m^9 * 1 m^9 * 1 m^9 * 1 m^9 * 1 m^9 * 1 m^9",
         "* 1 m^9}", "powers of the unit become too large"},
    };

    REFUSE_ALL(r);
}
END_TEST

START_TEST(formulas_that_refer_to_each_other_in_a_ring_are_refused)
{
    static const refusal ring[] = {
        {"[0, 0, string.height]", "[string.line.z, 0, string.line.x]", "string.line.x]",
         "string.line.z = \"string.line.x\": the formula refers to itself"},
    };

    REFUSE_ALL(ring);
}
END_TEST

/** A body with a mass at the end of a chain of n formulas, in the arena of the caller. */
static void chain(char *text, size_t size, int n)
{
    snprintf(text, size,
             "mechanism: a\nbodies:\n b:\n  joint: T z\n  mass: b.p%d.x * 1 kg/m\n"
             "  points:\n   p0: [1.7 m, 0, 0]\n",
             n);
    for (int i = 1; i <= n; i++) {
        size_t k = strlen(text);

        snprintf(text + k, size - k, "   p%d: [b.p%d.x / 2, 0, 0]\n", i, i - 1);
    }
}

START_TEST(a_chain_of_formulas_is_followed_until_it_is_too_long)
{
    char text[4000];

    chain(text, sizeof text, 20);
    mechanism *m = read_ok(text, NULL, 0);
    ck_assert_close(m->bodies[0].mass.value, 1.7 / (1 << 20), 1e-14, 0.0);
    mech_free(m);
    chain(text, sizeof text, 50);
    refuse_text(text, strlen(text), NULL, 0, "b.p18.x / 2", "refer to each other too deeply");
}
END_TEST

START_TEST(limits_of_formulas_are_reported)
{
    static const refusal r[] = {
        {"radius: 1.9 mm", "radius: ((((((((((((((((((((((((((((((((((1 mm", "((1 mm",
         "brackets are nested too deeply"},
        {"radius: 1.9 mm",
         "radius: 1 mm*(1-(1-(1-(1-(1-(1-(1-(1-(1-(1-(1-(1-(1-(1-(1-(1-1))))))))))))))))",
         "1 mm*(1", "the formula is nested too deeply"},
    };

    REFUSE_ALL(r);

    char text[4000] = "mechanism: a\nbodies:\n b:\n  joint: T z\n  mass: 0 kg";
    for (int i = 1; i < 200; i++) {
        size_t n = strlen(text);

        snprintf(text + n, sizeof text - n, " + 0.%03d kg", i);
    }
    strcat(text, "\n");
    refuse_text(text, strlen(text), NULL, 0, "+ 0.129 kg", "the formula is too long");
}
END_TEST

START_TEST(a_bad_name_is_refused)
{
    static const refusal r[] = {
        {"mechanism: demo", "mechanism: my demo", "my demo", "\"my demo\" cannot name a mechanism"},
        {"mechanism: demo", "mechanism: while", "while", "a word of the language C"},
        {"  tie:", "  9tie:", "9tie", "cannot name a link, expected a letter"},
        {"  tie:", "  tie*/:", "tie*/", "cannot name a link"},
        {"  tie:", "  \"\":", "\"\":", "cannot name a link"},
        {"  tie:", "  int:", "int: {", "a word of the language C"},
        {"  tie:", "  abcdefghijklmnopqrstuvwxyz0123456:", "abcdef", "at most 31"},
        {"  anchor: [0.113 m, 0, 0]", "  anchor: [0.113 m, 0, 0]\n  b-c: [0, 0, 0]", "b-c",
         "cannot name a point"},
        {"  pawl.stop_shift: 0.31 mm", "  pawl.stop_shift: 0.31 mm\n  dx: 3 mm", "dx: 3",
         "expected owner.name"},
        {"  pawl.stop_shift: 0.31 mm", "  pawl.stop_shift: 0.31 mm\n  a..b: 3 mm", "a..b",
         "cannot name a part of a parameter's name"},
        {"  pawl.stop_shift: 0.31 mm", "  pawl.stop_shift: 0.31 mm\n  pawl.~x: 3 mm", "pawl.~x",
         "cannot name a part of a parameter's name"},
        {"  pawl.stop_shift: 0.31 mm",
         "  pawl.stop_shift: 0.31 mm\n  "
         "of_the_owner.of_the_owner.of_the_owner.of_the_owner.of_the_owner.of_the_owner."
         "of_the_owner.of_the_owner: 3 mm",
         "of_the_owner.of", "cannot name a parameter, expected owner.name"},
        {"  distance:", "  time:", "time:", "every model has the output \"time\""},
        {"bodies:\n", "bodies:\n  frame: {joint: R y, mass: 1, centre: [1, 0, 0]}\n", "frame: {j",
         "the name of the fixed frame"},
        {"bodies:\n", "bodies:\n  load: {joint: R y, mass: 1, centre: [1, 0, 0]}\n", "load: {j",
         "the name of the free load"},
        {"contacts:\n", "contacts:\n  load: {}\n", "load: {}", "the name of the free load"},
    };

    REFUSE_ALL(r);
}
END_TEST

START_TEST(a_name_used_twice_is_refused)
{
    static const refusal r[] = {
        {"    mass: 3.9 g\n", "    mass: 3.9 g\n    mass: 4.1 g\n", "mass: 4.1 g",
         "the key \"mass\" appears twice, first in line 29"},
        {"  pawl.stop_shift: 0.31 mm", "  pawl.stop_shift: 0.31 mm\n  key.mass: 3 g", "key.mass: 3",
         "the parameter \"key.mass\" has the name of another number"},
        {"  pawl.stop_shift: 0.31 mm", "  pawl.stop_shift: 0.31 mm\n  key.centre.y: {value: 0 mm}",
         "key.centre.y", "\"key.centre.y\" has the name of another number"},
        {"drive: {motion: key, idle: hold}", "drive: {motion: key}\n  again: {motion: key}",
         "again", "the joint key has two motion inputs"},
    };

    REFUSE_ALL(r);

    /* a point must not share the names of its coordinates with the centre of mass */
    char *text = changed("{corner:", "{centre: [0.1, 0, 0], corner:");
    log_t log = {"", 0};
    mechanism *m = NULL;
    ck_assert_int_eq(mech_read_text(&m, "d", text, strlen(text), NULL, 0, record, &log, NULL),
                     STEIN_EPARSE);
    ck_assert(strstr(log.first, "two numbers of the file are called \"pawl.centre.x\"") != NULL);
    free(text);
}
END_TEST

START_TEST(a_reference_to_nothing_is_refused)
{
    static const refusal r[] = {
        {"parent: key", "parent: kye", "kye", "there is no body \"kye\", did you mean \"key\"?"},
        {"at: key.kapsel", "at: key.kapsle", "key.kapsle", "did you mean \"key.kapsel\"?"},
        {"at: key.kapsel", "at: frame.anchor", "frame.anchor\n",
         "the point frame.anchor is not on the parent, expected a point of key"},
        {"from: frame.anchor", "from: anchor", "anchor, to", "no point \"anchor\""},
        {"from: frame.anchor", "from: key.kapsel", "tie:", "both ends of the link are on one body"},
        {"on: frame, at: [0, 0, s", "on: fram, at: [0, 0, s", "fram,", "did you mean"},
        {"circle: {at", "circle: {on: hammer, at", "hammer, at", "pawl.back is not on this body"},
        {"{contact: string,", "{contact: strnig,", "strnig", "there is no contact \"strnig\", did"},
        {"force: key.front", "force: key.fornt", "key.fornt", "did you mean \"key.front\"?"},
        {"motion: key", "motion: hamer", "hamer", "there is no joint \"hamer\", did you mean"},
        {"input: drive", "input: drvie", "drvie", "there is no input \"drvie\", did you mean"},
        {"{string: string,", "{string: stopp,", "stopp", "there is no contact \"stopp\", did you"},
        {"notch: notch}", "notch: nut}", "nut}", "there is no notch \"nut\""},
        {"on: key.front", "on: key.fornt", "key.fornt, n", "there is no point \"key.fornt\""},
    };

    REFUSE_ALL(r);
}
END_TEST

START_TEST(a_word_that_is_no_choice_is_refused)
{
    static const refusal r[] = {
        {"joint: R y", "joint: R w", "R w", "\"R w\" is no joint, expected R or T"},
        {"joint: R y", "joint: Ry", "Ry", "is no joint"},
        {"joint: R y", "joint: R yy", "R yy", "is no joint"},
        {"joint: R y", "joint: [R, y]", "[R, y]", "single text|found a list"},
        {"read: gap", "read: gpa", "gpa",
         "expected one of gap force friction, did you mean \"gap\""},
        {"idle: hold", "idle: held", "held", "expected one of free hold, did you mean \"hold\"?"},
        {"sign: -1", "sign: 2", "2, zero", "expected one of 1 -1"},
        {"zero: rest", "zero: start", "start}", "expected one of origin rest"},
        {"integrator: dp5", "integrator: dp4", "dp4", "did you mean \"dp5\"?"},
        {"settle: yes", "settle: maybe", "maybe", "expected one of no yes"},
        {"{input: drive, read: force}", "{input: finger, read: force}", "force}\nstroke",
         "only a motion input"},
        {"{contact: string, read: gap}", "{contact: string, joint: key, read: gap}", "distance",
         "exactly one of joint, point"},
        {"finger: {force: key.front,", "finger: {force: key.front, torque: key,", "finger",
         "exactly one of force, torque, motion"},
        {"- {point: hammer.head}", "- {}", "{}\n", "exactly one of point, circle, line"},
    };

    REFUSE_ALL(r);
}
END_TEST

START_TEST(a_tree_that_is_none_is_refused)
{
    static const refusal r[] = {
        {"    about: the lever\n", "    parent: hammer\n", "hammer\n    joint",
         "the parents form a loop|expected a tree"},
        {"    about: the lever\n", "    parent: key\n", "key\n    joint: R y", "key -> key"},
    };

    REFUSE_ALL(r);

    char text[16000] = "mechanism: many\nbodies:\n";
    for (int i = 0; i < 221; i++) {
        size_t n = strlen(text);

        snprintf(text + n, sizeof text - n, "  b%d: {joint: T z, mass: 1 kg}\n", i);
    }
    refuse_text(text, strlen(text), NULL, 0, "bodies", "221 entries, expected at most 220");
    mechanism *m = NULL;
    strstr(text, "  b220")[0] = '\0';
    m = read_ok(text, NULL, 0);
    ck_assert_int_eq(m->nbody, 220);
    mech_free(m);
}
END_TEST

START_TEST(contacts_that_cannot_be_are_refused)
{
    static const refusal r[] = {
        {"  hammer:\n    parent: key\n    joint: R -y",
         "  hammer:\n    parent: key\n    joint: R z", "hammer.head}",
         "notches and loads are planar: the joint hammer must turn about y"},
        {"{line: {on: frame, at: [0, 0, string.height], facing: -90 deg}}", "{point: key.front}",
         "- {point: hammer", "a point cannot touch a point"},
        {"{on: frame, at: [0, 0, string.height]", "{on: hammer, at: [0, 0, string.height]",
         "- {point: hammer", "both sides are on one body"},
        {"{circle: {at: pawl.back, radius: 1.9 mm}}", "{line: {at: pawl.back, facing: 0}}",
         "{line: {on: frame, at: [-1", "of two lines the first needs an extent"},
        {"facing: 180 deg", "facing: 180 deg, extent: [3 mm, -3 mm]",
         "stop:", "an extent of the contact stop ends before it begins"},
        {"facing: 180 deg", "facing: 180 deg, extent: [3 mm]", "[3 mm]", "a list of two lengths"},
        {"facing: 180 deg", "facing: 180 deg, extent: 3 mm", "3 mm}", "a list of two lengths"},
        {"\n      - {line: {on: frame, at: [-121 mm + pawl.stop_shift, 0, 0], facing: 180 deg}}"
         "\n      - {circle: {at: pawl.back, radius: 1.9 mm}}\n",
         " pawl.back\n", "pawl.back\n    normal", "a list of two sides"},
        {"      - {point: hammer.head}\n", "", "- {line: {on: frame, at: [0, 0, s", "two sides"},
        {"beak: {at: hammer.beak", "beak: {at: pawl.back", "notch:\n    corner",
         "corner and beak are on one body"},
    };

    for (size_t i = 1; i < sizeof r / sizeof r[0]; i++) {
        refuse_all(&r[i], 1);
    }

    /* a notch of a body that leaves the plane is refused; its other contacts are in space then */
    char *text = changed(r[0].from, r[0].to);
    mechanism *m = NULL;
    log_t log = {"", 0};
    ck_assert_int_eq(mech_read_text(&m, "d", text, strlen(text), NULL, 0, record, &log, NULL),
                     STEIN_EPARSE);
    ck_assert_int_eq(log.n, 1);
    ck_assert(strstr(log.first, r[0].words) != NULL);
    free(text);
}
END_TEST

/** A mechanism of the bodies in `text`; refused for a joint without inertia, or accepted. */
static void judge_inertia(const char *bodies, const char *at, const char *words)
{
    char text[900];

    snprintf(text, sizeof text, "mechanism: m\nbodies:\n%s", bodies);
    if (words) {
        refuse_text(text, strlen(text), NULL, 0, at, words);
    } else {
        mech_free(read_ok(text, NULL, 0));
    }
}

START_TEST(a_joint_with_nothing_to_move_is_named)
{
    judge_inertia(
        "  a: {joint: R y, mass: 1.3, centre: [0.1, 0, 0]}\n  b: {parent: a, joint: R y}\n", "b: {",
        "the joint b has no inertia to move");
    judge_inertia("  a: {joint: R z, mass: 1.3, centre: [0, 0, 0.2]}\n", "a: {", "the joint a");
    judge_inertia("  a: {joint: T x}\n  b: {parent: a, joint: T z, mass: 1.3}\n", NULL, NULL);
    judge_inertia("  a: {joint: T x}\n  b: {parent: a, joint: T x, mass: 1.3}\n", "b: {",
                  "the joint b has no inertia");
    judge_inertia("  a: {joint: R x}\n  b: {parent: a, joint: R y}\n"
                  "  c: {parent: b, joint: R z, mass: 0.7, centre: [0.1, 0.2, 0.3]}\n",
                  "c: {", "has no inertia"); /* a point mass on three axes through one point */
    judge_inertia("  a: {joint: R x}\n  b: {parent: a, joint: R y}\n"
                  "  c: {parent: b, joint: R z, inertia: {xx: 1e-7, yy: 1.3e-7, zz: 1.2e-7}}\n",
                  NULL, NULL);
    judge_inertia(
        "  a: {joint: R y, mass: 1e3 kg, centre: [1 m, 0, 0]}\n"
        "  b: {parent: a, joint: R y, at: [1 m, 0, 0], mass: 1 mg, centre: [1 mm, 0, 0]}\n",
        NULL, NULL);
    judge_inertia("  a: {joint: R y}\ninputs: {d: {motion: a, idle: free}}\n", "a: {",
                  "the joint a");
    judge_inertia("  a: {joint: R y}\ninputs: {d: {motion: a, idle: hold}}\n", NULL, NULL);
}
END_TEST

START_TEST(an_inertia_that_no_body_can_have_is_refused)
{
    judge_inertia("  a: {joint: R y, inertia: {yy: -1e-5}}\n", "{yy", "negative");
    judge_inertia("  a: {joint: R y, inertia: {xx: 1, yy: 1, zz: 1, xz: 1.2}}\n", "{xx",
                  "negative");
    judge_inertia("  a: {joint: R y, inertia: {xx: 1, yy: 3, zz: 1.9}}\n", "{xx",
                  "exceeds the sum of the other two");
    judge_inertia("  a: {joint: R y, inertia: {xx: 1, yy: 2.9, zz: 1.9, xz: 0.1}}\n", NULL, NULL);
    judge_inertia("  a: {joint: R y, inertia: {xx: 1, yy: 3}}\n", NULL, NULL);
    judge_inertia("  a: {joint: R y, mass: 1, centre: [0.1, 0, 0], pendulum: {frequency: 2 Hz}}\n",
                  "{frequency", "negative"); /* faster than a point mass at that distance */
    judge_inertia("  a: {joint: R y, mass: 1, pendulum: {frequency: 1}}\n", "{frequency",
                  "its centre on its joint");
    judge_inertia("  a: {joint: R x, mass: 1, centre: [0, 1, 0], pendulum: {frequency: 0.1}}\n",
                  "pendulum", "needs a joint about y");
    judge_inertia(
        "  a: {joint: R y, mass: 1, centre: [0.1, 0, 0], pendulum: {frequency: 1 Hz, period: "
        "1 s}}\n",
        "period", "exclude each other");
    judge_inertia("  a: {joint: R y, mass: 1, inertia: {yy: 1}, pendulum: {frequency: 1}}\n",
                  "pendulum", "exclude each other");
}
END_TEST

START_TEST(a_range_that_cannot_be_regulated_is_refused)
{
    static const refusal r[] = {
        {"stroke:", "regulation: {pawl.stop_shfit: {from: 0, to: 1}}\nstroke:", "pawl.stop_shfit",
         "there is no parameter \"pawl.stop_shfit\" to regulate|did you mean \"pawl.stop_shift\"?"},
        {"stroke:", "regulation: {pawl.stop_shift: {from: 0 N, to: 1 mm}}\nstroke:", "0 N",
         "from of pawl.stop_shift"},
        {"stroke:", "regulation: {pawl.stop_shift: {from: 0 mm, to: 1 mm, lable: x}}\nstroke:",
         "lable", "unknown key \"lable\" in a range of the regulation, did you mean \"label\"?"},
        {"stroke:", "regulation: {pawl.stop_shift: {from: 2 mm, to: 1 mm}}\nstroke:", "{from: 2",
         "the range of pawl.stop_shift ends where it begins or before"},
        {"stroke:", "regulation: {pawl.stop_shift: 1 mm}\nstroke:", "1 mm}\nstroke",
         "a range of the regulation must be a mapping with the keys from to label"},
        {"stroke:", "regulation: [pawl.stop_shift]\nstroke:", "[pawl.stop_shift]",
         "expected a mapping from parameters"},
    };

    REFUSE_ALL(r);
}
END_TEST

START_TEST(a_bad_override_is_refused)
{
    static const struct {
        const char *name, *value, *words;
    } wrong[] = {
        {"hammer.maas", "3 g", "no number of that name, did you mean \"hammer.mass\"?"},
        {"", "3 g", "no number of that name"},
        {"hammer.mass", "3 mm", "set hammer.mass = \"3 mm\": the unit is m, expected kg"},
        {"hammer.mass", "-3 g", "must not be negative"},
        {"hammer.mass", "heavy", "expected a number"},
        {"hammer.mass", "key.mass", "expected a number"},
        {"hammer.mass", "3,1 g", "decimal point"},
        {"stop.line.x", "-120 mm",
         "by the formula -121 mm + pawl.stop_shift, set instead "
         "\"pawl.stop_shift\""},
        {"string.line.z", "40 mm", "set instead \"string.height\""},
        {"string.height", "3 kg", "the unit is kg, expected m"},
        {"string.friction.vt", "0", "must be greater than zero"},
    };

    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        mech_set set = {wrong[i].name, wrong[i].value};

        refuse_text(good, sizeof good - 1, &set, 1, NULL, wrong[i].words);
    }

    /* a number that follows from others without a formula in the file */
    mech_set inertia = {"pawl.inertia.yy", "4e-6 kg m^2"};
    char *text = changed("inertia: {yy: 4.1e-6 kg m^2}",
                         "centre: [7 mm, 0, 11 mm]\n    pendulum: {frequency: 1.3 Hz}");
    refuse_text(text, strlen(text), &inertia, 1, NULL,
                "set pawl.inertia.yy|by the formula m g d / (2 pi nu)^2 - m d^2, set instead|"
                "\"pawl.mass\", \"pawl.centre.x\"|\"pawl.pendulum.frequency\"");
    free(text);
}
END_TEST

void refusal_cases(Suite *suite)
{
    TCase *tc = tcase_create("refusals");

    tcase_set_timeout(tc, 60.0);
    tcase_add_test(tc, an_unknown_key_is_named_with_the_one_that_was_meant);
    tcase_add_test(tc, a_missing_key_is_named_at_its_mapping);
    tcase_add_test(tc, a_number_of_the_wrong_kind_is_refused);
    tcase_add_test(tc, a_formula_that_makes_no_sense_is_refused);
    tcase_add_test(tc, formulas_that_refer_to_each_other_in_a_ring_are_refused);
    tcase_add_test(tc, a_chain_of_formulas_is_followed_until_it_is_too_long);
    tcase_add_test(tc, limits_of_formulas_are_reported);
    tcase_add_test(tc, a_bad_name_is_refused);
    tcase_add_test(tc, a_name_used_twice_is_refused);
    tcase_add_test(tc, a_reference_to_nothing_is_refused);
    tcase_add_test(tc, a_word_that_is_no_choice_is_refused);
    tcase_add_test(tc, a_tree_that_is_none_is_refused);
    tcase_add_test(tc, contacts_that_cannot_be_are_refused);
    tcase_add_test(tc, a_joint_with_nothing_to_move_is_named);
    tcase_add_test(tc, an_inertia_that_no_body_can_have_is_refused);
    tcase_add_test(tc, a_range_that_cannot_be_regulated_is_refused);
    tcase_add_test(tc, a_bad_override_is_refused);
    suite_add_tcase(suite, tc);
}
