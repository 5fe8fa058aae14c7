# SPDX-License-Identifier: GPL-3.0-or-later
"""Expressions for SymPy, sensitivities, forces of one's own."""
import copy
import json
import os
import pickle

import numpy
import pytest
import stein
from conftest import ACTION, PENDULUM, ROOT, command

PIANO_TREE = os.path.join(ROOT, "models", "robotran", "piano_tree.yaml")
DOUBLE = os.path.join(ROOT, "models", "double_pendulum.yaml")


def somewhere(m):
    """q, qd, qdd of no special kind, and what every symbol of an expression is there."""
    rows = numpy.random.default_rng(2385).normal(0.0, 0.7, (3, len(m.bodies)))
    values = dict(m)
    for word, row in zip(("q", "qd", "qdd"), rows):
        values.update({f"{word}.{body}": x for body, x in zip(m.bodies, row)})
    return rows, values


def evaluated(text, values):
    sympy = pytest.importorskip("sympy")
    expression = sympy.sympify(text)
    names = sorted(expression.free_symbols, key=str)
    found = sympy.lambdify(names, expression, "numpy")(*(values[str(n)] for n in names))
    return numpy.asarray(found, dtype=float)


@pytest.mark.parametrize("file", [PENDULUM, DOUBLE, ACTION, PIANO_TREE])
def test_sympy_reads_the_equations(file):
    m = stein.load(file)
    m[next(n for n in m if n.endswith(".mass"))] = 0.2385
    (q, qd, qdd), values = somewhere(m)
    for what, there in (("M", m.mass_matrix(q)), ("c", m.bias(q, qd)), ("Q", m.inverse(q, qd, qdd))):
        found = evaluated(m.sympy(what), values).reshape(there.shape)
        assert abs(found - there).max() <= 1e-13 * abs(there).max(), what
    m.set_state(q, qd)
    for what, there in zip("TV", m.energy()):
        assert evaluated(m.sympy(what), values) == pytest.approx(there, rel=1e-12)


def test_sympy_reads_where_a_point_is():
    m = stein.load(ACTION)
    (q, _, _), values = somewhere(m)
    assert evaluated(m.sympy("hammer.head"), values).ravel() == pytest.approx(
        m.position("hammer.head", q), rel=1e-12)
    with pytest.raises(stein.UnknownName, match="expected M, c, Q, T, V or the name of a point"):
        m.sympy("qdd")


def shifted(file, name, change, until):
    m = stein.load(file)
    m[name] += change
    m.run(until)
    return m.q, m.qd


@pytest.mark.parametrize("file, until, change, names", [
    (PENDULUM, 0.5, 1e-6, ["rod.mass", "rod.damping", "rod.initial.position"]),
    (ACTION, 0.06, 1e-8, ["hammer.mass", "pawl.stop_shift"]),  # through escapement and impact
])
def test_sensitivities_are_differences_of_neighbouring_runs(file, until, change, names):
    m = stein.load(file)
    found = m.sensitivities(names, until, every=1e-3)
    assert list(found.q) == list(found.qd) == names
    assert numpy.array_equal(found.run["time"], stein.load(file).run(until, every=1e-3)["time"])
    for name in names:
        up, down = (shifted(file, name, d, until) for d in (change, -change))
        for by, k in ((found.q, 0), (found.qd, 1)):
            assert by[name].shape == (len(found.run["time"]), len(m.bodies))
            there = (up[k] - down[k]) / (2 * change)
            assert abs(by[name][-1] - there).max() <= 1e-3 * abs(there).max(), name


def test_sensitivities_refuse_what_has_no_derivative():
    m = stein.load(PENDULUM)
    with pytest.raises(stein.UnknownName, match="rod.mass"):
        m.sensitivities(["rod.mas"])
    m.drive("push", lambda t: 0.1)
    with pytest.raises(stein.InvalidValue, match="signal"):
        m.sensitivities(["rod.mass"], 0.1)
    m.drive("push", None)
    m.on_force(lambda t, q, qd: [0.1])
    with pytest.raises(stein.InvalidValue, match="hook"):
        m.sensitivities(["rod.mass"], 0.1)


def damping(t, q, qd):
    return [-3e-3 * qd[0]]


def test_a_force_of_ones_own_is_that_of_the_law():
    lawful, own = stein.load(PENDULUM, {"rod.damping": 3e-3}), stein.load(PENDULUM, {"rod.damping": 0})
    own.on_force(damping)
    run = own.run(1.0)
    assert numpy.allclose(run["angle"], lawful.run(1.0)["angle"], rtol=0, atol=1e-12)
    for other in (own.copy(), copy.deepcopy(own), pickle.loads(pickle.dumps(own))):
        assert numpy.array_equal(other.run(1.0)["angle"], run["angle"])
    own.on_force(None)
    assert own.run(1.0)["angle"][-1] != run["angle"][-1]


@pytest.mark.parametrize("force, error", [
    (lambda t, q, qd: 1 / 0, ZeroDivisionError), (lambda t, q, qd: [1, 2], ValueError),
    (lambda t, q, qd: ["a"], TypeError), (lambda t: [0], TypeError)])
def test_what_a_force_raises_ends_the_step(force, error):
    m = stein.load(PENDULUM)
    m.on_force(force)
    for work in (m.step, lambda: m.run(1.0), lambda: m.step(5), m.acceleration):
        with pytest.raises(error):
            work()
    m.on_force(None)
    m.reset()
    assert m.step() == 1e-3
    with pytest.raises(TypeError):
        m.on_force(3)


def test_what_is_too_long_for_sympy_is_refused(tmp_path):
    joints = "".join(
        f"  b{i}: {{{f'parent: b{i - 1}, ' if i else ''}joint: R {'xyz'[i % 3]}, at: [0.1 m, 0.2 m, 0.3 m], mass: 1 kg,"
        " centre: [0.1 m, 0.05 m, 0.02 m], inertia: {xx: 0.1 kg m^2, yy: 0.2 kg m^2, zz: 0.15 kg m^2}}\n"
        for i in range(8))
    file = tmp_path / "chain.yaml"
    file.write_text(f"mechanism: chain\nbodies:\n{joints}outputs: {{a: {{joint: b0, read: position}}}}\n"
                    "simulation: {dt: 1 ms, until: 1 s}\n")
    m = stein.load(file)
    assert len(m.sympy("V")) < 20000
    with pytest.raises(stein.EquationsError, match="M of chain is longer than 4 MB"):
        m.sympy("M")


def test_a_linear_system_is_that_of_the_command():
    m = stein.load(ACTION)
    m.lift()
    m.settle()
    before, here = m.state, m.linearise()
    assert m.state == before
    there = json.loads(command("linearise", ACTION, "--json"))
    for word in "ABCD":
        assert numpy.array_equal(getattr(here, word), numpy.array(there[word])), word
    assert list(here.inputs) == [i["name"] for i in there["inputs"]] == ["finger"]
    assert list(here.states) == [s["name"] for s in there["states"]]
    assert [mode.frequency for mode in here.modes] == [mode["frequency"] for mode in there["modes"]]
    assert here.exact and here.why is None and here.error == 0.0 and not here.edges
    assert [o["name"] for o in there["outputs"] if not o["exact"]] == list(here.inexact)
    expected = numpy.linalg.eigvals(here.A)
    found = numpy.array([m.eigenvalue for m in here.modes])
    assert sorted(abs(expected)) == pytest.approx(sorted(abs(numpy.concatenate([found, found]))))
    for mode in here.modes:
        z = numpy.array(mode.shape)
        x = numpy.concatenate([z, mode.eigenvalue * z])
        assert abs(here.A @ x - mode.eigenvalue * x).max() <= 1e-9 * abs(here.A).max()


def test_a_state_that_is_no_equilibrium_is_an_error():
    m = stein.load(PENDULUM)
    with pytest.raises(stein.NumericalError, match='"rod" accelerates with -20.9'):
        m.linearise()
    m.settle()
    assert m.linearise().modes[0].frequency == pytest.approx(1.03)
    loop = stein.load(os.path.join(ROOT, "models", "four_bar.yaml"))
    loop.settle()
    here = loop.linearise()
    assert not here.exact and "loops" in here.why and here.error < 1e-10
    assert here.T.shape == (3, 1) and here.coordinates == ("crank",) and here.free == 1
