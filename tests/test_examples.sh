#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_examples.sh - the examples are made by their own Makefiles against an installed tree, run,
# and give the documented results: the force of the haptic loop agrees with `stein simulate`; the
# audio callback makes no system call and the same sound with and without a sandbox; the plugin
# strikes its string in a host; a new mechanism becomes a program.
set -u
. tests/claims.sh
# within VALUE LOW HIGH
within() { awk -v x="$1" -v a="$2" -v b="$3" 'BEGIN {exit !(x + 0 >= a && x + 0 <= b)}'; }

${MAKE:-make} -s install VARIANT="$variant" PREFIX="$dir/to" >"$dir/log" 2>&1
ok "make install ($(tail -n 1 "$dir/log"))" $?
PKG_CONFIG_PATH=$dir/to/lib/pkgconfig
export PKG_CONFIG_PATH
here=$dir/to/share/stein/examples
# built NAME: its Makefile makes it, without a warning
built() {
    CFLAGS="$san -Wall -Wextra -Werror" ${MAKE:-make} -s -C "$here/$1" >"$dir/log" 2>&1
    ok "examples/$1 is made ($(head -n 1 "$dir/log"))" $?
}

# ---- haptic: force out, and the same by another way
built haptic
"$here/haptic/haptic" >"$dir/felt.csv" 2>"$dir/err"
ok "a made-up motion is felt: $(cat "$dir/err")" $?
test "$(wc -l <"$dir/felt.csv")" = 501
ok "500 ticks and a header" $?
# held down for 150 ms it is at rest: the torque of an equilibrium, which simulate finds as well
held=$(awk -F, '$1 == "0.240" {print $3}' "$dir/felt.csv")
awk 'BEGIN {print "time [s],key_motion [rad]"; for (i = 0; i <= 500; i++) {x = (i < 20 ? 0 : i < 70 ? (1 - cos(3.14159265358979 * (i - 20) / 50)) / 2 : 1); printf "%.3f,%.9f\n", i / 1000, 0.0379664 * x}}' >"$dir/motion.csv"
"$B/stein" simulate models/stein1788.yaml --drive "$dir/motion.csv" --until 0.45s --release 0s --json >"$dir/out.json" 2>/dev/null
torque=$(sed -n 's/.*"key_force": \([-0-9.e]*\).*/\1/p' "$dir/out.json")
awk -v f="$held" -v t="$torque" 'BEGIN {w = t / 0.181; exit !(w > 1 && (f - w) ^ 2 < (0.01 * w) ^ 2)}'
ok "the force of a held key ($held N) is that of stein simulate (torque $torque N m)" $?
# the motion it was given, from a file, is the same
sed 's/,[^,]*$//' "$dir/felt.csv" >"$dir/again.csv"
"$here/haptic/haptic" "$dir/again.csv" >"$dir/felt2.csv" 2>/dev/null &&
    test "$(wc -l <"$dir/felt2.csv")" = 501 &&
    awk -F, 'NR == FNR {f[$1] = $3; next} FNR > 1 && ($3 - f[$1]) ^ 2 > 0.01 {exit 1}' "$dir/felt.csv" "$dir/felt2.csv"
ok "a file of the same motion feels the same" $?
"$here/haptic/haptic" "$dir/nothing.csv" >/dev/null 2>"$dir/err"
test $? = 1 && grep -q 'nothing.csv' "$dir/err"
ok "a file without rows is refused by name" $?

# ---- audio
built audio
"$here/audio/audio" "$dir/a.wav" >"$dir/out" 2>&1
ok "61 actions play: $(tail -n 1 "$dir/out")" $?
sed 's/^/test_examples: audio, /' "$dir/out"
grep -q '^all keys at once: up to 61 keys awake' "$dir/out"
ok "all keys move at once" $?
grep -q '^[0-9]* steps, 0 failed' "$dir/out"
ok "no step of the piece fails ($(sed -n 's/ steps, .*//p' "$dir/out") steps)" $?
awake=$(sed -n 's/^ten fingers: up to \([0-9]*\) keys.*/\1/p' "$dir/out")
within "$awake" 10 40
ok "keys at rest fall asleep ($awake awake)" $?
if [ -z "$san" ]; then
    "$here/audio/audio" --sandbox "$dir/b.wav" >"$dir/out" 2>&1
    code=$?
    if [ $code = 77 ]; then
        echo "test_examples: no seccomp here, the callback's system calls are not tested"
    else
        test $code = 0
        ok "the callback makes no system call (exit $code)" $?
        cmp -s "$dir/a.wav" "$dir/b.wav"
        ok "and the same sound" $?
    fi
fi
# loudest sample of each quarter second, as a float: every part of the piece sounds
peak=$(tail -c +45 "$dir/a.wav" | od -An -v -t f4 -w48000 | awk '{m = 0; for (i = 1; i <= NF; i++) {x = $i < 0 ? -$i : $i; if (x > m) m = x} print m}' | sort -g | sed -n '1p;$p' | tr '\n' ' ')
within "${peak%% *}" 0.01 1 && peak=${peak#* } && within "${peak%% *}" 0.1 1
ok "the sound is loud enough and not clipped (loudest $peak)" $?

# ---- the plugin
if ! pkg-config --exists lv2 || ! command -v lv2apply >/dev/null 2>&1; then
    echo "test_examples: no lv2 or lv2apply, the plugin is not tested"
elif [ -n "$san" ]; then
    echo "test_examples: hosts of plugins have no sanitizer, the plugin is not tested"
else
    built lv2
    LV2_PATH=$here/lv2/bundle
    export LV2_PATH
    test "$(nm -D --defined-only "$here/lv2/bundle/action.lv2/action.so" | awk '{print $3}')" = lv2_descriptor
    ok "the plugin exports one name" $?
    lv2info urn:stein:action1788 >"$dir/out" 2>"$dir/err"
    test "$(grep -c 'Port [0-9]' "$dir/out")" = 4 && test ! -s "$dir/err"
    ok "lv2info lists four ports and complains about nothing ($(head -n 1 "$dir/err"))" $?
    # a key pressed from 0.15 to 0.3 s of 0.5 s, 16 bits at 48 kHz; the stop has arrived before
    { printf 'RIFF\244\273\000\000WAVEfmt \020\000\000\000\001\000\001\000\200\273\000\000\000\167\001\000\002\000\020\000data\200\273\000\000'
      head -c 14400 /dev/zero; head -c 14400 /dev/zero | tr '\0' '\177'; head -c 19200 /dev/zero; } >"$dir/in.wav"
    # strikes WEIGHT STOP: $struck is the greatest force on the string [N], and when [ms]
    strikes() {
        lv2apply -i "$dir/in.wav" -o "$dir/out.wav" -c weight "$1" -c stop "$2" urn:stein:action1788 >"$dir/log" 2>&1
        ok "lv2apply runs it ($(head -n 1 "$dir/log"))" $?
        struck=$(tail -c +45 "$dir/out.wav" | od -An -v -t d2 -w2 |
            awk '$1 > m {m = $1; at = NR} END {printf "%.2f %.1f\n", m / 3276.8, at / 48}')
    }
    strikes 2 0
    hit=$struck
    within "${hit% *}" 5 10 && within "${hit#* }" 170 300
    ok "2 N strike the string: $hit (N, ms)" $?
    strikes 2 -1
    early=$struck
    within "${early% *}" 0.5 "$(awk -v x="${hit% *}" 'BEGIN {print x - 1}')"
    ok "with the stop 1 mm to the left the blow is weaker: $early" $?
    strikes 0 0
    missed=$struck
    test "${missed% *}" = 0.00
    ok "without a force there is no sound: $missed" $?
fi

# ---- a mechanism of one's own
built own
"$here/own/rocker" >"$dir/out" 2>&1
ok "it runs: $(cat "$dir/out")" $?
# m g (30 mm cos q) / (150 mm cos q) at rest
within "$(sed -n 's/.*at rest with \([0-9.]*\) N/\1/p' "$dir/out")" 0.2347 0.2390
ok "the felt carries its share of the weight" $?
test "$(wc -l <examples/own/Makefile)" -le 10
ok "its Makefile has ten lines" $?

finish
