"""How much of something is done, on a terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def share_shown(what: str) -> Iterator[Callable[[float], None]]:
    """Gives what is to be called with the share that is done, 0 to 1.

    Where stderr is a terminal it shows as a bar, gone in the end; elsewhere nothing is written.
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
