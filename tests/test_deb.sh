#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_deb.sh - the Debian packages: each holds what it is for, they depend on what they need, and
# programs run and are built with what is in them. They are packed from what is built already; `make
# deb` by itself compiles with Debian's flags and lets lintian look at the packages.
set -u
. tests/claims.sh

case ${B##*/} in
*-*)
    echo "test_deb: packages are made of the release build, not of $B"
    finish
    exit
    ;;
esac
if ! ${CC:-cc} --version 2>/dev/null | grep -q 'Free Software Foundation'; then
    echo "test_deb: packages are made of what gcc built, not ${CC:-cc}: Debian's dwz reads no other"
    finish
    exit
fi
missing=
for p in dpkg-buildpackage dh fakeroot; do command -v $p >/dev/null 2>&1 || missing="$missing $p"; done
pkg-config --exists 'python3 >= 3.11' || missing="$missing python3-dev"
if [ -n "$missing" ]; then
    echo "test_deb: no packages are made, this machine lacks:$missing (make deps-check)"
    finish
    exit
fi

DEB_BUILD_OPTIONS="nocheck noautodbgsym" DPKG_DEB_COMPRESSOR_LEVEL=0 \
    ${MAKE:-make} -s deb BUILT=1 DEB="$dir/deb" >"$dir/out" 2>"$dir/err"
ok "make deb ($(tail -n 2 "$dir/out" "$dir/err" | tr '\n' ' '))" $?
if grep -q ' -c src/' "$dir/deb/build.log"; then fail "what is built is built again"; else pass; fi

# ---- what is in them
version=$(sed -n 's/^.define STEIN_VERSION *"\(.*\)"/\1/p' include/stein/version.h)
arch=$(dpkg --print-architecture)
for p in libstein0 libsteinlab0 libstein-dev stein python3-stein; do
    test -s "$dir/deb/${p}_${version}_$arch.deb" && dpkg-deb -x "$dir/deb/${p}_${version}_$arch.deb" "$dir/$p"
    ok "package $p is there" $?
done
lib=usr/lib/$(dpkg-architecture -q DEB_HOST_MULTIARCH)
for p in stein steinlab; do
    test -f "$dir/lib${p}0/$lib/lib$p.so.$version" &&
        test "$(readlink "$dir/lib${p}0/$lib/lib$p.so.0")" = "lib$p.so.$version" &&
        test "$(readlink "$dir/libstein-dev/$lib/lib$p.so")" = "lib$p.so.0" &&
        test -s "$dir/libstein-dev/$lib/lib$p.a"
    ok "lib$p: library, soname and archive" $?
done
for h in include/stein/*.h; do
    cmp -s "$h" "$dir/libstein-dev/usr/$h"
    ok "$h is in libstein-dev" $?
done
for c in $("$stein" help --commands); do
    gunzip -c "$dir/stein/usr/share/man/man1/stein-$c.1.gz" 2>/dev/null | cmp -s - "$B/man/stein-$c.1"
    ok "the page of stein $c is in stein" $?
done
same "the completion is in stein" "$B/stein.bash" "$dir/stein/usr/share/bash-completion/completions/stein"
same "a mechanism is in stein" models/stein1788.yaml "$dir/stein/usr/share/stein/models/stein1788.yaml"
for e in haptic audio lv2 own strike; do
    test -s "$dir/libstein-dev/usr/share/doc/libstein-dev/examples/$e/Makefile"
    ok "example $e is in libstein-dev" $?
done

# ---- what they need
# needs PACKAGE PATTERN
needs() {
    dpkg-deb -f "$dir/deb/$1_${version}_$arch.deb" Depends >"$dir/depends"
    grep -q "$2" "$dir/depends"
    ok "$1 depends on $2 ($(cat "$dir/depends"))" $?
}
needs libstein0 'libc6'
needs libsteinlab0 "libstein0 (>= $version"
needs libsteinlab0 'libgsl'
needs libstein-dev "libstein0 (= $version)"
needs libstein-dev "libsteinlab0 (= $version)"
needs stein 'libyaml'
needs python3-stein 'libgsl.*python3 (>= 3.11)'

# ---- put together, as they would be in /
mkdir "$dir/unpacked" && for p in libstein0 libsteinlab0 libstein-dev stein; do cp -a "$dir/$p/." "$dir/unpacked"; done
LD_LIBRARY_PATH=$dir/unpacked/$lib
export LD_LIBRARY_PATH
said=$("$stein" strike models/stein1788.yaml --json)
test -n "$said" && test "$("$dir/unpacked/usr/bin/stein" strike "$dir/unpacked/usr/share/stein/models/stein1788.yaml" --json |
    sed "s|$dir/unpacked/usr/share/stein/||")" = "$said"
ok "the packed program strikes as the built one" $?
examples=$dir/unpacked/usr/share/doc/libstein-dev/examples
# shellcheck disable=SC2046
PKG_CONFIG_PATH=$dir/unpacked/$lib/pkgconfig PKG_CONFIG_SYSTEM_INCLUDE_PATH=/none \
    ${MAKE:-make} -s -C "$examples/strike" >"$dir/out" 2>"$dir/err"
ok "an example is made with what is packed" $?
"$examples/strike/strike" >"$dir/out" 2>"$dir/err"
ok "and runs ($(cat "$dir/out"))" $?
said=$(PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=$dir/python3-stein/usr/lib/python3/dist-packages python3 -c '
import stein
print(stein.load("models/stein1788.yaml").strike().outcome)' 2>"$dir/err")
test "$said" = struck
ok "the packed module strikes ($said)" $?
if ldd "$examples/strike/strike" | grep -q "=> $dir/unpacked/$lib/libstein.so.0"; then pass; else fail "with the packed library"; fi

finish
