#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_faults.sh - failing memory and failing writes, for every command that writes: one message, an
# exit code, the previous file unchanged, no half-written file beside it.
set -u
. tests/claims.sh
XDG_CACHE_HOME=$dir/cache # its own

# ---- memory: tests/faults/main.c (its malloc is none of a sanitizer's)
case $B in
*san*) echo "test_faults: allocations are not made to fail under sanitizers" ;;
*) claim 0 "every allocation that fails is an error, and leaves nothing behind" "$B/faults"
   grep FAILED "$dir/out" | head -n 5
   grep -v FAILED "$dir/out" ;;
esac

# ---- writes
pendulum=models/pendulum.yaml
"$stein" simulate $pendulum --until 400ms --set rod.damping=2e-4 -o "$dir/all.csv" >/dev/null || exit 1
grep -v '^#' "$dir/all.csv" | cut -d, -f1,2 >"$dir/swing.csv"
"$stein" sweep $pendulum --vary rod.mass=200:220:100g --until 2ms --journal "$dir/journal" -o "$dir/sweep.csv" 2>"$dir/err" || exit 1

# every command that writes, to FILE
writer() { # writer NAME FILE
    case $1 in
    simulate) "$stein" simulate $pendulum --until 2s -o "$2" ;;
    strike) "$stein" strike models/stein1788.yaml --until 20ms -o "$2" ;;
    sweep) "$stein" sweep $pendulum --vary rod.mass=200:220:100g --until 2ms -o "$2" ;;
    merge) "$stein" merge "$dir/journal" -o "$2" ;;
    fit) "$stein" fit $pendulum "$dir/swing.csv" --free rod.damping -o "$2" ;;
    steingen) "$B/steingen" models/stein1788.yaml -o "$2" ;;
    esac
}
plot() { "$stein" simulate $pendulum --until 200ms --plot "$1"; }
journal() { "$stein" sweep $pendulum --vary rod.mass=200:220:300g --until 2ms --journal "$1" -o "$dir/rest.csv"; }
limited() { ( ulimit -f "$1"; shift; "$@" ); }
told() { # told TEXT PATTERN: it is said in one line
    says "$1 is told" "$2"
    if [ "$(grep -c 'cannot be written\|No space\|too large' "$dir/err")" = 1 ]; then pass; else fail "$1: in one line"; fi
}
mkdir "$dir/place"
# by a link of our own: a program that replaced the device by a file would replace the link
ln -s /dev/full "$dir/full"
for name in simulate strike sweep merge fit steingen; do
    claim 1 "$name to a full disk" writer $name "$dir/full"
    told "$name to a full disk" '/full'
    if [ -c "$dir/full" ]; then pass; else fail "$name: the device is one"; ln -sf /dev/full "$dir/full"; fi
    claim 1 "$name into a folder that is not there" writer $name "$dir/none/x"
    told "$name into a folder that is not there" 'none/x'
    [ $name = steingen ] || claim 1 "$name onto a folder" writer $name "$dir/place"
    echo previous >"$dir/place/file"
    claim 1 "$name where the disk ends in the middle" limited 1 writer $name "$dir/place/file"
    told "$name where the disk ends" 'place/file'
    if [ "$(cat "$dir/place/file")" = previous ]; then pass; else fail "$name: the previous file is intact"; fi
    if [ "$(ls -A "$dir/place")" = file ]; then pass; else fail "$name: nothing is left beside it: $(ls -A "$dir/place")"; fi
done
claim 1 "generate onto a file" "$stein" generate $pendulum -o "$dir/swing.csv"
claim 1 "generate where the disk ends" limited 1 "$stein" generate models/stein1788.yaml -o "$dir/equations"
told "generate where the disk ends" 'stein1788.c'
if [ -z "$(ls -A "$dir/equations" 2>/dev/null)" ]; then pass; else fail "generate: nothing is left"; fi
if command -v gnuplot >/dev/null; then
    echo previous >"$dir/place/file.svg"
    claim 1 "a picture where the disk ends" limited 1 plot "$dir/place/file.svg"
    if [ "$(cat "$dir/place/file.svg")" = previous ]; then pass; else fail "the previous picture is intact"; fi
    if [ "$(ls -A "$dir/place" | wc -l)" = 2 ]; then pass; else fail "a picture: nothing is left: $(ls -A "$dir/place")"; fi
fi
claim 1 "a journal where the disk ends" limited 2 journal "$dir/short"
told "a journal where the disk ends" 'short'
claim 0 "goes on when there is room" journal "$dir/short"

# a new mechanism is compiled into a cache: a cache that cannot be written is reported
sed 's/centre: .*/centre: [3 mm, 0, -174 mm]/' $pendulum >"$dir/own.yaml"
claim 1 "a cache that cannot be made" env XDG_CACHE_HOME=/dev/full "$stein" simulate "$dir/own.yaml" --until 1ms
claim 1 "a cache on a disk that ends" limited 1 "$stein" simulate "$dir/own.yaml" --until 1ms
claim 0 "is whole when there is room" "$stein" simulate "$dir/own.yaml" --until 1ms
own() { env -u XDG_CACHE_HOME -u HOME "$@" "$stein" simulate "$dir/own.yaml" --until 1ms; }
claim 1 "without a home there is no place for one" own
says "and what to set is told" 'set XDG_CACHE_HOME or HOME'
claim 1 "a home without a name is none" own HOME= XDG_CACHE_HOME=
claim 0 "one at home" own HOME="$dir/home"
if [ -n "$(find "$dir/home/.cache/stein" -name 'pendulum-*.so')" ]; then pass; else fail "has the equations"; fi
claim 0 "a relative one is none" own HOME="$dir/home" XDG_CACHE_HOME=cache-of-nobody
gone "and is not made" cache-of-nobody

# ---- standard output: full, and closed by its reader
for words in "check $pendulum" "check --json $pendulum" "simulate --until 1ms --json $pendulum" \
    "simulate --until 2s -o - $pendulum" "sweep $pendulum --vary rod.mass=1,2 --until 1ms" "effects" "effects --json" \
    "version" "version --json" "help" "help fit" "merge $dir/journal" "fit --json --free rod.damping $pendulum $dir/swing.csv"; do
    # shellcheck disable=SC2086
    "$stein" $words >/dev/full 2>"$dir/err"
    if [ $? = 1 ] && grep -q 'standard output' "$dir/err"; then pass; else fail "$words: a full standard output"; fi
done
# shellcheck disable=SC2016
claim 1 "a reader that goes away" sh -c '{ "$0" simulate models/stein1788.yaml --until 1s -o -; echo $? >"$1"; } | true; exit "$(cat "$1")"' \
    "$stein" "$dir/code"
says "is told" 'standard output'

# ---- folders and files without the right to write; root may always, so as somebody else
nobody=
[ "$(id -u)" = 0 ] && nobody='setpriv --reuid=65534 --regid=65534 --clear-groups'
if [ -z "$nobody" ] || $nobody true 2>/dev/null; then
    chmod 755 "$dir" && mkdir "$dir/locked" && echo previous >"$dir/locked/file" && chmod 555 "$dir/locked"
    chmod 444 "$dir/locked/file"
    cp "$B/stein" "$dir/stein" && cp $pendulum "$dir/p.yaml" && chmod 755 "$dir/stein"
    for file in new file; do
        # shellcheck disable=SC2086
        claim 1 "$file in a locked folder" $nobody "$dir/stein" simulate "$dir/p.yaml" --until 1ms -o "$dir/locked/$file"
        says "is told" "locked/$file"
    done
    if [ "$(ls -A "$dir/locked")" = file ] && [ "$(cat "$dir/locked/file")" = previous ]; then pass; else fail "a locked folder stays"; fi
else
    echo "test_faults: run by root without setpriv, locked folders are not tested"
fi
finish
