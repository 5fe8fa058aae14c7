#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_second.sh: 10 random mechanisms that touch move as in Simbody, where that is installed.
set -eu
if [ ! -x "${STEIN_BUILD:-build}/second" ]; then
    echo "test_second: skipped, Simbody is not here: apt-get install libsimbody-dev"
    exit 0
fi
sh tests/second.sh 0 10 1
