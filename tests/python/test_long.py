# SPDX-License-Identifier: GPL-3.0-or-later
"""Long work: Control-C, progress, threads, memory."""
import os
import threading
import time

import pytest
import stein
from conftest import ACTION, PENDULUM, interrupted, python


@pytest.mark.parametrize("work", [
    lambda m: m.run(1e6),
    lambda m: m.run(1e6, every=0.1),
    lambda m: m.step(10**9),
    lambda m: m.sweep({"rod.initial.position": "1:80:10000 deg"}, until=500),
])
def test_control_c_ends_work_that_would_take_hours(work):
    m = stein.load(PENDULUM)
    assert interrupted(lambda: work(m)) < 5.0
    m.reset()
    m.run(0.1)


def test_control_c_ends_a_fit_and_a_diagnosis(swings):
    m = stein.load(PENDULUM)
    names = [n for n in m if n.startswith("rod.") and n != "rod.initial.position"][:4]
    assert interrupted(lambda: [stein.fit(m, swings, names) for _ in range(100)]) < 5.0
    assert interrupted(lambda: [stein.diagnose(m, swings) for _ in range(100)]) < 5.0
    assert stein.diagnose(m, swings).verdict == "missing_effect"


def test_progress_is_told_to_the_thread_that_asked():
    m = stein.load(PENDULUM)
    told = []
    m.sweep({"rod.initial.position": "1:80:3000 deg"}, until=1,
            progress=lambda f, s: told.append((f, s, threading.get_ident())))
    assert len(told) > 1 and {t[2] for t in told} == {threading.get_ident()}
    assert all(a[0] <= b[0] for a, b in zip(told, told[1:])) and 0 <= told[0][0] and told[-1][0] == 1


def test_a_line_of_progress_is_for_what_takes_longer_than_a_second(capsys):
    m = stein.load(PENDULUM)
    m.run(1.0, progress=True)
    assert capsys.readouterr().err == ""
    m.run(6e3, every=1.0, progress=True)  # six million steps
    told = capsys.readouterr().err
    assert "pendulum [##############################] 100 %" in told and told.endswith("\n")


def test_a_notebook_has_a_bar():
    told = python("""
import importlib.util, sys
if importlib.util.find_spec("IPython") is None:
    sys.exit()
from IPython.core.displaypub import CapturingDisplayPublisher
from IPython.core.interactiveshell import InteractiveShell
shell = InteractiveShell.instance()
shell.kernel, shell.display_pub = object(), CapturingDisplayPublisher()
import stein
stein.load(sys.argv[1]).run(6e3, every=1.0, progress=True)
shown = shell.display_pub.outputs
assert len({o["transient"]["display_id"] for o in shown}) == 1 and not shown[0].get("update")
print(shown[-1]["update"], shown[-1]["data"]["text/html"])
""", PENDULUM)
    assert told == "" or "True pendulum <progress max='1' value='1.000'></progress> 100 %" in told


def test_what_progress_raises_ends_the_work():
    def refuse(fraction, step):
        raise LookupError(step)

    with pytest.raises(LookupError, match="pendulum"):
        stein.load(PENDULUM).run(1e6, progress=refuse)
    with pytest.raises(LookupError):
        stein.load(PENDULUM).sweep({"rod.initial.position": "1:80:10000 deg"}, progress=refuse)


def test_other_threads_go_on_while_a_simulation_runs():
    m, counted, over = stein.load(ACTION), [0], threading.Event()

    def count():
        while not over.is_set():
            counted[0] += 1
            time.sleep(1e-4)

    other = threading.Thread(target=count)
    other.start()
    begin = counted[0]
    m.run(0.5)
    during = counted[0] - begin
    over.set()
    other.join()
    assert during > 10


def test_threads_take_turns_with_one_simulation():
    m, alone = stein.load(PENDULUM), stein.load(PENDULUM)
    threads = [threading.Thread(target=lambda: [m.step(100) for _ in range(50)]) for _ in range(4)]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    alone.step(20000)
    assert m.state == alone.state


def test_two_simulations_run_side_by_side_to_the_same_bits():
    one = stein.load(ACTION)
    several = [one.copy() for _ in range(4)]
    threads = [threading.Thread(target=s.run, args=(0.1,)) for s in several]
    for t in threads:
        t.start()
    one.run(0.1)
    for t in threads:
        t.join()
    assert {s.state for s in several} == {one.state}


def resident():
    with open("/proc/self/statm", encoding="ascii") as f:
        return int(f.read().split()[1]) * os.sysconf("SC_PAGESIZE")


@pytest.mark.parametrize("times, work", [
    (80000 if "SOAK" in os.environ else 8000, lambda m: m.copy().run(0.002, every=0)["angle"].sum()),
    (2000, lambda m: m.sensitivities("rod.mass", 0.01).q),
    (2000, lambda m: m.on_force(lambda t, q, qd: [0.0]) or m.step(2)),
    (2000, lambda m: m.sympy("Q")),
    (2000, lambda m: stein.load(PENDULUM).mass_matrix()),
    (2000, lambda m: m.drive("push", lambda t: 0.0) or m.step(2)),
    (2000, lambda m: pytest.raises(stein.Error, m.run, -1.0)),
    (2000, lambda m: pytest.raises(KeyError, m.read, "angel")),
    (200, lambda m: m.sweep({"rod.initial.position": [0.1, 0.2]}, until=0.01)["angle"]),
])
def test_nothing_is_left_behind(times, work):
    m, grown = stein.load(PENDULUM), []
    for _ in range(5):  # an allocator grows by steps now and then, a leak every time
        before = resident()
        for _ in range(times // 4):
            work(m)
        grown.append(resident() - before)
    assert min(grown) < 16 * (times // 4)
