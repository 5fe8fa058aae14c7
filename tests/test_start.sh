#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_start.sh - the first steps with a mechanism of one's own: a file to begin with, its drawing,
# its mistakes shown in place, a check that goes on, a diagnosis in a few lines.
set -u
. tests/claims.sh

# ---- stein new
claim 0 "a file to begin with" "$stein" new "$dir/swing"
shows "its path is printed" "^$dir/swing.yaml\$"
shows "it has the name that was given" '^mechanism: swing$' "$dir/swing.yaml"
shows "its commands are those that work here" "^#  .*  $stein check $dir/swing.yaml\$" "$dir/swing.yaml"
says "as are those that come next" "^  $stein show $dir/swing.yaml -o $dir/swing.svg\$"
mkdir "$dir/two words"
claim 0 "a folder that a shell has to quote" "$stein" new "$dir/two words/swing"
shows "is left out of the commands" "^#  .*  $stein check swing.yaml\$" "$dir/two words/swing.yaml"
if grep -q 'NAME\|FILE\|PROGRAM' "$dir/swing.yaml"; then fail "nothing is left to be named"; else pass; fi
claim 1 "a file that is there stays" "$stein" new "$dir/swing.yaml"
says "and it is told" 'exists already'
claim 2 "a name that no mechanism can have" "$stein" new "$dir/7 swings"
says "is told" 'expected a letter'
gone "nothing is written" "$dir/7 swings.yaml"
claim 1 "a folder that is not there" "$stein" new "$dir/none/swing"
claim 0 "its name as JSON" "$stein" new "$dir/other.yaml" --json
shows "has the file" "\"file\": \"$dir/other.yaml\""
claim 0 "it is in order" "$stein" check "$dir/swing.yaml"
grep '^  # [a-z]*:' "$dir/swing.yaml" | sed 's/^  # //' >"$dir/offers"
if [ "$(wc -l <"$dir/offers")" -ge 3 ]; then pass; else fail "lines are offered to be used"; fi
while read -r offer; do
    word=${offer%%:*}
    sed "s/^  # $word:/    $word:/" "$dir/swing.yaml" >"$dir/used.yaml"
    claim 0 "its line \"$word\" can be used" "$stein" check "$dir/used.yaml"
done <"$dir/offers"

# ---- it runs, and a record of it is diagnosed in at most 12 lines
claim 0 "it runs" "$stein" simulate "$dir/swing.yaml" --every 10ms --set rod.damping=8e-4 -o "$dir/run.csv"
awk -F, 'BEGIN { print "# noise angle: 1 mrad" } /^#/ { next } /^time/ { print $1 "," $2; next }
    { printf "%s,%.9f\n", $1, $2 + 1e-3 * ((n++ * 7919) % 13 - 6) / 3.74 }' "$dir/run.csv" >"$dir/record.csv"
claim 0 "its record is diagnosed" "$stein" diagnose "$dir/swing.yaml" "$dir/record.csv" -o "$dir/found"
if [ "$(wc -l <"$dir/out")" -le 12 ]; then pass; else fail "in 12 lines: $(wc -l <"$dir/out")"; fi
shows "the verdict comes first" '^swing: [a-z_]* ([0-9]* pieces* of 1 record fitted'
shows "the cause has its size" '^cause: [a-z_]* at rod'
shows "the report is named" "^$dir/found/report.html\$"

# ---- stein show: every name of every mechanism, in XML that can be read
for model in models/*.yaml models/robotran/*.yaml; do
    case $model in models/cube.yaml | models/gyroscope.yaml)
        claim 1 "$model moves in space: it is not drawn" "$stein" show "$model" -o "$dir/a.svg"
        continue ;;
    esac
    claim 0 "$model is drawn" "$stein" show "$model" -o "$dir/a.svg"
    "$stein" check "$model" >"$dir/listed"
    sed -n '/^bodies/,/^$/s/^  \([a-z][a-z0-9_]*\) .*/\1/p; /^contacts/,/^$/s/^  \([a-z][a-z0-9_]*\) .*/\1/p
        /^points/,/^$/s/^  \([a-z][a-z0-9_.]*\)$/\1/p; /^notches/,/^$/s/^  \([a-z][a-z0-9_]*\) .*/\1/p
        /^loops/,/^$/{/ times /d;s/^  \([a-z][a-z0-9_]*\) .*/\1/p}' "$dir/listed" |
        while read -r name; do grep -q ">$name</text>" "$dir/a.svg" || echo "$name"; done >"$dir/unnamed"
    test ! -s "$dir/unnamed"
    ok "$model: its parts have their names in it ($(tr '\n' ' ' <"$dir/unnamed"))" $?
    if grep -q 'nan\|inf"' "$dir/a.svg"; then fail "$model: all numbers of the drawing are finite"; else pass; fi
    if command -v python3 >/dev/null 2>&1; then
        python3 -c 'import sys, xml.dom.minidom as m; m.parse(sys.argv[1])' "$dir/a.svg" 2>"$dir/err"
        ok "$model: its drawing is XML" $?
    fi
done
claim 2 "a drawing that is no SVG" "$stein" show "$dir/swing.yaml" -o "$dir/swing.png"
says "is told" 'swing.png: the drawing is an SVG, expected FILE.svg'
sed 's/damping: .*/damping:/' "$dir/swing.yaml" >"$dir/unsaid.yaml"
claim 0 "a number that is not there" "$stein" check "$dir/unsaid.yaml"
says "is a warning" 'unsaid.yaml:[0-9]*:5: warning: "damping" in a body has no value and is left out'
claim 0 "a drawing to standard output" "$stein" show "$dir/swing.yaml"
shows "is an SVG" '^<svg '
claim 0 "at another place" "$stein" show "$dir/swing.yaml" --set rod.initial.position=90deg
"$stein" show "$dir/swing.yaml" >"$dir/first.svg"
if cmp -s "$dir/first.svg" "$dir/out"; then fail "the drawing follows --set"; else pass; fi
claim 2 "one thing for standard output" "$stein" show "$dir/swing.yaml" --json
claim 1 "a drawing that cannot be written" "$stein" show "$dir/swing.yaml" -o "$dir/none/a.svg"

# ---- a mistake is shown in its line
# points TEXT SED LINE CARET: the starter with an edit; line and caret in the printed form
points() {
    sed "$2" "$dir/swing.yaml" >"$dir/bad.yaml"
    claim 1 "$1" "$stein" check "$dir/bad.yaml"
    sed -n '2,3p' "$dir/err" | sed 's/^ *[0-9]* |//; s/^ *|//' >"$dir/shown"
    printf ' %s\n %s\n' "$3" "$4" >"$dir/expected"
    if cmp -s "$dir/expected" "$dir/shown"; then pass; else fail "$1: $(cat "$dir/shown")"; fi
}
points "an unknown key" 's/    mass: 200 g +- 2 g/    mess: 200 g/' '    mess: 200 g' '    ^'
points "an unknown unit" 's/    mass: 200 g +- 2 g/    mass: 200 gr/' '    mass: 200 gr' '              ^'
points "behind letters of two bytes" 's/^about: .*/about: "Grüße" extra/' 'about: "Grüße" extra' '               ^'
claim 1 "of a file that is a pipe nothing is shown" sh -c "sed 's/mass:/mess:/' $dir/swing.yaml | $stein check /dev/stdin"
if grep -q '\^' "$dir/err"; then fail "it was read already"; else pass; fi

# ---- stein check --watch
cp "$dir/swing.yaml" "$dir/watched.yaml"
"$stein" check "$dir/watched.yaml" --watch >"$dir/seen" 2>"$dir/told" &
watcher=$!
# waits_for TEXT PATTERN FILE
waits_for() {
    n=0
    while [ $n -lt 100 ] && ! grep -q -e "$2" "$3"; do
        sleep 0.1
        n=$((n + 1))
    done
    grep -q -e "$2" "$3"
    ok "$1" $?
}
waits_for "it is checked at once" '^operations' "$dir/seen"
sed 's/mass: 200 g/mess: 200 g/' "$dir/swing.yaml" >"$dir/next" && mv "$dir/next" "$dir/watched.yaml"
waits_for "and when it has changed" 'unknown key "mess"' "$dir/told"
shows "which is told" "watched.yaml has changed" "$dir/told"
kill -0 $watcher 2>/dev/null
ok "a mistake does not end it" $?
kill $watcher 2>/dev/null
wait $watcher 2>/dev/null
claim 1 "a file that is not there cannot be watched" "$stein" check "$dir/absent.yaml" --watch

# ---- docs/first-diagnosis.md: its commands one after the other, with the output that it shows
tutorial=docs/first-diagnosis.md work=$dir/first
: >"$dir/printed"
sed -n 's/^    \(build\/stein\|mkdir\) /\1 /p' $tutorial >"$dir/commands"
if [ "$(wc -l <"$dir/commands")" -ge 7 ]; then pass; else fail "$tutorial: its commands are found"; fi
while read -r command; do
    command=$(echo "$command" | sed "s#build/first#$work#g;s#^build/stein#$stein#")
    claim 0 "$tutorial: $command" sh -c "$command"
    sed "s#$work#build/first#g" "$dir/out" >>"$dir/printed"
done <"$dir/commands"
# numbers may differ in later versions, words may not: every number is a # on both sides
figures() { sed 's/-\{0,1\}[0-9][0-9]*\(\.[0-9]*\)\{0,1\}\(e-\{0,1\}[0-9]*\)\{0,1\}/#/g' "$1"; }
figures "$dir/printed" >"$dir/printed_words"
sed -n '/^```text$/,/^```$/p' $tutorial | sed '/^```/d; /^\.\.\.$/d' >"$dir/told"
figures "$dir/told" >"$dir/told_words"
while read -r line; do
    grep -qF -e "$line" "$dir/printed_words"
    ok "$tutorial: \"$line\" is printed" $?
done <"$dir/told_words"
# found VALUE FILE: the b of a diagnosis is within 5 % of it
found() { sed -n 's/^cause: .* b = \([0-9.]*\) .*/\1/p' "$2" | awk -v b="$1" '$1 > 0.95 * b && $1 < 1.05 * b {n++} END {exit n != 1}'; }
found "$(sed -n 's/^cause: .* b = \([0-9.]*\) .*/\1/p' $tutorial)" "$dir/printed"
ok "$tutorial: the size that it tells is found" $?
found "$(sed -n 's/^Viscous friction of \([0-9.]*\) .*/\1/p' $tutorial)" "$dir/printed"
ok "$tutorial: it is the one that was hidden" $?

# ---- records that state the wrong thing: the report has no fit in it, and of two signs none is chosen
sed 's/^outputs:$/&\n  end_x: {point: lever.end, read: x}/' models/swing/swing.yaml >"$dir/both.yaml"
for i in 1 2 3; do
    awk -F, '/^#/ { next } /^time/ { print "time [s],angle [rad],end_x [mm]"; next }
        { printf "%s,%s,%.3f\n", $1, $2, -330 * sin($2) }' models/swing/swing_0$i.csv >"$dir/both_$i.csv"
    awk -F, '/^#/ { next } /^time/ { print "time [s],angle [rad]"; next }
        { printf "%s,%.4f\n", $1, $2 * 57.29577951 }' models/swing/swing_0$i.csv >"$dir/degrees_$i.csv"
done
claim 1 "a channel that is mirrored beside one that is not" "$stein" diagnose "$dir/both.yaml" "$dir"/both_?.csv -o "$dir/both"
shows "both are named" 'angle or end_x: moves against the model'
shows "none is chosen" 'cannot tell which of the two'
if grep -q '^cause' "$dir/out"; then fail "there is no cause"; else pass; fi
gone "and no file changes one" "$dir/both/extended.yaml"
claim 1 "degrees under a title of radians" "$stein" diagnose models/swing/swing.yaml "$dir"/degrees_?.csv -o "$dir/degrees"
shows "nothing was fitted" '^swing: unusable_model (nothing was fitted'
shows "the headline says what is wrong" '<h1>angle is in deg, not in rad</h1>' "$dir/degrees/report.html"
if grep -q 'every candidate\|samples of\|held out' "$dir/degrees/report.html"; then fail "no fit is told of"; else pass; fi
if [ "$(cat "$dir/out" "$dir/err" | grep -c 'do not mean what they say')" = 1 ]; then pass; else fail "the reason is printed once"; fi

# ---- an inertia that was entered about the pin: the cause shows old and new number, errors are in degrees
cat >"$dir/pin.yaml" <<'END'
mechanism: bob
bodies:
  rod:
    joint: R -y
    mass: 300 g +- 1 g
    centre: [0, 0, -400 mm +- 1 mm]
    inertia: {yy: 0.052 kg m^2 +- 0.001 kg m^2}
    damping: 1.5e-3 N m s/rad +- 5e-5 N m s/rad
    points: {end: [0, 0, -600 mm]}
outputs:
  angle: {joint: rod, read: position}
simulation: {dt: 1 ms, until: 20 s}
END
for start in 15 5 30; do
    "$stein" simulate "$dir/pin.yaml" --set rod.inertia.yy=0.004 --set rod.initial.position=${start}deg --every 20ms -o "$dir/run.csv" --format csv-plain >/dev/null 2>&1
    awk -F, -v seed=$start 'BEGIN { srand(seed); print "t;angle (deg)" } NR > 1 {
        line = sprintf("%.3f;%.3f", $1, 57.29577951 * $2 + 0.15 * sqrt(-2 * log(1 - rand())) * cos(6.283185307 * rand()))
        gsub(/\./, ",", line); print line }' "$dir/run.csv" >"$dir/pin_$start.csv"
done
claim 0 "records in degrees" "$stein" check "$dir/pin.yaml" "$dir"/pin_*.csv
shows "are audited in degrees" '^  angle: 1001 samples, -[0-9.]* deg \.\. [0-9.]* deg, noise 0\.[0-9]* deg '
shows "what all have in common is told once" 'titles without a unit, read as time \[s\] (and in 2 records more)$'
claim 0 "an inertia about the pin" "$stein" diagnose "$dir/pin.yaml" "$dir"/pin_*.csv -o "$dir/pin" --explain inertia@rod
shows "the cause has the old and the new number" '^cause: inertia at rod: inertia.yy: 0\.052 -> 0\.00[34][0-9]* kg m^2 (95 %: .* times smaller$'
shows "the error is in the unit of the records" '^held-out error: angle [0-9.]* -> 0\.1[0-9]* deg ([0-9]* -> 2\.[0-9]* mrad), '
shows "a named cause is explained" '^explain: inertia at rod is in the verdict: .* a gain of [0-9.]*, where [0-9]* is enough'
shows "so are its curves" 'angle \[deg\]' "$dir/pin/report.html"
shows "the report has the new number" 'inertia.yy: 0\.052 → 0\.00[34][0-9]* kg m<sup>2</sup> (95 %: ' "$dir/pin/report.html"
if [ "$(grep -c 'titles without a unit' "$dir/pin/report.html")" = 1 ]; then pass; else fail "titles without a unit are told once"; fi
moved=$(sed -n 's/^#   rod.inertia.yy = \([0-9.]*\) .*without the cause inertia at rod.*/\1/p' "$dir/pin/extended.yaml")
[ -n "$moved" ] && grep -q "inertia: {yy: $(echo "$moved" | cut -c 1-6)" "$dir/pin/extended.yaml"
ok "head and body of the extended file agree" $?

# ---- a tracked point that is too far out acts exactly like a gain of its channel: both are named
sed 's/end: \[0, 0, -330 mm\]/end: [0, 0, -345 mm]/; /^  angle:/d' "$dir/both.yaml" >"$dir/far.yaml"
for i in 1 2 3 4; do
    awk -F, '/^#/ { next } /^time/ { print "time [s],end_x [mm]"; next }
        { printf "%s,%.3f\n", $1, 330 * sin($2) }' models/swing/swing_0$i.csv >"$dir/far_$i.csv"
done
claim 0 "a point in the wrong place" "$stein" diagnose "$dir/far.yaml" "$dir"/far_?.csv -o "$dir/far"
if grep -q 'sensor_gain at end_x' "$dir/out"; then
    shows "is told beside the gain" 'a change of lever.end.z' "$dir/out"
    shows "and in the report" 'A wrong lever.end.z of the file acts in exactly the same way' "$dir/far/report.html"
else
    fail "is found as a gain"
fi

# the same records as a phone's tracked positions and as an encoder's counts
sed 's/^outputs:$/&\n  end_x: {point: lever.end, read: x}/' models/swing/swing.yaml >"$dir/phone.yaml"
for i in 1 2 3 4 5 6 7 8; do
    awk -F, '/^#/ { next } /^time/ { print "t [s];end_x (mm)"; next }
        { line = sprintf("%.7f;%.3f", $1, 330 * sin($2)); gsub(/\./, ",", line); print line }' models/swing/swing_0$i.csv >"$dir/phone_$i.csv"
    awk -F, '/^#/ { next } /^time/ { print "time_s,angle_deg"; next }
        { n = $2 * 16384 / 6.283185307; printf "%s,%.5f\n", $1, int(n + (n < 0 ? -0.5 : 0.5)) * 360 / 16384 }' models/swing/swing_0$i.csv >"$dir/encoder_$i.csv"
done
cmp -s "$dir/phone_1.csv" /dev/null || head -n 3 "$dir/phone_1.csv" >"$dir/head"
sed -n '/^t \[s\];end_x/,/^```$/p' $tutorial | sed '/^```/d' | cmp -s - "$dir/head"
ok "$tutorial: a phone's table is as it says: $(tr '\n' ' ' <"$dir/head")" $?
claim 0 "positions of a phone" "$stein" diagnose "$dir/phone.yaml" "$dir"/phone_*.csv -o "$dir/phone"
found 102.3 "$dir/out"
ok "give the same cause" $?
claim 0 "counts of an encoder" "$stein" diagnose models/swing/swing.yaml "$dir"/encoder_*.csv -o "$dir/encoder"
found 102.3 "$dir/out"
ok "give the same cause" $?
finish
