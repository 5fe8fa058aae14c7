# SPDX-License-Identifier: GPL-3.0-or-later
# %% [markdown]
# # A machine axis
#
# A carriage on a ball screw: its measured position prescribes the motion, and the force that this
# needs is compared with the measured one. The mechanism file contains only a mass of 95.1 kg, as
# for the benchmark EMPS (Janot, Gautier & Brunot 2019). What does it lack?

# %%
import os

import numpy as np
import stein

models = os.environ.get("STEIN_MODELS", "models")
axis = stein.load(f"{models}/emps.yaml")
print(axis.inputs, axis.outputs)

# %% [markdown]
# Three runs to and fro, "measured" at 250 Hz, written as CSV files: with viscous and Coulomb friction
# and 1 N of noise. Of the benchmark itself these are its columns `qm` and `gtau vir`, or with scipy
# `stein.Record({"time": d["t"], "slide_motion": d["qm"], "slide_force": 35.15065 * d["vir"]})`.

# %%
noise, files = np.random.default_rng(3), []
for run in range(3):
    t, w = np.arange(0.0, 4.0, 0.004), 2 * np.pi * (0.4 + 0.15 * run)
    s, c = np.sin(w * t), np.cos(w * t)
    x, v, a = 0.1 * s**3, 0.3 * w * s**2 * c, 0.3 * w**2 * (2 * s * c**2 - s**3)
    force = 95.1 * a + 200 * v + 20 * np.tanh(v / 5e-5) + noise.normal(0, 1, len(t))
    files.append(f"axis_{run + 1}.csv")
    np.savetxt(files[-1], np.column_stack([t, x, force]), delimiter=",", comments="",
               header="# noise slide_force: 1 N\ntime [s],slide_motion [m],slide_force [N]")

# %% [markdown]
# From CSV to named causes.

# %%
diagnosis = stein.diagnose(axis, files)
print(diagnosis)
causes = {cause["kind"]: cause["parameters"] for cause in diagnosis.causes}
assert set(causes) == {"viscous_friction", "coulomb_friction"}

# %% [markdown]
# 200 N s/m and 20 N were put in.

# %%
for kind, symbol, true in (("viscous_friction", "b", 200.0), ("coulomb_friction", "T", 20.0)):
    number = causes[kind][symbol]
    print(f"{kind}: {number['lo']:.2f} .. {number['hi']:.2f} {number['unit']}, was {true}")
    assert abs(number["value"] - true) < 0.01 * true

# %% [markdown]
# And the force of a run, before and after.

# %%
runs = {}
for name, model in (("mass alone", axis), ("with both causes", diagnosis.extended)):
    model.drive_file(files[2])
    runs[name] = need = model.run(3.9, every=0.004)
    error = need["slide_force"] - np.interp(need["time"], t, force)
    print(f"{name}: {np.sqrt(np.mean(error**2)):.2f} N off")
assert np.median(np.abs(error)) < 1.0

# %%
try:
    import matplotlib.pyplot as plt
except ImportError:
    print("no picture: matplotlib is not installed")
else:
    figure, axes = plt.subplots(figsize=(8, 4), layout="constrained")
    axes.plot(t, force, color="0.7", linewidth=3, label="measured")
    for name, need in runs.items():
        axes.plot(need["time"], need["slide_force"], linewidth=1, label=name)
    axes.set(xlabel="time [s]", ylabel="force [N]", ylim=(-700, 850), title="What the measured motion needs")
    axes.legend(loc="upper center", ncols=3)
    figure.savefig("axis.png", dpi=120)
