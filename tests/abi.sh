#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# abi.sh - may a program that was linked with an earlier libstein.so run with this one? abidiff
# against the description that tests/abi/ keeps (`make abi`), the description of the last release
# or, before the first one, the last accepted one. `abi.sh accept` (make abi-accept) keeps this one.
#
# New functions are welcome. A function that is gone, other arguments or another layout of a public
# structure need a larger SOVERSION (packaging/install.mk) and version; then accept.
set -u
B=${STEIN_BUILD:-build}
kept=tests/abi/libstein.abi.gz
for tool in abidw abidiff; do
    command -v "$tool" >/dev/null || { echo "abi: no $tool, not compared - run: apt-get install abigail-tools"; exit 0; }
done
tmp=$(mktemp -d) || exit 1
trap 'rm -rf "$tmp"' EXIT
# declarations of public headers: private types end as names; places in files are left out
abidw --no-corpus-path --no-comp-dir-path --headers-dir include --drop-private-types "$B/libstein.so" |
    sed "s/ filepath='[^']*'//; s/ line='[0-9]*'//; s/ column='[0-9]*'//" >"$tmp/now.abi" || exit 1
if [ "${1-}" = accept ]; then
    gzip -9nc "$tmp/now.abi" >"$kept.new" && mv "$kept.new" "$kept"
    exit
fi
gunzip -c "$kept" >"$tmp/kept.abi" || exit 1
# the list of built-in mechanisms may grow: its length is private; so may the list of status codes
printf '[suppress_variable]\n  name = stein_models\n' >"$tmp/ignored"
printf '[suppress_type]\n  type_kind = enum\n  name = stein_status\n  changed_enumerators = STEIN_STATUS_COUNT\n' >>"$tmp/ignored"
abidiff --suppressions "$tmp/ignored" --no-added-syms "$tmp/kept.abi" "$tmp/now.abi" && {
    echo "abi: $(nm -D --defined-only "$B/libstein.so" | grep -c ' [TDBR] ') symbols, nothing taken away or changed"
    exit 0
}
echo "abi: programs would have to be linked or compiled anew: raise SOVERSION and the version, then make abi-accept"
exit 1
