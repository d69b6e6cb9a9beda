"""Progress bar on a terminal for the finished share of a computation."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def share_shown(what: str) -> Iterator[Callable[[float], None]]:
    """Yield a function to call with the finished share, 0 to 1.

    On a terminal (stderr) it shows a bar, removed at the end; otherwise nothing is written.
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
