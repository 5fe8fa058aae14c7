#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_layers.sh - a folder uses only what docs/architecture.md puts above it: by what its sources
# include, and by the names that its objects leave to the linker.
set -u
. tests/claims.sh

# of each folder, subfolders not among them: global names that its objects define and need, and how
# its headers are included
lab=$(find src/lab -mindepth 1 -type d | sort)
for folder in src/core src/load src/model gen src/cli $lab; do
    mkdir -p "$dir/$folder"
    nm -g --defined-only "$B/obj/$folder"/*.o 2>/dev/null | sed -n 's/^[0-9a-f]* [A-Z] //p' >"$dir/$folder/defined"
    nm -g -u "$B/obj/$folder"/*.o 2>/dev/null | sed -n 's/^ *[Uw] //p' >"$dir/$folder/needed"
    # types of the whole diagnosis: the root of search.h, above the judge that it is kept with
    find "$folder" -maxdepth 1 -name '*.h' ! -name diagnosing.h |
        sed 's|.*/\(.*\)|#include "\1"|' >"$dir/$folder/headers"
done
# of KIND FOLDER...: one of these lists, of several folders
of() {
    kind=$1
    shift
    for f in "$@"; do cat "$dir/$f/$kind"; done | sort -u
}
# never FOLDER FOLDER...: the first one uses nothing of the others
never() {
    from=$1
    shift
    of defined "$@" >"$dir/there"
    of needed "$from" >"$dir/wanted"
    comm -12 "$dir/there" "$dir/wanted" >"$dir/both"
    test ! -s "$dir/both"
    ok "$from uses nothing of $* ($(tr '\n' ' ' <"$dir/both"))" $?
    of headers "$@" >"$dir/there"
    grep -hF -f "$dir/there" "$from"/*.[ch] >"$dir/both"
    test ! -s "$dir/both"
    ok "$from includes nothing of $* ($(tr '\n' ' ' <"$dir/both"))" $?
}

test "$(echo "$lab" | wc -l)" -gt 5
ok "the folders of the lab are found" $?
test -z "$(find src/lab -maxdepth 1 -type f)"
ok "every file of the lab is in a folder" $?
of needed src/cli >"$dir/wanted"
# shellcheck disable=SC2086
of defined $lab | comm -12 - "$dir/wanted" >"$dir/both"
test "$(wc -l <"$dir/both")" -gt 20
ok "what one folder uses of others is seen" $?

for folder in src/core src/load src/model gen; do
    # shellcheck disable=SC2086
    never $folder $lab src/cli
    grep -lE '#include [<"](gsl/|stein/(lab|data|fit|diagnose|plan|import)[.]h)' $folder/*.[ch] >"$dir/both"
    test ! -s "$dir/both"
    ok "$folder knows neither GSL nor headers of the lab ($(tr '\n' ' ' <"$dir/both"))" $?
done
never src/core src/load src/model gen
never src/load gen
never src/model gen src/load
# only FOLDER FOLDER...: of the lab the first one uses nothing but the others
only() {
    from=$1
    there=
    for folder in $lab src/cli; do
        case " $* " in *" $folder "*) ;; *) there="$there $folder" ;; esac
    done
    # shellcheck disable=SC2086
    never $from $there
}
io=src/lab/io open=src/lab/open run=src/lab/run data=src/lab/data fit=src/lab/fit sweep=src/lab/sweep
only $io
only $open $io
only $run $io $open
only src/lab/accuracy $io $open $run $data
only $sweep $io $open $run
only src/lab/plot $io $open $run $sweep
only src/lab/study $io $open $run $sweep src/lab/plot
only src/lab/identity $io $open $run $sweep $data $fit
for folder in src/lab/page src/lab/fmu src/lab/draw src/lab/import src/lab/linear; do only $folder $io $open; done
# the order of a diagnosis: records, fits, effects, search, verdict; what is later is not asked before
only $data $io $open $run src/lab/effects $fit
only $fit $io $open $run src/lab/effects $data
only src/lab/effects $io $open $run $data $fit src/lab/law src/lab/report
only src/lab/search $io $open $run src/lab/effects $data $fit
only src/lab/law $io $open $run src/lab/effects $data $fit src/lab/search src/lab/verdict src/lab/report
only src/lab/verdict $io $open $run src/lab/effects $data $fit src/lab/search src/lab/report src/lab/plan
only src/lab/report $io $open $run src/lab/effects $data $fit src/lab/search src/lab/law src/lab/verdict src/lab/plan
for folder in $lab; do never "$folder" src/cli; done
grep -lE '#include "(verdict|motion|diagnosis_page)[.]h"' src/lab/search/*.[ch] >"$dir/both"
test ! -s "$dir/both"
ok "src/lab/search knows nothing of how a verdict is found or shown ($(tr '\n' ' ' <"$dir/both"))" $?

# a header names the folders that include it: "Included by: this folder, src/lab, src/cli."
headers=$(find src gen -name '*.h')
for header in $headers; do
    allowed=$(sed -n 's/^ \* Included by: \(.*\)\.$/\1/p;/\*\//q' "$header" | tr -d ,)
    grep -rl "#include \"${header##*/}\"" src gen --include='*.[ch]' | while read -r user; do
        case "$user" in "${header%/*}"/*) continue ;; esac
        for folder in $allowed; do
            case "$user" in "$folder"/*) continue 2 ;; esac
        done
        echo "$header: $user"
    done
    [ -n "$allowed" ] || echo "$header: says nothing"
done >"$dir/both"
test "$(echo "$headers" | wc -l)" -gt 50 && test ! -s "$dir/both"
ok "headers are included where they say ($(tr '\n' ' ' <"$dir/both"))" $?

# the core neither prints nor reads files, and has no global variable
of needed src/core >"$dir/wanted"
grep -xE 'printf|fprintf|fopen|fread|fwrite|fputs|puts|stdout|stderr|getenv|setlocale|exit|abort' "$dir/wanted" >"$dir/both"
test ! -s "$dir/both"
ok "src/core neither prints nor opens files ($(tr '\n' ' ' <"$dir/both"))" $?
nm -g --defined-only "$B/obj/src/core"/*.o | sed -n 's/^[0-9a-f]* [BDC] //p' >"$dir/both"
test ! -s "$dir/both"
ok "src/core has no global variables ($(tr '\n' ' ' <"$dir/both"))" $?
finish
