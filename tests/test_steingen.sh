#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_steingen.sh - the program that writes equations: output file, overrides, and one line with an
# exit code for every misuse.
set -u
. tests/claims.sh
gen=$B/steingen
pendulum=models/pendulum.yaml

claim 0 "equations go to standard output" "$gen" $pendulum
cp "$dir/out" "$dir/expected"
shows "they export the model" 'const stein_model stein_model_pendulum'
for how in "-o $dir/a.c" "--output=$dir/b.c" "--output $dir/c.c" "-o $dir/d/"; do
    mkdir -p "$dir/d"
    # shellcheck disable=SC2086
    claim 0 "steingen $how" "$gen" $pendulum $how
    quiet "nothing is printed with $how"
done
for file in a.c b.c c.c d/pendulum.c; do same "$file has the same bytes" "$dir/$file" "$dir/expected"; done
rm "$dir/d/pendulum.c"
claim 0 "a folder without its stroke" "$gen" -o "$dir/d" $pendulum
same "a folder gets NAME.c" "$dir/d/pendulum.c" "$dir/expected"
claim 0 "behind -- all is a name" "$gen" -o "$dir/e.c" -- $pendulum
cp $pendulum "$dir/-odd.yaml"
( cd "$dir" && case $gen in /*) g=$gen ;; *) g=$OLDPWD/$gen ;; esac && "$g" -o f.c -- -odd.yaml ) && pass || fail "a file called -odd.yaml"
grep -v "^ \* input " "$dir/f.c" >"$dir/g.c"
grep -v "^ \* input " "$dir/expected" | cmp -s - "$dir/g.c"
ok "and it is the same mechanism" $?

claim 0 "a number is changed first" "$gen" $pendulum --set rod.mass=213g
shows "its new value is in the tables" '0\.213'
claim 0 "and with --set=" "$gen" --set=rod.mass=213g $pendulum
shows "its new value is in the tables, too" '0\.213'
claim 0 "help" "$gen" --help
shows "help names the options" '--output PATH'
claim 0 "help, short" "$gen" -h

usage() { # usage TEXT PATTERN ARGUMENTS...: refused as a wrong use, in one line
    text=$1 pattern=$2
    shift 2
    claim 2 "$text" "$gen" "$@"
    says "$text is told" "$pattern"
    quiet "$text: no equations"
    if [ "$(wc -l <"$dir/err")" = 1 ]; then pass; else fail "$text: one line"; fi
}
usage "no model" 'no model given'
usage "two models" 'one model at a time, unexpected.*pendulum' $pendulum $pendulum
usage "an unknown option" 'unknown option.*--colour' --colour $pendulum
usage "-o without a path" '-o expects a path' $pendulum -o
usage "--set without anything" '--set expects NAME=VALUE, got.*nothing' $pendulum --set
usage "--set without a value" '--set expects NAME=VALUE, got.*rod.mass' $pendulum --set rod.mass
usage "--set without a name" '--set expects NAME=VALUE, got.*=3' $pendulum --set =3

claim 1 "a file that is not there" "$gen" "$dir/none.yaml"
says "it is named" 'none.yaml'
claim 1 "a number that is not there" "$gen" $pendulum --set rod.weight=3
says "it is named with what was meant" 'rod.weight'
claim 1 "a unit that does not fit" "$gen" $pendulum --set rod.mass=3m
says "it is told" 'rod.mass.*the unit is m, expected kg'
printf 'mechanism: m\nbodies: {b: {joint: T z}}\n' >"$dir/bad.yaml"
claim 1 "a mechanism that cannot move" "$gen" "$dir/bad.yaml"
says "its place is told" 'bad.yaml:2:[0-9]*: '
echo previous >"$dir/kept.c"
claim 1 "a bad mechanism leaves the file as it was" "$gen" "$dir/bad.yaml" -o "$dir/kept.c"
if [ "$(cat "$dir/kept.c")" = previous ]; then pass; else fail "the previous file is intact"; fi
for to in "$dir/none/x.c" "$dir/none/" /dev/full; do
    claim 1 "equations to $to" "$gen" $pendulum -o "$to"
    says "$to is named" "$(basename "$to")"
done
"$gen" $pendulum >/dev/full 2>"$dir/err"
if [ $? = 1 ]; then pass; else fail "standard output to a full disk"; fi
says "standard output is named" 'standard output cannot be written'
claim 0 "a device is written to" "$gen" $pendulum -o /dev/null
if [ -c /dev/null ]; then pass; else fail "/dev/null is still a device"; fi
finish
