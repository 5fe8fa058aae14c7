#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_fmu.sh - stein export: the command, the archive, its description against rules of our own
# (tests/fmu/*.rng and below), its functions, and what an importer of our own computes with it: as
# shared object, and from its sources. `make deps-check` installs what it needs.
set -u
B=${STEIN_BUILD:-build}
stein=$B/stein
dir=$(mktemp -d "${TMPDIR:-/tmp}/stein-fmu-XXXXXX") || exit 1
trap 'rm -rf "$dir"' EXIT
trap 'exit 1' HUP INT TERM
. tests/claims.sh
CC=${CC:-cc}

# ---- the command
claim 2 "an FMU needs a place" "$stein" export models/pendulum.yaml
says "and says so" 'expected -o FILE.fmu'
claim 2 "there is no FMI 4" "$stein" export models/pendulum.yaml --fmi 4 -o "$dir/x.fmu"
says "there are two" 'expected 3 or 2'
claim 2 "standard output holds one thing" "$stein" export models/pendulum.yaml -o - --json
claim 1 "without a compiler there is no FMU" env CC=no-such-cc "$stein" export models/pendulum.yaml -o "$dir/x.fmu"
says "the package is named" 'no "no-such-cc": run apt-get install gcc'
claim 1 "a compiler for nothing of ours" env CC=false "$stein" export models/pendulum.yaml -o "$dir/x.fmu"
claim 1 "a place that is none" "$stein" export models/pendulum.yaml -o "$dir/no/x.fmu"
if [ -e "$dir/x.fmu" ]; then fail "an FMU that failed is not there"; else pass; fi

# ---- machines: the target of a compiler, by one that compiles nothing
cat >"$dir/cc" <<'EOF'
#!/bin/sh
[ "$1" = -dumpmachine ] && echo "$MACHINE" && exit
while [ "$1" != -o ]; do shift; done
echo compiled >"$2"
EOF
chmod +x "$dir/cc"
export_for() { # MACHINE VERSION
    env MACHINE="$1" CC="$dir/cc" XDG_CACHE_HOME="$dir/none" "$stein" export models/pendulum.yaml --fmi "$2" -o "$dir/for.fmu" --json
}
for line in 'x86_64-linux-gnu 3 x86_64-linux' 'x86_64-linux-gnu 2.0 linux64' 'i686-linux-gnu 3.0 x86-linux' \
    'i386-pc-linux-gnu 2 linux32' 'i586-linux-gnu 2 linux32' 'aarch64-linux-gnu 3 aarch64-linux' \
    'aarch64-linux-gnu 2 aarch64-linux' 'arm-linux-gnueabihf 3 aarch32-linux' 'armv7l-linux-gnueabihf 2 aarch32-linux' \
    'riscv64-linux-gnu 3 riscv64-linux' 'x86_64-w64-mingw32 3 x86_64-windows' 'x86_64-w64-mingw32 2 win64' \
    'i686-w64-mingw32 3 x86-windows' 'i686-w64-mingw32 2 win32'; do
    # shellcheck disable=SC2086
    set -- $line
    claim 0 "for $1, FMI $2" export_for "$1" "$2"
    shows "the folder is $3" "\"platform\": \"$3\""
done
rm -f "$dir/for.fmu"
for machine in arm-none-eabi a_processor_with_a_name_that_fits_no_folder-linux-gnu; do
    claim 1 "none for $machine" export_for $machine 3
    says "the machine is told" "compiles for $machine: an FMU needs one for Linux, or mingw for Windows"
done
if [ -e "$dir/for.fmu" ]; then fail "and none is left"; else pass; fi

# several compilers, each for another machine
for two in 'x86_64-linux-gnu i386-linux-gnu' 'x86_64-linux-gnu x86_64-w64-mingw32'; do
    for machine in $two; do
        printf '#!/bin/sh\nMACHINE=%s exec "%s" "$@"\n' "$machine" "$dir/cc" >"$dir/$machine-cc" && chmod +x "$dir/$machine-cc"
    done
    claim 0 "for $two" env XDG_CACHE_HOME="$dir/none" "$stein" export models/pendulum.yaml -o "$dir/for.fmu" \
        --cc "$dir/${two% *}-cc,$dir/${two#* }-cc" --json
done
shows "both folders are told" '"platform": "x86_64-linux x86_64-windows"'
claim 1 "two for one machine" env XDG_CACHE_HOME="$dir/none" "$stein" export models/pendulum.yaml -o "$dir/for.fmu" \
    --cc "$dir/x86_64-linux-gnu-cc,$dir/x86_64-linux-gnu-cc"
says "are refused" 'both compile for x86_64-linux'
claim 2 "a list with a hole" "$stein" export models/pendulum.yaml -o "$dir/for.fmu" --cc cc,,cc
rm -f "$dir/for.fmu"

# compilers that do not optimise, which changes no bit and is sooner done; make soak does without
for compiler in cc x86_64-w64-mingw32-gcc; do
    command=$compiler
    [ $compiler = cc ] && command=$CC
    printf '#!/bin/sh\nexec %s "$@" %s\n' "$command" "$([ -n "${SOAK-}" ] || echo -O0)" >"$dir/quick-$compiler"
    chmod +x "$dir/quick-$compiler"
done

# what lies in the cache may be damaged
claim 0 "a first FMU" env XDG_CACHE_HOME="$dir/kept" CC="$dir/quick-cc" "$stein" export models/pendulum.yaml -o "$dir/first.fmu"
core=$(find "$dir/kept" -name core.o)
cp "$core" "$dir/core" && echo damaged >"$core"
claim 0 "one from a damaged cache" env XDG_CACHE_HOME="$dir/kept" CC="$dir/quick-cc" "$stein" export models/pendulum.yaml -o "$dir/second.fmu"
same "has the same bytes" "$dir/first.fmu" "$dir/second.fmu"
same "and the cache is whole again" "$dir/core" "$core"

missing=
for p in xmllint unzip; do command -v $p >/dev/null 2>&1 || missing="$missing $p"; done
if [ -n "$missing" ]; then
    echo "test_fmu: FMUs are not looked at, this machine lacks:$missing (make deps-check)"
    echo "test_fmu: $passed passed, $failed failed"
    exit "$((failed > 0))"
fi

# ---- archives
export_one() { # MODEL VERSION
    claim 0 "FMI $2 of $1" "$stein" export "models/$1.yaml" --fmi "$2" -o "$dir/$1-$2.fmu" --json
    mkdir "$dir/$1-$2"
    unzip -q "$dir/$1-$2.fmu" -d "$dir/$1-$2" 2>"$dir/err" || fail "$1-$2 is a ZIP"
}
for m in stein1788 pendulum emps slider_crank stick_slip; do export_one $m 3; done
for m in stein1788 pendulum; do export_one $m 2; done
claim 0 "the same again" "$stein" export models/stein1788.yaml -o "$dir/again.fmu"
if cmp -s "$dir/again.fmu" "$dir/stein1788-3.fmu"; then pass; else fail "has the same bytes"; fi
claim 0 "into a pipe" sh -c "'$stein' export models/stein1788.yaml -o - | cmp - '$dir/again.fmu'"
claim 0 "other numbers" "$stein" export models/stein1788.yaml --set pawl.stop_shift=-0.3mm -o "$dir/again.fmu"
unzip -p "$dir/again.fmu" modelDescription.xml | grep -o 'Token="[^"]*"' >"$dir/other"
if grep -qF "$(cat "$dir/other")" "$dir/stein1788-3/modelDescription.xml"; then fail "have another token"; else pass; fi
if unzip -p "$dir/again.fmu" modelDescription.xml | grep '"pawl.stop_shift"' | grep -q 'start="-0.0003"'; then pass; else fail "and are start values"; fi
# method deflate, readers of version 2.0, one date, no links
if unzip -Zl "$dir/stein1788-3.fmu" | grep -v '^Archive\|^Zip\|files,' | grep -vqE '^-rw---- +[012]\.0 fat .* (def[A-Z]|stor) 80-Jan-01 00:00 '; then fail "an archive as importers want it"; else pass; fi
if unzip -Zv "$dir/stein1788-2.fmu" | grep 'minimum software version required' | grep -vq '2\.0$'; then fail "of version 2.0"; else pass; fi

# names that two things of the file have
sed 's/^  rate: /  push: /' models/pendulum.yaml >"$dir/twice.yaml"
claim 0 "an input and an output of one name" env CC="$dir/quick-cc" XDG_CACHE_HOME="$dir/kept" "$stein" export "$dir/twice.yaml" -o "$dir/twice.fmu"
unzip -p "$dir/twice.fmu" modelDescription.xml >"$dir/twice.xml"
if grep -q '<Float64 name="push" .*causality="output"' "$dir/twice.xml" && grep -q '<Float64 name="input.push" .*causality="input"' "$dir/twice.xml"; then pass; else
    fail "have two names"; fi

# what the file says of its things, and what is said of those of which it says nothing
cat >"$dir/cart.yaml" <<'EOF'
mechanism: cart
bodies:
  cart: {joint: T x, mass: 2 kg, points: {hook: [0.1 m, 0, 0]}}
  wheel: {parent: cart, joint: R y, inertia: {yy: 0.2 kg m^2}}
inputs:
  path: {about: where a rail leads it, motion: cart}
  push: {about: a hand on the hook, force: cart.hook, direction: [1, 0, 0]}
  pull: {force: cart.hook, direction: [0, 0, 1]}
  turn: {torque: wheel}
outputs:
  place: {about: along the rail, joint: cart, read: position}
  back: {joint: cart, read: speed, sign: -1, zero: rest}
  shown: {input: turn, read: value}
  asked: {input: path, read: value}
  carried: {joint: wheel, read: reaction}
regulation:
  cart.mass: {from: 1 kg, to: 3 kg}
EOF
claim 0 "an FMU of a cart" env CC="$dir/quick-cc" XDG_CACHE_HOME="$dir/kept" "$stein" export "$dir/cart.yaml" -o "$dir/cart.fmu"
unzip -p "$dir/cart.fmu" modelDescription.xml >"$dir/cart.xml"
while IFS='|' read -r name words; do
    shows "$name is described" "name=\"$name\" valueReference=\"[0-9]*\" description=\"$words\"" "$dir/cart.xml"
done <<'EOF'
place|along the rail
back|speed of joint cart, counted the other way, from its value at rest
shown|input turn
carried|reaction of wheel
path.speed|speed given to joint cart: where a rail leads it
push|a hand on the hook
pull|force on point cart.hook
turn|force or torque in joint wheel
cart.mass|cart: mass
EOF
reference() { sed -n "s/.* name=\"$1\" valueReference=\"\([0-9]*\)\".*/\1/p" "$dir/cart.xml"; }
# depends OUTPUT INPUT: does the one follow from the other at once?
depends() { grep "<Output valueReference=\"$(reference "$1")\"" "$dir/cart.xml" | grep -qE "[\" ]$(reference "$2")[\" ]"; }
for pair in 'shown turn' 'asked path.position' 'place path.position' 'back path.speed' 'carried push'; do
    # shellcheck disable=SC2086
    if depends $pair; then pass; else fail "dependencies: $pair"; fi
done
for pair in 'shown push' 'asked path.speed' 'asked turn' 'place path.speed' 'place push'; do
    # shellcheck disable=SC2086
    if depends $pair; then fail "no dependency: $pair"; else pass; fi
done

# ---- functions: all of them and nothing else, nothing from outside but memory and a few of libm
allowed='^(malloc|calloc|free|mem(cpy|move|set|cmp)|str(cmp|len|ncmp|ncpy|spn)|frexp|ldexp|f(max|min|abs)|floor|sqrt|bcmp|__stack_chk_fail|_ITM_.*|__cxa_finalize|__gmon_start__)$'
for fmu in "$dir"/*-[23]; do
    v=${fmu##*-} so=$(find "$fmu/binaries" -name '*.so')
    nm -D --defined-only "$so" | awk '{print $3}' >"$dir/symbols"
    wanted=$([ "$v" = 3 ] && echo 75 || echo 44)
    if [ "$(grep -c "^fmi$v" "$dir/symbols")" = "$wanted" ] && [ "$(wc -l <"$dir/symbols")" = "$wanted" ]; then pass; else
        fail "$fmu has $wanted functions: $(grep -c "^fmi$v" "$dir/symbols") of $(wc -l <"$dir/symbols")"; fi
    grep -o "fmi$v[A-Za-z0-9]*" src/fmi/fmi$v.h | grep -xF -f "$dir/symbols" | sort -u | wc -l >"$dir/declared"
    if [ "$(cat "$dir/declared")" -eq "$wanted" ]; then pass; else fail "$fmu: all that is declared"; fi
    if nm -D --undefined-only "$so" | awk '{print $2}' | sed 's/@.*//' | grep -vE "$allowed" >"$dir/err"; then fail "$fmu asks for more"; else pass; fi
done
# no data that could be shared between instances: what a C runtime has in every library
size -A "$(find "$dir/stein1788-3" -name '*.so')" | awk '$1 == ".data" || $1 == ".bss" {n += $2} END {exit n > 16}' || fail "no variables outside of instances"

# ---- the description
count() { xmllint --xpath "count($2)" "$1" 2>"$dir/err"; }
none() { # FILE TEXT XPATH
    if [ "$(count "$1" "$3")" = 0 ]; then pass; else fail "$1: $2 ($(count "$1" "$3"))"; fi
}
for fmu in "$dir"/*-[23]; do
    v=${fmu##*-} x=$fmu/modelDescription.xml
    claim 0 "$fmu is as FMI $v has it" xmllint --noout --relaxng tests/fmu/fmi$v.rng "$x"
    all=$([ "$v" = 3 ] && echo '//ModelVariables/*' || echo '//ModelVariables/ScalarVariable')
    none "$x" "a name twice" "$all/@name[. = ../preceding-sibling::*/@name]"
    none "$x" "a value reference twice" "$all/@valueReference[. = ../preceding-sibling::*/@valueReference]"
    none "$x" "a unit twice" "//Unit/@name[. = ../preceding-sibling::*/@name]"
    none "$x" "a unit that is not defined" "//ModelVariables//@unit[not(. = //UnitDefinitions/Unit/@name)]"
    none "$x" "a unit of nothing" "//UnitDefinitions/Unit[not(@name = //ModelVariables//@unit)]"
    none "$x" "a category twice" "//Category/@name[. = ../preceding-sibling::*/@name]"
    [ "$(count "$x" "$all[@causality='independent']")" = 1 ] || fail "$x: one independent variable"
    [ "$(count "$x" "$all[@name='simulation.dt']")" = 1 ] || fail "$x: a step"
    id=$(xmllint --xpath 'string(//CoSimulation/@modelIdentifier)' "$x")
    if [ -s "$(find "$fmu/binaries" -name "$id.so")" ]; then pass; else fail "$x: the binary has the identifier's name"; fi
    if [ "$v" = 3 ]; then
        outs='//ModelStructure/Output/@valueReference' start='//ModelStructure/InitialUnknown/@valueReference' key=valueReference
        none "$x" "an output that is not in the structure" "$all[@causality='output'][not(@valueReference = $outs)]"
        none "$x" "an output that is not unknown at the start" "$all[@causality='output'][not(@valueReference = $start)]"
        none "$x" "a derivative of what is none" "//ContinuousStateDerivative[not(@valueReference = ${all}[@derivative]/@valueReference)]"
        none "$x" "a derivative that is not in the structure" "$all[@derivative][not(@valueReference = //ContinuousStateDerivative/@valueReference)]"
        none "$x" "a state that is not unknown at the start" "$all[@valueReference = ${all}/@derivative or @derivative][not(@valueReference = $start)]"
        none "$x" "an indicator that is no guard" "//EventIndicator[not(@valueReference = ${all}[contains(@name, '.guard') or contains(@name, '.stick')]/@valueReference)]"
        none "$x" "a guard that is no indicator" "$all[contains(@name, '.guard') or contains(@name, '.stick')][not(@valueReference = //EventIndicator/@valueReference)]"
        none "$x" "something else among the outputs" "${outs}[not(. = ${all}[@causality='output']/@valueReference)]"
        none "$x" "something else unknown at the start" "${start}[not(. = ${all}[@causality='output' or @derivative or @valueReference = ${all}/@derivative]/@valueReference)]"
        none "$x" "a derivative of no local" "$all/@derivative[not(. = ${all}[@causality='local']/@valueReference)]"
        xmllint --xpath "$all[@causality='input' or @causality='parameter' or @valueReference = ${all}/@derivative]/@valueReference" "$x" | tr -dc '0-9\n' | sort >"$dir/knowns"
        none "$x" "an output twice" "${outs}[. = ../preceding-sibling::Output/@valueReference]"
    else
        outs='//Outputs/Unknown' start='//InitialUnknowns/Unknown' key=index
        [ "$(count "$x" "$outs")" = "$(count "$x" "$all[@causality='output']")" ] || fail "$x: all outputs are in the structure"
        coordinates="$all[@name[contains(., '.q')] and @causality='local']"
        [ "$(count "$x" "$start")" = "$(($(count "$x" "$outs") + $(count "$x" "$coordinates")))" ] || fail "$x: outputs and coordinates are unknown at the start"
        [ "$(count "$x" "//Derivatives/Unknown")" = "$(count "$x" '//Real[@derivative]')" ] || fail "$x: all derivatives are in the structure"
        for i in $(xmllint --xpath '//Derivatives/Unknown/@index' "$x" | tr -dc '0-9\n'); do
            [ "$(count "$x" "${all}[$i]/Real[@derivative]")" = 1 ] || fail "$x: variable $i is a derivative"
        done
        [ "$(xmllint --xpath 'string(/*/@numberOfEventIndicators)' "$x")" = "$(count "$x" "$all[contains(@name, '.guard')]")" ] ||
            fail "$x: as many indicators as guards"
        for i in $(xmllint --xpath "$outs/@index" "$x" | tr -dc '0-9\n'); do
            [ "$(count "$x" "${all}[$i][@causality='output']")" = 1 ] || fail "$x: variable $i is an output"
        done
        for i in $(xmllint --xpath '//@derivative' "$x" | tr -dc '0-9\n'); do
            [ "$(count "$x" "${all}[$i][@causality='local']")" = 1 ] || fail "$x: variable $i is a local"
        done
        n=$(count "$x" "$all") i=1
        while [ $i -le "$n" ]; do echo $i; i=$((i + 1)); done | sort >"$dir/knowns"
        xmllint --xpath '//CoSimulation/SourceFiles/File/@name' "$x" | sed 's/.*name="\(.*\)"/\1/' | grep . | sort >"$dir/listed"
        (cd "$fmu/sources" && ls -- *.c) | sort >"$dir/there"
        if cmp -s "$dir/listed" "$dir/there"; then pass; else fail "$x: all sources are listed"; fi
    fi
    xmllint --xpath "(//ModelStructure//@dependencies)" "$x" | tr ' ' '\n' | tr -dc '0-9\n' | grep . | sort -u >"$dir/used"
    if [ -z "$(comm -23 "$dir/used" "$dir/knowns")" ]; then pass; else fail "$x: a dependency on nothing known"; fi
done
x=$dir/stein1788-3/modelDescription.xml
regulated=$("$stein" check models/stein1788.yaml --json | sed -n '/"regulation"/,/\]/s/.*"name": "\(.*\)",*/\1/p' | sort)
tunable=$(xmllint --xpath '//*[@variability="tunable"]/@name' "$x" | sed 's/.*name="\(.*\)"/\1/' | grep . | sort)
if [ -n "$regulated" ] && [ "$regulated" = "$tunable" ]; then pass; else fail "the regulation is what is tunable: $tunable"; fi
# what a force cannot change at once: importers find no loop there
finger=$(xmllint --xpath 'string(//Float64[@name="finger"]/@valueReference)' "$x")
depends=$(xmllint --xpath "//ModelVariables/*[@valueReference = //Output[contains(concat(' ', @dependencies, ' '), ' $finger ')]/@valueReference]/@name" "$x")
if [ "$(echo "$depends" | tr -d ' \n')" = 'name="key_force"' ]; then pass; else fail "only the force of the motion follows the finger: $depends"; fi
none "$x" "no description" '//ModelVariables/*[string-length(@description) < 4]'
none "$x" "no words" '//ModelVariables/*[starts-with(@description, "parameter ")]'

# ---- numbers
counted() { # FILE TEXT
    last=$(tail -n 1 "$1")
    case $last in
    *[!0-9\ ]* | "") cat "$1"; last="0 1" ;;
    *) sed '$d; s/^note: /test_fmu: '"$2"': /' "$1" ;;
    esac
    passed=$((passed + ${last% *})) failed=$((failed + ${last#* }))
}
claim 0 "a stroke" "$stein" strike models/stein1788.yaml --until 100ms --every 0.5ms -o "$dir/stein1788.csv"
claim 0 "a swing" "$stein" simulate models/pendulum.yaml --until 2s --every 10ms -o "$dir/pendulum.csv"
claim 0 "an engine" "$stein" simulate models/slider_crank.yaml --until 1s --every 10ms -o "$dir/slider_crank.csv"
claim 0 "a block on a belt" "$stein" simulate models/stick_slip.yaml --until 1s --every 10ms -o "$dir/stick_slip.csv"
claim 0 "an axis" "$stein" simulate models/emps.yaml --until 1s --every 10ms -o "$dir/emps.csv"
for fmu in "$dir"/*-[23]; do
    name=$(basename "${fmu%-*}")
    "$B/importer" "${fmu##*-}" "$(find "$fmu/binaries" -name '*.so')" "$fmu/modelDescription.xml" "$dir/$name.csv" >"$dir/log" 2>&1
    counted "$dir/log" "$name, FMI ${fmu##*-}"
done

# ---- from the sources, as the build description says (but not optimised: that changes no bit and is
# sooner done); meanwhile the rest
fmu=$dir/stein1788-3 d=$dir/stein1788-3/sources/buildDescription.xml
options=$(xmllint --xpath 'string(//SourceFileSet/@compilerOptions)' "$d")
(
    cd "$fmu/sources" || exit 1
    # shellcheck disable=SC2046,SC2086
    "$CC" $options -O0 -shared -fPIC \
        $(xmllint --xpath '//IncludeDirectory/@name' "$d" | sed 's/.*name="\(.*\)"/-I\1/') \
        $(xmllint --xpath '//SourceFile/@name' "$d" | sed 's/.*name="\(.*\)"/\1/') \
        -l"$(xmllint --xpath 'string(//Library/@name)' "$d")" -o "$dir/own3.so" >"$dir/built" 2>&1
) &
compiler=$!
# the FMI side with sanitizers, on the library's own core
own2=$dir/stein1788-2/sources flags="-O1 -g -fsanitize=address,undefined -fno-sanitize-recover=all"
# shellcheck disable=SC2086
if ! (cd "$own2" && "$CC" -std=c11 $flags -shared -fPIC -I. slave*.c exchange*.c fmi2.c fmu_model.c \
    "$(cd "$OLDPWD" && cd "$B" && pwd)/libstein.a" -lm -o "$dir/own2.so") >"$dir/err" 2>&1; then
    echo "test_fmu: $CC has no sanitizers, nothing is run with them"
else
    # shellcheck disable=SC2086
    claim 0 "an importer with sanitizers" "$CC" -std=c11 -D_POSIX_C_SOURCE=200809L -O0 ${flags#-O1 -g} -Iinclude -I"$B/include" \
        -Isrc/fmi -Isrc/core tests/fmu/*.c "$B/libstein.a" -lexpat -lm -ldl -pthread -o "$dir/importer"
    "$dir/importer" 2 "$dir/own2.so" "$dir/stein1788-2/modelDescription.xml" "$dir/stein1788.csv" \
        starts refusals rest states parameters inputs discard slopes exchange >"$dir/log" 2>&1
    counted "$dir/log" "stein1788, FMI 2 with sanitizers"
fi
wait $compiler || fail "the sources compile: $(head -n 3 "$dir/built")"
"$B/importer" 3 "$dir/own3.so" "$fmu/modelDescription.xml" "$dir/stein1788.csv" record states parameters >"$dir/log" 2>&1
counted "$dir/log" "stein1788, FMI 3 from its sources"
# the FMI side without a warning
for compiler in "$CC" clang; do
    command -v "$compiler" >/dev/null 2>&1 || continue
    for v in 2 3; do
        own=$(cd "$dir/stein1788-$v/sources" && if [ $v = 3 ]; then ls slave*.c exchange*.c fmi3.c none3.c; else ls exchange2.c fmi2.c; fi)
        # shellcheck disable=SC2086
        claim 0 "$compiler has nothing against FMI $v" sh -c 'cd "$1" && shift && "$@"' sh "$dir/stein1788-$v/sources" \
            "$compiler" -std=c11 -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Wstrict-prototypes \
            -Wmissing-prototypes -Wundef -Wvla -Werror -fsyntax-only -I. $own
    done
done
# as importers compile that know nothing of options: by CMake, or every C file, then a shared library of all
if command -v cmake >/dev/null 2>&1; then
    printf 'cmake_minimum_required(VERSION 3.15)\nproject(pendulum C)\nfile(GLOB sources sources/*.c)\nadd_library(pendulum SHARED ${sources})\ntarget_include_directories(pendulum PUBLIC sources)\nset_target_properties(pendulum PROPERTIES PREFIX "")\n' \
        >"$dir/pendulum-3/CMakeLists.txt"
    { cmake -S "$dir/pendulum-3" -B "$dir/cmake" -DCMAKE_C_COMPILER="$CC" && cmake --build "$dir/cmake" -j2; } >"$dir/built" 2>&1
    ok "and by CMake: $(tail -n 3 "$dir/built")" $?
    "$B/importer" 3 "$dir/cmake/pendulum.so" "$dir/pendulum-3/modelDescription.xml" "$dir/pendulum.csv" record states exchange >"$dir/log" 2>&1
    counted "$dir/log" "pendulum, FMI 3 by CMake"
fi
if [ -n "${SOAK-}" ] || ! command -v cmake >/dev/null 2>&1; then
    (cd "$dir/pendulum-2/sources" && "$CC" -c -I. -fPIC ./*.c && "$CC" -static-libgcc -shared -o "$dir/plain2.so" ./*.o) >"$dir/built" 2>&1
    ok "every C file compiles without options: $(head -n 3 "$dir/built")" $?
    "$B/importer" 2 "$dir/plain2.so" "$dir/pendulum-2/modelDescription.xml" "$dir/pendulum.csv" record states >"$dir/log" 2>&1
    counted "$dir/log" "pendulum, FMI 2 compiled without options"
fi
# linked into a program, functions have a name in front that is asked for
claim 0 "one file of it" "$CC" -std=c11 -DFMI3_FUNCTION_PREFIX=stein1788_ -I"$fmu/sources" -c "$fmu/sources/fmi3.c" -o "$dir/fmi3.o"
if nm "$dir/fmi3.o" | grep -q ' T stein1788_fmi3DoStep$' && ! nm "$dir/fmi3.o" | grep -q ' T fmi3'; then pass; else fail "has prefixes"; fi

# ---- for Windows, by a cross compiler, and there where wine is
wine=$(command -v wine64 || command -v wine || echo /usr/lib/wine/wine64)
if command -v x86_64-w64-mingw32-gcc >/dev/null 2>&1; then
    claim 0 "an FMU for Linux and Windows" "$stein" export models/stein1788.yaml --cc "$CC,$dir/quick-x86_64-w64-mingw32-gcc" -o "$dir/both.fmu"
    mkdir "$dir/both" && unzip -q "$dir/both.fmu" -d "$dir/both"
    same "has the binary for Linux" "$dir/both/binaries/x86_64-linux/stein1788.so" "$dir/stein1788-3/binaries/x86_64-linux/stein1788.so"
    dll=$dir/both/binaries/x86_64-windows/stein1788.dll
    x86_64-w64-mingw32-objdump -p "$dll" | sed -n 's/.*\[ *[0-9]*\] .*\(fmi3[A-Za-z0-9]*\)$/\1/p' | sort -u >"$dir/symbols"
    [ "$(wc -l <"$dir/symbols")" = 75 ]
    ok "and one with 75 functions: $(wc -l <"$dir/symbols")" $?
    x86_64-w64-mingw32-objdump -p "$dll" | sed -n 's/.*DLL Name: //p' | grep -viE '^(kernel32|msvcrt|api-ms-win-crt.*)\.dll$' >"$dir/err"
    test ! -s "$dir/err"
    ok "it needs nothing that Windows has not" $?
    claim 0 "the same again" "$stein" export models/stein1788.yaml --cc "$CC,$dir/quick-x86_64-w64-mingw32-gcc" -o "$dir/again.fmu"
    same "has the same bytes" "$dir/both.fmu" "$dir/again.fmu"
    if [ -x "$wine" ]; then
        claim 0 "a program for Windows" x86_64-w64-mingw32-gcc -std=c11 -Isrc/fmi tests/fmu/windows/run.c -o "$dir/run.exe"
        token=$(xmllint --xpath 'string(/fmiModelDescription/@instantiationToken)' "$dir/both/modelDescription.xml")
        WINEPREFIX=$dir/wine WINEDEBUG=-all timeout 200 "$wine" "$dir/run.exe" "$dll" "$token" 2>"$dir/err" | tr -d '\r' >"$dir/got"
        "$stein" strike models/stein1788.yaml --until 100ms -o "$dir/last.csv" >/dev/null
        tail -n 1 "$dir/last.csv" | cut -d , -f 2,3 | tr , ' ' >"$dir/expected"
        # the file has the shortest digits of a number, the program seventeen: both as seventeen
        for file in got expected; do
            awk '{ printf "%.17g %.17g\n", $1, $2 }' "$dir/$file" >"$dir/$file.digits"
        done
        diff "$dir/got.digits" "$dir/expected.digits" >"$dir/err"
        ok "it computes the same bits there" $?
    else
        echo "test_fmu: no wine, the binary for Windows is not run - run: apt-get install wine64"
    fi
else
    echo "test_fmu: nothing is compiled for Windows - run: apt-get install gcc-mingw-w64-x86-64"
fi

echo "test_fmu: $passed passed, $failed failed"
test "$failed" -eq 0
