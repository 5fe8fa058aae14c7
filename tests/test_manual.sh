#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_manual.sh - the manual pages have the text of --help and are formatted without warnings;
# every public function has one; the completions of bash, zsh and fish contain every command, every
# option, and the names of the numbers of a file.
set -u
. tests/claims.sh

${MAKE:-make} -s manual shared VARIANT="$variant" >"$dir/err" 2>&1
ok "make manual shared" $?

# words of a text, one a line: what is left when filling and indenting are taken away
words() { tr -s ' \t\n' '\n\n\n' <"$1" | sed '/^$/d'; }

commands=$("$stein" help --commands)
for page in stein.1 steingen.1 $(for c in $commands; do echo "stein-$c.1"; done) \
    $(cd include/stein && for h in *.h; do echo "stein_$h.3"; done) stein_models.h.3; do
    file=$B/man/$page
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
# ---- section 3: what the headers declare and say
nm -D --defined-only "$B/libstein.so" "$B/libsteinlab.so" | sed -n 's/.* T \([a-z_0-9]*\).*/\1/p' | sort -u >"$dir/exported"
while read -r f; do
    [ "$(cat "$B/man/$f.3")" = ".so man3/$(sed -n 's/^\.so man3\///p' "$B/man/$f.3")" ] && echo "$f"
done <"$dir/exported" 2>"$dir/err" >"$dir/found"
test -s "$dir/found" && cmp -s "$dir/exported" "$dir/found"
ok "each of $(wc -l <"$dir/exported") public functions has a page" $?
for f in stein_step lab_diagnose stein_normal_force; do
    to=$B/man/$(sed 's/^\.so man3\///' "$B/man/$f.3")
    sed '/^\.SH SYNOPSIS/,$d' "$to" | grep -qw "$f" && sed '1,/^\.SH DECL/d' "$to" | grep -q "$f("
    ok "$f is where its page leads" $?
done
sed 's/\\e/\\/g; s/\\-/-/g' "$B/man/stein_sim.h.3" >"$dir/page"
for t in 'One step of dt, split at located events. On ENONFINITE, ESINGULAR or ECHATTER the state is that' \
    'ESTALE (the equations' 'double tolerance; /\* of a step' 'Link with \\fI-lstein\\fR'; do
    grep -q "$t" "$dir/page"
    ok "stein_sim.h(3) has: $t" $?
done
grep -q 'lsteinlab' "$B/man/stein_lab.h.3"
ok "stein_lab.h(3) names its library" $?

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
    gives "integrators complete" "controlled dp5 implicit rk4" stein strike models/pendulum.yaml --integrator ""
    gives "also behind =" "dp5" stein strike models/pendulum.yaml --integrator = d
    gives "parameters complete" "rod.centre.z" "$stein" strike models/pendulum.yaml --set rod.c
    gives "files complete" "models/pendulum.yaml" stein strike models/pend
    gives "folders complete for -o of a study" "models/drive models/robotran models/strokes models/swing" stein study m.yaml -o models/
    gives "a time does not" "" stein strike m.yaml --until ""
fi

# the other shells, as a person has them: PROGRAM is found in the path
PATH=$(cd "$B" && pwd):$PATH
export PATH
if command -v fish >/dev/null 2>&1; then
    # fish_gives EXPECTED LINE
    fish_gives() {
        got=$(fish --no-config -c "source $B/stein.fish; complete -C '$2'" 2>"$dir/err" | cut -f 1 | tr '\n' ' ')
        test "$got" = "$1${1:+ }"
        ok "fish completes '$2' (completed: $got)" $?
    }
    fish_gives "controlled dp5 implicit rk4" "stein strike --integrator "
    fish_gives "rod.centre.z" "stein strike models/pendulum.yaml --set rod.c"
    fish_gives "models/drive/ models/robotran/ models/strokes/ models/swing/" "stein study m.yaml -o models/"
    fish_gives "" "stein strike --until "
    for c in $commands; do
        fish_gives "$c" "stein $c"
        "$stein" help "$c" | sed -n '/^OPTIONS/,/^OUTPUT/s/^    \(-., \)\{0,1\}\(--[a-z-]*\).*/\2/p' | sort >"$dir/options"
        fish --no-config -c "source $B/stein.fish; complete -C 'stein $c --'" | cut -f 1 | sort >"$dir/got"
        cmp -s "$dir/options" "$dir/got"
        ok "fish completes all options of $c" $?
    done
else
    echo "test_manual: no fish, its completion is not tested"
fi
if command -v zsh >/dev/null 2>&1; then
    mkdir "$dir/zsh" && cp "$B/stein.zsh" "$dir/zsh/_stein"
    # lines typed into a terminal, each with a tabulator behind it; what they are then
    cat >"$dir/type.zsh" <<'END'
zmodload zsh/zpty
zpty z zsh -f -i
zpty -w z "PS1=; fpath=($1 \$fpath); autoload -Uz compinit; compinit -u -D; show() { print -r -- \"<<\$BUFFER>>\"; BUFFER= }; zle -N show; bindkey '^X' show; print begun"
zpty -r z out '*begun*begun*'
while read -r line; do
    zpty -n -w z "$line"$'\t\x18'
    zpty -r z out '*<<*>>*'
    print -r -- "${${out##*<<}%%>>*}"
done
zpty -d z
END
    {
        for c in $commands; do echo "stein $c"; done
        printf '%s\n' "stein strike --integrator d" "stein strike models/pendulum.yaml --set rod.cen" \
            "stein study m.yaml -o models/robo" "stein strike models/pend" "stein export --fm"
    } >"$dir/typed"
    {
        for c in $commands; do echo "stein $c "; done
        printf '%s\n' "stein strike --integrator dp5 " "stein strike models/pendulum.yaml --set rod.centre.z" \
            "stein study m.yaml -o models/robotran/" "stein strike models/pendulum.yaml " "stein export --fmi="
    } >"$dir/expected"
    timeout 60 zsh -f "$dir/type.zsh" "$dir/zsh" <"$dir/typed" >"$dir/got" 2>"$dir/err"
    diff "$dir/got" "$dir/expected" >"$dir/err"
    ok "zsh completes commands, words, names, folders, files and options" $?
    for c in $commands; do
        "$stein" help "$c" | sed -n '/^OPTIONS/,/^OUTPUT/s/^    \(-., \)\{0,1\}\(--[a-z-]*\).*/\2/p' | sort >"$dir/options"
        sed -n "/^    $c)/,/^        ;;/s/.*'\*\(--[a-z-]*\).*/\1/p" "$B/stein.zsh" | sort >"$dir/got"
        cmp -s "$dir/options" "$dir/got"
        ok "zsh completes all options of $c" $?
    done
else
    echo "test_manual: no zsh, its completion is not tested"
fi
claim 2 "there are no completions of other shells" "$stein" help --completion csh

finish
