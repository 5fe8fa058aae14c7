# SPDX-License-Identifier: GPL-3.0-or-later
"""Costs of Python: a step by step(), one call a step, beside step(n), one call for all; a sweep
beside `stein sweep`; two simulations in two threads beside one after the other. Works that are compared
take turns; the least time and the best ratio are printed."""
import os
import resource
import subprocess
import tempfile
import threading
import time

import stein

STEPS, ROUNDS = 5000, 40


def together(model):
    model.step(STEPS)


def one_by_one(model):
    step = model.step
    for _ in range(STEPS):
        step()


def with_output(model):
    step, read = model.step, model.read
    for _ in range(STEPS):
        step()
        read("time")


def seconds(model, *works):
    """Of a step of each, the least of several rounds in turn."""
    best = [float("inf")] * len(works)
    for _ in range(ROUNDS):
        for i, work in enumerate(works):
            model.reset()
            begin = time.perf_counter()
            work(model)
            best[i] = min(best[i], (time.perf_counter() - begin) / STEPS)
    return best


for name in ("pendulum", "stein1788"):
    m = stein.load(os.path.join("models", f"{name}.yaml"))
    alone, each, read = seconds(m, together, one_by_one, with_output)
    print(f"python: {name}: a step {1e6 * alone:.2f} us in C, {1e6 * each:.2f} us by step(): "
          f"{1e6 * (each - alone):.2f} us more, {each / alone:.2f} times; "
          f"and {1e6 * (read - each):.2f} us to read an output")


def spent(who):
    used = resource.getrusage(who)
    return used.ru_utime + used.ru_stime


def sweeps(points, rounds=3):
    """Seconds of processor time of a sweep here and by the command."""
    m, own, commands = stein.load("models/stein1788.yaml"), [], []
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(rounds):
            begin = spent(resource.RUSAGE_SELF)
            m.sweep({"pawl.stop_shift": f"-1.2:0:{points} mm"})
            own.append(spent(resource.RUSAGE_SELF) - begin)
            begin = spent(resource.RUSAGE_CHILDREN)
            subprocess.run(["build/stein", "sweep", "models/stein1788.yaml", "--vary",
                            f"pawl.stop_shift=-1.2:0:{points}mm", "-o", f"{folder}/sweep.csv"],
                           check=True, capture_output=True)
            commands.append(spent(resource.RUSAGE_CHILDREN) - begin)
    return min(own), min(commands)


def alone(work):
    """Seconds that a thread would take on a free processor: what it computed, and what it waited
    for others of its process; not what it waited for a processor."""
    path = f"/proc/self/task/{threading.get_native_id()}/schedstat"

    def queued():
        with open(path, encoding="ascii") as f:
            return 1e-9 * int(f.read().split()[1])

    begin, waited = time.perf_counter(), queued()
    work()
    return time.perf_counter() - begin - (queued() - waited)


def threads(rounds=15):
    """How many times faster two simulations are in two threads than one after the other."""
    both = [stein.load("models/stein1788.yaml") for _ in range(2)]
    one_by_one, together = [], []
    for _ in range(rounds):
        one_by_one.append(sum(alone(lambda m=m: m.run(2.0)) for m in both))
        took = []
        crew = [threading.Thread(target=lambda m=m: took.append(alone(lambda: m.run(2.0))))
                for m in both]
        for t in crew:
            t.start()
        for t in crew:
            t.join()
        together.append(max(took))
    return min(one_by_one) / min(together)


here, command = sweeps(1000)
print(f"python: a sweep of 1000 strokes: {here:.2f} s of processor time, {command:.2f} s by stein sweep: "
      f"{100 * (here / command - 1):+.1f} %")
print(f"python: two simulations in two threads: {threads():.2f} times as fast as one after the "
      "other (without the time that processors were busy with other work)")
