#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# identity.sh - the same bits everywhere: `make identity` and, with "quick", a part of `make check`.
# Prints a table of builds and their hashes; ends with 1 when two of them differ.
#
# A build of the core is core, equations and tests/identity/main.c; a whole build is the program
# `stein`, whose hashes of a sweep and a fit go through the lab and GSL as well. A missing compiler
# or emulator is reported and skipped.
set -u
B=${STEIN_BUILD:-build}
tmp=$(mktemp -d) || exit 1
trap 'rm -rf "$tmp"' EXIT
jobs=$(nproc 2>/dev/null || echo 1)
builds=0 different=0
core='' sweep='' fit=''

row() { printf '%-58s %-17s %-17s %s\n' "$@"; }
# hash NAME CORE [SWEEP FIT]: compare with the first of its kind
hash() {
    builds=$((builds + 1))
    mark=
    : "${core:=$2}"
    [ -n "$2" ] && [ "$2" = "$core" ] || mark=' DIFFERENT'
    if [ $# -gt 2 ]; then
        : "${sweep:=$3}" "${fit:=$4}"
        [ -n "$3" ] && [ -n "$4" ] && [ "$3" = "$sweep" ] && [ "$4" = "$fit" ] || mark=' DIFFERENT'
    fi
    [ -z "$mark" ] || different=$((different + 1))
    row "$1" "$2" "${3--}" "${4--}$mark"
}
# whole NAME COMMAND...: a program `stein`
whole() {
    name=$1
    shift
    "$@" version --hash >"$tmp/out" 2>"$tmp/err" || { cat "$tmp/err"; : >"$tmp/out"; }
    part() { sed -n "s/^$1 *//p" "$tmp/out"; }
    hash "$name" "$(part core)" "$(part sweep)" "$(part fit)"
}
# of_core RUNNER CC FLAG...: RUNNER may be empty, words separated by blanks
of_core() {
    runner=$1 cc=$2
    shift 2
    # shellcheck disable=SC2086
    if ! command -v "$cc" >/dev/null || { [ -n "$runner" ] && ! command -v ${runner%% *} >/dev/null; }; then
        row "core: $cc $*" "not here" "" ""
        return
    fi
    mkdir "$tmp/o"
    for source in src/core/*.c "$B"/models/*.c tests/identity/main.c; do echo "$source"; done |
        xargs -P "$jobs" -I{} sh -c '
            source=$1 folder=$2; shift 2
            exec "$@" -c "$source" -o "$folder/$(basename "$source").o"' - {} "$tmp/o" \
            "$cc" -std=c11 -D_POSIX_C_SOURCE=200809L -Iinclude -I"$B/include" -Isrc/core \
            -ffp-contract=off -fno-tree-slp-vectorize "$@" &&
        "$cc" "$@" "$tmp"/o/*.o -lm -o "$tmp/core" 2>"$tmp/err" || cat "$tmp/err"
    # shellcheck disable=SC2086
    hash "core: $cc $*" "$($runner "$tmp/core")"
    rm -rf "$tmp/o" "$tmp/core"
}
# of_all CC AR FLAG...: the whole program. Its bits are asked, not what this optimiser warns of.
of_all() {
    cc=$1 ar=$2
    shift 2
    if ! command -v "$cc" >/dev/null; then
        row "stein: $cc $*" "not here" "" ""
        return
    fi
    ${MAKE:-make} -s -j"$jobs" B="$tmp/b" CC="$cc" AR="$ar" OPT="$*" CFLAGS=-Wno-error "$tmp/b/stein" >"$tmp/log" 2>&1 ||
        tail -n 5 "$tmp/log"
    whole "stein: $cc $*" "$tmp/b/stein"
    rm -rf "$tmp/b"
}

row build core sweep fit
one() { "$B/stein" "$@" --jobs 1; }
whole "stein as it is, one thread" one
two() { "$B/stein" "$@" --jobs 2; }
whole "stein as it is, two threads" two
plain() { GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-FMA,-AVX2_Usable,-FMA_Usable "$B/stein" "$@"; }
whole "stein as it is, libm without fused multiplication" plain
# quick: a build that could fuse a product with a sum
if [ "${1-}" = quick ]; then
    of_core '' gcc -O1 -march=native
else
    for cc in gcc clang; do
        for flags in -O0 -O1 -O2 -O3 -Os '-O3 -march=native' '-O2 -flto'; do
            # shellcheck disable=SC2086
            of_core '' $cc $flags
        done
    done
    of_core '' i686-linux-gnu-gcc -O2 -msse2 -mfpmath=sse
    for flags in -O0 -O2 -O3; do
        of_core 'qemu-aarch64 -L /usr/aarch64-linux-gnu' aarch64-linux-gnu-gcc $flags
        of_core 'qemu-riscv64 -L /usr/riscv64-linux-gnu' riscv64-linux-gnu-gcc $flags
    done
    of_all gcc ar -O0
    of_all gcc ar -O3 -march=native
    of_all gcc gcc-ar -O2 -flto=auto
    of_all clang ar -O2
    of_all clang ar -O3 -march=native
fi
echo "identity: $builds builds, $different different"
test "$different" -eq 0
