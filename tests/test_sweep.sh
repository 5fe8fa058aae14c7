#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_sweep.sh - stein sweep and stein merge from outside: shards, kills, full disks, bad ranges. Runs
# from the checkout's root. One line for each claim that fails, and a final count.
# Everything is compared byte by byte with one undisturbed sweep on one thread.
set -u
. tests/claims.sh
kills=${KILLS:-40} # make soak: 1000
model=models/stein1788.yaml

# one_line: standard error of the last claim is a single line, standard output empty
one_line() {
    if [ "$(wc -l <"$dir/err")" = 1 ] && [ ! -s "$dir/out" ]; then pass; else fail "$1: one line"; fi
}

# short strokes: 240 of them take about half a second
grid="--vary pawl.stop_shift=-1.2:0.2:30mm --vary hammer.mass=2.4:3.1:8g --until 5ms --release 4ms"
sweep() {
    # shellcheck disable=SC2086
    "$stein" sweep $model $grid "$@"
}

# ---- one table, however it was computed
claim 0 "a sweep on one thread" sweep -j 1 -o "$dir/serial.csv"
claim 0 "a sweep on four threads" sweep -j 4 -o "$dir/threads.csv"
same "threads leave no trace" "$dir/serial.csv" "$dir/threads.csv"
claim 0 "a sweep to standard output" sweep
same "the table is the same there" "$dir/serial.csv" "$dir/out"
# the head states the computation
shows "with steps of controlled error" '^# tolerance string_distance: 1e-07 m$' "$dir/serial.csv"
claim 0 "a sweep with fixed steps" "$stein" sweep $model --vary pawl.stop_shift=-0.1,0mm --until 5ms --fixed
shows "says so" '^# integrator: rk4$'
claim 2 "fixed steps have no tolerance" "$stein" sweep $model --vary pawl.stop_shift=0,1mm --fixed --tolerance string_distance=1um
sed 's/integrator: rk4/integrator: dp5/' models/pendulum.yaml >"$dir/dp5.yaml"
claim 0 "a sweep with the other integrator" "$stein" sweep "$dir/dp5.yaml" --vary rod.mass=0.2,0.3 --until 5ms
shows "says so" '^# integrator: dp5$'
for i in 1 2 3; do
    claim 0 "shard $i of 3" sweep --shard $i/3 --journal "$dir/part$i" -j 2
    if [ $i = 2 ]; then
        claim 1 "a merge of two shards of three" "$stein" merge "$dir/part1" "$dir/part2" -o "$dir/two.csv"
        says "what is missing is told" '80 of 240 points are missing: 2 5 8'
        gone "nothing was written" "$dir/two.csv"
        claim 0 "unless --partial is given" "$stein" merge --partial "$dir/part1" "$dir/part2" \
            -o "$dir/two.csv"
    fi
done
claim 0 "the merge of three shards" "$stein" merge "$dir/part3" "$dir/part1" "$dir/part2" \
    -o "$dir/merged.csv"
same "shards leave no trace" "$dir/serial.csv" "$dir/merged.csv"
claim 0 "a finished journal" sweep --journal "$dir/part1" -o "$dir/rest.csv"
says "is not computed again" '80 points were in'
same "and completes the table" "$dir/serial.csv" "$dir/rest.csv"

if command -v parallel >/dev/null 2>&1; then
    # shellcheck disable=SC2086
    seq 4 | PARALLEL_HOME="$dir" parallel --will-cite "$stein" sweep $model $grid -j 1 --shard {}/4 \
        --journal "$dir/gnu{}" >"$dir/out" 2>"$dir/err" &&
        "$stein" merge "$dir"/gnu? -o "$dir/parallel.csv" >"$dir/out" 2>>"$dir/err"
    same "GNU parallel over four shards" "$dir/serial.csv" "$dir/parallel.csv"
else
    echo "test_sweep: no GNU parallel (apt-get install parallel), its one-liner is not tried"
fi

# ---- kill -9 at random points: every other one as soon as a point more stands in the journal, so
# that however slow the machine is, sweeps die in the middle of their work and not only at its start
lines() { grep -c '^[0-9].* \*[0-9a-f]\{8\}$' "$dir/journal" 2>/dev/null || true; }
done_kills=0 rounds=0 lost=0 halves=0
for delay in $(awk 'BEGIN { srand(1788); for (i = 0; i < 5000; i++)
        printf "%.3f\n", 0.005 + 0.055 * rand() }'); do
    [ $done_kills -lt "$kills" ] || break
    before=$(lines)
    # shellcheck disable=SC2086
    "$stein" sweep $model $grid -j 2 --journal "$dir/journal" -o "$dir/killed.csv" >"$dir/out" \
        2>"$dir/err" &
    pid=$!
    if [ $((done_kills % 2)) = 1 ]; then
        polls=0
        while now=$(lines); [ "${now:-0}" -le "${before:-0}" ] && [ $polls -lt 400 ] && kill -0 $pid 2>/dev/null; do
            polls=$((polls + 1))
            sleep 0.005
        done
    else
        sleep "$delay"
    fi
    kill -9 $pid 2>/dev/null
    wait $pid 2>/dev/null
    code=$?
    after=$(lines)
    [ "${after:-0}" -ge "${before:-0}" ] || lost=$((lost + 1))
    [ ! -e "$dir/killed.csv" ] || cmp -s "$dir/serial.csv" "$dir/killed.csv" || halves=$((halves + 1))
    if [ $code = 137 ]; then
        done_kills=$((done_kills + 1))
    elif [ $code = 0 ]; then
        rounds=$((rounds + 1))
        claim 0 "the journal of a sweep that was killed" "$stein" merge "$dir/journal" -o "$dir/m.csv"
        same "has every point, byte for byte" "$dir/serial.csv" "$dir/m.csv"
        rm -f "$dir/journal" "$dir/killed.csv" "$dir/m.csv"
    else
        fail "a sweep that goes on after kill -9 (exit $code)"
        break
    fi
done
claim 0 "the last one runs to its end" sweep -j 2 --journal "$dir/journal" -o "$dir/killed.csv"
same "kills leave no trace" "$dir/serial.csv" "$dir/killed.csv"
if [ $done_kills = "$kills" ]; then pass; else fail "$done_kills kills of $kills"; fi
if [ $lost = 0 ]; then pass; else fail "finished points lost after $lost kills"; fi
if [ $halves = 0 ]; then pass; else fail "half a table after $halves kills"; fi
if [ "$(sort "$dir/journal" | uniq -d | wc -l)" = 0 ]; then pass; else fail "points computed twice"; fi

# ---- a disk that is full in the middle: the journal stops at 8 or 16 KiB, then there is room
(
    trap '' XFSZ
    ulimit -f 16
    sweep --journal "$dir/full" >"$dir/out" 2>"$dir/err"
)
code=$?
if [ $code = 1 ]; then pass; else fail "a full disk (exit $code, expected 1)"; fi
says "a full disk is told" 'full cannot be written: '
claim 0 "and when there is room again" sweep --journal "$dir/full" -o "$dir/resumed.csv"
same "the sweep goes on" "$dir/serial.csv" "$dir/resumed.csv"

# ---- a file that cannot be written is reported in one line
short() {
    "$stein" sweep $model --vary pawl.stop_shift=-1:0:2mm --until 1ms --release 1ms "$@"
}
claim 1 "a table on a full disk" short -o /dev/full
one_line "a table on a full disk"
claim 1 "a journal on a full disk" short --journal /dev/full
one_line "a journal on a full disk"
claim 1 "a folder that is not there" short -o "$dir/none/x.csv"
one_line "a folder that is not there"
claim 1 "a journal in a folder that is not there" short --journal "$dir/none/x"
one_line "a journal in a folder that is not there"
mkdir "$dir/closed" && chmod a-w "$dir/closed"
if [ "$(id -u)" != 0 ]; then
    claim 1 "a folder that is closed" short -o "$dir/closed/x.csv"
    one_line "a folder that is closed"
    claim 1 "a journal in a closed folder" short --journal "$dir/closed/x"
    one_line "a journal in a closed folder"
fi
claim 1 "a journal that is none" short --journal $model
says "is refused" 'is no journal of a sweep'
claim 1 "the journal of another sweep" short --journal "$dir/part1"
says "is refused, with what differs" 'belongs to another sweep: there "# '
one_line "the journal of another sweep"
claim 1 "other options" sweep --journal "$dir/part1" --set key.mass=60g
one_line "other options"
claim 1 "a merge of two sweeps" sh -c "\"$stein\" sweep $model --vary pawl.stop_shift=0,1mm --until 1ms \
    --release 0s --journal \"$dir/b\" >/dev/null 2>&1; \"$stein\" merge \"$dir/b\" \"$dir/part1\""
says "is refused" 'belongs to another sweep'

# ---- bad ranges
for vary in pawl.stop_shift=1:2:0 pawl.stop_shift=a:2:3 pawl.stop_shift=1kg:2kg:3 \
    pawl.stop_shift=1mm:1mm:3 pawl.stop_shift=1:2 pawl.stop_shift=1,,2 pawl.stop_shft=1,2 \
    key.mass=-1:1:3 key.at.x=1,2 pawl.stop_shift=1:2:9999999; do
    claim 2 "--vary $vary" "$stein" sweep $model --vary $vary
    one_line "--vary $vary"
    says "--vary $vary is named" "vary ${vary%%=*}"
done
claim 2 "no --vary" "$stein" sweep $model
claim 2 "a shard without a journal" short --shard 1/2
claim 2 "shard 0" short --shard 0/2 --journal "$dir/s"
claim 2 "no threads" short -j 0
claim 2 "a picture of no known kind" short --plot "$dir/x.jpg"
claim 2 "merge without journals" "$stein" merge
claim 3 "every point fails" "$stein" sweep $model --vary string.height=-80mm --until 1ms --release 0s
claim 0 "one point fails" "$stein" sweep $model --vary string.height=-60,70mm --until 1ms --release 0s

# ---- pictures
if command -v gnuplot >/dev/null 2>&1; then
    claim 0 "a map" "$stein" merge "$dir/part1" "$dir/part2" "$dir/part3" --plot "$dir/map.svg" \
        -o "$dir/merged.csv"
    if grep -q 'escapement height' "$dir/map.svg"; then pass; else fail "the map has a label"; fi
    claim 0 "curves" "$stein" sweep $model --vary pawl.stop_shift=-0.6:0:3mm --until 60ms --release \
        60ms --plot "$dir/curve.svg" -o "$dir/curve.csv"
    if grep -q 'pawl.stop_shift \[mm\]' "$dir/curve.svg"; then pass; else fail "the axis has a unit"; fi
    claim 0 "curves without an event" short --plot "$dir/empty.svg" -o "$dir/empty.csv"
fi

finish "$done_kills kills in $rounds rounds"
