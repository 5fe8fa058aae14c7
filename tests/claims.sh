# SPDX-License-Identifier: GPL-3.0-or-later
# claims.sh - what the tests of commands share: sourced by tests/test_*.sh with the folder $dir made.
# One line for each claim that fails; the script ends with a count of both.
XDG_CACHE_HOME=$dir/cache
export XDG_CACHE_HOME
LC_ALL=C
export LC_ALL
passed=0 failed=0

pass() { passed=$((passed + 1)); }
fail() { failed=$((failed + 1)); echo "FAILED: $*"; sed 's/^/    /' "$dir/err" | head -n 4; }
# claim CODE TEXT COMMAND...: the command exits with CODE; output in $dir/out, $dir/err
claim() {
    code=$1 text=$2
    shift 2
    "$@" >"$dir/out" 2>"$dir/err" </dev/null
    got=$?
    if [ "$got" = "$code" ]; then pass; else fail "$text (exit $got, expected $code)"; fi
}
# says TEXT PATTERN: standard error of the last claim has the pattern
says() { if grep -q -e "$2" "$dir/err"; then pass; else fail "$1"; fi; }
