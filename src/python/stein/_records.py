# SPDX-License-Identifier: GPL-3.0-or-later
"""Records as programs have them, written as the data files that the library reads."""
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass
class Record:
    """One measured run: columns by name, one of them "time"; a column without a unit in its name
    ("angle [deg]") is in the model's unit, SI. set: parameters of this run, {"load.mass": "70 g"};
    known: the same, measured by themselves; noise: standard deviation of one sample of a column."""

    columns: Mapping
    name: str = ""
    set: Mapping = field(default_factory=dict)
    known: Mapping = field(default_factory=dict)
    noise: Mapping = field(default_factory=dict)
    trigger: str = ""

    def text(self, units):
        """The record as a data file; units of what the model names."""
        lines = [f"# {word} {name}: {value if isinstance(value, str) else repr(float(value))}"
                 for word in ("set", "known", "noise") for name, value in getattr(self, word).items()]
        if self.trigger:
            lines.append(f"# trigger: {self.trigger}")
        columns = _titled(self.columns, units)
        lines.append(",".join(columns))
        lines += map(",".join, zip(*(_cells(c) for c in columns.values()), strict=True))
        return "\n".join(lines) + "\n"


def _cells(column):
    numbers = column.tolist() if hasattr(column, "tolist") else list(column)
    return ["" if x is None or math.isnan(x) else repr(float(x)) for x in numbers]


def _titled(columns, units):
    """Columns with their titles, the time first."""
    names = sorted(columns.keys(), key=lambda name: not str(name).lower().startswith("time"))
    return {f"{n} [{units[n]}]" if n in units else str(n): columns[n] for n in names}


def _of_file(path):
    """The columns of a binary file."""
    if path.endswith(".npy"):
        import numpy

        table = numpy.load(path)
        return {name: table[name] for name in table.dtype.names}
    import scipy.io

    table = scipy.io.loadmat(path, squeeze_me=True)
    units = dict(zip(table["units"].dtype.names, table["units"].item())) if "units" in table else {}
    return {f"{name} [{units[name]}]" if name in units else name: column
            for name, column in table.items()
            if not name.startswith("__") and getattr(column, "ndim", 0) == 1 and
            column.dtype.kind in "fiu"}


def _named_text(record, number, units):
    """(name, text) of a record; text None: it is a file that the library reads itself."""
    if isinstance(record, (str, os.PathLike)):
        path = os.fspath(record)
        if not path.endswith((".npy", ".mat")):
            return path, None
        record = Record(_of_file(path), path)
    elif not isinstance(record, Record):
        attrs = getattr(record, "attrs", {})  # of a DataFrame
        known = {k: attrs[k] for k in ("set", "known", "noise", "trigger") if k in attrs}
        if getattr(getattr(record, "dtype", None), "names", None):  # a structured array
            record = {name: record[name] for name in record.dtype.names}
        record = Record(record, **known)
    return record.name or f"record {number}", record.text(units)


def named_texts(records, model):
    """Lists of names and texts of one record or several, for a simulation."""
    units = {**model.outputs, **model.inputs}
    one = isinstance(records, (str, os.PathLike, Record, Mapping)) or hasattr(records, "columns")
    one = one or getattr(getattr(records, "dtype", None), "names", None)
    pairs = [_named_text(r, i + 1, units) for i, r in enumerate([records] if one else records)]
    return [p[0] for p in pairs], [p[1] for p in pairs]
