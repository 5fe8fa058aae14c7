#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_identity.sh - the same bits from other compilers, options, threads and another libm: the part
# of `make identity` that takes seconds. And what would differ is noticed.
set -u
. tests/claims.sh
tests/identity.sh quick
ok "the same bits" $?
"$stein" version --hash | sed 1d >"$dir/hash"
same "those that were accepted (make golden accepts others)" "$dir/hash" tests/golden/hash
# one bit in the square of an angle
sed 's/z = x \* x, half = 0.5 \* z, one = 1.0 - half/z = x * x * (1.0 + 0x1p-52), half = 0.5 * z, one = 1.0 - half/' src/core/elementary.h >"$dir/elementary.h"
cmp -s "$dir/elementary.h" src/core/elementary.h
ok "something was changed" $((! $?))
# what takes sines itself; the rest unchanged, if the archive needs no library of its compiler
case ${B##*/} in
*-*) cp src/core/*.c "$dir" && rest=$(echo "$B"/models/*.c) ;;
*) cp src/core/elementary.c src/core/sim.c src/core/dynamics.c "$dir" && rest=$B/libstein.a ;;
esac
cp -n src/core/*.h "$dir"
# shellcheck disable=SC2086
${CC:-cc} -std=c11 -O0 -D_POSIX_C_SOURCE=200809L -I"$dir" -Iinclude -I"$B/include" -ffp-contract=off \
    -fno-tree-slp-vectorize "$dir"/*.c tests/identity/main.c $rest -lm -o "$dir/core" || exit 1
was=$("$B/stein" version --hash | sed -n 's/^core *//p')
now=$("$dir/core")
test -n "$was" && test -n "$now" && test "$was" != "$now"
ok "one last bit in the square of an angle changes the hash: $was, $now" $?
finish
