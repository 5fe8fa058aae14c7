# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulations: the bits of the command, views, copies, pickles, drives, equations, failures."""
import copy
import gc
import json
import pickle
import warnings

import numpy
import pytest
import stein
from conftest import ACTION, PENDULUM, command, python


def same(run, table):
    assert list(run) == list(table.dtype.names)
    for name in run:
        assert numpy.array_equal(run[name], table[name]), name


# ---- what the command computes


def test_a_run_has_the_bits_of_the_command(tmp_path):
    command("simulate", PENDULUM, "--set", "rod.damping=3e-4", "--until", "1.3s", "--every", "7ms",
            "-o", tmp_path / "run.npy")
    m = stein.load(PENDULUM)
    m["rod.damping"] = 3e-4
    same(m.run(1.3, every=7e-3), numpy.load(tmp_path / "run.npy"))


def test_a_stroke_has_the_bits_of_the_command(tmp_path):
    told = json.loads(command("strike", ACTION, "--set", "pawl.stop_shift=-0.3mm", "--release",
                              "0.15s", "--json", "-o", tmp_path / "stroke.npy"))
    m = stein.load(ACTION)
    m["pawl.stop_shift"] = "-0.3 mm"
    stroke = m.strike(release=0.15)
    same(stroke.run, numpy.load(tmp_path / "stroke.npy"))
    assert stroke.outcome == told["outcome"] == "struck"
    assert stroke.escapement_time == told["escapement"]["time"]
    assert stroke.escapement_height == told["escapement"]["height"]
    assert stroke.impact_time == told["impact"]["time"]
    assert stroke.impact_speed == told["impact"]["speed"]
    for key in ("impacts", "free_flight", "forced_escapement", "peak_string_force", "rearmed"):
        assert getattr(stroke, key) == told[key], key
    assert m.read("string_distance") == told["final"]["string_distance"]


def test_what_did_not_happen_is_nan():
    m = stein.load(ACTION, {"load.mass": "20 g"})
    stroke = m.strike(0.05)
    assert stroke.outcome != "struck" and numpy.isnan(stroke.impact_time)


def test_a_file_drives_as_the_command_does(tmp_path):
    path = tmp_path / "push.csv"
    path.write_text("time [s],push [N m]\n0,0\n0.1,0.02\n0.2,-0.01\n0.3,0\n")
    command("simulate", PENDULUM, "--drive", path, "--until", "0.5s", "-o", tmp_path / "run.npy")
    m = stein.load(PENDULUM)
    m.drive_file(path)
    same(m.run(0.5), numpy.load(tmp_path / "run.npy"))


def test_equations_that_are_not_built_in_are_compiled(tmp_path):
    file = tmp_path / "two.yaml"
    file.write_text("mechanism: two\nbodies:\n"
                    "  one: {joint: T z, mass: 2 kg, spring: {k: 30 N/m}}\n"
                    "  other: {parent: one, joint: R y, mass: 1 kg, centre: [0.1 m, 0, 0.03 m],\n"
                    "          inertia: {yy: 0.02 kg m^2}}\n"
                    "outputs: {height: {joint: one, read: position}}\n"
                    "simulation: {dt: 1 ms, until: 1 s}\n")
    command("simulate", file, "-o", tmp_path / "run.npy")
    same(stein.load(file).run(), numpy.load(tmp_path / "run.npy"))


def test_steps_are_those_of_a_run():
    m, n = stein.load(ACTION), stein.load(ACTION)
    run = m.run(0.06, every=0)
    times, events = [n.time], []
    while n.time < 0.06 - 1e-9:
        times.append(n.step())
        events += n.events
    assert numpy.array_equal(times[:-1], run["time"][:-1])  # the last one ends at 0.06 exactly
    assert numpy.allclose(n.q, m.q, rtol=1e-12) and m.time == 0.06
    assert events == run.events == m.events
    assert {"contact_begin", "escapement", "impact", "phase"} <= {e.kind for e in events}
    n.reset()
    assert n.step(6000) == pytest.approx(0.06) and n.events == events


def test_a_run_goes_on_where_it_ended():
    m, n = stein.load(ACTION), stein.load(ACTION)
    m.run(0.06)
    n.run(0.02)
    assert n.run(0.04, restart=False)["time"][0] == 0.02
    assert numpy.allclose(n.q, m.q, rtol=1e-12) and n.time == pytest.approx(m.time)
    assert n.run(0.02)["time"][0] == 0.0


# ---- names and numbers


def test_a_simulation_is_a_mapping_of_its_parameters():
    m = stein.load(PENDULUM)
    assert "rod.mass" in m and "rod.mas" not in m and 3 not in m
    assert len(m) == len(list(m)) == len(dict(m)) == len(m.parameters)
    assert m["rod.mass"] == m.parameters["rod.mass"].value == 0.213
    assert m.parameters["rod.mass"].tolerance == 0.001 and m.parameters["rod.mass"].unit == "kg"
    assert dict(m.items()) == dict(m) and list(m.values()) == list(dict(m).values())
    assert m.get("rod.mass") == 0.213 and m.get("rod.mas", 7) == 7
    m["rod.mass"] = "95 g"
    assert m["rod.mass"] == 0.095
    m["rod.mass"] = numpy.float64(0.1)
    assert m["rod.mass"] == 0.1
    assert m.outputs["angle"] == "rad" and list(m.outputs)[0] == "time"
    assert m.inputs == {"push": "N m"} and m.bodies == ("rod",) and m.name == "pendulum"
    assert m.dt == 1e-3 and "pendulum" in repr(m)


def test_numbers_that_are_a_literal_zero_come_in_by_set():
    file_has_none = "rod.drag"
    m = stein.load(PENDULUM, {file_has_none: 1e-4})
    assert m[file_has_none] == 1e-4


@pytest.mark.parametrize("wrong, error, words", [
    (lambda m: m["rod.mas"], KeyError, "no parameter 'rod.mas', did you mean 'rod.mass'?"),
    (lambda m: m.__setitem__("rod.dampin", 1), stein.UnknownName, "'rod.damping'"),
    (lambda m: m.__setitem__("rod.mass", -1.0), ValueError, "expected a finite number, at least 0"),
    (lambda m: m.__setitem__("rod.mass", "3 mm"), stein.InvalidValue, "the unit is m, expected kg"),
    (lambda m: m.__setitem__("rod.mass", "much"), stein.InvalidValue, "much"),
    (lambda m: m.__setitem__("rod.mass", None), TypeError, "number"),
    (lambda m: m.__delitem__("rod.mass"), TypeError, "cannot be deleted"),
    (lambda m: m[1], TypeError, "name of a parameter"),
    (lambda m: m.read("angel"), KeyError, "no output 'angel', did you mean 'angle'?"),
    (lambda m: m.run(0.1)["angel"], KeyError, "did you mean 'angle'?"),
    (lambda m: m.drive("pull", 1), KeyError, "no input 'pull'"),
    (lambda m: m.drive("push", [1, 2, 3, 4]), ValueError, "two derivatives"),
    (lambda m: m.drive("push", "hard"), TypeError, "not a text"),
    (lambda m: m.position("rod.tap"), KeyError, "did you mean 'rod.tip'?"),
    (lambda m: m.touches("string"), KeyError, "no contact 'string'"),
    (lambda m: m.mass_matrix([1, 2]), ValueError, "q: expected 1 numbers, not 2"),
    (lambda m: m.set_state([float("nan")], [0]), ValueError, "finite"),
    (lambda m: m.run(-1.0), ValueError, "expected"),
    (lambda m: m.run(1.0, release=0.5), ValueError, "no load"),
    (lambda m: m.strike(), ValueError, "names no stroke"),
    (lambda m: m.sweep({"rod.mass": [-1.0]}), ValueError, "rod.mass"),
    (lambda m: m.sweep(mas=[1.0]), KeyError, "no parameter 'mas'"),
    (lambda m: m.sweep(position="1:2:3 kg"), ValueError, "rod.initial.position"),
    (lambda m: m.drive_file("/no/such.csv"), OSError, "/no/such.csv"),
    (lambda m: stein.fit(m, "/no/such.csv", "rod.mass"), OSError, "/no/such.csv"),
    (lambda m: stein.fit(m, "x.csv", "rod.mas"), KeyError, "did you mean 'rod.mass'?"),
    (lambda m: stein.fit(m, "x.csv", "rod.mass", initial="no"), ValueError, "'free', 'fixed'"),
    (lambda m: stein.load("/no/such.yaml"), OSError, "/no/such.yaml"),
    (lambda m: stein.load(PENDULUM, {"rod.mas": 1}), ValueError, "rod.mass"),
    (lambda m: stein.load(PENDULUM, integrator="euler"), ValueError, "'rk4', 'dp5'"),
    (lambda m: stein.load(PENDULUM, dt=-1), ValueError, "dt"),
])
def test_what_is_wrong_is_told(wrong, error, words):
    with pytest.raises(error, match=None) as caught:
        wrong(stein.load(PENDULUM))
    assert words in str(caught.value)


def test_problems_of_a_file_have_their_places(tmp_path):
    file = tmp_path / "bad.yaml"
    file.write_text("mechanism: bad\nbodies:\n  rod: {joint: R -y, mass: 3 mm}\n  bar: {joint: Q}\n")
    with pytest.raises(stein.ParseError) as caught:
        stein.load(file)
    error = caught.value
    assert (error.file, error.line) == (str(file), 3) and error.column > 1
    assert error.code == "EPARSE" and len(error.problems) >= 2
    assert "expected kg" in str(error) and f"{file}:4:" in str(error)
    again = pickle.loads(pickle.dumps(error))
    assert str(again) == str(error) and again.line == 3


def test_a_motion_that_fails_is_an_arithmetic_error():
    m = stein.load(PENDULUM)
    m.drive("push", float("nan"))
    with pytest.raises(stein.NumericalError) as caught:
        m.step(10)
    assert caught.value.code == "ENONFINITE" and isinstance(caught.value, ArithmeticError)


def test_a_step_that_is_too_long_is_warned_of():
    m = stein.load(PENDULUM.replace("pendulum", "bouncing_ball"), dt=1e-3)
    assert m.dt == 1e-3
    with pytest.warns(RuntimeWarning, match='the step of 0.001 s is too long.*contact "floor"'):
        m.run(1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        stein.load(PENDULUM).run(1.0)


# ---- memory


def test_columns_are_views_that_outlive_their_run():
    m = stein.load(PENDULUM)
    run = m.run(0.5, every=0)
    angle, rate = run["angle"], run["rate"]
    assert isinstance(angle, numpy.ndarray) and angle.dtype == float and len(angle) == 501
    assert angle.strides == (8 * len(m.outputs),)
    there, later = angle.__array_interface__["data"][0], rate.__array_interface__["data"][0]
    assert later - there == 8  # side by side: nothing was copied
    with pytest.raises(ValueError):
        angle[0] = 1.0
    kept = angle.copy()
    del run, m
    gc.collect()
    assert numpy.array_equal(angle, kept)


def test_without_numpy_columns_are_memoryviews():
    assert python(
        "import sys; sys.modules['numpy'] = None\n"
        f"import stein; m = stein.load({PENDULUM!r}); a = m.run(0.2, every=0)['angle']\n"
        "assert 'numpy.core' not in sys.modules\n"
        "M = m.mass_matrix(); assert M.shape == (1, 1) and M[0, 0] > 0\n"
        "print(type(a).__name__, a.format, len(a), a.readonly, a[200] == m.read('angle'))\n"
    ) == "memoryview d 201 True True\n"


def test_a_table_of_pandas():
    pandas = pytest.importorskip("pandas")
    run = stein.load(PENDULUM).run(0.5)
    frame = run.to_pandas()
    assert isinstance(frame, pandas.DataFrame) and frame.attrs["units"]["angle"] == "rad"
    assert list(frame) == list(run) and (frame["angle"].to_numpy() == run["angle"]).all()


# ---- copies


def half_way():
    m = stein.load(ACTION, {"load.mass": "80 g"}, dt=2e-5, integrator="rk4")
    m["pawl.stop_shift"] = -0.2e-3
    m.reset()
    m.step(3000)
    return m


@pytest.mark.parametrize("duplicate", [
    copy.copy, copy.deepcopy, lambda m: m.copy(), lambda m: pickle.loads(pickle.dumps(m))])
def test_a_copy_goes_on_by_itself_to_the_same_bits(duplicate):
    m = half_way()
    n = duplicate(m)
    assert dict(n) == dict(m) and n.state == m.state
    n.step(3000)
    assert n.state != m.state
    m.step(3000)
    assert n.state == m.state and m.read("hammer_height") == n.read("hammer_height")
    n["pawl.stop_shift"] = 0.0
    assert m["pawl.stop_shift"] == -0.2e-3


def test_a_pickle_goes_on_in_another_process(tmp_path):
    m = half_way()
    (tmp_path / "kept").write_bytes(pickle.dumps(m))
    told = python(f"import pickle; m = pickle.load(open({str(tmp_path / 'kept')!r}, 'rb'))\n"
                  "m.step(2000); print(m.state.hex())")
    m.step(2000)
    assert told.strip() == m.state.hex()


def test_a_copy_needs_no_file(tmp_path):
    file = tmp_path / "mine.yaml"
    with open(PENDULUM, encoding="utf-8") as f:
        file.write_text(f.read())
    m = stein.load(file)
    m.step(100)
    file.unlink()
    n = m.copy()
    n.step(100)
    assert n.time == pytest.approx(0.2)
    with pytest.raises(stein.FileError, match="mine.yaml"):
        pickle.loads(pickle.dumps(m))


def test_a_stroke_is_pickled_with_its_run():
    stroke = stein.load(ACTION).strike(0.06)
    again = pickle.loads(pickle.dumps(stroke))
    assert again[:-1] == stroke[:-1] and again.run.events == stroke.run.events
    for name in stroke.run:
        assert numpy.array_equal(again.run[name], stroke.run[name])
    third = pickle.loads(pickle.dumps(again))
    assert numpy.array_equal(third.run["time"], stroke.run["time"])


def test_drives_are_copied(tmp_path):
    path = tmp_path / "push.csv"
    path.write_text("time [s],push [N m]\n0,0\n0.1,0.02\n0.2,-0.01\n0.3,0\n")
    for drive in (lambda m: m.drive_file(path), lambda m: m.drive("push", 0.01)):
        m = stein.load(PENDULUM)
        drive(m)
        m.step(50)
        n, k = m.copy(), pickle.loads(pickle.dumps(m))
        for x in (m, n, k):
            x.step(200)
        assert m.state == n.state == k.state
    m.drive("push", None)
    assert m.copy().read("angle") == m.read("angle")


def test_a_state_of_another_mechanism_is_refused():
    m = stein.load(PENDULUM)
    with pytest.raises(stein.InvalidValue, match="another model|bytes"):
        m.state = stein.load(ACTION).state
    with pytest.raises(stein.InvalidValue, match="cut off"):
        m.state = b"short"
    kept = m.state
    m.step(10)
    m.state = kept
    assert m.time == 0.0


# ---- drives


def test_inputs_are_held_or_asked():
    m, n = stein.load(PENDULUM), stein.load(PENDULUM)
    m.drive("push", 0.3)
    n.drive("push", lambda t: (0.3, 0.0))
    assert numpy.array_equal(m.run(0.5)["angle"], n.run(0.5)["angle"])
    free = stein.load(PENDULUM).run(0.5)["angle"]
    assert not numpy.array_equal(free, m.run(0.5)["angle"])
    m.drive("push", None)
    assert numpy.array_equal(free, m.run(0.5)["angle"])


@pytest.mark.parametrize("use", [lambda m: m.run(0.5), lambda m: m.step(), lambda m: m.step(400),
                                 lambda m: m.reset() or m.step(300), lambda m: m.acceleration()])
def test_what_a_signal_raises_is_raised(use):
    m = stein.load(PENDULUM)
    m.drive("push", lambda t: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        use(m)
    m.drive("push", None)
    m.reset()
    m.step()


def test_a_signal_must_not_use_its_simulation():
    m = stein.load(PENDULUM)
    m.drive("push", lambda t: m.read("angle"))
    with pytest.raises(RuntimeError, match="must not use it"):
        m.run(0.1)


def test_a_simulation_that_its_own_signal_holds_is_collected():
    import weakref

    m = stein.load(PENDULUM)
    m.drive("push", lambda t: 0.0 if m is None else 0.1)
    gone = weakref.ref(m)
    del m
    gc.collect()
    assert gone() is None


# ---- equations


def test_the_equations_agree_with_each_other():
    m = stein.load(ACTION)
    q, qd, qdd = [0.01, -0.02, 0.03, 0.001], [0.3, -1.2, 0.7, 0.1], [11.0, -3.0, 5.0, 1.0]
    M, c = m.mass_matrix(q), m.bias(q, qd)
    assert M.shape == (4, 4) and numpy.array_equal(M, M.T)
    assert numpy.allclose(m.inverse(q, qd, qdd), M @ qdd + c, rtol=1e-12, atol=1e-15)
    assert numpy.array_equal(m.mass_matrix(), m.mass_matrix(m.q))
    h = 1e-6
    J = numpy.array([(m.position("hammer.head", q + h * e) - m.position("hammer.head", q - h * e))
                     / (2 * h) for e in numpy.eye(4)]).T
    assert numpy.allclose(m.jacobian("hammer.head", q), J, atol=1e-8)
    assert numpy.allclose(m.velocity("hammer.head", q, qd), J @ qd, atol=1e-7)
    m.step(500)
    assert numpy.array_equal(m.acceleration(), m.qdd)
    assert numpy.array_equal(m.acceleration(m.q, m.qd), m.qdd)


def test_derivatives_are_those_of_the_acceleration():
    m, h = stein.load(ACTION), 1e-7
    m.step(700)
    by_q, by_qd, by = m.derivatives("hammer.mass", "pawl.spring.k")
    qdd, q, qd = m.acceleration(), m.q, m.qd
    for e, row, by_state in ((numpy.eye(4), 0, by_q), (numpy.eye(4), 1, by_qd)):
        for k in range(4):
            state = [[q + h * e[k], qd], [q, qd + h * e[k]]][row]
            back = [[q - h * e[k], qd], [q, qd - h * e[k]]][row]
            slope = (m.acceleration(*state) - m.acceleration(*back)) / (2 * h)
            assert numpy.allclose(by_state[:, k], slope, rtol=1e-4, atol=1e-3 * abs(by_state).max())
    for name, column in by.items():
        more, less, step = m.copy(), m.copy(), 1e-5 * m[name]
        more[name] += step
        less[name] -= step
        slope = (more.acceleration(q, qd) - less.acceleration(q, qd)) / (2 * step)
        assert numpy.allclose(column, slope, rtol=1e-4, atol=1e-6 * abs(slope).max())
    assert numpy.array_equal(m.acceleration(), qdd)
    with pytest.raises(stein.UnknownName, match="hammer.mass"):
        m.derivatives("hammer.mas")


def test_energy_is_kept_without_damping():
    m = stein.load(PENDULUM, {"rod.damping": 0})
    before = sum(m.energy())
    m.step(1000)
    assert m.energy()[0] > 0 and sum(m.energy()) == pytest.approx(before, rel=1e-9)


def test_a_state_of_ones_own():
    m = stein.load(PENDULUM)
    m.set_state([0.7], [-0.1], 2.5)
    assert m.q[0] == 0.7 and m.qd[0] == -0.1 and m.time == 2.5
    m.set_state(qd=[0.0])
    assert m.q[0] == 0.7
    m.settle()
    assert abs(m.q[0]) < 1e-9
