# SPDX-License-Identifier: GPL-3.0-or-later
# Types of `import stein`; __init__.py describes the functions.
import os
from abc import abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple

from numpy.typing import NDArray

_Array = NDArray[Any]  # a memoryview where numpy is not installed
_Numbers = Sequence[float] | _Array
_Path = str | os.PathLike[str]
_Value = float | str  # SI, or a text with a unit
_Progress = bool | Callable[[float, str], object] | None
_Drive = float | Sequence[float]
_Signal = _Drive | Callable[[float], _Drive] | None
_Force = Callable[[float, _Array, _Array], _Numbers] | None  # of t, q, qd
_OneRecord = _Path | Record | Mapping[str, Any]  # or a DataFrame, or a structured array
_Records = _OneRecord | Sequence[_OneRecord]

__version__: str

class Error(Exception):
    code: str
    problems: tuple[str, ...]
    file: str | None
    line: int | None
    column: int | None
    def __init__(self, message: str, code: str = ..., problems: Iterable[str] = ...) -> None: ...

class UnknownName(Error, KeyError): ...
class InvalidValue(Error, ValueError): ...
class ParseError(Error, ValueError): ...
class FileError(Error, OSError): ...
class EquationsError(Error): ...
class NumericalError(Error, ArithmeticError): ...

class Event(NamedTuple):
    time: float
    kind: str
    at: str
    phase: int

class Parameter(NamedTuple):
    name: str
    unit: str
    value: float
    tolerance: float

class Derivatives(NamedTuple):
    by_q: _Array
    by_qd: _Array
    by: dict[str, _Array]

class Mode(NamedTuple):
    kind: Literal["oscillates", "decays", "grows", "neutral"]
    eigenvalue: complex
    frequency: float
    damping: float
    joint: str
    share: float
    shape: tuple[complex, ...]

class Linear(NamedTuple):
    A: _Array
    B: _Array
    C: _Array
    D: _Array
    T: _Array
    mass: _Array
    coordinates: tuple[str, ...]
    free: int
    states: dict[str, str]
    inputs: dict[str, str]
    outputs: dict[str, str]
    inexact: tuple[str, ...]
    modes: tuple[Mode, ...]
    edges: tuple[tuple[str, str, float], ...]
    exact: bool
    why: str | None
    error: float
    residual: float

class Sensitivities(NamedTuple):
    q: dict[str, _Array]
    qd: dict[str, _Array]
    run: Run

class Record:
    columns: Mapping[str, Any]
    name: str
    set: Mapping[str, _Value]
    known: Mapping[str, _Value]
    noise: Mapping[str, _Value]
    trigger: str
    def __init__(
        self,
        columns: Mapping[str, Any],
        name: str = ...,
        set: Mapping[str, _Value] = ...,
        known: Mapping[str, _Value] = ...,
        noise: Mapping[str, _Value] = ...,
        trigger: str = ...,
    ) -> None: ...
    def text(self, units: Mapping[str, str]) -> str: ...

class Table(Mapping[str, Any]):
    units: dict[str, str]
    def __init__(self, units: dict[str, str]) -> None: ...
    @abstractmethod
    def __getitem__(self, name: str) -> Any: ...
    def __iter__(self) -> Iterator[str]: ...
    def __len__(self) -> int: ...
    def to_pandas(self) -> Any: ...

class Run(Table):
    events: list[Event]
    def __init__(
        self, record: Any, units: dict[str, str], events: list[Event], warning: str | None = ...
    ) -> None: ...
    def __getitem__(self, name: str) -> _Array: ...

class Stroke(NamedTuple):
    outcome: Literal["struck", "missed_notch", "no_escapement", "no_impact"]
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
    def __init__(self, path: _Path) -> None: ...
    def __getitem__(self, name: str) -> Any: ...

class Simulation:
    file: str
    state: bytes
    def __new__(
        cls,
        file: _Path,
        set: Mapping[str, _Value] | None = ...,
        *,
        dt: float | None = ...,
        integrator: Literal["rk4", "dp5", "controlled", "implicit"] | None = ...,
    ) -> Simulation: ...
    @property
    def name(self) -> str: ...
    @property
    def time(self) -> float: ...
    @property
    def dt(self) -> float: ...
    @property
    def q(self) -> _Array: ...
    @property
    def qd(self) -> _Array: ...
    @property
    def qdd(self) -> _Array: ...
    @property
    def events(self) -> list[Event]: ...
    @property
    def parameters(self) -> dict[str, Parameter]: ...
    @property
    def outputs(self) -> dict[str, str]: ...
    @property
    def inputs(self) -> dict[str, str]: ...
    @property
    def bodies(self) -> tuple[str, ...]: ...
    def keys(self) -> Iterable[str]: ...
    def get(self, key: str, default: Any = ...) -> Any: ...
    def items(self) -> Iterable[tuple[str, float]]: ...
    def values(self) -> Iterable[float]: ...
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[str]: ...
    def __contains__(self, name: object) -> bool: ...
    def __getitem__(self, name: str) -> float: ...
    def __setitem__(self, name: str, value: _Value) -> None: ...
    def reset(self) -> None: ...
    def lift(self) -> None: ...
    def settle(self) -> None: ...
    def step(self, n: int = ..., /) -> float: ...
    def read(self, output: str, /) -> float: ...
    def touches(self, contact: str, /) -> bool: ...
    def energy(self) -> tuple[float, float]: ...
    def run(
        self,
        until: float | None = ...,
        every: float | None = ...,
        *,
        release: float | None = ...,
        restart: bool = ...,
        progress: _Progress = ...,
    ) -> Run: ...
    def strike(
        self,
        until: float | None = ...,
        every: float | None = ...,
        *,
        release: float | None = ...,
        progress: _Progress = ...,
    ) -> Stroke: ...
    def drive(self, input: str, signal: _Signal) -> None: ...
    def on_force(self, function: _Force) -> None: ...
    def drive_file(self, path: _Path) -> None: ...
    def sweep(
        self,
        vary: Mapping[str, str | Iterable[float]] | None = ...,
        *,
        until: float | None = ...,
        release: float | None = ...,
        threads: int | None = ...,
        journal: _Path | None = ...,
        progress: _Progress = ...,
        **short: str | Iterable[float],
    ) -> Sweep: ...
    def mass_matrix(self, q: _Numbers | None = ...) -> _Array: ...
    def bias(self, q: _Numbers | None = ..., qd: _Numbers | None = ...) -> _Array: ...
    def inverse(
        self,
        q: _Numbers | None = ...,
        qd: _Numbers | None = ...,
        qdd: _Numbers | None = ...,
    ) -> _Array: ...
    def acceleration(self, q: _Numbers | None = ..., qd: _Numbers | None = ...) -> _Array: ...
    def position(self, point: str, q: _Numbers | None = ...) -> _Array: ...
    def velocity(
        self, point: str, q: _Numbers | None = ..., qd: _Numbers | None = ...
    ) -> _Array: ...
    def jacobian(self, point: str, q: _Numbers | None = ...) -> _Array: ...
    def sensitivities(
        self,
        parameters: str | Iterable[str],
        until: float | None = ...,
        every: float | None = ...,
        *,
        progress: _Progress = ...,
    ) -> Sensitivities: ...
    def sympy(self, what: str = ...) -> str: ...
    def derivatives(self, *parameters: str) -> Derivatives: ...
    def linearise(self) -> Linear: ...
    def set_state(
        self, q: _Numbers | None = ..., qd: _Numbers | None = ..., time: float = ...
    ) -> None: ...
    def copy(self) -> Simulation: ...

class Fit:
    data: dict[str, Any]
    doubts: list[str]
    model: Simulation
    status: Literal["converged", "misfit", "not_converged"]
    reason: str | None
    values: dict[str, float]
    intervals: dict[str, tuple[float, float]]
    chi2_dof: float
    def __init__(self, data: dict[str, Any], doubts: list[str], model: Simulation) -> None: ...

class Diagnosis:
    folder: Path
    explanation: str | None
    data: dict[str, Any]
    verdict: str
    reason: str
    causes: list[dict[str, Any]]
    rivals: list[dict[str, Any]]
    table: list[dict[str, Any]]
    def __init__(
        self, folder: _Path, explanation: str | None = ..., keep: object = ...
    ) -> None: ...
    @property
    def html(self) -> str: ...
    @property
    def extended(self) -> Simulation | None: ...
    def save(self, folder: _Path) -> None: ...

class Plan:
    folder: Path
    data: dict[str, Any]
    experiments: list[dict[str, Any]]
    stroke: str | None
    rival: str | None
    def __init__(self, folder: _Path, keep: object = ...) -> None: ...

def load(
    file: _Path,
    set: Mapping[str, _Value] | None = ...,
    *,
    dt: float | None = ...,
    integrator: Literal["rk4", "dp5", "controlled", "implicit"] | None = ...,
) -> Simulation: ...
def fit(
    model: Simulation,
    records: _Records,
    free: str | Iterable[str],
    *,
    profile: str | Iterable[str] = ...,
    starts: int = ...,
    robust: bool = ...,
    initial: Literal["auto", "free", "fixed"] = ...,
    scatter: Literal["auto", "yes", "no"] = ...,
    prior: float | None = ...,
    offset: float | None = ...,
    trigger: float | None = ...,
    output: _Path | None = ...,
    journal: _Path | None = ...,
    threads: int | None = ...,
    progress: _Progress = ...,
) -> Fit: ...
def diagnose(
    model: Simulation,
    records: _Records,
    *,
    held_out: _Records | None = ...,
    free: str | Iterable[str] = ...,
    without: Iterable[str] = ...,
    budget: int | None = ...,
    seconds: float | None = ...,
    trust_settings: bool = ...,
    explain: str | None = ...,
    trace: _Path | None = ...,
    output: _Path | None = ...,
    threads: int | None = ...,
    progress: _Progress = ...,
) -> Diagnosis: ...
def plan(
    model: Simulation,
    diagnosis: Diagnosis | _Path,
    *,
    odds: float | None = ...,
    instruments: Iterable[str] | None = ...,
    output: _Path | None = ...,
    threads: int | None = ...,
    progress: _Progress = ...,
) -> Plan: ...
