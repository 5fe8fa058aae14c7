# SPDX-License-Identifier: GPL-3.0-or-later
"""What the equations of a simulation give: derivatives, sensitivities, a linear system."""
from typing import NamedTuple


class Derivatives(NamedTuple):
    """Of qdd: row i of by_q is that of qdd[i] by every q."""

    by_q: object
    by_qd: object
    by: dict


class Sensitivities(NamedTuple):
    """How a run changes with parameters: q[name] and qd[name] [samples, nq], a unit of the coordinate a
    unit of the parameter, at the times of `run`."""

    q: dict
    qd: dict
    run: object


class Mode(NamedTuple):
    """An eigenvalue of A [1/s], or one of a conjugate pair, with what it means."""

    kind: str  # "oscillates", "decays", "grows", "neutral"
    eigenvalue: complex
    frequency: float  # |eigenvalue| / 2 pi [Hz], 0 where nothing oscillates
    damping: float  # ratio, 1 is critical
    joint: str  # with the largest share of the kinetic energy
    share: float
    shape: tuple  # complex, of each free coordinate, the largest 1


class Linear(NamedTuple):
    """dx/dt = A x + B u, y = C x + D u: deviations from a state, x the coordinates, then their speeds.

    The last `len(coordinates) - free` coordinates have a prescribed motion; their inputs are
    accelerations. dq = T dz, z the coordinates. scipy.signal.StateSpace(l.A, l.B, l.C, l.D) reads
    it."""

    A: object
    B: object
    C: object
    D: object
    T: object
    mass: object
    coordinates: tuple
    free: int
    states: dict  # name: unit, in the order of A
    inputs: dict
    outputs: dict
    inexact: tuple  # outputs with a row of C by differences
    modes: tuple
    edges: tuple  # (kind, name, how far apart) of contacts and stops that just touch
    exact: bool  # A is by exact derivatives
    why: object  # why not, or None
    error: float  # estimate of that of A, 0 where exact
    residual: float  # largest acceleration at the state

    def __repr__(self):
        way = "exact" if self.exact else f"differences: {self.why}"
        return f"<Linear {', '.join(self.coordinates)} ({way})>"


def linear(found):
    """Of what the library found, a dict."""
    outputs = found["outputs"]
    return Linear(**{**found,
                     "coordinates": tuple(found["coordinates"]),
                     "states": dict(found["states"]),
                     "inputs": dict(found["inputs"]),
                     "outputs": {name: unit for name, unit, _ in outputs},
                     "modes": tuple(Mode(*m[:6], tuple(m[6])) for m in found["modes"]),
                     "edges": tuple(found["edges"])},
                  inexact=tuple(name for name, _, exact in outputs if not exact))
