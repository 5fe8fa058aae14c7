/* SPDX-License-Identifier: MIT
 * test_generator_text.c - the emitted text: operation counts, golden file, equations hash, names
 * that try to break out, and every refusal of gen_equations.
 */
#include <stdlib.h>
#include <string.h>

#include "generator_reference.h"
#include "gen.h"
#include "open.h"
#include "mechanism_cases.h"
#include "support.h"

void generator_text_cases(Suite *suite);

static mechanism *read_model(const char *file)
{
    mechanism *m = NULL;
    ck_assert_stein(mech_read(&m, file, NULL, 0, NULL, NULL, err));
    return m;
}

static mechanism *read_text(const char *text, const mech_set *set, int nset)
{
    mechanism *m = NULL;
    ck_assert_stein(
        mech_read_text(&m, "test.yaml", text, strlen(text), set, nset, NULL, NULL, err));
    return m;
}

static gen_result generate(const mechanism *m)
{
    gen_result r;
    ck_assert_stein(gen_equations(&r, m, err));
    return r;
}

static int total(const stein_ops *o)
{
    return o->add + o->mul + o->neg + o->div + o->trig;
}

/* ---- operation counts ----------------------------------------------------------------------- */

/* ROBOTRAN's counts (spec, from its public projects) and what is reached here, which may only fall.
 */
static const struct {
    const char *file;
    int robotran_mass_bias, robotran_inverse, mass_bias, inverse;
} counts[] = {
    {"models/robotran/piano_tree.yaml", 144, 123, 63, 71},
    {"models/robotran/suspension_a.yaml", 95, 77, 57, 64},
    {"models/robotran/suspension_b.yaml", 172, 114, 71, 84},
    {"models/robotran/piston.yaml", 125, 83, 53, 61},
};

START_TEST(counts_are_below_robotrans)
{
    mechanism *m = read_model(counts[_i].file);
    gen_result r = generate(m);
    ck_assert_int_lt(total(&r.mass_bias), counts[_i].robotran_mass_bias);
    ck_assert_int_lt(total(&r.inverse), counts[_i].robotran_inverse);
    ck_assert_int_le(total(&r.mass_bias), counts[_i].mass_bias);
    ck_assert_int_le(total(&r.inverse), counts[_i].inverse);
    gen_free(&r);
    mech_free(m);
}
END_TEST

/* OpenSYMORO's RX90 needs 378 products and 329 sums for the inverse dynamics of its six joints,
 * with most hinge vectors zero; this arm has three components in each. */
START_TEST(six_axis_arm_stays_cheap)
{
    unsigned long long seed = 90;
    mechanism *m = ref_arm("arm6", "zyyxyx", &seed);
    m->npoint = 0;
    gen_result r = generate(m);
    printf("arm6: M and c %d mul %d add, inverse dynamics %d mul %d add\n", r.mass_bias.mul,
           r.mass_bias.add, r.inverse.mul, r.inverse.add);
    ck_assert_int_le(r.inverse.mul, 310);
    ck_assert_int_le(r.inverse.add, 319);
    ck_assert_int_le(r.mass_bias.mul, 411);
    ck_assert_int_le(r.mass_bias.add, 414);
    // Pinocchio's algorithms written out by CasADi: 1408 + 10 for M and c, 1815 + 10 for qdd
    ck_assert_int_eq(total(&r.articulated), 0);
    ck_assert_int_lt(total(&r.mass_bias), 1408 + 10);
    ck_assert_int_lt(total(&r.unloaded) + total(&r.solve), 1815 + 10);
    gen_free(&r);
    ref_tree_free(m);
}
END_TEST

/* the same peer's 30 joints: 15257 + 58, and 12283 + 58 by articulated bodies */
START_TEST(long_chain_stays_cheap)
{
    unsigned long long seed = 30;
    mechanism *m = ref_arm("chain30", "zyxzyxzyxzyxzyxzyxzyxzyxzyxzyx", &seed);
    m->npoint = 0;
    gen_result r = generate(m);
    printf("chain30: M and c %d, solution %d, qdd by articulated bodies %d\n", total(&r.mass_bias),
           total(&r.solve), total(&r.articulated));
    ck_assert_int_lt(total(&r.mass_bias), 15257 + 58);
    ck_assert_int_gt(total(&r.articulated), 0);
    ck_assert_int_lt(total(&r.articulated), 12283 + 58);
    gen_free(&r);
    ref_tree_free(m);
}
END_TEST

/** A planar model costs the same about any axis: the general 3-D recursion leaves nothing behind.
 */
START_TEST(planar_cost_is_the_same_about_every_axis)
{
    int cost[3];
    for (int a = 0; a < 3; a++) {
        char text[600];
        char u = (char)('x' + a);
        snprintf(text, sizeof text,
                 "mechanism: plane\ngravity: [%s]\nbodies:\n"
                 "  one: {joint: R %c, mass: 2 kg, centre: [%s], inertia: {%c%c: 0.3}}\n"
                 "  two: {parent: one, joint: R %c, at: [%s], mass: 1 kg, centre: [%s]}\n",
                 a == 2 ? "0, -9.81, 0" : "0, 0, -9.81", u, a == 2 ? "0, 0.1, 0" : "0, 0, 0.1", u,
                 u, u, a == 2 ? "0, 0.5, 0" : "0, 0, 0.5", a == 2 ? "0, 0.2, 0" : "0, 0, 0.2");
        mechanism *m = read_text(text, NULL, 0);
        gen_result r = generate(m);
        cost[a] = total(&r.mass_bias);
        gen_free(&r);
        mech_free(m);
    }
    ck_assert_int_eq(cost[0], cost[1]);
    ck_assert_int_eq(cost[1], cost[2]);
}
END_TEST

/* ---- the text ------------------------------------------------------------------------------- */

static char *read_file(const char *path, size_t *size)
{
    FILE *f = fopen(path, "rb");
    ck_assert_msg(f != NULL, "%s", path);
    char *text = calloc(1, 1 << 20);
    *size = fread(text, 1, (1 << 20) - 1, f);
    fclose(f);
    return text;
}

/* the line of `now` at which two texts first differ */
static void assert_same_text(const char *now, const char *accepted)
{
    int line = 1;
    const char *a = now, *b = accepted;
    while (*a != '\0' && *a == *b) {
        line += *a == '\n';
        a++, b++;
    }
    if (*a == *b) {
        return;
    }
    while (a > now && a[-1] != '\n') {
        a--, b--;
    }
    ck_abort_msg("line %d is\n    %.*s\naccepted was\n    %.*s\n`make golden` accepts it", line,
                 (int)strcspn(a, "\n"), a, (int)strcspn(b, "\n"), b);
}

/* `make golden` accepts a changed text after it has been read. */
START_TEST(pendulum_is_generated_as_in_the_golden_file)
{
    size_t size;
    char *golden = read_file("tests/golden/pendulum.c", &size);
    mechanism *m = read_model("models/pendulum.yaml");
    gen_result r = generate(m);
    ck_assert_uint_eq(r.size, strlen(r.source));
    assert_same_text(r.source, golden);
    gen_free(&r);
    mech_free(m);
    free(golden);
}
END_TEST

/* ---- many texts, by their hashes: names, order, sharing and layout, to the byte ---- */

static const char golden_texts[] = "tests/golden/texts";

static void put_text(FILE *f, const mechanism *m)
{
    gen_result r = generate(m);
    fprintf(f, "%016llx %zu %s\n", lab__hash(STEIN_HASH, r.source, r.size), r.size, m->name);
    gen_free(&r);
}

/* one line for each text: trees of 1 to 11 bodies in space and in the plane, arms, every part that
 * a file may have */
static char *list_texts(void)
{
    char *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    static const int sizes[] = {1, 2, 3, 4, 5, 6, 7, 11};
    for (int k = 0; k < 24; k++) {
        char name[24];
        unsigned long long seed = 4711u + 13u * (unsigned)k;
        snprintf(name, sizeof name, "tree%d", k);
        mechanism *m = ref_tree(name, sizes[k % 8], k % 3 == 0, &seed);
        put_text(f, m);
        ref_tree_free(m);
    }
    static const char *const axes[] = {"zyyxyx", "yyyyyyyyyyyy", "zxzxzx", "xyz", "zzyyx"};
    for (int k = 0; k < 5; k++) {
        unsigned long long seed = 90u + (unsigned)k;
        mechanism *m = ref_arm(axes[k], axes[k], &seed);
        put_text(f, m);
        ref_tree_free(m);
    }
    mechanism *m = read_text(good, NULL, 0);
    put_text(f, m);
    mech_free(m);
    fclose(f);
    return text;
}

START_TEST(other_texts_are_those_that_were_accepted)
{
    char *now = list_texts();
    if (getenv("STEIN_GOLDEN") != NULL) { // make golden
        FILE *f = fopen(golden_texts, "w");
        ck_assert(f != NULL && fputs(now, f) >= 0 && fclose(f) == 0);
    }
    size_t size;
    char *golden = read_file(golden_texts, &size), *was_left = NULL, *now_left = NULL;
    char *was = strtok_r(golden, "\n", &was_left), *is = strtok_r(now, "\n", &now_left);
    while (was != NULL && is != NULL) {
        ck_assert_msg(strcmp(was, is) == 0,
                      "the text is another one: \"%s\", accepted was \"%s\". Compare the output of "
                      "steingen with the golden one; make golden accepts it",
                      is, was);
        was = strtok_r(NULL, "\n", &was_left);
        is = strtok_r(NULL, "\n", &now_left);
    }
    ck_assert(was == NULL && is == NULL);
    free(golden);
    free(now);
}
END_TEST

START_TEST(generating_again_gives_the_same_bytes)
{
    for (int k = 0; k < 2; k++) {
        unsigned long long seed = 77;
        mechanism *m = ref_tree("again", 9, k, &seed);
        gen_result a = generate(m), b = generate(m);
        ck_assert_str_eq(a.source, b.source);
        ck_assert_str_eq(a.equations, b.equations);
        gen_free(&a);
        gen_free(&b);
        ref_tree_free(m);
    }
}
END_TEST

/* ---- the hash of the equations --------------------------------------------------------------- */

static const char rod[] = "mechanism: rod\n"
                          "parameters: {wall.height: 44 mm, wall.shift: 0 mm}\n"
                          "bodies:\n"
                          "  rod:\n"
                          "    joint: R y\n"
                          "    mass: 1 kg\n"
                          "    centre: [0.3, 0, 0]\n"
                          "    points: {tip: [0.7, 0, 0]}\n"
                          "contacts:\n"
                          "  wall:\n"
                          "    between: [{point: rod.tip}, {line: {on: frame, at: [0, 0, "
                          "wall.height + 2 mm], facing: -90 deg}}]\n"
                          "    normal: {c: 1e4}\n"
                          "outputs: {angle: {joint: rod, read: position}}\n"
                          "simulation: {dt: 1 ms, until: 1 s}\n";

/** Hash after replacing `from` by `to` in the text of the rod. */
static void hash_of(const char *from, const char *to, char hash[17])
{
    char text[1200];
    const char *at = strstr(rod, from);
    ck_assert_msg(at != NULL, "%s", from);
    snprintf(text, sizeof text, "%.*s%s%s", (int)(at - rod), rod, to, at + strlen(from));
    mechanism *m = read_text(text, NULL, 0);
    gen_result r = generate(m);
    memcpy(hash, r.equations, 17);
    ck_assert_ptr_nonnull(strstr(r.source, hash));
    gen_free(&r);
    mech_free(m);
}

static const struct {
    const char *from, *to;
    int same;
} changes[] = {
    {"mass: 1 kg", "mass: 1.25 kg", 1},
    {"mass: 1 kg", "mass: 1 kg +- 2 g", 1},
    {"mass: 1 kg", "mass: 1000 g", 1},
    {"wall.shift: 0 mm", "wall.shift: 3 mm", 1},
    {"dt: 1 ms", "dt: 10 us, integrator: dp5, settle: yes", 1},
    {"until: 1 s", "until: 3 s", 1},
    {"mechanism: rod\n", "# a comment\nmechanism: rod\nabout: more words\n", 1},
    {"centre: [0.3, 0, 0]", "centre: [0.3, 0, 0.1]", 0},
    {"centre: [0.3, 0, 0]", "centre: [0.3, 0, 0]\n    damping: 1e-3",
     1}, /* was there at its neutral value */
    {"joint: R y", "joint: R -y", 0},
    {"wall.height + 2 mm", "wall.height + 3 mm", 0},
    {"wall.height + 2 mm", "wall.height - wall.shift", 0},
    {"outputs: {angle:", "outputs: {angel:", 0},
    {"read: position", "read: speed", 0},
    {"tip: [0.7, 0, 0]", "tip: [0.7, 0, 0], top: [0.1, 0, 0]", 0},
    {"mechanism: rod", "mechanism: pole", 0},
};

START_TEST(equations_hash_ignores_numbers_and_depends_on_structure)
{
    char before[17], after[17];
    hash_of("mass", "mass", before);
    hash_of(changes[_i].from, changes[_i].to, after);
    ck_assert_msg((strcmp(before, after) == 0) == changes[_i].same, "%s -> %s", changes[_i].from,
                  changes[_i].to);
}
END_TEST

START_TEST(a_zero_that_becomes_a_number_changes_the_equations)
{
    const mech_set set = {"rod.centre.z", "3 mm"};
    mechanism *a = read_text(rod, NULL, 0), *b = read_text(rod, &set, 1);
    gen_result ra = generate(a), rb = generate(b);
    ck_assert_str_ne(ra.equations, rb.equations);
    gen_free(&ra);
    gen_free(&rb);
    mech_free(a);
    mech_free(b);
}
END_TEST

/* ---- hostile names and refusals -------------------------------------------------------------- */

/** 1 when `needle` occurs outside of string literals. */
static int outside_literals(const char *text, const char *needle)
{
    int inside = 0;
    for (const char *s = text; *s; s++) {
        if (*s == '\\' && inside) {
            s++;
        } else if (*s == '"') {
            inside = !inside;
        } else if (!inside && strncmp(s, needle, strlen(needle)) == 0) {
            return 1;
        }
    }
    return 0;
}

START_TEST(hostile_names_stay_in_string_literals)
{
    unsigned long long seed = 5;
    char file[] = "evil */ int x; /*.yaml";
    mechanism *m = ref_tree("hostile", 4, 1, &seed);
    const char evil[] = "*/evil\"\\\n\?\?/";
    m->file = file;
    for (int i = 0; i < m->nbody; i++) {
        snprintf(m->bodies[i].name, sizeof m->bodies[i].name, "%s", evil);
        snprintf(m->contacts[i].name, sizeof m->contacts[i].name, "%s", evil);
        snprintf(m->points[i].name, sizeof m->points[i].name, "%s", evil);
    }
    for (int i = 0; i < m->nparam; i++) {
        snprintf(m->params[i].name, sizeof m->params[i].name, "%s", evil);
        snprintf(m->params[i].unit, sizeof m->params[i].unit, "%s", evil);
    }
    gen_result r = generate(m);
    ck_assert(!outside_literals(r.source, "evil"));
    ck_assert_ptr_nonnull(strstr(r.source, "\"*/evil\\\"\\\\\\012\\?\\?/\""));
    gen_free(&r);
    ref_tree_free(m);
}
END_TEST

static void refused(const mechanism *m, const char *expected)
{
    gen_result r = {.size = 4711};
    stein_err err = {STEIN_OK, ""};
    ck_assert_int_eq(gen_equations(&r, m, &err), STEIN_EGENERATE);
    ck_assert_int_eq(err.code, STEIN_EGENERATE);
    ck_assert_msg(strstr(err.msg, expected) != NULL, "%s", err.msg);
    ck_assert_uint_eq(r.size, 4711);
    ck_assert_int_eq(gen_equations(&r, m, NULL), STEIN_EGENERATE);
}

enum {
    BAD_NAME,
    BAD_COUNT,
    BAD_GRAVITY,
    BAD_FORMULA,
    BAD_PARENT,
    BAD_JOINT,
    BAD_SIGN,
    BAD_NUMBER,
    BAD_SPOTS,
    BAD_SIDE,
    BAD_SHAPE_BODY,
    BAD_PLANE,
    BAD_NOTCH,
    BAD_POINT,
    BAD_INPUT,
    BAD_CHANNEL,
    BAD_LINK,
    BAD_END
};

START_TEST(every_refusal_names_the_cause)
{
    static const char *const cause[BAD_END] = {
        "identifier",      "bodies",          "gravity",      "formula",      "parent",
        "joint is R or T", "joint is R or T", "no parameter", "1 to 8 spots", "first side",
        "no body",         "planar",          "no body",      "no body",      "acts on nothing",
        "unknown reading", "no point"};
    unsigned long long seed = 6;
    mechanism *m = ref_tree("refused", 5, 1, &seed);
    mech_step step[1] = {{MECH_OP_ADD, 0, 0.0}};
    mech_formula formula = {.steps = step, .nsteps = 1};
    mech_notch notch = {.catcher = 0, .beak = 9};
    mech_input input = {.kind = STEIN_INPUT_POINT, .index = 99};
    mech_channel channel = {.read = 1000};
    mech_link link = {.point = {0, 99}};
    switch (_i) {
    case BAD_NAME: strcpy(m->name, "a b"); break;
    case BAD_COUNT: m->nbody = 0; break;
    case BAD_GRAVITY: m->gravity[0] = (mech_scalar){MECH_PARAM, 9999, 0.0}; break;
    case BAD_FORMULA:
        m->formulas = &formula;
        m->nformula = 1;
        break;
    case BAD_PARENT: m->bodies[1].parent = 1; break;
    case BAD_JOINT: m->bodies[1].type = 'S'; break;
    case BAD_SIGN: m->bodies[1].sign = 0; break;
    case BAD_NUMBER: m->bodies[1].mass = (mech_scalar){MECH_FORMULA, 0, 0.0}; break;
    case BAD_SPOTS: m->contacts[0].nspot = 9; break;
    case BAD_SIDE: m->contacts[0].spot[0].side[0].is_line = 1; break;
    case BAD_SHAPE_BODY: m->contacts[0].spot[0].side[0].body = 77; break;
    case BAD_PLANE:
        m->bodies[0].type = 'R';
        m->bodies[0].axis = 'z';
        break;
    case BAD_NOTCH:
        m->notches = &notch;
        m->nnotch = 1;
        break;
    case BAD_POINT: m->points[0].body = 77; break;
    case BAD_INPUT:
        m->inputs = &input;
        m->ninput = 1;
        break;
    case BAD_CHANNEL:
        m->channels = &channel;
        m->nchannel = 1;
        break;
    default:
        m->links = &link;
        m->nlink = 1;
        break;
    }
    refused(m, cause[_i]);
    ref_tree_free(m);
}
END_TEST

/* n numbers, then sums of all of them: n cells at the deepest */
START_TEST(a_formula_may_be_as_deep_as_the_stack_and_no_deeper)
{
    unsigned long long seed = 6;
    mechanism *m = ref_tree("deep", 2, 1, &seed);
    mech_step steps[2 * MECH_STACK + 1];
    for (int n = MECH_STACK; n <= MECH_STACK + 1; n++) {
        mech_formula formula = {.steps = steps, .nsteps = 2 * n - 1};
        for (int i = 0; i < formula.nsteps; i++) {
            steps[i] = (mech_step){i < n ? MECH_OP_CONST : MECH_OP_ADD, 0, 1.5};
        }
        m->formulas = &formula;
        m->nformula = 1;
        if (n <= MECH_STACK) {
            gen_result r = generate(m);
            gen_free(&r);
        } else {
            refused(m, "formula");
        }
    }
    m->formulas = NULL;
    m->nformula = 0;
    ref_tree_free(m);
}
END_TEST

/* more than a file may have: copies of its only body, side by side */
START_TEST(equations_have_up_to_220_bodies)
{
    mechanism *m = read_text("mechanism: star\nbodies:\n  b: {joint: T x, mass: 1 kg}\n", NULL, 0);
    mech_body *own = m->bodies, many[221];
    for (int n = 220; n <= 221; n++) {
        for (int i = 0; i < n; i++) {
            many[i] = own[0];
            snprintf(many[i].name, sizeof many[i].name, "b%d", i);
        }
        m->bodies = many;
        m->nbody = n;
        if (n == 220) {
            gen_result r = generate(m);
            gen_free(&r);
        } else {
            refused(m, "1 to 220");
        }
    }
    m->bodies = own;
    m->nbody = 1;
    mech_free(m);
}
END_TEST

START_TEST(freeing_nothing_is_fine)
{
    gen_result r = {.source = NULL};
    gen_free(&r);
    gen_free(NULL);
}
END_TEST

void generator_text_cases(Suite *suite)
{
    TCase *t = tcase_create("text");
    tcase_set_timeout(t, 300);
    tcase_add_loop_test(t, counts_are_below_robotrans, 0, (int)(sizeof counts / sizeof *counts));
    tcase_add_test(t, six_axis_arm_stays_cheap);
    tcase_add_test(t, long_chain_stays_cheap);
    tcase_add_test(t, planar_cost_is_the_same_about_every_axis);
    tcase_add_test(t, pendulum_is_generated_as_in_the_golden_file);
    tcase_add_test(t, other_texts_are_those_that_were_accepted);
    tcase_add_test(t, generating_again_gives_the_same_bytes);
    tcase_add_loop_test(t, equations_hash_ignores_numbers_and_depends_on_structure, 0,
                        (int)(sizeof changes / sizeof *changes));
    tcase_add_test(t, a_zero_that_becomes_a_number_changes_the_equations);
    tcase_add_test(t, hostile_names_stay_in_string_literals);
    tcase_add_loop_test(t, every_refusal_names_the_cause, 0, BAD_END);
    tcase_add_test(t, a_formula_may_be_as_deep_as_the_stack_and_no_deeper);
    tcase_add_test(t, equations_have_up_to_220_bodies);
    tcase_add_test(t, freeing_nothing_is_fine);
    suite_add_tcase(suite, t);
}
