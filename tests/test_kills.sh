#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_kills.sh - kill -9 of a fit and of a diagnosis at random times: under a final name there is a
# whole file or none, and a fit goes on from its journal to the same bytes. (test_sweep.sh kills
# sweeps.) KILLS of each.
set -u
. tests/claims.sh
kills=${KILLS:-20}
model=models/pendulum.yaml

# ---- four swings with some noise
for i in 1 2 3 4; do
    begin="rod.initial.position=${i}1.3deg"
    "$stein" simulate $model --until 600ms --every 10ms --set rod.damping=2e-4 --set $begin -o "$dir/all" >"$dir/out" || exit 1
    awk -F, -v s=$i -v begin="${i}1.3 deg" '
        BEGIN { print "# noise angle: 0.1 mrad"; print "# set rod.initial.position: " begin }
        /^#/ { next }
        /^time/ { print $1 "," $2; next }
        { s = (s * 16807 + 11) % 2147483647; printf "%s,%.9f\n", $1, $2 + 1e-4 * (s / 1073741823 - 1) }' "$dir/all" >"$dir/swing$i.csv"
done

data="$dir/swing1.csv $dir/swing2.csv $dir/swing3.csv $dir/swing4.csv"
fit="$model $data --free rod.damping,rod.pendulum.frequency --starts 16 -j 1 --journal $dir/journal"
# what differs from run to run: how long it took
timeless() { sed 's/"seconds": [0-9.e+-]*/"seconds": 0/; s/[0-9.]*&nbsp;s\. The same figures/0 s. The same figures/' "$1"; }

milliseconds() { echo $(($(date +%s%N) / 1000000)); }
begin=$(milliseconds)
claim 0 "a fit" "$stein" fit $fit -o "$dir/fitted.yaml"
fit_takes=$(($(milliseconds) - begin))
rm "$dir/journal"
begin=$(milliseconds)
claim 0 "a diagnosis" "$stein" diagnose $model $data -j 1 -o "$dir/whole"
diagnosis_takes=$(($(milliseconds) - begin))

# kill_once MOST COMMAND...: kill it after up to MOST milliseconds. Leaves its exit code in $code
seed=1788
kill_once() {
    seed=$(((seed * 16807) % 2147483647))
    delay=$(awk -v s=$seed -v most="$1" 'BEGIN { printf "%.3f", s / 2147483647 * most / 1000 }')
    shift
    "$@" >"$dir/out" 2>"$dir/err" &
    pid=$!
    sleep "$delay"
    kill -9 $pid 2>/dev/null
    wait $pid 2>/dev/null
    code=$?
}

# ---- a fit
killed=0 went_on=0
while [ $killed -lt "$kills" ]; do
    [ ! -s "$dir/journal" ] || went_on=$((went_on + 1))
    kill_once "$fit_takes" "$stein" fit $fit -o "$dir/again.yaml"
    if [ -e "$dir/again.yaml" ]; then
        same "a fit that was killed $killed times is the same" "$dir/fitted.yaml" "$dir/again.yaml"
    fi
    if [ $code = 137 ]; then
        killed=$((killed + 1))
    elif [ $code = 0 ]; then
        rm -f "$dir/journal" "$dir/again.yaml"
        fit_takes=$((fit_takes * 9 / 10 + 1)) # too late to kill
    else
        fail "a fit after kill -9 (exit $code)"
        break
    fi
done
rm -f "$dir/again.yaml"
claim 0 "the last fit runs to its end" "$stein" fit $fit -o "$dir/again.yaml"
same "and is the same" "$dir/fitted.yaml" "$dir/again.yaml"

# ---- a diagnosis
for file in diagnosis.json extended.yaml report.html; do timeless "$dir/whole/$file" >"$dir/whole/$file.is"; done
deaths=0
while [ $deaths -lt "$kills" ]; do
    kill_once "$diagnosis_takes" "$stein" diagnose $model $data -j 1 -o "$dir/part"
    for file in diagnosis.json extended.yaml report.html; do
        [ -e "$dir/part/$file" ] || continue
        timeless "$dir/part/$file" >"$dir/is"
        same "$file is whole after $deaths kills" "$dir/whole/$file.is" "$dir/is"
    done
    rm -rf "$dir/part"
    case $code in
    137) deaths=$((deaths + 1)) ;;
    0) diagnosis_takes=$((diagnosis_takes * 9 / 10 + 1)) ;;
    *) fail "a diagnosis (exit $code)"; break ;;
    esac
done

finish "$killed kills of fits, $went_on went on from a journal; $deaths of diagnoses"
