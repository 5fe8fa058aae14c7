/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_digest.c - mechanisms of one structure have the same equations: a program with the equations
 * of one uses them for the other without generating.
 *
 * Model files are changed in places all over the text: a line is left out, a number becomes zero or
 * another one, a letter another one. Of those that can still be read one in three is generated
 * (of the action, one in 23). Each part of a mechanism that was read is changed by
 * itself.
 */
#include <ctype.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "gen.h"
#include "lab_support.h"
#include "mechanism_cases.h"
#include "suites.h"

enum { VARIANTS = 1000, ONE_OF = 3, ONE_OF_LARGE = 23 };

typedef struct variant {
    char structure[17], equations[17];
} variant;

static variant seen[VARIANTS];
static int nseen, is_large;

/* generated for one change in so many */
static int is_skipped(void)
{
    static int turn;
    return ++turn % (is_large ? ONE_OF_LARGE : ONE_OF) != 0;
}

static void add(const char *text)
{
    mechanism *m = NULL;
    gen_result r;
    stein_err why;
    if (is_skipped() || mech_read_text(&m, "changed.yaml", text, strlen(text), NULL, 0, NULL, NULL,
                                       &why) != STEIN_OK) {
        return;
    }
    if (gen_equations(&r, m, &why) == STEIN_OK) {
        ck_assert_int_lt(nseen, VARIANTS);
        gen_structure(m, seen[nseen].structure);
        memcpy(seen[nseen++].equations, r.equations, sizeof r.equations);
        gen_free(&r);
    }
    mech_free(m);
}

/* the text with `n` bytes at `at` replaced */
static void add_changed(const char *text, size_t at, size_t n, const char *by)
{
    char *changed = lab__text("%.*s%s%s", (int)at, text, by, text + at + n);
    ck_assert_ptr_nonnull(changed);
    add(changed);
    free(changed);
}

static void change_everywhere(const char *text)
{
    for (size_t i = 0; text[i] != '\0'; i++) {
        int begins = i == 0 || !(isalnum((unsigned char)text[i - 1]) || text[i - 1] == '.');
        if (begins && isdigit((unsigned char)text[i])) {
            size_t n = strspn(text + i, "0123456789.eE");
            add_changed(text, i, n, "0");
            add_changed(text, i, n, "3.25");
        } else if (begins && isalpha((unsigned char)text[i])) {
            add_changed(text, i, 1, text[i] == 'y' ? "x" : text[i] == 'R' ? "T" : "y");
        }
        if (i == 0 || text[i - 1] == '\n') {
            add_changed(text, i, strcspn(text + i, "\n"), "");
        }
    }
}

static int by_structure(const void *a, const void *b)
{
    const variant *x = a, *y = b;
    int order = strcmp(x->structure, y->structure);
    return order != 0 ? order : strcmp(x->equations, y->equations);
}

static const char *const files[] = {
    "models/pendulum.yaml",        "models/double_pendulum.yaml",
    "models/bouncing_ball.yaml",   "models/block_on_slope.yaml",
    "models/falling_ball.yaml",    "models/emps.yaml",
    "models/newtons_cradle.yaml",  "models/grand_action.yaml",
    "models/robotran/piston.yaml", "models/robotran/piano_tree.yaml",
    "models/stein1788.yaml",
};
enum { FILES = sizeof files / sizeof *files };

START_TEST(mechanisms_of_one_structure_have_the_same_equations)
{
    char *text = NULL;
    size_t size;
    ck_assert_stein(lab__read_file(files[_i], &text, &size, err));
    nseen = 0;
    is_large = size > 4000;
    change_everywhere(text);
    qsort(seen, (size_t)nseen, sizeof *seen, by_structure);
    int structures = nseen > 0, same = 0;
    for (int i = 1; i < nseen; i++) {
        int equal = strcmp(seen[i].structure, seen[i - 1].structure) == 0;
        ck_assert_msg(!equal || strcmp(seen[i].equations, seen[i - 1].equations) == 0,
                      "%s: one structure, two equations", files[_i]);
        same += equal;
        structures += !equal;
    }
    printf("%-32s %4d changed texts, %3d structures\n", files[_i], nseen, structures);
    ck_assert_msg(same >= 10 && structures >= 3, "%d of %d", same, nseen);
    free(text);
}
END_TEST

/* a changed value is none of the structure, a zero is */
START_TEST(values_are_no_structure_and_zeros_are)
{
    static const mech_set other = {"pawl.stop_shift", "-0.3 mm"}, mass = {"hammer.mass", "2 g"},
                          none = {"pawl.centre.x", "0"};
    const mech_set *set[] = {NULL, &other, &mass, &none};
    char hash[4][17];
    for (int i = 0; i < 4; i++) {
        mechanism *m = NULL;
        ck_assert_stein(
            mech_read(&m, "models/stein1788.yaml", set[i], set[i] != NULL, NULL, NULL, err));
        gen_structure(m, hash[i]);
        mech_free(m);
    }
    ck_assert_str_eq(hash[1], hash[0]);
    ck_assert_str_eq(hash[2], hash[0]);
    ck_assert_str_ne(hash[3], hash[0]);
}
END_TEST

/* ---- every part counts ---- */

static char before[17], after[17];

static void counts(const mechanism *m, const char *what)
{
    gen_structure(m, after);
    ck_assert_msg(strcmp(after, before) != 0, "%s is no part of the structure", what);
}

/* each number made of another parameter, and of none */
static void numbers_count(const mechanism *m, mech_scalar *s, int n, const char *what)
{
    for (int i = 0; i < n; i++) {
        mech_scalar was = s[i];
        s[i] = (mech_scalar){.kind = MECH_PARAM, .index = (was.index + 1) % m->nparam};
        counts(m, what);
        s[i] = (mech_scalar){.kind = was.kind == MECH_ZERO ? MECH_FORMULA : MECH_ZERO};
        counts(m, what);
        s[i] = was;
    }
}

static void choice_counts(const mechanism *m, int *choice, const char *what)
{
    *choice += 1;
    counts(m, what);
    *choice -= 1;
}

static void letter_counts(const mechanism *m, char *letter, const char *what)
{
    char was = *letter;
    *letter = was == 'q' ? 'p' : 'q';
    counts(m, what);
    *letter = was;
}

static void params_count(const mechanism *m)
{
    for (int i = 0; i < m->nparam; i++) {
        letter_counts(m, m->params[i].name, "name of a parameter");
        letter_counts(m, m->params[i].unit, "unit of a parameter");
        choice_counts(m, &m->params[i].declared, "declaration");
        stein_range was = m->params[i].range;
        m->params[i].range = was == STEIN_ANY ? STEIN_POSITIVE : STEIN_ANY;
        counts(m, "range of a parameter");
        m->params[i].range = was;
    }
    for (int i = 0; i < m->nformula; i++) {
        mech_formula *f = &m->formulas[i];
        letter_counts(m, f->name, "name of a formula");
        for (int k = 0; k < f->nsteps; k++) {
            mech_step was = f->steps[k];
            choice_counts(m, &f->steps[k].param, "parameter of a formula");
            f->steps[k].value += 1.0;
            counts(m, "number of a formula");
            f->steps[k] = was;
            f->steps[k].op = was.op == MECH_OP_ADD ? MECH_OP_SUB : MECH_OP_ADD;
            counts(m, "operation of a formula");
            f->steps[k] = was;
        }
    }
}

static void bodies_count(const mechanism *m)
{
    for (int i = 0; i < m->nbody; i++) {
        mech_body *b = &m->bodies[i];
        letter_counts(m, b->name, "name of a body");
        choice_counts(m, &b->parent, "parent");
        choice_counts(m, &b->part, "piece of a body");
        choice_counts(m, &b->sign, "sign of a joint");
        letter_counts(m, &b->type, "type of a joint");
        letter_counts(m, &b->axis, "axis of a joint");
        numbers_count(m, b->at, 3, "place of a joint");
        numbers_count(m, &b->mass, 1, "mass");
        numbers_count(m, b->centre, 3, "centre");
        numbers_count(m, b->inertia, 6, "inertia");
        numbers_count(m, &b->armature, 1, "armature");
        numbers_count(m, b->joint, STEIN_JOINT_SIZE, "forces of a joint");
        numbers_count(m, &b->q0, 1, "position in the beginning");
        numbers_count(m, &b->qd0, 1, "speed in the beginning");
    }
    for (int i = 0; i < m->npoint; i++) {
        letter_counts(m, m->points[i].name, "name of a point");
        choice_counts(m, &m->points[i].body, "body of a point");
        numbers_count(m, m->points[i].at, 3, "place of a point");
    }
}

static void shape_counts(const mechanism *m, mech_shape *s)
{
    choice_counts(m, &s->body, "body of a shape");
    choice_counts(m, &s->is_line, "line or circle");
    choice_counts(m, &s->has_extent, "extent");
    choice_counts(m, &s->end, "end of a line");
    numbers_count(m, s->at, 3, "place of a shape");
    numbers_count(m, &s->radius, 1, "radius");
    numbers_count(m, &s->facing, 1, "facing");
    numbers_count(m, s->extent, 2, "extent");
}

static void contacts_count(const mechanism *m)
{
    for (int i = 0; i < m->ncontact; i++) {
        mech_contact *c = &m->contacts[i];
        letter_counts(m, c->name, "name of a contact");
        for (int k = 0; k < c->nspot; k++) {
            shape_counts(m, &c->spot[k].side[0]);
            shape_counts(m, &c->spot[k].side[1]);
        }
        numbers_count(m, c->normal.v, STEIN_NORMAL_SIZE, "normal law");
        numbers_count(m, c->friction.v, STEIN_FRICTION_SIZE, "friction");
    }
    for (int i = 0; i < m->nnotch; i++) {
        mech_notch *n = &m->notches[i];
        letter_counts(m, n->name, "name of a notch");
        choice_counts(m, &n->catcher, "catcher");
        choice_counts(m, &n->beak, "beak");
        numbers_count(m, n->corner, 3, "corner");
        numbers_count(m, &n->lean, 1, "lean");
        numbers_count(m, &n->angle, 1, "angle");
        numbers_count(m, n->end, 3, "end");
        numbers_count(m, &n->tilt, 1, "tilt");
        numbers_count(m, n->normal.v, STEIN_NORMAL_SIZE, "normal law of a notch");
        numbers_count(m, n->friction.v, STEIN_FRICTION_SIZE, "friction of a notch");
    }
}

static void laws_and_signals_count(const mechanism *m)
{
    for (int i = 0; i < m->nlink; i++) {
        letter_counts(m, m->links[i].name, "name of a link");
        choice_counts(m, &m->links[i].point[0], "beginning of a link");
        choice_counts(m, &m->links[i].point[1], "end of a link");
        numbers_count(m, m->links[i].law, STEIN_LINK_SIZE, "law of a link");
    }
    for (int i = 0; i < m->ntable; i++) {
        letter_counts(m, m->tables[i].name, "name of a table");
        choice_counts(m, &m->tables[i].kind, "kind of a table");
        choice_counts(m, &m->tables[i].index, "place of a table");
        numbers_count(m, m->tables[i].v, 2 * m->tables[i].n, "table");
    }
    for (int i = 0; i < m->ninput; i++) {
        mech_input *s = &m->inputs[i];
        letter_counts(m, s->name, "name of an input");
        letter_counts(m, s->unit, "unit of an input");
        choice_counts(m, &s->kind, "kind of an input");
        choice_counts(m, &s->index, "place of an input");
        choice_counts(m, &s->hold, "what an input does when idle");
        numbers_count(m, s->direction, 3, "direction");
        numbers_count(m, s->signal, STEIN_SIGNAL_SIZE, "signal");
    }
    for (int i = 0; i < m->nchannel; i++) {
        mech_channel *c = &m->channels[i];
        letter_counts(m, c->name, "name of an output");
        letter_counts(m, c->unit, "unit of an output");
        choice_counts(m, &c->read, "what an output reads");
        choice_counts(m, &c->index, "of what an output reads");
        choice_counts(m, &c->sign, "sign of an output");
        choice_counts(m, &c->from_rest, "zero of an output");
        numbers_count(m, c->sensor, STEIN_SENSOR_SIZE, "sensor");
    }
}

static const char curve[] = "tables:\n  coil: {joint: pawl, of: position, at: [-0.1 rad, 0.1 rad],"
                            " torque: [0.31 N m, -0.2 N m]}\n"
                            "points:\n  anchor";

START_TEST(every_part_of_a_mechanism_is_part_of_its_structure)
{
    char *text = changed("points:\n  anchor", curve);
    mechanism *m = read_ok(text, NULL, 0);
    ck_assert(m->nlink > 0 && m->nnotch > 0 && m->ntable > 0 && m->nformula > 0);
    gen_structure(m, before);
    params_count(m);
    bodies_count(m);
    contacts_count(m);
    laws_and_signals_count(m);
    numbers_count(m, m->gravity, 3, "gravity");
    numbers_count(m, &m->clock_error, 1, "clock");
    letter_counts(m, m->name, "name");
    choice_counts(m, &m->load_body, "load");
    choice_counts(m, &m->load_contact, "contact of the load");
    choice_counts(m, &m->stroke_string, "string");
    choice_counts(m, &m->stroke_notch, "notch");
    gen_structure(m, after);
    ck_assert_str_eq(after, before); // nothing changed
    mech_free(m);
    free(text);
}
END_TEST

START_TEST(built_in_equations_are_found_by_their_structure)
{
    int n = 0;
    for (const lab__structure *s = lab__structures; s->hash != NULL; s++, n++) {
        char path[100];
        mechanism *m = NULL;
        ck_assert_ptr_eq(s->model, stein_models[n]);
        snprintf(path, sizeof path, "models/%s.yaml", s->model->name);
        if (access(path, R_OK) != 0) {
            snprintf(path, sizeof path, "models/robotran/%s.yaml", s->model->name);
        }
        ck_assert_stein(mech_read(&m, path, NULL, 0, NULL, NULL, err));
        gen_structure(m, after);
        ck_assert_str_eq(s->hash, after);
        mech_free(m);
    }
    ck_assert_ptr_null(stein_models[n]);
}
END_TEST

Suite *digest_suite(void)
{
    Suite *suite = suite_create("digest");
    TCase *tc = tcase_create("structure");
    tcase_set_timeout(tc, 60);
    tcase_add_loop_test(tc, mechanisms_of_one_structure_have_the_same_equations, 0, FILES);
    tcase_add_test(tc, values_are_no_structure_and_zeros_are);
    tcase_add_test(tc, every_part_of_a_mechanism_is_part_of_its_structure);
    tcase_add_test(tc, built_in_equations_are_found_by_their_structure);
    suite_add_tcase(suite, tc);
    return suite;
}
