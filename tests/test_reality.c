/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_reality.c - the independent source of measurements (tests/reality). It agrees with the core
 * where nothing is hidden. Every effect changes something, and nothing at size zero; sizes are as
 * stated. The films do not contain the answer.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "reality_support.h"

START_TEST(the_base_model_agrees_with_the_core_to_a_micrometre)
{
    static const double settings[][2] = {{-0.9, 80.0}, {-0.7, 140.0}, {-0.4, 100.0},
                                         {-0.1, 70.0}, {0.0, 100.0},  {0.1, 120.0}};
    stein_sim *sim = make_sim(&stein_model_stein1788, STEIN_RK4, 0.0);
    for (size_t i = 0; i < sizeof settings / sizeof *settings; i++) {
        double dx = settings[i][0], load = settings[i][1];
        char what[80];
        ck_assert_int_eq(run("--stroke --dx %g --load %g -o %s", dx, load, in_folder("a.csv")), 0);
        read_table(&film, in_folder("a.csv"));
        ck_assert_int_eq(film.rows, 2401);
        ck_assert_stein(stein_set(sim, "pawl.stop_shift", 1e-3 * dx, err));
        ck_assert_stein(stein_set(sim, "load.mass", 1e-3 * load, err));
        ck_assert_stein(stein_reset(sim, err));
        snprintf(what, sizeof what, "dx %+.1f mm, %g g", dx, load);
        compare(sim, what);
    }
    stein_sim_destroy(sim);
}
END_TEST

typedef struct touch {
    double zero, size, time;
} touch;

/* the touch of the driven strokes, written independently: 10 s^3 - 15 s^4 + 6 s^5 */
static void smooth_rise(void *ctx, double t, double u[3])
{
    const touch *k = ctx;
    double s = fmin(fmax(t / k->time, 0.0), 1.0), s2 = s * s;
    u[0] = k->zero + k->size * s2 * s * (10.0 - 15.0 * s + 6.0 * s2);
    u[1] = k->size / k->time * 30.0 * s2 * (1.0 - 2.0 * s + s2);
    u[2] = k->size / (k->time * k->time) * (60.0 * s - 180.0 * s2 + 120.0 * s2 * s);
}

START_TEST(driven_strokes_agree_with_the_core)
{
    stein_sim *sim = make_sim(&stein_model_stein1788, STEIN_RK4, 0.0);
    ck_assert_stein(stein_set(sim, "load.mass", 5e-3, err));
    ck_assert_stein(stein_reset(sim, err));
    double rest = stein_q(sim)[0];
    touch finger = {0.0, 1.2, 0.03}, key = {rest, 0.039, 0.07};

    ck_assert_int_eq(
        run("--stroke --kind input_gain --place finger --amount 0 -o %s", in_folder("a.csv")), 0);
    read_table(&film, in_folder("a.csv"));
    ck_assert_stein(stein_drive(sim, "finger", smooth_rise, &finger, err));
    compare(sim, "finger");

    ck_assert_int_eq(
        run("--stroke --kind input_gain --place key_motion --amount 0 -o %s", in_folder("a.csv")),
        0);
    read_table(&film, in_folder("a.csv"));
    ck_assert_stein(stein_drive(sim, "finger", NULL, NULL, err));
    ck_assert_stein(stein_drive(sim, "key_motion", smooth_rise, &key, err));
    ck_assert_stein(stein_reset(sim, err));
    compare(sim, "key motion");
    stein_sim_destroy(sim);
}
END_TEST

/* Effects that are parameters of every mechanism: the names of size and of what goes with it. */
static const struct {
    const char *kind, *place, *size, *side[2];
} known[] = {
    {"viscous_friction", "key", "key.damping", {NULL, NULL}},
    {"coulomb_friction", "hammer", "hammer.coulomb.T", {"hammer.coulomb.w", NULL}},
    {"stiction_peak", "pawl", "pawl.friction.B1", {"pawl.friction.B2", NULL}},
    {"quadratic_drag", "hammer", "hammer.drag", {NULL, NULL}},
    {"preload", "pawl", "pawl.preload", {NULL, NULL}},
    {"hardening_spring", "pawl", "pawl.spring.k3", {NULL, NULL}},
    {"backlash", "hammer", "hammer.backlash.k", {"hammer.backlash.gap", NULL}},
    {"contact_exponent", "dip", "dip.normal.p", {NULL, NULL}},
    {"contact_hysteresis", "string", "string.normal.h", {NULL, NULL}},
    {"contact_gap", "loops", "loops.gap", {NULL, NULL}},
    {"contact_gap", "notch", "notch.gap", {NULL, NULL}},
    {"adhesion", "string", "string.adhesion.F", {"string.adhesion.range", NULL}},
    {"adhesion", "notch", "notch.adhesion.F", {"notch.adhesion.range", NULL}},
    {"mass", "hammer", "hammer.mass", {NULL, NULL}},
    {"wrong_parameter", "pawl.corner.z", "pawl.corner.z", {NULL, NULL}},
};

START_TEST(known_effects_are_the_same_in_the_core)
{
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        stein_sim *sim = make_sim(&stein_model_stein1788, STEIN_RK4, 0.0);
        double value[3];
        char what[80];
        ck_assert_int_eq(run("--stroke --dx -0.3 --kind %s --place %s --amount 0.1 -o %s",
                             known[i].kind, known[i].place, in_folder("a.csv")),
                         0);
        char *said = read_all(in_folder("said"));
        ck_assert_int_eq(sscanf(said, "%lf %lf %lf", &value[0], &value[1], &value[2]), 3);
        free(said);
        read_table(&film, in_folder("a.csv"));
        ck_assert_stein(stein_set(sim, "pawl.stop_shift", -0.3e-3, err));
        ck_assert_stein(stein_set(sim, known[i].size, value[0], err));
        for (int k = 0; k < 2 && known[i].side[k] != NULL; k++) {
            ck_assert_stein(stein_set(sim, known[i].side[k], value[k + 1], err));
        }
        ck_assert_stein(stein_reset(sim, err));
        snprintf(what, sizeof what, "%s at %s", known[i].kind, known[i].place);
        compare(sim, what);
        stein_sim_destroy(sim);
    }
}
END_TEST

/* ---- effects ---- */

static double largest_change(const table *a, const table *b)
{
    double worst = 0.0;
    ck_assert_int_eq(a->rows, b->rows);
    for (int i = 0; i < a->rows; i++) {
        for (int k = 1; k < a->columns; k++) {
            worst = fmax(worst, fabs(a->cell[i][k] - b->cell[i][k]));
        }
    }
    return worst;
}

static void check_effect(const char *kind, const char *place)
{
    static table none;
    static char played[20] = "nothing yet"; // what moved the key in the last stroke without effect
    int driven = strncmp(kind, "input_", 6) == 0;
    const char *bare = driven ? "input_gain" : "mass", *at = driven ? place : "key";
    if (strcmp(played, at) != 0) {
        ck_assert_int_eq(run("--stroke --dx -0.3 --kind %s --place %s --amount 0 -o %s", bare, at,
                             in_folder("none.csv")),
                         0);
        snprintf(played, sizeof played, "%s", at);
    }
    ck_assert_int_eq(run("--stroke --dx -0.3 --kind %s --place %s --amount 0 -o %s", kind, place,
                         in_folder("zero.csv")),
                     0);
    ck_assert_int_eq(run("--stroke --dx -0.3 --kind %s --place %s --amount 0.2 -o %s", kind, place,
                         in_folder("some.csv")),
                     0);
    read_table(&none, in_folder("none.csv"));
    read_table(&film, in_folder("zero.csv"));
    read_table(&other, in_folder("some.csv"));
    ck_assert_msg(largest_change(&none, &film) <= 0.0, "%s at %s acts at size 0", kind, place);
    ck_assert_msg(largest_change(&none, &other) > 1e-9, "%s at %s does nothing", kind, place);
}

START_TEST(every_effect_acts_and_does_nothing_at_size_zero)
{
    ck_assert_int_eq(run("--list"), 0);
    char *text = read_all(in_folder("said")), *rest = text, kind[40] = "";
    int kinds = 0, places = 0;
    for (char *line = strtok_r(text, "\n", &rest); line != NULL;
         line = strtok_r(NULL, "\n", &rest)) {
        if (line[0] != ' ') {
            ck_assert_int_eq(sscanf(line, "%39s", kind), 1);
            kinds++;
        } else if (strncmp(line, "    places: ", 12) == 0) {
            char *more = line;
            strtok_r(line + 12, " ", &more);
            for (char *place = line + 12; place != NULL; place = strtok_r(NULL, " ", &more)) {
                check_effect(kind, place);
                places++;
            }
        }
    }
    printf("%d kinds of effects at %d places\n", kinds, places);
    ck_assert_int_ge(kinds, 36);
    free(text);
}
END_TEST

static void check_level(const char *kind, const char *place, const char *level, double target)
{
    ck_assert_int_eq(run("--seed 7 --kind %s --place %s --level %s --verify -o %s", kind, place,
                         level, in_folder("set")),
                     0);
    char *answer = read_all(in_folder("set/answer.json"));
    double reached = json_number(answer, "reached"), dense = json_number(answer, "dense");
    printf("%s at %s, %s: size %.4f, by dense least squares %.4f\n", kind, place, level, reached,
           dense);
    ck_assert_ptr_nonnull(strstr(answer, kind));
    ck_assert_ptr_nonnull(strstr(answer, "\"met\": true"));
    ck_assert_close(reached, target, 0.1, 0.0); // within the tolerance
    ck_assert_close(dense, reached, 0.03, 0.0);
    free(answer);
}

START_TEST(a_level_is_the_size_after_refitting)
{
    check_level("coulomb_friction", "key", "L2", 0.5);
}
END_TEST

/* ---- sets ---- */

static const char *set_file(const char *set, int i)
{
    char name[60];
    snprintf(name, sizeof name, "%s/%s_%02d.csv", set, i < FIT ? "fit" : "held",
             i < FIT ? i + 1 : i - FIT + 1);
    return in_folder(name);
}

START_TEST(a_seed_gives_the_same_bytes_and_another_seed_others)
{
    ck_assert_int_eq(run("--seed 11 --null -o %s", in_folder("one")), 0);
    ck_assert_int_eq(run("--seed 11 --null -o %s", in_folder("two")), 0);
    ck_assert_int_eq(run("--seed 12 --null -o %s", in_folder("three")), 0);
    for (int i = 0; i <= FIT + HELD; i++) {
        int last = i == FIT + HELD;
        char *a = read_all(last ? in_folder("one/answer.json") : set_file("one", i));
        char *b = read_all(last ? in_folder("two/answer.json") : set_file("two", i));
        char *c = read_all(last ? in_folder("three/answer.json") : set_file("three", i));
        ck_assert_str_eq(a, b);
        ck_assert_str_ne(a, c);
        free(a);
        free(b);
        free(c);
    }
}
END_TEST

/* the lines above the numbers of a film */
static char *head_of(const char *path)
{
    char *text = read_all(path), *end = strstr(text, "\n-0.0");
    ck_assert_ptr_nonnull(end);
    *end = '\0';
    return text;
}

START_TEST(films_give_nothing_away)
{
    ck_assert_int_eq(run("--seed 22 --null -o %s", in_folder("null")), 0);
    ck_assert_int_eq(
        run("--seed 22 --kind camera_tilt --place key_dip --level L1 -o %s", in_folder("tilted")),
        0);
    for (int i = 0; i < FIT + HELD; i++) {
        char *a = head_of(set_file("null", i)), *b = head_of(set_file("tilted", i));
        ck_assert_str_eq(a, b);
        for (const char *line = a; line != NULL; line = strchr(line, '\n')) {
            line += *line == '\n';
            ck_assert(strncmp(line, "# set pawl.stop_shift: ", 23) == 0 ||
                      strncmp(line, "# set load.mass: ", 17) == 0 ||
                      strncmp(line, "# noise string_distance: ", 25) == 0 ||
                      strncmp(line, "# noise key_dip: ", 17) == 0 ||
                      strcmp(line, "time [s],string_distance [m],key_dip [m]") == 0 ||
                      strncmp(line, "# trigger: unsynchronised\n", 26) == 0);
        }
        free(a);
        free(b);
        read_table(&film, set_file("null", i));
        read_table(&other, set_file("tilted", i));
        ck_assert_int_eq(film.rows, other.rows);
        ck_assert(largest_change(&film, &other) > 0.0 || i > 0);
    }
}
END_TEST

/* standard deviation of the frames before the release, all strokes, about each stroke's mean */
static double rest_noise(const char *set, int column)
{
    double sum = 0.0;
    int n = 0;
    for (int i = 0; i < FIT + HELD; i++) {
        double mean = 0.0, square = 0.0;
        int m = 0;
        read_table(&film, set_file(set, i));
        for (int k = 0; k < film.rows && film.cell[k][0] < -0.5e-3; k++) {
            double x = film.cell[k][column];
            if (!isnan(x)) {
                mean += x;
                square += x * x;
                m++;
            }
        }
        sum += square - mean * mean / m;
        n += m - 1;
    }
    return sqrt(sum / n);
}

/* RMS over the strokes of one number of the answer's list; *n counts them */
static double scatter_of(const char *answer, const char *key, int *n)
{
    double sum = 0.0;
    char quoted[60];
    *n = 0;
    snprintf(quoted, sizeof quoted, "\"%s\": ", key);
    for (const char *at = strstr(answer, "\"strokes\""); at != NULL; at = strstr(at, quoted)) {
        if (*n > 0 || strncmp(at, quoted, strlen(quoted)) == 0) {
            double x = strtod(at + strlen(quoted), NULL);
            sum += x * x;
            ++*n;
        }
        at++;
    }
    return sqrt(sum / (*n > 0 ? *n : 1));
}

START_TEST(null_sets_have_the_noise_and_the_scatter_they_should)
{
    int rough = 0, n = 0;
    double drive = 0.0, contacts = 0.0;
    for (int seed = 31; seed < 39; seed++) {
        ck_assert_int_eq(run("--seed %d --null -o %s", seed, in_folder("null")), 0);
        char *answer = read_all(in_folder("null/answer.json"));
        ck_assert_ptr_nonnull(strstr(answer, "\"kind\": null"));
        ck_assert_ptr_nonnull(strstr(answer, "\"class\": \"explained\""));
        for (int column = 1; column <= 2; column++) {
            ck_assert_close(rest_noise("null", column), 11.547e-6, 0.15, 0.0);
        }
        double d = scatter_of(answer, "drive", &n);
        double c = scatter_of(answer, "contact_friction", &n) /
                   json_number(strstr(answer, "\"scatter\""), "contact_friction");
        ck_assert_int_eq(n, FIT + HELD);
        ck_assert_double_lt(scatter_of(answer, "trigger", &n), 2.5e-4);
        ck_assert_double_gt(scatter_of(answer, "trigger", &n), 4e-5);
        if (d > 0.0) {
            rough++;
            drive += d * d;
            contacts += c * c;
        }
        free(answer);
    }
    ck_assert_int_ge(rough, 1);
    ck_assert_int_le(rough, 7);
    printf("%d of 8 null sets with scatter: drive %.2f %%, contacts %.2f of what is told\n", rough,
           100.0 * sqrt(drive / rough), sqrt(contacts / rough));
    ck_assert_close(sqrt(drive / rough), 0.003, 0.3, 0.0);
    ck_assert_close(sqrt(contacts / rough), 1.0, 0.3, 0.0);
}
END_TEST

Suite *reality_suite(void)
{
    Suite *suite = suite_create("reality");
    TCase *tc = tcase_create("reality");
    tcase_set_timeout(tc, 300);
    tcase_add_checked_fixture(tc, make_folder, remove_folder);
    tcase_add_test(tc, the_base_model_agrees_with_the_core_to_a_micrometre);
    tcase_add_test(tc, driven_strokes_agree_with_the_core);
    tcase_add_test(tc, known_effects_are_the_same_in_the_core);
    tcase_add_test(tc, every_effect_acts_and_does_nothing_at_size_zero);
    tcase_add_test(tc, a_level_is_the_size_after_refitting);
    tcase_add_test(tc, a_seed_gives_the_same_bytes_and_another_seed_others);
    tcase_add_test(tc, films_give_nothing_away);
    tcase_add_test(tc, null_sets_have_the_noise_and_the_scatter_they_should);
    suite_add_tcase(suite, tc);
    return suite;
}
