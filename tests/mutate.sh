#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# mutate.sh N SEED JOBS [FILE...] - the checks checked: N small mistakes (tests/mutate/mutate.c), drawn
# with SEED from generator, contact laws, notch and integrators, or from FILEs, one at a time in a copy
# of the sources; the suites that could find it run until one does. Prints every mutant and the share
# that was found, file by file; survivors.txt states why some cannot be found. What it measured is
# in build-mutate/results. Ends with 1 when fewer than 90 % are found or a survivor has no reason.
set -u
n=$1 seed=$2 jobs=$3
shift 3
M=$PWD/build-mutate
known=$PWD/tests/mutate/survivors.txt
mkdir -p "$M"
[ $# -gt 0 ] || set -- gen/dyn.c gen/emit.c gen/expr.c gen/frames.c gen/gen.c gen/kin.c gen/recombine.c \
    gen/search.c gen/setup.c gen/solve.c gen/tables.c gen/text.c src/core/law.c src/core/laws.h \
    src/core/contact.c src/core/forces.c src/core/inputs.c src/core/contact_sites.c src/core/notch.c \
    src/core/trial.c src/core/step.c src/core/adapt.c

# the suites that can find a mistake in a file, quick ones first; SUITE.CASE is one case of a suite
suites() {
    case $1 in
    gen/*) echo generator.graph generator.arm generator.text parts generator.models table generator.trees faults.generate generator.compiled ;;
    *) echo core law contact parts integrator stroke table facts wrong batch effects ;;
    esac
}
tests_of() { # TREE SUITE SECONDS: run it there, with its own cache and limits
    (
        cd "$1" && rm -rf cache || exit 1
        case $2 in faults.*) timeout -k 2 "$3" build/faults "${2#*.}" >log 2>&1; exit ;; esac
        ulimit -v 4000000 && ulimit -f 1000000
        case $2 in *.*) export CK_RUN_CASE="${2#*.}" ;; esac
        XDG_CACHE_HOME=$1/cache STEIN_BUILD=build CK_RUN_SUITE=${2%.*} timeout -k 2 "$3" build/check >log 2>&1
    )
}
# undefined behaviour of what was changed is a crash
build() { make -s -C "$1" B=build OPT=-O2 CFLAGS="-w -fsanitize=undefined -fsanitize-undefined-trap-on-error" -o build/steingen build/check build/faults >"$1/log" 2>&1; }

# ---- copies of the sources, built once; every suite has to pass in them, and its time is kept
cc -std=c11 -O1 -o "$M/mutate" tests/mutate/mutate.c || exit 1
i=0
while [ $i -lt "$jobs" ]; do
    [ -d "$M/$i" ] || [ $i = 0 ] || cp -Rp "$M/0" "$M/$i"
    find Makefile make packaging src gen include models tests bench -type f | while read -r f; do
        cmp -s "$f" "$M/$i/$f" || { mkdir -p "$M/$i/$(dirname "$f")" && cp "$f" "$M/$i/$f"; }
    done
    make -s -C "$M/$i" B=build OPT=-O2 CFLAGS=-w build/check build/faults build/steingen >"$M/$i/log" 2>&1 ||
        { echo "mutate: the sources do not build, see $M/$i/log"; exit 1; }
    i=$((i + 1))
done
[ -n "${KEEP:-}" ] && [ -f "$M/times" ] || : >"$M/times"
for suite in $(for f in "$@"; do suites "$f"; done | tr ' ' '\n' | sort -u); do
    ! grep -q "^$suite " "$M/times" || continue
    begin=$(date +%s)
    tests_of "$M/0" "$suite" 300 || { echo "mutate: $suite fails without any mistake"; exit 1; }
    echo "$suite $((6 * ($(date +%s) - begin) + 10))" >>"$M/times"
done

# ---- the mutants; with KEEP=1 what was found before needs not be found again
[ -n "${KEEP:-}" ] && [ -f "$M/results" ] || : >"$M/results"
"$M/mutate" list "$seed" "$n" "$@" >"$M/list.all" || exit 1
awk -F'\t' 'FILENAME ~ /list/ { wanted[$1 FS $4 FS $5]; next }
    $1 != "survived" && ($2 FS $4 FS $5 in wanted)' "$M/list.all" "$M/results" >"$M/found"
mv "$M/found" "$M/results"
awk -F'\t' 'FILENAME ~ /results/ { done[$2 FS $4 FS $5]; next } !($1 FS $4 FS $5 in done)' \
    "$M/results" "$M/list.all" >"$M/list"
try() { # TREE FILE NUMBER: what became of it
    "$M/mutate" apply "$2" "$3" >"$1/$2"
    if ! build "$1"; then
        echo "not built"
        return
    fi
    for suite in $(suites "$2"); do
        tests_of "$1" "$suite" "$(sed -n "s/^$suite //p" "$M/times")"
        case $? in
        0) ;;
        124 | 137) echo "killed by time in $suite"; return ;;
        *) echo "killed by $suite"; return ;;
        esac
    done
    echo survived
}
worker() { # K: every file that is the K-th of JOBS
    tree=$M/$1 last=
    awk -F'\t' -v k="$1" -v jobs="$jobs" '$1 != last { last = $1; n++ } n % jobs == k' "$M/list" |
        while IFS='	' read -r file number line change text; do
            [ "$last" = "$file" ] || [ -z "$last" ] || cp "$last" "$tree/$last"
            last=$file
            fate=$(try "$tree" "$file" "$number" </dev/null)
            printf '%s\t%s\t%s\t%s\t%s\n' "$fate" "$file" "$line" "$change" "$text" | tee -a "$M/results"
        done
}
k=0
while [ $k -lt "$jobs" ]; do
    worker $k &
    k=$((k + 1))
done
wait

# ---- what came out; a survivor is known by its file, its change and the text of its line
awk -F'\t' '
    FILENAME ~ /survivors/ { if (NF > 3) why[$1 FS $2 FS $3] = $4; next }
    $1 == "not built" { next }
    { all[$2]++; total++ }
    $1 ~ /^killed/ { killed[$2]++; found++; next }
    (reason = why[$2 FS $4 FS $5]) != "" { known[$2]++; explained++; next }
    { open = open "  " $2 ":" $3 "  " $4 "  in  " $5 "\n" }
    END {
        printf "\n%-24s %8s %8s %10s\n", "file", "mutants", "killed", "explained"
        for (f in all) printf "%-24s %8d %7.1f%% %10d\n", f, all[f], 100 * killed[f] / all[f], known[f] | "sort"
        close("sort")
        printf "%-24s %8d %7.1f%% %10d\n", "all", total, 100 * found / total, explained
        if (open != "") printf "\nsurvivors without a reason in tests/mutate/survivors.txt:\n%s", open
        exit open != "" || found < 0.9 * total
    }' "$known" "$M/results"
