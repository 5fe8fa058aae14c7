#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_layers.sh - a folder uses only what docs/architecture.md puts above it: by what its sources
# include, and by the names that its objects leave to the linker.
set -u
. tests/claims.sh

# defined FOLDER..., needed FOLDER...: global names of the objects of these folders, subfolders not
# among them
defined() { for f in "$@"; do nm -g --defined-only "$B/obj/$f"/*.o 2>/dev/null; done | sed -n 's/^[0-9a-f]* [A-Z] //p' | sort -u; }
needed() { for f in "$@"; do nm -g -u "$B/obj/$f"/*.o 2>/dev/null; done | sed -n 's/^ *[Uw] //p' | sort -u; }
# never FOLDER FOLDER...: the first one uses nothing of the others
never() {
    from=$1
    shift
    defined "$@" >"$dir/there"
    needed "$from" >"$dir/wanted"
    comm -12 "$dir/there" "$dir/wanted" >"$dir/both"
    test ! -s "$dir/both"
    ok "$from uses nothing of $* ($(tr '\n' ' ' <"$dir/both"))" $?
    for other in "$@"; do
        for header in "$other"/*.h; do
            [ -e "$header" ] && grep -ln "#include \"${header##*/}\"" "$from"/*.[ch]
        done
    done >"$dir/both"
    test ! -s "$dir/both"
    ok "$from includes nothing of $* ($(tr '\n' ' ' <"$dir/both"))" $?
}

lab=$(find src/lab -type d | sort)
test "$(echo "$lab" | wc -l)" -gt 5
ok "the folders of the lab are found" $?
needed src/cli >"$dir/wanted"
# shellcheck disable=SC2086
defined $lab | comm -12 - "$dir/wanted" >"$dir/both"
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
for folder in $lab; do never "$folder" src/cli; done
# the order of a diagnosis: records, fits, effects, search, verdict; what is later is not asked before
# shellcheck disable=SC2086
for folder in src/lab src/lab/data src/lab/fit; do
    never $folder src/lab/search src/lab/verdict src/lab/diagnosis src/lab/report src/lab/plan
done
never src/lab/effects src/lab/search src/lab/diagnosis src/lab/plan
never src/lab/search src/lab/diagnosis src/lab/plan src/lab/law
never src/lab/law src/lab/diagnosis src/lab/plan
for folder in src/lab/study src/lab/page src/lab/fmu src/lab/draw src/lab/import; do
    never $folder src/lab/search src/lab/verdict src/lab/diagnosis src/lab/plan src/lab/report src/lab/effects src/lab/law
done
grep -lE '#include "(verdict|motion|diagnosis_page)[.]h"' src/lab/search/*.[ch] >"$dir/both"
test ! -s "$dir/both"
ok "src/lab/search knows nothing of how a verdict is found or shown ($(tr '\n' ' ' <"$dir/both"))" $?

# the core neither prints nor reads files, and has no number of its own that a run could change
needed src/core >"$dir/wanted"
grep -xE 'printf|fprintf|fopen|fread|fwrite|fputs|puts|stdout|stderr|getenv|setlocale|exit|abort' "$dir/wanted" >"$dir/both"
test ! -s "$dir/both"
ok "src/core neither prints nor opens files ($(tr '\n' ' ' <"$dir/both"))" $?
nm -g --defined-only "$B/obj/src/core"/*.o | sed -n 's/^[0-9a-f]* [BDC] //p' >"$dir/both"
test ! -s "$dir/both"
ok "src/core has no global variables ($(tr '\n' ' ' <"$dir/both"))" $?
finish
