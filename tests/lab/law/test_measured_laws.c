/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_measured_laws.c - measurements made by others: laws recovered without a table, and a
 * coupling that is taken apart.
 */
#include <string.h>

#include "measured_support.h"

/* ---- the air's law without a table ---- */

/* straight line through a law by least squares: force at speed 0 and per speed. @return largest
 * distance in standard deviations of the law */
static double straight(const lab_law *l, double *at_rest, double *per_speed)
{
    double sw = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0, far = 0.0;
    for (int k = 0; k < l->n; k++) {
        double w = 1.0 / (l->sd[k] * l->sd[k]), x = fabs(l->at[k]);
        sw += w, sx += w * x, sy += w * l->value[k];
        sxx += w * x * x, sxy += w * x * l->value[k];
    }
    *per_speed = (sw * sxy - sx * sy) / (sw * sxx - sx * sx);
    *at_rest = (sy - *per_speed * sx) / sw;
    for (int k = 0; k < l->n; k++) {
        double off = l->value[k] - *at_rest - *per_speed * fabs(l->at[k]);
        far = fmax(far, fabs(off) / l->sd[k]);
    }
    return far;
}

/* the same for a multiple of the square of the speed */
static double parabola(const lab_law *l)
{
    double sxx = 0.0, sxy = 0.0, far = 0.0;
    for (int k = 0; k < l->n; k++) {
        double w = 1.0 / (l->sd[k] * l->sd[k]), x = l->at[k] * l->at[k];
        sxx += w * x * x, sxy += w * x * l->value[k];
    }
    for (int k = 0; k < l->n; k++) {
        double off = l->value[k] - sxy / sxx * l->at[k] * l->at[k];
        far = fmax(far, fabs(off) / l->sd[k]);
    }
    return far;
}

static void recover_law(const char *ball, int light)
{
    static const char *const nothing[] = {"all", NULL};
    char name[2][60];
    fitted f;
    for (int i = 0; i < 2; i++) {
        snprintf(name[i], sizeof name[i], "ball_%s_%d.csv", ball, i + 1);
    }
    const char *const file[] = {name[0], name[1]};
    lab_diagnosis *d = diagnosed(&f, "models/falling_ball.yaml", file, 2, 1, nothing);
    ck_assert_int_eq(d->nsuspect, 0);
    const lab_law *l = d->law;
    if (!light) {
        printf("%-20s without a table: %s, best curve gains %.2g\n", ball,
               lab_verdict_text(d->verdict), d->nlaw > 0 ? l->gain : 0.0);
        ck_assert_int_eq(d->verdict, LAB_VERDICT_EXPLAINED);
        ck_assert(d->nlaw == 0 || !l->pays);
    } else {
        double rest, slope, line = 0.0;
        ck_assert_int_eq(d->verdict, LAB_VERDICT_UNKNOWN_EFFECT);
        ck_assert(d->nlaw > 0 && l->pays);
        ck_assert_str_eq(l->place, "ball");
        ck_assert_str_eq(l->of, "speed");
        ck_assert(d->gain.ratio <= 0.25);
        line = straight(l, &rest, &slope);
        printf("%-20s without a table: force %.3f N + %.4f N s/m |v| (%.1f sd), k v^2 is %.1f sd "
               "off; held-out error %.3f\n",
               ball, rest, slope, line, parabola(l), d->gain.ratio);
        ck_assert(slope > 0.0); // against the motion, and more when it is faster
        for (int k = 0; k < l->n; k++) {
            // the last metres of a fall have little information about the fastest speeds: there a
            // band may reach 0
            ck_assert_msg(l->at[k] > -8.0 || l->at[k] < -17.0 || l->lo[k] > 0.0, "%s at %g m/s",
                          ball, l->at[k]);
            ck_assert_msg(l->at[k] > -8.0 || l->value[k] > 0.0, "%s at %g m/s", ball, l->at[k]);
        }
        ck_assert(strstr(d->reason, "do not separate the two") != NULL); // height, of one height
    }
    lab_diagnosis_destroy(d);
    drop(&f);
}

START_TEST(the_law_of_the_air_is_recovered_without_a_table_where_it_matters)
{
    static const char *const light[] = {"whiffle_ball_1", "whiffle_ball_2", "orange_whiffle_ball",
                                        "tennis_ball"},
                             *const heavy[] = {"bowling_ball", "golf_ball", "baseball"};
    if (is_too_slow() || !converted()) {
        return;
    }
    for (size_t i = 0; i < sizeof light / sizeof *light; i++) {
        recover_law(light[i], 1);
    }
    for (size_t i = 0; i < sizeof heavy / sizeof *heavy; i++) {
        recover_law(heavy[i], 0);
    }
}
END_TEST

/* two drops in air, in their frames, without a stated noise */
START_TEST(a_short_record_that_states_no_noise_shows_its_law)
{
    static const char *const air[] = {"ball.drag=9e-4 N s^2/m^2", NULL},
                             *const told[] = {"ball.mass=28 g", NULL},
                             *const nothing[] = {"all", NULL},
                             *const name[] = {"drop_1.csv", "drop_2.csv"};
    fitted f;
    for (int i = 0; i < 2; i++) {
        film m = {.model = "models/falling_ball.yaml",
                  .truth = air,
                  .told = told,
                  .channels = "height",
                  .rate = 15.0,
                  .until = 3.5,
                  .noise = 0.015,
                  .silent = 1,
                  .seed = 31ULL + (unsigned long long)i};
        take(name[i], &m);
    }
    lab_diagnosis *d = diagnosed(&f, "models/falling_ball.yaml", name, 2, 1, nothing);
    ck_assert_int_eq(d->verdict, LAB_VERDICT_UNKNOWN_EFFECT);
    ck_assert(d->nlaw > 0 && d->law[0].pays);
    const lab_law *l = &d->law[0];
    printf("a drop made here: %d samples, k v^2 is %.1f sd off, held-out error %.3f\n", d->samples,
           parabola(l), d->gain.ratio);
    ck_assert_int_lt(d->samples, 60);
    ck_assert_str_eq(l->of, "speed");
    ck_assert(d->gain.ratio < 0.1);
    ck_assert(parabola(l) < 3.0);
    lab_diagnosis_destroy(d);
    drop(&f);
}
END_TEST

/* ---- key and hammer of a grand ---- */

START_TEST(a_rigid_coupling_is_found_to_let_go_and_a_plain_sensor_to_be_bent)
{
    static const char *const file[] = {"grand_slow.csv",   "grand_fast_1.csv", "grand_fast_2.csv",
                                       "grand_fast_3.csv", "grand_fast_4.csv", "grand_fast_5.csv",
                                       "grand_fast_6.csv"};
    static const char *const plain[] = {"grand_plain_slow.csv", "grand_plain_fast_1.csv",
                                        "grand_plain_fast_2.csv"};
    if (is_too_slow() || !converted()) {
        return;
    }
    fitted f;
    lab_diagnosis *d =
        diagnosed(&f, "models/grand_action.yaml", file, soaks() > 0 ? 7 : 4, 2, NULL);
    int k = 0; // the stiffness of the jack beside it is another one, too
    while (k < d->ncause && strcmp(d->suspect[k].candidate.effect->kind, "let_off") != 0) {
        k++;
    }
    ck_assert_msg(k < d->ncause, "%s", d->reason);
    const lab_suspect *s = &d->suspect[k];
    ck_assert_str_eq(s->candidate.place, "jack");
    double z = 8e-3 - s->number[0].value;
    printf("grand: the jack lets go %.2f mm up (95 %%: %.2f .. %.2f), held-out error %.3f of what "
           "it was, chi2/dof %.2f -> %.2f\n",
           1e3 * z, 8.0 - 1e3 * s->number[0].hi, 8.0 - 1e3 * s->number[0].lo, d->gain.ratio,
           d->chi2_dof_before, d->chi2_dof_after);
    ck_assert(z > 4e-3 && z < 6e-3); // it goes up to 6.8 mm
    ck_assert(d->gain.hi < 0.6);
    ck_assert(d->chi2_dof_after < 1.2);
    char *path = lab__text("%s", in_folder("grand_off.yaml"));
    ck_assert_stein(lab_extend(path, "models/grand_action.yaml", d, err));
    lab_diagnosis_destroy(d);
    drop(&f);
    // the same strokes, read as if the hammer's sensor were linear
    int slow = soaks() > 0;
    d = diagnosed(&f, path, plain + !slow, 2 + slow, 1, NULL);
    s = &d->suspect[0];
    ck_assert_int_eq(d->verdict, LAB_VERDICT_SENSOR);
    ck_assert_str_eq(s->candidate.effect->kind, "sensor_nonlinearity");
    ck_assert_str_eq(s->candidate.place, "hammer_travel");
    printf("grand, plain sensor: k2 = %.1f 1/m (95 %%: %.1f .. %.1f), held-out error %.3f of what "
           "it was\n",
           s->number[0].value, s->number[0].lo, s->number[0].hi, d->gain.ratio);
    ck_assert(s->number[0].lo > 30.0); // its table is bent that way: steep at the far end
    ck_assert(d->gain.ratio < 0.8);
    lab_diagnosis_destroy(d);
    drop(&f);
    free(path);
}
END_TEST

Suite *measured_laws_suite(void)
{
    Suite *suite = suite_create("measured_laws");
    TCase *all = tcase_create("measured_laws");
    tcase_add_unchecked_fixture(all, make_measured, remove_folder);
    tcase_set_timeout(all, 900);
    tcase_add_test(all, the_law_of_the_air_is_recovered_without_a_table_where_it_matters);
    tcase_add_test(all, a_short_record_that_states_no_noise_shows_its_law);
    tcase_add_test(all, a_rigid_coupling_is_found_to_let_go_and_a_plain_sensor_to_be_bent);
    suite_add_tcase(suite, all);
    return suite;
}
