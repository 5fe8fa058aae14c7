#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_cli.sh - the program `stein`: exit codes, JSON, files, messages. Runs from the checkout's root.
# One line for each claim that fails, and a final count.
set -u
. tests/claims.sh
unset CC

if command -v python3 >/dev/null 2>&1; then python=yes; else
    python=; echo "test_cli: no python3, the JSON is not parsed"; fi
# json TEXT EXPRESSION: the last output is one JSON value v and the expression holds
json() {
    [ -n "$python" ] || return 0
    if python3 -c "import json, sys; v = json.load(open(sys.argv[1])); assert $2, v" "$dir/out" \
        2>"$dir/err"; then pass; else fail "$1"; fi
}

# ---- version, help and lists of the program
claim 0 "stein --version" "$stein" --version
shows "the version is a number" '^stein [0-9]*\.[0-9]*\.[0-9]*$'
claim 2 "no command at all is misuse" "$stein"
says "the commands are listed" 'commands:'
claim 2 "an unknown command is misuse" "$stein" chekc models/pendulum.yaml
says "and the nearest is named" 'did you mean check?'
says "and the commands are listed" 'simulate '
claim 0 "stein --help" "$stein" --help
claim 2 "help for an unknown command is misuse" "$stein" help nothing
for command in check generate strike simulate study sweep merge fit diagnose import page; do
    claim 0 "stein $command --help" "$stein" $command --help
    for section in NAME SYNOPSIS DESCRIPTION OPTIONS OUTPUT 'EXIT STATUS' EXAMPLES; do
        shows "the help of $command has $section" "^$section\$"
    done
    if awk 'length > 100 {exit 1}' "$dir/out"; then pass; else fail "$command --help is narrow"; fi
    cp "$dir/out" "$dir/help"
    claim 0 "stein help $command" "$stein" help $command
    same "help $command is $command --help" "$dir/help" "$dir/out"
    claim 2 "$command without a model is misuse" "$stein" $command
    claim 2 "$command refuses an unknown option" "$stein" $command models/pendulum.yaml --jsn
    says "$command names the nearest option" 'did you mean --json?'
done

# ---- options
claim 2 "an option without its value is misuse" "$stein" strike models/pendulum.yaml --until
claim 2 "a flag with a value is misuse" "$stein" check models/pendulum.yaml --json=yes
claim 2 "two models are misuse" "$stein" check models/pendulum.yaml models/pendulum.yaml
claim 2 "an override without = is misuse" "$stein" check models/pendulum.yaml --set nothing
claim 2 "a time needs a unit of time" "$stein" simulate models/pendulum.yaml --until 3kg
claim 2 "a decimal comma is refused" "$stein" simulate models/pendulum.yaml --until 0,3
claim 2 "the duration is positive" "$stein" simulate models/pendulum.yaml --until 0
claim 2 "the step is positive" "$stein" simulate models/pendulum.yaml --dt=-1us
claim 2 "integrators have names" "$stein" simulate models/pendulum.yaml --integrator euler
claim 2 "pictures are .svg or .png" "$stein" simulate models/pendulum.yaml --plot x.pdf
claim 2 "release comes before the end" "$stein" strike models/stein1788.yaml --until 0.1 --release 0.2s
claim 2 "a study needs a folder" "$stein" study models/stein1788.yaml
claim 2 "threads are a number" "$stein" study models/stein1788.yaml -o "$dir/s" -j many
claim 2 "stdout holds one thing" "$stein" simulate models/pendulum.yaml --json -o -

# ---- check
for model in models/*.yaml models/robotran/*.yaml; do
    claim 0 "check $model" "$stein" check "$model"
    claim 0 "check --json $model" "$stein" check "$model" --json
    json "operations of $model" \
        "all(sum(v['operations'][k][o] for o in ('add','mul','neg','div','trig')) == v['operations'][k]['total'] for k in ('M_c','inverse_dynamics','setup'))"
done
claim 0 "check looks at data" "$stein" check models/stein1788.yaml models/strokes/stroke_01.csv
shows "their audit is shown" 'stroke_01.csv: [0-9]* rows'
shows "and that nothing is suspected" 'suspicions (0)'
if grep -q '^operations\|^parameters' "$dir/out"; then fail "the mechanism is not listed again"; else pass; fi
awk -F, '/^#/ || /^time/ { print; next } { print $1 "," $2 "," ($3 == "" ? "" : -$3) }' \
    models/strokes/stroke_01.csv >"$dir/mirrored.csv"
claim 1 "check suspects a sign" "$stein" check models/stein1788.yaml "$dir/mirrored.csv"
shows "with file, column and what would fit" 'mirrored.csv: key_dip: moves against the model; with the opposite sign it fits'
claim 1 "also as JSON" "$stein" check models/stein1788.yaml "$dir/mirrored.csv" --json
shows "with its kind" '"kind": *"sign"'
: >"$dir/empty.csv"
claim 1 "an empty file is no data" "$stein" check models/stein1788.yaml "$dir/empty.csv"
says "which is told" 'empty.csv: no header line'
claim 0 "check takes overrides" "$stein" check models/stein1788.yaml --set pawl.stop_shift=-0.3mm --json
json "and shows them" \
    "[abs(p['value'] + 3e-4) < 1e-18 for p in v['parameters'] if p['name'] == 'pawl.stop_shift'] == [True]"
json "with the names other programs rely on" \
    "{'pawl.stop_shift','pawl.notch_angle','pawl.spring.k','pawl.spring.theta0','load.mass','hammer.mass','key.mass','string.height'} <= {p['name'] for p in v['parameters']}"
json "and channels" \
    "{'time','string_distance','string_force','key_angle','hammer_angle','pawl_angle','hammer_height','key_dip','notch_force','notch_phase'} <= {o['name'] for o in v['outputs']}"
json "and the regulation" \
    "[(d['label'], d['from'], d['to']) for d in v['regulation'] if d['name'] == 'pawl.stop_shift'] == [('stop (dx)', -1.4e-3, 4e-4)]"
claim 1 "an absent file" "$stein" check "$dir/absent.yaml"
says "is named" 'absent.yaml'
says "with the reason" 'No such file or directory'
quiet "and standard output stays empty"
if [ "$("$stein" effects models/stein1788.yaml 2>"$dir/err" | head -n 1 | wc -l)" = 1 ]; then pass; else fail "a list is cut"; fi
if [ -s "$dir/err" ]; then fail "which is no mistake"; else pass; fi
claim 1 "a folder" "$stein" check "$dir"
says "is no file" "$dir: the file cannot be read: Is a directory"
claim 1 "an empty path" "$stein" check ""
says "is told" 'the path of the mechanism file is empty'
if [ "$(id -u)" != 0 ]; then
    cp models/pendulum.yaml "$dir/locked.yaml" && chmod 000 "$dir/locked.yaml"
    claim 1 "a file without permission" "$stein" check "$dir/locked.yaml"
    says "has that as its reason" 'Permission denied'
fi
claim 1 "an override of nothing" "$stein" check models/stein1788.yaml --set pawl.stop_shfit=1mm --json
says "names the nearest" 'pawl.stop_shift'
quiet "and prints no JSON"
mkdir "$dir/kept" && echo kept >"$dir/kept/motion.csv"
claim 3 "a contact too stiff for the step" "$stein" simulate models/bouncing_ball.yaml --dt 10ms --until 1s \
    -o "$dir/kept/motion.csv" --plot "$dir/kept/motion.svg"
says "is named, with time and the step it needs" 't = 0\.2257.* s: contact "floor" is too stiff for steps of 0\.01 s, it needs 0\.000[0-9]* s'
test "$(ls -A "$dir/kept")" = motion.csv && test "$(cat "$dir/kept/motion.csv")" = kept
ok "and the file of before is there, alone and unharmed" $?
claim 3 "a step far too large" "$stein" strike models/stein1788.yaml --dt 1ms -o "$dir/kept/motion.csv"
says "with a place and a hint" 't = 0\.0[0-9]* s: contact "stop" is too stiff for steps of .* it needs [0-9.e-]* s or less'
test "$(cat "$dir/kept/motion.csv")" = kept
ok "and no other file either" $?
claim 1 "a body without inertia" "$stein" simulate models/falling_ball.yaml --set ball.mass=0
says "is told before anything moves" 'falling_ball.yaml:[0-9]*:[0-9]*: the joint ball has no inertia'
claim 1 "friction that turns at no speed" "$stein" simulate models/bouncing_ball.yaml --set floor.friction.vt=0
says "is told with its range" 'floor.friction.vt.*must be greater than zero'
cat >"$dir/bad.yaml" <<'YAML'
mechanism: bad
bodies:
  rod: {joint: R y, mas: 1 kg}
  bob: {joint: Q z, mass: 82 m}
YAML
claim 1 "a bad file" "$stein" check "$dir/bad.yaml"
says "is told by line" 'bad.yaml:3:'
says "in all its places" 'bad.yaml:4:'
claim 1 "a bad file is not simulated" "$stein" simulate "$dir/bad.yaml"

# ---- generate
claim 0 "generate makes its folder" "$stein" generate models/pendulum.yaml -o "$dir/a/b"
shows "and prints the path" "^$dir/a/b/pendulum.c\$"
claim 0 "generate --json" "$stein" generate models/pendulum.yaml -o "$dir/c" --json
json "names the file" "v['model'] == 'pendulum' and v['file'].endswith('/c/pendulum.c') and len(v['equations']) == 16"
same "the same file gives the same bytes" "$dir/a/b/pendulum.c" "$dir/c/pendulum.c"
claim 1 "a folder that cannot be made" "$stein" generate models/pendulum.yaml -o "$dir/bad.yaml/x"
says "is named" "$dir/bad.yaml/x"

# ---- strike and simulate
claim 0 "a stroke" "$stein" strike models/stein1788.yaml --json
json "has the keys other programs rely on" \
    "set(v) == {'model','outcome','escapement','impact','impacts','free_flight','forced_escapement','peak_string_force','rearmed','final','undetermined','errors','energy','trusted'} and set(v['escapement']) == {'time','height'} and set(v['impact']) == {'time','speed'}"
json "is in SI units" "v['outcome'] == 'struck' and 0.03 < v['impact']['time'] < 0.1 and v['rearmed'] is True"
cp "$dir/out" "$dir/stroke.json"
claim 0 "the same stroke" "$stein" simulate models/stein1788.yaml --json --every 0 -o "$dir/stroke.csv"
same "is the same to the byte, recorded or not" "$dir/stroke.json" "$dir/out"
claim 0 "a stroke that misses" "$stein" strike models/stein1788.yaml --set pawl.stop_shift=-2.5mm --json
json "has null for what did not happen" "v['outcome'] == 'missed_notch' and v['escapement'] is None"
claim 0 "a mechanism without stroke" "$stein" simulate models/pendulum.yaml --until 0.2s --json
json "is simulated" "set(v) == {'model','final','undetermined','errors','energy','trusted'} and v['trusted'] and abs(v['final']['time'] - 0.2) < 1e-15"
claim 0 "dp5 with its own step" "$stein" simulate models/pendulum.yaml --integrator=dp5 --dt 2ms --until 200ms --json
json "arrives at the same place" "abs(v['final']['time'] - 0.2) < 1e-15"
claim 1 "no load, no release" "$stein" simulate models/pendulum.yaml --release 1s
says "and says so" 'no load'
claim 3 "a spring of 1e308 N/m is a numerical failure" "$stein" simulate models/bouncing_ball.yaml --dt 1s --until 9s --set floor.normal.c=1e308N/m
says "with joint and time" 'joint "ball".* t = '
claim 3 "a hundredfold step for a stroke too" "$stein" strike models/stein1788.yaml --dt 1s --until 9s --json
quiet "and prints no JSON"

claim 0 "a table" "$stein" strike models/stein1788.yaml --set pawl.stop_shift=-0.3mm --until 80ms --every 1ms -o "$dir/t.csv"
shows "its path is told" "^$dir/t.csv\$"
if grep -q '^# set pawl.stop_shift: -0.3mm$' "$dir/t.csv"; then pass; else fail "overrides are in the table"; fi
if grep -q '^time \[s\],string_distance \[m\],' "$dir/t.csv"; then pass; else fail "the header has units"; fi
if [ "$(grep -vc '^#' "$dir/t.csv")" = 82 ]; then pass; else fail "81 rows and a header"; fi
claim 0 "the same table" "$stein" strike models/stein1788.yaml --set pawl.stop_shift=-0.3mm --until 80ms --every 1ms -o "$dir/t2.csv"
same "has the same bytes" "$dir/t.csv" "$dir/t2.csv"
claim 0 "a table on standard output" "$stein" strike models/stein1788.yaml --set pawl.stop_shift=-0.3mm --until 80ms --every 1ms -o -
same "is the same table" "$dir/t.csv" "$dir/out"
says "and the summary goes to standard error" 'escapement'
claim 0 "/dev/stdout is standard output" "$stein" strike models/stein1788.yaml --set pawl.stop_shift=-0.3mm --until 80ms --every 1ms -o /dev/stdout
same "as well" "$dir/t.csv" "$dir/out"

# ---- driven by a file
awk 'BEGIN {print "time [ms],push [N m]"; for (i = 0; i <= 50; i++) print 4 * i "," 0.2 * sin(i / 5)}' >"$dir/push.csv"
claim 0 "an input driven by a file" "$stein" simulate models/pendulum.yaml --drive "$dir/push.csv" --until 0.2s --json
json "moves otherwise" "abs(v['final']['time'] - 0.2) < 1e-15"
claim 1 "a mechanism file is nothing to import" "$stein" import models/pendulum.yaml -o "$dir/x.yaml"
says "which is told" 'pendulum.yaml:1:[0-9]*: this is no XML file, expected a ROBOTRAN project'
printf 'time [s],push [N m]\n0,1\n1,x\n' >"$dir/push.csv"
claim 1 "a drive that is no number" "$stein" simulate models/pendulum.yaml --drive "$dir/push.csv"
says "is told by line" 'push.csv:3:'

# ---- places that cannot be written
claim 1 "a full disk" "$stein" simulate models/pendulum.yaml --until 1s -o /dev/full
says "is told" '/dev/full'
if "$stein" check models/pendulum.yaml >/dev/full 2>"$dir/err"; then fail "a full stdout is an error"; else pass; fi
claim 1 "an absent folder" "$stein" simulate models/pendulum.yaml --until 1s -o "$dir/none/x.csv"
says "is told" 'none/x.csv'
claim 1 "a folder in the place of a file" "$stein" simulate models/pendulum.yaml --until 1s -o "$dir"
mkdir "$dir/locked"
: >"$dir/locked/here"
chmod 555 "$dir/locked"
if [ "$(id -u)" = 0 ]; then
    echo "test_cli: run by root, folders without write permission are not tested"
else
    claim 1 "a locked folder" "$stein" simulate models/pendulum.yaml --until 1s -o "$dir/locked/x.csv"
fi
if [ -z "$(find "$dir" -name '*.part-*')" ]; then pass; else fail "no part of a file stays behind"; fi

# ---- equations that are not built in, in a cache that has none of them
kept=$XDG_CACHE_HOME XDG_CACHE_HOME=$dir/cache
sed 's/joint: R -y/joint: R y/' models/pendulum.yaml >"$dir/mine.yaml"
CC=no-such-compiler
export CC
claim 1 "without a compiler" "$stein" simulate "$dir/mine.yaml" --until 0.1s
says "it is told what to run" 'apt-get install gcc'
unset CC
claim 0 "other equations are compiled" "$stein" simulate "$dir/mine.yaml" --until 0.1s --json
cp "$dir/out" "$dir/mine.json"
CC=no-such-compiler
export CC
claim 0 "and kept" "$stein" simulate "$dir/mine.yaml" --until 0.1s --json
same "with the same result" "$dir/mine.json" "$dir/out"
claim 0 "a number needs no compiler" "$stein" simulate "$dir/mine.yaml" --until 0.1s --set rod.mass=0.3kg
claim 1 "another structure does" "$stein" simulate "$dir/mine.yaml" --until 0.1s --set rod.centre.x=1mm
CC='   '
claim 1 "a compiler without a name" "$stein" simulate "$dir/mine.yaml" --until 0.1s --set rod.centre.x=1mm
says "it is told so" "compiler's name is empty"
CC="env A=1 B=1 C=1 D=1 E=1 F=1 G=1 H=1 I=1 J=1 K=1 L=1 M=1 N=1 O=1 P=1 Q=1 R=1 S=1 T=1 cc"
claim 0 "a compiler of many words" "$stein" simulate "$dir/mine.yaml" --until 0.1s --set rod.centre.x=1mm
unset CC
claim 0 "and is compiled by itself" "$stein" simulate "$dir/mine.yaml" --until 0.1s --set rod.centre.y=1mm
"$stein" simulate "$dir/mine.yaml" --until 0.1s --set rod.at.z=1mm --json >"$dir/one" 2>"$dir/err" &
"$stein" simulate "$dir/mine.yaml" --until 0.1s --set rod.at.z=1mm --json >"$dir/two" 2>>"$dir/err"
two=$?
if wait $! && [ $two = 0 ]; then pass; else fail "two processes compile at the same time"; fi
same "and agree" "$dir/one" "$dir/two"
XDG_CACHE_HOME=$kept

# ---- plots
if command -v gnuplot >/dev/null 2>&1; then
    claim 0 "a stroke as SVG" "$stein" strike models/stein1788.yaml --until 0.1s --plot "$dir/s.svg"
    if grep -q '</svg>' "$dir/s.svg"; then pass; else fail "the SVG is complete"; fi
    claim 0 "a run as PNG" "$stein" simulate models/double_pendulum.yaml --until 1s --plot "$dir/it's a.png"
    if [ -s "$dir/it's a.png" ]; then pass; else fail "quotes in a path"; fi
else
    echo "test_cli: no gnuplot, plots are not tested"
fi

# ---- study
claim 0 "a study" "$stein" study models/stein1788.yaml -o "$dir/study"
shows "ends with its files" "^$dir/study/facts.json\$"
if grep -q '</html>' "$dir/study/study.html"; then pass; else fail "the page is complete"; fi
if [ "$(grep -c '<svg' "$dir/study/study.html")" = 10 ]; then pass; else fail "ten pictures in it"; fi
if grep -q -e 'src=' -e '@import' "$dir/study/study.html"; then fail "the page loads nothing"; else pass; fi
for figure in figure09 figure11 figure12 figure13 notch_angle repetition sensitivity tolerance; do
    if [ -s "$dir/study/$figure.svg" ] && [ -s "$dir/study/$figure.csv" ]; then pass; else
        fail "$figure with its data"; fi
done
for table in notch_angle regulation_stop regulation_stiffness regulation_angle repetition tolerance; do
    if grep -v '^#' "$dir/study/$table.csv" | grep -q -e ',,' -e ',$'; then fail "$table: a cell is empty"; else pass; fi
done
shows "compares with the paper" 'escapement height at dx = 0 *2.2 mm *[0-9.]* mm'
cp "$dir/study/facts.json" "$dir/out"
json "facts.json holds the facts" "len(v) > 10 and all({'fact','paper','simulated','within','calibrated','ok'} == set(f) for f in v)"
if [ "$(grep -vc '^#' "$dir/study/sweep.csv")" = 38 ]; then pass; else fail "37 strokes and a header"; fi
claim 0 "the facts alone, on one thread" "$stein" study models/stein1788.yaml --facts -j 1 -o "$dir/study1" --json
json "is summed up in JSON" "v['facts'] > 10 and len(v['off']) == v['facts'] - v['ok']"
same "has the same sweep" "$dir/study/sweep.csv" "$dir/study1/sweep.csv"
if [ -e "$dir/study1/study.html" ]; then fail "the facts alone are no report"; else pass; fi
claim 1 "a study into a file" "$stein" study models/stein1788.yaml -o "$dir/bad.yaml"
says "is told before any work" 'bad.yaml'
claim 1 "a study into a device" "$stein" study models/stein1788.yaml -o /dev/full
says "is told" '/dev/full'
claim 1 "a study of something else" "$stein" study models/pendulum.yaml -o "$dir/study2"
says "says what it lacks" 'pawl.stop_shift'

finish
