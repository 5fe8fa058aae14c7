#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_world.sh - the independent simulator of tests/world and `stein simulate` agree on every
# mechanism, with and without effects; its sets are those that `make hidden WORLD=any` needs.
set -u
. tests/claims.sh
world=$B/world

# near FILE LIMIT: no column of the comparison is further apart than that
near() { awk -v limit="$2" '$2 > limit { bad = 1 } END { exit bad || !NR }' "$1"; }
# agree MECHANISM LIMIT OPTION...: its exact record, and the same from stein with these options
agree() {
    name=$1 limit=$2 folder=$dir/$1
    shift 2
    rate=$(awk -F, '!/^#/ && ++n == 3 { print $1; exit }' "$folder/exact.csv")
    last=$(tail -n 1 "$folder/exact.csv" | cut -d, -f1)
    grep -q '^inputs' "$folder/model.yaml" && set -- "$@" --drive "$folder/exact.csv"
    "$stein" simulate "$folder/model.yaml" --until "${last}s" --every "${rate}s" "$@" \
        -o "$folder/stein.csv" >"$dir/said" 2>"$dir/err" &&
        "$world" compare "$folder/exact.csv" "$folder/stein.csv" >"$folder/apart" &&
        near "$folder/apart" "$limit"
}

# ---- nothing hidden: positions, speeds, forces of both agree
for name in $("$world" list); do
    "$world" exact "$name" --seed 1 -o "$dir/$name" >"$dir/out" 2>"$dir/err" && agree "$name" 1e-6
    ok "$name moves as in stein simulate: $(tr '\n' ' ' <"$dir/$name/apart")" $?
done

# ---- the laws of effects agree with the table, under its names
# laws MECHANISM LIMIT STEP: every STEP-th of its effects, in make soak all of them
laws() {
    "$stein" effects "$dir/$1/model.yaml" --json >"$dir/table.json" 2>"$dir/err"
    { tr -d ' \n' <"$dir/table.json" | tr '{' '\n'; echo; } |
        sed -n 's/^"kind":"\([a-z_]*\)","class":"[a-z_]*","place":"\([^"]*\)".*/\1 \2/p' >"$dir/table"
    # other names of the same
    sed -n 's/^ *"also_called": "\([^"]*\)".*/\1/p' "$dir/table.json" | tr ' ' '\n' |
        sed '/./s/^/wrong_parameter /' | sed '/^$/d' >>"$dir/table"
    "$world" effects "$1" --seed 1 >"$dir/list"
    grep -vxFf "$dir/table" "$dir/list" >"$dir/strange"
    ok "$1: stein effects has all of them, not: $(tr '\n' ' ' <"$dir/strange")" "$([ -s "$dir/strange" ]; echo $((!$?)))"
    i=0
    while read -r effect; do
        if [ -n "${SOAK-}" ] || [ $((i % $3)) = 0 ]; then
            "$world" exact "$1" --seed 1 --hide $i -o "$dir/$1" >"$dir/set" 2>"$dir/err" &&
                agree "$1" "$2" $(cat "$dir/set")
            ok "$1 with $effect: $(tr '\n' ' ' <"$dir/$1/apart")" $?
        fi
        i=$((i + 1))
    done <"$dir/list"
}
laws pendulum 1e-6 2
laws block 1e-6 2
laws ball 1e-6 2
laws crank 5e-6 4 # a spring that begins inside of a fixed step
laws rotary_pendulum 1e-6 6
laws arm_inverse 1e-6 7
laws key_hammer 1e-5 7

# ---- sets
draw() { "$world" draw --level "$1" --seed "$2" -o "$dir/$3" --answer "$dir/$3.json" >"$dir/out" 2>"$dir/err"; }
for level in null small clear gross two law wrong mistake; do
    draw $level 14 $level
    ok "a set of level $level is made" $?
    [ -f "$dir/$level/fit_01.csv" ] && "$stein" check "$dir/$level/model.yaml" >"$dir/out" 2>"$dir/err"
    ok "with a file that stein reads" $?
done
draw clear 14 again
same "a seed gives the same records" "$dir/clear/fit_01.csv" "$dir/again/fit_01.csv"
same "and the same answer" "$dir/clear.json" "$dir/again.json"
draw clear 28 other
if cmp -s "$dir/clear/fit_01.csv" "$dir/other/fit_01.csv"; then fail "seeds are alike"; else pass; fi
if ls "$dir/clear" | grep -vqx -e 'fit_[0-9]*.csv' -e 'held_[0-9]*.csv' -e model.yaml; then fail "a set has more files"; else pass; fi
claim 1 "there is no such mechanism" "$world" exact steam_engine -o "$dir/none"
claim 2 "a level is one of the list" "$world" draw --level loud --seed 1 -o "$dir/none" --answer "$dir/none.json"

# ---- a verdict on a wrong set-up: what exits with 0 is trusted
mkdir "$dir/bench"
ln -s "$(cd "$B" && pwd)/world" "$dir/bench/world"
cat >"$dir/bench/stein" <<END
#!/bin/sh
for last; do :; done
case \$1 in
effects) echo '{"candidates": []}' ;;
diagnose)
    mkdir -p "\$last"
    echo "\$*" >"$dir/asked"
    cp "$dir/verdict.json" "\$last/diagnosis.json"
    exit \$(cat "$dir/status")
    ;;
esac
END
chmod +x "$dir/bench/stein"
# judged VERDICT STATUS LEVEL: one draw, with a program that prints so
judged() {
    echo "{\"verdict\": \"$1\", \"causes\": [], \"indistinguishable\": []}" >"$dir/verdict.json"
    echo "$2" >"$dir/status"
    rm -rf "$dir"/sets/*/*.score
    "$B/hidden" run --world any --levels "$3" --draws 1 --seed 3 --jobs 1 --quiet --build "$dir/bench" \
        -o "$dir/sets" >"$dir/out" 2>"$dir/err"
    ok "a draw of level $3 is judged" $?
}
judged missing_effect 0 wrong
shows "a cause in a wrong set-up is trusted" '^| wrong set-up, given a verdict to be trusted | 0 | 100.0 %'
judged explained 0 wrong
shows "so is that all is explained" '^| wrong set-up, given a verdict to be trusted | 0 | 100.0 %'
judged not_converged 3 wrong
shows "a failure is not" '^| wrong set-up, given a verdict to be trusted | 0 | 0.0 %'
judged unusable_model 1 wrong
shows "nor is what says it" '^| wrong set-up, given a verdict to be trusted | 0 | 0.0 %'
shows "which is counted" '^| - called an unusable model |  | 100.0 %'
judged explained 0 null
shows "nothing hidden and nothing found" '^| nothing hidden, called anything but explained | 3 % | 0.0 %'
grep -q "diagnose $dir/sets/sets/3-null-0001/model.yaml $dir/sets/sets/3-null-0001/fit_01.csv" "$dir/asked"
ok "the file is that of the set" $?
if grep -q -e sealed -e answer "$dir/asked"; then fail "the diagnosis sees the answer"; else pass; fi
claim 2 "levels of the action are none of a world" "$B/hidden" table --world any --levels L1 --build "$dir/bench"

finish
