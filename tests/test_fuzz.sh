#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_fuzz.sh - the kept inputs of the fuzz targets, as they are and damaged, on the readers as they
# were built: nothing crashes, and what tests/fuzz/*.c asks for holds. (`make fuzz` looks for more.)
set -u
. tests/claims.sh
for target in $(ls tests/fuzz/corpus); do
    for input in tests/fuzz/corpus/$target/*; do
        claim 0 "replay-$target $input" "$B/replay-$target" "$input"
    done
done
finish
