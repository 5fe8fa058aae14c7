# SPDX-License-Identifier: GPL-3.0-or-later
"""libstein: simulate mechanisms with contacts, fit and diagnose them with measured records.

    m = stein.load("stein1788.yaml")
    m["pawl.stop_shift"] = "-0.3 mm"            # or -0.3e-3, SI
    m.run(0.12)["string_distance"]              # a view of numpy, nothing is copied
    m.strike().impact_speed
    m.sweep({"pawl.stop_shift": "-1.2:0:13 mm"})
    stein.diagnose(m, ["run_1.csv", "run_2.csv"])

Quantities are SI; names come from the mechanism file. A simulation belongs to one thread at a time
(it has a lock); different ones run side by side.
"""
import csv
import html
import json
import math
import os
import shutil
import tempfile
import warnings
import weakref
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from . import _stein
from ._equations import Derivatives, Linear, Mode, Sensitivities, linear as _linear
from ._records import Record, named_texts
from ._progress import told as _told
from ._support import (Error, EquationsError, Event, FileError, InvalidValue, NumericalError,
                       ParseError, UnknownName, unknown, view)

__version__ = _stein.version
__all__ = ["load", "fit", "diagnose", "plan", "Simulation", "Record", "Run", "Stroke", "Sweep", "Fit",
           "Diagnosis", "Plan", "Event", "Parameter", "Derivatives", "Sensitivities", "Linear", "Mode",
           "Table", "Error", "UnknownName", "InvalidValue", "ParseError", "FileError",
           "EquationsError", "NumericalError"]
_nan = math.nan


def load(file, set=None, *, dt=None, integrator=None):
    """A simulation of a mechanism file in its initial state.

    set: numbers of the file to override, {"pawl.stop_shift": "-0.3 mm"}; a number that is a literal
    0 in the file comes into the equations by it. dt [s] and integrator, "rk4", "dp5", "controlled" or
    "implicit": simulation settings, if they differ from the file's.
    """
    return Simulation(file, set, dt=dt, integrator=integrator)


class Parameter(NamedTuple):
    """A number of a mechanism file: SI unit, value, standard deviation that the file states."""

    name: str
    unit: str
    value: float
    tolerance: float


class Simulation(_stein.Simulation):
    """A mechanism, its parameters and its state: a mapping of parameters to numbers."""

    def __new__(cls, file, set=None, *, dt=None, integrator=None):
        sets = {name: _written(value) for name, value in (set or {}).items()}
        how = _or_nan(dt), _choice("integrator", integrator, {None: -1, "rk4": 0, "dp5": 1, "controlled": 2, "implicit": 3})
        model = _stein.open(os.path.abspath(file), [f"{n}={v}" for n, v in sets.items()])
        return cls._begun(model, os.path.abspath(file), sets, how)

    @classmethod
    def _begun(cls, model, file, sets, how):
        self = _stein.start(cls, model, *how)
        self.file, self._set, self._how = file, sets, how  # how: step and integrator
        self._inputs, self._drive_path, self._force = {}, None, None
        return self

    def __repr__(self):
        return f"<stein.Simulation {self.name}: {len(self.bodies)} bodies, t = {self.time:g} s>"

    # ---- what there is

    @property
    def name(self):
        """Name of the mechanism."""
        return self._model.facts()[0]

    @property
    def parameters(self):
        """The numbers of the file, {name: Parameter}."""
        return {p[0]: Parameter(*p) for p in self._model.parameters()}

    @property
    def outputs(self):
        """Outputs and their units, in the order of a run."""
        return self._model.outputs()

    @property
    def inputs(self):
        """Inputs and their units."""
        return self._model.inputs()

    @property
    def bodies(self):
        """Names of the bodies, in the order of q."""
        return tuple(self._model.bodies())

    def keys(self):
        """Names of the parameters."""
        return self.parameters.keys()

    def __iter__(self):
        return iter(self.parameters)

    get, items, values = Mapping.get, Mapping.items, Mapping.values

    # ---- runs

    def run(self, until=None, every=None, *, release=None, restart=True, progress=None):
        """One motion of `until` seconds, recorded, as `stein simulate` runs it.

        every: interval of the samples [s], rounded up to whole steps; 0: every step; None: 3000
        rows. release: the load is lifted then. restart=False goes on from the present state.
        """
        record, events, _, warning, _ = self._run(
            _or_nan(until), _or_nan(every), _or_nan(release), restart, False, _told(progress), ())
        return Run(record, self.outputs, events, warning)

    def strike(self, until=None, every=None, *, release=None, progress=None):
        """One stroke from rest, judged as `stein strike` judges it."""
        record, events, stroke, warning, _ = self._run(
            _or_nan(until), _or_nan(every), _or_nan(release), True, True, _told(progress), ())
        return Stroke(*stroke, Run(record, self.outputs, events, warning))

    def sensitivities(self, parameters, until=None, every=None, *, progress=None):
        """The derivatives of a run from rest by parameters, through contacts and their events: exact
        to the accuracy of the steps, the initial state included. Not with signals or forces of
        one's own."""
        names = _names(self, parameters)
        record, events, _, warning, slopes = self._run(
            _or_nan(until), _or_nan(every), _nan, True, False, _told(progress), names)
        half = len(names)
        return Sensitivities(dict(zip(names, slopes[:half])), dict(zip(names, slopes[half:])),
                             Run(record, self.outputs, events, warning))

    def drive(self, input, signal):
        """Drive an input from now on: by a number that is held, by (value, rate, acceleration), by
        a function of the time that returns one of these (slow: Python is called at every
        evaluation), or by nothing, None."""
        super().drive(input, signal)
        self._inputs[input] = signal

    def on_force(self, function):
        """Generalised forces of one's own from now on: function(t, q, qd) gives one for every
        coordinate [N m or N], which is added (slow: Python is called at every evaluation); None: no
        more."""
        super().on_force(function)
        self._force = function

    def drive_file(self, path):
        """Drive inputs by the columns of a data file, as `stein simulate --drive` does."""
        self._drive_file(path)
        self._drive_path = os.path.abspath(path)
        self._inputs.clear()

    def sweep(self, vary=None, *, until=None, release=None, threads=None, journal=None,
              progress=None, **short):
        """One stroke (of a mechanism without one: one run) at every combination of values, on all
        processors, as `stein sweep` does it.

        vary: {name: values}, values numbers or a text, "-1.2:0:13 mm". A parameter with a unique
        last word may be given by that word: sweep(stop_shift=numpy.linspace(-1.2e-3, 0, 13)).
        Drives of this simulation are none of the runs'.
        """
        axes = {**(vary or {}), **{self._full(k): v for k, v in short.items()}}
        words = [f"{n}={v if isinstance(v, str) else ','.join(map(_written, v))}"
                 for n, v in axes.items()]
        with tempfile.TemporaryDirectory(prefix="stein-") as folder:
            path = os.path.join(folder, "sweep.csv")
            _stein.sweep(self._present(), words, path, _or_nan(until), _or_nan(release),
                         threads or os.cpu_count(), _path(journal), _told(progress))
            return Sweep(path)

    def _full(self, word):
        found = [n for n in self.parameters if n == word or n.endswith("." + word)]
        if len(found) > 1:
            raise InvalidValue(f"{word} may be {', '.join(found)}: give the whole name", "EINVAL")
        if not found:
            raise unknown("parameter", word, list(self.parameters))
        return found[0]

    # ---- state and equations

    def mass_matrix(self, q=None):
        """M [kg m^2, kg] at q, the present one if None."""
        return self._mass_bias(q, None)[0]

    def bias(self, q=None, qd=None):
        """c of M qdd + c = Q: gravity and gyroscopic forces."""
        return self._mass_bias(q, qd)[1]

    def inverse(self, q=None, qd=None, qdd=None):
        """Inverse dynamics: M qdd + c. None: the present q and qd, qdd = 0."""
        return super().inverse(q, qd, qdd)

    def acceleration(self, q=None, qd=None):
        """qdd with all contacts, laws and inputs, at the present time."""
        return super().acceleration(q, qd)

    def position(self, point, q=None):
        """Where a point is, "hammer.head" [m]."""
        return self._point(point, q, None)[0]

    def velocity(self, point, q=None, qd=None):
        """How it moves [m/s]."""
        return self._point(point, q, qd)[1]

    def jacobian(self, point, q=None):
        """Its velocity by qd, [3, nq]."""
        return self._point(point, q, None)[2]

    def derivatives(self, *parameters):
        """Exact derivatives of qdd in the present state: by q and qd [nq, nq], {name: by it [nq]}."""
        names = _names(self, parameters)
        by_q, by_qd, rows = self._derivatives(names)
        return Derivatives(by_q, by_qd, dict(zip(names, rows)))

    def linearise(self):
        """A, B, C, D, natural frequencies and damping about the present state, an equilibrium: a Linear."""
        return _linear(self._linearise())

    def sympy(self, what="M"):
        """A generated expression as text for sympy.sympify: "M", "c", "Q" (M qdd + c), "T", "V"
        (energies of the tree), or the position of a point. Its symbols are named as in the file,
        'hammer.mass', and 'q.hammer', 'qd.hammer', 'qdd.hammer'."""
        return self._model.expressions(what)

    def set_state(self, q=None, qd=None, time=0.0):
        """Put the mechanism into a state of one's own."""
        self._set_state(q, qd, time)

    @property
    def state(self):
        """Time, positions, speeds, contacts, as bytes that continue to the bit."""
        return self._save()

    @state.setter
    def state(self, block):
        self._restore(block)

    # ---- copies

    def copy(self):
        """An independent simulation with the same parameters, state, drives and forces."""
        other = self._begun(self._model, self.file, self._set, self._how)
        return other._take(*self._own())

    __copy__ = copy

    def __deepcopy__(self, memo):
        return self.copy()

    def __reduce__(self):
        return _unpickled, (type(self), self.file, self._set, self._how, self._own())

    def _own(self):
        return list(self._values()), self.state, self._drive_path, self._inputs, self._force

    def _take(self, values, state, path, inputs, force):
        self._set_values(values)
        if path:
            self.drive_file(path)
        for name, signal in inputs.items():
            self.drive(name, signal)
        if force is not None:
            self.on_force(force)
        self.state = state
        return self

    def _changed(self):
        """Overrides that make the file the present parameters."""
        own = {p[0]: v for p, v in zip(self._model.parameters(), self._values()) if p[2] != v}
        return {**self._set, **{n: _written(v) for n, v in own.items()}}

    def _present(self):
        """The file with the present parameters, as the library reads it."""
        sets = self._changed()
        return self._model if sets == self._set else _stein.open(
            self.file, [f"{n}={v}" for n, v in sets.items()])


def _unpickled(cls, file, sets, how, own):
    model = _stein.open(file, [f"{n}={v}" for n, v in sets.items()])
    return cls._begun(model, file, sets, how)._take(*own)


# ---- tables


class Table(Mapping):
    """Columns by name; `units` has the units of columns of numbers."""

    def __init__(self, units):
        self.units = units

    def __iter__(self):
        return iter(self.units)

    def __len__(self):
        return len(self.units)

    def to_pandas(self):
        """A DataFrame; units in its attrs["units"]."""
        import pandas

        frame = pandas.DataFrame({name: self[name] for name in self})
        frame.attrs["units"] = dict(self.units)
        return frame


class Run(Table):
    """Samples of all outputs: run["angle"], an array of numpy (without numpy a memoryview) over the
    memory of the run. `events` were located between the samples."""

    def __init__(self, record, units, events, warning=None):
        super().__init__(units)
        self._record, self.events = record, events
        self._index = {name: i for i, name in enumerate(units)}
        if warning:
            warnings.warn(warning, RuntimeWarning, stacklevel=3)

    def __getitem__(self, name):
        if name not in self._index:
            raise unknown("output", name, list(self._index))
        return self._record.column(self._index[name])

    def __reduce__(self):
        return Run, (_Kept([memoryview(self[n]).tobytes() for n in self]), self.units, self.events)

    def __repr__(self):
        t = self["time"]
        return f"<stein.Run: {len(t)} samples of {', '.join(self)}, {t[0]:g} to {t[-1]:g} s>"


class _Kept(NamedTuple):
    """The columns of a run that was pickled."""

    columns: list

    def column(self, i):
        return view(memoryview(self.columns[i]).cast("d"))


class Stroke(NamedTuple):
    """What happened in a stroke [SI], nan without the event; `run` has its samples and events."""

    outcome: str
    escapement_time: float
    escapement_height: float
    impact_time: float
    impact_speed: float
    impacts: int
    free_flight: float
    forced_escapement: bool
    peak_string_force: float
    blow: float
    rearmed: bool
    run: Run


class Sweep(Table):
    """The table of `stein sweep`: a row a point; nan without the event. `status` and `outcome` are
    lists of texts."""

    _texts = ("status", "outcome")

    def __init__(self, path):
        with open(path, encoding="utf-8") as f:
            rows = list(csv.reader(line for line in f if not line.startswith("#")))
        titles = [(title + " [").split(" [")[:2] for title in rows[0]]
        super().__init__({name: unit.rstrip("]") for name, unit in titles})
        self._columns = {}
        for (name, _), cells in zip(titles, zip(*rows[1:])):
            self._columns[name] = list(cells) if name in self._texts else view(
                _doubles(float(c) if c else _nan for c in cells))

    def __getitem__(self, name):
        if name not in self._columns:
            raise unknown("column", name, list(self._columns))
        return self._columns[name]

    def __repr__(self):
        return f"<stein.Sweep: {len(self['point'])} points, {', '.join(self)}>"


# ---- fits and diagnoses


class Fit:
    """What `stein fit --json` prints as `data`; `values` {name: value}, `model` a simulation of the
    file with them; `doubts` about records and setup."""

    def __init__(self, data, doubts, model):
        self.data, self.doubts, self.model = data, doubts, model
        self.status, self.reason = data["status"], data["reason"]
        self.values = {p["name"]: p["value"] for p in data["parameters"]}
        self.intervals = {p["name"]: (p["lo"], p["hi"]) for p in data["parameters"]}
        self.chi2_dof = data["chi2_dof"]

    def __repr__(self):
        lines = [f"{p['name']} = {p['value']:.6g} {p['unit']}  (95 %: {p['lo']:.6g} .. {p['hi']:.6g})"
                 for p in self.data["parameters"]]
        return "\n".join([f"{self.data['model']}: {self.status}"] + lines)


def fit(model, records, free, *, profile=(), starts=3, robust=False, initial="auto",
        scatter="auto", prior=None, offset=None, trigger=None, output=None, journal=None,
        threads=None, progress=None):
    """Parameters of a simulation's mechanism from measured records; the options of `stein fit`.

    records: one or several, each a path (CSV, npy, mat), a Record, a DataFrame, a mapping of names
    to arrays. output: mechanism file to be written. A status that is not "converged" is a warning.
    """
    free, profile = _names(model, free), _names(model, profile)
    initial = _choice("initial", initial, {"auto": -1, "free": 1, "fixed": 0})
    scatter = _choice("scatter", scatter, {"auto": -1, "yes": 1, "no": 0})
    names, texts = named_texts(records, model)
    with tempfile.TemporaryDirectory(prefix="stein-") as folder:
        path = os.path.join(folder, "fit.json")
        doubts = _stein.fit(
            model._present(), names, texts, free, profile, path, _path(output),
            (starts, robust, initial, scatter, threads or os.cpu_count()),
            (_or_nan(prior), _or_nan(offset), _or_nan(trigger)), _path(journal), _told(progress))
        data = json.loads(Path(path).read_text(encoding="utf-8"))
    if data["status"] != "converged":
        warnings.warn(f"{data['status']}: {data['reason']}", RuntimeWarning, stacklevel=2)
    values = {p["name"]: p["value"] for p in data["parameters"]}
    return Fit(data, doubts, load(model.file, {**model._changed(), **values}))


class Diagnosis:
    """What `stein diagnose` found: `verdict`, `reason`, `causes`, `table` (every candidate), all of
    diagnosis.json as `data`, the report as `html`; a notebook shows it. `extended` is a simulation
    of the mechanism with the causes in it, None without any."""

    def __init__(self, folder, explanation=None, keep=None):
        self.folder, self.explanation, self._keep = Path(folder), explanation, keep
        self.data = json.loads((self.folder / "diagnosis.json").read_text(encoding="utf-8"))
        self.verdict, self.reason = self.data["verdict"], self.data["reason"]
        self.causes, self.table = self.data["causes"], self.data["suspects"]
        self.rivals = self.data["indistinguishable"]

    @property
    def html(self):
        """The report, one self-contained page."""
        return (self.folder / "report.html").read_text(encoding="utf-8")

    @property
    def extended(self):
        path = self.folder / "extended.yaml"
        if not path.exists():
            return None
        model = load(path)
        model._keep = self._keep
        return model

    def save(self, folder):
        """diagnosis.json, report.html and, with a cause, extended.yaml."""
        shutil.copytree(self.folder, folder, dirs_exist_ok=True)

    def __repr__(self):
        lines = [f"{self.verdict}: {self.reason}"]
        for cause in self.causes:
            name = f"cause: {cause['kind']} at {cause['place']}: "
            rest = list(cause["parameters"].items())[1 if cause["change"] else 0:]
            numbers = (f"{n} = {p['value']:.6g} {p['unit']}"
                       + (f" (95 %: {p['lo']:.6g} .. {p['hi']:.6g})" if p["lo"] is not None else "")
                       for n, p in rest)
            lines.append(name + ", ".join([cause["change"], *numbers] if cause["change"] else numbers))
        return "\n".join(lines)

    def _repr_html_(self):
        return (f'<iframe srcdoc="{html.escape(self.html)}" width="100%" height="700" '
                'style="border:0"></iframe>')


def diagnose(model, records, *, held_out=None, free=(), without=(), budget=None, seconds=None,
             trust_settings=False, explain=None, trace=None, output=None, threads=None,
             progress=None):
    """What the simulation gets wrong: the cause, from measured records; see `stein diagnose`.

    records: as for fit. held_out: records that judge and are not fitted to. budget: simulated
    records, seconds: time, after which the search ends. output: folder for the results.
    """
    names, texts = named_texts(records, model)
    more, their = named_texts(held_out, model) if held_out is not None else ([], [])
    keep = None if output else _Folder()
    folder = output or keep.name
    os.makedirs(folder, exist_ok=True)
    (Path(folder) / "extended.yaml").unlink(missing_ok=True)  # of another verdict
    held = bytes(len(names)) + b"\1" * len(more) if more else b""
    explanation = _stein.diagnose(
        model._present(), names + more, texts + their, held, _names(model, free), list(without),
        _path(folder), int(budget or 0), float(seconds or 0.0), threads or os.cpu_count(),
        trust_settings, explain, _path(trace), _told(progress))
    return Diagnosis(folder, explanation, keep)


class Plan:
    """What `stein plan` proposes: `experiments`, the best first, all of plan.json as `data`; `stroke`
    and `rival`, paths of the best one's records as the cause and its rival predict them."""

    def __init__(self, folder, keep=None):
        self.folder, self._keep = Path(folder), keep
        self.data = json.loads((self.folder / "plan.json").read_text(encoding="utf-8"))
        self.experiments = self.data["experiments"]
        self.stroke, self.rival = self.data["stroke"], self.data["stroke_of_rival"]

    def __repr__(self):
        cause, rivals = self.data["cause"], self.data["rivals"]
        lines = [" or ".join(f"{s['kind']} at {s['place']}" for s in [cause, *rivals]) + "?"]
        for e in self.experiments:
            if e["feasible"]:
                lines.append(f"{e['experiment']}: 2 ln odds {e['odds']:.3g}, "
                             f"{e['repeats'] or 'too many'} times")
        return "\n".join(lines)


def plan(model, diagnosis, *, odds=None, instruments=None, output=None, threads=None,
         progress=None):
    """The next experiment, which separates a cause from its rivals; see `stein plan`.

    diagnosis: a Diagnosis with rivals, or the path of a diagnosis.json. instruments: outputs that
    can be measured as well; None: all. output: folder for the results.
    """
    keep = None if output else _Folder()
    folder = output or keep.name
    path = diagnosis.folder / "diagnosis.json" if isinstance(diagnosis, Diagnosis) else diagnosis
    _stein.plan(model._present(), os.fspath(path), os.fspath(folder), _or_nan(odds),
                instruments is None, list(instruments or ()), threads or os.cpu_count(),
                _told(progress))
    return Plan(folder, keep)


# ---- small things


class _Folder:
    """A folder of temporary files, gone with the last that needs it."""

    def __init__(self):
        self.name = tempfile.mkdtemp(prefix="stein-")
        weakref.finalize(self, shutil.rmtree, self.name, True)


def _or_nan(x):
    return _nan if x is None else float(x)


def _choice(what, word, known):
    if word not in known:
        words = ", ".join(repr(k) for k in known if k)
        raise InvalidValue(f"{what}={word!r}: expected one of {words}", "EINVAL")
    return known[word]


def _path(x):
    return None if x is None else os.fspath(x)


def _written(value):
    """A number or a text with a unit, as an override of a file has it."""
    return value if isinstance(value, str) else repr(float(value))


def _doubles(numbers):
    from array import array

    return array("d", numbers)


def _names(model, names):
    names = [names] if isinstance(names, str) else list(names)
    for name in names:
        if name not in model:
            raise unknown("parameter", name, list(model))
    return names
