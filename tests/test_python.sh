#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_python.sh - `import stein`: the tests of tests/python/, by pytest of the system's Python.
set -u
. tests/claims.sh
python=/usr/bin/python3
[ -x "$python" ] || python=python3
root=$PWD
skip() { echo "test_python: skipped, $1"; exit 0; }
case $variant in release | debug) ;; *) skip "a Python without sanitizers cannot load a module with them" ;; esac
[ -e "$B/python/stein/_stein.abi3.so" ] || skip "the module is not built - run: apt-get install python3-dev && make python"
"$python" -c 'import numpy, pytest' 2>/dev/null || skip "run: apt-get install python3-numpy python3-pytest"

PYTHONDONTWRITEBYTECODE=1
export PYTHONDONTWRITEBYTECODE
"$python" -m pytest -q -p no:cacheprovider --basetemp="$dir/pytest" tests/python >"$dir/log" 2>&1
code=$?
[ $code -eq 0 ] || cat "$dir/log"
ok "tests/python" $code

# the limited API, and no exported name of the library
nm -D --defined-only "$B/python/stein/_stein.abi3.so" | grep -v ' PyInit__stein$' >"$dir/names"
test ! -s "$dir/names"
ok "the module exports nothing but itself ($(tr '\n' ' ' <"$dir/names"))" $?

# the wheel, which other Pythons of this machine can install; it is made of build/ alone
if [ "$B" != build ]; then
    echo "test_python: no wheel of $B"
elif "$python" -c 'import setuptools, wheel, pip' 2>/dev/null; then
    env -u MAKEFLAGS -u MAKELEVEL "$python" -m pip wheel . -q --no-build-isolation --no-deps --no-index \
        -w "$dir/wheel" >"$dir/err" 2>&1
    ok "pip wheel . --no-build-isolation" $?
    "$python" -m pip install -q --no-index --no-deps --target "$dir/site" "$dir"/wheel/*-abi3-*.whl >"$dir/err" 2>&1
    ok "the wheel is installed" $?
    for each in "$python" python3; do
        "$each" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || continue
        (cd "$dir/site" && "$each" -c "import stein
print(stein.load('$root/models/pendulum.yaml').run(0.1)['angle'][-1], stein.__file__)") >"$dir/out" 2>"$dir/err"
        ok "$("$each" --version) runs what is in the wheel" $?
        grep -q "$dir/site" "$dir/out"
        ok "and no other" $?
    done
else
    echo "test_python: no wheel is made - run: apt-get install python3-pip"
fi

finish "$(tail -n 1 "$dir/log")"
