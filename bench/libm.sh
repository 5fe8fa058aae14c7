#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# libm.sh - costs of the library's elementary functions: the action's evaluation and its steps,
# against the same core with the platform's libm. Both programs run by turns; the least of each
# counts.
set -u
B=${STEIN_BUILD:-build}
rounds=${ROUNDS:-5}
tmp=$(mktemp -d) || exit 1
trap 'rm -rf "$tmp"' EXIT
for i in $(seq "$rounds"); do
    for which in bench bench-libm; do
        "$B/$which" stein1788 --csv "$tmp/csv" >/dev/null || exit 1
        # a case is named by all between model and figures, commas included
        sed -n "s/^case,[^,]*,stein1788,\(.*\),\([0-9.]*\),[0-9.]*,,,[0-9]*$/$which|\1|\2/p" "$tmp/csv" >>"$tmp/all"
    done
done
printf '%-40s %12s %12s %7s\n' case 'own ns' 'libm ns' ratio
awk -F'|' '{k = $2; if (!((k, $1) in t) || $3 < t[k, $1]) t[k, $1] = $3; name[k] = 1}
    END {for (k in name) printf "%-40s %12.1f %12.1f %7.3f\n", k, t[k, "bench"], t[k, "bench-libm"], \
             t[k, "bench"] / t[k, "bench-libm"]}' "$tmp/all" | sort
