# SPDX-License-Identifier: GPL-3.0-or-later
# %% [markdown]
# # Regulate an action
#
# The stop of the pawl decides when the hammer of the action of 1788 escapes: too early, and it is
# slow; too late, and it blocks against the string. Where has the stop to be for an escapement 5 mm
# below the string, and what does that do to the blow?

# %%
import os

import numpy as np
import stein

models = os.environ.get("STEIN_MODELS", "models")
action = stein.load(f"{models}/stein1788.yaml")
print(action)

# %% [markdown]
# One stroke with the file's numbers: its results, and the head's way to the string.

# %%
stroke = action.strike()
run = stroke.run
print(f"{stroke.outcome}: escapes {1e3 * stroke.escapement_height:.2f} mm below the string, "
      f"strikes it with {stroke.impact_speed:.3f} m/s after {1e3 * stroke.impact_time:.1f} ms")
print([f"{1e3 * e.time:.1f} ms {e.kind} {e.at}" for e in run.events if e.kind != "phase"][:6])

# %% [markdown]
# A sweep over the stop, on all processors; `stop_shift` is `pawl.stop_shift` for short.

# %%
table = action.sweep(stop_shift=np.linspace(-1.2e-3, 0.2e-3, 29))
struck = np.array(table["outcome"]) == "struck"
shift, height = table["pawl.stop_shift"][struck], table["escapement_height"][struck]
print(f"{struck.sum()} of {len(struck)} positions strike, escapement from {1e3 * height.max():.2f} "
      f"to {1e3 * height.min():.2f} mm below the string")

# %% [markdown]
# Between two positions the height is nearly straight: interpolate, set, strike once more.

# %%
wanted = 5e-3
order = np.argsort(height)
action["pawl.stop_shift"] = np.interp(wanted, height[order], shift[order])
regulated = action.strike()
print(f"stop at {1e3 * action['pawl.stop_shift']:.3f} mm: escapes "
      f"{1e3 * regulated.escapement_height:.3f} mm below, {regulated.impact_speed:.3f} m/s "
      f"instead of {stroke.impact_speed:.3f} m/s")
assert abs(regulated.escapement_height - wanted) < 0.05e-3

# %% [markdown]
# The same with one number that a hand cannot turn: where the mass of the load matters.

# %%
for grams in (60, 80, 100):
    action["load.mass"] = f"{grams} g"
    print(f"{grams} g: {action.strike().outcome}, {action.strike().impact_speed:.3f} m/s")

# %%
try:
    import matplotlib.pyplot as plt
except ImportError:
    print("no picture: matplotlib is not installed")
else:
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    left.plot(1e3 * shift, 1e3 * height, "o-", label="strokes of the sweep")
    left.plot(1e3 * np.interp(wanted, height[order], shift[order]), 1e3 * wanted, "r*", markersize=14,
              label="wanted")
    left.set(xlabel="displacement of the stop [mm]", ylabel="escapement below the string [mm]")
    left.legend()
    for name, one in (("as the file has it", stroke), ("regulated", regulated)):
        right.plot(1e3 * one.run["time"], 1e3 * one.run["string_distance"], label=name)
    right.set(xlabel="time [ms]", ylabel="head to string [mm]")
    right.legend()
    figure.savefig("regulate.png", dpi=120)
