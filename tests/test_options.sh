#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_options.sh - options that are seldom used, and every way to use them wrongly: one line with
# the expected value, and exit code 2 before anything is computed or written.
set -u
. tests/claims.sh
action=models/stein1788.yaml pendulum=models/pendulum.yaml data=models/strokes/stroke_01.csv

misuse() { # misuse PATTERN COMMAND OPTIONS...: stein is used wrongly
    pattern=$1
    shift
    asked=$(echo "stein $*" | cut -c 1-90)
    claim 2 "$asked" "$stein" "$@"
    says "$asked is told" "^stein $1: .*$pattern"
    says "$asked: how it is used" "^usage: stein $1 "
    quiet "$asked: nothing is printed"
}
misuse 'every -1 s: expected an interval' simulate $pendulum --every=-1s
misuse 'release -1 s: expected a time from 0 to the end' strike $action --release=-1s
misuse 'release .*: the unit is kg, expected s' strike $action --release 1kg
misuse 'no option --intgrator; did you mean --integrator' simulate $pendulum --intgrator rk4
misuse 'no option -Z' simulate $pendulum -Z
misuse 'no option --wwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwww' \
    simulate $pendulum --wwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwww=1
misuse 'json takes no value' simulate $pendulum --json=1
misuse '-o needs a value' simulate $pendulum -o
misuse 'set =3: expected NAME=VALUE' simulate $pendulum --set =3
misuse 'set rod.mass=: expected NAME=VALUE' simulate $pendulum --set rod.mass=
sets=$(i=0; while [ $i -lt 300 ]; do printf '%s ' --set=rod.mass=200g; i=$((i + 1)); done)
# shellcheck disable=SC2086
misuse 'more than [0-9]* --set' simulate $pendulum $sets

misuse 'which numbers are to be fitted? expected --free' fit $action $data
misuse 'free ,: expected names separated by commas' fit $action $data --free ,
misuse 'free qqqqqqqq: no such parameter in "stein1788" (a number that is 0 in the file is not in its equations: --set qqqqqqqq=... adds it)' \
    fit $action $data --free qqqqqqqq
misuse 'free key.mass,: expected names separated by commas' fit $action $data --free key.mass,
misuse 'profile ,: expected names separated by commas, or flagged' fit $action $data --free key.mass --profile ,
misuse 'prior 0: expected a fraction above 0' fit $action $data --free key.mass --prior 0
misuse 'prior .*: expected no negative number' fit $action $data --free key.mass --prior=-1
misuse 'prior .*unit' fit $action $data --free key.mass --prior 3mm
misuse 'offset .*: the unit is s, expected m' fit $action $data --free key.mass --offset 3s
misuse 'trigger .*: the unit is m, expected s' fit $action $data --free key.mass --trigger 3m
misuse 'initial never: expected free, fixed or auto' fit $action $data --free key.mass --initial never
misuse 'scatter much: expected yes, no or auto' fit $action $data --free key.mass --scatter much
misuse 'starts' fit $action $data --free key.mass --starts 0
misuse 'starts' fit $action $data --free key.mass --starts many

misuse 'what varies? expected --vary' sweep $pendulum
misuse 'vary rod.mass: expected NAME=FROM:TO:COUNT' sweep $pendulum --vary rod.mass
misuse 'vary =3: expected NAME=FROM:TO:COUNT' sweep $pendulum --vary =3
misuse 'shard 2/1: expected I/N' sweep $pendulum --vary rod.mass=200:220:2g --shard 2/1
misuse 'shard 1-2: expected I/N' sweep $pendulum --vary rod.mass=200:220:2g --shard 1-2
misuse 'shard 1/2x: expected I/N' sweep $pendulum --vary rod.mass=200:220:2g --shard 1/2x
misuse 'shard 1/2 computes a part: table and picture come from stein merge' \
    sweep $pendulum --vary rod.mass=200:220:2g --shard 1/2 --journal "$dir/j" -o "$dir/t.csv"
misuse 'shard 1/2 computes a part: table and picture come from stein merge' \
    sweep $pendulum --vary rod.mass=200:220:2g --shard 1/2 --journal "$dir/j" --plot "$dir/p.svg"
misuse 'until 0 s: expected a positive time' sweep $pendulum --vary rod.mass=200:220:2g --until 0
misuse 'release 1 s: expected a time from 0 to the end at 0.1 s' \
    sweep $action --vary pawl.stop_shift=-1:0:2mm --until 0.1s --release 1s
misuse 'plot shows one or two varied parameters, not 3' sweep $pendulum --vary rod.mass=200:220:2g \
    --vary rod.damping=0,1e-4 --vary rod.centre.z=-0.1,-0.2m --plot "$dir/p.svg"
gone "no journal was begun" "$dir/j"

misuse 'held-out ,x.csv: expected files separated by commas' diagnose $action $data -o "$dir/d" --held-out ,x.csv
misuse 'without stiction_peek: no kind, site or class of effects; did you mean stiction_peak' \
    diagnose $action $data -o "$dir/d" --without stiction_peek
misuse 'without ,: expected words separated by commas' diagnose $action $data -o "$dir/d" --without ,
misuse 'without zzzzzzzzzzzz: no kind, site or class of effects (see' diagnose $action $data -o "$dir/d" --without zzzzzzzzzzzz
misuse 'held-out a,: expected files separated by commas' diagnose $action $data -o "$dir/d" --held-out a,
misuse 'free ,: expected names separated by commas' diagnose $action $data -o "$dir/d" --free ,
gone "no folder was made" "$dir/d"
misuse 'one mechanism file at most' effects $pendulum $action
misuse 'odds 1e9: expected a number from 1 to 1e6' plan $action "$dir" --odds 1e9
misuse 'odds 30 mm: expected a number from 1 to 1e6' plan $action "$dir" --odds '30 mm'
misuse 'odds 1: expected a number from 1 to 1e6' plan $action "$dir" --odds 1
misuse 'both want standard output' import models/robotran/piston.mbs --json -o -

# forms that few use
claim 0 "behind -- all is a name" "$stein" simulate --until 1ms -- $pendulum
claim 0 "a value behind its letter" "$stein" simulate $pendulum --until 1ms -o"$dir/letter.csv"
shows "it is a table" '^time \[s\]' "$dir/letter.csv"
claim 0 "a sweep of one shard is a whole sweep" "$stein" sweep $pendulum --vary rod.mass=200,220g --until 2ms \
    --shard 1/1 -o "$dir/one.csv"
claim 0 "and has the rows of one without" "$stein" sweep $pendulum --vary rod.mass=200,220g --until 2ms -o "$dir/all.csv"
if [ "$(grep -vc '^#' "$dir/one.csv")" = 3 ]; then pass; else fail "two rows below a header"; fi
grep -v '^#' "$dir/one.csv" >"$dir/a"
grep -v '^#' "$dir/all.csv" | cmp -s - "$dir/a"
ok "the same rows" $?
claim 0 "a sweep as JSON" "$stein" sweep $pendulum --vary rod.mass=200,220g --until 2ms --json
for part in '"model": *"pendulum"' '"points": *2' '"present": *2' '"failed": *0' '"name": *"rod.mass"' \
    '"unit": *"kg"' '0\.22' '"point": *1' '"status": *"ok"'; do
    shows "JSON of a sweep has $part" "$part"
done
claim 0 "what can be wrong with a mechanism" "$stein" effects $action
shows "it counts the candidates" '^stein1788: [0-9][0-9]* candidates'
shows "with their places and limits" '^ *felt_\|^[a-z_]* .* up to '
claim 0 "the same as JSON" "$stein" effects $action --json
shows "JSON names the model" '"model": *"stein1788"'
shows "and parameters" '"parameters": *\['
claim 1 "effects of a file that is not there" "$stein" effects "$dir/none.yaml"
says "it is named" 'none.yaml'

# a run that goes to its end with a step that is too long may look like a result
claim 3 "a step that is too long" "$stein" simulate models/bouncing_ball.yaml --dt 1ms --until 1s
says "is told with where and when" '^stein: the step of 0\.001 s is too long: at 0\.[0-9]* s contact "floor" needs 0\.000[0-9]* s or less$'
says "and what it has done" '^stein: do not trust the result: errors of the steps add up to .* of the energy is unexplained; use --integrator controlled'
claim 0 "and in a notch" "$stein" strike $action --dt 200us --until 20ms
says "as well" 'the step of 0\.0002 s is too long: at 0\.[0-9]* s contact "notch" needs [0-9.e-]* s or less'
claim 0 "a step that is not" "$stein" simulate models/bouncing_ball.yaml --dt 100us --until 1s
if [ -s "$dir/err" ]; then fail "says nothing"; else pass; fi
claim 0 "help in short" "$stein" -h
cp "$dir/out" "$dir/short"
claim 0 "and in full" "$stein" --help
same "is the same" "$dir/short" "$dir/out"
finish
