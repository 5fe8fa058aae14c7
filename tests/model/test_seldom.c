/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_seldom.c - what files seldom hold: rare mistakes, rare forms, ends of files and limits of
 * sizes. Each is either read correctly or refused by file, line and field.
 */
#include "data_support.h"
#include "mechanism_cases.h"

/* ---- mechanism files ---- */

START_TEST(rare_mistakes_of_a_mechanism_are_refused_with_their_place)
{
    static const refusal r[] = {
        {"radius: 1.9 mm", "radius: \"(1.9 mm), 2\"", "\"(1.9", "a comma in a number"},
        {"radius: 1.9 mm", "radius: 1 mm / 1 m^9 / 1 m^9 / 1 m^9 / 1 m^9 / 1 m^9 / 1 m^9 / 1 m^9",
         "/ 1 m^9}", "powers of the unit become too large"},
        {"radius: 1.9 mm", "radius: inf * 1 mm", "inf *", "finite"},
        {"radius: 1.9 mm", "radius: 1.9 m^21", "m^21", "powers of the unit are too large"},
        {"radius: 1.9 mm", "radius: 1.9 m^9999999999", "m^9999", "powers of the unit"},
        {"radius: 1.9 mm", "radius: 1.9 kg^15 kg^15", "kg^15}", "powers of the unit"},
        {"radius: 1.9 mm", "radius: 1.9 s^15 s^15", "s^15}", "powers of the unit"},
        {"radius: 1.9 mm", "radius: 1.9 rad^15 rad^15", "rad^15}", "powers of the unit"},
        {"angle: 89 deg", "angle: 0 deg", "0 deg}\n    beak", "between 0 and 180 deg"},
        {"links:\n  tie: {from: frame.anchor, to: key.front, k: 93 N/m, length: 0.127 m}\n",
         "links: none\n", "none\n", "expected a mapping from names to"},
        {"  pawl.stop_shift: 0.31 mm", "  pawl.stop_shift: 0.31 mm\n  key.extra: [1 mm]", "[1 mm]",
         "key.extra must be a single number with its unit"},
        {"{point: hammer.head}", "{point: hammer.head, colour: red}", "colour",
         "unknown key \"colour\" in a side of a contact"},
        {"tilt: -0.011 rad}", "tilt: -0.011 rad, colour: red}", "colour", "unknown key \"colour\""},
        {"read: vz,", "read: vz, colour: red,", "colour", "unknown key \"colour\" in an output"},
        {"  effort:", "  motion: {energy: kinetic, read: gap}\n  effort:", "read: gap}\n  effort",
         "unknown key \"read\" in an output of energy"},
        {"  effort:", "  motion: kinetic\n  effort:", "kinetic", "an output must be a mapping"},
        {"    inertia: {yy: 3.17e-6 kg m^2}\n",
         "    pendulum: {frequency: 2 Hz, gravitation: 1 m/s^2}\n", "gravitation",
         "unknown key \"gravitation\" in pendulum, expected one of frequency period gravity"},
        {"stroke:", "regulation: {pawl.stop_shift: {from: 0 mm, to: 1 kg}}\nstroke:", "1 kg",
         "to of pawl.stop_shift|the unit is kg, expected m"},
        {"stroke:", "regulation: {nowhere.near.that: {from: 0 mm, to: 1 mm}}\nstroke:", "nowhere",
         "there is no parameter \"nowhere.near.that\" to regulate"},
        {"stroke:", "regulation: {pawl.stop_shift: {from: [0 mm], to: 1 mm}}\nstroke:", "[0 mm]",
         "found a list"},
        {"inputs:\n",
         "tables: {t: {notch: nutch, of: rate, at: [0, 1], factor: [0, 1]}}\ninputs:\n", "nutch",
         "there is no notch \"nutch\", did you mean \"notch\"?"},
    };

    REFUSE_ALL(r);
}
END_TEST

START_TEST(an_entry_that_is_no_mapping_or_has_no_place_is_refused)
{
    static const refusal whole[] = {
        {NULL, "mechanism: m\nparameters: 3\nbodies: {b: {joint: T z, mass: 1 kg}}\n", "3\n",
         "expected a mapping from names (owner.name) to numbers"},
        {NULL, "mechanism: m\nbodies: [b]\n", "[b]", "expected a mapping from names to a body"},
        {NULL, "mechanism: m\nbodies: {b: {joint: T z, mass: 1 kg, pendulum: {frequency: 1 Hz}}}\n",
         "pendulum", "a pendulum test needs a joint about y, expected inertia"},
        {NULL, "mechanism: m\nbodies: {b: {joint: R x, mass: 1 kg, pendulum: {frequency: 1 Hz}}}\n",
         "pendulum", "a pendulum test needs a joint about y, expected inertia"},
    };
    for (size_t i = 0; i < sizeof whole / sizeof *whole; i++) {
        refuse_text(whole[i].to, strlen(whole[i].to), NULL, 0, whole[i].at, whole[i].words);
    }
}
END_TEST

/* names are cut between letters, what cannot be printed is a question mark */
START_TEST(quotes_of_a_file_are_short_and_printable)
{
    char name[200], expected[200], text[600];
    memset(name, 'a', 59);
    strcpy(name + 59, "\xC3\xA9\xC3\xA9\xC3\xA9"); // the 60th byte is the first of two
    snprintf(expected, sizeof expected, "there is no body \"%.59s...\"", name);
    snprintf(text, sizeof text, "mechanism: m\nbodies: {b: {joint: T z, mass: 1 kg, parent: %s}}\n",
             name);
    refuse_text(text, strlen(text), NULL, 0, "aaa", expected);
    static const char odd[] =
        "mechanism: m\nbodies: {b: {joint: T z, mass: 1 kg, parent: \"k\\x7fy\\x01\"}}\n";
    refuse_text(odd, sizeof odd - 1, NULL, 0, "\"k", "there is no body \"k?y?\"");
}
END_TEST

START_TEST(a_mechanism_has_no_more_points_than_it_can)
{
    size_t room = 20000, n;
    char *text = malloc(room);
    ck_assert_ptr_nonnull(text);
    n = (size_t)snprintf(text, room,
                         "mechanism: m\nbodies:\n  b:\n    joint: T z\n    mass: 1 kg\n"
                         "    points:\n");
    for (int i = 0; i < 256; i++) {
        n += (size_t)snprintf(text + n, room - n, "      p%d: [%d mm, 0, 0]\n", i, i);
    }
    mechanism *m = read_ok(text, NULL, 0);
    ck_assert_int_eq(m->npoint, 256);
    mech_free(m);
    snprintf(text + n, room - n, "points: {last: [0, 0, 1 m]}\n");
    refuse_text(text, strlen(text), NULL, 0, "last", "more than 256 points");
    free(text);
}
END_TEST

/* parts of parts, each with its own formula: the rest of the whole is longer than can be kept
 */
START_TEST(the_rest_of_a_body_may_be_too_long_a_formula)
{
    char sum[3000] = "2 kg", text[9000];
    for (int i = 0; i < 127; i++) {
        strcat(sum, " + a.bit");
    }
    snprintf(text, sizeof text,
             "mechanism: m\nparameters: {a.bit: 1 g}\nbodies:\n"
             "  a: {joint: R y, mass: %s, centre: [a.bit * (1 m / (1 kg)), 0, 0],"
             " inertia: {yy: 1 kg m^2}}\n"
             "  b: {part_of: a, joint: R y, mass: %s, centre: [0.1 m, 0, 0],"
             " inertia: {yy: 0.1 kg m^2}}\n",
             sum, sum + 7);
    stein_err err = {STEIN_OK, ""};
    mechanism *m = NULL;
    log_t log = {"", 0};
    ck_assert_int_eq(
        mech_read_text(&m, "demo.yaml", text, strlen(text), NULL, 0, record, &log, &err),
        STEIN_EPARSE);
    ck_assert_msg(strstr(log.first, "the formula is too long") != NULL, "%s", log.first);
    ck_assert_ptr_null(m);
}
END_TEST

static double param(const mechanism *m, const char *name, double *tolerance)
{
    int i = mech_find_param(m, name, NULL);
    ck_assert_msg(i >= 0, "%s", name);
    *tolerance = m->params[i].tolerance;
    return m->params[i].value;
}

START_TEST(a_tolerance_may_be_written_with_its_sign)
{
    double plus_minus, sign;
    char *text = changed("71.3 g +- 2 %", "71.3 g \xC2\xB1 2 %");
    mechanism *m = read_ok(text, NULL, 0), *same = read_ok(good, NULL, 0);
    ck_assert(param(m, "key.mass", &sign) == param(same, "key.mass", &plus_minus));
    ck_assert_close(sign, 0.02 * 71.3e-3, 1e-12, 0.0);
    ck_assert(sign == plus_minus);
    mech_free(m);
    mech_free(same);
    free(text);
}
END_TEST

START_TEST(a_pendulum_test_may_have_been_made_elsewhere)
{
    const double g = 1.62, nu = 0.61, d = 0.1, pi = 3.14159265358979323846;
    mechanism *m = read_ok("mechanism: m\nbodies:\n  b:\n    joint: R y\n    mass: 0.3 kg\n"
                           "    centre: [0.1 m, 0, 0]\n"
                           "    pendulum: {frequency: 0.61 Hz, gravity: 1.62 m/s^2}\n",
                           NULL, 0);
    double none;
    ck_assert_close(m->bodies[0].inertia[1].value,
                    0.3 * (g * d / (4.0 * pi * pi * nu * nu) - d * d), 1e-12, 0.0);
    ck_assert(param(m, "b.pendulum.gravity", &none) == g);
    mech_free(m);
}
END_TEST

START_TEST(a_pendulum_test_may_state_its_period)
{
    static const char *const of[] = {"frequency: 0.625 Hz +- 0.0125 Hz", "period: 1.6 s +- 32 ms"};
    static const char *const name[] = {"b.pendulum.frequency", "b.pendulum.period"};
    double inertia[2], none;
    for (int i = 0; i < 2; i++) {
        char text[300];
        snprintf(text, sizeof text,
                 "mechanism: m\nbodies:\n  b:\n    joint: R y\n    mass: 0.3 kg\n"
                 "    centre: [0.1 m, 0, 0]\n    pendulum: {%s}\n",
                 of[i]);
        mechanism *m = read_ok(text, NULL, 0);
        inertia[i] = m->bodies[0].inertia[1].value;
        ck_assert(param(m, name[i], &none) == (i == 0 ? 0.625 : 1.6));
        mech_free(m);
    }
    ck_assert_close(inertia[1], inertia[0], 1e-12, 0.0);
}
END_TEST

START_TEST(a_sliding_joint_has_tables_of_forces)
{
    mechanism *m = read_ok("mechanism: m\nbodies: {b: {joint: T x, mass: 1 kg}}\n"
                           "tables:\n"
                           "  brake: {joint: b, of: speed, at: [0, 1 mm/s], force: [0, -2 N]}\n"
                           "  spring: {joint: b, of: position, at: [0, 3 mm], force: [0, -4 mN]}\n",
                           NULL, 0);
    double none;
    ck_assert(param(m, "brake.at.2", &none) == 1e-3 && param(m, "brake.force.2", &none) == -2.0);
    ck_assert(param(m, "spring.at.2", &none) == 3e-3);
    ck_assert(param(m, "spring.force.2", &none) == -4e-3);
    mech_free(m);
}
END_TEST

START_TEST(every_kind_of_output_has_a_row_and_words_of_its_own)
{
    for (int i = 0; i < STEIN_READ_KINDS; i++) {
        const mech_output_kind *k = mech_output_kind_of(i);
        ck_assert_msg(k->word != NULL && *k->word != '\0' && *k->about != '\0', "kind %d", i);
        for (int j = 0; j < i; j++) {
            const mech_output_kind *other = mech_output_kind_of(j);
            ck_assert_msg(strcmp(k->name, other->name) != 0, "%s", k->name);
            ck_assert_msg(k->of != other->of || strcmp(k->word, other->word) != 0, "%s", k->word);
        }
    }
}
END_TEST

START_TEST(an_input_can_be_read_in_its_own_unit)
{
    char *text = changed("  effort:", "  push: {input: finger, read: value}\n  effort:");
    mechanism *m = read_ok(text, NULL, 0);
    int seen = 0;
    for (int i = 0; i < m->nchannel; i++) {
        if (strcmp(m->channels[i].name, "push") == 0) {
            ck_assert_str_eq(m->channels[i].unit, "N");
            ck_assert_str_eq(mech_target(m, &m->channels[i]), "finger");
            seen++;
        } else if (strcmp(m->channels[i].name, "dip") == 0) {
            ck_assert_str_eq(mech_target(m, &m->channels[i]), "key.front");
        }
    }
    ck_assert_int_eq(seen, 1);
    mech_free(m);
    free(text);
}
END_TEST

/* ---- data ---- */

#define HEAD "time [s],key_dip [mm]\n"

START_TEST(rare_mistakes_of_data_are_refused_with_their_place)
{
    static const bad_data bad[] = {
        {"\xfe\xfft\n", ":1:1: ", "UTF-16"},
        {HEAD "0,1\n1,1e\n2,2\n3,1\n4,5\n", ":3:3: ", "expected a number"},
        {HEAD "0,1\n1,1e+\n2,2\n3,1\n4,5\n", ":3:3: ", "expected a number"},
        {HEAD "0,1\n1,1ex\n2,2\n3,1\n4,5\n", ":3:3: ", "expected a number"},
        {HEAD "0,1\n1,1e99999999999\n2,2\n3,1\n4,5\n", ":3:3: ", "too large"},
        {HEAD "0,1\n1,.\n2,2\n3,1\n4,5\n", ":3:3: ", "expected a number"},
        {HEAD "0,1\n1,\"2\" 3\n2,2\n3,1\n4,5\n", ":3:3: ", "quotes"},
        {HEAD "0,1\n1,\"2;3\"\n2,2\n3,1\n4,5\n", ":3:3: ", "separated by \";\""},
        {HEAD "0,1\n1,+inf\n2,2\n3,1\n4,5\n", ":3:3: ", "a missing sample is an empty cell"},
        {HEAD "0,1\n1,-nan\n2,2\n3,1\n4,5\n", ":3:3: ", "a missing sample is an empty cell"},
        {HEAD "0,1\n1,--\n2,2\n3,1\n4,5\n", ":3:3: ", "a missing sample is an empty cell"},
        {HEAD "0,1\n1,2\x7f\n2,2\n3,1\n4,5\n", ":3:3: ", "\"2?\": expected a number"},
    };
    REFUSE(bad);
}
END_TEST

START_TEST(too_long_data_are_refused_with_their_place)
{
    static char text[300000];
    size_t n = (size_t)snprintf(text, sizeof text, HEAD "0,1\n1,");
    memset(text + n, '1', 201);
    strcpy(text + n + 201, "\n2,2\n3,3\n4,4\n");
    refuse_data(&(bad_data){text, ":3:3: ", "a number of more than 200 characters"}, 1);

    n = (size_t)snprintf(text, sizeof text, HEAD "0,1\n1,2");
    memset(text + n, ',', 300);
    strcpy(text + n + 300, "\n2,2\n3,3\n4,4\n");
    refuse_data(&(bad_data){text, ":3:", "more than 256 cells where the header has 2"}, 1);

    // a word that is cut between letters: the 60th byte is the second of two
    n = (size_t)snprintf(text, sizeof text, HEAD "0,1\n1,");
    memset(text + n, 'b', 59);
    strcpy(text + n + 59, "\xC3\xA9\xC3\xA9\xC3\xA9\n2,2\n3,3\n4,4\n");
    refuse_data(&(bad_data){text, ":3:3: ", "bbb...\": expected a number"}, 1);

    n = 0;
    for (int i = 0; i < 10001; i++) {
        n += (size_t)snprintf(text + n, sizeof text - n, "# remark %d\n", i);
    }
    snprintf(text + n, sizeof text - n, HEAD "0,1\n1,2\n2,4\n3,1\n");
    refuse_data(&(bad_data){text, ":10001:1: ", "more than 10000 lines above the header"}, 1);
}
END_TEST

/* quotes with blanks behind them, signs and powers of ten of every form, tabs, no last line end */
START_TEST(rare_forms_of_numbers_are_read)
{
    lab_data *d =
        open_data(write_file("rare.csv", "# noise key_dip: 2 um\n# noise key_dip: 2e-3 mm\n"
                                         "time [s] , key_dip [mm]\n"
                                         "0,\"1\" \t\n1,\t-.5e+1 \n2 ,+2.E0\n3,3e-0\n"
                                         "4,4e-99999999999"),
                  &stein_model_stein1788);
    static const double expected[] = {1e-3, -5e-3, 2e-3, 3e-3, 0.0};
    ck_assert_int_eq(d->nrow, 5);
    for (int i = 0; i < 5; i++) {
        ck_assert_msg(d->column[0].value[i] == expected[i], "%d: %.17g", i, d->column[0].value[i]);
    }
    ck_assert(d->column[0].noise == 2e-6);
    lab_data_close(d);
}
END_TEST

/* what is said of it is one line a finding, and the same text again */
static void keep_line(void *ctx, const char *line)
{
    hear(ctx, line);
}

START_TEST(a_record_that_moves_from_the_beginning_is_reported)
{
    camera c = camera_default(61);
    c.from = 0.0575; // in the middle of the stroke
    c.to = 0.0605;
    c.trigger = 0.0;
    c.rate = 8000.0;
    lab_data *d = open_data(film("late.csv", "", c, NULL), &stein_model_stein1788);
    lab_audit *a = audit_of(d);
    said s = {.n = 0};
    ck_assert_msg(was_found(a, "in motion: the start of the motion is missing") == 1, "%d findings",
                  a->nfinding);
    ck_assert_stein(lab_audit_text(a, keep_line, &s, err));
    ck_assert_int_eq(was_said(&s, "the start of the motion is missing"), 1);
    lab_audit_destroy(a);
    lab_data_close(d);

    c.from = -0.0025; // the same frames by a clock that began later
    c.to = 0.0005;
    c.trigger = -0.06;
    d = open_data(film("early.csv", "# trigger: synchronised\n", c, NULL), &stein_model_stein1788);
    a = audit_of(d);
    ck_assert_int_eq(was_found(a, "it moves from the first sample on, at -2.5 ms, though the "
                                  "trigger is called synchronised"),
                     1);
    lab_audit_destroy(a);
    lab_data_close(d);
}
END_TEST

START_TEST(the_audit_finds_rests_and_the_first_motion)
{
    lab_data *d =
        open_data(film("whole.csv", "", camera_default(62), NULL), &stein_model_stein1788);
    lab_audit *a = audit_of(d);
    said s = {.n = 0};
    ck_assert_stein(lab_audit_text(a, keep_line, &s, err));
    ck_assert_int_gt(was_said(&s, "  at rest 0 s .. 5"), 0);
    ck_assert_int_eq(was_said(&s, "  first motion at 5"), 1);
    ck_assert_int_eq(was_said(&s, "  string_distance: 1601 samples"), 1);
    lab_audit_destroy(a);
    lab_data_close(d);
}
END_TEST

/* ---- journals ---- */

static const char sweep_head[] = "# stein: test\n# vary a.b [m]: 0:0.1:2 mm\n# points: 2\n"
                                 "point,a.b [m],status,height [m]\n";
static const char other_head[] = "# stein: test\n# vary a.b [m]: 0:0.2:2 mm\n# points: 2\n"
                                 "point,a.b [m],status,height [m]\n";

/* @return its path, to be freed */
static char *write_journal(const char *name, const char *head)
{
    char *path = lab__text("%s/%s", folder, name);
    lab_table *table = NULL;
    lab__journal journal;
    ck_assert_stein(lab__table_new(&table, head, err));
    ck_assert_stein(lab__journal_open(&journal, path, table, NULL, err));
    ck_assert_stein(lab__journal_add(&journal, "0,0,ok,1", err));
    lab__journal_close(&journal);
    lab_table_destroy(table);
    return path;
}

static void merge_refused(const char *const *path, int n, stein_status expected, const char *says)
{
    lab_table *table = NULL;
    stein_err why = {STEIN_OK, ""};
    ck_assert_int_eq(lab_merge(&table, path, n, NULL, &why), expected);
    ck_assert_msg(strstr(why.msg, says) != NULL, "%s, expected %s", why.msg, says);
    ck_assert_ptr_null(table);
}

START_TEST(journals_that_cannot_be_merged_are_named)
{
    char *one = write_journal("one", sweep_head), *other = write_journal("other", other_head);
    merge_refused(&(const char *){folder}, 1, STEIN_EIO, "cannot be read: Is a directory");
    merge_refused(&(const char *){in_folder("none")}, 1, STEIN_EIO,
                  "/none cannot be read: No such");
    merge_refused(&(const char *){write_file("text", "hello\n")}, 1, STEIN_EPARSE,
                  "/text is no journal of a sweep");
    merge_refused(&(const char *){write_file("empty", "")}, 1, STEIN_EPARSE,
                  "/empty is no journal of a sweep");
    merge_refused(&(const char *){write_file("short", "# stein-journal 1")}, 1, STEIN_EPARSE,
                  "/short: the head of this journal is damaged");
    merge_refused((const char *[]){one, other}, 2, STEIN_ESTALE,
                  "other belongs to another sweep: there \"# vary a.b [m]: 0:0.2:2 mm\", here "
                  "\"# vary a.b [m]: 0:0.1:2 mm\"");
    free(one);
    free(other);
}
END_TEST

START_TEST(a_journal_that_cannot_be_written_is_named)
{
    static const char *const where[] = {"", "/none/journal"};
    for (int i = 0; i < 3; i++) { // the folder itself, one that is not there, a full disk
        char *path = i < 2 ? lab__text("%s%s", folder, where[i]) : lab__text("/dev/full");
        lab_table *table = NULL;
        lab__journal journal;
        stein_err why = {STEIN_OK, ""};
        ck_assert_stein(lab__table_new(&table, sweep_head, err));
        ck_assert_int_eq(lab__journal_open(&journal, path, table, NULL, &why), STEIN_EIO);
        ck_assert_msg(strstr(why.msg, path) != NULL && strstr(why.msg, "cannot be written") != NULL,
                      "%s", why.msg);
        lab_table_destroy(table);
        free(path);
    }
}
END_TEST

Suite *seldom_suite(void)
{
    Suite *suite = suite_create("seldom");
    TCase *tc = tcase_create("seldom");
    tcase_add_checked_fixture(tc, make_folder, remove_folder);
    tcase_set_timeout(tc, 60.0);
    tcase_add_test(tc, rare_mistakes_of_a_mechanism_are_refused_with_their_place);
    tcase_add_test(tc, an_entry_that_is_no_mapping_or_has_no_place_is_refused);
    tcase_add_test(tc, quotes_of_a_file_are_short_and_printable);
    tcase_add_test(tc, a_mechanism_has_no_more_points_than_it_can);
    tcase_add_test(tc, the_rest_of_a_body_may_be_too_long_a_formula);
    tcase_add_test(tc, a_tolerance_may_be_written_with_its_sign);
    tcase_add_test(tc, a_pendulum_test_may_have_been_made_elsewhere);
    tcase_add_test(tc, a_pendulum_test_may_state_its_period);
    tcase_add_test(tc, a_sliding_joint_has_tables_of_forces);
    tcase_add_test(tc, every_kind_of_output_has_a_row_and_words_of_its_own);
    tcase_add_test(tc, an_input_can_be_read_in_its_own_unit);
    tcase_add_test(tc, rare_mistakes_of_data_are_refused_with_their_place);
    tcase_add_test(tc, too_long_data_are_refused_with_their_place);
    tcase_add_test(tc, rare_forms_of_numbers_are_read);
    tcase_add_test(tc, a_record_that_moves_from_the_beginning_is_reported);
    tcase_add_test(tc, the_audit_finds_rests_and_the_first_motion);
    tcase_add_test(tc, journals_that_cannot_be_merged_are_named);
    tcase_add_test(tc, a_journal_that_cannot_be_written_is_named);
    suite_add_tcase(suite, tc);
    return suite;
}
