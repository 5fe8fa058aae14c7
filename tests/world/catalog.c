/* SPDX-License-Identifier: GPL-3.0-or-later
 * catalog.c - the mechanisms. Sizes are drawn within a factor, so that no two sets are of one kind.
 */
#include <math.h>
#include <stdio.h>

#include "world.h"

static const double g = 9.81;

static double about(chance *c, double x)
{
    return x * chance_log(c, 0.75, 1.35);
}

/* a lever hanging from its joint: mass, centre and inertia of a rod that is not quite uniform */
static int rod(mech *m, chance *c, const char *name, int parent, double mass, double length)
{
    int b = mech_body(m, name, parent, 'R', 1, -1);
    mech_mass(m, b, mass, 0.0, -length * chance_uniform(c, 0.42, 0.6));
    mech_inertia(m, b, 0.0, mass * length * length * chance_uniform(c, 0.06, 0.1), 0.0);
    return b;
}

/* friction in the file, of a joint that carries a moment (force) and turns so fast
 * @param chance_of  that there is any */
static void rubbing(mech *m, chance *c, int b, double moment, double speed, double chance_of)
{
    int law = m->body[b].law;
    if (!chance_coin(c, chance_of)) {
        return;
    }
    if (chance_coin(c, 0.5)) {
        mech_state(m, law + J_B, moment / speed * chance_log(c, 0.003, 0.02), 0.05);
    } else {
        mech_state(m, law + J_T, moment * chance_log(c, 0.003, 0.015), 0.05);
        mech_state(m, law + J_W, speed * chance_log(c, 0.005, 0.02), 0.0);
    }
}

static void pendulum(mech *m, chance *c)
{
    double length = about(c, 0.3), mass = about(c, 0.15);
    mech_start(m, "pendulum", "A lever that swings.");
    int r = rod(m, c, "rod", -1, mass, length);
    rubbing(m, c, r, mass * g * length / 2.0, 4.0, 0.5);
    mech_channel(m, "angle", READ_POSITION, r);
    if (chance_coin(c, 0.4)) {
        mech_channel(m, "rate", READ_SPEED, r);
    }
    m->swing[r] = chance_uniform(c, 0.3, 1.4);
    m->kick[r] = 1.0;
    m->duration[0] = 4.0, m->duration[1] = 15.0;
}

/* two or three levers in a chain, with `motor` driven */
static void chain(mech *m, chance *c, int n, int motor, int kind_of_drive)
{
    static const char *const name[] = {"upper", "lower", "last"};
    static const char *const turn[] = {"angle1", "angle2", "angle3"};
    static const char *const drive[] = {"drive1", "drive2", "drive3"};
    static const char *const effort[] = {"torque1", "torque2", "torque3"};
    double length = about(c, 0.28), mass = about(c, 0.25);
    for (int i = 0; i < n; i++) {
        double moment = (n - i) * mass * g * length / 2.0;
        int b = rod(m, c, name[i], i - 1, mass, length);
        if (i > 0) {
            mech_at(m, b, 0.0, -length * chance_log(c, 1.0, 1.2));
        }
        rubbing(m, c, b, moment, 5.0, motor ? 0.8 : 0.4);
        m->swing[i] = motor ? 0.3 : chance_uniform(c, 0.4, 1.2);
        m->kick[i] = 0.5;
        length *= chance_uniform(c, 0.6, 0.9), mass *= chance_uniform(c, 0.5, 0.9);
        if (motor) {
            mech_input(m, drive[i], kind_of_drive, b);
            m->drive[i] = kind_of_drive == INPUT_MOTION ? chance_uniform(c, 0.4, 1.2)
                                                        : moment * chance_uniform(c, 0.2, 0.5);
        }
        if (kind_of_drive != INPUT_MOTION) {
            mech_channel(m, turn[i], READ_POSITION, b);
        } else {
            mech_channel(m, effort[i], READ_EFFORT, i);
        }
    }
    m->duration[0] = 1.5, m->duration[1] = 4.0;
    m->drive_rate[0] = 0.2, m->drive_rate[1] = 1.2;
}

static void double_pendulum(mech *m, chance *c)
{
    mech_start(m, "double_pendulum", "Two levers in a chain.");
    chain(m, c, 2, 0, INPUT_TORQUE);
}

static void mass_spring(mech *m, chance *c)
{
    int upright = chance_coin(c, 0.4);
    double mass = about(c, 0.8), rate = chance_uniform(c, 6.0, 25.0), k = mass * rate * rate;
    mech_start(m, "mass_spring", "A mass on a spring and a linear guide.");
    int s = mech_body(m, "sled", -1, 'T', upright ? 2 : 0, 1);
    mech_mass(m, s, mass, 0.0, 0.0);
    mech_state(m, m->body[s].law + J_K, k, 0.01);
    m->swing[s] = chance_uniform(c, 0.01, 0.06);
    m->mean[s] = upright ? -mass * g / k : 0.0;
    m->kick[s] = 0.2;
    rubbing(m, c, s, k * m->swing[s], rate * m->swing[s], 0.6);
    mech_channel(m, "x", READ_POSITION, s);
    m->duration[0] = 2.0, m->duration[1] = 6.0;
}

static void cart_pole(mech *m, chance *c)
{
    double mass = about(c, 0.15), length = about(c, 0.35), heavy = about(c, 0.6);
    mech_start(m, "cart_pole", "A cart on a guide with a lever that hangs on it.");
    int cart = mech_body(m, "cart", -1, 'T', 0, 1);
    mech_mass(m, cart, heavy, 0.0, 0.0);
    rubbing(m, c, cart, mass * g, 0.5, 0.6);
    int pole = rod(m, c, "pole", cart, mass, length);
    rubbing(m, c, pole, mass * g * length / 2.0, 4.0, 0.4);
    if (chance_coin(c, 0.5)) {
        mech_input(m, "force", INPUT_TORQUE, cart);
        m->drive[0] = chance_uniform(c, 0.3, 1.0) * mass * g;
    }
    mech_channel(m, "x", READ_POSITION, cart);
    mech_channel(m, "angle", READ_POSITION, pole);
    m->swing[cart] = 0.1, m->swing[pole] = chance_uniform(c, 0.4, 1.2);
    m->kick[cart] = 0.1, m->kick[pole] = 1.0;
    m->duration[0] = 2.0, m->duration[1] = 5.0;
    m->drive_rate[0] = 0.3, m->drive_rate[1] = 1.5;
}

static void arm(mech *m, chance *c)
{
    mech_start(m, "arm", "Two levers with a motor at each joint.");
    chain(m, c, 2, 1, INPUT_TORQUE);
}

static void arm_inverse(mech *m, chance *c)
{
    mech_start(m, "arm_inverse", "Two levers moved as measured, and the torques that this needs.");
    chain(m, c, 2, 1, INPUT_MOTION);
    m->duration[0] = 5.0, m->duration[1] = 12.0;
    m->drive_rate[0] = 0.1, m->drive_rate[1] = 0.8;
}

static void triple_pendulum(mech *m, chance *c)
{
    mech_start(m, "triple_pendulum", "Three levers in a chain.");
    chain(m, c, 3, 0, INPUT_TORQUE);
    m->duration[0] = 1.0, m->duration[1] = 2.5;
}

static void rotary(mech *m, chance *c)
{
    double reach = about(c, 0.2), mass = about(c, 0.08), length = about(c, 0.25);
    double heavy = about(c, 0.2), I = mass * length * length * 0.08;
    mech_start(m, "rotary_pendulum", "An arm about a vertical axis with a lever at its end.");
    int a = mech_body(m, "arm", -1, 'R', 2, 1);
    mech_mass(m, a, heavy, reach * chance_uniform(c, 0.3, 0.5), 0.0);
    mech_inertia(m, a, 0.0, 0.0, heavy * reach * reach * chance_uniform(c, 0.07, 0.12));
    rubbing(m, c, a, mass * g * reach, 3.0, 0.7);
    int p = mech_body(m, "pole", a, 'R', 0, 1);
    mech_at(m, p, reach, 0.0);
    mech_mass(m, p, mass, 0.0, -length * chance_uniform(c, 0.42, 0.6));
    // a flat lever: errors of its moments leave a body that can be
    mech_inertia(m, p, I, I * 0.9, I * 0.3);
    rubbing(m, c, p, mass * g * length / 2.0, 5.0, 0.4);
    if (chance_coin(c, 0.5)) {
        mech_input(m, "motor", INPUT_TORQUE, a);
        m->drive[0] = mass * g * reach * chance_uniform(c, 0.2, 0.5);
    }
    mech_channel(m, "arm_angle", READ_POSITION, a);
    mech_channel(m, "pole_angle", READ_POSITION, p);
    m->swing[a] = 0.3, m->swing[p] = chance_uniform(c, 0.5, 1.5);
    m->kick[a] = m->kick[p] = 1.0;
    m->duration[0] = 2.0, m->duration[1] = 5.0;
    m->drive_rate[0] = 0.3, m->drive_rate[1] = 2.0;
}

static void flexible(mech *m, chance *c)
{
    double length = about(c, 0.3), mass = about(c, 0.2), rate = chance_uniform(c, 30.0, 70.0);
    mech_start(m, "flexible_link", "A lever that bends at one place.");
    int a = rod(m, c, "root", -1, mass, length);
    rubbing(m, c, a, mass * g * length, 4.0, 0.5);
    int b = rod(m, c, "outer", a, 0.4 * mass, 0.8 * length);
    mech_at(m, b, 0.0, -length);
    double k = 0.1 * mass * length * length * rate * rate;
    mech_state(m, m->body[b].law + J_K, k, 0.02);
    mech_state(m, m->body[b].law + J_B, k * chance_log(c, 0.01, 0.05) / rate, 0.05);
    int tip = mech_point(m, "tip", b, 0.0, -0.8 * length);
    mech_channel(m, "angle", READ_POSITION, a);
    mech_channel(m, "tip_x", READ_X, tip);
    m->swing[a] = chance_uniform(c, 0.3, 1.0), m->swing[b] = 0.05;
    m->kick[a] = 1.0, m->kick[b] = 1.0;
    m->duration[0] = 1.0, m->duration[1] = 3.0;
}

static void ball(mech *m, chance *c)
{
    double mass = about(c, 0.05), radius = about(c, 0.02);
    mech_start(m, "ball", "A ball that falls on a floor.");
    int b = mech_body(m, "ball", -1, 'T', 2, 1);
    mech_mass(m, b, mass, 0.0, 0.0);
    rubbing(m, c, b, mass * g, 2.0, 0.2);
    int middle = mech_point(m, "middle", b, 0.0, 0.0);
    int f = mech_contact(m, "floor", middle, -1, radius, 0.0);
    mech_line(m, f, -1, 0.0, 0.0, 90.0);
    int law = m->contact[f].law, straight = chance_coin(c, 0.5);
    mech_state(m, law + (straight ? N_C : N_B), about(c, straight ? 3e4 : 3e7), 0.05);
    mech_state(m, law + N_D, chance_log(c, 0.05, 0.25), 0.03);
    mech_channel(m, "height", READ_POSITION, b);
    m->mean[b] = 0.3, m->swing[b] = 0.15, m->kick[b] = 0.5;
    m->duration[0] = 1.0, m->duration[1] = 2.5;
    m->dt = 1e-5;
}

static void block(mech *m, chance *c)
{
    double mass = about(c, 0.5), rate = chance_uniform(c, 8.0, 25.0), k = mass * rate * rate;
    mech_start(m, "block", "A block on a spring that rubs on its guide.");
    int b = mech_body(m, "block", -1, 'T', 0, 1);
    int law = m->body[b].law;
    mech_mass(m, b, mass, 0.0, 0.0);
    mech_state(m, law + J_K, k, 0.01);
    m->swing[b] = chance_uniform(c, 0.03, 0.08), m->kick[b] = 0.3;
    double rub = k * m->swing[b] * chance_log(c, 0.01, 0.04);
    mech_state(m, law + J_A, rub, 0.05);
    mech_state(m, law + J_VT, chance_log(c, 0.002, 0.01), 0.0);
    if (chance_coin(c, 0.5)) {
        mech_state(m, law + J_B1, chance_uniform(c, 0.2, 0.8), 0.0);
        mech_state(m, law + J_B2, chance_uniform(c, 0.1, 0.4), 0.0);
    }
    mech_channel(m, "x", READ_POSITION, b);
    m->duration[0] = 1.5, m->duration[1] = 4.0;
}

static void crank(mech *m, chance *c)
{
    double length = about(c, 0.12), mass = about(c, 0.2);
    mech_start(m, "crank", "A crank held by a spring between its pin and the frame.");
    int b = rod(m, c, "crank", -1, mass, length);
    rubbing(m, c, b, mass * g * length, 5.0, 0.7);
    int pin = mech_point(m, "pin", b, 0.0, -length);
    int post = mech_point(m, "post", -1, -0.2, -1.3 * length);
    mech_link(m, "spring", post, pin, about(c, 40.0), 0.12);
    mech_channel(m, "angle", READ_POSITION, b);
    if (chance_coin(c, 0.3)) {
        mech_channel(m, "rate", READ_SPEED, b);
    }
    m->swing[b] = chance_uniform(c, 0.4, 1.0), m->kick[b] = 2.0;
    m->duration[0] = 2.0, m->duration[1] = 5.0;
}

static void felt(mech *m, chance *c, int contact_of, double c1, double b2)
{
    int law = m->contact[contact_of].law;
    mech_state(m, law + N_C, about(c, c1), 0.04);
    if (b2 > 0.0) {
        mech_state(m, law + N_B, about(c, b2), 0.04);
    }
    mech_state(m, law + N_D, chance_log(c, 0.3, 1.5), 0.05);
}

static void key_hammer(mech *m, chance *c)
{
    mech_start(m, "key_hammer", "A key that throws a hammer at a string, with felts between them.");
    int k = mech_body(m, "key", -1, 'R', 1, -1);
    mech_mass(m, k, about(c, 0.11), -0.012, 0.0);
    mech_inertia(m, k, 0.0, about(c, 1.2e-3), 0.0);
    int front = mech_point(m, "front", k, 0.2, 0.0);
    int back = mech_point(m, "back", k, -0.16, 0.0);
    int capstan = mech_point(m, "capstan", k, -0.13, 0.012);
    int h = mech_body(m, "hammer", -1, 'R', 1, -1);
    mech_at(m, h, -0.2, 0.032);
    mech_mass(m, h, about(c, 0.011), 0.09, 0.002);
    mech_inertia(m, h, 0.0, about(c, 2.5e-5), 0.0);
    rubbing(m, c, k, 0.4, 2.0, 0.5);
    rubbing(m, c, h, 0.01, 20.0, 0.5);
    int head = mech_point(m, "head", h, 0.14, 0.01);
    int rest = mech_contact(m, "rest", back, -1, 0.0, 0.0);
    mech_line(m, rest, -1, -0.16, -0.002, 90.0);
    int stop = mech_contact(m, "stop", front, -1, 0.0, 0.0);
    mech_line(m, stop, -1, 0.2, -0.009, 90.0);
    int lift = mech_contact(m, "lift", capstan, -1, 0.0, 0.0);
    mech_line(m, lift, h, 0.07, -0.018, -90.0);
    int string = mech_contact(m, "string", head, -1, 0.0, 0.0);
    mech_line(m, string, -1, -0.06, 0.07, -90.0);
    felt(m, c, rest, 3e3, 1e6);
    felt(m, c, stop, 5e3, 3e6);
    felt(m, c, lift, 4e3, 2e6);
    felt(m, c, string, 1e4, 0.0);
    if (chance_coin(c, 0.5)) {
        mech_state(m, m->contact[lift].law + N_MU, chance_uniform(c, 0.2, 0.5), 0.05);
        mech_state(m, m->contact[lift].law + N_VT, 0.01, 0.0);
    }
    mech_input(m, "finger", INPUT_FORCE, front);
    m->drive[0] = chance_uniform(c, 2.0, 5.0);
    m->pushes = 1;
    mech_channel(m, "key_angle", READ_POSITION, k);
    mech_channel(m, "hammer_angle", READ_POSITION, h);
    m->settle = 1;
    m->duration[0] = 0.25, m->duration[1] = 0.5;
    m->dt = 1e-5;
}

static void four(mech *m, chance *c)
{
    static const char *const name[] = {"first", "second", "third", "fourth"};
    static const char *const angle[] = {"angle1", "angle2", "angle3", "angle4"};
    static const char *const hit[] = {"hit1", "hit2", "hit3"};
    double length = about(c, 0.25), mass = about(c, 0.1), radius = about(c, 0.02);
    int at[4];
    mech_start(m, "four", "Four pendulums side by side with felt between them.");
    for (int i = 0; i < 4; i++) {
        int b = mech_body(m, name[i], -1, 'R', 1, -1);
        mech_at(m, b, (i - 1.5) * (2.0 * radius + 0.0015), 0.0);
        mech_mass(m, b, mass * chance_uniform(c, 0.8, 1.2), 0.0, -length);
        mech_inertia(m, b, 0.0, mass * radius * radius * 0.5, 0.0);
        at[i] = mech_point(m, "weight", b, 0.0, -length);
        rubbing(m, c, b, mass * g * length, 3.0, 0.3);
        m->swing[b] = i == 0 || i == 3 ? 0.15 : 0.0;
        m->mean[b] = i == 0 ? -0.3 : i == 3 ? 0.15 : 0.0;
        mech_channel(m, angle[i], READ_POSITION, b);
    }
    for (int i = 0; i < 3; i++) {
        int k = mech_contact(m, hit[i], at[i], at[i + 1], radius, radius);
        felt(m, c, k, 5e3, chance_coin(c, 0.5) ? 3e6 : 0.0);
    }
    m->duration[0] = 0.8, m->duration[1] = 2.0;
    m->dt = 2e-5;
}

const entry catalog[] = {{"pendulum", pendulum},
                         {"double_pendulum", double_pendulum},
                         {"mass_spring", mass_spring},
                         {"cart_pole", cart_pole},
                         {"arm", arm},
                         {"arm_inverse", arm_inverse},
                         {"triple_pendulum", triple_pendulum},
                         {"rotary_pendulum", rotary},
                         {"flexible_link", flexible},
                         {"ball", ball},
                         {"block", block},
                         {"crank", crank},
                         {"key_hammer", key_hammer},
                         {"four", four}};

int catalog_count(void)
{
    return (int)(sizeof catalog / sizeof *catalog);
}
