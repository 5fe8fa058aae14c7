#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_fuzz.sh - the kept inputs of the fuzz targets, unchanged and damaged, on the built readers:
# nothing crashes, and the conditions in tests/fuzz/*.c hold. (`make fuzz` looks for more.)
set -u
. tests/claims.sh
for target in $(ls tests/fuzz/corpus); do
    for input in tests/fuzz/corpus/$target/*; do
        claim 0 "replay-$target $input" "$B/replay-$target" "$input"
    done
done
finish
