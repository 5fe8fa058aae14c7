/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_import.c - ROBOTRAN projects become mechanism files with the same M and c as mechanisms that
 * were written by hand; omissions are reported; files that are not in order are refused by place.
 */
#include "import_support.h"

enum { STATES = 20, MOST_NQ = 8 };

/* M, c of both at the same states; joint i of the one is joint map[i] of the other */
static void same_equations(const lab_model *one, const lab_model *other, const int *map)
{
    int n = lab_equations(one)->nq;
    unsigned long long seed = 1900;
    stein_sim *sim[2];
    ck_assert_int_eq(lab_equations(other)->nq, n);
    ck_assert_stein(lab_sim(one, NULL, &sim[0], err));
    ck_assert_stein(lab_sim(other, NULL, &sim[1], err));
    for (int i = 0; i < n && lab_equations(one)->nrow == 0; i++) { // initial values as well
        ck_assert_close(stein_q(sim[0])[i], stein_q(sim[1])[map[i]], 1e-15, 0.0);
        ck_assert_close(stein_qd(sim[0])[i], stein_qd(sim[1])[map[i]], 1e-15, 0.0);
    }
    for (int s = 0; s < STATES; s++) {
        double q[2][MOST_NQ], qd[2][MOST_NQ], M[2][MOST_NQ * MOST_NQ], c[2][MOST_NQ];
        for (int i = 0; i < n; i++) {
            q[1][map[i]] = q[0][i] = 2.3 * noise(&seed);
            qd[1][map[i]] = qd[0][i] = 3.7 * noise(&seed);
        }
        for (int k = 0; k < 2; k++) {
            stein_mass_bias(sim[k], q[k], qd[k], NULL, NULL, M[k], c[k]);
        }
        for (int i = 0; i < n; i++) {
            ck_assert_close(c[0][i], c[1][map[i]], 1e-12, 1e-12);
            for (int j = 0; j < n; j++) {
                ck_assert_close(M[0][i * n + j], M[1][map[i] * n + map[j]], 1e-12, 1e-14);
            }
        }
    }
    stein_sim_destroy(sim[0]);
    stein_sim_destroy(sim[1]);
}

START_TEST(a_planar_project_has_the_equations_of_the_file_written_by_hand)
{
    lab_options options = lab_options_default();
    lab_model *mine = NULL, *theirs = NULL;
    const char *set[] = {"block.initial.position=0.185", "crank.initial.speed=100"};
    int back[4]; // joint of theirs -> of mine
    lab_imported done = import("tests/mbs/piston.mbs", in_folder("piston.yaml"));
    ck_assert_str_eq(done.name, "piston");
    ck_assert(done.bodies == 4 && done.joints == 4 && done.points == 3 && done.left_out == 0);
    ck_assert_int_eq(done.loops, 1);
    ck_assert_stein(lab_open(&theirs, in_folder("piston.yaml"), &options, err));
    options.set = set;
    options.nset = 2;
    ck_assert_stein(lab_open(&mine, "models/robotran/piston.yaml", &options, err));
    for (int i = 0; i < 4; i++) {
        back[i] = stein_find_body(lab_equations(mine), lab_equations(theirs)->bodies[i].name);
        ck_assert_int_ge(back[i], 0);
    }
    ck_assert(lab_equations(theirs)->nrow == 2 && lab_equations(mine)->nrow == 0);
    same_equations(theirs, mine, back);
    ck_assert_int_eq(lab_equations(theirs)->ops_mass_bias.mul,
                     lab_equations(mine)->ops_mass_bias.mul);
    lab_close(mine);
    lab_close(theirs);
}
END_TEST

/* tests/mbs/arm.mbs as one would write it, with other names and units */
static const char arm_by_hand[] =
    "mechanism: by_hand\n"
    "gravity: [0.3 m/s^2, -0.7 m/s^2, -9.7 m/s^2]\n"
    "bodies:\n"
    "  post: {joint: R z, at: [11 cm, -23 cm, 370 mm], mass: 0,\n"
    "         initial: {position: 0.21 rad, speed: -0.4 rad/s}}\n"
    "  slide: {parent: post, joint: T y, mass: 0}\n"
    "  arm:\n"
    "    parent: slide\n"
    "    joint: R x\n"
    "    mass: 2.7 kg\n"
    "    centre: [21 mm, 13 mm, -31 mm]\n"
    "    inertia: {xx: 0.017 kg m^2, yy: 0.023 kg m^2, zz: 0.029 kg m^2,\n"
    "              xy: 1.3e-3 kg m^2, xz: -2.1e-3 kg m^2, yz: 7e-4 kg m^2}\n"
    "  wrist: {parent: arm, joint: R y, at: [-100 mm, 40 mm, 60 mm], mass: 0}\n"
    "  hand: {parent: wrist, joint: T x, mass: 900 g, centre: [0, 50 mm, 0],\n"
    "         inertia: {xx: 2e-3, yy: 3e-3, zz: 2.5e-3}}\n";

START_TEST(a_spatial_project_with_several_joints_a_body_does_so_too)
{
    static const int map[] = {0, 1, 2, 3, 4};
    lab_options options = lab_options_default();
    lab_model *mine = NULL, *theirs = NULL;
    lab_imported done = import("tests/mbs/arm.mbs", in_folder("arm.yaml"));
    ck_assert_str_eq(done.name, "n6_axes");
    ck_assert(done.bodies == 2 && done.joints == 5 && done.points == 4);
    static const char *const told[] = {"\"struct\" is called struct_",
                                       "\"tilt angle\"",
                                       "\"left up\" is called left_up_2",
                                       "sensor \"eye\": Om is not read here",
                                       "external force \"wind\" on struct_.left_up_2: its law is",
                                       "\"springy\"",
                                       "link rope: its law is in user code",
                                       "user model \"Motor\"",
                                       "<novelty> of the project (line"};
    text_has(said, told, sizeof told / sizeof *told);
    ck_assert_stein(lab_open(&theirs, in_folder("arm.yaml"), &options, err));
    ck_assert_stein(
        lab__open_text(&mine, "by_hand.yaml", arm_by_hand, sizeof arm_by_hand - 1, &options, err));
    same_equations(mine, theirs, map);

    // a driven joint is held, others move; the outputs are called like the joints
    stein_sim *sim;
    double lift = 1.0, tilt = 0.0;
    ck_assert_int_ge(stein_find_input(lab_equations(theirs), "drive_lift"), 0);
    ck_assert_stein(lab_sim(theirs, NULL, &sim, err));
    ck_assert_stein(stein_run(sim, 0.1, err));
    ck_assert_stein(stein_read_name(sim, "lift", &lift, err));
    ck_assert_stein(stein_read_name(sim, "tilt_angle", &tilt, err));
    ck_assert(lift == 0.0 && fabs(tilt) > 1e-6);
    stein_sim_destroy(sim);

    // the notes are at the head of the file as well
    char *text = NULL;
    size_t size;
    ck_assert_stein(lab__read_file(in_folder("arm.yaml"), &text, &size, err));
    ck_assert_ptr_nonnull(strstr(text, "#   user model \"Motor\"\n"));
    free(text);
    lab_close(mine);
    lab_close(theirs);
}
END_TEST

/* tests/mbs/rig.mbs as one would write it */
static const char rig_by_hand[] =
    "mechanism: by_hand\n"
    "inertia: accept\n"
    "gravity: [0, 0, -9.81]\n"
    "points: {a: [0.01, 0, 0.02], b: [0.31, 0, 0.02], c: [0.1, 0.07, 0]}\n"
    "bodies:\n"
    "  crank: {joint: R y, at: frame.a, mass: 0.5, centre: [0.05, 0, 0.01], inertia: {yy: 5e-4},\n"
    "          points: {p: [0.1, 0, 0]}, initial: {position: -1.1, speed: 3}}\n"
    "  coupler: {parent: crank, at: crank.p, joint: R y, mass: 0.8, centre: [0.15, 0, 0],\n"
    "            inertia: {yy: 6e-3}, points: {e: [0.3, 0, 0]}, initial: {guess: 0.9}}\n"
    "  rocker: {joint: R y, at: frame.b, mass: 0.6, centre: [0.1, 0, 0], inertia: {yy: 2e-3},\n"
    "           points: {e: [0.2, 0, 0]}, initial: {guess: -0.9}}\n"
    "  wheel: {parent: rocker, at: rocker.e, joint: R y, mass: 1.5,\n"
    "          inertia: {xx: 0.1, yy: 0.8, zz: 0.1}, initial: {position: 0.4}}\n"
    "  slider: {joint: T z, at: frame.c, mass: 0.7, points: {o: [0, 0, 0]},\n"
    "           initial: {guess: -0.3}}\n"
    "  fly_x: {joint: T x, mass: 0}\n"
    "  fly_z: {parent: fly_x, joint: T z, mass: 0}\n"
    "  plate: {parent: fly_z, joint: R y, mass: 0.2, centre: [0.02, 0, 0], inertia: {yy: 3e-4},\n"
    "          points: {m: [0.03, 0, 0.01]}}\n"
    "loops:\n"
    "  pin: {between: [coupler.e, rocker.e]}\n"
    "  pull: {between: [crank.p, slider.o], rod: 0.5}\n"
    "  glue: {between: [plate.m, rocker.e], weld: yes}\n"
    "inputs: {turn: {motion: wheel, idle: hold}, motor: {torque: slider}}\n"
    "outputs: {tip: {point: rocker.e, read: x}}\n";

static void constant(void *ctx, double t, double u[3])
{
    (void)t;
    u[0] = *(const double *)ctx;
    u[1] = u[2] = 0.0;
}

START_TEST(cuts_are_loops_and_the_motion_is_that_of_the_file_written_by_hand)
{
    lab_options options = lab_options_default();
    lab_model *model[2] = {NULL, NULL};
    stein_sim *sim[2];
    double force = 2.3;
    lab_imported done = import_as("tests/mbs/rig.mbs", in_folder("rig.yaml"), LAB_INERTIA_ACCEPT);
    ck_assert(done.bodies == 6 && done.joints == 8 && done.loops == 4);
    static const char *const told[] = {"cut pin ignores some of its conditions",
                                       "link spring: its law is in user code (user_LinkForces)",
                                       "external force \"gust\"",
                                       "the inertia of wheel is accepted"};
    text_has(said, told, sizeof told / sizeof *told);
    ck_assert_stein(lab_open(&model[0], in_folder("rig.yaml"), &options, err));
    ck_assert_stein(lab__open_text(&model[1], "by_hand.yaml", rig_by_hand, sizeof rig_by_hand - 1,
                                   &options, err));
    for (int k = 0; k < 2; k++) {
        const char *motor[] = {"motor_slide", "motor"};
        ck_assert_stein(lab_sim(model[k], NULL, &sim[k], err));
        ck_assert_int_eq(stein_freedom(sim[k]), 1); // the crank
        ck_assert(stein_q(sim[k])[0] == -1.1 && stein_q(sim[k])[3] == 0.4);
        ck_assert_stein(stein_drive(sim[k], motor[k], constant, &force, err));
    }
    for (int step = 0; step < 3; step++) {
        for (int i = 0; i < lab_equations(model[0])->nq; i++) {
            ck_assert_close(stein_q(sim[0])[i], stein_q(sim[1])[i], 1e-12, 1e-12);
            ck_assert_close(stein_qdd(sim[0])[i], stein_qdd(sim[1])[i], 1e-12, 1e-12);
        }
        ck_assert_stein(stein_run(sim[0], 0.02 * (step + 1), err));
        ck_assert_stein(stein_run(sim[1], 0.02 * (step + 1), err));
    }
    double before = stein_qdd(sim[0])[0]; // forces by name act at their places in the project
    ck_assert_stein(stein_drive(sim[0], "gust_x", constant, &force, err));
    ck_assert(fabs(stein_qdd(sim[0])[0] - before) > 0.1);
    for (int k = 0; k < 2; k++) {
        stein_sim_destroy(sim[k]);
        lab_close(model[k]);
    }
}
END_TEST

START_TEST(an_inertia_that_no_body_has_is_refused_taken_or_balanced_as_asked)
{
    stein_err told = {STEIN_OK, ""};
    const char *to = in_folder("rig.yaml");
    char *text = NULL;
    size_t size;
    ck_assert_int_eq(
        lab_import("tests/mbs/rig.mbs", to, LAB_INERTIA_REFUSE, NULL, NULL, NULL, &told),
        STEIN_EPARSE);
    ck_assert_msg(strstr(told.msg, "the inertia of wheel is not possible") != NULL, "%s", told.msg);
    import_as("tests/mbs/rig.mbs", to, LAB_INERTIA_BALANCE);
    ck_assert_ptr_nonnull(strstr(said, "the inertia of wheel is balanced: all three moments are"));
    ck_assert_stein(lab__read_file(to, &text, &size, err));
    ck_assert_ptr_nonnull(strstr(text, "\ninertia: balance\n"));
    free(text);
}
END_TEST

START_TEST(invalid_names_are_changed_and_empty_elements_ignored)
{
    char *text = NULL, *yaml = NULL;
    size_t size;
    ck_assert_stein(lab__read_file("tests/mbs/arm.mbs", &text, &size, err));
    const char *to = in_folder("named.yaml");
    import(changed(text, "<point><pointname>post",
                   "<point><pointname>{aft}</pointname><sensor><kind/></sensor><extforce/></point>"
                   "<point><pointname>post"),
           to);
    ck_assert_ptr_nonnull(strstr(said, "external force \"\" on "));
    ck_assert_stein(lab__read_file(to, &yaml, &size, err));
    ck_assert_ptr_nonnull(strstr(yaml, "n_aft__z: {point: frame.n_aft_, read: z}"));
    ck_assert_ptr_nonnull(strstr(yaml, "n_aft__z: {force: frame.n_aft_, direction: [0, 0, 1]}"));
    ck_assert_msg(strstr(yaml, "n_aft_:") != NULL, "%.900s", yaml);
    free(yaml);
    import(changed(text, "<x>0.021</x>", "<x></x>"), to);
    ck_assert_stein(lab__read_file(to, &yaml, &size, err));
    ck_assert_ptr_null(strstr(yaml, "0.021"));
    free(yaml);
    free(text);
}
END_TEST

START_TEST(projects_that_are_not_in_order_are_refused_by_place)
{
    static const struct {
        const char *from, *to, *told;
    } bad[] = {
        {"<type>R3</type>", "<type>R4</type>", "changed.mbs:12:41: a joint of type \"R4\""},
        {"<type>R3</type>", "<type>R0</type>", "changed.mbs:12:41: a joint of type \"R0\""},
        {"<type>R3</type>", "<type>X3</type>", "changed.mbs:12:41: a joint of type \"X3\""},
        {"<type>R3</type>", "<type>R3x</type>", "changed.mbs:12:41: a joint of type \"R3x\""},
        {"<type>R3</type>", "", "<joint> without a <type>"},
        {"<mass>2.7</mass>", "<mass>2,7</mass>", "changed.mbs:16:7: <mass> is \"2,7\""},
        {"<mass>2.7</mass>", "<mass>nan</mass>", "<mass> is \"nan\""},
        {"<mass>2.7</mass>", "<mass>2.7</mass><mass>3</mass>", "<mass> twice"},
        {"<x>0.021</x>", "<x>0x1p3</x>", "<x> is \"0x1p3\""},
        {"<bodyname>struct</bodyname><pointname>left up", "<bodyname>strut</bodyname><pointname>x",
         "hangs on \"strut\", which is no body"},
        {"<bodyname>struct</bodyname><pointname>left up", "<bodyname>struct</bodyname><pointname>x",
         "hangs on \"struct.x\", which is no point"},
        {"<bodyname>base</bodyname><pointname>post", "<bodyname>hand</bodyname><pointname>origin",
         "hangs on itself"},
        {"<parent><bodyname>base</bodyname><pointname>post</pointname></parent>", "",
         "has no <parent>"},
        {"<bodyname>hand</bodyname>", "", "<body> without a <bodyname>"},
        {"</bodytree>", "", "mismatched tag"},
        {"<mbsDescR7>", "<!DOCTYPE x [<!ENTITY a \"b\">]><mbsDescR7>", "a document type"},
        {"<bodytree>",
         "<bodytree><a><a><a><a><a><a><a><a><a><a><a><a><a><a><a><a><a><a><a><a><a>"
         "<a><a><a><a><a><a><a><a><a><a><a>",
         "more than 32 elements"},
    };
    static const struct {
        const char *from, *to, *told;
    } cut[] = {
        {"<length>0.5</length>", "", "changed.mbs:50:5: <rod> without a <length>"},
        {"<length>0.5</length>", "<length>half</length>", "<length> is \"half\""},
        {"<pointname>p</pointname></endpoint1>", "<pointname>pp</pointname></endpoint1>",
         "<rod> \"pull\" ends at \"crank.pp\", which is no point"},
        {"<solid>", "<hinge/><solid>", "a cut <hinge>, expected <ball>, <rod> or <solid>"},
        {"<endpoint1><bodyname>plate</bodyname><pointname>m</pointname></endpoint1>", "",
         "<solid> \"glue\" without an <endpoint1>"},
    };
    char *text = NULL;
    size_t size;
    stein_err told = {STEIN_OK, ""};
    lab_imported done = {.bodies = -7};
    ck_assert_stein(lab__read_file("tests/mbs/rig.mbs", &text, &size, err));
    for (size_t i = 0; i < sizeof cut / sizeof *cut; i++) {
        const char *file = changed(text, cut[i].from, cut[i].to), *to = in_folder("never.yaml");
        ck_assert_int_eq(lab_import(file, to, LAB_INERTIA_ACCEPT, NULL, NULL, &done, &told),
                         STEIN_EPARSE);
        ck_assert_msg(strstr(told.msg, cut[i].told) != NULL, "%s: %s", cut[i].told, told.msg);
    }
    free(text);
    text = NULL;
    ck_assert_stein(lab__read_file("tests/mbs/arm.mbs", &text, &size, err));
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        const char *file = changed(text, bad[i].from, bad[i].to), *to = in_folder("never.yaml");
        ck_assert_int_eq(lab_import(file, to, LAB_INERTIA_REFUSE, NULL, NULL, &done, &told),
                         STEIN_EPARSE);
        ck_assert_msg(strstr(told.msg, bad[i].told) != NULL, "%s: %s", bad[i].told, told.msg);
        ck_assert_int_ne(access(to, F_OK), 0);
    }
    ck_assert_int_eq(done.bodies, -7);
    ck_assert_int_eq(
        lab_import("models/pendulum.yaml", "-", LAB_INERTIA_REFUSE, NULL, NULL, NULL, &told),
        STEIN_EPARSE);
    ck_assert_int_eq(
        lab_import(in_folder("none"), "-", LAB_INERTIA_REFUSE, NULL, NULL, NULL, &told), STEIN_EIO);

    // an inertia that no body has: written, and reported by the line of the written file
    const char *to = in_folder("heavy.yaml");
    ck_assert_int_eq(lab_import(changed(text, "<Ixx>0.017</Ixx>", "<Ixx>1.7</Ixx>"), to,
                                LAB_INERTIA_REFUSE, NULL, NULL, NULL, &told),
                     STEIN_EPARSE);
    ck_assert_msg(strstr(told.msg, "heavy.yaml:") && strstr(told.msg, "inertia"), "%s", told.msg);
    ck_assert_int_eq(access(to, F_OK), 0);
    free(text);
}
END_TEST

START_TEST(half_a_file_is_refused_wherever_it_ends)
{
    char *text = NULL;
    size_t size;
    stein_err told;
    ck_assert_stein(lab__read_file("tests/mbs/arm.mbs", &text, &size, err));
    size_t whole = (size_t)(strstr(text, "</mbsDescR7>") - text) + 12;
    for (size_t n = 0; n < whole; n += 23) {
        const char *file = in_folder("half.mbs");
        FILE *f = fopen(file, "wb");
        ck_assert_uint_eq(fwrite(text, 1, n, f), n);
        fclose(f);
        ck_assert_int_eq(
            lab_import(file, in_folder("half.yaml"), LAB_INERTIA_REFUSE, NULL, NULL, NULL, &told),
            STEIN_EPARSE);
    }
    ck_assert_int_ne(access(in_folder("half.yaml"), F_OK), 0);
    free(text);
}
END_TEST

Suite *import_suite(void)
{
    Suite *s = suite_create("import");
    TCase *t = tcase_create("import");
    tcase_set_timeout(t, 120);
    tcase_add_unchecked_fixture(t, cache_in_build, NULL);
    tcase_add_checked_fixture(t, make_folder, remove_folder);
    tcase_add_test(t, a_planar_project_has_the_equations_of_the_file_written_by_hand);
    tcase_add_test(t, a_spatial_project_with_several_joints_a_body_does_so_too);
    tcase_add_test(t, cuts_are_loops_and_the_motion_is_that_of_the_file_written_by_hand);
    tcase_add_test(t, an_inertia_that_no_body_has_is_refused_taken_or_balanced_as_asked);
    tcase_add_test(t, invalid_names_are_changed_and_empty_elements_ignored);
    tcase_add_test(t, projects_that_are_not_in_order_are_refused_by_place);
    tcase_add_test(t, half_a_file_is_refused_wherever_it_ends);
    suite_add_tcase(s, t);
    return s;
}
