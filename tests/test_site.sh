#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_site.sh - make docs: every document is a page; the target of every link exists in the site,
# file and anchor.
set -u
. tests/claims.sh

if ! command -v cmark-gfm >/dev/null 2>&1 && ! command -v pandoc >/dev/null 2>&1; then
    echo "test_site: no cmark-gfm and no pandoc, the site is not written (make deps-check)"
    finish
    exit
fi
claim 0 "the site is written" sh packaging/site.sh "$dir/site"
shows "its first page is told" "^$dir/site/index.html\$"
for doc in README.md CONTRIBUTING.md docs/*.md examples/README.md; do
    page=$dir/site/$(echo "${doc%.md}.html" | sed 's#README\.html$#index.html#')
    test -s "$page"
    ok "$doc is a page" $?
    grep -q "<title>$(sed -n 's/^# *//p;T;q' "$doc")</title>" "$page"
    ok "$doc: its title is there" $?
done

# links PAGE: its addresses within the site
links() { grep -oE '(href|src)="[^"]*"' "$1" | sed 's/^[a-z]*="//; s/"$//; /^https*:/d; /^data:/d'; }
find "$dir/site" -name '*.html' | while read -r page; do
    links "$page" | while read -r link; do
        file=${link%%#*} anchor=
        case $link in *#*) anchor=${link#*#} ;; esac
        target=$(dirname "$page")/$file
        [ -n "$file" ] || target=$page
        [ -f "$target" ] || echo "${page#"$dir"/site/}: $link"
        [ -z "$anchor" ] || grep -q "id=\"$anchor\"" "$target" || echo "${page#"$dir"/site/}: no $link"
    done
done >"$dir/dead"
test ! -s "$dir/dead"
ok "all links lead somewhere ($(tr '\n' ' ' <"$dir/dead"))" $?
test "$(links "$dir/site/index.html" | wc -l)" -gt 20
ok "links are seen" $?
if command -v python3 >/dev/null 2>&1; then
    for page in $(find "$dir/site" -name '*.html'); do
        sed 1d "$page" | python3 -c 'import sys, xml.dom.minidom as m; m.parseString(sys.stdin.buffer.read().replace(b"&nbsp;", b" "))' 2>"$dir/err"
        ok "${page#"$dir"/site/}: every element is closed" $?
    done
fi
finish
