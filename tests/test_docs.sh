#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_docs.sh - what the documents show is true: every mechanism in them is read, every key of the
# reference is known to the reader, every file and command they name exists.
set -u
. tests/claims.sh

for doc in README.md docs/mechanism-files.md; do
    name=$dir/$(basename "$doc" .md).yaml
    sed -n '/^```yaml$/,/^```$/p' "$doc" | sed '/^```/d' >"$name"
    "$stein" check "$name" >"$dir/out" 2>&1 || cat "$dir/out"
    "$stein" check "$name" >/dev/null 2>&1
    ok "$doc: its mechanism is read" $?
    "$stein" simulate "$name" --until 20ms --json >"$dir/out" 2>&1 || cat "$dir/out"
    grep -q '"final"' "$dir/out"
    ok "$doc: its mechanism runs" $?
done

for doc in README.md CONTRIBUTING.md docs/*.md examples/README.md; do
    grep -o ']([^)]*)' "$doc" | sed 's/^](//; s/)$//; /^http/d' | while read -r link; do
        test -e "$(dirname "$doc")/$link" || echo "$link"
    done >"$dir/dead"
    test ! -s "$dir/dead"
    ok "$doc: its links lead somewhere ($(tr '\n' ' ' <"$dir/dead"))" $?
done

# functions and folders that they name
for name in $(sed -n '/^```c$/,/^```$/s/.*\(stein_[a-z_]*\)(.*/\1/p' docs/embedding.md | sort -u); do
    grep -q "[ *]$name(" include/stein/*.h
    ok "docs/embedding.md: $name is declared" $?
done
for folder in $(sed -n 's/^| `\([a-z0-9]*\)\/`.*/\1/p' examples/README.md); do
    test -e "examples/$folder/Makefile"
    ok "examples/README.md: $folder is there" $?
done

for doc in README.md CONTRIBUTING.md docs/*.md; do
    for command in $(sed -n 's/^ *build\/stein \([a-z]*\) .*/\1/p' "$doc" | sort -u); do
        "$stein" help "$command" >/dev/null 2>&1
        ok "$doc: stein $command exists" $?
    done
    for target in $(sed -n 's/^.*`make \([a-z-]*\)[ `].*/\1/p; s/^    make \([a-z-]*\)\( .*\)*$/\1/p' "$doc" | sort -u); do
        grep -q "^$target:" Makefile make/*.mk packaging/*.mk
        ok "$doc: make $target exists" $?
    done
done

# options of a command that a document shows
"$stein" help diagnose >"$dir/help"
for option in $(grep -oh '`--[a-z-]*' docs/diagnosis*.md | tr -d '`' | sort -u); do
    grep -q -- "$option" "$dir/help"
    ok "docs/diagnosis.md: stein diagnose $option exists" $?
done

# files that documents name by their path
for doc in README.md CONTRIBUTING.md docs/*.md; do
    for path in $(grep -oE '`(src|tests|models|bench|gen|docs|include)/[A-Za-z0-9_./]*`' "$doc" | tr -d '`' | sort -u); do
        test -e "$path"
        ok "$doc: $path is there" $?
    done
done

# thresholds of the diagnosis: the table has those of the header, in its order, with the same values
# and a reason; each decides something
thresholds=src/lab/search/thresholds.h
sed -n 's/^static const double \(diag__[a-z_]*\)\(\[\]\)* = {*\([^;}]*\)}*;.*/\1 \3/p
        s/^    \(DIAG_[A-Z_]*\) = \([0-9]*\).*/\1 \2/p' $thresholds | sed 's/\.0$//' >"$dir/header"
sed -n '/^## Thresholds/,$p' docs/diagnosis-details.md |
    sed -n 's/^| `\([A-Za-z_]*\)` \([0-9][0-9.e, -]*[0-9]\|[0-9]\)[^|]*| ..* |$/\1 \2/p' >"$dir/table"
diff "$dir/header" "$dir/table"
ok "docs/diagnosis-details.md has the thresholds of $thresholds" $?
test "$(wc -l <"$dir/header")" -gt 20 && test "$(wc -l <"$dir/header")" -le 40
ok "there are at most 40 thresholds ($(wc -l <"$dir/header"))" $?
test "$(grep -cE '^(static const|enum \{ | +DIAG_)' $thresholds)" = "$(($(wc -l <"$dir/header") + 1))"
ok "$thresholds has no number that the table does not know" $? # but the number of gains
while read -r name value; do
    grep -rqw "$name" src/lab --include='*.c'
    ok "$name ($value) decides something" $?
done <"$dir/header"

# the folders of docs/architecture.md are all folders of sources, and its table has them all
for folder in $(find src gen -type d -exec sh -c 'ls "$1"/*.c >/dev/null 2>&1 && echo "$1"' _ {} \; | grep -v stein$); do
    grep -q "\`$folder/\|\`${folder##*/}/\`" docs/architecture.md
    ok "docs/architecture.md tells what $folder holds" $?
done

# ten habits
test "$(grep -c '^[0-9]*\. \*\*' CONTRIBUTING.md)" = 10
ok "CONTRIBUTING.md has ten habits" $?

test "$(wc -l <README.md)" -le 150
ok "README.md is a page" $?
test "$(wc -l <Makefile)" -lt 250
ok "the Makefile is short" $?

finish
