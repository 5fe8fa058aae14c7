#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_manual.sh - the manual pages say what --help says and are set without a complaint; the
# completion of bash knows every command, every option, and the names of the numbers of a file.
set -u
. tests/claims.sh

${MAKE:-make} -s manual VARIANT="$variant" >"$dir/err" 2>&1
ok "make manual" $?

# words of a text, one a line: what is left when filling and indenting are taken away
words() { tr -s ' \t\n' '\n\n\n' <"$1" | sed '/^$/d'; }

commands=$("$stein" help --commands)
for page in stein steingen $(for c in $commands; do echo "stein-$c"; done); do
    file=$B/man/$page.1
    test -s "$file"
    ok "$page has a page" $?
    if command -v man >/dev/null 2>&1; then
        LC_ALL=C.UTF-8 MANWIDTH=90 man --warnings -E UTF-8 -l "$file" >"$dir/text" 2>"$dir/err"
        test ! -s "$dir/err"
        ok "man has nothing against $page" $?
    fi
    if command -v mandoc >/dev/null 2>&1; then
        mandoc -T lint -W warning "$file" >"$dir/err" 2>&1
        ok "mandoc has nothing against $page" $?
    fi
done
command -v man >/dev/null 2>&1 || echo "test_manual: no man, the pages are not set by it"
command -v mandoc >/dev/null 2>&1 || echo "test_manual: no mandoc, the pages are not looked at by it"

# every word of --help is in the page, in the same order
if command -v mandoc >/dev/null 2>&1; then
    for c in $commands; do
        mandoc -T ascii -O width=1000 "$B/man/stein-$c.1" | sed 's/.\x08//g' >"$dir/page"
        "$stein" help "$c" >"$dir/help"
        sed '1d;/^SEE ALSO/,$d' "$dir/page" >"$dir/body"
        words "$dir/body" | sed "s/^stein-$c\$/stein $c/; s/[][]//g" | tr ' ' '\n' | sed '/^$/d' >"$dir/a"
        words "$dir/help" | sed 's/[][]//g' | sed '/^$/d' >"$dir/b"
        diff "$dir/a" "$dir/b" >"$dir/err"
        ok "the page of $c has the words of its help" $?
    done
    mandoc -T ascii "$B/man/stein.1" | sed 's/.\x08//g' >"$dir/page"
    for c in $commands; do
        grep -q "stein-$c(1)" "$dir/page"
        ok "stein(1) lists $c" $?
    done
    "$B/steingen" --help >"$dir/help"
    mandoc -T ascii -O width=200 "$B/man/steingen.1" | sed 's/.\x08//g; s/^ *//' >"$dir/page"
    sed 's/^ *//' "$dir/help" | while read -r line; do grep -qxF -e "$line" "$dir/page" || echo "$line"; done >"$dir/err"
    test ! -s "$dir/err"
    ok "the page of steingen has the lines of its help" $?
fi
claim 2 "the page of an unknown command is misuse" "$stein" help --manual nothing

# ---- completion
if ! command -v bash >/dev/null 2>&1; then
    echo "test_manual: no bash, the completion is not tested"
else
    bash -n "$B/stein.bash" 2>"$dir/err"
    ok "the completion is good bash" $?
    # completes WORD...: what may stand in the place of the last word, one a line, sorted
    completes() {
        bash -c 'source "$0" && COMP_WORDS=("$@") && COMP_CWORD=$(($# - 1)) && _stein 2>/dev/null
            printf "%s\n" "${COMPREPLY[@]}"' "$B/stein.bash" "$@" 2>"$dir/err" | sort
    }
    # gives TEXT EXPECTED WORD...
    gives() {
        text=$1 expected=$2
        shift 2
        got=$(completes "$@" | tr '\n' ' ')
        test "$got" = "$expected "
        ok "$text (completed: $got)" $?
    }
    for c in $commands; do
        gives "$c completes" "$c" stein "$c"
        "$stein" help "$c" | sed -n '/^OPTIONS/,/^OUTPUT/s/^    \(-., \)\{0,1\}\(--[a-z-]*\).*/\2/p' | sort >"$dir/options"
        completes stein "$c" -- >"$dir/got"
        cmp -s "$dir/options" "$dir/got"
        ok "all options of $c complete" $?
    done
    gives "integrators complete" "dp5 rk4" stein strike models/pendulum.yaml --integrator ""
    gives "also behind =" "dp5" stein strike models/pendulum.yaml --integrator = d
    gives "parameters complete" "rod.centre.z" "$stein" strike models/pendulum.yaml --set rod.c
    gives "files complete" "models/pendulum.yaml" stein strike models/pend
    gives "folders complete for -o of a study" "models/robotran models/strokes" stein study m.yaml -o models/
    gives "a time does not" "" stein strike m.yaml --until ""
fi

finish
