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

for doc in README.md docs/*.md examples/README.md; do
    sed -n 's/.*](\([^)h][^)]*\)).*/\1/p' "$doc" | while read -r link; do
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

for command in $(sed -n 's/^ *build\/stein \([a-z]*\) .*/\1/p' README.md | sort -u); do
    "$stein" help "$command" >/dev/null 2>&1
    ok "README.md: stein $command exists" $?
done

finish
