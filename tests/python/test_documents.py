# SPDX-License-Identifier: GPL-3.0-or-later
"""What docs/python.md, README.md and the examples show, runs; types agree with the module."""
import importlib.util
import inspect
import os
import re
import subprocess
import sys

import pytest
import stein
from conftest import BUILD, ROOT


EXAMPLES = sorted(n for n in os.listdir(os.path.join(ROOT, "examples", "python")) if n.endswith(".py"))


def blocks(name, language="python"):
    with open(os.path.join(ROOT, name), encoding="utf-8") as f:
        return re.findall(rf"^```{language}\n(.*?)^```", f.read(), re.M | re.S)


def ran(words, folder):
    os.symlink(os.path.join(ROOT, "models"), folder / "models")
    done = subprocess.run([sys.executable, *words], cwd=folder, capture_output=True, text=True,
                          check=False, env={**os.environ, "PYTHONPATH": os.path.join(BUILD, "python"), "MPLBACKEND": "agg"})
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_page_runs_from_its_first_block_to_the_last(tmp_path):
    told = ran(["-W", "error", "-c", "\n".join(blocks("docs/python.md"))], tmp_path)
    assert "did you mean 'pawl.stop_shift'?" in told
    assert sorted(os.listdir(tmp_path / "out")) == ["diagnosis.json", "extended.yaml", "report.html"]


def test_the_lines_of_the_readme_run(tmp_path):
    assert len(blocks("README.md")) == 1
    ran(["-W", "error", "-c", blocks("README.md")[0]], tmp_path)


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_runs(name, tmp_path):
    path = os.path.join(ROOT, "examples", "python", name)
    assert ran(["-W", "error", path], tmp_path)
    with open(path, encoding="utf-8") as f:
        assert f.read().count("# %%") >= 6
    if importlib.util.find_spec("matplotlib"):
        picture = (tmp_path / name.replace(".py", ".png")).read_bytes()
        assert picture.startswith(b"\x89PNG") and len(picture) > 20000  # an empty one has 4 kB


def test_a_machine_axis_from_its_published_file_to_named_causes(tmp_path):
    """Causes and sizes published by Janot, Gautier, Brunot 2019; the asymmetry is theirs as well."""
    measured = os.path.join(ROOT, "..", "shared", "data", "emps", "emps_train.csv")
    block, = blocks("docs/python.md", "py")
    assert block.count("\n") <= 20
    if "SOAK" not in os.environ:
        pytest.skip("make soak: the suite of measurements finds the same")
    if not os.path.exists(measured):
        pytest.skip("no measurements in ../shared/data")
    os.symlink(measured, tmp_path / "emps_train.csv")
    told = ran(["-W", "error", "-c", block], tmp_path)
    found = {kind: float(value) for kind, value in
             re.findall(r"cause: (\w+) at slide: \w+ = (\S+)", told)}
    assert found == {"coulomb_friction": pytest.approx(20.3935, rel=0.02),
                     "viscous_friction": pytest.approx(203.5034, rel=0.02),
                     "viscous_asymmetry": pytest.approx(-0.181, abs=0.02)}


def test_the_types_are_those_of_the_module():
    with open(os.path.join(BUILD, "python", "stein", "__init__.pyi"), encoding="utf-8") as f:
        stub = f.read()
    for name in stein.__all__:
        assert re.search(rf"^(class|def) {name}\b", stub, re.M), name
    kinds = {n: getattr(stein, n) for n in stein.__all__ if inspect.isclass(getattr(stein, n))}
    typed = {n: re.search(rf"^class {n}\b.*?(?=^class |^def |\Z)", stub, re.M | re.S)[0] for n in kinds}
    for name, kind in kinds.items():
        for member in vars(kind):
            if not member.startswith("_") and not hasattr(kind, "_fields"):
                assert re.search(rf"\b{member}\b", typed[name]), f"{name}.{member}"
    for name in ("load", "fit", "diagnose", "plan"):
        told = re.search(rf"^def {name}\((.*?)\) ->", stub, re.M | re.S)[1]
        for argument in inspect.signature(getattr(stein, name)).parameters:
            assert re.search(rf"^    {argument}:", told, re.M), f"{name}({argument})"
    assert compile(stub, "__init__.pyi", "exec")


def test_a_type_checker_finds_the_types_to_be_those_of_the_module(tmp_path):
    if "SOAK" not in os.environ:
        pytest.skip("make soak: half of the time of all others")
    if importlib.util.find_spec("mypy") is None:
        pytest.skip("run: apt-get install mypy")
    (tmp_path / "mypy.ini").write_text("[mypy]\nignore_missing_imports = True\n")
    done = subprocess.run(
        [sys.executable, "-m", "mypy.stubtest", "stein", "--ignore-missing-stub", "--concise",
         "--mypy-config-file", "mypy.ini"], cwd=tmp_path, capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONPATH": os.path.join(BUILD, "python")})
    told = done.stdout.splitlines()  # of private modules only the imports are checked
    assert [line for line in told if not line.startswith("stein._")] == []


def test_everything_is_told():
    for name in stein.__all__:
        thing = getattr(stein, name)
        assert thing.__doc__, name
        for member, value in vars(thing).items() if inspect.isclass(thing) else ():
            if not member.startswith("_") and callable(value):
                assert value.__doc__, f"{name}.{member}"
