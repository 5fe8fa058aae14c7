# SPDX-License-Identifier: GPL-3.0-or-later
"""What a step costs through Python: step(), one call a step, beside step(n), one call for all."""
import os
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
