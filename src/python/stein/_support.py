# SPDX-License-Identifier: GPL-3.0-or-later
"""What stein._stein calls: exceptions, how numbers are shown, events."""
import difflib
import re
from typing import NamedTuple

try:
    from numpy import asarray as view  # over the same memory
except ImportError:
    view = memoryview  # type: ignore[assignment]


class Error(Exception):
    """A failure of libstein.

    code: its name, "EPARSE"; problems: every problem of a file, "file:line:column: what";
    file, line, column: where the first one is, None where that is no place in a file.
    """

    def __init__(self, message, code="", problems=()):
        super().__init__(message)
        self.code = code
        self.problems = tuple(problems)
        at = re.match(r"(.*?):(\d+):(\d+): ", self.problems[0] if self.problems else message)
        self.file, self.line, self.column = (at[1], int(at[2]), int(at[3])) if at else (None,) * 3

    def __str__(self):
        return str(self.args[0])

    def __reduce__(self):
        return type(self), (self.args[0], self.code, self.problems)


class UnknownName(Error, KeyError):
    """The mechanism has no parameter, output, input, point or contact of that name."""


class InvalidValue(Error, ValueError):
    """A number out of its range, a unit of another quantity, an option that cannot be."""


class ParseError(Error, ValueError):
    """A mechanism file or a record is not in order."""


class FileError(Error, OSError):
    """A file cannot be read or written."""


class EquationsError(Error):
    """The equations of a mechanism cannot be generated, compiled or loaded."""


class NumericalError(Error, ArithmeticError):
    """No equilibrium, a singular mass matrix, numbers that are no longer finite."""


_class = {"EINVAL": InvalidValue, "ENAME": UnknownName, "EPARSE": ParseError, "EIO": FileError,
          "EGENERATE": EquationsError, "ECOMPILE": EquationsError, "ELOAD": EquationsError,
          "ESTALE": EquationsError, "ENONFINITE": NumericalError, "ESINGULAR": NumericalError,
          "ECHATTER": NumericalError, "ESETTLE": NumericalError}


def failure(code, message, problems=None):
    """The exception for a failure of the library."""
    if code == "ENOMEM":
        return MemoryError(message)
    told = "\n".join(problems) if problems and code in ("EPARSE", "EIO") else message
    told = re.sub(r"\blab_\w+_def\.", "", told)  # fields of C are arguments here
    return _class.get(code, Error)(told, code, problems or ())


def unknown(what, name, known):
    """The exception for a name that is not among those that are known."""
    near = difflib.get_close_matches(name, known, 1)
    return UnknownName(f"no {what} {name!r}" + (f", did you mean {near[0]!r}?" if near else ""),
                       "ENAME")


class Event(NamedTuple):
    """What happened at an instant that was located [s]: contact_begin, contact_end, impact,
    escapement, caught, phase (of a notch, 0 to 4), stick, slip (1, -1: its direction); at which
    contact, notch or joint."""

    time: float
    kind: str
    at: str
    phase: int
