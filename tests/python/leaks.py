# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulations made, run and dropped as often as is asked for: sanitize.sh counts the blocks left."""
import gc
import sys

import stein

m = stein.load("models/pendulum.yaml")
for i in range(int(sys.argv[1])):
    s = m.copy()
    s.run(0.002, every=0)["angle"]
    if i % 100 == 0:
        s.sensitivities("rod.mass", 0.002)
        s.on_force(lambda t, q, qd: [0.0])
        s.drive("push", lambda t: 0.1)
        s.step(2)
        m.sympy("M")
        s.sweep({"rod.mass": [0.1, 0.2]}, until=0.002, threads=1)
        stein.load("models/pendulum.yaml")
        try:
            m["rod.mas"]
        except KeyError:
            pass
    del s
gc.collect()
