#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_formats.sh - `stein simulate --format`: NumPy and SciPy read the values of the CSV, bit for
# bit.
set -u
. tests/claims.sh
unset CC

# run TEXT OPTION...
run() {
    text=$1
    shift
    claim 0 "$text" "$stein" strike models/stein1788.yaml --set pawl.stop_shift=-0.3mm --until 80ms --every 1ms "$@"
}
run "a stroke as CSV" -o "$dir/s.csv"
run "as a structured array, by its ending" -o "$dir/s.npy"
run "as a MATLAB file, by its ending" -o "$dir/s.mat"
run "by an option, whatever the ending" --format npy -o "$dir/s.dat"
same "an option says the same as an ending" "$dir/s.dat" "$dir/s.npy"
run "to standard output" --format mat -o -
same "standard output holds the same file" "$dir/out" "$dir/s.mat"
run "the ending is overruled" --format csv -o "$dir/c.npy"
same "CSV stays CSV" "$dir/c.npy" "$dir/s.csv"
run "as plain CSV" --format csv-plain -o "$dir/plain.csv"
grep -v '^#' "$dir/s.csv" | sed '1s/ \[[^]]*\]//g' >"$dir/bare.csv"
same "plain CSV is the CSV without notes and units" "$dir/plain.csv" "$dir/bare.csv"
claim 2 "a form that is none is misuse" "$stein" strike models/stein1788.yaml --format hdf5 -o "$dir/x"
says "the forms are listed" 'expected csv, csv-plain, npy or mat'
claim 2 "a form without a file is misuse" "$stein" strike models/stein1788.yaml --format npy
says "the file is asked for" 'needs a file: -o'

numpy=
for p in python3 /usr/bin/python3; do
    if [ -z "$numpy" ] && $p -c 'import numpy' 2>/dev/null; then numpy=$p; fi
done
if [ -z "$numpy" ]; then
    echo "test_formats: no numpy, its reading of plain CSV is not tested"
else
    cat >"$dir/plain.py" <<'PY'
import csv, sys
import numpy
folder = sys.argv[1]
rows = list(csv.reader(open(folder + "/plain.csv")))
table = numpy.array([[float(x) for x in r] for r in rows[1:]])
a = numpy.genfromtxt(folder + "/plain.csv", names=True, delimiter=",")
assert list(a.dtype.names) == rows[0] and rows[0][0] == "time" and a.shape == (81,)
for i, name in enumerate(rows[0]):
    assert (a[name] == table[:, i]).all(), name
try:
    import pandas
    b = pandas.read_csv(folder + "/plain.csv", float_precision="round_trip")
    assert list(b.columns) == rows[0] and (b.to_numpy() == table).all()
except ImportError:
    print("test_formats: no pandas, its reading is not tested")
PY
    claim 0 "NumPy (and pandas) read plain CSV by name" "$numpy" "$dir/plain.py" "$dir"
fi

python=
for p in python3 /usr/bin/python3; do
    if [ -z "$python" ] && $p -c 'import numpy, scipy.io' 2>/dev/null; then python=$p; fi
done
if [ -z "$python" ]; then
    echo "test_formats: no numpy and scipy, their reading is not tested"
else
    cat >"$dir/read.py" <<'PY'
import csv, sys
import numpy, scipy.io
folder = sys.argv[1]
lines = [l for l in open(folder + "/s.csv") if not l.startswith("#")]
notes = "".join(l[2:] for l in open(folder + "/s.csv") if l.startswith("#"))
rows = list(csv.reader(lines))
names = [c.split(" [")[0] for c in rows[0]]
units = [c.split(" [")[1][:-1] for c in rows[0]]
table = numpy.array([[float(x) for x in r] for r in rows[1:]])
a = numpy.load(folder + "/s.npy")
m = scipy.io.loadmat(folder + "/s.mat")
assert list(a.dtype.names) == names and a.shape == (81,)
for i, name in enumerate(names):
    assert (a[name] == table[:, i]).all(), name
    assert m[name].shape == (81, 1) and (m[name][:, 0] == table[:, i]).all(), name
    assert m["units"][name][0, 0][0] == units[i], name
assert m["notes"][0] == notes
PY
    claim 0 "NumPy and SciPy read the numbers, units and notes of the CSV" "$python" "$dir/read.py" "$dir"
fi

finish
