/* SPDX-License-Identifier: GPL-3.0-or-later
 * unheard.c - what compared strings were is not told to libFuzzer: a quarter of an input's time.
 * The linker puts this function, which does not look at what it is given, in the place of its own
 * for `make fuzz MANY=1` (--defsym); that the strings may be read was checked before, as always.
 */
void fuzz_unheard(void);

void fuzz_unheard(void)
{
}
