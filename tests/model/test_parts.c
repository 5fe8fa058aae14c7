/* SPDX-License-Identifier: MIT
 * test_parts.c - bodies cut in two (part_of): as long as the piece does not move against the rest,
 * both together are the body that the file states. Bodies without a joint (fixed).
 */
#include <math.h>

#include "lab_support.h"
#include "mechanism_cases.h"

Suite *parts_suite(void);

/* a body that tumbles in space, all elements of its tensor stated */
static const char whole[] = "mechanism: tumbler\n"
                            "bodies:\n"
                            "  base: {joint: R z, mass: 1.31 kg, centre: [0.11 m, 0.07 m, 0],\n"
                            "    inertia: {xx: 0.21, yy: 0.27, zz: 0.33}}\n"
                            "  link:\n"
                            "    parent: base\n"
                            "    joint: R x\n"
                            "    at: [0.17 m, 0.03 m, 0.23 m]\n"
                            "    mass: 0.93 kg +- 1 %%\n"
                            "    centre: [0.31 m, -0.05 m, 0.13 m]\n"
                            "    inertia: {xx: 0.041, yy: 0.067, zz: 0.059, xy: 3e-3, xz: -2e-3, "
                            "yz: 5e-3}\n"
                            "%s"
                            "  tool: {parent: %s, joint: R y, at: [0.47 m, 0.09 m, 0.05 m], mass: "
                            "0.19 kg,\n"
                            "    centre: [0, 0.07 m, 0.02 m], inertia: {xx: 1e-3, yy: 2e-3, zz: "
                            "1.7e-3}}\n";

static const char piece[] = "  tail:\n"
                            "    part_of: link\n"
                            "    joint: R z\n"
                            "    at: [0.21 m, 0.02 m, 0.07 m]\n"
                            "    mass: 0.37 * link.mass\n"
                            "    centre: [link.centre.x + 0.13 m, link.centre.y, 0.11 m]\n"
                            "    inertia: {xx: 0.007, yy: 0.011, zz: 0.009, xy: 4e-4}\n";

/* M and c at the same motion with the piece at rest; rows and columns without the piece */
static void look(const char *text, const char *const *set, int nset, double M[3][3], double c[3],
                 double energy[2])
{
    static const double q[] = {0.37, -0.53, 1.13}, qd[] = {2.3, -1.7, 3.1};
    double full[16], bias[4], at[4] = {0.0}, speed[4] = {0.0};
    lab_model *model = open_text(text, set, nset);
    const stein_model *m = lab_equations(model);
    stein_sim *sim = NULL;
    int index[3], n = 0;
    for (int i = 0; i < m->nq; i++) {
        if (strcmp(m->bodies[i].name, "tail") != 0) {
            at[i] = q[n], speed[i] = qd[n], index[n++] = i;
        }
    }
    ck_assert_int_eq(n, 3);
    ck_assert_stein(lab_sim(model, NULL, &sim, err));
    stein_mass_bias(sim, at, speed, NULL, NULL, full, bias);
    stein_energy(sim, at, speed, &energy[0], &energy[1]);
    for (int i = 0; i < 3; i++) {
        c[i] = bias[index[i]];
        for (int k = 0; k < 3; k++) {
            M[i][k] = full[index[i] * m->nq + index[k]];
        }
    }
    stein_sim_destroy(sim);
    lab_close(model);
}

static void compare(const char *const *set, int nset)
{
    char one[2000], two[2000];
    double M[2][3][3], c[2][3], e[2][2];
    snprintf(one, sizeof one, whole, "", "link");
    snprintf(two, sizeof two, whole, piece, "tail");
    make_folder();
    look(one, set, nset, M[0], c[0], e[0]);
    look(two, set, nset, M[1], c[1], e[1]);
    remove_folder();
    for (int i = 0; i < 3; i++) {
        ck_assert_close(c[1][i], c[0][i], 1e-12, 1e-12);
        ck_assert_close(e[1][i % 2], e[0][i % 2], 1e-12, 1e-12);
        for (int k = 0; k < 3; k++) {
            ck_assert_close(M[1][i][k], M[0][i][k], 1e-12, 1e-14);
        }
    }
}

START_TEST(both_pieces_together_are_the_whole)
{
    compare(NULL, 0);
}
END_TEST

START_TEST(the_rest_follows_the_whole)
{
    static const char *const set[] = {"link.mass=1.07 kg", "link.centre.x=0.27 m",
                                      "link.inertia.yy=0.071", "tool.at.z=0.03 m"};
    compare(set, 4);
}
END_TEST

START_TEST(the_numbers_of_the_whole_stay_parameters)
{
    char text[2000];
    snprintf(text, sizeof text, whole, piece, "tail");
    mechanism *m = NULL;
    ck_assert_stein(mech_read_text(&m, "x", text, strlen(text), NULL, 0, NULL, NULL, err));
    int mass = mech_find_param(m, "link.mass", NULL), at = mech_find_param(m, "tool.at.x", NULL);
    ck_assert_int_ge(mass, 0);
    ck_assert_close(m->params[mass].value, 0.93, 0.0, 0.0);
    ck_assert_close(m->params[mass].tolerance, 0.0093, 1e-15, 0.0);
    ck_assert_close(m->params[at].value, 0.47, 0.0, 0.0);
    ck_assert_close(m->bodies[1].mass.value, 0.63 * 0.93, 1e-15, 0.0);
    ck_assert_int_eq(m->bodies[2].part, 1);
    ck_assert_close(m->bodies[2].centre[0].value, 0.31 + 0.13 - 0.21, 1e-14, 0.0);
    ck_assert_close(m->bodies[3].at[0].value, 0.47 - 0.21, 1e-15, 0.0);
    mech_free(m);
}
END_TEST

/* bodies in space, and bodies in the plane of a contact */
static const struct {
    const char *text, *point[4];
} moved[] = {
    {"mechanism: points\n"
     "bodies:\n"
     "  base: {joint: R z, mass: 1 kg, inertia: {zz: 0.3}, points: {c: [0.3 m, 0.04 m, 0.1 m]}}\n"
     "  tool: {parent: base, joint: R x, at: [0.17 m, 0.03 m, 0.23 m], mass: 1 kg, inertia: {xx: "
     "0.1},\n"
     "    points: {a: [0.11 m, 0.2 m, -0.05 m], b: [-0.3 m, 0.07 m, 0.41 m]}}\n"
     "  slide: {joint: T y, mass: 1 kg, points: {d: [0.05 m, 0, -0.2 m]}}\n",
     {"tool.a", "tool.b", "base.c", "slide.d"}},
    {"mechanism: plane\n"
     "bodies:\n"
     "  base: {joint: R y, mass: 1 kg, inertia: {yy: 0.3}, points: {c: [0.3 m, 0.04 m, 0.1 m]}}\n"
     "  tool: {parent: base, joint: R -y, at: [0.17 m, 0, 0.23 m], mass: 1 kg, inertia: {yy: "
     "0.1},\n"
     "    points: {a: [0.11 m, 0.2 m, -0.05 m], b: [-0.3 m, 0.07 m, 0.41 m]}}\n"
     "  slide: {joint: T z, mass: 1 kg, points: {d: [0.05 m, 0, -0.2 m]}}\n"
     "contacts:\n"
     "  floor: {between: [{point: tool.a}, {line: {on: frame, at: [0, 0, -9 m], facing: 90 deg}}], "
     "normal: {c: 1e4}}\n",
     {"tool.a", "tool.b", "base.c", "slide.d"}}};

/* each speed that is read is the slope of what is read as the place */
START_TEST(speeds_of_points_are_the_slopes_of_their_places)
{
    char all[4000];
    int at = snprintf(all, sizeof all, "%soutputs:\n", moved[_i].text);
    for (int i = 0; i < 12; i++) {
        const char *point = moved[_i].point[i / 3];
        char axis = "xyz"[i % 3];
        at += snprintf(all + at, sizeof all - (size_t)at,
                       "  p%d: {point: %s, read: %c}\n  v%d: {point: %s, read: v%c}\n", i, point,
                       axis, i, point, axis);
    }
    make_folder();
    lab_model *model = open_text(all, NULL, 0);
    stein_sim *sim = NULL;
    ck_assert_stein(lab_sim(model, NULL, &sim, err));
    const double q[] = {0.37, -0.53, 1.13}, qd[] = {2.3, -1.7, 3.1}, h = 1e-5;
    for (int i = 0; i < 12; i++) {
        char name[16];
        double place[2], speed, there[3];
        snprintf(name, sizeof name, "p%d", i);
        for (int side = 0; side < 2; side++) {
            for (int j = 0; j < 3; j++) {
                there[j] = q[j] + (side ? h : -h) * qd[j];
            }
            ck_assert_stein(stein_set_state(sim, 0.0, there, qd, err));
            ck_assert_stein(stein_read_name(sim, name, &place[side], err));
        }
        ck_assert_stein(stein_set_state(sim, 0.0, q, qd, err));
        name[0] = 'v';
        ck_assert_stein(stein_read_name(sim, name, &speed, err));
        ck_assert_close(speed, (place[1] - place[0]) / (2.0 * h), 1e-8, 1e-9);
    }
    stein_sim_destroy(sim);
    lab_close(model);
    remove_folder();
}
END_TEST

static double length_at(stein_sim *sim, const double *q, const double *qd)
{
    double sum = 0.0;
    ck_assert_stein(stein_set_state(sim, 0.0, q, qd, err));
    for (const char *name = "xyz"; *name != '\0'; name++) {
        double a, b;
        ck_assert_stein(stein_read_name(sim, (char[]){'a', *name, '\0'}, &a, err));
        ck_assert_stein(stein_read_name(sim, (char[]){'b', *name, '\0'}, &b, err));
        sum += (b - a) * (b - a);
    }
    return sqrt(sum);
}

/* M (qdd with a link - qdd without) = -(k (L - L0) + d L') dL/dq, in space */
START_TEST(a_link_pulls_along_the_slope_of_its_length)
{
    char all[3000];
    snprintf(
        all, sizeof all,
        "%slinks:\n  tie: {from: tool.a, to: slide.d, k: 37 N/m, length: 0.4 m, damping: 1.7 N "
        "s/m}\noutputs: {ax: {point: tool.a, read: x}, ay: {point: tool.a, read: y}, az: {point: "
        "tool.a, read: z}, bx: {point: slide.d, read: x}, by: {point: slide.d, read: y}, bz: "
        "{point: slide.d, read: z}}\n",
        moved[0].text);
    make_folder();
    lab_model *model = open_text(all, NULL, 0);
    stein_sim *sim = NULL;
    ck_assert_stein(lab_sim(model, NULL, &sim, err));
    const double q[] = {0.37, -0.53, 1.13}, qd[] = {2.3, -1.7, 3.1}, h = 1e-5;
    double M[9], c[3], with[3], without[3], slope[3], rate = 0.0, length = length_at(sim, q, qd);
    for (int j = 0; j < 3; j++) {
        double up[] = {q[0], q[1], q[2]}, down[] = {q[0], q[1], q[2]};
        up[j] += h;
        down[j] -= h;
        slope[j] = (length_at(sim, up, qd) - length_at(sim, down, qd)) / (2.0 * h);
        rate += slope[j] * qd[j];
    }
    stein_mass_bias(sim, q, qd, NULL, NULL, M, c);
    ck_assert_stein(stein_acceleration(sim, 0.0, q, qd, with, err));
    ck_assert_stein(stein_set(sim, "tie.k", 0.0, err));
    ck_assert_stein(stein_set(sim, "tie.damping", 0.0, err));
    ck_assert_stein(stein_acceleration(sim, 0.0, q, qd, without, err));
    double pull = 37.0 * (length - 0.4) + 1.7 * rate;
    for (int i = 0; i < 3; i++) {
        double Q = 0.0;
        for (int j = 0; j < 3; j++) {
            Q += M[3 * i + j] * (with[j] - without[j]);
        }
        ck_assert_close(Q, -pull * slope[i], 1e-7, 1e-8);
    }
    stein_sim_destroy(sim);
    lab_close(model);
    remove_folder();
}
END_TEST

START_TEST(impossible_parts_are_refused)
{
    static const refusal r[] = {
        {"    joint: R -y\n    at: key.kapsel\n    mass: 3.31 g",
         "    part_of: key\n    joint: R -y\n    at: key.kapsel\n    mass: 3.31 g", "part_of",
         "parent and part_of exclude each other"},
        {"  pawl:\n    joint: R -y\n", "  pawl:\n    part_of: frame\n    joint: R -y\n",
         "frame\n    joint", "the frame has no parts"},
        {"    parent: key\n", "    part_of: ky\n", "ky\n    joint",
         "there is no body \"ky\", did you mean \"key\"?"},
    };
    refuse_all(r, 3);
    char *text = changed("    parent: key\n", "    part_of: key\n");
    const char *at = strstr(text, "3.31 g");
    memcpy((char *)at, "91.2 g", 6);
    refuse_text(text, strlen(text), NULL, 0, "part_of: key",
                "the mass of key is not larger than the mass of its part hammer");
    free(text);
    text =
        changed("  pawl:\n    joint: R -y\n    at: [-123 mm, 0, -33.1 mm]\n",
                "  pawl:\n    part_of: hammer\n    joint: R -y\n    at: [-123 mm, 0, -33.1 mm]\n");
    char *parent = strstr(text, "parent: key"), *rest = malloc(strlen(text) + 10);
    sprintf(rest, "%.*spart_of%s", (int)(parent - text), text, parent + strlen("parent"));
    refuse_text(rest, strlen(rest), NULL, 0, "hammer\n    joint: R -y\n    at: [-123",
                "hammer is a part itself, expected a whole body");
    free(rest);
    free(text);
}
END_TEST

/* a body that hangs on the link: with a joint that rests, or without one */
static const char carried[] = "  tail:\n"
                              "    parent: link\n"
                              "    joint: %s\n"
                              "    at: [0.21 m, 0.02 m, 0.07 m]\n"
                              "    mass: 0.37 * link.mass\n"
                              "    centre: [0.13 m, link.centre.y, 0.11 m]\n"
                              "    inertia: {xx: 0.007, yy: 0.011, zz: 0.009, xy: 4e-4}\n";

START_TEST(a_fixed_body_weighs_as_one_whose_joint_rests)
{
    char piece_text[600], text[2][2600];
    double M[2][3][3], c[2][3], e[2][2];
    make_folder();
    for (int k = 0; k < 2; k++) {
        snprintf(piece_text, sizeof piece_text, carried, k == 0 ? "R z" : "fixed");
        snprintf(text[k], sizeof text[k], whole, piece_text, "tail");
        look(text[k], NULL, 0, M[k], c[k], e[k]);
    }
    assert_near("M", &M[1][0][0], &M[0][0][0], 9, 1e-14);
    assert_near("c", c[1], c[0], 3, 1e-14);
    assert_near("energy", &e[1][0], &e[0][0], 1, 1e-14);
    remove_folder();
}
END_TEST

/* two fixed bodies behind each other, one on the frame, a joint and a surface on them */
#define ON_FIXED(bodies, floor)                                                                    \
    "mechanism: crane\n"                                                                           \
    "bodies:\n" bodies                                                                             \
    "outputs: {x: {point: bob.e, read: x}, z: {point: bob.e, read: z}, g: {contact: floor, read: " \
    "gap}}\n"                                                                                      \
    "contacts:\n"                                                                                  \
    "  floor: {between: [{point: bob.e}, {line: {on: " floor ", facing: 90 deg}}], normal: {c: "   \
    "1e3 N/m}}\n"                                                                                  \
    "simulation: {dt: 1 ms, until: 2 s}\n"

START_TEST(children_of_fixed_bodies_move_as_children_of_the_moving_body)
{
    static const char *const file[] = {
        ON_FIXED(
            "  base: {joint: fixed, at: [10 mm, 0, 20 mm], mass: 3 kg, points: {pin: [5 mm, 0, "
            "0]}}\n"
            "  arm: {parent: base, at: base.pin, joint: R -y, mass: 1 kg, centre: [0.05, 0, "
            "0], inertia: {yy: 5e-4}, points: {p: [0.1, 0, 0]}, initial: {position: 60 deg}}\n"
            "  plate: {parent: arm, at: arm.p, joint: fixed, points: {o: [20 mm, 0, 0]}}\n"
            "  tip: {parent: plate, at: plate.o, joint: fixed, mass: 0.6 kg, inertia: {yy: "
            "1e-3}, points: {q: [0, 0, 3 mm]}}\n"
            "  bob: {parent: tip, at: tip.q, joint: R -y, mass: 0.1 kg, centre: [0.03, 0, "
            "0], points: {e: [0.05, 0, 0]}}\n",
            "base, at: [0, 0, -0.1]"),
        ON_FIXED("  arm: {at: [15 mm, 0, 20 mm], joint: R -y, mass: 1.6 kg, centre: [0.07625, 0, "
                 "0], inertia: {yy: 0.0033375}, initial: {position: 60 deg}}\n"
                 "  bob: {parent: arm, at: [0.12, 0, 3 mm], joint: R -y, mass: 0.1 kg, centre: "
                 "[0.03, 0, 0], points: {e: [0.05, 0, 0]}}\n",
                 "frame, at: [0, 0, -0.08]")};
    static const char *const channel[] = {"x", "z", "g"};
    double y[2][3];
    make_folder();
    for (int k = 0; k < 2; k++) {
        lab_model *model = open_text(file[k], NULL, 0);
        stein_sim *sim = NULL;
        ck_assert_int_eq(lab_equations(model)->nq, 2);
        ck_assert_stein(lab_sim(model, NULL, &sim, err));
        ck_assert_stein(stein_run(sim, 0.3, err));
        for (int i = 0; i < 3; i++) {
            ck_assert_stein(stein_read_name(sim, channel[i], &y[k][i], err));
        }
        stein_sim_destroy(sim);
        lab_close(model);
    }
    assert_near("end", y[1], y[0], 3, 1e-10);
    remove_folder();
}
END_TEST

START_TEST(keys_that_a_fixed_body_lacks_are_refused)
{
    static const struct {
        const char *from, *to, *words;
    } wrong[] = {
        {"    joint: R -y\n    at: [-123", "    joint: fixed\n    at: [-123",
         "unknown key \"spring\""},
        {"motion: key", "motion: stand", "stand is fixed"},
        {"{point: key.front, read: vz", "{joint: stand, read: speed", "stand is fixed"},
        {"inputs:\n", "couplings: {c: {joint: key, follows: stand}}\ninputs:\n", "stand is fixed"},
        {"    parent: key\n", "    part_of: stand\n", "stand is fixed, it has no parts"},
        {"R -y", "fixd", "or fixed"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        mechanism *m = NULL;
        stein_err why = {STEIN_OK, ""};
        char *text = changed(wrong[i].from, wrong[i].to), all[4000];
        const char *at = strstr(text, "bodies:\n") + strlen("bodies:\n");
        snprintf(all, sizeof all, "%.*s  stand: {joint: fixed, mass: 1 kg}\n%s", (int)(at - text),
                 text, at);
        stein_status status =
            mech_read_text(&m, "demo.yaml", all, strlen(all), NULL, 0, NULL, NULL, &why);
        ck_assert_msg(status == STEIN_EPARSE, "%s", wrong[i].to);
        ck_assert_msg(strstr(why.msg, wrong[i].words) != NULL, "%s: %s", wrong[i].to, why.msg);
        free(text);
    }
}
END_TEST

Suite *parts_suite(void)
{
    Suite *suite = suite_create("parts");
    TCase *tc = tcase_create("parts");
    tcase_set_timeout(tc, 60);
    tcase_add_test(tc, both_pieces_together_are_the_whole);
    tcase_add_test(tc, the_rest_follows_the_whole);
    tcase_add_test(tc, the_numbers_of_the_whole_stay_parameters);
    tcase_add_loop_test(tc, speeds_of_points_are_the_slopes_of_their_places, 0, 2);
    tcase_add_test(tc, a_link_pulls_along_the_slope_of_its_length);
    tcase_add_test(tc, impossible_parts_are_refused);
    tcase_add_test(tc, a_fixed_body_weighs_as_one_whose_joint_rests);
    tcase_add_test(tc, children_of_fixed_bodies_move_as_children_of_the_moving_body);
    tcase_add_test(tc, keys_that_a_fixed_body_lacks_are_refused);
    suite_add_tcase(suite, tc);
    return suite;
}
