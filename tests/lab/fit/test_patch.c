/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_patch.c - numbers that are written into a mechanism file. Only they change, in the unit and
 * the form that stands there. A number without a place gets one. Errors of writing are reported.
 */
#include "fitting.h"
#include "lab_support.h"
#include "mechanism.h"
#include "stein/fit.h"

static const char arm[] = "mechanism: arm # of µm\n"
                          "bodies:\n"
                          "  rod: {about: \"Stoß\", joint: T z, mass: 213 g +- 1 %}\n"
                          "  cart:\n"
                          "    joint: T x\n"
                          "    mass: '1.3e2 g'   # weighed\n"
                          "    spring: {k: 210 N/m ± 3 N/m, x0: 2 mm}\n"
                          "    damping: 0.031\n"
                          "    initial: {position: rod.mass / 70 * 1 m/kg}\n"
                          "inputs:\n"
                          "  push: {force: cart.tip, direction: [1, 0, 0]}\n"
                          "outputs:\n"
                          "  at: {joint: cart, read: position}\n";
static const char tip[] = "    points: {tip: [0, 0, 0]}\n";

static mechanism *read_arm(const char *text)
{
    mechanism *m = NULL;
    ck_assert_stein(mech_read_text(&m, "arm.yaml", text, strlen(text), NULL, 0, NULL, NULL, err));
    return m;
}

/* the file with its point, to be freed */
static char *whole_arm(void)
{
    const char *at = strstr(arm, "inputs:");
    return lab__text("%.*s%s%s", (int)(at - arm), arm, tip, at);
}

/* a text with numbers in it: `from` has become `to`; the rest is the same */
static void patched(const char *text, const fit__number *number, int n, const char *from,
                    const char *to)
{
    mechanism *m = read_arm(text);
    char *out = NULL;
    size_t size = 0;
    const char *at = strstr(text, from);
    ck_assert_msg(at != NULL, "the text has no %s", from);
    char *expected = lab__text("%.*s%s%s", (int)(at - text), text, to, at + strlen(from));
    ck_assert_stein(fit__patch(&out, &size, m, text, strlen(text), number, n, 6, err));
    ck_assert_str_eq(out, expected);
    ck_assert_uint_eq(size, strlen(expected));
    free(expected);
    free(out);
    mech_free(m);
}

START_TEST(a_number_keeps_the_unit_and_the_form_that_stands_there)
{
    static const struct {
        fit__number number;
        const char *from, *to;
    } change[] = {
        {{"rod.mass", 0.22, 1.1e-3},
         "213 g +- 1 %",
         "220 g +- 1.1 g"}, // behind a letter of two bytes
        {{"rod.mass", 0.22, 0.0}, "213 g +- 1 %", "220 g"},
        {{"cart.mass", 0.141, 0.0}, "1.3e2 g", "141 g"},
        {{"cart.spring.k", 217.0, 2.5}, "210 N/m ± 3 N/m", "217 N/m +- 2.5 N/m"},
        {{"cart.spring.x0", -3.1e-3, 0.0}, "2 mm", "-3.1 mm"},
        {{"cart.damping", 0.029, 0.0}, "0.031", "0.029 N s/m"},
        {{"cart.mass", 0.141, (double)INFINITY}, "1.3e2 g", "141 g"},
    };
    char *text = whole_arm();
    for (size_t i = 0; i < sizeof change / sizeof *change; i++) {
        patched(text, &change[i].number, 1, change[i].from, change[i].to);
    }
    free(text);
}
END_TEST

START_TEST(a_number_that_is_not_there_gets_its_place)
{
    static const fit__number law[] = {{"cart.coulomb.T", 1.7, 0.2}, {"cart.coulomb.w", 0.013, 0.0}};
    static const struct {
        fit__number number;
        const char *from, *to;
    } change[] = {
        {{"rod.damping", 2e-3, 1e-4}, "{about", "{damping: 0.002 N s/m +- 0.0001 N s/m, about"},
        {{"cart.drag", 0.3, 0.0}, "    joint: T x", "    drag: 0.3 N s^2/m^2\n    joint: T x"},
        {{"cart.spring.k3", 5e5, 0.0}, "{k: 210", "{k3: 500000 N/m^3, k: 210"},
        {{"push.gain", 1.1, 0.0}, "{force: cart.tip", "{gain: 1.1, force: cart.tip"},
        {{"at.sensor.offset", 1e-3, 0.0},
         "{joint: cart",
         "{sensor: {gain: 1, offset: 0.001 m, square: 0 1/m, tilt: 0 rad, delay: 0 s}, joint: "
         "cart"},
        {{"clock.error", 3e-5, 0.0},
         "read: position}\n",
         "read: position}\nclock: {error: 3e-05}\n"},
    };
    char *text = whole_arm();
    for (size_t i = 0; i < sizeof change / sizeof *change; i++) {
        patched(text, &change[i].number, 1, change[i].from, change[i].to);
    }
    // both numbers of a law come together
    patched(text, law, 2, "    joint: T x",
            "    coulomb: {T: 1.7 N +- 0.2 N, w: 0.013 m/s, asymmetry: 0}\n    joint: T x");
    text[strlen(text) - 1] = '\0'; // a file without a last end of line
    patched(text, &change[5].number, 1, "read: position}",
            "read: position}\nclock: {error: 3e-05}\n");
    free(text);
}
END_TEST

START_TEST(a_file_that_begins_with_a_mark_is_counted_behind_it)
{
    static const char text[] =
        "\xEF\xBB\xBF{mechanism: one, bodies: {rod: {joint: R y, mass: 2 kg, "
        "inertia: {yy: 0.3}}}, outputs: {a: {joint: rod, read: speed}}}\n";
    patched(text, &(fit__number){"rod.mass", 3.0, 0.0}, 1, "2 kg", "3 kg");
}
END_TEST

START_TEST(a_number_in_any_form_is_replaced_as_a_whole)
{
    static const char text[] = "mechanism: one\n"
                               "bodies:\n"
                               "  a: {joint: T x, mass: \"2 kg\" , damping: 1e-2 N s/m  }\n"
                               "  b: {joint: T x, mass: 2 kg * 3}\n"
                               "  c: {joint: T x, mass: 1.5e3 g \xc2\xb1 2 %   # weighed\n"
                               "   }\n"
                               "  d: {joint: T x, mass: \"4 kg +- 3 %\"}\n";
    static const struct {
        fit__number number;
        const char *from, *to;
    } change[] = {
        {{"a.mass", 3.0, 0.0}, "2 kg\" ,", "3 kg\" ,"}, // and the blank behind it stays
        {{"a.damping", 0.03, 0.001}, "1e-2 N s/m  }", "0.03 N s/m +- 0.001 N s/m  }"},
        {{"b.mass", 7.0, 0.0}, "2 kg * 3", "7 kg"},
        {{"c.mass", 1.25, 0.02}, "1.5e3 g \xc2\xb1 2 %   #", "1250 g +- 20 g   #"},
        {{"d.mass", 2.5, 0.1}, "4 kg +- 3 %", "2.5 kg +- 0.1 kg"},
    };
    for (size_t i = 0; i < sizeof change / sizeof *change; i++) {
        patched(text, &change[i].number, 1, change[i].from, change[i].to);
    }
}
END_TEST

START_TEST(a_number_without_a_place_is_refused)
{
    static const char *const none[] = {"rod.masse", "nothing", "clock.offset",
                                       "cart.initial.position"};
    char *text = whole_arm();
    mechanism *m = read_arm(text);
    for (size_t i = 0; i < sizeof none / sizeof *none; i++) {
        fit__number number[] = {{"rod.mass", 0.3, 0.0}, {none[i], 1.0, 0.0}};
        char *out = NULL, *says = lab__text("%s has no place in arm.yaml: write it there", none[i]);
        size_t size = 4711;
        stein_err why = {STEIN_OK, ""};
        ck_assert_int_eq(fit__patch(&out, &size, m, text, strlen(text), number, 2, 6, &why),
                         STEIN_EINVAL);
        ck_assert_msg(strstr(why.msg, says) != NULL, "%s, expected %s", why.msg, says);
        ck_assert(out == NULL && size == 4711);
        free(says);
    }
    mech_free(m);
    free(text);
}
END_TEST

START_TEST(a_text_that_cannot_be_read_again_is_not_written)
{
    static const struct {
        fit__number number;
        stein_status status;
        const char *says;
    } bad[] = {
        {{"rod.mass", -0.1, 0.0}, STEIN_EPARSE, "the fitted file would not be valid: "},
        {{"rod.mass", (double)NAN, 0.0}, STEIN_EPARSE, "the fitted file would not be valid: "},
        {{"rod.mass", 0.2123456789, 0.0}, STEIN_EINVAL, "rod.mass cannot be written to arm.yaml"},
    };
    char *text = whole_arm();
    mechanism *m = read_arm(text);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char *out = NULL;
        size_t size;
        stein_err why = {STEIN_OK, ""};
        ck_assert_int_eq(fit__patch(&out, &size, m, text, strlen(text), &bad[i].number, 1, 4, &why),
                         bad[i].status);
        ck_assert_msg(strstr(why.msg, bad[i].says) != NULL, "%s", why.msg);
        ck_assert_ptr_null(out);
    }
    mech_free(m);
    free(text);
}
END_TEST

/* ---- the file of a fit ---- */

START_TEST(a_fitted_file_states_the_fit_and_has_the_overrides)
{
    char *whole = whole_arm(), *text = NULL, *file = lab__text("%s", in_folder("arm.yaml"));
    char *name = lab__text("%s", in_folder("push.csv"));
    size_t size = 0;
    lab_fit_value value[] = {
        {.name = "rod.mass", .unit = "kg", .value = 0.31, .sd = 0.004, .start = 0.213},
        {.name = "clock.error", .unit = "1", .value = 2e-5, .sd = 1e-5, .unseen = 1}};
    lab_fit_stroke stroke = {.file = name, .hash = 0xabcULL};
    lab_fit fit = {.status = LAB_FIT_NOT_CONVERGED,
                   .reason = "too few iterations",
                   .nvalue = 2,
                   .nstroke = 1,
                   .value = value,
                   .stroke = &stroke,
                   .chi2 = 71.25,
                   .samples = 50,
                   .chi2_dof = 1.5};
    static const char *const set[] = {"cart.spring.k=250 N/m", "rod.mass=5 kg"};
    lab_options options = lab_options_default();
    options.set = set;
    options.nset = 2;
    write_file("arm.yaml", whole);
    ck_assert_stein(lab_fit_write(in_folder("out.yaml"), &fit, file, &options, err));
    ck_assert_stein(lab__read_file(in_folder("out.yaml"), &text, &size, err));
    static const char *const has[] = {
        "# Fitted by stein fit (not_converged), from arm.yaml (fnv1a64 ",
        "# too few iterations\n",
        "# 50 samples of 1 records, chi2 71.25, chi2/dof 1.5\n",
        "#   data push.csv (fnv1a64 0000000000000abc)\n",
        "#   rod.mass = 0.31 +- 0.004 kg (was 0.213)\n",
        "#   clock.error = 2e-05 +- 1e-05  (was 0) - no data depend on it\n",
        "mass: 310 g +- 4 g}",
        "{k: 250 N/m +- 3 N/m, x0",
        "\nclock: {error: 2e-05 +- 1e-05}\n"};
    text_has(text, has, sizeof has / sizeof *has);
    free(text);

    static const struct {
        const char *set;
        stein_status status;
        const char *says;
    } bad[] = {{"rod.mass", STEIN_EINVAL, "override \"rod.mass\": expected NAME=VALUE"},
               {"rod.mess=1", STEIN_EPARSE, "rod.mess"}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        stein_err why = {STEIN_OK, ""};
        options.set = &bad[i].set;
        options.nset = 1;
        ck_assert_int_eq(lab_fit_write(in_folder("no.yaml"), &fit, file, &options, &why),
                         bad[i].status);
        ck_assert_msg(strstr(why.msg, bad[i].says) != NULL, "%s", why.msg);
        ck_assert_int_ne(access(in_folder("no.yaml"), F_OK), 0);
    }
    ck_assert_int_eq(lab_fit_write(in_folder("no.yaml"), &fit, in_folder("none"), NULL, NULL),
                     STEIN_EIO);
    free(whole);
    free(file);
    free(name);
}
END_TEST

Suite *patch_suite(void)
{
    Suite *s = suite_create("patch");
    TCase *tc = tcase_create("patch");
    tcase_add_checked_fixture(tc, make_folder, remove_folder);
    tcase_add_test(tc, a_number_keeps_the_unit_and_the_form_that_stands_there);
    tcase_add_test(tc, a_number_that_is_not_there_gets_its_place);
    tcase_add_test(tc, a_file_that_begins_with_a_mark_is_counted_behind_it);
    tcase_add_test(tc, a_number_in_any_form_is_replaced_as_a_whole);
    tcase_add_test(tc, a_number_without_a_place_is_refused);
    tcase_add_test(tc, a_text_that_cannot_be_read_again_is_not_written);
    tcase_add_test(tc, a_fitted_file_states_the_fit_and_has_the_overrides);
    suite_add_tcase(s, tc);
    return s;
}
