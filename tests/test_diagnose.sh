#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_diagnose.sh - stein diagnose: data that are not in order get one clear message each, with file
# and line, and never a verdict; exit codes; files.
set -u
. tests/claims.sh
model=models/stein1788.yaml

# holds TEXT COMMAND...
holds() { text=$1; shift; if "$@" >/dev/null 2>&1; then pass; else fail "$text"; fi; }

# ---- the command line
claim 2 "a diagnosis needs a folder" "$stein" diagnose $model models/strokes/stroke_01.csv
claim 2 "and data" "$stein" diagnose $model -o "$dir/o"
claim 2 "threads are a number" "$stein" diagnose $model models/strokes/stroke_01.csv -o "$dir/o" -j 0
claim 2 "something has to be left to fit to" "$stein" diagnose $model models/strokes/stroke_01.csv \
    --held-out models/strokes/stroke_01.csv -o "$dir/o"
says "and it is told" 'all records are held out'
claim 2 "files held out have names" "$stein" diagnose $model models/strokes/stroke_01.csv \
    --held-out a.csv,,b.csv -o "$dir/o"
claim 2 "what is to be hidden has to be in the table" "$stein" diagnose $model models/strokes/stroke_01.csv \
    models/strokes/stroke_02.csv -o "$dir/o" --without input,coulomb_frictoin
says "and the nearest kind is told" 'coulomb_frictoin.*did you mean coulomb_friction'
claim 1 "an absent file" "$stein" diagnose $model "$dir/absent.csv" -o "$dir/o"
says "is named" 'absent.csv'
: >"$dir/file"
claim 1 "a folder that cannot be made" "$stein" diagnose $model models/strokes/stroke_0*.csv -o "$dir/file/o"
says "is named" "$dir/file"

# ---- data that are not in order: one message each, and no verdict
# broken TEXT PATTERN FILE SED: ten strokes with FILE edited
broken() {
    text=$1 pattern=$2 file=$3 edit=$4
    rm -rf "$dir/data" "$dir/o"
    mkdir "$dir/data"
    cp models/strokes/stroke_0*.csv models/strokes/stroke_10.csv "$dir/data"
    sed -e "$edit" "models/strokes/$file" >"$dir/data/$file"
    if cmp -s "$dir/data/$file" "models/strokes/$file"; then fail "$text: the edit does nothing"; fi
    claim 1 "$text" "$stein" diagnose $model "$dir"/data/*.csv -o "$dir/o"
    messages=$(grep -c "^$dir/data/$file:[0-9][0-9]*" "$dir/err")
    if [ "$messages" = 1 ]; then pass; else fail "$text: $messages messages with file and line"; fi
    if grep -v "^$dir/data/$file:[0-9]" "$dir/err" | grep -q .; then fail "$text: says more"; else pass; fi
    says "$text: says what" "$pattern"
    if [ -s "$dir/out" ] || [ -e "$dir/o" ]; then fail "$text: gives no verdict"; else pass; fi
}
broken "a wrong unit" ':6:.*kg' stroke_03.csv 's/string_distance \[m\]/string_distance [kg]/'
broken "a time that goes back" ':50:.*goes back' stroke_04.csv '50s/^[^,]*,/-0.004,/'
broken "a constant channel" ':6:.*measures nothing' stroke_05.csv '7,$s/,[^,]*,/,0.0392,/'
broken "nan" ':90:.*nan' stroke_06.csv '90s/,[^,]*$/,nan/'
broken "one sample" ':6:.*1 sample' stroke_07.csv '8,$d'
broken "a channel that the model lacks" ':6:.*key_dipp' stroke_08.csv 's/key_dip \[m\]/key_dipp [m]/; s/noise key_dip/noise key_dipp/'
broken "an unknown setting" ':2:.*load.mas' stroke_09.csv 's/set load.mass/set load.mas/'
broken "a setting with a wrong unit" ':2:.*load.mass' stroke_10.csv 's/\(set load.mass: .*\) g/\1 mm/'
broken "a load that is told wrongly" ':2:.*contradicts.*load.mass' stroke_02.csv \
    's/set load.mass: 100 g/set load.mass: 190 g/'
broken "kilograms for grams" ':2:.*contradicts.*load.mass' stroke_02.csv \
    's/set load.mass: 100 g/set load.mass: 100 kg/'
broken "a sign that is lost" ':1:.*contradicts.*pawl.stop_shift' stroke_01.csv \
    's/stop_shift: -0.7 mm/stop_shift: 0.7 mm/'
broken "metres for millimetres" ':1:.*contradicts.*pawl.stop_shift' stroke_01.csv \
    's/stop_shift: -0.7 mm/stop_shift: -0.7 m/'

claim 1 "settings can be trusted against the evidence" "$stein" diagnose $model "$dir"/data/*.csv \
    -o "$dir/file/o" --trust-settings
if grep -q contradicts "$dir/err"; then fail "then nothing is said of them"; else pass; fi

finish
