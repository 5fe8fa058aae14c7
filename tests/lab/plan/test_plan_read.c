/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_plan_read.c - a diagnosis.json that is read back: every field that can be wrong is refused
 * by its line and its name, and nothing is returned.
 */
#include "pendulum_model.h"
#include "planning.h"

static const char good[] =
    "{\n"
    "  \"verdict\": \"missing_effect\",\n"
    "  \"scatter\": {\"joint_friction\": 0.013, \"contact_friction\": 0, \"drive\": 0},\n"
    "  \"causes\": [\n"
    "    {\"kind\": \"quadratic_drag\", \"place\": \"rod\", \"posterior\": [\n"
    "      {\"name\": \"rod.drag\", \"logarithmic\": true, \"value\": 2.3e-4, \"sd\": 0.11,\n"
    "       \"correlation\": []},\n"
    "      {\"name\": \"amount\", \"logarithmic\": false, \"value\": 7.1e-4, \"sd\": 1e-5,\n"
    "       \"correlation\": [-0.37]}]}\n"
    "  ],\n"
    "  \"indistinguishable\": [\n"
    "    {\"kind\": \"viscous_friction\", \"place\": \"rod\", \"posterior\": []}\n"
    "  ],\n"
    "  \"conditions\": {\n"
    "    \"from\": 0.1, \"until\": 0.9, \"interval\": 0.004, \"unsynchronised\": false,\n"
    "    \"channels\": [\n"
    "      {\"name\": \"angle\", \"lo\": -0.4, \"hi\": 0.52, \"noise\": 1.3e-3}],\n"
    "    \"inputs\": [{\"name\": \"push\", \"lo\": 0, \"hi\": 0.02}],\n"
    "    \"settings\": [\n"
    "      {\"name\": \"rod.initial.position\", \"lo\": 0.3, \"hi\": 0.3}]\n"
    "  }\n"
    "}\n";

/* the good text with a piece of it replaced, to be freed */
static char *with(const char *from, const char *to)
{
    const char *at = strstr(good, from);
    ck_assert_msg(at != NULL, "the text has no %s", from);
    return lab__text("%.*s%s%s", (int)(at - good), good, to, at + strlen(from));
}

static void refuse(const char *text, int line, const char *says)
{
    const char *path = write_file("bad.json", text);
    lab_diagnosis *d = NULL;
    stein_err why = {STEIN_OK, ""};
    char *place = lab__text("%s:%d: ", path, line);
    ck_assert_msg(lab_diagnosis_read(&d, path, model, &why) == STEIN_EPARSE, "accepted: %s", says);
    ck_assert_ptr_null(d);
    ck_assert_msg(strncmp(why.msg, place, strlen(place)) == 0 && strstr(why.msg, says) != NULL,
                  "%s\nexpected %s%s", why.msg, place, says);
    free(place);
}

START_TEST(a_written_diagnosis_is_read)
{
    lab_diagnosis *d = NULL;
    ck_assert_stein(lab_diagnosis_read(&d, write_file("good.json", good), model, err));
    ck_assert_int_eq(d->verdict, LAB_VERDICT_MISSING_EFFECT);
    ck_assert(d->scatter[0] == 0.013);
    ck_assert_int_eq(d->ncause, 1);
    ck_assert_int_eq(d->nrival, 1);
    ck_assert_int_eq(d->nsuspect, 2);
    const lab_posterior *q = &d->suspect[0].posterior;
    ck_assert_int_eq(q->n, 2);
    ck_assert(q->correlation[1] == -0.37 && q->correlation[2] == -0.37);
    ck_assert(q->correlation[0] == 1.0 && q->correlation[3] == 1.0);
    ck_assert_int_eq(q->number[0].logarithmic, 1);
    ck_assert(d->suspect[0].amount == 7.1e-4);
    ck_assert_str_eq(d->suspect[1].candidate.effect->kind, "viscous_friction");
    ck_assert_int_eq(d->suspect[1].posterior.n, 0);
    const lab_conditions *c = &d->conditions;
    ck_assert(c->from == 0.1 && c->until == 0.9 && c->interval == 0.004 && !c->unsynchronised);
    ck_assert_str_eq(c->channel[0].unit, "rad");
    ck_assert_str_eq(c->input[0].unit, "N m");
    ck_assert_str_eq(c->setting[0].name, "rod.initial.position");
    ck_assert(c->setting[0].lo == c->setting[0].hi && isnan(c->setting[0].noise));
    lab_diagnosis_destroy(d);
}
END_TEST

START_TEST(a_field_that_is_wrong_is_named_with_its_line)
{
    static const struct {
        const char *from, *to;
        int line;
        const char *says;
    } bad[] = {
        {"\"missing_effect\"", "[1]", 2, "\"verdict\": expected a text"},
        {"\"missing_effect\"", "\"guilty\"", 1, "\"guilty\" is none of explained .."},
        {"{\"joint_friction\": 0.013, \"contact_friction\": 0, \"drive\": 0}", "[0]", 3,
         "expected an object with \"joint_friction\""},
        {"\"drive\": 0}", "\"driven\": 0}", 3, "\"drive\" is missing"},
        {"\"drive\": 0}", "\"drive\": {}}", 3, "\"drive\": expected a number, not nothing"},
        {"\"drive\": 0}", "\"drive\": \"a lot\"}", 3, "expected a number, not \"a lot\""},
        {"\"drive\": 0}", "[1]: 0, \"driven\": 0}", 3, "\"drive\" is missing"},
        {"{\"kind\": \"viscous_friction\", \"place\": \"rod\", \"posterior\": []}", "7", 12,
         "expected an object with \"kind\""},
        {"\"kind\": \"quad", "\"kind\": \"cub", 5, "there is no cubratic_drag at \"rod\""},
        {"\"kind\": \"quadratic_drag\"", "\"kind\": \"changed_after\"", 5,
         "changed_after at \"rod\" is of a part of the records"},
        {"\"place\": \"rod\", \"posterior\": []", "\"place\": \"arm\", \"posterior\": []", 12,
         "there is no viscous_friction at \"arm\" in \"pendulum\""},
        {"\"posterior\": []", "\"posterior\": {}", 12, "\"posterior\": expected a list"},
        {"\"posterior\": []", "\"limit\": 0, \"posterior\": []", 12, "expected more than 0"},
        {"\"posterior\": []", "\"posterior\": [3]", 12, "expected an object with \"name\""},
        {"\"rod.drag\"", "\"rod.drug\"", 6, "\"rod.drug\" is not a parameter of \"pendulum\""},
        {"\"rod.drag\"",
         "\"a_name_that_is_longer_than_any_name_of_a_place_in_a_mechanism_file_could_ever_be_even_"
         "with_all_of_its_parts_and_the_words_behind_the_dots_in_it_which_are_many_and_long_too\"",
         6, "\"name\": expected a name of less than"},
        {"\"logarithmic\": true", "\"logarithmic\": 1", 6, "expected true or false"},
        {"\"sd\": 0.11", "\"sd\": -0.11", 6, "\"sd\": expected 0 or more"},
        {"\"value\": 2.3e-4", "\"value\": -2.3e-4", 6, "expected more than 0 where it is log"},
        {"\"correlation\": []", "\"correlation\": [0.1]", 7, "expected 0 numbers"},
        {"[-0.37]", "[]", 9, "\"correlation\": expected 1 numbers, those with the entries before"},
        {"[-0.37]", "[-1.37]", 9, "\"correlation\": expected numbers from -1 to 1"},
        {"[-0.37]", "[none]", 9, "\"correlation\": expected a number, not \"none\""},
        {"[-0.37]", "0.37", 9, "\"correlation\": expected a list"},
        {"\"until\": 0.9", "\"until\": 0.1", 14, "\"until\": expected more than \"from\" and 0"},
        {"\"from\": 0.1, \"until\": 0.9", "\"from\": -2, \"until\": -1", 14,
         "\"until\": expected more than \"from\" and 0"},
        {"\"interval\": 0.004", "\"interval\": 0", 14, "expected more than 0, less than the rec"},
        {"\"interval\": 0.004", "\"interval\": 0.9", 14, "expected more than 0, less than the re"},
        {"\"unsynchronised\": false", "\"unsynchronised\": \"no\"", 14, "expected true or false"},
        {"\"angle\"", "\"angel\"", 17, "\"angel\" is not an output of \"pendulum\""},
        {"\"push\"", "\"pull\"", 18, "\"pull\" is not an input of \"pendulum\""},
        {"\"rod.initial.position\"", "\"rod.position\"", 20, "is not a parameter of \"pendulum\""},
        {"\"lo\": -0.4", "\"lo\": 0.6", 17, "\"hi\": expected no less than \"lo\""},
        {"\"noise\": 1.3e-3", "\"noise\": 0", 17, "\"noise\": expected more than 0"},
        {"\n      {\"name\": \"angle\", \"lo\": -0.4, \"hi\": 0.52, \"noise\": 1.3e-3}", "", 14,
         "\"channels\": expected at least one"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char *text = with(bad[i].from, bad[i].to);
        refuse(text, bad[i].line, bad[i].says);
        free(text);
    }
}
END_TEST

START_TEST(only_an_object_is_a_diagnosis)
{
    refuse("", 1, "expected a diagnosis.json");
    refuse("\n\"explained\"\n", 2, "expected a diagnosis.json");
    refuse("{\n\"verdict\": [\n", 3, "no JSON: ");
    enum { MOST = 1000 };
    char list[3 * MOST + 10] = "";
    for (size_t i = 0; i <= MOST; i++) { // one more than can be
        strcpy(list + 3 * i, i < MOST ? "{}," : "{}");
    }
    char *text = lab__text("{\"verdict\": \"explained\", \"scatter\": {\"joint_friction\": 0,\n"
                           "\"contact_friction\": 0, \"drive\": 0},\n\"causes\": [%s]}",
                           list);
    refuse(text, 3, "\"causes\": more than 1000 entries");
    free(text);
}
END_TEST

/* ---- files of a plan ---- */

START_TEST(a_stroke_to_be_made_has_its_input_and_every_channel_to_be_measured)
{
    static const char head[] = "# set rod.initial.position: 0.3 rad\n"
                               "# noise angle: 0.0013\n"
                               "# noise tip_x: 0.00013\n"
                               "# prediction: quadratic_drag at rod, without noise\n"
                               "# experiment: a push\n"
                               "time [s],push [N m],angle [rad],tip_x [m]\n"
                               "0.1,0.0120703125,0.3,";
    lab_experiment e = {.name = "a push",
                        .nset = 1,
                        .set = {{.name = "rod.initial.position", .unit = "rad", .value = 0.3}},
                        .input = "push",
                        .shape = LAB_SHAPE_RISE,
                        .zero = 0.01,
                        .size = 0.02,
                        .time = 0.4,
                        .channel = "tip_x",
                        .noise = 0.02,
                        .faster = 1,
                        .feasible = 1};
    lab_diagnosis *d = NULL;
    char *text = NULL;
    size_t size = 0;
    const char *path = in_folder("stroke.csv");
    ck_assert_stein(lab_diagnosis_read(&d, write_file("good.json", good), model, err));
    ck_assert_stein(lab_plan_stroke(path, &e, 0, "models/pendulum.yaml", model, d, NULL, err));
    ck_assert_stein(lab__read_file(path, &text, &size, err));
    ck_assert_msg(strncmp(text, head, strlen(head)) == 0, "%.500s", text);
    free(text);
    // nothing is driven, no further channel is measured
    e.input[0] = e.channel[0] = '\0';
    e.nset = 0;
    ck_assert_stein(lab_plan_stroke(path, &e, 0, "models/pendulum.yaml", model, d, NULL, err));
    ck_assert_stein(lab__read_file(path, &text, &size, err));
    ck_assert_msg(strstr(text, "\ntime [s],angle [rad]\n0.1,0.42") != NULL, "%.300s", text);
    ck_assert_ptr_null(strstr(text, "# set "));
    free(text);
    stein_err why = {STEIN_OK, ""};
    for (int suspect = -1; suspect < 3; suspect += 3) {
        ck_assert_int_eq(
            lab_plan_stroke(path, &e, suspect, "models/pendulum.yaml", model, d, NULL, &why),
            STEIN_EINVAL);
        ck_assert_ptr_nonnull(strstr(why.msg, "no suspect"));
    }
    lab_diagnosis_destroy(d);
}
END_TEST

START_TEST(a_plan_separates_feasible_from_infeasible_experiments)
{
    static const char *const has[] = {"\"rivals\": []",
                                      "\"left_out\": 2",
                                      "\"feasible\": true",
                                      "\"repeats\": 7",
                                      "\"against\": {",
                                      "\"kind\": \"viscous_friction\"",
                                      "\"shape\": \"there_and_back\"",
                                      "\"to\": 0.03",
                                      "\"channel\": \"rate\"",
                                      "\"feasible\": false",
                                      "\"repeats\": null",
                                      "\"against\": null",
                                      "\"drive\": null",
                                      "\"channel\": null",
                                      "\"stroke\": \"next.csv\"",
                                      "\"stroke_of_rival\": null"};
    lab_experiment both[] = {{.name = "a push",
                              .input = "push",
                              .shape = LAB_SHAPE_BACK,
                              .zero = 0.01,
                              .size = 0.02,
                              .time = 0.4,
                              .channel = "rate",
                              .feasible = 1,
                              .repeats = 7,
                              .against = 1},
                             {.name = "a leap", .why = "it cannot be simulated", .repeats = 3}};
    const lab_plan plan = {.n = 2, .experiment = both, .nrival = 1, .left_out = 2, .wanted = 100.0};
    char *stroke[] = {"next.csv", NULL};
    lab_diagnosis *d = NULL;
    char *text = NULL;
    size_t size = 0;
    const char *path = in_folder("plan.json");
    ck_assert_stein(lab_diagnosis_read(&d, write_file("good.json", good), model, err));
    ck_assert_stein(lab_plan_json(path, &plan, d, stroke, err));
    ck_assert_stein(lab__read_file(path, &text, &size, err));
    text_has(text, has, sizeof has / sizeof *has);
    free(text);
    ck_assert_int_eq(lab_plan_json(in_folder("none/plan.json"), &plan, d, NULL, NULL), STEIN_EIO);
    lab_diagnosis_destroy(d);
}
END_TEST

Suite *plan_read_suite(void)
{
    Suite *s = suite_create("plan_read");
    TCase *tc = tcase_create("plan_read");
    tcase_add_checked_fixture(tc, open_pendulum, close_pendulum);
    tcase_set_timeout(tc, 60.0);
    tcase_add_test(tc, a_written_diagnosis_is_read);
    tcase_add_test(tc, a_field_that_is_wrong_is_named_with_its_line);
    tcase_add_test(tc, only_an_object_is_a_diagnosis);
    tcase_add_test(tc, a_stroke_to_be_made_has_its_input_and_every_channel_to_be_measured);
    tcase_add_test(tc, a_plan_separates_feasible_from_infeasible_experiments);
    suite_add_tcase(s, tc);
    return s;
}
