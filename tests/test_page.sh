#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_page.sh - stein page: the command, the page without a browser (nodejs), the page in a browser
# (chromium). Missing programs are reported and their tests left out; `make deps-page` installs it.
set -u
. tests/claims.sh
XDG_CACHE_HOME=$dir/cache # its own
unset WASM_CC WASI_SYSROOT

# ---- the command
claim 2 "a page needs a place" "$stein" page models/pendulum.yaml
says "and says so" 'expected -o FILE.html'
claim 2 "standard output holds one thing" "$stein" page models/pendulum.yaml -o - --json
claim 1 "without a compiler there is no page" env WASM_CC=no-such-clang "$stein" page models/pendulum.yaml -o "$dir/p.html"
says "the packages are named" 'lacks: clang.*; run apt-get install clang lld wasi-libc'
claim 1 "nor without its library" env WASI_SYSROOT="$dir" "$stein" page models/pendulum.yaml -o "$dir/p.html"
says "which is named" 'lacks:.* wasi-libc; run apt-get install clang lld wasi-libc'
gone "a page that failed is not there" "$dir/p.html"

missing=
for p in clang wasm-ld; do command -v $p >/dev/null 2>&1 || missing="$missing $p"; done
[ -e /usr/include/wasm32-wasi/stdlib.h ] || missing="$missing wasi-libc"
if [ -n "$missing" ]; then
    echo "test_page: no pages are tested, this machine lacks:$missing (make deps-page)"
    finish
    exit "$((failed > 0))"
fi
if command -v node >/dev/null 2>&1; then node=yes; else
    node=; echo "test_page: no nodejs, pages are written and not run (make deps-page)"; fi

# ---- pages of several mechanisms: a notch and a load, lines with ends, a plane other than x-z, a loop, motors
# the first one as it is given away, the others compiled in half the time
printf '#!/bin/sh\nexec clang "$@" -O0\n' >"$dir/quick" && chmod +x "$dir/quick"
for model in models/stein1788.yaml models/block_on_slope.yaml models/robotran/piston.yaml models/slider_crank.yaml \
    models/drive/geared_arm.yaml; do
    name=$(basename "$model" .yaml)
    claim 0 "a page of $name" "$stein" page "$model" -o "$dir/$name.html"
    WASM_CC=$dir/quick
    export WASM_CC
    [ -n "$node" ] || continue
    stroke=
    if [ "$name" = stein1788 ]; then
        stroke="$dir/stroke.json $dir/check.json"
        "$stein" strike "$model" --json >"$dir/stroke.json"
        "$stein" check "$model" --json >"$dir/check.json"
    fi
    # shellcheck disable=SC2086
    node tests/page/module_test.js "$dir/$name.html" src/page/shim.c $stroke >"$dir/log" 2>&1
    counted "$dir/log"
done

claim 0 "the shim has no warnings" clang --target=wasm32-wasi --sysroot=/usr -std=c11 -Wall -Wextra \
    -Wpedantic -Wconversion -Wshadow -Werror -fsyntax-only -DPAGE_MODEL=stein1788 -Iinclude -Isrc/core src/page/shim.c
module=$(find "$XDG_CACHE_HOME" -name 'block_on_slope-*.wasm')
if [ -s "$module" ]; then pass; else fail "a module is in the cache"; fi
: >"$module"
core=$(find "$XDG_CACHE_HOME" -name 'sim.c.o' -newer "$dir/stein1788.html")
echo damaged >"$core"
claim 0 "a damaged module in the cache is made anew" "$stein" page models/block_on_slope.yaml -o "$dir/again.html"
if [ "$(wc -c <"$core")" -gt 1000 ]; then pass; else fail "with what is kept of the core"; fi
same "as it was" "$dir/block_on_slope.html" "$dir/again.html"

# ---- numbers need no compiler; the file's words cannot end the script they stand in
claim 0 "the same page again" env WASM_CC=no-such-clang "$stein" page models/stein1788.yaml -o "$dir/again.html"
same "has the same bytes" "$dir/stein1788.html" "$dir/again.html"
claim 0 "other numbers need no compiler" env WASM_CC=no-such-clang \
    "$stein" page models/block_on_slope.yaml --set block.mass=1.7kg -o "$dir/other.html" --json
if cmp -s "$dir/block_on_slope.html" "$dir/other.html"; then fail "but they are other numbers"; else pass; fi
if grep -q '"hash": "[0-9a-f]\{16\}"' "$dir/out"; then pass; else fail "--json tells the hash"; fi
sed 's|^about:.*|about: "</script><script>alert(1)</script><!-- \\" \\\\"|' models/block_on_slope.yaml >"$dir/rude.yaml"
if grep -q 'alert(1)' "$dir/rude.yaml"; then pass; else fail "the rude file is rude"; fi
claim 0 "a page of rude words" "$stein" page "$dir/rude.yaml" -o "$dir/rude.html"
if grep -q '<script>alert' "$dir/rude.html"; then fail "they stay words"; else pass; fi
if [ -n "$node" ]; then
    node tests/page/module_test.js "$dir/rude.html" src/page/shim.c >"$dir/log" 2>&1
    counted "$dir/log"
fi

# ---- in a browser; sanitizer messages about `stein` are above
case $B in
*san) ;;
*)
    if [ -z "$node" ] || ! command -v chromium >/dev/null 2>&1; then
        echo "test_page: no chromium, the page is not played (make deps-page)"
    else
        node tests/page/browser_test.js "$(command -v chromium)" "$dir/stein1788.html" \
            "$dir/block_on_slope.html" "$dir/piston.html" >"$dir/log" 2>&1
        counted "$dir/log"
        "$stein" page models/pendulum.yaml -o "$dir/pendulum.html" >/dev/null 2>&1
        node tests/page/controls_test.js "$(command -v chromium)" "$dir/stein1788.html" models/strokes/stroke_01.csv \
            "$dir/pendulum.html" >"$dir/log" 2>&1
        counted "$dir/log"
        cat >"$dir/rods.yaml" <<'YAML'
mechanism: rods
bodies:
  left:
    joint: R -y
    mass: 1 kg
    centre: [0, 0, -50 mm]
    inertia: {yy: 500 kg mm^2}
    points: {end: [0, 0, -100 mm]}
  right:
    joint: R -y
    at: [120 mm, 0, 0]
    mass: 1 kg
    centre: [0, 0, -50 mm]
    inertia: {yy: 500 kg mm^2}
    points: {end: [0, 0, -100 mm], middle: [0, 0, -60 mm]}
  block:
    joint: T x
    at: [0, 0, -60 mm]
    mass: 0.1 kg
    initial: {position: 120 mm}
    points: {pin: [0, 0, 0]}
loops:
  bar: {between: [left.end, right.end], rod: 120 mm}
  groove: {between: [right.middle, block.pin], slot: z}
outputs:
  angle: {joint: left, read: position}
simulation: {dt: 1 ms, until: 1 s}
YAML
        for model in bench/rx90.yaml "$dir/rods.yaml"; do
            "$stein" page "$model" -o "$dir/$(basename "$model" .yaml).html" >/dev/null 2>&1
        done
        node tests/page/views_test.js "$(command -v chromium)" "$dir/stein1788.html" "$dir/rx90.html" \
            "$dir/slider_crank.html" "$dir/rods.html" "$dir/piston.html" >"$dir/log" 2>&1
        counted "$dir/log"
    fi
    ;;
esac

finish
