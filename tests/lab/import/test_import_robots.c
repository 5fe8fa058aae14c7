/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_import_robots.c - robots of ROS (URDF) and models of MuJoCo (MJCF) have the accelerations of
 * mechanism files written by hand; those that are not in order are refused by place.
 */
#include "import_support.h"

enum { STATES = 20 };

/* tests/mbs/arm.urdf and arm.xml as one would write it, in the axes of the base. %s: place of tip
 * in the axes of the link "tool", which is turned by 0.5 rad against "slide" */
static const char robot_by_hand[] =
    "mechanism: by_hand\n"
    "bodies:\n"
    "  upper: {joint: R -y, at: [0.1, 0.2, 0.3], mass: 1.3, centre: [0.05, -0.02, 0.01],\n"
    "          inertia: {xx: 0.002, yy: 0.0025, zz: 0.001, xz: -0.0001}, limits: [-2, 2.5]}\n"
    "  slide: {parent: upper, joint: T z, at: [0.3, -0.1, 0], mass: 0.4, centre: [0, -0.03, 0],\n"
    "          inertia: {xx: 1e-4, yy: 1.4e-4, zz: 1.2e-4}, limits: [-0.1, 0.1], damping: 3,\n"
    "          coulomb: {T: 0.2, w: 0.05}}\n"
    "  finger: {parent: upper, joint: R y, at: [0.3, 0, 0], mass: 0.2, centre: [0.04, 0, 0],\n"
    "           inertia: {xx: 2e-4, yy: 4e-4, zz: 3e-4}}\n"
    "  plate: {parent: finger, joint: fixed, at: [0.08, -0.02, 0], mass: 0.05,\n"
    "          centre: [0, 0, 0.01], inertia: {xx: 3e-5, yy: 5e-5, zz: 4e-5}}\n"
    "  tip: {parent: slide, joint: R -y, mass: 0.1, %s}\n"
    "couplings: {c: {joint: finger, follows: upper, ratio: -2, offset: 0.1}}\n";

static char *tip_by_hand(void)
{
    double c = cos(0.5), s = sin(0.5);
    char tip[300];
    snprintf(tip, sizeof tip,
             "at: [%.17g, 0, %.17g], centre: [%.17g, 0, %.17g],\n"
             "        inertia: {xx: %.17g, yy: 2.5e-5, zz: %.17g, xz: %.17g}",
             0.01 * c, 0.1 + 0.01 * s, 0.02 * c, 0.02 * s, 1e-5 * c * c + 2e-5 * s * s,
             1e-5 * s * s + 2e-5 * c * c, -1e-5 * c * s);
    return lab__text(robot_by_hand, tip);
}

/* what is imported to `file` has the accelerations of the text written by hand at random states */
static void same_accelerations(const char *file)
{
    static const char *const name[] = {"upper", "slide", "finger", "tip"};
    lab_options options = lab_options_default();
    lab_model *model[2] = {NULL, NULL};
    stein_sim *sim[2];
    char *by_hand = tip_by_hand();
    ck_assert_stein(lab_open(&model[0], file, &options, err));
    ck_assert_stein(
        lab__open_text(&model[1], "by_hand.yaml", by_hand, strlen(by_hand), &options, err));
    free(by_hand);
    unsigned long long seed = 42;
    int at[4];
    for (int k = 0; k < 2; k++) {
        ck_assert_stein(lab_sim(model[k], NULL, &sim[k], err));
        ck_assert_int_eq(stein_freedom(sim[k]), 3);
        ck_assert_int_eq(lab_equations(model[k])->nq, 4);
    }
    for (int i = 0; i < 4; i++) {
        at[i] = stein_find_body(lab_equations(model[0]), name[i]);
        ck_assert_int_ge(at[i], 0);
    }
    for (int s = 0; s < STATES; s++) { // beyond the limits as well
        double q[2][4], qd[2][4], qdd[2][4];
        for (int i = 0; i < 4; i++) {
            q[1][i] = (i == 1 ? 0.15 : 2.9) * noise(&seed);
            qd[1][i] = 1.7 * noise(&seed);
        }
        q[1][2] = -2.0 * q[1][0] + 0.1;
        qd[1][2] = -2.0 * qd[1][0];
        for (int i = 0; i < 4; i++) {
            q[0][at[i]] = q[1][i];
            qd[0][at[i]] = qd[1][i];
        }
        for (int k = 0; k < 2; k++) {
            ck_assert_stein(stein_acceleration(sim[k], 0.0, q[k], qd[k], qdd[k], err));
        }
        for (int i = 0; i < 4; i++) {
            ck_assert_close(qdd[0][at[i]], qdd[1][i], 1e-12, 1e-12);
        }
    }
    for (int k = 0; k < 2; k++) {
        stein_sim_destroy(sim[k]);
        lab_close(model[k]);
    }
}

START_TEST(a_robot_of_ros_has_the_accelerations_of_the_file_written_by_hand)
{
    lab_imported done = import("tests/mbs/arm.urdf", in_folder("arm.yaml"));
    ck_assert_str_eq(done.name, "arm_1");
    ck_assert(done.bodies == 6 && done.joints == 4 && done.points == 2 && done.loops == 1);
    static const char *const told[] = {"an angle of lift (line 20) is 1.5708 rad: taken as 90 deg",
                                       "limits of effort and velocity of joint lift",
                                       "1 <collision> of link upper",
                                       "link plate is fixed: part of finger",
                                       "friction of joint push is smooth below 0.05 m/s",
                                       "<transmission> of the robot"};
    text_has(said, told, sizeof told / sizeof *told);
    same_accelerations(in_folder("arm.yaml"));
}
END_TEST

START_TEST(a_model_of_mujoco_has_the_accelerations_of_the_file_written_by_hand)
{
    lab_imported done = import("tests/mbs/arm.xml", in_folder("arm.yaml"));
    ck_assert_str_eq(done.name, "arm_1");
    ck_assert(done.bodies == 6 && done.joints == 4 && done.points == 2 && done.loops == 1);
    static const char *const told[] = {"contacts of 1 <geom> of upper",
                                       "body plate is fixed: part of finger",
                                       "<site> of tip",
                                       "friction of joint push is smooth below 0.05 m/s",
                                       "actuator <position> \"twist\"",
                                       "<sensor> of the model"};
    text_has(said, told, sizeof told / sizeof *told);
    same_accelerations(in_folder("arm.yaml"));
}
END_TEST

static const char askew[] =
    "<robot name='askew'><link name='world'/>"
    "<link name='bar'><inertial><origin xyz='0.1 -0.2 0.3'/><mass value='0.7'/>"
    "<inertia ixx='0.01' iyy='0.02' izz='0.025' ixy='0.001' ixz='-0.002' iyz='0.003'/></inertial>"
    "</link>"
    "<joint name='hinge' type='continuous'><parent link='world'/><child link='bar'/>"
    "<origin xyz='1 2 3' rpy='0.3 -0.4 0.5'/><axis xyz='1 2 %s'/></joint></robot>";

static const char *robot_file(const char *format, const char *word)
{
    const char *path = in_folder("robot.urdf");
    FILE *f = fopen(path, "wb");
    ck_assert_ptr_nonnull(f);
    ck_assert(fprintf(f, format, word) > 0 && fclose(f) == 0);
    return path;
}

/* Rz(0.5) Ry(-0.4) Rx(0.3) x, each turn by itself */
static void turned(const double x[3], double y[3])
{
    static const double angle[] = {0.3, -0.4, 0.5};
    double v[3] = {x[0], x[1], x[2]};
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        double c = cos(angle[i]), s = sin(angle[i]), a = v[j], b = v[k];
        v[j] = c * a - s * b;
        v[k] = s * a + c * b;
    }
    memcpy(y, v, sizeof v);
}

/* qdd = a . (r x m g) / (a . (I a) + m |a x r|^2), whatever the axis */
START_TEST(an_axis_that_is_askew_is_that_of_the_robot)
{
    static const double a[3] = {1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0}, r[3] = {0.1, -0.2, 0.3};
    static const double I[9] = {0.01, 0.001, -0.002, 0.001, 0.02, 0.003, -0.002, 0.003, 0.025};
    static const double mass = 0.7, gravity = -9.81;
    lab_options options = lab_options_default();
    lab_model *model = NULL;
    stein_sim *sim = NULL;
    double axis[3], centre[3], inertia = 0.0;
    import(robot_file(askew, "2"), in_folder("askew.yaml"));
    ck_assert_ptr_nonnull(strstr(said, "joint hinge is askew to x, y and z"));
    turned(a, axis);
    turned(r, centre);
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        double across = a[j] * r[k] - a[k] * r[j];
        inertia += mass * across * across;
        for (int e = 0; e < 3; e++) {
            inertia += a[i] * I[3 * i + e] * a[e];
        }
    }
    double torque = mass * gravity * (axis[0] * centre[1] - axis[1] * centre[0]);
    ck_assert_stein(lab_open(&model, in_folder("askew.yaml"), &options, err));
    ck_assert_stein(lab_sim(model, NULL, &sim, err));
    int bar = stein_find_body(lab_equations(model), "bar");
    ck_assert_close(stein_qdd(sim)[bar], torque / inertia, 1e-12, 1e-12);
    stein_sim_destroy(sim);
    lab_close(model);
}
END_TEST

START_TEST(robots_that_are_not_in_order_are_refused_by_place)
{
    static const struct {
        const char *from, *to, *told;
    } bad[] = {
        {"type=\"prismatic\"", "type=\"planar\"", "a joint of type \"planar\", expected revolute"},
        {"<axis xyz=\"0 2 0\"/>", "<axis xyz=\"0 0 0\"/>",
         "axis of joint \"push\" has no direction"},
        {"<axis xyz=\"0 2 0\"/>", "<axis xyz=\"0 2\"/>", ":23:30: xyz is \"0 2\", expected three"},
        {"<axis xyz=\"0 2 0\"/>", "<axis xyz=\"0 2 0 1\"/>", "expected three numbers"},
        {"<axis xyz=\"0 2 0\"/>", "<axis xyz=\"0 two 0\"/>", "xyz is \"two\", expected a number"},
        {"mimic joint=\"lift\"", "mimic joint=\"mount\"",
         "<mimic> of joint \"mount\", which is no"},
        {"<parent link=\"slide\"/>", "<parent link=\"tip\"/>", "link \"tool\" hangs on itself"},
        {"<parent link=\"slide\"/>", "<parent link=\"rail\"/>",
         "joint \"mount\" is at \"rail\", which is no link"},
        {"<parent link=\"slide\"/>", "", "<joint> \"mount\" without a <parent>"},
        {"<child link=\"tip\"/>", "<child link=\"tool\"/>", "link \"tool\" hangs on two joints"},
        {"<link name=\"tool\"/>", "<link name=\"tool\"/><link name=\"tool\"/>", "a second link"},
        {"<link name=\"tool\"/>", "<link name=\"tool\"/><link name=\"loose\"/>",
         "2 links without a joint"},
        {"<link name=\"tool\"/>", "<link/>", "<link> without name="},
        {"<mass value=\"0.4\"/>", "<mass value=\"0,4\"/>", "value is \"0,4\", expected a number"},
    };
    char *text = NULL;
    size_t size;
    stein_err told = {STEIN_OK, ""};
    ck_assert_stein(lab__read_file("tests/mbs/arm.urdf", &text, &size, err));
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        const char *file = changed(text, bad[i].from, bad[i].to), *to = in_folder("never.yaml");
        ck_assert_int_eq(lab_import(file, to, LAB_INERTIA_REFUSE, NULL, NULL, NULL, &told),
                         STEIN_EPARSE);
        ck_assert_msg(strstr(told.msg, bad[i].told) != NULL, "%s: %s", bad[i].told, told.msg);
        ck_assert_int_ne(access(to, F_OK), 0);
    }
    free(text);
}
END_TEST

/* ---- MJCF ---- */

/* The same rotation in four ways, of a body with an oblique hinge: +60 deg about z, +30 about x. */
START_TEST(orientations_are_the_same_however_they_are_written)
{
    static const char text[] =
        "<mujoco><compiler eulerseq='zxy'/><worldbody><body %s><joint axis='1 2 3'/>"
        "<inertial pos='0.1 0.2 -0.1' mass='0.7' diaginertia='0.01 0.02 0.025'/></body>"
        "</worldbody></mujoco>";
    static const char *const way[] = {
        "euler='60 30 0'",
        "quat='0.836516303737808 0.224143868042013 0.12940952255126 0.482962913144534'",
        "axisangle='0.224143868042013 0.12940952255126 0.482962913144534 66.45188440657513'",
        "xyaxes='0.5 0.866025403784439 0 -0.75 0.433012701892219 0.5'"};
    double qdd[4];
    for (int k = 0; k < 4; k++) {
        lab_options options = lab_options_default();
        lab_model *model = NULL;
        stein_sim *sim = NULL;
        import(robot_file(text, way[k]), in_folder("way.yaml"));
        ck_assert_stein(lab_open(&model, in_folder("way.yaml"), &options, err));
        ck_assert_stein(lab_sim(model, NULL, &sim, err));
        qdd[k] = stein_qdd(sim)[stein_find_body(lab_equations(model), "body")];
        ck_assert_close(qdd[k], qdd[0], 1e-9, 0.0);
        stein_sim_destroy(sim);
        lab_close(model);
    }
    ck_assert(fabs(qdd[0]) > 1.0);
}
END_TEST

/* of a hinge, of a slide by its class, and of a ball, where it is reported */
static const char geared[] =
    "<mujoco><default><default class='screw'><joint type='slide' armature='1.6'/></default>"
    "</default><worldbody>"
    "<body name='arm'><joint name='turn' axis='0 -1 0' armature='0.02' range='-60 60'/>"
    "<inertial pos='0.1 0 0' mass='0.7' diaginertia='0.01 0.02 0.025'/>"
    "<body name='cart' pos='0.3 0 0' childclass='screw'><joint name='push' axis='1 0 0'/>"
    "<inertial pos='0 0 0' mass='%s' diaginertia='0.01 0.02 0.025'/></body></body>"
    "<body name='bob' pos='0 1 0'><joint type='ball' armature='0.1'/>"
    "<inertial pos='0 0 -0.1' mass='1' diaginertia='0.01 0.02 0.025'/></body>"
    "</worldbody></mujoco>";

START_TEST(an_armature_is_that_of_its_joint)
{
    lab_options options = lab_options_default();
    lab_model *model = NULL;
    stein_sim *sim = NULL;
    import(robot_file(geared, "2"), in_folder("geared.yaml"));
    ck_assert_ptr_nonnull(strstr(said, "armature of joint bob, which has several axes"));
    ck_assert_ptr_null(strstr(said, "armature of joint turn"));
    ck_assert_stein(lab_open(&model, in_folder("geared.yaml"), &options, err));
    ck_assert_stein(lab_sim(model, NULL, &sim, err));
    const stein_model *m = lab_equations(model);
    int turn = stein_find_body(m, "arm"), push = stein_find_body(m, "cart");
    // at rest and level: 0.02 + 0.02 + 0.02 + 0.7 0.1^2 + 2 0.3^2 on the hinge
    double inertia = 0.06 + 0.7 * 0.01 + 2.0 * 0.09, torque = -9.81 * (0.7 * 0.1 + 2.0 * 0.3);
    ck_assert_close(stein_qdd(sim)[turn], torque / inertia, 1e-12, 0.0);
    ck_assert_double_eq_tol(stein_qdd(sim)[push], 0.0, 1e-12);
    // by 90 deg: the cart falls with 2 kg against 3.6 kg
    double *q = calloc((size_t)m->nq, sizeof *q), *qd = calloc((size_t)m->nq, sizeof *qd);
    ck_assert(q != NULL && qd != NULL);
    q[turn] = -0.5 * 3.14159265358979324 * (m->bodies[turn].sign < 0 ? 1.0 : -1.0);
    ck_assert_stein(stein_set_state(sim, 0.0, q, qd, err));
    ck_assert_close(stein_qdd(sim)[push], 9.81 * 2.0 / 3.6, 1e-6, 0.0);
    free(q);
    free(qd);
    stein_sim_destroy(sim);
    lab_close(model);
}
END_TEST

static const char swing[] =
    "<mujoco><option gravity='9.81 0 0'/><worldbody><body><joint name='hinge' axis='0 1 0'/>"
    "<geom %s/></body></worldbody></mujoco>";

/* Mass, its moment about the hinge and the distance to its centre of a capsule along the line from
 * a to b, by slices (Simpson's rule in each of the three parts, of degree 4 in z at most) */
static void capsule(const double a[3], const double b[3], double r, double *m, double *I, double *l)
{
    double d[3], length = 0.0, across = 0.0, mass = 0.0, centre[3];
    for (int i = 0; i < 3; i++) {
        d[i] = b[i] - a[i];
        centre[i] = 0.5 * (a[i] + b[i]);
        length += d[i] * d[i];
    }
    double h = 0.5 * sqrt(length);
    enum { SLICES = 2000 };
    for (int part = 0; part < 3; part++) {
        double from = part == 0   ? -h - r
                      : part == 1 ? -h
                                  : h,
               to = part == 0   ? -h
                    : part == 1 ? h
                                : h + r;
        for (int k = 0; k <= SLICES; k++) {
            double z = from + (to - from) * k / SLICES, beyond = fmax(0.0, fabs(z) - h);
            double disc = 3.14159265358979324 * fmax(0.0, r * r - beyond * beyond), w;
            w = (k == 0 || k == SLICES ? 1.0 : k % 2 ? 4.0 : 2.0) * (to - from) / SLICES / 3.0;
            mass += 1000.0 * w * disc;
            across += 1000.0 * w * disc * (disc / 3.14159265358979324 / 4.0 + z * z);
        }
    }
    *m = mass;
    *l = -centre[2];
    *I = across + mass * (centre[0] * centre[0] + centre[2] * centre[2]);
}

START_TEST(a_body_has_the_mass_of_its_geoms)
{
    static const double a[3] = {0.1, 0.0, -0.1}, b[3] = {0.3, 0.0, -0.5};
    double m[4], I[4], l[4];
    capsule(a, b, 0.05, &m[0], &I[0], &l[0]);
    m[1] = 4.0 / 3.0 * 3.14159265358979324 * 1e-3 * 500.0;
    I[1] = m[1] * (0.4 * 0.01 + 0.25);
    m[2] = 2.5;
    I[2] = m[2] * ((0.04 + 0.01) / 3.0 + 0.09);
    l[1] = 0.5;
    l[2] = 0.3;
    m[3] = m[0];
    I[3] = I[0];
    l[3] = l[0];
    static const char *const geom[] = {"type='capsule' size='0.05' fromto='0.1 0 -0.1 0.3 0 -0.5'",
                                       "size='0.1' density='500' pos='0 0 -0.5'",
                                       "type='box' size='0.2 0.3 0.1' euler='0 33 0' mass='2.5' "
                                       "pos='0 0 -0.3'",
                                       "type='capsule' size='0.05 0.223606797749979' "
                                       "pos='0.2 0 -0.3' zaxis='0.2 0 -0.4'"};
    for (int k = 0; k < 4; k++) {
        lab_options options = lab_options_default();
        lab_model *model = NULL;
        stein_sim *sim = NULL;
        import(robot_file(swing, geom[k]), in_folder("swing.yaml"));
        ck_assert_stein(lab_open(&model, in_folder("swing.yaml"), &options, err));
        ck_assert_stein(lab_sim(model, NULL, &sim, err));
        // about y a force along x below the hinge turns it back
        ck_assert_close(stein_qdd(sim)[0], -9.81 * m[k] * l[k] / I[k], 1e-9, 0.0);
        stein_sim_destroy(sim);
        lab_close(model);
    }
}
END_TEST

#define LOOPED(equality)                                                                  \
    "<mujoco><compiler angle='radian'/><worldbody>"                                       \
    "<body name='crank'><joint name='c' axis='0 -1 0'/>"                                  \
    "<inertial pos='0.05 0 0' mass='0.5' diaginertia='1e-3 1e-3 1e-3'/>"                  \
    "<body name='coupler' pos='0.1 0 0' euler='0 -0.6 0'><joint name='k' axis='0 -1 0'/>" \
    "<inertial pos='0.15 0 0' mass='0.8' diaginertia='6e-3 6e-3 6e-3'/></body></body>"    \
    "<body name='rocker' pos='0.3 0 0'><joint name='r' axis='0 -1 0'/>"                   \
    "<inertial pos='0.1 0 0' mass='0.6' diaginertia='2e-3 2e-3 2e-3'/></body>"            \
    "</worldbody><equality>" equality "</equality>%s</mujoco>"

/* the coupler is turned by 0.6 rad at the reference; its end is at the anchor */
START_TEST(equalities_are_loops)
{
    static const char text[] =
        "mechanism: m\nbodies:\n"
        "  crank: {joint: R -y, mass: 0.5, centre: [0.05, 0, 0], inertia: {yy: 1e-3},\n"
        "          points: {k: [0.1, 0, 0]}, initial: {position: 0}}\n"
        "  coupler: {parent: crank, joint: R -y, at: crank.k, mass: 0.8, initial: {position: 0},\n"
        "            centre: [0.15 m * cos(0.6), 0, 0.15 m * sin(0.6)], inertia: {yy: 6e-3},\n"
        "            points: {e: [0.3 m * cos(0.6), 0, 0.3 m * sin(0.6)]}}\n"
        "  rocker: {joint: R -y, at: [0.3, 0, 0], mass: 0.6, centre: [0.1, 0, 0],\n"
        "           inertia: {yy: 2e-3}, initial: {position: 0},\n"
        "           points: {e: [0.3 m * cos(0.6) - 0.2 m, 0, 0.3 m * sin(0.6)]}}\n"
        "loops: {pin: {between: [coupler.e, rocker.e]}}\n";
    lab_options options = lab_options_default();
    lab_model *model[2] = {NULL, NULL};
    stein_sim *sim[2];
    import(robot_file(LOOPED("<connect body1='coupler' body2='rocker' anchor='0.3 0 0'/>"), ""),
           in_folder("bar.yaml"));
    ck_assert_stein(lab_open(&model[0], in_folder("bar.yaml"), &options, err));
    ck_assert_stein(lab__open_text(&model[1], "m.yaml", text, sizeof text - 1, &options, err));
    for (int k = 0; k < 2; k++) {
        ck_assert_stein(lab_sim(model[k], NULL, &sim[k], err));
        ck_assert_int_eq(stein_freedom(sim[k]), 1);
        ck_assert_stein(stein_run(sim[k], 0.05, err));
    }
    for (int i = 0; i < 3; i++) {
        ck_assert_close(stein_q(sim[0])[i], stein_q(sim[1])[i], 1e-10, 1e-12);
        ck_assert_close(stein_qdd(sim[0])[i], stein_qdd(sim[1])[i], 1e-9, 1e-10);
    }
    for (int k = 0; k < 2; k++) {
        stein_sim_destroy(sim[k]);
        lab_close(model[k]);
    }
}
END_TEST

START_TEST(models_of_mujoco_that_are_not_in_order_are_refused)
{
    static const struct {
        const char *text, *word, *told;
    } bad[] = {
        {"<mujoco>%s</mujoco>", "", "<mujoco> without a <worldbody>"},
        {"<mujoco><worldbody>%s</worldbody></mujoco>", "", "without a body that moves"},
        {"<mujoco><worldbody>%s</worldbody></mujoco>", "<frame/>", "<frame>, expected a model in"},
        {"<mujoco><compiler eulerseq='%s'/><worldbody/></mujoco>", "xy", "eulerseq is \"xy\""},
        {swing, "type='cone'", "a geom of type \"cone\""},
        {swing, "size='a'", "size is \"a\", expected a number"},
        {swing, "size='1' class='fine'", "there is no default class \"fine\""},
        {swing, "size='1' quat='1 0 0'", "quat has 3 numbers, expected 4"},
        {swing, "size='1' quat='0 0 0 0'", "the orientation of <geom> is none"},
        {swing, "size='1' xyaxes='1 0 0 0 1'", "xyaxes has 5 numbers, expected 6"},
        {LOOPED("<connect body1='coupler' body2='rod' anchor='0 0 0'/>"), "",
         "<connect> at \"rod\", which is no body"},
        {LOOPED("<joint joint1='c' joint2='x'/>"), "", "<joint> at \"x\", which is no joint"},
        {LOOPED("<joint joint1='c' joint2='k' polycoef='0 1 2 0 0'/>"), "", "second or higher"},
        {LOOPED("<tendon/>"), "", "an equality <tendon>, expected connect, weld or joint"},
        {LOOPED(""), "<include file='a.xml'/>", "<include>, expected a model in which"},
        {LOOPED(""), "<actuator><motor joint='z'/></actuator>", "<motor> at \"z\", which is no"},
    };
    stein_err told = {STEIN_OK, ""};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        const char *to = in_folder("never.yaml");
        ck_assert_int_eq(lab_import(robot_file(bad[i].text, bad[i].word), to, LAB_INERTIA_REFUSE,
                                    NULL, NULL, NULL, &told),
                         STEIN_EPARSE);
        ck_assert_msg(strstr(told.msg, bad[i].told) != NULL, "%s: %s", bad[i].told, told.msg);
        ck_assert_int_ne(access(to, F_OK), 0);
    }
}
END_TEST

Suite *import_robots_suite(void)
{
    Suite *s = suite_create("import_robots");
    TCase *t = tcase_create("import_robots");
    tcase_set_timeout(t, 120);
    tcase_add_unchecked_fixture(t, cache_in_build, NULL);
    tcase_add_checked_fixture(t, make_folder, remove_folder);
    tcase_add_test(t, a_robot_of_ros_has_the_accelerations_of_the_file_written_by_hand);
    tcase_add_test(t, an_axis_that_is_askew_is_that_of_the_robot);
    tcase_add_test(t, robots_that_are_not_in_order_are_refused_by_place);
    tcase_add_test(t, a_model_of_mujoco_has_the_accelerations_of_the_file_written_by_hand);
    tcase_add_test(t, a_body_has_the_mass_of_its_geoms);
    tcase_add_test(t, orientations_are_the_same_however_they_are_written);
    tcase_add_test(t, an_armature_is_that_of_its_joint);
    tcase_add_test(t, equalities_are_loops);
    tcase_add_test(t, models_of_mujoco_that_are_not_in_order_are_refused);
    suite_add_tcase(s, t);
    return s;
}
