#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# libm.sh - what own elementary functions cost: the action's evaluation and its steps, against the
# same core with the platform's libm. Both programs run by turns; the least median of each counts.
set -u
B=${STEIN_BUILD:-build}
rounds=${ROUNDS:-5}
tmp=$(mktemp -d) || exit 1
trap 'rm -rf "$tmp"' EXIT
for i in $(seq "$rounds"); do
    for which in bench bench-libm; do
        "$B/$which" stein1788 --csv "$tmp/csv" >/dev/null || exit 1
        sed "1d;s/^/$which,/" "$tmp/csv" >>"$tmp/all"
    done
done
awk -F, '{k = $4; if (!((k, $1) in t) || $6 < t[k, $1]) t[k, $1] = $6; name[k] = 1}
    END {printf "%-34s %10s %10s %7s\n", "case", "own ns", "libm ns", "ratio"
         for (k in name) printf "%-34s %10.1f %10.1f %7.3f\n", k, t[k, "bench"], t[k, "bench-libm"], \
             t[k, "bench"] / t[k, "bench-libm"]}' "$tmp/all"
