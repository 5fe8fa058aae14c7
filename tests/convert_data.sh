#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# convert_data.sh - measurements made by others, rewritten in the form that stein reads.
#
#   sh tests/convert_data.sh DATA FOLDER
#
# DATA holds emps/, ball_drops/, piano_action/ with the files as they were published (see SOURCE.md
# there); what is absent is left out. FOLDER gets one CSV file a record:
#   emps_train.csv, emps_pulses.csv      slide_motion [m], slide_force [N] = 35.15065 N/V vir
#   emps_train_1.csv .. _4.csv, pulses   the same, one file a cycle of the programme (6.24 s)
#   ball_NAME_DROP.csv                   height [m], with mass and diameter where they are known
#   piano_*.csv                          raw columns of the sensors, for the audit
# Nothing is filtered, scaled or left out but the columns that are no measurements.
set -eu
[ $# = 2 ] || { echo "usage: $0 DATA FOLDER" >&2; exit 2; }
data=$1
out=$2
mkdir -p "$out"
LC_ALL=C
export LC_ALL

emps() { # FROM TO
    [ -f "$1" ] || return 0
    awk -F, -v source="$(basename "$1")" '
        NR == 1 {
            print "# source: EMPS benchmark, Janot, Gautier, Brunot 2019, " source
            print "# trigger: unsynchronised"
            print "time [s],slide_motion [m],slide_force [N]"
            next
        }
        { printf "%s,%s,%.8f\n", $1, $3, 35.15065 * $4 }' "$1" >"$2"
    awk -v to="${2%.csv}" '
        /^#/ || /^time/ { head = head $0 "\n"; next }
        {
            file = to "_" (int(row / 6240) + 1) ".csv"
            if (row % 6240 == 0) printf "%s", head >file
            print >file
            row++
        }' "$2"
}

# weight in ounces (28.349523125 g) and circumference as in balls.txt, whose names differ a little
balls() { # BALL_DROPS.CSV BALLS.TXT FOLDER
    [ -f "$1" ] && [ -f "$2" ] || return 0
    awk -v out="$3" '
        function plain(s) {
            s = tolower(s)
            gsub(/[^a-z0-9]/, "", s)
            sub(/whiffle/, "wiffle", s)
            return s
        }
        FNR == NR {
            if (FNR > 1 && NF == 3 && $2 != "??") { ounces[plain($1)] = $2; around[plain($1)] = $3 }
            next
        }
        FNR == 1 { FS = ","; next }
        {
            split($0, cell, ",")
            name = cell[1]
            gsub(/[^A-Za-z0-9]/, "_", name)
            file = out "/ball_" name "_" cell[2] ".csv"
            if (!(file in begun)) {
                begun[file] = 1
                key = plain(cell[1])
                if (!(key in ounces)) sub(/ball$/, "", key)
                print "# source: de Silva, Higdon, Brunton, Kutz 2020, " cell[1] ", drop " cell[2] >file
                if (key in ounces) {
                    printf "# set ball.mass: %.9g g\n", 28.349523125 * ounces[key] >file
                    printf "# set ball.diameter: %.9g mm\n", 10 * around[key] / 3.14159265358979 >file
                }
                print "# trigger: unsynchronised" >file
                print "time [s],height [m]" >file
            }
            print cell[3] "," cell[4] >file
        }' "$2" "$1"
}

raw() { # FROM TO RATE NAMES  - rows without a time get one
    [ -f "$1" ] || return 0
    awk -F, -v rate="$3" -v names="$4" '
        BEGIN {
            n = split(names, name, " ")
            printf "# trigger: unsynchronised\ntime [s]"
            for (i = 1; i <= n; i++) printf ",%s [1]", name[i]
            print ""
        }
        $1 ~ /^[-+.0-9]/ { printf "%.9g,%s\n", row / rate, $0; row++ }' "$1" >"$2"
}

emps "$data/emps/emps_train.csv" "$out/emps_train.csv"
emps "$data/emps/emps_test_pulses.csv" "$out/emps_pulses.csv"
balls "$data/ball_drops/ball_drops.csv" "$data/ball_drops/balls.txt" "$out"
piano=$data/piano_action
raw "$piano/kawai_E4_hammer_key_2kHz.csv" "$out/piano_hammer_key.csv" 2000 "hammer_adc keyback_adc"
raw "$piano/kawai_E4_keyback_2kHz_fast_slow.csv" "$out/piano_keyback.csv" 2000 keyback_adc
raw "$piano/kawai_A4_hammer_16kHz_fast.csv" "$out/piano_hammer_fast.csv" 16000 hammer_adc
raw "$piano/kawai_A4_hammer_16kHz_slow.csv" "$out/piano_hammer_slow.csv" 16000 hammer_adc
