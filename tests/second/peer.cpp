// SPDX-License-Identifier: GPL-3.0-or-later
// peer.cpp - a random mechanism as a system of Simbody (Sherman, Seth & Delp 2011).
#include <Simbody.h>

#include <cstdio>
#include <cmath>

#include "second.h"

using namespace SimTK;

namespace {

Vec3 vec(const double *p)
{
    return Vec3(p[0], p[1], p[2]);
}

// Everything of a draw. Members are made in their order and refer to those before them.
struct World {
    MultibodySystem system;
    SimbodyMatterSubsystem matter{system};
    GeneralForceSubsystem forces{system};
    std::vector<MobilizedBody> body;

    explicit World(const draw &d)
    {
        Force::UniformGravity(forces, matter, vec(d.gravity));
        for (int i = 0; i < d.n; i++) {
            add(d.body[i]);
        }
    }

    MobilizedBody &at(int i)
    {
        return i < 0 ? (MobilizedBody &)matter.updGround() : body[i];
    }

    // revolute about z, prismatic along x of a frame that the joint has on both sides
    void add(const draw_body &b)
    {
        Vec3 along(0);
        along[b.axis] = b.sign;
        Rotation turn(UnitVec3(along), CoordinateAxis(b.turns ? 2 : 0));
        Inertia central(b.inertia[0], b.inertia[1], b.inertia[2], b.inertia[3], b.inertia[4],
                        b.inertia[5]);
        Body::Rigid rigid(MassProperties(b.mass, vec(b.centre),
                                         central.shiftFromMassCenter(vec(b.centre), b.mass)));
        Transform outside(turn, vec(b.at)), inside(turn);
        if (b.turns) {
            body.push_back(MobilizedBody::Pin(at(b.parent), outside, rigid, inside));
        } else {
            body.push_back(MobilizedBody::Slider(at(b.parent), outside, rigid, inside));
        }
        if (b.k > 0.0) {
            Force::MobilityLinearSpring(forces, body.back(), MobilizerQIndex(0), b.k, b.rest);
            Force::MobilityLinearDamper(forces, body.back(), MobilizerUIndex(0), b.damping);
        }
    }

    void close(const draw_loop &l, bool planar)
    {
        MobilizedBody &a = at(l.a), &b = at(l.b);
        Vec3 pa = vec(l.pa), pb = vec(l.pb);
        if (l.kind == ROD) {
            Constraint::Rod(a, pa, b, pb, l.length);
        } else if (l.kind == SLOT && !planar) {
            Constraint::PointOnLine(a, UnitVec3(ZAxis), pa, b, pb);
        } else if (planar) {
            Constraint::PointInPlane(a, UnitVec3(XAxis), pa[0], b, pb);
            if (l.kind == MEET) {
                Constraint::PointInPlane(a, UnitVec3(ZAxis), pa[2], b, pb);
            }
        } else {
            Constraint::Ball(a, pa, b, pb);
        }
    }

    void connect(const draw &d)
    {
        for (int i = 0; i < d.nloop; i++) {
            close(d.loop[i], d.planar != 0);
        }
        if (d.joint >= 0) { // 0 = q_joint - ratio q_follows - offset
            Vector factors(3);
            factors[0] = 1.0;
            factors[1] = -d.ratio;
            factors[2] = -d.offset;
            Array_<MobilizedBodyIndex> bodies;
            bodies.push_back(body[d.joint].getMobilizedBodyIndex());
            bodies.push_back(body[d.follows].getMobilizedBodyIndex());
            Array_<MobilizerQIndex> coordinates(2, MobilizerQIndex(0));
            Constraint::CoordinateCoupler(matter, new Function::Linear(factors), bodies,
                                          coordinates);
        }
        if (d.to >= 0) {
            Force::TwoPointLinearSpring(forces, at(d.from), vec(d.pfrom), at(d.to), vec(d.pto),
                                        d.stiffness, d.length);
            Force::TwoPointLinearDamper(forces, at(d.from), vec(d.pfrom), at(d.to), vec(d.pto),
                                        d.damping);
        }
    }
};

} // namespace

void peer_place(const draw *d, int which, const double *p, int in, double *out)
{
    World w(*d);
    State s = w.system.realizeTopology();
    for (int i = 0; i < d->n; i++) {
        w.body[i].setOneQ(s, 0, d->body[i].q);
    }
    w.system.realize(s, Stage::Position);
    Vec3 there = w.at(which).findStationLocationInAnotherBody(s, vec(p), w.at(in));
    for (int i = 0; i < 3; i++) {
        out[i] = there[i];
    }
}

int peer_look(const draw *d, const double *q, const double *qd, peer_state *out, char *text,
              int size)
{
    try {
        World w(*d);
        w.connect(*d);
        State s = w.system.realizeTopology();
        for (int i = 0; i < d->n; i++) {
            w.body[i].setOneQ(s, 0, q[i]);
            w.body[i].setOneU(s, 0, qd[i]);
        }
        w.system.realize(s, Stage::Acceleration);
        for (int i = 0; i < d->n; i++) {
            out->qdd[i] = w.body[i].getOneUDot(s, 0);
        }
        out->open = 0.0;
        out->condition = 1.0;
        if (s.getNUErr() > 0) {
            Matrix compliance;
            Vector singular;
            out->open = std::fmax(s.getQErr().normInf(), s.getUErr().normInf());
            w.matter.calcProjectedMInv(s, compliance);
            FactorSVD(compliance).getSingularValues(singular);
            for (int i = 0; i < singular.size(); i++) {
                if (singular[i] > 1e-13 * singular[0]) {
                    out->condition = singular[0] / singular[i];
                }
            }
        }
        return 0;
    } catch (const std::exception &e) {
        std::snprintf(text, (size_t)size, "%s", e.what());
        return -1;
    }
}
