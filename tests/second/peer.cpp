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

// depth and velocity of a contact, and where its force acts: at the lowest place of the first body
struct Meeting {
    Vec3 at, n, slide;
    double depth, rate;
};

// A contact whose forces are those that second.h states.
class Contact : public Force::Custom::Implementation {
  public:
    Contact(const draw_contact &c, const MobilizedBody &a, const MobilizedBody &b)
        : c(c), a(a), b(b)
    {
    }

    void calcForce(const State &s, Vector_<SpatialVec> &onBodies, Vector_<Vec3> &,
                   Vector &) const override
    {
        Meeting m = meet(s);
        if (m.depth <= 0.0) {
            return;
        }
        double x = m.depth, v = m.slide.norm(), u = v / c.vt;
        double normal =
            (c.cubic * x * x + c.linear) * x * std::pow(x / 1e-4, c.power) * (1.0 + c.D * m.rate);
        if (normal <= 0.0) {
            return;
        }
        double mu = c.A * (std::tanh(u) + c.B1 * u / (1.0 + c.B2 * std::pow(u, 4)));
        Vec3 force = normal * m.n;
        if (v > 0.0) {
            force -= mu * normal / v * m.slide;
        }
        a.applyForceToBodyPoint(s, a.findStationAtGroundPoint(s, m.at), force, onBodies);
        b.applyForceToBodyPoint(s, b.findStationAtGroundPoint(s, m.at), -force, onBodies);
    }

    Real calcPotentialEnergy(const State &) const override
    {
        return 0.0;
    }

  private:
    Meeting meet(const State &s) const
    {
        Meeting m;
        Vec3 from = b.findStationLocationInGround(s, vec(c.pb));
        Vec3 to = a.findStationLocationInGround(s, vec(c.pa));
        m.n = c.is_plane ? b.expressVectorInGroundFrame(s, vec(c.n)) : (to - from).normalize();
        m.depth = c.ra + c.rb - dot(to - from, m.n);
        m.at = to - c.ra * m.n;
        Vec3 v = a.findStationVelocityInGround(s, a.findStationAtGroundPoint(s, m.at)) -
                 b.findStationVelocityInGround(s, b.findStationAtGroundPoint(s, m.at));
        m.rate = -dot(v, m.n);
        m.slide = v + m.rate * m.n;
        return m;
    }

    draw_contact c;
    MobilizedBody a, b;
};

// Everything of a draw. Members are made in their order and refer to those before them.
struct World {
    MultibodySystem system;
    SimbodyMatterSubsystem matter{system};
    GeneralForceSubsystem forces{system};
    GeneralContactSubsystem touches{system};
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

    // The first body is hard, so that all of the depth is the second one's.
    void touch_by_library(const draw_contact &c)
    {
        const double hard = 1e40;
        double radius = c.is_plane ? c.ra : c.ra * c.rb / (c.ra + c.rb);
        double modulus = 0.75 * c.linear / std::sqrt(1e-4 * radius);
        double dry = c.dry ? c.A : 0.0, viscous = c.dry ? 0.0 : c.A / c.vt;
        ContactSetIndex set = touches.createContactSet();
        touches.addBody(set, at(c.a), ContactGeometry::Sphere(c.ra), Transform(vec(c.pa)));
        if (c.is_plane) { // x of a half-space points into it
            Rotation inwards(UnitVec3(-vec(c.n)), XAxis);
            touches.addBody(set, at(c.b), ContactGeometry::HalfSpace(),
                            Transform(inwards, vec(c.pb)));
        } else {
            touches.addBody(set, at(c.b), ContactGeometry::Sphere(c.rb), Transform(vec(c.pb)));
        }
        HuntCrossleyForce force(forces, touches, set);
        force.setBodyParameters(ContactSurfaceIndex(0), hard, c.D / 1.5, dry, dry, viscous);
        force.setBodyParameters(ContactSurfaceIndex(1), modulus, c.D / 1.5, dry, dry, viscous);
        force.setTransitionVelocity(c.dry ? c.vt : 1.0);
    }

    void connect(const draw &d)
    {
        for (int i = 0; i < d.ncontact; i++) {
            const draw_contact &c = d.contact[i];
            if (c.hertz) {
                touch_by_library(c);
            } else {
                Force::Custom(forces, new Contact(c, at(c.a), at(c.b)));
            }
        }
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

int peer_move(const draw *d, double time, double *q, double *qd, char *text, int size)
{
    try {
        World w(*d);
        w.connect(*d);
        State s = w.system.realizeTopology();
        for (int i = 0; i < d->n; i++) {
            w.body[i].setOneQ(s, 0, q[i]);
            w.body[i].setOneU(s, 0, qd[i]);
        }
        RungeKuttaMersonIntegrator integrator(w.system);
        integrator.setAccuracy(1e-11);
        integrator.setConstraintTolerance(1e-11);
        TimeStepper stepper(w.system, integrator);
        stepper.initialize(s);
        stepper.stepTo(time);
        for (int i = 0; i < d->n; i++) {
            q[i] = w.body[i].getOneQ(integrator.getState(), 0);
            qd[i] = w.body[i].getOneU(integrator.getState(), 0);
        }
        return 0;
    } catch (const std::exception &e) {
        std::snprintf(text, (size_t)size, "%s", e.what());
        return -1;
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
