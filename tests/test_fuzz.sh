#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_fuzz.sh - the kept inputs of the fuzz targets, as they are and damaged, on the readers as they
# were built: nothing crashes, and what tests/fuzz/*.c asks for holds. (`make fuzz` looks for more.)
set -u
B=${STEIN_BUILD:-build}
log=$(mktemp) || exit 1
trap 'rm -f "$log"' EXIT
failed=0 kept=0
for target in mechanism csv state journal set; do
    for input in tests/fuzz/corpus/$target/*; do
        kept=$((kept + 1))
        "$B/replay-$target" "$input" >"$log" 2>&1 || {
            failed=$((failed + 1))
            echo "FAILED: replay-$target $input: $(grep -m 1 -E 'does not hold|SUMMARY|rror' "$log")"
        }
    done
done
echo "test_fuzz: $kept kept inputs, $failed failed"
test "$failed" -eq 0
