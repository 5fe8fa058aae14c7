#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_locale.sh - in a host that writes 1,5 for one and a half every file is the same, byte for byte:
# equations, data, pictures, fitted mechanisms, JSON of numbers. (tests/locale/main.c is the host.)
set -u
. tests/claims.sh
unset LC_ALL
LOCPATH=$dir/locales
export LOCPATH
mkdir "$LOCPATH"
if ! command -v localedef >/dev/null || ! localedef -i de_DE -f UTF-8 "$LOCPATH/de_DE.UTF-8" 2>"$dir/err" >&2; then
    echo "test_locale: skipped, no localedef or no source of de_DE: apt-get install locales"
    exit 0
fi
if [ "$(LC_ALL=de_DE.UTF-8 printf '%.1f' 1,5 2>/dev/null)" = 1,5 ]; then comma='a comma'; else comma='not seen by this shell'; fi

pendulum=models/pendulum.yaml
for locale in C de_DE.UTF-8; do
    to=$dir/$locale
    mkdir "$to"
    run() { claim 0 "$locale: $1 $2" "$B/comma" $locale "$@"; }
    run strike models/stein1788.yaml --set load.mass=90.5g --until 70.25ms -o "$to/strike.csv" --plot "$to/strike.svg"
    run strike models/stein1788.yaml --set load.mass=90.5g --until 70.25ms --json
    cp "$dir/out" "$to/strike.json"
    run sweep models/stein1788.yaml --vary pawl.stop_shift=-1.2:0:5mm --vary load.mass=90.5,100g --until 20ms \
        -o "$to/sweep.csv" --plot "$to/sweep.svg" --journal "$to/journal" -j 1
    run merge "$to/journal" -o "$to/merged.csv"
    run generate models/stein1788.yaml -o "$to"
    sed 's/centre: .*/centre: [3.5 mm, 0, -174 mm]/' $pendulum >"$dir/own.yaml"
    XDG_CACHE_HOME=$to/cache run simulate "$dir/own.yaml" --until 400ms -o "$to/own.csv"
    grep -v '^#' "$to/own.csv" | cut -d, -f1,2 >"$dir/swing.csv"
    run fit "$dir/own.yaml" "$dir/swing.csv" --free rod.damping --set rod.mass=210.5g -o "$to/fitted.yaml"
    run check --json "$to/fitted.yaml"
    grep -v '"file"' "$dir/out" >"$to/check.json"
    run version --hash
    cp "$dir/out" "$to/hash"
    rm -rf "$to/cache"
done
"$B/comma" de_DE.UTF-8 check $pendulum >"$dir/out"
if grep -q '[0-9],[0-9]' "$dir/out"; then pass; else fail "the host has a comma ($comma)"; fi
diff -r "$dir/C" "$dir/de_DE.UTF-8" >"$dir/err"
if [ ! -s "$dir/err" ]; then pass; else fail "files differ"; fi
n=$(find "$dir/C" -type f | wc -l)
if [ "$n" = 12 ]; then pass; else fail "$n files, expected 12"; fi
finish "$n files compared"
