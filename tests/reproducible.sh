#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# reproducible.sh - the same bytes in any folder: libraries and programs built in two folders with
# names of different lengths, by `make reproducible`. Ends with 1 when two of them differ.
set -u
tmp=$(mktemp -d) || exit 1
trap 'rm -rf "$tmp"' EXIT
one=$tmp/one two=$tmp/a/folder/further/down
products="libstein.a libsteinlab.a libstein.so libsteinlab.so stein steingen"
jobs=$(nproc 2>/dev/null || echo 1)
for folder in "$one" "$two"; do
    mkdir -p "$folder" && tar cf - --exclude='./build*' --exclude=./.git . | tar xf - -C "$folder" || exit 1
    # shellcheck disable=SC2086
    (cd "$folder" && env -u MAKEFLAGS -u MAKELEVEL ${MAKE:-make} -s -j"$jobs" $(printf 'build/%s ' $products)) \
        >"$tmp/log" 2>&1 || { tail -n 20 "$tmp/log"; exit 1; }
done
different=0
for product in $products; do
    if cmp -s "$one/build/$product" "$two/build/$product"; then
        printf 'same bytes   %10d  %s\n' "$(wc -c <"$one/build/$product")" "$product"
    else
        printf 'DIFFERENT    %10s  %s\n' '' "$product"
        different=$((different + 1))
    fi
done
test "$different" -eq 0
