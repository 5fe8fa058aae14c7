#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_linearise.sh - stein linearise: text, JSON, CSV, states that are stated, and what is refused.
set -u
. tests/claims.sh
pendulum=models/pendulum.yaml action=models/stein1788.yaml bar=models/four_bar.yaml
csv=$dir/linear.csv

claim 0 "a pendulum" "$stein" linearise $pendulum
shows "about its equilibrium" '^pendulum, linearised about the equilibrium next to its initial state$'
shows "by exact derivatives" 'by exact derivatives; largest acceleration there '
shows "with its frequency, which the file states" '^ *-0\.00863968 *+- 6\.47168 *i *1\.03 *0\.001335 *rod (100 %)$'
shows "A and B" '^ *d/dt qd\.rod *-41\.8827 *-0\.0172794 *115\.196$'
shows "C and D" '^ *tip_x *0\.35 *0 *0$'

claim 0 "a pendulum that stands" "$stein" linearise $pendulum --at rod=180deg
shows "about what is stated" 'linearised about the stated state$'
shows "falls" '^ *6\.46305 *grows in s *0\.1547 '
claim 0 "a torque holds it aside" "$stein" linearise $pendulum --at rod=30deg --input "push=0.18178911 N m"
claim 3 "a state that is none" "$stein" linearise $pendulum --at initial
says "is told with its acceleration" '"pendulum" is not in equilibrium: "rod" accelerates with -20.9.* rad/s^2 in this state, expected 1.* at most'
quiet "nothing is printed"
claim 3 "a motion that changes" "$stein" linearise $pendulum --at rod=0,rod.speed=1rad/s --set rod.damping=0
says "is told" 'moves unsteadily'

claim 0 "a linkage" "$stein" linearise $bar -o "$csv" --set crank.mass=0.6kg
shows "by differences, and how good they are" 'by differences (it has loops or couplings), good to [0-9.]*e-1[0-9]'
shows "the table has the way" '^# by: differences (it has loops' "$csv"
shows "what was set" '^# set crank\.mass: 0\.6kg$' "$csv"
shows "where all joints are" '^# at rocker: -\{0,1\}[0-9.]* rad$' "$csv"
shows "the mode" '^# mode: .* Hz, damping ratio .*, most in crank$' "$csv"
shows "columns with units" '^row,q\.crank \[rad\],qd\.crank \[rad/s\],motor \[N m\]$' "$csv"
shows "rows with units" '^d/dt qd\.crank \[rad/s^2\],-[0-9.]*,0,[0-9.]*$' "$csv"
shows "outputs" '^tracer_x \[m\],[-0-9.]*,0,0$' "$csv"
claim 0 "a table alone" "$stein" linearise $bar -o -
shows "on standard output" '^row,q'
if grep -q linearised "$dir/out"; then fail "nothing else is there"; else pass; fi
claim 0 "a torque moves the equilibrium" "$stein" linearise $bar --input "motor=0.1 N m"
shows "to another angle" '^ *crank  *4\.5[0-9]* rad'
claim 3 "a linkage where it is stated" "$stein" linearise $bar --at crank=100deg,crank.speed=0
says "is in no equilibrium there" '"four_bar" is not in equilibrium: "[a-z]*" accelerates'
claim 1 "a position that the loop does not reach" "$stein" linearise models/slider_crank.yaml --at piston=0.5m
says "is told" 'stein: .*\(closed\|allow\)'

claim 0 "an action" "$stein" linearise $action
shows "frequencies of its parts" '^ *-389\.1[0-9]* *+- 556\.4[0-9]* *i *108\.0[0-9]* *0\.573[0-9]* *pawl'
claim 0 "the same as JSON" "$stein" linearise $action --json
for part in '"model": "stein1788"' '"exact": true' '"why": null' '"residual": ' '"states": \[' '"prescribed": false' \
    '"inputs": \[' '"unit": "N"' '"A": \[' '"modes": \[' '"kind": "oscillates"' '"edges": \[\]' '"exact": false'; do
    shows "JSON has $part" "$part"
done
claim 0 "balls that just touch" "$stein" linearise models/newtons_cradle.yaml
shows "are told" '! contact hit is at its edge'
claim 0 "a key that is moved" "$stein" linearise models/grand_action.yaml
shows "is a coordinate, not a mode" '^ *key *0 rad, moved by an input$'

misuse() { # misuse PATTERN OPTIONS...: used wrongly
    pattern=$1
    shift
    claim 2 "linearise $*" "$stein" linearise "$@"
    says "linearise $*: is told" "^stein linearise: .*$pattern"
}
misuse 'at somewhere: expected equilibrium, initial, or JOINT=VALUE' $pendulum --at somewhere
misuse 'at rot=1: "pendulum" has no such joint' $pendulum --at rot=1
misuse 'at rod=1m: "1m": the unit is m, expected rad' $pendulum --at rod=1m
misuse 'at rod.spede=1: "pendulum" has no such joint' $pendulum --at rod.spede=1
misuse 'input pull=1: "pendulum" has no such input' $pendulum --input pull=1
misuse 'input push: expected NAME=VALUE' $pendulum --input push
misuse 'both want standard output' $pendulum --json -o -
finish
