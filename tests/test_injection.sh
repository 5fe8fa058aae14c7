#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_injection.sh - hostile names, units and texts: in a mechanism file they are refused or harmless,
# as names of files they are only names. Nothing of them becomes C, SVG, gnuplot, JSON, YAML or a
# command of a shell. Runs from the checkout's root.
set -u
. tests/claims.sh
B=$(cd "${STEIN_BUILD:-build}" && pwd) || exit 1
stein=$B/stein
root=$(pwd)
cd "$dir" || exit 1

# what would be left behind by a command that ran; the marker that no output may hold unescaped
harmless() {
    if [ -e "$dir/INJECTED" ] || [ -e INJECTED ]; then
        fail "$1: a command ran"
        rm -f INJECTED "$dir/INJECTED"
    else pass; fi
}
nl='
'
# ---- names and units inside of a mechanism file: one NAME a line, escapes as in a YAML text
cat >hostile <<'EOF'
a*/ int injected; /*
a\" ; int injected; //
a\\
a\n#define injected
a%s%n
a'); system('touch INJECTED'); ('
a`touch INJECTED`
a$(touch INJECTED)
a;touch INJECTED
a|touch INJECTED
<script>injected</script>
a&amp;
a/../../b
../../INJECTED
a..b
a b
a-b
int
while
register
_a
1a
a\u202Eb
ä
aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa
??/
\0
EOF
# mechanism NAME BODY POINT INPUT OUTPUT PARAMETER UNIT
mechanism() {
    cat <<EOF
mechanism: "$1"
about: "$1"
parameters: {"tuned.$6": 1 kg}
bodies:
  "$2": {joint: R -y, mass: "2 $7", centre: [0, 0, -0.1], inertia: {yy: 1e-3}, points: {"$3": [0, 0, -0.2]}}
inputs: {"$4": {torque: "$2"}}
outputs: {"$5": {point: "$2.$3", read: x}}
simulation: {dt: 1 ms, until: 3 ms}
EOF
}
mechanism m rod tip push out mass kg >good.yaml
claim 0 "the mechanism that carries the names" "$stein" check good.yaml
n=0
while IFS= read -r name; do
    for place in 1 2 3 4 5 6 7; do
        n=$((n + 1))
        set -- m rod tip push out mass kg
        before=$* i=0
        for word in $before; do
            i=$((i + 1))
            shift
            if [ $i = $place ]; then set -- "$@" "$name"; else set -- "$@" "$word"; fi
        done
        mechanism "$@" >bad.yaml
        claim 1 "\"$name\" at place $place is refused" "$stein" check bad.yaml
        if [ "$(grep -c '^bad.yaml:\|^ *[0-9]* | ' err)" = "$(wc -l <err)" ]; then pass; else fail "\"$name\" at place $place: lines of problems only"; fi
    done
done <hostile
harmless "names in a file"

# names that are words of the generated text, of libm or of gnuplot compile and run
for name in main p d M setup sin y0 NULL I linux nan EOF; do
    mechanism $name ${name}1 $name ${name}2 ${name}3 ${name}4 kg >word.yaml
    claim 0 "\"$name\" as a name" "$stein" simulate word.yaml -o word.csv
    mechanism m $name tip push out mass kg >word.yaml
    claim 0 "\"$name\" as a body" "$stein" generate word.yaml -o words
    claim 0 "\"$name\" compiles without warnings" "${CC:-cc}" -std=c11 -Wall -Wextra -Wpedantic -Werror \
        -I"$root/include" -c words/m.c -o words/m.o
done

# ---- texts that are free
sed 's|^about:.*|about: "*/ int injected; /* ?\?/ \\" <script>injected</script> $(touch INJECTED) `touch INJECTED`"|' \
    "$root/models/pendulum.yaml" >about.yaml
claim 0 "equations of a mechanism with a hostile description" "$stein" generate about.yaml -o about
claim 0 "compile" "${CC:-cc}" -std=c11 -Wall -Wextra -Werror -I"$root/include" -c about/pendulum.c -o about.o
if nm about.o | grep -q injected || grep -q 'int injected' about/pendulum.c; then fail "it got into the equations"; else pass; fi

# FMUs: texts of the file are the values of attributes, names of an FMU only names
if command -v xmllint >/dev/null 2>&1 && command -v unzip >/dev/null 2>&1; then
    sed -i 's|^about:.*|about: "\\"/><Injected x=\\"\&lt; '"'"' <!-- ]]> \\u0007\\uFFFE\\n $(touch INJECTED) `touch INJECTED` */ int injected; /*"|' about.yaml
    printf '\nregulation: {rod.mass: {from: 0.1, to: 0.3, label: "a\\"/><Injected b=\\"\\u0001"}}\n' >>about.yaml
    if grep -q '<Injected' about.yaml; then pass; else fail "the hostile file is hostile"; fi
    printf '#!/bin/sh\nexec %s "$@" -O0\n' "${CC:-cc}" >fast-cc && chmod +x fast-cc
    for v in 3 2; do
        claim 0 "FMI $v of a mechanism with hostile texts" env CC="$dir/fast-cc" "$stein" export about.yaml --fmi $v -o 'a$(touch INJECTED);"`touch INJECTED`.fmu'
        rm -rf fmu && unzip -q 'a$(touch INJECTED);"`touch INJECTED`.fmu' -d fmu
        claim 0 "its description is well-formed and holds what it may" xmllint --noout --relaxng "$root/tests/fmu/fmi$v.rng" fmu/modelDescription.xml
        if [ "$(xmllint --xpath 'string(/*/@description)' fmu/modelDescription.xml | grep -c 'Injected x="&lt; '"'"' <!-- ]]> ??  $(touch')" = 1 ]; then pass; else fail "FMI $v: the text is still there, as text"; fi
        if [ "$(xmllint --xpath 'string(//*[@name="rod.mass"]/@description)' fmu/modelDescription.xml)" = 'a"/><Injected b="?' ]; then pass; else fail "FMI $v: so is the label"; fi
        if grep -rq 'int injected' fmu/sources; then fail "FMI $v: it got into the sources"; else pass; fi
    done
    harmless "texts in an FMU"
else echo "test_injection: no xmllint or unzip, FMUs are not looked at"; fi

# ---- names of files
i=0
for name in "a${nl}bodies: {injected: 1}${nl}" 'a"; system("touch INJECTED"); "' "a'; system 'touch INJECTED'; '" \
    'a$(touch INJECTED)' 'a`touch INJECTED`' 'a;touch INJECTED;' '-o INJECTED' 'a<script>injected</script>'"" \
    'a%s%n%n' 'a\"\\' "a$(printf '\033')[31m"; do
    case $name in *script*) name=$(printf %s "$name" | tr / .) ;; esac
    i=$((i + 1))
    mkdir "f$i" && cd "f$i" || exit 1
    cp "$root/models/pendulum.yaml" "./$name.yaml"
    claim 0 "file $i is checked" "$stein" check --json -- "$name.yaml"
    if [ "$(tr -d '\n -~\200-\377' <"$dir/out" | wc -c)" = 0 ] && grep -q '"equations"' "$dir/out"; then pass; else fail "file $i: JSON is plain"; fi
    claim 0 "file $i is simulated" "$stein" simulate --until 200ms --plot "./$name.svg" --set rod.damping=2e-4 \
        -o "./$name.csv" -- "./$name.yaml"
    if [ -s "./$name.csv" ] && [ -s "./$name.svg" ] && ! grep -q '<script' "./$name.svg"; then pass; else fail "file $i: picture and data"; fi
    cut -d, -f1,2 <"./$name.csv" | grep -v '^#' >"./d$name.csv"
    claim 0 "file $i is fitted" "$stein" fit --free rod.damping -o "./fitted$name.yaml" -- "./$name.yaml" "./d$name.csv"
    if grep -q '^bodies: {injected' "./fitted$name.yaml"; then fail "file $i: a key got into the file"; else pass; fi
    claim 0 "the fitted file $i is read" "$stein" check -- "./fitted$name.yaml"
    claim 1 "a file that is not there" "$stein" check -- "x$name"
    if [ "$(wc -l <"$dir/err")" = 1 ] && [ "$(tr -d '\n -~\200-\377' <"$dir/err" | wc -c)" = 0 ]; then pass; else fail "file $i: one plain line"; fi
    harmless "file $i"
    cd .. || exit 1
done
claim 0 "a number over two lines" "$stein" simulate "$root/models/pendulum.yaml" --set "rod.mass=3${nl} kg" --until 2ms -o two.csv
if [ "$(grep -c '^[^#]' two.csv)" = 4 ]; then pass; else fail "the head of a record is comments and columns"; fi
claim 2 "a hostile option" "$stein" check "--$(printf '\033')[31m${nl}x"
if [ "$(tr -d '\n -~' <"$dir/err" | wc -c)" = 0 ] && [ "$(wc -l <"$dir/err")" = 2 ]; then pass; else fail "is shown in plain"; fi
harmless "all of it"
finish "$n names in files, $i names of files"
