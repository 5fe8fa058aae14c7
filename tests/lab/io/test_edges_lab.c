/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_edges_lab.c - edge cases of input: the largest possible and empty projects of other
 * programs; mechanisms that no file holds; rows that belong to no table; records with columns
 * without information.
 */
#include "data_support.h"
#include "gen.h"
#include "mechanism_cases.h"
#include "stein/import.h"

/* ---- projects ---- */

#define JOINT    "<joint><jointname>j%d</jointname><type>T1</type></joint>"
#define POINT    "<point><pointname>p%d</pointname></point>"
#define BODY_END "<parent><bodyname>base</bodyname></parent><mass> 1.5 </mass>"

/* a project with something in its tree, `n` times */
static const char *project(const char *before, const char *each, int n, const char *after)
{
    const char *path = in_folder("p.mbs");
    FILE *f = fopen(path, "w");
    ck_assert_ptr_nonnull(f);
    fprintf(f, "<mbsDescR7><mbsname>p</mbsname><bodytree>%s", before);
    for (int i = 0; i < n; i++) {
        for (const char *s = each; *s != '\0'; s++) { // %d is the number of it
            int number = s[0] == '%' && s[1] == 'd';
            number ? fprintf(f, "%d", i) : fputc(*s, f);
            s += number;
        }
    }
    fprintf(f, "%s</bodytree></mbsDescR7>", after);
    ck_assert_int_eq(fclose(f), 0);
    return path;
}

static void refuse_project(const char *path, const char *says)
{
    stein_err why = {STEIN_OK, ""};
    const char *to = in_folder("never.yaml");
    ck_assert_int_eq(lab_import(path, to, LAB_INERTIA_REFUSE, NULL, NULL, NULL, &why),
                     STEIN_EPARSE);
    ck_assert_msg(strncmp(why.msg, path, strlen(path)) == 0 && strstr(why.msg, says) != NULL,
                  "%s, expected \"%s\"", why.msg, says);
    ck_assert_int_ne(access(to, F_OK), 0);
}

START_TEST(an_incomplete_project_is_refused)
{
    static const struct {
        const char *text, *says;
    } bad[] = {
        {"<other/>", ":1:1: <other>, expected <mbsDescR7>, a project of ROBOTRAN"},
        {"<mbsDescR7/>", ":1:1: <mbsDescR7> without a <bodytree>, expected a project of ROBOTRAN"},
        {"<mbsDescR7><bodytree/></mbsDescR7>", ":1:12: <bodytree> without a <body>"},
        {"<mbsDescR7><base><gravity><coordinates><z>down</z></coordinates></gravity></base>"
         "<bodytree/></mbsDescR7>",
         "<z> is \"down\", expected a number"},
        {"<mbsDescR7><base><point><pointname> </pointname></point></base><bodytree/></mbsDescR7>",
         "<point> without a <pointname>"},
        {"<mbsDescR7><bodytree><body><bodyname>b</bodyname></body></bodytree></mbsDescR7>",
         "body \"b\" has no joint"},
        {"<mbsDescR7><bodytree><body><bodyname>b</bodyname><joint><jointname>j</jointname>"
         "<type>T1</type></joint><mass>m</mass></body></bodytree></mbsDescR7>",
         "<mass> is \"m\", expected a number"},
        {"<mbsDescR7><bodytree><body><bodyname>b</bodyname><joint><jointname>j</jointname>"
         "<type>T1</type><initialvalue><qd>x</qd></initialvalue></joint></body></bodytree>"
         "</mbsDescR7>",
         "<qd> is \"x\", expected a number"},
        {"<mbsDescR7><bodytree><body><bodyname>b</bodyname><joint><jointname>j</jointname>"
         "<type>T1</type></joint><parent/></body></bodytree></mbsDescR7>",
         "<parent> without a <bodyname>"},
        {"", "this is no XML file"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        refuse_project(write_file("bad.mbs", bad[i].text), bad[i].says);
    }
}
END_TEST

START_TEST(a_project_can_be_so_large_and_no_larger)
{
    static const struct {
        const char *before, *each, *after, *says;
        int most; /* that are read */
    } limit[] = {
        {"", "<body><bodyname>b%d</bodyname>" JOINT BODY_END "</body>", "", "more than 220 bodies",
         220},
        {"<body><bodyname>b</bodyname>" BODY_END, JOINT, "</body>", "more than 220 bodies", 220},
        {"<body><bodyname>b</bodyname><joint><jointname>j</jointname><type>T1</type></"
         "joint>" BODY_END,
         POINT, "</body>", "more than 256 points", 256},
    };
    for (size_t i = 0; i < sizeof limit / sizeof *limit; i++) {
        int n = limit[i].most;
        const char *path = project(limit[i].before, limit[i].each, n, limit[i].after);
        lab_imported done;
        stein_err why = {STEIN_OK, ""};
        stein_status status =
            lab_import(path, in_folder("large.yaml"), LAB_INERTIA_REFUSE, NULL, NULL, &done, &why);
        if (i == 1) { // so many joints are read, and then do not carry a mass each
            ck_assert_int_eq(status, STEIN_EPARSE);
            ck_assert_ptr_nonnull(strstr(why.msg, "has no inertia to move"));
        } else {
            ck_assert_msg(status == STEIN_OK, "%s", why.msg);
            ck_assert_int_eq(i == 0 ? done.bodies : done.points, n);
        }
        refuse_project(project(limit[i].before, limit[i].each, n + 1, limit[i].after),
                       limit[i].says);
    }
}
END_TEST

START_TEST(a_project_of_more_than_8_mib_is_not_read)
{
    const char *path = in_folder("huge.mbs");
    FILE *f = fopen(path, "w");
    ck_assert_ptr_nonnull(f);
    ck_assert(fputs("<mbsDescR7>", f) >= 0 && fseek(f, 8 << 20, SEEK_SET) == 0);
    ck_assert(fputc(' ', f) == ' ' && fclose(f) == 0);
    refuse_project(path, ": more than 8 MiB");
}
END_TEST

static char notes[2000];

static void keep_note(void *ctx, const char *message)
{
    size_t n = strlen(notes);
    (void)ctx;
    snprintf(notes + n, sizeof notes - n, "%s\n", message);
}

/* duplicate names, names of C, characters that no name has; two that are the same in the end */
START_TEST(names_of_a_project_become_names_of_a_file)
{
    const char *path = write_file(
        "names.mbs",
        "<mbsDescR7><bodytree>"
        "<body><bodyname>double</bodyname><joint><jointname>2nd</jointname><type>T1</type>"
        "<nature>locked</nature></joint><joint><jointname>double</jointname><type>T2</type></joint>"
        "<parent><bodyname>base</bodyname></parent><mass>\n\t2.5\r\n</mass></body>"
        "<body><bodyname>double_</bodyname><joint><jointname>2nd</jointname><type>T3</type>"
        "</joint><parent><bodyname>double</bodyname></parent><mass>1</mass></body>"
        "<body><bodyname>n2nd</bodyname><joint><jointname>Z</jointname><type>T3</type>"
        "</joint><parent><bodyname>double</bodyname></parent><mass>1</mass></body>"
        "</bodytree></mbsDescR7>");
    lab_imported done;
    char *text = NULL;
    size_t size;
    notes[0] = '\0';
    ck_assert_stein(
        lab_import(path, in_folder("names.yaml"), LAB_INERTIA_REFUSE, keep_note, NULL, &done, err));
    ck_assert_str_eq(done.name, "imported"); // it has none
    static const char *const told[] = {
        "body \"double\" is called double_ here", "body \"double_\" is called double__2 here",
        "joint \"2nd\" is called n2nd here", "joint \"2nd\" is called n2nd_2 here"};
    for (size_t i = 0; i < sizeof told / sizeof *told; i++) {
        ck_assert_msg(strstr(notes, told[i]) != NULL, "%s in %s", told[i], notes);
    }
    ck_assert_stein(lab__read_file(in_folder("names.yaml"), &text, &size, err));
    ck_assert_ptr_nonnull(strstr(text, "mass: 2.5\n"));
    free(text);
}
END_TEST

/* ---- mechanisms that no file holds ---- */

static mech_step *first_parameter(mechanism *m)
{
    for (int i = 0; i < m->nformula; i++) {
        for (int k = 0; k < m->formulas[i].nsteps; k++) {
            if (m->formulas[i].steps[k].op == MECH_OP_PARAM) {
                return &m->formulas[i].steps[k];
            }
        }
    }
    ck_abort_msg("no formula with a parameter");
    return NULL;
}

/* @return the expected message of the generator */
static const char *spoil(mechanism *m, int what)
{
    mech_body *b = &m->bodies[1];
    const mech_scalar below = {MECH_PARAM, -1, 0.0}, above = {MECH_PARAM, m->nparam, 0.0};
    const mech_scalar no_formula = {MECH_FORMULA, m->nformula, 0.0};
    mech_scalar *const number[] = {&b->at[2],      &b->mass, &b->centre[1],
                                   &b->inertia[5], &b->q0,   &b->qd0};
    if (what < 18) {
        *number[what / 3] = what % 3 == 0 ? below : what % 3 == 1 ? above : no_formula;
        return "body 1: a number refers to no parameter";
    }
    switch (what) {
    case 18: m->name[0] = '\0'; return "no identifier";
    case 19: m->name[0] = '7'; return "no identifier";
    case 20: memset(m->name, 'a', sizeof m->name); return "no identifier";
    case 21: first_parameter(m)->param = -1; return "formula is not well formed";
    case 22: first_parameter(m)->param = m->nparam; return "formula is not well formed";
    case 23: b->parent = -2; return "body 1: its parent must come before it";
    case 24: b->axis = 'x' - 1; return "a joint is R or T with axis x, y or z";
    case 25: b->axis = 'z' + 1; return "a joint is R or T with axis x, y or z";
    case 26: b->sign = 2; return "a joint is R or T with axis x, y or z";
    case 27: m->contacts[0].spot[0].side[0].body = -2; return "string: it refers to no body";
    case 28: m->contacts[0].nspot = 0; return "string: a contact has 1 to 8 spots";
    case 29: m->notches[0].catcher = -2; return "notch: it refers to no body";
    case 30: m->points[0].body = -2; return "it refers to no body";
    case 31: m->inputs[0].index = -1; return "finger: the input acts on nothing";
    case 32: m->inputs[1].index = m->nbody; return "drive: the input acts on nothing";
    case 33: m->links[0].point[1] = -1; return "tie: it refers to no point";
    default: m->nbody = 221; return "221 bodies, expected 1 to 220";
    }
}
enum { SPOILT = 35 };

START_TEST(a_mechanism_that_is_not_in_order_has_no_equations)
{
    mechanism *m = read_ok(good, NULL, 0);
    gen_result r = {.size = 4711};
    stein_err why = {STEIN_OK, ""};
    mechanism whole = *m;
    const char *says = spoil(m, _i);
    ck_assert_int_eq(gen_equations(&r, m, &why), STEIN_EGENERATE);
    ck_assert_int_eq(why.code, STEIN_EGENERATE);
    ck_assert_msg(strstr(why.msg, says) != NULL, "%s, expected \"%s\"", why.msg, says);
    ck_assert_uint_eq(r.size, 4711);
    m->nbody = whole.nbody;
    mech_free(m);
}
END_TEST

/* ---- tables ---- */

START_TEST(a_row_belongs_to_its_table_or_to_none)
{
    static const char head[] = "# vary a.b [m]: 0:0.1:2 mm\npoint,a.b [m],status,height [m]\n";
    static const char *const bad[] = {"",        "x,0,ok,1",   "-1,0,ok,1",        "2,0,ok,1",
                                      "1",       "1;0;ok;1",   "1,0,ok,1,",        "1,0,ok",
                                      ",0,ok,1", "0x1,0,ok,1", "0000000001,0,ok,1"};
    lab_table *table = NULL;
    stein_err why;
    ck_assert_stein(lab__table_new(&table, head, err));
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        ck_assert_msg(lab__table_take(table, bad[i], strlen(bad[i]), &why) == STEIN_EPARSE,
                      "accepted: %s", bad[i]);
        ck_assert_str_eq(why.msg, "this is no row of the sweep");
    }
    ck_assert_int_eq(lab__table_take(table, "1,0\0ok,,1", 9, &why), STEIN_EPARSE);
    ck_assert_stein(lab__table_take(table, "1,0.0001,ok,7.5e-3", 18, err));
    ck_assert_stein(lab__table_take(table, "1,0.0001,ok,7.5e-3", 18, err)); // the same again
    ck_assert_int_eq(lab__table_take(table, "1,0.0001,ok,7.5e-4", 18, &why), STEIN_EINVAL);
    ck_assert_str_eq(why.msg, "point 1 has two different results");
    ck_assert_int_eq(lab_table_has(table, -1), 0);
    ck_assert_int_eq(lab_table_has(table, 0), 0);
    ck_assert_int_eq(lab_table_has(table, 1), 1);
    ck_assert_int_eq(lab_table_has(table, 2), 0);
    int height = lab__table_column(table, "height");
    ck_assert_int_eq(height, 3);
    ck_assert_int_eq(lab__table_column(table, "heigh"), -1);
    ck_assert(lab__table_number(table, 1, height) == 7.5e-3);
    ck_assert(isnan(lab__table_number(table, 0, height)));
    ck_assert(isnan(lab__table_number(table, 1, -1)));
    ck_assert(isnan(lab__table_number(table, 1, 2))); // "ok"
    ck_assert_int_eq(lab__table_ok(table, 1), 1);
    ck_assert_int_eq(lab__table_ok(table, 0), 0);
    lab_table_destroy(table);
}
END_TEST

START_TEST(a_head_that_no_sweep_wrote_is_refused)
{
    static const char *const bad[] = {
        "",
        "# vary a.b [m]: 0:0.1:2 mm\n",
        "# vary a.b: 0:0.1:2 mm\npoint,a.b,status\n",
        "# vary a.b [m] 0:0.1:2 mm\npoint,a.b,status\n",
        "# vary a.b ]: [m\npoint,a.b,status\n",
        "# vary a.b [m]: 0:0.1:2 s\npoint,a.b,status\n",
        "points,a.b,status\n",
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        lab_table *table = NULL;
        stein_err why = {STEIN_OK, ""};
        ck_assert_msg(lab__table_new(&table, bad[i], &why) != STEIN_OK, "accepted: %s", bad[i]);
        ck_assert_int_ne(why.msg[0], '\0');
        ck_assert_ptr_null(table);
    }
}
END_TEST

/* ---- records ---- */

START_TEST(a_force_that_is_always_0_is_information)
{
    lab_data *d = open_data(
        write_file("none.csv", "time [s],string_force [N],hammer_height [mm],notch_force [N]\n"
                               "0,0,1,0\n1,0,2,0\n2,0,1,0\n3,0,4,0\n4,0,3,0\n5,0,3,0\n"),
        &stein_model_stein1788);
    ck_assert_int_eq(d->ncolumn, 3);
    ck_assert_int_eq(d->nrow, 6);
    lab_data_close(d);
}
END_TEST

START_TEST(a_dataset_needs_a_file_and_reports_unreadable_ones)
{
    lab_data_options o = lab_data_options_default(&stein_model_stein1788);
    lab_dataset *set = NULL;
    stein_err why = {STEIN_OK, ""};
    said heard = {.n = 0};
    ck_assert_int_eq(lab_dataset_open(&set, NULL, 0, &o, &why), STEIN_EINVAL);
    ck_assert_str_eq(why.msg, "no data files");
    char *none = lab__text("%s/none.csv", folder);
    const char *const file[] = {none, folder};
    ck_assert_int_eq(lab_dataset_open(&set, file, 2, &o, &why), STEIN_EIO);
    ck_assert_ptr_nonnull(strstr(why.msg, none)); // the first of them
    o.report = hear;
    o.ctx = &heard;
    ck_assert_int_eq(lab_dataset_open(&set, file, 2, &o, &why), STEIN_EIO);
    ck_assert_int_eq(heard.n, 2);
    ck_assert_ptr_null(set);
    free(none);
}
END_TEST

Suite *edges_lab_suite(void)
{
    Suite *suite = suite_create("edges_lab");
    TCase *tc = tcase_create("edges_lab");
    tcase_add_checked_fixture(tc, make_folder, remove_folder);
    tcase_set_timeout(tc, 60.0);
    tcase_add_test(tc, an_incomplete_project_is_refused);
    tcase_add_test(tc, a_project_can_be_so_large_and_no_larger);
    tcase_add_test(tc, a_project_of_more_than_8_mib_is_not_read);
    tcase_add_test(tc, names_of_a_project_become_names_of_a_file);
    tcase_add_loop_test(tc, a_mechanism_that_is_not_in_order_has_no_equations, 0, SPOILT);
    tcase_add_test(tc, a_row_belongs_to_its_table_or_to_none);
    tcase_add_test(tc, a_head_that_no_sweep_wrote_is_refused);
    tcase_add_test(tc, a_force_that_is_always_0_is_information);
    tcase_add_test(tc, a_dataset_needs_a_file_and_reports_unreadable_ones);
    suite_add_tcase(suite, tc);
    return suite;
}
