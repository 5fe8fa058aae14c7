# SPDX-License-Identifier: GPL-3.0-or-later
"""Sweeps, fits and diagnoses: what the commands compute, from records of every form."""
import csv
import importlib.util
import json
import warnings

import numpy
import pytest
import stein
from conftest import ACTION, PENDULUM, ROOT, command, interrupted, plain


def rows_of(path):
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    return list(csv.DictReader(lines))


def test_a_sweep_is_the_table_of_the_command(tmp_path):
    path = tmp_path / "sweep.csv"
    command("sweep", ACTION, "--set", "load.mass=80 g", "--vary", "pawl.stop_shift=-0.9:0:4mm", "--vary",
            "pawl.notch_angle=80,84deg", "-o", path)
    m = stein.load(ACTION)
    m["load.mass"] = "80 g"
    table = m.sweep({"pawl.stop_shift": "-0.9:0:4 mm", "pawl.notch_angle": "80,84 deg"})
    rows = rows_of(path)
    assert len(rows) == 8 == len(table["point"])
    for title in rows[0]:
        name = title.split(" [")[0]
        cells = [row[title] for row in rows]
        if name in ("status", "outcome"):
            assert table[name] == cells
        else:
            numbers = [float(c) if c else numpy.nan for c in cells]
            assert numpy.array_equal(table[name], numbers, equal_nan=True), name
    assert table.units["impact_speed"] == "m/s"
    shifts = numpy.linspace(-0.9e-3, 0.0, 4)
    short = m.sweep(stop_shift=shifts, threads=1)
    assert numpy.array_equal(short["pawl.stop_shift"], shifts)
    point = m.copy()
    point["pawl.stop_shift"] = shifts[1]
    # the sweep takes steps by the file's tolerance, the stroke steps of its dt
    assert point.strike().impact_speed == pytest.approx(short["impact_speed"][1], rel=1e-6)


def test_a_sweep_goes_on_from_its_journal(tmp_path):
    m, vary = stein.load(PENDULUM), {"rod.initial.position": "1:9:5 deg"}
    first = m.sweep(vary, until=0.1, journal=tmp_path / "journal")
    assert (tmp_path / "journal").exists()
    again = m.sweep(vary, until=0.1, journal=tmp_path / "journal")
    assert numpy.array_equal(first["angle"], again["angle"])
    with pytest.raises(stein.EquationsError, match="sweep"):
        m.sweep(vary, until=0.2, journal=tmp_path / "journal")


def test_a_name_that_two_parameters_share_is_asked_for_whole():
    with pytest.raises(ValueError, match="give the whole name"):
        stein.load(ACTION).sweep(mass=[0.1])


def test_a_fit_is_that_of_the_command(files, tmp_path):
    told = json.loads(command("fit", PENDULUM, *files, "--free", "rod.drag,rod.damping", "--set",
                              "rod.drag=1e-3", "--profile", "rod.drag", "--json"))
    m = stein.load(PENDULUM, {"rod.drag": 1e-3})
    fit = stein.fit(m, files, ["rod.drag", "rod.damping"], profile=["rod.drag"],
                    output=tmp_path / "fitted.yaml")
    assert fit.data == told and fit.status == "converged"
    assert fit.values["rod.drag"] == pytest.approx(2e-3, rel=0.02)
    assert fit.model["rod.drag"] == fit.values["rod.drag"]
    assert fit.intervals["rod.drag"][0] < fit.values["rod.drag"] < fit.intervals["rod.drag"][1]
    assert stein.load(tmp_path / "fitted.yaml")["rod.drag"] == pytest.approx(fit.values["rod.drag"])
    assert "rod.drag = 0.00" in repr(fit)


def test_a_misfit_is_warned_of(swings):
    with pytest.warns(RuntimeWarning, match="misfit"):
        assert stein.fit(stein.load(PENDULUM), swings, "rod.damping").status == "misfit"


def forms(record, folder):
    """A record in every form that programs have it in."""
    t, y = numpy.asarray(record.columns["time"]), record.columns["angle"]
    table = numpy.rec.fromarrays([t, y], names="time,angle")
    numpy.save(folder / "r.npy", table)
    yield from (record, {"time": t, "angle": y}, {"angle": list(y), "time": list(t)}, table,
                folder / "r.npy")
    if importlib.util.find_spec("scipy"):
        import scipy.io

        scipy.io.savemat(folder / "r.mat", {"time": t, "angle": y})
        yield str(folder / "r.mat")
    if importlib.util.find_spec("pandas"):
        import pandas

        frame = pandas.DataFrame({"time": t, "angle [deg]": numpy.degrees(y)})
        frame.attrs.update(set=record.set, noise=record.noise)
        yield frame
        yield stein.Record(frame, **frame.attrs)


def test_records_come_in_every_form(swings, tmp_path):
    m = stein.load(PENDULUM, {"rod.drag": 1e-3})
    m["rod.initial.position"] = swings[0].set["rod.initial.position"]
    found = []
    for form in forms(swings[0], tmp_path):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found.append(stein.fit(m, form, "rod.drag", initial="fixed", starts=1).values["rod.drag"])
    assert found == pytest.approx([found[0]] * len(found), rel=0.05) and found[0] > 1.5e-3


def test_missing_samples_are_empty_cells():
    text = stein.Record({"time": [0.0, 0.1], "angle": [1.0, float("nan")]}).text({"angle": "rad"})
    assert text == "time,angle [rad]\n0.0,1.0\n0.1,\n"


def test_a_record_that_is_not_in_order_is_told_with_its_places():
    bad = stein.Record({"time": [0, 1, 1, 2], "angel": [0, 0, 0, 0]}, "swing 7")
    with pytest.raises(stein.ParseError) as caught:
        stein.fit(stein.load(PENDULUM), bad, "rod.damping")
    assert caught.value.file == "swing 7" and caught.value.line >= 1
    assert "angel" in str(caught.value) and "angle" in str(caught.value)


def test_a_diagnosis_is_that_of_the_command(files, swings, tmp_path):
    command("diagnose", PENDULUM, *files, "-o", tmp_path / "out")
    told = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    m = stein.load(PENDULUM)
    d = stein.diagnose(m, files)
    for one in (told, d.data):
        del one["fit"]["seconds"]
    assert d.data == told
    assert d.verdict == "missing_effect" and d.causes[0]["kind"] == "quadratic_drag"
    assert "quadratic_drag at rod: k = 0.00" in repr(d) and not d.rivals
    assert {row["kind"] for row in d.table if row["presence"] == "present"} == {"quadratic_drag"}
    assert "<iframe srcdoc=" in d._repr_html_() and "&lt;html" in d._repr_html_()
    d.save(tmp_path / "saved")
    assert ((tmp_path / "saved" / "extended.yaml").read_bytes() ==
            (tmp_path / "out" / "extended.yaml").read_bytes())
    k = d.causes[0]["parameters"]["k"]["value"]
    better = d.extended
    assert better["rod.drag"] == pytest.approx(k)
    folder = d.folder
    del d
    better.run(0.1)
    assert folder.exists()
    del better
    assert not folder.exists()  # nothing is left in the folder of temporary files
    memory = stein.diagnose(m, swings, explain="viscous_friction@rod", output=tmp_path / "memory")
    assert memory.causes[0]["parameters"] == told["causes"][0]["parameters"]
    assert memory.reason == told["reason"] and memory.data["verified"] == told["verified"]
    assert memory.explanation and (tmp_path / "memory" / "report.html").exists()


def test_held_out_records_judge_and_nothing_is_a_verdict(swings):
    truth = stein.load(PENDULUM, {"rod.drag": "2e-3"})
    d = stein.diagnose(truth, swings[:4], held_out=swings[4:], threads=1)
    assert d.verdict == "explained" and not d.causes and d.extended is None
    assert [d.data["strokes"][k] for k in ("fitted", "choosing", "reporting")] == [4, 0, 2]
    assert plain(d.causes) == []


def test_settings_that_a_record_belies_are_refused(tmp_path):
    paths = [f"{ROOT}/models/strokes/stroke_{i:02}.csv" for i in (1, 2, 3)]
    text = open(paths[0], encoding="utf-8").read()
    (tmp_path / "slip.csv").write_text(text.replace("load.mass: 70 g", "load.mass: 70 kg"))
    with pytest.raises(stein.ParseError, match="slip.csv:2:7: .*load.mass"):
        stein.diagnose(stein.load(ACTION), [tmp_path / "slip.csv", *paths[1:]], budget=1)


WHEEL = """mechanism: wheel
bodies:
  wheel:
    joint: R y
    mass: 0.4 kg
    inertia: {yy: 2.1e-3 kg m^2 +- 1 %}
    spring: {k: 0.83 N m/rad +- 1 %}
    initial: {position: 0.2 rad}
inputs: {turn: {motion: wheel}}
outputs: {angle: {joint: wheel, read: position}, rate: {joint: wheel, read: speed}}
simulation: {dt: 0.2 ms, until: 0.7 s}
"""


def test_a_plan_is_that_of_the_command(tmp_path):
    file = tmp_path / "wheel.yaml"
    file.write_text(WHEEL)
    swing = stein.load(file, {"wheel.drag": 1e-4}).run(every=5e-3)
    noise, records = numpy.random.default_rng(5), []
    for i in range(6):
        angle = swing["angle"] + noise.normal(0.0, 1e-3, len(swing["angle"]))
        records.append(stein.Record({"time": swing["time"], "angle": angle}, f"stroke {i + 1}",
                                    set={"wheel.initial.position": 0.2}, noise={"angle": 1e-3}))
    m = stein.load(file)
    d = stein.diagnose(m, records, output=tmp_path / "out")
    assert {c["kind"] for c in d.causes + d.rivals} >= {"quadratic_drag", "viscous_friction"}
    command("plan", file, tmp_path / "out" / "diagnosis.json", "-o", tmp_path / "plan")
    told = json.loads((tmp_path / "plan" / "plan.json").read_text())
    plan = stein.plan(m, d, output=tmp_path / "next")
    for one in (told, plan.data):
        del one["seconds"], one["stroke"], one["stroke_of_rival"]
    assert plan.data == told and plan.experiments == told["experiments"]
    for name in ("next_stroke.csv", "next_rival.csv"):
        assert (tmp_path / "next" / name).read_bytes() == (tmp_path / "plan" / name).read_bytes()
    assert plan.stroke == str(tmp_path / "next" / "next_stroke.csv")
    assert plan.experiments[0]["experiment"] in repr(plan)
    again = stein.plan(m, tmp_path / "out" / "diagnosis.json", odds=20, instruments=[])
    assert again.data["odds_wanted"] == 20
    assert interrupted(lambda: [stein.plan(m, d) for _ in range(100)]) < 5.0
    with pytest.raises(stein.InvalidValue):
        stein.plan(m, d, odds=0.5)
    with pytest.raises(stein.ParseError, match="diagnosis.json:1"):
        (tmp_path / "diagnosis.json").write_text("{}")
        stein.plan(m, tmp_path / "diagnosis.json")
