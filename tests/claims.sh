# SPDX-License-Identifier: GPL-3.0-or-later
# claims.sh - shared by tests/test_*.sh; each begins with it, from the checkout's root. One line for
# each claim that fails; `finish` ends the script with a count of both.
#
#   $B, $stein       what was built, the program; $variant and $san: how, for make and a compiler
#   $dir             a folder of the script's own, gone when it ends
#   XDG_CACHE_HOME   beside the products: equations are compiled once for all tests
script=${0##*/} script=${script%.sh}
B=${STEIN_BUILD:-build}
stein=$B/stein
variant=release san=
case ${B##*/} in *-*) variant=${B##*-} ;; esac
case $variant in san) san='-fsanitize=address,undefined' ;; esac
dir=$(mktemp -d "${TMPDIR:-/tmp}/stein-${script#test_}-XXXXXX") || exit 1
trap 'chmod -R u+w "$dir"; rm -rf "$dir"' EXIT
trap 'exit 1' HUP INT TERM
mkdir -p "$B" && XDG_CACHE_HOME=$(cd "$B" && pwd)/cache
export XDG_CACHE_HOME
LC_ALL=C
export LC_ALL
passed=0 failed=0

pass() { passed=$((passed + 1)); }
fail() {
    failed=$((failed + 1))
    echo "FAILED: $*"
    [ ! -f "$dir/err" ] || sed 's/^/    /' "$dir/err" | head -n 4
}
# ok TEXT STATUS: a command ended with 0
ok() { if [ "$2" -eq 0 ]; then pass; else fail "$1"; fi; }
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
# shows TEXT PATTERN [FILE]: standard output of the last claim, or the file, has the pattern
shows() { if grep -q -e "$2" "${3:-$dir/out}"; then pass; else fail "$1"; fi; }
# quiet TEXT: standard output of the last claim is empty
quiet() { if [ -s "$dir/out" ]; then fail "$1"; else pass; fi; }
# same TEXT A B: two files have the same bytes
same() { if cmp -s "$2" "$3"; then pass; else fail "$1"; fi; }
# gone TEXT FILE: there is no such file
gone() { if [ ! -e "$2" ]; then pass; else fail "$1"; fi; }
# counted FILE: claims that another script has counted in the last line of its output; failures are
# printed
counted() {
    last=$(tail -n 1 "$1")
    case $last in
    *[!0-9\ ]* | "") # it broke off
        cat "$1"
        last="0 1"
        ;;
    *) sed '$d' "$1" ;;
    esac
    passed=$((passed + ${last% *})) failed=$((failed + ${last#* }))
}
# finish [MORE]: the last line of a script, with more of what it did
finish() {
    echo "$script: $passed passed, $failed failed${1:+ ($1)}"
    [ "$failed" = 0 ]
}
