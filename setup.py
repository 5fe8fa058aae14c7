# SPDX-License-Identifier: GPL-3.0-or-later
"""The wheel: what `make python` builds, which finds libraries and compilers."""
import pathlib
import re
import shutil
import subprocess

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = pathlib.Path(__file__).parent
BUILD = ROOT / "build/wheel"  # nothing is written outside of build/
HEADER = (ROOT / "include/stein/version.h").read_text(encoding="utf-8")


class Make(build_ext):
    """The module with its texts, into the wheel."""

    def run(self):
        subprocess.run(["make", "python"], cwd=ROOT, check=True)
        to = pathlib.Path(self.build_lib) / "stein"
        to.mkdir(parents=True, exist_ok=True)
        for file in (ROOT / "build/python/stein").iterdir():
            if file.is_file():
                shutil.copy(file, to)


BUILD.mkdir(parents=True, exist_ok=True)
setup(
    version=re.search(r'#define STEIN_VERSION +"(.*)"', HEADER)[1],
    packages=[],
    ext_modules=[Extension("stein._stein", [], py_limited_api=True)],
    cmdclass={"build_ext": Make},
    options={"build": {"build_base": str(BUILD)}, "egg_info": {"egg_base": str(BUILD)},
             "bdist_wheel": {"py_limited_api": "cp311"}},
)
