# SPDX-License-Identifier: GPL-3.0-or-later
"""Bars of progress: in a notebook and on a terminal, for work that takes longer than a second."""
import html
import sys
import time


def told(progress):
    """What is called with (fraction, step): None and False: nothing, True: a bar."""
    if progress is not True:
        return progress or None
    show, begin = _notebook() or _terminal, time.monotonic()

    def bar(fraction, step):
        spent = time.monotonic() - begin
        if spent > 1.0:
            show(fraction, step, spent)

    return bar


def _terminal(fraction, step, spent):
    done = round(30 * fraction)
    print(f"\r{step} [{'#' * done}{'-' * (30 - done)}] {100 * fraction:3.0f} %, {spent:.0f} s\033[K",
          end="\n" if fraction >= 1.0 else "", file=sys.stderr, flush=True)


def _notebook():
    """The same as HTML that is replaced, where a kernel shows such; else None."""
    if "IPython" not in sys.modules:
        return None
    from IPython import get_ipython

    if getattr(get_ipython(), "kernel", None) is None:
        return None
    from IPython.display import HTML, display

    handle = None

    def show(fraction, step, spent):
        nonlocal handle
        bar = HTML(f"{html.escape(step)} <progress max='1' value='{fraction:.3f}'></progress> "
                   f"{100 * fraction:.0f} %, {spent:.0f} s")
        if handle is None:
            handle = display(bar, display_id=True)
        else:
            handle.update(bar)

    return show
