#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_python.sh - `import stein`: the tests of tests/python/, by pytest of the system's Python.
set -u
. tests/claims.sh
python=/usr/bin/python3
[ -x "$python" ] || python=python3
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

# the limited API, and no name of the library that others would see
nm -D --defined-only "$B/python/stein/_stein.abi3.so" | grep -v ' PyInit__stein$' >"$dir/names"
test ! -s "$dir/names"
ok "the module exports nothing but itself ($(tr '\n' ' ' <"$dir/names"))" $?

finish "$(tail -n 1 "$dir/log")"
