#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# second.sh COUNT JOBS: accelerations of COUNT random mechanisms here and in an independent library
# (tests/second/second.h): a table by kind. Fails where they differ by more than the bar. Near a
# singular position of loops the last digits are rounding: beyond a condition of 1e6 the bar is as
# much higher.
set -eu
count=$1 jobs=$2
program=$(pwd)/${STEIN_BUILD:-build}/second
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
i=0
while [ "$i" -lt "$jobs" ]; do
    (XDG_CACHE_HOME=$work/cache$i && export XDG_CACHE_HOME && "$program" "$i" "$count" "$jobs" >"rows$i" && : >"ended$i") &
    i=$((i + 1))
done
wait
cat rows* | sort -n | awk -F '\t' -v count="$count" '
    { near = $6 > 1e6; bar = 1e-10 * (near ? $6 / 1e6 : 1); group = near ? "near-singular" : $3
      n[group]++; bodies[group] += $2
      if ($4 + 0 > worst[group] + 0) worst[group] = $4
      if ($5 + 0 > open[group] + 0) open[group] = $5
      if (!($4 + 0 <= bar)) { far++; print "mechanism " $1 ": accelerations differ by " $4 ", condition " $6 } }
    END {
      printf "%-14s %10s %8s %16s %20s\n", "mechanisms", "compared", "bodies", "worst, relative", "loops open by [SI]"
      kinds = split("tree-plane tree-space closed-plane closed-space near-singular", kind, " ")
      for (k = 1; k <= kinds; k++) { all += n[kind[k]]
        printf "%-14s %10d %8d %16.1e %20.1e\n", kind[k], n[kind[k]], bodies[kind[k]], worst[kind[k]], open[kind[k]] }
      printf "%d of %d random mechanisms compared, %d differ by more than their bar\n", all, count, far
      exit far > 0 || all < count }'
[ "$(ls | grep -c '^ended')" -eq "$jobs" ]
