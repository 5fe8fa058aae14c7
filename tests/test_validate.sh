#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_validate.sh - published problems come out as published: the rows of `make validate`.
set -u
. tests/claims.sh

"$B/validate" >"$dir/rows"
ok "mechanisms and the action of 1788 are where they are published" $?
"$B/validate-nist" >>"$dir/rows"
ok "the minimiser of a fit finds all 54 minima of NIST's regressions, to 6 digits" $?
awk -F '\t' '$7 != "yes" || NF != 9 { print; bad = 1 } END { exit bad }' "$dir/rows"
ok "every row has its nine cells and is passed" $?
[ "$(wc -l <"$dir/rows")" -eq "$(sed -n '/^<!-- validate: -->/,/^<!-- end -->/p' docs/validation.md | grep -c '| yes |')" ]
ok "the table of docs/validation.md has the same rows" $?

finish
