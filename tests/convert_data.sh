#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# convert_data.sh - measurements made by others, rewritten in the form that stein reads.
#
#   sh tests/convert_data.sh DATA FOLDER
#
# DATA holds emps/, ball_drops/, piano_action/ with the files as they were published (see SOURCE.md
# there); absent files are left out. FOLDER gets one CSV file a record:
#   emps_train.csv, emps_pulses.csv      slide_motion [m], slide_force [N] = 35.15065 N/V vir
#   emps_train_1.csv .. _4.csv, pulses   the same, one file a cycle of the programme (6.24 s)
#   ball_NAME_DROP.csv                   height [m], with mass and diameter where they are known
#   piano_*.csv                          raw columns of the sensors, for the audit
#   grand_slow.csv, grand_fast_1..6.csv  key_motion [rad], hammer_travel [mm]: from the key's start until
#                                        the hammer falls back and is caught, by the tables of the
#                                        authors; of the slow one every fifth row
#   grand_plain_*.csv                    the same with a hammer sensor that is taken as linear
# Nothing is filtered, and nothing left out but columns that are no measurements and the pauses.
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

# strokes of the grand: reading of the ADC to travel by the author's tables, straight between their
# points and beyond; the key's travel is measured at its back, 200 mm behind the pin. The tables go
# in steps of 0.4 mm (hammer) and 0.8 mm (key): what they leave, about 0.1 mm, is more than the
# ADC's noise
grand() { # FROM FOLDER NAME BEGIN END [s] EVERY [rows]
    [ -f "$1" ] || return 0
    for how in "" plain_; do
        awk -F, -v begin="$4" -v end="$5" -v every="$6" -v how="$how" '
            function travel(x, table, n, i) {
                for (i = 1; i < n && x > table[i]; i++) { }
                return i - 1 + (x - table[i - 1]) / (table[i] - table[i - 1])
            }
            BEGIN {
                nh = split(".015 .04 .11 .17 .28 .39 .57 .75 .9 1.1", hammer, " ")
                nk = split(".0015 .0035 .0064 .0115 .0165 .026 .0365 .057 .081 .145 .225 .365 .57 .81 1", key, " ")
                hammer[0] = key[0] = 0
                print "# source: Zweigle, Piano-Data, kawai_E4_hammer_key_2kHz, from " begin " s"
                print "# trigger: unsynchronised"
                print "# noise hammer_travel: 0.1 mm"
                print "time [s],key_motion [rad],hammer_travel [mm]"
            }
            $1 ~ /^[0-9]/ {
                t = row * 0.0005
                row++
                if (t < begin || t > end || row % every) next
                h = ($1 - 0.69) / 0.29
                k = ($2 - 0.3) / 0.58
                printf "%.4f,%.7f,%.5f\n", t - begin, 12.7e-3 / 16 * travel(k, key, nk) / 0.2,
                       3.97 * (how == "" ? travel(h, hammer, nh) / 10 : h)
            }' "$1" >"$2/grand_$how$3.csv"
    done
}

emps "$data/emps/emps_train.csv" "$out/emps_train.csv"
emps "$data/emps/emps_test_pulses.csv" "$out/emps_pulses.csv"
balls "$data/ball_drops/ball_drops.csv" "$data/ball_drops/balls.txt" "$out"
piano=$data/piano_action
raw "$piano/kawai_E4_hammer_key_2kHz.csv" "$out/piano_hammer_key.csv" 2000 "hammer_adc keyback_adc"
raw "$piano/kawai_E4_keyback_2kHz_fast_slow.csv" "$out/piano_keyback.csv" 2000 keyback_adc
raw "$piano/kawai_A4_hammer_16kHz_fast.csv" "$out/piano_hammer_fast.csv" 16000 hammer_adc
raw "$piano/kawai_A4_hammer_16kHz_slow.csv" "$out/piano_hammer_slow.csv" 16000 hammer_adc
strokes=$piano/kawai_E4_hammer_key_2kHz.csv
grand "$strokes" "$out" slow 16.7 18.38 5
grand "$strokes" "$out" fast_1 24.952 25.045 1
grand "$strokes" "$out" fast_2 27.758 27.803 1
grand "$strokes" "$out" fast_3 33.554 33.6 1
grand "$strokes" "$out" fast_4 34.921 34.968 1
grand "$strokes" "$out" fast_5 36.062 36.111 1
grand "$strokes" "$out" fast_6 40.279 40.325 1
