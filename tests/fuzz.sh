#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# fuzz.sh SECONDS [TARGET...] - libFuzzer on every target for so long, from its kept inputs, as many
# targets at once as there are processors. New inputs stay in build-fuzz/corpus/; a failing input is
# named. Ends with 1 when there is one. RECORD=FILE: a table of the inputs and failures of all runs,
# to which this run is added. BYTES: of the longest input; short ones are tried several times as
# often. MANY: the build that does not trace comparisons, any input changed as often as any other,
# less freed memory kept and none of it filled: more inputs with the same checks, which find new
# paths more slowly.
set -u
seconds=${1:-60}
[ $# -eq 0 ] || shift
B=build-fuzz${MANY:+many}
if [ -z "${FUZZ_ONE:-}" ]; then
    rm -f "$B"/*.count
    # shellcheck disable=SC2046,SC2048,SC2086
    printf '%s\n' ${*:-$(ls tests/fuzz/corpus)} | xargs -P "$(nproc)" -n 1 env FUZZ_ONE=1 sh "$0" "$seconds"
    failed=$?
    if [ -n "${RECORD:-}" ]; then
        [ -e "$RECORD" ] || echo "target,inputs,failures" >"$RECORD"
        awk -F, -v OFS=, 'FNR == 1 && NR == 1 {print; next}
            !($1 in inputs) {order[++n] = $1}
            {inputs[$1] += $2; failures[$1] += $3}
            END {for (i = 1; i <= n; i++) print order[i], inputs[order[i]], failures[order[i]]}' \
            "$RECORD" "$B"/*.count >"$RECORD.new" && mv "$RECORD.new" "$RECORD" || exit 1
        awk -F, 'NR > 1 {printf "fuzz %s: %d inputs in all runs, %d failures\n", $1, $2, $3}' "$RECORD"
    fi
    [ $failed -eq 0 ] || exit 1
    exit 0
fi
target=$1
failed=0
case $target in
mechanism) most=4096 ;;
csv) most=4096 ;;
*) most=1024 ;;
esac
most=${BYTES:-$most}
# every block of memory has written down where it came from, which costs; more of that is for whoever
# looks at a failure
checks=malloc_context_size=2:quarantine_size_mb=16
[ -z "${MANY:-}" ] || checks=malloc_context_size=0:quarantine_size_mb=4:max_malloc_fill_size=0
export ASAN_OPTIONS="$checks${ASAN_OPTIONS:+:$ASAN_OPTIONS}"
found=build-fuzz/corpus/$target
mkdir -p "$found"
if "$B/fuzz-$target" -max_total_time="$seconds" -max_len=$most -timeout=20 -rss_limit_mb=3000 \
    -close_fd_mask=3 -print_final_stats=1 ${MANY:+-entropic=0} -artifact_prefix="$found/failed-" \
    -dict="tests/fuzz/$target.dict" "$found" "tests/fuzz/corpus/$target" >"$B/$target.log" 2>&1; then
    what=ok
else
    what=FAILED
    failed=1
    # the input, and what is said about it by a second run that may write
    grep -m 3 -E '^SUMMARY|Test unit written|^Base64' "$B/$target.log"
    input=$(sed -n 's/.*Test unit written to //p' "$B/$target.log")
    [ -z "$input" ] || "$B/fuzz-$target" "$input" 2>&1 | grep -m 3 -E 'does not hold|ERROR|runtime error'
fi
runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$B/$target.log")
echo "$target,${runs:-0},$failed" >"$B/$target.count"
awk -v n="${runs:-0}" -v s="$seconds" -v what="fuzz $target: $what" 'BEGIN {
    printf "%s, %d inputs in %d s, 1e8 take %.1f h at this rate\n", what, n, s, (n > 0 ? 1e8 * s / n / 3600 : 0)}'
exit $failed
