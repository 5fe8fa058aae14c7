#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_realtime.sh - external names of the core, one by one, and races between two threads in it.
set -u
. tests/claims.sh

# ---- an allow-list of undefined symbols
# needs FILE...: names that come from outside of the library
needs() { nm -u "$@" | awk '$1 == "U" {print $2}' | grep -vE '^(stein_|_GLOBAL_OFFSET_TABLE_)' | sort -u; }
# only CLAIM PATTERN FILE...
only() {
    claim=$1 pattern=$2
    shift 2
    needs "$@" | grep -vxE "$pattern" >"$dir/extra"
    test ! -s "$dir/extra"
    ok "$claim (extra: $(tr '\n' ' ' <"$dir/extra"))" $?
}
# copies of memory; floor, fmin and fmax are exact and never write errno
pure='mem(cpy|move|set|cmp)|floor|fmin|fmax'
case $B in
*-*) echo "test_realtime: $B is not the release build, its symbols are not counted" ;;
*)
    for object in "$B"/obj/src/core/*.o; do
        case $object in
        */sim.o) only "sim.o also allocates by default, and compares names" "$pure|malloc|free|strcmp" "$object" ;;
        */handover.o) only "handover.o is pure" "$pure" "$object" ;;
        # products of complex numbers, which clang leaves to the compiler's own library
        */tangent.o) only "tangent.o is pure" "$pure|__stack_chk_fail|__(mul|div)dc3" "$object" ;;
        *) only "$(basename "$object") is pure" "$pure|__stack_chk_fail" "$object" ;;
        esac
    done
    # the formulas of a file may take a root
    only "equations are pure" "$pure|sqrt" "$B"/obj/models/*.o
    only "so are both in lanes" "$pure|sqrt" "$B"/obj/lanes*/*.o
    # constant tables of addresses stand in .data.rel.ro; .data, .data.rel and .bss are what could change
    writable=$(size -A "$B"/obj/src/core/*.o "$B"/obj/models/*.o "$B"/obj/lanes*/*.o |
        awk '/^\.t?(data|bss)(\.rel(\.local)?)? / {n += $2} END {print n + 0}')
    test "$writable" = 0
    ok "core and equations have no mutable globals ($writable bytes)" $?
    ;;
esac

# ---- two threads
printf '#include <pthread.h>\nstatic void *f(void *p) { return p; }\nint main(void) { pthread_t t; return pthread_create(&t, 0, f, 0) || pthread_join(t, 0); }\n' >"$dir/t.c"
tsan='-fsanitize=thread -O0 -g -fPIE -pie'
# shellcheck disable=SC2086
if ${CC:-cc} $tsan "$dir/t.c" -o "$dir/t" -pthread 2>/dev/null && "$dir/t" 2>/dev/null; then
    # shellcheck disable=SC2086
    ${CC:-cc} -std=c11 $tsan -ffp-contract=off -Iinclude -Isrc/core -D_POSIX_C_SOURCE=200809L \
        tests/threads/handover.c src/core/*.c "$B/models/stein1788.c" -lm -pthread -o "$dir/handover" 2>"$dir/log"
    ok "the core is built with the thread sanitizer ($(head -n 1 "$dir/log"))" $?
    TSAN_OPTIONS=halt_on_error=1 "$dir/handover" >"$dir/out" 2>"$dir/log"
    ok "parameters of another thread race with nothing: $(cat "$dir/out"; grep -m 1 WARNING "$dir/log")" $?
    found=1 # the sanitizer forgets: where one thread runs long before the other it may detect nothing
    for attempt in 1 2 3 4 5; do
        TSAN_OPTIONS=halt_on_error=1 "$dir/handover" racy >"$dir/out" 2>"$dir/log" && continue
        grep -q 'data race' "$dir/log" && found=0 && break
    done
    ok "a race would have been found ($attempt attempts)" $found
else
    echo "test_realtime: no thread sanitizer here, races are not looked for"
fi

finish
