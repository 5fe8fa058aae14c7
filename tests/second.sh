#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# second.sh COUNT CONTACTS JOBS: accelerations of COUNT random mechanisms, and of CONTACTS that
# touch, here and in an independent library (tests/second/second.h); motions over 50 ms of the
# latter, too: a table by kind. Fails where they differ by more than the bar. Near a singular
# position of loops the last digits are rounding: beyond a condition of 1e6 the bar is as much higher.
set -eu
count=$1 contacts=$2 jobs=$3
program=$(pwd)/${STEIN_BUILD:-build}/second
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
i=0
while [ "$i" -lt "$jobs" ]; do
    (XDG_CACHE_HOME=$work/cache$i && export XDG_CACHE_HOME && mkdir "at$i" && cd "at$i" &&
        "$program" "$i" "$count" "$jobs" >"../rows$i" &&
        "$program" "$i" "$contacts" "$jobs" contacts >>"../rows$i" && : >"../ended$i") &
    i=$((i + 1))
done
wait
cat rows* | sort -n | awk -F '\t' -v count="$((count + contacts))" '
    { near = $6 > 1e6; bar = 1e-10 * (near ? $6 / 1e6 : 1); group = near ? "near-singular" : $3
      n[group]++; bodies[group] += $2
      if ($4 + 0 > worst[group] + 0) worst[group] = $4
      if ($5 + 0 > open[group] + 0) open[group] = $5
      if ($7 + 0 > motion[group] + 0) motion[group] = $7
      if (!($4 + 0 <= bar && $7 + 0 <= 1e-8)) { far++
        print "mechanism " $1 ", " $3 ": accelerations differ by " $4 ", motions by " $7 ", condition " $6 } }
    END {
      printf "%-14s %10s %8s %16s %20s %18s\n", "mechanisms", "compared", "bodies", "worst, relative", "loops open by [SI]", "motion, 50 ms [SI]"
      kinds = split("tree-plane tree-space closed-plane closed-space contacts-plane contacts-space contacts-dry near-singular", kind, " ")
      for (k = 1; k <= kinds; k++) if (n[kind[k]] > 0) { all += n[kind[k]]
        printf "%-14s %10d %8d %16.1e %20.1e %18.1e\n", kind[k], n[kind[k]], bodies[kind[k]], worst[kind[k]], open[kind[k]], motion[kind[k]] }
      printf "%d of %d random mechanisms compared, %d differ by more than their bar\n", all, count, far
      exit far > 0 || all < count }'
[ "$(ls | grep -c '^ended')" -eq "$jobs" ]
