# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests of `import stein` share. They run from the checkout's root: test_python.sh."""
import json
import os
import signal
import subprocess
import sys
import threading
import time

import pytest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
BUILD = os.path.join(ROOT, os.environ.get("STEIN_BUILD", "build"))
sys.path.insert(0, os.path.join(BUILD, "python"))
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

PENDULUM = os.path.join(ROOT, "models", "pendulum.yaml")
ACTION = os.path.join(ROOT, "models", "stein1788.yaml")


def command(*words, code=0):
    """Standard output of the program `stein`."""
    done = subprocess.run([os.path.join(BUILD, "stein"), *map(str, words)], capture_output=True,
                          text=True, check=False)
    assert done.returncode == code, done.stderr
    return done.stdout


def python(text, *words, **environment):
    """Standard output of a separate Python process."""
    done = subprocess.run([sys.executable, "-c", text, *words], capture_output=True, text=True, check=False,
                          env={**os.environ, "PYTHONPATH": os.path.join(BUILD, "python"),
                               **environment})
    assert done.returncode == 0, done.stderr
    return done.stdout


def plain(value):
    """A value as JSON has it."""
    return json.loads(json.dumps(value))


def interrupted(work):
    """Seconds from Control-C until it is raised."""
    pressed = []

    def press():
        pressed.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.4, press)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        work()
    raised = time.monotonic()
    timer.join()
    return raised - pressed[0]


@pytest.fixture
def swings():
    """Six swings of a pendulum with quadratic drag, which models/pendulum.yaml lacks."""
    import numpy
    import stein

    truth = stein.load(PENDULUM, {"rod.drag": "2e-3 N m s^2/rad^2"})
    noise, records = numpy.random.default_rng(1), []
    for i in range(6):
        start = f"{12 + 8 * i} deg"
        truth["rod.initial.position"] = start
        run = truth.run(6.0, every=0.01)
        angle = run["angle"] + noise.normal(0.0, 1e-3, len(run["angle"]))
        records.append(stein.Record({"time": run["time"], "angle": angle}, f"swing {i + 1}",
                                    set={"rod.initial.position": start}, noise={"angle": 1e-3}))
    return records


@pytest.fixture
def files(swings, tmp_path):
    """The same as CSV files."""
    import stein

    model = stein.load(PENDULUM)
    paths = []
    for i, record in enumerate(swings):
        paths.append(tmp_path / f"swing_{i + 1}.csv")
        paths[-1].write_text(record.text({**model.outputs, **model.inputs}))
    return paths
