/* SPDX-License-Identifier: MIT
 * test_hostile.c - the mechanism reader and files that are no mechanism: broken, damaged, too
 * large.
 */
#include <stdlib.h>
#include <string.h>

#include "mechanism_cases.h"

void hostile_cases(Suite *suite);

START_TEST(text_that_is_no_plain_yaml_is_refused)
{
    static const refusal r[] = {
        {"mass: 3.9 g", "mass: &m 3.9 g", "&m", "anchors and aliases"},
        {"mass: 3.9 g", "mass: *m", "*m", "anchors and aliases"},
        {"points: {corner", "points: &m {corner", "&m", "anchors and aliases"},
        {"between:\n      - {point", "between: &m\n      - {point", "&m", "anchors and aliases"},
        {"mass: 3.9 g", "mass: !!float 3.9", "!!float", "tags (!) are not allowed"},
        {"direction: [0, 0, -1]", "direction: !!seq [0, 0, -1]", "!!seq",
         "tags (!) are not allowed"},
        {"mechanism: demo", "%TAG !e! tag:example.org,2026:\n---\nmechanism: demo", "%TAG",
         "tags (!) are not allowed"},
        {"simulation:", "---\nsimulation:", "---", "a second document begins"},
        {"mass: 3.9 g", "\tmass: 3.9 g", "\tmass", "a tab, expected blanks"},
        {"mass: 3.9 g", "mass: @3.9 g", "@3.9", "not valid YAML"},
        {"    mass: 3.9 g", "    {a: b}: 3.9 g", "{a: b}", "a key must be a word"},
        {"mass: 3.9 g", "mass: \"3.9\\0 g\"", "\"3.9\\0", "NUL"},
        {"about: the lever", "about: [1, 2]", "[1, 2]", "single text|found a list"},
    };

    REFUSE_ALL(r);
    refuse_text("", 0, NULL, 0, "", "the file is empty, expected a mapping");
    refuse_text("- a\n", 4, NULL, 0, "", "expected a mapping");
    refuse_text("\xEF\xBB\xBF- a\n", 7, NULL, 0, "", "expected a mapping"); // behind a mark
    refuse_text("a: b\n\xff", 6, NULL, 0, "\xff", "not plain UTF-8");
    refuse_text("a: b\nc: \x01", 9, NULL, 0, "\x01", "control characters are not allowed");
    mechanism *m = NULL;
    ck_assert_int_eq(mech_read_text(&m, "d", "a: b\0c\n", 7, NULL, 0, NULL, NULL, NULL),
                     STEIN_EPARSE);
}
END_TEST

START_TEST(depth_width_and_size_are_capped)
{
    size_t n = (1 << 20) + 1;
    char *text = malloc(n + 1);

    memset(text, '#', n);
    text[n] = '\0';
    refuse_text(text, n, NULL, 0, NULL, "larger than 1 MiB");
    memset(text, '[', n);
    memcpy(text, "[[[[[[[[[[[[[[[[{", 17);
    refuse_text(text, n - 1, NULL, 0, "{", "nested more than 16 deep");
    for (size_t i = 0; i < n - 1; i++) {
        text[i] = i < 4 ? "a: ["[i] : i % 2 ? ',' : '1';
    }
    text[4 + 2 * 1024] = '2';
    refuse_text(text, n - 1, NULL, 0, "2", "more than 1024 entries");
    free(text);
}
END_TEST

static void record_all(void *ctx, const char *message)
{
    strcat(ctx, message);
    strcat(ctx, "\n");
}

START_TEST(all_problems_are_reported_in_the_order_of_the_file)
{
    static const char text[] = "mechanism: m\nbodies:\n  a: {joint: R q, mass: 1 m}\n"
                               "  b: {parent: c, jiont: T x, mass: -1}\nsimulation: {dt: -1}\n";
    static const char *const places[] = {
        "m:3:14: \"R q\" is no joint",
        "m:3:25: a.mass = \"1 m\": the unit is m, expected kg",
        "m:4:3: a body lacks \"joint\"",
        "m:4:15: there is no body \"c\"",
        "m:4:18: unknown key \"jiont\" in a body, did you mean \"joint\"?",
        "m:4:36: b.mass = \"-1\": must not be negative",
        "m:5:18: dt = \"-1\": must be greater than zero",
    };
    char all[2000] = "";
    const char *at = all;
    mechanism *m = NULL;

    ck_assert_int_eq(mech_read_text(&m, "m", text, sizeof text - 1, NULL, 0, record_all, all, NULL),
                     STEIN_EPARSE);
    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++) {
        ck_assert_msg(strncmp(at, places[i], strlen(places[i])) == 0, "%s, expected %s", at,
                      places[i]);
        at = strchr(at, '\n') + 1;
    }
    ck_assert_msg(*at == '\0', "%s", at);
}
END_TEST

START_TEST(a_problem_is_one_line_whatever_stands_in_the_file)
{
    static const char text[] = "mechanism: m\nbodies: {a: {joint: T x, mass: 1}}\n"
                               "simulation: {dt: \"\\n\\x1b[31m1\\r\", until: 1 \n\n\n  q}\n";
    char all[2000] = "";
    mechanism *m = NULL;
    ck_assert_int_eq(
        mech_read_text(&m, "m\n", text, sizeof text - 1, NULL, 0, record_all, all, NULL),
        STEIN_EPARSE);
    int lines = 0;
    for (const char *c = all; *c != '\0'; c++) {
        ck_assert_msg(*c == '\n' || ((unsigned char)*c >= ' ' && *c != 127), "%s", all);
        lines += *c == '\n';
    }
    ck_assert_msg(lines == 2, "%s", all);
}
END_TEST

START_TEST(at_most_fifty_problems_are_reported)
{
    char text[6000] = "mechanism: m\nbodies: {a: {joint: T x, mass: 1}}\n";
    mechanism *m = NULL;
    log_t log = {"", 0};

    for (int i = 0; i < 200; i++) {
        size_t n = strlen(text);

        snprintf(text + n, sizeof text - n, "unknown%d: 1\n", i);
    }
    ck_assert_int_eq(mech_read_text(&m, "m", text, strlen(text), NULL, 0, record, &log, NULL),
                     STEIN_EPARSE);
    ck_assert_int_eq(log.n, 51);
}
END_TEST

START_TEST(damaged_files_are_refused_or_read_but_never_crash)
{
    unsigned long long seed = 20240917;
    int accepted = 0;

    for (int i = 0; i < 1500; i++) {
        char text[sizeof good];
        size_t n = sizeof good - 1;
        int changes = 1 + (int)(2.0 * (1.0 + noise(&seed)));
        mechanism *m = NULL;
        stein_err err = {STEIN_OK, ""};

        memcpy(text, good, sizeof good);
        for (int k = 0; k < changes; k++) {
            size_t at = (size_t)(0.5 * (1.0 + noise(&seed)) * (double)n);

            text[at] = k % 2 ? good[(at * 7919) % n] : (char)(128.0 * noise(&seed));
        }
        if (mech_read_text(&m, "x", text, n, NULL, 0, NULL, NULL, &err) == STEIN_OK) {
            accepted++;
        } else {
            ck_assert(err.code == STEIN_EPARSE && err.msg[0] != '\0');
        }
        mech_free(m);
    }
    printf("damaged mechanism files: %d of 1500 are still valid\n", accepted);
}
END_TEST

void hostile_cases(Suite *suite)
{
    TCase *tc = tcase_create("hostile");

    tcase_set_timeout(tc, 60.0);
    tcase_add_test(tc, text_that_is_no_plain_yaml_is_refused);
    tcase_add_test(tc, depth_width_and_size_are_capped);
    tcase_add_test(tc, all_problems_are_reported_in_the_order_of_the_file);
    tcase_add_test(tc, a_problem_is_one_line_whatever_stands_in_the_file);
    tcase_add_test(tc, at_most_fifty_problems_are_reported);
    tcase_add_test(tc, damaged_files_are_refused_or_read_but_never_crash);
    suite_add_tcase(suite, tc);
}
