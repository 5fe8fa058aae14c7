/* SPDX-License-Identifier: GPL-3.0-or-later
 * unheard.c - compared strings are not reported to libFuzzer: a quarter of an input's time.
 * For `make fuzz MANY=1` the linker uses this empty function in the place of libFuzzer's
 * (--defsym); that the strings may be read was checked before, as always.
 */
void fuzz_unheard(void);

void fuzz_unheard(void)
{
}
