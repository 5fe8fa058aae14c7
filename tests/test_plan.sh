#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_plan.sh - stein plan: from strokes over a diagnosis with a rival to the stroke that separates
# them, whose file can be simulated and diagnosed; errors of a diagnosis.json are reported with
# file, line and field; exit codes; files appear whole.
set -u
. tests/claims.sh

# ---- a wheel on a spiral spring, with a drag; strokes at one angle, with noise
model=$dir/wheel.yaml
cat >"$model" <<'END'
mechanism: wheel
bodies:
  wheel:
    joint: R y
    mass: 0.4 kg
    inertia: {yy: 2.1e-3 kg m^2 +- 1 %}
    spring: {k: 0.83 N m/rad +- 1 %}
    initial: {position: 0.2 rad}
inputs:
  turn: {motion: wheel}
outputs:
  angle: {joint: wheel, read: position}
  rate: {joint: wheel, read: speed}
simulation: {dt: 0.2 ms, until: 0.7 s}
END
# film FILE SEED ANGLE
film() {
    "$stein" simulate "$model" --set wheel.drag=1e-4 --set wheel.initial.position="$3" --every 5ms \
        -o "$dir/raw.csv" >/dev/null 2>"$dir/err" || fail "a stroke is simulated"
    awk -F, -v seed="$2" -v angle="$3" '
        BEGIN { srand(seed); print "# set wheel.initial.position: " angle
                print "# noise angle: 1 mrad"; print "time [s],angle [rad]" }
        /^#/ || /^time/ { next }
        { g = sqrt(-2 * log(1 - rand())) * cos(6.283185307 * rand())
          printf "%s,%.9f\n", $1, $2 + 1e-3 * g }' "$dir/raw.csv" >"$1"
}
for k in 1 2 3 4 5 6; do film "$dir/s$k.csv" $k "0.2 rad"; done
claim 0 "a diagnosis of strokes at one angle" "$stein" diagnose "$model" "$dir"/s?.csv -o "$dir/o"
cause=$(sed -n 's/^cause: \([a-z_]*\).*/\1/p' "$dir/out") # any of the two
shows "has a rival" 'cannot separate it from' "$dir/out"
shows "and the next experiment" '"experiment": "wheel.initial.position = 100 mrad"' "$dir/o/diagnosis.json"
diagnosis=$dir/o/diagnosis.json

# ---- what somebody measured is known
for k in 1 2 3 4 5 6; do
    { echo '# known wheel.inertia.yy: 2.1e-3 kg m^2'; cat "$dir/s$k.csv"; } >"$dir/k$k.csv"
done
claim 0 "strokes that state a number" "$stein" diagnose "$model" "$dir"/k?.csv -o "$dir/k"
if tr -d '\n' <"$dir/k/diagnosis.json" | grep -q '"kind": "inertia",[^}]*"place": "wheel".*"every record states it"'; then pass; else fail "is not under suspicion"; fi

# ---- the plan
claim 0 "a plan" "$stein" plan "$model" "$diagnosis" -o "$dir/p"
shows "names the cause" "^wheel: $cause at wheel, or " "$dir/out"
for kind in quadratic_drag viscous_friction; do shows "names both" "$kind at wheel" "$dir/out"; done
first() { sed -n '/^experiment /{n;p;}' "$dir/out"; }
if first | grep -q 'wheel.initial.position = 100 mrad'; then pass; else fail "the other angle is best"; fi
shows "its columns have units" '^experiment  *\[records\] .*9 of 10 above  how$'
shows "and a line that tells how to read them" '^The first row separates them best\. Needed: .* 0 tells nothing\.$'
shows "compares with the same again" 'the same again' "$dir/out"
shows "offers the prescribed motion" 'turn ' "$dir/out"
if grep -q -e 'string removed' -e 'load' -e 'camera tilt' "$dir/out"; then fail "what it lacks is proposed"; else pass; fi
for f in plan.json next_stroke.csv next_rival.csv; do
    if [ -s "$dir/p/$f" ]; then pass; else fail "$f is written"; fi
done
if [ "$(ls "$dir/p" | wc -l)" -eq 3 ]; then pass; else fail "nothing else is"; fi
cp "$dir/out" "$dir/table"
claim 0 "on one thread" "$stein" plan "$model" "$diagnosis" -j 1
if [ "$(sed '/simulated/,$d' "$dir/out")" = "$(sed '/simulated/,$d' "$dir/table")" ]; then pass; else fail "the same"; fi
claim 0 "as JSON" "$stein" plan "$model" "$diagnosis" --json
shows "one object" '"experiments": \[' "$dir/out"
if [ "$(head -c 1 "$dir/out")" = "{" ]; then pass; else fail "and nothing else"; fi
claim 0 "other odds" "$stein" plan "$model" "$diagnosis" --odds 20
shows "are told" 'odds of 20 to 1' "$dir/out"

# ---- two causes at once: they are one hypothesis, and so is a rival with the cause beside it
for k in 1 2 3 4; do
    awk -F, '/^#/ || /^time/ { print; next } { printf "%s,%.9f\n", $1, 1.06 * $2 }' "$dir/s$k.csv" >"$dir/two$k.csv"
done
claim 0 "strokes with a drag and a gain" "$stein" diagnose "$model" "$dir"/two?.csv -o "$dir/two"
shows "have two causes" '^cause: sensor_gain at angle: '
shows "and a rival of one of them" 'cannot separate it from: .*at wheel'
shows "and the next experiment" '"experiment": "wheel.initial.position = ' "$dir/two/diagnosis.json"
claim 0 "they have a plan" "$stein" plan "$model" "$dir/two/diagnosis.json" -o "$dir/p2"
shows "which names both hypotheses" '^wheel: sensor_gain at angle and [a-z_]* at wheel, or [a-z_]* at wheel and [a-z_]* at [a-z]*'
if first | grep -q 'wheel.initial.position = '; then pass; else fail "another angle separates the drags"; fi
if tr -d ' \n' <"$dir/p2/plan.json" | grep -q '"cause":{"kind":"sensor_gain","place":"angle","beside":\[{"kind":'
then pass; else fail "plan.json has what acts beside"; fi
shows "the record is predicted by both" '^# prediction: sensor_gain at angle and [a-z_]* at wheel, without noise' "$dir/p2/next_stroke.csv"

# ---- a start that nobody stated is estimated; from rest nothing would be seen
for k in 1 2 3 4; do grep -v '^# set' "$dir/s$k.csv" >"$dir/free$k.csv"; done
claim 0 "strokes whose start is not stated" "$stein" diagnose "$model" "$dir"/free?.csv -o "$dir/free"
if grep -q 'cannot separate it from' "$dir/out"; then
    shows "have it in their conditions" '"name": "wheel.initial.position"' "$dir/free/diagnosis.json"
    claim 0 "and a plan" "$stein" plan "$model" "$dir/free/diagnosis.json" -o "$dir/p3"
    shows "with another angle" '^wheel.initial.position = '
    shows "above those so far" 'twice what was set so far'
else
    fail "have rivals"
fi

# ---- its strokes are data
shows "the stroke says its settings" '^# set wheel.initial.position: 0.1 rad' "$dir/p/next_stroke.csv"
claim 0 "the prediction is a stroke for the diagnosis" "$stein" diagnose "$model" "$dir"/s[1-4].csv \
    "$dir/p/next_stroke.csv" --held-out "$dir/s5.csv","$dir/s6.csv" -o "$dir/o2"
shows "which then is sure" "^cause: $cause at wheel" "$dir/out"
if grep -q 'cannot separate it from' "$dir/out"; then fail "and has no rival"; else pass; fi
film "$dir/made.csv" 7 "0.4 rad"
claim 0 "made with what is really there" "$stein" diagnose "$model" "$dir"/s[1-4].csv \
    "$dir/made.csv" --held-out "$dir/s5.csv","$dir/s6.csv" -o "$dir/o3"
shows "it names that" '^cause: quadratic_drag at wheel' "$dir/out"
if grep -q 'cannot separate it from' "$dir/out"; then fail "and nothing else"; else pass; fi
claim 0 "the settings can be simulated" "$stein" simulate "$model" --set 'wheel.initial.position=0.4 rad'
printf 'time [s],turn [rad]\n0,0\n0.1,0.01\n0.2,0.1\n0.3,0.2\n0.4,0.2\n0.7,0.2\n' >"$dir/drive.csv"
claim 0 "a driven input, too" "$stein" simulate "$model" --drive "$dir/drive.csv"

# ---- the command line
claim 2 "a plan needs a diagnosis" "$stein" plan "$model"
claim 2 "and no more" "$stein" plan "$model" "$diagnosis" more
claim 2 "threads are a number" "$stein" plan "$model" "$diagnosis" -j 0
claim 2 "odds are above 1" "$stein" plan "$model" "$diagnosis" --odds 1
says "which is told" 'expected a number'
claim 2 "instruments have names" "$stein" plan "$model" "$diagnosis" --instruments ,
says "which is told" 'expected names of outputs separated by commas, or none'
claim 0 "no further instrument" "$stein" plan "$model" "$diagnosis" --instruments none
if grep -q 'with rate' "$dir/out"; then fail "none is proposed"; else pass; fi
claim 1 "an instrument that is no output" "$stein" plan "$model" "$diagnosis" --instruments angle,speed
says "is named" 'speed'
claim 0 "help" "$stein" plan --help
shows "has a synopsis" 'stein plan \[options\] MODEL\|stein plan MODEL' "$dir/out"
: >"$dir/file"
claim 1 "a folder that cannot be made" "$stein" plan "$model" "$diagnosis" -o "$dir/file/p"
says "is named" "$dir/file"

# ---- a diagnosis.json that is not in order: file, line, field
# broken TEXT PATTERN SED
broken() {
    sed -e "$3" "$diagnosis" >"$dir/broken.json"
    if cmp -s "$diagnosis" "$dir/broken.json"; then fail "$1: the edit does nothing"; fi
    claim 1 "$1" "$stein" plan "$model" "$dir/broken.json" -o "$dir/q"
    says "$1: says where and what" "broken.json:[0-9][0-9]*: .*$2"
    if [ -s "$dir/out" ] || [ -e "$dir/q" ]; then fail "$1: gives no plan"; else pass; fi
}
broken "half a file" 'no JSON' '20,$d'
broken "a field that is missing" '"conditions" is missing' 's/"conditions"/"konditions"/'
broken "a field of an earlier version" '"posterior" is missing' 's/"posterior"/"anterior"/'
broken "a text for a number" '"interval": expected a number' 's/"interval": .*,/"interval": "often",/'
broken "no number at all" '"until": expected a number' 's/"until": .*,/"until": null,/'
broken "an interval of nothing" '"interval": expected more than 0' 's/"interval": .*,/"interval": 0,/'
broken "a verdict that there is not" '"verdict"' 's/"missing_effect"/"guilty"/'
broken "a kind that there is not" 'no gravitation' 's/"quadratic_drag"/"gravitation"/'
broken "another mechanism's channel" '"elbow" is not an output' 's/"name": "angle"/"name": "elbow"/'
broken "another mechanism's number" 'is not a parameter' 's/"name": "wheel.spring.k"/"name": "spring.k"/'
broken "a correlation of 3" 'from -1 to 1' 's/"correlation": \[\]/"correlation": []/; s/^ *0\.99[0-9]*$/3/'
echo 'not json: [' >"$dir/broken.json"
claim 1 "no JSON" "$stein" plan "$model" "$dir/broken.json"
echo '[1, 2]' >"$dir/broken.json"
claim 1 "another JSON" "$stein" plan "$model" "$dir/broken.json"
says "what it should be" 'expected a diagnosis.json'
claim 1 "an absent file" "$stein" plan "$model" "$dir/absent.json"
says "is named" 'absent.json'
sed -e '/"indistinguishable": \[/,/^  \],/c\  "indistinguishable": [],' "$diagnosis" >"$dir/alone.json"
claim 0 "a cause without rivals" "$stein" plan "$model" "$dir/alone.json"
shows "leaves nothing to separate" "^wheel: $cause at wheel, and no rival: there is nothing to separate\$"
claim 0 "the same as JSON" "$stein" plan "$model" "$dir/alone.json" --json
shows "has no experiment" '"experiments": \[\]'
claim 1 "the diagnosis of another mechanism" "$stein" plan models/stein1788.yaml "$diagnosis"
says "is told" 'another mechanism'

# ---- before anything is measured
one="0.7 s at 200 Hz with wheel.initial.position=0.2 rad"
claim 0 "a plan before records" "$stein" plan --before "$model" --channels angle --records "$one" -o "$dir/b"
shows "names what can be named" '^viscous_friction at wheel ' "$dir/out"
shows "and what cannot be told from it" '^viscous_friction at wheel .*quadratic_drag at wheel' "$dir/out"
shows "and another channel or start" '^one record more: wheel.initial.speed' "$dir/out"
cp "$dir/b/plan.json" "$dir/b.json"
claim 0 "the same as JSON" "$stein" plan --before "$model" --channels angle --records "$one" --json
if sed '/"seconds"/d' "$dir/out" | cmp -s - "$(sed '/"seconds"/d' "$dir/b.json" >"$dir/b.txt"; echo "$dir/b.txt")"
then pass; else fail "is the same again"; fi
claim 2 "a plan before records with a diagnosis" "$stein" plan --before "$model" "$diagnosis" --channels angle --records "$one"
says "is no such thing" 'MODEL alone'
claim 2 "a plan before no records" "$stein" plan --before "$model" --channels angle
says "misses them" 'needs --channels and --records'
claim 2 "a plan without a diagnosis" "$stein" plan "$model"
says "misses it" 'MODEL DIAGNOSIS.json, or --before MODEL'
claim 1 "records that set what is not there" "$stein" plan --before "$model" --channels angle --records "1 s at 50 Hz with x.y=1"
says "name it" 'has no number "x.y"'

finish
