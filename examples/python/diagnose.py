# SPDX-License-Identifier: GPL-3.0-or-later
# %% [markdown]
# # Diagnose a pendulum
#
# Six swings of a pendulum are measured, each let go from further out. The mechanism file contains a
# viscous damping; the swings have a drag with the square of the speed. Which effect does the
# simulation lack?

# %%
import os

import numpy as np
import stein

models = os.environ.get("STEIN_MODELS", "models")
pendulum = stein.load(f"{models}/pendulum.yaml")

# %% [markdown]
# The "measurements": a pendulum with drag, seen by a camera at 100 Hz with 1 mrad of noise. Yours
# are `records = ["swing_1.csv", ...]`, DataFrames, or arrays in a `stein.Record`.

# %%
truth = stein.load(f"{models}/pendulum.yaml", {"rod.drag": "2e-3 N m s^2/rad^2"})
noise, records = np.random.default_rng(1), []
for degrees in range(12, 60, 8):
    truth["rod.initial.position"] = f"{degrees} deg"
    run = truth.run(6.0, every=0.01)
    records.append(stein.Record(
        {"time": run["time"], "angle": run["angle"] + noise.normal(0, 1e-3, len(run["time"]))},
        f"swing from {degrees} deg", set={"rod.initial.position": f"{degrees} deg"},
        noise={"angle": "1 mrad"}))

# %% [markdown]
# More damping alone does not explain them: the best fit is a misfit.

# %%
import warnings

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # that it is one, which is asked for here
    fit = stein.fit(pendulum, records, "rod.damping")
print(fit, f"\nchi2/dof {fit.chi2_dof:.4g}")
assert fit.status == "misfit"

# %% [markdown]
# The cause, its size with an interval, its rivals. A notebook shows the report here.

# %%
diagnosis = stein.diagnose(pendulum, records)
print(diagnosis)
print("candidates that would have been seen and are not there:",
      sum(row["presence"] == "absent" for row in diagnosis.table))
assert [cause["kind"] for cause in diagnosis.causes] == ["quadratic_drag"]
diagnosis

# %% [markdown]
# The mechanism with the cause in it predicts a swing that was not measured.

# %%
better = diagnosis.extended
for model in (truth, better, pendulum):
    model["rod.initial.position"] = "75 deg"
runs = [model.run(6.0) for model in (truth, better, pendulum)]
ends = [run["angle"][-1] for run in runs]
print("after 6 s: %.4f rad, predicted %.4f rad, without the cause %.4f rad" % tuple(ends))
assert abs(ends[1] - ends[0]) < 0.05 * abs(ends[2] - ends[0])

# %%
try:
    import matplotlib.pyplot as plt
except ImportError:
    print("no picture: matplotlib is not installed")
else:
    figure, axes = plt.subplots(figsize=(8, 4), layout="constrained")
    for run, name, style in zip(runs, ("what happens", "predicted", "without the cause"), ("-", "--", ":")):
        axes.plot(run["time"], np.degrees(run["angle"]), style, linewidth=2, label=name)
    axes.set(xlabel="time [s]", ylabel="angle [deg]", ylim=(-80, 110), title="A swing that nobody has measured")
    axes.legend(loc="upper center", ncols=3)
    figure.savefig("diagnose.png", dpi=120)
