/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_change.c - what a cause changes, in the words and units of the file.
 */
#include "added_parts.h"
#include "lab_support.h"

Suite *change_suite(void);

static const char text_of_file[] = "mechanism: bob\n"
                                   "bodies:\n"
                                   "  rod:\n"
                                   "    joint: R -y\n"
                                   "    mass: 300 g +- 1 g\n"
                                   "    centre: [0, 0, -400 mm +- 1 mm]\n"
                                   "    inertia: {yy: 520 kg cm^2 +- 10 kg cm^2}\n"
                                   "    damping: 1.5e-3\n"
                                   "    points:\n"
                                   "      end: [0, 0, -600 mm]\n"
                                   "outputs:\n"
                                   "  angle: {joint: rod, read: position}\n"
                                   "simulation: {dt: 1 ms, until: 20 s}\n";

static lab_model *model;
static lab_candidate *list;
static int n;
static const char *file;

static void open_bob(void)
{
    make_folder();
    cache_in_build();
    file = write_file("bob.yaml", text_of_file);
    ck_assert_stein(lab_open(&model, file, NULL, err));
    ck_assert_stein(lab_candidates(&list, &n, model, err));
}

static void close_bob(void)
{
    free(list);
    lab_close(model);
    remove_folder();
}

/* a candidate of the file with a size, known to a tenth of it */
static lab_suspect found(const char *kind, double amount, const lab_fit_value *value, int nvalue)
{
    lab_suspect s = {.amount = amount, .refitted = 1, .nnumber = 1, .stated = NAN};
    for (int i = 0; i < n; i++) {
        if (strcmp(list[i].effect->kind, kind) == 0 && strcmp(list[i].place, "rod") == 0) {
            s.candidate = list[i];
        }
    }
    ck_assert_ptr_nonnull(s.candidate.effect);
    double half = 0.1 * fabs(amount);
    s.number[0] = (lab_cause_number){.unit = s.candidate.unit,
                                     .value = amount,
                                     .sd = 0.5 * half,
                                     .lo = amount - half,
                                     .hi = amount + half};
    snprintf(s.number[0].name, sizeof s.number[0].name, "%s", lab_candidate_size(&s.candidate));
    lab__note_changes(&s, &s.candidate, model, value, nvalue);
    return s;
}

START_TEST(a_cause_is_told_by_the_old_and_the_new_number)
{
    static const struct {
        const char *kind, *says;
        double amount;
    } told[] = {
        {"inertia", "inertia.yy: 520 -> 41 kg cm^2 (95 %: -7 to 89), 13 times smaller", -0.0479},
        {"centre",
         "centre.z: -400 -> -379.8 mm (95 %: -381.8 to -377.8), 20 mm nearer to the joint", 0.0202},
        {"mass", "mass: 300 -> 313.0 g (95 %: 311.7 to 314.3), 4.3 % heavier", 0.013},
        {"viscous_friction",
         "damping: 0.0015 -> 0.001600 N m s/rad (95 %: 0.001590 to 0.001610), 6.7 % larger", 1e-4},
        {"quadratic_drag", "", 1e-4}}; // the file has none
    for (size_t i = 0; i < sizeof told / sizeof *told; i++) {
        char text[LAB_CHANGE_TEXT];
        lab_suspect s = found(told[i].kind, told[i].amount, NULL, 0);
        ck_assert_str_eq(lab_change_text(&s, text), told[i].says);
    }
}
END_TEST

START_TEST(numbers_that_are_scaled_alike_are_told_by_their_factor)
{
    lab_model *action = NULL;
    lab_candidate *of = NULL;
    int k = 0, many = 0;
    char text[LAB_CHANGE_TEXT];
    ck_assert_stein(lab_open(&action, "models/stein1788.yaml", NULL, err));
    ck_assert_stein(lab_candidates(&of, &many, action, err));
    while (strcmp(of[k].effect->kind, "contact_stiffness") != 0 || of[k].nparam < 2) {
        ck_assert_int_lt(++k, many);
    }
    lab_suspect s = {.candidate = of[k], .nnumber = 1, .stated = NAN};
    s.number[0] = (lab_cause_number){.value = log(2.05), .lo = log(1.9), .hi = log(2.2)};
    lab__note_changes(&s, &of[k], action, NULL, 0);
    ck_assert_int_eq(s.nchange, of[k].nparam);
    ck_assert_str_eq(lab_change_text(&s, text), "2.05 times stiffer (95 %: 1.90 to 2.20)");
    free(of);
    lab_close(action);
}
END_TEST

/* the head of the extended file and its body have the same number, and say what moved it */
START_TEST(a_refitted_number_that_a_cause_moves_is_the_same_in_head_and_body)
{
    static const char *const has[] = {
        "#     so inertia.yy: 520 -> 40 kg cm^2 (95 %: -8 to 88), 13 times smaller\n",
        "#   rod.inertia.yy = 0.004 +- 0.002395 kg m^2 (was 0.052; without the cause inertia at "
        "rod "
        "it is 0.0519)\n",
        "inertia: {yy: 40 kg cm^2 +- 23.9 kg cm^2}"};
    lab_fit_value value = {
        .name = "rod.inertia.yy", .unit = "kg m^2", .start = 0.052, .value = 0.0519, .sd = 0.001};
    lab_suspect s = found("inertia", -0.0479, &value, 1);
    lab_diagnosis d = {.nsuspect = 1, .suspect = &s, .ncause = 1, .nvalue = 1, .value = &value};
    const char *path = in_folder("extended.yaml");
    char *text = NULL;
    size_t size = 0;
    ck_assert_stein(lab_extend(path, file, &d, err));
    ck_assert_stein(lab__read_file(path, &text, &size, err));
    for (size_t i = 0; i < sizeof has / sizeof *has; i++) {
        ck_assert_msg(strstr(text, has[i]) != NULL, "no \"%s\" in\n%.2000s", has[i], text);
    }
    free(text);
}
END_TEST

Suite *change_suite(void)
{
    Suite *suite = suite_create("change");
    TCase *tc = tcase_create("change");
    tcase_add_checked_fixture(tc, open_bob, close_bob);
    tcase_set_timeout(tc, 60.0);
    tcase_add_test(tc, a_cause_is_told_by_the_old_and_the_new_number);
    tcase_add_test(tc, numbers_that_are_scaled_alike_are_told_by_their_factor);
    tcase_add_test(tc, a_refitted_number_that_a_cause_moves_is_the_same_in_head_and_body);
    suite_add_tcase(suite, tc);
    return suite;
}
