#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_commands.sh - messages and exit codes of commands with rare results: imports, fits that are
# not sure, sweeps of which all points fail, journals with damage, pictures beside results, limits of
# the command line.
set -u
. tests/claims.sh
action=models/stein1788.yaml pendulum=models/pendulum.yaml

# ---- import
claim 0 "a project to standard output" "$stein" import tests/mbs/arm.mbs
shows "it is a mechanism file" '^mechanism: '
says "what was read is told beside" '^[a-z_0-9]*: [0-9]* bodies, [0-9]* joints, [0-9]* points, [0-9]* loops and links$'
says "what is left out, too" '^left out or changed: '
cp "$dir/out" "$dir/arm.yaml"
left=$(grep -c '^left out' "$dir/err")
claim 0 "a project to a file" "$stein" import tests/mbs/arm.mbs -o "$dir/a.yaml"
shows "the file is named" " links in $dir/a.yaml\$"
same "the same file" "$dir/arm.yaml" "$dir/a.yaml"
claim 0 "a project as JSON" "$stein" import tests/mbs/arm.mbs -o "$dir/b.yaml" --json
for part in '"model": "' "\"file\": \"$dir/b.yaml\"" '"bodies": [0-9]' '"joints": [0-9]' '"left_out": \['; do
    shows "JSON of an import has $part" "$part"
done
if [ -s "$dir/err" ]; then fail "nothing is told beside JSON"; else pass; fi
if [ "$left" -ge 1 ]; then pass; else fail "all that is left out is told: $left"; fi
claim 1 "an inertia that no body has" "$stein" import tests/mbs/rig.mbs -o "$dir/rig.yaml"
says "is refused with what to say" 'inertia of wheel is not possible.*accept or balance'
claim 0 "unless it is to be taken" "$stein" import tests/mbs/rig.mbs -o "$dir/rig.yaml" --inertia accept
says "with a warning" '^warning: .*the inertia of wheel is accepted'
claim 0 "or balanced" "$stein" import tests/mbs/rig.mbs -o "$dir/rig.yaml" --inertia balance
says "with a warning, too" 'the inertia of wheel is balanced'
claim 2 "no other way" "$stein" import tests/mbs/rig.mbs --inertia yes
claim 0 "a mechanism with loops runs" "$stein" simulate "$dir/rig.yaml" --until 5ms -o "$dir/rig.csv"
claim 0 "a robot of ROS" "$stein" import tests/mbs/arm.urdf -o "$dir/urdf.yaml"
shows "with its couplings" '6 bodies, 4 joints, 2 points, 1 loops and links'
claim 0 "a model of MuJoCo" "$stein" import tests/mbs/arm.xml -o "$dir/mjcf.yaml"
shows "with its equalities" '6 bodies, 4 joints, 2 points, 1 loops and links'
claim 1 "no project" "$stein" import $pendulum -o "$dir/c.yaml"
says "is named" 'pendulum.yaml:'
claim 1 "none that is there" "$stein" import "$dir/none.mbs"
says "is named" 'none.mbs'
gone "nothing is written" "$dir/c.yaml"

# ---- fits
"$stein" simulate $pendulum --until 400ms --every 4ms --set rod.damping=2e-4 -o "$dir/all.csv" >/dev/null || exit 1
awk -F, 'BEGIN { print "# noise angle: 1 mrad" } /^#/ { next } /^time/ { print $1 "," $2; next }
    { printf "%s,%.9f\n", $1, $2 + 1e-3 * ((n++ * 7919) % 13 - 6) / 3.74 }' "$dir/all.csv" >"$dir/swing.csv"
claim 0 "a profile" "$stein" fit $pendulum "$dir/swing.csv" --free rod.damping --profile rod.damping --initial fixed \
    --scatter no --starts 1
shows "it is printed" '^ *profile: .* \.\. '
claim 0 "as JSON" "$stein" fit $pendulum "$dir/swing.csv" --free rod.damping --profile rod.damping --initial fixed \
    --scatter yes --starts 1 --json
for part in '"profile": {' '"lo": ' '"status": "converged"' '"reason": null'; do shows "JSON of a fit has $part" "$part"; done
claim 0 "numbers that go together" "$stein" fit $pendulum "$dir/swing.csv" --free rod.damping,rod.mass,rod.pendulum.frequency \
    --profile flagged --initial fixed --starts 1
shows "are told" 'the data hardly'
claim 0 "the same as JSON" "$stein" fit $pendulum "$dir/swing.csv" --free rod.damping,rod.mass,rod.pendulum.frequency \
    --initial auto --scatter auto --starts 1 --json
shows "with the combination" '"rod.pendulum.frequency": -\?[0-9]'
sed '40s/,.*/,3 rad/' "$dir/swing.csv" >"$dir/bad.csv"
claim 1 "a unit among numbers" "$stein" fit $pendulum "$dir/bad.csv" --free rod.damping
says "has its place" 'bad.csv:40:'
awk -F, 'NR > 2 && NR % 9 == 0 { $2 += 0.3 } { print $1 (NF > 1 ? "," $2 : "") }' "$dir/swing.csv" >"$dir/spikes.csv"
claim 0 "bad frames" "$stein" fit $pendulum "$dir/spikes.csv" --free rod.damping --robust --initial fixed --starts 1
shows "lose their weight" 'down-weighted'
claim 2 "a name that is none" "$stein" fit $pendulum "$dir/swing.csv" --free rod.dumping
says "has one that was meant" 'did you mean rod.damping'
claim 2 "too many names" "$stein" fit $pendulum "$dir/swing.csv" --free "$(i=0; while [ $i -lt 300 ]; do printf 'rod.mass,'; i=$((i + 1)); done)rod.mass"
says "are told" '^stein fit: --free rod.mass,rod.mass'

# ---- sweeps, their journals and tables
claim 0 "a sweep to its journal" "$stein" sweep $pendulum --vary rod.mass=200:220:4g --until 2ms --journal "$dir/j" -o "$dir/t.csv"
head -n -2 "$dir/j" >"$dir/part" && echo 'rubbish' >>"$dir/part"
claim 0 "a journal with damage" "$stein" merge "$dir/part" --partial -o "$dir/m.csv"
says "is told with its lines" '^stein: 1 damaged line of the journal counts as not there'
says "and the points that are missing" ' 2-3'
claim 2 "one place for two" "$stein" merge "$dir/j" --json -o -
says "is told" 'both want standard output'
claim 2 "parts in numbers that are too long" "$stein" sweep $pendulum --vary rod.mass=1,2 --shard 1/12345678901
claim 2 "a part of no number" "$stein" sweep $pendulum --vary rod.mass=1,2 --shard x/2
claim 2 "threads in a number that is too long" "$stein" sweep $pendulum --vary rod.mass=1,2 -j 12345678
claim 2 "a release that is no time" "$stein" sweep $action --vary pawl.stop_shift=-1:0:2mm --release soon
claim 2 "a value that a sweep cannot have" "$stein" sweep $pendulum --vary rod.mass=1:2:3s --until 1ms
says "is told" 'kg'
claim 3 "a sweep of which no point ends well" "$stein" sweep $pendulum --vary rod.spring.k=-1e200,-2e200 --until 20ms -o "$dir/x.csv"
vary=$(i=0; while [ $i -lt 40 ]; do printf '%s ' --vary=rod.mass=1; i=$((i + 1)); done)
# shellcheck disable=SC2086
claim 2 "more parameters than vary" "$stein" sweep $pendulum $vary
says "are told" 'more than [0-9]* --vary'

# ---- strokes and the rest
claim 0 "a stroke with a release and a picture" "$stein" strike $action --until 60ms --release 55ms -o "$dir/s.csv"
shows "says it" 're-armed'
shows "the release is noted" 'release' "$dir/s.csv"
claim 0 "a stroke that is driven" sh -c "printf 'time [s],finger [N]\n0,0\n0.05,2\n' >$dir/d.csv; $stein strike $action --until 40ms --drive $dir/d.csv -o $dir/e.csv"
shows "the drive is noted" 'd.csv' "$dir/e.csv"
claim 0 "a stroke that strikes nothing" "$stein" strike $action --until 5ms
claim 2 "an integrator that is none" "$stein" simulate $pendulum --integrator euler
claim 0 "the other one" "$stein" simulate $pendulum --integrator dp5 --until 20ms
claim 2 "an FMU of another time" "$stein" export $pendulum -o "$dir/p.fmu" --fmi 1
claim 1 "equations into a file" "$stein" generate $pendulum -o "$dir/s.csv"
claim 1 "equations of no mechanism" "$stein" generate "$dir/none.yaml" -o "$dir"
claim 0 "the hash as JSON" "$stein" version --hash --json -j 1
shows "of all three" '"core": "[0-9a-f]\{16\}"'
claim 2 "threads that are none" "$stein" version --hash -j none
finish
