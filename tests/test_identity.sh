#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_identity.sh - the same bits from other compilers, options, threads and another libm: the part
# of `make identity` that takes seconds. And what would differ is noticed.
set -u
tests/identity.sh quick || exit 1
B=${STEIN_BUILD:-build}
tmp=$(mktemp -d) || exit 1
trap 'rm -rf "$tmp"' EXIT
# one bit in the square of an angle
sed 's/z = x \* x, half = 0.5 \* z, one = 1.0 - half/z = x * x * (1.0 + 0x1p-52), half = 0.5 * z, one = 1.0 - half/' src/core/elementary.h >"$tmp/elementary.h"
cmp -s "$tmp/elementary.h" src/core/elementary.h && { echo "FAILED: nothing was changed"; exit 1; }
cp src/core/*.c "$tmp"; cp -n src/core/*.h "$tmp"
${CC:-cc} -std=c11 -O0 -D_POSIX_C_SOURCE=200809L -I"$tmp" -Iinclude -I"$B/include" -ffp-contract=off \
    -fno-tree-slp-vectorize "$tmp"/*.c "$B"/models/*.c tests/identity/main.c -lm -o "$tmp/core" || exit 1
was=$("$B/stein" version --hash | sed -n 's/^core *//p')
now=$("$tmp/core") && [ -n "$was" ] && [ -n "$now" ] || { echo "FAILED: no hash"; exit 1; }
if [ "$was" = "$now" ]; then
    echo "FAILED: one last bit in the square of an angle is not noticed"
    exit 1
fi
echo "test_identity: one last bit changes the hash: $was, $now"
