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

# thresholds of the diagnosis: each name stands in the code with the value of the table
sed -n '/^## Thresholds/,/^Not built/p' docs/diagnosis-details.md |
    grep -oE '`[A-Za-z_]+` [0-9][0-9.e-]*' | tr -d '`' | sort -u >"$dir/thresholds"
while read -r name value; do
    grep -rqE "[ _]$name(\[\])? = \{?$value[,;} ]|[ _]$name = $value(\.0)?[,;]?( |$)" src/lab/search src/lab/verdict src/lab/law \
        src/lab/fit src/lab/diagnosis
    ok "docs/diagnosis-details.md: $name is $value" $?
done <"$dir/thresholds"

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
