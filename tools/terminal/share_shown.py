"""Progress bar on a terminal for the finished share of a computation."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def share_shown(what: str) -> Iterator[Callable[[float], None]]:
    """Yield a function that the caller calls from time to time with the finished share of the work, 0 to 1.

    If stderr is a terminal, the function shows a progress bar, which is removed at the end. Otherwise nothing
    is written.

    Args:
        what: description of the work, shown in front of the bar.
    """
    if not sys.stderr.isatty():
        yield lambda share: None
        return
    from rich.console import Console
    from rich.markup import escape
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task(escape(what), total=1.0)
        yield lambda share: progress.update(task, completed=share)
