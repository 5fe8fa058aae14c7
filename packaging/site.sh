#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# site.sh DIR - the documents as one static site: DIR/index.html is README.md, all others lie as they
# do here, so links between them hold; files that they link to are copied. Run by `make docs`.
set -eu
site=$1
if command -v cmark-gfm >/dev/null; then
    markdown() { cmark-gfm --extension table --extension autolink "$1"; }
elif command -v pandoc >/dev/null; then
    markdown() { pandoc --from gfm --to html "$1"; }
else
    echo "make docs needs cmark-gfm or pandoc - run: apt-get install cmark-gfm" >&2
    exit 1
fi

title_of() { sed -n 's/^# *//p;T;q' "$1"; }
page_of() { echo "${1%.md}.html" | sed 's#README\.html$#index.html#'; }

pages="README.md docs/first-diagnosis.md"
for doc in docs/*.md; do
    [ "$doc" = docs/first-diagnosis.md ] || pages="$pages $doc"
done
pages="$pages examples/README.md CONTRIBUTING.md"

style=':root{color-scheme:light dark;--paper:#fbfaf7;--ink:#23241f;--quiet:#6d6a60;--line:#e2ded2;--code:#f1eee5;--link:#1f4e79}
@media(prefers-color-scheme:dark){:root{--paper:#16181a;--ink:#e4e1d8;--quiet:#9a978c;--line:#33373b;--code:#202427;--link:#7fb2e0}}
*{box-sizing:border-box}body{margin:0;background:var(--paper);color:var(--ink);font:17px/1.55 Georgia,serif;display:grid;grid-template-columns:15rem minmax(0,52rem);gap:0 2.5rem;padding:1.5rem}
nav{font:15px/1.4 Helvetica,Arial,sans-serif}nav a{display:block;padding:.25rem 0;color:var(--quiet);text-decoration:none}nav a[aria-current]{color:var(--ink);font-weight:600}
a{color:var(--link)}h1,h2,h3{font-weight:normal;line-height:1.25}h2{border-top:1px solid var(--line);padding-top:1rem;margin-top:2rem}
code,pre{font:14px/1.45 ui-monospace,monospace;background:var(--code);border-radius:4px}code{padding:.1em .3em}pre{padding:.8rem 1rem;overflow-x:auto}pre code{padding:0}
img{max-width:100%;height:auto}table{display:block;overflow-x:auto;border-collapse:collapse;font:15px/1.4 Helvetica,Arial,sans-serif}th,td{text-align:left;vertical-align:top;padding:.35rem .9rem .35rem 0;border-bottom:1px solid var(--line)}
@media(max-width:800px){body{display:block;padding:1rem}nav{columns:2;border-bottom:1px solid var(--line);margin-bottom:1rem;padding-bottom:.5rem}}'

# from a page to the top: "" or "../"
up() { dirname "$1" | sed 's#^\.$##; s#[^/][^/]*#..#g; s#\(.\)$#\1/#'; }

write_page() {
    doc=$1 page=$2 top=$(up "$2")
    printf '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8" />\n'
    printf '<meta name="viewport" content="width=device-width, initial-scale=1" />\n'
    printf '<title>%s</title>\n<style>\n%s\n</style>\n</head>\n<body>\n<nav aria-label="Documents">\n' "$(title_of "$doc")" "$style"
    for other in $pages; do
        here=
        [ "$other" != "$doc" ] || here=' aria-current="page"'
        printf '<a href="%s%s"%s>%s</a>\n' "$top" "$(page_of "$other")" "$here" "$(title_of "$other")"
    done
    printf '</nav>\n<main>\n'
    markdown "$doc" | sed -E 's#<pre>#<pre tabindex="0">#; s#(href="[^":]*)README\.md#\1index.html#g; s#(href="[^":]*)\.md([\#"])#\1.html\2#g'
    printf '</main>\n</body>\n</html>\n'
}

rm -rf "$site"
for doc in $pages; do
    page=$(page_of "$doc")
    mkdir -p "$site/$(dirname "$page")"
    write_page "$doc" "$page" >"$site/$page"
    # linked files other than documents
    { grep -o ']([^):#]*)' "$doc" || true; } | sed 's/^](//; s/)$//' | grep -v '\.md$' | while read -r file; do
        from=$(dirname "$doc")/$file
        if [ -f "$from" ]; then
            mkdir -p "$site/$(dirname "$from")"
            cp "$from" "$site/$from"
        fi
    done
done
echo "$site/index.html"
